//! Payload of a chunk of one cell: its header, and a substream for each region (color.md 6.4).

use std::ops::Range;

use crate::color::transform::blocks::{MAX_FRAMES, regions};
use crate::color::transform::contexts::Tables;
use crate::color::transform::domain::{ChromaSlopes, Keyed};
use crate::color::transform::palette::Color;
use crate::color::transform::steps::{DELTAS, OFFSET_SETS, StepIndices};
use crate::container::fields::Fields;
use crate::error::{Error, Result};

pub const SECTION: &str = "color.md 6.4";
/// First byte of a payload with keyframes and weights (color.md 4) instead of regions.
pub const CELLS: u8 = 255;
/// Bit of the byte `choices`: regions have deltas.
const HAS_DELTAS: u8 = 0x80;

/// Coding parameters of a cell's chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Index of the table set.
    pub set: usize,
    pub steps: StepIndices,
    pub slopes: ChromaSlopes,
    /// Index of the set of frequency offsets.
    pub offset_set: usize,
    /// Initial colours of the caches of all regions.
    pub colors: Vec<Color>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    pub header: Header,
    /// Delta of the step indices of each region.
    pub deltas: Vec<i8>,
    /// Byte ranges of the substreams in the payload.
    pub substreams: Vec<Range<usize>>,
}

/// True if a payload has keyframes and weights (color.md 4), which start at its second byte.
pub fn holds_cells(payload: &[u8]) -> bool {
    payload.first() == Some(&CELLS)
}

pub fn check_frames(frames: u32) -> Result<()> {
    if frames <= MAX_FRAMES {
        return Ok(());
    }
    Err(Error::invalid_at(SECTION, 0, format!("a chunk of {frames} frames, at most {MAX_FRAMES} are legal")))
}

impl Layout {
    pub fn parse<S: Keyed>(payload: &[u8], size: [usize; 2], tables: &Tables) -> Result<Layout> {
        let mut fields = Fields::new(payload, 0, SECTION);
        let set = usize::from(fields.u8()?);
        if set >= tables.sets().len() {
            return Err(fields.error(format!("table set {set}, the stream has {}", tables.sets().len())));
        }
        let steps = StepIndices { luma: fields.u8()?, chroma: fields.u8()? };
        let slopes = ChromaSlopes { green: fields.u8()? as i8, orange: fields.u8()? as i8 };
        let choices = fields.u8()?;
        let (count, offset_set) = (usize::from(choices & 15), usize::from(choices >> 4 & 7));
        if offset_set >= OFFSET_SETS.len() {
            return Err(fields.error(format!("set {offset_set} of frequency offsets, there are {}", OFFSET_SETS.len())));
        }
        let mut colors = vec![[0; 3]; count];
        for key in colors.as_flattened_mut() {
            *key = if S::BYTES == 1 { fields.u8()?.into() } else { fields.u16()?.into() };
        }
        let regions = regions(size).len();
        let deltas = if choices & HAS_DELTAS == 0 {
            vec![0; regions]
        } else {
            let nibbles = fields.bytes(regions.div_ceil(2))?.iter().flat_map(|byte| [byte & 15, byte >> 4]);
            nibbles.take(regions).map(|nibble| nibble as i8 + DELTAS.start()).collect()
        };
        let mut sizes = Vec::with_capacity(regions.min(fields.remaining() + 1));
        for _ in 1..regions {
            sizes.push(fields.varint_u32()? as usize);
        }
        let mut substreams = Vec::with_capacity(regions);
        let base = fields.position();
        let mut end = 0;
        for size in sizes {
            let start = end;
            end += fields.bytes(size)?.len();
            substreams.push(base + start..base + end);
        }
        substreams.push(base + end..payload.len());
        Ok(Layout { header: Header { set, steps, slopes, offset_set, colors }, deltas, substreams })
    }
}

#[cfg(feature = "encode")]
impl Header {
    /// Returns a payload with this header, and the deltas and substreams of all regions.
    pub fn write<S: Keyed>(&self, deltas: &[i8], substreams: &[Vec<u8>]) -> Vec<u8> {
        use crate::container::serialize::PutFields;

        let StepIndices { luma, chroma } = self.steps;
        let ChromaSlopes { green, orange } = self.slopes;
        let mut out = vec![self.set as u8, luma, chroma, green as u8, orange as u8];
        let has_deltas = if deltas.iter().any(|&delta| delta != 0) { HAS_DELTAS } else { 0 };
        out.push((self.offset_set << 4 | self.colors.len()) as u8 | has_deltas);
        for &key in self.colors.as_flattened() {
            if S::BYTES == 1 { out.push(key as u8) } else { out.put_u16(key as u16) }
        }
        for pair in deltas.chunks(2).filter(|_| has_deltas != 0) {
            let nibble = |at: usize| pair.get(at).map_or(0, |delta| (delta - DELTAS.start()) as u8);
            out.push(nibble(0) | nibble(1) << 4);
        }
        for substream in substreams.iter().take(substreams.len().saturating_sub(1)) {
            out.put_varint(substream.len() as u64);
        }
        out.extend(substreams.iter().flatten());
        out
    }
}
