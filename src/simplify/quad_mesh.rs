//! Tiles as a textured triangle mesh, in drawing order (Seurat 5, 6).

use std::io::Write;
use std::sync::Arc;

use glam::{DVec3, Vec2};
use serde_json::Value;

use super::texture_sizes::{Layout, resized};
use super::textures::TileTexture;
use super::tiles::TileSet;
use crate::error::Result;
use crate::image::ToneMap;
use crate::mesh::gltf::write;
use crate::mesh::{ImageTexture, Material, Mesh, Wrap};

/// A mesh whose triangles are drawn in their order, over each other, and its texture: sRGB codes, not multiplied by alpha.
#[derive(Debug)]
pub struct QuadMesh {
    pub mesh: Mesh,
    pub texture: Arc<ImageTexture>,
}

impl QuadMesh {
    pub fn new(tiles: &TileSet, textures: &[TileTexture], layout: &Layout, middle: DVec3) -> QuadMesh {
        let [width, height] = layout.size;
        let mut texture =
            ImageTexture { width, height, pixels: vec![[0; 4]; (width * height) as usize], wrap: [Wrap::Clamp; 2] };
        let mut mesh = Mesh::default();
        let tone = ToneMap::default();
        for (at, tile) in tiles.tiles.iter().enumerate() {
            let place = layout.places[at];
            let of_tile = resized(&textures[at], place.side as usize);
            for (row, texels) in of_tile.light.chunks_exact(of_tile.side).enumerate() {
                for (column, light) in texels.iter().enumerate() {
                    let alpha = of_tile
                        .alpha
                        .as_ref()
                        .map_or(255, |alpha| (alpha[row * of_tile.side + column] * 255.0).round() as u8);
                    let [r, g, b] = light.map(|light| tone.code(light));
                    let (x, y) = (place.corner[0] as usize + column, place.corner[1] as usize + row);
                    texture.pixels[y * width as usize + x] = [r, g, b, alpha];
                }
            }
            let [columns, rows] = tile.divisions;
            let first = mesh.positions.len() as u32;
            for row in 0..=rows {
                for column in 0..=columns {
                    let part = [f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows)];
                    let plane: [f64; 2] = std::array::from_fn(|axis| {
                        tile.rect.min[axis] + part[axis] * (tile.rect.max[axis] - tile.rect.min[axis])
                    });
                    // As files hold it.
                    mesh.positions.push((middle + tile.point(plane)).as_vec3().as_dvec3());
                    let uv: [f64; 2] = std::array::from_fn(|axis| {
                        let texel = f64::from(place.corner[axis]) + 0.5 + part[axis] * f64::from(place.side - 1);
                        texel / f64::from(layout.size[axis])
                    });
                    mesh.uvs.push(Vec2::new(uv[0] as f32, uv[1] as f32));
                }
            }
            for row in 0..rows {
                for column in 0..columns {
                    let a = first + row * (columns + 1) + column;
                    let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
                    mesh.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        mesh.material_of = vec![0; mesh.triangles.len()];
        QuadMesh { mesh, texture: Arc::new(texture) }
    }
}

/// Writes the mesh as binary glTF: one unlit, blended primitive whose triangles are in drawing order.
pub fn write_glb(scene: &QuadMesh, extras: Value, out: &mut dyn Write) -> Result<()> {
    let material = Material {
        name: "quads".into(),
        base_color: DVec3::ONE,
        base_texture: Some(scene.texture.clone()),
        is_blended: true,
        specular: None,
        unlit: true,
        ..Material::default()
    };
    write::glb(std::slice::from_ref(&scene.mesh), &[material], Some(extras), out)
}
