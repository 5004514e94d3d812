//! Fuzz tests of the parsers, with inputs mutated from valid ones.
//!
//! The test runs a fixed number of inputs of each target. `scripts/fuzz` runs any number of them: with `--long`, this program
//! runs a share of one target's inputs and prints a line of JSON.

#![allow(clippy::disallowed_methods)]

use std::fs;
use std::io::{Seek, Write};
use std::path::PathBuf;

use libtest_mimic::{Arguments, Failed, Trial};
use peak_alloc::PeakAlloc;
use serde_json::json;

mod inputs;
mod json;
#[allow(dead_code)]
#[path = "../suite/model_files.rs"]
mod model_files;
mod mutate;
mod run;
#[allow(dead_code)]
#[path = "../suite/samples.rs"]
mod samples;
mod seeds;
mod targets;

use inputs::Inputs;
use targets::{TARGETS, Target};

#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// Seed of the test.
const SEED: u64 = 1;
/// Kept regression inputs: targets, and number of files in `regressions/TARGET`.
const KEPT: &[(&str, usize)] = &[("exr", 6)];

/// Writes an input that caused a finding to a file and returns its path.
fn kept(target: &Target, input: &[u8]) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    fs::create_dir_all(&folder).expect("a folder for findings");
    let path = folder.join(format!("{}-{:08x}", target.name, crc32fast::hash(input)));
    fs::write(&path, input).expect("the finding is written");
    path
}

fn test(target: &'static Target) -> Result<(), Failed> {
    let inputs = Inputs::new(target, SEED);
    let (figures, findings) = run::run(target, &inputs, 0..target.execs, |_| ());
    if let Some(finding) = findings.first() {
        let path = kept(target, &inputs.get(finding.number));
        let again = format!("scripts/fuzz --target {} --replay {}", target.name, path.display());
        return Err(format!("{} findings; the first: {}; again: {again}", findings.len(), finding.what).into());
    }
    if figures.accepted == 0 || figures.accepted == figures.execs {
        return Err(format!("the test sees too little: {figures:?}").into());
    }
    Ok(())
}

/// Checks that the regression inputs of `KEPT` exist and no longer cause findings.
fn regressions() -> Result<(), Failed> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/regressions");
    for entry in fs::read_dir(&folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if entry.file_type()?.is_dir() && !KEPT.iter().any(|(target, _)| name == *target) {
            return Err(format!("regressions of {} are not in the list of this file", name.display()).into());
        }
    }
    for &(name, count) in KEPT {
        let target = TARGETS.iter().find(|target| target.name == name).ok_or("a target of the list is gone")?;
        let mut seen = 0;
        for file in fs::read_dir(folder.join(name)).map_err(|error| format!("regressions of {name}: {error}"))? {
            let path = file?.path();
            run::exec(target, &fs::read(&path)?).map_err(|what| format!("{}: {what}", path.display()))?;
            seen += 1;
        }
        if seen != count {
            return Err(format!("{seen} regressions of {name}, where {count} are kept").into());
        }
    }
    Ok(())
}

/// Checks that a seed determines the inputs of all targets.
fn inputs_follow_from_the_seed() -> Result<(), Failed> {
    for target in TARGETS {
        let (one, two, other) = (Inputs::new(target, 7), Inputs::new(target, 7), Inputs::new(target, 8));
        let numbers = 1000..1050;
        let all = |inputs: &Inputs| numbers.clone().map(|number| inputs.get(number)).collect::<Vec<_>>();
        if all(&one) != all(&two) || all(&one) == all(&other) {
            return Err(format!("inputs of {} do not follow from the seed", target.name).into());
        }
    }
    Ok(())
}

/// Options of `--long`.
#[derive(Default)]
struct Long {
    target: String,
    seed: u64,
    first: u64,
    step: u64,
    execs: u64,
    progress: Option<PathBuf>,
    replay: Option<PathBuf>,
    write: Option<PathBuf>,
}

impl Long {
    fn read(arguments: &[String]) -> Result<Long, String> {
        let mut long = Long { step: 1, execs: u64::MAX, ..Long::default() };
        for pair in arguments.chunks(2) {
            let [name, value] = pair else { return Err(format!("{pair:?} lacks a value")) };
            let count = || value.parse::<u64>().map_err(|_| format!("{name} {value}: a number was expected"));
            match name.as_str() {
                "--target" => long.target.clone_from(value),
                "--seed" => long.seed = count()?,
                "--first" => long.first = count()?,
                "--step" => long.step = count()?.max(1),
                "--execs" => long.execs = count()?,
                "--progress" => long.progress = Some(value.into()),
                "--replay" => long.replay = Some(value.into()),
                "--write" => long.write = Some(value.into()),
                _ => return Err(format!("{name} is unknown")),
            }
        }
        Ok(long)
    }

    fn run(&self) -> Result<i32, String> {
        let names: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
        if self.target == "list" {
            println!("{}", names.join("\n"));
            return Ok(0);
        }
        if self.target == "bounds" {
            // Prints, for each target, the maximum memory bound over 500 inputs.
            for target in TARGETS {
                let inputs = Inputs::new(target, self.seed);
                let bytes = (0..500).map(|at| (target.bound)(&inputs.get(at))).max().unwrap_or_default();
                println!("{} {bytes}", target.name);
            }
            return Ok(0);
        }
        let target = TARGETS.iter().find(|target| target.name == self.target);
        let target = target.ok_or_else(|| format!("the targets are {}", names.join(" ")))?;
        if let Some(path) = &self.replay {
            let input = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
            let result = run::exec(target, &input);
            println!("{}", result.as_ref().map_or_else(String::clone, |figures| format!("{figures:?}")));
            return Ok(i32::from(result.is_err()));
        }
        let inputs = Inputs::new(target, self.seed);
        if let Some(path) = &self.write {
            fs::write(path, inputs.get(self.first)).map_err(|error| format!("{}: {error}", path.display()))?;
            return Ok(0);
        }
        let mut progress =
            self.progress.as_ref().map(fs::File::create).transpose().map_err(|error| error.to_string())?;
        let started = |number: u64| {
            if let Some(file) = &mut progress {
                // If this process dies, the parent process reads the number of the input from this file.
                let _ = file.rewind().and_then(|()| file.write_all(&number.to_le_bytes()));
            }
        };
        let numbers = (0..self.execs).map(|at| self.first + at * self.step);
        let (figures, findings) = run::run(target, &inputs, numbers, started);
        let found = |finding: &run::Finding| {
            let path = kept(target, &inputs.get(finding.number));
            json!({ "number": finding.number, "what": finding.what, "file": path })
        };
        let line = json!({
            "target": target.name, "execs": figures.execs, "accepted": figures.accepted,
            "memory_share": figures.memory_share, "memory_bytes": figures.memory_bytes,
            "slowest_seconds": figures.slowest_seconds, "seconds": figures.seconds,
            "finding_count": findings.len(), "findings": findings.iter().take(8).map(found).collect::<Vec<_>>(),
        });
        println!("{line}");
        Ok(i32::from(!findings.is_empty()))
    }
}

fn main() {
    // Inputs are small, so waking other threads would take longer than running them.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(("--long", rest)) = arguments.split_first().map(|(first, rest)| (first.as_str(), rest)) {
        run::keep_panics();
        let code = Long::read(rest).and_then(|long| long.run()).unwrap_or_else(|message| {
            eprintln!("{message}");
            2
        });
        std::process::exit(code);
    }
    // One test at a time, because memory is measured for the whole process.
    let arguments = Arguments { test_threads: Some(1), ..Arguments::from_args() };
    run::keep_panics();
    let mut trials: Vec<Trial> =
        TARGETS.iter().map(|target| Trial::test(format!("fuzz::{}", target.name), move || test(target))).collect();
    trials.push(Trial::test("fuzz::regressions", regressions));
    trials.push(Trial::test("fuzz::inputs_follow_from_the_seed", inputs_follow_from_the_seed));
    libtest_mimic::run(&arguments, trials).exit();
}
