//! Perceptually uniform encoding of scene-referred HDR colour, in which its PSNR is measured.
//!
//! Based on: R. K. Mantiuk and M. Azimi, "PU21: A novel perceptually uniform encoding for adapting existing quality
//! metrics for HDR", Picture Coding Symposium, 2021; parameter set "banding + glare", the one its authors recommend.
//!
//! A PSNR of logarithms is not used: a logarithm diverges at black, so the result depends on the choice of an offset, and it
//! weights a step of 1% in deep shadow, where it is invisible, as much as in bright areas. PU21 follows the measured contrast
//! sensitivity of the eye from 0.005 to 10,000 cd/m², and is scaled so that the range of a 100 cd/m² display spans 0 to 256:
//! decibels are comparable to those of 8-bit images. Darker, negative and brighter values have codes by extrapolation, so that
//! their errors count.

use half::f16;

use crate::error::{Error, Result};

/// Peak of the PSNR in PU21 units: the code of 100 cd/m², as in the authors' metric, independent of the maximum of the image.
pub const PU21_PEAK: f64 = 256.0;
/// Luminance in cd/m² of the sample value 1.0 if none is given: the white of a standard display.
pub const DEFAULT_WHITE_CD_M2: f64 = 100.0;
/// Minimum luminance, in cd/m², that PU21 distinguishes from black.
pub const PU21_MIN_CD_M2: f64 = 0.005;
/// Maximum luminance, in cd/m², for which PU21 is defined.
pub const PU21_MAX_CD_M2: f64 = 10_000.0;

const P: [f64; 7] = [
    0.353_487_901,
    0.373_465_862_9,
    8.277_049_286e-5,
    0.906_256_262_7,
    0.091_503_031_66,
    0.909_951_720_4,
    596.314_814_2,
];

/// Slope below [`PU21_MIN_CD_M2`], per cd/m²: the slope of PU21 at that luminance.
const DARK_SLOPE: f64 = 77.44;
/// Slope above [`PU21_MAX_CD_M2`], per unit of the natural logarithm: the slope of PU21 at that luminance.
const BRIGHT_SLOPE: f64 = 69.93;
/// Sample values whose codes are used for infinities and NaN, with their signs; finite halves end at 65504.
const INFINITE_VALUE: f64 = 131_072.0;
const NAN_VALUE: f64 = 262_144.0;

/// Code of a luminance in cd/m²: about 0 at 0.005, 256 at 100, 595 at 10,000.
///
/// From 0.005 to 10,000 cd/m² it is the code of PU21. It is extrapolated with the slope of PU21 at either end: above linearly in
/// the logarithm of luminance, below linearly in luminance down to black. Negative values mirror positive ones about black. The
/// code increases with luminance everywhere.
pub fn pu21_encode(luminance_cd_m2: f64) -> f64 {
    let magnitude = luminance_cd_m2.abs();
    // libm gives the same bits on every machine, which the decisions of encoders need.
    let code = if magnitude < PU21_MIN_CD_M2 {
        within_range(PU21_MIN_CD_M2) - DARK_SLOPE * (PU21_MIN_CD_M2 - magnitude)
    } else if magnitude <= PU21_MAX_CD_M2 {
        within_range(magnitude)
    } else {
        within_range(PU21_MAX_CD_M2) + BRIGHT_SLOPE * libm::log(magnitude / PU21_MAX_CD_M2)
    };
    let black = within_range(PU21_MIN_CD_M2) - DARK_SLOPE * PU21_MIN_CD_M2;
    if luminance_cd_m2 < 0.0 { 2.0 * black - code } else { code }
}

fn within_range(y: f64) -> f64 {
    let [p1, p2, p3, p4, p5, p6, p7] = P;
    let power = libm::pow(y, p4);
    p7 * (libm::pow((p1 + p2 * power) / (1.0 + p3 * power), p5) - p6)
}

/// PU21 codes of all 65,536 half floats, for one luminance of white.
#[derive(Clone)]
pub struct PuTable {
    code: Vec<f32>,
}

impl std::fmt::Debug for PuTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PuTable(white = {})", self.encode(f16::ONE))
    }
}

impl PuTable {
    /// Creates the table for a sample value 1.0 of `white_cd_m2` cd/m². Infinities have the codes of ±2^17, and NaN those of
    /// ±2^18 by its sign, so neither has the code of a finite half.
    pub fn new(white_cd_m2: f64) -> Result<Self> {
        if !(white_cd_m2.is_finite() && white_cd_m2 > 0.0) {
            return Err(Error::Usage(format!("the luminance of white must be above 0 cd/m2, not {white_cd_m2}")));
        }
        let value = |half: f16| match half {
            _ if half.is_finite() => half.to_f64(),
            _ => (if half.is_nan() { NAN_VALUE } else { INFINITE_VALUE }).copysign(half.to_f64()),
        };
        let code = |bits| pu21_encode(value(f16::from_bits(bits)) * white_cd_m2) as f32;
        Ok(PuTable { code: (0..=u16::MAX).map(code).collect() })
    }

    pub fn encode(&self, sample: f16) -> f32 {
        self.code[usize::from(sample.to_bits())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_codes() {
        assert!((pu21_encode(100.0) - 256.0).abs() < 0.5, "{}", pu21_encode(100.0));
        assert!(pu21_encode(0.005).abs() < 1e-3);
        assert!((pu21_encode(10_000.0) - 595.3939).abs() < 1e-3);
        assert!((pu21_encode(0.0) + 0.3872).abs() < 1e-3, "{}", pu21_encode(0.0));
        assert!((pu21_encode(-100.0) + pu21_encode(100.0) - 2.0 * pu21_encode(0.0)).abs() < 1e-9);
        assert!((pu21_encode(1e5) - pu21_encode(1e4) - 69.93 * 10f64.ln()).abs() < 1e-9);
    }

    #[test]
    fn slope_is_continuous_at_both_ends_of_the_range() {
        for end in [0.005, 1e4] {
            let slope = |from: f64, to: f64| (pu21_encode(to) - pu21_encode(from)) / (to - from);
            let (below, above) = (slope(end * 0.9999, end), slope(end, end * 1.0001));
            assert!((below / above - 1.0).abs() < 1e-3, "{below} {above}");
        }
    }

    #[test]
    fn codes_have_the_same_bits_on_every_machine() {
        let found =
            [0.02, 0.5, 18.0, 100.0, 1234.5].map(|luminance| format!("{:016x}", pu21_encode(luminance).to_bits()));
        assert_eq!(
            found,
            ["3ff1027f8a04f4e2", "4036356c4a0d416d", "406342004ba6a6c2", "4070062471823160", "407b4416af980882"]
        );
    }

    #[test]
    fn table_ascends_with_every_half() {
        for white in [1.0, DEFAULT_WHITE_CD_M2, 10_000.0] {
            let table = PuTable::new(white).unwrap();
            let code = |bits: u16| table.encode(f16::from_bits(bits));
            // Positive halves, from zero to infinity and NaN, are 0x0000..=0x7fff in ascending order.
            for bits in 0..0x7fff_u16 {
                assert!(code(bits) <= code(bits + 1), "{bits:#06x}");
                assert!(code(bits | 0x8000) >= code((bits + 1) | 0x8000), "-{bits:#06x}");
            }
            // Above the range of PU21, codes of neighbouring halves differ by more than rounding.
            assert!((0x7000..0x7bff_u16).all(|bits| code(bits + 1) - code(bits) > 0.02));
            assert_eq!(table.encode(f16::ZERO), table.encode(f16::NEG_ZERO));
            let ascending = [-f16::NAN, f16::NEG_INFINITY, f16::MIN, f16::ZERO, f16::MAX, f16::INFINITY, f16::NAN];
            assert!(ascending.windows(2).all(|pair| table.encode(pair[0]) + 40.0 < table.encode(pair[1])));
            assert!((0..=u16::MAX).all(|bits| code(bits).is_finite()));
        }
        assert!((PuTable::new(DEFAULT_WHITE_CD_M2).unwrap().encode(f16::ONE) - 256.0).abs() < 0.5);
    }

    #[test]
    fn white_scales_luminance() {
        let table = PuTable::new(1000.0).unwrap();
        assert!((f64::from(table.encode(f16::from_f64(0.5))) - pu21_encode(500.0)).abs() < 1e-4);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(PuTable::new(bad).is_err());
        }
    }

    #[test]
    fn highlights_are_compressed() {
        let table = PuTable::new(DEFAULT_WHITE_CD_M2).unwrap();
        let apart = |a: f32, b: f32| (table.encode(f16::from_f32(a)) - table.encode(f16::from_f32(b))).abs();
        // An absolute difference has less weight in bright areas, a relative difference less in deep shadow.
        assert!(apart(20.0, 20.5) < apart(0.1, 0.6));
        assert!(apart(0.000_1, 0.000_2) < apart(1.0, 2.0));
    }
}
