//! Source views: what is visible from a place on the line, and what lies behind it.

use half::f16;

use crate::scene::shading::Gloss;

/// Layers of a source view at most.
pub const MAX_LAYERS: usize = 10;

/// Where a pixel's light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// The same from every eye.
    Steady,
    /// With highlights: an index into [`SourceRow::gloss`].
    Gloss(u32),
    /// A mirror or glass: no line in epipolar space.
    Traced,
}

/// A pixel of a layer with a surface, or with the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourcePixel {
    /// Column in the picture from this place; a widened window has some below 0, and beyond its width.
    pub column: i32,
    /// Planar distance in metres, above 0; `+inf` for the background.
    pub depth_m: f32,
    /// 0 for the nearest surface.
    pub layer: u8,
    pub light: Light,
    /// Radiance in other views, without highlights.
    pub steady: [f16; 3],
    /// All light, as the picture from this place shows it: in the first layer, the mean over the pixel.
    pub own: [f16; 3],
}

/// A scanline: its pixels by layer, then by column.
#[derive(Debug, Clone, Default)]
pub struct SourceRow {
    pub pixels: Vec<SourcePixel>,
    pub gloss: Vec<Gloss>,
}

impl SourceRow {
    /// Without room for more: many rows are held.
    #[must_use]
    pub fn fitted(mut self) -> SourceRow {
        self.pixels.shrink_to_fit();
        self.gloss.shrink_to_fit();
        self
    }

    /// Memory that it takes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.pixels[..]) as u64 + self.gloss.iter().map(Gloss::bytes).sum::<u64>()
    }
}

#[derive(Debug, Clone)]
pub struct SourceView {
    /// Metres to the right of the middle of the output views.
    pub offset_m: f64,
    /// As many as output views have.
    pub rows: Vec<SourceRow>,
    /// With any pixel.
    pub layers: u32,
}

impl SourceView {
    /// An image as a source view, by columns and rows: light, and planar distances in metres; `None` where nothing is known.
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

    /// With all pixels so many columns farther to the left.
    #[must_use]
    pub fn moved_left(mut self, columns: i32) -> SourceView {
        self.rows.iter_mut().flat_map(|row| &mut row.pixels).for_each(|pixel| pixel.column -= columns);
        self
    }

    /// With the pixels of its rows.
    pub fn of_rows(offset_m: f64, rows: Vec<SourceRow>) -> SourceView {
        let layers = |row: &SourceRow| row.pixels.last().map_or(0, |pixel| u32::from(pixel.layer) + 1);
        let layers = rows.iter().map(layers).max().unwrap_or(0);
        SourceView { offset_m, rows, layers }
    }

    pub fn pixel_count(&self) -> u64 {
        self.rows.iter().map(|row| row.pixels.len() as u64).sum()
    }
}

/// Sources by their place, each place once: their order in a list does not matter.
pub fn in_order(mut sources: Vec<SourceView>) -> Vec<SourceView> {
    sources.sort_by(|a, b| a.offset_m.total_cmp(&b.offset_m));
    sources.dedup_by(|a, b| a.offset_m == b.offset_m);
    sources
}
