//! Integer cosine bases (color.md 6.1).
//!
//! All transforms use one table of cosines: angles are multiples of π/192, which covers 4 to 32 points in space and the
//! lengths in time.

/// round(256·√2·cos(jπ/192)) for j from 0 to 96.
pub const COSINES: [i32; 97] = [
    362, 362, 362, 362, 361, 361, 360, 360, 359, 358, 357, 356, 355, 354, 353, 351, 350, 348, 346, 345, 343, 341, 339,
    337, 334, 332, 330, 327, 325, 322, 319, 316, 314, 311, 307, 304, 301, 298, 294, 291, 287, 284, 280, 276, 272, 268,
    264, 260, 256, 252, 247, 243, 239, 234, 230, 225, 220, 216, 211, 206, 201, 196, 191, 186, 181, 176, 171, 165, 160,
    155, 149, 144, 139, 133, 128, 122, 116, 111, 105, 99, 94, 88, 82, 76, 71, 65, 59, 53, 47, 41, 35, 30, 24, 18, 12,
    6, 0,
];
/// Fraction bits of a basis value: 1.0 is 256.
pub const BASIS_BITS: u32 = 8;

/// Numbers of frames that a block may span.
pub const LENGTHS: [usize; 9] = [1, 2, 3, 4, 6, 8, 12, 16, 24];
/// Maximum number of frames of a block.
pub const MAX_LENGTH: usize = 24;

/// Index of a length in [`LENGTHS`].
pub fn length_index(frames: usize) -> Option<usize> {
    LENGTHS.iter().position(|&length| length == frames)
}

/// Sample `n` of basis function `k` of `points` points, in 256ths; `points` must divide 96.
pub const fn basis(points: usize, k: usize, n: usize) -> i32 {
    if k == 0 {
        return 1 << BASIS_BITS;
    }
    let turn = (2 * n + 1) * k * (96 / points) % 384;
    let half = if turn > 192 { 384 - turn } else { turn };
    if half > 96 { -COSINES[192 - half] } else { COSINES[half] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosines_are_those_of_the_formula() {
        for (j, &cosine) in COSINES.iter().enumerate() {
            let exact = 256.0 * std::f64::consts::SQRT_2 * (j as f64 * std::f64::consts::PI / 192.0).cos();
            assert_eq!(f64::from(cosine), exact.round());
        }
    }

    #[test]
    fn bases_are_orthogonal_within_their_precision() {
        for points in [2, 3, 4, 6, 8, 12, 16, 24, 32] {
            for (a, b) in (0..points).flat_map(|a| (0..points).map(move |b| (a, b))) {
                let product: i32 = (0..points).map(|n| basis(points, a, n) * basis(points, b, n)).sum();
                let expected = if a == b { points as i32 * 65536 } else { 0 };
                assert!((product - expected).abs() <= 256 * points as i32, "{points} {a} {b}: {product}");
            }
        }
    }
}
