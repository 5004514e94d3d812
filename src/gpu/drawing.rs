//! Drawing with the device's rasteriser: pipelines, textures, and readback of pictures.

use glam::DVec3;
use half::f16;

use crate::Gpu;
use codec::error::{Error, Result};
use kernels::layout::DrawnPicture;
use kernels::{Blending, Drawing};

/// Linear RGB and alpha: the most precise format that every device can blend.
pub const LIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub const COUNT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
/// Two unsigned integers.
pub const INDEX_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Near distance of drawings, relative to the distance of the farthest corner. The CPU has no near limit.
const NEAREST: f64 = 1e-7;
/// Maximum bytes that are sent or read at once.
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

    /// Creates a bind group; `resource` returns the resource of a binding by its name.
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
    let has_depth = drawing.targets.iter().any(|target| target.blending.has_depth());
    let depth_stencil = has_depth.then(|| wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        // Depth 1 is near. Of equal depths the last one drawn is kept.
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
        // No culling: triangles are visible from both sides.
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
        Blending::Index => (INDEX_FORMAT, None),
    };
    wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
}

/// Creates an empty texture of one layer. Fails if a side exceeds the device's limit.
pub fn texture(
    gpu: &Gpu,
    label: &'static str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> Result<wgpu::Texture> {
    let most = gpu.device.limits().max_texture_dimension_2d;
    if width.max(height) > most {
        return Err(gpu.failed(label, &format!("{width}x{height} exceeds the texture size limit of {most}")));
    }
    let usage = match format {
        LIGHT_FORMAT | COUNT_FORMAT => wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        DEPTH_FORMAT => wgpu::TextureUsages::RENDER_ATTACHMENT,
        INDEX_FORMAT => {
            wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::TEXTURE_BINDING
        }
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

/// Creates a view of a one-layer texture as a texture array.
pub fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    })
}

/// Returns a colour attachment that is cleared at the start of the pass.
pub fn cleared(view: &wgpu::TextureView, color: wgpu::Color) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store };
    Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
}

/// Returns the rows of a texture from `top` on.
fn rows_of(texture: &wgpu::Texture, top: u32) -> wgpu::TexelCopyTextureInfo<'_> {
    let origin = wgpu::Origin3d { x: 0, y: top, z: 0 };
    wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin, aspect: wgpu::TextureAspect::All }
}

/// Splits an image into bands of at most `BAND_BYTES`; yields the first row and the number of rows of each.
fn bands(height: u32, row_bytes: u64) -> impl Iterator<Item = [u32; 2]> {
    let most = (BAND_BYTES / row_bytes.max(1)).clamp(1, u64::from(height.max(1))) as u32;
    (0..height).step_by(most as usize).map(move |top| [top, most.min(height - top)])
}

/// Uploads texels of four bytes.
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

/// Reads a texture of half floats with `channels` channels per texel.
pub fn read_halves(gpu: &Gpu, texture: &wgpu::Texture, channels: usize) -> Result<Vec<f16>> {
    let both = |word: u32| [f16::from_bits(word as u16), f16::from_bits((word >> 16) as u16)];
    let mut halves = Vec::with_capacity(channels * texture.width() as usize * texture.height() as usize);
    let row = texture.width() as usize * channels;
    read_rows(gpu, texture, 2 * channels, |words| halves.extend(words.iter().copied().flat_map(both).take(row)))?;
    Ok(halves)
}

/// Reads a texture of [`INDEX_FORMAT`].
pub fn read_indices(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<[u32; 2]>> {
    let mut indices = Vec::with_capacity(texture.width() as usize * texture.height() as usize);
    let width = texture.width() as usize;
    read_rows(gpu, texture, 8, |words| indices.extend(words.as_chunks().0.iter().take(width)))?;
    Ok(indices)
}

/// Rows of a texture, copied into a buffer.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    pub top: u32,
    pub rows: u32,
    /// Row pitch in bytes.
    pub pitch: u32,
}

/// Copies a texture into buffers, one band of rows at a time, and passes each to `take`.
pub fn copy_rows(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    texel_bytes: usize,
    mut take: impl FnMut(&wgpu::Buffer, Band) -> Result<()>,
) -> Result<()> {
    let (width, height) = (texture.width(), texture.height());
    // The row pitch of a copy must be a multiple of 256 bytes.
    let pitch = (width * texel_bytes as u32).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    for [top, rows] in bands(height, u64::from(pitch)) {
        let buffer = gpu.buffer("picture", pitch as usize / 4 * rows as usize, wgpu::BufferUsages::empty())?;
        gpu.submit("picture", |encoder| {
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: Some(rows) };
            let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
            let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            encoder.copy_texture_to_buffer(rows_of(texture, top), to, size);
        })?;
        take(&buffer, Band { top, rows, pitch })?;
    }
    Ok(())
}

/// Passes each row of a texture to `take` as words; the last words of a row may be padding.
fn read_rows(gpu: &Gpu, texture: &wgpu::Texture, texel_bytes: usize, mut take: impl FnMut(&[u32])) -> Result<()> {
    copy_rows(gpu, texture, texel_bytes, |buffer, Band { rows, pitch, .. }| {
        let words = pitch as usize / 4 * rows as usize;
        let found = gpu.read(buffer, words)?;
        if found.len() != words {
            return Err(Error::unsupported(format!("{}: a picture was not read back", gpu.info.name)));
        }
        found.chunks_exact(pitch as usize / 4).for_each(&mut take);
        Ok(())
    })
}

/// Part of a camera's picture.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    pub eye: DVec3,
    /// Forward, right and down; unit vectors.
    pub axes: [DVec3; 3],
    /// Tangents of its left and right, and of its top and bottom edge.
    pub tangents: [[f64; 2]; 2],
    pub size: [u32; 2],
    /// Position of the sample within each pixel; 0.5 is the centre.
    pub sample: [f64; 2],
}

impl Window {
    /// Returns the input for drawing the window with triangles up to `farthest_m` metres from the eye.
    pub fn drawn(&self, farthest_m: f64) -> DrawnPicture {
        let Window { eye, axes, tangents, size, sample } = self;
        let [forward, right, down] = axes.map(|axis| axis.as_vec3().to_array());
        // Scale and shift from tangents to clip coordinates; rows are flipped. A sample off the pixel centre shifts the
        // picture.
        let clip = |axis: usize| {
            let [from, to] = tangents[axis];
            let shift = -(from + to) / (to - from) - (2.0 * sample[axis] - 1.0) / f64::from(size[axis]);
            [2.0 / (to - from), shift]
        };
        let [[scale_x, shift_x], [scale_y, shift_y]] = [clip(0), clip(1).map(|part| -part)];
        DrawnPicture {
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
            near_m: 0.0,
            far_m: f32::MAX,
            threshold: 0.0,
            spare: 0,
        }
    }
}

/// Returns the distance in metres from an eye to the farthest corner of a box, given by two opposite corners.
pub fn farthest_m(bounds: [DVec3; 2], eye: DVec3) -> f64 {
    bounds.iter().map(|corner| (*corner - eye).abs()).fold(DVec3::ZERO, DVec3::max).length()
}
