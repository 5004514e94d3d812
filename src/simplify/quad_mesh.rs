//! Tiles as a textured triangle mesh in drawing order (Seurat 5, 6).

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use half::f16;
use rayon::prelude::*;

use super::cost::TextureCoordinates;
use super::texture_sizes::{Layout, Place, resized};
use super::textures::TileTexture;
use super::tiles::{QuadTile, TileSet};
use codec::image::{CodeSteps, ToneMap};
use scene::mesh::{ImageTexture, Mesh, Wrap};

/// A mesh whose triangles are drawn in order, over each other, and its texture: sRGB codes, not multiplied by alpha. Triangles
/// are counter-clockwise for an eye at the centre of the viewing region.
#[derive(Debug)]
pub struct QuadMesh {
    pub mesh: Mesh,
    pub texture: Arc<ImageTexture>,
    /// Homogeneous texture coordinates of each corner, (u q, v q, q), or empty. They are exact, while those of the mesh are
    /// affine.
    pub stq: Vec<Vec3>,
    /// Linear RGB of each texel, which replaces the codes of the texture, or `None`. Alpha is that of the texture.
    pub light: Option<Vec<[f16; 3]>>,
    /// Lengths of runs of triangles in drawing order, alternately blended and opaque, blended first. Empty if it is unknown which
    /// triangles are opaque.
    pub runs: Vec<u32>,
}

/// Precision of colour in an atlas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtlasLight {
    /// 8-bit sRGB codes: linear RGB from 0 to 1.
    Codes,
    /// Half floats, in addition to the codes.
    HalfFloats,
}

/// Parameters of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct MeshForm {
    /// Centre of the viewing region, in metres.
    pub middle: DVec3,
    pub coordinates: TextureCoordinates,
    pub light: AtlasLight,
}

impl QuadMesh {
    pub fn new(tiles: &TileSet, textures: Vec<TileTexture>, layout: &Layout, form: &MeshForm) -> QuadMesh {
        let [width, height] = layout.size;
        let texels = (width * height) as usize;
        let texture = ImageTexture { width, height, pixels: vec![[0; 4]; texels], wrap: [Wrap::Clamp; 2] };
        let light = (form.light == AtlasLight::HalfFloats).then(|| vec![[f16::ZERO; 3]; texels]);
        let mut scene =
            QuadMesh { mesh: Mesh::default(), texture: Arc::new(texture), stq: Vec::new(), light, runs: Vec::new() };
        let codes = CodeSteps::new(ToneMap::default());
        let fit = |(texture, place): (TileTexture, &Place)| resized(texture, place.side as usize);
        let textures: Vec<TileTexture> = textures.into_par_iter().zip(&layout.places).map(fit).collect();
        for (at, (tile, texture)) in tiles.tiles.iter().zip(textures).enumerate() {
            scene.add_texture(&texture, layout.places[at], &codes);
            let first_triangle = scene.mesh.triangles.len();
            scene.add_triangles(tile, layout.places[at], layout.size, form);
            let count = (scene.mesh.triangles.len() - first_triangle) as u32;
            add_to_runs(&mut scene.runs, usize::from(texture.is_opaque), count);
        }
        scene.mesh.material_of = vec![0; scene.mesh.triangles.len()];
        scene
    }

    /// Returns the triangles of tiles, relative to the centre of the region and transparent.
    pub fn of_shapes(tiles: &TileSet) -> QuadMesh {
        let texture = ImageTexture { width: 1, height: 1, pixels: vec![[0; 4]], wrap: [Wrap::Clamp; 2] };
        let mut scene = QuadMesh {
            mesh: Mesh::default(),
            texture: Arc::new(texture),
            stq: Vec::new(),
            light: None,
            runs: Vec::new(),
        };
        let form = MeshForm { middle: DVec3::ZERO, coordinates: TextureCoordinates::Affine, light: AtlasLight::Codes };
        for tile in &tiles.tiles {
            // A quad counts once, however it is divided.
            let whole = QuadTile { divisions: [1, 1], ..*tile };
            scene.add_triangles(&whole, Place { side: 1, corner: [0; 2] }, [1; 2], &form);
        }
        scene
    }

    /// Moves all corners that lie outside of a cube to its surface, towards its centre. Pictures from the centre do not change.
    pub fn pull_in(&mut self, middle: DVec3, half_m: f64) {
        for (at, position) in self.mesh.positions.iter_mut().enumerate() {
            let from_middle = *position - middle;
            let part = half_m / from_middle.abs().max_element();
            if part < 1.0 {
                *position = (middle + part * from_middle).as_vec3().as_dvec3();
                // Homogeneous coordinates are multiples of the depth.
                if let Some(stq) = self.stq.get_mut(at) {
                    *stq *= part as f32;
                }
            }
        }
    }

    fn add_texture(&mut self, texture: &TileTexture, place: Place, codes: &CodeSteps) {
        let atlas = Arc::make_mut(&mut self.texture);
        for (at, &[r, g, b, alpha]) in texture.texels.iter().enumerate() {
            let light = [r, g, b];
            let [r, g, b] = light.map(|light| codes.code(light));
            let corner = place.corner.map(|at| at as usize);
            let (x, y) = (corner[0] + at % texture.side, corner[1] + at / texture.side);
            let texel = y * atlas.width as usize + x;
            atlas.pixels[texel] = [r, g, b, (alpha * 255.0).round() as u8];
            if let Some(lights) = &mut self.light {
                lights[texel] = light.map(finite_half);
            }
        }
    }

    fn add_triangles(&mut self, tile: &QuadTile, place: Place, atlas: [u32; 2], form: &MeshForm) {
        let [columns, rows] = tile.divisions;
        let first = self.mesh.positions.len() as u32;
        // Texture coordinates are linear in the plane of the face; on the tile, their products with the depth along the face's
        // axis are linear.
        let farthest = tile.corners().map(|corner| tile.depth(corner)).into_iter().fold(0.0, f64::max);
        for row in 0..=rows {
            for column in 0..=columns {
                let part = [f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows)];
                let plane: [f64; 2] = std::array::from_fn(|axis| {
                    tile.rect.min[axis] + part[axis] * (tile.rect.max[axis] - tile.rect.min[axis])
                });
                let point = tile.point(plane);
                // Rounded to the precision of files.
                self.mesh.positions.push((form.middle + point).as_vec3().as_dvec3());
                let uv: [f64; 2] = std::array::from_fn(|axis| {
                    let texel = f64::from(place.corner[axis]) + 0.5 + part[axis] * f64::from(place.side - 1);
                    texel / f64::from(atlas[axis])
                });
                self.mesh.uvs.push(Vec2::new(uv[0] as f32, uv[1] as f32));
                if form.coordinates == TextureCoordinates::Projective {
                    let q = tile.depth(point) / farthest;
                    self.stq.push(DVec3::new(uv[0] * q, uv[1] * q, q).as_vec3());
                }
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = first + row * (columns + 1) + column;
                let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
                self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
}

/// Converts to a half float that is finite.
fn finite_half(light: f32) -> f16 {
    if light.is_nan() { f16::ZERO } else { f16::from_f32(light.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())) }
}

/// Adds triangles of a kind: 0 for blended, 1 for opaque.
fn add_to_runs(runs: &mut Vec<u32>, kind: usize, count: u32) {
    while runs.len() % 2 == kind || runs.is_empty() {
        runs.push(0);
    }
    if let Some(last) = runs.last_mut() {
        *last += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_of_blended_and_opaque_triangles_in_turns() {
        let of = |kinds: &[usize]| {
            let mut runs = Vec::new();
            kinds.iter().for_each(|kind| add_to_runs(&mut runs, *kind, 2));
            runs
        };
        assert_eq!(of(&[0, 0, 1, 0]), [4, 2, 2]);
        assert_eq!(of(&[1, 1, 0]), [0, 4, 2]);
        assert_eq!(of(&[]), [0; 0]);
    }

    #[test]
    fn what_is_far_is_pulled_in_along_its_direction() {
        let positions = [[1.0, 2.0, -3.0], [1.0, 22.0, 3.0], [-7.0, 2.0, 3.0]].map(DVec3::from_array).to_vec();
        let texture = ImageTexture { width: 1, height: 1, pixels: vec![[0; 4]], wrap: [Wrap::Clamp; 2] };
        let mesh = Mesh { positions, ..Mesh::default() };
        let stq = vec![Vec3::ONE; 3];
        let mut quads = QuadMesh { mesh, texture: Arc::new(texture), stq, light: None, runs: Vec::new() };
        quads.pull_in(DVec3::new(1.0, 2.0, 3.0), 5.0);
        let expected = [[1.0, 2.0, -2.0], [1.0, 7.0, 3.0], [-4.0, 2.0, 3.0]].map(DVec3::from_array);
        assert_eq!(quads.mesh.positions, expected);
        assert_eq!(quads.stq, [Vec3::splat(5.0 / 6.0), Vec3::splat(0.25), Vec3::splat(0.625)]);
    }

    #[test]
    fn light_of_half_floats_is_finite() {
        let found = [f32::NAN, f32::INFINITY, 1e9, -1e9, 0.5].map(|light| finite_half(light).to_f32());
        assert_eq!(found, [0.0, 65504.0, 65504.0, -65504.0, 0.5]);
    }
}
