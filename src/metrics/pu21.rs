//! A perceptually uniform code of scene-referred HDR colour, in which its PSNR is measured.
//!
//! Based on: R. K. Mantiuk and M. Azimi, "PU21: A novel perceptually uniform encoding for adapting existing quality
//! metrics for HDR", Picture Coding Symposium, 2021; parameter set "banding + glare", the one its authors recommend.
//!
//! Why not a PSNR of logarithms: a logarithm goes to −inf at black, so that its result is the choice of an offset, and
//! it weighs a step of 1% the same in deep shadow, where nobody sees it, as in the light. PU21 follows the measured
//! contrast sensitivity of the eye from 0.005 to 10,000 cd/m², is finite at 0, and is scaled so that the range of a
//! 100 cd/m² display spans 0 to 256: its decibels read like those of 8-bit images.

use half::f16;

use crate::error::{Error, Result};

/// Peak of the PSNR in PU21 units: the code of 100 cd/m², as in the authors' metric, whatever the image's brightest pixel.
pub const PU21_PEAK: f64 = 256.0;
/// Luminance in cd/m² of the sample value 1.0, when nothing else is known: the white of a standard display.
pub const DEFAULT_WHITE_CD_M2: f64 = 100.0;
/// Darkest luminance, in cd/m², that PU21 tells from black.
pub const PU21_MIN_CD_M2: f64 = 0.005;
/// Brightest luminance, in cd/m², that PU21 describes.
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

/// PU21 code of a luminance in cd/m²: about 0 at 0.005, 256 at 100, 595 at 10,000.
/// Luminance outside 0.005..10,000 is clamped, so 0, negative numbers and `−inf` give the code of the floor, `+inf` the
/// code of the ceiling. NaN gives the floor as well.
pub fn pu21_encode(luminance_cd_m2: f64) -> f64 {
    // Clamping alone would let NaN through.
    let y =
        if luminance_cd_m2.is_nan() { PU21_MIN_CD_M2 } else { luminance_cd_m2 }.clamp(PU21_MIN_CD_M2, PU21_MAX_CD_M2);
    let [p1, p2, p3, p4, p5, p6, p7] = P;
    // The same bits on every machine: encoders decide by it.
    let power = libm::pow(y, p4);
    p7 * (libm::pow((p1 + p2 * power) / (1.0 + p3 * power), p5) - p6)
}

/// PU21 codes of all 65,536 half-float values, for one luminance of white.
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
    /// The table in which the sample value 1.0 means `white_cd_m2` cd/m².
    /// Negative samples and NaN have the code of the floor (0.005 cd/m²): neither is light.
    pub fn new(white_cd_m2: f64) -> Result<Self> {
        if !(white_cd_m2.is_finite() && white_cd_m2 > 0.0) {
            return Err(Error::Usage(format!("the luminance of white must be above 0 cd/m2, not {white_cd_m2}")));
        }
        let code = (0..=u16::MAX).map(|bits| pu21_encode(f16::from_bits(bits).to_f64() * white_cd_m2) as f32).collect();
        Ok(PuTable { code })
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
        assert_eq!(pu21_encode(0.0), pu21_encode(0.005));
        assert_eq!(pu21_encode(f64::NAN), pu21_encode(0.005));
        assert_eq!(pu21_encode(f64::INFINITY), pu21_encode(1e4));
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
    fn table_is_monotone_and_finite() {
        let table = PuTable::new(DEFAULT_WHITE_CD_M2).unwrap();
        // Positive halves, zero to infinity, are 0x0000..=0x7c00 in order of value.
        for bits in 0..0x7c00_u16 {
            let [low, high] = [bits, bits + 1].map(|bits| table.encode(f16::from_bits(bits)));
            assert!(low <= high, "{bits:#06x}");
        }
        let floor = table.encode(f16::ZERO);
        for bad in [f16::NEG_ONE, f16::NEG_INFINITY, f16::NAN, f16::MIN] {
            assert_eq!(table.encode(bad), floor);
        }
        assert!((table.encode(f16::ONE) - 256.0).abs() < 0.5);
        assert_eq!(table.encode(f16::INFINITY), table.encode(f16::from_f32(100.0)));
        assert!((0..=u16::MAX).all(|bits| table.encode(f16::from_bits(bits)).is_finite()));
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
        // The same absolute difference weighs less in the light, the same relative one less in deep shadow.
        assert!(apart(20.0, 20.5) < apart(0.1, 0.6));
        assert!(apart(0.000_1, 0.000_2) < apart(1.0, 2.0));
    }
}
