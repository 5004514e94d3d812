//! Draws a simplified scene by the rasteriser of a device, as `simplify::raster` does on the CPU (Seurat 6).
//!
//! Triangles are sent once, a batch in each buffer, and drawn in their order. A picture is a pass for each sample of a pixel. Light is
//! blended as half floats, counts of fragments are added in another target of the same pass.

use glam::DVec3;
use half::f16;

use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::drawing::{self, COUNT_FORMAT, DEPTH_FORMAT, DrawingPipeline, LIGHT_FORMAT, read_halves};
use crate::gpu::kernels;
use crate::gpu::layout::{QuadPicture, words_of};
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::simplify::quad_mesh::QuadMesh;
use crate::simplify::raster::{Compositing, DrawSettings, Drawn, Sample, light_of_codes, texture_coordinates};

/// Words of a corner: position and homogeneous texture coordinates.
const CORNER_WORDS: usize = 6;
/// Triangles of a batch: 72 MiB of corners.
const BATCH: usize = 1 << 20;
/// The least depth that is drawn, in parts of the greatest distance of a corner: the CPU has none.
const NEAREST: f64 = 1e-7;
/// Counts from here on are not exact as half floats.
const COUNT_LIMIT: u32 = 2048;

pub struct GpuQuads<'a> {
    gpu: &'a Gpu,
    painter: DrawingPipeline,
    z_buffer: DrawingPipeline,
    overdraw: DrawingPipeline,
    /// Corners, and their number.
    batches: Vec<(wgpu::Buffer, u32)>,
    light_of_codes: wgpu::Buffer,
    picture: wgpu::Buffer,
    atlas: wgpu::TextureView,
    /// Corners of the box around the scene.
    bounds: [DVec3; 2],
}

/// What a pass draws into.
struct Targets {
    light: wgpu::Texture,
    counts: wgpu::Texture,
    depth: Option<wgpu::Texture>,
}

/// An attachment of a pass, cleared.
fn cleared(view: &wgpu::TextureView) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
}

impl<'a> GpuQuads<'a> {
    /// Sends a scene to a device.
    pub fn new(gpu: &'a Gpu, scene: &QuadMesh) -> Result<GpuQuads<'a>> {
        let mesh = &scene.mesh;
        let texture = &scene.texture;
        let size = [texture.width, texture.height];
        if scene.light.is_some() {
            return Err(gpu.failed("atlas", "half floats are drawn on the CPU alone"));
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
        let view = wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        };
        Ok(GpuQuads {
            gpu,
            painter: DrawingPipeline::new(gpu, &kernels::QUADS_PAINTER)?,
            z_buffer: DrawingPipeline::new(gpu, &kernels::QUADS_Z_BUFFER)?,
            overdraw: DrawingPipeline::new(gpu, &kernels::QUADS_OVERDRAW)?,
            batches,
            light_of_codes: gpu.filled("light_of_codes", &words_of(&light_of_codes()))?,
            picture: gpu.buffer("picture", QuadPicture::WORDS, wgpu::BufferUsages::empty())?,
            atlas: atlas.create_view(&view),
            bounds: [corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max)],
        })
    }

    /// Draws the scene over a transparent picture. The monitor advances by one for each row.
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
        let (mut fragments, mut most_fragments) = (0u64, 0u32);
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
            most_fragments = most_fragments.max(counts().max().unwrap_or(0));
        }
        if most_fragments >= COUNT_LIMIT {
            return Err(gpu.failed("counting", &format!("{COUNT_LIMIT} triangles or more lie over a pixel")));
        }
        let share = 1.0 / samples.len() as f32;
        monitor.advance(u64::from(height));
        Ok(Drawn { pixels: sums.iter().map(|sum| sum.map(|part| part * share)).collect(), fragments, most_fragments })
    }

    /// Draws all batches.
    fn pass(&self, drawing: &DrawingPipeline, targets: &[&wgpu::Texture], depth: Option<&wgpu::Texture>) -> Result<()> {
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (views, depth) = (targets.iter().map(|target| view(target)).collect::<Vec<_>>(), depth.map(view));
        let attachments: Vec<_> = views.iter().map(cleared).collect();
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

    fn picture_of(&self, camera: &Camera, size: [u32; 2], sample: &Sample) -> QuadPicture {
        let [forward, right, down] = camera.axes().map(|axis| axis.as_vec3().to_array());
        let (eye, window) = (camera.eye(), camera.window());
        // Clip coordinates of a tangent, upside down for rows; a sample beside the middle of its pixel moves the picture.
        let clip = |[from, to]: [f64; 2], offset: f64, pixels: u32| {
            [2.0 / (to - from), -(from + to) / (to - from) - (2.0 * offset - 1.0) / f64::from(pixels)]
        };
        let [scale_x, shift_x] = clip(window.u, sample.offset[0], size[0]);
        let [scale_y, shift_y] = clip(window.v, sample.offset[1], size[1]).map(|part| -part);
        let farthest_m = self.bounds.iter().map(|corner| (*corner - eye).abs()).fold(DVec3::ZERO, DVec3::max).length();
        let depth_m = camera.depth_m().map(|metres| metres.min(f64::from(f32::MAX)) as f32);
        QuadPicture {
            right,
            down,
            forward,
            scale_x: scale_x as f32,
            shift_x: shift_x as f32,
            scale_y: scale_y as f32,
            shift_y: shift_y as f32,
            eye: eye.as_vec3().to_array(),
            eye_rest: (eye - eye.as_vec3().as_dvec3()).as_vec3().to_array(),
            nearest_m: (NEAREST * farthest_m).max(f64::from(f32::MIN_POSITIVE)).log2().floor().exp2() as f32,
            near_m: depth_m[0],
            far_m: depth_m[1],
            threshold: sample.threshold,
            spare: 0,
        }
    }
}
