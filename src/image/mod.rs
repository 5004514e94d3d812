//! Images: planes of pixels, image files, transfer functions, and projections.

pub mod channels;
#[cfg(feature = "encode")]
pub mod color_space;
pub mod cube;
pub mod equirect;
#[cfg(feature = "encode")]
pub mod exr;
mod folder_names;
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
pub mod primaries;
pub mod projection;
#[cfg(feature = "encode")]
pub mod quilt;
pub mod sequence;
pub mod texel_map;
pub mod transfer;

pub use channels::ChannelSelect;
#[cfg(feature = "encode")]
pub use color_space::ColorSpace;
pub use cube::Face;
pub use folder_names::FolderNames;
pub use kind::{DepthKind, Projection, StreamKind};
pub use layout::{Eye, FaceLayout, StereoLayout};
pub use limits::ReadLimits;
pub use plane::{AlphaPlane, ColorPlane, DepthPlane, MaterialPlane, NormalPlane, Plane, unit_alpha};
pub use primaries::{LightMatrix, Primaries};
pub use projection::ImageProjection;
pub use sequence::{FrameRange, Pattern, Sequence};
pub use texel_map::TexelMap;
pub use transfer::{CodeSteps, DecodeTable, EncodeTable, ToneMap, Transfer};
