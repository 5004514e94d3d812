//! Texels on a device: the images of those views that take part, in textures of layers, and which of their texels are
//! no longer what the CPU has.
//!
//! All images have tiles of one size, so that any image fits into any tile. A tile is a whole layer as long as the
//! layers that WebGPU grants suffice, else several share one.

use std::collections::{HashMap, HashSet};

use half::slice::HalfFloatSliceExt;

use crate::dataset::stream::StreamKind;
use crate::error::{Error, Result};
use crate::gpu::device::Gpu;
use crate::gpu::render::depth_planes::Plane;
use crate::gpu::render::scene::Origin;
use crate::gpu::render::units::DeviceUnits;
use crate::march::active_views::ActiveViews;
use crate::march::pyramid::DepthPyramid;
use crate::views::light_field::{ColorCoding, ColorTexels, FaceTexels};
use crate::views::rects::{bounds, overlap};

/// Rectangles of an image that are sent one by one; of more, the whole image is sent.
const MOST_RECTANGLES: usize = 64;

/// An image of a view: the probe's index in the container, and the number of the face.
type Key = (usize, usize);
/// Left, top, width and height in texels.
type Rectangle = [u32; 4];

/// Texels on a device.
#[derive(Debug)]
pub struct DeviceTexels {
    /// Width and height of a tile: those of the largest images that were needed so far.
    tile: [u32; 2],
    coding: ColorCoding,
    /// Whether an image that was needed so far has a material.
    has_material: bool,
    textures: Option<Textures>,
    held: HashMap<Key, Held>,
}

/// Textures of one shape, with a place for so many tiles.
#[derive(Debug)]
struct Textures {
    tiles: usize,
    /// Tiles in each row and column of a layer.
    grid: [usize; 2],
    inverse_depths: wgpu::Texture,
    pyramids: wgpu::Texture,
    colors: wgpu::Texture,
    materials: wgpu::Texture,
}

/// An image that has a tile.
#[derive(Debug)]
struct Held {
    tile: usize,
    /// What the device does not have yet, of each kind.
    stale: Vec<(StreamKind, Rectangle)>,
}

impl DeviceTexels {
    /// Room for images whose colours are coded so; none is on the device yet.
    pub fn new(coding: ColorCoding) -> DeviceTexels {
        DeviceTexels { tile: [1, 1], coding, has_material: false, textures: None, held: HashMap::new() }
    }

    /// Texels of an image have changed on the CPU.
    pub fn change(&mut self, key: Key, kind: StreamKind, rectangle: Rectangle) {
        if let Some(held) = self.held.get_mut(&key) {
            held.stale.push((kind, rectangle));
        }
    }

    /// A rectangle that holds any image, of each kind.
    fn whole(&self) -> Vec<(StreamKind, Rectangle)> {
        let [width, height] = self.tile;
        let kinds = [StreamKind::Depth, StreamKind::Color, StreamKind::Material];
        kinds.map(|kind| (kind, [0, 0, width, height])).to_vec()
    }

    /// Sees to it that all images of these views are in textures of the device, as they are now; answers the bytes that were
    /// sent, and those that were copied of what the device has decoded.
    ///
    /// # Errors
    /// They are too many or too large for the device.
    pub fn bring(&mut self, gpu: &Gpu, views: &ActiveViews<'_>, units: Option<&DeviceUnits<'_>>) -> Result<[u64; 2]> {
        let images = || {
            views.views.iter().flat_map(|active| {
                let faces = active.view.faces.iter().enumerate();
                faces.filter_map(|(face, texels)| {
                    Some(((active.view.probe, face), texels.as_ref()?, active.pyramids.face(face)))
                })
            })
        };
        let needed: HashSet<Key> = images().map(|(key, ..)| key).collect();
        for (_, texels, _) in images() {
            self.suit(texels);
        }
        if self.textures.as_ref().is_none_or(|textures| textures.tiles < needed.len()) {
            // The old ones go first: there may be no room for both.
            self.textures = None;
            self.held.clear();
            self.textures = Some(self.make(gpu, needed.len().max(1))?);
        }
        self.place(images().map(|(key, ..)| key), &needed);
        let (mut sent, mut copies) = (0, Vec::new());
        for (key, texels, pyramid) in images() {
            sent += self.send(gpu, key, texels, pyramid)?;
            if let Some(units) = units.filter(|_| texels.is_on_device()) {
                self.list_copies(key, units, &mut copies);
            }
        }
        if copies.is_empty() {
            return Ok([sent, 0]);
        }
        let copied = copies.iter().map(|copy| 4 * u64::from(copy.size[0]) * u64::from(copy.size[1])).sum();
        gpu.guard("texels", || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            copies.iter().for_each(|copy| copy.encode(&mut encoder));
            gpu.queue.submit([encoder.finish()]);
        })?;
        Ok([sent, copied])
    }

    /// Gives textures up that an image does not fit into, or that have no room for its material. A light field has images only
    /// of views that take part, so that larger ones may come at any time.
    fn suit(&mut self, texels: &FaceTexels) {
        let tile = [0, 1].map(|axis| self.tile[axis].max(texels.size[axis]));
        let has_material = self.has_material || texels.material.is_some();
        if (tile, has_material) != (self.tile, self.has_material) {
            (self.tile, self.has_material) = (tile, has_material);
            self.textures = None;
            self.held.clear();
        }
    }

    /// Gives tiles to images that have none; images that are not needed give theirs up.
    fn place(&mut self, keys: impl Iterator<Item = Key>, needed: &HashSet<Key>) {
        let missing: Vec<Key> = {
            let mut known: HashSet<Key> = self.held.keys().copied().collect();
            keys.filter(|key| known.insert(*key)).collect()
        };
        if missing.is_empty() {
            return;
        }
        let tiles = self.textures.as_ref().map_or(0, |textures| textures.tiles);
        let mut taken = vec![false; tiles];
        self.held.values().for_each(|held| taken[held.tile] = true);
        let mut free: Vec<usize> = (0..tiles).filter(|&tile| !taken[tile]).collect();
        let mut spare: Vec<(usize, Key)> =
            self.held.iter().filter(|(key, _)| !needed.contains(*key)).map(|(key, held)| (held.tile, *key)).collect();
        spare.sort_unstable();
        let stale = self.whole();
        for key in missing {
            let tile = free.pop().or_else(|| {
                let (tile, given_up) = spare.pop()?;
                self.held.remove(&given_up);
                Some(tile)
            });
            if let Some(tile) = tile {
                self.held.insert(key, Held { tile, stale: stale.clone() });
            }
        }
    }

    fn make(&self, gpu: &Gpu, tiles: usize) -> Result<Textures> {
        let limits = gpu.device.limits();
        let pyramid = [self.tile[0].div_ceil(2), self.pyramid_rows()];
        let most = [0, 1].map(|axis| (limits.max_texture_dimension_2d / self.tile[axis].max(pyramid[axis])) as usize);
        let most_layers = limits.max_texture_array_layers as usize;
        let together = tiles.div_ceil(most_layers);
        let columns = together.min(most[0]);
        let grid = [columns, together.div_ceil(columns.max(1))];
        if columns == 0 || grid[1] > most[1] {
            let ([width, height], most) = (self.tile, most[0] * most[1] * most_layers);
            return Err(Error::unsupported(format!(
                "{}: {tiles} images of {width}x{height} texels are needed at once, and it holds {most} of this size: let \
                fewer views take part, or use `device` cpu",
                gpu.info.name
            )));
        }
        let layers = tiles.div_ceil(grid[0] * grid[1]) as u32;
        let texture = |label: &'static str, tile: [u32; 2], format| {
            let size = wgpu::Extent3d {
                width: tile[0] * grid[0] as u32,
                height: tile[1] * grid[1] as u32,
                depth_or_array_layers: layers,
            };
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
        Ok(Textures {
            tiles,
            grid,
            inverse_depths: texture("inverse_depths", self.tile, wgpu::TextureFormat::R32Uint)?,
            pyramids: texture("pyramids", pyramid, wgpu::TextureFormat::R32Uint)?,
            colors: match self.coding {
                ColorCoding::Codes(_) => texture("colors", self.tile, wgpu::TextureFormat::Rgba8Unorm)?,
                ColorCoding::Light => texture("colors", self.tile, wgpu::TextureFormat::Rgba16Float)?,
            },
            // Kernels that ask for materials are given a texture also where there are none.
            materials: texture(
                "materials",
                if self.has_material { self.tile } else { [1, 1] },
                wgpu::TextureFormat::Rgba8Unorm,
            )?,
        })
    }

    /// Rows of the pyramid of a tile: the power of two that its sides fit into. Level k, of 2ᵏ texels a square, begins
    /// below the one before it, as many rows before the last as the power of two over 2ᵏ⁻¹.
    pub fn pyramid_rows(&self) -> u32 {
        self.tile[0].max(self.tile[1]).next_power_of_two()
    }

    /// Where an image lies.
    pub fn origin(&self, key: Key) -> Origin {
        let (Some(textures), Some(held)) = (&self.textures, self.held.get(&key)) else { return Origin::default() };
        let [columns, rows] = textures.grid;
        let (layer, within) = (held.tile / (columns * rows), held.tile % (columns * rows));
        let [column, row] = [within % columns, within / columns].map(|at| at as u32);
        Origin {
            texels: [column * self.tile[0], row * self.tile[1]],
            pyramid: [column * self.tile[0].div_ceil(2), row * self.pyramid_rows()],
            layer: layer as u32,
        }
    }

    fn send(&mut self, gpu: &Gpu, key: Key, texels: &FaceTexels, pyramid: &DepthPyramid) -> Result<u64> {
        let origin = self.origin(key);
        let (whole, rows) = (self.whole(), self.pyramid_rows());
        let (Some(textures), Some(held)) = (&self.textures, self.held.get_mut(&key)) else { return Ok(0) };
        if held.stale.len() > MOST_RECTANGLES {
            held.stale = whole;
        }
        // What lies on the device is copied there.
        let stays = |kind: StreamKind| texels.is_on_device() && kind != StreamKind::Material;
        let stale: Vec<_> = held.stale.extract_if(.., |(kind, _)| !stays(*kind)).collect();
        if stale.is_empty() {
            return Ok(0);
        }
        gpu.guard("texels", || {
            let mut sent = 0;
            for (kind, rectangle) in stale {
                let (texture, bytes) = match kind {
                    StreamKind::Depth => (&textures.inverse_depths, bytemuck::cast_slice(&texels.inverse_depth)),
                    StreamKind::Color => (&textures.colors, color_bytes(&texels.color)),
                    StreamKind::Material => {
                        (&textures.materials, texels.material.as_deref().unwrap_or_default().as_flattened())
                    }
                };
                if !bytes.is_empty() {
                    sent += write(gpu, (texture, origin.texels, origin.layer), (bytes, texels.size), rectangle);
                }
                if kind == StreamKind::Depth {
                    for level in 0..pyramid.levels() {
                        let Some((size, values)) = pyramid.level(level) else { continue };
                        let [column, row] = origin.pyramid;
                        let place = [column, row + rows - (rows >> level)];
                        let target = (&textures.pyramids, place, origin.layer);
                        sent += write(gpu, target, (bytemuck::cast_slice(values), size), above(rectangle, level));
                    }
                }
            }
            sent
        })
    }

    /// Lists what is to be copied of what the device has decoded of an image.
    fn list_copies<'u>(&mut self, key: Key, units: &'u DeviceUnits<'_>, copies: &mut Vec<TexelCopy<'u>>) {
        let (origin, rows) = (self.origin(key), self.pyramid_rows());
        let (Some(textures), Some(held)) = (&self.textures, self.held.get_mut(&key)) else { return };
        let Some(planes) = units.planes(key.0) else { return };
        let [texels, levels @ ..] = planes.levels(key.1) else { return };
        let [width, height] = texels.size;
        let mut changed = None;
        for (kind, rectangle) in std::mem::take(&mut held.stale) {
            let Some(rectangle) = overlap(rectangle, [0, 0, width, height]) else { continue };
            if kind == StreamKind::Depth {
                changed = Some(bounds(changed, rectangle));
                let target = (textures.inverse_depths.clone(), origin.texels, origin.layer);
                copies.push(TexelCopy::of_plane((planes.buffer(), texels), target, rectangle));
            } else {
                copies.extend(units.cells(key, rectangle).into_iter().map(|cell| TexelCopy {
                    buffer: cell.pictures,
                    at: cell.at,
                    pitch: cell.pitch,
                    texture: textures.colors.clone(),
                    origin: [origin.texels[0] + cell.rect[0], origin.texels[1] + cell.rect[1], origin.layer],
                    size: [cell.rect[2], cell.rect[3]],
                }));
            }
        }
        let Some(changed) = changed else { return };
        for (level, plane) in levels.iter().enumerate() {
            let place = [origin.pyramid[0], origin.pyramid[1] + rows - (rows >> level)];
            let target = (textures.pyramids.clone(), place, origin.layer);
            copies.push(TexelCopy::of_plane((planes.buffer(), plane), target, above(changed, level)));
        }
    }

    /// The textures of inverse depths, colours, pyramids and materials, where there are any: for tests, which read them back.
    pub fn textures(&self) -> Option<[&wgpu::Texture; 4]> {
        self.textures.as_ref().map(|textures| {
            let Textures { inverse_depths, colors, pyramids, materials, .. } = textures;
            [inverse_depths, colors, pyramids, materials]
        })
    }

    /// Views of the textures of inverse depths, colours, pyramids and materials.
    pub fn views(&self) -> Vec<wgpu::TextureView> {
        let view = |texture: &wgpu::Texture| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        let Some(Textures { inverse_depths, pyramids, colors, materials, .. }) = &self.textures else {
            return Vec::new();
        };
        [inverse_depths, colors, pyramids, materials].map(view).to_vec()
    }
}

/// Words of a buffer that become texels of four bytes.
#[derive(Debug)]
struct TexelCopy<'u> {
    buffer: &'u wgpu::Buffer,
    /// First word.
    at: u32,
    /// Words from row to row.
    pitch: u32,
    texture: wgpu::Texture,
    /// Column, row and layer.
    origin: [u32; 3],
    /// Columns and rows.
    size: [u32; 2],
}

impl<'u> TexelCopy<'u> {
    /// A rectangle of a plane, to the same place of an image that begins at a column and a row of a layer.
    fn of_plane(
        (buffer, plane): (&'u wgpu::Buffer, &Plane),
        (texture, [column, row], layer): (wgpu::Texture, [u32; 2], u32),
        [left, top, width, height]: Rectangle,
    ) -> TexelCopy<'u> {
        let at = plane.at + top * plane.pitch + left;
        TexelCopy {
            buffer,
            at,
            pitch: plane.pitch,
            texture,
            origin: [column + left, row + top, layer],
            size: [width, height],
        }
    }

    fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let ([x, y, z], [width, height]) = (self.origin, self.size);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 4 * u64::from(self.at),
            // Of one row, which may be the last of its buffer, there is no next.
            bytes_per_row: (height > 1).then_some(4 * self.pitch),
            rows_per_image: None,
        };
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo { buffer: self.buffer, layout },
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}

/// The squares of a level of a pyramid, counted from 0, that a rectangle of texels lies in.
pub(super) fn above([left, top, width, height]: Rectangle, level: usize) -> Rectangle {
    let span = |begin: u32, length: u32| {
        let first = begin >> (level + 1);
        [first, ((begin + length - 1) >> (level + 1)) - first + 1]
    };
    let ([left, width], [top, height]) = (span(left, width.max(1)), span(top, height.max(1)));
    [left, top, width, height]
}

fn color_bytes(texels: &ColorTexels) -> &[u8] {
    match texels {
        ColorTexels::Codes(codes) => codes.as_flattened(),
        ColorTexels::Light(light) => bytemuck::cast_slice(light.as_flattened().reinterpret_cast()),
    }
}

/// Sends a rectangle of an image of `size` texels, which lies in `bytes` row by row; answers how many bytes it has.
fn write(
    gpu: &Gpu,
    (texture, [column, row], layer): (&wgpu::Texture, [u32; 2], u32),
    (bytes, size): (&[u8], [u32; 2]),
    [left, top, width, height]: Rectangle,
) -> u64 {
    // A rectangle may be that of a tile, and larger than the image.
    let [width, height] = [(left, width, size[0]), (top, height, size[1])]
        .map(|(from, length, size)| length.min(size.saturating_sub(from)));
    if width == 0 || height == 0 {
        return 0;
    }
    let texel = bytes.len() as u64 / (u64::from(size[0]) * u64::from(size[1]));
    let target = wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: wgpu::Origin3d { x: column + left, y: row + top, z: layer },
        aspect: wgpu::TextureAspect::All,
    };
    let layout = wgpu::TexelCopyBufferLayout {
        offset: (u64::from(top) * u64::from(size[0]) + u64::from(left)) * texel,
        bytes_per_row: Some(size[0] * texel as u32),
        rows_per_image: None,
    };
    gpu.queue.write_texture(target, bytes, layout, wgpu::Extent3d { width, height, depth_or_array_layers: 1 });
    u64::from(width) * u64::from(height) * texel
}
