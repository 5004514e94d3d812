//! Hierarchical acquisition: sources at the ends, and between them as long as too many pixels are missing (Epipolar 3.3.1).
//!
//! In listings 3.4 to 3.6 the comparison of the count of holes with the threshold goes the wrong way round, and a set of
//! vertices stands for a set of views: an interval is divided where more pixels are missing than the threshold allows.

use std::collections::VecDeque;

use super::tracer::SourceTracer;
use crate::epipolar::counters::Counters;
use crate::epipolar::interpolate::hole_percent;
use crate::epipolar::source::SourceView;
use crate::error::Result;

pub(super) fn acquire(tracer: &SourceTracer<'_>, ends_m: [f64; 2]) -> Result<(Vec<SourceView>, Counters)> {
    let (mut sources, mut counters) = tracer.views(ends_m.into_iter(), 1)?;
    let mut open = VecDeque::from([ends_m]);
    while let Some([left_m, right_m]) = open.pop_front()
        && sources.len() < tracer.settings.max_sources
    {
        let middle_m = 0.5 * (left_m + right_m);
        let pair: Vec<&SourceView> =
            sources.iter().filter(|source| [left_m, right_m].contains(&source.offset_m)).collect();
        if middle_m <= left_m || middle_m >= right_m {
            continue;
        }
        if hole_percent(tracer.views, &pair, middle_m) <= tracer.settings.hole_threshold_percent {
            continue;
        }
        let (added, of_view) = tracer.views([middle_m].into_iter(), 1)?;
        counters.add(&of_view);
        sources.extend(added);
        open.extend([[left_m, middle_m], [middle_m, right_m]]);
    }
    Ok((sources, counters))
}
