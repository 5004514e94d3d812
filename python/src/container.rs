//! An open container.

use std::path::PathBuf;
use std::sync::Arc;

use library::{Decoder, StreamKind};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use crate::errors::raised;
use crate::probe::Probe;
use crate::report;
use crate::stream::Stream;

/// Opens a container; `path` is a string or a path.
///
/// Raises `OSError` if the file cannot be read, and `Error` if its header or index is damaged.
///
/// >>> film = lightfold.open("film.lfold")
/// >>> film
/// <Container 'film', 12 streams of 1 probe>
#[pyfunction]
pub fn open(py: Python<'_>, path: PathBuf) -> PyResult<Container> {
    let decoder = py.detach(|| Decoder::open(path)).map_err(raised)?;
    let decoder = Arc::new(decoder);
    let probes = decoder.probes().iter().map(|entry| Py::new(py, Probe::of_entry(entry)));
    let streams = (0..decoder.streams().len()).map(|at| Py::new(py, Stream::new(&decoder, at)));
    Ok(Container { probes: probes.collect::<PyResult<_>>()?, streams: streams.collect::<PyResult<_>>()?, decoder })
}

/// An open container, returned by `open`.
#[pyclass(frozen, module = "lightfold")]
#[derive(Debug)]
pub struct Container {
    decoder: Arc<Decoder>,
    probes: Vec<Py<Probe>>,
    streams: Vec<Py<Stream>>,
}

#[pymethods]
impl Container {
    /// Name of the dataset.
    #[getter]
    fn name(&self) -> &str {
        self.decoder.name()
    }

    /// Frames per second.
    #[getter]
    fn fps(&self) -> f64 {
        self.decoder.fps()
    }

    /// All probes, in the order of the container.
    ///
    /// >>> lightfold.open("film.lfold").probes
    /// [Probe('00', position=(0.0, 1.5, 0.0))]
    #[getter]
    fn probes(&self, py: Python<'_>) -> Vec<Py<Probe>> {
        self.probes.iter().map(|probe| probe.clone_ref(py)).collect()
    }

    /// All streams; each access returns the same objects. A stream keeps the last frame that it decoded, from which it decodes
    /// the next.
    ///
    /// >>> for stream in lightfold.open("film.lfold").streams[:2]:
    /// ...     print(stream.kind, stream.probe, stream.face, stream.size, stream.frames)
    /// color 00 px (32, 32) range(0, 4)
    /// color 00 nx (32, 32) range(0, 4)
    #[getter]
    fn streams(&self, py: Python<'_>) -> Vec<Py<Stream>> {
        self.streams.iter().map(|stream| stream.clone_ref(py)).collect()
    }

    /// Returns the stream of a kind ("color", "depth", "material" or "alpha"), probe (a name) and face ("px", "nx", "py", "ny",
    /// "pz", "nz" or "view"). Probe and face may be omitted if only one stream matches.
    ///
    /// Raises `KeyError` if no stream matches, or if several do.
    ///
    /// >>> lightfold.open("film.lfold").stream("depth", "00", "py")
    /// <Stream depth of probe 00, face py, 32x32, frames 0-3, predictive>
    #[pyo3(signature = (kind, probe=None, face=None))]
    fn stream(&self, py: Python<'_>, kind: &str, probe: Option<&str>, face: Option<&str>) -> PyResult<Py<Stream>> {
        let fits = |stream: &Stream| {
            let (info, of_probe) = (stream.info(), stream.probe());
            info.kind.name() == kind
                && probe.is_none_or(|probe| probe == of_probe)
                && face.is_none_or(|face| face == info.face.name())
        };
        let mut found = self.streams.iter().filter(|stream| fits(stream.get()));
        let none = || format!("no {kind} of probe {}, face {}", probe.unwrap_or("any"), face.unwrap_or("any"));
        match (found.next(), found.count()) {
            (Some(stream), 0) => Ok(stream.clone_ref(py)),
            (Some(_), others) => {
                Err(PyKeyError::new_err(format!("{} streams of {kind} fit: name a probe and a face", others + 1)))
            }
            (None, _) if StreamKind::from_name(kind).is_none() => {
                Err(PyKeyError::new_err(format!("no kind \"{kind}\": color, depth, material or alpha")))
            }
            (None, _) => Err(PyKeyError::new_err(none())),
        }
    }

    /// Returns bytes, chunks, keyframes and settings of all streams, in the format of `lightfold inspect --json`. Reads every
    /// chunk.
    ///
    /// Raises `Error` for the first damaged chunk.
    ///
    /// >>> statistics = lightfold.open("film.lfold").statistics()
    /// >>> statistics["frames"], sorted(statistics["kinds"])
    /// (48, ['color', 'depth'])
    /// >>> depth = statistics["streams"][6]
    /// >>> depth["kind"], depth["chunks"], depth["near_m"], depth["far_m"]
    /// ('depth', 1, 2.0, 5.0)
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let json = py.detach(|| {
            let found = library::statistics(&self.decoder).map_err(raised)?;
            report::json(&found.report(&self.decoder))
        })?;
        report::object(py, &json)
    }

    fn __repr__(&self) -> String {
        let probes = self.probes.len();
        let plural = if probes == 1 { "" } else { "s" };
        format!("<Container '{}', {} streams of {probes} probe{plural}>", self.name(), self.streams.len())
    }
}
