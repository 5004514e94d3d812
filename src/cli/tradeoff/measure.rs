//! Steps of every sweep: lock the folder, measure, write the files, print.

use std::path::Path;
use std::time::Instant;

use serde_json::Value;

use super::args::Args;
use super::child::Children;
use super::fixed::parse;
use super::text;
use crate::progress::Progress;
use crate::report::machine;
use crate::report::tradeoff::folder::Folder;
use crate::report::tradeoff::json::{self as points, Report};
use crate::report::tradeoff::page::{self, Extras};
use crate::report::tradeoff::runner::{Bench, CommandBench, Commands, shell_line};
use crate::report::tradeoff::schedule::{self, Extent, FailedPoint, Lab};
use crate::report::tradeoff::store::Store;
use crate::report::tradeoff::study::{ExampleCommand, Results, Study, all_points};
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::error::{Error, Result, counted};
use footage::json;

pub struct Opened {
    pub folder: Folder,
    pub store: Store,
}

impl Opened {
    /// Opens the folder of a sweep whose points have this configuration hash.
    pub fn new(args: &Args, study: &Study, made_of: u32) -> Result<Opened> {
        let kind = study.sweep;
        let folder = Folder::open(&args.output, kind)?;
        if let Some(path) = folder.in_the_way().filter(|_| !args.overwrite) {
            return refuse(format!(
                "{}: the file exists and would be replaced: use another folder, or --overwrite",
                path.display()
            ));
        }
        let store = match kind.is_resumable {
            true => Store::open(kind, &args.output, Some(made_of))?,
            false => Store::new(kind, &args.output, study.axes.iter().map(|axis| axis.knob).collect()),
        };
        if args.overwrite && (store.dropped > 0 || !kind.is_resumable) {
            folder.clear()?;
        } else if store.dropped > 0 {
            let are = if store.dropped == 1 { "is" } else { "are" };
            let points = counted(store.dropped as u64, "point");
            return refuse(format!(
                "{}: {points} {are} of other footage, options, machine or version of lightfold: use another folder, \
                or replace all results with --overwrite",
                store.path().display()
            ));
        }
        Ok(Opened { folder, store })
    }
}

/// Measures a study whose points are one command each. Earlier results are not reused.
pub fn measure_grid<B: CommandBench>(args: &Args, study: Study, bench: B, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    let (points, here) = (study.points(), Path::new("."));
    let lines = bench.preparation(here).map(|(_, line)| line).into_iter();
    lines.chain(points.iter().map(|point| bench.line(point, here))).try_for_each(|line| parse(&line).map(drop))?;
    let mut opened = Opened::new(args, &study, 0)?;
    let (about, commands, more) = (bench.about(), bench.examples(&points), bench.input());
    let sweeping = Sweeping { args, global, start, studies: vec![study], left_out: Vec::new(), about, commands };
    let finished = sweeping.measure(&mut opened, |work| Commands { bench, work: work.to_path_buf() })?;
    let extras = Extras { findings: B::findings(&finished.results), figures: Vec::new() };
    finished.tell(&opened, &extras, more, "")?;
    Ok(ExitStatus::Passed)
}

pub struct Sweeping<'a> {
    pub args: &'a Args,
    pub global: &'a GlobalArgs,
    pub start: Instant,
    pub studies: Vec<Study>,
    /// One sentence for each study of the preset whose stream the input lacks.
    pub left_out: Vec<String>,
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
    /// Measures all points. `bench` takes the folder for unfinished work.
    pub fn measure<B: Bench>(self, opened: &mut Opened, bench: impl FnOnce(&Path) -> B) -> Result<Finished<'a>> {
        let Opened { folder, store } = opened;
        let kind = store.kind;
        let extent = Extent { repeats: self.args.repeats, budget_seconds: self.args.budget_seconds };
        let work = folder.work()?;
        let progress = Progress::start(self.global, "measuring", schedule::runs(&self.studies, extent, store))?;
        let children = Children::new(&progress, self.start)?;
        let mut bench = bench(work.files());
        let lab = Lab { runner: &children, bench: &mut bench, store };
        let done = schedule::measure(&self.studies, extent, lab, &progress);
        drop(progress);
        if done.is_err() && !store.rows.is_empty() {
            let next =
                if kind.is_resumable { "the same command continues from there" } else { "measuring again starts over" };
            let kept = counted(store.rows.len() as u64, "point");
            output::note(format_args!("{}: kept: {kept}; {next}", store.path().display()));
        }
        let done = done?;
        let mut left_out = self.left_out;
        left_out.extend(done.left_out);
        left_out.extend(done.failed.iter().map(|FailedPoint { point, error, is_infeasible }| match is_infeasible {
            true => format!("Point {point} is infeasible: {error}"),
            false => format!("Point {point} failed: {error}"),
        }));
        let points = all_points(&done.studies);
        // Points without a run have no time to report.
        let timed = points.iter().filter(|point| store.runs(point) > 0);
        let machine = std::iter::once(machine::describe()).chain(bench.devices().iter().cloned());
        let results = Results {
            sweep: kind,
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
    /// Writes pictures, page and JSON, and prints the report. `more` contains further JSON keys, and `words` further
    /// text.
    pub fn tell(&self, opened: &Opened, extras: &Extras, more: Value, words: &str) -> Result<()> {
        let (Opened { folder, store }, args) = (opened, self.args);
        let rows = self.results.measured.iter().filter_map(|measured| store.row(&measured.point));
        let mut files = vec![store.path().to_path_buf(), folder.report()];
        files.extend(page::write(&self.results, extras, &args.output)?);
        // Pictures of other sweeps over the same footage are kept and listed.
        let mut names = folder.files();
        names.extend(files.iter().filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())));
        names.sort();
        names.dedup();
        let report = Report {
            results: &self.results,
            version: env!("CARGO_PKG_VERSION"),
            points: rows.map(points::point).collect(),
            findings: &extras.findings,
            failed: &self.failed,
        };
        let mut all = serde_json::to_value(report).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
        all["files"] = names.into();
        if let Value::Object(more) = more {
            more.into_iter().for_each(|(key, value)| all[key] = value);
        }
        output::write_file(&folder.report(), &json::pretty(&all)?)?;
        let text = || format!("{}{words}", text::report(&self.results, &extras.findings, &files));
        output::print_either(args.json, &all, text)?;
        self.results.left_out.iter().for_each(|note| self.global.note(note));
        let failed: Vec<&FailedPoint> = self.failed.iter().filter(|of| !of.is_infeasible).collect();
        match failed.first() {
            None => Ok(()),
            Some(FailedPoint { point, error, .. }) => Err(Error::invalid(format!(
                "{} of {} points failed, and are measured again by the same command; {point}: {error}",
                failed.len(),
                all_points(&self.results.studies).len()
            ))),
        }
    }
}
