//! SIMD arithmetic on four lanes, one per ray of a packet.

use glam::{BVec4A, Vec4};
use wide::{f32x4, i32x4};

/// One number per ray of a packet.
pub(crate) type Lanes = Vec4;

/// Bits of all four lanes.
pub(crate) const ALL: u32 = 0b1111;

/// Bits of √½ in single precision.
const ROOT_OF_HALF: i32 = 0x3f35_04f3;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Points {
    pub(crate) x: Lanes,
    pub(crate) y: Lanes,
    pub(crate) z: Lanes,
}

/// Iterates over the lanes whose bits are set, in ascending order.
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (lane < 4).then_some(lane as usize)
    })
}

#[inline(always)]
pub(crate) fn either(mask: BVec4A, yes: Lanes, no: Lanes) -> Lanes {
    Lanes::select(mask, yes, no)
}

/// Returns the natural logarithm of positive normal numbers, to within a millionth.
#[inline(always)]
pub(crate) fn ln(lanes: Lanes) -> Lanes {
    let (exponent, part) = split(lanes);
    let s = (part - 1.0) / (part + 1.0);
    let z = s * s;
    let series = (((z * (1.0 / 9.0) + 1.0 / 7.0) * z + 1.0 / 5.0) * z + 1.0 / 3.0) * z + 1.0;
    exponent * std::f32::consts::LN_2 + 2.0 * s * series
}

/// Truncates numbers of at least 0 and below 2³¹ to integers.
#[inline(always)]
pub(crate) fn to_whole(lanes: Lanes) -> [u32; 4] {
    bytemuck::cast(cut(lanes))
}

/// Rounds numbers of magnitude below 2³¹ down to integers.
#[inline(always)]
pub(crate) fn floor(lanes: Lanes) -> Lanes {
    let cut = to_lanes(cut(lanes));
    cut - either(cut.cmpgt(lanes), Lanes::ONE, Lanes::ZERO)
}

/// Returns the indices of the texels at these columns and rows, which are at least 0, in images with this number of columns and
/// at most 2²³ texels.
#[inline(always)]
pub(crate) fn number_of([column, row]: [Lanes; 2], columns: Lanes) -> [u32; 4] {
    bytemuck::cast(cut(to_lanes(cut(row)) * columns) + cut(column))
}

/// Converts the three lower bytes of each number to floats.
#[inline(always)]
pub(crate) fn bytes(numbers: [u32; 4]) -> [Lanes; 3] {
    let numbers: i32x4 = bytemuck::cast(numbers);
    // The division by a power of two is exact.
    let byte = |at: i32| to_lanes(numbers & i32x4::splat(0xff << (8 * at))) * (1.0 / (1 << (8 * at)) as f32);
    [byte(0), byte(1), byte(2)]
}

/// Converts the highest byte of each number to floats.
#[inline(always)]
pub(crate) fn fourth_bytes(numbers: [u32; 4]) -> Lanes {
    to_lanes(bytemuck::cast(numbers.map(|number| number >> 24)))
}

/// Splits positive normal numbers into exponent and mantissa: each is 2^exponent · mantissa, with a mantissa from √½ to √2.
#[inline(always)]
fn split(lanes: Lanes) -> (Lanes, Lanes) {
    const PART: i32 = (1 << 23) - 1;
    let bits: i32x4 = bytemuck::cast(lanes.to_array());
    let exponent = (bits - i32x4::splat(ROOT_OF_HALF)) & i32x4::splat(!PART);
    let part: [f32; 4] = bytemuck::cast(bits - exponent);
    (to_lanes(exponent) * (1.0 / (PART + 1) as f32), Lanes::from_array(part))
}

#[inline(always)]
fn cut(lanes: Lanes) -> i32x4 {
    f32x4::new(lanes.to_array()).fast_trunc_int()
}

#[inline(always)]
fn to_lanes(numbers: i32x4) -> Lanes {
    Lanes::from_array(numbers.round_float().to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_those_of_the_library() {
        for at in 0..200_000u32 {
            let value = (f64::from(at) / 200_000.0 * 60.0 - 30.0).exp() as f32;
            let near_one = 1.0 + (at as f32 - 100_000.0) * 1e-7;
            let both = ln(Lanes::new(value, near_one, 1.0, 0.5));
            assert!((both.x - value.ln()).abs() <= 1e-6 * value.ln().abs().max(1.0), "{value}");
            assert!((both.y - near_one.ln()).abs() <= 1e-6 * near_one.ln().abs() + 1e-12, "{near_one}");
            assert_eq!(both.z, 0.0);
        }
    }

    #[test]
    fn what_follows_the_point_is_cut() {
        for at in [0.0f32, 0.49, 0.5, 0.51, 0.999_999_94, 1.0, 1.5, 2.5, 511.999_97, 512.0, 16_383.999, 4_000_000.5] {
            assert_eq!(to_whole(Lanes::splat(at)), [at as u32; 4], "{at}");
        }
    }

    #[test]
    fn four_at_once_are_each_by_itself() {
        for at in 0..100_000u32 {
            let bits = [0, 1, 2, 3].map(|lane| (4 * at + lane).wrapping_mul(2_654_435_761));
            let each_byte = [0, 8, 16].map(|shift| Lanes::from_array(bits.map(|bits| (bits >> shift & 0xff) as f32)));
            assert_eq!(bytes(bits), each_byte);
            assert_eq!(fourth_bytes(bits).to_array(), bits.map(|bits| (bits >> 24) as f32));
            let below = bits.map(|bits| bits as f32 / 2.1);
            assert_eq!(to_whole(Lanes::from_array(below)), below.map(|below| below as u32));
            let around = bits.map(|bits| (bits % 1_000_003) as f32 / 97.0 - 3.0);
            assert_eq!(floor(Lanes::from_array(around)).to_array(), around.map(f32::floor));
            let (column, row) = (around.map(|at| at.clamp(0.0, 1023.999)), below.map(|at| at % 4096.0));
            let number = std::array::from_fn(|lane| row[lane] as u32 * 1024 + column[lane] as u32);
            let at = [column, row].map(Lanes::from_array);
            assert_eq!(number_of(at, Lanes::splat(1024.0)), number);
            let normal = bits.map(|bits| f32::from_bits(bits % 0x7f00_0000 + 0x0080_0000));
            let (exponent, part) = split(Lanes::from_array(normal));
            for lane in 0..4 {
                assert!((0.499_999..2.000_001).contains(&part[lane].powi(2)), "{part}");
                assert_eq!(f64::from(exponent[lane]).exp2() * f64::from(part[lane]), f64::from(normal[lane]));
            }
        }
    }

    #[test]
    fn lanes_are_those_of_bits() {
        assert_eq!(lanes_of(0b1010).collect::<Vec<_>>(), [1, 3]);
        assert_eq!(lanes_of(ALL).count(), 4);
        assert_eq!(lanes_of(0).count(), 0);
    }
}
