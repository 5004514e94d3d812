//! Precision of a node's coefficients: the number of low bits that are zero and not stored (depth.md 9).

/// Precision from 0 to 15: 0 keeps all bits, larger values are coarser.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Precision(u8);

/// Number of low bits that are zero, by kind of coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shifts {
    pub constant: u32,
    pub linear: u32,
    pub quadratic: u32,
}

impl Precision {
    const COARSEST: u8 = 15;

    pub fn new(value: u8) -> Option<Precision> {
        (value <= Self::COARSEST).then_some(Precision(value))
    }

    pub fn get(self) -> u8 {
        self.0
    }

    pub fn from_coarsest() -> impl Iterator<Item = Precision> {
        (1..=Self::COARSEST).rev().map(Precision)
    }

    /// Returns the number of zero bits in a node of `level`. Terms that grow across the node have finer precision in proportion,
    /// so that rounding any of them changes the far corner about as much as rounding the constant.
    pub fn shifts(self, level: u8) -> Shifts {
        if self.0 == 0 {
            return Shifts { constant: 0, linear: 0, quadratic: 0 };
        }
        let (constant, side_bits) = (u32::from(self.0) + 5, u32::from(level) + 2);
        Shifts {
            constant,
            linear: (constant + 1).saturating_sub(side_bits),
            quadratic: (constant + 8 + 2).saturating_sub(2 * side_bits),
        }
    }
}
