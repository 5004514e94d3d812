//! Medians and ranges of timed runs; means, ranges and line fits of measured values.

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub low: f64,
    pub high: f64,
}

/// Median: the middle run, or the mean of the two middle runs. `None` without runs.
pub fn median(runs: &[f64]) -> Option<f64> {
    let mut sorted = runs.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        count if count % 2 == 1 => Some(sorted[middle]),
        _ => Some((sorted[middle - 1] + sorted[middle]) / 2.0),
    }
}

pub fn spread(runs: &[f64]) -> Option<Spread> {
    let runs = || runs.iter().copied();
    Some(Spread { low: runs().min_by(f64::total_cmp)?, high: runs().max_by(f64::total_cmp)? })
}

/// Describes the number of runs of points: `a single run`, `medians of 3 runs`, `medians of 1 to 3 runs`. `None`
/// without runs.
pub fn runs_in_words(counts: impl IntoIterator<Item = usize>) -> Option<String> {
    let counts: Vec<usize> = counts.into_iter().filter(|&count| count > 0).collect();
    let (&least, &most) = (counts.iter().min()?, counts.iter().max()?);
    Some(match least {
        1 if most == 1 => "a single run".to_owned(),
        _ if least == most => format!("medians of {most} runs"),
        _ => format!("medians of {least} to {most} runs"),
    })
}

pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

pub fn geometric_mean(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value.max(f64::MIN_POSITIVE).ln())).exp()
}

/// Returns the smallest and the largest of positive values.
pub fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, 0.0], |[low, high], of| [low.min(of), high.max(of)])
}

/// Least-squares line through points: returns its slope and R², the share of the variance that the line explains. R² is
/// 1 if all y are equal.
pub fn line_fit(x: &[f64], y: &[f64]) -> (f64, f64) {
    let (mean_x, mean_y) = (mean(x.iter().copied()), mean(y.iter().copied()));
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| -> f64 { x.iter().zip(y).map(|(&x, &y)| of(x - mean_x, y - mean_y)).sum() };
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let explained = if yy > 0.0 { slope * xy / yy } else { 1.0 };
    (slope, explained)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_ranges() {
        assert_eq!((median(&[]), spread(&[])), (None, None));
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(spread(&[3.0, 1.0, 2.0]), Some(Spread { low: 1.0, high: 3.0 }));
    }

    #[test]
    fn runs_are_counted_in_words() {
        assert_eq!(runs_in_words([]), None);
        assert_eq!(runs_in_words([0, 0]), None);
        assert_eq!(runs_in_words([1, 1, 0]).as_deref(), Some("a single run"));
        assert_eq!(runs_in_words([3, 3]).as_deref(), Some("medians of 3 runs"));
        assert_eq!(runs_in_words([3, 1]).as_deref(), Some("medians of 1 to 3 runs"));
    }

    #[test]
    fn straight_lines_are_fitted() {
        let (slope, explained) = line_fit(&[1.0, 2.0, 3.0], &[3.0, 5.0, 7.0]);
        assert!((slope - 2.0).abs() < 1e-12 && (explained - 1.0).abs() < 1e-12);
        let (slope, explained) = line_fit(&[1.0, 2.0, 3.0], &[1.0, 0.0, 1.0]);
        assert!(slope.abs() < 1e-12 && explained.abs() < 1e-12);
        assert_eq!(line_fit(&[1.0, 2.0], &[4.0, 4.0]), (0.0, 1.0));
        assert_eq!(line_fit(&[2.0, 2.0], &[1.0, 4.0]), (0.0, 0.0));
    }
}
