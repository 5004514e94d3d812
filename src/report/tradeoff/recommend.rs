//! Of the points at hand, the smallest that meets all demands; where nothing is asked of its quality, the closest to the
//! source.

use super::point::Measured;
use crate::dataset::stream::StreamKind;

/// What is asked of a point. Each demand counts for the kinds of streams that it speaks of.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Demands {
    /// Largest error: 16-bit log codes of depth, steps of 8 bits of material.
    pub max_error_codes: Option<u32>,
    /// Largest error of depth in metres.
    pub max_error_m: Option<f64>,
    /// Lowest PSNR of any frame of any cell of colour, in dB.
    pub min_psnr_db: Option<f64>,
    /// Milliseconds for one point in time, all probes and faces.
    pub decode_ms: Option<f64>,
    /// Bytes of the container.
    pub max_bytes: Option<u64>,
    /// Bytes of the container in percent of those of the footage.
    pub max_ratio_percent: Option<f64>,
}

/// Which of the points that meet all demands is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// The one with the fewest bytes, since a quality was asked for.
    Smallest,
    /// The one that is closest to the source, since only bytes and time are limited.
    Closest,
}

/// The point to use for a kind of stream, or the one that comes nearest.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice<'a> {
    /// The point: what was aimed at among those that meet all demands, or the one that misses them least.
    pub point: &'a Measured,
    /// What was aimed at.
    pub aim: Aim,
    /// Demands that it does not meet, a sentence each: none where the point is to be used.
    pub misses: Vec<String>,
}

/// A demand that a point misses: how it is put, and by how much, as a ratio above 1.
type Miss = (String, f64);

impl Demands {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        *self == Demands::default()
    }

    /// What is aimed at for a kind of stream; none where nothing of it is asked.
    pub fn aim(&self, kind: StreamKind) -> Option<Aim> {
        let quality = match kind {
            StreamKind::Depth => self.max_error_codes.is_some() || self.max_error_m.is_some(),
            StreamKind::Material => self.max_error_codes.is_some(),
            StreamKind::Color => self.min_psnr_db.is_some(),
        };
        let cost = self.decode_ms.is_some() || self.max_bytes.is_some() || self.max_ratio_percent.is_some();
        match (quality, cost) {
            (true, _) => Some(Aim::Smallest),
            (false, true) => Some(Aim::Closest),
            (false, false) => None,
        }
    }

    fn misses(&self, measured: &Measured) -> Vec<Miss> {
        let mut misses = Vec::new();
        let kind = measured.point.kind;
        if let (Some(limit), Some(codes)) = (self.max_error_codes, measured.quality.max_error_codes)
            && codes > limit
        {
            let words = format!("--max-error {limit}: its largest error is {codes} codes");
            misses.push((words, f64::from(codes) / f64::from(limit.max(1))));
        }
        if let (Some(limit), Some(metres)) = (self.max_error_m, measured.quality.max_error_m)
            && metres > limit
        {
            let words = format!("--max-error-m {limit}: its largest error is {metres:.4} m");
            misses.push((words, metres / limit.max(1e-9)));
        }
        if let (Some(limit), StreamKind::Color) = (self.min_psnr_db, kind) {
            let found = measured.quality.min_psnr_db.unwrap_or(measured.quality.psnr_db);
            // A PSNR is computed twice, on either side of a file: the last digit may differ.
            if found < limit - 1e-6 {
                let words = format!("--min-psnr {limit}: its lowest PSNR of a frame of a cell is {found:.2} dB");
                misses.push((words, limit / found.max(1.0)));
            }
        }
        if let Some(limit) = self.decode_ms {
            match measured.decode_ms_per_frame() {
                Some(found) if found <= limit => {}
                Some(found) => {
                    let words = format!("--decode-ms {limit}: one point in time takes {found:.3} ms");
                    misses.push((words, found / limit.max(1e-9)));
                }
                None => misses.push((format!("--decode-ms {limit}: its decoding has not been timed"), f64::INFINITY)),
            }
        }
        let bytes = measured.sizes.container;
        if let Some(limit) = self.max_bytes.filter(|limit| bytes > *limit) {
            misses.push((format!("--max-bytes {limit}: it has {bytes}"), bytes as f64 / limit.max(1) as f64));
        }
        let ratio = measured.ratio_percent();
        if let Some(limit) = self.max_ratio_percent.filter(|limit| ratio > *limit) {
            misses.push((format!("--max-ratio {limit}: it has {ratio:.2}% of the footage"), ratio / limit.max(1e-9)));
        }
        misses
    }
}

/// Advice for each kind of stream that was measured and of which something is asked, in the order of kinds.
pub fn recommend<'a>(measured: &[&'a Measured], demands: &Demands) -> Vec<Advice<'a>> {
    let of_kind = |kind: StreamKind| {
        let aim = demands.aim(kind)?;
        let points = measured.iter().filter(|measured| measured.point.kind == kind);
        let judged = points.map(|&point| (point, demands.misses(point)));
        let (point, misses) = judged.min_by(|(a, misses_a), (b, misses_b)| {
            let by_how_much = |misses: &[Miss]| misses.iter().map(|(_, ratio)| ratio.ln()).sum::<f64>();
            let order = misses_a.len().cmp(&misses_b.len());
            let order = order.then(by_how_much(misses_a).total_cmp(&by_how_much(misses_b)));
            let order = match aim {
                Aim::Smallest => order,
                Aim::Closest => order.then(closeness_db(b).total_cmp(&closeness_db(a))),
            };
            order.then(a.sizes.container.cmp(&b.sizes.container)).then(a.point.cmp(&b.point))
        })?;
        Some(Advice { point, aim, misses: misses.into_iter().map(|(words, _)| words).collect() })
    };
    StreamKind::ALL.into_iter().filter_map(of_kind).collect()
}

/// How close a point is to the source in dB: by its worst cell where it has cells.
fn closeness_db(of: &Measured) -> f64 {
    of.quality.min_psnr_db.unwrap_or(of.quality.psnr_db)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::point::{Point, Quality, Sizes, Timing};

    /// A point of depth of so many bytes, codes of error and seconds of decoding.
    fn depth(error: &str, bytes: u64, codes: u32, seconds: f64) -> Measured {
        Measured {
            point: Point::new(StreamKind::Depth, vec![("max-error", error.to_owned())]),
            sizes: Sizes { raw: 1000, temporal: bytes, spatial: None, container: bytes, lzma2: bytes },
            quality: Quality {
                psnr_db: 80.0,
                min_psnr_db: None,
                ssim: None,
                max_error_codes: Some(codes),
                max_error_m: Some(0.1),
            },
            encode: Timing { runs: vec![1.0] },
            decode: Timing { runs: vec![seconds] },
            frames: 10,
            images: 60,
            pixels: 1000,
            updated_pixels: 500,
            decode_passes: 9,
            encode_peak_bytes: None,
            decode_peak_bytes: None,
        }
    }

    fn color(psnr: &str, bytes: u64, min_psnr_db: f64) -> Measured {
        let mut of = depth("0", bytes, 0, 0.01);
        of.point = Point::new(StreamKind::Color, vec![("psnr", psnr.to_owned())]);
        of.quality = Quality { min_psnr_db: Some(min_psnr_db), max_error_codes: None, max_error_m: None, ..of.quality };
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
            advice.iter().map(|advice| (advice.point.point.settings[0].1.clone(), advice.misses.len())).collect()
        };
        let said = |values: &[(&str, usize)]| -> Vec<(String, usize)> {
            values.iter().map(|(value, misses)| ((*value).to_owned(), *misses)).collect()
        };
        let none = Demands::default();
        assert!(none.is_empty());
        // A demand in dB says nothing about depth, and one in codes or metres nothing about colour.
        assert_eq!(ask(&Demands { max_error_codes: Some(55), ..none }), said(&[("50", 0)]));
        assert_eq!(ask(&Demands { max_error_m: Some(0.2), ..none }), said(&[("60", 0)]));
        assert_eq!(ask(&Demands { max_error_m: Some(0.05), ..none }), said(&[("60", 1)]));
        assert_eq!(ask(&Demands { min_psnr_db: Some(35.0), ..none }), said(&[("40", 0)]));
        // 0.02 s for ten points in time are 2 ms. Nothing is asked of the quality of colour: the best in time.
        let fast = Demands { max_error_codes: Some(55), decode_ms: Some(2.5), ..none };
        assert_eq!(ask(&fast), said(&[("40", 0), ("0", 0)]));
        assert_eq!(fast.aim(StreamKind::Color), Some(Aim::Closest));
        assert_eq!(fast.aim(StreamKind::Depth), Some(Aim::Smallest));
        assert_eq!(ask(&Demands { max_ratio_percent: Some(15.0), ..none }), said(&[("30", 1), ("60", 0)]));
        // Of several with the same quality, the smallest.
        assert_eq!(ask(&Demands { max_bytes: Some(450), ..none }), said(&[("30", 0), ("60", 0)]));
    }

    #[test]
    fn where_none_does_the_nearest_and_what_it_misses() {
        let points = [depth("0", 300, 0, 0.02), depth("50", 200, 50, 0.03), depth("60", 100, 60, 0.01)];
        let all: Vec<_> = points.iter().collect();
        let strict = Demands { max_error_codes: Some(40), max_bytes: Some(150), ..Demands::default() };
        let advice = recommend(&all, &strict);
        assert_eq!(advice[0].point.point.settings[0].1, "60");
        assert_eq!(advice[0].misses, ["--max-error 40: its largest error is 60 codes"]);
        let untimed = Measured { decode: Timing::default(), ..points[2].clone() };
        let advice = recommend(&[&untimed], &Demands { decode_ms: Some(1e9), ..Demands::default() });
        assert!(advice[0].misses[0].contains("not been timed"));
    }
}
