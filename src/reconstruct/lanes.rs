//! Arithmetic on the numbers of four rays at once.

use glam::{BVec4A, Vec4};

/// A number of each of four rays.
pub(crate) type Lanes = Vec4;

/// All four rays, as bits.
pub(crate) const ALL: u32 = 0b1111;

/// Single precision has whole numbers only from here on.
const WHOLE: f32 = 8_388_608.0;
/// The bits of a number from there on that are its lower part.
const BITS: u32 = 0x7f_ffff;

/// Points of four rays.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Points {
    pub(crate) x: Lanes,
    pub(crate) y: Lanes,
    pub(crate) z: Lanes,
}

/// The lanes whose bits are set, in rising order.
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (lane < 4).then_some(lane as usize)
    })
}

/// The whole numbers of lanes that are whole, at least 0 and below 2²³.
#[inline(always)]
pub(crate) fn to_whole(lanes: Lanes) -> [u32; 4] {
    let [a, b, c, d] = (lanes + WHOLE).to_array();
    [a.to_bits() & BITS, b.to_bits() & BITS, c.to_bits() & BITS, d.to_bits() & BITS]
}

/// Lanes of at least 0 and below 2²² without what follows the point.
#[inline(always)]
pub(crate) fn cut(lanes: Lanes) -> Lanes {
    let nearest = (lanes + WHOLE) - WHOLE;
    nearest - Lanes::select(nearest.cmpgt(lanes), Lanes::ONE, Lanes::ZERO)
}

/// Either of two by a mask.
#[inline(always)]
pub(crate) fn either(mask: BVec4A, yes: Lanes, no: Lanes) -> Lanes {
    Lanes::select(mask, yes, no)
}

/// The natural logarithm of normal numbers above 0, to a millionth.
#[inline(always)]
pub(crate) fn ln(lanes: Lanes) -> Lanes {
    // Each is 2^exponent · part, with a part from √½ to √2.
    const ROOT_OF_HALF: u32 = 0x3f35_04f3;
    let bits = lanes.to_array().map(f32::to_bits);
    let exponent = bits.map(|bits| (bits.wrapping_sub(ROOT_OF_HALF) as i32) >> 23);
    let part: [f32; 4] = std::array::from_fn(|at| f32::from_bits(bits[at].wrapping_sub((exponent[at] << 23) as u32)));
    let part = Lanes::from_array(part);
    let s = (part - 1.0) / (part + 1.0);
    let z = s * s;
    let series = (((z * (1.0 / 9.0) + 1.0 / 7.0) * z + 1.0 / 5.0) * z + 1.0 / 3.0) * z + 1.0;
    Lanes::from_array(exponent.map(|exponent| exponent as f32)) * std::f32::consts::LN_2 + 2.0 * s * series
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
    fn whole_parts_are_cut() {
        for at in [0.0f32, 0.49, 0.5, 0.51, 0.999_999_94, 1.0, 1.5, 2.5, 511.999_97, 512.0, 16_383.999, 4_000_000.5] {
            assert_eq!(to_whole(cut(Lanes::splat(at))), [at as u32; 4], "{at}");
        }
    }

    #[test]
    fn lanes_are_those_of_bits() {
        assert_eq!(lanes_of(0b1010).collect::<Vec<_>>(), [1, 3]);
        assert_eq!(lanes_of(ALL).count(), 4);
        assert_eq!(lanes_of(0).count(), 0);
    }
}
