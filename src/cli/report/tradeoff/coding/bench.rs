//! Measures a point of a coding sweep by running encode, decode, diff and pack.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::commands::{self, Input, decoder_passes};
use super::table::CODING;
use crate::report::tradeoff::kind::{Measured, Point, Value};
use crate::report::tradeoff::runner::{Bench, Cost, Report, Runner, Survey, shell_line};
use codec::error::Result;
use codec::image::StreamKind;

pub struct CodingBench<'a> {
    input: &'a Input,
    container: PathBuf,
    packed: PathBuf,
    known_bytes: BTreeMap<Vec<OsString>, u64>,
    devices: Vec<String>,
}

impl<'a> CodingBench<'a> {
    pub fn new(input: &'a Input, work: &Path) -> CodingBench<'a> {
        CodingBench {
            input,
            container: work.join("point.lfold"),
            packed: work.join("packed.lfold"),
            known_bytes: BTreeMap::new(),
            devices: Vec::new(),
        }
    }

    fn compare(&self, runner: &dyn Runner, measured: &mut Measured) -> Result<()> {
        let point = measured.point.clone();
        let report = Report::of(runner, &self.input.diff(&point, &self.container))?;
        let of = report.part(point.stream.map_or("", |stream| stream.name()));
        measured.set("psnr_db", Value::Number(of.number("psnr_db")?));
        match point.stream {
            Some(StreamKind::Color) => {
                measured.set("min_psnr_db", Value::Number(of.number("min_cell_psnr_db")?));
                measured.set("min_quality", of.value["min_quality"].as_f64().map(Value::Number));
                // Not defined for half floats.
                measured.set("ssim", of.value["ssim"].as_f64().map(Value::Number));
            }
            stream => {
                measured.set("max_error_codes", Value::Count(of.count("max_error_codes")?));
                if stream == Some(StreamKind::Depth) {
                    measured.set("max_error_m", Value::Number(of.number("max_error_m")?));
                }
            }
        }
        Ok(())
    }

    /// Returns the number of bytes that an encoding command writes. Each command runs once for all points.
    fn bytes(&mut self, runner: &dyn Runner, words: Vec<OsString>) -> Result<u64> {
        if let Some(&bytes) = self.known_bytes.get(&words) {
            return Ok(bytes);
        }
        let bytes = Report::of(runner, &commands::into_file(words.clone(), &self.packed))?.count("bytes")?;
        self.known_bytes.insert(words, bytes);
        Ok(bytes)
    }
}

impl Bench for CodingBench<'_> {
    fn made_of(&self) -> u32 {
        self.input.made_of
    }

    fn devices(&self) -> &[String] {
        &self.devices
    }

    fn command(&self, point: &Point) -> String {
        let mut words = self.input.encode(point);
        words.extend(["-o".into(), "point.lfold".into()]);
        shell_line(&words)
    }

    fn survey(&mut self, runner: &dyn Runner, point: &Point) -> Result<Survey> {
        let start = runner.now_seconds();
        let words = self.input.encode(point);
        let encoded = Report::of(runner, &commands::into_file(words.clone(), &self.container))?;
        let encode_seconds = runner.now_seconds() - start;
        let container = encoded.count("bytes")?;
        self.known_bytes.insert(words, container);
        let decode_start = runner.now_seconds();
        let decoded = Report::of(runner, &self.input.decode(point, &self.container, 1))?;
        let decode_seconds = runner.now_seconds() - decode_start;
        let pass_seconds = decoded.number("seconds")?;
        let mut measured = Measured::new(&CODING, point.clone());
        self.compare(runner, &mut measured)?;
        let lzma2 = match point.value("lzma2").filter(|level| *level != "none") {
            Some(_) => container,
            None => Report::of(runner, &commands::pack(&self.container, &self.packed))?.count("bytes")?,
        };
        let temporal = self.bytes(runner, self.input.temporal(point))?;
        let spatial = self.input.spatial(point).map(|words| self.bytes(runner, words)).transpose()?;
        if let Some(device) = decoded.value["device"].as_str().filter(|name| *name != "cpu")
            && !self.devices.iter().any(|known| known == device)
        {
            self.devices.push(device.to_owned());
        }
        let passes = decoder_passes(pass_seconds);
        for (name, count) in [
            ("bytes_raw", encoded.count("raw_bytes")?),
            ("bytes_temporal", temporal),
            ("bytes_container", container),
            ("bytes_lzma2", lzma2),
            ("decode_passes", passes.into()),
            ("frames", self.input.frames(point.stream.unwrap_or(StreamKind::Color))),
            ("images", decoded.count("frames")?),
            ("pixels", decoded.count("pixels")?),
            ("updated_pixels", decoded.count("updated_pixels")?),
        ] {
            measured.set(name, Value::Count(count));
        }
        measured.set("bytes_spatial", spatial.map(Value::Count));
        for (name, report) in [("encode_peak_bytes", &encoded), ("decode_peak_bytes", &decoded)] {
            measured.set(name, report.value["peak_memory_bytes"].as_u64().map(Value::Count));
        }
        // The survey decoded twice, a warm-up and one timed pass; further passes add to the cost of a run.
        let run = encode_seconds + decode_seconds + pass_seconds * f64::from(passes - 1);
        Ok(Survey { measured, cost: Cost { survey: runner.now_seconds() - start, run } })
    }

    fn time(&mut self, runner: &dyn Runner, measured: &mut Measured) -> Result<()> {
        let point = measured.point.clone();
        let passes = measured.count("decode_passes") as u32;
        let encoded = Report::of(runner, &commands::into_file(self.input.encode(&point), &self.container))?;
        let decoded = Report::of(runner, &self.input.decode(&point, &self.container, passes))?;
        let (encode, decode) = (encoded.number("seconds")?, decoded.number("seconds")?);
        measured.push_run("encode_runs", encode);
        measured.push_run("decode_runs", decode);
        Ok(())
    }

    fn cost(&self, measured: &Measured) -> Option<Cost> {
        let (encode, decode) = (measured.number("encode_seconds")?, measured.number("decode_seconds")?);
        let passes = measured.count("decode_passes") as f64 + 1.0;
        // A survey encodes at least twice, compares and packs; each step takes about as long as encoding.
        Some(Cost { survey: encode * 4.0 + decode * 2.0, run: encode + decode * passes })
    }
}
