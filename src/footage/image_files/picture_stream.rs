//! Image streams for other programs, such as ffmpeg: concatenated PNG files, Y4M, or raw samples.
//!
//! Takes images of one size, in order, and their frame rate; writes bytes to a pipe.
//!
//! - `Png`: each image as a PNG file. 16-bit depth codes and the alpha of rendered images are kept.
//! - `Y4m`: YUV4MPEG2, 8 bits, 4:4:4, BT.709 in limited range. Images with alpha are composited over black.
//! - `Raw`: a text line, `width=W height=H pixel_format=F fps=N/D`, then the images in row order without padding. F is `rgb24`,
//!   composited over black, or `gray16le`.

use std::fmt;
use std::io::Write;

use super::png;
use codec::error::{Error, Result};
use codec::image::plane::Plane;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamFormat {
    Png,
    Y4m,
    Raw,
}

/// An image of integer codes, as stored in PNG files.
#[derive(Debug, Clone, PartialEq)]
pub enum CodePicture {
    Gray16(Plane<u16>),
    Rgb8(Plane<[u8; 3]>),
    /// Colour is not premultiplied by alpha.
    Rgba8(Plane<[u8; 4]>),
}

impl CodePicture {
    pub fn size(&self) -> [u32; 2] {
        match self {
            CodePicture::Gray16(plane) => [plane.width(), plane.height()],
            CodePicture::Rgb8(plane) => [plane.width(), plane.height()],
            CodePicture::Rgba8(plane) => [plane.width(), plane.height()],
        }
    }

    /// Writes the image as a PNG file.
    pub fn encode_png(&self, out: &mut dyn Write) -> Result<()> {
        match self {
            CodePicture::Gray16(plane) => png::encode_depth16(out, plane),
            CodePicture::Rgb8(plane) => png::encode_color8(out, plane),
            CodePicture::Rgba8(plane) => png::encode_rgba8(out, plane),
        }
    }

    /// Returns the RGB codes in row order, composited over black; `None` for gray images.
    fn rgb(&self) -> Option<Vec<[u8; 3]>> {
        let over_black = |&[r, g, b, alpha]: &[u8; 4]| {
            [r, g, b].map(|code| ((u32::from(code) * u32::from(alpha) + 127) / 255) as u8)
        };
        match self {
            CodePicture::Gray16(_) => None,
            CodePicture::Rgb8(plane) => Some(plane.data().to_vec()),
            CodePicture::Rgba8(plane) => Some(plane.data().iter().map(over_black).collect()),
        }
    }

    /// Returns the ffmpeg name of the pixel format of [`StreamFormat::Raw`].
    fn pixel_format(&self) -> &'static str {
        if matches!(self, CodePicture::Gray16(_)) { "gray16le" } else { "rgb24" }
    }
}

/// Frame rate in images per second, as a fraction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRate {
    pub numerator: u32,
    pub denominator: u32,
}

impl FrameRate {
    const MAX_TERM: f64 = i32::MAX as f64;

    /// Converts `fps`, above 0, to a fraction. Rates such as 23.976 and 29.97 become multiples of 1000/1001, the NTSC rates.
    pub fn of(fps: f64) -> FrameRate {
        let of_television = (fps * 1.001).round();
        let is_whole = fps.fract() == 0.0;
        if !is_whole && of_television <= 1e6 && (fps * 1.001 - of_television).abs() < 1e-3 && of_television >= 1.0 {
            return FrameRate { numerator: 1000 * of_television as u32, denominator: 1001 };
        }
        // Continued fraction expansion.
        let (mut rest, [mut p, mut q], [mut before_p, mut before_q]) = (fps, [1.0, 0.0], [0.0, 1.0]);
        loop {
            let whole = rest.floor();
            let [next_p, next_q] = [whole * p + before_p, whole * q + before_q];
            if next_p > Self::MAX_TERM || next_q > Self::MAX_TERM {
                break;
            }
            ([before_p, before_q], [p, q]) = ([p, q], [next_p, next_q]);
            if (p / q - fps).abs() <= 1e-9 * fps || rest <= whole {
                break;
            }
            rest = 1.0 / (rest - whole);
        }
        if q == 0.0 {
            return FrameRate { numerator: i32::MAX as u32, denominator: 1 };
        }
        if p == 0.0 {
            return FrameRate { numerator: 1, denominator: i32::MAX as u32 };
        }
        FrameRate { numerator: p as u32, denominator: q as u32 }
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}

/// Writer of an image stream.
#[derive(Debug)]
pub struct PictureStream<W: Write> {
    out: W,
    format: StreamFormat,
    rate: FrameRate,
    /// Size and pixel format of all images; `None` before the first one.
    layout: Option<([u32; 2], &'static str)>,
    /// Number of bytes written.
    pub bytes: u64,
}

impl<W: Write> PictureStream<W> {
    pub fn new(out: W, format: StreamFormat, rate: FrameRate) -> PictureStream<W> {
        PictureStream { out, format, rate, layout: None, bytes: 0 }
    }

    pub fn format(&self) -> StreamFormat {
        self.format
    }

    /// Writes the next image.
    ///
    /// # Errors
    /// [`Error::Usage`] if the format cannot hold the image, or if its size or pixel format differs from that of the first image;
    /// [`Error::Io`] if writing fails, for example because the reader closed the pipe.
    pub fn put(&mut self, picture: &CodePicture) -> Result<()> {
        let layout = (picture.size(), picture.pixel_format());
        let is_first = self.layout.is_none();
        let (size @ [width, height], pixel_format) = *self.layout.get_or_insert(layout);
        if layout != (size, pixel_format) {
            let [other_width, other_height] = layout.0;
            return Err(Error::Usage(format!(
                "a picture of {other_width}x{other_height} pixels follows one of {width}x{height}: all pictures of a \
                stream must have the same size"
            )));
        }
        let rate = self.rate;
        let mut bytes = Vec::new();
        match (self.format, picture.rgb(), picture) {
            (StreamFormat::Png, ..) => picture.encode_png(&mut bytes)?,
            (StreamFormat::Y4m, Some(rgb), _) => {
                if is_first {
                    let FrameRate { numerator, denominator } = rate;
                    let head = format!(
                        "YUV4MPEG2 W{width} H{height} F{numerator}:{denominator} Ip A1:1 C444 XCOLORRANGE=LIMITED\n"
                    );
                    bytes.extend(head.into_bytes());
                }
                bytes.extend(b"FRAME\n");
                let pixels: Vec<[u8; 3]> = rgb.into_iter().map(yuv).collect();
                (0..3).for_each(|plane| bytes.extend(pixels.iter().map(|pixel| pixel[plane])));
            }
            (StreamFormat::Raw, rgb, _) => {
                if is_first {
                    let head = format!("width={width} height={height} pixel_format={pixel_format} fps={rate}\n");
                    bytes.extend(head.into_bytes());
                }
                match (rgb, picture) {
                    (Some(rgb), _) => bytes.extend(rgb.as_flattened()),
                    (None, CodePicture::Gray16(plane)) => {
                        bytes.extend(plane.data().iter().flat_map(|code| code.to_le_bytes()));
                    }
                    _ => {}
                }
            }
            (StreamFormat::Y4m, None, _) => {
                return Err(Error::Usage(
                    "Y4M stores 8-bit colour only, and depth has 16-bit codes: use `stream_format` png or raw".into(),
                ));
            }
        }
        self.bytes += bytes.len() as u64;
        self.out.write_all(&bytes).and_then(|()| self.out.flush()).map_err(|error| Error::io("-", error))
    }
}

/// Converts RGB to Y, Cb, Cr of BT.709 in limited range, rounded to nearest.
fn yuv(rgb: [u8; 3]) -> [u8; 3] {
    const RED: f64 = 0.2126;
    const BLUE: f64 = 0.0722;
    let [r, g, b] = rgb.map(|code| f64::from(code) / 255.0);
    let y = RED * r + (1.0 - RED - BLUE) * g + BLUE * b;
    let chroma = |value: f64, weight: f64| 128.0 + 224.0 * (value - y) / (2.0 * (1.0 - weight));
    [16.0 + 219.0 * y, chroma(b, BLUE), chroma(r, RED)].map(|code| code.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(fps: f64) -> String {
        FrameRate::of(fps).to_string()
    }

    #[test]
    fn rates_are_the_fractions_that_are_meant() {
        let expected = [
            (24.0, "24/1"),
            (23.976, "24000/1001"),
            (24000.0 / 1001.0, "24000/1001"),
            (29.97, "30000/1001"),
            (59.94, "60000/1001"),
            (12.5, "25/2"),
            (0.1, "1/10"),
            (1.0 / 3.0, "1/3"),
            (1e300, "2147483647/1"),
            (1e-300, "1/2147483647"),
        ];
        for (fps, fraction) in expected {
            assert_eq!(rate(fps), fraction, "{fps}");
        }
        let FrameRate { numerator, denominator } = FrameRate::of(std::f64::consts::PI);
        assert!((f64::from(numerator) / f64::from(denominator) - std::f64::consts::PI).abs() < 1e-8);
    }

    fn stream(format: StreamFormat, pictures: &[CodePicture]) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut stream = PictureStream::new(&mut bytes, format, FrameRate::of(29.97));
        pictures.iter().try_for_each(|picture| stream.put(picture))?;
        let written = stream.bytes;
        assert_eq!(written, bytes.len() as u64);
        Ok(bytes)
    }

    #[test]
    fn y4m_is_bt709_in_limited_range() {
        let colors = [[0; 3], [255; 3], [255, 0, 0], [0, 255, 0], [0, 0, 255]];
        // ITU-R BT.709-6, table 4: quantised levels of black, white and the primaries.
        let expected = [[16, 128, 128], [235, 128, 128], [63, 102, 240], [173, 42, 26], [32, 240, 118]];
        assert_eq!(colors.map(yuv), expected);
        let picture = CodePicture::Rgba8(Plane::new(2, 1, vec![[255, 255, 255, 255], [255, 0, 0, 0]]).unwrap());
        let bytes = stream(StreamFormat::Y4m, &[picture.clone(), picture]).unwrap();
        let mut expected = b"YUV4MPEG2 W2 H1 F30000:1001 Ip A1:1 C444 XCOLORRANGE=LIMITED\n".to_vec();
        for _ in 0..2 {
            expected.extend(b"FRAME\n\xeb\x10\x80\x80\x80\x80");
        }
        assert_eq!(bytes, expected);
    }

    #[test]
    fn raw_codes_follow_a_line_of_text() {
        let color = CodePicture::Rgb8(Plane::new(1, 2, vec![[1, 2, 3], [4, 5, 6]]).unwrap());
        let expected = b"width=1 height=2 pixel_format=rgb24 fps=30000/1001\n\x01\x02\x03\x04\x05\x06".to_vec();
        assert_eq!(stream(StreamFormat::Raw, std::slice::from_ref(&color)).unwrap(), expected);
        let depth = CodePicture::Gray16(Plane::new(2, 1, vec![0x0102, 0xfffe]).unwrap());
        let expected = b"width=2 height=1 pixel_format=gray16le fps=30000/1001\n\x02\x01\xfe\xff".to_vec();
        assert_eq!(stream(StreamFormat::Raw, std::slice::from_ref(&depth)).unwrap(), expected);
        assert!(stream(StreamFormat::Y4m, std::slice::from_ref(&depth)).unwrap_err().to_string().contains("16-bit"));
        assert!(stream(StreamFormat::Png, &[color, depth]).unwrap_err().to_string().contains("the same size"));
    }
}
