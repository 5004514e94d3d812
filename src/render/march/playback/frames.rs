//! Playback: selects views and units for each frame request, decodes, renders, and measures.
//!
//! Takes an open container, frame requests ([`crate::frame_requests`]) and a renderer. Returns rendered images, a
//! trace, and statistics.

use std::time::Instant;

use glam::DVec3;

use crate::frame_requests::FrameRequest;
use crate::march::aov::{AovKind, aovs};
use crate::march::columns::render_columns;
use crate::march::playback::pacing::{FramePacing, Pacing};
use crate::march::playback::selection::{SelectionSettings, ViewSelector};
use crate::march::playback::trace::{self, FrameTrace};
use crate::march::render::render;
use crate::march::{
    Acceleration, ActiveViews, Counters, Pyramids, Refinements, RenderSettings, Rendered, SpecularMode, Steps,
};
use crate::rendered_image::{BackgroundFill, HoleFill};
use crate::views::player::{Player, ShowCounts, UnitRequest};
use crate::views::visible_set::VisibleSets;
use crate::views::{Change, CpuBackend, LightField, ProbeChoice, TexelBackend};
use codec::decode::{AllUnits, Decoder};
use codec::error::{Error, Result};
use codec::image::Primaries;
use codec::math::Camera;
use codec::memory::Budget;
use codec::monitor::Monitor;

/// Units of the active views that are decoded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DecodeScope {
    /// The visible set (CALF 6.2). With secondary rays, all units if a material in it is specular, because such rays can go
    /// anywhere.
    #[default]
    Seen,
    All,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlaybackOptions {
    pub probes: ProbeChoice,
    pub selection: SelectionSettings,
    pub decode: DecodeScope,
}

/// Settings of rendered images. Near and far default to those of the light field.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Number of steps of a ray, at least 1.
    pub steps: u32,
    /// Number of bisections of the interval before a hit.
    pub refine: u32,
    /// Start of rays in metres; by default a tenth of the distance of the nearest surface of all views.
    pub near_m: Option<f32>,
    /// End of rays in metres; by default beyond all surfaces of the views.
    pub far_m: Option<f32>,
    /// See [`RenderSettings::samples`].
    pub samples: u32,
    pub holes: HoleFill,
    pub background: BackgroundFill,
    pub specular: SpecularMode,
    /// Maximum number of bounces of a ray.
    pub max_bounces: u32,
    pub acceleration: Acceleration,
    pub refinements: Refinements,
    /// Auxiliary planes to render; only the CPU supports them.
    pub aovs: Vec<AovKind>,
}

impl Default for PictureOptions {
    fn default() -> PictureOptions {
        PictureOptions {
            size: [512, 512],
            steps: 1024,
            refine: 8,
            near_m: None,
            far_m: None,
            samples: 1,
            holes: HoleFill::default(),
            background: BackgroundFill::default(),
            specular: SpecularMode::Auto,
            max_bounces: 4,
            acceleration: Acceleration::Pyramid,
            refinements: Refinements::default(),
            aovs: Vec::new(),
        }
    }
}

impl PictureOptions {
    pub fn settings(&self, views: &ActiveViews<'_>) -> RenderSettings {
        let near_m = self.near_m.unwrap_or_else(|| views.near_m() / 10.0);
        let far_m = self.far_m.unwrap_or_else(|| views.far_m());
        RenderSettings {
            size: self.size,
            steps: Steps::new(self.steps, near_m, far_m, self.refine),
            samples: self.samples,
            holes: self.holes,
            background: self.background,
            specular: self.specular,
            max_bounces: self.max_bounces,
            acceleration: self.acceleration,
            refinements: self.refinements,
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Stage<'s> {
    pub field: &'s LightField,
    /// Its active views, in order of priority.
    pub views: &'s [usize],
}

pub trait Renderer {
    /// Secondary rays of the renderer, which affect what is decoded.
    fn specular(&self) -> SpecularMode {
        SpecularMode::None
    }

    /// Returns the backend that decodes and keeps depth and colour, or none if the CPU does. Every call must return the same one.
    fn backend(&mut self) -> Option<&mut dyn TexelBackend> {
        None
    }

    /// Applies changes since the last call. Called once per frame request, before its images are rendered.
    fn update(&mut self, _stage: &Stage<'_>, _changes: &[Change]) -> Result<()> {
        Ok(())
    }

    /// Renders an image. The monitor advances by one per row.
    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered>;
}

#[derive(Debug, Clone, Default)]
pub struct CpuRenderer {
    pub options: PictureOptions,
    pyramids: Pyramids,
}

impl CpuRenderer {
    pub fn new(options: PictureOptions) -> CpuRenderer {
        CpuRenderer { options, pyramids: Pyramids::default() }
    }
}

impl Renderer for CpuRenderer {
    fn specular(&self) -> SpecularMode {
        self.options.specular
    }

    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()> {
        self.pyramids.update(stage.field, changes);
        Ok(())
    }

    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views_from = |eye| ActiveViews::with_pyramids(stage.field, &self.pyramids, stage.views, eye);
        let picture = |views: &ActiveViews<'_>, camera: &Camera, settings: &RenderSettings, monitor: &dyn Monitor| {
            let mut rendered = render(views, camera, settings, monitor)?;
            if !self.options.aovs.is_empty() {
                rendered.image.aovs = aovs(views, camera, settings, &self.options.aovs, monitor)?;
            }
            Ok(rendered)
        };
        let views = views_from(camera.eye());
        let settings = self.options.settings(&views);
        if !camera.has_moving_eye() {
            return picture(&views, camera, &settings, monitor);
        }
        // All columns use the steps computed from the middle of the eyes.
        let settings = RenderSettings { size: [settings.size[1], 1], ..settings };
        render_columns(self.options.size, camera, monitor, |camera, monitor| {
            picture(&views_from(camera.eye()), camera, &settings, monitor)
        })
    }
}

/// Returns the mean position of the cameras.
fn eye_of(request: &FrameRequest) -> DVec3 {
    request.cameras.iter().map(Camera::eye).sum::<DVec3>() / request.cameras.len().max(1) as f64
}

#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    pub pictures: Vec<Rendered>,
    pub counts: ShowCounts,
    pub trace: FrameTrace,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlaybackSummary {
    pub shots: usize,
    /// Maximum number of active views of one request.
    pub max_views: usize,
    pub counters: Counters,
    pub counts: ShowCounts,
    pub pacing: FramePacing,
}

#[derive(Debug)]
pub struct Playback<'a> {
    pub player: Player<'a>,
    cpu: CpuBackend,
    visible_sets: VisibleSets<'a>,
    selector: ViewSelector,
    options: PlaybackOptions,
    summary: PlaybackSummary,
    update_ms: Vec<f64>,
    render_ms: Vec<f64>,
    /// Primaries of the container's colours.
    primaries: Primaries,
}

impl<'a> Playback<'a> {
    pub fn new(decoder: &'a Decoder, options: PlaybackOptions) -> Result<Playback<'a>> {
        Ok(Playback {
            player: Player::new(decoder, &options.probes)?,
            cpu: CpuBackend,
            visible_sets: VisibleSets::new(decoder),
            selector: ViewSelector::new(options.selection),
            options,
            summary: PlaybackSummary::default(),
            update_ms: Vec::new(),
            render_ms: Vec::new(),
            primaries: decoder.primaries(),
        })
    }

    /// Returns the minimum bytes that suffice to show the views of each request.
    pub fn min_bytes<'r>(&self, requests: impl IntoIterator<Item = &'r FrameRequest>) -> u64 {
        let mut selector = ViewSelector::new(self.options.selection);
        let of_request = |request: &FrameRequest| {
            let selection = selector.select(&self.player.candidates(request.frame), eye_of(request));
            self.player.min_bytes(&selection.views())
        };
        requests.into_iter().map(of_request).max().unwrap_or(0)
    }

    /// Sets a memory budget, of which `beside_bytes` are used by others.
    pub fn limit_memory(&mut self, budget: Budget, beside_bytes: u64) {
        self.player.limit_memory(budget, beside_bytes);
    }

    pub fn show(
        &mut self,
        request: &FrameRequest,
        renderer: &mut dyn Renderer,
        monitor: &dyn Monitor,
    ) -> Result<Shown> {
        monitor.check()?;
        let start = Instant::now();
        if request.cameras.is_empty() {
            return Err(Error::Usage("a frame request needs at least one camera".into()));
        }
        let eye = eye_of(request);
        let selection = self.selector.select(&self.player.candidates(request.frame), eye);
        let views = selection.views();
        let secondary_rays = renderer.specular() != SpecularMode::None && self.player.has_material();
        let units = if self.options.decode == DecodeScope::All {
            UnitRequest { visible: &AllUnits, secondary_rays: false }
        } else {
            let streams = self.player.streams_of(request.frame, &views);
            let visible = self.visible_sets.find(&streams, &request.cameras);
            UnitRequest { visible, secondary_rays }
        };
        let backend = renderer.backend().unwrap_or(&mut self.cpu);
        let counts = self.player.show_on(request.frame, &views, units, backend)?;
        let changes = self.player.take_changes();
        let stage = Stage { field: &self.player.field, views: &views };
        renderer.update(&stage, &changes)?;
        let update_ms = start.elapsed().as_secs_f64() * 1e3;
        let start = Instant::now();
        let mut pictures = request
            .cameras
            .iter()
            .map(|camera| renderer.render(&stage, camera, monitor))
            .collect::<Result<Vec<_>>>()?;
        pictures.iter_mut().for_each(|picture| picture.image.primaries = self.primaries);
        let render_ms = start.elapsed().as_secs_f64() * 1e3;
        self.selector.measured(update_ms + render_ms, views.len());
        let (active, culled) = trace::name(&selection, &self.player.field);
        let trace = FrameTrace {
            shot: self.summary.shots,
            frame: request.frame,
            eye: eye.to_array(),
            active,
            culled,
            cells_decoded: counts.cells_decoded,
            cells_skipped: counts.cells_skipped(),
            bytes_read: counts.bytes_read,
            update_ms,
            render_ms,
        };
        self.update_ms.push(update_ms);
        self.render_ms.push(render_ms);
        self.summary.shots += 1;
        self.summary.max_views = self.summary.max_views.max(views.len());
        self.summary.counts = self.summary.counts + counts;
        self.summary.counters = pictures.iter().fold(self.summary.counters, |sum, picture| sum + picture.counters);
        Ok(Shown { pictures, counts, trace })
    }

    pub fn summary(&self) -> PlaybackSummary {
        let frame_ms: Vec<f64> = self.update_ms.iter().zip(&self.render_ms).map(|(a, b)| a + b).collect();
        let pacing = FramePacing {
            frame: Pacing::of(&frame_ms),
            update: Pacing::of(&self.update_ms),
            render: Pacing::of(&self.render_ms),
        };
        PlaybackSummary { pacing, ..self.summary }
    }
}
