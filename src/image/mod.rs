//! Images: planes of pixels, their files, transfer functions, and the image model.

use std::fs::File;
use std::path::Path;

use crate::error::{Error, Result};

pub mod channels;
pub mod cube;
pub mod equirect;
#[cfg(feature = "encode")]
pub mod exr;
pub mod kind;
pub mod layout;
pub mod limits;
pub mod plane;
#[cfg(feature = "encode")]
pub mod png;
pub mod projection;
pub mod sequence;
pub mod texel_map;
pub mod transfer;

pub use channels::ChannelSelect;
pub use cube::Face;
pub use kind::{DepthKind, Projection, StreamKind};
pub use layout::FaceLayout;
pub use limits::ReadLimits;
pub use plane::{ColorPlane, DepthPlane, MaterialPlane, Plane};
#[cfg(feature = "encode")]
pub use png::ColorSpace;
pub use projection::ImageProjection;
pub use sequence::{FrameRange, Pattern, Sequence};
pub use texel_map::TexelMap;
pub use transfer::{DecodeTable, EncodeTable, ToneMap, Transfer};

/// Opens a regular file; a named pipe would block.
pub(crate) fn open_regular(path: &Path) -> Result<File> {
    let io = |error| Error::io(path, error);
    if std::fs::metadata(path).map_err(io)?.is_file() {
        return File::open(path).map_err(io);
    }
    Err(Error::invalid("not a regular file").in_file(path))
}
