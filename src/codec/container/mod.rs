//! The `.lfold` container (formats/container.md): streams of opaque chunks, and their index.
//!
//! Takes descriptions of probes and streams, and chunk payloads as bytes, and returns the same. The module has probes, faces
//! and frame ranges, but no codec: formats/depth.md and color.md define payloads.

pub mod attributes;
pub mod chunk;
#[cfg(feature = "encode")]
pub mod compression;
pub mod fields;
pub mod header;
pub mod index;
pub mod index_read;
#[cfg(feature = "encode")]
pub mod index_write;
#[cfg(feature = "encode")]
pub mod journal;
pub mod limits;
pub mod lzma2;
pub mod payload;
pub mod reader;
pub mod serialize;
pub mod source;
#[cfg(feature = "encode")]
pub mod writer;
pub mod zstd;

pub use attributes::Attributes;
pub use chunk::{ChunkEntry, ChunkKey, ChunkPlace, EncodedChunk, Storage};
#[cfg(feature = "encode")]
pub use compression::{Compression, PayloadKind};
pub use fields::Fields;
pub use index::{Index, ProbeEntry, StreamEntry};
#[cfg(feature = "encode")]
pub use journal::{Journal, Recovered, SafeChunks};
pub use limits::OpenLimits;
pub use payload::Payload;
pub use reader::Reader;
pub use source::ByteSource;
#[cfg(feature = "encode")]
pub use writer::{PackedChunk, Writer};
