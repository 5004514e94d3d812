//! Writes the payload of a chunk of one colour cell (color.md 4).

use crate::color::blend::Sample;
use crate::color::cells::{AS_SAMPLES, CLOSED_BY_NEXT, KEYFRAME_ROW_BYTES, MAX_WEIGHTS};
use crate::container::serialize::PutFields;
use crate::error::{Error, Result};

const FIXED_BYTES: usize = 8;

#[derive(Debug, Default)]
pub struct CellBuilder {
    keyframes: Vec<u32>,
    weights: Vec<u8>,
    samples: Vec<u8>,
}

impl CellBuilder {
    pub fn push_keyframe<S: Sample>(&mut self, samples: &[S]) {
        self.keyframes.push(self.weights.len() as u32);
        self.weights.push(0);
        self.samples.reserve(samples.len() * S::BYTES);
        samples.iter().for_each(|sample| sample.put(&mut self.samples));
    }

    /// Adds a keyframe at the next frame, stored as samples, in a codec with blocks.
    pub fn push_keyframe_as_samples<S: Sample>(&mut self, samples: &[S]) {
        self.push_keyframe(samples);
        if let Some(row) = self.keyframes.last_mut() {
            *row |= AS_SAMPLES;
        }
    }

    pub fn push_keyframe_in_blocks(&mut self, blocks: &[u8]) {
        self.keyframes.push(self.weights.len() as u32);
        self.weights.push(0);
        self.samples.extend_from_slice(blocks);
    }

    pub fn push_weight(&mut self, weight: u8, run: u32) {
        self.weights.resize(self.weights.len() + run as usize, weight);
    }

    pub fn frame_count(&self) -> u32 {
        self.weights.len() as u32
    }

    pub fn keyframe_count(&self) -> usize {
        self.keyframes.len()
    }

    pub fn bytes(&self) -> usize {
        FIXED_BYTES + KEYFRAME_ROW_BYTES * self.keyframes.len() + self.weights.len() + self.samples.len()
    }

    /// Returns the payload. Weights other than 0 after the last keyframe lead to the next chunk.
    pub fn finish(self) -> Result<Vec<u8>> {
        let Ok(count) = u16::try_from(self.keyframes.len()) else {
            return Err(Error::unsupported(format!("a chunk of {} keyframes", self.keyframes.len())));
        };
        let used = self.weights.iter().rposition(|&weight| weight != 0).map_or(0, |last| last + 1);
        if used > MAX_WEIGHTS as usize {
            return Err(Error::unsupported(format!("a chunk of {used} weights; at most {MAX_WEIGHTS} fit")));
        }
        let last = self.keyframes.last().map_or(0, |&row| (row & !AS_SAMPLES) as usize);
        let mut payload = Vec::with_capacity(self.bytes());
        payload.put_u16(count);
        payload.push(if used > last { CLOSED_BY_NEXT } else { 0 });
        payload.push(0);
        payload.put_u32(used as u32);
        self.keyframes.iter().for_each(|&frame| payload.put_u32(frame));
        payload.extend_from_slice(&self.weights[..used]);
        payload.extend_from_slice(&self.samples);
        Ok(payload)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::cells::{CellChunk, CellFormat};

    fn sample() -> Vec<u8> {
        let mut builder = CellBuilder::default();
        builder.push_keyframe::<u8>(&[10, 20, 30, 40, 50, 60]);
        builder.push_weight(100, 1);
        builder.push_weight(200, 2);
        builder.push_keyframe::<u8>(&[1, 2, 3, 4, 5, 6]);
        builder.push_weight(0, 3);
        builder.finish().unwrap()
    }

    #[test]
    fn keyframes_and_weights_come_back() {
        let chunk = CellChunk::<u8>::parse(sample(), CellFormat::of_samples(2, 1), 8).unwrap();
        assert_eq!(chunk.keyframes, [0, 4]);
        assert_eq!((chunk.weight_count(), chunk.keyframe_bytes(1)), (4, 10));
        let blends: Vec<_> = (0..8).map(|frame| chunk.blend(frame)).map(|b| (b.keyframe, b.weight)).collect();
        assert_eq!(blends, [(0, 0), (0, 100), (0, 200), (0, 200), (1, 0), (1, 0), (1, 0), (1, 0)]);
        let mut samples = [0; 6];
        chunk.read_keyframe(1, &mut samples);
        assert_eq!(samples, [1, 2, 3, 4, 5, 6]);
        assert!(chunk.is_last(1) && !chunk.is_last(0));
    }

    #[test]
    fn damaged_payloads_are_refused() {
        let good = sample();
        for length in 0..good.len() {
            assert!(CellChunk::<u8>::parse(good[..length].to_vec(), CellFormat::of_samples(2, 1), 8).is_err());
        }
        for at in 0..good.len() {
            for bit in 0..8 {
                let mut damaged = good.clone();
                damaged[at] ^= 1 << bit;
                if let Ok(chunk) = CellChunk::<u8>::parse(damaged, CellFormat::of_samples(2, 1), 8) {
                    let mut samples = [0; 6];
                    for frame in 0..8 {
                        chunk.read_keyframe(chunk.blend(frame).keyframe, &mut samples);
                    }
                }
            }
        }
        assert!(CellChunk::<u8>::parse(good.clone(), CellFormat::of_samples(3, 1), 8).is_err());
        assert!(CellChunk::<u8>::parse(good, CellFormat::of_samples(2, 1), 4).is_err());
    }

    #[test]
    fn weights_are_limited() {
        let mut builder = CellBuilder::default();
        builder.push_keyframe::<u8>(&[1, 2, 3]);
        builder.push_weight(7, MAX_WEIGHTS - 1);
        let payload = builder.finish().unwrap();
        assert!(CellChunk::<u8>::parse(payload.clone(), CellFormat::of_samples(1, 1), MAX_WEIGHTS + 1).is_ok());
        let mut more = payload;
        more[4..8].copy_from_slice(&(MAX_WEIGHTS + 1).to_le_bytes());
        more.insert(12, 7);
        assert!(CellChunk::<u8>::parse(more, CellFormat::of_samples(1, 1), MAX_WEIGHTS + 1).is_err());
        let mut builder = CellBuilder::default();
        builder.push_keyframe::<u8>(&[1, 2, 3]);
        builder.push_weight(7, MAX_WEIGHTS);
        assert!(builder.finish().is_err());
    }

    #[test]
    fn a_weight_with_nothing_to_lead_to_is_refused() {
        let mut builder = CellBuilder::default();
        builder.push_keyframe::<u8>(&[1, 2, 3]);
        builder.push_weight(7, 1);
        let mut payload = builder.finish().unwrap();
        assert!(CellChunk::<u8>::parse(payload.clone(), CellFormat::of_samples(1, 1), 2).is_ok());
        payload[2] = 0;
        assert!(CellChunk::<u8>::parse(payload, CellFormat::of_samples(1, 1), 2).is_err());
    }
}
