//! Nodes of the quadtree: their places, their 32 bytes of coefficients, and the precision of these (depth.md 7, 9; GDC 4).

use byteorder::{ByteOrder, LittleEndian};

use crate::depth::biquadratic::Biquadratic;
use crate::depth::block::{BlockMut, side_of};
use crate::depth::platelet::{Plane, Platelet};

/// Bytes of a node's coefficients in the runtime form, for every function.
pub const COEFFICIENT_BYTES: usize = 32;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    /// 16 unmodified codes; level 0 only.
    Raw,
    /// Two planes and a line; level 1 and above.
    Platelet,
    /// A constant, a plane or a biquadratic surface; level 1 and above.
    Biquadratic,
    Bc4w,
}

impl Function {
    pub const ALL: [Function; 4] = [Function::Raw, Function::Platelet, Function::Biquadratic, Function::Bc4w];

    pub fn name(self) -> &'static str {
        match self {
            Function::Raw => "raw",
            Function::Platelet => "platelet",
            Function::Biquadratic => "biquadratic",
            Function::Bc4w => "bc4w",
        }
    }
}

/// Place of a node: its level, and its column and row, counted in nodes of that level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Place {
    /// 0 to 8: the side is 4 · 2^level pixels.
    pub level: u8,
    pub x: u8,
    pub y: u8,
}

impl Place {
    pub fn pixel(self) -> [usize; 2] {
        let side = side_of(self.level);
        [usize::from(self.x) * side, usize::from(self.y) * side]
    }

    /// Returns the four places of the next finer level, in the order of the walk: row by row from the top.
    pub fn children(self) -> [Place; 4] {
        let at = |x, y| Place { level: self.level.saturating_sub(1), x: 2 * self.x + x, y: 2 * self.y + y };
        [at(0, 0), at(1, 0), at(0, 1), at(1, 1)]
    }

    pub fn holds(self, other: Place) -> bool {
        let Some(up) = self.level.checked_sub(other.level) else { return false };
        // Shifted as u32, because the root of the largest tiles is eight levels up and a u8 cannot be shifted by eight.
        (u32::from(other.x) >> up, u32::from(other.y) >> up) == (u32::from(self.x), u32::from(self.y))
    }

    /// Returns the rank of the place's top left leaf in the walk. Nodes that do not overlap are stored in this order.
    pub fn walk_key(self) -> u32 {
        let spread = |value: u8| {
            let value = u32::from(value) << self.level;
            (0..8).fold(0, |sum, bit| sum | (value >> bit & 1) << (2 * bit))
        };
        spread(self.x) | spread(self.y) << 1
    }
}

/// Size of the picture that a quadtree covers: a unit of at most 1024×1024 pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    pub width: u32,
    pub height: u32,
}

impl Grid {
    /// Returns the place that covers the picture, at the finest level where one node does.
    pub fn root(self) -> Place {
        let longer = self.width.max(self.height);
        let level = (0..).find(|&level| side_of(level) as u64 >= u64::from(longer)).unwrap_or(0);
        Place { level, x: 0, y: 0 }
    }

    pub fn has(self, place: Place) -> bool {
        let [x, y] = place.pixel();
        x < self.width as usize && y < self.height as usize
    }

    pub fn pixels_of(self, place: Place) -> u64 {
        let ([x, y], side) = (place.pixel(), side_of(place.level));
        let inside = |start: usize, size: u32| side.min((size as usize).saturating_sub(start)) as u64;
        inside(x, self.width) * inside(y, self.height)
    }

    /// Returns left, top, width and height of the part of a place that lies in the picture. The place must overlap the picture.
    pub fn rect_of(self, place: Place) -> [u32; 4] {
        let ([x, y], side) = (place.pixel().map(|at| at as u32), side_of(place.level) as u32);
        [x, y, side.min(self.width.saturating_sub(x)), side.min(self.height.saturating_sub(y))]
    }

    pub fn pixel_count(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    pub fn leaves(self) -> [usize; 2] {
        [self.width.div_ceil(4) as usize, self.height.div_ceil(4) as usize]
    }

    pub fn leaf_rows(self, place: Place) -> impl Iterator<Item = std::ops::Range<usize>> {
        let ([columns, rows], side) = (self.leaves(), 1usize << place.level);
        let (left, top) = (usize::from(place.x) * side, usize::from(place.y) * side);
        (top..rows.min(top + side)).map(move |y| y * columns + left..y * columns + columns.min(left + side))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Node {
    pub place: Place,
    pub coefficients: [u8; COEFFICIENT_BYTES],
}

impl Node {
    pub fn function(&self) -> Function {
        function_of(self.place.level, &self.coefficients)
    }
}

pub fn function_of(level: u8, coefficients: &[u8; COEFFICIENT_BYTES]) -> Function {
    match (level, coefficients) {
        (0, _) => Function::Raw,
        (_, [.., 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]) => Function::Biquadratic,
        (_, [.., 0xFF, 0xFF, 0xFF, 0xFF]) => Function::Platelet,
        _ => Function::Bc4w,
    }
}

/// Returns the coefficients of a modelling function: six 32-bit numbers, and the bytes after them.
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

/// Precision of a node's coefficients (depth.md 9), which is the number of low bits that are zero and not stored: from 0, which
/// keeps all bits, to 15, the coarsest.
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

pub mod raw {
    use super::{BlockMut, COEFFICIENT_BYTES};
    use crate::depth::block::Block;

    pub fn decode(coefficients: &[u8; COEFFICIENT_BYTES], target: &mut BlockMut<'_>) {
        for (row, bytes) in target.rows_mut().zip(coefficients.as_chunks::<8>().0) {
            for (code, bytes) in row.iter_mut().zip(bytes.as_chunks::<2>().0) {
                *code = u16::from_le_bytes(*bytes);
            }
        }
    }

    /// Returns the codes of a leaf; pixels outside the picture repeat the nearest pixel inside.
    pub fn encode(block: &Block<'_>) -> [u8; COEFFICIENT_BYTES] {
        let mut out = [0; COEFFICIENT_BYTES];
        for (at, bytes) in out.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let (x, y) = (at % 4, at / 4);
            *bytes = block.row(y.min(block.height - 1))[x.min(block.width - 1)].to_le_bytes();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_know_what_they_hold_and_where_they_come_in_the_walk() {
        let root = Grid { width: 1024, height: 3 }.root();
        assert_eq!(root, Place { level: 8, x: 0, y: 0 });
        assert_eq!(Grid { width: 4, height: 1 }.root().level, 0);
        assert_eq!(Grid { width: 5, height: 1 }.root().level, 1);
        assert!([0, 1, 100, 255].iter().all(|&x| root.holds(Place { level: 0, x, y: 255 - x })));
        let place = Place { level: 2, x: 3, y: 1 };
        assert!(place.children().iter().all(|&child| place.holds(child)));
        assert!(!place.holds(Place { level: 1, x: 5, y: 2 }) && !place.holds(root) && root.holds(place));
        let keys: Vec<_> = place.children().iter().map(|child| child.walk_key()).collect();
        assert!(keys.is_sorted() && keys[0] == place.walk_key());
        let grid = Grid { width: 50, height: 18 };
        assert_eq!(grid.pixels_of(place), 2 * 2);
        assert!(grid.has(place) && !grid.has(Place { level: 2, x: 4, y: 0 }));
    }
}
