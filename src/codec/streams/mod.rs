//! Typed streams of a container: codec headers, parsed chunks, and conversion between values and codes.

pub mod convert;
mod depth_chunk;
mod footage;
mod header;
mod header_bytes;
mod info;
mod picture_chunk;
pub mod shard;
mod stream_chunk;

pub use crate::image::{DepthKind, Projection, StreamKind};
pub use depth_chunk::DepthChunk;
pub use footage::{FootageInfo, FramePose, MissingFrame, StartView};
pub use header::{
    ALPHA_PREDICTIVE, AlphaHeader, COLOR_CELLS_8, COLOR_CELLS_BC1, COLOR_CELLS_BC6H, COLOR_CELLS_BC7, COLOR_CELLS_HALF,
    COLOR_TRANSFORM_8, COLOR_TRANSFORM_HALF, CodecHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader,
    DEPTH_AABB, DEPTH_AABB_BC5, DEPTH_BLOCKS, DEPTH_NODES, DEPTH_PREDICTIVE, DEPTH_TREE, DepthCoding, DepthHeader,
    MATERIAL_AABB, MATERIAL_AABB_BC1, MaterialHeader, NodeHeader,
};
pub use info::{StreamInfo, check_memory, check_written, streams};
pub use picture_chunk::PictureChunk;
pub use stream_chunk::StreamChunk;
