//! `inspect SCENE`: reports bounds, counts and animations of a scene.

use std::fmt::Write;

use serde::Serialize;

use super::args::Args;
use crate::options::WithAccount;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs, output};
use codec::error::Result;
pub use scene::Scene;
use scene::{Play, SceneBounds, SceneSummary};

#[derive(Serialize)]
struct Document<'a> {
    scene: &'a str,
    #[serde(flatten)]
    summary: SceneSummary,
}

pub fn run(args: &Args, name: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    args.refuse_all_but_json(&format!("{name}: a scene"))?;
    let (scene, account) = Scene::open(name, Play::All)?;
    let document = WithAccount { report: Document { scene: name, summary: scene.summary() }, account: &account };
    output::print_either(args.json, &document, || text(name, &document.report.summary))?;
    args.account.print_inspected(&account, args.json, global);
    Ok(ExitStatus::Passed)
}

pub fn box_text(&SceneBounds { min, max }: &SceneBounds) -> String {
    let numbers = |numbers: [f64; 3]| numbers.map(|value| format!("{value:.3}"));
    let size = numbers([0, 1, 2].map(|axis| max[axis] - min[axis])).join(" x ");
    format!("{} to {}, {size} m in x, y, z", numbers(min).join(", "), numbers(max).join(", "))
}

fn text(name: &str, summary: &SceneSummary) -> String {
    let mut out = format!("{name}\n");
    if let Some(bounds) = &summary.bounds_m {
        let _ = writeln!(out, "{}", box_text(bounds));
    }
    let mut table = Table::new("What|>Count");
    for (what, count) in [
        ("triangles", summary.triangles),
        ("objects", summary.objects),
        ("materials", summary.materials),
        ("textures", summary.textures),
        ("suns", summary.suns),
        ("lamps", summary.lamps),
    ] {
        table.row([what.to_owned(), count.to_string()]);
    }
    let _ = write!(out, "\n{table}");
    if summary.is_lit_by_default {
        out.push_str("\nNo lights: capture adds a sun and a sky\n");
    }
    if summary.animations.is_empty() {
        out.push_str("\nNo animations\n");
        return out;
    }
    let mut table = Table::new("Animation|>Seconds");
    for animation in &summary.animations {
        let length = animation.duration_s.map_or("-".to_owned(), |length| format!("{length:.3}"));
        table.row([animation.name.clone().unwrap_or_else(|| "(without a name)".to_owned()), length]);
    }
    let _ = write!(out, "\n{table}");
    out
}
