//! Erosion: an estimate of what two source views miss between them, without interpolation (Epipolar 3.3.1).
//!
//! A pixel is at an edge where its inverse distance differs from the mean of five pixels of its scanline. Counts of edges, summed from the
//! left, differ between a pixel and the place that it has in the other source where an edge lies on that way: what is behind the edge may
//! come into view. Listing 3.6 of the thesis counts the pixels that are not marked so.

use rayon::prelude::*;

use crate::epipolar::source::SourceView;
use crate::epipolar::views::OutputViews;

/// Pixels in the window of the mean.
const WINDOW: usize = 5;
/// Columns between the two sources by which a pixel within a surface differs from the mean.
const TOLERANCE_COLUMNS: f64 = 1.0;

/// Pixels in percent, of two sources from left to right, from which the way to their place in the other one crosses an edge.
pub(super) fn eroded_percent(views: &OutputViews, [left, right]: [&SourceView; 2]) -> f64 {
    let columns = views.focal_pixels() * (right.offset_m - left.offset_m);
    let width = views.size[0] as usize;
    let of_row = |row: usize| {
        // Surfaces move to the left, as the eye moves to the right.
        let [of_left, of_right] = [(left, -columns), (right, columns)]
            .map(|(source, columns)| marked(&inverse_of_row(source, row, width), columns));
        (of_left + of_right) as u64
    };
    let count: u64 = (0..views.size[1] as usize).into_par_iter().map(of_row).sum();
    50.0 * count as f64 / views.size.map(f64::from).iter().product::<f64>()
}

/// Inverse distances of the first layer by column, 0 where there is no pixel.
fn inverse_of_row(source: &SourceView, row: usize, width: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; width];
    for pixel in source.rows[row].pixels.iter().filter(|pixel| pixel.layer == 0) {
        if let Some(at) = usize::try_from(pixel.column).ok().and_then(|column| inverse.get_mut(column)) {
            *at = f64::from(pixel.depth_m).recip();
        }
    }
    inverse
}

/// Pixels from which an edge lies on the way to their place in another view, where a surface at 1 m has moved by so many columns.
fn marked(inverse: &[f64], columns: f64) -> usize {
    let window = |at: usize| at.saturating_sub(WINDOW / 2)..(at + WINDOW / 2 + 1).min(inverse.len());
    let is_edge = |at: usize| {
        let beside = &inverse[window(at)];
        let mean = beside.iter().sum::<f64>() / beside.len() as f64;
        ((inverse[at] - mean) * columns).abs() > TOLERANCE_COLUMNS
    };
    let mut edges = Vec::with_capacity(inverse.len());
    let mut count = 0u32;
    for at in 0..inverse.len() {
        count += u32::from(is_edge(at));
        edges.push(count);
    }
    let is_marked = |at: usize| {
        let end = (at as f64 + columns * inverse[at]).round();
        // What leaves the image is not missing in it.
        (0.0..inverse.len() as f64).contains(&end) && edges[end as usize] != edges[at]
    };
    (0..inverse.len()).filter(|&at| is_marked(at)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_whole_and_a_step_hides_as_much_as_it_moves() {
        assert_eq!(marked(&[0.5; 60], -20.0), 0);
        // A near wall before a far one: 10 and 2 columns.
        let mut step = vec![0.5; 60];
        step[30..].fill(0.1);
        let [small, large] = [-8.0, -20.0].map(|columns| marked(&step, columns));
        assert!(small > 0 && large > small, "{small} {large}");
        // Slants of less than a column a pixel have no edges.
        let slant: Vec<f64> = (0..60).map(|at| 0.5 + 0.001 * f64::from(at)).collect();
        assert_eq!(marked(&slant, -20.0), 0);
    }
}
