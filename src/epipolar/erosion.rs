//! Erosion: estimates how many pixels two source views miss between them, without interpolation (Epipolar 3.3.1).
//!
//! A pixel is at an edge if its move differs from the mean move of five pixels of its scanline. Edges are counted cumulatively
//! from the left. If the count at a pixel differs from the count at its position in the other source, an edge lies between the
//! two, and surfaces behind the edge may come into view. (Listing 3.6 of the thesis counts the pixels that are not marked this
//! way.) Moves are integers, so that devices return the same counts.

use rayon::prelude::*;

use super::source::SourceView;
use super::views::OutputViews;
use codec::error::Result;

/// Number of pixels on each side of the centre of the window.
pub const REACH: usize = 2;
/// Number of fractional bits of moves.
pub const MOVE_BITS: u32 = 8;
/// Maximum difference between the move of a pixel within a surface and the mean: one column.
pub const TOLERANCE: i32 = 1 << MOVE_BITS;
/// Maximum move of a pixel in columns. A larger move leaves every image. The sum of five moves, in 1/256 pixels, fits 32
/// bits.
const MAX_COLUMNS: f64 = (1 << 18) as f64;

/// Moves of the pixels of scanlines to another source, in 1/256 pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moves {
    /// Number of pixels of a scanline, at least 1.
    pub width: usize,
    /// Moves in row-major order.
    pub columns: Vec<i32>,
}

/// Returns the percentage of pixels of two sources, from left to right, that have an edge between their column and their position
/// in the other source. `count` returns the number of these pixels, as computed by a backend.
pub fn eroded_percent(
    views: &OutputViews,
    pair: [&SourceView; 2],
    count: impl FnOnce(&Moves) -> Result<u64>,
) -> Result<f64> {
    Ok(50.0 * count(&Moves::between(views, pair))? as f64 / views.size.map(f64::from).iter().product::<f64>())
}

impl Moves {
    /// Returns the moves of the first layers of two sources, from left to right: the scanlines of the first, then those of the
    /// second.
    pub fn between(views: &OutputViews, [left, right]: [&SourceView; 2]) -> Moves {
        let columns = views.focal_pixels() * (right.offset_m - left.offset_m);
        let width = views.size[0] as usize;
        // Surfaces move to the left as the eye moves to the right.
        let rows = [(left, -columns), (right, columns)].into_iter().flat_map(|(source, columns)| {
            (0..views.size[1] as usize)
                .into_par_iter()
                .flat_map_iter(move |row| moves_of_row(source, row, (width, columns)))
                .collect::<Vec<i32>>()
        });
        Moves { width, columns: rows.collect() }
    }

    /// Returns the number of pixels that have an edge between their column and their position in the other source.
    pub fn eroded(&self) -> u64 {
        self.columns.par_chunks(self.width).map(|moves| u64::from(eroded(moves, &edges(moves)))).sum()
    }
}

/// Returns the moves of a scanline, 0 where there is no pixel. A surface at 1 m moves by `columns` columns.
fn moves_of_row(source: &SourceView, row: usize, (width, columns): (usize, f64)) -> Vec<i32> {
    let mut moves = vec![0; width];
    for pixel in source.rows[row].pixels.iter().filter(|pixel| pixel.layer == 0) {
        if let Some(at) = usize::try_from(pixel.column).ok().and_then(|column| moves.get_mut(column)) {
            let moved = (columns / f64::from(pixel.depth_m)).clamp(-MAX_COLUMNS, MAX_COLUMNS);
            *at = (moved * f64::from(1 << MOVE_BITS)).round() as i32;
        }
    }
    moves
}

/// Returns the number of edges of a scanline up to and including each pixel.
pub fn edges(moves: &[i32]) -> Vec<u32> {
    let is_edge = |at: usize| {
        let beside = &moves[at.saturating_sub(REACH)..(at + REACH + 1).min(moves.len())];
        let count = beside.len() as i32;
        (count * moves[at] - beside.iter().sum::<i32>()).abs() > count * TOLERANCE
    };
    let count = |sum: &mut u32, at: usize| {
        *sum += u32::from(is_edge(at));
        Some(*sum)
    };
    (0..moves.len()).scan(0, count).collect()
}

/// Returns the number of pixels of a scanline that have an edge between their column and their position in the other source.
pub fn eroded(moves: &[i32], edges: &[u32]) -> u32 {
    let is_eroded = |(at, moved): (usize, &i32)| {
        let end = at as i32 + ((moved + (1 << (MOVE_BITS - 1))) >> MOVE_BITS);
        // A pixel that leaves the image is not missing.
        usize::try_from(end).ok().and_then(|end| edges.get(end)).is_some_and(|end| *end != edges[at])
    };
    moves.iter().enumerate().map(|pixel| u32::from(is_eroded(pixel))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_whole_and_a_step_hides_as_much_as_it_moves() {
        let marked = |inverse: &[f64], columns: f64| {
            let moves: Vec<i32> = inverse.iter().map(|inverse| (256.0 * inverse * columns).round() as i32).collect();
            Moves { width: inverse.len(), columns: moves }.eroded()
        };
        assert_eq!(marked(&[0.5; 60], -20.0), 0);
        // A near wall beside a far one: they move by 10 and 2 columns in the larger case.
        let mut step = vec![0.5; 60];
        step[30..].fill(0.1);
        let [small, large] = [-8.0, -20.0].map(|columns| marked(&step, columns));
        assert!(small > 0 && large > small, "{small} {large}");
        // Slants of less than one column per pixel have no edges.
        let slant: Vec<f64> = (0..60).map(|at| 0.5 + 0.001 * f64::from(at)).collect();
        assert_eq!(marked(&slant, -20.0), 0);
    }
}
