//! Stores points in a CSV file. If the file holds all runs, the sweep is resumed from it.
//!
//! The file is rewritten after every run, under a temporary name first, so that it is complete at any time.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::Deserialize;
use serde_json::json;

use super::kind::{Measure, Source, SweepKind};
use super::point::{Measured, Point, Value};
use crate::report::csv::of_records;
use codec::error::{Error, Result};
use codec::image::StreamKind;
use footage::files::write_whole;

const BETWEEN: &str = ";";

#[derive(Debug, Clone, PartialEq)]
pub struct StoredPoint {
    pub studies: Vec<String>,
    pub measured: Measured,
    pub command: String,
    /// Configuration hash of the input, the fixed options and the program.
    pub made_of: u32,
}

#[derive(Debug, Clone)]
pub struct Store {
    pub kind: &'static SweepKind,
    path: PathBuf,
    knobs: Vec<&'static str>,
    /// One row per point, in the order of first measurement.
    pub rows: Vec<StoredPoint>,
    /// Number of rows of the file that have another configuration hash.
    pub dropped: usize,
}

impl Store {
    /// Creates an empty store of points that differ in the given knobs.
    pub fn new(kind: &'static SweepKind, folder: &Path, knobs: Vec<&'static str>) -> Store {
        Store { kind, path: folder.join(kind.csv_name()), knobs, rows: Vec::new(), dropped: 0 }
    }

    /// Opens the file of a resumable kind, or creates an empty store. If a configuration hash is given, rows with
    /// another hash are dropped.
    pub fn open(kind: &'static SweepKind, folder: &Path, made_of: Option<u32>) -> Result<Store> {
        let mut store = Store::new(kind, folder, kind.knobs.iter().map(|knob| knob.name).collect());
        let path = store.path.clone();
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(store),
            Err(error) => return Err(Error::io(&path, error)),
        };
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let foreign =
            |what: String| Error::invalid(format!("{what}: use another folder, or remove the file")).in_file(&path);
        let heads = reader.headers().map_err(|error| foreign(format!("not a CSV file of tradeoff: {error}")))?.clone();
        if let Some(missing) = store.columns().iter().find(|column| heads.iter().all(|head| head != **column)) {
            return Err(foreign(format!("not a CSV file of this kind of tradeoff: it has no column {missing}")));
        }
        for (at, cells) in reader.deserialize::<Cells>().enumerate() {
            let wrong = |error: &dyn std::fmt::Display| foreign(format!("row {}: {error}", at + 2));
            let cells = cells.map_err(|error| wrong(&error))?;
            let hash = u32::from_str_radix(cells.text("made_of"), 16).ok();
            if made_of.is_some() && hash != made_of {
                store.dropped += 1;
                continue;
            }
            let row = cells.row(kind).map_err(|error| wrong(&error))?;
            if store.row(&row.measured.point).is_some() {
                return Err(wrong(&format!("{} is in another row, too", row.measured.point)));
            }
            store.rows.push(row);
        }
        Ok(store)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn row(&self, point: &Point) -> Option<&StoredPoint> {
        self.rows.iter().find(|row| row.measured.point == *point)
    }

    pub fn row_mut(&mut self, point: &Point) -> Option<&mut StoredPoint> {
        self.rows.iter_mut().find(|row| row.measured.point == *point)
    }

    pub fn runs(&self, point: &Point) -> usize {
        self.row(point).map_or(0, |row| row.measured.timed_runs())
    }

    pub fn save(&self) -> Result<()> {
        write_whole(&self.path, self.text()?.as_bytes())
    }

    fn columns(&self) -> Vec<String> {
        let before = if self.kind.is_resumable { "" } else { "settings_" };
        let knobs = self.knobs.iter().map(|name| format!("{before}{name}"));
        let measures = self.measures().map(|measure| measure.name.to_owned());
        self.record(["studies", "kind"], knobs.chain(measures), ["command", "made_of"])
    }

    pub fn text(&self) -> Result<String> {
        let row = |row: &StoredPoint| {
            let point = &row.measured.point;
            let knobs = self.knobs.iter().map(|name| point.value(name).unwrap_or_default().to_owned());
            let values = self.measures().map(|measure| self.cell(row.measured.value(measure.name)));
            let (studies, hash) = (row.studies.join(BETWEEN), format!("{:08x}", row.made_of));
            let stream = point.stream.map_or("", StreamKind::name);
            self.record([&studies, stream], knobs.chain(values), [&row.command, &hash])
        };
        of_records(std::iter::once(self.columns()).chain(self.rows.iter().map(row)))
    }

    /// Returns a record. Files of kinds that are not resumable have only the columns of knobs and measures.
    fn record(&self, first: [&str; 2], own: impl Iterator<Item = String>, last: [&str; 2]) -> Vec<String> {
        match self.kind.is_resumable {
            true => first.map(str::to_owned).into_iter().chain(own).chain(last.map(str::to_owned)).collect(),
            false => own.collect(),
        }
    }

    fn measures(&self) -> impl Iterator<Item = &'static Measure> {
        let with_runs = self.kind.is_resumable;
        self.kind.measures.iter().filter(move |measure| with_runs || measure.source != Source::Runs)
    }

    fn cell(&self, value: Option<Value>) -> String {
        match value {
            None => String::new(),
            Some(Value::Count(count)) => count.to_string(),
            // Files that are never read back format numbers as JSON does.
            Some(Value::Number(number)) if number.is_finite() && !self.kind.is_resumable => json!(number).to_string(),
            Some(Value::Number(number)) => number.to_string(),
            Some(Value::Runs(runs)) => runs.iter().map(f64::to_string).collect::<Vec<_>>().join(BETWEEN),
        }
    }
}

/// Cells of a row by their headings.
#[derive(Deserialize)]
struct Cells(BTreeMap<String, String>);

impl Cells {
    fn text(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    fn parts(&self, name: &str) -> impl Iterator<Item = &str> {
        self.text(name).split(BETWEEN).filter(|part| !part.is_empty())
    }

    /// Parses a number that must satisfy `fits`. `None` if it is missing and not needed.
    fn parse<T: FromStr + Copy>(
        &self,
        name: &str,
        is_needed: bool,
        fits: impl Fn(T) -> bool,
    ) -> Result<Option<T>, String> {
        let text = self.text(name);
        match text.parse() {
            Ok(value) if fits(value) => Ok(Some(value)),
            Ok(_) => Err(format!("{name} is '{text}', which is not a valid measurement")),
            Err(_) if text.is_empty() && !is_needed => Ok(None),
            Err(_) if text.is_empty() => Err(format!("it has no {name}")),
            Err(_) => Err(format!("{name} is '{text}', where a number was expected")),
        }
    }

    fn value(&self, measure: &Measure) -> Result<Option<Value>, String> {
        let (name, is_needed) = (measure.name, !measure.optional);
        Ok(match measure.source {
            Source::Count => self.parse(name, is_needed, |count| count >= measure.least)?.map(Value::Count),
            Source::Number | Source::Decibels => {
                let is_decibels = measure.source == Source::Decibels;
                let fits = |number: f64| number >= 0.0 && (number.is_finite() || is_decibels);
                self.parse(name, is_needed, fits)?.map(Value::Number)
            }
            Source::Signed => {
                self.parse(name, false, |_| true)?.filter(|number: &f64| number.is_finite()).map(Value::Number)
            }
            Source::Runs => {
                let runs: Result<Vec<f64>, _> = self.parts(name).map(str::parse).collect();
                let runs = runs.ok().filter(|runs| runs.iter().all(|of| of.is_finite() && *of >= 0.0));
                let text = self.text(name);
                let wrong = || format!("{name} is '{text}', where seconds separated by {BETWEEN} were expected");
                Some(runs.ok_or_else(wrong)?).filter(|runs| !runs.is_empty()).map(Value::Runs)
            }
            Source::Median | Source::Shortest | Source::Longest | Source::Formula => None,
        })
    }

    fn row(&self, kind: &'static SweepKind) -> Result<StoredPoint, String> {
        let stream = self.text("kind");
        let stream = StreamKind::from_name(stream).ok_or_else(|| format!("'{stream}' is not a kind of stream"))?;
        let settings = kind.knobs.iter().map(|knob| (knob.name, self.text(knob.name).to_owned()));
        let settings = settings.filter(|(_, value)| !value.is_empty()).collect();
        let mut measured = Measured::new(kind, Point::new(kind, Some(stream), settings));
        for measure in &kind.measures {
            measured.set(measure.name, self.value(measure)?);
        }
        let hash = self.text("made_of");
        Ok(StoredPoint {
            studies: self.parts("studies").map(str::to_owned).collect(),
            measured,
            command: self.text("command").to_owned(),
            made_of: u32::from_str_radix(hash, 16)
                .map_err(|_| format!("made_of is '{hash}', which is not a configuration hash"))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::kind::CODING;

    fn row(stream: StreamKind, runs: &[f64]) -> StoredPoint {
        let settings = vec![("psnr", "40".to_owned()), ("threads", "1".to_owned())];
        let mut measured = Measured::new(&CODING, Point::new(&CODING, Some(stream), settings));
        for (name, count) in [
            ("bytes_raw", 1000),
            ("bytes_temporal", 90),
            ("bytes_spatial", 80),
            ("bytes_container", 80),
            ("bytes_lzma2", 70),
            ("frames", 6),
            ("images", 36),
            ("pixels", 1 << 40),
            ("updated_pixels", 12_345),
            ("decode_passes", 17),
            ("encode_peak_bytes", 1 << 30),
        ] {
            measured.set(name, Value::Count(count));
        }
        for (name, number) in [("psnr_db", f64::INFINITY), ("min_psnr_db", 40.125), ("ssim", 0.987_654_321_012_345_6)] {
            measured.set(name, Value::Number(number));
        }
        for run in runs {
            measured.push_run("encode_runs", *run);
            measured.push_run("decode_runs", run / 3.0);
        }
        StoredPoint {
            studies: vec!["cells".to_owned(), "color".to_owned()],
            measured,
            command: "lightfold encode 'a, \"b\"' --stream=color -o point.lfold".to_owned(),
            made_of: 0x00ab_cdef,
        }
    }

    #[test]
    fn figures_that_nothing_measured_has_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&CODING, folder.path(), None).unwrap();
        store.rows = vec![row(StreamKind::Color, &[0.5, 0.25])];
        let text = store.text().unwrap();
        let said = |text: &str| {
            std::fs::write(&store.path, text).unwrap();
            let opened = Store::open(&CODING, folder.path(), None);
            opened.map(|store| store.rows.len()).map_err(|error| error.to_string())
        };
        assert_eq!(said(&text), Ok(1));
        let twice = format!("{text}{}\n", text.lines().nth(1).unwrap());
        for (wrong, word) in [
            (text.replace("0.5;0.25", "0.5;-0.25"), "encode_runs"),
            (text.replace("0.5;0.25", "NaN"), "encode_runs"),
            (text.replace(",inf,40.125,", ",NaN,40.125,"), "psnr_db"),
            (text.replace(",inf,40.125,", ",inf,-1,"), "min_psnr_db"),
            (text.replace(",1000,90,80,80,70,", ",0,90,80,80,70,"), "bytes_raw"),
            (text.replacen(",psnr,", ",psrn,", 1), "psnr"),
            (twice, "another row"),
        ] {
            assert_ne!(wrong, text, "{word}");
            let error = said(&wrong).unwrap_err();
            assert!(error.contains(word), "{word}: {error}");
        }
    }

    #[test]
    fn rows_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let open = |made_of| Store::open(&CODING, folder.path(), made_of).unwrap();
        let mut store = open(Some(0x00ab_cdef));
        store.rows = vec![row(StreamKind::Color, &[0.1, 0.2 + 0.1]), row(StreamKind::Depth, &[])];
        store.save().unwrap();
        let again = open(Some(0x00ab_cdef));
        assert_eq!((&again.rows, again.dropped), (&store.rows, 0));
        assert_eq!(again.runs(&store.rows[0].measured.point), 2);
        assert_eq!(again.text().unwrap(), store.text().unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        store.rows[1].made_of = 7;
        store.save().unwrap();
        let seven = open(Some(7));
        assert_eq!((seven.rows.len(), seven.dropped), (1, 1));
        assert_eq!(seven.rows[0].measured.point.stream, Some(StreamKind::Depth));
        assert_eq!(open(None).rows.len(), 2);
    }

    #[test]
    fn a_file_of_something_else_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(&CODING, folder.path(), None).unwrap();
        let heads = store.columns();
        let line = |of: &[(&str, &str)]| {
            let cell = |head: &String| of.iter().find(|(name, _)| name == head).map_or("", |(_, cell)| *cell);
            format!("{}\n{}\n", heads.join(","), heads.iter().map(cell).collect::<Vec<_>>().join(","))
        };
        for (text, said) in [
            ("a,b\n1,2\n".to_owned(), "no column studies"),
            (line(&[("kind", "sound"), ("made_of", "1")]), "row 2: 'sound' is not a kind of stream"),
            (line(&[("kind", "depth"), ("made_of", "1")]), "row 2: it has no bytes_raw"),
            (line(&[("kind", "depth"), ("bytes_raw", "many")]), "bytes_raw is 'many'"),
            (format!("{}depth,1,2\n", line(&[])), "row 2"),
        ] {
            std::fs::write(store.path(), text).unwrap();
            let error = Store::open(&CODING, folder.path(), None).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
            assert!(error.contains("remove the file"), "{error}");
        }
    }
}
