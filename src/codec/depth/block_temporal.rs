//! Encodes boxes in texture blocks: tracks the decoder's picture in blocks of 4x4 pixels (CALF 5.2, 5.3; depth.md 14).
//!
//! A block within epsilon of the source is left unchanged. Any other block is encoded from the source, or stored as values if a
//! pixel of the encoded block is not within epsilon. It is sent unchanged in this frame and the W - 1 frames after it, which
//! satisfies the window rule. Memory: one picture, one block of the format per 4x4 pixels, and the open chunk.

use crate::block::{self, BlockFormat, SIDE, TEXELS};
use crate::depth::block_tiles::encode::{self, EncodeTexel};
use crate::depth::boxes::cover::{BoxBudget, Mask, cover};
use crate::depth::boxes::{PixelBox, TemporalSettings};
use crate::depth::record_table::TableBuilder;
use crate::depth::temporal::{Held, TemporalEncoder};
use crate::effort::Effort;

/// Bytes of a box before its block tiles: 8, and an allowance for the map.
const BOX_BYTES: usize = 10;

#[derive(Debug)]
struct HeldBlocks<T> {
    settings: TemporalSettings,
    effort: Effort,
    size: [usize; 2],
    columns: usize,
    picture: Vec<T>,
    blocks: Vec<HeldBlock>,
    /// Encoded block of each 4x4 pixels; valid if the block is held in encoded form.
    stored: Vec<u8>,
    /// One byte per block: 1 if the current frame must send it.
    mask: Vec<u8>,
}

#[derive(Debug, Clone, Copy)]
struct HeldBlock {
    /// Frames since the block changed, saturating; also `u8::MAX` if it has not changed since the keyframe.
    age: u8,
    in_block: bool,
}

impl<T: EncodeTexel> TemporalEncoder<T> {
    pub fn in_blocks(size: [u32; 2], settings: TemporalSettings, effort: Effort) -> Self {
        Self::with(Box::new(HeldBlocks::new(size, settings, effort)), settings.keyframe_interval)
    }
}

impl<T: EncodeTexel> HeldBlocks<T> {
    fn new(size: [u32; 2], settings: TemporalSettings, effort: Effort) -> Self {
        let size = size.map(|side| side as usize);
        let [columns, rows] = block::grid(size[0], size[1]);
        HeldBlocks {
            settings,
            effort,
            size,
            columns,
            picture: Vec::new(),
            blocks: vec![HeldBlock { age: u8::MAX, in_block: false }; columns * rows],
            stored: vec![0; columns * rows * T::Format::BYTES],
            mask: vec![0; columns * rows],
        }
    }

    /// Returns the pixels of a block that lie in the unit: their indices in the picture and in the block.
    fn pixels(&self, at: usize) -> impl Iterator<Item = (usize, usize)> + use<T> {
        let [width, height] = self.size;
        let (x, y) = (at % self.columns * SIDE, at / self.columns * SIDE);
        let (columns, rows) = (SIDE.min(width - x), SIDE.min(height - y));
        (0..rows)
            .flat_map(move |row| (0..columns).map(move |column| ((y + row) * width + x + column, row * SIDE + column)))
    }

    /// Returns the values of a block; beyond the edge the last column and row are repeated.
    fn cut(&self, at: usize, source: &[T]) -> [T; TEXELS] {
        let [width, height] = self.size;
        let (x, y) = (at % self.columns * SIDE, at / self.columns * SIDE);
        std::array::from_fn(|i| source[(y + i / SIDE).min(height - 1) * width + (x + i % SIDE).min(width - 1)])
    }

    fn serves(&self, at: usize, source: &[T], epsilon: u16) -> bool {
        self.pixels(at).all(|(pixel, _)| T::within(self.picture[pixel], source[pixel], epsilon))
    }

    /// Replaces the wanted blocks by the source: in encoded form if that is within `epsilon`, otherwise as values.
    fn replace(&mut self, wanted: &[usize], source: &[T], epsilon: u16) {
        let values: Vec<_> = wanted.iter().map(|&at| self.cut(at, source)).collect();
        let encoded = T::encode(&values, self.effort);
        for (&at, block) in wanted.iter().zip(encoded.chunks_exact(T::Format::BYTES)) {
            let shown = T::decode(block);
            let in_block = self.pixels(at).all(|(pixel, texel)| T::within(shown[texel], source[pixel], epsilon));
            for (pixel, texel) in self.pixels(at) {
                self.picture[pixel] = if in_block { shown[texel] } else { source[pixel] };
            }
            self.stored[at * T::Format::BYTES..][..T::Format::BYTES].copy_from_slice(block);
            self.blocks[at].in_block = in_block;
        }
    }

    /// Appends a rectangle (left, top, width, height in pixels) in the form in which its blocks are held.
    fn put(&self, [left, top, width, height]: [usize; 4], out: &mut Vec<u8>) {
        let block = |x: usize, y: usize| {
            let at = (top + y) / SIDE * self.columns + (left + x) / SIDE;
            self.blocks[at].in_block.then(|| &self.stored[at * T::Format::BYTES..][..T::Format::BYTES])
        };
        let value = |x: usize, y: usize| self.picture[(top + y) * self.size[0] + left + x];
        encode::put([width, height], block, value, out);
    }

    fn boxes(&self) -> Vec<PixelBox> {
        // An additional box must save more bytes of blocks than it takes.
        let min_saving = (BOX_BYTES / T::Format::BYTES) as u32;
        let budget = BoxBudget { max_boxes: self.settings.max_aabbs, min_saving };
        let covers = cover(Mask { pixels: &self.mask, width: self.columns }, budget);
        let pixels = |start: u16, size: u16, limit: usize| {
            let start = usize::from(start) * SIDE;
            (start as u16, (usize::from(size) * SIDE).min(limit - start) as u16)
        };
        let scaled = covers.into_iter().map(|b| {
            let ((x, width), (y, height)) = (pixels(b.x, b.width, self.size[0]), pixels(b.y, b.height, self.size[1]));
            PixelBox { x, y, width, height }
        });
        scaled.collect()
    }
}

impl<T: EncodeTexel> Held<T> for HeldBlocks<T> {
    fn start(&mut self, source: &[T], chunk: &mut TableBuilder) {
        self.picture.clear();
        self.picture.extend_from_slice(source);
        let all: Vec<usize> = (0..self.blocks.len()).collect();
        // A constant keyframe is stored as one exact value, which later boxes must repeat exactly.
        let constant = source.iter().all(|value| *value == source[0]);
        self.replace(&all, source, if constant { 0 } else { self.settings.epsilon });
        self.blocks.iter_mut().for_each(|block| block.age = u8::MAX);
        let whole = [0, 0, self.size[0], self.size[1]];
        chunk.put_keyframe(source, |data| self.put(whole, data));
    }

    fn advance(&mut self, source: &[T], frame: u32, chunk: &mut TableBuilder) {
        let epsilon = self.settings.epsilon;
        let wanted: Vec<usize> = (0..self.blocks.len()).filter(|&at| !self.serves(at, source, epsilon)).collect();
        self.replace(&wanted, source, epsilon);
        self.blocks.iter_mut().for_each(|block| block.age = block.age.saturating_add(1));
        wanted.iter().for_each(|&at| self.blocks[at].age = 0);
        for (mask, block) in self.mask.iter_mut().zip(&self.blocks) {
            *mask = u8::from(block.age < self.settings.window);
        }
        if self.mask.contains(&1) {
            let boxes = self.boxes();
            chunk.put_boxes(frame, &boxes, |b, data| self.put(b.rect(), data));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::block_tiles::{BlockTileCount, Layout};
    use crate::depth::records::TemporalChunk;
    use crate::depth::temporal::tests::paths;
    use crate::math::random::Random;

    fn check<T: EncodeTexel>(frames: &[Vec<T>], size: [u32; 2], settings: TemporalSettings) -> BlockTileCount {
        let chunks = paths::encode(TemporalEncoder::in_blocks(size, settings, Effort::Fast), frames);
        let mut count = BlockTileCount::default();
        for chunk in &chunks {
            let parsed =
                TemporalChunk::<T>::parse(Layout::BlockTiles, chunk.payload.clone(), size, chunk.frame_count).unwrap();
            for record in &parsed.records {
                parsed
                    .rectangles(record.body)
                    .for_each(|(size, bytes)| count.add(BlockTileCount::of_rectangle(bytes, size)));
            }
        }
        paths::check_all::<T>(frames, (size, Layout::BlockTiles), chunks, settings);
        count
    }

    /// Returns frames of a slope in which pixels jump, creep, become background and return.
    fn moving_codes([width, height]: [u32; 2], count: usize, random: &mut Random) -> Vec<Vec<u16>> {
        let pixels = width * height;
        let mut frame: Vec<u16> = (0..pixels).map(|at| (20_000 + at % width * 9 + at / width * 3) as u16).collect();
        let mut frames = vec![frame.clone()];
        for _ in 1..count {
            for _ in 0..random.below(6) {
                let at = random.below(pixels) as usize;
                frame[at] = match random.below(4) {
                    0 => u16::MAX,
                    1 => frame[at].wrapping_add(1),
                    2 => 20_000,
                    _ => random.below(65_536) as u16,
                };
            }
            frames.push(frame.clone());
        }
        frames
    }

    #[test]
    fn every_legal_path_shows_the_same_depth_within_epsilon() {
        let mut random = Random::new(3);
        for size in [[37, 21], [16, 16], [5, 3], [64, 1]] {
            let frames = moving_codes(size, 40, &mut random);
            for window in [1, 2, 16, 100] {
                for epsilon in [0, 40, 3000] {
                    for (max_aabbs, keyframe_interval) in [(1, 1000), (8, 20), (256, 7), (3, 1)] {
                        check(&frames, size, TemporalSettings { window, epsilon, max_aabbs, keyframe_interval });
                    }
                }
            }
        }
    }

    #[test]
    fn every_legal_path_shows_the_same_material_within_epsilon() {
        let mut random = Random::new(9);
        let size = [26, 19];
        let mut frame: Vec<[u8; 3]> = (0..size[0] * size[1]).map(|at| [(at % 26 * 4) as u8, 30, 0]).collect();
        let mut frames = vec![frame.clone()];
        for _ in 1..30 {
            for _ in 0..random.below(5) {
                let at = random.below(size[0] * size[1]) as usize;
                frame[at] = [random.below(256) as u8, frame[at][1].wrapping_add(1), (at % 3) as u8];
            }
            frames.push(frame.clone());
        }
        for (window, epsilon) in [(1, 0), (2, 8), (3, 30), (255, 8)] {
            check(&frames, size, TemporalSettings { window, epsilon, ..TemporalSettings::default() });
        }
    }

    #[test]
    fn a_pixel_that_creeps_below_epsilon_for_600_frames_stays_within_it() {
        let frames: Vec<Vec<u16>> =
            (0..600u16).map(|n| (0..144).map(|at| if at == 50 { 1000 + n } else { 1007 }).collect()).collect();
        let settings = TemporalSettings { epsilon: 10, keyframe_interval: 1000, ..TemporalSettings::default() };
        check(&frames, [12, 12], settings);
        let chunks = paths::encode(TemporalEncoder::in_blocks([12, 12], settings, Effort::Fast), &frames);
        let parsed = TemporalChunk::<u16>::parse(Layout::BlockTiles, chunks[0].payload.clone(), [12, 12], 600).unwrap();
        // At most one record per frame, and at least as many as values would need.
        assert!(parsed.records.len() > 599 / 21, "{}", parsed.records.len());
    }

    #[test]
    fn tiles_are_in_blocks_where_these_are_close_enough_and_only_there() {
        let smooth: Vec<u16> = (0..32 * 32).map(|at| (0x5000 + at % 32 + at / 32) as u16).collect();
        let settings = |epsilon| TemporalSettings { epsilon, ..TemporalSettings::default() };
        assert_eq!(check(std::slice::from_ref(&smooth), [32, 32], settings(2)), BlockTileCount { blocks: 4, raw: 0 });
        let mut rough = smooth;
        rough[0] = u16::MAX;
        rough[1] = 0x1234;
        rough[2] = 0x9876;
        assert_eq!(check(&[rough], [32, 32], settings(2)), BlockTileCount { blocks: 3, raw: 1 });
    }

    #[test]
    fn one_value_is_stored_once_and_repeated_exactly() {
        let flat = vec![0x1234u16; 20 * 20];
        let mut cut = flat.clone();
        (cut[0], cut[20 * 20 - 1]) = (9, 9);
        let settings = TemporalSettings { max_aabbs: 1, epsilon: 900, ..TemporalSettings::default() };
        check(&[flat.clone(), cut, flat.clone()], [20, 20], settings);
        let chunks = paths::encode(TemporalEncoder::in_blocks([20, 20], settings, Effort::Fast), &[flat]);
        assert_eq!(chunks[0].payload.len(), 4 + 8 + 4 + 2);
    }
}
