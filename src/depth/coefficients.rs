//! Functions as the bytes of a node, and the domain as the numbers of a header (depth.md 3, 7).

use crate::depth::biquadratic::Biquadratic;
use crate::depth::domain::{Domain, DomainKind};
use crate::depth::nodes::COEFFICIENT_BYTES;
use crate::depth::platelet::{Plane, Platelet};
use crate::error::Result;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DomainParts {
    /// In which quantity functions are polynomials.
    pub kind: DomainKind,
    /// Logarithm of the value at near; 0 in the log domain.
    pub base: u32,
    /// Codes for each unit of the logarithm; 0 in the log domain.
    pub scale: u32,
}

impl Domain {
    pub fn parts(&self) -> DomainParts {
        DomainParts { kind: self.kind(), base: self.base(), scale: self.scale() }
    }
}

impl DomainParts {
    pub fn domain(self) -> Result<Domain> {
        Domain::from_parts(self.kind, self.base, self.scale)
    }
}

impl DomainKind {
    pub fn name(self) -> &'static str {
        match self {
            DomainKind::Log => "log",
            DomainKind::Linear => "linear",
            DomainKind::Inverse => "inverse",
        }
    }
}

/// Six numbers, and what follows them.
fn put(integers: [i32; 6], tail: [u8; 8]) -> [u8; COEFFICIENT_BYTES] {
    let mut out = [0; COEFFICIENT_BYTES];
    for (bytes, integer) in out.as_chunks_mut::<4>().0.iter_mut().zip(integers) {
        *bytes = integer.to_le_bytes();
    }
    out[24..].copy_from_slice(&tail);
    out
}

/// The six 32-bit numbers at the start of a node's coefficients.
pub(super) fn integers(coefficients: &[u8; COEFFICIENT_BYTES]) -> [i32; 6] {
    let mut out = [0; 6];
    for (number, bytes) in out.iter_mut().zip(coefficients.as_chunks::<4>().0) {
        *number = i32::from_le_bytes(*bytes);
    }
    out
}

impl Biquadratic {
    pub fn from_bytes(bytes: &[u8; COEFFICIENT_BYTES]) -> Biquadratic {
        Biquadratic { coefficients: integers(bytes) }
    }

    pub fn to_bytes(self) -> [u8; COEFFICIENT_BYTES] {
        put(self.coefficients, [0xFF; 8])
    }
}

impl Platelet {
    pub fn from_bytes(bytes: &[u8; COEFFICIENT_BYTES]) -> Platelet {
        let [a0, a1, a5, b0, b1, b5] = integers(bytes);
        let line = [bytes[24], bytes[25], bytes[26], bytes[27]];
        Platelet { sides: [Plane { a0, a1, a5 }, Plane { a0: b0, a1: b1, a5: b5 }], line }
    }

    pub fn to_bytes(self) -> [u8; COEFFICIENT_BYTES] {
        let ([a, b], [x0, y0, x1, y1]) = (self.sides, self.line);
        put([a.a0, a.a1, a.a5, b.a0, b.a1, b.a5], [x0, y0, x1, y1, 0xFF, 0xFF, 0xFF, 0xFF])
    }
}
