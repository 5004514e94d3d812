//! Streams, decoded into numpy arrays.

use std::sync::{Arc, Mutex, PoisonError};

use half::f16;
use library::{Decoder, DepthRange, FaceDecoder, PixelsMut, StreamInfo, StreamKind};
use numpy::{
    Element, IxDyn, PyArrayDescr, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods, dtype,
};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyRange, PyTuple};
use self_cell::self_cell;

use crate::errors::{Error, raised, refuse};

self_cell!(
    /// A face decoder and the container that it borrows from.
    struct Images {
        owner: Arc<Decoder>,
        #[covariant]
        dependent: FaceDecoder,
    }

    impl {Debug}
);

/// Images of one kind (color, depth, material, alpha), of one face of one probe, over a range of frames.
#[pyclass(frozen, module = "lightfold")]
#[derive(Debug)]
pub struct Stream {
    container: Arc<Decoder>,
    at: usize,
    /// Decoder of the stream, created at the first call of `decode`; keeps the last frame.
    images: Mutex<Option<Images>>,
}

impl Stream {
    pub fn new(container: &Arc<Decoder>, at: usize) -> Stream {
        Stream { container: Arc::clone(container), at, images: Mutex::new(None) }
    }

    pub fn info(&self) -> &StreamInfo {
        &self.container.streams()[self.at]
    }

    /// Decodes a frame, detached from the Python interpreter, so that other Python threads run meanwhile.
    fn show(&self, frame: u32, pixels: PixelsMut<'_>) -> library::Result<()> {
        // After a failure or panic, the decoder is dropped, and the next call creates a new one.
        let mut images = self.images.lock().unwrap_or_else(PoisonError::into_inner);
        let mut shown = images.take().unwrap_or_else(|| {
            Images::new(Arc::clone(&self.container), |container| container.face(&container.streams()[self.at]))
        });
        shown.with_dependent_mut(|_, face| face.decode_into(frame, pixels))?;
        *images = Some(shown);
        Ok(())
    }

    fn decode_as<'py, T: Element + Copy>(
        &self,
        frame: u32,
        target: &Target<'_, 'py>,
        pixels: for<'p> fn(&'p mut [T]) -> PixelsMut<'p>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, shape) = (target.py, self.dimensions());
        let array = match target.out {
            None => PyArrayDyn::<T>::zeros(py, IxDyn(&shape), false),
            Some(out) => match out.cast::<PyArrayDyn<T>>() {
                Ok(array) if array.shape() == shape && array.is_c_contiguous() => array.clone(),
                _ => {
                    let dtype = dtype::<T>(py).repr()?;
                    return refuse(format!("`out` is no contiguous array of shape {shape:?} and {dtype}"));
                }
            },
        };
        let mut writable = array.try_readwrite().map_err(|error| Error::new_err(format!("`out`: {error}")))?;
        let slice = writable.as_slice_mut()?;
        py.detach(|| self.show(frame, pixels(slice))).map_err(raised)?;
        drop(writable);
        Ok(array.into_any())
    }

    fn dimensions(&self) -> Vec<usize> {
        let [width, height] = self.info().size().map(|side| side as usize);
        match self.info().kind {
            StreamKind::Depth | StreamKind::Alpha => vec![height, width],
            StreamKind::Color | StreamKind::Material => vec![height, width, 3],
        }
    }
}

/// Destination of a decoded image: the caller's array, or a new one.
struct Target<'a, 'py> {
    py: Python<'py>,
    out: Option<&'a Bound<'py, PyAny>>,
}

#[pymethods]
impl Stream {
    /// "color", "depth", "material" or "alpha".
    #[getter]
    fn kind(&self) -> &'static str {
        self.info().kind.name()
    }

    /// Name of the probe.
    #[getter]
    pub fn probe(&self) -> &str {
        &self.container.probe(self.info()).name
    }

    /// "px", "nx", "py", "ny", "pz" or "nz" for a cube map, "view" for a probe with a single view.
    #[getter]
    fn face(&self) -> &'static str {
        self.info().face.name()
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.info().size().into()
    }

    /// Shape of a decoded image: (height, width) for depth and alpha, (height, width, 3) for color and material.
    #[getter]
    fn shape<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.dimensions())
    }

    /// Default type of the pixels that `decode` returns.
    #[getter]
    fn dtype<'py>(&self, py: Python<'py>) -> Bound<'py, PyArrayDescr> {
        match (self.info().kind, self.info().is_half_float()) {
            (StreamKind::Color, Some(true)) => dtype::<f16>(py),
            (StreamKind::Color, _) => dtype::<u8>(py),
            (StreamKind::Depth | StreamKind::Material | StreamKind::Alpha, _) => dtype::<f32>(py),
        }
    }

    /// Range of frame numbers, as in the source.
    #[getter]
    fn frames<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyRange>> {
        let frames = self.info().frames;
        PyRange::new(py, frames.first as isize, frames.last as isize + 1)
    }

    /// Name of the codec, such as "predictive" or "transform-8bit".
    #[getter]
    fn codec(&self) -> &'static str {
        self.info().codec()
    }

    /// Distance of depth code 0 in metres; `None` if the stream is not depth.
    #[getter]
    fn near_m(&self) -> Option<f32> {
        self.info().depth_range().map(DepthRange::near_m)
    }

    /// Distance of depth code 65534 in metres; `None` if the stream is not depth.
    #[getter]
    fn far_m(&self) -> Option<f32> {
        self.info().depth_range().map(DepthRange::far_m)
    }

    /// Maximum error of a decoded depth in codes; `None` if the codec has no error bound.
    #[getter]
    fn error_bound_codes(&self) -> Option<u16> {
        self.info().error_bound_codes()
    }

    /// Decodes a frame into a new array, or into `out`, which is then returned.
    ///
    /// `dtype` selects the type and meaning of the pixels:
    ///
    /// - depth: float32 (default) for metres, inf for background; uint16 for logarithmic codes, 0 at near, 65534 at far, 65535
    ///   for background
    /// - color: uint8 (default) for codes of the stream's transfer function; float16 (default of half-float streams) or float32
    ///   for linear Rec. 709 RGB
    /// - material: float32 (default) for weights of reflection and refraction, 0 to 1, and index of refraction, 1 to 3; uint8
    ///   for their codes
    /// - alpha: float32 (default), 0 to 1; uint8 for its codes
    ///
    /// Frames may be decoded in any order; increasing order is fastest.
    ///
    /// Raises `IndexError` for a frame outside `frames`, and `Error` for a damaged chunk or an unsupported type.
    ///
    /// >>> film = lightfold.open("film.lfold")
    /// >>> depth = film.stream("depth", face="px")
    /// >>> metres = depth.decode(0)
    /// >>> metres.dtype, float(metres.min().round(2)), float(metres.max().round(2))
    /// (dtype('float32'), 2.0, 5.0)
    /// >>> depth.decode(0, dtype="uint16")[0, 0]
    /// np.uint16(65534)
    /// >>> light = film.stream("color", face="px").decode(3, dtype=np.float32)
    /// >>> light.shape
    /// (32, 32, 3)
    #[pyo3(signature = (frame, dtype=None, out=None))]
    fn decode<'py>(
        &self,
        py: Python<'py>,
        frame: i64,
        dtype: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let info = self.info();
        let frame = u32::try_from(frame).ok().filter(|frame| info.frames.contains(*frame)).ok_or_else(|| {
            PyIndexError::new_err(format!("frame {frame} is not one of the stream's frames {}", info.frames))
        })?;
        let asked = match (dtype, out) {
            (Some(asked), _) => PyArrayDescr::new(py, asked)?,
            (None, Some(out)) if out.hasattr("dtype")? => PyArrayDescr::new(py, out.getattr("dtype")?)?,
            _ => self.dtype(py),
        };
        let is = |other: Bound<'py, PyArrayDescr>| asked.is_equiv_to(&other);
        let (half, single) = (is(numpy::dtype::<f16>(py)), is(numpy::dtype::<f32>(py)));
        let (bytes, codes) = (is(numpy::dtype::<u8>(py)), is(numpy::dtype::<u16>(py)));
        let target = Target { py, out };
        match (info.kind, info.is_half_float()) {
            (StreamKind::Depth, _) if single => self.decode_as::<f32>(frame, &target, |p| PixelsMut::DepthMetres(p)),
            (StreamKind::Depth, _) if codes => self.decode_as::<u16>(frame, &target, |p| PixelsMut::DepthCodes(p)),
            (StreamKind::Color, Some(false)) if bytes => {
                self.decode_as::<u8>(frame, &target, |p| PixelsMut::Color8(p.as_chunks_mut().0))
            }
            (StreamKind::Color, _) if half => {
                self.decode_as::<f16>(frame, &target, |p| PixelsMut::ColorHalf(p.as_chunks_mut().0))
            }
            (StreamKind::Color, _) if single => {
                self.decode_as::<f32>(frame, &target, |p| PixelsMut::ColorFloat(p.as_chunks_mut().0))
            }
            (StreamKind::Material, _) if single => {
                self.decode_as::<f32>(frame, &target, |p| PixelsMut::Material(p.as_chunks_mut().0))
            }
            (StreamKind::Material, _) if bytes => {
                self.decode_as::<u8>(frame, &target, |p| PixelsMut::Material8(p.as_chunks_mut().0))
            }
            (StreamKind::Alpha, _) if single => self.decode_as::<f32>(frame, &target, |p| PixelsMut::Alpha(p)),
            (StreamKind::Alpha, _) if bytes => self.decode_as::<u8>(frame, &target, |p| PixelsMut::Alpha8(p)),
            (kind, is_half) => {
                let types = match (kind, is_half) {
                    (StreamKind::Depth, _) => "float32 and uint16",
                    (StreamKind::Color, Some(true)) => "float16 and float32",
                    (StreamKind::Color, _) => "uint8, float16 and float32",
                    (StreamKind::Material | StreamKind::Alpha, _) => "float32 and uint8",
                };
                refuse(format!("{} does not decode to {asked}: {types} are possible", self.__repr__()))
            }
        }
    }

    fn __repr__(&self) -> String {
        let (info, probe) = (self.info(), self.probe());
        let [width, height] = info.size();
        let (kind, face, frames, codec) = (info.kind.name(), info.face.name(), info.frames, info.codec());
        format!("<Stream {kind} of probe {probe}, face {face}, {width}x{height}, frames {frames}, {codec}>")
    }
}
