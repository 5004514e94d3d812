//! Sweeps of camera placement. The input is a scene.

use super::args::{Args, refuse_options_of_coding};
use super::fixed::{OptionsOf, implied};
use super::measure::measure_grid;
use crate::report::tradeoff::placement::{PLACEMENT, PlacementBench};
use crate::report::tradeoff::plan;
use crate::report::tradeoff::study::Axis;
use crate::{ExitStatus, GlobalArgs};
use codec::error::Result;

/// Options of `place` that are set by tradeoff.
const OWN: &[&str] = &["output", "json", "quiet", "plot", "csv", "start", "compare-k"];
/// Options of the search. All others define the surface to cover, and also apply to the comparison.
const OF_THE_SEARCH: &[&str] =
    &["effort", "candidates", "surface-samples", "grid", "cameras", "until", "uniform", "threads"];

pub fn measure(args: &Args, scene: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    refuse_options_of_coding(args, "placing cameras in a scene")?;
    let study = plan::grid(&PLACEMENT, &args.sweep)?;
    let fixed = fixed(scene, &args.fixed, &study.axes)?;
    let bench = PlacementBench { scene: scene.to_owned(), fixed: fixed.all, ruler: fixed.ruler };
    measure_grid(args, study, bench, global)
}

#[derive(Debug, Default)]
struct Fixed {
    all: Vec<String>,
    /// Options that define the surface to cover.
    ruler: Vec<String>,
}

/// Returns the options after `--`, and those that the swept knobs require.
fn fixed(scene: &str, words: &[String], axes: &[Axis]) -> Result<Fixed> {
    let line = [scene, "-o", "a.json"];
    let options = OptionsOf { command: "place", line: &line, own: OWN, also: None }.read(words, axes)?;
    let mut fixed = Fixed::default();
    for option in &options {
        fixed.all.extend(option.words());
        if !OF_THE_SEARCH.contains(&option.name.as_str()) {
            fixed.ruler.extend(option.words());
        }
    }
    for (name, value) in implied(&PLACEMENT, axes, &options) {
        let word = format!("--{name}={value}");
        fixed.ruler.push(word.clone());
        fixed.all.push(word);
    }
    Ok(fixed)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::Cli;
    use crate::tradeoff::fixed::parse;

    #[test]
    fn every_knob_is_an_option_of_place_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let place = root.find_subcommand("place").unwrap();
        for knob in PLACEMENT.knobs {
            let option = place.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
            for value in knob.usual {
                let option = knob.option(value).unwrap();
                let line = ["place", "cornell", "--region=0,0,0,1,1,1", option.as_str(), "-o", "a.json"];
                let implied = knob.implies.iter().map(|(name, value)| format!("--{name}={value}").into());
                let line: Vec<_> = line.map(Into::into).into_iter().chain(implied).collect();
                parse(&line).unwrap_or_else(|error| panic!("{option}: {error}"));
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
            fixed("cornell", &words, &[Axis { knob: swept, values: vec!["1".to_owned()] }])
        };
        let two = "--region -1,-1,-1,1,1,1 --region=2,2,2,3,3,3 --cameras 4";
        let found = of(two, "effort").unwrap();
        assert_eq!(found.ruler, ["--region=-1,-1,-1,1,1,1", "--region=2,2,2,3,3,3"]);
        assert!(found.all.len() == 3 && found.all.contains(&"--cameras=4".to_owned()), "{found:?}");
        let many = "--region=0,0,0,1,1,1 --k 2 --lighting specular --theta 20 --fps 30 --frames 0-3 --min-distance 1 \
                    --candidates 9 --surface-samples 99 --grid --until 0.1 --threads 2";
        let of_scene = of(many, "effort").unwrap().ruler;
        let mut names: Vec<&str> = of_scene.iter().filter_map(|word| word.split('=').next()).collect();
        names.sort_unstable();
        assert_eq!(names, ["--fps", "--frames", "--k", "--lighting", "--min-distance", "--region", "--theta"]);
        assert!(of("--region 0,0,0,1,1,1 --cameras 4", "cameras").unwrap_err().to_string().contains("swept"));
        let implied = |line: &str| of(line, "theta").unwrap().ruler.contains(&"--lighting=specular".to_owned());
        assert!(implied(two) && !implied("--region 0,0,0,1,1,1 --lighting diffuse"));
        assert!(of("--region 0,0,0,1,1,1 --json", "k").unwrap_err().to_string().contains("itself"));
    }
}
