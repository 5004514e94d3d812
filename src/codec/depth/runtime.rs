//! Runtime form of a chunk's nodes, from which the CPU and GPUs decode (depth.md 10, GDC 4).
//!
//! One buffer holds all frames of a unit. Each frame has a header with the number of nodes of each level, the places of the nodes
//! in two bytes each, and their coefficients in 32 bytes each. All parts are aligned to 16 bytes, so that a node is located by
//! its number alone. A table maps frames to offsets in the buffer.

use crate::depth::bc4w::Bc4w;
use crate::depth::biquadratic::Biquadratic;
use crate::depth::block::{BlockMut, MAX_LEVEL};
use crate::depth::domain::Domain;
use crate::depth::nodes::{COEFFICIENT_BYTES, Function, Grid, Node, Place, function_of, raw};
use crate::depth::platelet::Platelet;

pub const LEVELS: usize = MAX_LEVEL as usize + 1;
/// Bytes of a frame's header: the number of nodes, the number per level, and zeros.
pub const HEADER_BYTES: usize = 48;
const ALIGN: usize = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RuntimeFrame {
    pub frame: u32,
    pub offset: usize,
    pub nodes: u64,
    pub updated_pixels: u64,
}

#[derive(Debug, Clone)]
pub struct Runtime {
    pub grid: Grid,
    pub buffer: Vec<u8>,
    pub frames: Vec<RuntimeFrame>,
}

impl Runtime {
    pub fn new(grid: Grid) -> Runtime {
        Runtime { grid, buffer: Vec::new(), frames: Vec::new() }
    }

    /// Appends a frame. Its nodes must not overlap, must be in the order of the walk, and must lie in the picture. Returns the
    /// number of pixels that they cover.
    pub fn push(&mut self, frame: u32, nodes: &[Node]) -> u64 {
        let offset = self.buffer.len();
        let mut counts = [0u32; LEVELS];
        nodes.iter().for_each(|node| counts[usize::from(node.place.level)] += 1);
        self.buffer.extend_from_slice(&(nodes.len() as u32).to_le_bytes());
        counts.iter().for_each(|count| self.buffer.extend_from_slice(&count.to_le_bytes()));
        self.buffer.resize(offset + HEADER_BYTES, 0);
        let by_level = || (0..LEVELS as u8).flat_map(|level| nodes.iter().filter(move |n| n.place.level == level));
        by_level().for_each(|node| self.buffer.extend_from_slice(&[node.place.x, node.place.y]));
        self.buffer.resize(self.buffer.len().next_multiple_of(ALIGN), 0);
        by_level().for_each(|node| self.buffer.extend_from_slice(&node.coefficients));
        let updated_pixels = nodes.iter().map(|node| self.grid.pixels_of(node.place)).sum();
        self.frames.push(RuntimeFrame { frame, offset, nodes: nodes.len() as u64, updated_pixels });
        updated_pixels
    }

    /// Returns the nodes of a frame with their places and coefficients, level by level.
    pub fn nodes(&self, frame: RuntimeFrame) -> impl Iterator<Item = (Place, &[u8; COEFFICIENT_BYTES])> {
        let words = self.buffer[frame.offset..frame.offset + HEADER_BYTES].as_chunks::<4>().0;
        let count = u32::from_le_bytes(words[0]) as usize;
        let places_at = frame.offset + HEADER_BYTES;
        let coefficients_at = (places_at + 2 * count).next_multiple_of(ALIGN);
        let places = self.buffer[places_at..places_at + 2 * count].as_chunks::<2>().0;
        let coefficients = self.buffer[coefficients_at..coefficients_at + COEFFICIENT_BYTES * count].as_chunks().0;
        let levels = (0..LEVELS)
            .flat_map(move |level| std::iter::repeat_n(level as u8, u32::from_le_bytes(words[1 + level]) as usize));
        levels.zip(places).zip(coefficients).map(|((level, &[x, y]), c)| (Place { level, x, y }, c))
    }

    pub fn apply(&self, picture: &mut [u16], frame: RuntimeFrame, domain: &Domain) -> u64 {
        let width = self.grid.width as usize;
        for (place, coefficients) in self.nodes(frame) {
            decode_node(place, coefficients, domain, &mut BlockMut::of(picture, width, place.level, place.pixel()));
        }
        frame.updated_pixels
    }
}

pub fn decode_node(place: Place, coefficients: &[u8; COEFFICIENT_BYTES], domain: &Domain, target: &mut BlockMut<'_>) {
    match function_of(place.level, coefficients) {
        Function::Raw => raw::decode(coefficients, target),
        Function::Biquadratic => Biquadratic::from_bytes(coefficients).decode(domain, target),
        Function::Platelet => Platelet::from_bytes(coefficients).decode(domain, target),
        // `from_bytes` succeeds, because a block with a marker is another function.
        Function::Bc4w => Bc4w::from_bytes(*coefficients).iter().for_each(|block| block.decode(target)),
    }
}
