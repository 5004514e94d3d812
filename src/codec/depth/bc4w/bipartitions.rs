//! Distinct bipartitions of the 64 pixels of a block by lines.

use std::sync::LazyLock;

use crate::depth::bc4w::Line;

/// A bipartition of the pixels and a line that produces it. A search does not depend on which side is called B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bipartition {
    /// First line, in the order of its bits, with these two sides in either order.
    pub line: Line,
    pub side_b: u64,
}

/// Returns all distinct bipartitions by lines. The first one has all pixels on one side.
pub fn bipartitions() -> &'static [Bipartition] {
    static ALL: LazyLock<Vec<Bipartition>> = LazyLock::new(|| {
        let mut seen = std::collections::BTreeSet::new();
        (0..4096)
            .map(|bits| Bipartition { line: Line::from_bits(bits), side_b: Line::from_bits(bits).side_b() })
            .filter(|parted| seen.insert(parted.side_b.min(!parted.side_b)))
            .collect()
    });
    &ALL
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
            let side = Line::from_bits(bits).side_b();
            let count = all.iter().filter(|parted| parted.side_b == side || parted.side_b == !side).count();
            assert_eq!(count, 1, "line {bits:03x}");
        }
        // Number of bipartitions of a lattice of 8×8 points by a straight line.
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
        // From (2, 0) down to (2, 7): side B is the pixels with x < 2.
        let line = Line::from_bits(2 | 2 << 6 | 7 << 9);
        assert_eq!(line.points(), [[2, 0], [2, 7]]);
        assert_eq!(line.side_b(), 0x0303_0303_0303_0303);
        assert_eq!(Line::from_bits(2 | 7 << 3 | 2 << 6).side_b(), 0xf8f8_f8f8_f8f8_f8f8);
        assert_eq!(Line::from_bits(0xfff).side_b(), 0);
        assert_eq!(Line::NONE.side_b(), 0);
    }
}
