//! Renders a scene that `simplify` wrote.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Instant;

use super::args::Args;
use super::options::{METHODS, Method, OF_LIGHT_FIELDS};
use super::pictures::{Job, pixels};
use super::report::{Figures, QuadFigures};
use super::subject::{JobRenderer, RenderedJob, Subject};
use super::truth::TruthRun;
use crate::options::word_of;
use crate::{GlobalArgs, refuse};
use codec::error::Result;
use codec::image::FrameRange;
use codec::image::transfer::ToneMap;
use codec::math::Camera;
use codec::memory::Need;
use codec::monitor::Monitor;
use evaluate::cameras::{self, ReadSettings};
use gpu::Gpu;
use gpu::quads::GpuQuads;
use render::march::memory::picture_bytes;
use scene::mesh::gltf::document::is_glb;
use simplify::raster::{Compositing, DrawSettings, Drawn, draw_picture, drawing_bytes};
use simplify::read_glb::{QuadScene, read_glb};

/// Default number of samples in each row and column of a pixel for z-buffer rendering: four steps of alpha.
const Z_BUFFER_SAMPLES: u32 = 2;

/// Frame rate of a scene, which is the same in all frames.
const STILL_FPS: f64 = 24.0;

/// True if a file is a mesh, by its extension or its first bytes.
pub fn is_scene(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let starts_as_glb = || {
        let mut bytes = [0; 4];
        let read = path.is_file().then(|| File::open(path).and_then(|mut file| file.read_exact(&mut bytes)));
        read.is_some_and(|read| read.is_ok()) && is_glb(&bytes)
    };
    ["glb", "gltf", "obj"].contains(&ending.as_str()) || starts_as_glb()
}

pub struct QuadSubject<'a> {
    args: &'a Args,
    scene: QuadScene,
    /// Camera of the file, if it has one.
    camera: Option<Camera>,
}

impl<'a> QuadSubject<'a> {
    pub fn open(args: &'a Args, input: &Path) -> Result<QuadSubject<'a>> {
        if let Some(option) = OF_LIGHT_FIELDS.iter().find(|option| args.given.names.iter().any(|name| name == *option))
        {
            return refuse(format!(
                "--{option} applies to light fields, and {} is a mesh: leave it out",
                input.display()
            ));
        }
        if args.projection.is_panorama() {
            return refuse(format!(
                "{}: simplified scenes support --projection perspective and cubemap only",
                input.display()
            ));
        }
        if let Some(method @ (Method::March | Method::Calf | Method::Splat | Method::Reproject)) = args.march.method {
            let word = word_of(METHODS, &method);
            return refuse(format!(
                "--method {word} renders containers, and {} is a mesh: use painter or z-buffer",
                input.display()
            ));
        }
        let scene = read_glb(input)?;
        let cameras = cameras::read(input, ReadSettings::with_fps(STILL_FPS)).map(|found| found.cameras);
        let camera = cameras.unwrap_or_default().first().map(|camera| camera.timed.camera);
        Ok(QuadSubject { args, scene, camera })
    }

    fn settings(&self) -> DrawSettings {
        let is_given = self.args.given.names.iter().any(|name| name == "samples");
        let samples = Some(self.args.march.samples).filter(|_| is_given);
        match self.method() {
            Method::ZBuffer => DrawSettings {
                size: [1, 1],
                compositing: Compositing::ZBuffer,
                samples: samples.unwrap_or(Z_BUFFER_SAMPLES),
            },
            _ => DrawSettings { size: [1, 1], compositing: Compositing::Painter, samples: samples.unwrap_or(1) },
        }
    }
}

impl Subject for QuadSubject<'_> {
    fn method(&self) -> Method {
        self.args.march.method.unwrap_or(Method::Painter)
    }

    fn frames(&self) -> Option<FrameRange> {
        None
    }

    fn fps(&self) -> f64 {
        STILL_FPS
    }

    fn reference_frames(&self, asked: Option<FrameRange>) -> Option<FrameRange> {
        asked.or(Some(FrameRange { first: self.scene.frame, last: self.scene.frame }))
    }

    fn own_camera(&self, _frame: u32) -> Result<(Camera, String)> {
        match self.camera {
            Some(camera) => Ok((camera, "rendering the view of the camera of the scene".to_owned())),
            None => refuse("no camera was given: use --eye and --look-at, or --camera with a camera file"),
        }
    }

    fn tone(&self) -> ToneMap {
        ToneMap::default()
    }

    fn check(&mut self, jobs: &[Job], _global: &GlobalArgs) -> Result<()> {
        let args = self.args;
        let pixels_of = |job: &Job| pixels(job.size).saturating_mul(job.request.cameras.len() as u64);
        let of_drawing =
            |job: &Job| drawing_bytes(&self.scene.quads, &DrawSettings { size: job.size, ..self.settings() });
        let max_pixels = jobs.iter().map(pixels_of).max().unwrap_or(0);
        let of_pictures = picture_bytes(max_pixels, false, args.truth.reference.is_some());
        let fixed = of_pictures.saturating_add(jobs.iter().map(of_drawing).max().unwrap_or(0));
        let need = Need { what: "rendering", fixed, each: 0, instead: "a smaller --size" };
        args.memory.get().at_once(&need, 1).map(|_| ())
    }

    fn renderer<'s>(&'s mut self, gpu: Option<&'s Gpu>) -> Result<Box<dyn JobRenderer + 's>> {
        let start = Instant::now();
        let on_device = gpu.map(|gpu| GpuQuads::new(gpu, &self.scene.quads)).transpose()?;
        let sending_ms = if gpu.is_some() { start.elapsed().as_secs_f64() * 1e3 } else { 0.0 };
        let figures = QuadFigures::of(self.scene.quads.mesh.triangles.len());
        Ok(Box::new(QuadRenderer { settings: self.settings(), scene: &self.scene, on_device, sending_ms, figures }))
    }
}

struct QuadRenderer<'s> {
    scene: &'s QuadScene,
    settings: DrawSettings,
    on_device: Option<GpuQuads<'s>>,
    /// Time to upload the scene. 0 after the first frame has reported it.
    sending_ms: f64,
    figures: QuadFigures,
}

impl QuadRenderer<'_> {
    fn draw(&self, camera: &Camera, monitor: &dyn Monitor) -> Result<Drawn> {
        match &self.on_device {
            Some(quads) => quads.draw(camera, &self.settings, monitor),
            None => draw_picture(&self.scene.quads, camera, &self.settings, monitor),
        }
    }
}

impl JobRenderer for QuadRenderer<'_> {
    fn render(&mut self, job: &Job, truth: Option<&mut TruthRun>, monitor: &dyn Monitor) -> Result<RenderedJob> {
        self.settings.size = job.size;
        let start = Instant::now();
        let drawn = job.request.cameras.iter().map(|camera| self.draw(camera, monitor)).collect::<Result<Vec<_>>>()?;
        let times_ms = [std::mem::take(&mut self.sending_ms), start.elapsed().as_secs_f64() * 1e3];
        let samples = pixels(job.size) * u64::from(self.settings.samples).pow(2);
        self.figures.add(&drawn, samples, times_ms);
        let compared = truth.map(|_| drawn.iter().map(|drawn| drawn.over_black(job.size)).collect::<Result<_>>());
        Ok(RenderedJob {
            near_silhouettes: Vec::new(),
            images: drawn.iter().map(|drawn| drawn.image(job.size)).collect::<Result<_>>()?,
            compared: compared.transpose()?,
            trace: None,
        })
    }

    fn figures(&self) -> Figures {
        Figures::Quads(self.figures.clone())
    }
}
