//! Payload of a chunk of plain BC4w blocks: complete frames at a fixed ratio of 4:1 (depth.md 12).
//!
//! A frame and a block are located by their numbers alone. The error of surfaces is not bounded; the background is exact.

#[cfg(feature = "encode")]
pub mod encoder;

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::bc4w::Bc4w;
use crate::depth::block::BlockMut;
use crate::depth::mode_statistics::{ModeStatistics, Share};
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, function_of};
use crate::depth::runtime::Runtime;
use crate::error::Result;

const SECTION: &str = "depth.md 12";
const LEVEL: u8 = 1;

#[derive(Debug, Clone)]
pub struct BlockChunk {
    payload: Payload,
    grid: Grid,
}

fn corners(grid: Grid) -> impl Iterator<Item = [usize; 2]> {
    let columns = grid.width.div_ceil(8) as usize;
    (0..grid.height.div_ceil(8) as usize).flat_map(move |y| (0..columns).map(move |x| [8 * x, 8 * y]))
}

/// Returns the blocks of a unit of at most 1024×1024 pixels, row by row.
pub fn places(grid: Grid) -> impl Iterator<Item = Place> {
    corners(grid).map(|[x, y]| Place { level: LEVEL, x: (x / 8) as u8, y: (y / 8) as u8 })
}

pub fn picture_bytes(grid: Grid) -> usize {
    grid.width.div_ceil(8) as usize * grid.height.div_ceil(8) as usize * COEFFICIENT_BYTES
}

impl BlockChunk {
    pub fn parse(payload: impl Into<Payload>, grid: Grid, frame_count: u32) -> Result<BlockChunk> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let expected = picture_bytes(grid) as u64 * u64::from(frame_count);
        let blocks = fields.bytes(usize::try_from(expected).unwrap_or(usize::MAX))?;
        if blocks.as_chunks().0.iter().any(|block| function_of(LEVEL, block) != Function::Bc4w) {
            return Err(fields.error("a BC4w block that ends like another function"));
        }
        fields.finish()?;
        Ok(BlockChunk { payload, grid })
    }

    pub fn blocks_of_frame(&self) -> u64 {
        (picture_bytes(self.grid) / COEFFICIENT_BYTES) as u64
    }

    pub fn mode_statistics(&self) -> ModeStatistics {
        let mut statistics = ModeStatistics::default();
        let pictures = self.payload.len() / picture_bytes(self.grid);
        for place in (0..pictures).flat_map(|_| places(self.grid)) {
            let share = Share { nodes: 1, pixels: self.grid.pixels_of(place), bytes: COEFFICIENT_BYTES as u64 };
            statistics.add_share(LEVEL, Function::Bc4w, share);
        }
        statistics
    }

    pub fn runtime(&self) -> Runtime {
        let mut runtime = Runtime::new(self.grid);
        let blocks = |picture: &[u8]| -> Vec<Node> {
            let blocks = picture.as_chunks().0.iter().zip(places(self.grid));
            blocks.map(|(&coefficients, place)| Node { place, coefficients }).collect()
        };
        let pictures = self.payload.chunks_exact(picture_bytes(self.grid)).zip(0..);
        for (picture, frame) in pictures {
            runtime.push(frame, &blocks(picture));
        }
        runtime
    }

    /// Decodes frame `target` of the chunk; returns the number of pixels written.
    pub fn show(&self, picture: &mut [u16], target: u32) -> u64 {
        let bytes = picture_bytes(self.grid);
        let blocks = self.payload[target as usize * bytes..][..bytes].as_chunks().0;
        for (block, place) in blocks.iter().zip(corners(self.grid)) {
            let mut target = BlockMut::of(picture, self.grid.width as usize, LEVEL, place);
            // `parse` rejects markers.
            Bc4w::from_bytes(*block).iter().for_each(|block| block.decode(&mut target));
        }
        self.grid.pixel_count()
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.payload.into_spare()
    }
}
