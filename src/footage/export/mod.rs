//! Decodes streams of a container into image files and picture streams, with a manifest beside them.

mod files;
mod image_writer;
mod manifest;
mod report;

pub use files::{Destination, decode_to_files, decode_to_stream, file_sequences};
pub use manifest::{FileCoding, FileFormat, has_decoded};
pub use report::{DamagedChunkReport, DecodeReport, DecodeTimes};
