//! Lines of a BC4w block and the ways in which they part its 64 pixels (depth.md 8).
//!
//! A mask has bit 8y + x for pixel (x, y).

use std::sync::LazyLock;

/// A line through two pixels, as its 12 bits: x0, y0, x1, y1 from the lowest bit on, three bits each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line(u16);

/// Side B of each of the 4096 lines.
static SIDES: LazyLock<Vec<u64>> = LazyLock::new(|| (0..4096).map(|bits| Line(bits).by_cross_product()).collect());

impl Line {
    /// The line that does not part the block: all pixels are on side A.
    pub const NONE: Line = Line(0);

    /// The line of the lowest 12 bits.
    pub fn from_bits(bits: u16) -> Line {
        Line(bits & 0xfff)
    }

    /// Its 12 bits.
    pub fn bits(self) -> u16 {
        self.0
    }

    /// Its two points, (x, y) each, 0 to 7.
    pub fn points(self) -> [[u8; 2]; 2] {
        let at = |shift: u32| (self.0 >> shift & 7) as u8;
        [[at(0), at(3)], [at(6), at(9)]]
    }

    /// The pixels of side B.
    pub fn side_b(self) -> u64 {
        SIDES[usize::from(self.0)]
    }

    /// Side B where (x1 − x0)(y − y0) − (y1 − y0)(x − x0) is above zero. The points' own pixels are on side A.
    fn by_cross_product(self) -> u64 {
        let [[x0, y0], [x1, y1]] = self.points().map(|point| point.map(i32::from));
        (0..64).fold(0, |mask, pixel| {
            let (x, y) = (pixel & 7, pixel >> 3);
            let cross = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0);
            mask | u64::from(cross > 0) << pixel
        })
    }
}

/// One way to part the pixels, and a line that does so. Which side is called B makes no difference to a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bipartition {
    /// The first line, in the order of its bits, that parts the pixels so or the other way round.
    pub line: Line,
    /// The pixels of side B.
    pub side_b: u64,
}

/// All that lines can do, each once; the first is that of [`Line::NONE`].
static BIPARTITIONS: LazyLock<Vec<Bipartition>> = LazyLock::new(|| {
    let mut seen = std::collections::BTreeSet::new();
    (0..4096)
        .map(|bits| Bipartition { line: Line(bits), side_b: Line(bits).by_cross_product() })
        .filter(|parted| seen.insert(parted.side_b.min(!parted.side_b)))
        .collect()
});

/// All distinct bipartitions that lines make, beginning with the one that leaves the block whole.
pub fn bipartitions() -> &'static [Bipartition] {
    &BIPARTITIONS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bipartition_is_what_its_line_makes_and_none_is_missing() {
        let all = bipartitions();
        assert_eq!(all[0], Bipartition { line: Line::NONE, side_b: 0 });
        assert!(all.iter().all(|parted| parted.line.side_b() == parted.side_b));
        assert!(all[1..].iter().all(|parted| parted.side_b != 0 && parted.side_b != u64::MAX));
        for bits in 0..4096 {
            let side = Line(bits).side_b();
            let count = all.iter().filter(|parted| parted.side_b == side || parted.side_b == !side).count();
            assert_eq!(count, 1, "line {bits:03x}");
        }
        // The number of ways in which a straight line can part a lattice of 8×8 points.
        assert_eq!(all.len(), 1283);
    }

    #[test]
    fn rows_of_a_side_begin_at_one_end() {
        for parted in bipartitions() {
            for row in parted.side_b.to_le_bytes() {
                assert!(row.leading_zeros() + row.count_ones() == 8 || row.trailing_zeros() + row.count_ones() == 8);
            }
        }
    }

    #[test]
    fn the_sides_of_a_line() {
        // From (2, 0) down to (2, 7): side B is where x is less.
        let line = Line::from_bits(2 | 2 << 6 | 7 << 9);
        assert_eq!(line.points(), [[2, 0], [2, 7]]);
        assert_eq!(line.side_b(), 0x0303_0303_0303_0303);
        assert_eq!(Line::from_bits(2 | 7 << 3 | 2 << 6).side_b(), 0xf8f8_f8f8_f8f8_f8f8);
        assert_eq!(Line::from_bits(0xfff).side_b(), 0);
        assert_eq!(Line::NONE.side_b(), 0);
    }
}
