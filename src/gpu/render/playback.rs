//! Playback on a graphics device: changes are sent once per frame request, for all its cameras. The device decodes depth and
//! colour if it can and decoding is enabled. The CPU decodes materials and half floats, and everything for containers with
//! alpha and for rendering with secondary rays.

use glam::DVec3;

use crate::Gpu;
use crate::render::backend::{GpuBackend, can_decode};
use crate::render::scene::ImageId;
use crate::render::{GpuRenderer, RenderCost};
use codec::decode::Decoder;
use codec::error::Result;
use codec::image::StreamKind;
use codec::math::Camera;
use codec::monitor::Monitor;
use codec::streams::CodecHeader;
use render::march::{ActiveViews, PictureOptions, Pyramids, Rendered, Renderer, SpecularMode, Stage};
use render::views::{Change, ColorCoding, TexelBackend};

pub struct DeviceRenderer<'a> {
    pub options: PictureOptions,
    gpu: &'a Gpu,
    pyramids: Pyramids,
    /// Created for the first frame request.
    pub renderer: Option<GpuRenderer<'a>>,
}

impl<'a> DeviceRenderer<'a> {
    pub fn new(gpu: &'a Gpu, options: PictureOptions) -> DeviceRenderer<'a> {
        DeviceRenderer { options, gpu, pyramids: Pyramids::default(), renderer: None }
    }

    /// Enables decoding on the device if it can decode the container. `coding` is the colour coding of the light field. With
    /// secondary rays the CPU decodes, because it fits refractive spheres to the texels.
    #[must_use]
    pub fn decoding(self, decoder: &'a Decoder, coding: ColorCoding) -> DeviceRenderer<'a> {
        let gpu = self.gpu;
        let has_material = decoder.streams().iter().any(|stream| stream.kind == StreamKind::Material);
        let is_apart = self.options.specular == SpecularMode::None || !has_material;
        let renderer = (is_apart && can_decode(decoder, gpu.info.max_binding_bytes))
            .then(|| GpuRenderer { backend: Some(GpuBackend::new(gpu, decoder)), ..GpuRenderer::new(gpu, coding) });
        DeviceRenderer { renderer, ..self }
    }

    /// As [`Self::decoding`], except for containers with entropy-coded colour: a device decodes each region with one
    /// invocation. An update of nine cubes of 128x128 pixels took 26 ms on an NVIDIA H200, and 3.5 ms when its host decoded and
    /// sent everything.
    #[must_use]
    pub fn decoding_unless_entropy_coded(self, decoder: &'a Decoder, coding: ColorCoding) -> DeviceRenderer<'a> {
        let is_entropy_coded =
            |header: &CodecHeader| matches!(header, CodecHeader::Color(color) if color.tables().is_some());
        if decoder.streams().iter().any(|stream| is_entropy_coded(&stream.header)) {
            return self;
        }
        self.decoding(decoder, coding)
    }

    pub fn decodes(&self) -> bool {
        self.renderer.as_ref().is_some_and(|renderer| renderer.backend.is_some())
    }

    pub fn gpu_backend(&mut self) -> Option<&mut GpuBackend<'a>> {
        self.renderer.as_mut()?.backend.as_mut()
    }

    pub fn cost(&self) -> RenderCost {
        self.renderer.as_ref().map(GpuRenderer::cost).unwrap_or_default()
    }
}

impl Renderer for DeviceRenderer<'_> {
    fn specular(&self) -> SpecularMode {
        self.options.specular
    }

    fn backend(&mut self) -> Option<&mut dyn TexelBackend> {
        self.gpu_backend().map(|backend| backend as &mut dyn TexelBackend)
    }

    fn update(&mut self, stage: &Stage<'_>, changes: &[Change]) -> Result<()> {
        self.pyramids.update(stage.field, changes);
        let renderer = self.renderer.get_or_insert_with(|| GpuRenderer::new(self.gpu, stage.field.coding));
        for change in changes {
            let probe = stage.field.views[change.view].probe;
            renderer.texels.change(ImageId { probe, face: change.face }, change.kind, change.rect);
        }
        // The set of needed texels does not depend on the eye.
        renderer.upload(&ActiveViews::with_pyramids(stage.field, &self.pyramids, stage.views, DVec3::ZERO))
    }

    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views = ActiveViews::with_pyramids(stage.field, &self.pyramids, stage.views, camera.eye());
        let settings = self.options.settings(&views);
        let renderer = self.renderer.get_or_insert_with(|| GpuRenderer::new(self.gpu, stage.field.coding));
        renderer.render(&views, camera, &settings, monitor)
    }
}
