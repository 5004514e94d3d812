//! Points in a CSV file. A sweep whose file holds all runs is resumed from it.
//!
//! The file is written anew after every run, under another name first, so that it is whole at any time.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde_json::json;

use super::kind::{Measure, Measured, Point, Source, SweepKind, Value};
use crate::error::{Error, Result};
use crate::files::write_whole;
use crate::image::StreamKind;

/// Separator of several values in one cell.
const BETWEEN: &str = ";";

/// A row of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredPoint {
    /// Names of the studies that the point belongs to.
    pub studies: Vec<String>,
    /// Its values; as many runs as are finished.
    pub measured: Measured,
    pub command: String,
    /// Configuration hash of the input, the fixed options and the program.
    pub made_of: u32,
}

/// The file and its rows.
#[derive(Debug, Clone)]
pub struct Store {
    kind: &'static SweepKind,
    path: PathBuf,
    knobs: Vec<&'static str>,
    /// One for each point, in the order in which they were first measured.
    pub rows: Vec<StoredPoint>,
    /// Rows of the file that have another configuration hash.
    pub dropped: usize,
}

impl Store {
    /// An empty file of points that differ in these knobs.
    pub fn new(kind: &'static SweepKind, folder: &Path, knobs: Vec<&'static str>) -> Store {
        Store { kind, path: folder.join(kind.csv_name()), knobs, rows: Vec::new(), dropped: 0 }
    }

    /// Opens the file of a resumable kind, or starts one. With a configuration hash, rows of another one are dropped.
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
            |what: String| Error::invalid(format!("{what}; name another folder, or remove the file")).in_file(&path);
        let heads = reader.headers().map_err(|error| foreign(format!("no CSV of tradeoff: {error}")))?.clone();
        if let Some(missing) = store.columns().iter().find(|column| heads.iter().all(|head| head != **column)) {
            return Err(foreign(format!("no CSV of this tradeoff: it has no column {missing}")));
        }
        for (at, record) in reader.records().enumerate() {
            let line = at + 2;
            let record = record.map_err(|error| foreign(format!("row {line}: {error}")))?;
            let cells = Cells(heads.iter().zip(record.iter()).collect());
            let hash = u32::from_str_radix(cells.text("made_of"), 16).ok();
            if made_of.is_some() && hash != made_of {
                store.dropped += 1;
                continue;
            }
            let row = cells.row(kind).map_err(|error| foreign(format!("row {line}: {error}")))?;
            if store.row(&row.measured.point).is_some() {
                return Err(foreign(format!("row {line}: {} is in another row, too", row.measured.point)));
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

    /// Timed runs of a point that are complete.
    pub fn runs(&self, point: &Point) -> usize {
        self.row(point).map_or(0, |row| row.measured.timed_runs())
    }

    /// Replaces the file.
    pub fn save(&self) -> Result<()> {
        let text = self.text()?;
        write_whole(&self.path, |partial| std::fs::write(partial, text).map_err(|error| Error::io(partial, error)))
    }

    fn columns(&self) -> Vec<String> {
        let measures = self.measures().map(|measure| measure.name.to_owned());
        if self.kind.is_resumable {
            let knobs = self.knobs.iter().map(|name| self.kind.key(name).to_owned());
            let [first, last] = [["studies", "kind"], ["command", "made_of"]].map(|names| names.map(str::to_owned));
            first.into_iter().chain(knobs).chain(measures).chain(last).collect()
        } else {
            self.knobs.iter().map(|name| format!("settings_{}", self.kind.key(name))).chain(measures).collect()
        }
    }

    fn measures(&self) -> impl Iterator<Item = &'static Measure> {
        let with_runs = self.kind.is_resumable;
        self.kind.measures.iter().filter(move |measure| with_runs || !matches!(measure.source, Source::Runs))
    }

    /// The file's text.
    pub fn text(&self) -> Result<String> {
        let broken = |error: csv::Error| Error::invalid(format!("CSV: {error}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns()).map_err(broken)?;
        for row in &self.rows {
            let point = &row.measured.point;
            let knobs = self.knobs.iter().map(|name| point.value(name).unwrap_or_default().to_owned());
            let values = self.measures().map(|measure| self.cell(row.measured.value(measure.name)));
            let cells: Vec<String> = if self.kind.is_resumable {
                let first = [row.studies.join(BETWEEN), point.stream.map_or("", StreamKind::name).to_owned()];
                let last = [row.command.clone(), format!("{:08x}", row.made_of)];
                first.into_iter().chain(knobs).chain(values).chain(last).collect()
            } else {
                knobs.chain(values).collect()
            };
            writer.write_record(&cells).map_err(broken)?;
        }
        let bytes = writer.into_inner().map_err(|error| Error::invalid(format!("CSV: {}", error.error())))?;
        String::from_utf8(bytes).map_err(|error| Error::invalid(format!("CSV: {error}")))
    }

    fn cell(&self, value: Option<Value>) -> String {
        match value {
            None => String::new(),
            Some(Value::Count(count)) => count.to_string(),
            // Files that are only written have numbers as JSON has them.
            Some(Value::Number(number)) if number.is_finite() && !self.kind.is_resumable => json!(number).to_string(),
            Some(Value::Number(number)) => number.to_string(),
            Some(Value::Runs(runs)) => runs.iter().map(f64::to_string).collect::<Vec<_>>().join(BETWEEN),
        }
    }
}

/// The cells of a row by the names of their columns.
struct Cells<'a>(BTreeMap<&'a str, &'a str>);

impl Cells<'_> {
    fn text(&self, name: &str) -> &str {
        self.0.get(name).copied().unwrap_or_default()
    }

    fn parse<T: FromStr>(&self, name: &str, is_needed: bool) -> Result<Option<T>, String> {
        let text = self.text(name);
        match text.parse() {
            Ok(value) => Ok(Some(value)),
            Err(_) if text.is_empty() && !is_needed => Ok(None),
            Err(_) if text.is_empty() => Err(format!("it has no {name}")),
            Err(_) => Err(format!("{name} is '{text}', where a number was expected")),
        }
    }

    fn count(&self, name: &str, least: Option<u64>) -> Result<Option<Value>, String> {
        let count: Option<u64> = self.parse(name, least.is_some())?;
        match count {
            Some(0) if least > Some(0) => Err(format!("{name} is 0, which no measurement gives")),
            count => Ok(count.map(Value::Count)),
        }
    }

    fn number(&self, name: &str, is_needed: bool, may_be_infinite: bool) -> Result<Option<Value>, String> {
        let found: Option<f64> = self.parse(name, is_needed)?;
        match found {
            Some(number) if number < 0.0 || number.is_nan() || (number.is_infinite() && !may_be_infinite) => {
                Err(format!("{name} is '{}', which no measurement gives", self.text(name)))
            }
            found => Ok(found.map(Value::Number)),
        }
    }

    fn runs(&self, name: &str) -> Result<Option<Value>, String> {
        let wrong = || format!("{name} is '{}', where seconds separated by {BETWEEN} were expected", self.text(name));
        let runs = self.text(name).split(BETWEEN).filter(|run| !run.is_empty());
        let runs: Vec<f64> = runs.map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
        if runs.iter().any(|seconds| !seconds.is_finite() || *seconds < 0.0) {
            return Err(wrong());
        }
        Ok((!runs.is_empty()).then_some(Value::Runs(runs)))
    }

    fn row(&self, kind: &'static SweepKind) -> Result<StoredPoint, String> {
        let stream = self.text("kind");
        let stream = StreamKind::from_name(stream).ok_or_else(|| format!("'{stream}' is no kind of stream"))?;
        let settings = kind.knobs.iter().map(|knob| (knob.name, self.text(knob.key()).to_owned()));
        let settings = settings.filter(|(_, value)| !value.is_empty()).collect();
        let mut measured = Measured::new(kind, Point::new(kind, Some(stream), settings));
        for measure in kind.measures {
            let value = match measure.source {
                Source::Count(least) => self.count(measure.name, least)?,
                Source::Number { is_needed, may_be_infinite } => {
                    self.number(measure.name, is_needed, may_be_infinite)?
                }
                Source::Signed => {
                    let number: Option<f64> = self.parse(measure.name, false)?;
                    number.filter(|number| number.is_finite()).map(Value::Number)
                }
                Source::Runs => self.runs(measure.name)?,
                Source::Derived(_) => None,
            };
            if let Some(value) = value {
                measured.set(measure.name, value);
            }
        }
        let hash = self.text("made_of");
        Ok(StoredPoint {
            studies: self.text("studies").split(BETWEEN).filter(|name| !name.is_empty()).map(str::to_owned).collect(),
            measured,
            command: self.text("command").to_owned(),
            made_of: u32::from_str_radix(hash, 16)
                .map_err(|_| format!("made_of is '{hash}', no configuration hash"))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::coding::CODING;

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
            (line(&[("kind", "sound"), ("made_of", "1")]), "row 2: 'sound' is no kind of stream"),
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
