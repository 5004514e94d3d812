//! Memory that a run takes at most.

use super::acquire::Acquisition;
use super::source::{MAX_LAYERS, SourcePixel};
use super::views::OutputViews;

/// Layers of a source view with culling, over its first one: as measured in cluttered scenes, with room.
const LAYERS: u64 = 3;
/// Bytes of a pixel of an output view: light and coverage by row, as a view, and as a picture in single precision.
const VIEW_PIXEL_BYTES: u64 = 2 * 8 + 16;
/// Bytes of all hits of a ray, while a scanline is acquired.
const HIT_BYTES: u64 = 72 * MAX_LAYERS as u64;
/// Scanlines that a thread acquires at once.
const BAND: u64 = 16;

/// Bytes of the source views, and of one output view.
pub fn bytes(views: &OutputViews, acquisition: Acquisition, max_sources: usize) -> [u64; 2] {
    let [width, height] = views.size.map(u64::from);
    let pixels = width * height;
    let source_pixels = match acquisition {
        // Twice as wide.
        Acquisition::Center => 2 * LAYERS * pixels,
        Acquisition::Dual => 2 * LAYERS * pixels,
        Acquisition::Hierarchical => max_sources as u64 * pixels,
    };
    let hits = 2 * width * BAND * HIT_BYTES * rayon::current_num_threads() as u64;
    [source_pixels * size_of::<SourcePixel>() as u64 + hits, pixels * VIEW_PIXEL_BYTES]
}
