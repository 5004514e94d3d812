//! From the value of a modelling function to a code: as it is, or through a logarithm in integers (arithmetic.md 7).
//!
//! Functions may be fitted to codes, to depth or to its inverse. The domain is a property of the stream; what leaves
//! it is always a code. Based on: GDC 3.2 (linear depth) and 3.1 (codes).

use std::sync::OnceLock;

use crate::depth::quantise::{BACKGROUND_CODE, DepthRange, FAR_CODE};
use crate::error::{Error, Result};

/// In which quantity modelling functions are linear or biquadratic. The values are those of a stream's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum DomainKind {
    /// Codes, which are even in the logarithm of depth.
    #[default]
    Log = 0,
    /// Depth: 65535 at far.
    Linear = 1,
    /// Inverse depth, in which planes in space are planes: 65535 at near.
    Inverse = 2,
}

impl DomainKind {
    /// All of them, in the order of their bytes.
    pub const ALL: [DomainKind; 3] = [DomainKind::Log, DomainKind::Linear, DomainKind::Inverse];

    /// The kind that a header's byte stands for.
    pub fn from_byte(byte: u8) -> Option<DomainKind> {
        Self::ALL.get(usize::from(byte)).copied()
    }
}

/// Fraction bits of what Horner evaluation yields (Q14).
pub(crate) const VALUE_BITS: u32 = 14;
/// What Horner evaluation yields for the first value beyond 65535.
const BEYOND: i32 = 1 << (16 + VALUE_BITS);
/// Values are made Q8 before their logarithm is taken.
const LOG_VALUE_BITS: u32 = 8;
/// The first Q8 value beyond 65535.
const LOG_VALUE_END: i32 = 1 << (16 + LOG_VALUE_BITS);
/// Logarithms are Q24.
const LOG_BITS: u32 = 24;

/// A domain with the numbers that its logarithm needs.
#[derive(Debug, Clone)]
pub struct Domain {
    kind: DomainKind,
    base: u32,
    scale: u32,
    /// What functions are fitted to, for each code; made when an encoder first asks.
    values: OnceLock<Box<[f64]>>,
}

impl Domain {
    /// Codes themselves.
    pub fn log() -> Domain {
        Domain { kind: DomainKind::Log, base: 0, scale: 0, values: OnceLock::new() }
    }

    /// The domain of a stream's header: `base` is a logarithm (Q24), `scale` codes for each unit of it (Q32).
    pub fn from_parts(kind: DomainKind, base: u32, scale: u32) -> Result<Domain> {
        let legal = match kind {
            DomainKind::Log => base == 0 && scale == 0,
            DomainKind::Linear | DomainKind::Inverse => base < MAX_LOG && scale > 0,
        };
        if legal {
            Ok(Domain { kind, base, scale, values: OnceLock::new() })
        } else {
            Err(Error::invalid(format!("a {kind:?} domain with base {base} and scale {scale} was not expected")))
        }
    }

    /// In which quantity functions are linear.
    pub fn kind(&self) -> DomainKind {
        self.kind
    }

    /// Logarithm (Q24) of the Q8 value at near; 0 in the log domain.
    pub fn base(&self) -> u32 {
        self.base
    }

    /// Codes for each unit of the logarithm (Q32); 0 in the log domain.
    pub fn scale(&self) -> u32 {
        self.scale
    }

    /// The code of `r`, the result of a function in Q14.
    #[inline]
    pub fn code_of(&self, r: i32) -> u16 {
        match self.kind {
            DomainKind::Log => log_code(r),
            DomainKind::Linear => self.linear_code(r),
            DomainKind::Inverse => self.inverse_code(r),
        }
    }

    /// `code_of` where the kind is known to be linear.
    #[inline]
    pub(crate) fn linear_code(&self, r: i32) -> u16 {
        let value = q8(r);
        if value >= LOG_VALUE_END {
            return BACKGROUND_CODE;
        }
        self.scaled(integer_log2(value.max(1) as u32).saturating_sub(self.base))
    }

    /// `code_of` where the kind is known to be inverse.
    #[inline]
    pub(crate) fn inverse_code(&self, r: i32) -> u16 {
        let value = q8(r);
        if value <= 0 {
            return BACKGROUND_CODE;
        }
        self.scaled(self.base.saturating_sub(integer_log2(value.min(LOG_VALUE_END - 1) as u32)))
    }

    #[inline]
    fn scaled(&self, log: u32) -> u16 {
        let code = (u64::from(log) * u64::from(self.scale) + (1 << 31)) >> 32;
        code.min(u64::from(FAR_CODE)) as u16
    }

    /// The constant function, in Q14, that is background everywhere.
    pub fn background(&self) -> i32 {
        match self.kind {
            DomainKind::Log | DomainKind::Linear => BEYOND,
            DomainKind::Inverse => 0,
        }
    }
}

/// The code of a result in Q14 in the log domain, written so that it becomes saturating arithmetic of 16 bits.
#[inline]
pub(crate) fn log_code(r: i32) -> u16 {
    let code = r.wrapping_add(1 << (VALUE_BITS - 1)) >> VALUE_BITS;
    ((code - 32768).clamp(-32768, 32767) as i16 as u16) ^ 0x8000
}

/// Q14 to Q8, to nearest.
#[inline]
fn q8(r: i32) -> i32 {
    let shift = VALUE_BITS - LOG_VALUE_BITS;
    r.wrapping_add(1 << (shift - 1)) >> shift
}

/// log2 of `value` in Q24: the place of the leading one, and a line between two entries of the table for what follows
/// it. `value` is at least 1.
#[inline]
pub fn integer_log2(value: u32) -> u32 {
    let exponent = 31 - (value | 1).leading_zeros();
    let fraction = (value << (31 - exponent)) << 1 >> 9;
    let (index, rest) = ((fraction >> 15) as usize & 255, fraction & 0x7fff);
    let (low, high) = (LOG2_TABLE[index], LOG2_TABLE[index + 1]);
    (exponent << LOG_BITS) + low + (((high - low) * rest + 0x4000) >> 15)
}

/// log2(1 + i/256) in Q24, to nearest. Part of the format: never computed anew.
#[rustfmt::skip]
pub const LOG2_TABLE: [u32; 257] = [
    0, 94364, 188362, 281996, 375270, 468185, 560745, 652952, 744810, 836320,
    927485, 1018309, 1108793, 1198939, 1288752, 1378232, 1467383, 1556207, 1644705, 1732882,
    1820738, 1908277, 1995500, 2082410, 2169009, 2255299, 2341283, 2426963, 2512340, 2597417,
    2682196, 2766679, 2850868, 2934766, 3018374, 3101694, 3184728, 3267478, 3349946, 3432134,
    3514044, 3595678, 3677038, 3758124, 3838941, 3919488, 3999768, 4079782, 4159533, 4239023,
    4318251, 4397222, 4475935, 4554394, 4632599, 4710552, 4788255, 4865709, 4942916, 5019878,
    5096595, 5173071, 5249305, 5325300, 5401057, 5476578, 5551864, 5626916, 5701737, 5776327,
    5850688, 5924821, 5998727, 6072409, 6145867, 6219103, 6292118, 6364913, 6437490, 6509850,
    6581994, 6653924, 6725641, 6797146, 6868440, 6939525, 7010402, 7081072, 7151536, 7221795,
    7291852, 7361706, 7431359, 7500812, 7570066, 7639123, 7707984, 7776649, 7845119, 7913397,
    7981483, 8049377, 8117082, 8184598, 8251926, 8319067, 8386022, 8452793, 8519380, 8585785,
    8652008, 8718050, 8783912, 8849596, 8915102, 8980431, 9045584, 9110562, 9175366, 9239998,
    9304457, 9368745, 9432863, 9496811, 9560591, 9624203, 9687648, 9750928, 9814042, 9876993,
    9939780, 10002404, 10064867, 10127170, 10189312, 10251295, 10313120, 10374787, 10436298, 10497652,
    10558852, 10619897, 10680789, 10741528, 10802114, 10862550, 10922835, 10982970, 11042956, 11102794,
    11162484, 11222028, 11281425, 11340677, 11399784, 11458748, 11517568, 11576245, 11634780, 11693175,
    11751428, 11809542, 11867517, 11925353, 11983051, 12040612, 12098037, 12155325, 12212479, 12269497,
    12326382, 12383133, 12439752, 12496238, 12552593, 12608817, 12664911, 12720875, 12776710, 12832416,
    12887994, 12943445, 12998770, 13053968, 13109041, 13163988, 13218811, 13273511, 13328087, 13382540,
    13436871, 13491080, 13545168, 13599135, 13652983, 13706711, 13760320, 13813810, 13867183, 13920438,
    13973576, 14026597, 14079503, 14132294, 14184969, 14237530, 14289978, 14342312, 14394532, 14446641,
    14498638, 14550523, 14602297, 14653961, 14705514, 14756958, 14808293, 14859519, 14910637, 14961648,
    15012551, 15063347, 15114037, 15164621, 15215099, 15265473, 15315742, 15365906, 15415967, 15465925,
    15515779, 15565531, 15615181, 15664730, 15714177, 15763523, 15812769, 15861915, 15910962, 15959909,
    16008758, 16057508, 16106160, 16154714, 16203172, 16251532, 16299796, 16347964, 16396036, 16444013,
    16491896, 16539683, 16587377, 16634976, 16682482, 16729896, 16777216,
];

// Encoder

/// Logarithms of Q8 values of 24 bits lie below this.
const MAX_LOG: u32 = 24 << LOG_BITS;

impl Domain {
    /// The domain of a stream from near to far. Depth and its inverse need a far that is 1.003 times near or more:
    /// below, their logarithm has fewer steps than there are codes.
    pub fn new(kind: DomainKind, range: DepthRange) -> Result<Domain> {
        let top = f64::from(u16::MAX) * f64::from(1 << LOG_VALUE_BITS);
        let ratio = f64::from(range.near_m()) / f64::from(range.far_m());
        // Below 1 the table has nothing; so little resolution is left there that it does not matter.
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
                "{kind:?} depth from {} m to {} m: far = 1.003 near or more was expected; use the log domain",
                range.near_m(),
                range.far_m()
            )));
        }
        let scale = ((u64::from(FAR_CODE) << 32) + span / 2) / span;
        Domain::from_parts(kind, base, scale as u32)
    }

    /// What a function should yield for a code, in units of which 65535 are the whole range: its Q14 is `code_of`'s
    /// input. For the background the value of [`Self::background`].
    #[inline]
    pub fn value_of(&self, code: u16) -> f64 {
        match self.kind {
            DomainKind::Log => f64::from(code) + f64::from(u8::from(code == BACKGROUND_CODE)),
            DomainKind::Linear | DomainKind::Inverse => self.values()[usize::from(code)],
        }
    }

    /// d code / d value where `value_of` is `value`; negative for inverse depth.
    #[inline]
    pub fn slope_at(&self, value: f64) -> f64 {
        // d log2(v) = dv / (v ln 2)
        let codes = f64::from(self.scale) / f64::from(1 << (32 - LOG_BITS)) * std::f64::consts::LOG2_E;
        let least = 1.0 / f64::from(1 << LOG_VALUE_BITS);
        match self.kind {
            DomainKind::Log => 1.0,
            DomainKind::Linear => codes / value.max(least),
            DomainKind::Inverse => -codes / value.max(least),
        }
    }

    fn values(&self) -> &[f64] {
        self.values.get_or_init(|| {
            let step = 4_294_967_296.0 / f64::from(self.scale);
            let sign = if self.kind == DomainKind::Inverse { -1.0 } else { 1.0 };
            let value = |code: u16| match code {
                BACKGROUND_CODE => f64::from(self.background()) / f64::from(1 << VALUE_BITS),
                _ => exp2_of(f64::from(self.base) + sign * f64::from(code) * step) / f64::from(1 << LOG_VALUE_BITS),
            };
            (0..=u16::MAX).map(value).collect()
        })
    }
}

/// The inverse of [`integer_log2`], its table included, so that a code's value is the middle of what decodes to it.
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
        // The least ratios to which every code has a value of its own in Q8.
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
                // Where neighbouring Q8 values are further apart than codes, the nearest one has to do.
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
            assert!(Domain::from_parts(kind, 24 << 24, 1).is_err());
            assert!(Domain::from_parts(kind, 0, 0).is_err());
        }
        assert!(Domain::new(DomainKind::Log, range(1.0)).is_ok());
        assert!(Domain::from_parts(DomainKind::Log, 0, 1).is_err());
        assert_eq!(DomainKind::ALL.map(|kind| kind as u8), [0, 1, 2]);
        assert_eq!(DomainKind::from_byte(3), None);
    }
}
