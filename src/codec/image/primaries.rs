//! Primaries and white point of linear RGB, as CIE 1931 chromaticities, and conversion matrices between them.
//!
//! A conversion maps the first primaries to CIE XYZ (SMPTE RP 177), adapts the white point by the Bradford transform, and maps
//! XYZ to the second primaries. Matrices are computed in 64-bit floats. Colours outside the target gamut have negative
//! components; nothing is clipped.

use glam::{DMat3, DVec3};
use half::f16;

use crate::error::{Error, Result};
use crate::image::ColorPlane;

/// Matrix from XYZ to cone responses (Lam 1985).
const BRADFORD: DMat3 =
    DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);
/// Maximum difference of chromaticities that count as equal; writers round them differently.
const SAME: f32 = 1e-5;

/// The x and y of red, green, blue and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    pub red: [f32; 2],
    pub green: [f32; 2],
    pub blue: [f32; 2],
    pub white: [f32; 2],
}

const D65: [f32; 2] = [0.3127, 0.3290];
const ACES_WHITE: [f32; 2] = [0.32168, 0.33767];

impl Primaries {
    /// Primaries of sRGB, and of OpenEXR files that state none.
    pub const REC709: Primaries = Primaries { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: D65 };
    /// AP1 (S-2014-004).
    pub const ACESCG: Primaries =
        Primaries { red: [0.713, 0.293], green: [0.165, 0.83], blue: [0.128, 0.044], white: ACES_WHITE };
    /// AP0 (SMPTE ST 2065-1).
    pub const ACES2065_1: Primaries =
        Primaries { red: [0.7347, 0.2653], green: [0.0, 1.0], blue: [0.0001, -0.077], white: ACES_WHITE };
    /// ITU-R BT.2020.
    pub const REC2020: Primaries =
        Primaries { red: [0.708, 0.292], green: [0.17, 0.797], blue: [0.131, 0.046], white: D65 };
    /// SMPTE EG 432-1 with D65 white.
    pub const P3_D65: Primaries = Primaries { red: [0.68, 0.32], green: [0.265, 0.69], blue: [0.15, 0.06], white: D65 };

    /// Creates primaries from red x, red y, green x, and so on to white y, the order of files. Fails if the chromaticities span
    /// no gamut.
    pub fn from_array(values: [f32; 8]) -> Result<Primaries> {
        let [red, green, blue, white] = [0, 2, 4, 6].map(|at| [values[at], values[at + 1]]);
        let primaries = Primaries { red, green, blue, white };
        let whole = primaries.to_xyz().filter(|matrix| matrix.is_finite() && matrix.inverse().is_finite());
        match whole {
            Some(_) => Ok(primaries),
            None => Err(Error::invalid(format!("the chromaticities {values:?} do not define a colour space"))),
        }
    }

    pub fn to_array(self) -> [f32; 8] {
        let Primaries { red, green, blue, white } = self;
        [red[0], red[1], green[0], green[1], blue[0], blue[1], white[0], white[1]]
    }

    pub fn is_rec709(self) -> bool {
        self.is_same(Primaries::REC709)
    }

    /// Returns true if both are equal up to the rounding in files.
    pub fn is_same(self, other: Primaries) -> bool {
        self.to_array().iter().zip(other.to_array()).all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// Returns the matrix from linear RGB in these primaries to linear RGB in `other`; `None` if both are the same.
    pub fn conversion_to(self, other: Primaries) -> Option<LightMatrix> {
        if self.is_same(other) {
            return None;
        }
        let (from, to) = (self.to_xyz()?, other.to_xyz()?);
        let cones = |primaries: Primaries| Some(BRADFORD * xyz(primaries.white)?);
        let adapt = BRADFORD.inverse() * DMat3::from_diagonal(cones(other)? / cones(self)?) * BRADFORD;
        Some(LightMatrix(to.inverse() * adapt * from))
    }

    /// Returns the matrix from RGB to XYZ. Its columns are the XYZ of red, green and blue; they sum to white with Y = 1.
    fn to_xyz(self) -> Option<DMat3> {
        let columns = DMat3::from_cols(xyz(self.red)?, xyz(self.green)?, xyz(self.blue)?);
        if columns.determinant().abs() < 1e-9 {
            return None;
        }
        Some(columns * DMat3::from_diagonal(columns.inverse() * xyz(self.white)?))
    }
}

/// Returns XYZ with Y = 1; `None` if the chromaticities are not those of a colour.
fn xyz([x, y]: [f32; 2]) -> Option<DVec3> {
    let (x, y) = (f64::from(x), f64::from(y));
    let found = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    found.is_finite().then_some(found)
}

/// Matrix that converts linear RGB between two sets of primaries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightMatrix(DMat3);

impl LightMatrix {
    pub fn convert(self, light: [f32; 3]) -> [f32; 3] {
        (self.0 * DVec3::from_array(light.map(f64::from))).to_array().map(|value| value as f32)
    }

    /// Converts as [`Self::convert`] does, rounded to half floats and clamped to their finite range.
    pub fn convert_half(self, light: [f16; 3]) -> [f16; 3] {
        let [least, most] = [f16::MIN, f16::MAX].map(f16::to_f64);
        let light = self.0 * DVec3::from_array(light.map(f16::to_f64));
        light.to_array().map(|value| f16::from_f64(value.clamp(least, most)))
    }

    pub fn convert_plane(self, plane: &ColorPlane) -> ColorPlane {
        plane.map(|&light| self.convert_half(light))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(from: Primaries, to: Primaries) -> [[f64; 3]; 3] {
        from.conversion_to(to).unwrap().0.transpose().to_cols_array_2d()
    }

    fn near(found: [[f64; 3]; 3], published: [[f64; 3]; 3]) {
        for (found, published) in found.iter().flatten().zip(published.iter().flatten()) {
            assert!((found - published).abs() < 1e-4, "{found} {published}");
        }
    }

    #[test]
    fn matrices_are_those_that_are_published() {
        // ACES: AP1 and AP0 to sRGB, with Bradford adaptation.
        let acescg = [
            [1.705_051, -0.621_792, -0.083_259],
            [-0.130_256, 1.140_805, -0.010_548],
            [-0.024_003, -0.128_969, 1.152_972],
        ];
        near(rows(Primaries::ACESCG, Primaries::REC709), acescg);
        let aces = [
            [2.521_686, -1.134_131, -0.387_555],
            [-0.276_480, 1.372_719, -0.096_239],
            [-0.015_378, -0.152_975, 1.168_354],
        ];
        near(rows(Primaries::ACES2065_1, Primaries::REC709), aces);
        // ITU-R BT.2087, to four digits.
        let rec2020 = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        near(rows(Primaries::REC2020, Primaries::REC709), rec2020);
        let p3 = [[1.224_940, -0.224_940, 0.0], [-0.042_057, 1.042_057, 0.0], [-0.019_638, -0.078_636, 1.098_274]];
        near(rows(Primaries::P3_D65, Primaries::REC709), p3);
    }

    #[test]
    fn gray_stays_gray_and_ways_back_return() {
        let all = [Primaries::REC709, Primaries::ACESCG, Primaries::ACES2065_1, Primaries::REC2020, Primaries::P3_D65];
        for (from, to) in all.iter().flat_map(|from| all.iter().map(move |to| (*from, *to))) {
            let Some(there) = from.conversion_to(to) else {
                assert_eq!(from, to);
                continue;
            };
            let back = to.conversion_to(from).unwrap();
            for light in [[1.0; 3], [0.25, 4.0, 0.0]] {
                let shown = there.convert(light);
                if light == [1.0; 3] {
                    assert!(shown.iter().all(|value| (value - 1.0).abs() < 1e-6), "{shown:?}");
                }
                let again = back.convert(shown);
                assert!(light.iter().zip(again).all(|(a, b)| (a - b).abs() < 1e-5), "{light:?} {again:?}");
            }
        }
    }

    #[test]
    fn what_spans_no_colours_is_refused() {
        let bad = [[0.0; 8], [0.3; 8], [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3, f32::NAN]];
        for values in bad {
            assert!(Primaries::from_array(values).is_err(), "{values:?}");
        }
        let rounded = Primaries { white: [0.312_699_97, 0.329_000_03], ..Primaries::REC709 };
        assert!(rounded.is_rec709() && rounded.conversion_to(Primaries::REC709).is_none());
        assert_eq!(Primaries::from_array(Primaries::ACES2065_1.to_array()).unwrap(), Primaries::ACES2065_1);
        assert!(!Primaries::REC2020.is_rec709());
    }
}
