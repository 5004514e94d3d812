//! Source views of a container: pictures rendered at the sources' positions, with the distances of their pixels.

use std::cell::RefCell;

use half::f16;

use super::args::Args;
use crate::refuse;
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::{FrameRange, Plane, ToneMap};
use codec::math::Camera;
use codec::monitor::Monitor;
use epipolar::acquire::{Places, hierarchical};
use epipolar::backend::Backend;
use epipolar::counters::Counters;
use epipolar::source::{SourceView, in_order};
use epipolar::views::OutputViews;
use render::frame_requests::FrameRequest;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions, Renderer, Stage};
use render::march::{ActiveViews, Rendered, distances_m};
use render::rendered_image::RenderedImage;
use render::views::Change;

/// A frame of a container.
pub(super) struct LightField<'a> {
    playback: RefCell<Playback<'a>>,
    frame: u32,
    options: PictureOptions,
}

impl<'a> LightField<'a> {
    /// Returns the frames of a container.
    pub fn frames(decoder: &'a Decoder) -> Result<FrameRange> {
        Ok(Playback::new(decoder, PlaybackOptions::default())?.player.frames())
    }

    pub fn open(args: &Args, decoder: &'a Decoder, frame: u32) -> Result<LightField<'a>> {
        let mut playback = Playback::new(decoder, PlaybackOptions::default())?;
        let frames = playback.player.frames();
        if !frames.contains(frame) {
            return Err(Error::Usage(format!("there is no frame {frame}: the container has {frames}")));
        }
        playback.limit_memory(args.memory.get(), 0);
        // Samples form a square grid in each pixel.
        let samples = args.samples.isqrt();
        if samples * samples != args.samples {
            return refuse(format!(
                "--samples {}: pixels of containers have as many rays across as down: choose {} or {}",
                args.samples,
                samples * samples,
                (samples + 1) * (samples + 1)
            ));
        }
        let options = PictureOptions { samples, ..PictureOptions::default() };
        Ok(LightField { playback: RefCell::new(playback), frame, options })
    }

    pub fn tone(&self) -> ToneMap {
        self.playback.borrow().player.field.coding.tone()
    }

    /// Returns the source views, sorted by position.
    pub fn sources(
        &self,
        views: &OutputViews,
        args: &Args,
        (backend, monitor): (&dyn Backend, &dyn Monitor),
    ) -> Result<(Vec<SourceView>, Counters)> {
        let make = |offsets_m: &[f64]| {
            let sources = offsets_m.iter().map(|&offset_m| self.source(views, offset_m, monitor));
            Ok((sources.collect::<Result<Vec<_>>>()?, Counters::default()))
        };
        let (sources, counters) = match args.acquire.places(views) {
            None => hierarchical(views, &args.hierarchy(), backend, make)?,
            Some(Places { offsets_m, is_wide: false }) => make(&offsets_m)?,
            Some(Places { offsets_m, is_wide: true }) => {
                let wide = offsets_m.iter().map(|&offset_m| self.wide_source(views, offset_m, monitor));
                (wide.collect::<Result<Vec<_>>>()?, Counters::default())
            }
        };
        let sources = in_order(sources);
        let counters = counters.of_sources(&sources);
        Ok((sources, counters))
    }

    /// Returns a source with additional columns on each side, as many as the disparities of its pixels require.
    fn wide_source(&self, views: &OutputViews, offset_m: f64, monitor: &dyn Monitor) -> Result<SourceView> {
        let narrow = self.source(views, offset_m, monitor)?;
        let pixels = narrow.rows.iter().flat_map(|row| &row.pixels);
        let moves = pixels.map(|pixel| views.columns_per_metre(f64::from(pixel.depth_m)).abs());
        match views.wider_columns(moves.fold(0.0, f64::max)) {
            0 => Ok(narrow),
            columns => Ok(self.source(&views.widened(columns)?, offset_m, monitor)?.moved_left(columns as i32)),
        }
    }

    fn source(&self, views: &OutputViews, offset_m: f64, monitor: &dyn Monitor) -> Result<SourceView> {
        let (image, distances_m) = self.show(views, offset_m, monitor)?;
        let camera = views.camera(offset_m)?;
        let [width, height] = views.size.map(f64::from);
        let forward = camera.axes()[0];
        Ok(SourceView::of_image(offset_m, views.size, |column, row| {
            let at = [(f64::from(column) + 0.5) / width, (f64::from(row) + 0.5) / height];
            let planar_m = f64::from(distances_m.get(column, row)) * camera.direction(at).dot(forward);
            let light = image.color.get(column, row).map(f16::from_f32);
            // A pixel that no probe saw is unknown.
            (image.alpha.get(column, row) >= 0.5).then_some((planar_m as f32, light))
        }))
    }

    /// Returns the picture at a position.
    pub fn picture(&self, views: &OutputViews, offset_m: f64, monitor: &dyn Monitor) -> Result<RenderedImage> {
        self.show(views, offset_m, monitor).map(|(image, _)| image)
    }

    fn show(&self, views: &OutputViews, offset_m: f64, monitor: &dyn Monitor) -> Result<(RenderedImage, Plane<f32>)> {
        let request = FrameRequest { frame: self.frame, cameras: vec![views.camera(offset_m)?] };
        let options = PictureOptions { size: views.size, ..self.options.clone() };
        let mut renderer = WithDistances { renderer: CpuRenderer::new(options), distances_m: None };
        let shown = self.playback.borrow_mut().show(&request, &mut renderer, &Checked(monitor))?;
        let picture = shown.pictures.into_iter().next();
        // Interpolation expects Rec. 709 primaries.
        let both = picture.map(|picture| picture.image.into_rec709()).zip(renderer.distances_m);
        both.ok_or_else(|| Error::invalid("a picture without distances"))
    }
}

/// Renders pictures on the CPU, and keeps the distances of the last picture.
struct WithDistances {
    renderer: CpuRenderer,
    distances_m: Option<Plane<f32>>,
}

impl Renderer for WithDistances {
    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()> {
        self.renderer.update(stage, changes)
    }

    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views = ActiveViews::new(stage.field, stage.views, camera.eye());
        let settings = self.renderer.options.settings(&views);
        self.distances_m = Some(distances_m(&views, camera, &settings, monitor)?);
        self.renderer.render(stage, camera, monitor)
    }
}

/// Reports interruption by another monitor, but no steps to it.
struct Checked<'a>(&'a dyn Monitor);

impl Monitor for Checked<'_> {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        self.0.interrupted()
    }
}
