//! Encodes frames of a source into a container: `lightfold encode`, and [`Encoder`] for frames in memory.
//!
//! Input: a [`FrameSource`]. Output: a container, written front to back. A [`Plan`] holds what is known before the first frame is
//! read: the order of groups and the memory that each needs. A frame passes through these stages:
//!
//! 0. `first_frames` reads the first frame of each stream if the caller requests it, so that unreadable files are reported before
//!    anything is encoded.
//! 1. `depth_range` finds near and far of each probe unless they are given, and keeps the depth images that fit into memory.
//! 2. `group` reads a frame of all faces and converts it to the domain of its codec: depth codes, 8-bit codes, half-float keys.
//! 3. `job` passes the rectangle of each unit to its own encoder (`unit`), one batch of frames at a time, units in parallel.
//! 4. [`codec::container::Writer`] writes chunks in a fixed order, so that the bytes depend only on input and settings.

mod budget;
mod complete;
mod configuration;
mod depth_range;
mod encoder;
mod first_frames;
mod footage;
mod group;
mod job;
mod part;
mod plan;
mod precision;
mod resume;
mod scan;
mod scan_file;
mod settings;
mod shard;
mod source;
pub mod tile_quality;
mod unit;

pub use complete::complete_shard;
pub use depth_range::keep_few_planar_depths;
pub use encoder::{Encoder, EncoderStream, ProbePose};
pub use first_frames::FirstFrames;
pub use footage::Footage;
pub use job::{EncodeReport, EncodeSummary, Kept, Resumable, Stopped, encode};
pub use part::Part;
pub use plan::Plan;
pub use precision::{NamedPixel, NamedStrays, ProbePrecision, strays_of};
pub use scan::Scans;
pub use scan_file::{ScanFile, probe_images, scan_probes};
pub use settings::{
    Clipping, ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, ErrorBound, MaterialSettings,
    TileSize,
};
pub use shard::{Shard, ShardBy, ShardChoice};
pub use source::{FrameSource, selected_groups};
