//! Layout of a quilt, by the name of its file.

use std::path::Path;

use serde::Serialize;

use codec::error::{Error, Result};
use codec::image::ReadLimits;
use footage::image_files::png;
use footage::image_files::quilt::{QuiltName, parse_quilt_name};

/// Limits of the page for quilts (viewer/src/ui/film_file.ts, viewer/src/quilt.ts).
const MAX_TILES: u32 = 4096;
const MAX_QUILT_PIXELS: u64 = 1 << 28;
const ASPECTS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// Tiles of a quilt, and the width / height of a view.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct QuiltShape {
    pub columns: u32,
    pub rows: u32,
    pub aspect: f64,
}

impl QuiltShape {
    /// Parses the layout in the name of a picture, and checks it against the picture's size.
    pub fn of(path: &Path) -> Result<QuiltShape> {
        let Some(QuiltName { columns, rows, aspect }) = parse_quilt_name(path) else {
            let message = "the name of the picture has no quilt layout: use a name such as film_qs8x6a0.75.png: 8 \
                columns, 6 rows, views of width / height 0.75";
            return Err(Error::unsupported(message).in_file(path));
        };
        let (width, height) = png::read_size(path, &ReadLimits::default())?;
        if columns > width || rows > height {
            let message = format!("{width}x{height} pixels, but its name states {columns}x{rows} tiles");
            return Err(Error::invalid(message).in_file(path));
        }
        if columns > MAX_TILES || rows > MAX_TILES || u64::from(width) * u64::from(height) > MAX_QUILT_PIXELS {
            let message = format!(
                "{width}x{height} pixels in {columns}x{rows} tiles; the player shows up to {MAX_QUILT_PIXELS} pixels, and {MAX_TILES} tiles \
                 along a side"
            );
            return Err(Error::unsupported(message).in_file(path));
        }
        let in_pixels = || f64::from(width) / f64::from(columns) / (f64::from(height) / f64::from(rows));
        let aspect = aspect.unwrap_or_else(in_pixels);
        if !ASPECTS.contains(&aspect) {
            let message =
                format!("views of width / height {aspect}; the player shows {} to {}", ASPECTS.start(), ASPECTS.end());
            return Err(Error::unsupported(message).in_file(path));
        }
        Ok(QuiltShape { columns, rows, aspect })
    }
}
