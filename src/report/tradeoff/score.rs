//! One number for size and decoding time: CALF's weighted geometric score (figures 7 and 8).

use super::Results;
use super::point::Measured;
use super::study::{Study, Weights};

/// What takes less than this counts as this much, so that a ratio to it exists.
const LEAST_SECONDS: f64 = 1e-9;

/// The score of each point: the product of its bytes over the least bytes of all and of its decoding time over the least
/// time of all, each to the power of its weight. 1 is best in both; less is better. None for a point that was not
/// measured or whose decoding was not timed.
///
/// CALF brings both into the range of 0 to 1 before they are multiplied. With that, a point that is best in one has the
/// score 0, however bad it is in the other; ratios do not.
pub fn scores(points: &[Option<&Measured>], weights: Weights) -> Vec<Option<f64>> {
    let costs: Vec<Option<(f64, f64)>> = points.iter().map(|point| point.and_then(cost)).collect();
    let least = |of: fn(&(f64, f64)) -> f64| costs.iter().flatten().map(of).fold(f64::INFINITY, f64::min);
    let (least_bytes, least_seconds) = (least(|cost| cost.0), least(|cost| cost.1));
    let score = |(bytes, seconds): (f64, f64)| {
        (bytes / least_bytes).powf(weights.compression) * (seconds / least_seconds).powf(weights.decoding)
    };
    costs.into_iter().map(|cost| cost.map(score)).collect()
}

/// The points of a study, in its order, with their scores, and which is the best.
pub fn of_study<'a>(
    results: &'a Results,
    study: &Study,
) -> (Vec<Option<&'a Measured>>, Vec<Option<f64>>, Option<usize>) {
    let points: Vec<Option<&Measured>> = study.points().iter().map(|point| results.of(point)).collect();
    let scores = scores(&points, results.weights);
    let best = best(&scores);
    (points, scores, best)
}

/// The least score, the first of several.
pub fn best(scores: &[Option<f64>]) -> Option<usize> {
    let scored = scores.iter().enumerate().filter_map(|(at, score)| Some((at, (*score)?)));
    scored.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}

fn cost(point: &Measured) -> Option<(f64, f64)> {
    let seconds = point.decode.median()?;
    Some((point.sizes.container.max(1) as f64, seconds.max(LEAST_SECONDS)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::sample;

    #[test]
    fn one_is_best_in_both_and_weights_are_powers() {
        let of = |bytes: u64, seconds: f64| {
            let mut point = sample::measured(&[], bytes, seconds);
            point.decode.runs = vec![seconds];
            point
        };
        let points = [of(100, 2.0), of(1600, 2.0), of(100, 32.0)];
        let points: Vec<Option<&Measured>> = points.iter().map(Some).chain([None]).collect();
        let found = scores(&points, Weights::default());
        let expected = [1.0, 2.0, 8.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.unwrap() - expected).abs() < 1e-12, "{found:?} {expected}");
        }
        assert_eq!((found[3], best(&found)), (None, Some(0)));
    }

    #[test]
    fn no_time_and_no_bytes_are_no_division_by_zero() {
        let points = [sample::measured(&[], 0, 0.0), sample::measured(&[], 10, 1.0)];
        let points: Vec<Option<&Measured>> = points.iter().map(Some).collect();
        assert!(scores(&points, Weights::default()).iter().all(|score| score.is_some_and(f64::is_finite)));
        assert_eq!(best(&scores(&[], Weights::default())), None);
    }
}
