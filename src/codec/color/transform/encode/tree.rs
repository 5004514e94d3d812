//! Tree of the blocks of a region, as it will be written.

use crate::color::transform::blocks::{Block, Shape};
use crate::color::transform::coder::Coder;
use crate::color::transform::contexts::{self, Position};
use crate::color::transform::domain::CHANNELS;
use crate::color::transform::levels::{History, Levels};
use crate::color::transform::palette::{Color, ColorCache, Palette};
use crate::color::transform::region::{PALETTE, PARTS, QUARTERS, TRANSFORM};
use crate::color::transform::scan;

#[derive(Debug, Clone)]
pub enum Tree {
    Transform(Block, BlockLevels),
    Palette(Block, Palette),
    Quarters(Block, Vec<Tree>),
    Parts(Block, Vec<Tree>),
}

/// Levels of a block by channel, plane and row.
#[derive(Debug, Clone)]
pub struct BlockLevels {
    shape: Shape,
    values: [Vec<i32>; CHANNELS],
    planes: [usize; CHANNELS],
}

impl BlockLevels {
    /// `values` has the levels of all planes of each channel.
    pub fn new(shape: Shape, values: [Vec<i32>; CHANNELS]) -> BlockLevels {
        let planes = values.each_ref().map(|values| {
            let empty = values.rchunks_exact(shape.pixels()).take_while(|plane| plane.iter().all(|&level| level == 0));
            shape.frames - empty.count()
        });
        BlockLevels { shape, values, planes }
    }

    fn plane(&self, channel: usize, plane: usize) -> &[i32] {
        &self.values[channel][plane * self.shape.pixels()..][..self.shape.pixels()]
    }
}

impl Levels for &BlockLevels {
    fn planes(&self, channel: usize) -> usize {
        self.planes[channel]
    }

    fn last(&self, channel: usize, plane: usize) -> Option<usize> {
        let (levels, side) = (self.plane(channel, plane), self.shape.side());
        scan::order(self.shape.level).iter().rposition(|position| levels[position.y() * side + position.x()] != 0)
    }

    fn get(&self, channel: usize, plane: usize, position: Position) -> i32 {
        self.plane(channel, plane)[position.y() * self.shape.side() + position.x()]
    }

    fn put(&mut self, _: usize, _: usize, _: Position, _: i32) {}
}

impl Tree {
    pub fn block(&self) -> Block {
        match self {
            Tree::Transform(block, _) | Tree::Palette(block, _) | Tree::Quarters(block, _) | Tree::Parts(block, _) => {
                *block
            }
        }
    }

    /// Codes the region's symbols.
    pub fn code(&self, coder: &mut impl Coder, cache: &mut ColorCache, key_bits: u32) {
        self.code_node(coder, &mut History::default(), cache, key_bits);
    }

    fn code_node(&self, coder: &mut impl Coder, history: &mut History, cache: &mut ColorCache, key_bits: u32) {
        let shape = self.block().shape;
        let kind = match self {
            Tree::Transform(..) => TRANSFORM,
            Tree::Palette(..) => PALETTE,
            Tree::Quarters(..) => QUARTERS,
            Tree::Parts(..) => PARTS,
        };
        coder.symbol(contexts::node(shape), kind);
        match self {
            Tree::Transform(_, levels) => history.code(coder, shape, &mut &*levels),
            Tree::Palette(_, palette) => palette.clone().code(coder, shape, cache, key_bits),
            Tree::Quarters(_, children) | Tree::Parts(_, children) => {
                children.iter().for_each(|child| child.code_node(coder, history, cache, key_bits));
            }
        }
    }

    /// Calls `each` for the colours of every palette.
    pub fn for_each_palette(&self, each: &mut impl FnMut(&[Color])) {
        match self {
            Tree::Transform(..) => {}
            Tree::Palette(_, palette) => each(&palette.colors),
            Tree::Quarters(_, children) | Tree::Parts(_, children) => {
                children.iter().for_each(|child| child.for_each_palette(each));
            }
        }
    }
}
