//! Parts of transform payloads (formats/color.md 6) for tests: headers, table sets, and statistics of what regions contain.

use std::collections::BTreeSet;

use codec::color::transform::Tables;
use codec::color::transform::contexts::{ALPHABETS, FAMILIES, NODE};
use codec::color::transform::domain::ChromaSlopes;
use codec::color::transform::payload::Header;
use codec::color::transform::region::{Content, Region};
use codec::color::transform::steps::StepIndices;
use codec::container::fields::Fields;
use codec::container::serialize::PutFields;
use codec::entropy::Family;

use crate::samples::Random;

/// Returns a header with typical steps and slopes for samples of `bytes` bytes.
pub fn usual_header(bytes: usize) -> Header {
    let luma = if bytes == 1 { 84 } else { 180 };
    Header {
        set: 0,
        steps: StepIndices { luma, chroma: luma + 5 },
        slopes: ChromaSlopes { green: 3, orange: -7 },
        offset_set: 1,
        colors: Vec::new(),
    }
}

/// Returns random own table sets, in which about every third symbol has frequency 0.
pub fn own_sets(count: u8, random: &mut Random) -> Tables {
    let mut bytes = Vec::new();
    for _ in 0..count {
        for (cluster, alphabet) in ALPHABETS.into_iter().enumerate() {
            let certain = cluster >= NODE.clusters && random.below(9) == 0;
            let mut left = 4096;
            for _ in 1..alphabet {
                // Node symbols have a frequency of at least 1, so that every block has a legal symbol.
                let spared = if cluster < NODE.clusters { 1 } else { 0 };
                let frequency = match random.below(3) {
                    _ if certain => 0,
                    0 => spared,
                    _ => (1 + random.below(left / 3)).max(spared),
                };
                bytes.put_varint(frequency.into());
                left -= frequency;
            }
        }
    }
    Tables::read(&mut Fields::new(&bytes, 0, ""), count).unwrap()
}

/// Returns tables with one own set; `frequencies` returns the frequencies of all distributions of a family.
pub fn own_set(frequencies: impl Fn(Family) -> Vec<u16>) -> Tables {
    let mut bytes = Vec::new();
    for family in FAMILIES {
        for _ in 0..family.clusters {
            frequencies(family)[..family.alphabet - 1].iter().for_each(|&count| bytes.put_varint(count.into()));
        }
    }
    Tables::read(&mut Fields::new(&bytes, 0, ""), 1).unwrap()
}

/// Shapes of blocks that occur in payloads.
#[derive(Debug, Default)]
pub struct Coverage {
    /// Size level and length in frames of transformed blocks.
    pub transforms: BTreeSet<(usize, usize)>,
    /// Size level and number of colours of palette blocks.
    pub palettes: BTreeSet<(usize, usize)>,
    pub regions: usize,
}

impl Coverage {
    pub fn note(&mut self, regions: &[Region]) {
        for region in regions {
            self.regions += 1;
            for leaf in region.leaves() {
                let shape = leaf.block().shape;
                match &leaf.content {
                    Content::Transform { .. } => self.transforms.insert((shape.level, shape.frames)),
                    Content::Palette(palette) => self.palettes.insert((shape.level, palette.colors.len())),
                };
            }
        }
    }
}
