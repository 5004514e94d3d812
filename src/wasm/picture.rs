//! The light field of the page, and pictures of it by ray marching.
//!
//! Takes texels of loaded views in the form that the decoder outputs. Views are numbered as in the page's catalogue.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use half::f16;

use crate::numbers::{Numbers, take_camera};
use codec::container::ProbeEntry;
use codec::depth::DepthRange;
use codec::error::{Error, Result};
use codec::image::{DepthKind, StreamKind, TexelMap, ToneMap, Transfer};
use codec::monitor::Silent;
use render::march::playback::frames::CpuRenderer;
use render::march::{PictureOptions, Rendered, Renderer, SpecularMode, Stage};
use render::rendered_image::HoleFill;
use render::views::{Change, ColorCoding, ColorTexels, FaceTexels, InverseDepth, LightField, Rect, UNKNOWN, View};

/// Coding of overlays: 8-bit sRGB codes.
const OVERLAY: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });

/// A rectangle of a face of a view.
#[derive(Debug, Clone, Copy)]
pub struct FaceArea {
    pub view: u32,
    /// Index of the face ([`codec::image::Face`]).
    pub face: u32,
    pub rect: Rect,
}

/// Settings of a picture.
#[derive(Debug, Clone, Copy)]
pub struct PictureSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub steps: u32,
    pub holes: HoleFill,
    pub colors: PictureColors,
}

/// Colours that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureColors {
    Texels,
    /// Those of the overlay, without secondary rays.
    Overlay,
}

pub struct PictureField {
    field: LightField,
    renderer: CpuRenderer,
    /// Changes of texels since the last picture.
    changes: Vec<Change>,
    /// Tables of the depth codes of loaded faces, by view and face.
    tables: BTreeMap<(usize, usize), Arc<InverseDepth>>,
    /// Overlays of faces that have one, by view and face.
    overlays: BTreeMap<(usize, usize), FaceColors>,
    /// Views and faces with new material since the last picture.
    new_materials: BTreeSet<(usize, usize)>,
}

/// Colours in place of those of a face.
struct FaceColors {
    color: ColorTexels,
    has_alpha: bool,
}

impl FaceColors {
    /// Returns a black overlay.
    fn overlay(texels: &FaceTexels) -> FaceColors {
        FaceColors { color: ColorTexels::Codes(vec![[0; 4]; texels.inverse_depth.len()]), has_alpha: false }
    }

    fn swap(&mut self, texels: &mut FaceTexels) {
        std::mem::swap(&mut self.color, &mut texels.color);
        std::mem::swap(&mut self.has_alpha, &mut texels.has_alpha);
    }
}

impl PictureField {
    /// Creates a light field without views.
    pub fn new(coding: ColorCoding) -> PictureField {
        PictureField {
            field: LightField { views: Vec::new(), coding },
            renderer: CpuRenderer::new(PictureOptions::default()),
            changes: Vec::new(),
            tables: BTreeMap::new(),
            overlays: BTreeMap::new(),
            new_materials: BTreeSet::new(),
        }
    }

    /// Loads a view whose texels are unknown. `rows` has its near and far in metres, then twelve numbers for each face: its
    /// index, width and height, the scale and the centre of its map, near and far of its depth codes, and 1 or 0 for codes of
    /// distance, alpha, and material.
    pub fn load(&mut self, view: u32, mut rows: Numbers<'_>) -> Result<()> {
        let [near_m, far_m] = rows.take()?.map(|metres| metres as f32);
        let at = view as usize;
        self.unload(view)?;
        if self.field.views.len() <= at {
            self.field.views.resize_with(at + 1, View::default);
        }
        self.field.views[at] = View { near_m, far_m, ..View::default() };
        while !rows.is_empty() {
            let face = rows.take_u32()? as usize;
            let size = [rows.take_u32()?, rows.take_u32()?];
            let [scale, centre, range] = [rows.take()?, rows.take()?, rows.take()?].map(|pair| pair.map(|x| x as f32));
            let [is_distance, has_alpha, has_material] = rows.take()?.map(|flag: f64| flag != 0.0);
            let slot = self.field.views[at].faces.get_mut(face).ok_or_else(|| no_face(view, face as u32))?;
            let texels = FaceTexels::unknown(size, TexelMap { scale, centre }, self.field.coding);
            let texels = if has_material { texels.with_material() } else { texels };
            *slot = Some(FaceTexels { has_alpha, ..texels });
            let kind = if is_distance { DepthKind::Distance } else { DepthKind::Planar };
            let table = self.table(DepthRange::new(range[0], range[1])?, kind);
            self.tables.insert((at, face), table);
            self.change(FaceArea { view, face: face as u32, rect: [0, 0, size[0], size[1]] }, StreamKind::Depth);
        }
        Ok(())
    }

    /// Frees the texels of a view.
    pub fn unload(&mut self, view: u32) -> Result<()> {
        let at = view as usize;
        if let Some(view) = self.field.views.get_mut(at) {
            *view = View::default();
        }
        self.tables.retain(|&(view, _), _| view != at);
        self.overlays.retain(|&(view, _), _| view != at);
        self.new_materials.retain(|&(view, _)| view != at);
        self.changes.retain(|change| change.view != at);
        // Drops its pyramids.
        self.renderer.update(&Stage { field: &self.field, views: &[] }, &[])
    }

    /// Returns the table of a range, shared by faces of the same range and kind.
    fn table(&self, range: DepthRange, kind: DepthKind) -> Arc<InverseDepth> {
        let known = self.tables.values().find(|table| (table.range, table.kind) == (range, kind));
        known.cloned().unwrap_or_else(|| Arc::new(InverseDepth::new(range, kind)))
    }

    fn change(&mut self, FaceArea { view, face, rect }: FaceArea, kind: StreamKind) {
        self.changes.push(Change { view: view as usize, face: face as usize, kind, rect });
    }

    /// Writes depth codes, row by row; without codes the depths become unknown.
    pub fn write_depth(&mut self, area: FaceArea, codes: &[u8]) -> Result<()> {
        let table = self.tables.get(&(area.view as usize, area.face as usize)).cloned();
        let table = table.ok_or_else(|| no_face(area.view, area.face))?;
        let texels = face_of(&mut self.field, area)?;
        let [left, top, width, height] = area.rect;
        if codes.is_empty() {
            for row in rows(texels.size[0], area.rect) {
                texels.inverse_depth[row].fill(UNKNOWN);
            }
        } else {
            let codes: Vec<u16> = pixels_of(codes, area, u16::from_le_bytes)?;
            for (row, codes) in (top..top + height).zip(codes.chunks_exact(width as usize)) {
                table.write_row(codes, texels, [left, row]);
            }
        }
        self.change(area, StreamKind::Depth);
        Ok(())
    }

    /// Writes straight colours and alpha, row by row: bytes of codes, or bit patterns of halves of light.
    pub fn write_color(&mut self, area: FaceArea, colors: &[u8]) -> Result<()> {
        let texels = face_of(&mut self.field, area)?;
        match &mut texels.color {
            ColorTexels::Codes(image) => write(image, texels.size[0], area, &pixels_of(colors, area, |texel| texel)?),
            ColorTexels::Light(image) => {
                let light = |texel: [u8; 8]| {
                    [0, 2, 4, 6].map(|at| f16::from_bits(u16::from_le_bytes([texel[at], texel[at + 1]])))
                };
                write(image, texels.size[0], area, &pixels_of(colors, area, light)?);
            }
        }
        Ok(())
    }

    /// Writes three bytes of material for each texel, row by row.
    pub fn write_material(&mut self, area: FaceArea, materials: &[u8]) -> Result<()> {
        let texels = face_of(&mut self.field, area)?;
        let width = texels.size[0];
        let image = texels.material.as_mut().ok_or_else(|| no_face(area.view, area.face))?;
        write(image, width, area, &pixels_of(materials, area, |[a, b, c]| [a, b, c, 0])?);
        self.new_materials.insert((area.view as usize, area.face as usize));
        Ok(())
    }

    /// Writes four bytes of overlay for each texel, row by row: sRGB codes, and a byte that is ignored.
    pub fn write_overlay(&mut self, area: FaceArea, colors: &[u8]) -> Result<()> {
        let texels = face_of(&mut self.field, area)?;
        let overlay = self.overlays.entry((area.view as usize, area.face as usize));
        if let ColorTexels::Codes(image) = &mut overlay.or_insert_with(|| FaceColors::overlay(texels)).color {
            write(image, texels.size[0], area, &pixels_of(colors, area, |texel| texel)?);
        }
        Ok(())
    }

    /// Renders a picture. `rows` has the camera, then eight numbers for each active view, the most important first: its number,
    /// position and orientation.
    pub fn render(&mut self, mut rows: Numbers<'_>, settings: PictureSettings) -> Result<Rendered> {
        let camera = take_camera(&mut rows)?;
        let mut views = Vec::new();
        while !rows.is_empty() {
            let number = rows.take_u32()?;
            let entry = ProbeEntry {
                name: format!("view {number}"),
                position: rows.take()?,
                orientation: rows.take()?,
                frames: [0; 2],
                intrinsics: [0.0; 4],
            };
            let view = self.field.views.get_mut(number as usize).filter(|view| view.faces.iter().any(Option::is_some));
            view.ok_or_else(|| not_loaded(number))?.place(&entry)?;
            views.push(number as usize);
        }
        let PictureSettings { size, steps, holes, colors } = settings;
        let is_overlay = colors == PictureColors::Overlay;
        let specular = if is_overlay { SpecularMode::None } else { SpecularMode::Auto };
        self.renderer.options = PictureOptions { size, steps, holes, specular, ..PictureOptions::default() };
        for (view, face) in std::mem::take(&mut self.new_materials) {
            if let Some(texels) = &mut self.field.views[view].faces[face] {
                texels.update_specular();
            }
        }
        let changes = std::mem::take(&mut self.changes);
        self.renderer.update(&Stage { field: &self.field, views: &views }, &changes)?;
        let coding = self.field.coding;
        if is_overlay {
            self.field.coding = OVERLAY;
            self.swap_overlays(&views);
        }
        let rendered = self.renderer.render(&Stage { field: &self.field, views: &views }, &camera, &Silent);
        if is_overlay {
            self.field.coding = coding;
            self.swap_overlays(&views);
        }
        rendered
    }

    /// Exchanges colours and overlays of views.
    fn swap_overlays(&mut self, views: &[usize]) {
        for &view in views {
            for (face, texels) in self.field.views[view].faces.iter_mut().enumerate() {
                if let Some(texels) = texels {
                    self.overlays.entry((view, face)).or_insert_with(|| FaceColors::overlay(texels)).swap(texels);
                }
            }
        }
    }
}

/// Returns the face of an area that lies inside its image.
fn face_of(field: &mut LightField, FaceArea { view, face, rect }: FaceArea) -> Result<&mut FaceTexels> {
    let loaded = field.views.get_mut(view as usize).and_then(|view| view.faces.get_mut(face as usize)?.as_mut());
    let texels = loaded.ok_or_else(|| no_face(view, face))?;
    let [left, top, width, height] = rect.map(u64::from);
    let [columns, rows] = texels.size.map(u64::from);
    match width > 0 && height > 0 && left + width <= columns && top + height <= rows {
        true => Ok(texels),
        false => Err(Error::Usage(format!("the rectangle {rect:?} of an image of {columns}x{rows} texels"))),
    }
}

/// Returns the texels of each row of a rectangle of an image.
fn rows(columns: u32, [left, top, width, height]: Rect) -> impl Iterator<Item = Range<usize>> {
    let start = move |row: u32| row as usize * columns as usize + left as usize;
    (top..top + height).map(move |row| start(row)..start(row) + width as usize)
}

/// Converts the `N` bytes of each texel of an area.
fn pixels_of<T, const N: usize>(bytes: &[u8], area: FaceArea, convert: impl Fn([u8; N]) -> T) -> Result<Vec<T>> {
    let [_, _, width, height] = area.rect;
    let (texels, rest) = bytes.as_chunks();
    if texels.len() as u64 != u64::from(width) * u64::from(height) || !rest.is_empty() {
        return Err(Error::Usage(format!("{} bytes for {width}x{height} texels of {N}", bytes.len())));
    }
    Ok(texels.iter().map(|&texel| convert(texel)).collect())
}

/// Writes the rows of an area into an image with this number of columns.
fn write<T: Copy>(image: &mut [T], columns: u32, area: FaceArea, pixels: &[T]) {
    for (row, pixels) in rows(columns, area.rect).zip(pixels.chunks_exact(area.rect[2] as usize)) {
        image[row].copy_from_slice(pixels);
    }
}

fn no_face(view: u32, face: u32) -> Error {
    Error::Usage(format!("view {view} has no face {face}"))
}

fn not_loaded(view: u32) -> Error {
    Error::Usage(format!("view {view} is not loaded"))
}
