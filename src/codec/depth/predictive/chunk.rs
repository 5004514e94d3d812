//! Chunk of predictive coding: the number of a table set and one substream, from which frames are decoded in order (depth.md
//! 15.1, 15.2).

#[cfg(feature = "encode")]
use std::cell::RefCell;

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::predictive::contexts;
#[cfg(feature = "encode")]
use crate::depth::predictive::contexts::Predictive;
use crate::depth::predictive::contexts::TableSet;
use crate::depth::predictive::modes::{BACKGROUND, BLOCK, BlockCoding, PIXELS, PLANES, QUARTERS, SAME, SMALL, SOURCES};
use crate::depth::predictive::pixel::{
    Around, Pixel, RESIDUALS, SYMBOL_ABOVE, SYMBOL_BACKGROUND, SYMBOL_CANDIDATE, SYMBOL_KEEP, Steps,
};
use crate::depth::predictive::plane::{Plane, Side};
use crate::depth::predictive::projection::UnitArea;
#[cfg(feature = "encode")]
use crate::depth::predictive::source::Counting;
use crate::depth::predictive::source::{Reader, Source};
use crate::depth::predictive::tile::{Area, MAX_FRAMES, MAX_SIDE, PredictiveHeader, Tile};
use crate::entropy;
use crate::entropy::rans::Mark;
use crate::error::{Error, Result};

const SECTION: &str = "depth.md 15";
/// Bytes before the substream.
const HEAD: usize = 1;

#[derive(Debug, Clone)]
pub struct PredictiveChunk {
    payload: Payload,
    header: PredictiveHeader,
    area: UnitArea,
    frames: u32,
    tables: TableSet,
    state: Option<State>,
}

/// Decoder state of a unit between two frames.
#[derive(Debug, Clone)]
struct State {
    tile: Tile,
    mark: Mark,
    /// Next frame to be decoded, counted from the chunk's first.
    next: u32,
}

impl PredictiveChunk {
    /// Parses a payload; checks only what needs no decoding.
    pub fn parse(
        payload: impl Into<Payload>,
        header: PredictiveHeader,
        area: UnitArea,
        frames: u32,
    ) -> Result<PredictiveChunk> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let set = fields.u8()?;
        let tables = header.tables.sets().get(usize::from(set)).cloned();
        let tables = tables.ok_or_else(|| fields.error_at(0, format!("table set {set} is unknown")))?;
        if frames > MAX_FRAMES {
            return Err(fields.error(format!("a chunk of {frames} frames, at most {MAX_FRAMES} are legal")));
        }
        if area.size().iter().any(|side| !(1..=MAX_SIDE).contains(side)) {
            return Err(fields.error(format!("a tile of {:?} pixels: sides are 1 to {MAX_SIDE}", area.size())));
        }
        Ok(PredictiveChunk { payload, header, area, frames, tables, state: None })
    }

    /// Advances `picture` from frame `at` of this chunk (`None`: no frame shown yet) to frame `target`. Returns the number of
    /// pixels written: those of blocks that differ from the frame before, and all pixels in the first frame.
    ///
    /// # Errors
    /// Fails if the substream ends before its last frame does, or continues after it.
    pub fn advance(&mut self, picture: &mut [u16], at: Option<u32>, target: u32) -> Result<u64> {
        if at == Some(target) {
            return Ok(0);
        }
        let mut state = match self.state.take() {
            Some(state) if state.next <= target + 1 => state,
            Some(mut state) => {
                state.tile.clear();
                State { mark: entropy::Decoder::new(&self.payload[HEAD..]).mark(), next: 0, ..state }
            }
            None => State {
                tile: Tile::new(&self.header, self.area)?,
                mark: entropy::Decoder::new(&self.payload[HEAD..]).mark(),
                next: 0,
            },
        };
        // If the picture does not show the last decoded frame of this state, all of it is written.
        let is_ours = at.is_some_and(|at| at + 1 == state.next);
        let mut updated = 0;
        let mut source = self.reader(entropy::Decoder::resume(&self.payload[HEAD..], state.mark));
        while state.next <= target {
            let mut frame = FrameDecoder { source, tile: &mut state.tile, picture, updated: 0 };
            frame.decode(|_, _| ());
            updated += frame.updated;
            source = frame.source;
            state.next += 1;
            self.check_substream(&source.stream, state.next)?;
        }
        state.mark = source.stream.mark();
        if !is_ours {
            let [width, height] = [state.tile.width, state.tile.height];
            state.tile.show(Area { x: 0, y: 0, width, height }, picture);
            updated = updated.max((width * height) as u64);
        }
        self.state = Some(state);
        Ok(updated)
    }

    /// Decodes all frames, to verify the chunk.
    pub fn check(&self) -> Result<()> {
        self.for_each_frame(|_| Ok(()))
    }

    /// Decodes all frames in order and calls `visit` for each.
    ///
    /// # Errors
    /// As for [`Self::advance`], and the errors of `visit`.
    pub fn for_each_frame(&self, mut visit: impl FnMut(&FrameBlocks<'_>) -> Result<()>) -> Result<()> {
        let mut tile = Tile::new(&self.header, self.area)?;
        let mut picture = vec![0; tile.width * tile.height];
        let mut source = self.reader(entropy::Decoder::new(&self.payload[HEAD..]));
        let mut blocks = Vec::new();
        for number in 0..self.frames {
            blocks.clear();
            let start = source.stream.bits_left();
            let mut before = start;
            let mut frame = FrameDecoder { source, tile: &mut tile, picture: &mut picture, updated: 0 };
            frame.decode(|mode, source| {
                let left = source.stream.bits_left();
                blocks.push((mode, std::mem::replace(&mut before, left) - left));
            });
            let updated_pixels = frame.updated;
            source = frame.source;
            self.check_substream(&source.stream, number + 1)?;
            let blocks = blocks.iter().enumerate();
            visit(&FrameBlocks {
                frame: number,
                blocks: blocks
                    .map(|(at, &(mode, bits))| CodedBlock { area: tile.area(at), coding: BlockCoding::of(mode), bits })
                    .collect(),
                updated_pixels,
                bits: start - source.stream.bits_left(),
                size: self.area.size(),
                picture: &picture,
            })?;
        }
        Ok(())
    }

    /// Counts the symbols of all frames.
    ///
    /// # Errors
    /// As for [`Self::advance`].
    #[cfg(feature = "encode")]
    pub fn count(&self) -> Result<entropy::PayloadCounts<Predictive>> {
        let counts = RefCell::new(entropy::Counts::default());
        let mut tile = Tile::new(&self.header, self.area)?;
        let mut picture = vec![0; tile.width * tile.height];
        let mut source =
            Counting { reader: self.reader(entropy::Decoder::new(&self.payload[HEAD..])), counts: &counts };
        for number in 0..self.frames {
            let mut frame = FrameDecoder { source, tile: &mut tile, picture: &mut picture, updated: 0 };
            frame.decode(|_, _| ());
            source = frame.source;
            self.check_substream(&source.reader.stream, number + 1)?;
        }
        let counts = counts.into_inner();
        let bits = entropy::Prices::new(&self.tables).total(&counts);
        Ok(entropy::PayloadCounts { counts, bytes: self.payload.len() as u64, bits })
    }

    fn reader<'a>(&'a self, stream: entropy::Decoder<'a>) -> Reader<'a> {
        Reader { stream, tables: self.tables.distributions() }
    }

    /// Checks a substream after its first `frames` frames are decoded.
    fn check_substream(&self, stream: &entropy::Decoder<'_>, frames: u32) -> Result<()> {
        if stream.is_short() || frames == self.frames && !stream.finished() {
            let problem = if stream.is_short() { "ends too early" } else { "does not end with its last frame" };
            return Err(Error::invalid(format!("a substream that {problem} ({SECTION})")));
        }
        Ok(())
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.payload.into_spare()
    }
}

/// Blocks and picture of one coded frame.
pub struct FrameBlocks<'a> {
    /// Number of the frame, counted from the chunk's first.
    pub frame: u32,
    /// All blocks of the unit, row by row; empty if the frame is coded as equal to the one before, or as background.
    pub blocks: Vec<CodedBlock>,
    /// Number of pixels in blocks that differ from the frame before; all pixels in the first frame.
    pub updated_pixels: u64,
    /// Bits of the frame in the substream.
    pub bits: f64,
    /// Width and height of the unit.
    pub size: [u32; 2],
    /// Codes of the unit, row by row.
    pub picture: &'a [u16],
}

#[derive(Debug, Clone, Copy)]
pub struct CodedBlock {
    pub area: Area,
    pub coding: BlockCoding,
    pub bits: f64,
}

impl FrameBlocks<'_> {
    /// Returns left, top, width and height of the rectangles that the frame writes: horizontal runs of blocks, or the whole unit
    /// in the first frame.
    pub fn written(&self) -> Vec<[u32; 4]> {
        if self.frame == 0 {
            return vec![[0, 0, self.size[0], self.size[1]]];
        }
        let mut written: Vec<[u32; 4]> = Vec::new();
        for block in self.blocks.iter().filter(|block| block.coding != BlockCoding::Same) {
            let [x, y, width, height] = block.area.rect();
            match written.last_mut() {
                Some(last) if last[1] == y && last[0] + last[2] == x => last[2] += width,
                _ => written.push([x, y, width, height]),
            }
        }
        written
    }
}

struct FrameDecoder<'b, S> {
    source: S,
    tile: &'b mut Tile,
    picture: &'b mut [u16],
    updated: u64,
}

impl<S: Source> FrameDecoder<'_, S> {
    /// Decodes a frame. After each block, `coded` gets its mode and the source.
    fn decode(&mut self, mut coded: impl FnMut(usize, &S)) {
        if self.source.symbol(contexts::frame(self.tile.later())) == 1 {
            for block in 0..self.tile.blocks.len() {
                self.block(block);
                coded(self.tile.blocks[block].mode, &self.source);
            }
        } else if !self.tile.is_later {
            self.picture.fill(u16::MAX);
        }
        if !self.tile.is_later {
            self.updated = self.picture.len() as u64;
        }
        self.tile.is_later = true;
    }

    fn block(&mut self, at: usize) {
        let area = self.tile.area(at);
        let mode = self.source.symbol(self.tile.mode_context(at));
        self.tile.blocks[at].mode = mode;
        if mode == SAME {
            if !self.tile.is_later {
                self.tile.show(area, self.picture);
            }
            return;
        }
        match mode {
            BACKGROUND => self.tile.fill_background(area),
            PIXELS => self.pixels(area),
            QUARTERS => {
                for quarter in self.tile.quarters(area) {
                    match self.source.symbol(self.tile.small_mode_context(quarter)) {
                        0 => self.pixels(quarter),
                        mode => {
                            let mut plane = self.tile.small_plane_from(quarter, (mode - 1) % SOURCES);
                            if mode > SOURCES {
                                plane = self.changed(plane, Side::Quarter);
                            }
                            self.tile.fill_plane::<SMALL>(quarter, &plane);
                        }
                    }
                }
            }
            _ => {
                let mut plane = self.tile.plane_from(at, (mode - PLANES) % SOURCES);
                if mode >= PLANES + SOURCES {
                    plane = self.changed(plane, Side::Block);
                }
                self.tile.fill_plane::<BLOCK>(area, &plane);
                self.tile.blocks[at].plane = plane;
            }
        }
        self.tile.blocks[at].content = mode;
        self.tile.show(area, self.picture);
        self.updated += (area.width * area.height) as u64;
    }

    fn changed(&mut self, plane: Plane, side: Side) -> Plane {
        let (mut change, mut before) = ([0; 3], 0);
        for (number, value) in change.iter_mut().enumerate() {
            *value = self.change(contexts::change(side, number, before));
            before = *value;
        }
        plane.changed(change, self.tile.change_steps(side))
    }

    /// Decodes a signed number. Symbol 0 is 0; other symbols are twice the class plus 1, or plus 2 if the number is positive.
    fn change(&mut self, context: usize) -> i32 {
        match self.source.symbol(context) {
            0 => 0,
            symbol => {
                let magnitude = rest(&mut self.source, &CHANGES, (symbol - 1) / 2) as i32;
                if symbol % 2 == 1 { -magnitude } else { magnitude }
            }
        }
    }

    fn pixels(&mut self, area: Area) {
        let (later, steps) = (self.tile.later(), self.tile.steps);
        let mut source = self.source.clone();
        for y in area.y..area.y + area.height {
            let (above, row, corrections) = self.tile.rows(area.x, y, area.width);
            let (mut left, mut above_left, mut over) = (row[0], above[0], above[1]);
            for ((pixel, &above_right), &correction) in row[1..].iter_mut().zip(&above[2..]).zip(corrections) {
                let around = Around { left, above: over, above_left, above_right, before: *pixel, correction };
                left = pixel_of(&mut source, &around, &steps, later);
                *pixel = left;
                (above_left, over) = (over, above_right);
            }
        }
        self.source = source;
    }
}

/// Reads the raw bits that follow the class of a magnitude; returns the magnitude.
fn rest<const COUNT: usize>(source: &mut impl Source, classes: &Classes<COUNT>, class: usize) -> u32 {
    classes.least[class] + source.bits(classes.bits[class].into())
}

#[inline(always)]
fn pixel_of(source: &mut impl Source, around: &Around, steps: &Steps, later: usize) -> Pixel {
    let above = contexts::pixel_above(&around.above, &around.above_right, later);
    let symbol = source.symbol(contexts::pixel(&around.left, above));
    match symbol {
        0..SYMBOL_KEEP => around.predict(steps).with_residual(RESIDUALS[symbol], steps),
        SYMBOL_KEEP => around.before.kept(),
        SYMBOL_BACKGROUND => Pixel::BACKGROUND,
        _ => far_pixel(source, around, steps, symbol),
    }
}

/// Decodes a pixel on another surface, or with a residual of three steps or more.
fn far_pixel(source: &mut impl Source, around: &Around, steps: &Steps, symbol: usize) -> Pixel {
    let prediction = around.predict(steps);
    if symbol < SYMBOL_ABOVE {
        let which = symbol - SYMBOL_CANDIDATE;
        let class = source.symbol(contexts::candidate(which));
        let magnitude = rest(source, &CANDIDATES, class) as i32;
        let residual = if magnitude > 0 && source.bits(1) == 1 { -magnitude } else { magnitude };
        return around.candidates(&prediction, steps).pixels[which].on_surface(residual, steps);
    }
    let class = source.symbol(contexts::escape(&around.left, &around.above, &around.above_right));
    let magnitude = rest(source, &ESCAPES, class) as i32;
    prediction.escaped(if symbol == SYMBOL_ABOVE { magnitude } else { -magnitude }, steps)
}

/// Classes of magnitudes (depth.md 15.5), at most 16: minimum magnitude of each class, and the number of raw bits that follow the
/// class.
#[derive(Debug)]
pub struct Classes<const COUNT: usize> {
    pub least: [u32; COUNT],
    pub bits: [u8; COUNT],
}

impl<const COUNT: usize> Classes<COUNT> {
    const fn new(bits: [u8; COUNT], first: u32) -> Classes<COUNT> {
        let mut least = [first; COUNT];
        let mut class = 1;
        while class < COUNT {
            least[class] = least[class - 1] + (1 << bits[class - 1]);
            class += 1;
        }
        Classes { least, bits }
    }

    /// Returns the class of a magnitude, which must be at least the minimum of the first class.
    pub fn of(&self, magnitude: u32) -> usize {
        self.least.iter().rposition(|&least| least <= magnitude).unwrap_or(0)
    }
}

/// Classes of escapes: residuals of at least 3 steps.
pub const ESCAPES: Classes<16> = Classes::new([0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7, 9, 16], 3);
/// Classes of residuals on another surface.
pub const CANDIDATES: Classes<16> = Classes::new([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7, 8, 9, 16], 0);
/// Classes of nonzero changes of a plane.
pub const CHANGES: Classes<7> = Classes::new([0, 0, 1, 1, 2, 6, 14], 1);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_every_residual_of_16_bits() {
        for magnitude in 0..=65_535u32 {
            let class = CANDIDATES.of(magnitude);
            assert!(magnitude - CANDIDATES.least[class] < 1 << CANDIDATES.bits[class]);
            let class = ESCAPES.of(magnitude + 3);
            assert!(magnitude + 3 - ESCAPES.least[class] < 1 << ESCAPES.bits[class]);
        }
        assert_eq!((ESCAPES.least[15], CANDIDATES.least[15]), (833, 1039));
        assert_eq!(CHANGES.least, [1, 2, 3, 5, 7, 11, 75]);
    }
}
