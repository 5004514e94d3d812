//! Contexts of symbols (color.md 6.6): the values decoded before a symbol select its distribution. The entropy model:
//! formats/color-tables.txt (color.md 6.7).

use std::sync::LazyLock;

use crate::color::transform::basis::{LENGTHS, length_index};
use crate::color::transform::blocks::Shape;
use crate::entropy::text_reader::BuiltIn;
use crate::entropy::{self, Family, Model};

const SIZES: usize = 4;
/// Number of channel classes: luma, chroma.
const COLORS: usize = 2;
/// Number of classes of temporal frequencies: constant, first, later, and that of single frames.
const PLANE_CLASSES: usize = 4;
/// Number of classes of positions, by the sum of the two spatial frequencies.
const POSITION_CLASSES: usize = 6;
const SUM_CLASSES: usize = 8;
const OTHER_CLASSES: usize = 3;
/// Number of logarithms of the last position in a plane of at most 32x32 levels.
const LOGARITHMS: usize = 11;
/// Class of a sum of magnitudes; greater sums are in the last class.
pub const CLASSES_OF_SUMS: [u8; 12] = [0, 1, 2, 3, 4, 5, 5, 6, 6, 6, 6, 7];

/// Kind of a node.
pub const NODE: Family = Family::first(SIZES * (LENGTHS.len() + 1), 4, 8);
/// Number of coded planes of a channel.
pub const PLANES: Family = Family::after(NODE, 3 * SIZES * LENGTHS.len() * 3, 16, 12);
/// Flag: a plane before the last has levels.
pub const CODED: Family = Family::after(PLANES, 3 * PLANE_CLASSES * SIZES * 2, 2, 8);
/// Logarithm of the last position.
pub const LAST: Family = Family::after(CODED, COLORS * SIZES * PLANE_CLASSES * (1 + LOGARITHMS), LOGARITHMS, 12);
/// The two bits below the highest bit of the last position.
pub const LAST_BITS: Family = Family::after(LAST, COLORS * LOGARITHMS, 4, 3);
/// Levels: contexts of the last level of a plane, then those of all others.
pub const LEVELS: Family =
    Family::after(LAST_BITS, COLORS * PLANE_CLASSES * POSITION_CLASSES * OTHER_CLASSES * (1 + SUM_CLASSES), 16, 32);
/// Number of colours of a palette, minus 1.
pub const PALETTE_SIZE: Family = Family::after(LEVELS, SIZES, 16, SIZES);
/// Position of a colour in the cache.
pub const PALETTE_COLOR: Family = Family::after(PALETTE_SIZE, 1, 16, 1);
/// Flag: a row of the first frame repeats the row above.
pub const ROW: Family = Family::after(PALETTE_COLOR, 2, 2, 2);
/// Neighbour that a pixel of the first frame repeats.
pub const PIXEL: Family = Family::after(ROW, 16, 3, 16);
/// Flag: a later frame repeats the frame before.
pub const LATER_FRAME: Family = Family::after(PIXEL, 2, 2, 2);
/// Flag: a row of a later frame repeats the same row of the frame before.
pub const LATER_ROW: Family = Family::after(LATER_FRAME, 2, 2, 2);
/// Neighbour that a pixel of a later frame repeats.
pub const LATER_PIXEL: Family = Family::after(LATER_ROW, 16, 4, 16);

pub const FAMILIES: [Family; 13] = [
    NODE,
    PLANES,
    CODED,
    LAST,
    LAST_BITS,
    LEVELS,
    PALETTE_SIZE,
    PALETTE_COLOR,
    ROW,
    PIXEL,
    LATER_FRAME,
    LATER_ROW,
    LATER_PIXEL,
];
pub const CONTEXTS: usize = LATER_PIXEL.first_context + LATER_PIXEL.contexts;
pub const CLUSTERS: usize = LATER_PIXEL.first_cluster + LATER_PIXEL.clusters;

/// Alphabet size of each cluster.
pub const ALPHABETS: [u8; CLUSTERS] = Family::alphabets(&FAMILIES);

pub fn node(shape: Shape) -> usize {
    let length = length_index(shape.frames).unwrap_or(LENGTHS.len());
    NODE.first_context + shape.level * (LENGTHS.len() + 1) + length
}

/// Context of the number of planes of a channel. `before` is the number of planes, at most 2, of the last channel that had
/// any.
pub fn planes(channel: usize, shape: Shape, before: usize) -> usize {
    let length = length_index(shape.frames).unwrap_or(0);
    PLANES.first_context + ((channel * SIZES + shape.level) * LENGTHS.len() + length) * 3 + before
}

/// Class, 0 to 11, of the scan index of a plane's last level: 1 more than log2 of (index + 1); 0 for a plane without levels.
pub fn last_class(last: Option<usize>) -> usize {
    last.map_or(0, |last| 1 + (last + 1).ilog2() as usize)
}

/// Contexts of a plane of a channel of a block; a plane is a temporal frequency.
#[derive(Debug, Clone, Copy)]
pub struct PlaneContext {
    channel: usize,
    size_class: usize,
    class: usize,
    /// First context, over all position classes, of the levels other than the last; `last_levels` is that of the last level.
    levels: usize,
    last_levels: usize,
}

impl PlaneContext {
    pub fn new(channel: usize, shape: Shape, plane: usize) -> PlaneContext {
        let class = if shape.frames == 1 { PLANE_CLASSES - 1 } else { plane.min(2) };
        let row = (usize::from(channel > 0) * PLANE_CLASSES + class) * POSITION_CLASSES;
        let others = LEVELS.first_context + COLORS * PLANE_CLASSES * POSITION_CLASSES * OTHER_CLASSES;
        PlaneContext {
            channel,
            size_class: shape.level,
            class,
            levels: others + row * SUM_CLASSES * OTHER_CLASSES,
            last_levels: LEVELS.first_context + row * OTHER_CLASSES,
        }
    }

    pub fn coded(&self, before: bool) -> usize {
        CODED.first_context
            + ((self.channel * PLANE_CLASSES + self.class) * SIZES + self.size_class) * 2
            + usize::from(before)
    }

    /// Context of the logarithm of the last position; `class_before` is [`last_class`] of the plane before.
    pub fn last(&self, class_before: usize) -> usize {
        let row = (usize::from(self.channel > 0) * SIZES + self.size_class) * PLANE_CLASSES + self.class;
        LAST.first_context + row * (1 + LOGARITHMS) + class_before
    }

    pub fn last_bits(&self, class: usize) -> usize {
        LAST_BITS.first_context + usize::from(self.channel > 0) * LOGARITHMS + class
    }

    /// Context of the level at `position`, from the sum of the magnitudes around it and the magnitude in the plane before.
    #[inline(always)]
    pub fn level(&self, position: Position, sum: usize, other: usize) -> usize {
        let sum = usize::from(CLASSES_OF_SUMS[sum.min(CLASSES_OF_SUMS.len() - 1)]);
        self.levels + (position.class() * SUM_CLASSES + sum) * OTHER_CLASSES + other.min(OTHER_CLASSES - 1)
    }

    /// Context of the last level, at `position`.
    #[inline(always)]
    pub fn last_level(&self, position: Position, other: usize) -> usize {
        self.last_levels + position.class() * OTHER_CLASSES + other.min(OTHER_CLASSES - 1)
    }
}

/// A pair of spatial frequencies: 32·vertical + horizontal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Position(pub u16);

impl Position {
    #[inline(always)]
    pub fn x(self) -> usize {
        usize::from(self.0 & 31)
    }

    #[inline(always)]
    pub fn y(self) -> usize {
        usize::from(self.0 >> 5)
    }

    #[inline(always)]
    pub fn class(self) -> usize {
        const CLASSES: [u8; 63] = {
            let mut classes = [5; 63];
            let first = [0, 1, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4];
            let mut at = 0;
            while at < first.len() {
                classes[at] = first[at];
                at += 1;
            }
            classes
        };
        usize::from(CLASSES[(self.x() + self.y()).min(62)])
    }
}

/// Number of built-in sets.
pub const BUILT_IN: usize = 10;

static FORMAT: BuiltIn<CONTEXTS, CLUSTERS, BUILT_IN> =
    BuiltIn::parse(include_bytes!(concat!(env!("LIGHTFOLD_FORMATS"), "/color-tables.txt")), &FAMILIES, &ALPHABETS);

/// Index of the distribution of each context.
pub static CLUSTER_OF: [u8; CONTEXTS] = FORMAT.cluster_of;

/// Entropy model of the transform codec.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transform;

pub type TableSet = entropy::TableSet<Transform>;
pub type Tables = entropy::Tables<Transform>;

impl Model for Transform {
    const TITLE: &'static str = "Entropy tables of the transform codec (color.md 6.7)";
    const FILE: &'static str = "formats/color-tables.txt";
    const FAMILIES: &'static [Family] = &FAMILIES;
    const ALPHABETS: &'static [u8] = &ALPHABETS;

    #[inline(always)]
    fn cluster_of(context: usize) -> usize {
        CLUSTER_OF[context].into()
    }

    fn built_in() -> &'static Tables {
        static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables::of_format(&FORMAT.sets));
        &TABLES
    }
}
