//! Images: planes of pixels, the files they live in, and the projections they are seen through.

pub mod channels;
pub mod cube;
pub mod equirect;
pub mod exr;
pub mod layout;
pub mod limits;
pub mod plane;
pub mod png;
pub mod sequence;
pub mod transfer;

pub use channels::ChannelSelect;
pub use cube::Face;
pub use layout::FaceLayout;
pub use limits::ReadLimits;
pub use plane::{ColorPlane, DepthPlane, MaterialPlane, Plane};
pub use png::ColorSpace;
pub use sequence::{FrameRange, Pattern, Sequence};
pub use transfer::{DecodeTable, EncodeTable, ToneMap, Transfer};
