//! Converts the value of a modelling function to a code: directly, or by an integer logarithm (arithmetic.md 7).
//!
//! Functions are fitted to log codes, to depth or to inverse depth. The domain is a property of the stream; the result is always
//! a code. Based on: GDC 3.2 (linear depth) and 3.1 (codes).

#[cfg(feature = "encode")]
mod fit;

use std::sync::OnceLock;

use crate::depth::quantise::{BACKGROUND_CODE, FAR_CODE};
use crate::error::{Error, Result};

/// Quantity in which modelling functions are linear or biquadratic. The discriminants are the values of a stream's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum DomainKind {
    /// Codes, which are uniform in the logarithm of depth.
    #[default]
    Log = 0,
    /// Depth, scaled to 65535 at far.
    Linear = 1,
    /// Inverse depth, scaled to 65535 at near. Planes in space are planes in this domain.
    Inverse = 2,
}

impl DomainKind {
    /// All domains, in the order of their header values.
    pub const ALL: [DomainKind; 3] = [DomainKind::Log, DomainKind::Linear, DomainKind::Inverse];

    /// Returns the domain with this header value, if there is one.
    pub fn from_byte(byte: u8) -> Option<DomainKind> {
        Self::ALL.get(usize::from(byte)).copied()
    }

    /// Returns `log`, `linear` or `inverse`.
    pub fn name(self) -> &'static str {
        match self {
            DomainKind::Log => "log",
            DomainKind::Linear => "linear",
            DomainKind::Inverse => "inverse",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DomainParts {
    pub kind: DomainKind,
    /// Logarithm (Q24) of the value at near; 0 in the log domain.
    pub base: u32,
    /// Codes per unit of the logarithm (Q32); 0 in the log domain.
    pub scale: u32,
}

impl DomainParts {
    pub fn domain(self) -> Result<Domain> {
        let DomainParts { kind, base, scale } = self;
        let legal = match kind {
            DomainKind::Log => base == 0 && scale == 0,
            DomainKind::Linear | DomainKind::Inverse => base < MAX_LOG && scale > 0,
        };
        if legal {
            Ok(Domain { parts: self, values: OnceLock::new() })
        } else {
            Err(Error::invalid(format!("a {kind:?} domain with base {base} and scale {scale} was not expected")))
        }
    }
}

/// Fraction bits of the result of Horner evaluation (Q14).
pub const VALUE_BITS: u32 = 14;
/// Result of Horner evaluation for the first value beyond 65535.
const BEYOND: i32 = 1 << (16 + VALUE_BITS);
const LOG_VALUE_BITS: u32 = 8;
const LOG_VALUE_END: i32 = 1 << (16 + LOG_VALUE_BITS);
const LOG_BITS: u32 = 24;
/// Exclusive upper bound of the logarithms of 24-bit values in Q8.
const MAX_LOG: u32 = 24 << LOG_BITS;

#[derive(Debug, Clone)]
pub struct Domain {
    pub parts: DomainParts,
    /// Value that functions are fitted to, for each code; computed when an encoder first needs it.
    #[cfg_attr(not(feature = "encode"), expect(dead_code))]
    values: OnceLock<Box<[f64]>>,
}

impl Domain {
    pub fn log() -> Domain {
        Domain { parts: DomainParts { kind: DomainKind::Log, base: 0, scale: 0 }, values: OnceLock::new() }
    }

    pub fn kind(&self) -> DomainKind {
        self.parts.kind
    }

    /// Returns the code of `r`, the result of a function in Q14.
    #[inline]
    pub fn code_of(&self, r: i32) -> u16 {
        match self.parts.kind {
            DomainKind::Log => log_code(r),
            DomainKind::Linear => self.linear_code(r),
            DomainKind::Inverse => self.inverse_code(r),
        }
    }

    #[inline]
    pub fn linear_code(&self, r: i32) -> u16 {
        let value = q8(r);
        if value >= LOG_VALUE_END {
            return BACKGROUND_CODE;
        }
        self.scaled(integer_log2(value.max(1) as u32).saturating_sub(self.parts.base))
    }

    #[inline]
    pub fn inverse_code(&self, r: i32) -> u16 {
        let value = q8(r);
        if value <= 0 {
            return BACKGROUND_CODE;
        }
        self.scaled(self.parts.base.saturating_sub(integer_log2(value.min(LOG_VALUE_END - 1) as u32)))
    }

    #[inline]
    fn scaled(&self, log: u32) -> u16 {
        let code = (u64::from(log) * u64::from(self.parts.scale) + (1 << 31)) >> 32;
        code.min(u64::from(FAR_CODE)) as u16
    }

    /// Returns the constant function, in Q14, that is background everywhere.
    pub fn background(&self) -> i32 {
        match self.parts.kind {
            DomainKind::Log | DomainKind::Linear => BEYOND,
            DomainKind::Inverse => 0,
        }
    }
}

/// Returns the code of a result in Q14 in the log domain. This form compiles to saturating 16-bit arithmetic.
#[inline]
pub fn log_code(r: i32) -> u16 {
    let code = r.wrapping_add(1 << (VALUE_BITS - 1)) >> VALUE_BITS;
    ((code - 32768).clamp(-32768, 32767) as i16 as u16) ^ 0x8000
}

#[inline]
fn q8(r: i32) -> i32 {
    let shift = VALUE_BITS - LOG_VALUE_BITS;
    r.wrapping_add(1 << (shift - 1)) >> shift
}

/// Returns log2 of `value` in Q24: the position of the leading one, plus linear interpolation between two table entries for the
/// bits below it. `value` is at least 1.
#[inline]
pub fn integer_log2(value: u32) -> u32 {
    let exponent = 31 - (value | 1).leading_zeros();
    let fraction = (value << (31 - exponent)) << 1 >> 9;
    let (index, rest) = ((fraction >> 15) as usize & 255, fraction & 0x7fff);
    let (low, high) = (LOG2_TABLE[index], LOG2_TABLE[index + 1]);
    (exponent << LOG_BITS) + low + (((high - low) * rest + 0x4000) >> 15)
}

/// log2(1 + i/256) in Q24, rounded to nearest. The table is part of the format and never recomputed.
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
