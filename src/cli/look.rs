//! Conversion of rendered light to the 8-bit codes of PNG files, streams and films: a display, or a lookup table.

use std::sync::Arc;

use codec::image::{Display, Plane, Primaries, ToneMap, Transfer};
use footage::image_files::lookup_table::LookupTable;
use render::rendered_image::RenderedImage;

/// Values that a lookup table takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableInput {
    /// Linear light with the primaries of the container.
    Linear,
    /// ACEScct (S-2016-001), with AP1 primaries.
    AcesCct,
}

/// A lookup table, and what it is applied to.
#[derive(Debug)]
pub struct TableLook {
    pub table: LookupTable,
    pub input: TableInput,
    /// Factor of light before the table.
    pub gain: f64,
}

#[derive(Debug, Clone)]
pub enum Look {
    Display(Display),
    Table(Arc<TableLook>),
}

impl From<ToneMap> for Look {
    fn from(tone: ToneMap) -> Look {
        Look::Display(tone.into())
    }
}

impl Look {
    /// Returns 8-bit codes and alpha; colour is not premultiplied by alpha.
    pub fn rgba_codes(&self, image: &RenderedImage) -> Plane<[u8; 4]> {
        match self {
            Look::Display(display) => image.rgba_codes(*display),
            Look::Table(look) => look.rgba_codes(image),
        }
    }

    /// Returns the transfer function of the codes, as far as it is known.
    pub fn transfer(&self) -> Transfer {
        match self {
            Look::Display(display) => display.tone.transfer,
            Look::Table(_) => Transfer::Srgb,
        }
    }
}

impl TableLook {
    fn rgba_codes(&self, image: &RenderedImage) -> Plane<[u8; 4]> {
        let matrix = match self.input {
            TableInput::Linear => None,
            TableInput::AcesCct => image.primaries.conversion_to(Primaries::ACESCG),
        };
        Plane::from_fn(image.color.width(), image.color.height(), |x, y| {
            let light = image.color.get(x, y);
            let exposed =
                matrix.map_or(light, |matrix| matrix.convert(light)).map(|light| f64::from(light) * self.gain);
            let [r, g, b] = self.table.apply(exposed.map(|light| match self.input {
                TableInput::Linear => light as f32,
                TableInput::AcesCct => acescct(light) as f32,
            }));
            let code = |value: f32| (f64::from(value) * 255.0).round().clamp(0.0, 255.0) as u8;
            [code(r), code(g), code(b), (image.alpha.get(x, y) * 255.0).round() as u8]
        })
    }
}

/// Returns the ACEScct value of linear light: a line below 2^-7, log2 above (S-2016-001, 4.4).
fn acescct(light: f64) -> f64 {
    const BREAK: f64 = 0.007_812_5;
    const SLOPE: f64 = 10.540_237_741_654_5;
    const OFFSET: f64 = 0.072_905_534_195_835_5;
    if light > BREAK { (light.log2() + 9.72) / 17.52 } else { SLOPE * light + OFFSET }
}

#[cfg(test)]
mod tests {
    use super::*;
    use footage::image_files::lookup_table;

    #[test]
    fn acescct_has_its_published_values() {
        // S-2016-001, table 1: mid gray, the minimum and the maximum of half floats, and 1.
        for (light, expected) in [(0.18, 0.413_588_4), (0.0, 0.072_905_5), (65504.0, 1.467_996_3), (1.0, 0.554_794_5)] {
            assert!((acescct(light) - expected).abs() < 1e-6, "{light} {}", acescct(light));
        }
        assert!((acescct(0.007_812_5) - acescct(0.007_812_500_1)).abs() < 1e-6);
    }

    #[test]
    fn a_table_is_applied_to_exposed_light() {
        let table = lookup_table::parse(&mut &b"LUT_1D_SIZE 2\nDOMAIN_MAX 2 2 2\n0 0 0\n1 1 1\n"[..]).unwrap();
        let image = RenderedImage::of_pixels([2, 1], [[0.5, 1.0, 4.0, 1.0], [f32::NAN, -1.0, 0.25, 0.5]].into_iter());
        let look = |input, gain| Look::Table(Arc::new(TableLook { table: table.clone(), input, gain }));
        let codes = |look: Look| look.rgba_codes(image.as_ref().unwrap()).data().to_vec();
        assert_eq!(codes(look(TableInput::Linear, 1.0)), [[64, 128, 255, 255], [0, 0, 32, 128]]);
        assert_eq!(codes(look(TableInput::Linear, 0.5)), [[32, 64, 255, 255], [0, 0, 16, 128]]);
        // Gray stays gray in AP1; (log2(1/2) + 9.72) / 17.52 / 2 * 255 = 63.46.
        let gray = RenderedImage::of_pixels([1, 1], std::iter::once([0.5, 0.5, 0.5, 1.0])).unwrap();
        assert_eq!(look(TableInput::AcesCct, 1.0).rgba_codes(&gray).data(), [[63, 63, 63, 255]]);
    }
}
