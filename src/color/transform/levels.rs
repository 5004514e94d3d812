//! Transformed blocks: levels of each channel, plane by plane, from the last one back (color.md 6.6).

use crate::color::transform::blocks::Shape;
use crate::color::transform::coder::Coder;
use crate::color::transform::contexts::{self, PlaneContext, Position};
use crate::color::transform::domain::CHANNELS;
use crate::color::transform::scan::{self, Magnitudes};

/// The levels of a block: those to write, or a place for those that are read.
pub trait Levels {
    /// Planes of a channel up to the last that has levels.
    fn planes(&self, channel: usize) -> usize;

    /// Index in the scan of a plane's last level other than 0.
    fn last(&self, channel: usize, plane: usize) -> Option<usize>;

    fn get(&self, channel: usize, plane: usize, position: Position) -> i32;

    /// Notes a level other than 0.
    fn put(&mut self, channel: usize, plane: usize, position: Position, level: i32);
}

/// Magnitudes that contexts look at.
#[derive(Debug, Default)]
pub struct History {
    /// Of this plane.
    plane: Magnitudes,
    /// Of the plane before; for a channel's first, the greatest of the first planes of the channels before.
    other: Magnitudes,
    channels: Magnitudes,
}

impl History {
    pub fn code(&mut self, coder: &mut impl Coder, shape: Shape, levels: &mut impl Levels) {
        let mut before = 0;
        // The greatest class of the last position in the first planes of the channels before.
        let mut first_class = 0;
        self.channels.clear(shape.side());
        for channel in 0..CHANNELS {
            let context = contexts::planes(channel, shape, before);
            let planes = coder.number(context, levels.planes(channel) as u32).min(shape.frames as u32) as usize;
            if channel == 0 || planes > 0 {
                before = planes.min(2);
            }
            let mut coded = false;
            let mut class_before = first_class;
            for plane in 0..planes {
                if plane == 0 {
                    self.other.clone_from(&self.channels);
                } else {
                    std::mem::swap(&mut self.plane, &mut self.other);
                }
                self.plane.clear(shape.side());
                let context = PlaneContext::new(channel, shape, plane);
                let last = levels.last(channel, plane);
                coded = plane + 1 == planes || coder.flag(context.coded(coded), last.is_some());
                class_before = if coded {
                    let last = code_last(coder, (&context, class_before), shape, last.unwrap_or(0));
                    self.code_plane(coder, &context, shape, last, &mut PlaneLevels { levels, channel, plane });
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

    #[inline(always)]
    fn code_plane<L: Levels>(
        &mut self,
        coder: &mut impl Coder,
        context: &PlaneContext,
        shape: Shape,
        last: usize,
        levels: &mut PlaneLevels<'_, L>,
    ) {
        for (at, &position) in scan::order(shape.level)[..=last].iter().enumerate().rev() {
            let level = levels.get(position);
            let other = self.other.get(position);
            let magnitude = if at == last {
                coder.number(context.last_level(position, other), level.unsigned_abs().wrapping_sub(1)) + 1
            } else {
                coder.number(context.level(position, self.plane.sum(position), other), level.unsigned_abs())
            };
            if magnitude > 0 {
                let negative = coder.bits(u32::from(level < 0), 1) == 1;
                levels.put(position, if negative { -(magnitude as i32) } else { magnitude as i32 });
                self.plane.set(position, magnitude);
                if levels.plane == 0 {
                    self.channels.raise(position, magnitude);
                }
            }
        }
    }
}

struct PlaneLevels<'a, L> {
    levels: &'a mut L,
    channel: usize,
    plane: usize,
}

impl<L: Levels> PlaneLevels<'_, L> {
    #[inline(always)]
    fn get(&self, position: Position) -> i32 {
        self.levels.get(self.channel, self.plane, position)
    }

    #[inline(always)]
    fn put(&mut self, position: Position, level: i32) {
        self.levels.put(self.channel, self.plane, position, level);
    }
}

/// Codes the scan index of a plane's last level: its logarithm, two bits, and the rest raw.
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

/// Levels of blocks as they are read: only those other than 0, in the order of coding.
#[derive(Debug)]
pub struct SparseLevels {
    pub levels: Vec<Level>,
}

impl SparseLevels {
    /// The list never grows: a substream that has more levels is shorter than its symbols say, and refused.
    pub fn with_capacity(most: usize) -> SparseLevels {
        SparseLevels { levels: Vec::with_capacity(most) }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Level {
    /// As it was read; once its block is, the coefficient.
    pub value: i32,
    pub position: Position,
    pub plane: u8,
    pub channel: u8,
}

impl Level {
    /// Whether it is the constant one of the first plane, which is coded as a difference.
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
