//! Pareto front: the points that no other point dominates.

/// Returns the indices of the (cost, quality) points on the Pareto front, in order of cost. A point is on the front if
/// no other has at most its cost and at least its quality, with one of them better. Of equal points, the first is kept.
///
/// Points with NaN are never on the front. Infinite quality is better than any other.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&at| !points[at].0.is_nan() && !points[at].1.is_nan()).collect();
    // Sorts by cost, then by decreasing quality. The sort is stable: the first of equal points stays first.
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[b].1.total_cmp(&points[a].1)));
    let mut best = f64::NEG_INFINITY;
    let mut first = true;
    order.retain(|&at| {
        let leads = first || points[at].1 > best;
        if leads {
            best = points[at].1;
            first = false;
        }
        leads
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_front_rises() {
        let points = [(3.0, 40.0), (1.0, 30.0), (2.0, 29.0), (3.0, 41.0), (9.0, f64::INFINITY), (9.5, f64::INFINITY)];
        assert_eq!(front(&points), [1, 3, 4]);
        assert_eq!(front(&[(1.0, 1.0), (1.0, 1.0), (f64::NAN, 9.0)]), [0]);
        assert_eq!(front(&[]), [0usize; 0]);
    }

    proptest! {
        #[test]
        fn exactly_what_is_dominated_is_off_the_front(
            points in prop::collection::vec((0u8..12, 0u8..12), 0..24),
        ) {
            let points: Vec<(f64, f64)> = points.into_iter().map(|(a, b)| (f64::from(a), f64::from(b))).collect();
            let found = front(&points);
            for (at, &(cost, quality)) in points.iter().enumerate() {
                let better = points.iter().enumerate().any(|(other, &(c, q))| {
                    c <= cost && q >= quality && (c < cost || q > quality || other < at)
                });
                prop_assert_eq!(found.contains(&at), !better, "{:?} {:?}", points, found);
            }
        }
    }
}
