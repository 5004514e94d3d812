//! Reads the substream of a region: a tree of blocks in space and time (color.md 6.4 to 6.8).

use std::ops::Range;

use crate::color::transform::basis::{MAX_LENGTH, length_index};
use crate::color::transform::blocks::{Block, LEAST};
use crate::color::transform::coder::{Reader, SourceCoder};
use crate::color::transform::contexts;
use crate::color::transform::domain::{self, CHANNELS, Domain};
use crate::color::transform::levels::{History, Level, SparseLevels};
use crate::color::transform::means::Means;
use crate::color::transform::palette::{ColorCache, Palette};
use crate::color::transform::payload::{Header, SECTION};
use crate::color::transform::steps::Steps;
use crate::color::transform::tables::TableSet;
use crate::entropy;
use crate::error::{Error, Result};

/// Kinds of nodes.
pub const TRANSFORM: usize = 0;
pub const QUARTERS: usize = 1;
pub const PARTS: usize = 2;
pub const PALETTE: usize = 3;

/// A block without children.
#[derive(Debug)]
pub struct Leaf {
    pub block: Block,
    pub content: Content,
}

#[derive(Debug)]
pub enum Content {
    Transform {
        channels: [ChannelLevels; CHANNELS],
        /// Whether all frames are one picture.
        still: bool,
    },
    /// Index among the region's.
    Palette(usize),
}

/// Levels of a channel of a block.
#[derive(Debug, Clone, Default)]
pub struct ChannelLevels {
    /// Where they are among the region's.
    pub levels: Range<usize>,
    /// Predicted level of the mean.
    pub predicted: i32,
    /// Columns and rows of spatial frequencies that have levels, at least 1.
    pub extent: [usize; 2],
}

/// A region as it was read.
#[derive(Debug, Default)]
pub struct Region {
    pub leaves: Vec<Leaf>,
    pub levels: Vec<Level>,
    pub palettes: Vec<Palette>,
}

impl Region {
    /// Reads a whole substream; `at` is its offset in the payload.
    pub fn read(
        substream: (&[u8], usize),
        root: Block,
        header: &Header,
        tables: &TableSet,
        domain: &Domain,
    ) -> Result<Region> {
        let (bytes, at) = substream;
        let coder = Reader { stream: entropy::Decoder::new(bytes), tables };
        Region::read_by(coder, root, header, domain).map_err(|message| Error::invalid_at(SECTION, at as u64, message))
    }

    /// As [`Region::read`], by any coder.
    pub fn read_by<C: SourceCoder>(
        coder: C,
        root: Block,
        header: &Header,
        domain: &Domain,
    ) -> Result<Region, &'static str> {
        let mut reader = RegionReader {
            coder,
            header,
            domain,
            steps: Steps::new(header.steps, domain),
            means: Means::default(),
            cache: ColorCache::new(&header.colors),
            history: History::default(),
            levels: SparseLevels::default(),
            region: Region::default(),
            illegal: None,
        };
        reader.node(root);
        match reader.illegal {
            Some(message) => Err(message),
            None if !reader.coder.is_finished() => Err("a region's substream does not end where its symbols do"),
            None => Ok(Region { levels: reader.levels.levels, ..reader.region }),
        }
    }
}

struct RegionReader<'a, C> {
    coder: C,
    header: &'a Header,
    domain: &'a Domain,
    steps: Steps,
    means: Means,
    cache: ColorCache,
    history: History,
    levels: SparseLevels,
    region: Region,
    illegal: Option<&'static str>,
}

impl<C: SourceCoder> RegionReader<'_, C> {
    fn node(&mut self, block: Block) {
        // What follows the end of a substream that is too short is not worth reading.
        if self.illegal.is_some() || self.coder.is_short() {
            return;
        }
        match (self.coder.symbol(contexts::node(block.shape), 0), length_index(block.shape.frames)) {
            (TRANSFORM, Some(length)) => self.transform(block, length),
            (QUARTERS, _) if block.shape.level > 0 => {
                block.quarters().into_iter().for_each(|quarter| self.node(quarter));
            }
            (PARTS, _) if block.shape.frames > 1 => block.parts().for_each(|part| self.node(part)),
            (PALETTE, _) => self.palette(block),
            _ => self.illegal = Some("a block is split or transformed as its size does not allow"),
        }
    }

    fn transform(&mut self, block: Block, length: usize) {
        let first = self.levels.levels.len();
        self.history.code(&mut self.coder, block.shape, &mut self.levels);
        let levels = &self.levels.levels;
        let mut channels: [ChannelLevels; CHANNELS] = Default::default();
        let mut end = first;
        for (channel, of) in channels.iter_mut().enumerate() {
            let start = end;
            let mut constant = [0; MAX_LENGTH];
            of.extent = [1, 1];
            while let Some(level) = levels.get(end).filter(|level| usize::from(level.channel) == channel) {
                if level.position.0 == 0 {
                    constant[usize::from(level.plane)] = level.value;
                }
                of.extent = [of.extent[0].max(level.position.x() + 1), of.extent[1].max(level.position.y() + 1)];
                end += 1;
            }
            of.levels = start..end;
            let step = self.steps.step(channel, length);
            of.predicted = self.means.predict(channel, block, step);
            constant[0] = of.predicted.wrapping_add(constant[0]);
            self.means.set_block(channel, block, &constant[..block.shape.frames], step);
        }
        let still = levels[first..].iter().all(|level| level.plane == 0);
        self.region.leaves.push(Leaf { block, content: Content::Transform { channels, still } });
    }

    fn palette(&mut self, block: Block) {
        let mut palette = Palette::default();
        palette.code(&mut self.coder, block.shape, &mut self.cache, self.domain.key_bits);
        if palette.indices.iter().any(|&index| usize::from(index) >= palette.colors.len()) {
            self.illegal = Some("a pixel names a colour that its palette does not have");
        }
        note_palette(&palette, block, self.header, self.domain, &mut self.means);
        self.region.leaves.push(Leaf { block, content: Content::Palette(self.region.palettes.len()) });
        self.region.palettes.push(palette);
    }
}

/// Notes the means of a palette's last frame (color.md 6.5).
pub fn note_palette(palette: &Palette, block: Block, header: &Header, domain: &Domain, means: &mut Means) {
    let side = block.shape.side();
    let indices = palette.frame(block.shape, block.shape.frames - 1);
    for (y, x) in (0..side).step_by(LEAST).flat_map(|y| (0..side).step_by(LEAST).map(move |x| (y, x))) {
        let mut sums = [0; 3];
        for at in (y..y + LEAST).flat_map(|y| (x..x + LEAST).map(move |x| y * side + x)) {
            let index = indices.map_or(0, |indices| usize::from(indices[at]));
            let color = palette.colors.get(index).copied().unwrap_or_default();
            sums.iter_mut().zip(color).for_each(|(sum, key)| *sum += key);
        }
        let keys = sums.map(|sum| (sum + 8) >> 4);
        let means_of_square =
            domain::forward(keys, header.slopes, domain).map(|value| value.wrapping_shl(domain.fraction_bits));
        means.set_square([block.place.x + x, block.place.y + y], means_of_square);
    }
}
