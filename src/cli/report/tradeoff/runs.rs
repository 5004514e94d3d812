//! Rows of points that differ in one knob only.

use super::kind::{Measured, Setting};
use super::knob;
use super::study::Results;
use codec::image::StreamKind;

/// Points that have all settings but one in common.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    pub others: Vec<Setting>,
    /// Value of the knob and the measured point, by increasing value.
    pub points: Vec<(f64, &'a Measured)>,
}

/// Returns all runs along a knob with at least `least` different values.
pub fn along<'a>(results: &'a Results, stream: Option<StreamKind>, name: &str, least: usize) -> Vec<Run<'a>> {
    let mut runs: Vec<Run<'a>> = Vec::new();
    for measured in results.measured.iter().filter(|measured| measured.point.stream == stream) {
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
