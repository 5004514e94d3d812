//! `lightfold tradeoff MANIFEST -o DIR`: measures bytes, time and quality of settings on the user's own footage.

mod args;
mod coding;
mod fixed;
mod grid;
mod input;
mod measure;
mod text;

use crate::report::tradeoff::kind::{INTERPOLATION, PLACEMENT, RENDERING, SIMPLIFICATION, SweepKind};
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::error::Result;
use scene::Scene;

pub use args::Args;

/// Returns the kind of sweep whose points are a command each. `None` for coding.
fn kind(args: &Args, input: &str) -> Option<&'static SweepKind> {
    let has = |kind: &SweepKind| args.sweep.iter().any(|sweep| sweep.kind == kind);
    let mut names = args.sweep.iter().map(|sweep| sweep.knob.name);
    let mut is_interpolated = || names.any(|name| INTERPOLATION.knob(name).is_some() && PLACEMENT.knob(name).is_none());
    match Scene::is_named_by(input) {
        true if is_interpolated() => Some(&INTERPOLATION),
        true => Some(&PLACEMENT),
        false if has(&RENDERING) => Some(&RENDERING),
        false if has(&SIMPLIFICATION) => Some(&SIMPLIFICATION),
        false => None,
    }
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.list_knobs {
        text::list_knobs(args.json)?;
        return Ok(ExitStatus::Passed);
    }
    let demands = args.recommend.demands()?;
    if let Some(input) = &args.input
        && let Some(kind) = kind(args, input)
    {
        return grid::measure(args, kind, input, global);
    }
    match (&args.input, demands) {
        (Some(input), demands) => coding::measure(args, input, demands, global),
        (None, Some(demands)) => {
            let measuring = !args.sweep.is_empty() || args.preset.is_some() || !args.fixed.is_empty();
            if measuring || args.budget_seconds.is_some() || args.weights.is_some() {
                return refuse(
                    "--sweep, --preset, --budget-seconds, --weights and options after -- need footage to measure: \
                    specify it, or leave them out to recommend a point in DIR",
                );
            }
            coding::recommend_from_folder(args, &demands)
        }
        (None, None) => refuse("no footage to measure was given"),
    }
}
