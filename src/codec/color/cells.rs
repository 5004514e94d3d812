//! Payload of a chunk of one colour cell: keyframes and weights (color.md 4).

#[cfg(feature = "encode")]
pub mod builder;

use crate::color::blend::Sample;
use crate::color::keyframe_blocks::KeyframeBlocks;
use crate::container::fields::Fields;
use crate::container::{ChunkPlace, Payload};
use crate::error::{Error, Result};

const SECTION: &str = "color.md 4";
/// Flag: the keyframe after the last one is the first keyframe of the cell's next chunk.
const CLOSED_BY_NEXT: u8 = 1;
/// Maximum number of weights in a chunk: more than twelve hours at 24 frames per second (color.md 4).
pub const MAX_WEIGHTS: u32 = 1 << 20;
const KEYFRAME_ROW_BYTES: usize = 4;
/// Bit of a keyframe row, in codecs with blocks: the keyframe is stored as samples.
const AS_SAMPLES: u32 = 1 << 31;

/// Error of a cell whose last chunk has a weight after its last keyframe.
pub const MISSING_NEXT_KEYFRAME: &str = "a cell's last chunk leads to a next one, and there is none";

#[derive(Debug, Clone, Copy)]
pub struct CellFormat<S> {
    pub size: [usize; 2],
    /// Block format of keyframes; `None` if all keyframes are samples.
    pub blocks: Option<KeyframeBlocks<S>>,
}

impl<S: Sample> CellFormat<S> {
    pub fn of_samples(width: usize, height: usize) -> CellFormat<S> {
        CellFormat { size: [width, height], blocks: None }
    }

    pub fn pixels(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Bytes of a keyframe in blocks (`None` if the codec has none), and of a keyframe in samples.
    fn keyframe_bytes(&self) -> [Option<u64>; 2] {
        let blocks = self.blocks.map(|blocks| blocks.image_bytes(self.size) as u64);
        [blocks, Some(self.pixels() as u64 * 3 * S::BYTES as u64)]
    }
}

#[derive(Debug, Clone, Copy)]
struct Place {
    start: usize,
    bytes: usize,
    in_blocks: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blend {
    /// Index in the chunk of the keyframe at or before the frame.
    pub keyframe: usize,
    /// Weight of the next keyframe, in 255ths; 0 shows the keyframe itself.
    pub weight: u8,
}

#[derive(Debug, Clone)]
pub struct CellChunk<S> {
    pub payload: Payload,
    pub keyframes: Vec<u32>,
    places: Vec<Place>,
    weights: std::ops::Range<usize>,
    /// True if frames after the last keyframe may need the next chunk.
    pub closed_by_next: bool,
    pub format: CellFormat<S>,
}

impl<S: Sample> CellChunk<S> {
    /// As [`Self::parse`], and the last chunk of a cell must not lead to a next one. Such a chunk is refused as a whole, so
    /// that the frames that can be decoded do not depend on the one that is requested.
    pub fn parse_at(
        payload: impl Into<Payload>,
        format: CellFormat<S>,
        frame_count: u32,
        place: ChunkPlace,
    ) -> Result<Self> {
        let chunk = Self::parse(payload, format, frame_count)?;
        if place == ChunkPlace::Last && chunk.leads_on() {
            Err(Error::invalid(MISSING_NEXT_KEYFRAME))
        } else {
            Ok(chunk)
        }
    }

    /// Parses and checks a payload: all keyframes lie inside, their frames ascend from 0, and each weight other than 0 is
    /// between two keyframes or is closed by the next chunk.
    pub fn parse(payload: impl Into<Payload>, format: CellFormat<S>, frame_count: u32) -> Result<Self> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let (count, flags) = (fields.u16()?, fields.u8()?);
        fields.zeros(1)?;
        let weight_count = fields.u32()?;
        if count == 0
            || u32::from(count) > frame_count
            || flags > CLOSED_BY_NEXT
            || weight_count > frame_count.min(MAX_WEIGHTS)
        {
            return Err(fields.error(format!(
                "{count} keyframes, {weight_count} weights and flags {flags} for {frame_count} frames are impossible"
            )));
        }
        let mut keyframes = Vec::with_capacity(usize::from(count));
        let mut in_blocks = Vec::with_capacity(usize::from(count));
        for at in 0..usize::from(count) {
            let row = fields.u32()?;
            // Without blocks the bit belongs to the frame number, which is then out of range.
            let frame = if format.blocks.is_some() { row & !AS_SAMPLES } else { row };
            let ascends = if at == 0 { frame == 0 } else { frame > keyframes[at - 1] };
            if !ascends || frame >= frame_count {
                return Err(fields.error(format!("keyframe {at} at frame {frame} is out of order or out of range")));
            }
            keyframes.push(frame);
            in_blocks.push(format.blocks.is_some() && row & AS_SAMPLES == 0);
        }
        let start = fields.position();
        let weights = fields.bytes(weight_count as usize)?;
        let at_keyframe = keyframes.iter().any(|&frame| weights.get(frame as usize).is_some_and(|&weight| weight != 0));
        let after_last = keyframes[keyframes.len() - 1] as usize + 1;
        let unclosed = flags & CLOSED_BY_NEXT == 0 && weights.iter().skip(after_last).any(|&weight| weight != 0);
        if at_keyframe || unclosed {
            return Err(fields.error("a weight is not between two keyframes"));
        }
        let weights = start..fields.position();
        let sizes = format.keyframe_bytes();
        let bytes_of = |&in_blocks: &bool| sizes[usize::from(!in_blocks)].unwrap_or(0);
        let wanted: u64 = in_blocks.iter().map(bytes_of).sum();
        if wanted != fields.remaining() as u64 {
            return Err(fields.error(format!("keyframes of {wanted} bytes expected, {} there", fields.remaining())));
        }
        let mut start = weights.end;
        let places = in_blocks.iter().map(|in_blocks| {
            let place = Place { start, bytes: bytes_of(in_blocks) as usize, in_blocks: *in_blocks };
            start += place.bytes;
            place
        });
        let places = places.collect();
        Ok(CellChunk { payload, keyframes, places, weights, closed_by_next: flags == CLOSED_BY_NEXT, format })
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.payload.into_spare()
    }

    /// Returns the payload offset of the weights, and the weights of the first frames; all later frames have weight 0.
    pub fn weights(&self) -> (usize, &[u8]) {
        (self.weights.start, &self.payload[self.weights.clone()])
    }

    pub fn keyframe_at(&self, keyframe: usize) -> usize {
        self.places[keyframe].start
    }

    /// Number of frames, from the first on, that have a stored weight; later ones have weight 0.
    pub fn weight_count(&self) -> u32 {
        self.weights.len() as u32
    }

    /// Payload bytes of a keyframe, including its row in the table of keyframes.
    pub fn keyframe_bytes(&self, keyframe: usize) -> u64 {
        (KEYFRAME_ROW_BYTES + self.places[keyframe].bytes) as u64
    }

    pub fn in_blocks(&self, keyframe: usize) -> bool {
        self.places[keyframe].in_blocks
    }

    pub fn blend(&self, frame: u32) -> Blend {
        let keyframe = self.keyframes.partition_point(|&first| first <= frame) - 1;
        let weight = self.payload[self.weights.clone()].get(frame as usize).copied().unwrap_or(0);
        Blend { keyframe, weight }
    }

    pub fn is_last(&self, keyframe: usize) -> bool {
        keyframe + 1 == self.keyframes.len()
    }

    pub fn leads_on(&self) -> bool {
        let after_last = self.keyframes.last().map_or(0, |&frame| frame as usize + 1);
        self.weights().1.iter().skip(after_last).any(|&weight| weight != 0)
    }

    /// Decodes a keyframe into `out`: three samples per pixel, for all pixels.
    pub fn read_keyframe(&self, keyframe: usize, out: &mut [S]) {
        let Place { start, bytes, in_blocks } = self.places[keyframe];
        let stored = &self.payload[start..start + bytes];
        match self.format.blocks {
            Some(blocks) if in_blocks => (blocks.decode)(stored, self.format.size, out),
            _ => S::get_row(out, stored),
        }
    }
}
