//! A setting of the knobs, and what was measured of it.

use super::knob::KNOBS;
use crate::dataset::stream::StreamKind;

/// A setting of the knobs for one kind of stream. Knobs that are not named have their usual value.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Point {
    /// The kind of stream that is coded, and alone is.
    pub kind: StreamKind,
    /// Names of knobs and their values as the command line has them, in the order of [`KNOBS`].
    pub settings: Vec<(&'static str, String)>,
}

impl Point {
    /// A setting of these knobs, brought into the order of [`KNOBS`].
    pub fn new(kind: StreamKind, mut settings: Vec<(&'static str, String)>) -> Point {
        let order = |name: &str| KNOBS.iter().position(|knob| knob.name == name);
        settings.sort_by_key(|(name, _)| order(name));
        Point { kind, settings }
    }

    /// The settings as `name=value name=value`; `default settings` without any.
    pub fn words(&self) -> String {
        words(&self.settings).unwrap_or_else(|| "default settings".to_owned())
    }

    /// The value of a knob, where it is not the usual one.
    pub fn value(&self, knob: &str) -> Option<&str> {
        self.settings.iter().find(|(name, _)| *name == knob).map(|(_, value)| value.as_str())
    }
}

impl std::fmt::Display for Point {
    /// Such as `depth with max-error=50 threads=1`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} with {}", self.kind.name(), self.words())
    }
}

/// Settings as `name=value name=value`; none where there are none.
pub fn words(settings: &[(&'static str, String)]) -> Option<String> {
    let words: Vec<String> = settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    (!words.is_empty()).then(|| words.join(" "))
}

/// Bytes of a point; CALF table 1's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// The footage as CALF's table 1 counts it: 4 bytes a depth, 3 a colour.
    pub raw: u64,
    /// After the coding in time alone: samples as they are.
    pub temporal: u64,
    /// With blocks or modelling functions, where the point has them.
    pub spatial: Option<u64>,
    /// The container of the point itself, as decoding was timed on it.
    pub container: u64,
    /// With LZMA2 on top.
    pub lzma2: u64,
}

/// How far a point's images are from the source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// PSNR of all samples of all frames, in dB; infinite where nothing differs. Depth: of 16-bit log codes.
    pub psnr_db: f64,
    /// Lowest PSNR of any frame of any cell, in dB. Colour.
    pub min_psnr_db: Option<f64>,
    /// Mean SSIM. Colour of 8 bits.
    pub ssim: Option<f64>,
    /// Largest error of any pixel in 16-bit log codes (depth) or steps of 8 bits (material).
    pub max_error_codes: Option<u32>,
    /// Largest error of any pixel in metres. Depth.
    pub max_error_m: Option<f64>,
}

impl Quality {
    /// Whether both are the same in all that reports print of them: to 1/100 dB, to 1/10,000 of SSIM and to a code.
    pub fn is_like(&self, other: &Quality) -> bool {
        let near = |a: Option<f64>, b: Option<f64>, reach: f64| match (a, b) {
            (Some(a), Some(b)) => a == b || (a - b).abs() < reach,
            (a, b) => a.is_none() && b.is_none(),
        };
        near(Some(self.psnr_db), Some(other.psnr_db), 0.01)
            && near(self.min_psnr_db, other.min_psnr_db, 0.01)
            && near(self.ssim, other.ssim, 1e-4)
            && self.max_error_codes == other.max_error_codes
    }
}

/// The seconds of some runs of the same work.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timing {
    /// One entry for each run that counts, in the order they ran.
    pub runs: Vec<f64>,
}

impl Timing {
    /// The middle one, or the mean of the two in the middle; none without runs.
    pub fn median(&self) -> Option<f64> {
        let sorted = self.sorted();
        let middle = sorted.len() / 2;
        match sorted.len() {
            0 => None,
            count if count % 2 == 1 => Some(sorted[middle]),
            _ => Some((sorted[middle - 1] + sorted[middle]) / 2.0),
        }
    }

    /// How many runs all of some timings have, in words: `a single run`, `medians of 3 runs`, `medians of 1 to 3 runs`. None
    /// where there is none.
    pub fn runs_in_words<'a>(timings: impl IntoIterator<Item = &'a Timing>) -> Option<String> {
        let counts: Vec<usize> =
            timings.into_iter().map(|timing| timing.runs.len()).filter(|&count| count > 0).collect();
        let (&least, &most) = (counts.iter().min()?, counts.iter().max()?);
        Some(match least {
            1 if most == 1 => "a single run".to_owned(),
            _ if least == most => format!("medians of {most} runs"),
            _ => format!("medians of {least} to {most} runs"),
        })
    }

    /// The shortest and the longest; none without runs.
    pub fn spread(&self) -> Option<(f64, f64)> {
        let sorted = self.sorted();
        Some((*sorted.first()?, *sorted.last()?))
    }

    fn sorted(&self) -> Vec<f64> {
        let mut sorted = self.runs.clone();
        sorted.sort_by(f64::total_cmp);
        sorted
    }
}

/// What was measured of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The point.
    pub point: Point,
    /// Bytes.
    pub sizes: Sizes,
    /// Distance from the source.
    pub quality: Quality,
    /// Seconds of encoding, reading the source included.
    pub encode: Timing,
    /// Seconds of decoding all frames of all streams into nothing, the container in memory: each run is the median of
    /// [`decode_passes`](Measured::decode_passes) in one process.
    pub decode: Timing,
    /// Points in time that were decoded, each with the images of all probes and faces: `frames` in `decode seconds / frames`
    /// is what one moment of the light field takes.
    pub frames: u64,
    /// Images decoded.
    pub images: u64,
    /// Pixels shown.
    pub pixels: u64,
    /// Pixels written: those that changed.
    pub updated_pixels: u64,
    /// Passes over all frames in one timed run of the decoder, whose median the run is.
    pub decode_passes: u32,
    /// Largest resident memory of the encoding process, where the system tells.
    pub encode_peak_bytes: Option<u64>,
    /// Largest resident memory of the decoding process, where the system tells.
    pub decode_peak_bytes: Option<u64>,
}

impl Measured {
    /// Milliseconds that decoding one point in time takes, all probes and faces of it: the median.
    pub fn decode_ms_per_frame(&self) -> Option<f64> {
        Some(self.decode.median()? * 1000.0 / self.frames.max(1) as f64)
    }

    /// Millions of pixels shown in a second, where decoding was timed.
    pub fn megapixels_per_second(&self) -> Option<f64> {
        Some(self.pixels as f64 / 1e6 / self.decode.median()?.max(1e-9))
    }

    /// How many of the pixels shown were written, in percent.
    pub fn changed_percent(&self) -> f64 {
        100.0 * self.updated_pixels as f64 / self.pixels.max(1) as f64
    }

    /// Bytes of the container in percent of those of the footage.
    pub fn ratio_percent(&self) -> f64 {
        100.0 * self.sizes.container as f64 / self.sizes.raw.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_have_a_name_for_people() {
        let settings = vec![("threads", "1".to_owned()), ("max-error", "50".to_owned())];
        assert_eq!(Point::new(StreamKind::Depth, settings).to_string(), "depth with max-error=50 threads=1");
        assert_eq!(Point::new(StreamKind::Color, vec![]).to_string(), "color with default settings");
    }

    #[test]
    fn medians_and_spreads() {
        let timing = |runs: &[f64]| Timing { runs: runs.to_vec() };
        assert_eq!(timing(&[]).median(), None);
        assert_eq!(timing(&[]).spread(), None);
        assert_eq!(timing(&[3.0, 1.0, 2.0]).median(), Some(2.0));
        assert_eq!(timing(&[4.0, 1.0, 2.0, 3.0]).median(), Some(2.5));
        assert_eq!(timing(&[3.0, 1.0, 2.0]).spread(), Some((1.0, 3.0)));
    }

    #[test]
    fn runs_are_counted_in_words() {
        let of = |counts: &[usize]| {
            let timings: Vec<Timing> = counts.iter().map(|&count| Timing { runs: vec![1.0; count] }).collect();
            Timing::runs_in_words(&timings)
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[0, 0]), None);
        assert_eq!(of(&[1, 1, 0]).as_deref(), Some("a single run"));
        assert_eq!(of(&[3, 3]).as_deref(), Some("medians of 3 runs"));
        assert_eq!(of(&[3, 1]).as_deref(), Some("medians of 1 to 3 runs"));
    }

    #[test]
    fn settings_are_told_in_words() {
        let settings = vec![("max-error", "10".to_owned()), ("depth-codec", "quadtree".to_owned())];
        assert_eq!(Point::new(StreamKind::Depth, settings).words(), "depth-codec=quadtree max-error=10");
        assert_eq!(Point::new(StreamKind::Depth, vec![]).words(), "default settings");
    }

    #[test]
    fn qualities_are_alike_where_they_are_printed_alike() {
        let of = |psnr_db, max_error_codes| {
            let max_error_codes = Some(max_error_codes);
            Quality { psnr_db, min_psnr_db: None, ssim: None, max_error_codes, max_error_m: None }
        };
        let inf = f64::INFINITY;
        assert!(of(inf, 0).is_like(&of(inf, 0)) && of(40.0, 3).is_like(&of(40.004, 3)));
        assert!(!of(inf, 0).is_like(&of(90.0, 0)) && !of(40.0, 3).is_like(&of(40.0, 4)));
        assert!(!of(40.0, 3).is_like(&Quality { ssim: Some(1.0), ..of(40.0, 3) }));
    }
}
