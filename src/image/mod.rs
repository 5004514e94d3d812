//! Images: planes of pixels, the files they live in, and the projections they are seen through.

pub mod cube;
pub mod plane;
pub mod sequence;

pub use cube::Face;
pub use plane::{ColorPlane, DepthPlane, MaterialPlane, Plane};
pub use sequence::FrameRange;
