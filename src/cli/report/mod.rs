//! Tables, CSV, charts and pictures of all commands, and parameter sweeps.

pub mod coding_map;
pub mod csv;
pub mod interpolation;
pub mod machine;
pub mod picture;
pub mod placement;
pub mod plot;
pub mod simplification;
pub mod statistics;
pub mod table;
pub mod tile_psnr;
pub mod tradeoff;

pub use table::Table;
