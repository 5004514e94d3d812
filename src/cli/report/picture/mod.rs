//! Pictures composed of images, which are scaled by integer factors, with captions, keys and colour bars.

pub mod contact_sheet;
pub mod raster;
pub mod sheet;
pub mod shown;
