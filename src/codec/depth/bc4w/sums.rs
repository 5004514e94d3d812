//! Computes sums over both sides of many lines at once.
//!
//! In each row a side is a run of pixels from one end, so there are 16 sums per row; many lines share sums of two rows and of
//! four rows. Several quantities, the *lanes*, are summed in parallel, in vector instructions.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::depth::bc4w::bipartitions::bipartitions;

/// Number of sums per row: over its first 0 to 8 pixels, then over its last 1 to 7.
const ROW_SUMS: usize = 16;
const LEAVES: usize = 8 * ROW_SUMS;

/// A quantity that can be summed. Sums are monotonic in their terms, also where they are rounded or saturate.
pub trait Quantity: Copy + PartialOrd {
    const ZERO: Self;
    /// Larger than any valid sum.
    const INFINITE: Self;
    fn plus(self, other: Self) -> Self;
}

impl Quantity for i16 {
    const ZERO: i16 = 0;
    const INFINITE: i16 = i16::MAX;
    #[inline(always)]
    fn plus(self, other: i16) -> i16 {
        self.saturating_add(other)
    }
}

impl Quantity for f32 {
    const ZERO: f32 = 0.0;
    const INFINITE: f32 = f32::MAX;
    #[inline(always)]
    fn plus(self, other: f32) -> f32 {
        self + other
    }
}

#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Greatest(pub f32);

impl Quantity for Greatest {
    const ZERO: Greatest = Greatest(f32::MIN);
    const INFINITE: Greatest = Greatest(f32::MAX);
    #[inline(always)]
    fn plus(self, other: Greatest) -> Greatest {
        if self.0 > other.0 { self } else { other }
    }
}

/// Exact for integers up to 2^53, which is above the sum of 64 squared differences.
impl Quantity for f64 {
    const ZERO: f64 = 0.0;
    const INFINITE: f64 = 1e14;
    #[inline(always)]
    fn plus(self, other: f64) -> f64 {
        self + other
    }
}

/// Returns the lesser value; no NaN occurs.
#[inline(always)]
pub fn lesser<T: Quantity>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

#[derive(Debug, Clone)]
pub struct Plan {
    /// For each sum after the leaves, the two sums that it adds.
    parts: Vec<[u16; 2]>,
    /// For each line, the sums of the upper and the lower half of side A, then of side B.
    sides: Vec<[u16; 4]>,
}

fn leaf(y: usize, mask: u8) -> u16 {
    let count = mask.count_ones() as usize;
    let from_left = mask.trailing_ones() as usize == count;
    (ROW_SUMS * y + if from_left { count } else { 8 + count }) as u16
}

impl Plan {
    /// Returns the plan of all bipartitions, in their order.
    pub fn all() -> &'static Plan {
        static ALL: LazyLock<Plan> = LazyLock::new(Plan::of_all);
        &ALL
    }

    fn of_all() -> Plan {
        let (mut parts, mut seen) = (Vec::new(), BTreeMap::new());
        // Sums of two rows and of four rows in one list. The parts of a sum precede it.
        let mut add = |of: [u16; 2]| {
            *seen.entry(of).or_insert_with(|| {
                parts.push(of);
                (LEAVES + parts.len() - 1) as u16
            })
        };
        let mut sides = Vec::new();
        for parted in bipartitions() {
            let mut halves = [!parted.side_b, parted.side_b].into_iter().flat_map(|side| {
                let rows = side.to_le_bytes();
                [0, 4].map(|y| {
                    let at = |y: usize| leaf(y, rows[y]);
                    [[at(y), at(y + 1)], [at(y + 2), at(y + 3)]]
                })
            });
            let mut next = || {
                let [upper, lower] = halves.next().unwrap_or_default();
                let pair = [add(upper), add(lower)];
                add(pair)
            };
            sides.push([next(), next(), next(), next()]);
        }
        Plan { parts, sides }
    }

    /// Returns the plan of some of these lines, given by their indices in ascending order, with only the sums that they need.
    pub fn of_some(&self, lines: &[usize]) -> Plan {
        let mut wanted = vec![false; LEAVES + self.parts.len()];
        let sides: Vec<[u16; 4]> = lines.iter().map(|&line| self.sides[line]).collect();
        sides.iter().flatten().for_each(|&sum| wanted[usize::from(sum)] = true);
        for (at, parts) in self.parts.iter().enumerate().rev() {
            if wanted[LEAVES + at] {
                parts.iter().for_each(|&part| wanted[usize::from(part)] = true);
            }
        }
        let mut place: Vec<u16> = (0..LEAVES as u16).collect();
        let mut parts = Vec::new();
        for (at, of) in self.parts.iter().enumerate() {
            place.push((LEAVES + parts.len()) as u16);
            if wanted[LEAVES + at] {
                parts.push(of.map(|part| place[usize::from(part)]));
            }
        }
        Plan { parts, sides: sides.into_iter().map(|side| side.map(|sum| place[usize::from(sum)])).collect() }
    }

    pub fn len(&self) -> usize {
        self.sides.len()
    }

    /// Calls `each` with the index of every line and the sums of its sides A and B. `room` is scratch memory, reused between
    /// calls.
    #[inline(always)]
    pub fn for_each_line<T: Quantity, const L: usize>(
        &self,
        pixels: &[[T; L]; 64],
        room: &mut Vec<[T; L]>,
        mut each: impl FnMut(usize, [T; L], [T; L]),
    ) {
        room.resize(LEAVES + self.parts.len(), [T::ZERO; L]);
        for (row, sums) in pixels.chunks_exact(8).zip(room.chunks_exact_mut(ROW_SUMS)) {
            sums[0] = [T::ZERO; L];
            for x in 0..8 {
                sums[x + 1] = plus(sums[x], row[x]);
            }
            sums[9] = row[7];
            for x in 1..7 {
                sums[9 + x] = plus(sums[8 + x], row[7 - x]);
            }
        }
        for (at, &[a, b]) in self.parts.iter().enumerate() {
            let (before, rest) = room.split_at_mut(LEAVES + at);
            let (a, b, sum) = (&before[usize::from(a)], &before[usize::from(b)], &mut rest[0]);
            for lane in 0..L {
                sum[lane] = a[lane].plus(b[lane]);
            }
        }
        for (line, side) in self.sides.iter().enumerate() {
            let [a0, a1, b0, b1] = side.map(|sum| &room[usize::from(sum)]);
            let (mut a, mut b) = ([T::ZERO; L], [T::ZERO; L]);
            for lane in 0..L {
                a[lane] = a0[lane].plus(a1[lane]);
                b[lane] = b0[lane].plus(b1[lane]);
            }
            each(line, a, b);
        }
    }
}

#[inline(always)]
pub fn plus<T: Quantity, const L: usize>(a: [T; L], b: [T; L]) -> [T; L] {
    std::array::from_fn(|lane| a[lane].plus(b[lane]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_pixels() {
        let pixels: [[f32; 2]; 64] = std::array::from_fn(|at| [1.0, (at * at) as f32]);
        let check = |plan: &Plan, lines: &[usize]| {
            assert_eq!(plan.len(), lines.len());
            plan.for_each_line(&pixels, &mut Vec::new(), |at, a, b| {
                let side_b = bipartitions()[lines[at]].side_b;
                for (side, sums) in [(!side_b, a), (side_b, b)] {
                    let of =
                        |lane: usize| (0..64).filter(|&p| side >> p & 1 != 0).map(|p| pixels[p][lane]).sum::<f32>();
                    assert_eq!(sums, [of(0), of(1)]);
                }
            });
        };
        let all: Vec<usize> = (0..bipartitions().len()).collect();
        check(Plan::all(), &all);
        let some: Vec<usize> = all.iter().copied().filter(|line| line % 7 == 3).collect();
        check(&Plan::all().of_some(&some), &some);
    }
}
