//! Measures a point: once for all that is not time, and again for each timed run.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::commands::{self, Input, decoder_passes};
use super::point::{Measured, Point, Quality, Sizes, Timing};
use crate::dataset::stream::StreamKind;
use crate::error::{Error, Result};

/// Runs command lines of this program. Implemented by the command line.
pub trait Runner {
    /// Runs a command and answers the JSON that it printed. An error names the command.
    fn run(&self, words: &[OsString]) -> Result<Value>;

    /// Seconds since the program began.
    fn now_seconds(&self) -> f64;
}

/// Seconds that a point takes, as far as is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// The first pass: sizes, quality, memory.
    pub survey: f64,
    /// Each timed run.
    pub run: f64,
}

/// Measures points of one input.
pub struct Bench<'a> {
    runner: &'a dyn Runner,
    input: &'a Input,
    container: PathBuf,
    packed: PathBuf,
    /// Bytes of what was encoded, by the command line.
    known_bytes: BTreeMap<Vec<OsString>, u64>,
    /// Graphics devices that decoded.
    devices: Vec<String>,
}

impl<'a> Bench<'a> {
    /// A bench that writes containers into the folder `work`.
    pub fn new(runner: &'a dyn Runner, input: &'a Input, work: &Path) -> Bench<'a> {
        Bench {
            runner,
            input,
            container: work.join("point.lfold"),
            packed: work.join("packed.lfold"),
            known_bytes: BTreeMap::new(),
            devices: Vec::new(),
        }
    }

    /// The mark of the input.
    pub fn made_of(&self) -> u32 {
        self.input.made_of
    }

    /// Graphics devices that decoded any point.
    pub fn devices(&self) -> &[String] {
        &self.devices
    }

    /// Seconds on the runner's clock.
    pub fn now_seconds(&self) -> f64 {
        self.runner.now_seconds()
    }

    /// The command that a user would give for a point.
    pub fn command(&self, point: &Point) -> String {
        let mut words = self.input.encode(point);
        words.extend(["-o".into(), "point.lfold".into()]);
        commands::shell_line(&words)
    }

    /// All of a point that is not time. Encoding and decoding it is the warm-up as well.
    pub fn survey(&mut self, point: &Point) -> Result<(Measured, Cost)> {
        let start = self.runner.now_seconds();
        let words = self.input.encode(point);
        let encoded = self.json(&commands::into_file(words.clone(), &self.container))?;
        let encode_seconds = self.runner.now_seconds() - start;
        let (container, raw) = (encoded.count("bytes")?, encoded.count("raw_bytes")?);
        self.known_bytes.insert(words, container);
        let decode_start = self.runner.now_seconds();
        let decoded = self.json(&self.input.decode(point, &self.container, 1))?;
        let decode_seconds = self.runner.now_seconds() - decode_start;
        let pass_seconds = decoded.number("seconds")?;
        let quality = self.quality(point)?;
        let lzma2 = match point.value("lzma2").filter(|level| *level != "none") {
            Some(_) => container,
            None => self.json(&commands::pack(&self.container, &self.packed))?.count("bytes")?,
        };
        let temporal = self.bytes(self.input.temporal(point))?;
        let spatial = self.input.spatial(point).map(|words| self.bytes(words)).transpose()?;
        if let Some(device) = decoded.value["device"].as_str().filter(|name| *name != "cpu")
            && !self.devices.iter().any(|known| known == device)
        {
            self.devices.push(device.to_owned());
        }
        let measured = Measured {
            point: point.clone(),
            sizes: Sizes { raw, temporal, spatial, container, lzma2 },
            quality,
            encode: Timing::default(),
            decode: Timing::default(),
            frames: self.input.frames(point.kind),
            images: decoded.count("frames")?,
            pixels: decoded.count("pixels")?,
            updated_pixels: decoded.count("updated_pixels")?,
            decode_passes: decoder_passes(pass_seconds),
            encode_peak_bytes: encoded.value["peak_memory_bytes"].as_u64(),
            decode_peak_bytes: decoded.value["peak_memory_bytes"].as_u64(),
        };
        // There were one warm-up and one pass of the decoder.
        let more = measured.decode_passes - 1;
        let run = encode_seconds + decode_seconds + pass_seconds * f64::from(more);
        Ok((measured, Cost { survey: self.runner.now_seconds() - start, run }))
    }

    /// One timed run of a point: seconds of encoding, and the median of so many passes of decoding.
    pub fn time(&mut self, point: &Point, passes: u32) -> Result<[f64; 2]> {
        let encoded = self.json(&commands::into_file(self.input.encode(point), &self.container))?;
        let decoded = self.json(&self.input.decode(point, &self.container, passes))?;
        Ok([encoded.number("seconds")?, decoded.number("seconds")?])
    }

    fn quality(&self, point: &Point) -> Result<Quality> {
        let report = self.json(&self.input.diff(point, &self.container))?;
        let of = Report { value: report.value[point.kind.name()].clone(), command: report.command.clone() };
        let codes = |of: &Report| of.count("max_error_codes").map(|codes| Some(codes as u32));
        Ok(match point.kind {
            StreamKind::Depth => Quality {
                psnr_db: of.number("psnr_db")?,
                min_psnr_db: None,
                ssim: None,
                max_error_codes: codes(&of)?,
                max_error_m: Some(of.number("max_error_m")?),
            },
            StreamKind::Color => Quality {
                psnr_db: of.number("psnr_db")?,
                min_psnr_db: Some(of.number("min_cell_psnr_db")?),
                // Half floats have none.
                ssim: of.value["ssim"].as_f64(),
                max_error_codes: None,
                max_error_m: None,
            },
            StreamKind::Material => Quality {
                psnr_db: of.number("psnr_db")?,
                min_psnr_db: None,
                ssim: None,
                max_error_codes: codes(&of)?,
                max_error_m: None,
            },
        })
    }

    /// Bytes of what a command encodes, which is done once for all points.
    fn bytes(&mut self, words: Vec<OsString>) -> Result<u64> {
        if let Some(&bytes) = self.known_bytes.get(&words) {
            return Ok(bytes);
        }
        let bytes = self.json(&commands::into_file(words.clone(), &self.packed))?.count("bytes")?;
        self.known_bytes.insert(words, bytes);
        Ok(bytes)
    }

    fn json(&self, words: &[OsString]) -> Result<Report> {
        Ok(Report { value: self.runner.run(words)?, command: commands::shell_line(words) })
    }
}

/// The JSON that a command printed.
struct Report {
    value: Value,
    command: String,
}

impl Report {
    /// A number, also one of those that JSON has no word for.
    fn number(&self, key: &str) -> Result<f64> {
        let value = &self.value[key];
        let infinite = match value.as_str() {
            Some("inf") => Some(f64::INFINITY),
            Some("-inf") => Some(f64::NEG_INFINITY),
            _ => None,
        };
        value.as_f64().or(infinite).ok_or_else(|| self.lacks(key))
    }

    fn count(&self, key: &str) -> Result<u64> {
        self.value[key].as_u64().ok_or_else(|| self.lacks(key))
    }

    fn lacks(&self, key: &str) -> Error {
        Error::invalid(format!("{}: its report has no number {key}", self.command))
    }
}
