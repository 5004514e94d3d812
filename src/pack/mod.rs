//! Joins containers without decoding them, and packs quadtrees at an error bound.

#![doc(hidden)]

mod flatten;
mod join;
mod shards;

use std::io::Write;

use crate::container::Reader;
use crate::error::Result;
use crate::monitor::Monitor;

pub use flatten::FlattenSettings;
pub use join::{PackReport, PackSettings, PackSummary, Repack};

/// Writes all streams of `inputs` into `out`: shards of one encode as the container that it would have written, all others one
/// after the other. Then probes of one name must agree; streams of one kind, probe and face must not occur twice. Name, frame
/// rate and projection are the first input's. The monitor advances by one for each chunk.
pub fn pack<W: Write + Send>(
    inputs: &[Reader],
    settings: &PackSettings,
    out: W,
    monitor: &dyn Monitor,
) -> Result<(W, PackSummary)> {
    match shards::shard_entries(inputs)? {
        Some(entries) => shards::join(&shards::Joined::new(inputs, &entries)?, settings, out, monitor),
        None => join::join(inputs, settings, out, monitor),
    }
}
