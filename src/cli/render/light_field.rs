//! Renders a light field by ray marching, on the CPU or a device, or with the methods it is compared with.

use std::path::Path;

use glam::DVec3;

use super::args::Args;
use super::options::{METHODS, Method};
use super::pictures::{Job, pixels};
use super::report::{Figures, Frames, LightFieldFigures};
use super::subject::{JobRenderer, RenderedJob, Subject};
use super::truth::TruthRun;
use crate::options::word_of;
use crate::{GlobalArgs, refuse};
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::transfer::ToneMap;
use codec::image::{Face, FrameRange, StreamKind};
use codec::math::Camera;
use codec::memory::Need;
use codec::monitor::Monitor;
use codec::streams::StreamInfo;
use evaluate::reference::upright_camera;
use footage::export::FileFormat;
use gpu::Gpu;
use gpu::render::playback::DeviceRenderer;
use render::march::active_views::ActiveViews;
use render::march::aov::AovKind;
use render::march::baseline::reproject::ReprojectRenderer;
use render::march::baseline::splat::SplatRenderer;
use render::march::memory::{JOINED_BYTES, march_bytes, picture_bytes, splat_bytes};
use render::march::playback::frames::{CpuRenderer, DecodeScope, PictureOptions, Playback, PlaybackOptions, Renderer};
use render::march::playback::selection::SelectionSettings;
use render::march::settings::{Refinements, SpecularMode};
use render::march::silhouettes::near_silhouettes;
use render::rendered_image::BackgroundFill;
use render::views::View;
use render::views::catalogue::ProbeChoice;
use render::views::head_box::HeadBox;

const SHEET_BYTES: u64 = 1 << 20;
const RENDERED_INSTEAD: &str = "a smaller --size or fewer `views`";

pub struct LightFieldSubject<'a> {
    args: &'a Args,
    input: &'a Path,
    decoder: &'a Decoder,
    playback: Playback<'a>,
}

impl<'a> LightFieldSubject<'a> {
    pub fn open(args: &'a Args, input: &'a Path, decoder: &'a Decoder) -> Result<LightFieldSubject<'a>> {
        let playback = Playback::new(decoder, args.playback_options()).map_err(|error| error.in_file(input))?;
        Ok(LightFieldSubject { args, input, decoder, playback })
    }

    /// Fails if --far is nearer than the default --near.
    fn check_far(&self, job: &Job) -> Result<()> {
        let march = &self.args.march;
        let (Some(far_m), None, Some(camera)) = (march.far, march.near, job.request.cameras.first()) else {
            return Ok(());
        };
        let field = &self.playback.player.field;
        let all: Vec<usize> = (0..field.views.len()).collect();
        let near_m = ActiveViews::new(field, &all, camera.eye()).near_m() / 10.0;
        if f64::from(near_m) < far_m {
            return Ok(());
        }
        refuse(format!("--far {far_m} is below the default of --near, {near_m}: set --near, or increase --far"))
    }

    fn bytes_beside_views(&self, jobs: &[Job]) -> Result<u64> {
        let args = self.args;
        let pixels_of = |job: &Job| pixels(job.size).saturating_mul(job.request.cameras.len() as u64);
        let max_pixels = jobs.iter().map(pixels_of).max().unwrap_or(0);
        let sheet = if args.contact_sheet.is_some() { jobs.len() as u64 * SHEET_BYTES } else { 0 };
        let of_method = match self.method() {
            Method::Splat => splat_bytes(self.decoder),
            Method::Reproject => 0,
            _ => march_bytes(self.decoder, &args.playback_options(), args.march.effects),
        };
        let of_pictures = picture_bytes(max_pixels, !args.march.aov.is_empty(), args.truth.reference.is_some())
            .saturating_add(sheet)
            .saturating_add(if jobs.iter().any(|job| job.request.cameras.len() > 1) {
                max_pixels.saturating_mul(JOINED_BYTES)
            } else {
                0
            });
        let fixed = of_pictures.saturating_add(of_method);
        let views = self.playback.min_bytes(jobs.iter().map(|job| &job.request));
        let need = Need { what: "rendering", fixed: fixed.saturating_add(views), each: 0, instead: RENDERED_INSTEAD };
        args.memory.get().at_once(&need, 1)?;
        Ok(fixed)
    }
}

impl Subject for LightFieldSubject<'_> {
    fn method(&self) -> Method {
        self.args.march.method.unwrap_or(Method::March)
    }

    fn frames(&self) -> Option<FrameRange> {
        Some(self.playback.player.frames())
    }

    fn fps(&self) -> f64 {
        self.decoder.reader().index().fps
    }

    /// Returns the camera of face nz of the first probe, or of its perspective image.
    fn own_camera(&self, frame: u32) -> Result<(Camera, String)> {
        let probe = self.playback.player.field.views.first().map(|view| view.probe);
        let images = || {
            let of_probe = |stream: &&StreamInfo| Some(stream.probe) == probe && stream.kind == StreamKind::Color;
            self.decoder.streams().iter().filter(of_probe)
        };
        let ahead = images().find(|stream| stream.face == Face::Nz).or_else(|| images().next());
        let image =
            ahead.ok_or_else(|| Error::Usage("no camera was given, and no probe has colour and depth".into()))?;
        let face = if image.face == Face::View { String::new() } else { format!(", face {}", image.face.name()) };
        let words = format!("rendering the view of probe {}{face}", self.decoder.probe(image).name);
        Ok((upright_camera(self.decoder, image, frame)?, words))
    }

    fn tone(&self) -> ToneMap {
        self.playback.player.field.coding.tone()
    }

    fn check(&mut self, jobs: &[Job], global: &GlobalArgs) -> Result<()> {
        let march = &self.args.march;
        if !self.method().marches() && (march.samples != 1 || march.effects == SpecularMode::Force) {
            let method = word_of(METHODS, &self.method());
            global.note(format_args!("--method {method} ignores --samples and --effects"));
        }
        let views = || self.playback.player.field.views.iter();
        // Probes may move: the box is around those of all rendered frames, as in the player.
        let places = jobs.iter().flat_map(|job| {
            views().map(|view| DVec3::from_array(self.decoder.probe_at(view.probe, job.request.frame).position))
        });
        let field = HeadBox::of(places);
        let eyes = jobs.iter().flat_map(|job| &job.request.cameras).map(Camera::eye);
        // With a reference, the eyes are those of its probes.
        if let Some(warning) =
            field.and_then(|field| field.warning(eyes)).filter(|_| self.args.truth.reference.is_none())
        {
            global.note(warning);
        }
        let beside_bytes = self.bytes_beside_views(jobs)?;
        self.playback.limit_memory(self.args.memory.get(), beside_bytes);
        jobs.iter().try_for_each(|job| self.check_far(job))
    }

    fn renderer<'s>(&'s mut self, gpu: Option<&'s Gpu>) -> Result<Box<dyn JobRenderer + 's>> {
        let options = self.args.picture_options();
        let method = match (self.method(), gpu) {
            (Method::Splat, _) => MethodRenderer::Splat(SplatRenderer { options }),
            (Method::Reproject, _) => {
                MethodRenderer::Reproject(ReprojectRenderer { options, ..ReprojectRenderer::default() })
            }
            (_, Some(gpu)) => {
                let coding = self.playback.player.field.coding;
                MethodRenderer::Device(Box::new(
                    DeviceRenderer::new(gpu, options).decoding_unless_entropy_coded(self.decoder, coding),
                ))
            }
            (_, None) => MethodRenderer::March(CpuRenderer::new(options)),
        };
        Ok(Box::new(LightFieldRenderer {
            input: self.input,
            playback: &mut self.playback,
            method,
            frames: Frames::default(),
        }))
    }
}

struct LightFieldRenderer<'s, 'a> {
    input: &'s Path,
    playback: &'s mut Playback<'a>,
    method: MethodRenderer<'s>,
    frames: Frames,
}

impl JobRenderer for LightFieldRenderer<'_, '_> {
    fn render(&mut self, job: &Job, truth: Option<&mut TruthRun>, monitor: &dyn Monitor) -> Result<RenderedJob> {
        let is_compared = truth.is_some();
        let renderer = self.method.prepare(job, truth)?;
        let named = |error: Error| error.in_file(self.input);
        let shown = self.playback.show(&job.request, renderer, monitor).map_err(named)?;
        self.frames.add(&shown.trace);
        let is_active = |view: &&View| shown.trace.active.iter().any(|active| active.probe == view.name);
        let active: Vec<&View> = self.playback.player.field.views.iter().filter(is_active).collect();
        let near = |camera| near_silhouettes(&active, camera, job.size);
        let compared = if is_compared { &job.request.cameras[..] } else { &[] };
        Ok(RenderedJob {
            near_silhouettes: compared.iter().map(near).collect::<Result<_>>()?,
            images: shown.pictures.into_iter().map(|picture| picture.image).collect(),
            compared: None,
            trace: Some(shown.trace),
        })
    }

    fn figures(&self) -> Figures {
        let (gpu_cost, decoded_on) = match &self.method {
            MethodRenderer::Device(renderer) => {
                (Some(renderer.cost()), if renderer.decodes() { "device" } else { "cpu" })
            }
            _ => (None, "cpu"),
        };
        let (summary, frames) = (self.playback.summary(), self.frames.clone());
        Figures::LightField(Box::new(LightFieldFigures { summary, frames, gpu_cost, decoded_on }))
    }
}

enum MethodRenderer<'g> {
    March(CpuRenderer),
    Device(Box<DeviceRenderer<'g>>),
    Splat(SplatRenderer),
    Reproject(ReprojectRenderer),
}

impl MethodRenderer<'_> {
    fn prepare(&mut self, job: &Job, truth: Option<&mut TruthRun>) -> Result<&mut dyn Renderer> {
        let options = match self {
            MethodRenderer::March(renderer) => &mut renderer.options,
            MethodRenderer::Device(renderer) => &mut renderer.options,
            MethodRenderer::Splat(renderer) => &mut renderer.options,
            MethodRenderer::Reproject(renderer) => &mut renderer.options,
        };
        options.size = job.size;
        if let (MethodRenderer::Reproject(renderer), Some(truth)) = (&mut *self, truth) {
            renderer.distances_m = truth.distances(job)?;
        }
        Ok(match self {
            MethodRenderer::March(renderer) => renderer,
            MethodRenderer::Device(renderer) => renderer.as_mut(),
            MethodRenderer::Splat(renderer) => renderer,
            MethodRenderer::Reproject(renderer) => renderer,
        })
    }
}

impl Args {
    /// Fails if an option does not apply to light fields.
    pub fn check_container(&self) -> Result<()> {
        if let (Some(near), Some(far)) = (self.march.near, self.march.far)
            && near >= far
        {
            return refuse(format!("--near {near} must be below --far {far}"));
        }
        let choice = &self.views;
        if !choice.probe.is_empty() && choice.probe.iter().all(|name| choice.exclude_probe.contains(name)) {
            return refuse("--exclude-probe excludes all probes of --probe");
        }
        if self.march.background == BackgroundFill::Transparent && self.truth.reference.is_some() {
            return refuse("--background transparent cannot be compared with --reference: leave out one of them");
        }
        if !self.march.aov.is_empty() {
            if self.is_on_device() {
                return refuse("--aov is rendered on the CPU only: leave out --device");
            }
            if self.output.as_deref().is_none_or(|path| FileFormat::of(path) != Some(FileFormat::Exr)) {
                return refuse("--aov adds channels to EXR images: use an output ending in .exr");
            }
        }
        let Some(method) = self.march.method else { return Ok(()) };
        let word = word_of(METHODS, &method);
        if matches!(method, Method::Painter | Method::ZBuffer) {
            return refuse(format!(
                "--method {word} draws simplified scenes (.glb); march, calf, splat and reproject render containers"
            ));
        }
        if !method.marches() && self.is_on_device() {
            return refuse(format!("--method {word} runs on the CPU only: leave out --device"));
        }
        if !method.marches() && self.projection.is_panorama() {
            return refuse(format!("--method {word} draws perspective pictures only: use march or calf for panoramas"));
        }
        if !method.marches() && !self.march.aov.is_empty() {
            return refuse(format!("--method {word} does not support --aov: use march or calf"));
        }
        Ok(())
    }

    fn playback_options(&self) -> PlaybackOptions {
        let views = &self.views;
        PlaybackOptions {
            probes: ProbeChoice {
                only: views.probe.clone(),
                without: views.exclude_probe.clone(),
                no_materials: self.march.effects == SpecularMode::None,
            },
            selection: SelectionSettings {
                priority: views.view_priority,
                pivot: views.pivot,
                cull_angle_deg: (views.cull_angle > 0.0).then_some(views.cull_angle),
                most: views.views.map(|views| views as usize),
                target_ms: views.target_ms,
            },
            // Normals are fitted to texels around those that pictures show.
            decode: if self.march.aov.contains(&AovKind::Normal) { DecodeScope::All } else { views.decode },
        }
    }

    fn picture_options(&self) -> PictureOptions {
        let march = &self.march;
        PictureOptions {
            size: [1, 1],
            steps: march.steps,
            refine: march.refine,
            near_m: march.near.map(|metres| metres as f32),
            far_m: march.far.map(|metres| metres as f32),
            samples: march.samples,
            holes: march.holes,
            background: march.background,
            specular: march.effects,
            max_bounces: march.max_bounces,
            acceleration: march.acceleration,
            refinements: if march.method == Some(Method::Calf) { Refinements::NONE } else { march.refinements },
            aovs: march.aov.clone(),
        }
    }
}
