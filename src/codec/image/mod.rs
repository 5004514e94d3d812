//! Images in memory: planes of pixels, channel names, file patterns, transfer functions, and the image model.

pub mod channels;
pub mod cube;
pub mod equirect;
mod folder_names;
pub mod kind;
pub mod layout;
pub mod plane;
pub mod primaries;
pub mod projection;
pub mod sequence;
pub mod texel_map;
pub mod transfer;

pub use crate::memory::ReadLimits;
pub use channels::ChannelSelect;
pub use cube::Face;
pub use folder_names::FolderNames;
pub use kind::{DepthKind, Projection, StreamKind};
pub use layout::{Eye, FaceLayout, StereoLayout};
pub use plane::{AlphaPlane, ColorPlane, DepthPlane, MaterialPlane, NormalPlane, Plane, unit_alpha};
pub use primaries::{LightMatrix, Primaries};
pub use projection::ImageProjection;
pub use sequence::{FrameRange, Pattern, Sequence};
pub use texel_map::TexelMap;
pub use transfer::{CodeSteps, DecodeTable, Display, EncodeTable, ToneCurve, ToneMap, Transfer};
