//! Hierarchical acquisition (Epipolar 3.3.1): source views at both ends of the line, and more between them while too many pixels
//! are missing.
//!
//! Listings 3.4 to 3.6 of the thesis compare the number of holes with the threshold in the wrong direction, and name a set of
//! vertices where a set of views is meant. This implementation divides an interval if more pixels are missing than the threshold
//! allows.

use std::collections::VecDeque;
use std::time::Instant;

use super::settings::{Hierarchy, SourcePlacement, StoppingRule};
use crate::backend::Backend;
use crate::counters::Counters;
use crate::erosion::eroded_percent;
use crate::interpolate::hole_percent;
use crate::source::SourceView;
use crate::views::OutputViews;
use codec::error::Result;

/// Number of equal parts of the interval between two sources. The positions between the parts are searched for the most holes
/// (Epipolar 7.5).
const PARTS: u32 = 8;

/// Returns source views that span the line from the first output view to the last, in any order. `make` acquires source views at
/// the given positions, in metres to the right of the middle.
pub fn hierarchical(
    views: &OutputViews,
    settings: &Hierarchy,
    backend: &dyn Backend,
    mut make: impl FnMut(&[f64]) -> Result<(Vec<SourceView>, Counters)>,
) -> Result<(Vec<SourceView>, Counters)> {
    let begun = Instant::now();
    let ends_m = views.ends_m();
    let (mut sources, mut counters) = make(&ends_m)?;
    let mut open = VecDeque::from([ends_m]);
    while let Some([left_m, right_m]) = open.pop_front()
        && sources.len() < settings.max_sources
        && settings.time.is_none_or(|time| begun.elapsed() < time)
    {
        let at = |offset_m: f64| sources.iter().find(|source| source.offset_m == offset_m);
        let Some(pair) = at(left_m).zip(at(right_m)) else { continue };
        let gap = Gap { views, pair: [pair.0, pair.1] };
        let next_m = match settings.placement {
            SourcePlacement::Midpoint => gap.place_m(0.5),
            SourcePlacement::Clusters => gap.max_holes_m(),
        };
        if next_m <= left_m || next_m >= right_m {
            continue;
        }
        let missing = match settings.stop {
            StoppingRule::Holes => hole_percent(views, &gap.pair, next_m),
            StoppingRule::Erosion => eroded_percent(views, gap.pair, |moves| backend.eroded(moves))?,
        };
        if missing <= settings.hole_threshold_percent {
            continue;
        }
        let (source, of_source) = make(&[next_m])?;
        counters.add(&of_source);
        sources.extend(source);
        open.extend([[left_m, next_m], [next_m, right_m]]);
    }
    Ok((sources, counters))
}

/// Interval between two neighbouring sources, from left to right.
struct Gap<'a> {
    views: &'a OutputViews,
    pair: [&'a SourceView; 2],
}

impl Gap<'_> {
    fn place_m(&self, part: f64) -> f64 {
        let [left_m, right_m] = self.pair.map(|source| source.offset_m);
        left_m + part * (right_m - left_m)
    }

    /// Returns the position with the most missing pixels; ties go to the position nearest to the middle.
    fn max_holes_m(&self) -> f64 {
        // From the middle outwards, so that the first of several equal positions is kept.
        let mut parts: Vec<u32> = (1..PARTS).collect();
        parts.sort_by_key(|&part| part.abs_diff(PARTS / 2));
        let mut most = (-1.0, 0.5);
        for part in parts.into_iter().map(|part| f64::from(part) / f64::from(PARTS)) {
            let holes = hole_percent(self.views, &self.pair, self.place_m(part));
            if holes > most.0 {
                most = (holes, part);
            }
        }
        self.place_m(most.1)
    }
}
