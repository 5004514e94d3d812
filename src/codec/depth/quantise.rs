//! Conversion between metres and 16-bit log codes (depth.md 2).
//!
//! Based on: CALF 5.3, equation 13. The paper uses all codes for surfaces, so the sky becomes a surface at far. Here code 65535
//! is exactly the background, which leaves 65,534 steps of 0.0015% of the span. Near and far are those of the probe, as close to
//! its surfaces as the footage allows; its six faces share them, so that there is no seam between faces.

use std::fmt;

use crate::error::{Error, Result};

pub use crate::metrics::psnr::BACKGROUND_CODE;

/// Code of the far distance, and number of steps from near to far.
pub const FAR_CODE: u16 = u16::MAX - 1;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    near_m: f32,
    far_m: f32,
}

/// Formats a distance in metres, in scientific notation if it has many digits: `0.25`, `1e30`.
pub fn metres_in_words(distance_m: f32) -> String {
    let is_plain = distance_m == 0.0 || !distance_m.is_finite() || (1e-4..1e7).contains(&distance_m.abs());
    if is_plain { distance_m.to_string() } else { format!("{distance_m:e}") }
}

/// Rounds up to two significant digits, for bounds in messages.
pub fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return value;
    }
    let digits = 1 - value.log10().floor() as i32;
    // The tolerance covers the rounding of these operations. A quotient by a power of ten prints with the fewest digits.
    let scale = 10f64.powi(digits.abs());
    if digits >= 0 { (value * scale - 1e-9).ceil() / scale } else { (value / scale - 1e-9).ceil() * scale }
}

impl fmt::Display for DepthRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} m to {} m", metres_in_words(self.near_m), metres_in_words(self.far_m))
    }
}

impl DepthRange {
    /// Creates a range with 0 < `near_m` ≤ `far_m` < ∞. If both are equal, all surfaces have the same code.
    ///
    /// # Errors
    /// [`Error::Invalid`] for any other range.
    pub fn new(near_m: f32, far_m: f32) -> Result<DepthRange> {
        if near_m > 0.0 && near_m <= far_m && far_m.is_finite() {
            Ok(DepthRange { near_m, far_m })
        } else {
            Err(Error::invalid(format!("depths from {near_m} m to {far_m} m: 0 < near <= far < inf was expected")))
        }
    }

    /// Returns the range of a probe without any surface.
    pub fn empty() -> DepthRange {
        DepthRange { near_m: 1.0, far_m: 1.0 }
    }

    pub fn near_m(self) -> f32 {
        self.near_m
    }

    pub fn far_m(self) -> f32 {
        self.far_m
    }

    /// Returns ln(far/near), exact to a few ulp even if far and near are neighbouring floats.
    fn log_span(self) -> f64 {
        let (near, far) = (f64::from(self.near_m), f64::from(self.far_m));
        libm::log1p((far - near) / near)
    }

    /// Returns the code of a surface at `z_m` metres (depth.md 2): round(65534 · ln(z/near) / ln(far/near)). `+inf` is the
    /// background; values below near and NaN are code 0; values beyond far are the far code. If far equals near, all surfaces are
    /// code 0. `Quantiser` is the fast form.
    pub fn code(self, z_m: f32) -> u16 {
        if z_m == f32::INFINITY {
            return BACKGROUND_CODE;
        }
        let span = self.log_span();
        if z_m <= self.near_m || z_m.is_nan() || span == 0.0 {
            return 0;
        }
        let near = f64::from(self.near_m);
        let log = libm::log1p((f64::from(z_m) - near) / near);
        (log / span * f64::from(FAR_CODE) + 0.5).min(f64::from(FAR_CODE)) as u16
    }

    /// Returns the distance in metres of a code: near · (far/near)^(code/65534), exact at both ends; `+inf` for the background.
    pub fn metres(self, code: u16) -> f32 {
        self.metres_within(self.log_span(), code)
    }

    /// As `metres`, with a precomputed logarithm of the span.
    fn metres_within(self, log_span: f64, code: u16) -> f32 {
        match code {
            BACKGROUND_CODE => f32::INFINITY,
            0 => self.near_m,
            FAR_CODE => self.far_m,
            _ => {
                let log = log_span * f64::from(code) / f64::from(FAR_CODE);
                (f64::from(self.near_m) * libm::exp(log)) as f32
            }
        }
    }

    /// Returns the relative difference of the depths of two neighbouring codes: (far/near)^(1/65534) − 1.
    pub fn step_ratio(self) -> f64 {
        libm::expm1(self.log_span() / f64::from(FAR_CODE))
    }

    /// Returns the maximum relative error of a decoded depth whose code differs by up to `codes` from that of the source. It
    /// includes the half step of rounding to a code, and the rounding of the decoded float.
    pub fn relative_error(self, codes: u16) -> f64 {
        if self.log_span() == 0.0 {
            return 0.0;
        }
        let near = f64::from(self.near_m);
        // Floats have the lowest relative precision at near if near is denormal.
        let float = ((f64::from(self.near_m.next_up()) - near) / (2.0 * near)).max(f64::from(f32::EPSILON) / 2.0);
        let code = libm::expm1((f64::from(codes) + 0.5) * self.log_span() / f64::from(FAR_CODE));
        (1.0 + code) * (1.0 + float) - 1.0
    }

    /// Returns the maximum number of codes whose [`Self::relative_error`] is at most `share`; `None` if rounding alone exceeds
    /// it.
    pub fn codes_within(self, share: f64) -> Option<u16> {
        let fits = |codes: &u16| self.relative_error(*codes) <= share;
        if !fits(&0) {
            return None;
        }
        let step = self.log_span() / f64::from(FAR_CODE);
        let estimate = if step > 0.0 { (libm::log1p(share) / step - 0.5).clamp(0.0, f64::from(FAR_CODE)) } else { 0.0 };
        (0..=estimate as u16).rev().find(fits)
    }
}

const CODES: usize = 1 << 16;

/// Table of the metres of all codes.
#[derive(Debug, Clone)]
pub struct CodeTable {
    metres: Box<[f32; CODES]>,
}

impl CodeTable {
    pub fn new(range: DepthRange, background: f32) -> CodeTable {
        let log_span = range.log_span();
        let mut metres = Box::new([f32::INFINITY; CODES]);
        for code in 0..BACKGROUND_CODE {
            metres[usize::from(code)] = range.metres_within(log_span, code);
        }
        metres[usize::from(BACKGROUND_CODE)] = background;
        CodeTable { metres }
    }

    pub fn metres(&self, code: u16) -> f32 {
        self.metres[usize::from(code)]
    }
}

/// Fast form of [`DepthRange::code`]: the same codes by table.
///
/// The float's bit pattern, which increases with the float, selects a bucket, which contains the code of its smallest float.
/// Comparison with the first float of the following codes gives the result in one or two steps.
#[derive(Debug, Clone)]
pub struct Quantiser {
    pub range: DepthRange,
    near_bits: u32,
    far_bits: u32,
    shift: u32,
    bucket_codes: Vec<u16>,
    /// Bit pattern of the first float of each code, and a sentinel at the end.
    first_bits: Vec<u32>,
}

impl Quantiser {
    pub fn new(range: DepthRange) -> Quantiser {
        let (near_bits, far_bits) = (range.near_m.to_bits(), range.far_m.to_bits());
        let span = far_bits - near_bits;
        let mut first_bits = Vec::with_capacity(usize::from(u16::MAX) + 1);
        first_bits.push(near_bits);
        let log_span = range.log_span();
        for code in 1..=FAR_CODE {
            // Starts near the lower boundary of the code, then steps to the first float of the code.
            let log = log_span * (f64::from(code) - 0.5) / f64::from(FAR_CODE);
            let aim = (f64::from(range.near_m) * libm::exp(log)) as f32;
            let mut bits = aim.clamp(range.near_m, range.far_m).to_bits();
            while bits > near_bits && range.code(f32::from_bits(bits)) >= code {
                bits -= 1;
            }
            while bits <= far_bits && range.code(f32::from_bits(bits)) < code {
                bits += 1;
            }
            first_bits.push(bits);
        }
        first_bits.push(u32::MAX);
        let shift = (32 - span.leading_zeros()).saturating_sub(16);
        let bucket_codes =
            (0..=span >> shift).map(|bucket| range.code(f32::from_bits(near_bits + (bucket << shift)))).collect();
        Quantiser { range, near_bits, far_bits, shift, bucket_codes, first_bits }
    }

    /// Returns the code of a depth in metres. `+inf` is the background; `0.0`, an invalid reading taken as near, is code 0.
    /// Returns `None` for other values outside near to far.
    #[inline]
    pub fn code(&self, z_m: f32) -> Option<u16> {
        let bits = z_m.to_bits();
        if bits.wrapping_sub(self.near_bits) <= self.far_bits - self.near_bits {
            let mut code = self.bucket_codes[((bits - self.near_bits) >> self.shift) as usize];
            while bits >= self.first_bits[usize::from(code) + 1] {
                code += 1;
            }
            return Some(code);
        }
        if z_m == f32::INFINITY {
            Some(BACKGROUND_CODE)
        } else if z_m == 0.0 {
            Some(0)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges() -> Vec<DepthRange> {
        let next = |z: f32| f32::from_bits(z.to_bits() + 1);
        [
            (1.0, 1.0),
            (1.0, next(1.0)),
            (1.0, 1.0 + 1e-5),
            (0.5, 37.25),
            (0.001, 1000.0),
            (1e-6, 1e6),
            (1e-45, 1e-40),
            (1e-45, 3e38),
            (f32::MIN_POSITIVE, 1.0),
        ]
        .map(|(near, far)| DepthRange::new(near, far).unwrap())
        .to_vec()
    }

    #[test]
    fn the_fast_form_gives_the_codes_of_the_plain_form() {
        for range in ranges() {
            let fast = Quantiser::new(range);
            let (low, high) = (range.near_m.to_bits(), range.far_m.to_bits());
            let stride = ((high - low) / 300_000).max(1);
            let boundaries = fast.first_bits[..65535].iter().flat_map(|&bits| [bits.max(low + 1) - 1, bits.min(high)]);
            for bits in (low..=high).step_by(stride as usize).chain(boundaries).chain([low, high]) {
                let z = f32::from_bits(bits.min(high));
                assert_eq!(fast.code(z), Some(range.code(z)), "{z:e} in {range:?}");
            }
            assert_eq!(fast.code(f32::INFINITY), Some(BACKGROUND_CODE));
            assert_eq!(fast.code(f32::NAN), None);
            assert_eq!(fast.code(-1.0), None);
            assert_eq!(fast.code(f32::from_bits(high + 1)).filter(|&code| code != BACKGROUND_CODE), None);
        }
    }

    #[test]
    fn every_code_comes_back_from_its_own_metres_where_floats_are_fine_enough() {
        for range in ranges() {
            let mut last = 0.0;
            for code in 0..=FAR_CODE {
                let metres = range.metres(code);
                assert!(metres >= last && metres >= range.near_m && metres <= range.far_m, "{code} in {range:?}");
                last = metres;
            }
            assert_eq!(range.metres(0), range.near_m);
            assert_eq!(range.metres(FAR_CODE), range.far_m);
        }
        let range = DepthRange::new(0.5, 37.25).unwrap();
        for code in 0..=FAR_CODE {
            assert_eq!(range.code(range.metres(code)), code);
        }
    }

    #[test]
    fn every_float_comes_back_within_half_a_step() {
        for range in ranges() {
            let half = (range.log_span() / 65534.0 / 2.0).exp_m1() * (1.0 + 1e-6) + 1.2e-7;
            let (low, high) = (range.near_m.to_bits(), range.far_m.to_bits());
            for bits in (low..=high).step_by(((high - low) / 50_000).max(1) as usize) {
                let z = f32::from_bits(bits);
                let back = range.metres(range.code(z));
                // The error of a float can be as large as its spacing, which matters below 1e-38.
                let spacing = f64::from(f32::from_bits(bits + 1)) - f64::from(z);
                let error = (f64::from(back) - f64::from(z)).abs();
                assert!(error <= f64::from(z) * half + spacing, "{z:e} became {back:e} in {range:?}");
            }
        }
    }

    #[test]
    fn bounds_are_rounded_up_to_two_digits() {
        let shown =
            [0.0, 0.1234, 0.12, 2.5001, 99.9, 1234.0, 4.0, 0.000_011].map(|value| rounded_up(value).to_string());
        assert_eq!(shown, ["0", "0.13", "0.12", "2.6", "100", "1300", "4", "0.000011"]);
    }

    #[test]
    fn no_float_is_farther_off_than_the_relative_error() {
        for range in ranges() {
            let share = range.relative_error(100);
            assert!(range.codes_within(share).is_none_or(|codes| codes == 100 || range.log_span() == 0.0), "{range:?}");
            let (low, high) = (range.near_m.to_bits(), range.far_m.to_bits());
            for bits in (low..=high).step_by(((high - low) / 5000).max(1) as usize) {
                let z = f32::from_bits(bits);
                let code = range.code(z);
                for shown in [code.saturating_sub(100), code.saturating_add(100).min(FAR_CODE)] {
                    let error = (f64::from(range.metres(shown)) - f64::from(z)).abs() / f64::from(z);
                    assert!(error <= share * (1.0 + 1e-9), "{z:e} in {range:?}: {error} of {share}");
                }
            }
        }
    }

    #[test]
    fn ranges_that_are_none_are_refused() {
        for (near, far) in [(0.0, 1.0), (-1.0, 1.0), (2.0, 1.0), (1.0, f32::INFINITY), (f32::NAN, 1.0), (1.0, f32::NAN)]
        {
            assert!(DepthRange::new(near, far).is_err());
        }
    }
}
