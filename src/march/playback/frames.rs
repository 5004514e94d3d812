//! Shows frames one after the other: which views, which units of them, what changed, pictures, and how long it took.
//!
//! Enters: an open container, requests ([`crate::evaluate::frame_requests`]), and what makes pictures. Leaves: pictures, a trace, figures.

use std::time::Instant;

use glam::DVec3;

use crate::decode::{AllUnits, Decoder};
use crate::error::{Error, Result};
use crate::evaluate::frame_requests::FrameRequest;
use crate::evaluate::rendered_image::HoleFill;
use crate::march::active_views::ActiveViews;
use crate::march::counters::Counters;
use crate::march::playback::pacing::{FramePacing, Pacing};
use crate::march::playback::selection::{SelectionSettings, ViewSelector};
use crate::march::playback::trace::{self, FrameTrace};
use crate::march::pyramid::Pyramids;
use crate::march::ray::Steps;
use crate::march::render::{Rendered, render};
use crate::march::settings::{Acceleration, EffectMode, RenderSettings};
use crate::math::Camera;
use crate::memory::Budget;
use crate::monitor::Monitor;
use crate::views::backend::{CpuBackend, TexelBackend};
use crate::views::catalogue::ProbeChoice;
use crate::views::light_field::LightField;
use crate::views::player::{Change, Player, ShowCounts, UnitRequest};
use crate::views::visible_set::VisibleSets;

/// Which units of the active views are decoded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DecodeScope {
    /// Those that the cameras see (CALF 6.2). With effects all materials, too, and where a weight of them is above 0 all
    /// units, as mirrors and glass send rays anywhere.
    #[default]
    Seen,
    /// All.
    All,
}

/// What is shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlaybackOptions {
    /// Which probes there are.
    pub probes: ProbeChoice,
    /// Which of them take part in a frame.
    pub selection: SelectionSettings,
    /// Which of their units are decoded.
    pub decode: DecodeScope,
}

/// How pictures are made, where near and far may be left to the light field.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Steps of a ray, at least 1.
    pub steps: u32,
    /// How often the interval before a hit is halved.
    pub refine: u32,
    /// Where rays begin, in metres; where it is not given, at a tenth of the nearest surface of any view.
    pub near_m: Option<f32>,
    /// Where rays end, in metres; where it is not given, beyond all that the views show.
    pub far_m: Option<f32>,
    /// Rays in each row and column of a pixel.
    pub samples: u32,
    /// What is shown in holes.
    pub holes: HoleFill,
    /// Whether mirrors and glass send rays on.
    pub effects: EffectMode,
    /// How often at most a ray is sent on.
    pub max_bounces: u32,
    /// How rays are marched.
    pub acceleration: Acceleration,
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
            holes: HoleFill::Blank,
            effects: EffectMode::Auto,
            max_bounces: 4,
            acceleration: Acceleration::Pyramid,
        }
    }
}

impl PictureOptions {
    /// The settings for these views.
    pub fn settings(&self, views: &ActiveViews<'_>) -> RenderSettings {
        let near_m = self.near_m.unwrap_or_else(|| views.near_m() / 10.0);
        let far_m = self.far_m.unwrap_or_else(|| views.far_m());
        RenderSettings {
            size: self.size,
            steps: Steps::new(self.steps, near_m, far_m, self.refine),
            samples: self.samples,
            holes: self.holes,
            effects: self.effects,
            max_bounces: self.max_bounces,
            acceleration: self.acceleration,
        }
    }
}

/// What a picture is made of.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'s> {
    /// The light field in this frame.
    pub field: &'s LightField,
    /// Its views that take part, first the most useful.
    pub views: &'s [usize],
}

/// What makes pictures: a processor, a device, or another method.
pub trait Renderer {
    /// Whether its mirrors and glass send rays on, which decides what is decoded.
    fn effects(&self) -> EffectMode;

    /// What decodes and keeps depth and colour, unless the CPU does; always the same.
    fn backend(&mut self) -> Option<&mut dyn TexelBackend> {
        None
    }

    /// Takes over what changed since it was called last, at first everything. Called once for each request, before its pictures.
    ///
    /// # Errors
    /// When the renderer has no room for it.
    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()>;

    /// Makes a picture. The monitor advances by one for each of its rows.
    ///
    /// # Errors
    /// When the monitor says to stop, or the renderer fails.
    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered>;
}

/// Renders on the processor.
#[derive(Debug, Clone, Default)]
pub struct CpuRenderer {
    /// How pictures are made.
    pub options: PictureOptions,
    pyramids: Pyramids,
}

impl CpuRenderer {
    /// A renderer to which nothing was shown yet.
    pub fn new(options: PictureOptions) -> CpuRenderer {
        CpuRenderer { options, pyramids: Pyramids::default() }
    }

    /// The pyramids of the light field that was shown last.
    pub fn pyramids(&self) -> &Pyramids {
        &self.pyramids
    }
}

impl Renderer for CpuRenderer {
    fn effects(&self) -> EffectMode {
        self.options.effects
    }

    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()> {
        self.pyramids.update(stage.field, changes);
        Ok(())
    }

    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views = ActiveViews::with_pyramids(stage.field, &self.pyramids, stage.views, camera.eye());
        render(&views, camera, &self.options.settings(&views), monitor)
    }
}

/// What came of a request.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// A picture for each camera.
    pub pictures: Vec<Rendered>,
    /// What it took to show the frame.
    pub counts: ShowCounts,
    /// Line for a trace file.
    pub trace: FrameTrace,
}

/// What came of all requests.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlaybackSummary {
    /// Shots.
    pub shots: usize,
    /// The most views that took part in one.
    pub most_views: usize,
    /// Rays.
    pub counters: Counters,
    /// Units and bytes.
    pub counts: ShowCounts,
    /// Times.
    pub pacing: FramePacing,
}

/// Shows a light field.
#[derive(Debug)]
pub struct Playback<'a> {
    player: Player<'a>,
    cpu: CpuBackend,
    visible_sets: VisibleSets<'a>,
    selector: ViewSelector,
    options: PlaybackOptions,
    summary: PlaybackSummary,
    update_ms: Vec<f64>,
    render_ms: Vec<f64>,
}

impl<'a> Playback<'a> {
    /// A playback of a container in which nothing was shown yet.
    ///
    /// # Errors
    /// As for [`Player::new`].
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
        })
    }

    /// The same, with at most so much memory for what is decoded and `beside_bytes` that are taken all the while.
    #[must_use]
    pub fn with_memory(self, budget: Budget, beside_bytes: u64) -> Playback<'a> {
        Playback { player: self.player.with_memory(budget, beside_bytes), ..self }
    }

    /// What shows the frames.
    pub fn player(&self) -> &Player<'a> {
        &self.player
    }

    /// Shows a request and makes its pictures.
    ///
    /// # Errors
    /// When the request has no camera, no probe has the frame, a chunk is damaged, the renderer fails, or the monitor says to
    /// stop.
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
        let eye = request.cameras.iter().map(Camera::eye).sum::<DVec3>() / request.cameras.len() as f64;
        let selection = self.selector.select(&self.player.candidates(request.frame), eye);
        let views = selection.views();
        let secondary_rays = renderer.effects() != EffectMode::None && self.player.has_material();
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
        let stage = Stage { field: self.player.field(), views: &views };
        renderer.update(&stage, &changes)?;
        let update_ms = start.elapsed().as_secs_f64() * 1e3;
        let start = Instant::now();
        let pictures = request
            .cameras
            .iter()
            .map(|camera| renderer.render(&stage, camera, monitor))
            .collect::<Result<Vec<_>>>()?;
        let render_ms = start.elapsed().as_secs_f64() * 1e3;
        self.selector.measured(update_ms + render_ms, views.len());
        let (active, culled) = trace::name(&selection, self.player.field());
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
        self.summary.most_views = self.summary.most_views.max(views.len());
        self.summary.counts = self.summary.counts.plus(counts);
        self.summary.counters = pictures.iter().fold(self.summary.counters, |sum, picture| sum.plus(picture.counters));
        Ok(Shown { pictures, counts, trace })
    }

    /// What came of all requests so far.
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
