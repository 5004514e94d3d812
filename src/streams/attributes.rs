//! Attributes of a container that say how its footage was made (container.md, "Attributes").

use crate::container::Index;
use crate::error::{Error, Result};
use crate::image::Primaries;

/// Chromaticities of colour: red, green, blue and white, x and y of each, 32-bit floats. Without it they are those of Rec. 709.
pub const CHROMATICITIES: &str = "color.chromaticities";
/// Colour pixels that did not fit 8 bits: a 64-bit number. Without it nothing is known of any.
pub const CLIPPED_PIXELS: &str = "color.clipped_pixels";
/// Frames whose file was missing: stream, frame, and the frame in its place or [`BLACK`], 32-bit numbers each.
pub const MISSING_FRAMES: &str = "frames.missing";
/// In place of a frame: black light and background.
const BLACK: u32 = u32::MAX;

/// A frame whose file was missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissingFrame {
    /// Index in the stream table.
    pub stream: u32,
    pub frame: u32,
    /// The frame that stands in its place; none for black light and background.
    pub held: Option<u32>,
}

fn bytes_of<'a>(index: &'a Index, name: &str) -> Option<&'a [u8]> {
    let _ = (index, name);
    None // STUB until merge
}

fn wrong(name: &str, bytes: &[u8]) -> Error {
    Error::invalid(format!("the attribute {name} has {} bytes, which no value of it has", bytes.len()))
}

/// The primaries of a container's colour.
pub fn primaries(index: &Index) -> Result<Primaries> {
    let Some(bytes) = bytes_of(index, CHROMATICITIES) else { return Ok(Primaries::REC709) };
    let (values, []) = bytes.as_chunks() else { return Err(wrong(CHROMATICITIES, bytes)) };
    let values: Vec<f32> = values.iter().copied().map(f32::from_le_bytes).collect();
    let values = values.try_into().map_err(|_| wrong(CHROMATICITIES, bytes))?;
    Primaries::from_array(values).map_err(|error| error.context(format!("the attribute {CHROMATICITIES}")))
}

/// The attribute of primaries; none for those of Rec. 709.
pub fn of_primaries(primaries: Primaries) -> Option<Vec<u8>> {
    (!primaries.is_rec709()).then(|| primaries.to_array().into_iter().flat_map(f32::to_le_bytes).collect())
}

/// Colour pixels that encoding clipped, where that is known.
pub fn clipped_pixels(index: &Index) -> Result<Option<u64>> {
    let Some(bytes) = bytes_of(index, CLIPPED_PIXELS) else { return Ok(None) };
    let count = bytes.try_into().map_err(|_| wrong(CLIPPED_PIXELS, bytes))?;
    Ok(Some(u64::from_le_bytes(count)))
}

/// The frames whose files were missing, by stream and frame.
pub fn missing_frames(index: &Index) -> Result<Vec<MissingFrame>> {
    let Some(bytes) = bytes_of(index, MISSING_FRAMES) else { return Ok(Vec::new()) };
    let (records, []) = bytes.as_chunks::<12>() else { return Err(wrong(MISSING_FRAMES, bytes)) };
    let number = |record: &[u8; 12], at: usize| u32::from_le_bytes(std::array::from_fn(|byte| record[4 * at + byte]));
    let frame = |record: &[u8; 12]| MissingFrame {
        stream: number(record, 0),
        frame: number(record, 1),
        held: Some(number(record, 2)).filter(|held| *held != BLACK),
    };
    Ok(records.iter().map(frame).collect())
}

/// The attribute of missing frames; none without any.
pub fn of_missing_frames(frames: &[MissingFrame]) -> Option<Vec<u8>> {
    let numbers = |missing: &MissingFrame| [missing.stream, missing.frame, missing.held.unwrap_or(BLACK)];
    (!frames.is_empty()).then(|| frames.iter().flat_map(numbers).flat_map(u32::to_le_bytes).collect())
}
