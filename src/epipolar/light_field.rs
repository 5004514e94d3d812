//! Source views of a container: pictures rendered at the sources' positions, with the distances of their pixels.

use std::cell::RefCell;

use half::f16;

use crate::acquire::{Acquisition, Hierarchy, Places, hierarchical};
use crate::backend::Backend;
use crate::counters::Counters;
use crate::source::{SourceView, in_order};
use crate::views::OutputViews;
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::{FrameRange, Plane, ToneMap};
use codec::math::Camera;
use codec::memory::Budget;
use codec::monitor::Monitor;
use render::frame_requests::FrameRequest;
use render::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions, Renderer, Stage};
use render::march::{ActiveViews, Rendered, distances_m};
use render::rendered_image::RenderedImage;
use render::views::Change;

/// A frame of a container.
pub struct LightField<'a> {
    playback: RefCell<Playback<'a>>,
    frame: u32,
    options: PictureOptions,
}

impl<'a> LightField<'a> {
    /// Returns the frames of a container.
    pub fn frames(decoder: &'a Decoder) -> Result<FrameRange> {
        Ok(Playback::new(decoder, PlaybackOptions::default())?.player.frames())
    }

    /// Opens a frame of a container, of which pictures have `side * side` rays per pixel. Fails if the container has no such frame.
    pub fn open(decoder: &'a Decoder, frame: u32, side: u32, budget: Budget) -> Result<LightField<'a>> {
        let mut playback = Playback::new(decoder, PlaybackOptions::default())?;
        let frames = playback.player.frames();
        if !frames.contains(frame) {
            return Err(Error::Usage(format!("there is no frame {frame}: the container has {frames}")));
        }
        playback.limit_memory(budget, 0);
        let options = PictureOptions { samples: side, ..PictureOptions::default() };
        Ok(LightField { playback: RefCell::new(playback), frame, options })
    }

    pub fn tone(&self) -> ToneMap {
        self.playback.borrow().player.field.coding.tone()
    }

    /// Returns the source views, sorted by position.
    pub fn sources(
        &self,
        views: &OutputViews,
        acquisition: Acquisition,
        hierarchy: &Hierarchy,
        backend: &dyn Backend,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<SourceView>, Counters)> {
        let make = |offsets_m: &[f64]| {
            let sources = offsets_m.iter().map(|&offset_m| self.source(views, offset_m, monitor));
            Ok((sources.collect::<Result<Vec<_>>>()?, Counters::default()))
        };
        let (sources, counters) = match acquisition.places(views) {
            None => hierarchical(views, hierarchy, backend, make)?,
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
