//! Sums over both sides of many lines at once.
//!
//! In each row a side has pixels from one end on, so there are 16 sums for each row; sums of two rows and of four rows
//! are shared by many lines. Several quantities, the *lanes*, are summed side by side, which is what processors like.

use std::collections::BTreeMap;
use std::ops::{Add, Mul, Sub};
use std::sync::LazyLock;

use crate::depth::bc4w::lines::bipartitions;

/// Sums of a row: of its first 0 to 8 pixels, then of its last 1 to 7; one is left over.
const ROW_SUMS: usize = 16;
/// Sums of all eight rows.
const LEAVES: usize = 8 * ROW_SUMS;

/// A float whose sums of integers up to [`Real::CAP`] are exact; above it they stay above.
pub trait Real: Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Stands for everything that is too much. Roundings are monotone, so no sum that contains it is below it.
    const CAP: Self;
    /// An integer up to 2^24.
    fn from_code(code: u32) -> Self;
    /// The float of an integer, which is exact up to the cap.
    fn from_sum(sum: u64) -> Self;
}

impl Real for f32 {
    const CAP: f32 = 16_777_216.0;
    fn from_code(code: u32) -> f32 {
        code as f32
    }
    fn from_sum(sum: u64) -> f32 {
        sum as f32
    }
}

impl Real for f64 {
    const CAP: f64 = 1_099_511_627_776.0;
    fn from_code(code: u32) -> f64 {
        f64::from(code)
    }
    fn from_sum(sum: u64) -> f64 {
        sum as f64
    }
}

/// The lesser; no NaN occurs.
#[inline(always)]
pub fn lesser<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// The greater; no NaN occurs.
#[inline(always)]
pub fn greater<T: Real>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Which sums make up the sides of which lines.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The two sums that each sum after the leaves adds.
    parts: Vec<[u16; 2]>,
    /// For each line the sums of the upper and the lower half of side A, then of side B.
    sides: Vec<[u16; 4]>,
}

/// The plan of all bipartitions, in their order.
static ALL: LazyLock<Plan> = LazyLock::new(Plan::of_all);

/// The place among the leaves of a row's mask.
fn leaf(y: usize, mask: u8) -> u16 {
    let count = mask.count_ones() as usize;
    let from_left = mask.trailing_ones() as usize == count;
    (ROW_SUMS * y + if from_left { count } else { 8 + count }) as u16
}

impl Plan {
    /// All bipartitions.
    pub fn all() -> &'static Plan {
        &ALL
    }

    fn of_all() -> Plan {
        let (mut parts, mut seen) = (Vec::new(), BTreeMap::new());
        // Sums of two rows, then of four, in one list: those of two come first, since lines ask in two rounds.
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

    /// The plan of some of these lines, given by their places in ascending order, with no sum that they do not need.
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

    /// How many lines it has.
    pub fn len(&self) -> usize {
        self.sides.len()
    }

    /// Calls `each` with every line's place and the sums of its sides A and B. `room` is kept between calls.
    #[inline(always)]
    pub fn for_each_line<T: Real, const L: usize>(
        &self,
        pixels: &[[T; L]; 64],
        room: &mut Vec<[T; L]>,
        mut each: impl FnMut(usize, [T; L], [T; L]),
    ) {
        room.clear();
        for row in pixels.chunks_exact(8) {
            let mut sum = [T::from_code(0); L];
            room.push(sum);
            for pixel in row {
                sum = plus(sum, *pixel);
                room.push(sum);
            }
            sum = [T::from_code(0); L];
            for pixel in row[1..].iter().rev() {
                sum = plus(sum, *pixel);
                room.push(sum);
            }
        }
        for &[a, b] in &self.parts {
            room.push(plus(room[usize::from(a)], room[usize::from(b)]));
        }
        for (line, side) in self.sides.iter().enumerate() {
            let [a0, a1, b0, b1] = side.map(|sum| room[usize::from(sum)]);
            each(line, plus(a0, a1), plus(b0, b1));
        }
    }
}

#[inline(always)]
fn plus<T: Real, const L: usize>(a: [T; L], b: [T; L]) -> [T; L] {
    std::array::from_fn(|lane| a[lane] + b[lane])
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
