//! Score of size and decoding time: CALF's weighted geometric score (figures 7 and 8).

use super::point::Measured;
use super::study::{Results, Study, Weights};

const MIN_SECONDS: f64 = 1e-9;

#[derive(Debug, Clone)]
pub struct Scored<'a> {
    /// In the given order. `None` for points that were not measured.
    pub points: Vec<Option<&'a Measured>>,
    pub scores: Vec<Option<f64>>,
    pub best: Option<usize>,
}

impl<'a> Scored<'a> {
    /// Scores points: the product of bytes and decoding time, each raised to the power of its weight, divided by the
    /// smallest such product. The best point scores 1, and less is better. `None` for points that were not measured or
    /// timed.
    ///
    /// CALF first maps bytes and times to 0..=1. In a product of such numbers, a point that is best in one scores 0
    /// regardless of the other, so these scores differ from the paper's. Neither score accounts for quality.
    pub fn new(points: Vec<Option<&'a Measured>>, weights: Weights) -> Scored<'a> {
        let products: Vec<Option<f64>> = points.iter().map(|point| product((*point)?, weights)).collect();
        let best = best(&products);
        let least = best.and_then(|at| products[at]).unwrap_or(0.0);
        // Computed from logarithms to avoid overflow.
        let scores = products.into_iter().map(|product| product.map(|product| (product - least).exp())).collect();
        Scored { points, scores, best }
    }

    /// Scores the points of a study, in its order. Empty for sweep kinds without scores.
    pub fn of_study(results: &'a Results, study: &Study) -> Scored<'a> {
        let points = if results.sweep.is_scored { study.points() } else { Vec::new() };
        Scored::new(points.iter().map(|point| results.of(point)).collect(), results.weights)
    }

    /// Returns the point with the lowest score, if at least two points have a score.
    pub fn winner(&self) -> Option<&'a Measured> {
        if self.count() > 1 { self.points[self.best?] } else { None }
    }

    pub fn count(&self) -> usize {
        self.scores.iter().flatten().count()
    }

    pub fn quality_differs(&self) -> bool {
        let scored = self.points.iter().zip(&self.scores).filter(|(_, score)| score.is_some());
        let mut qualities = scored.filter_map(|(point, _)| *point);
        let first = qualities.next();
        qualities.any(|other| first.is_some_and(|first| !is_of_like_quality(first, other)))
    }
}

pub fn best(values: &[Option<f64>]) -> Option<usize> {
    let there = values.iter().enumerate().filter_map(|(at, value)| Some((at, (*value)?)));
    there.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}

/// Returns the weighted sum of the logarithms of bytes and decoding time.
fn product(point: &Measured, weights: Weights) -> Option<f64> {
    let seconds = point.number("decode_seconds")?.max(MIN_SECONDS);
    let bytes = point.number("bytes_container")?.max(1.0);
    Some(weights.compression * bytes.ln() + weights.decoding * seconds.ln())
}

/// True if two points have the same quality in tables: to 1/100 dB, 1/10,000 of SSIM and one code.
fn is_of_like_quality(a: &Measured, b: &Measured) -> bool {
    let near = |name: &str, reach: f64| match (a.number(name), b.number(name)) {
        (Some(a), Some(b)) => a == b || (a - b).abs() < reach,
        (a, b) => a.is_none() && b.is_none(),
    };
    near("psnr_db", 0.01) && near("min_psnr_db", 0.01) && near("ssim", 1e-4) && near("max_error_codes", 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::point::Value;
    use crate::report::tradeoff::tests::sample;

    fn point(bytes: u64, seconds: f64) -> Measured {
        let mut point = sample::measured(&[], bytes, seconds);
        point.set("decode_runs", Value::Runs(vec![seconds]));
        point
    }

    fn check(points: &[Measured], expected: &[f64], best: usize) {
        let points: Vec<Option<&Measured>> = points.iter().map(Some).chain([None]).collect();
        let found = Scored::new(points, Weights::default());
        for (found, expected) in found.scores.iter().zip(expected) {
            assert!((found.unwrap() - expected).abs() < 1e-9, "{found:?} {expected}");
        }
        assert_eq!((found.scores[expected.len()], found.best, found.count()), (None, Some(best), expected.len()));
    }

    #[test]
    fn the_best_has_1_and_weights_are_powers() {
        check(&[point(100, 2.0), point(1600, 2.0), point(100, 32.0)], &[1.0, 2.0, 8.0], 0);
        // Neither point is best in both; the better one scores 1 nevertheless.
        check(&[point(100, 32.0), point(1600, 2.0)], &[4.0, 1.0], 1);
    }

    #[test]
    fn no_time_and_no_bytes_are_no_division_by_zero() {
        let points = [sample::measured(&[], 0, 0.0), sample::measured(&[], 10, 1.0)];
        let scored = Scored::new(points.iter().map(Some).collect(), Weights::default());
        assert!(scored.scores.iter().all(|score| score.is_some_and(|score| score > 0.0 && score.is_finite())));
        assert_eq!(Scored::new(vec![], Weights::default()).best, None);
        assert!(Scored::new(vec![Some(&points[0])], Weights::default()).winner().is_none());
    }

    #[test]
    fn quality_differs_where_a_knob_of_quality_is_swept() {
        let results = sample::paper();
        let differs = |at: usize| Scored::of_study(&results, &results.studies[at]).quality_differs();
        assert_eq!([0, 1, 2, 3].map(differs), [false, true, true, false]);
    }

    #[test]
    fn qualities_are_alike_where_they_are_printed_alike() {
        let of = |psnr_db, codes| {
            let mut of = sample::measured(&[], 1, 1.0);
            of.set("psnr_db", Value::Number(psnr_db));
            of.set("max_error_codes", Value::Count(codes));
            of
        };
        let inf = f64::INFINITY;
        assert!(is_of_like_quality(&of(inf, 0), &of(inf, 0)) && is_of_like_quality(&of(40.0, 3), &of(40.004, 3)));
        assert!(!is_of_like_quality(&of(inf, 0), &of(90.0, 0)) && !is_of_like_quality(&of(40.0, 3), &of(40.0, 4)));
        let mut other = of(40.0, 3);
        other.set("ssim", Value::Number(1.0));
        assert!(!is_of_like_quality(&of(40.0, 3), &other));
    }
}
