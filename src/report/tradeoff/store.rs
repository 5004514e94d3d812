//! Finished runs in a CSV file, from which an interrupted sweep goes on.
//!
//! The file is written anew after every run, under another name first, so that it is whole at any time.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::knob::KNOBS;
use super::point::{Measured, Point, Quality, Sizes, Timing};
use crate::dataset::stream::StreamKind;
use crate::error::{Error, Result};
use crate::files::write_whole;

/// Name of the file below the folder of a report.
pub const FILE_NAME: &str = "tradeoff.csv";

/// What stands between words of one cell.
const BETWEEN: &str = ";";

/// What is known of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Names of the studies that it belongs to.
    pub studies: Vec<String>,
    /// All that was measured; as many runs as are finished.
    pub measured: Measured,
    /// The command that encodes it.
    pub command: String,
    /// Mark of the input and the options that are no knobs.
    pub made_of: u32,
}

/// The file and its rows.
#[derive(Debug, Clone)]
pub struct Store {
    path: PathBuf,
    /// One for each point, in the order in which they were first measured.
    pub rows: Vec<Row>,
    /// Rows that were found and are of another input, other options or another program.
    pub dropped: usize,
}

impl Store {
    /// Opens the file in a folder, or starts one. With a mark, rows of another mark are dropped.
    pub fn open(folder: &Path, made_of: Option<u32>) -> Result<Store> {
        let path = folder.join(FILE_NAME);
        let mut store = Store { path: path.clone(), rows: Vec::new(), dropped: 0 };
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(store),
            Err(error) => return Err(Error::io(&path, error)),
        };
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let foreign =
            |what: String| Error::invalid(format!("{what}; name another folder, or remove the file")).in_file(&path);
        let heads = reader.headers().map_err(|error| foreign(format!("no CSV of tradeoff: {error}")))?.clone();
        if let Some(missing) = columns().find(|column| heads.iter().all(|head| head != *column)) {
            return Err(foreign(format!("no CSV of this tradeoff: it has no column {missing}")));
        }
        let mut seen = BTreeSet::new();
        for (at, record) in reader.records().enumerate() {
            let line = at + 2;
            let record = record.map_err(|error| foreign(format!("row {line}: {error}")))?;
            let cells = Cells(heads.iter().zip(record.iter()).collect());
            let mark = u32::from_str_radix(cells.text("made_of"), 16).ok();
            if made_of.is_some() && mark != made_of {
                store.dropped += 1;
                continue;
            }
            let row = cells.row().map_err(|error| foreign(format!("row {line}: {error}")))?;
            if !seen.insert(row.measured.point.clone()) {
                return Err(foreign(format!("row {line}: {} stands in another row, too", row.measured.point)));
            }
            store.rows.push(row);
        }
        Ok(store)
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The row of a point.
    pub fn row(&self, point: &Point) -> Option<&Row> {
        self.rows.iter().find(|row| row.measured.point == *point)
    }

    /// The row of a point, to be changed.
    pub fn row_mut(&mut self, point: &Point) -> Option<&mut Row> {
        self.rows.iter_mut().find(|row| row.measured.point == *point)
    }

    /// Timed runs of a point that are finished.
    pub fn runs(&self, point: &Point) -> usize {
        self.row(point).map_or(0, |row| row.measured.encode.runs.len().min(row.measured.decode.runs.len()))
    }

    /// Writes the file. It is replaced as a whole.
    pub fn save(&self) -> Result<()> {
        let text = self.text()?;
        write_whole(&self.path, |partial| std::fs::write(partial, text).map_err(|error| Error::io(partial, error)))
    }

    /// The file's text.
    pub fn text(&self) -> Result<String> {
        let broken = |error: csv::Error| Error::invalid(format!("CSV: {error}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(columns()).map_err(broken)?;
        for row in &self.rows {
            let point = &row.measured.point;
            let mut cells = vec![row.studies.join(BETWEEN), point.kind.name().to_owned()];
            cells.extend(KNOBS.iter().map(|knob| point.value(knob.name).unwrap_or_default().to_owned()));
            cells.extend(FIGURES.iter().map(|name| figure(&row.measured, name).text()));
            cells.extend([row.command.clone(), format!("{:08x}", row.made_of)]);
            writer.write_record(&cells).map_err(broken)?;
        }
        let bytes = writer.into_inner().map_err(|error| Error::invalid(format!("CSV: {}", error.error())))?;
        String::from_utf8(bytes).map_err(|error| Error::invalid(format!("CSV: {error}")))
    }
}

/// Names of all columns, in their order.
fn columns() -> impl Iterator<Item = &'static str> {
    let knobs = KNOBS.iter().map(|knob| knob.name);
    ["studies", "kind"].into_iter().chain(knobs).chain(FIGURES.iter().copied()).chain(["command", "made_of"])
}

/// Figures of a point, by the names that CSV and JSON have for them.
pub const FIGURES: &[&str] = &[
    "bytes_raw",
    "bytes_temporal",
    "bytes_spatial",
    "bytes_container",
    "bytes_lzma2",
    "ratio_percent",
    "ratio_lzma2_percent",
    "encode_seconds",
    "encode_seconds_min",
    "encode_seconds_max",
    "encode_runs",
    "decode_seconds",
    "decode_seconds_min",
    "decode_seconds_max",
    "decode_runs",
    "decode_passes",
    "decode_ms_per_frame",
    "megapixels_per_second",
    "changed_percent",
    "frames",
    "images",
    "pixels",
    "updated_pixels",
    "psnr_db",
    "min_psnr_db",
    "ssim",
    "max_error_codes",
    "max_error_m",
    "encode_peak_bytes",
    "decode_peak_bytes",
];

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub enum Figure {
    /// Not known, or of another kind of stream.
    None,
    /// A count.
    Count(u64),
    /// A number, perhaps infinite.
    Number(f64),
    /// Seconds of runs.
    Runs(Vec<f64>),
}

impl Figure {
    /// As a cell of a CSV file.
    pub fn text(&self) -> String {
        match self {
            Figure::None => String::new(),
            Figure::Count(count) => count.to_string(),
            Figure::Number(number) => number.to_string(),
            Figure::Runs(runs) => runs.iter().map(f64::to_string).collect::<Vec<_>>().join(BETWEEN),
        }
    }
}

/// A figure of a point by its name in [`FIGURES`].
pub fn figure(measured: &Measured, name: &str) -> Figure {
    let Measured { sizes, quality, .. } = measured;
    let count = |count: Option<u64>| count.map_or(Figure::None, Figure::Count);
    let number = |number: Option<f64>| number.map_or(Figure::None, Figure::Number);
    let least = |timing: &Timing| number(timing.spread().map(|(least, _)| least));
    let most = |timing: &Timing| number(timing.spread().map(|(_, most)| most));
    match name {
        "bytes_raw" => Figure::Count(sizes.raw),
        "bytes_temporal" => Figure::Count(sizes.temporal),
        "bytes_spatial" => count(sizes.spatial),
        "bytes_container" => Figure::Count(sizes.container),
        "bytes_lzma2" => Figure::Count(sizes.lzma2),
        "ratio_percent" => Figure::Number(measured.ratio_percent()),
        "ratio_lzma2_percent" => Figure::Number(100.0 * sizes.lzma2 as f64 / sizes.raw.max(1) as f64),
        "encode_seconds" => number(measured.encode.median()),
        "encode_seconds_min" => least(&measured.encode),
        "encode_seconds_max" => most(&measured.encode),
        "encode_runs" => Figure::Runs(measured.encode.runs.clone()),
        "decode_seconds" => number(measured.decode.median()),
        "decode_seconds_min" => least(&measured.decode),
        "decode_seconds_max" => most(&measured.decode),
        "decode_runs" => Figure::Runs(measured.decode.runs.clone()),
        "decode_passes" => Figure::Count(measured.decode_passes.into()),
        "decode_ms_per_frame" => number(measured.decode_ms_per_frame()),
        "megapixels_per_second" => number(measured.megapixels_per_second()),
        "changed_percent" => Figure::Number(measured.changed_percent()),
        "frames" => Figure::Count(measured.frames),
        "images" => Figure::Count(measured.images),
        "pixels" => Figure::Count(measured.pixels),
        "updated_pixels" => Figure::Count(measured.updated_pixels),
        "psnr_db" => Figure::Number(quality.psnr_db),
        "min_psnr_db" => number(quality.min_psnr_db),
        "ssim" => number(quality.ssim),
        "max_error_codes" => count(quality.max_error_codes.map(u64::from)),
        "max_error_m" => number(quality.max_error_m),
        "encode_peak_bytes" => count(measured.encode_peak_bytes),
        "decode_peak_bytes" => count(measured.decode_peak_bytes),
        _ => Figure::None,
    }
}

/// The cells of a row by the names of their columns.
struct Cells<'a>(BTreeMap<&'a str, &'a str>);

impl Cells<'_> {
    fn text(&self, name: &str) -> &str {
        self.0.get(name).copied().unwrap_or_default()
    }

    fn optional<T: std::str::FromStr>(&self, name: &str) -> Result<Option<T>, String> {
        let text = self.text(name);
        let wrong = |_| format!("{name} is '{text}', where a number was expected");
        if text.is_empty() { Ok(None) } else { text.parse().map(Some).map_err(wrong) }
    }

    fn needed<T: std::str::FromStr>(&self, name: &str) -> Result<T, String> {
        self.optional(name)?.ok_or_else(|| format!("it has no {name}"))
    }

    /// A number from 0 on, or infinite where that means that nothing differs.
    fn measured(&self, name: &str, infinite: bool) -> Result<Option<f64>, String> {
        let found: Option<f64> = self.optional(name)?;
        match found {
            Some(number) if number < 0.0 || number.is_nan() || (number.is_infinite() && !infinite) => {
                Err(format!("{name} is '{}', which nothing measured has", self.text(name)))
            }
            found => Ok(found),
        }
    }

    /// A count above 0.
    fn positive(&self, name: &str) -> Result<u64, String> {
        let count = self.needed(name)?;
        if count == 0 { Err(format!("{name} is 0, which nothing measured has")) } else { Ok(count) }
    }

    fn timing(&self, name: &str) -> Result<Timing, String> {
        let wrong =
            |_| format!("{name} is '{}', where seconds with {BETWEEN} between them were expected", self.text(name));
        let runs = self.text(name).split(BETWEEN).filter(|run| !run.is_empty());
        let runs: Vec<f64> = runs.map(str::parse).collect::<Result<_, _>>().map_err(wrong)?;
        if runs.iter().any(|seconds| !seconds.is_finite() || *seconds < 0.0) {
            return Err(format!("{name} is '{}', where seconds from 0 on were expected", self.text(name)));
        }
        Ok(Timing { runs })
    }

    fn row(&self) -> Result<Row, String> {
        let kind = self.text("kind");
        let kind = StreamKind::from_name(kind).ok_or_else(|| format!("'{kind}' is no kind of stream"))?;
        let settings = KNOBS.iter().map(|knob| (knob.name, self.text(knob.name).to_owned()));
        let settings = settings.filter(|(_, value)| !value.is_empty()).collect();
        let mark = self.text("made_of");
        Ok(Row {
            studies: self.text("studies").split(BETWEEN).filter(|name| !name.is_empty()).map(str::to_owned).collect(),
            measured: Measured {
                point: Point::new(kind, settings),
                sizes: Sizes {
                    raw: self.positive("bytes_raw")?,
                    temporal: self.positive("bytes_temporal")?,
                    spatial: self.optional("bytes_spatial")?,
                    container: self.positive("bytes_container")?,
                    lzma2: self.positive("bytes_lzma2")?,
                },
                quality: Quality {
                    psnr_db: self.measured("psnr_db", true)?.ok_or("it has no psnr_db")?,
                    min_psnr_db: self.measured("min_psnr_db", true)?,
                    ssim: self.optional("ssim")?.filter(|ssim: &f64| ssim.is_finite()),
                    max_error_codes: self.optional("max_error_codes")?,
                    max_error_m: self.measured("max_error_m", false)?,
                },
                encode: self.timing("encode_runs")?,
                decode: self.timing("decode_runs")?,
                frames: self.positive("frames")?,
                images: self.positive("images")?,
                pixels: self.positive("pixels")?,
                updated_pixels: self.needed("updated_pixels")?,
                decode_passes: self.needed("decode_passes")?,
                encode_peak_bytes: self.optional("encode_peak_bytes")?,
                decode_peak_bytes: self.optional("decode_peak_bytes")?,
            },
            command: self.text("command").to_owned(),
            made_of: u32::from_str_radix(mark, 16).map_err(|_| format!("made_of is '{mark}', no mark"))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(kind: StreamKind, runs: &[f64]) -> Row {
        let settings = vec![("psnr", "40".to_owned()), ("threads", "1".to_owned())];
        Row {
            studies: vec!["cells".to_owned(), "color".to_owned()],
            measured: Measured {
                point: Point::new(kind, settings),
                sizes: Sizes { raw: 1000, temporal: 90, spatial: Some(80), container: 80, lzma2: 70 },
                quality: Quality {
                    psnr_db: f64::INFINITY,
                    min_psnr_db: Some(40.125),
                    ssim: Some(0.987_654_321_012_345_6),
                    max_error_codes: None,
                    max_error_m: None,
                },
                encode: Timing { runs: runs.to_vec() },
                decode: Timing { runs: runs.iter().map(|run| run / 3.0).collect() },
                frames: 6,
                images: 36,
                pixels: 1 << 40,
                updated_pixels: 12_345,
                decode_passes: 17,
                encode_peak_bytes: Some(1 << 30),
                decode_peak_bytes: None,
            },
            command: "lightfold encode 'a, \"b\"' --stream=color -o point.lfold".to_owned(),
            made_of: 0x00ab_cdef,
        }
    }

    #[test]
    fn figures_that_nothing_measured_has_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let store =
            Store { path: folder.path().join(FILE_NAME), rows: vec![row(StreamKind::Color, &[0.5, 0.25])], dropped: 0 };
        let text = store.text().unwrap();
        let said = |text: &str| {
            std::fs::write(&store.path, text).unwrap();
            Store::open(folder.path(), None).map(|store| store.rows.len()).map_err(|error| error.to_string())
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
        let mut store = Store::open(folder.path(), Some(0x00ab_cdef)).unwrap();
        store.rows = vec![row(StreamKind::Color, &[0.1, 0.2 + 0.1]), row(StreamKind::Depth, &[])];
        store.save().unwrap();
        let again = Store::open(folder.path(), Some(0x00ab_cdef)).unwrap();
        assert_eq!((&again.rows, again.dropped), (&store.rows, 0));
        assert_eq!(again.runs(&store.rows[0].measured.point), 2);
        assert_eq!(again.text().unwrap(), store.text().unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn rows_of_something_else_are_dropped_and_counted() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path(), None).unwrap();
        store.rows = vec![row(StreamKind::Color, &[]), Row { made_of: 7, ..row(StreamKind::Depth, &[]) }];
        store.save().unwrap();
        let seven = Store::open(folder.path(), Some(7)).unwrap();
        assert_eq!((seven.rows.len(), seven.dropped), (1, 1));
        assert_eq!(seven.rows[0].measured.point.kind, StreamKind::Depth);
        assert_eq!(Store::open(folder.path(), None).unwrap().rows.len(), 2);
    }

    #[test]
    fn a_file_of_something_else_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE_NAME);
        let heads = columns().collect::<Vec<_>>();
        let line = |of: &[(&str, &str)]| {
            let cell = |head: &&str| of.iter().find(|(name, _)| name == head).map_or("", |(_, cell)| *cell);
            format!("{}\n{}\n", heads.join(","), heads.iter().map(cell).collect::<Vec<_>>().join(","))
        };
        for (text, said) in [
            ("a,b\n1,2\n".to_owned(), "no column studies"),
            (line(&[("kind", "sound"), ("made_of", "1")]), "row 2: 'sound' is no kind of stream"),
            (line(&[("kind", "depth"), ("made_of", "1")]), "row 2: it has no bytes_raw"),
            (line(&[("kind", "depth"), ("bytes_raw", "many")]), "bytes_raw is 'many'"),
            (format!("{}depth,1,2\n", line(&[])), "row 2"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = Store::open(folder.path(), None).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
            assert!(error.contains("remove the file"), "{error}");
        }
    }
}
