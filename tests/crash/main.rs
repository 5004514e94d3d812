//! Crash tests of every command that writes files: power fails after each of its file operations.
//!
//! A command runs in this process while `footage::files` records its operations. Each prefix of the record is a point at which
//! power may fail. The states that the disk may then have are given by a model in which everything that was not synced may be
//! lost ([`disk`]). In each state, every output is the previous file, the complete new file, or missing. After the command has
//! ended it is the new file, and `--resume` produces the bytes of an uninterrupted run.

#![allow(clippy::disallowed_methods)]

mod cases;
mod disk;

use std::collections::BTreeSet;
use std::error::Error;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cases::{CAMERAS, CASES, Case, INPUTS};
use disk::{Disk, Names};
use footage::files::record::{Operation, record};
use libtest_mimic::{Arguments, Failed, Trial};

type Outcome = Result<(), Box<dyn Error>>;

/// Number of crashed states to resume from, per kind of loss.
const RESUMED: usize = 6;

fn main() -> ExitCode {
    // `tradeoff` starts commands with its own executable, which is this program.
    let words: Vec<OsString> = std::env::args_os().collect();
    let is_command = |word: &OsString| !word.to_string_lossy().starts_with('-') && std::env::var_os(CHILD).is_some();
    if words.get(1).is_some_and(is_command) {
        return lightfold::run_command_line(words);
    }
    let mut arguments = Arguments::from_args();
    // Cases change the working directory of the process, so they cannot run in parallel.
    arguments.test_threads = Some(1);
    if arguments.list {
        return libtest_mimic::run(&arguments, trials(PathBuf::new())).exit_code();
    }
    let base = tempfile::tempdir().expect("a folder for temporary files");
    let base = base.path().canonicalize().expect("a folder that is there");
    fs::create_dir(base.join("inputs")).expect("a folder that may be written");
    std::env::set_current_dir(base.join("inputs")).expect("a folder that is there");
    fs::write("path.json", CAMERAS).expect("an input");
    for line in INPUTS {
        run(line).unwrap_or_else(|error| panic!("{error}"));
    }
    let conclusion = libtest_mimic::run(&arguments, trials(base.clone()));
    let _ = std::env::set_current_dir("/").and_then(|()| fs::remove_dir_all(base));
    conclusion.exit_code()
}

/// Environment variable that is set for the processes that `tradeoff` starts.
const CHILD: &str = "LIGHTFOLD_ENDS_WITH_INPUT";

fn trials(base: PathBuf) -> Vec<Trial> {
    let trial = |case: &'static Case| {
        let folder = base.join("work");
        Trial::test(case.line.replace("../inputs/", ""), move || case.test(&folder).map_err(Failed::from))
    };
    CASES.iter().map(trial).collect()
}

/// Runs a command line in this process.
fn run(line: &str) -> Outcome {
    let words = ["lightfold"].into_iter().chain(line.split_whitespace());
    match lightfold::run_command_line(words.map(OsString::from)) {
        code if code == ExitCode::SUCCESS => Ok(()),
        code => Err(format!("{line}: {code:?}").into()),
    }
}

impl Case {
    fn test(&self, folder: &Path) -> Outcome {
        let mut before = self.prepared(folder)?;
        for round in ["a new place", "files of an earlier run"] {
            disk::write(folder, &before);
            std::env::set_current_dir(folder)?;
            let (ended, operations) = record(Path::new(""), || run(self.line));
            ended?;
            let after = disk::read(folder);
            self.replay(&before, &operations, &after).map_err(|error| format!("into {round}: {error}"))?;
            if self.resumes {
                self.resume(folder, &before, &operations, &after).map_err(|error| format!("into {round}: {error}"))?;
            }
            if !self.is_repeatable {
                break;
            }
            before = self.older(&before, &after);
        }
        Ok(())
    }

    fn prepared(&self, folder: &Path) -> Result<Names, Box<dyn Error>> {
        disk::write(folder, &Names::new());
        std::env::set_current_dir(folder)?;
        self.before.iter().try_for_each(|line| run(line))?;
        let mut names = disk::read(folder);
        names.retain(|name, _| !self.without.iter().any(|without| name.ends_with(without)));
        Ok(names)
    }

    /// Returns the outputs as an earlier run with different content may have left them.
    fn older(&self, before: &Names, after: &Names) -> Names {
        let mut names = after.clone();
        for (name, bytes) in &mut names {
            if let Some(bytes) = bytes
                && !before.contains_key(name)
                && self.may_age(name)
            {
                bytes.extend_from_slice(b"older");
            }
        }
        names
    }

    /// True if the command does not read an existing output of this name.
    fn may_age(&self, name: &Path) -> bool {
        name.extension().is_none_or(|end| end != "json" && end != "csv")
    }

    /// Replays each prefix of the operations as a crash.
    fn replay(&self, before: &Names, operations: &[Operation], after: &Names) -> Outcome {
        let mut disk = Disk::of(before);
        let mut seen = BTreeSet::new();
        // Some commands replace an output more than once, each time by a better one; every version is complete.
        let mut whole = [before, after].map(Clone::clone).to_vec();
        for (at, operation) in operations.iter().enumerate() {
            disk.perform(operation);
            if let Operation::Rename { to, .. } = operation
                && let Some(bytes) = disk.content(to)
            {
                whole.push(Names::from([(to.clone(), Some(bytes.to_vec()))]));
            }
            for (words, names) in disk.crashes() {
                if seen.insert(crc(&names)) {
                    check(&whole, &names).map_err(|error| {
                        format!("a crash after operation {at} ({}), {words}: {error}", shown(operation))
                    })?;
                }
            }
        }
        if !operations.iter().any(|operation| matches!(operation, Operation::Rename { .. })) {
            return Err("nothing was renamed".into());
        }
        let names = disk.names();
        let differing = |other: &Names| {
            let either = names.keys().chain(other.keys());
            either.filter(|name| names.get(*name) != other.get(*name)).cloned().collect::<BTreeSet<PathBuf>>()
        };
        let unrecorded = differing(after);
        if !unrecorded.is_empty() {
            return Err(format!("files were changed past the record: {unrecorded:?}").into());
        }
        for (words, names) in disk.crashes() {
            let lost = after.iter().find(|(name, bytes)| bytes.is_some() && names.get(*name) != Some(bytes));
            if let Some((name, _)) = lost {
                return Err(format!("{} is lost after the command has ended ({words})", name.display()).into());
            }
        }
        Ok(())
    }

    /// Resumes from a sample of the crashed states.
    fn resume(&self, folder: &Path, before: &Names, operations: &[Operation], after: &Names) -> Outcome {
        let mut disk = Disk::of(before);
        // Most operations are writes of a few bytes. Crash points are chosen among the others, such as renames and syncs, where
        // states differ.
        let telling: Vec<usize> = (0..operations.len())
            .filter(|&at| !matches!(operations[at], Operation::Write { .. } | Operation::CreateFolder { .. }))
            .collect();
        let step = telling.len().div_ceil(RESUMED * disk::LOSSES.len()).max(1);
        for (at, operation) in operations.iter().enumerate() {
            disk.perform(operation);
            let Ok(turn) = telling.binary_search(&at) else { continue };
            if turn % step != 0 {
                continue;
            }
            let crashes = disk.crashes();
            let (words, names) = &crashes[(turn / step) % crashes.len()];
            disk::write(folder, names);
            std::env::set_current_dir(folder)?;
            run(&format!("{} --resume", self.line))
                .map_err(|error| format!("after operation {at} ({}), {words}: {error}", shown(operation)))?;
            if disk::read(folder) != *after {
                return Err(format!("after operation {at}, {words}: other files than those of a whole run").into());
            }
        }
        Ok(())
    }
}

/// Checks that each file has its content in one of `whole`, whose first element is the state before the command and whose second
/// is the state after it, or is missing. Hidden files may be incomplete.
fn check(whole: &[Names], crashed: &Names) -> Result<(), String> {
    for (name, bytes) in crashed {
        let is_hidden = name.iter().any(|part| part.to_string_lossy().starts_with('.'));
        if bytes.is_some() && !is_hidden && !whole.iter().any(|names| names.get(name) == Some(bytes)) {
            return Err(format!("{} is neither the old file nor the new one", name.display()));
        }
    }
    // A file that exists before and after the command also exists in each crashed state.
    let (before, after) = (&whole[0], &whole[1]);
    match before.keys().find(|name| after.contains_key(*name) && !crashed.contains_key(*name)) {
        Some(lost) => Err(format!("{} is lost", lost.display())),
        None => Ok(()),
    }
}

/// Returns a key that identifies a state: paths, and CRC-32s of the files.
fn crc(names: &Names) -> Vec<(PathBuf, Option<u32>)> {
    names.iter().map(|(name, bytes)| (name.clone(), bytes.as_ref().map(|bytes| crc32fast::hash(bytes)))).collect()
}

fn shown(operation: &Operation) -> String {
    format!("{operation:?}").chars().take(120).collect()
}
