//! Draws a textured mesh in the order of its triangles, on the CPU (Seurat 6).
//!
//! Triangles are not culled and not clipped: the ray of a pixel meets the plane of a triangle, and signs of three volumes say whether it
//! meets the triangle.

use glam::{DVec3, Vec4};
use half::f16;
use rayon::prelude::*;

use super::quad_mesh::QuadMesh;
use crate::image::Transfer;
use crate::math::Camera;

/// Rows that one job draws.
const ROWS_A_JOB: u32 = 16;

/// What was drawn.
#[derive(Debug)]
pub struct Drawn {
    /// Linear light multiplied by alpha, and alpha.
    pub pixels: Vec<[f32; 4]>,
    /// Triangles drawn over each pixel, in all.
    pub fragments: u64,
    /// And at most.
    pub most_fragments: u32,
}

/// A triangle as one camera sees it.
struct Seen {
    /// Left, top, right, bottom in pixels.
    rect: [u32; 4],
    /// The weight of a corner along a ray is its dot product with one of them; all are above 0 inside.
    normals: [DVec3; 3],
    /// Which edges belong to this triangle: an edge of two triangles belongs to one of them.
    owns_edges: [bool; 3],
    /// Homogeneous texture coordinates.
    stq: [[f64; 3]; 3],
}

/// Draws the mesh over a transparent picture.
pub fn draw(scene: &QuadMesh, camera: &Camera, size: [u32; 2]) -> Drawn {
    let [width, height] = size;
    let decode: Vec<f32> = (0..256).map(|code| Transfer::Srgb.decode(f64::from(code) / 255.0) as f32).collect();
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
                    let light = sample(scene, &decode, [s / q, t / q]);
                    pixels[index] = light + (1.0 - light.w) * pixels[index];
                    counts[index] += 1;
                }
            }
        }
        (pixels, counts)
    };
    let rows: Vec<_> = (0..height.div_ceil(ROWS_A_JOB)).into_par_iter().map(draw_rows).collect();
    let counts = || rows.iter().flat_map(|(_, counts)| counts);
    Drawn {
        fragments: counts().map(|&count| u64::from(count)).sum(),
        most_fragments: counts().copied().max().unwrap_or(0),
        pixels: rows.iter().flat_map(|(pixels, _)| pixels.iter().map(|pixel| pixel.to_array())).collect(),
    }
}

/// Bilinear, in linear light, multiplied by alpha.
fn sample(scene: &QuadMesh, decode: &[f32], [u, v]: [f64; 2]) -> Vec4 {
    let texture = &scene.texture;
    let place = |at: f64, side: u32| {
        let at = (at * f64::from(side) - 0.5).clamp(0.0, f64::from(side - 1)) as f32;
        let first = at as u32;
        (first, (first + 1).min(side - 1), at - first as f32)
    };
    let ((left, right, along), (top, bottom, down)) = (place(u, texture.width), place(v, texture.height));
    let texel = |x: u32, y: u32| {
        let at = (y * texture.width + x) as usize;
        let [r, g, b, alpha] = texture.pixels[at];
        let [r, g, b] = match &scene.light {
            Some(light) => light[at].map(f16::to_f32),
            None => [r, g, b].map(|code| decode[code as usize]),
        };
        Vec4::new(r, g, b, f32::from(alpha) / 255.0)
    };
    let upper = texel(left, top).lerp(texel(right, top), along);
    let lower = texel(left, bottom).lerp(texel(right, bottom), along);
    let light = upper.lerp(lower, down);
    (light.truncate() * light.w).extend(light.w)
}

fn see(scene: &QuadMesh, triangle: usize, camera: &Camera, size: [u32; 2]) -> Option<Seen> {
    let eye = camera.eye();
    let [a, b, c] = scene.mesh.corners(triangle).map(|corner| corner - eye);
    let rect = bounds(&[a, b, c], camera, size)?;
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    let stq = scene.mesh.triangles[triangle].map(|corner| match scene.stq.get(corner as usize) {
        Some(stq) => stq.as_dvec3().to_array(),
        None => scene.mesh.uvs[corner as usize].as_dvec2().extend(1.0).to_array(),
    });
    let volume = a.dot(normals[0]);
    let normals = normals.map(|normal| normal * volume.signum());
    let owns_edges =
        normals.map(|normal| normal.to_array().into_iter().find(|at| *at != 0.0).is_some_and(|at| at > 0.0));
    (volume != 0.0).then_some(Seen { rect, normals, owns_edges, stq })
}

/// Pixels that a polygon can cover, of corners relative to the eye; none where it lies behind the camera or beside the image.
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Lens;
    use crate::mesh::{ImageTexture, Mesh, Wrap};

    /// A square across the view at a distance, half as wide as the picture, of one colour.
    fn square(mesh: &mut Mesh, distance: f64, texel: f32) {
        let first = mesh.positions.len() as u32;
        for [x, y] in [[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]] {
            mesh.positions.push(DVec3::new(x, y, -1.0) * distance);
            mesh.uvs.push(glam::Vec2::new(texel, 0.5));
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.material_of.extend([0, 0]);
    }

    fn scene(mesh: Mesh) -> QuadMesh {
        let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 128]];
        let texture = ImageTexture { width: 2, height: 1, pixels, wrap: [Wrap::Clamp; 2] };
        QuadMesh { mesh, texture: Arc::new(texture), stq: Vec::new(), light: None, runs: Vec::new() }
    }

    fn camera(eye: DVec3, target: DVec3) -> Camera {
        Camera::look_at(eye, target, DVec3::Y, Lens::new(90.0)).unwrap()
    }

    #[test]
    fn later_triangles_are_blended_over_earlier_ones() {
        let mut mesh = Mesh::default();
        // The nearer one comes first: order decides, not depth.
        square(&mut mesh, 1.0, 0.25);
        square(&mut mesh, 3.0, 0.75);
        let drawn = draw(&scene(mesh), &camera(DVec3::ZERO, DVec3::NEG_Z), [16, 16]);
        assert_eq!((drawn.fragments, drawn.most_fragments), (2 * 8 * 8, 2));
        let alpha = 128.0 / 255.0;
        for (at, pixel) in drawn.pixels.iter().enumerate() {
            let is_inside = [at % 16, at / 16].iter().all(|place| (4..12).contains(place));
            let wanted = if is_inside { [1.0 - alpha, alpha, 0.0, 1.0] } else { [0.0; 4] };
            assert!(pixel.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5), "{at}: {pixel:?}");
        }
    }

    #[test]
    fn homogeneous_texture_coordinates_are_those_of_the_plane_of_a_face() {
        // A quad that goes away from the eye, whose texture is a ramp over the picture.
        let mut mesh = Mesh::default();
        let corners = [([-1.0, 1.0], 1.0), ([1.0, 1.0], 4.0), ([1.0, -1.0], 4.0), ([-1.0, -1.0], 1.0)];
        for ([x, y], depth) in corners {
            mesh.positions.push(DVec3::new(x, y, -1.0) * depth);
            mesh.uvs.push(glam::Vec2::new(0.5 + 0.25 * x as f32, 0.5));
        }
        (mesh.triangles, mesh.material_of) = (vec![[0, 1, 2], [0, 2, 3]], vec![0, 0]);
        let stq = mesh.uvs.iter().zip(corners).map(|(uv, (_, depth))| uv.extend(1.0) * depth as f32).collect();
        let pixels = vec![[0, 0, 0, 255], [255; 4]];
        let texture = ImageTexture { width: 2, height: 1, pixels, wrap: [Wrap::Clamp; 2] };
        let light = Some(vec![[f16::ZERO; 3], [f16::from_f32(8.0); 3]]);
        let mut scene = QuadMesh { mesh, texture: Arc::new(texture), stq, light, runs: Vec::new() };
        let error = |scene: &QuadMesh| {
            let drawn = draw(scene, &camera(DVec3::ZERO, DVec3::NEG_Z), [16, 16]);
            assert_eq!(drawn.fragments, 256);
            let wanted = |at: usize| 8.0 * ((at % 16) as f32 + 0.5) / 16.0;
            drawn.pixels.iter().enumerate().map(|(at, pixel)| (pixel[0] - wanted(at)).abs()).fold(0.0, f32::max)
        };
        assert!(error(&scene) < 1e-4, "{}", error(&scene));
        scene.stq.clear();
        assert!(error(&scene) > 1.0, "{}", error(&scene));
    }

    #[test]
    fn triangles_are_seen_from_both_sides_and_not_behind_the_eye() {
        let mut mesh = Mesh::default();
        square(&mut mesh, 2.0, 0.25);
        let scene = scene(mesh);
        let seen = |eye: DVec3, target: DVec3| draw(&scene, &camera(eye, target), [16, 16]).fragments;
        assert_eq!(seen(DVec3::ZERO, DVec3::Z), 0);
        assert_eq!(seen(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO), 64);
        // An eye so near that the square goes on behind it, and one in its plane.
        assert!(seen(DVec3::new(0.0, 0.3, -1.999), DVec3::new(0.0, 0.2, -2.1)) > 128);
        assert_eq!(seen(DVec3::new(0.0, 0.0, -2.0), DVec3::new(1.0, 0.0, -2.0)), 0);
    }

    #[test]
    fn the_two_triangles_of_a_square_share_no_pixel_and_leave_none() {
        let mut mesh = Mesh::default();
        square(&mut mesh, 2.0, 0.25);
        let scene = scene(mesh);
        for step in 0..20 {
            let turn = f64::from(step) * 0.31;
            let eye = DVec3::new(0.3 * turn.cos(), 0.3 * turn.sin(), 0.1);
            let drawn = draw(&scene, &camera(eye, DVec3::new(0.01, 0.02, -2.0)), [61, 61]);
            // No more than the corners lie on the diagonal exactly.
            assert!(drawn.most_fragments == 1, "{step}");
            assert_eq!(drawn.fragments, drawn.pixels.iter().filter(|pixel| pixel[3] > 0.0).count() as u64);
        }
    }
}
