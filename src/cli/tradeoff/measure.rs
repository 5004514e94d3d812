//! The steps of every sweep: lock the folder, measure, write the files, print.

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::args::Args;
use super::child::Children;
use super::text;
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, output, refuse};
use crate::error::{Error, Result};
use crate::json;
use crate::report::machine;
use crate::report::tradeoff::folder::Folder;
use crate::report::tradeoff::json::Report;
use crate::report::tradeoff::kind::SweepKind;
use crate::report::tradeoff::page::{self, Extras};
use crate::report::tradeoff::runner::{Bench, shell_line};
use crate::report::tradeoff::schedule::{self, Extent, FailedPoint, Lab};
use crate::report::tradeoff::store::{Store, StoredPoint};
use crate::report::tradeoff::study::{ExampleCommand, Results, Study, all_points};

pub struct Opened {
    pub folder: Folder,
    pub store: Store,
}

impl Opened {
    pub fn new(args: &Args, kind: &'static SweepKind, store: impl FnOnce(&Path) -> Result<Store>) -> Result<Opened> {
        let folder = Folder::open(&args.output, kind)?;
        if let Some(path) = folder.in_the_way().filter(|_| !args.overwrite) {
            return refuse(format!(
                "{}: exists and would be lost; name another folder, or replace it by --overwrite",
                path.display()
            ));
        }
        let store = store(&args.output)?;
        if args.overwrite && (store.dropped > 0 || !kind.is_resumable) {
            folder.clear()?;
        } else if store.dropped > 0 {
            let count = store.dropped;
            let are = if count == 1 { "1 point is" } else { &format!("{count} points are") };
            return refuse(format!(
                "{}: {are} of other footage, options, machine or program; name another folder, or replace all of it by \
                 --overwrite",
                store.path().display()
            ));
        }
        Ok(Opened { folder, store })
    }
}

pub struct Sweeping<'a> {
    pub args: &'a Args,
    pub global: &'a GlobalArgs,
    pub start: Instant,
    pub kind: &'static SweepKind,
    pub studies: Vec<Study>,
    /// What a preset has and the input has no streams for.
    pub left_out: Vec<String>,
    /// A sentence.
    pub about: String,
    pub commands: Vec<ExampleCommand>,
}

pub struct Finished<'a> {
    args: &'a Args,
    global: &'a GlobalArgs,
    pub results: Results,
    pub failed: Vec<FailedPoint>,
}

impl<'a> Sweeping<'a> {
    /// Measures one grid, which begins anew each time; `more` has further keys of the JSON.
    pub fn measure_grid<'b>(self, more: Value, bench: impl FnOnce(&Path) -> Box<dyn Bench + 'b>) -> Result<ExitStatus> {
        let knobs = self.studies.iter().flat_map(|study| &study.axes).map(|axis| axis.knob).collect();
        let store = |folder: &Path| Ok(Store::new(self.kind, folder, knobs));
        let mut opened = Opened::new(self.args, self.kind, store)?;
        self.measure(&mut opened, bench)?.tell(&opened, &Extras::default(), more, "")?;
        Ok(ExitStatus::Passed)
    }

    /// Measures all points. `bench` is given the folder of unfinished work.
    pub fn measure<'b>(
        self,
        opened: &mut Opened,
        bench: impl FnOnce(&Path) -> Box<dyn Bench + 'b>,
    ) -> Result<Finished<'a>> {
        let Opened { folder, store } = opened;
        let extent = Extent { repeats: self.args.repeats, budget_seconds: self.args.budget_seconds };
        let work = folder.work()?;
        let progress = Progress::start(self.global, "measuring", schedule::runs(&self.studies, extent, store))?;
        let children = Children::new(&progress, self.start)?;
        let mut bench = bench(work.path());
        let lab = Lab { runner: &children, bench: bench.as_mut(), store };
        let done = schedule::measure(&self.studies, extent, lab, &progress);
        drop(progress);
        if done.is_err() && !store.rows.is_empty() {
            let next = if self.kind.is_resumable {
                "the same command goes on from there"
            } else {
                "measuring again starts over"
            };
            output::note(format_args!("{}: {} points are kept; {next}", store.path().display(), store.rows.len()));
        }
        let done = done?;
        let mut left_out = self.left_out;
        left_out.extend(done.left_out);
        left_out.extend(done.failed.iter().map(|of| format!("Point {} failed: {}", of.point, of.error)));
        let points = all_points(&done.studies);
        // Without a run there is no time to show.
        let timed = points.iter().filter(|point| store.runs(point) > 0);
        let machine = std::iter::once(machine::describe()).chain(bench.devices().iter().cloned());
        let results = Results {
            sweep: self.kind,
            input: self.args.input.clone().unwrap_or_default(),
            about: self.about,
            command_line: shell_line(&std::env::args_os().skip(1).collect::<Vec<_>>()),
            machine: machine.collect::<Vec<_>>().join("; "),
            measured: timed.filter_map(|point| Some(store.row(point)?.measured.clone())).collect(),
            studies: done.studies,
            left_out,
            weights: self.args.weights.unwrap_or_default(),
            commands: self.commands,
        };
        Ok(Finished { args: self.args, global: self.global, results, failed: done.failed })
    }
}

impl Finished<'_> {
    /// Writes pictures, page and JSON, and prints; `more` has further keys of the JSON, and `words` further text.
    pub fn tell(&self, opened: &Opened, extras: &Extras, more: Value, words: &str) -> Result<()> {
        let (Opened { folder, store }, args) = (opened, self.args);
        let rows: Vec<&StoredPoint> =
            self.results.measured.iter().filter_map(|measured| store.row(&measured.point)).collect();
        let mut files = vec![store.path().to_path_buf(), folder.report()];
        files.extend(page::write(&self.results, extras, &args.output)?);
        // Pictures of other sweeps over the same footage stay, and are listed.
        let mut names = folder.files();
        names.extend(files.iter().filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())));
        names.sort();
        names.dedup();
        let report = Report::new(&self.results, &extras.findings, &rows, &self.failed);
        let mut all = serde_json::to_value(report).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
        all["files"] = json!(names);
        if let Value::Object(more) = more {
            more.into_iter().for_each(|(key, value)| all[key] = value);
        }
        output::write_file(&folder.report(), &json::pretty(&all)?)?;
        let text = || format!("{}{words}", text::report(&self.results, &extras.findings, &files));
        output::print_either(args.json, &all, text)?;
        self.results.left_out.iter().for_each(|note| self.global.note(note));
        match self.failed.first() {
            None => Ok(()),
            Some(FailedPoint { point, error }) => Err(Error::invalid(format!(
                "{} of {} points failed, and are tried again by the same command; {point}: {error}",
                self.failed.len(),
                all_points(&self.results.studies).len()
            ))),
        }
    }
}
