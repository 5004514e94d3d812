//! Magnitudes as one of at most 16 classes, and raw bits (depth.md 15.5).

/// Minimum magnitude of each class, and the number of raw bits that follow the class.
#[derive(Debug)]
pub struct Classes<const COUNT: usize> {
    pub least: [u32; COUNT],
    pub bits: [u8; COUNT],
}

impl<const COUNT: usize> Classes<COUNT> {
    const fn new(bits: [u8; COUNT], first: u32) -> Classes<COUNT> {
        let mut least = [first; COUNT];
        let mut class = 1;
        while class < COUNT {
            least[class] = least[class - 1] + (1 << bits[class - 1]);
            class += 1;
        }
        Classes { least, bits }
    }

    /// Returns the class of a magnitude, which must be at least the minimum of the first class.
    pub fn of(&self, magnitude: u32) -> usize {
        self.least.iter().rposition(|&least| least <= magnitude).unwrap_or(0)
    }
}

/// Classes of escapes: residuals of at least 3 steps.
pub const ESCAPES: Classes<16> = Classes::new([0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7, 9, 16], 3);
/// Classes of residuals on another surface.
pub const CANDIDATES: Classes<16> = Classes::new([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7, 8, 9, 16], 0);
/// Classes of nonzero changes of a plane.
pub const CHANGES: Classes<7> = Classes::new([0, 0, 1, 1, 2, 6, 14], 1);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_every_residual_of_16_bits() {
        for magnitude in 0..=65_535u32 {
            let class = CANDIDATES.of(magnitude);
            assert!(magnitude - CANDIDATES.least[class] < 1 << CANDIDATES.bits[class]);
            let class = ESCAPES.of(magnitude + 3);
            assert!(magnitude + 3 - ESCAPES.least[class] < 1 << ESCAPES.bits[class]);
        }
        assert_eq!((ESCAPES.least[15], CANDIDATES.least[15]), (833, 1039));
        assert_eq!(CHANGES.least, [1, 2, 3, 5, 7, 11, 75]);
    }
}
