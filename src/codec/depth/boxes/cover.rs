//! Covers the pixels of a mask with a few tight, non-overlapping boxes.
//!
//! Based on: CALF 5.2, figure 6: starts with one tight box and repeatedly splits. Every split position of every box is tried; the
//! one that removes the most pixels is taken, and both halves are shrunk.

use crate::depth::boxes::PixelBox;

/// A mask of `width` columns, one byte per pixel, nonzero if the pixel is set.
#[derive(Debug, Clone, Copy)]
pub struct Mask<'a> {
    pub pixels: &'a [u8],
    /// Pixels per row, at most 16,384.
    pub width: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoxBudget {
    /// Maximum number of boxes, 1 to [`MAX_BOXES`](crate::depth::boxes::MAX_BOXES).
    pub max_boxes: u16,
    pub min_saving: u32,
}

/// Returns non-overlapping boxes that cover every set pixel of the mask; none for an empty mask.
pub fn cover(mask: Mask<'_>, budget: BoxBudget) -> Vec<PixelBox> {
    let height = mask.pixels.len() / mask.width.max(1);
    let whole = Half { columns: [0, mask.width], rows: [0, height] };
    let Some(first) = Candidate::new(mask, whole) else { return Vec::new() };
    let mut done = vec![first];
    while done.len() < usize::from(budget.max_boxes) {
        // Ties are resolved by the lowest index, so that the result depends only on the mask.
        let best = (0..done.len()).rev().max_by_key(|&at| done[at].saving);
        let Some(at) = best.filter(|&at| done[at].saving > budget.min_saving) else { break };
        let halves = done[at].halves;
        // A split position lies between two set pixels, so neither half is empty.
        let mut parts: Vec<_> = halves.iter().filter_map(|&half| Candidate::new(mask, half)).collect();
        let Some(second) = parts.pop() else { break };
        let Some(first) = parts.pop() else { break };
        done[at] = first;
        done.push(second);
    }
    done.into_iter().map(|candidate| candidate.tight).collect()
}

/// Range of columns and rows, with exclusive ends, in which a candidate is searched.
#[derive(Debug, Clone, Copy, Default)]
struct Half {
    columns: [usize; 2],
    rows: [usize; 2],
}

#[derive(Debug)]
struct Candidate {
    tight: PixelBox,
    saving: u32,
    halves: [Half; 2],
}

/// First and last set position of each row or column, relative to the origin of the search; first > last if none is set.
type Spans = Vec<[u16; 2]>;
const EMPTY_SPAN: [u16; 2] = [u16::MAX, 0];

impl Candidate {
    fn new(mask: Mask<'_>, search: Half) -> Option<Candidate> {
        let (columns, rows) = spans(mask, search);
        let [left, right] = occupied(&columns)?;
        let [top, bottom] = occupied(&rows)?;
        let area = ((right - left + 1) * (bottom - top + 1)) as u32;
        let vertical = best_split(&columns[left..=right]);
        let horizontal = best_split(&rows[top..=bottom]);
        let (x, y) = (search.columns[0] + left, search.rows[0] + top);
        let (columns, rows) = ([x, search.columns[0] + right + 1], [y, search.rows[0] + bottom + 1]);
        let (kept, halves) = match (vertical, horizontal) {
            (Some((at, kept)), other) if other.is_none_or(|(_, least)| kept <= least) => {
                let cut = x + at;
                (kept, [Half { columns: [x, cut], rows }, Half { columns: [cut, columns[1]], rows }])
            }
            (_, Some((at, kept))) => {
                let cut = y + at;
                (kept, [Half { columns, rows: [y, cut] }, Half { columns, rows: [cut, rows[1]] }])
            }
            _ => (area, [Half::default(); 2]),
        };
        let size = |span: [usize; 2]| (span[1] - span[0]) as u16;
        let tight = PixelBox { x: x as u16, y: y as u16, width: size(columns), height: size(rows) };
        Some(Candidate { tight, saving: area - kept, halves })
    }
}

fn spans(mask: Mask<'_>, search: Half) -> (Spans, Spans) {
    let [left, right] = search.columns;
    let mut first = vec![u16::MAX; right - left];
    let mut last = vec![0; right - left];
    let mut rows = Vec::with_capacity(search.rows[1] - search.rows[0]);
    for (at, y) in (search.rows[0]..search.rows[1]).enumerate() {
        let row = &mask.pixels[y * mask.width + left..y * mask.width + right];
        let Some(start) = row.iter().position(|&set| set != 0) else {
            rows.push(EMPTY_SPAN);
            continue;
        };
        let end = row.iter().rposition(|&set| set != 0).unwrap_or(start);
        rows.push([start as u16, end as u16]);
        let at = at as u16;
        // Branch-free, so that the compiler vectorises it over columns.
        for ((first, last), &set) in first[start..=end].iter_mut().zip(&mut last[start..=end]).zip(&row[start..=end]) {
            let set = set != 0;
            *first = if set { at.min(*first) } else { *first };
            *last = if set { at } else { *last };
        }
    }
    (first.into_iter().zip(last).map(|(first, last)| [first, last]).collect(), rows)
}

fn occupied(lines: &[[u16; 2]]) -> Option<[usize; 2]> {
    let holds = |span: &[u16; 2]| span[0] <= span[1];
    Some([lines.iter().position(holds)?, lines.iter().rposition(holds)?])
}

/// Returns the cut that leaves the fewest pixels in two tight boxes: its position (lines before it) and the number of pixels.
fn best_split(lines: &[[u16; 2]]) -> Option<(usize, u32)> {
    // The outermost lines are occupied, so neither side of a cut is empty.
    let before = areas(lines.iter());
    let after = areas(lines.iter().rev());
    (1..lines.len()).map(|cut| (cut, before[cut - 1] + after[lines.len() - cut - 1])).min_by_key(|&(_, kept)| kept)
}

/// Returns the area of the tight box around the first line, around the first two, and so on.
fn areas<'a>(lines: impl Iterator<Item = &'a [u16; 2]>) -> Vec<u32> {
    let (mut low, mut high, mut depth, mut held) = (u16::MAX, 0, 0, 0);
    lines
        .map(|&[first, last]| {
            depth += 1;
            if first <= last {
                low = low.min(first);
                high = high.max(last);
                held = depth;
            }
            held * (u32::from(high) + 1 - u32::from(low.min(high)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask_of(rows: &[&str]) -> (Vec<u8>, usize) {
        let pixels = rows.iter().flat_map(|row| row.bytes().map(|c| u8::from(c == b'#'))).collect();
        (pixels, rows[0].len())
    }

    fn check(pixels: &[u8], width: usize, budget: BoxBudget) -> Vec<PixelBox> {
        let boxes = cover(Mask { pixels, width }, budget);
        assert!(boxes.len() <= usize::from(budget.max_boxes));
        for (at, a) in boxes.iter().enumerate() {
            assert!(boxes[at + 1..].iter().all(|b| !a.overlaps(*b)), "{boxes:?}");
        }
        for (at, &set) in pixels.iter().enumerate() {
            let (x, y) = ((at % width) as u16, (at / width) as u16);
            let inside = boxes.iter().any(|b| x >= b.x && y >= b.y && x - b.x < b.width && y - b.y < b.height);
            assert!(inside || set == 0, "({x}, {y}) is not covered by {boxes:?}");
        }
        boxes
    }

    #[test]
    fn two_blobs_get_a_tight_box_each() {
        let (pixels, width) = mask_of(&["##......", "##......", "........", "......##", ".....###"]);
        let budget = BoxBudget { max_boxes: 2, min_saving: 0 };
        let boxes = check(&pixels, width, budget);
        assert_eq!(boxes, [PixelBox { x: 0, y: 0, width: 2, height: 2 }, PixelBox { x: 5, y: 3, width: 3, height: 2 }]);
        assert_eq!(check(&pixels, width, BoxBudget { max_boxes: 1, ..budget }).len(), 1);
        assert_eq!(check(&pixels, width, BoxBudget { min_saving: 40, ..budget }).len(), 1);
    }

    #[test]
    fn an_empty_mask_has_no_boxes_and_a_full_one_has_one() {
        let budget = BoxBudget { max_boxes: 8, min_saving: 0 };
        assert_eq!(cover(Mask { pixels: &[0; 12], width: 4 }, budget), []);
        assert_eq!(check(&[1; 12], 4, budget).len(), 1);
        assert_eq!(check(&[1], 1, budget).len(), 1);
    }

    #[test]
    fn random_masks_are_covered_and_more_boxes_never_cost_pixels() {
        let mut seed = 1u32;
        for (width, height) in [(1, 9), (9, 1), (3, 3), (16, 16), (33, 7)] {
            for density in [2, 8, 64] {
                let pixels: Vec<u8> = (0..width * height)
                    .map(|_| {
                        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        u8::from((seed >> 16).is_multiple_of(density))
                    })
                    .collect();
                let mut last = u32::MAX;
                for max_boxes in [1, 2, 4, 8, 256] {
                    let boxes = check(&pixels, width, BoxBudget { max_boxes, min_saving: 0 });
                    let area = boxes.iter().map(|b| b.area()).sum();
                    assert!(area <= last);
                    last = area;
                }
            }
        }
    }
}
