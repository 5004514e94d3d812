//! Encodes frames from memory through the same code as `lightfold encode`.

use std::io::Write;

use half::f16;

use crate::dataset::manifest::is_probe_name;
use crate::dataset::{ProbeInfo, SourceGroup};
use crate::encode::EncodeSettings;
use crate::encode::job::{self, EncodeSummary};
use crate::encode::source::FrameSource;
use codec::error::{Error, Result};
use codec::image::transfer::{DecodeTable, ToneMap};
use codec::image::{
    AlphaPlane, ColorPlane, DepthPlane, Face, FrameRange, MaterialPlane, Plane, Projection, StreamKind,
};
use codec::monitor::{Monitor, Silent};

/// Encodes frames from memory into a container.
///
/// Add probes and streams first, then push frames; [`Self::finish`] encodes them. All streams start at the same frame; each may
/// have its own number of frames. Frames are held until `finish`, at 4 bytes a pixel for depth and alpha, 6 for colour, 12 for
/// material.
#[derive(Debug)]
pub struct Encoder {
    source: MemorySource,
    settings: EncodeSettings,
    first_frame: u32,
}

/// Position and orientation of a probe, and the intrinsics of its view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbePose {
    /// Centre in metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w that rotates the probe's axes into the world's.
    pub orientation: [f64; 4],
    /// fx, fy, cx, cy in pixels of [`Face::View`]; `None` for a cube map, and if they are unknown.
    pub intrinsics: Option<[f64; 4]>,
}

impl Default for ProbePose {
    fn default() -> Self {
        ProbePose { position: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0], intrinsics: None }
    }
}

/// Handle of a stream of an [`Encoder`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncoderStream(usize);

impl Encoder {
    /// Creates an encoder without probes, with the default settings of `lightfold encode`.
    pub fn new(name: &str, fps: f64) -> Encoder {
        let source =
            MemorySource { name: name.to_owned(), fps, probes: Vec::new(), groups: Vec::new(), frames: Vec::new() };
        Encoder { source, settings: EncodeSettings::default(), first_frame: 0 }
    }

    /// Replaces the settings.
    #[must_use]
    pub fn with_settings(self, settings: EncodeSettings) -> Encoder {
        Encoder { settings, ..self }
    }

    /// Sets the number of the first frame, 0 by default.
    #[must_use]
    pub fn starting_at(self, first_frame: u32) -> Encoder {
        Encoder { first_frame, ..self }
    }

    /// Adds a probe and returns its number.
    ///
    /// # Errors
    /// [`Error::Usage`] for a name that is in use, or has characters other than letters, digits, `.`, `_` and `-`.
    pub fn add_probe(&mut self, name: &str, pose: ProbePose) -> Result<usize> {
        if !is_probe_name(name) || self.source.probes.iter().any(|probe| probe.name == name) {
            return Err(Error::Usage(format!(
                "\"{name}\" is not a new probe name of letters, digits, '.', '_' and '-'"
            )));
        }
        let ProbePose { position, orientation, intrinsics } = pose;
        let frames = FrameRange { first: self.first_frame, last: self.first_frame };
        self.source.probes.push(ProbeInfo {
            name: name.to_owned(),
            position,
            orientation,
            poses: Vec::new(),
            frames,
            intrinsics,
        });
        Ok(self.source.probes.len() - 1)
    }

    /// Adds a depth stream of images of `size` (width, height) pixels.
    ///
    /// # Errors
    /// [`Error::Usage`] for an unknown probe, a second stream of the same kind and face, a cube face that is not square, or
    /// a mix of [`Face::View`] and cube faces.
    pub fn add_depth(&mut self, probe: usize, face: Face, size: [u32; 2]) -> Result<EncoderStream> {
        self.add_stream(probe, face, size, Frames::Depth(Vec::new()))
    }

    /// Adds a colour stream.
    ///
    /// # Errors
    /// As for [`Self::add_depth`].
    pub fn add_color(&mut self, probe: usize, face: Face, size: [u32; 2]) -> Result<EncoderStream> {
        self.add_stream(probe, face, size, Frames::Color(Vec::new()))
    }

    /// Adds a material stream.
    ///
    /// # Errors
    /// As for [`Self::add_depth`].
    pub fn add_material(&mut self, probe: usize, face: Face, size: [u32; 2]) -> Result<EncoderStream> {
        self.add_stream(probe, face, size, Frames::Material(Vec::new()))
    }

    /// Adds an alpha stream. The colour of the same face is premultiplied by it.
    ///
    /// # Errors
    /// As for [`Self::add_depth`].
    pub fn add_alpha(&mut self, probe: usize, face: Face, size: [u32; 2]) -> Result<EncoderStream> {
        self.add_stream(probe, face, size, Frames::Alpha(Vec::new()))
    }

    fn add_stream(&mut self, probe: usize, face: Face, size: [u32; 2], frames: Frames) -> Result<EncoderStream> {
        let [width, height] = size;
        let wrong = |message: &str| Err(Error::Usage(format!("{width}x{height} {}: {message}", face.name())));
        let groups = &self.source.groups;
        if probe >= self.source.probes.len() {
            return wrong("the probe is unknown");
        }
        if width == 0 || height == 0 || (face != Face::View && width != height) {
            return wrong("cube faces must be square, and images must not be empty");
        }
        if groups.iter().any(|group| (group.faces == [Face::View]) != (face == Face::View)) {
            return wrong("a container cannot have both cube faces and views");
        }
        let kind = frames.kind();
        if groups.iter().any(|group| (group.kind, group.probe, &group.faces[..]) == (kind, probe, &[face])) {
            return wrong("the probe already has such a stream");
        }
        let range = FrameRange { first: self.first_frame, last: self.first_frame };
        self.source.groups.push(SourceGroup { kind, probe, faces: vec![face], frames: range, width, height });
        self.source.frames.push(frames);
        Ok(EncoderStream(self.source.groups.len() - 1))
    }

    /// Adds a frame of distances from the probe's centre in metres, row by row; +inf for the background.
    ///
    /// # Errors
    /// [`Error::Usage`] for a stream of another kind or a slice of another length; [`Error::Invalid`] for a depth that is NaN,
    /// zero or negative.
    pub fn push_depth(&mut self, stream: EncoderStream, metres: &[f32]) -> Result<()> {
        let ([width, height], Some(Frames::Depth(frames))) = self.stream(stream) else { return Err(wrong_kind()) };
        if let Some(at) = metres.iter().position(|&z| z.is_nan() || z <= 0.0) {
            let (x, y) = (at % width as usize, at / width as usize);
            return Err(Error::invalid(format!("pixel ({x}, {y}) of frame {} lies at {} m", frames.len(), metres[at])));
        }
        frames.push(plane(width, height, metres)?);
        Ok(())
    }

    /// Adds a frame of linear Rec. 709 colour, row by row.
    ///
    /// # Errors
    /// As for [`Self::push_depth`]; [`Error::Invalid`] for NaN and infinity.
    pub fn push_color(&mut self, stream: EncoderStream, light: &[[f16; 3]]) -> Result<()> {
        let ([width, height], Some(Frames::Color(frames))) = self.stream(stream) else { return Err(wrong_kind()) };
        if light.as_flattened().iter().any(|value| !value.is_finite()) {
            return Err(Error::invalid(format!("frame {} has a colour that is not finite", frames.len())));
        }
        frames.push(plane(width, height, light)?);
        Ok(())
    }

    /// Adds a frame of 8-bit sRGB codes, row by row, as stored in a PNG file.
    ///
    /// # Errors
    /// As for [`Self::push_depth`].
    pub fn push_color8(&mut self, stream: EncoderStream, codes: &[[u8; 3]]) -> Result<()> {
        let table = DecodeTable::new(&ToneMap::default());
        let light: Vec<_> = codes.iter().map(|pixel| pixel.map(|code| table.value(code))).collect();
        self.push_color(stream, &light)
    }

    /// Adds a frame of reflection weight, refraction weight (0 to 1) and index of refraction (1 to 3), row by row.
    ///
    /// # Errors
    /// As for [`Self::push_depth`]. [`Self::finish`] fails for values outside their ranges.
    pub fn push_material(&mut self, stream: EncoderStream, material: &[[f32; 3]]) -> Result<()> {
        let ([width, height], Some(Frames::Material(frames))) = self.stream(stream) else { return Err(wrong_kind()) };
        frames.push(plane(width, height, material)?);
        Ok(())
    }

    /// Adds a frame of alpha, 0 to 1, row by row.
    ///
    /// # Errors
    /// As for [`Self::push_depth`]. [`Self::finish`] fails for values outside the range.
    pub fn push_alpha(&mut self, stream: EncoderStream, alpha: &[f32]) -> Result<()> {
        let ([width, height], Some(Frames::Alpha(frames))) = self.stream(stream) else { return Err(wrong_kind()) };
        frames.push(plane(width, height, alpha)?);
        Ok(())
    }

    fn stream(&mut self, EncoderStream(at): EncoderStream) -> ([u32; 2], Option<&mut Frames>) {
        let size = self.source.groups.get(at).map_or([0; 2], |group| [group.width, group.height]);
        (size, self.source.frames.get_mut(at))
    }

    /// Encodes all frames into `out`, front to back; returns `out` and the statistics of the encode.
    ///
    /// # Errors
    /// [`Error::Usage`] for settings out of range, no stream, or a stream without frames; [`Error::Invalid`] for values that
    /// cannot be coded; [`Error::Io`] if writing fails.
    pub fn finish<W: Write>(self, out: W) -> Result<(W, EncodeSummary)> {
        self.finish_monitored(out, &Silent)
    }

    /// As [`Self::finish`], with a monitor, which advances by one per image and can stop the encode.
    ///
    /// # Errors
    /// As for [`Self::finish`]; [`Error::Interrupted`] if the monitor stopped the encode.
    pub fn finish_monitored<W: Write>(self, out: W, monitor: &dyn Monitor) -> Result<(W, EncodeSummary)> {
        let Encoder { mut source, settings, first_frame } = self;
        // Same order as a dataset: by kind, probe and face.
        let mut streams: Vec<_> = source.groups.into_iter().zip(source.frames).collect();
        streams.sort_by_key(|(group, _)| (group.kind, group.probe, group.faces[0]));
        for (group, frames) in &mut streams {
            let Some(last) = frames.len().checked_sub(1) else {
                return Err(Error::Usage(format!("the {} of probe {} has no frames", group.kind.name(), group.probe)));
            };
            group.frames.last = u32::try_from(u64::from(first_frame) + last as u64)
                .map_err(|_| Error::Usage("frame numbers must be below 2^31".into()))?;
            let probe = &mut source.probes[group.probe];
            probe.frames = probe.frames.hull(group.frames);
        }
        (source.groups, source.frames) = streams.into_iter().unzip();
        job::encode(&source, &settings, out, monitor)
    }
}

fn plane<T: Clone>(width: u32, height: u32, pixels: &[T]) -> Result<Plane<T>> {
    Plane::new(width, height, pixels.to_vec()).map_err(|error| Error::Usage(error.to_string()))
}

fn wrong_kind() -> Error {
    Error::Usage("a frame of another kind than its stream".into())
}

#[derive(Debug)]
enum Frames {
    Depth(Vec<DepthPlane>),
    Color(Vec<ColorPlane>),
    Material(Vec<MaterialPlane>),
    Alpha(Vec<AlphaPlane>),
}

impl Frames {
    fn kind(&self) -> StreamKind {
        match self {
            Frames::Depth(_) => StreamKind::Depth,
            Frames::Color(_) => StreamKind::Color,
            Frames::Material(_) => StreamKind::Material,
            Frames::Alpha(_) => StreamKind::Alpha,
        }
    }

    fn len(&self) -> usize {
        match self {
            Frames::Depth(frames) => frames.len(),
            Frames::Color(frames) => frames.len(),
            Frames::Material(frames) => frames.len(),
            Frames::Alpha(frames) => frames.len(),
        }
    }
}

#[derive(Debug)]
struct MemorySource {
    name: String,
    fps: f64,
    probes: Vec<ProbeInfo>,
    groups: Vec<SourceGroup>,
    /// Frames of each group.
    frames: Vec<Frames>,
}

impl MemorySource {
    fn frames(&self, group: &SourceGroup) -> Option<&Frames> {
        self.groups.iter().position(|known| known == group).map(|at| &self.frames[at])
    }
}

/// Returns the plane of a frame as a one-element list, for a group of one face.
fn one<T: Clone>(frames: &[Plane<T>], group: &SourceGroup, frame: u32) -> Result<Vec<Plane<T>>> {
    let plane = frame.checked_sub(group.frames.first).and_then(|at| frames.get(at as usize));
    Ok(vec![plane.ok_or_else(|| Error::Usage(format!("there is no frame {frame}")))?.clone()])
}

impl FrameSource for MemorySource {
    fn name(&self) -> &str {
        &self.name
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn projection(&self) -> Projection {
        match self.groups.first() {
            Some(group) if group.faces == [Face::View] => Projection::Perspective,
            _ => Projection::Cubemap,
        }
    }

    fn probes(&self) -> &[ProbeInfo] {
        &self.probes
    }

    fn groups(&self) -> &[SourceGroup] {
        &self.groups
    }

    fn read_depth(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        let Some(Frames::Depth(frames)) = self.frames(group) else { return Err(wrong_kind()) };
        one(frames, group, frame)
    }

    fn read_color(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>> {
        let Some(Frames::Color(frames)) = self.frames(group) else { return Err(wrong_kind()) };
        one(frames, group, frame)
    }

    fn read_material(&self, group: &SourceGroup, frame: u32) -> Result<Vec<MaterialPlane>> {
        let Some(Frames::Material(frames)) = self.frames(group) else { return Err(wrong_kind()) };
        one(frames, group, frame)
    }

    fn read_alpha(&self, group: &SourceGroup, frame: u32) -> Result<Vec<AlphaPlane>> {
        let Some(Frames::Alpha(frames)) = self.frames(group) else { return Err(wrong_kind()) };
        one(frames, group, frame)
    }
}
