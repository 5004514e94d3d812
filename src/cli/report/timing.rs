//! Medians and ranges of timed runs.

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
}
