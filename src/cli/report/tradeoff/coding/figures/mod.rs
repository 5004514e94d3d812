//! Figures of coding that need more data than the points: decoding by error bound, and PSNR of tiles.

mod bound;
mod tiles;

pub use bound::figures as bounds;
pub use tiles::figure as tiles;
