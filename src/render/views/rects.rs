//! Rectangles of texels: intersection, bounding rectangle, and merging.

/// Left, top, width and height; width and height are above 0.
pub type Rect = [u32; 4];

pub fn overlap(a: Rect, b: Rect) -> Option<Rect> {
    let [left, top] = [0, 1].map(|axis| a[axis].max(b[axis]));
    let [right, bottom] = [0, 1].map(|axis| (a[axis] + a[axis + 2]).min(b[axis] + b[axis + 2]));
    (left < right && top < bottom).then(|| [left, top, right - left, bottom - top])
}

/// Returns the smallest rectangle that contains both.
pub fn bounds(a: Option<Rect>, b: Rect) -> Rect {
    let Some(a) = a else { return b };
    let [left, top] = [0, 1].map(|axis| a[axis].min(b[axis]));
    let [right, bottom] = [0, 1].map(|axis| (a[axis] + a[axis + 2]).max(b[axis] + b[axis + 2]));
    [left, top, right - left, bottom - top]
}

/// Returns the same texels as fewer rectangles: joins neighbours in a row that have the same height, then neighbours in a column
/// that have the same width. Overlapping rectangles are not joined.
pub fn joined(rects: Vec<Rect>) -> Vec<Rect> {
    joined_along(1, joined_along(0, rects))
}

fn joined_along(axis: usize, mut rects: Vec<Rect>) -> Vec<Rect> {
    let across = 1 - axis;
    rects.sort_unstable_by_key(|rect| [rect[across], rect[axis]]);
    let mut all: Vec<Rect> = Vec::with_capacity(rects.len());
    for rect in rects {
        let begin = [rect[across], rect[across + 2], rect[axis]];
        match all.last_mut() {
            Some(last) if [last[across], last[across + 2], last[axis] + last[axis + 2]] == begin => {
                last[axis + 2] += rect[axis + 2];
            }
            _ => all.push(rect),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_meet() {
        assert_eq!(overlap([0, 0, 4, 4], [2, 3, 9, 9]), Some([2, 3, 2, 1]));
        assert_eq!(overlap([0, 0, 4, 4], [4, 0, 1, 1]), None);
        assert_eq!(bounds(None, [3, 4, 1, 2]), [3, 4, 1, 2]);
        assert_eq!(bounds(Some([3, 4, 1, 2]), [0, 5, 2, 4]), [0, 4, 4, 5]);
    }

    #[test]
    fn a_grid_becomes_one_rectangle_and_a_gap_splits_it() {
        let grid: Vec<Rect> = (0..12).map(|at| [at % 4 * 8, at / 4 * 8, 8, 8]).collect();
        assert_eq!(joined(grid.clone()), [[0, 0, 32, 24]]);
        let gap: Vec<Rect> = grid.iter().copied().filter(|rect| *rect != [8, 8, 8, 8]).collect();
        let parts = joined(gap);
        assert!(parts.len() < 6);
        let covers = |parts: &[Rect], x: u32, y: u32| {
            parts.iter().filter(|&&rect| overlap(rect, [x, y, 1, 1]).is_some()).count()
        };
        for (x, y) in (0..24).flat_map(|y| (0..32).map(move |x| (x, y))) {
            assert_eq!(covers(&parts, x, y), usize::from(!((8..16).contains(&x) && (8..16).contains(&y))));
        }
    }
}
