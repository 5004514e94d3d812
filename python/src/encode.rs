//! Encoding of numpy arrays into a container.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use half::f16;
use library::{EncodeSummary, Encoder, EncoderStream, Error, Face, Monitor, StreamKind};
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use crate::errors::{raised, refuse};
use crate::probe::Probe;
use crate::report;
use crate::settings::{Given, settings};

/// Interval between checks for signals.
const POLL: Duration = Duration::from_millis(100);

/// Encodes arrays into a container and returns a summary, in the format of `lightfold encode --json`.
///
/// `color`, `depth`, `material` and `alpha` have one entry per probe, `None` for a probe without such images. An entry is the
/// frames of the probe's single view, or a dict from faces of its cube map to their frames. Frames are an array whose first
/// axis is the frame, or a sequence of images:
///
/// - depth: (frames, height, width), distances in metres, inf for background
/// - color: (frames, height, width, 3), floats of linear Rec. 709 RGB, or uint8 sRGB codes
/// - material: (frames, height, width, 3), weights of reflection and refraction, 0 to 1, and index of refraction, 1 to 3
/// - alpha: (frames, height, width), 0 to 1, by which the probe's color is multiplied
///
/// `probes` are names or `Probe` objects; with a single probe, the argument may be omitted. `name` (default: the file name
/// without its extension), `fps` (default 24) and `first_frame` (default 0) describe the dataset. All other arguments are
/// settings, named like the options of `lightfold encode`, such as `max_error`, `psnr`, `depth_window` or `hdr`;
/// `lightfold encode --help` explains them.
///
/// Frames are held in memory until the file is written, and the file appears only when it is complete. Raises `Error` for
/// values or settings that cannot be encoded, `TypeError` for an unknown argument, and `OSError` if the file cannot be
/// written.
///
/// >>> depth = np.full((4, 64, 128), 2.0)      # frames, height, width
/// >>> depth[:, 16:48, 32:96] = 1.5
/// >>> lightfold.encode("view.lfold", depth=[depth], max_error=0)["frames"]
/// 4
///
/// A cube map:
///
/// >>> light = {face: np.full((4, 32, 32, 3), 0.5) for face in lightfold.FACES}
/// >>> probe = lightfold.Probe("00", position=(0, 1.5, 0))
/// >>> summary = lightfold.encode("cube.lfold", [probe], color=[light], psnr=45, fps=30)
/// >>> lightfold.open("cube.lfold")
/// <Container 'cube', 6 streams of 1 probe>
#[pyfunction]
#[pyo3(
    signature = (path, probes=None, **arguments),
    text_signature = "(path, probes=None, *, color=None, depth=None, material=None, alpha=None, name=None, fps=24.0, first_frame=0, **settings)"
)]
pub fn encode<'py>(
    py: Python<'py>,
    path: PathBuf,
    probes: Option<Vec<Named>>,
    arguments: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut given = Given::new(arguments);
    let mut entries = Vec::new();
    for kind in StreamKind::ALL {
        entries.push((kind, given.take::<Bound<'py, PyAny>>(kind.name())?));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = given.take("name")?.unwrap_or(stem);
    let fps = given.take("fps")?.unwrap_or(24.0);
    if !(f64::is_finite(fps) && fps > 0.0) {
        return refuse(format!("`fps` {fps}: a number above 0 was expected"));
    }
    let first_frame = given.take("first_frame")?.unwrap_or(0);
    let settings = settings(&mut given)?;
    given.finish()?;

    let mut encoder = Encoder::new(&name, fps).with_settings(settings).starting_at(first_frame);
    let probes: Vec<Probe> = match probes {
        Some(probes) => probes.into_iter().map(Named::probe).collect(),
        None => vec![Named::Name("00".into()).probe()],
    };
    for probe in &probes {
        encoder.add_probe(&probe.name, probe.pose()).map_err(raised)?;
    }
    for (kind, entries) in entries {
        let Some(entries) = entries else { continue };
        let entries: Vec<_> = entries.try_iter()?.collect::<PyResult<_>>()?;
        let (name, count) = (kind.name(), entries.len());
        if count != probes.len() {
            let expected = format!("one for each probe was expected, as in {name}=[frames]");
            return refuse(format!("`{name}` has {count} entries, there are {} probes: {expected}", probes.len()));
        }
        for (at, (entry, probe)) in entries.iter().zip(&probes).enumerate() {
            Frames { encoder: &mut encoder, kind, probe: at, name: &probe.name }.push(entry)?;
        }
    }
    let summary = write(py, encoder, &path)?;
    report::object(py, &report::json(&summary)?)
}

/// A probe, or the name of a probe at the origin with the default orientation.
#[derive(FromPyObject)]
pub enum Named {
    Name(String),
    Probe(Probe),
}

impl Named {
    fn probe(self) -> Probe {
        match self {
            Named::Probe(probe) => probe,
            Named::Name(name) => Probe::new(name, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), None),
        }
    }
}

/// Adds the images of one kind of a probe to an encoder.
struct Frames<'a> {
    encoder: &'a mut Encoder,
    kind: StreamKind,
    probe: usize,
    /// Name of the probe, for error messages.
    name: &'a str,
}

impl Frames<'_> {
    fn push(&mut self, entry: &Bound<'_, PyAny>) -> PyResult<()> {
        if entry.is_none() {
            return Ok(());
        }
        let Ok(faces) = entry.cast::<PyMapping>() else { return self.push_face(Face::View, entry) };
        for item in faces.items()? {
            let (name, frames): (String, Bound<'_, PyAny>) = item.extract()?;
            let Some(face) = Face::CUBE.into_iter().find(|face| face.name() == name) else {
                let kind = self.kind.name();
                return refuse(format!("`{kind}`: \"{name}\" is no face: px, nx, py, ny, pz or nz was expected"));
            };
            self.push_face(face, &frames)?;
        }
        Ok(())
    }

    fn push_face(&mut self, face: Face, frames: &Bound<'_, PyAny>) -> PyResult<()> {
        let place = format!("`{}` of probe {}, face {}", self.kind.name(), self.name, face.name());
        let named = |error: Error| raised(error.context(&place));
        let mut stream = None;
        for (frame, image) in frames.try_iter()?.enumerate() {
            let image = Image::new(&image?, self.kind)?;
            let shape = image.array.shape();
            let size = match (self.kind, shape) {
                (StreamKind::Depth | StreamKind::Alpha, &[height, width]) => [width, height],
                (StreamKind::Color | StreamKind::Material, &[height, width, 3]) => [width, height],
                (kind, shape) => {
                    let is_single = matches!(kind, StreamKind::Depth | StreamKind::Alpha);
                    let samples = if is_single { "" } else { ", 3" };
                    return refuse(format!(
                        "{place}: frame {frame} has the shape {shape:?}, (height, width{samples}) was expected"
                    ));
                }
            };
            let size = size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
            let stream = match stream {
                Some(stream) => stream,
                None => *stream.insert(self.add(face, size).map_err(named)?),
            };
            image.push(self.encoder, stream, &named)?;
        }
        Ok(())
    }

    fn add(&mut self, face: Face, size: [u32; 2]) -> library::Result<EncoderStream> {
        match self.kind {
            StreamKind::Depth => self.encoder.add_depth(self.probe, face, size),
            StreamKind::Color => self.encoder.add_color(self.probe, face, size),
            StreamKind::Material => self.encoder.add_material(self.probe, face, size),
            StreamKind::Alpha => self.encoder.add_alpha(self.probe, face, size),
        }
    }
}

/// A contiguous image of a type that the encoder accepts.
struct Image<'py> {
    array: Bound<'py, PyUntypedArray>,
    kind: StreamKind,
    is_bytes: bool,
}

impl<'py> Image<'py> {
    fn new(image: &Bound<'py, PyAny>, kind: StreamKind) -> PyResult<Image<'py>> {
        let numpy = image.py().import("numpy")?;
        let image = numpy.call_method1("asarray", (image,))?.cast_into::<PyUntypedArray>()?;
        let found = image.dtype();
        let is_bytes = found.str()? == "uint8";
        let class: char = found.getattr("kind")?.extract()?;
        let dtype = match (kind, class) {
            (StreamKind::Depth | StreamKind::Material | StreamKind::Alpha, 'f') => "float32",
            (StreamKind::Color, 'f') => "float16",
            (StreamKind::Color, _) if is_bytes => "uint8",
            _ => {
                let expected = if kind == StreamKind::Color { "floats or uint8" } else { "floats" };
                return refuse(format!("`{}`: an array of {found}, {expected} were expected", kind.name()));
            }
        };
        let array = numpy.call_method1("ascontiguousarray", (image, dtype))?.cast_into::<PyUntypedArray>()?;
        Ok(Image { array, kind, is_bytes })
    }

    fn push(&self, encoder: &mut Encoder, stream: EncoderStream, named: &dyn Fn(Error) -> PyErr) -> PyResult<()> {
        match self.kind {
            StreamKind::Depth => self.with(|metres: &[f32]| encoder.push_depth(stream, metres)),
            StreamKind::Color if self.is_bytes => {
                self.with(|codes: &[u8]| encoder.push_color8(stream, codes.as_chunks().0))
            }
            StreamKind::Color => self.with(|light: &[f16]| encoder.push_color(stream, light.as_chunks().0)),
            StreamKind::Material => self.with(|values: &[f32]| encoder.push_material(stream, values.as_chunks().0)),
            StreamKind::Alpha => self.with(|alpha: &[f32]| encoder.push_alpha(stream, alpha)),
        }?
        .map_err(named)
    }

    /// Calls `push` with the array's values, in row-major order.
    fn with<T: Element, R>(&self, push: impl FnOnce(&[T]) -> R) -> PyResult<R> {
        let array = self.array.cast::<PyArrayDyn<T>>()?.try_readonly()?;
        Ok(push(array.as_slice()?))
    }
}

/// Encodes into a temporary file in the same folder, and renames it.
#[allow(clippy::disallowed_methods)]
fn write(py: Python<'_>, encoder: Encoder, path: &Path) -> PyResult<EncodeSummary> {
    let io = |error| raised(Error::io(path, error));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.suffix(".partial");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let partial = builder.tempfile_in(folder).map_err(io)?;
    let out = BufWriter::new(partial.as_file().try_clone().map_err(io)?);
    let (mut out, summary) = run(py, encoder, out)?;
    out.flush().map_err(io)?;
    // The content is synced before the rename, and the folder before the function returns.
    partial.as_file().sync_all().map_err(io)?;
    partial.persist(path).map_err(|error| io(error.error))?;
    #[cfg(unix)]
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(io)?;
    Ok(summary)
}

/// Encodes on another thread while this thread checks for signals, such as SIGINT (Ctrl-C).
fn run(py: Python<'_>, encoder: Encoder, out: BufWriter<File>) -> PyResult<(BufWriter<File>, EncodeSummary)> {
    let stop = Stop(AtomicBool::new(false));
    let mut raised_by_signal = None;
    let done = thread::scope(|scope| {
        let caller = thread::current();
        let work = scope.spawn({
            let stop = &stop;
            move || {
                let done = encoder.finish_monitored(out, stop);
                caller.unpark();
                done
            }
        });
        while !work.is_finished() {
            py.detach(|| thread::park_timeout(POLL));
            if let Err(error) = py.check_signals() {
                stop.0.store(true, Ordering::Relaxed);
                raised_by_signal = Some(error);
            }
        }
        work.join()
    });
    match (done, raised_by_signal) {
        (Err(panic), _) => std::panic::resume_unwind(panic),
        (Ok(_), Some(error)) => Err(error),
        (Ok(done), None) => done.map_err(raised),
    }
}

#[derive(Debug)]
struct Stop(AtomicBool);

impl Monitor for Stop {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
