//! Capital letters of straight strokes, on a grid of four columns and six rows.

use crate::Segment;

/// A polyline through grid points, each given by its column and row from the lower left.
type Stroke = &'static [[u8; 2]];

/// Height of a capital, and distance between letters, in grid steps.
const HEIGHT: f64 = 6.0;
const GAP: f64 = 2.2;

fn strokes(letter: char) -> &'static [Stroke] {
    match letter {
        'D' => &[&[[0, 0], [0, 6], [2, 6], [4, 4], [4, 2], [2, 0], [0, 0]]],
        'E' => &[&[[4, 0], [0, 0], [0, 6], [4, 6]], &[[0, 3], [3, 3]]],
        'F' => &[&[[0, 0], [0, 6], [4, 6]], &[[0, 3], [3, 3]]],
        'G' => &[&[[4, 5], [3, 6], [1, 6], [0, 5], [0, 1], [1, 0], [3, 0], [4, 1], [4, 3], [2, 3]]],
        'H' => &[&[[0, 0], [0, 6]], &[[4, 0], [4, 6]], &[[0, 3], [4, 3]]],
        'I' => &[&[[0, 0], [0, 6]]],
        'L' => &[&[[0, 6], [0, 0], [4, 0]]],
        'O' => &[&[[1, 0], [3, 0], [4, 1], [4, 5], [3, 6], [1, 6], [0, 5], [0, 1], [1, 0]]],
        'S' => &[&[[0, 1], [1, 0], [3, 0], [4, 1], [4, 2], [3, 3], [1, 3], [0, 4], [0, 5], [1, 6], [3, 6], [4, 5]]],
        'T' => &[&[[2, 0], [2, 6]], &[[0, 6], [4, 6]]],
        'Y' => &[&[[0, 6], [2, 3], [4, 6]], &[[2, 3], [2, 0]]],
        _ => &[],
    }
}

/// Returns the strokes of a line of text, centred on the origin, with capitals of this height in metres. Letters that are not
/// in the table are spaces.
pub(super) fn line(text: &str, height_m: f64) -> Vec<Segment> {
    let width = |letter: char| strokes(letter).iter().flat_map(|stroke| stroke.iter()).map(|at| at[0]).max();
    let advance = |letter: char| width(letter).map_or(2.0, f64::from) + GAP;
    let length = text.chars().map(advance).sum::<f64>() - GAP;
    let scale = height_m / HEIGHT;
    let (mut left, mut segments) = (-0.5 * length, Vec::new());
    for letter in text.chars() {
        let place =
            |[column, row]: [u8; 2]| [scale * (left + f64::from(column)), scale * (f64::from(row) - 0.5 * HEIGHT)];
        for pair in strokes(letter).iter().flat_map(|stroke| stroke.windows(2)) {
            if let [from, to] = *pair {
                segments.push([place(from), place(to)]);
            }
        }
        left += advance(letter);
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_centred_and_as_high_as_they_should_be() {
        let segments = line("TOY", 0.6);
        let extent = |axis: usize| {
            let all = segments.iter().flatten().map(|end| end[axis]);
            (all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max))
        };
        let (left, right) = extent(0);
        assert!((left + right).abs() < 1e-12 && (right - left - 0.1 * (12.0 + 2.0 * GAP)).abs() < 1e-12);
        let (bottom, top) = extent(1);
        assert!((bottom + 0.3).abs() < 1e-12 && (top - 0.3).abs() < 1e-12);
        assert_eq!(line("", 1.0), [] as [Segment; 0]);
        assert_eq!(line("1", 1.0), [] as [Segment; 0]);
    }
}
