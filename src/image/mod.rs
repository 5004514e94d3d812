//! Images: planes of pixels, their files, transfer functions, and the image model.

pub mod channels;
pub mod cube;
pub mod equirect;
#[cfg(feature = "encode")]
pub mod exr;
pub mod kind;
#[cfg(feature = "encode")]
pub mod ktx2;
pub mod layout;
pub mod limits;
#[cfg(feature = "encode")]
pub mod picture_stream;
pub mod plane;
#[cfg(feature = "encode")]
pub mod png;
pub mod projection;
#[cfg(feature = "encode")]
pub mod quilt;
pub mod sequence;
pub mod texel_map;
pub mod transfer;

pub use channels::ChannelSelect;
pub use cube::Face;
pub use kind::{DepthKind, Projection, StreamKind};
pub use layout::FaceLayout;
pub use limits::ReadLimits;
pub use plane::{ColorPlane, DepthPlane, MaterialPlane, NormalPlane, Plane};
#[cfg(feature = "encode")]
pub use png::ColorSpace;
pub use projection::ImageProjection;
pub use sequence::{FrameRange, Pattern, Sequence};
pub use texel_map::TexelMap;
pub use transfer::{CodeSteps, DecodeTable, EncodeTable, ToneMap, Transfer};
