//! Reads pictures back from the device and assembles each from its units.

use half::f16;

use crate::GpuDecoder;
use crate::family::PixelWords;
use codec::decode::{Picture, StreamInfo, UnitFilter};
use codec::error::Result;
use codec::image::{Plane, StreamKind};
use codec::streams::convert::alpha_byte;
use kernels::pictures::{leave_out, unpack_bytes, unpack_codes, unpack_halves};

impl GpuDecoder<'_> {
    pub fn read(&mut self) -> Result<Vec<Picture>> {
        self.wait()?;
        let words = self.gpu.read(&self.buffers.pictures, self.buffers.pictures.size() as usize / 4)?;
        Ok(self
            .streams
            .iter()
            .zip(&self.first_units)
            .map(|(stream, &first)| self.picture(stream, first, &words))
            .collect())
    }

    /// As [`GpuDecoder::read`], with units that the filter excludes filled with background or 0.
    pub fn read_wanted(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Vec<Picture>> {
        let mut pictures = self.read()?;
        for (picture, stream) in pictures.iter_mut().zip(&self.streams) {
            let unwanted = (0..stream.entry.unit_count()).filter(|&unit| !filter.wants(stream, unit, frame));
            unwanted.for_each(|unit| leave_out(picture, stream.entry.unit_rect(unit)));
        }
        Ok(pictures)
    }

    fn picture(&self, stream: &StreamInfo, first: usize, words: &[u32]) -> Picture {
        match self.family.words {
            PixelWords::Codes => {
                let codes = self.assemble(stream, first, words, unpack_codes);
                match stream.kind {
                    StreamKind::Alpha => Picture::Alpha(codes.map(|&code| alpha_byte(code))),
                    _ => Picture::Depth(codes),
                }
            }
            PixelWords::Bytes if self.family.is_color => Picture::Color8(self.assemble(stream, first, words, bytes_of)),
            PixelWords::Bytes => Picture::Material(self.assemble(stream, first, words, bytes_of)),
            PixelWords::Halves => Picture::ColorHalf(self.assemble(stream, first, words, halves_of)),
        }
    }

    /// Assembles the units of a stream; `unpack` converts the words of a row.
    fn assemble<T: Copy + Default>(
        &self,
        stream: &StreamInfo,
        first: usize,
        words: &[u32],
        unpack: impl Fn(&[u32], &mut [T]),
    ) -> Plane<T> {
        let mut plane = Plane::filled(stream.entry.width, stream.entry.height, T::default());
        for (number, unit) in (0..stream.entry.unit_count()).zip(&self.units[first..]) {
            let [left, top, width, height] = stream.entry.unit_rect(number);
            for y in 0..height {
                let row = &words[(unit.picture + y * unit.stride) as usize..][..unit.stride as usize];
                unpack(row, &mut plane.row_mut(top + y)[left as usize..(left + width) as usize]);
            }
        }
        plane
    }
}

fn bytes_of(words: &[u32], out: &mut [[u8; 3]]) {
    out.iter_mut().zip(words).for_each(|(pixel, &word)| *pixel = unpack_bytes(word));
}

fn halves_of(words: &[u32], out: &mut [[f16; 3]]) {
    for (pixel, &words) in out.iter_mut().zip(words.as_chunks().0) {
        *pixel = unpack_halves(words).map(f16::from_bits);
    }
}
