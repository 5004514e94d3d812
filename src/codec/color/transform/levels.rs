//! Levels of transformed blocks: those of each channel, plane by plane, from the last level back (color.md 6.6).

use crate::color::transform::blocks::Shape;
use crate::color::transform::coder::Coder;
use crate::color::transform::contexts::{self, PlaneContext, Position};
use crate::color::transform::domain::CHANNELS;
use crate::color::transform::scan::{self, Magnitudes};

/// Levels of a block: those to write, or storage for those that are read.
pub trait Levels {
    /// Number of planes of a channel, up to the last that has levels.
    fn planes(&self, channel: usize) -> usize;

    /// Scan index of a plane's last level other than 0.
    fn last(&self, channel: usize, plane: usize) -> Option<usize>;

    fn get(&self, channel: usize, plane: usize, position: Position) -> i32;

    /// Stores a level other than 0.
    fn put(&mut self, channel: usize, plane: usize, position: Position, level: i32);
}

/// Magnitudes that contexts depend on.
#[derive(Debug, Default)]
pub struct History {
    /// Two planes of a channel, used alternately: the current one and the one before it.
    planes: [Magnitudes; 2],
    /// Maximum magnitudes of the first planes of the channels so far.
    channels: Magnitudes,
}

impl History {
    pub fn code(&mut self, coder: &mut impl Coder, shape: Shape, levels: &mut impl Levels) {
        let mut planes_before = 0;
        // Maximum class of the last position in the first planes of the channels before.
        let mut first_class = 0;
        self.channels.clear(shape.side());
        for channel in 0..CHANNELS {
            let context = contexts::planes(channel, shape, planes_before);
            let planes = coder.number(context, levels.planes(channel) as u32).min(shape.frames as u32) as usize;
            if channel == 0 || planes > 0 {
                planes_before = planes.min(2);
            }
            let mut coded = false;
            let mut class_before = first_class;
            for plane in 0..planes {
                let context = PlaneContext::new(channel, shape, plane);
                let [even, odd] = &mut self.planes;
                let (magnitudes, before) = if plane % 2 == 0 { (even, odd) } else { (odd, even) };
                magnitudes.clear(shape.side());
                let last = levels.last(channel, plane);
                coded = plane + 1 == planes || coder.flag(context.coded(coded), last.is_some());
                class_before = if coded {
                    let last = code_last(coder, (&context, class_before), shape, last.unwrap_or(0));
                    let other = if plane == 0 { &mut self.channels } else { before };
                    let positions = &scan::order(shape.level)[..=last];
                    PlaneCoder { context, levels, channel, plane, magnitudes, other }.code(coder, positions);
                    contexts::last_class(Some(last))
                } else {
                    0
                };
                if plane == 0 {
                    first_class = first_class.max(class_before);
                }
            }
        }
    }
}

/// Codes the levels of a plane.
struct PlaneCoder<'a, L> {
    context: PlaneContext,
    levels: &'a mut L,
    channel: usize,
    plane: usize,
    magnitudes: &'a mut Magnitudes,
    /// Magnitudes of the plane before; for a channel's first plane, the maximum of the first planes of the channels so far.
    other: &'a mut Magnitudes,
}

impl<L: Levels> PlaneCoder<'_, L> {
    /// `positions` are in scan order and end with the last level other than 0, which is coded first.
    #[inline(always)]
    fn code(mut self, coder: &mut impl Coder, positions: &[Position]) {
        let Some((&last, positions)) = positions.split_last() else { return };
        let context = self.context.last_level(last, self.other.get(last));
        let level = self.levels.get(self.channel, self.plane, last);
        let magnitude = coder.number(context, level.unsigned_abs().wrapping_sub(1)) + 1;
        self.code_sign(coder, last, level, magnitude);
        for &position in positions.iter().rev() {
            let (sum, other) = (self.magnitudes.sum(position), self.other.get(position));
            let level = self.levels.get(self.channel, self.plane, position);
            let magnitude = coder.number(self.context.level(position, sum, other), level.unsigned_abs());
            if magnitude > 0 {
                self.code_sign(coder, position, level, magnitude);
            }
        }
    }

    #[inline(always)]
    fn code_sign(&mut self, coder: &mut impl Coder, position: Position, level: i32, magnitude: u32) {
        let negative = coder.bits(u32::from(level < 0), 1) == 1;
        let level = if negative { -(magnitude as i32) } else { magnitude as i32 };
        self.levels.put(self.channel, self.plane, position, level);
        self.magnitudes.set(position, magnitude);
        if self.plane == 0 {
            self.other.raise(position, magnitude);
        }
    }
}

/// Codes the scan index of a plane's last level: its logarithm, two bits, and the remaining bits raw.
fn code_last(
    coder: &mut impl Coder,
    (context, class_before): (&PlaneContext, usize),
    shape: Shape,
    last: usize,
) -> usize {
    let class = coder.symbol(context.last(class_before), (last + 1).ilog2() as usize);
    let (high_bits, value) = (class.min(2), (last + 1).wrapping_sub(1 << class));
    let low_bits = class - high_bits;
    let mut index = 1usize;
    if class > 0 {
        let high = coder.symbol(context.last_bits(class), value >> low_bits & 3);
        let low = coder.bits((value & ((1 << low_bits) - 1)) as u32, low_bits as u32);
        index = 1 << class | (high & ((1 << high_bits) - 1)) << low_bits | low as usize;
    }
    (index - 1).min(shape.pixels() - 1)
}

/// Levels of blocks that are read: only those other than 0, in coding order.
#[derive(Debug)]
pub struct SparseLevels {
    pub levels: Vec<Level>,
}

impl SparseLevels {
    /// The list never grows: a substream with more levels is too short for its symbols, and is refused.
    pub fn with_capacity(most: usize) -> SparseLevels {
        SparseLevels { levels: Vec::with_capacity(most) }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Level {
    /// The level as it was read; the coefficient once the block is complete.
    pub value: i32,
    pub position: Position,
    pub plane: u8,
    pub channel: u8,
}

impl Level {
    /// True for the constant level of the first plane, which is coded as a difference.
    #[inline(always)]
    pub fn is_mean(&self) -> bool {
        self.plane == 0 && self.position.0 == 0
    }
}

impl Levels for SparseLevels {
    fn planes(&self, _: usize) -> usize {
        0
    }

    fn last(&self, _: usize, _: usize) -> Option<usize> {
        None
    }

    fn get(&self, _: usize, _: usize, _: Position) -> i32 {
        0
    }

    #[inline(always)]
    fn put(&mut self, channel: usize, plane: usize, position: Position, value: i32) {
        if self.levels.len() < self.levels.capacity() {
            self.levels.push(Level { value, position, plane: plane as u8, channel: channel as u8 });
        }
    }
}
