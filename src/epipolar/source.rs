//! Source views: the surfaces that are visible from a position on the line, and the surfaces behind them.

use half::f16;

use scene::shading::Gloss;

/// Maximum number of layers of a source view.
pub const MAX_LAYERS: usize = 10;

/// How a pixel's radiance depends on the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// Radiance does not depend on the eye.
    Steady,
    /// Radiance has highlights; index into [`SourceRow::gloss`].
    Gloss(u32),
    /// A mirror or glass, which is not a line in epipolar space.
    Traced,
}

/// A pixel of a layer that shows a surface or the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourcePixel {
    /// Column in the picture from the source's position. Widened windows have columns below 0 and beyond the width.
    pub column: i32,
    /// Planar distance in metres, above 0; `+inf` for the background.
    pub depth_m: f32,
    /// Index of the layer; 0 is the nearest surface.
    pub layer: u8,
    pub light: Light,
    /// Radiance in other views, without highlights.
    pub steady: [f16; 3],
    /// Total radiance in the picture from the source's position; in the first layer, the mean over the pixel.
    pub own: [f16; 3],
}

/// A scanline: its pixels, sorted by layer, then by column.
#[derive(Debug, Clone, Default)]
pub struct SourceRow {
    pub pixels: Vec<SourcePixel>,
    pub gloss: Vec<Gloss>,
}

impl SourceRow {
    /// Returns the row without spare capacity, as many rows are kept in memory.
    #[must_use]
    pub fn fitted(mut self) -> SourceRow {
        self.pixels.shrink_to_fit();
        self.gloss.shrink_to_fit();
        self
    }

    /// Returns the size of the row in memory, in bytes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.pixels[..]) as u64 + self.gloss.iter().map(Gloss::bytes).sum::<u64>()
    }
}

#[derive(Debug, Clone)]
pub struct SourceView {
    /// Position in metres to the right of the middle of the output views.
    pub offset_m: f64,
    /// Scanlines: those of the output views, or a band of them.
    pub rows: Vec<SourceRow>,
    /// Number of layers that have any pixel.
    pub layers: u32,
}

impl SourceView {
    /// Creates a source view from an image. `pixel` returns the planar distance in metres and the radiance at a column and row;
    /// `None` if they are unknown.
    pub fn of_image(
        offset_m: f64,
        [width, height]: [u32; 2],
        pixel: impl Fn(u32, u32) -> Option<(f32, [f16; 3])>,
    ) -> SourceView {
        let pixel = |column: u32, row: u32| {
            let (depth_m, light) = pixel(column, row)?;
            let depth_m = depth_m.max(f32::MIN_POSITIVE);
            let (steady, own) = (light, light);
            Some(SourcePixel { column: column as i32, depth_m, layer: 0, light: Light::Steady, steady, own })
        };
        let row = |row: u32| {
            let pixels = (0..width).filter_map(|column| pixel(column, row)).collect();
            SourceRow { pixels, gloss: Vec::new() }
        };
        SourceView { offset_m, rows: (0..height).map(row).collect(), layers: 1 }
    }

    /// Returns the view with all pixels moved to the left by `columns`.
    #[must_use]
    pub fn moved_left(mut self, columns: i32) -> SourceView {
        self.rows.iter_mut().flat_map(|row| &mut row.pixels).for_each(|pixel| pixel.column -= columns);
        self
    }

    /// Creates a source view from its rows.
    pub fn of_rows(offset_m: f64, rows: Vec<SourceRow>) -> SourceView {
        let layers = |row: &SourceRow| row.pixels.last().map_or(0, |pixel| u32::from(pixel.layer) + 1);
        let layers = rows.iter().map(layers).max().unwrap_or(0);
        SourceView { offset_m, rows, layers }
    }

    pub fn pixel_count(&self) -> u64 {
        self.rows.iter().map(|row| row.pixels.len() as u64).sum()
    }
}

/// Sorts sources by position and keeps one per position, so that their order in the input does not matter.
pub fn in_order(mut sources: Vec<SourceView>) -> Vec<SourceView> {
    sources.sort_by(|a, b| a.offset_m.total_cmp(&b.offset_m));
    sources.dedup_by(|a, b| a.offset_m == b.offset_m);
    sources
}
