//! Sweeps of simplification. The input is a capture.

use super::args::{Args, refuse_options_of_coding};
use super::fixed::{FixedSettings, OptionsOf};
use super::measure::measure_grid;
use crate::report::tradeoff::plan;
use crate::report::tradeoff::simplification::{SIMPLIFICATION, SimplificationBench};
use crate::report::tradeoff::study::Axis;
use crate::{ExitStatus, GlobalArgs};
use codec::error::Result;

/// Options of `simplify` that are set by tradeoff.
const OWN: &[&str] = &["output", "json", "quiet"];

pub fn measure(args: &Args, capture: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    refuse_options_of_coding(args, "simplifying a capture")?;
    let mut study = plan::grid(&SIMPLIFICATION, &args.sweep)?;
    let fixed = fixed(&args.fixed, &study.axes)?;
    study.fixed = fixed.knobs;
    measure_grid(args, study, SimplificationBench { capture: capture.to_owned(), fixed: fixed.words }, global)
}

fn fixed(words: &[String], axes: &[Axis]) -> Result<FixedSettings> {
    let line = ["capture", "-o", "scene.glb"];
    let options = OptionsOf { command: "simplify", line: &line, own: OWN, also: None };
    Ok(FixedSettings::new(&SIMPLIFICATION, axes, &options.read(words, axes)?))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::CommandFactory;

    use super::*;
    use crate::Cli;
    use crate::report::tradeoff::runner::CommandBench;
    use crate::tradeoff::fixed::parse;

    #[test]
    fn every_knob_is_an_option_of_simplify_and_takes_its_usual_values() {
        let mut root = Cli::command();
        root.build();
        let simplify = root.find_subcommand("simplify").unwrap();
        let bench = SimplificationBench { capture: "set".to_owned(), fixed: Vec::new() };
        for knob in SIMPLIFICATION.knobs {
            let option = simplify.get_arguments().find(|argument| argument.get_long() == Some(knob.name)).unwrap();
            if let [default] = option.get_default_values() {
                assert_eq!(default.to_str(), Some(knob.default), "{}", knob.name);
            }
            let study = plan::grid(&SIMPLIFICATION, &[plan::Sweep::parse(knob.name).unwrap()]).unwrap();
            for point in study.points() {
                let line = bench.line(&point, Path::new("."));
                parse(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"));
            }
        }
        for name in OWN {
            assert!(simplify.get_arguments().any(|argument| argument.get_long() == Some(name)), "--{name}");
        }
    }

    #[test]
    fn options_of_all_points_are_taken_or_refused() {
        let of = |line: &str| {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            fixed(&words, &[Axis { knob: "area", values: vec!["2".to_owned()] }])
        };
        let mut fixed = of("--frames 3 --region=0,0,0,1,1,1 --effort fast").unwrap();
        fixed.words.sort_unstable();
        assert_eq!(fixed.words, ["--frames=3", "--region=0,0,0,1,1,1"]);
        assert_eq!(fixed.knobs, [("effort", "fast".to_owned())]);
        let said = |line: &str| of(line).unwrap_err().to_string();
        assert!(said("--area 3").contains("swept") && said("--json").contains("itself"));
    }
}
