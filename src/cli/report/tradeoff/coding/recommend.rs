//! Recommends a point: the smallest that meets all demands or, if only time and bytes are limited, the one closest to
//! the source.

use crate::report::tradeoff::kind::Measured;
use crate::report::tradeoff::store::StoredPoint;
use codec::image::StreamKind;

/// Limits for a point. Each limit applies to the kinds of streams that have its measure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Demands {
    /// Depth: steps of 16-bit log codes. Material: steps of 8-bit codes.
    pub max_error_codes: Option<u32>,
    pub max_error_m: Option<f64>,
    /// Minimum PSNR in dB of every frame of every colour cell.
    pub min_psnr_db: Option<f64>,
    /// Minimum perceptual quality of every frame of every colour cell.
    pub min_quality: Option<f64>,
    pub decode_ms: Option<f64>,
    pub max_bytes: Option<u64>,
    /// Maximum size of the container in percent of the size of the footage.
    pub max_ratio_percent: Option<f64>,
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

struct Miss {
    words: String,
    ratio: f64,
}

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
        let more = |limit: Option<f64>, least: f64, name: &str, words: fn(f64, f64) -> String| {
            let (limit, found) = (limit?, of.number(name)?);
            (found > limit).then(|| Miss { words: words(limit, found), ratio: found / limit.max(least) })
        };
        // The PSNR is computed before and after a file is written: the last digit may differ.
        let psnr = self.min_psnr_db.filter(|_| of.point.stream == Some(StreamKind::Color));
        let psnr = psnr.map(|limit| (limit, closeness_db(of))).filter(|(limit, found)| *found < limit - 1e-6);
        let quality = self.min_quality.zip(of.number("min_quality")).filter(|(limit, found)| *found < limit - 1e-6);
        let untimed = self.decode_ms.filter(|_| of.number("decode_ms_per_frame").is_none());
        let all = [
            more(self.max_error_codes.map(f64::from), 1.0, "max_error_codes", |limit, codes| {
                format!("--max-error {limit}: its largest error is {codes} codes")
            }),
            more(self.max_error_m, 1e-9, "max_error_m", |limit, metres| {
                format!("--max-error-m {limit}: its largest error is {metres:.4} m")
            }),
            psnr.map(|(limit, found)| Miss {
                words: format!("--min-psnr {limit}: its lowest PSNR of a frame of a cell is {found:.2} dB"),
                ratio: limit / found.max(1.0),
            }),
            quality.map(|(limit, found)| Miss {
                words: format!("--min-quality {limit}: the lowest quality of a frame of a cell is {found:.1}"),
                ratio: limit / found.max(1.0),
            }),
            more(self.decode_ms, 1e-9, "decode_ms_per_frame", |limit, ms| {
                format!("--decode-ms {limit}: decoding a frame takes {ms:.3} ms")
            }),
            untimed.map(|limit| Miss {
                words: format!("--decode-ms {limit}: its decoding has not been timed"),
                ratio: f64::INFINITY,
            }),
            more(self.max_bytes.map(|bytes| bytes as f64), 1.0, "bytes_container", |limit, bytes| {
                format!("--max-bytes {limit}: it has {bytes}")
            }),
            more(self.max_ratio_percent, 1e-9, "ratio_percent", |limit, percent| {
                format!("--max-ratio {limit}: it has {percent:.2}% of the footage")
            }),
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
            let by_how_much = |misses: &[Miss]| misses.iter().map(|miss| miss.ratio.ln()).sum::<f64>();
            let closeness = |of: &Measured| if aim == Aim::Closest { closeness_db(of) } else { 0.0 };
            let bytes = |of: &Measured| of.count("bytes_container");
            (misses_a.len().cmp(&misses_b.len()))
                .then(by_how_much(misses_a).total_cmp(&by_how_much(misses_b)))
                .then(closeness(b).total_cmp(&closeness(a)))
                .then(bytes(a).cmp(&bytes(b)))
                .then(a.point.cmp(&b.point))
        })?;
        Some(Advice { row, aim, misses: misses.into_iter().map(|miss| miss.words).collect() })
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
    use crate::report::tradeoff::coding::CODING;
    use crate::report::tradeoff::kind::{Point, Value};

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
