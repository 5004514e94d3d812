//! Figures of coding that need more than the points: decoding by the error bound, and PSNR of tiles.

mod bound;
mod tiles;

pub use bound::figures as bounds;
pub use tiles::figure as tiles;
