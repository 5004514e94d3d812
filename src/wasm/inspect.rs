//! The coding of units, as `lightfold inspect` shows it: files of `src/inspect`, under the paths that they use.

#[allow(dead_code)]
#[path = "../inspect/patch.rs"]
pub mod patch;
#[allow(dead_code)]
#[path = "../inspect/unit_map.rs"]
mod unit_map;

use codec::error::Result;
use codec::streams::StreamChunk;
use patch::Patch;

/// Returns the patches that frame `at` of a chunk writes; `size` is the width and height of its unit in pixels.
pub fn patches(chunk: &StreamChunk, size: [u32; 2], at: u32) -> Result<Vec<Patch>> {
    Ok(unit_map::unit_map(chunk, size, at)?.patches)
}
