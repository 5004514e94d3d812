//! Points that differ in one knob only.

use super::table::CODING;
use crate::image::StreamKind;
use crate::report::tradeoff::kind::{Measured, Point, Setting};
use crate::report::tradeoff::knob;
use crate::report::tradeoff::study::Results;

/// Points that have all settings but one in common.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    pub others: Vec<Setting>,
    /// The number that the knob has, and what was measured; by rising number.
    pub points: Vec<(f64, &'a Measured)>,
}

/// All runs along a knob of a kind of stream with at least `least` different numbers.
pub fn along<'a>(results: &'a Results, kind: StreamKind, name: &str, least: usize) -> Vec<Run<'a>> {
    let mut runs: Vec<Run<'a>> = Vec::new();
    for measured in results.measured.iter().filter(|measured| measured.point.stream == Some(kind)) {
        let Some(number) = measured.point.value(name).and_then(knob::number) else { continue };
        let others = measured.point.without(name);
        match runs.iter_mut().find(|run| run.others == others) {
            Some(run) => run.points.push((number, measured)),
            None => runs.push(Run { others, points: vec![(number, measured)] }),
        }
    }
    for run in &mut runs {
        run.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    runs.retain(|run| run.points.len() >= least);
    runs
}

/// Depth as boxes of codes, without modelling functions, with these settings otherwise.
pub fn in_boxes<'a>(results: &'a Results, others: &[Setting]) -> Option<&'a Measured> {
    let others = others.iter().filter(|(name, _)| *name != "depth-codec").cloned();
    let settings = others.chain([("depth-codec", "aabb".to_owned())]).collect();
    results.of(&Point::new(&CODING, Some(StreamKind::Depth), settings))
}
