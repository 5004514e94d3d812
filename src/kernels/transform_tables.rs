//! Tables of the transform codec in device memory: those of the format, then the table sets of the streams (color.md 6, 7).

use codec::color::transform::basis::{LENGTHS, basis, length_index};
use codec::color::transform::blocks::MAX_FRAMES;
use codec::color::transform::contexts::{CLASSES_OF_SUMS, CLUSTER_OF, CLUSTERS};
use codec::color::transform::steps::{INVERSE_ROOTS, OCTAVE, OFFSET_SETS};
use codec::color::transform::{Tables, scan};
use codec::entropy::SYMBOLS;
use codec::streams::{CodecHeader, StreamInfo};

/// Points of the largest spatial basis; it is not a transform length in time.
const MAX_POINTS: usize = 32;
/// Number of block sizes.
const SIZES: usize = 4;
/// Words of a table set, one per symbol: its first slot, and from bit 16 the end of its slots.
pub const SET_WORDS: usize = CLUSTERS * SYMBOLS;

/// Tables of all streams in one buffer.
#[derive(Debug, Default)]
pub struct TransformTables {
    pub words: Vec<u32>,
    /// First word of each stream's table sets.
    pub first_sets: Vec<u32>,
}

impl TransformTables {
    /// Returns the tables of streams of one family; empty for other codecs.
    pub fn of(streams: &[&StreamInfo]) -> TransformTables {
        let tables = streams.iter().filter_map(|stream| match &stream.header {
            CodecHeader::Color(header) => header.tables(),
            _ => None,
        });
        let tables: Vec<&Tables> = tables.collect();
        if tables.is_empty() { TransformTables::default() } else { TransformTables::new(tables) }
    }

    pub fn new<'a>(streams: impl IntoIterator<Item = &'a Tables>) -> TransformTables {
        let mut words = of_format();
        let mut known: Vec<(&Tables, u32)> = Vec::new();
        let mut first_of = |tables: &'a Tables| {
            if let Some((_, first)) = known.iter().find(|(other, _)| *other == tables) {
                return *first;
            }
            let first = words.len() as u32;
            known.push((tables, first));
            let distributions = tables.sets().iter().flat_map(|set| set.distributions());
            words.extend(distributions.flat_map(|distribution| {
                let starts = distribution.starts();
                (0..SYMBOLS).map(|symbol| u32::from(starts[symbol]) | u32::from(starts[symbol + 1]) << 16)
            }));
            first
        };
        let first_sets = streams.into_iter().map(&mut first_of).collect();
        TransformTables { words, first_sets }
    }
}

/// Returns the words of the format's tables.
pub fn of_format() -> Vec<u32> {
    let points: Vec<usize> = LENGTHS.into_iter().chain([MAX_POINTS]).collect();
    let scans = (0..SIZES).flat_map(scan::order);
    let scans: Vec<u32> = scans.map(|at| u32::from(at.0) | (at.class() as u32) << 16).collect();
    let classes = CLASSES_OF_SUMS.map(u32::from);
    let clusters = CLUSTER_OF.iter().map(|&cluster| u32::from(cluster) * SYMBOLS as u32);
    let offsets = OFFSET_SETS.iter().flatten().flatten().map(|&offset| u32::from(offset));
    let steps: Vec<u32> = OCTAVE.into_iter().chain(INVERSE_ROOTS).chain(offsets).collect();
    let (mut heads, mut bases) = (vec![LENGTHS.len() as u32; MAX_FRAMES as usize + 1], Vec::new());
    let first = heads.len() + classes.len() + scans.len() + clusters.len() + steps.len();
    for points in points {
        heads[points] = length_index(points).unwrap_or(LENGTHS.len()) as u32 | ((first + bases.len()) as u32) << 8;
        bases.extend((0..points * points).map(|at| basis(points, at / points, at % points) as u32));
    }
    [heads, classes.to_vec(), scans, clusters.collect(), steps, bases].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout;
    use codec::color::transform::contexts::{BUILT_IN, CONTEXTS, FAMILIES};

    #[test]
    fn constants_are_those_of_the_format() {
        let first = FAMILIES.map(|family| family.first_context as u32);
        let known = [
            layout::CONTEXT_NODE,
            layout::CONTEXT_PLANES,
            layout::CONTEXT_CODED,
            layout::CONTEXT_LAST,
            layout::CONTEXT_LAST_BITS,
            layout::CONTEXT_LEVELS,
            layout::CONTEXT_PALETTE_SIZE,
            layout::CONTEXT_PALETTE_COLOR,
            layout::CONTEXT_ROW,
            layout::CONTEXT_PIXEL,
            layout::CONTEXT_LATER_FRAME,
            layout::CONTEXT_LATER_ROW,
            layout::CONTEXT_LATER_PIXEL,
        ];
        assert_eq!(first, known);
        let words = of_format();
        let at = |first: u32, count: usize| &words[first as usize..][..count];
        assert_eq!(at(layout::SUM_CLASSES_AT, CLASSES_OF_SUMS.len()), CLASSES_OF_SUMS.map(u32::from));
        let sizes = [0, 16, 16 + 64, 16 + 64 + 256].map(|before| layout::SCAN_AT + before);
        for (level, first) in sizes.into_iter().enumerate() {
            let order = scan::order(level);
            assert!(
                at(first, order.len()).iter().zip(order).all(|(word, position)| word & 0xffff == u32::from(position.0))
            );
        }
        assert!(at(layout::CLUSTERS_AT, CONTEXTS).iter().zip(CLUSTER_OF).all(|(&at, of)| at == u32::from(of) * 16));
        assert_eq!(at(layout::OCTAVE_AT, OCTAVE.len()), OCTAVE);
        assert_eq!(at(layout::ROOTS_AT, INVERSE_ROOTS.len()), INVERSE_ROOTS);
        let offsets = at(layout::OFFSETS_AT, 128 * OFFSET_SETS.len());
        assert!(
            offsets
                .iter()
                .zip(OFFSET_SETS.iter().flatten().flatten())
                .all(|(&word, &offset)| word == u32::from(offset))
        );
        for points in [1, 24, 32] {
            let first = words[points] >> 8;
            assert_eq!(words[first as usize], 256);
            assert_eq!(at(first, points * points)[points * points - 1] as i32, basis(points, points - 1, points - 1));
        }
        assert_eq!((words[2] & 255, words[5]), (1, 9));
    }

    #[test]
    fn streams_of_equal_tables_share_them() {
        let own = Tables::with_own(Tables::default().sets()[..1].to_vec());
        let tables = TransformTables::new([&Tables::default(), &own, &Tables::default()]);
        let (first, sets) = (of_format().len() as u32, BUILT_IN as u32);
        assert_eq!(tables.first_sets, [first, first + sets * SET_WORDS as u32, first]);
        assert_eq!(tables.words.len(), of_format().len() + (2 * sets as usize + 1) * SET_WORDS);
    }
}
