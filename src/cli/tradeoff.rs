//! `lightfold tradeoff MANIFEST -o DIR`: measures bytes, time and quality of settings on the user's own footage.

mod args;
mod child;
mod coding;
mod fixed;
mod input;
mod interpolation;
mod measure;
mod placement;
mod rendering;
mod simplification;
mod text;
mod tiles;

use crate::report::tradeoff::knob::Stage;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::error::Result;
use scene::Scene;

pub use args::Args;
pub use child::end_with_parent;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.list_knobs {
        text::list_knobs(args.json)?;
        return Ok(ExitStatus::Passed);
    }
    let demands = args.recommend.demands()?;
    match (&args.input, demands) {
        (Some(scene), _) if Scene::is_named_by(scene) && interpolation::is_swept(args) => {
            interpolation::measure(args, scene, global)
        }
        (Some(scene), _) if Scene::is_named_by(scene) => placement::measure(args, scene, global),
        (Some(dataset), _) if args.sweep.iter().any(|sweep| sweep.knob.stage == Stage::Render) => {
            rendering::measure(args, dataset, global)
        }
        (Some(capture), _) if args.sweep.iter().any(|sweep| sweep.knob.stage == Stage::Simplify) => {
            simplification::measure(args, capture, global)
        }
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
