//! How a sweep of one grid goes, be it of rendering or of placing cameras: begins in a folder, keeps what it has measured,
//! and tells it as files and in words.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::Value;

use super::child::Children;
use super::folder::{Folder, PAGE};
use super::{Args, write_json};
use crate::cli::GlobalArgs;
use crate::cli::output;
use crate::cli::progress::Progress;
use crate::error::{Error, Result};
use crate::files::OutputFile;
use crate::report::Table;
use crate::report::machine;
use crate::report::tradeoff::commands::shell_line;
use crate::report::tradeoff::figures::Figure;
use crate::report::tradeoff::grid_page::GridPage;
use crate::report::tradeoff::html::How;

/// What is for coding alone.
pub fn refuse_others(args: &Args, what: &str) -> Result<()> {
    let given = [
        ("--preset", args.preset.is_some()),
        ("--recommend", args.recommend.recommend),
        ("--budget-seconds", args.budget_seconds.is_some()),
        ("--weights", args.weights.is_some()),
        ("--stream", !args.stream.is_empty()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Error::Usage(format!("{name} is for coding footage, and not for {what}"))),
        None => Ok(()),
    }
}

/// A sweep that is to begin.
pub struct Grid<'a> {
    /// What was asked for.
    pub args: &'a Args,
    /// How much is said.
    pub global: &'a GlobalArgs,
    /// When the command began.
    pub start: Instant,
    /// What is done, for the bar.
    pub what: &'static str,
    /// Commands that are run.
    pub runs: u64,
    /// Points.
    pub points: usize,
    /// The CSV and the JSON.
    pub files: [PathBuf; 2],
}

/// What has come of a sweep.
pub struct Told<'a> {
    /// Title of the page.
    pub title: String,
    /// A word for what was measured, and how the user named it.
    pub input: (&'a str, &'a str),
    /// What the figures of the table are.
    pub about: &'a str,
    /// All points.
    pub table: &'a Table,
    /// Figures.
    pub figures: &'a [Figure],
    /// Commands that anyone can repeat, and what each is for.
    pub commands: &'a [(&'static str, String)],
    /// The same as JSON.
    pub report: &'a Value,
}

/// Takes what is known so far.
type Keep<'k, T> = dyn FnMut(&[T]) -> Result<()> + 'k;

impl Grid<'_> {
    /// Names of the CSV and of the JSON.
    fn names(&self) -> [String; 2] {
        self.files.each_ref().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned())
    }

    /// Measures all points, in a folder that is locked as long as what is answered lives. What is known is in the CSV after
    /// each point, also where the sweep is stopped.
    ///
    /// # Errors
    /// Where the folder holds a sweep that is not to be replaced, and those of `measure`.
    pub fn measure<T>(
        &self,
        measure: impl FnOnce(&Children<'_>, &Path, &Progress, &mut Keep<'_, T>) -> Result<Vec<T>>,
        to_csv: impl Fn(&[T]) -> Result<String>,
    ) -> Result<(Folder, Vec<T>)> {
        let args = self.args;
        let folder = Folder::open(&args.output)?;
        let [csv_path, _] = &self.files;
        let [csv, json] = self.names();
        match args.overwrite {
            false => folder.refuse_to_replace(&[&csv, &json, PAGE], &[])?,
            // Else a sweep that is stopped would leave its points beside the pictures of another.
            true => folder.remove(&[&csv, &json, PAGE], csv.trim_end_matches(".csv"))?,
        }
        let work = folder.work()?;
        let progress = Progress::start(self.global, self.what, self.runs)?;
        let mut kept = 0;
        let mut keep = |known: &[T]| {
            kept = known.len();
            write(csv_path, &to_csv(known)?)
        };
        let measured = measure(&Children::new(&progress, self.start)?, work.path(), &progress, &mut keep);
        drop(progress);
        if measured.is_err() && kept > 0 {
            let (path, all) = (csv_path.display(), self.points);
            output::note(format_args!("{path}: {kept} of {all} points are kept; to measure again is to start over"));
        }
        Ok((folder, measured?))
    }

    /// Writes pictures, page and JSON, and prints.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn tell(&self, told: &Told<'_>, folder: Folder) -> Result<()> {
        let (machine, command_line) =
            (machine::describe(), shell_line(&std::env::args_os().skip(1).collect::<Vec<_>>()));
        let page = GridPage {
            title: &told.title,
            about: told.about,
            figures: told.figures,
            table: told.table,
            how: How { input: told.input, command_line: &command_line, machine: &machine },
            commands: told.commands,
        };
        let files = page.write(&self.args.output)?;
        write_json(told.report, &self.files[1])?;
        drop(folder);
        if self.args.json {
            return output::print_json(told.report);
        }
        let files: Vec<String> = self.files.iter().chain(&files).map(|path| path.display().to_string()).collect();
        output::print_text(&format!("{}\n{}\n\n{}\n", told.table, told.about, files.join("\n")))
    }
}

/// Writes a file in one go.
fn write(path: &Path, text: &str) -> Result<()> {
    let mut file = OutputFile::create(path)?;
    std::io::Write::write_all(&mut file, text.as_bytes()).map_err(|error| Error::io(path, error))?;
    file.commit()
}
