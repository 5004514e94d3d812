//! Inputs of view interpolation: a scene, images of probes, or a container.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::args::Args;
use crate::refuse;
use crate::report::machine;
use codec::container::header::is_container;
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::memory::Need;
use codec::monitor::Monitor;
use epipolar::acquire::AcquireSettings;
use epipolar::captured::CapturedSources;
use epipolar::light_field::LightField;
use epipolar::memory::SourceNeed;
use epipolar::views::OutputViews;
use evaluate::reference::Reference;
use footage::dataset::manifest::{MANIFEST_NAME, is_dataset, manifest_path};
use footage::fingerprint::{digest, file_state};
use render::views::head_box::HeadBox;
use scene::{LightRays, Play, Scene, SceneAtTime};

/// Memory of code, stacks and tables.
const PROGRAM_BYTES: u64 = 32 << 20;

/// Memory of an open input.
pub(super) struct Loaded {
    pub bytes: u64,
    /// Part of `bytes` that loading freed.
    pub freed: u64,
}

pub(super) enum Input {
    Scene(Box<Scene>),
    /// Images of the selected probes.
    Images(Box<Reference>),
    /// Container, rendered at the positions of sources.
    Field(Box<Decoder>),
}

/// One frame of the input.
pub(super) enum FrameInput<'a> {
    Scene(Box<SceneAtTime>),
    Images(Box<CapturedSources>),
    Field(Box<LightField<'a>>),
}

impl Input {
    /// Opens the input. Notes list the omitted parts of a scene.
    pub fn open(args: &Args, notes: &mut Vec<String>) -> Result<Input> {
        let path = Path::new(&args.input);
        if !args.probe.is_empty() {
            return Ok(Input::Images(Box::new(Reference::open(path)?)));
        }
        if path.is_file() && is_container(path)? {
            return Ok(Input::Field(Box::new(Decoder::open(path)?)));
        }
        if is_dataset(path) {
            return refuse(format!(
                "{}: --eye needs a scene or container: select probes of a dataset with --probe, or encode it first: \
                lightfold encode {0} -o film.lfold",
                path.display()
            ));
        }
        let budget = args.memory.whole();
        let reading =
            |bytes: u64| Need { what: "reading the scene", fixed: bytes, each: 0, instead: "a smaller scene" };
        // The whole file is read.
        budget.at_once(&reading(path.metadata().map_or(0, |of| of.len())), 1)?;
        let (scene, of_scene) = Scene::open(&args.input, Play::All)?;
        notes.extend(of_scene.left_out);
        let scene = scene.subdivided(args.subdivide)?;
        budget.at_once(&reading(machine::peak_memory_bytes().unwrap_or(0)), 1)?;
        Ok(Input::Scene(Box::new(scene)))
    }

    /// Returns the files of the input; for a dataset those of all frames and kinds.
    pub fn files(&self, args: &Args) -> Vec<PathBuf> {
        let path = Path::new(&args.input);
        let mut files = match self {
            Input::Images(images) => images.all_files(),
            Input::Scene(_) | Input::Field(_) => Vec::new(),
        };
        files.extend([path.to_path_buf(), manifest_path(path)]);
        files
    }

    /// Returns an identifier of the contents. Files are identified by size and modification time.
    pub fn contents(&self, args: &Args) -> String {
        match self {
            Input::Scene(scene) => scene.contents().to_owned(),
            Input::Images(_) | Input::Field(_) => {
                let path = Path::new(&args.input);
                let states = [file_state(path), file_state(&path.join(MANIFEST_NAME))];
                digest(format!("{states:?} {:?}", args.probe).as_bytes())
            }
        }
    }

    /// Returns the memory of the input and the program, and that of the source views that are held at the same time.
    pub fn need(
        &self,
        args: &Args,
        views: &OutputViews,
        acquire: &AcquireSettings,
        monitor: &dyn Monitor,
    ) -> Result<(Loaded, SourceNeed)> {
        let resident = || machine::memory_bytes().unwrap_or(PROGRAM_BYTES);
        let all = || Loaded { bytes: resident(), freed: 0 };
        Ok(match self {
            Input::Images(_) => (all(), SourceNeed::images(args.probe.len() as u32)),
            Input::Field(_) => (all(), SourceNeed::images(args.max_sources)),
            Input::Scene(scene) => {
                // The animation data of a scene is held in memory as well.
                let is_still = scene.duration_s() == 0.0;
                let scene = scene.at(0.0);
                let need = SourceNeed::measured(&scene, views, acquire, monitor)?;
                // Memory freed by loading stays with the allocator. Views of this thread reuse it, other threads
                // hardly.
                let in_use = PROGRAM_BYTES + scene.bytes();
                let bytes = resident().max(in_use);
                let loaded = Loaded { bytes, freed: if is_still { bytes - in_use } else { 0 } };
                (loaded, if args.by_columns() { need.by_columns() } else { need })
            }
        })
    }

    /// Returns the frames of the input. `None` for a scene, which has all frames.
    fn available(&self, args: &Args) -> Result<Option<FrameRange>> {
        match self {
            Input::Scene(_) => Ok(None),
            Input::Images(images) => CapturedSources::frames(images, &args.probe, args.face).map(Some),
            Input::Field(decoder) => LightField::frames(decoder).map(Some),
        }
    }

    /// Returns the frames to interpolate: the requested ones, else the first of the input, with a note if there are
    /// more.
    pub fn frames(&self, args: &Args, notes: &mut Vec<String>) -> Result<FrameRange> {
        if let Some(asked) = args.frames.frames {
            return Ok(asked);
        }
        let available = self.available(args).map_err(|error| error.in_file(&args.input))?;
        let first = available.map_or(0, |available| available.first);
        if let Some(available) = available.filter(|available| available.count() > 1) {
            notes.push(format!("interpolating frame {first} of {available}; --frames selects others"));
        }
        Ok(FrameRange { first, last: first })
    }

    /// Fails if a dataset or a container lacks one of the frames.
    pub fn check_frames(&self, args: &Args, frames: FrameRange) -> Result<()> {
        let of_input = |error: Error| error.in_file(&args.input);
        match self {
            Input::Scene(_) => Ok(()),
            Input::Images(images) => {
                let check = |frame| CapturedSources::check_probes(images, &args.probe, args.face, frame);
                frames.iter().try_for_each(check).map_err(of_input)
            }
            Input::Field(decoder) => [frames.first, frames.last]
                .into_iter()
                .try_for_each(|frame| field(args, decoder, frame).map(drop))
                .map_err(of_input),
        }
    }

    /// Returns the output views. Those of images are relative to the captured views of a frame.
    pub fn views(&mut self, args: &Args, frame: u32) -> Result<OutputViews> {
        match self {
            Input::Images(images) => args.views_between(&captured(args, images, frame)?),
            Input::Scene(_) | Input::Field(_) => args.views_from_eye(),
        }
    }

    /// Returns a sentence about views outside the box around the probes; none for scenes.
    pub fn views_beyond_probes(&self, views: &OutputViews, frame: u32) -> Option<String> {
        let points: Vec<DVec3> = match self {
            Input::Scene(_) => return None,
            Input::Images(images) => {
                images.images.iter().flat_map(|image| image.cameras().map(|(_, camera)| camera.eye())).collect()
            }
            Input::Field(decoder) => {
                let place = |probe| DVec3::from_array(decoder.probe_at(probe, frame).position);
                (0..decoder.probes().len()).map(place).collect()
            }
        };
        let eyes = views.offsets_m.iter().map(|offset_m| views.eye(*offset_m));
        HeadBox::of(points)?.warning(eyes)
    }

    pub fn frame(&mut self, args: &Args, frame: u32) -> Result<FrameInput<'_>> {
        match self {
            Input::Scene(scene) => {
                let rays = LightRays { shadows: args.shadows, occlusion: args.ao_rays };
                let scene = scene.at(f64::from(frame) / args.fps).with_light_rays(rays);
                Ok(FrameInput::Scene(Box::new(scene)))
            }
            Input::Images(images) => captured(args, images, frame).map(|images| FrameInput::Images(Box::new(images))),
            Input::Field(decoder) => {
                let opened = field(args, decoder, frame);
                opened.map(|field| FrameInput::Field(Box::new(field))).map_err(|error| error.in_file(&args.input))
            }
        }
    }
}

/// Opens a frame of a container. Its samples form a square grid in each pixel.
fn field<'a>(args: &Args, decoder: &'a Decoder, frame: u32) -> Result<LightField<'a>> {
    let side = args.samples.isqrt();
    if side * side != args.samples {
        return refuse(format!(
            "--samples {}: containers need a square number of samples: use {} or {}",
            args.samples,
            side * side,
            (side + 1) * (side + 1)
        ));
    }
    LightField::open(decoder, frame, side, args.memory.get())
}

fn captured(args: &Args, images: &mut Reference, frame: u32) -> Result<CapturedSources> {
    CapturedSources::read(images, &args.probe, args.face, frame).map_err(|error| error.in_file(&args.input))
}
