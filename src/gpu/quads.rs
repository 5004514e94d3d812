//! Draws a simplified scene with the device's rasteriser, as `simplify::raster` does on the CPU (Seurat 6).
//!
//! Triangles are sent once, one batch per buffer, and drawn in order. A picture takes one pass per sample of a pixel. Colours
//! are blended as half floats; fragment counts are added in a second target.

use glam::DVec3;
use half::f16;

use crate::Gpu;
use crate::drawing::{
    self, COUNT_FORMAT, DEPTH_FORMAT, DrawingPipeline, LIGHT_FORMAT, Window, cleared, farthest_m, read_halves,
};
use codec::error::Result;
use codec::math::Camera;
use codec::monitor::Monitor;
use kernels::layout::{DrawnPicture, words_of};
use simplify::quad_mesh::QuadMesh;
use simplify::raster::{Compositing, DrawSettings, Drawn, Sample, light_of_codes, texture_coordinates};

/// Words per corner: position and homogeneous texture coordinates.
const CORNER_WORDS: usize = 6;
/// Triangles per batch: 72 MiB of corners.
const BATCH: usize = 1 << 20;
/// Half floats are exact only for counts below this.
const COUNT_LIMIT: u32 = 2048;

pub struct GpuQuads<'a> {
    gpu: &'a Gpu,
    painter: DrawingPipeline,
    z_buffer: DrawingPipeline,
    overdraw: DrawingPipeline,
    /// Corner buffers, and the number of corners in each.
    batches: Vec<(wgpu::Buffer, u32)>,
    light_of_codes: wgpu::Buffer,
    picture: wgpu::Buffer,
    atlas: wgpu::TextureView,
    /// Opposite corners of the scene's bounding box.
    bounds: [DVec3; 2],
}

/// Render targets of a pass.
struct Targets {
    light: wgpu::Texture,
    counts: wgpu::Texture,
    depth: Option<wgpu::Texture>,
}

impl<'a> GpuQuads<'a> {
    /// Uploads a scene to a device.
    pub fn new(gpu: &'a Gpu, scene: &QuadMesh) -> Result<GpuQuads<'a>> {
        let mesh = &scene.mesh;
        let texture = &scene.texture;
        let size = [texture.width, texture.height];
        if scene.light.is_some() {
            return Err(gpu.failed("atlas", "half floats are drawn on the CPU only"));
        }
        let atlas = drawing::texture(gpu, "atlas", size, wgpu::TextureFormat::Rgba8Uint)?;
        drawing::send(gpu, &atlas, &texture.pixels)?;
        let mut batches = Vec::new();
        for triangles in mesh.triangles.chunks(BATCH) {
            let mut words = Vec::with_capacity(3 * CORNER_WORDS * triangles.len());
            for &corner in triangles.as_flattened() {
                let stq = texture_coordinates(scene, corner).map(|part| part as f32);
                let position = mesh.positions[corner as usize].as_vec3().to_array();
                words.extend(position.into_iter().chain(stq).map(f32::to_bits));
            }
            batches.push((gpu.filled("corners", &words)?, 3 * triangles.len() as u32));
        }
        let corners = || mesh.positions.iter().copied();
        Ok(GpuQuads {
            gpu,
            painter: DrawingPipeline::new(gpu, &kernels::QUADS_PAINTER)?,
            z_buffer: DrawingPipeline::new(gpu, &kernels::QUADS_Z_BUFFER)?,
            overdraw: DrawingPipeline::new(gpu, &kernels::QUADS_OVERDRAW)?,
            batches,
            light_of_codes: gpu.filled("light_of_codes", &words_of(&light_of_codes()))?,
            picture: gpu.buffer("picture", DrawnPicture::WORDS, wgpu::BufferUsages::empty())?,
            atlas: drawing::array_view(&atlas),
            bounds: [corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max)],
        })
    }

    /// Draws the scene over a transparent background. The monitor advances by one per row.
    pub fn draw(&self, camera: &Camera, settings: &DrawSettings, monitor: &dyn Monitor) -> Result<Drawn> {
        let gpu = self.gpu;
        let [width, height] = settings.size;
        let is_z_buffer = settings.compositing == Compositing::ZBuffer;
        let texture = |label, format| drawing::texture(gpu, label, settings.size, format);
        let targets = Targets {
            light: texture("light", LIGHT_FORMAT)?,
            counts: texture("counts", COUNT_FORMAT)?,
            depth: is_z_buffer.then(|| texture("depth", DEPTH_FORMAT)).transpose()?,
        };
        let samples = settings.samples();
        let mut sums = vec![[0f32; 4]; width as usize * height as usize];
        let (mut fragments, mut max_fragments) = (0u64, 0u32);
        for sample in &samples {
            monitor.check()?;
            gpu.write("picture", &self.picture, &words_of(&[self.picture_of(camera, settings.size, sample)]))?;
            match settings.compositing {
                Compositing::Painter => self.pass(&self.painter, &[&targets.light, &targets.counts], None)?,
                Compositing::ZBuffer => {
                    self.pass(&self.z_buffer, &[&targets.light], targets.depth.as_ref())?;
                    self.pass(&self.overdraw, &[&targets.counts], None)?;
                }
            }
            let light = read_halves(gpu, &targets.light, 4)?;
            for (sum, light) in sums.iter_mut().zip(light.as_chunks::<4>().0) {
                *sum = std::array::from_fn(|channel| sum[channel] + light[channel].to_f32());
            }
            let counts = read_halves(gpu, &targets.counts, 1)?;
            let counts = || counts.iter().map(|&count| f16::to_f32(count) as u32);
            fragments += counts().map(u64::from).sum::<u64>();
            max_fragments = max_fragments.max(counts().max().unwrap_or(0));
        }
        if max_fragments >= COUNT_LIMIT {
            return Err(gpu.failed("counting", &format!("{COUNT_LIMIT} triangles or more lie over a pixel")));
        }
        let share = 1.0 / samples.len() as f32;
        monitor.advance(u64::from(height));
        Ok(Drawn { pixels: sums.iter().map(|sum| sum.map(|part| part * share)).collect(), fragments, max_fragments })
    }

    /// Draws all batches in one pass.
    fn pass(&self, drawing: &DrawingPipeline, targets: &[&wgpu::Texture], depth: Option<&wgpu::Texture>) -> Result<()> {
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (views, depth) = (targets.iter().map(|target| view(target)).collect::<Vec<_>>(), depth.map(view));
        let attachments: Vec<_> = views.iter().map(|view| cleared(view, wgpu::Color::TRANSPARENT)).collect();
        let depth_ops = wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard };
        let depth_stencil_attachment = depth.as_ref().map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(depth_ops),
            stencil_ops: None,
        });
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("quads"),
            color_attachments: &attachments,
            depth_stencil_attachment,
            ..wgpu::RenderPassDescriptor::default()
        };
        let groups = self.batches.iter().map(|(corners, _)| {
            drawing.bind(self.gpu, |name| match name {
                "picture" => Some(self.picture.as_entire_binding()),
                "corners" => Some(corners.as_entire_binding()),
                "light_of_codes" => Some(self.light_of_codes.as_entire_binding()),
                "atlas" => Some(wgpu::BindingResource::TextureView(&self.atlas)),
                _ => None,
            })
        });
        let groups = groups.collect::<Result<Vec<_>>>()?;
        self.gpu.submit("quads", |encoder| {
            let mut pass = encoder.begin_render_pass(&descriptor);
            pass.set_pipeline(&drawing.pipeline);
            for ((_, count), group) in self.batches.iter().zip(&groups) {
                pass.set_bind_group(0, group, &[]);
                pass.draw(0..*count, 0..1);
            }
        })
    }

    fn picture_of(&self, camera: &Camera, size: [u32; 2], sample: &Sample) -> DrawnPicture {
        let (eye, window) = (camera.eye(), camera.window());
        let depth_m = camera.depth_m().map(|metres| metres.min(f64::from(f32::MAX)) as f32);
        let tangents = [window.u, window.v];
        let window = Window { eye, axes: camera.axes(), tangents, size, sample: sample.offset };
        let picture = window.drawn(farthest_m(self.bounds, eye));
        DrawnPicture { near_m: depth_m[0], far_m: depth_m[1], threshold: sample.threshold, ..picture }
    }
}
