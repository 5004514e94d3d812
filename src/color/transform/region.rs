//! Reads the substream of a region: a tree of blocks in space and time (color.md 6.4 to 6.8).

use std::ops::Range;

use crate::color::transform::basis::{MAX_LENGTH, length_index};
use crate::color::transform::blocks::{Block, LEAST, Place, Shape, padded_pixels, regions};
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

/// Blocks without children, and colours of their palettes, that a region may have whatever the size of its substream.
pub const FREE_ITEMS: u64 = 64;
/// Those that it may have for each byte of its substream on top (color.md 6.4): symbols can take no bits.
pub const ITEMS_A_BYTE: u64 = 8;

/// Leaves and colours that a substream may have.
pub fn most_items(substream: &[u8]) -> u64 {
    FREE_ITEMS + ITEMS_A_BYTE * substream.len() as u64
}

/// A block without children, in few bytes.
#[derive(Debug)]
pub struct Leaf {
    /// Column, row and first frame.
    place: [u8; 3],
    level: u8,
    frames: u8,
    pub content: Content,
}

impl Leaf {
    fn new(Block { place, shape }: Block, content: Content) -> Leaf {
        // A region has at most 32 columns, 32 rows and 96 frames.
        let place = [place.x as u8, place.y as u8, place.frame as u8];
        Leaf { place, level: shape.level as u8, frames: shape.frames as u8, content }
    }

    pub fn block(&self) -> Block {
        let [x, y, frame] = self.place.map(usize::from);
        Block { place: Place { x, y, frame }, shape: Shape { level: self.level.into(), frames: self.frames.into() } }
    }
}

#[derive(Debug)]
pub enum Content {
    Transform {
        channels: [ChannelLevels; CHANNELS],
        /// Whether all frames are one picture.
        still: bool,
    },
    /// Index among the region's.
    Palette(u32),
}

/// Levels of a channel of a block.
#[derive(Debug, Clone, Default)]
pub struct ChannelLevels {
    /// Where they are among the region's.
    levels: Range<u32>,
    /// Predicted level of the mean.
    pub predicted: i32,
    extent: [u8; 2],
}

impl ChannelLevels {
    pub fn of<'a>(&self, region: &'a Region) -> &'a [Level] {
        &region.levels[self.levels.start as usize..self.levels.end as usize]
    }

    /// Columns and rows of spatial frequencies that have levels, at least 1.
    pub fn extent(&self) -> [usize; 2] {
        self.extent.map(usize::from)
    }
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
        Region::read_by(coder, most_items(bytes), root, header, domain)
            .map_err(|message| Error::invalid_at(SECTION, at as u64, message))
    }

    /// As [`Region::read`], by any coder, at most so many leaves and colours.
    pub fn read_by<C: SourceCoder>(
        coder: C,
        most_items: u64,
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
            items_left: most_items,
            illegal: None,
        };
        reader.node(root);
        match reader.illegal {
            Some(message) => Err(message),
            None if !reader.coder.is_finished() => Err("a region's substream does not end where its symbols do"),
            None => {
                let mut region = Region { levels: reader.levels.levels, ..reader.region };
                region.leaves.shrink_to_fit();
                region.levels.shrink_to_fit();
                region.palettes.shrink_to_fit();
                Ok(region)
            }
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
    items_left: u64,
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

    fn take_items(&mut self, count: usize) {
        match self.items_left.checked_sub(count as u64) {
            Some(left) => self.items_left = left,
            None => self.illegal = Some("a region has more blocks and colours than its substream justifies"),
        }
    }

    fn transform(&mut self, block: Block, length: usize) {
        self.take_items(1);
        let first = self.levels.levels.len();
        self.history.code(&mut self.coder, block.shape, &mut self.levels);
        let levels = &self.levels.levels;
        let mut channels: [ChannelLevels; CHANNELS] = Default::default();
        let mut end = first;
        for (channel, of) in channels.iter_mut().enumerate() {
            let start = end;
            let mut constant = [0; MAX_LENGTH];
            let mut extent = [1, 1];
            while let Some(level) = levels.get(end).filter(|level| usize::from(level.channel) == channel) {
                if level.position.0 == 0 {
                    constant[usize::from(level.plane)] = level.value;
                }
                extent = [extent[0].max(level.position.x() + 1), extent[1].max(level.position.y() + 1)];
                end += 1;
            }
            of.extent = extent.map(|frequencies: usize| frequencies as u8);
            of.levels = start as u32..end as u32;
            let step = self.steps.step(channel, length);
            of.predicted = self.means.predict(channel, block, step);
            constant[0] = of.predicted.wrapping_add(constant[0]);
            self.means.set_block(channel, block, &constant[..block.shape.frames], step);
        }
        let still = levels[first..].iter().all(|level| level.plane == 0);
        self.region.leaves.push(Leaf::new(block, Content::Transform { channels, still }));
    }

    fn palette(&mut self, block: Block) {
        let mut palette = Palette::default();
        palette.code(&mut self.coder, block.shape, &mut self.cache, self.domain.key_bits);
        self.take_items(1 + palette.colors.len());
        if palette.indices.iter().any(|&index| usize::from(index) >= palette.colors.len()) {
            self.illegal = Some("a pixel names a colour that its palette does not have");
        }
        note_palette(&palette, block, self.header, self.domain, &mut self.means);
        self.region.leaves.push(Leaf::new(block, Content::Palette(self.region.palettes.len() as u32)));
        self.region.palettes.push(palette);
    }
}

/// Bytes of a leaf, or of a palette with one colour or a colour more, in memory of its own.
const ITEM_BYTES: u64 = 80;
const LEVEL_BYTES: u64 = size_of::<Level>() as u64;
/// Bytes of a leaf with a palette of sixteen colours.
const MOST_LEAF_BYTES: u64 = 336;

/// Upper bound of the bytes that a chunk of `frames` frames of a cell of `size` pixels holds with its payload, when it is parsed.
pub fn held_bytes(payload_bytes: u64, size: [usize; 2], frames: u32) -> u64 {
    let regions = regions(size).len() as u64;
    let pixels = padded_pixels(size) * u64::from(frames);
    let items = FREE_ITEMS * regions + payload_bytes.saturating_mul(ITEMS_A_BYTE);
    // A level takes a bit for its sign.
    let by_payload = items.saturating_mul(ITEM_BYTES).saturating_add(payload_bytes.saturating_mul(8 * LEVEL_BYTES));
    let squares = pixels / (LEAST * LEAST) as u64;
    let by_pixels = squares * MOST_LEAF_BYTES + CHANNELS as u64 * pixels * LEVEL_BYTES;
    // An index of a palette for each pixel.
    by_payload.min(by_pixels) + pixels + regions * size_of::<Region>() as u64 + payload_bytes
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parsed_chunks_take_what_is_said_of_them() {
        let palette = (size_of::<Palette>() + 2 * 16) as u64;
        let color = size_of::<crate::color::transform::palette::Color>() as u64;
        assert!(size_of::<Leaf>() as u64 <= ITEM_BYTES);
        assert!(size_of::<Leaf>() as u64 + palette + color <= 2 * ITEM_BYTES && color <= ITEM_BYTES);
        assert!(size_of::<Leaf>() as u64 + palette + 16 * color <= MOST_LEAF_BYTES);
        assert!(size_of::<Region>() <= 100);
        let of = |bytes, size, frames| held_bytes(bytes, size, frames);
        assert_eq!(of(1000, [64, 64], 24), 704 * 1000 + 5120 * 4 + 1000 + 4 * size_of::<Region>() as u64 + 24 * 4096);
        assert_eq!(of(1 << 20, [64, 64], 24), 45 * 24 * 4096 + (1 << 20) + 4 * size_of::<Region>() as u64 + 24 * 4096);
    }
}
