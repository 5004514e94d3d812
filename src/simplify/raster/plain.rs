//! Reference rasteriser without optimisations: it tests every pixel of a triangle's bounding rectangle, and blends every
//! fragment.
//!
//! Triangles are neither culled nor clipped: the signs of three volumes determine whether the ray of a pixel meets a triangle.

use glam::{DVec3, Vec4};
use rayon::prelude::*;

use super::texels::{Texels, texture_coordinates};
use crate::quad_mesh::QuadMesh;
use codec::error::Result;
use codec::math::Camera;
use render::rendered_image::RenderedImage;

/// Number of rows that one job draws.
const ROWS_A_JOB: u32 = 16;

/// Pixels of a picture, and counts of triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Linear RGB multiplied by alpha, and alpha: means over the samples of a pixel.
    pub pixels: Vec<[f32; 4]>,
    /// Total number of triangles over all samples, visible or not.
    pub fragments: u64,
    /// Maximum number of triangles over a sample.
    pub max_fragments: u32,
}

impl Drawn {
    pub(super) fn of_rows(rows: Vec<(Vec<Vec4>, Vec<u32>)>) -> Drawn {
        let counts = || rows.iter().flat_map(|(_, counts)| counts);
        Drawn {
            fragments: counts().map(|&count| u64::from(count)).sum(),
            max_fragments: counts().copied().max().unwrap_or(0),
            pixels: rows.iter().flat_map(|(pixels, _)| pixels.iter().map(|pixel| pixel.to_array())).collect(),
        }
    }

    /// Returns the picture with straight colour, not multiplied by alpha.
    pub fn image(&self, size: [u32; 2]) -> Result<RenderedImage> {
        let straight = |&[r, g, b, alpha]: &[f32; 4]| {
            let factor = if alpha > 0.0 { alpha.recip() } else { 0.0 };
            [r * factor, g * factor, b * factor, alpha]
        };
        RenderedImage::of_pixels(size, self.pixels.iter().map(straight))
    }

    /// Returns the picture over black, as used in comparisons.
    pub fn over_black(&self, size: [u32; 2]) -> Result<RenderedImage> {
        RenderedImage::of_pixels(size, self.pixels.iter().copied())
    }
}

/// A triangle as seen from one camera.
struct Seen {
    /// Left, top, right, bottom in pixels.
    rect: [u32; 4],
    /// The weight of each corner along a ray is the dot product of the ray with one of these. All weights are above 0 inside.
    normals: [DVec3; 3],
    /// True for the edges that belong to this triangle: an edge shared by two triangles belongs to one of them.
    owns_edges: [bool; 3],
    /// Homogeneous texture coordinates.
    stq: [[f64; 3]; 3],
}

/// Draws the mesh as [`super::draw`] does, one fragment after the other.
pub fn draw_plainly(scene: &QuadMesh, camera: &Camera, size: [u32; 2]) -> Drawn {
    let [width, height] = size;
    let texels = Texels::new(scene);
    let seen: Vec<Seen> = (0..scene.mesh.triangles.len())
        .into_par_iter()
        .filter_map(|triangle| see(scene, triangle, camera, size))
        .collect();
    let draw_rows = |job: u32| {
        let (first, end) = (job * ROWS_A_JOB, ((job + 1) * ROWS_A_JOB).min(height));
        let mut pixels = vec![Vec4::ZERO; ((end - first) * width) as usize];
        let mut counts = vec![0u32; pixels.len()];
        let direction = |at: u32| {
            let (column, row) = (at % width, first + at / width);
            let centre = [f64::from(column) + 0.5, f64::from(row) + 0.5];
            camera.direction([centre[0] / f64::from(width), centre[1] / f64::from(height)])
        };
        let directions: Vec<DVec3> = (0..pixels.len() as u32).map(direction).collect();
        for triangle in &seen {
            let [left, top, right, bottom] = triangle.rect;
            for row in top.max(first)..bottom.min(end) {
                for column in left..right {
                    let index = ((row - first) * width + column) as usize;
                    let weights = triangle.normals.map(|normal| normal.dot(directions[index]));
                    if !weights
                        .iter()
                        .zip(triangle.owns_edges)
                        .all(|(&weight, owns)| weight > 0.0 || weight == 0.0 && owns)
                    {
                        continue;
                    }
                    let [s, t, q] =
                        [0, 1, 2].map(|axis| (0..3).map(|at| weights[at] * triangle.stq[at][axis]).sum::<f64>());
                    let texel = texels.sample([s / q, t / q]);
                    let light = (texel.truncate() * texel.w).extend(texel.w);
                    pixels[index] = light + (1.0 - light.w) * pixels[index];
                    counts[index] += 1;
                }
            }
        }
        (pixels, counts)
    };
    Drawn::of_rows((0..height.div_ceil(ROWS_A_JOB)).into_par_iter().map(draw_rows).collect())
}

fn see(scene: &QuadMesh, triangle: usize, camera: &Camera, size: [u32; 2]) -> Option<Seen> {
    let eye = camera.eye();
    let [a, b, c] = scene.mesh.corners(triangle).map(|corner| corner - eye);
    let rect = bounds(&[a, b, c], camera, size)?;
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    let stq = scene.mesh.triangles[triangle].map(|corner| texture_coordinates(scene, corner));
    let volume = a.dot(normals[0]);
    let normals = normals.map(|normal| normal * volume.signum());
    let owns_edges =
        normals.map(|normal| normal.to_array().into_iter().find(|at| *at != 0.0).is_some_and(|at| at > 0.0));
    (volume != 0.0).then_some(Seen { rect, normals, owns_edges, stq })
}

/// Returns the rectangle of pixels that a polygon can cover, given its corners relative to the eye; `None` if it is behind the
/// camera or outside of the image.
fn bounds(corners: &[DVec3], camera: &Camera, [width, height]: [u32; 2]) -> Option<[u32; 4]> {
    let [forward, ..] = camera.axes();
    let near = 1e-9 * corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let mut range = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    let mut add = |point: DVec3| {
        if let Some(([x, y], _)) = camera.project(point) {
            let [x, y] = [x * f64::from(width), y * f64::from(height)];
            range = [range[0].min(x), range[1].min(y), range[2].max(x), range[3].max(y)];
        }
    };
    for at in 0..corners.len() {
        let (a, b) = (corners[at], corners[(at + 1) % corners.len()]);
        let (da, db) = (a.dot(forward) - near, b.dot(forward) - near);
        if da >= 0.0 {
            add(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            add(a + da / (da - db) * (b - a));
        }
    }
    let clamp = |at: f64, side: u32| at.clamp(0.0, f64::from(side)) as u32;
    let [left, top] = [clamp(range[0].floor(), width), clamp(range[1].floor(), height)];
    let [right, bottom] = [clamp(range[2].ceil(), width), clamp(range[3].ceil(), height)];
    (left < right && top < bottom).then_some([left, top, right, bottom])
}
