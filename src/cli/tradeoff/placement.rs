//! Sweeps of the options of `place`, where a scene was named instead of footage.

use std::time::Instant;

use clap::CommandFactory;
use clap::parser::ValueSource;

use super::grid::{Grid, Told};
use super::{Args, grid, input};
use crate::cli::{Cli, ExitStatus, GlobalArgs};
use crate::error::{Error, Result};
use crate::report::tradeoff::knob::Stage;
use crate::report::tradeoff::placement::{self, Sweep};
use crate::report::tradeoff::{Axis, Knob};
use crate::scene::Scene;

/// Options of `place` that tradeoff gives itself.
const OWN: &[&str] = &["output", "json", "quiet", "plot", "csv", "start", "compare-k"];
/// Options that say how cameras are found. All others say what is to be covered: points and ruler have them alike.
const OF_THE_SEARCH: &[&str] =
    &["effort", "candidates", "surface-samples", "grid", "cameras", "until", "spread", "threads"];

/// Whether a scene is meant and not footage.
pub fn is_scene(text: &str) -> bool {
    Scene::is_named_by(text)
}

/// Measures what placing cameras costs.
pub fn measure(args: &Args, scene: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    grid::refuse_others(args, "placing cameras in a scene")?;
    let axes = axes(args)?;
    let (mut fixed, mut ruler) = options_of_all(scene, &args.fixed, &axes)?;
    for (name, value) in implied(&axes, &fixed) {
        let word = format!("--{name}={value}");
        fixed.push(word.clone());
        ruler.push(word);
    }
    let sweep = Sweep { scene, fixed: &fixed, ruler: &ruler, axes: &axes, repeats: args.repeats };
    for settings in sweep.points() {
        input::parse(&sweep.command(&settings).into_iter().chain(["-o".into(), "a.json".into()]).collect::<Vec<_>>())?;
    }
    let grid = Grid {
        args,
        global,
        start,
        what: "placing",
        runs: sweep.runs(),
        points: sweep.points().len(),
        files: placement::files(&args.output),
    };
    let (folder, placed) = grid.measure(
        |runner, work, progress, keep| sweep.measure(runner, work, progress, keep),
        |placed| placement::to_csv(&axes, placed),
    )?;
    let (about, commands) = (placement::about(), placement::commands(&sweep));
    let told = Told {
        title: format!("What placing cameras costs: {scene}"),
        input: ("Scene", scene),
        about: &about,
        table: &placement::table(&axes, &placed),
        figures: &placement::figures(&sweep, &placed),
        commands: &commands,
        report: &placement::json(scene, &placed),
    };
    grid.tell(&told, folder)?;
    Ok(ExitStatus::Passed)
}

fn axes(args: &Args) -> Result<Vec<Axis>> {
    let mut axes: Vec<Axis> = Vec::new();
    for sweep in &args.sweep {
        // Effort and threads are knobs of encoding, too.
        let knob: &Knob = placement::find(sweep.knob.name).ok_or_else(|| {
            let names: Vec<&str> = placement::KNOBS.iter().map(|knob| knob.name).collect();
            let name = sweep.knob.name;
            Error::Usage(format!("--sweep {name}: it is no option of placing cameras, which has {}", names.join(", ")))
        })?;
        if axes.iter().any(|axis| axis.knob == knob.name) {
            return Err(Error::Usage(format!("--sweep {}: swept twice; name all values at once", knob.name)));
        }
        // Its usual values may be others than those of the option of encoding that has this name.
        let own = sweep.knob.stage == Stage::Place || sweep.given;
        let usual = || knob.usual.iter().map(|value| (*value).to_owned()).collect();
        axes.push(Axis { knob: knob.name, values: if own { sweep.values.clone() } else { usual() } });
    }
    if axes.is_empty() {
        return Err(Error::Usage(
            "nothing to measure: name options of place with --sweep, such as --sweep effort".to_owned(),
        ));
    }
    Ok(axes)
}

/// What swept knobs imply, unless it is swept or given.
fn implied(axes: &[Axis], given: &[String]) -> Vec<(&'static str, &'static str)> {
    let knobs = axes.iter().filter_map(|axis| placement::find(axis.knob));
    let is_open = |name: &str| {
        axes.iter().all(|axis| axis.knob != name) && given.iter().all(|word| !word.starts_with(&format!("--{name}=")))
    };
    knobs.flat_map(|knob| knob.implies.iter().copied()).filter(|(name, _)| is_open(name)).collect()
}

/// The options that all points have, and those of them that the ruler has, one word each.
fn options_of_all(scene: &str, words: &[String], axes: &[Axis]) -> Result<(Vec<String>, Vec<String>)> {
    let mut root = Cli::command();
    root.build();
    let line = ["lightfold", "place", scene, "-o", "a.json"].map(str::to_owned);
    let matches =
        root.clone().try_get_matches_from(line.iter().chain(words)).map_err(|error| input::refused(&error))?;
    let (Some((_, matches)), Some(place)) = (matches.subcommand(), root.find_subcommand("place")) else {
        return Ok((Vec::new(), Vec::new()));
    };
    let (mut fixed, mut ruler) = (Vec::new(), Vec::new());
    for argument in place.get_arguments() {
        let (id, Some(name)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        let given = matches!(matches.try_contains_id(id), Ok(true))
            && matches.value_source(id) == Some(ValueSource::CommandLine);
        if !given || name == "output" {
            continue;
        }
        if OWN.contains(&name) {
            return Err(Error::Usage(format!("--{name} after --: tradeoff gives it to its points itself")));
        }
        if axes.iter().any(|axis| axis.knob == name) {
            return Err(Error::Usage(format!("--{name}: it is swept, so that it cannot be fixed as well")));
        }
        let mut words = Vec::new();
        if argument.get_action().takes_values() {
            for values in matches.get_raw_occurrences(id).into_iter().flatten() {
                let values: Vec<_> = values.map(|value| value.to_string_lossy().into_owned()).collect();
                words.push(format!("--{name}={}", values.join(",")));
            }
        } else {
            words.push(format!("--{name}"));
        }
        if !OF_THE_SEARCH.contains(&name) {
            ruler.extend(words.iter().cloned());
        }
        fixed.extend(words);
    }
    Ok((fixed, ruler))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_is_an_option_of_place_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let place = root.find_subcommand("place").unwrap();
        for knob in placement::KNOBS {
            let option = place.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
            for value in knob.usual {
                let option = knob.option(value).unwrap();
                let line = ["place", "cornell", "--region=0,0,0,1,1,1", option.as_str(), "-o", "a.json"];
                let implied = knob.implies.iter().map(|(name, value)| format!("--{name}={value}").into());
                let line: Vec<_> = line.map(Into::into).into_iter().chain(implied).collect();
                input::parse(&line).unwrap_or_else(|error| panic!("{option}: {error}"));
            }
        }
    }

    #[test]
    fn every_name_is_an_option_of_place_and_in_one_list() {
        let mut root = Cli::command();
        root.build();
        let place = root.find_subcommand("place").unwrap();
        for name in OWN.iter().chain(OF_THE_SEARCH) {
            assert!(place.get_arguments().any(|argument| argument.get_long() == Some(name)), "--{name}");
        }
        assert!(OWN.iter().all(|name| !OF_THE_SEARCH.contains(name)));
    }

    #[test]
    fn options_of_all_points_are_sorted_or_refused() {
        let of = |line: &str, swept: &'static str| {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            let axes = [Axis { knob: swept, values: vec!["1".to_owned()] }];
            options_of_all("cornell", &words, &axes)
        };
        let two = "--region -1,-1,-1,1,1,1 --region=2,2,2,3,3,3 --cameras 4";
        let (fixed, ruler) = of(two, "effort").unwrap();
        assert_eq!(ruler, ["--region=-1,-1,-1,1,1,1", "--region=2,2,2,3,3,3"]);
        assert_eq!(fixed.len(), 3);
        let many = "--region=0,0,0,1,1,1 --k 2 --lighting specular --theta 20 --fps 30 --frames 0-3 --min-distance 1 \
                    --candidates 9 --surface-samples 99 --grid --until 0.1 --threads 2";
        let (_, of_scene) = of(many, "effort").unwrap();
        let mut names: Vec<&str> = of_scene.iter().filter_map(|word| word.split('=').next()).collect();
        names.sort_unstable();
        assert_eq!(names, ["--fps", "--frames", "--k", "--lighting", "--min-distance", "--region", "--theta"]);
        assert!(fixed.contains(&"--cameras=4".to_owned()));
        assert!(of("--region 0,0,0,1,1,1 --cameras 4", "cameras").unwrap_err().to_string().contains("swept"));
        let theta = [Axis { knob: "theta", values: vec!["20".to_owned()] }];
        assert_eq!(implied(&theta, &fixed), [("lighting", "specular")]);
        assert_eq!(implied(&theta, &["--lighting=diffuse".to_owned()]), []);
        assert!(of("--region 0,0,0,1,1,1 --json", "k").unwrap_err().to_string().contains("itself"));
    }
}
