//! Reads the substream of a region: a tree of blocks in space and time (color.md 6.4 to 6.8).

use std::ops::Range;

use crate::color::transform::basis::{MAX_LENGTH, length_index};
use crate::color::transform::blocks::{Block, MIN_SIDE, Place, REGION, Shape, padded_pixels, regions};
use crate::color::transform::coder::{Reader, SourceCoder};
use crate::color::transform::contexts;
use crate::color::transform::contexts::TableSet;
use crate::color::transform::domain::{self, CHANNELS, Domain};
use crate::color::transform::levels::{History, Level, SparseLevels};
use crate::color::transform::means::Means;
use crate::color::transform::palette::{ColorCache, Palette};
use crate::color::transform::payload::{Header, SECTION};
use crate::color::transform::steps::Steps;
use crate::entropy;
use crate::error::{Error, Result};

/// Kinds of nodes.
pub const TRANSFORM: usize = 0;
pub const QUARTERS: usize = 1;
pub const PARTS: usize = 2;
pub const PALETTE: usize = 3;

/// Number of leaves, and of colours of their palettes, that a region may have regardless of the size of its substream.
pub const FREE_ITEMS: u64 = 64;
/// Additional leaves and colours per byte of the substream (color.md 6.4). Symbols may take no bits, so a limit is needed.
pub const ITEMS_A_BYTE: u64 = 8;

/// Maximum number of leaves and colours of a substream.
pub fn max_items(substream: &[u8]) -> u64 {
    FREE_ITEMS + ITEMS_A_BYTE * substream.len() as u64
}

/// Maximum content of a region (color.md 6.4).
#[derive(Debug, Clone, Copy)]
struct MostContent {
    /// Leaves, and colours of palettes.
    items: u64,
    /// Levels other than 0.
    levels: u64,
}

impl MostContent {
    /// Each level takes at least one raw bit of the substream, for its sign.
    fn of_substream(bytes: &[u8]) -> MostContent {
        MostContent { items: max_items(bytes), levels: 8 * bytes.len() as u64 }
    }
}

/// A block without children, in compact form.
#[derive(Debug)]
pub struct Leaf {
    /// Column, row and first frame.
    place: [u8; 3],
    size_class: u8,
    frames: u8,
    pub content: Content,
}

impl Leaf {
    fn new(Block { place, shape }: Block, content: Content) -> Leaf {
        // A region has at most 32 columns, 32 rows and 96 frames.
        let place = [place.x as u8, place.y as u8, place.frame as u8];
        Leaf { place, size_class: shape.level as u8, frames: shape.frames as u8, content }
    }

    pub fn block(&self) -> Block {
        let [x, y, frame] = self.place.map(usize::from);
        Block {
            place: Place { x, y, frame },
            shape: Shape { level: self.size_class.into(), frames: self.frames.into() },
        }
    }
}

#[derive(Debug)]
pub enum Content {
    Transform {
        channels: [ChannelLevels; CHANNELS],
        /// True if all frames are the same picture.
        still: bool,
    },
    Palette(Box<Palette>),
}

/// Levels of a channel of a block.
#[derive(Debug, Clone, Default)]
pub struct ChannelLevels {
    /// Range of the levels among those of the region.
    levels: Range<u32>,
    /// Coefficient of the mean; the level that was coded for it is stored as 0.
    pub mean: i32,
    extent: [u8; 2],
}

impl ChannelLevels {
    pub fn of<'a>(&self, region: &'a Region) -> &'a [Level] {
        &region.levels[self.levels.start as usize..self.levels.end as usize]
    }

    /// Number of columns and rows of spatial frequencies with levels, at least 1.
    pub fn extent(&self) -> [usize; 2] {
        self.extent.map(usize::from)
    }
}

/// Parameters for reading a region.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    pub header: &'a Header,
    /// Delta of the region's step indices.
    pub delta: i8,
    pub domain: &'a Domain,
}

/// A parsed region.
#[derive(Debug, Default)]
pub struct Region {
    leaves: Leaves,
    levels: Vec<Level>,
}

/// Leaves in lists that are never reallocated, so that no leaf is held twice while more are read.
#[derive(Debug, Default)]
struct Leaves {
    lists: Vec<Vec<Leaf>>,
    count: usize,
}

impl Leaves {
    fn push(&mut self, leaf: Leaf) {
        self.count += 1;
        match self.lists.last_mut() {
            Some(list) if list.len() < list.capacity() => list.push(leaf),
            _ => {
                let mut list = Vec::with_capacity((self.count / SPARE_SHARE).max(MIN_LIST));
                list.push(leaf);
                self.lists.push(list);
            }
        }
    }
}

impl Region {
    pub fn leaves(&self) -> impl Iterator<Item = &Leaf> {
        self.leaves.lists.iter().flatten()
    }

    /// Levels other than 0 of all leaves.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Reads a complete substream; `at` is its offset in the payload.
    pub fn read(substream: (&[u8], usize), root: Block, setting: Setting<'_>, tables: &TableSet) -> Result<Region> {
        let (bytes, at) = substream;
        let coder = Reader { stream: entropy::Decoder::new(bytes), tables };
        let most = MostContent::of_substream(bytes);
        Region::read_within(coder, most, root, setting)
            .map_err(|message| Error::invalid_at(SECTION, at as u64, message))
    }

    /// As [`Region::read`], with any coder, and at most `max_items` leaves and colours.
    pub fn read_by<C: SourceCoder>(
        coder: C,
        max_items: u64,
        root: Block,
        setting: Setting<'_>,
    ) -> Result<Region, &'static str> {
        Region::read_within(coder, MostContent { items: max_items, levels: u64::MAX }, root, setting)
    }

    fn read_within<C: SourceCoder>(
        coder: C,
        most: MostContent,
        root: Block,
        Setting { header, delta, domain }: Setting<'_>,
    ) -> Result<Region, &'static str> {
        let pixels = (root.shape.pixels() * root.shape.frames) as u64;
        let max_levels = most.levels.min(CHANNELS as u64 * pixels) as usize;
        let mut reader = RegionReader {
            coder,
            header,
            domain,
            steps: Steps::new(header.steps, header.offset_set, delta, domain.steps),
            means: Means::default(),
            cache: ColorCache::new(&header.colors),
            history: History::default(),
            levels: SparseLevels::with_capacity(max_levels),
            leaves: Leaves::default(),
            items_left: most.items,
            illegal: None,
        };
        reader.node(root);
        match reader.illegal {
            Some(message) => Err(message),
            None if !reader.coder.is_finished() => Err("a region's substream does not end where its symbols do"),
            None => {
                let mut levels = reader.levels.levels;
                levels.shrink_to_fit();
                Ok(Region { leaves: reader.leaves, levels })
            }
        }
    }
}

#[cfg(test)]
impl Region {
    /// Overhead of an allocation in bytes.
    const ALLOCATION: usize = 16;

    /// Bytes that the region occupies, including the struct itself.
    pub fn allocated_bytes(&self) -> usize {
        let room = |count: usize, bytes: usize| if count == 0 { 0 } else { count * bytes + Region::ALLOCATION };
        let palette = |palette: &Palette| {
            let colors = room(palette.colors.capacity(), size_of::<[i32; 3]>());
            room(1, size_of::<Palette>()) + colors + room(palette.indices.capacity(), 1)
        };
        let palettes: usize = self.palettes().map(palette).sum();
        let lists = &self.leaves.lists;
        let leaves: usize = lists.iter().map(|list| room(list.capacity(), size_of::<Leaf>())).sum();
        let lists = room(lists.capacity(), size_of::<Vec<Leaf>>());
        size_of::<Region>() + palettes + leaves + lists + room(self.levels.capacity(), size_of::<Level>())
    }

    pub fn palettes(&self) -> impl Iterator<Item = &Palette> {
        self.leaves().filter_map(|leaf| match &leaf.content {
            Content::Palette(palette) => Some(&**palette),
            Content::Transform { .. } => None,
        })
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
    leaves: Leaves,
    items_left: u64,
    illegal: Option<&'static str>,
}

impl<C: SourceCoder> RegionReader<'_, C> {
    fn node(&mut self, block: Block) {
        // Nothing is read past the end of a substream that is too short.
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
        let levels = &mut self.levels.levels;
        let mut channels: [ChannelLevels; CHANNELS] = Default::default();
        let mut end = first;
        for (channel, of) in channels.iter_mut().enumerate() {
            let steps = self.steps.of(channel, block.shape.level, length);
            let start = end;
            let mut constant = [0; MAX_LENGTH];
            let mut extent = [1, 1];
            let mut mean_level = self.means.predict(channel, block, steps.at(0));
            while let Some(level) = levels.get_mut(end).filter(|level| usize::from(level.channel) == channel) {
                let [x, y] = [level.position.x(), level.position.y()];
                if level.is_mean() {
                    mean_level = mean_level.wrapping_add(level.value);
                    level.value = 0;
                }
                level.value = steps.coefficient(x + y, level.value);
                if level.position.0 == 0 {
                    constant[usize::from(level.plane)] = level.value;
                }
                extent = [extent[0].max(x + 1), extent[1].max(y + 1)];
                end += 1;
            }
            of.extent = extent.map(|frequencies: usize| frequencies as u8);
            of.levels = start as u32..end as u32;
            of.mean = steps.coefficient(0, mean_level);
            constant[0] = of.mean;
            self.means.set_block(channel, block, &constant[..block.shape.frames]);
        }
        let still = levels[first..].iter().all(|level| level.plane == 0);
        self.leaves.push(Leaf::new(block, Content::Transform { channels, still }));
    }

    fn palette(&mut self, block: Block) {
        let mut palette = Palette::default();
        palette.code(&mut self.coder, block.shape, &mut self.cache, self.domain.key_bits);
        self.take_items(1 + palette.colors.len());
        if palette.indices.iter().any(|&index| usize::from(index) >= palette.colors.len()) {
            self.illegal = Some("a pixel names a colour that its palette does not have");
        }
        note_palette(&palette, block, self.header, self.domain, &mut self.means);
        self.leaves.push(Leaf::new(block, Content::Palette(Box::new(palette))));
    }
}

/// A new list of leaves has capacity for 1 / `SPARE_SHARE` of the existing leaves, and for at least [`MIN_LIST`].
const SPARE_SHARE: usize = 8;
const MIN_LIST: usize = 8;

/// Maximum bytes per item: a leaf counts as one item, and each colour of its palette as one more.
const ITEM_BYTES: u64 = 88;
/// Bytes of a level, which is held twice when the list is shrunk to its length.
const LEVEL_BYTES: u64 = 2 * size_of::<Level>() as u64;
/// Maximum bytes of a leaf with a palette of sixteen colours.
const MAX_LEAF_BYTES: u64 = 384;
/// Maximum bytes of a region without its leaves and levels: spare capacity for leaves, and the range of its substream.
const REGION_BYTES: u64 = 640;

/// Upper bound of the bytes of a chunk of `frames` frames of a cell of `size` pixels, with its payload, during and after
/// parsing (container.md 2).
pub fn held_bytes(payload_bytes: u64, size: [usize; 2], frames: u32) -> u64 {
    bound(payload_bytes, size, frames, LEVEL_BYTES, BYTES_A_PIXEL)
}

/// Upper bound of the bytes of a parsed chunk with its payload. Levels are counted once, because lists are shrunk.
pub fn parsed_bytes(payload_bytes: u64, size: [usize; 2], frames: u32) -> u64 {
    bound(payload_bytes, size, frames, size_of::<Level>() as u64, PARSED_BYTES_A_PIXEL)
}

/// Additional bytes during parsing: a list with capacity for all levels of one region.
pub fn parsing_bytes(payload_bytes: u64, size: [usize; 2], frames: u32) -> u64 {
    let pixels = padded_pixels(size).min(padded_pixels([REGION, REGION])) * u64::from(frames);
    (CHANNELS as u64 * pixels).min(payload_bytes.saturating_mul(8)) * size_of::<Level>() as u64
}

fn bound(payload_bytes: u64, size: [usize; 2], frames: u32, level_bytes: u64, bytes_a_pixel: u64) -> u64 {
    let regions = regions(size).len() as u64;
    let pixels = padded_pixels(size) * u64::from(frames);
    let by_payload = payload_bytes.saturating_mul(ITEMS_A_BYTE * ITEM_BYTES + 8 * level_bytes);
    let by_payload = by_payload.saturating_add(regions * FREE_ITEMS * ITEM_BYTES);
    // The second term is a palette index for each pixel.
    by_payload.min(pixels * bytes_a_pixel) + pixels + regions * REGION_BYTES + payload_bytes
}

/// Leaves of the minimum size with the largest palettes, plus levels of all coefficients.
const BYTES_A_PIXEL: u64 = MAX_LEAF_BYTES / (MIN_SIDE * MIN_SIDE) as u64 + CHANNELS as u64 * LEVEL_BYTES;

/// Leaves of the minimum size, each with the largest palette or with levels of all coefficients.
const PARSED_BYTES_A_PIXEL: u64 = {
    let palette = MAX_LEAF_BYTES / (MIN_SIDE * MIN_SIDE) as u64;
    let levels = ITEM_BYTES.div_ceil((MIN_SIDE * MIN_SIDE) as u64) + (CHANNELS * size_of::<Level>()) as u64;
    if palette > levels { palette } else { levels }
};

/// Stores the means of a palette's last frame (color.md 6.5).
pub fn note_palette(palette: &Palette, block: Block, header: &Header, domain: &Domain, means: &mut Means) {
    let side = block.shape.side();
    let indices = palette.frame(block.shape, block.shape.frames - 1);
    for (y, x) in (0..side).step_by(MIN_SIDE).flat_map(|y| (0..side).step_by(MIN_SIDE).map(move |x| (y, x))) {
        let mut sums = [0; 3];
        for at in (y..y + MIN_SIDE).flat_map(|y| (x..x + MIN_SIDE).map(move |x| y * side + x)) {
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
    use crate::color::transform::palette::{Color, MAX_COLORS};

    const ALLOCATION: u64 = Region::ALLOCATION as u64;

    #[test]
    fn bounds_of_parsed_chunks_hold_what_they_are_made_of() {
        let leaf = size_of::<Leaf>() as u64;
        let list = 3 * size_of::<Vec<Leaf>>() as u64;
        let with_room = leaf + leaf.div_ceil(SPARE_SHARE as u64) + (list + ALLOCATION).div_ceil(MIN_LIST as u64);
        let palette = |colors: usize| {
            // One colour has no indices.
            let indices = if colors > 1 { ALLOCATION } else { 0 };
            ALLOCATION + (size_of::<Palette>() + colors * size_of::<Color>()) as u64 + ALLOCATION + indices
        };
        assert!(with_room <= ITEM_BYTES, "a leaf takes {with_room}");
        for colors in 1..=MAX_COLORS {
            let bytes = with_room + palette(colors);
            assert!(bytes <= (1 + colors as u64) * ITEM_BYTES, "a leaf with {colors} colours takes {bytes}");
            assert!(bytes <= MAX_LEAF_BYTES, "a leaf with {colors} colours takes {bytes}");
        }
        let places = size_of::<Range<usize>>() + size_of::<usize>();
        let region = MIN_LIST as u64 * leaf + ALLOCATION + (size_of::<Region>() + places) as u64;
        assert!(region <= REGION_BYTES, "a region takes {region}");
    }

    #[test]
    fn the_document_has_the_numbers_of_the_bound() {
        let with_commas = |value: u64| match value {
            0..1000 => value.to_string(),
            _ => format!("{},{:03}", value / 1000, value % 1000),
        };
        let by_payload = with_commas(ITEMS_A_BYTE * ITEM_BYTES + 8 * LEVEL_BYTES);
        let [free, region] = [FREE_ITEMS * ITEM_BYTES, REGION_BYTES].map(with_commas);
        let sentence = format!(
            "count {by_payload} · b + {free} · r, but at most {BYTES_A_PIXEL} · p, and on top b + {region} · r + p;"
        );
        let document = include_str!(concat!(env!("LIGHTFOLD_FORMATS"), "/container.md")).replace('\n', " ");
        assert!(document.contains(&sentence), "container.md 2 does not say: {sentence}");
        let pixels = 24 * 4096;
        let on_top = |bytes: u64| bytes + 640 * 4 + pixels;
        assert_eq!(held_bytes(1000, [64, 64], 24), 832 * 1000 + 5632 * 4 + on_top(1000));
        assert_eq!(held_bytes(1 << 20, [64, 64], 24), 72 * pixels + on_top(1 << 20));
    }
}
