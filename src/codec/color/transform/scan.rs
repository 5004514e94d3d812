//! Scan order of the levels of a plane, and the magnitudes around a level (color.md 6.6).

use crate::color::transform::contexts::Position;

const SIDE: usize = 32;
/// Row length of magnitudes: two additional positions on the right and below are always 0.
const ROW: usize = SIDE + 2;
/// Maximum stored magnitude; larger ones are clamped.
const MAX_HELD: u32 = 15;

/// Positions of a plane of `side` × `side` levels in zigzag order along the diagonals.
const fn zigzag<const N: usize>(side: usize) -> [Position; N] {
    let mut order = [Position(0); N];
    let (mut at, mut diagonal) = (0, 0);
    while diagonal < 2 * side - 1 {
        let mut k = 0;
        while k <= diagonal {
            let y = if diagonal % 2 == 1 { k } else { diagonal - k };
            let x = diagonal - y;
            if x < side && y < side {
                order[at] = Position((y * SIDE + x) as u16);
                at += 1;
            }
            k += 1;
        }
        diagonal += 1;
    }
    order
}

static ZIGZAG_4: [Position; 16] = zigzag(4);
static ZIGZAG_8: [Position; 64] = zigzag(8);
static ZIGZAG_16: [Position; 256] = zigzag(16);
static ZIGZAG_32: [Position; 1024] = zigzag(32);

/// Scan order of the positions of a block of 4·2^size_class pixels square.
pub fn order(size_class: usize) -> &'static [Position] {
    match size_class {
        0 => &ZIGZAG_4,
        1 => &ZIGZAG_8,
        2 => &ZIGZAG_16,
        _ => &ZIGZAG_32,
    }
}

/// Magnitudes of the levels of a plane.
#[derive(Debug, Clone)]
pub struct Magnitudes([u8; ROW * ROW]);

impl Default for Magnitudes {
    fn default() -> Self {
        Magnitudes([0; ROW * ROW])
    }
}

impl Magnitudes {
    #[inline(always)]
    fn index(position: Position) -> usize {
        position.y() * ROW + position.x()
    }

    /// Clears the part that a block of `side` pixels reads.
    pub fn clear(&mut self, side: usize) {
        self.0[..ROW * (side + 2)].fill(0);
    }

    /// Copies the part that a block of `side` pixels reads.
    pub fn copy_from(&mut self, other: &Magnitudes, side: usize) {
        for (row, other) in self.0.chunks_exact_mut(ROW).zip(other.0.chunks_exact(ROW)).take(side + 2) {
            row[..side + 2].copy_from_slice(&other[..side + 2]);
        }
    }

    #[inline(always)]
    pub fn get(&self, position: Position) -> usize {
        usize::from(self.0[Self::index(position)])
    }

    #[inline(always)]
    pub fn set(&mut self, position: Position, magnitude: u32) {
        self.0[Self::index(position)] = magnitude.min(MAX_HELD) as u8;
    }

    #[inline(always)]
    pub fn raise(&mut self, position: Position, magnitude: u32) {
        let held = &mut self.0[Self::index(position)];
        *held = (*held).max(magnitude.min(MAX_HELD) as u8);
    }

    /// Raises each magnitude to at least that of another plane.
    pub fn raise_all(&mut self, other: &Magnitudes) {
        self.0.iter_mut().zip(&other.0).for_each(|(held, &other)| *held = (*held).max(other));
    }

    /// Sum of the five neighbours of higher frequency.
    #[inline(always)]
    pub fn sum(&self, position: Position) -> usize {
        let at = Self::index(position);
        let around = [at + 1, at + 2, at + ROW, at + ROW + 1, at + 2 * ROW];
        around.iter().map(|&at| usize::from(self.0[at])).sum()
    }
}
