//! Distinguishes linear colour from sRGB codes.

use half::f16;

use super::finding::{Finding, Verdict, percent};
use crate::image_files::ColorSpace;
use codec::image::{ColorPlane, Transfer};

/// With fewer pixels the check is inconclusive.
const MIN_PIXELS: u64 = 1000;
/// Minimum share of values above 1, the maximum of sRGB codes, that is not accidental.
const ABOVE_SHARE: f64 = 1e-4;
/// Minimum share of dim values at multiples of 1/255 for which the file is taken to hold codes. Of evenly distributed half floats
/// at most half are multiples.
const CODES_SHARE: f64 = 0.999;

/// Sample type of colour files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Files {
    /// Integers up to 255 or 65535: PNG.
    Integers,
    Floats,
}

/// Statistics of colour values, interpreted as linear.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ColorValues {
    pub pixels: u64,
    pub values: u64,
    pub above_one: u64,
    /// Number of components from 0.02 to 0.25, where half floats are much finer than multiples of 1/255.
    pub dim: u64,
    /// Number of `dim` components that are the half float nearest to a multiple of 1/255.
    pub codes: u64,
}

impl ColorValues {
    pub fn count(plane: &ColorPlane) -> ColorValues {
        let mut found = ColorValues { pixels: plane.data().len() as u64, ..ColorValues::default() };
        for component in plane.data().as_flattened() {
            let value = component.to_f32();
            found.values += 1;
            found.above_one += u64::from(value > 1.0);
            if (0.02..0.25).contains(&value) {
                found.dim += 1;
                let code = (value * 255.0).round() / 255.0;
                found.codes += u64::from(f16::from_f32(code) == *component);
            }
        }
        found
    }

    pub fn add(self, other: ColorValues) -> ColorValues {
        ColorValues {
            pixels: self.pixels + other.pixels,
            values: self.values + other.values,
            above_one: self.above_one + other.above_one,
            dim: self.dim + other.dim,
            codes: self.codes + other.codes,
        }
    }
}

pub fn check(values: &ColorValues, space: ColorSpace, files: Files) -> Finding {
    let above = values.above_one as f64 / values.values.max(1) as f64;
    let codes = values.codes as f64 / values.dim.max(1) as f64;
    let told = values.pixels >= MIN_PIXELS;
    let is_light = space.transfer() == Transfer::Linear;
    let (verdict, says) = match files {
        Files::Integers if is_light => (Verdict::CannotTell, "PNG files rarely hold linear light".to_owned()),
        _ if is_light && told && above >= ABOVE_SHARE => {
            (Verdict::Fine, format!("{} of the values are above 1, as only light is", percent(above)))
        }
        _ if is_light && told && values.dim >= MIN_PIXELS && codes >= CODES_SHARE => {
            (Verdict::Suspect, "all values are 255ths: they look like sRGB codes, not like linear light".to_owned())
        }
        // sRGB codes are at most 1, and so are the linear values decoded from them.
        _ if !is_light && told && above >= ABOVE_SHARE => {
            (Verdict::Suspect, format!("{} of the values are above 1, where sRGB codes end", percent(above)))
        }
        _ => (Verdict::CannotTell, "no value is above 1, as in light and in codes".to_owned()),
    };
    Finding::new("color.space", verdict, says).with(&[("above_one", above), ("255ths", codes)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::Plane;

    fn plane(value: impl Fn(u32) -> f32) -> ColorPlane {
        Plane::from_fn(64, 64, |x, y| [f16::from_f32(value(y * 64 + x)); 3])
    }

    #[test]
    fn codes_and_light() {
        let light = ColorValues::count(&plane(|at| at as f32 / 3000.0));
        let codes = ColorValues::count(&plane(|at| (at % 256) as f32 / 255.0));
        let dim = ColorValues::count(&plane(|at| at as f32 / 5000.0));
        let verdict = |values, space| check(values, space, Files::Floats).verdict;
        assert_eq!(verdict(&light, ColorSpace::LinearRec709), Verdict::Fine);
        assert_eq!(verdict(&light, ColorSpace::Srgb), Verdict::Suspect);
        assert_eq!(verdict(&codes, ColorSpace::LinearRec709), Verdict::Suspect);
        assert_eq!(verdict(&codes, ColorSpace::Srgb), Verdict::CannotTell);
        assert_eq!(verdict(&dim, ColorSpace::LinearRec709), Verdict::CannotTell);
    }
}
