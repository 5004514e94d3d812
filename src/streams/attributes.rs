//! Attributes of a container that say how its footage was made (container.md, "Attributes").

use crate::container::Index;
use crate::error::{Error, Result};
use crate::image::Primaries;

/// Red, green, blue and white, x and y of each, as 32-bit floats.
const CHROMATICITIES: &str = "color.chromaticities";
/// A 64-bit number.
const CLIPPED_PIXELS: &str = "color.clipped_pixels";
/// For each frame three 32-bit numbers: stream, frame, and the frame in its place or [`BLACK`].
const MISSING_FRAMES: &str = "frames.missing";
/// In place of a frame: black light and background.
const BLACK: u32 = u32::MAX;

/// A frame whose file was missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissingFrame {
    /// Index in the stream table.
    pub stream: u32,
    pub frame: u32,
    /// The frame in its place; none for black light and background.
    pub held: Option<u32>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Attributes {
    /// Of colour. Those of Rec. 709 have no attribute.
    pub primaries: Primaries,
    /// Colour pixels that did not fit 8 bits when they were encoded; `None` where there were none, or nothing is known.
    pub clipped_pixels: Option<u64>,
    /// By stream and frame.
    pub missing_frames: Vec<MissingFrame>,
}

impl Default for Attributes {
    fn default() -> Self {
        Attributes { primaries: Primaries::REC709, clipped_pixels: None, missing_frames: Vec::new() }
    }
}

impl Attributes {
    /// # Errors
    /// A value that its attribute cannot have.
    pub fn read(index: &Index) -> Result<Attributes> {
        let _ = index;
        Attributes::from_values(|_| None) // STUB
    }

    fn from_values<'a>(value: impl Fn(&str) -> Option<&'a [u8]>) -> Result<Attributes> {
        let mut read = Attributes::default();
        if let Some(bytes) = value(CHROMATICITIES) {
            let values = numbers::<8>(bytes).ok_or_else(|| wrong(CHROMATICITIES, bytes))?;
            read.primaries = Primaries::from_array(values.map(f32::from_bits))
                .map_err(|error| error.context(format!("attribute {CHROMATICITIES}")))?;
        }
        if let Some(bytes) = value(CLIPPED_PIXELS) {
            let count = bytes.try_into().map_err(|_| wrong(CLIPPED_PIXELS, bytes))?;
            read.clipped_pixels = Some(u64::from_le_bytes(count));
        }
        if let Some(bytes) = value(MISSING_FRAMES) {
            let (records, []) = bytes.as_chunks::<12>() else { return Err(wrong(MISSING_FRAMES, bytes)) };
            let frames = records.iter().filter_map(|record| numbers(record));
            read.missing_frames = frames
                .map(|[stream, frame, held]| MissingFrame { stream, frame, held: Some(held).filter(|at| *at != BLACK) })
                .collect();
        }
        Ok(read)
    }

    /// Names and values; none of what is as usual.
    pub fn to_values(&self) -> Vec<(&'static str, Vec<u8>)> {
        let bytes = |numbers: &mut dyn Iterator<Item = u32>| numbers.flat_map(u32::to_le_bytes).collect::<Vec<u8>>();
        let mut values = Vec::new();
        if !self.primaries.is_rec709() {
            values.push((CHROMATICITIES, bytes(&mut self.primaries.to_array().into_iter().map(f32::to_bits))));
        }
        if let Some(count) = self.clipped_pixels {
            values.push((CLIPPED_PIXELS, count.to_le_bytes().to_vec()));
        }
        if !self.missing_frames.is_empty() {
            let numbers = |missing: &MissingFrame| [missing.stream, missing.frame, missing.held.unwrap_or(BLACK)];
            values.push((MISSING_FRAMES, bytes(&mut self.missing_frames.iter().flat_map(numbers))));
        }
        values
    }
}

/// 32-bit numbers, if these are so many.
fn numbers<const N: usize>(bytes: &[u8]) -> Option<[u32; N]> {
    let (words, []) = bytes.as_chunks::<4>() else { return None };
    let numbers: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
    numbers.try_into().ok()
}

fn wrong(name: &str, bytes: &[u8]) -> Error {
    Error::invalid(format!("attribute {name} has {} bytes, which no value of it has", bytes.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(values: &[(&'static str, Vec<u8>)]) -> Result<Attributes> {
        Attributes::from_values(|name| values.iter().find(|(other, _)| *other == name).map(|(_, value)| value.as_slice()))
    }

    #[test]
    fn attributes_come_back_and_usual_ones_take_no_bytes() {
        assert!(Attributes::default().to_values().is_empty());
        assert_eq!(read(&[]).unwrap(), Attributes::default());
        let missing = |frame, held| MissingFrame { stream: 2, frame, held };
        let all = Attributes {
            primaries: Primaries::ACESCG,
            clipped_pixels: Some(1 << 40),
            missing_frames: vec![missing(3, Some(2)), missing(4, None)],
        };
        assert_eq!(read(&all.to_values()).unwrap(), all);
    }

    #[test]
    fn values_of_another_length_are_refused() {
        for (name, value) in
            [(CHROMATICITIES, vec![0; 31]), (CHROMATICITIES, vec![0; 32]), (CLIPPED_PIXELS, vec![0; 4]), (MISSING_FRAMES, vec![0; 11])]
        {
            let words = read(&[(name, value)]).unwrap_err().to_string();
            assert!(words.contains(name), "{words}");
        }
    }
}
