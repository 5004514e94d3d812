//! How many low bits of a node's coefficients are zero and need not be stored (formats/depth.md).

/// 0 to 15; coarser the larger it is. 0 keeps all bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Precision(u8);

/// Low bits that are zero, by kind of coefficient.
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

    /// The bits that are zero in a node of `level`. Terms that grow across the node are kept finer in proportion, so
    /// that rounding each of them moves the far corner about as much as rounding the constant.
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
