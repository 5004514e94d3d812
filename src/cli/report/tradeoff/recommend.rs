//! Recommends a point: the smallest that meets all demands or, if only time and bytes are limited, the one closest to
//! the source.

use super::point::Measured;
use super::store::StoredPoint;
use crate::options::parse_positive;
use codec::image::StreamKind;

// Limits for a point. Each limit applies to the kinds of streams that have its measure.
#[derive(Debug, Clone, Copy, Default, PartialEq, clap::Args)]
pub struct Demands {
    /// Maximum error: 16-bit log codes of depth, 8-bit steps of material
    #[arg(long = "max-error", value_name = "CODES", requires = "recommend")]
    pub max_error_codes: Option<u16>,
    /// Maximum error of depth in metres
    #[arg(long, value_name = "M", requires = "recommend", value_parser = parse_positive)]
    pub max_error_m: Option<f64>,
    /// Minimum PSNR in dB of every frame of every colour cell
    #[arg(long = "min-psnr", value_name = "DB", requires = "recommend", value_parser = parse_positive)]
    pub min_psnr_db: Option<f64>,
    /// Minimum perceptual quality of every frame of every colour cell, as diff --min-quality
    #[arg(long, value_name = "Q", requires = "recommend", value_parser = parse_positive)]
    pub min_quality: Option<f64>,
    /// Maximum decoding time in milliseconds of one frame, all probes and faces of a kind
    #[arg(long, value_name = "MS", requires = "recommend", value_parser = parse_positive)]
    pub decode_ms: Option<f64>,
    /// Maximum size of the container, such as 5000000, 5MB or 800kB
    #[arg(long, value_name = "BYTES", requires = "recommend", value_parser = parse_bytes)]
    pub max_bytes: Option<u64>,
    /// Maximum size of the container in percent of the raw footage, such as 5 or 5%
    #[arg(long = "max-ratio", value_name = "PERCENT", requires = "recommend", value_parser = parse_percent)]
    pub max_ratio_percent: Option<f64>,
}

fn parse_percent(text: &str) -> Result<f64, String> {
    parse_positive(text.trim_end_matches('%').trim())
}

fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let factor = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        unit => return Err(format!("'{unit}': B, kB, MB or GB was expected")),
    };
    Ok((parse_positive(digits.trim())? * factor).round() as u64)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// Fewest bytes: quality is limited.
    Smallest,
    /// Closest to the source: only bytes and time are limited.
    Closest,
}

/// Recommended point for a kind of stream, or the point that comes closest to meeting the demands.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice<'a> {
    pub row: &'a StoredPoint,
    pub aim: Aim,
    /// Demands that the point misses, one sentence each. Empty if it meets all.
    pub misses: Vec<String>,
}

/// Sentence about a demand that a point misses, and the ratio by which it does.
type Miss = (String, f64);

impl Demands {
    pub fn is_empty(&self) -> bool {
        *self == Demands::default()
    }

    /// Returns the aim for a kind of stream. `None` if no demand applies to it.
    pub fn aim(&self, kind: StreamKind) -> Option<Aim> {
        let quality = match kind {
            StreamKind::Depth => self.max_error_codes.is_some() || self.max_error_m.is_some(),
            StreamKind::Material | StreamKind::Alpha => self.max_error_codes.is_some(),
            StreamKind::Color => self.min_psnr_db.is_some() || self.min_quality.is_some(),
        };
        let cost = self.decode_ms.is_some() || self.max_bytes.is_some() || self.max_ratio_percent.is_some();
        match (quality, cost) {
            (true, _) => Some(Aim::Smallest),
            (false, true) => Some(Aim::Closest),
            (false, false) => None,
        }
    }

    fn misses(&self, of: &Measured) -> Vec<Miss> {
        let above = |limit: Option<f64>, name: &str, least: f64| {
            let (limit, found) = limit.zip(of.number(name))?;
            (found > limit).then(|| (limit, found, found / limit.max(least)))
        };
        // The PSNR is computed before and after a file is written: the last digit may differ.
        let below = |limit: Option<f64>, found: Option<f64>| {
            let (limit, found) = limit.zip(found)?;
            (found < limit - 1e-6).then(|| (limit, found, limit / found.max(1.0)))
        };
        let is_color = of.point.stream == Some(StreamKind::Color);
        let untimed = self.decode_ms.filter(|_| of.number("decode_ms_per_frame").is_none());
        let all = [
            above(self.max_error_codes.map(f64::from), "max_error_codes", 1.0)
                .map(|(limit, codes, by)| (format!("--max-error {limit}: its largest error is {codes} codes"), by)),
            above(self.max_error_m, "max_error_m", 1e-9)
                .map(|(limit, metres, by)| (format!("--max-error-m {limit}: its largest error is {metres:.4} m"), by)),
            below(self.min_psnr_db, is_color.then(|| closeness_db(of))).map(|(limit, db, by)| {
                (format!("--min-psnr {limit}: its lowest PSNR of a frame of a cell is {db:.2} dB"), by)
            }),
            below(self.min_quality, of.number("min_quality")).map(|(limit, found, by)| {
                (format!("--min-quality {limit}: the lowest quality of a frame of a cell is {found:.1}"), by)
            }),
            above(self.decode_ms, "decode_ms_per_frame", 1e-9)
                .map(|(limit, ms, by)| (format!("--decode-ms {limit}: decoding a frame takes {ms:.3} ms"), by)),
            untimed.map(|limit| (format!("--decode-ms {limit}: its decoding has not been timed"), f64::INFINITY)),
            above(self.max_bytes.map(|bytes| bytes as f64), "bytes_container", 1.0)
                .map(|(limit, bytes, by)| (format!("--max-bytes {limit}: it has {bytes}"), by)),
            above(self.max_ratio_percent, "ratio_percent", 1e-9)
                .map(|(limit, percent, by)| (format!("--max-ratio {limit}: it has {percent:.2}% of the footage"), by)),
        ];
        all.into_iter().flatten().collect()
    }
}

/// Returns advice for each kind of stream that was measured and has demands, in the order of kinds.
pub fn recommend<'a>(rows: &[&'a StoredPoint], demands: &Demands) -> Vec<Advice<'a>> {
    let of_kind = |kind: StreamKind| {
        let aim = demands.aim(kind)?;
        let own = rows.iter().filter(|row| row.measured.point.stream == Some(kind));
        let judged = own.map(|&row| (row, demands.misses(&row.measured)));
        let (row, misses) = judged.min_by(|(a, misses_a), (b, misses_b)| {
            let (a, b) = (&a.measured, &b.measured);
            let by_how_much = |misses: &[Miss]| misses.iter().map(|(_, by)| by.ln()).sum::<f64>();
            let closeness = |of: &Measured| if aim == Aim::Closest { closeness_db(of) } else { 0.0 };
            let bytes = |of: &Measured| of.count("bytes_container");
            (misses_a.len().cmp(&misses_b.len()))
                .then(by_how_much(misses_a).total_cmp(&by_how_much(misses_b)))
                .then(closeness(b).total_cmp(&closeness(a)))
                .then(bytes(a).cmp(&bytes(b)))
                .then(a.point.cmp(&b.point))
        })?;
        Some(Advice { row, aim, misses: misses.into_iter().map(|(words, _)| words).collect() })
    };
    StreamKind::ALL.into_iter().filter_map(of_kind).collect()
}

/// Returns the PSNR of the worst cell, or of all samples for streams without cells.
fn closeness_db(of: &Measured) -> f64 {
    of.number("min_psnr_db").or(of.number("psnr_db")).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::kind::CODING;
    use crate::report::tradeoff::point::{Point, Value};

    fn point(stream: StreamKind, setting: (&'static str, &str), bytes: u64, seconds: f64) -> StoredPoint {
        let settings = vec![(setting.0, setting.1.to_owned())];
        let mut of = Measured::new(&CODING, Point::new(&CODING, Some(stream), settings));
        for (name, count) in [("bytes_raw", 1000), ("bytes_container", bytes), ("frames", 10)] {
            of.set(name, Value::Count(count));
        }
        of.set("psnr_db", Value::Number(80.0));
        of.push_run("decode_runs", seconds);
        StoredPoint { studies: vec![], measured: of, command: String::new(), made_of: 0 }
    }

    /// A depth point with the given bytes, error in codes and decoding time in seconds.
    fn depth(error: &str, bytes: u64, codes: u64, seconds: f64) -> StoredPoint {
        let mut of = point(StreamKind::Depth, ("max-error", error), bytes, seconds);
        of.measured.set("max_error_codes", Value::Count(codes));
        of.measured.set("max_error_m", Value::Number(0.1));
        of
    }

    fn color(psnr: &str, bytes: u64, min_psnr_db: f64) -> StoredPoint {
        let mut of = point(StreamKind::Color, ("psnr", psnr), bytes, 0.01);
        of.measured.set("min_psnr_db", Value::Number(min_psnr_db));
        of
    }

    #[test]
    fn the_smallest_that_meets_all_demands_of_its_kind() {
        let points = [
            depth("0", 300, 0, 0.02),
            depth("50", 200, 50, 0.03),
            depth("60", 100, 60, 0.01),
            color("40", 500, 40.2),
            color("30", 400, 30.1),
        ];
        let all: Vec<_> = points.iter().collect();
        let ask = |demands: &Demands| -> Vec<(String, usize)> {
            let advice = recommend(&all, demands);
            advice.iter().map(|advice| (advice.row.measured.point.settings[0].1.clone(), advice.misses.len())).collect()
        };
        let said = |values: &[(&str, usize)]| -> Vec<(String, usize)> {
            values.iter().map(|(value, misses)| ((*value).to_owned(), *misses)).collect()
        };
        let none = Demands::default();
        assert!(none.is_empty());
        // Demands in dB do not apply to depth, and those in codes or metres do not apply to colour.
        assert_eq!(ask(&Demands { max_error_codes: Some(55), ..none }), said(&[("50", 0)]));
        assert_eq!(ask(&Demands { max_error_m: Some(0.2), ..none }), said(&[("60", 0)]));
        assert_eq!(ask(&Demands { max_error_m: Some(0.05), ..none }), said(&[("60", 1)]));
        assert_eq!(ask(&Demands { min_psnr_db: Some(35.0), ..none }), said(&[("40", 0)]));
        // 0.02 s for ten frames are 2 ms per frame. The quality of colour is not limited: the best point within the
        // time.
        let fast = Demands { max_error_codes: Some(55), decode_ms: Some(2.5), ..none };
        assert_eq!(ask(&fast), said(&[("40", 0), ("0", 0)]));
        assert_eq!(fast.aim(StreamKind::Color), Some(Aim::Closest));
        assert_eq!(fast.aim(StreamKind::Depth), Some(Aim::Smallest));
        assert_eq!(ask(&Demands { max_ratio_percent: Some(15.0), ..none }), said(&[("30", 1), ("60", 0)]));
        // Twice the smallest error misses its limit by less than three times the bytes do.
        let points = [depth("1", 50, 2, 0.02), depth("0", 150, 0, 0.02)];
        let lossless = Demands { max_error_codes: Some(0), max_ratio_percent: Some(5.0), ..none };
        let advice = recommend(&[&points[0], &points[1]], &lossless);
        assert_eq!(advice[0].row.measured.count("bytes_container"), 50);
        // Among points of equal quality, the smallest.
        assert_eq!(ask(&Demands { max_bytes: Some(450), ..none }), said(&[("30", 0), ("60", 0)]));
    }

    #[test]
    fn where_none_does_the_nearest_and_what_it_misses() {
        let points = [depth("0", 300, 0, 0.02), depth("50", 200, 50, 0.03), depth("60", 100, 60, 0.01)];
        let all: Vec<_> = points.iter().collect();
        let strict = Demands { max_error_codes: Some(40), max_bytes: Some(150), ..Demands::default() };
        let advice = recommend(&all, &strict);
        assert_eq!(advice[0].row.measured.point.settings[0].1, "60");
        assert_eq!(advice[0].misses, ["--max-error 40: its largest error is 60 codes"]);
        let mut untimed = points[2].clone();
        untimed.measured.set("decode_runs", Value::Runs(vec![]));
        let advice = recommend(&[&untimed], &Demands { decode_ms: Some(1e9), ..Demands::default() });
        assert!(advice[0].misses[0].contains("not been timed"));
    }
}
