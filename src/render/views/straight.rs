//! Conversion of premultiplied colours to straight colours.

use half::f16;

use codec::image::Transfer;

/// Divides light by the alpha that it was multiplied by; 0 if alpha is 0.
pub(crate) fn straight(light: f32, alpha: f32) -> f32 {
    if alpha > 0.0 { light / alpha } else { 0.0 }
}

/// Converts NaN to 0, and infinities to the largest half, as the encoders do. Containers may hold both, and a blend weight of 0
/// would turn an infinity into NaN.
pub fn finite_half(light: f16) -> f16 {
    if light.is_nan() { f16::ZERO } else { light.clamp(f16::MIN, f16::MAX) }
}

/// Computes `straight` of a half float; values beyond the range of halves become the largest half.
pub fn straight_half(light: f16, alpha: f32) -> f16 {
    match alpha {
        1.0 => light,
        _ => f16::from_f32(straight(light.to_f32(), alpha)).clamp(f16::MIN, f16::MAX),
    }
}

/// Table of `straight` for 8-bit codes.
#[derive(Debug)]
pub struct StraightCodes {
    /// Indexed by alpha in 255ths, then by code.
    codes: Vec<u8>,
}

impl StraightCodes {
    /// Creates the table for a transfer curve; it is the same for any exposure.
    pub fn new(transfer: Transfer) -> StraightCodes {
        let light: Vec<f64> = (0..=u8::MAX).map(|code| transfer.decode(f64::from(code) / 255.0)).collect();
        let straight = |alpha: u8, code: u8| match alpha {
            0 => 0,
            u8::MAX => code,
            _ => {
                (transfer.encode(light[usize::from(code)] * 255.0 / f64::from(alpha)) * 255.0).round().min(255.0) as u8
            }
        };
        let of = |alpha: u8| (0..=u8::MAX).map(move |code| (alpha, code));
        StraightCodes { codes: (0..=u8::MAX).flat_map(of).map(|(alpha, code)| straight(alpha, code)).collect() }
    }

    /// Returns the texel of a premultiplied colour and its alpha in 255ths.
    pub fn texel(&self, color: [u8; 3], alpha: u8) -> [u8; 4] {
        let [r, g, b] = color.map(|code| self.codes[usize::from(alpha) << 8 | usize::from(code)]);
        [r, g, b, alpha]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::ToneMap;

    #[test]
    fn multiplied_light_is_divided_again() {
        for transfer in [Transfer::Srgb, Transfer::Linear] {
            let (tone, codes) = (ToneMap { transfer, exposure_ev: 0.0 }, StraightCodes::new(transfer));
            for code in 0..=u8::MAX {
                let light = transfer.decode(f64::from(code) / 255.0) as f32;
                assert_eq!(codes.texel([code, 0, 255], 255), [code, 0, 255, 255]);
                assert_eq!(codes.texel([code, 0, 255], 0), [0; 4]);
                // At an alpha of a half, half a code of premultiplied light is up to one code of straight light.
                let [straight, ..] = codes.texel([tone.code(light * 128.0 / 255.0), 0, 0], 128);
                assert!(straight.abs_diff(code) <= 1, "{transfer:?}: {straight} of {code}");
                assert!((straight_half(f16::from_f32(light * 0.25), 0.25).to_f32() - light).abs() <= light / 1024.0);
            }
            assert_eq!(codes.texel([200, 10, 0], 1), [255, if transfer == Transfer::Linear { 255 } else { 228 }, 0, 1]);
        }
        assert_eq!(straight_half(f16::MAX, 0.5), f16::MAX);
        assert_eq!(straight_half(f16::MAX, 0.0), f16::ZERO);
    }
}
