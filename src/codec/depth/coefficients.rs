//! Conversion of modelling functions to and from the bytes of a node (depth.md 7).

use byteorder::{ByteOrder, LittleEndian};

use crate::depth::biquadratic::Biquadratic;
use crate::depth::nodes::COEFFICIENT_BYTES;
use crate::depth::platelet::{Plane, Platelet};

#[cfg_attr(not(feature = "encode"), expect(dead_code))]
pub(super) fn put(integers: [i32; 6], tail: [u8; 8]) -> [u8; COEFFICIENT_BYTES] {
    let mut out = [0; COEFFICIENT_BYTES];
    LittleEndian::write_i32_into(&integers, &mut out[..24]);
    out[24..].copy_from_slice(&tail);
    out
}

/// Returns the six 32-bit numbers at the start of a node's coefficients.
pub(super) fn integers(coefficients: &[u8; COEFFICIENT_BYTES]) -> [i32; 6] {
    let mut out = [0; 6];
    LittleEndian::read_i32_into(&coefficients[..24], &mut out);
    out
}

impl Biquadratic {
    pub fn from_bytes(bytes: &[u8; COEFFICIENT_BYTES]) -> Biquadratic {
        Biquadratic { coefficients: integers(bytes) }
    }
}

impl Platelet {
    pub fn from_bytes(bytes: &[u8; COEFFICIENT_BYTES]) -> Platelet {
        let [a0, a1, a5, b0, b1, b5] = integers(bytes);
        let line = [bytes[24], bytes[25], bytes[26], bytes[27]];
        Platelet { sides: [Plane { a0, a1, a5 }, Plane { a0: b0, a1: b1, a5: b5 }], line }
    }
}
