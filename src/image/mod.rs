//! Images: planes of pixels, the files they live in, and the projections they are seen through.

pub mod plane;

pub use plane::{ColorPlane, DepthPlane, MaterialPlane, Plane};
