//! Coding sweeps: command lines that measure a point.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::crops::Crop;
pub use super::kind::CODING;
use super::point::{Measured, Point, Setting};
use super::runner::{Bench, Cost, Report, Survey};
use crate::child::{Runner, shell_line};
use codec::error::Result;
use codec::image::StreamKind;
use codec::streams::ColorBlocks;
use footage::encode::ColorBlockSettings;

/// Target duration of decoding in one timed run of a point, in seconds. Short decodes vary most and are repeated more
/// often.
const TIMED_SECONDS: f64 = 0.3;
const DECODER_PASSES: [u32; 2] = [9, 200];
/// LZMA2 level of the sizes that are measured with LZMA2 on top.
pub const LZMA2_LEVEL: u32 = 6;

/// Returns how many passes over all frames to time in one run of a point, for a total of about `TIMED_SECONDS`. The median
/// pass is reported.
pub fn decoder_passes(pass_seconds: f64) -> u32 {
    let [least, most] = DECODER_PASSES;
    ((TIMED_SECONDS / pass_seconds.max(1e-9)) as u32).clamp(least, most)
}

/// The footage, and the options of all points that are not knobs.
#[derive(Debug, Clone, Default)]
pub struct Input {
    pub path: PathBuf,
    /// `encode`, or the encoder of a single sequence.
    pub encoder: &'static str,
    /// Kinds of streams in the footage, with the number of frames of each.
    pub kinds: Vec<(StreamKind, u64)>,
    pub encode: Vec<String>,
    /// Options that `diff` needs as well, such as `--frames=0-9`.
    pub diff: Vec<String>,
    pub decode: Vec<String>,
    /// Configuration hash. It covers everything that results depend on, except the knobs.
    pub made_of: u32,
}

impl Input {
    pub fn frames(&self, kind: StreamKind) -> u64 {
        self.kinds.iter().find(|(other, _)| *other == kind).map_or(0, |(_, frames)| *frames)
    }

    pub fn encode(&self, point: &Point) -> Vec<OsString> {
        self.encode_settings(stream_of(point), &point.settings, &self.encode)
    }

    /// Returns the command that encodes the same temporal coding with raw samples: no blocks, no modelling functions,
    /// no LZMA2.
    pub fn temporal(&self, point: &Point) -> Vec<OsString> {
        let mut settings = without(&point.settings, &["lzma2", "threads", "device"]);
        match stream_of(point) {
            StreamKind::Depth => {
                let of_functions =
                    "depth-codec depth-block max-error max-error-relative depth-domain optimize min-children effort";
                settings = without(&settings, &of_functions.split(' ').collect::<Vec<_>>());
                settings.push(("depth-codec", "aabb".to_owned()));
            }
            StreamKind::Color => {
                if let Some(psnr) = psnr_in_time(point, &self.encode) {
                    settings = without(&settings, &["psnr"]);
                    settings.push(("psnr", psnr));
                }
                if point.value("color-block").is_some_and(|of| of != "none") && point.value("color-codec").is_none() {
                    settings.push(("color-codec", "cells".to_owned()));
                }
                settings = without(&settings, &["color-block", "psnr-final"]);
            }
            StreamKind::Material | StreamKind::Alpha => {}
        }
        let options: Vec<String> =
            self.encode.iter().filter(|option| !option.starts_with("--material-")).cloned().collect();
        self.encode_settings(stream_of(point), &Point::new(&CODING, point.stream, settings).settings, &options)
    }

    /// Returns the command of the point without LZMA2, if the point uses blocks or functions.
    pub fn spatial(&self, point: &Point) -> Option<Vec<OsString>> {
        let value = |knob: &str| point.value(knob);
        let has = match stream_of(point) {
            StreamKind::Depth => {
                value("depth-codec") != Some("aabb") || value("depth-block").is_some_and(|of| of != "none")
            }
            StreamKind::Color => value("color-block").is_some_and(|of| of != "none"),
            StreamKind::Alpha => false,
            StreamKind::Material => {
                self.encode.iter().any(|option| option.starts_with("--material-block=") && !option.ends_with("=none"))
            }
        };
        has.then(|| self.encode_settings(stream_of(point), &without(&point.settings, &["lzma2"]), &self.encode))
    }

    fn encode_settings(&self, stream: StreamKind, settings: &[Setting], options: &[String]) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec![self.encoder.into(), self.path.clone().into()];
        if self.encoder == "encode" {
            words.push(format!("--stream={}", stream.name()).into());
        }
        words.extend(knob_options(settings, "encode"));
        // Sizes without LZMA2 are sizes of uncompressed payloads.
        let compressed = settings.iter().any(|(name, level)| *name == "lzma2" && level != "none");
        let says = |option: &String| option.starts_with("--zstd") || option == "--no-compression";
        if !compressed && !options.iter().any(says) {
            words.push("--no-compression".into());
        }
        let states_range = |option: &String| {
            ["--clip", "--hdr", "--transfer", "--exposure"].iter().any(|name| option.split('=').next() == Some(*name))
        };
        if stream == StreamKind::Color && !options.iter().any(states_range) {
            words.push("--clip".into());
        }
        words.extend(options.iter().map(OsString::from));
        words
    }

    /// Returns the command that decodes the container of a point `passes` times, after a warm-up.
    pub fn decode(&self, point: &Point, container: &Path, passes: u32) -> Vec<OsString> {
        let mut words = vec!["decode".into(), container.into(), "--null".into(), format!("--repeat={passes}").into()];
        words.extend(knob_options(&point.settings, "decode"));
        words.extend(self.decode.iter().map(OsString::from));
        words.push("--json".into());
        words
    }

    pub fn diff(&self, point: &Point, container: &Path) -> Vec<OsString> {
        let mut words = vec!["diff".into(), self.path.clone().into(), container.into()];
        words.push(format!("--stream={}", stream_of(point).name()).into());
        if stream_of(point) != StreamKind::Color {
            words.push("--ssim=none".into());
        } else {
            words.push("--allow-clipping".into());
        }
        words.extend(self.diff.iter().map(OsString::from));
        words.push("--json".into());
        words
    }
}

pub fn pack(container: &Path, output: &Path) -> Vec<OsString> {
    let level = format!("--lzma2={LZMA2_LEVEL}");
    vec!["pack".into(), container.into(), level.into(), "-o".into(), output.into(), "--json".into()]
}

pub fn into_file(mut words: Vec<OsString>, output: &Path) -> Vec<OsString> {
    words.extend(["-o".into(), output.into(), "--json".into()]);
    words
}

fn stream_of(point: &Point) -> StreamKind {
    point.stream.unwrap_or(StreamKind::Color)
}

fn knob_options(settings: &[Setting], stage: &'static str) -> impl Iterator<Item = OsString> {
    settings.iter().filter_map(move |(name, value)| {
        let knob = CODING.knob(name)?;
        [stage, "both"].contains(&knob.stage).then(|| knob.option(value))?.map(OsString::from)
    })
}

fn without(settings: &[Setting], names: &[&str]) -> Vec<Setting> {
    settings.iter().filter(|(name, _)| !names.contains(name)).cloned().collect()
}

/// Returns the PSNR threshold of a point's temporal coding in dB, if its blocks change the default threshold.
fn psnr_in_time(point: &Point, options: &[String]) -> Option<String> {
    let value = |knob: &str| {
        let prefix = format!("--{knob}=");
        let option = || options.iter().find_map(|option| option.strip_prefix(&prefix));
        point.value(knob).or_else(option)
    };
    let blocks = match value("color-block")?.to_ascii_lowercase().as_str() {
        "bc1" => ColorBlocks::Bc1,
        "bc7" => ColorBlocks::Bc7,
        "bc6h" => ColorBlocks::Bc6h,
        _ => return None,
    };
    let usual = || ColorBlockSettings::usual_psnr_db(blocks).to_string();
    Some(value("psnr").or(value("psnr-final")).map_or_else(usual, str::to_owned))
}

/// Measures a point by running encode, decode, diff and pack.
pub struct CodingBench<'a> {
    input: &'a Input,
    container: PathBuf,
    packed: PathBuf,
    known_bytes: BTreeMap<Vec<OsString>, u64>,
    devices: Vec<String>,
    /// Places of which each point gets a picture, and the folder of these.
    crops: (&'a [Crop], &'a Path),
}

impl<'a> CodingBench<'a> {
    pub fn new(input: &'a Input, work: &Path) -> CodingBench<'a> {
        let (container, packed) = (work.join("point.lfold"), work.join("packed.lfold"));
        let crops: (&[Crop], &Path) = (&[], Path::new(""));
        CodingBench { input, container, packed, known_bytes: BTreeMap::new(), devices: Vec::new(), crops }
    }

    /// Writes crops of the decoded pictures of each point into a folder.
    #[must_use]
    pub fn with_crops(self, crops: &'a [Crop], folder: &'a Path) -> CodingBench<'a> {
        CodingBench { crops: (crops, folder), ..self }
    }

    /// Returns the number of bytes that an encoding command writes. Each command runs once for all points.
    fn bytes(&mut self, runner: &dyn Runner, words: Vec<OsString>) -> Result<u64> {
        if let Some(&bytes) = self.known_bytes.get(&words) {
            return Ok(bytes);
        }
        let bytes = Report::of(runner, &into_file(words.clone(), &self.packed))?.count("bytes")?;
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
        let encoded = Report::of(runner, &into_file(words.clone(), &self.container))?;
        let encode_seconds = runner.now_seconds() - start;
        let container = encoded.count("bytes")?;
        self.known_bytes.insert(words, container);
        let (crops, folder) = self.crops;
        crops.iter().try_for_each(|crop| crop.save(&self.container, point, folder))?;
        let decode_start = runner.now_seconds();
        let decoded = Report::of(runner, &self.input.decode(point, &self.container, 1))?;
        let decode_seconds = runner.now_seconds() - decode_start;
        let pass_seconds = decoded.number("seconds")?;
        let compared = runner.run(&self.input.diff(point, &self.container))?;
        let lzma2 = match point.value("lzma2").filter(|level| *level != "none") {
            Some(_) => container,
            None => Report::of(runner, &pack(&self.container, &self.packed))?.count("bytes")?,
        };
        let temporal = self.bytes(runner, self.input.temporal(point))?;
        let spatial = self.input.spatial(point).map(|words| self.bytes(runner, words)).transpose()?;
        if let Some(device) = decoded.value["device"].as_str().filter(|name| *name != "cpu")
            && !self.devices.iter().any(|known| known == device)
        {
            self.devices.push(device.to_owned());
        }
        let passes = decoder_passes(pass_seconds);
        let value = json!({
            "encode": encoded.value,
            "decode": decoded.value,
            "diff": compared[stream_of(point).name()],
            "temporal": { "bytes": temporal },
            "spatial": { "bytes": spatial },
            "lzma2": { "bytes": lzma2 },
            "passes": passes,
            "frames": self.input.frames(stream_of(point)),
        });
        let mut measured = Measured::new(&CODING, point.clone());
        Report { value, command: encoded.command }.add_values(&mut measured)?;
        // The survey decoded twice, a warm-up and one timed pass; further passes add to the cost of a run.
        let run = encode_seconds + decode_seconds + pass_seconds * f64::from(passes - 1);
        Ok(Survey { measured, cost: Cost { survey: runner.now_seconds() - start, run } })
    }

    fn time(&mut self, runner: &dyn Runner, measured: &mut Measured) -> Result<()> {
        let (point, passes) = (&measured.point, measured.count("decode_passes") as u32);
        let encode = into_file(self.input.encode(point), &self.container);
        let encoded = runner.run(&encode)?;
        let decoded = runner.run(&self.input.decode(point, &self.container, passes))?;
        let value = json!({ "encode": encoded, "decode": decoded });
        Report { value, command: shell_line(&encode) }.add_runs(measured)
    }

    fn cost(&self, measured: &Measured) -> Option<Cost> {
        let (encode, decode) = (measured.number("encode_seconds")?, measured.number("decode_seconds")?);
        let passes = measured.count("decode_passes") as f64 + 1.0;
        // A survey encodes at least twice, compares and packs; each step takes about as long as encoding.
        Some(Cost { survey: encode * 4.0 + decode * 2.0, run: encode + decode * passes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use StreamKind::{Color, Depth};

    fn input(encoder: &'static str, encode: &[&str]) -> Input {
        Input {
            path: "scene".into(),
            encoder,
            kinds: vec![(Color, 6), (Depth, 6)],
            encode: encode.iter().map(|word| (*word).to_owned()).collect(),
            diff: Vec::new(),
            decode: Vec::new(),
            made_of: 0,
        }
    }

    fn point(stream: StreamKind, settings: &[(&'static str, &str)]) -> Point {
        Point::new(&CODING, Some(stream), settings.iter().map(|&(name, value)| (name, value.to_owned())).collect())
    }

    #[test]
    fn a_point_is_encoded_and_decoded_by_its_knobs() {
        let of = point(Depth, &[("device", "gpu"), ("depth-window", "4"), ("threads", "2"), ("lzma2", "none")]);
        let scene = input("encode", &["--near=1"]);
        let line = shell_line(&scene.encode(&of));
        assert_eq!(
            line,
            "lightfold encode scene --stream=depth --depth-window=4 --threads=2 --no-compression --near=1"
        );
        let line = shell_line(&scene.decode(&of, Path::new("a b.lfold"), 3));
        assert_eq!(line, "lightfold decode 'a b.lfold' --null --repeat=3 --threads=2 --device=gpu --json");
        let alone = input("encode-depth", &[]);
        assert_eq!(
            shell_line(&alone.encode(&of)),
            "lightfold encode-depth scene --depth-window=4 --threads=2 --no-compression"
        );
        let line = shell_line(&alone.diff(&of, Path::new("a.lfold")));
        assert_eq!(line, "lightfold diff scene a.lfold --stream=depth --ssim=none --json");
    }

    #[test]
    fn coding_in_time_alone_keeps_what_belongs_to_time() {
        let scene = input("encode", &[]);
        let of = point(Depth, &[("depth-window", "4"), ("max-error", "10"), ("update-threshold", "3"), ("lzma2", "6")]);
        let line = shell_line(&scene.temporal(&of));
        assert_eq!(
            line,
            "lightfold encode scene --stream=depth --depth-codec=aabb --depth-window=4 --update-threshold=3 --no-compression"
        );
        for (settings, psnr) in [
            (&[("color-block", "bc7"), ("color-cell", "8")][..], "40"),
            (&[("color-block", "bc1"), ("color-cell", "8"), ("psnr-final", "28")], "28"),
            (&[("color-block", "bc7"), ("color-cell", "8"), ("psnr", "45"), ("psnr-final", "28")], "45"),
        ] {
            let line = shell_line(&scene.temporal(&point(Color, settings)));
            assert_eq!(
                line,
                format!(
                    "lightfold encode scene --stream=color --color-cell=8 --color-codec=cells --psnr={psnr} --no-compression --clip"
                )
            );
        }
        let plain = point(Color, &[("psnr", "40")]);
        assert_eq!(scene.temporal(&plain), scene.encode(&plain));
        let line = shell_line(&scene.temporal(&point(Color, &[("color-block", "none")])));
        assert_eq!(line, "lightfold encode scene --stream=color --no-compression --clip");
        let hdr = Input { encode: vec!["--hdr".into()], ..scene };
        let line = shell_line(&hdr.encode(&plain));
        assert!(line.contains("--hdr") && !line.contains("--clip"), "{line}");
    }

    #[test]
    fn only_blocks_and_functions_have_a_size_in_space() {
        let scene = input("encode", &[]);
        assert!(scene.spatial(&point(Depth, &[("depth-codec", "aabb")])).is_none());
        assert!(scene.spatial(&point(Depth, &[("depth-codec", "aabb"), ("depth-block", "bc5")])).is_some());
        assert!(scene.spatial(&point(Color, &[("color-block", "none")])).is_none());
        let tree = scene.spatial(&point(Depth, &[("max-error", "10"), ("lzma2", "9")])).unwrap();
        assert_eq!(shell_line(&tree), "lightfold encode scene --stream=depth --max-error=10 --no-compression");
    }

    #[test]
    fn what_is_quick_is_decoded_more_often() {
        let passes = [0.0, 0.001, 0.002, 0.01, 0.1, 10.0].map(decoder_passes);
        assert_eq!(passes, [200, 200, 150, 30, 9, 9]);
    }
}
