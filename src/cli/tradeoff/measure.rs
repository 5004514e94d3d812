//! Steps of every sweep: lock the folder, measure, write the files, print.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Map, Value};

use super::args::Args;
use super::text;
use crate::child::{Children, shell_line};
use crate::progress::Progress;
use crate::report::machine;
use crate::report::tradeoff::folder::Folder;
use crate::report::tradeoff::json::report;
use crate::report::tradeoff::page::{self, Extras};
use crate::report::tradeoff::runner::Bench;
use crate::report::tradeoff::schedule::{self, Extent, FailedPoint, Lab};
use crate::report::tradeoff::store::{Store, StoredPoint};
use crate::report::tradeoff::study::{Results, Study, all_points};
use crate::{GlobalArgs, output, refuse};
use codec::error::{Error, Result, counted};
use footage::json;

pub struct Sweeping<'a> {
    args: &'a Args,
    global: &'a GlobalArgs,
    folder: Folder,
    pub store: Store,
    pub results: Results,
    failed: Vec<FailedPoint>,
}

impl<'a> Sweeping<'a> {
    /// Opens the folder of a sweep whose points have this configuration hash.
    pub fn open(args: &'a Args, study: &Study, made_of: u32, global: &'a GlobalArgs) -> Result<Sweeping<'a>> {
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
        let results = Results {
            sweep: kind,
            input: args.input.clone().unwrap_or_default(),
            about: kind.about.to_owned(),
            command_line: shell_line(&std::env::args_os().skip(1).collect::<Vec<_>>()),
            machine: machine::describe(),
            studies: Vec::new(),
            measured: Vec::new(),
            point_commands: Vec::new(),
            left_out: Vec::new(),
            weights: args.weights.unwrap_or_default(),
            commands: Vec::new(),
        };
        Ok(Sweeping { args, global, folder, store, results, failed: Vec::new() })
    }

    /// Measures all points. `bench` takes the folder for unfinished work. The budget counts from `start`.
    pub fn measure<B: Bench>(
        &mut self,
        studies: &[Study],
        start: Instant,
        bench: impl FnOnce(&Path) -> B,
    ) -> Result<()> {
        let Sweeping { args, global, folder, store, results, failed } = self;
        let kind = store.kind;
        let extent = Extent { repeats: args.repeats, budget_seconds: args.budget_seconds };
        let work = folder.work()?;
        let progress = Progress::start(global, "measuring", schedule::runs(studies, extent, store))?;
        let children = Children::new(&progress, start)?;
        let mut bench = bench(work.files());
        let lab = Lab { runner: &children, bench: &mut bench, store };
        let done = schedule::measure(studies, extent, lab, &progress);
        drop(progress);
        if done.is_err() && !store.rows.is_empty() {
            let next =
                if kind.is_resumable { "the same command continues from there" } else { "measuring again starts over" };
            let kept = counted(store.rows.len() as u64, "point");
            output::note(format_args!("{}: kept: {kept}; {next}", store.path().display()));
        }
        let done = done?;
        results.left_out.extend(done.left_out);
        results.left_out.extend(done.failed.iter().map(|FailedPoint { point, error, is_infeasible }| {
            let what = if *is_infeasible { "is infeasible" } else { "failed" };
            format!("Point {point} {what}: {error}")
        }));
        *failed = done.failed;
        // Points without a run have no time to report.
        let points = all_points(&done.studies).into_iter().filter(|point| store.runs(point) > 0);
        let rows: Vec<&StoredPoint> = points.filter_map(|point| store.row(&point)).collect();
        results.measured = rows.iter().map(|row| row.measured.clone()).collect();
        results.point_commands = rows.iter().map(|row| row.command.clone()).collect();
        results.studies = done.studies;
        bench.devices().iter().for_each(|device| results.machine += &format!("; {device}"));
        Ok(())
    }

    /// Writes pictures, page and JSON, and prints the report. `more` contains further JSON keys, and `words` further
    /// text.
    pub fn tell(&self, extras: &Extras, more: Map<String, Value>, words: &str) -> Result<()> {
        let Sweeping { folder, store, args, results, .. } = self;
        let rows = results.measured.iter().filter_map(|measured| store.row(&measured.point));
        let mut files: Vec<PathBuf> = vec![store.path().to_path_buf(), folder.report()];
        files.extend(page::write(results, extras, &args.output)?);
        // Pictures of other sweeps over the same footage are kept and listed.
        let mut names = folder.files();
        names.extend(files.iter().filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())));
        names.sort();
        names.dedup();
        let told = (&extras.findings[..], &self.failed[..]);
        let all = report(results, &rows.collect::<Vec<_>>(), told, &names, more)?;
        output::write_file(&folder.report(), &json::pretty(&all)?)?;
        output::print_either(args.json, &all, || {
            format!("{}{words}", text::report(results, &extras.findings, &files))
        })?;
        results.left_out.iter().for_each(|note| self.global.note(note));
        let failed: Vec<&FailedPoint> = self.failed.iter().filter(|of| !of.is_infeasible).collect();
        match failed.first() {
            None => Ok(()),
            Some(FailedPoint { point, error, .. }) => Err(Error::invalid(format!(
                "{} of {} points failed, and are measured again by the same command; {point}: {error}",
                failed.len(),
                all_points(&results.studies).len()
            ))),
        }
    }
}
