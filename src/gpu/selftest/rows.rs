//! Inputs of the kernels that process rows of pixels: compaction and erosion (Epipolar 3.3).

use crate::harness::Case;
use codec::math::random::Random;
use epipolar::drawing::{self, compact};
use epipolar::erosion::{edges, eroded};
use kernels::layout::{PixelRows, words_of};

const WORKGROUP: u32 = 256;
/// Widths and heights: one, odd, and around the size of a workgroup; the last one is timed.
const SIZES: [[u32; 2]; 9] = [[1, 1], [1, 700], [3, 2], [255, 3], [256, 1], [257, 5], [1025, 2], [4096, 1], [960, 540]];

fn block([width, rows]: [u32; 2], stride: u32) -> Vec<u32> {
    words_of(&[PixelRows { width, rows, stride, spare: 0 }])
}

/// A layer: its size and stride, and the triangle number plus 1 of each pixel.
struct Layer {
    label: String,
    size: [u32; 2],
    stride: u32,
    shown: Vec<u32>,
}

/// Returns layers without, with only, and with some active pixels, with and without padding between rows.
fn layers(seed: u64) -> Vec<Layer> {
    let mut random = Random::new(seed);
    let kinds: [(&str, u32); 4] = [("nothing", 0), ("everything", 1), ("every third", 3), ("a little", 40)];
    let layer = |([width, rows], (name, one_in)): ([u32; 2], (&str, u32))| {
        let number = |random: &mut Random| 1 + random.below(u32::MAX - 1);
        let shown =
            (0..width * rows).map(|_| if one_in > 0 && random.one_in(one_in) { number(&mut random) } else { 0 });
        let shown = shown.collect();
        let stride = if rows % 2 == 0 { width.next_multiple_of(32) } else { width };
        Layer { label: format!("{name} in {width}x{rows}"), size: [width, rows], stride, shown }
    };
    SIZES.into_iter().flat_map(|size| kinds.map(|kind| (size, kind))).map(layer).collect()
}

impl Layer {
    /// Returns the layer as texels of a drawing, with arbitrary values in the padding and in the second words.
    fn texels(&self) -> Vec<u32> {
        const LEFT_OUT: u32 = 0xdead_beef;
        let [width, stride] = [self.size[0], self.stride].map(|count| count as usize);
        let row = |row: &[u32]| {
            let texels = row.iter().flat_map(|&shown| [shown, LEFT_OUT]);
            texels.chain(vec![LEFT_OUT; 2 * (stride - width)]).collect::<Vec<_>>()
        };
        self.shown.chunks(width).flat_map(row).collect()
    }

    fn case(self, expected: (&'static str, Vec<u32>)) -> Case {
        let (name, words) = &expected;
        let buffers = [
            ("block", block(self.size, self.stride)),
            ("shown", self.texels()),
            ("counts", drawing::active_counts(&self.shown, self.size[0] as usize)),
            (*name, vec![0xdead_beef; words.len()]),
        ];
        let pixels = self.shown.len() as u64;
        Case {
            label: self.label,
            buffers: buffers.into(),
            invocations: self.size[1] * WORKGROUP,
            passes: 0,
            expected: vec![expected],
            inputs: pixels,
            pixels,
        }
    }
}

pub(super) fn active_counts(seed: u64) -> Vec<Case> {
    let case = |layer: Layer| {
        let expected = drawing::active_counts(&layer.shown, layer.size[0] as usize);
        layer.case(("counts", expected))
    };
    layers(seed).into_iter().map(case).collect()
}

pub(super) fn compacted(seed: u64) -> Vec<Case> {
    let case = |layer: Layer| {
        let expected = compact(&layer.shown).into_flattened();
        layer.case(("active_pixels", expected))
    };
    layers(seed).into_iter().map(case).collect()
}

/// Returns moves of flat and slanted surfaces, random moves, maximum moves, and steps at the tolerance and just above it.
fn moves([width, rows]: [u32; 2], random: &mut Random) -> Vec<i32> {
    const MAX_VALUE: i32 = 1 << 26;
    let mut moves = Vec::new();
    for _ in 0..rows {
        let mut row: Vec<i32> = Vec::new();
        while row.len() < width as usize {
            let length = 1 + random.below(width.min(60));
            let near = random.below(256 * width.min(200)) as i32 - 128 * width.min(200) as i32;
            let kind = random.below(6);
            let moved = |at: u32, random: &mut Random| match kind {
                0 => near,
                1 => near + 40 * at as i32,
                2 => near + (at % 2) as i32 * (320 + random.below(2) as i32),
                3 => random.word() as i32 % MAX_VALUE,
                4 => [MAX_VALUE, -MAX_VALUE][(at % 2) as usize],
                _ => 0,
            };
            row.extend((0..length).map(|at| moved(at, random)));
        }
        row.truncate(width as usize);
        moves.extend(row);
    }
    moves
}

fn erosions(seed: u64, of_row: impl Fn(&[i32]) -> Vec<u32>, name: &'static str) -> Vec<Case> {
    let mut random = Random::new(seed);
    let case = |size: [u32; 2]| {
        let moves = moves(size, &mut random);
        let rows = || moves.chunks(size[0] as usize);
        let expected: Vec<u32> = rows().flat_map(&of_row).collect();
        let buffers = [
            ("block", block(size, size[0])),
            ("moves", words_of(&moves)),
            ("edges", rows().flat_map(edges).collect()),
            (name, vec![0xdead_beef; expected.len()]),
        ];
        Case {
            label: format!("{}x{}", size[0], size[1]),
            buffers: buffers.into(),
            invocations: size[1] * WORKGROUP,
            passes: 0,
            expected: vec![(name, expected)],
            inputs: u64::from(size[1]),
            pixels: moves.len() as u64,
        }
    };
    SIZES.into_iter().map(case).collect()
}

pub(super) fn erosion_edges(seed: u64) -> Vec<Case> {
    erosions(seed, edges, "edges")
}

pub(super) fn erosion(seed: u64) -> Vec<Case> {
    erosions(seed, |moves| vec![eroded(moves, &edges(moves))], "eroded")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::SEED;

    #[test]
    fn inputs_have_edges_and_ways_that_cross_them() {
        let last = |cases: Vec<Case>| cases.into_iter().next_back().unwrap().expected.remove(0).1;
        let marked = u64::from(last(erosion(SEED)).iter().sum::<u32>());
        let most = u64::from(960u32 * 540);
        assert!(marked > most / 10 && marked < most, "{marked}");
        // Some steps near the tolerance are edges, and others are not.
        let edges = last(erosion_edges(SEED));
        assert!(edges.windows(2).any(|pair| pair[0] == pair[1]) && edges.iter().any(|count| *count > 100));
    }
}
