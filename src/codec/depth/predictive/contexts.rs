//! Contexts of symbols (depth.md 15.7), which select the distribution of a symbol from symbols that are already decoded; and the
//! entropy model: formats/depth-tables.txt (depth.md 15.8).

use std::sync::LazyLock;

use crate::depth::predictive::modes::{BLOCK_STATES, MODES, SMALL_MODES};
use crate::depth::predictive::pixel::{CLASSES, Pixel, SYMBOLS};
use crate::depth::predictive::plane::Side;
use crate::entropy::text_reader::BuiltIn;
use crate::entropy::{self, Family, Model};

/// Number of kinds of frames: the first of a chunk, and later ones.
const FRAMES: usize = 2;
/// Number of groups of classes of the pixel above on the right.
const RIGHT_GROUPS: usize = 5;
/// Number of states of a block's past: none in a first frame; coded as pixels or quarters; any other mode.
pub const PASTS: usize = 3;
/// Number of contexts of the class of an escape: 12 levels of the larger magnitude of the neighbours, times 3 levels of its ratio
/// to the smaller one.
const ESCAPES: usize = 36;
/// Maximum number of candidates for another surface. Each has its own context.
pub const CANDIDATES: usize = 3;
/// Number of contexts of a plane's change: value, horizontal slope or vertical slope, times whether the number before is 0.
const CHANGES: usize = 6;
/// Number of kinds of edges of a quarter: both pixels settled, both as predicted, one of them background, any other.
const EDGES: usize = 4;

/// 1 if a frame differs from the one before, otherwise 0.
pub const FRAME: Family = Family::first(FRAMES, 2, 2);
/// Mode of a block of 8x8 pixels.
pub const MODE: Family = Family::after(FRAME, BLOCK_STATES * BLOCK_STATES * PASTS, MODES, 40);
/// Mode of a block of 4x4 pixels.
pub const SMALL_MODE: Family = Family::after(MODE, EDGES * EDGES * FRAMES, SMALL_MODES, 16);
/// Class and sign of a number of a plane's change.
pub const CHANGE: Family = Family::after(SMALL_MODE, 2 * CHANGES, 15, 12);
/// Symbol of a pixel.
pub const PIXEL: Family = Family::after(CHANGE, CLASSES * CLASSES * RIGHT_GROUPS * FRAMES, SYMBOLS, 96);
/// Class of the magnitude of an escape.
pub const ESCAPE: Family = Family::after(PIXEL, ESCAPES, 16, 20);
/// Class of the magnitude of the residual on another surface.
pub const CANDIDATE: Family = Family::after(ESCAPE, CANDIDATES, 16, CANDIDATES);

pub const FAMILIES: [Family; 7] = [FRAME, MODE, SMALL_MODE, CHANGE, PIXEL, ESCAPE, CANDIDATE];
pub const CONTEXTS: usize = CANDIDATE.first_context + CANDIDATE.contexts;
pub const CLUSTERS: usize = CANDIDATE.first_cluster + CANDIDATE.clusters;
/// Number of symbol values of each cluster.
pub const ALPHABETS: [u8; CLUSTERS] = Family::alphabets(&FAMILIES);

/// Returns the context of [`FRAME`]. `later` is 0 in the first frame of a chunk, 1 in all others.
pub fn frame(later: usize) -> usize {
    FRAME.first_context + later
}

/// Returns the context of [`MODE`]. `left` and `above` are the states of blocks of this frame, `past` is below [`PASTS`].
pub fn mode(left: usize, above: usize, past: usize) -> usize {
    MODE.first_context + (left * BLOCK_STATES + above) * PASTS + past
}

/// Returns the context of [`SMALL_MODE`]. `left` and `above` are the pixels at both ends of the left and the upper edge.
pub fn small_mode(left: [Pixel; 2], above: [Pixel; 2], later: usize) -> usize {
    SMALL_MODE.first_context + (edge(left) * EDGES + edge(above)) * FRAMES + later
}

fn edge([first, last]: [Pixel; 2]) -> usize {
    if first.is_background() || last.is_background() {
        2
    } else if first.is_settled() && last.is_settled() {
        0
    } else if first.is_as_predicted() && last.is_as_predicted() {
        1
    } else {
        3
    }
}

/// Returns the context of [`CHANGE`]. `number` 0 is the value, 1 and 2 are slopes; `before` is the previous number, 0 for the
/// value.
pub fn change(side: Side, number: usize, before: i32) -> usize {
    CHANGE.first_context + side as usize * CHANGES + 2 * number + usize::from(before != 0)
}

/// Returns the context of a pixel without the part of its left neighbour, which is decoded last.
#[inline(always)]
pub fn pixel_above(above: &Pixel, right: &Pixel, later: usize) -> usize {
    const GROUPS: [u8; CLASSES] = [1, 1, 0, 1, 1, 2, 2, 3, 4];
    PIXEL.first_context
        + (usize::from(above.class) * RIGHT_GROUPS + usize::from(GROUPS[usize::from(right.class)])) * FRAMES
        + later
}

#[inline(always)]
pub fn pixel(left: &Pixel, above: usize) -> usize {
    above + usize::from(left.class) * (CLASSES * RIGHT_GROUPS * FRAMES)
}

pub fn escape(left: &Pixel, above: &Pixel, right: &Pixel) -> usize {
    let most = left.magnitude.max(above.magnitude);
    let least = u32::from(left.magnitude.min(above.magnitude));
    let level = if most == 0 { 0 } else { (8 - most.leading_zeros() + u32::from(right.magnitude > most)).min(11) };
    let most = u32::from(most);
    let balance = match least {
        least if 2 * least > most => 2,
        least if 8 * least > most => 1,
        _ => 0,
    };
    ESCAPE.first_context + (level * 3 + balance) as usize
}

pub fn candidate(which: usize) -> usize {
    CANDIDATE.first_context + which
}

/// Number of built-in table sets.
pub const BUILT_IN: usize = 9;

static FORMAT: BuiltIn<CONTEXTS, CLUSTERS, BUILT_IN> =
    BuiltIn::parse(include_bytes!(concat!(env!("LIGHTFOLD_FORMATS"), "/depth-tables.txt")), &FAMILIES, &ALPHABETS);

static CLUSTER_OF: [u8; CONTEXTS] = FORMAT.cluster_of;

/// Entropy model of predictive depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Predictive;

pub type TableSet = entropy::TableSet<Predictive>;
pub type Tables = entropy::Tables<Predictive>;

impl Model for Predictive {
    const TITLE: &'static str = "Entropy tables of predictive depth (depth.md 15.8)";
    const FILE: &'static str = "formats/depth-tables.txt";
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
