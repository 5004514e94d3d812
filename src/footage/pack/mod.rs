//! Joins containers without decoding them, and packs quadtrees at an error bound.

mod flatten;
mod join;
mod shards;

use std::io::Write;

use codec::container::Reader;
use codec::error::Result;
use codec::monitor::Monitor;

pub use flatten::FlattenSettings;
pub use join::{PackReport, PackSettings, PackSummary, Repack};

/// Writes all streams of `inputs` to `out`. Shards of one encode are joined to the container that the encode would have written;
/// other containers are appended one after the other. In that case probes with the same name must agree, streams of the same
/// kind, probe and face must not occur twice, and frame rate and projection must be the same; the name is that of the first
/// input. The monitor advances by one for each chunk.
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
