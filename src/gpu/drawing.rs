//! Drawings by the rasteriser of a device: pipelines, textures, and pictures that are read back.

use half::f16;

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::kernels::{Blending, Drawing};

/// Light and alpha: the most precise format that every device blends.
pub const LIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub const COUNT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Most bytes that are sent or read at once.
const BAND_BYTES: u64 = 64 << 20;

#[derive(Debug)]
pub struct DrawingPipeline {
    pub pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    drawing: &'static Drawing,
}

impl DrawingPipeline {
    pub fn new(gpu: &Gpu, drawing: &'static Drawing) -> Result<DrawingPipeline> {
        gpu.guard(drawing.name, || compile(gpu, drawing))
    }

    /// Its resources by the names of its bindings.
    pub fn bind<'r>(
        &self,
        gpu: &Gpu,
        resource: impl Fn(&str) -> Option<wgpu::BindingResource<'r>>,
    ) -> Result<wgpu::BindGroup> {
        gpu.guard(self.drawing.name, || gpu.bind_to(&self.layout, self.drawing.bindings, resource))
    }
}

fn compile(gpu: &Gpu, drawing: &'static Drawing) -> DrawingPipeline {
    let label = Some(drawing.name);
    let source = wgpu::ShaderSource::Wgsl(drawing.source().into());
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let (layout, of_pipeline) = gpu.layouts(drawing.name, drawing.bindings, wgpu::ShaderStages::VERTEX_FRAGMENT);
    let targets: Vec<_> = drawing.targets.iter().map(|target| Some(color_target(target.blending))).collect();
    let has_depth = drawing.targets.iter().any(|target| target.blending == Blending::Nearest);
    let depth_stencil = has_depth.then(|| wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        // Depth 1 is near. Of equal depths the last shows.
        depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    });
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&of_pipeline),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(drawing.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        // Triangles from both sides.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(drawing.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    });
    DrawingPipeline { pipeline, layout, drawing }
}

fn color_target(blending: Blending) -> wgpu::ColorTargetState {
    let component = |dst_factor| wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor,
        operation: wgpu::BlendOperation::Add,
    };
    let both = |dst_factor| Some(wgpu::BlendState { color: component(dst_factor), alpha: component(dst_factor) });
    let (format, blend) = match blending {
        Blending::Over => (LIGHT_FORMAT, both(wgpu::BlendFactor::OneMinusSrcAlpha)),
        Blending::Add => (COUNT_FORMAT, both(wgpu::BlendFactor::One)),
        Blending::Nearest => (LIGHT_FORMAT, None),
    };
    wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
}

/// An empty texture of one layer; refuses sides that the device does not have.
pub fn texture(
    gpu: &Gpu,
    label: &'static str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> Result<wgpu::Texture> {
    let most = gpu.device.limits().max_texture_dimension_2d;
    if width.max(height) > most {
        return Err(gpu.failed(label, &format!("{width}x{height}, where {most} are the most for a side of a texture")));
    }
    let usage = match format {
        LIGHT_FORMAT | COUNT_FORMAT => wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        DEPTH_FORMAT => wgpu::TextureUsages::RENDER_ATTACHMENT,
        _ => wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
    };
    gpu.guard(label, || {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    })
}

/// Rows of a texture from `top` on.
fn rows_of(texture: &wgpu::Texture, top: u32) -> wgpu::TexelCopyTextureInfo<'_> {
    let origin = wgpu::Origin3d { x: 0, y: top, z: 0 };
    wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin, aspect: wgpu::TextureAspect::All }
}

/// First row and number of rows of parts of an image.
fn bands(height: u32, row_bytes: u64) -> impl Iterator<Item = [u32; 2]> {
    let most = (BAND_BYTES / row_bytes.max(1)).clamp(1, u64::from(height.max(1))) as u32;
    (0..height).step_by(most as usize).map(move |top| [top, most.min(height - top)])
}

/// Sends texels of four bytes.
pub fn send(gpu: &Gpu, texture: &wgpu::Texture, texels: &[[u8; 4]]) -> Result<()> {
    let (width, height) = (texture.width(), texture.height());
    for [top, rows] in bands(height, 4 * u64::from(width)) {
        let texels = &texels[top as usize * width as usize..][..rows as usize * width as usize];
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: Some(rows) };
        let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
        gpu.guard("atlas", || {
            gpu.queue.write_texture(rows_of(texture, top), texels.as_flattened(), layout, size);
            gpu.queue.submit([]);
        })?;
    }
    Ok(())
}

/// The half floats of a texture whose texels have so many channels.
pub fn read_halves(gpu: &Gpu, texture: &wgpu::Texture, channels: usize) -> Result<Vec<f16>> {
    let (width, height) = (texture.width(), texture.height());
    let row_words = width as usize * channels;
    // Devices copy whole multiples of 256 bytes a row.
    let pitch = (2 * row_words as u32).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let mut halves = Vec::with_capacity(row_words * height as usize);
    for [top, rows] in bands(height, u64::from(pitch)) {
        let words = pitch as usize / 4 * rows as usize;
        let buffer = gpu.buffer("picture", words, wgpu::BufferUsages::empty())?;
        gpu.submit("picture", |encoder| {
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: Some(rows) };
            let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
            let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            encoder.copy_texture_to_buffer(rows_of(texture, top), to, size);
        })?;
        let words = gpu.read(&buffer, words)?;
        let both = |word: &u32| [f16::from_bits(*word as u16), f16::from_bits((word >> 16) as u16)];
        for row in words.chunks_exact(pitch as usize / 4) {
            halves.extend(row.iter().flat_map(both).take(row_words));
        }
    }
    match halves.len() == row_words * height as usize {
        true => Ok(halves),
        false => Err(Error::unsupported(format!("{}: a picture was not read back", gpu.info.name))),
    }
}
