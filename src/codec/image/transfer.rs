//! Table-based conversion of scene-referred half floats to and from 8-bit display codes.
//!
//! Encoding: value × 2^exposure, transfer curve, × 255, rounded to nearest, clamped to 0..255. Decoding is the inverse: codes
//! round-trip for exposures in −8..8 EV.

use std::sync::OnceLock;

use half::f16;

/// Transfer function between linear RGB and 8-bit codes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Transfer {
    /// The piecewise curve of IEC 61966-2-1.
    #[default]
    Srgb,
    /// Code = 255 × linear value.
    Linear,
}

impl Transfer {
    /// Returns `srgb` or `linear`.
    pub fn name(self) -> &'static str {
        if self == Transfer::Srgb { "srgb" } else { "linear" }
    }

    /// Converts a linear value, where 1 is the maximum code, to a code in 0..1. Odd-symmetric below 0; NaN stays NaN.
    pub fn encode(self, linear: f64) -> f64 {
        match self {
            Transfer::Linear => linear,
            Transfer::Srgb if linear.abs() <= 0.003_130_8 => linear * 12.92,
            Transfer::Srgb => (1.055 * libm::pow(linear.abs(), 1.0 / 2.4) - 0.055).copysign(linear),
        }
    }

    /// Inverse of [`Self::encode`].
    pub fn decode(self, code: f64) -> f64 {
        match self {
            Transfer::Linear => code,
            Transfer::Srgb if code.abs() <= 0.040_45 => code / 12.92,
            Transfer::Srgb => libm::pow((code.abs() + 0.055) / 1.055, 2.4).copysign(code),
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ToneMap {
    pub transfer: Transfer,
    /// Exposure in stops, −8..8; at 0, a linear value of 1.0 is the maximum code.
    pub exposure_ev: f32,
}

impl ToneMap {
    /// Returns the 8-bit code of a linear value, clamped to 0..255; 0 for NaN.
    pub fn code(self, light: f32) -> u8 {
        Display::from(self).code(light)
    }

    /// Returns the factor of the exposure.
    pub fn gain(self) -> f64 {
        libm::exp2(self.exposure_ev.into())
    }
}

/// Curve that maps exposed linear light to the range of a display, before the transfer function.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Light above 1 is clipped.
    #[default]
    None,
    /// x / (1 + x).
    Reinhard,
    /// x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14): a rational curve with a toe and a shoulder.
    Filmic,
}

impl ToneCurve {
    /// Exposed light at which the curves have reached their limit in single precision.
    const MAX_LIGHT: f64 = 1e9;

    /// Returns the light that is displayed for exposed light: 0 for light below 0 and for NaN, except that [`ToneCurve::None`] keeps
    /// both. All curves are monotone.
    pub fn apply(self, light: f64) -> f64 {
        let x = light.clamp(0.0, Self::MAX_LIGHT).max(0.0);
        match self {
            ToneCurve::None => light,
            ToneCurve::Reinhard => x / (1.0 + x),
            ToneCurve::Filmic => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
        }
    }
}

/// How linear light is displayed: exposure, then a tone curve, then a transfer function.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Display {
    /// Exposure and transfer function.
    pub tone: ToneMap,
    pub curve: ToneCurve,
}

impl Display {
    /// Returns the 8-bit code of a linear value, clamped to 0..255; 0 for NaN.
    pub fn code(self, light: f32) -> u8 {
        let shown = self.curve.apply(f64::from(light) * self.tone.gain());
        // The cast converts NaN to 0.
        (self.tone.transfer.encode(shown) * 255.0).round().clamp(0.0, 255.0) as u8
    }
}

impl From<ToneMap> for Display {
    fn from(tone: ToneMap) -> Display {
        Display { tone, curve: ToneCurve::None }
    }
}

/// Flag of an entry of [`EncodeTable`]: the value was clipped.
const CLIPPED: u16 = 0x100;

/// The 8-bit code of each of the 65,536 half floats.
#[derive(Debug, Clone)]
pub struct EncodeTable {
    entries: Vec<u16>,
    tone: ToneMap,
}

impl EncodeTable {
    pub fn new(tone: &ToneMap) -> EncodeTable {
        let gain = tone.gain();
        let entry = |bits: u16| {
            let value = f16::from_bits(bits).to_f64() * gain;
            // The power function is evaluated only for values in range.
            if value.is_nan() {
                return 0;
            }
            if value >= 2.0 {
                return 255 | CLIPPED;
            }
            if value <= -0.002 {
                return CLIPPED;
            }
            let code = tone.transfer.encode(value) * 255.0;
            // Decoding may give values above 1 by half-float rounding; these are code 255 and not clipped.
            let clipped = value > 1.0 + 1.0 / 2048.0 || code <= -0.5;
            code.round().clamp(0.0, 255.0) as u16 | if clipped { CLIPPED } else { 0 }
        };
        EncodeTable { entries: (0..=u16::MAX).map(entry).collect(), tone: *tone }
    }

    /// Returns the 8-bit code; 0 for NaN.
    pub fn code(&self, value: f16) -> u8 {
        self.entries[value.to_bits() as usize] as u8
    }

    /// Returns the code without clamping to 0..255, by extending the curve; 0 for NaN.
    pub fn unclipped_code(&self, value: f16) -> i32 {
        if !self.is_clipped(value) {
            return i32::from(self.code(value));
        }
        // The cast saturates.
        (self.tone.transfer.encode(value.to_f64() * self.tone.gain()) * 255.0).round() as i32
    }

    /// Returns true if the value is clipped by more than rounding.
    pub fn is_clipped(&self, value: f16) -> bool {
        self.entries[value.to_bits() as usize] & CLIPPED != 0
    }
}

/// Minimum linear value of each code from 1 on. Gives the codes of [`Display::code`] without a power function.
#[derive(Debug, Clone)]
pub struct CodeSteps {
    least: [f32; 255],
}

impl CodeSteps {
    pub fn new(display: impl Into<Display>) -> CodeSteps {
        let display = display.into();
        let least = |code: usize| {
            // Bits of non-negative floats sort as their values.
            let (mut below, mut from) = (0, f32::INFINITY.to_bits());
            while from - below > 1 {
                let middle = below + (from - below) / 2;
                let reaches = usize::from(display.code(f32::from_bits(middle))) >= code;
                (below, from) = if reaches { (below, middle) } else { (middle, from) };
            }
            f32::from_bits(from)
        };
        CodeSteps { least: std::array::from_fn(|at| least(at + 1)) }
    }

    /// Returns the 8-bit code; 0 for NaN.
    pub fn code(&self, light: f32) -> u8 {
        self.least.partition_point(|least| *least <= light) as u8
    }
}

/// The linear value of each of the 256 codes.
#[derive(Debug, Clone)]
pub struct DecodeTable {
    entries: [f16; 256],
}

impl DecodeTable {
    pub fn new(tone: &ToneMap) -> DecodeTable {
        let gain = tone.gain();
        let entry = |code: usize| f16::from_f64(tone.transfer.decode(code as f64 / 255.0) / gain);
        DecodeTable { entries: std::array::from_fn(entry) }
    }

    pub fn value(&self, code: u8) -> f16 {
        self.entries[code as usize]
    }
}

/// Returns the linear value of every 16-bit sRGB code, computed once.
pub fn srgb16() -> &'static [f16] {
    static TABLE: OnceLock<Vec<f16>> = OnceLock::new();
    TABLE.get_or_init(|| {
        (0..=u16::MAX).map(|code| f16::from_f64(Transfer::Srgb.decode(f64::from(code) / 65535.0))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_give_the_codes_of_the_curve() {
        for transfer in [Transfer::Srgb, Transfer::Linear] {
            for exposure_ev in [-8.0, 0.0, 2.5] {
                for curve in [ToneCurve::None, ToneCurve::Reinhard, ToneCurve::Filmic] {
                    let display = Display { tone: ToneMap { transfer, exposure_ev }, curve };
                    let steps = CodeSteps::new(display);
                    let around = steps.least.iter().flat_map(|least| [least.next_down(), *least, least.next_up()]);
                    let all = (0..=u16::MAX).map(|bits| f32::from_bits(u32::from(bits) << 16 | 0x1234));
                    for light in around.chain(all) {
                        assert_eq!(steps.code(light), display.code(light), "{display:?} {light}");
                    }
                }
            }
        }
    }

    #[test]
    fn tone_curves_have_their_values() {
        // By hand, from the formulas of viewer/src/gpu/present.wgsl: light 1/2, 1 and 4.
        let reinhard = [0.5, 1.0, 4.0].map(|light| ToneCurve::Reinhard.apply(light));
        assert_eq!(reinhard, [1.0 / 3.0, 0.5, 0.8]);
        let filmic = [0.5, 1.0, 4.0].map(|light| ToneCurve::Filmic.apply(light));
        for (found, expected) in filmic.into_iter().zip([0.6425 / 1.0425, 2.54 / 3.16, 40.28 / 41.38]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        for curve in [ToneCurve::Reinhard, ToneCurve::Filmic] {
            assert_eq!([-1.0, 0.0, f64::NAN, f64::NEG_INFINITY].map(|light| curve.apply(light)), [0.0; 4]);
            assert!((curve.apply(f64::INFINITY) - curve.apply(1e12)).abs() < 1e-6);
            let display = Display { tone: ToneMap { exposure_ev: 10.0, ..ToneMap::default() }, curve };
            assert_eq!([f32::INFINITY, f32::MAX, 65504.0].map(|light| display.code(light)), [255; 3]);
        }
        // sRGB codes of 1/3, at exposure 0 and for half the light at one stop more: 255 (1.055 (1/3)^(1/2.4) - 0.055) = 156.16.
        let code = |exposure_ev, light| {
            Display { tone: ToneMap { exposure_ev, ..ToneMap::default() }, curve: ToneCurve::Reinhard }.code(light)
        };
        assert_eq!([code(0.0, 0.5), code(1.0, 0.25), code(-1.0, 1.0)], [156; 3]);
    }

    #[test]
    fn every_code_comes_back() {
        for transfer in [Transfer::Srgb, Transfer::Linear] {
            for step in -64..=64 {
                let tone = ToneMap { transfer, exposure_ev: step as f32 / 8.0 };
                let (encode, decode) = (EncodeTable::new(&tone), DecodeTable::new(&tone));
                for code in 0..=255 {
                    let value = decode.value(code);
                    assert_eq!(encode.code(value), code, "{tone:?}");
                    assert_eq!(tone.code(value.to_f32()), code, "{tone:?}");
                    assert!(!encode.is_clipped(value), "{tone:?} {code}");
                }
            }
        }
    }

    #[test]
    fn out_of_range_is_flagged() {
        let table = EncodeTable::new(&ToneMap::default());
        let flags = |value: f32| {
            let value = f16::from_f32(value);
            (table.code(value), table.is_clipped(value))
        };
        assert_eq!(flags(1.0), (255, false));
        assert_eq!(flags(1.01), (255, true));
        assert_eq!(flags(f32::INFINITY), (255, true));
        assert_eq!(flags(-1e-5), (0, false));
        assert_eq!(flags(-0.01), (0, true));
        assert_eq!(flags(f32::NAN), (0, false));
        assert_eq!(flags(0.0), (0, false));
        let unclipped = [0.0, 0.5, 1.0, 4.0, -1.0].map(|value| table.unclipped_code(f16::from_f32(value)));
        assert_eq!(unclipped, [0, 188, 255, 465, -255]);
        // Code 128 of the curve, from its published table.
        assert_eq!(flags(0.215_86), (128, false));
        let codes = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.215_86].map(|v| ToneMap::default().code(v));
        assert_eq!(codes, [0, 255, 0, 0, 128]);
    }
}
