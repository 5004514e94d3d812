//! Binary models of COLMAP: `cameras.bin` and `images.bin`, little-endian.

use byteorder::{ByteOrder, LittleEndian};

use super::colmap_model::{Image, Intrinsics, Lenses, MODELS};
use super::document::FileCamera;
use super::lens::Distortion;
use codec::error::{Error, Result};

pub const CAMERAS: &str = "cameras.bin";
pub const IMAGES: &str = "images.bin";

/// Bytes of a 2D point of an image: X, Y and the index of its 3D point.
const POINT_BYTES: u64 = 24;

struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn take(&mut self, count: u64) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let count = usize::try_from(count).ok().filter(|count| *count <= rest.len());
        let count = count.ok_or_else(|| Error::invalid_at("", self.at as u64, "the file ends within an entry"))?;
        self.at += count;
        Ok(&rest[..count])
    }

    fn u64(&mut self) -> Result<u64> {
        self.take(8).map(LittleEndian::read_u64)
    }

    fn u32(&mut self) -> Result<u32> {
        self.take(4).map(LittleEndian::read_u32)
    }

    fn i32(&mut self) -> Result<i32> {
        self.take(4).map(LittleEndian::read_i32)
    }

    fn f64s<const N: usize>(&mut self) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        LittleEndian::read_f64_into(self.take(8 * N as u64)?, &mut numbers);
        Ok(numbers)
    }

    /// Returns bytes up to the next zero, as text.
    fn text(&mut self) -> Result<String> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == 0).map_or(u64::MAX, |end| end as u64);
        let text = String::from_utf8_lossy(self.take(end)?).into_owned();
        self.take(1)?;
        Ok(text)
    }
}

pub fn lenses(bytes: &[u8], distortion: &mut Distortion) -> Result<Lenses> {
    let mut fields = Fields { bytes, at: 0 };
    let mut all = Lenses::new();
    for _ in 0..fields.u64()? {
        let (id, number) = (fields.u32()?, fields.i32()?);
        let size = [fields.u64()?, fields.u64()?];
        let known = MODELS.iter().find(|known| known.number == number);
        let known = known.ok_or_else(|| Error::unsupported(format!("camera model {number} is not supported")))?;
        let stored = fields.take(8 * known.parameter_count as u64)?;
        let parameters: Vec<f64> = stored.chunks_exact(8).map(LittleEndian::read_f64).collect();
        let [Ok(width), Ok(height)] = size.map(u32::try_from) else {
            return Err(Error::invalid(format!("camera {id}: {} × {} pixels", size[0], size[1])));
        };
        all.insert(id.into(), Intrinsics::new(known, [width, height], &parameters, distortion)?);
    }
    Ok(all)
}

pub fn images(bytes: &[u8], lenses: &Lenses) -> Result<Vec<FileCamera>> {
    let mut fields = Fields { bytes, at: 0 };
    let mut cameras = Vec::new();
    for _ in 0..fields.u64()? {
        let id = fields.u32()?;
        let image =
            Image { turn: fields.f64s()?, shift: fields.f64s()?, camera: fields.u32()?.into(), name: fields.text()? };
        let points = fields.u64()?;
        fields.take(points.saturating_mul(POINT_BYTES))?;
        cameras.push(image.camera(lenses).map_err(|error| error.context(format!("image {id}")))?);
    }
    Ok(cameras)
}
