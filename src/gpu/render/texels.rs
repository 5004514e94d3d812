//! Texels on a device: the images of active views in texture arrays, and the list of their stale texels.
//!
//! All images have tiles of one size, so any image fits into any tile. A tile is a whole layer as long as the number of layers
//! that WebGPU guarantees suffices; otherwise several tiles share a layer.

use std::collections::{HashMap, HashSet};

use half::slice::HalfFloatSliceExt;

use crate::Gpu;
use crate::render::backend::GpuBackend;
use crate::render::depth_planes::{TexelWords, above};
use crate::render::scene::{ImageId, Origin};
use codec::error::{Error, Result};
use codec::image::StreamKind;
use render::atlas::{Allocation, Atlas, TextureLimits, TileGrid};
use render::march::{ActiveViews, DepthPyramid, Level};
use render::views::{ColorCoding, ColorTexels, FaceTexels, Rect, bounds, overlap};

/// Maximum number of stale rectangles that are sent individually; above it the whole image is sent.
const MAX_RECTANGLES: usize = 64;

/// A rectangle of texels of one kind that must be sent again.
type Stale = (StreamKind, Rect);

pub struct DeviceTexels {
    /// Width and height of a tile: the maximum over all images needed so far.
    tile: [u32; 2],
    coding: ColorCoding,
    /// True if any image needed so far has a material.
    has_material: bool,
    pub textures: Option<Textures>,
    resident: HashMap<ImageId, Resident>,
}

/// Texture arrays that share one atlas of tiles.
pub struct Textures {
    capacity: usize,
    atlas: Atlas,
    pub inverse_depths: wgpu::Texture,
    pub pyramids: wgpu::Texture,
    pub colors: wgpu::Texture,
    pub materials: wgpu::Texture,
}

struct Resident {
    tile: Allocation,
    stale: Vec<Stale>,
}

#[derive(Clone, Copy)]
struct Image<'v> {
    id: ImageId,
    texels: &'v FaceTexels,
    pyramid: &'v DepthPyramid,
}

/// A position in a texture array: column, row and layer.
#[derive(Clone, Copy)]
struct Place<'t> {
    texture: &'t wgpu::Texture,
    origin: [u32; 3],
}

impl Place<'_> {
    /// Returns the copy target of a rectangle of the image that begins here.
    fn copy_target(&self, [left, top, ..]: Rect) -> wgpu::TexelCopyTextureInfo<'_> {
        let [x, y, z] = self.origin;
        wgpu::TexelCopyTextureInfo {
            texture: self.texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: x + left, y: y + top, z },
            aspect: wgpu::TextureAspect::All,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Transferred {
    pub bytes_sent: u64,
    /// Bytes copied from buffers that the device has decoded into.
    pub bytes_copied: u64,
}

impl DeviceTexels {
    pub fn new(coding: ColorCoding) -> DeviceTexels {
        DeviceTexels { tile: [1, 1], coding, has_material: false, textures: None, resident: HashMap::new() }
    }

    pub fn change(&mut self, id: ImageId, kind: StreamKind, rect: Rect) {
        if let Some(resident) = self.resident.get_mut(&id) {
            resident.stale.push((kind, rect));
        }
    }

    /// Returns one rectangle per kind that covers any image.
    fn whole(&self) -> Vec<Stale> {
        let [width, height] = self.tile;
        let kinds = [StreamKind::Depth, StreamKind::Color, StreamKind::Material];
        kinds.map(|kind| (kind, [0, 0, width, height])).to_vec()
    }

    /// Updates the textures to the images of these views.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        views: &ActiveViews<'_>,
        backend: Option<&GpuBackend<'_>>,
    ) -> Result<Transferred> {
        let images = views.views.iter().flat_map(|active| {
            let faces = active.view.faces.iter().enumerate();
            faces.filter_map(|(face, texels)| {
                let id = ImageId { probe: active.view.probe, face };
                Some(Image { id, texels: texels.as_ref()?, pyramid: &active.pyramids.faces[face] })
            })
        });
        let images: Vec<Image<'_>> = images.collect();
        let needed: HashSet<ImageId> = images.iter().map(|image| image.id).collect();
        images.iter().for_each(|image| self.fit(image.texels));
        if self.textures.as_ref().is_none_or(|textures| textures.capacity < needed.len()) {
            // Drop the old textures first: both may not fit in memory.
            self.clear();
            self.textures = Some(self.make(gpu, needed.len().max(1))?);
        }
        images.iter().for_each(|image| self.allocate(image.id, &needed));
        let mut bytes_sent = 0;
        for image in &images {
            bytes_sent += self.send(gpu, image)?;
        }
        let mut copies = Vec::new();
        let in_backend = || images.iter().filter(|image| image.texels.is_in_backend()).map(|image| image.id);
        for (backend, id) in in_backend().filter_map(|id| Some((backend?, id))) {
            self.list_copies(id, backend, &mut copies);
        }
        let texels = copies.iter().map(|copy| copy.words.rect);
        let bytes_copied = texels.map(|[_, _, width, height]| 4 * u64::from(width) * u64::from(height)).sum();
        if !copies.is_empty() {
            gpu.submit("texels", |encoder| copies.iter().for_each(|copy| copy.encode(encoder)))?;
        }
        for id in in_backend().filter(|_| backend.is_some()) {
            self.resident.get_mut(&id).into_iter().for_each(|resident| resident.stale.clear());
        }
        Ok(Transferred { bytes_sent, bytes_copied })
    }

    fn clear(&mut self) {
        self.textures = None;
        self.resident.clear();
    }

    /// Drops the textures if an image does not fit into a tile, or if it has a material and the textures do not. Views are
    /// loaded when they become active, so a larger image may follow at any time.
    fn fit(&mut self, texels: &FaceTexels) {
        let tile = [0, 1].map(|axis| self.tile[axis].max(texels.size[axis]));
        let has_material = self.has_material || texels.material.is_some();
        if (tile, has_material) != (self.tile, self.has_material) {
            (self.tile, self.has_material) = (tile, has_material);
            self.clear();
        }
    }

    /// Allocates a tile for an image; if none is free, takes that of an image that is not needed.
    fn allocate(&mut self, id: ImageId, needed: &HashSet<ImageId>) {
        let stale = self.whole();
        let DeviceTexels { resident, textures: Some(textures), tile, .. } = self else { return };
        if resident.contains_key(&id) {
            return;
        }
        let tile = textures.atlas.allocate(*tile).or_else(|| {
            let spare = *resident.keys().find(|id| !needed.contains(*id))?;
            resident.remove(&spare).map(|resident| resident.tile)
        });
        if let Some(tile) = tile {
            resident.insert(id, Resident { tile, stale });
        }
    }

    fn make(&self, gpu: &Gpu, count: usize) -> Result<Textures> {
        let limits = gpu.device.limits();
        let limits = TextureLimits { side: limits.max_texture_dimension_2d, layers: limits.max_texture_array_layers };
        let pyramid = [self.tile[0].div_ceil(2), self.pyramid_rows()];
        // Tiles and pyramids share a grid.
        let larger = [0, 1].map(|axis| self.tile[axis].max(pyramid[axis]));
        let grid = u32::try_from(count).ok().and_then(|count| TileGrid::new(larger, count, limits));
        let Some(TileGrid { columns, rows, layers }) = grid else {
            let ([width, height], most) = (self.tile, TileGrid::most(larger, limits));
            return Err(Error::unsupported(format!(
                "{}: {count} images of {width}x{height} texels are needed at once, but at most {most} of this size \
                fit: use fewer `views`, or `device` cpu",
                gpu.info.name
            )));
        };
        let texture = |label: &'static str, tile: [u32; 2], format| {
            let size =
                wgpu::Extent3d { width: tile[0] * columns, height: tile[1] * rows, depth_or_array_layers: layers };
            gpu.guard(label, || {
                gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING
                        | wgpu::TextureUsages::COPY_DST
                        | wgpu::TextureUsages::COPY_SRC,
                    view_formats: &[],
                })
            })
        };
        let [width, height] = self.tile;
        Ok(Textures {
            capacity: count,
            atlas: Atlas::new([width * columns, height * rows], layers),
            inverse_depths: texture("inverse_depths", self.tile, wgpu::TextureFormat::R32Uint)?,
            pyramids: texture("pyramids", pyramid, wgpu::TextureFormat::R32Uint)?,
            colors: match self.coding {
                ColorCoding::Codes(_) => texture("colors", self.tile, wgpu::TextureFormat::Rgba8Unorm)?,
                ColorCoding::Light => texture("colors", self.tile, wgpu::TextureFormat::Rgba16Float)?,
            },
            // Kernels with a binding for materials need a texture even without materials.
            materials: texture(
                "materials",
                if self.has_material { self.tile } else { [1, 1] },
                wgpu::TextureFormat::Rgba8Unorm,
            )?,
        })
    }

    /// Returns the rows of a tile's pyramid: its larger side rounded up to a power of two, p. Level k, counted from 0, begins
    /// at row p − p / 2ᵏ, below the previous level.
    pub fn pyramid_rows(&self) -> u32 {
        self.tile[0].max(self.tile[1]).next_power_of_two()
    }

    pub fn origin(&self, id: ImageId) -> Origin {
        let Some(Resident { tile, .. }) = self.resident.get(&id) else { return Origin::default() };
        let [column, row] = [0, 1].map(|axis| tile.corner[axis] / self.tile[axis]);
        Origin {
            texels: tile.corner,
            pyramid: [column * self.tile[0].div_ceil(2), row * self.pyramid_rows()],
            layer: tile.layer,
        }
    }

    fn level_origin(&self, origin: Origin, level: usize) -> [u32; 3] {
        let rows = self.pyramid_rows();
        [origin.pyramid[0], origin.pyramid[1] + rows - (rows >> level), origin.layer]
    }

    /// Sends stale texels that the host keeps; returns the number of bytes.
    fn send(&mut self, gpu: &Gpu, image: &Image<'_>) -> Result<u64> {
        let (origin, whole, texels) = (self.origin(image.id), self.whole(), image.texels);
        let Some(resident) = self.resident.get_mut(&image.id) else { return Ok(0) };
        if resident.stale.len() > MAX_RECTANGLES {
            resident.stale = whole;
        }
        // Texels in the backend's buffers are copied instead.
        let is_in_backend = |kind: StreamKind| texels.is_in_backend() && kind != StreamKind::Material;
        let stale: Vec<Stale> = resident.stale.extract_if(.., |(kind, _)| !is_in_backend(*kind)).collect();
        let Some(textures) = self.textures.as_ref().filter(|_| !stale.is_empty()) else { return Ok(0) };
        let [x, y] = origin.texels;
        gpu.guard("texels", || {
            let (mut sent, mut changed) = (0, None);
            for (kind, rect) in stale {
                let (texture, bytes) = match kind {
                    // Never listed: alpha is part of the colour texels.
                    StreamKind::Alpha => continue,
                    StreamKind::Depth => (&textures.inverse_depths, bytemuck::cast_slice(&texels.inverse_depth)),
                    StreamKind::Color => (&textures.colors, color_bytes(&texels.color)),
                    StreamKind::Material => {
                        (&textures.materials, texels.material.as_deref().unwrap_or_default().as_flattened())
                    }
                };
                if !bytes.is_empty() {
                    let place = Place { texture, origin: [x, y, origin.layer] };
                    sent += write(gpu, place, bytes, texels.size, rect);
                }
                if kind == StreamKind::Depth {
                    changed = Some(bounds(changed, rect));
                }
            }
            let levels = image.pyramid.levels.iter().enumerate().filter_map(|(at, level)| Some((at, level, changed?)));
            for (level, Level { size, greatest }, changed) in levels {
                let place = Place { texture: &textures.pyramids, origin: self.level_origin(origin, level) };
                sent += write(gpu, place, bytemuck::cast_slice(greatest), *size, above(changed, level));
            }
            sent
        })
    }

    /// Lists the copies of an image's stale texels from the backend's buffers.
    fn list_copies<'u>(&'u self, id: ImageId, backend: &'u GpuBackend<'_>, copies: &mut Vec<TexelCopy<'u>>) {
        let (Some(textures), Some(planes)) = (&self.textures, backend.planes(id.probe)) else { return };
        let [texels, levels @ ..] = planes.levels(id.face) else { return };
        let origin = self.origin(id);
        let ([x, y], [width, height]) = (origin.texels, texels.size);
        let origin_of_texels = [x, y, origin.layer];
        let mut changed = None;
        let stale = self.resident.get(&id).map_or(&[][..], |resident| &resident.stale);
        for &(kind, rect) in stale {
            let Some(rect) = overlap(rect, [0, 0, width, height]) else { continue };
            if kind == StreamKind::Depth {
                changed = Some(bounds(changed, rect));
                let place = Place { texture: &textures.inverse_depths, origin: origin_of_texels };
                copies.push(TexelCopy { words: planes.texels(texels, rect), place });
            } else {
                let place = Place { texture: &textures.colors, origin: origin_of_texels };
                copies.extend(backend.cells(id, rect).into_iter().map(|words| TexelCopy { words, place }));
            }
        }
        let Some(changed) = changed else { return };
        for (level, plane) in levels.iter().enumerate() {
            let place = Place { texture: &textures.pyramids, origin: self.level_origin(origin, level) };
            copies.push(TexelCopy { words: planes.texels(plane, above(changed, level)), place });
        }
    }

    pub fn view(&self, binding: &str) -> Option<wgpu::TextureView> {
        let Textures { inverse_depths, pyramids, colors, materials, .. } = self.textures.as_ref()?;
        let texture = match binding {
            "inverse_depths" => inverse_depths,
            "pyramids" => pyramids,
            "colors" => colors,
            "materials" => materials,
            _ => return None,
        };
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        Some(texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() }))
    }
}

/// Copy of words from a buffer to texels of four bytes.
struct TexelCopy<'u> {
    words: TexelWords<'u>,
    place: Place<'u>,
}

impl TexelCopy<'_> {
    fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let TexelWords { buffer, at, pitch, rect } = self.words;
        let [_, _, width, height] = rect;
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 4 * u64::from(at),
            // If a single row is the last of its buffer, the buffer may end before a full row pitch.
            bytes_per_row: (height > 1).then_some(4 * pitch),
            rows_per_image: None,
        };
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo { buffer, layout },
            self.place.copy_target(rect),
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}

fn color_bytes(texels: &ColorTexels) -> &[u8] {
    match texels {
        ColorTexels::Codes(codes) => codes.as_flattened(),
        ColorTexels::Light(light) => bytemuck::cast_slice(light.as_flattened().reinterpret_cast()),
    }
}

/// Sends a rectangle of an image of `size`, given all bytes of the image; returns the number of bytes sent.
fn write(gpu: &Gpu, place: Place<'_>, bytes: &[u8], size: [u32; 2], rect: Rect) -> u64 {
    // The rectangle may cover a whole tile, which can be larger than the image.
    let Some(rect) = overlap(rect, [0, 0, size[0], size[1]]) else { return 0 };
    let [left, top, width, height] = rect;
    let texel = bytes.len() as u64 / (u64::from(size[0]) * u64::from(size[1]));
    let layout = wgpu::TexelCopyBufferLayout {
        offset: (u64::from(top) * u64::from(size[0]) + u64::from(left)) * texel,
        bytes_per_row: Some(size[0] * texel as u32),
        rows_per_image: None,
    };
    let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    gpu.queue.write_texture(place.copy_target(rect), bytes, layout, extent);
    u64::from(width) * u64::from(height) * texel
}
