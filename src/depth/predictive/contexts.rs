//! Contexts of symbols (depth.md 15.7): which distribution codes a symbol, from symbols that are decoded already.

use crate::depth::predictive::modes::{BLOCK_STATES, MODES, SMALL_MODES};
use crate::depth::predictive::pixel::{CLASSES, Pixel, SYMBOLS};
use crate::depth::predictive::plane::Side;
use crate::entropy::Family;

/// Kinds of frames: the first of a chunk, later ones.
const FRAMES: usize = 2;
/// Groups of classes of the pixel above on the right.
const RIGHT_GROUPS: usize = 5;
/// What is known of a block's past: nothing in a first frame; coded by pixels; all else.
pub const PASTS: usize = 3;
/// Contexts of the class of an escape: 12 of the largest magnitude beside it, 3 of the other.
const ESCAPES: usize = 36;
/// Symbols of a pixel other than its predecessor's code.
pub const CANDIDATES: usize = 3;
/// Numbers of a plane's change: value, horizontal slope, vertical slope; whether the one before is 0.
const CHANGES: usize = 6;
/// Kinds of edges of a small block: of a plane that goes on, of other planes, with background, else.
const EDGES: usize = 4;

/// Whether a frame differs from the one before.
pub const FRAME: Family = Family::first(FRAMES, 2, 2);
/// Mode of a block of 8x8 pixels.
pub const MODE: Family = Family::after(FRAME, BLOCK_STATES * BLOCK_STATES * PASTS, MODES, 40);
/// Mode of a block of 4x4 pixels.
pub const SMALL_MODE: Family = Family::after(MODE, EDGES * EDGES * FRAMES, SMALL_MODES, 16);
/// Class of a number of a plane's change.
pub const CHANGE: Family = Family::after(SMALL_MODE, 2 * CHANGES, 15, 12);
/// Symbol of a pixel.
pub const PIXEL: Family = Family::after(CHANGE, CLASSES * CLASSES * RIGHT_GROUPS * FRAMES, SYMBOLS, 96);
/// Class of an escape's magnitude.
pub const ESCAPE: Family = Family::after(PIXEL, ESCAPES, 16, 20);
/// Class of the residual of another surface.
pub const CANDIDATE: Family = Family::after(ESCAPE, CANDIDATES, 16, CANDIDATES);

pub const FAMILIES: [Family; 7] = [FRAME, MODE, SMALL_MODE, CHANGE, PIXEL, ESCAPE, CANDIDATE];
pub const CONTEXTS: usize = CANDIDATE.first_context + CANDIDATE.contexts;
pub const CLUSTERS: usize = CANDIDATE.first_cluster + CANDIDATE.clusters;
/// Values of symbols of each cluster.
pub const ALPHABETS: [u8; CLUSTERS] = Family::alphabets(&FAMILIES);

/// `later` is 0 in the first frame of a chunk, 1 in all others.
pub fn frame(later: usize) -> usize {
    FRAME.first_context + later
}

/// `left` and `above` are states of blocks of this frame, `past` is below [`PASTS`].
pub fn mode(left: usize, above: usize, past: usize) -> usize {
    MODE.first_context + (left * BLOCK_STATES + above) * PASTS + past
}

/// `left` and `above` are pairs of pixels at both ends of an edge.
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

/// `number` 0 is the value, 1 and 2 are slopes.
pub fn change(side: Side, number: usize, before: i32) -> usize {
    CHANGE.first_context + side as usize * CHANGES + 2 * number + usize::from(before != 0)
}

/// The context of a pixel without its left neighbour, which is the last to be known.
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
