//! Pictures made of images: enlarged or reduced by whole factors, on sheets with words, keys and colour bars.

pub mod contact_sheet;
pub mod error_picture;
pub mod raster;
pub mod sheet;
