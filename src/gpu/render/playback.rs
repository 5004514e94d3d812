//! Playback on a graphics device: what changed goes there once for each shot, and all its cameras see it. The device decodes
//! depth and colour itself where it can; materials, what has half floats, and what mirrors and glass show, the CPU decodes.

use glam::DVec3;

use crate::dataset::stream::StreamKind;
use crate::decode::Decoder;
use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::render::units::{DeviceUnits, can_decode};
use crate::gpu::render::{GpuRenderer, RenderCost};
use crate::march::active_views::ActiveViews;
use crate::march::playback::frames::{PictureOptions, Renderer, Stage};
use crate::march::pyramid::Pyramids;
use crate::march::render::Rendered;
use crate::march::settings::EffectMode;
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::views::light_field::ColorCoding;
use crate::views::player::Change;
use crate::views::units_on_device::UnitsOnDevice;

/// Makes the pictures of a playback on a device.
#[derive(Debug)]
pub struct DeviceRenderer<'a> {
    /// How pictures are made.
    pub options: PictureOptions,
    gpu: &'a Gpu,
    pyramids: Pyramids,
    /// Made for the first shot, when it is known what there is.
    renderer: Option<GpuRenderer<'a>>,
}

impl<'a> DeviceRenderer<'a> {
    /// A renderer to which no shot was shown yet.
    pub fn new(gpu: &'a Gpu, options: PictureOptions) -> DeviceRenderer<'a> {
        DeviceRenderer { options, gpu, pyramids: Pyramids::default(), renderer: None }
    }

    /// The same, where the device decodes depth and colour of the container that is shown, if it can. `coding` is that of the
    /// light field. Where mirrors and glass may send rays on, the CPU decodes: it looks for balls of glass in the texels.
    #[must_use]
    pub fn decoding(self, decoder: &'a Decoder, coding: ColorCoding) -> DeviceRenderer<'a> {
        let gpu = self.gpu;
        let has_material = decoder.streams().iter().any(|stream| stream.kind == StreamKind::Material);
        let is_apart = self.options.effects == EffectMode::None || !has_material;
        let renderer = (is_apart && can_decode(decoder, gpu.info.max_binding_bytes))
            .then(|| GpuRenderer::decoding(gpu, coding, DeviceUnits::new(gpu, decoder)));
        DeviceRenderer { renderer, ..self }
    }

    /// Whether the device decodes depth and colour.
    pub fn decodes(&self) -> bool {
        self.renderer.as_ref().is_some_and(GpuRenderer::decodes)
    }

    /// What decodes depth and colour, where the CPU does not.
    pub fn device_units(&mut self) -> Option<&mut DeviceUnits<'a>> {
        self.renderer.as_mut().and_then(GpuRenderer::units)
    }

    /// The renderer, once there is one.
    pub fn gpu_renderer(&self) -> Option<&GpuRenderer<'a>> {
        self.renderer.as_ref()
    }

    /// What it has cost so far.
    pub fn cost(&self) -> RenderCost {
        self.renderer.as_ref().map(GpuRenderer::cost).unwrap_or_default()
    }
}

impl Renderer for DeviceRenderer<'_> {
    fn effects(&self) -> EffectMode {
        self.options.effects
    }

    fn units(&mut self) -> Option<&mut dyn UnitsOnDevice> {
        self.device_units().map(|units| units as &mut dyn UnitsOnDevice)
    }

    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()> {
        self.pyramids.update(stage.field, changes);
        let renderer = self.renderer.get_or_insert_with(|| GpuRenderer::new(self.gpu, stage.field));
        for change in changes {
            let probe = stage.field.views[change.view].probe;
            renderer.change(probe, change.face, change.kind, change.rect);
        }
        // Which texels lie on the device does not depend on the eye.
        renderer.bring(&ActiveViews::with_pyramids(stage.field, &self.pyramids, stage.views, DVec3::ZERO))
    }

    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views = ActiveViews::with_pyramids(stage.field, &self.pyramids, stage.views, camera.eye());
        let settings = self.options.settings(&views);
        let renderer = self.renderer.get_or_insert_with(|| GpuRenderer::new(self.gpu, stage.field));
        renderer.render(&views, camera, &settings, monitor)
    }
}
