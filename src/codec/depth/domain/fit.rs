//! Computes the values that functions are fitted to, for each code.

use crate::depth::domain::{
    Domain, DomainKind, DomainParts, LOG_BITS, LOG_VALUE_BITS, LOG2_TABLE, VALUE_BITS, integer_log2,
};
use crate::depth::quantise::{BACKGROUND_CODE, DepthRange, FAR_CODE};
use crate::error::{Error, Result};

impl Domain {
    /// Returns the domain of a stream for a depth range. Fails for linear and inverse depth if far is less than 1.003 times near:
    /// the logarithm then has fewer steps than there are codes.
    pub fn new(kind: DomainKind, range: DepthRange) -> Result<Domain> {
        let top = f64::from(u16::MAX) * f64::from(1 << LOG_VALUE_BITS);
        let ratio = f64::from(range.near_m()) / f64::from(range.far_m());
        // The table starts at 1. Resolution is so low there that clamping does not matter.
        let small = (ratio * top).round().max(1.0) as u32;
        let (near, far) = match kind {
            DomainKind::Log => return Ok(Domain::log()),
            DomainKind::Linear => (small, top as u32),
            DomainKind::Inverse => (top as u32, small),
        };
        let (base, end) = (integer_log2(near), integer_log2(far));
        let span = u64::from(base.abs_diff(end));
        if span <= u64::from(FAR_CODE) {
            return Err(Error::invalid(format!(
                "{} depth from {range}: far = 1.003 near or more was expected; use `depth_domain` log",
                kind.name()
            )));
        }
        let scale = ((u64::from(FAR_CODE) << 32) + span / 2) / span;
        DomainParts { kind, base, scale: scale as u32 }.domain()
    }

    /// Returns the value that a function should have for a code, scaled so that 65535 is the whole range; in Q14 it is the input
    /// of `code_of`. The background has the value of [`Self::background`].
    #[inline]
    pub fn value_of(&self, code: u16) -> f64 {
        match self.parts.kind {
            DomainKind::Log => f64::from(code) + f64::from(u8::from(code == BACKGROUND_CODE)),
            DomainKind::Linear | DomainKind::Inverse => self.values()[usize::from(code)],
        }
    }

    /// Returns d code / d value at `value`; negative for inverse depth.
    #[inline]
    pub fn slope_at(&self, value: f64) -> f64 {
        // d log2(v) = dv / (v ln 2)
        let codes = f64::from(self.parts.scale) / f64::from(1 << (32 - LOG_BITS)) * std::f64::consts::LOG2_E;
        let least = 1.0 / f64::from(1 << LOG_VALUE_BITS);
        match self.parts.kind {
            DomainKind::Log => 1.0,
            DomainKind::Linear => codes / value.max(least),
            DomainKind::Inverse => -codes / value.max(least),
        }
    }

    fn values(&self) -> &[f64] {
        self.values.get_or_init(|| {
            let step = 4_294_967_296.0 / f64::from(self.parts.scale);
            let sign = if self.parts.kind == DomainKind::Inverse { -1.0 } else { 1.0 };
            let value = |code: u16| match code {
                BACKGROUND_CODE => f64::from(self.background()) / f64::from(1 << VALUE_BITS),
                _ => {
                    exp2_of(f64::from(self.parts.base) + sign * f64::from(code) * step) / f64::from(1 << LOG_VALUE_BITS)
                }
            };
            (0..=u16::MAX).map(value).collect()
        })
    }
}

/// Computes the inverse of [`integer_log2`] with the same table, so that the value of a code is the middle of the values that
/// decode to it.
fn exp2_of(log: f64) -> f64 {
    let one = f64::from(1 << LOG_BITS);
    let exponent = (log / one).floor();
    let mantissa = log - exponent * one;
    let index = LOG2_TABLE[..256].partition_point(|&entry| f64::from(entry) <= mantissa) - 1;
    let (low, high) = (f64::from(LOG2_TABLE[index]), f64::from(LOG2_TABLE[index + 1]));
    (1.0 + (index as f64 + (mantissa - low) / (high - low)) / 256.0) * exponent.exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(ratio: f32) -> DepthRange {
        DepthRange::new(1.0, ratio).unwrap()
    }

    fn curved(ratio: f32) -> [Domain; 2] {
        [DomainKind::Linear, DomainKind::Inverse].map(|kind| Domain::new(kind, range(ratio)).unwrap())
    }

    #[test]
    fn the_table_is_the_logarithm() {
        for (i, &entry) in LOG2_TABLE.iter().enumerate() {
            let log = (1.0 + i as f64 / 256.0).log2() * 16_777_216.0;
            assert!((f64::from(entry) - log).abs() <= 0.5 + 1e-6, "{i}");
        }
    }

    #[test]
    fn the_logarithm_ascends_and_is_close() {
        assert_eq!(integer_log2(1), 0);
        assert_eq!(integer_log2(1 << 23), 23 << 24);
        assert_eq!(integer_log2(3), (1 << 24) + LOG2_TABLE[128]);
        let mut last = 0;
        for value in (1..70_000).chain((70_000..1 << 24).step_by(37)).chain([(1 << 24) - 1, u32::MAX]) {
            let log = integer_log2(value);
            assert!(log >= last, "{value}");
            assert!((f64::from(log) / 16_777_216.0 - f64::from(value).log2()).abs() < 4e-6, "{value}");
            last = log;
        }
    }

    #[test]
    fn codes_come_back_from_their_values() {
        // Ratio of far to near, and the maximum difference in codes after a round trip.
        for (ratio, off) in [(1.01, 1), (1.5, 0), (10.5, 0), (300.0, 0), (4000.0, 1)] {
            for domain in curved(ratio) {
                for code in 0..=BACKGROUND_CODE {
                    let found = domain.code_of((domain.value_of(code) * 16384.0).round() as i32);
                    assert!(found.abs_diff(code) <= off, "{code} -> {found}, {ratio} {:?}", domain.kind());
                    assert_eq!(found == BACKGROUND_CODE, code == BACKGROUND_CODE);
                }
            }
        }
        assert!((0..=BACKGROUND_CODE).all(|code| Domain::log().code_of(i32::from(code) << 14) == code));
    }

    #[test]
    fn metres_become_the_codes_that_they_have_elsewhere() {
        for ratio in [1.5, 10.5, 300.0, 4000.0, 1e6] {
            let metres = range(ratio);
            for domain in curved(ratio) {
                // Where neighbouring Q8 values are further apart than codes, the nearest value is used.
                for code in 0..FAR_CODE {
                    let z = f64::from(metres.metres(code));
                    let value = match domain.kind() {
                        DomainKind::Linear => z / f64::from(ratio),
                        _ => 1.0 / z,
                    } * 65535.0;
                    let found = domain.code_of((value * 16384.0).round() as i32);
                    let gap = (0.5 / (value * 256.0)).ln_1p() / f64::from(ratio).ln() * 65534.0;
                    let at_the_end = (0.5 / (65535.0 * 256.0 / f64::from(ratio))).ln_1p() / f64::from(ratio).ln();
                    let allowed = 1.0 + gap + at_the_end * 65534.0;
                    assert!(
                        f64::from(found.abs_diff(code)) <= allowed,
                        "{code} -> {found}, {ratio} {:?}",
                        domain.kind()
                    );
                }
            }
        }
    }

    #[test]
    fn ends_are_exact_and_codes_are_in_order() {
        for ratio in [1.0035, 1.01, 2.0, 10.5, 1e3, 1e6, 1e30] {
            let [linear, inverse] = curved(ratio);
            let small = (65535.0 * 256.0 / f64::from(ratio)).round().max(1.0) as i32;
            assert_eq!((linear.code_of(small << 6), linear.code_of(65535 << 14)), (0, 65534));
            assert_eq!((inverse.code_of(65535 << 14), inverse.code_of(small << 6)), (0, 65534));
            for step in [1, 7, 64, 4099] {
                let rs = || (i64::from(i32::MIN)..i64::from(i32::MAX) - 64).step_by(step * 9973).map(|r| r as i32);
                assert!(rs().map(|r| linear.code_of(r)).is_sorted());
                assert!(rs().map(|r| inverse.code_of(r)).is_sorted_by(|a, b| a >= b));
            }
        }
    }

    #[test]
    fn the_background_is_beyond_the_last_value() {
        let [linear, inverse] = curved(10.5);
        for domain in [&Domain::log(), &linear, &inverse] {
            assert_eq!(domain.code_of(domain.background()), BACKGROUND_CODE);
            assert_eq!(f64::from(domain.background()), domain.value_of(BACKGROUND_CODE) * 16384.0);
        }
        assert_eq!(linear.code_of((1 << 30) - 33), 65534);
        assert_eq!(linear.code_of((1 << 30) - 32), 65535);
        assert_eq!(linear.code_of(-5), 0);
        assert_eq!((inverse.code_of(31), inverse.code_of(32)), (65535, 65534));
        assert_eq!((inverse.code_of(-1), inverse.code_of(1 << 30)), (65535, 0));
    }

    #[test]
    fn slopes_are_those_of_the_codes() {
        for domain in curved(10.5) {
            for code in (100..65_000u16).step_by(997) {
                let [low, high] = [code - 50, code + 50].map(|code| domain.value_of(code));
                let slope = domain.slope_at(domain.value_of(code));
                assert!((slope * (high - low) / 100.0 - 1.0).abs() < 0.01, "{code}");
            }
        }
    }

    #[test]
    fn a_span_too_small_for_a_logarithm_is_refused() {
        for kind in [DomainKind::Linear, DomainKind::Inverse] {
            for ratio in [1.0, 1.002] {
                assert!(Domain::new(kind, range(ratio)).is_err());
            }
            assert!(Domain::new(kind, range(1.0035)).is_ok());
            assert!(DomainParts { kind, base: 24 << 24, scale: 1 }.domain().is_err());
            assert!(DomainParts { kind, base: 0, scale: 0 }.domain().is_err());
        }
        assert!(Domain::new(DomainKind::Log, range(1.0)).is_ok());
        assert!(DomainParts { kind: DomainKind::Log, base: 0, scale: 1 }.domain().is_err());
        assert_eq!(DomainKind::ALL.map(|kind| kind as u8), [0, 1, 2]);
        assert_eq!(DomainKind::from_byte(3), None);
    }
}
