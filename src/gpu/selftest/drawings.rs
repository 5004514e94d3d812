//! Simplified scenes and cameras for the drawings: a room of tiles, leaves in front of it, triangles through the eye.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec2, Vec3};

use super::SEED;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::harness::KernelReport;
use crate::gpu::kernels::{self, Drawing};
use crate::gpu::quads::GpuQuads;
use crate::gpu::render::agreement::Agreement;
use crate::math::random::Random;
use crate::math::{Camera, Lens};
use crate::mesh::{ImageTexture, Mesh, Wrap};
use crate::monitor::Silent;
use crate::simplify::quad_mesh::QuadMesh;
use crate::simplify::raster::{Compositing, DrawSettings, Drawn, draw_picture};

/// Texels along a side of the atlas: tiles of 32.
const ATLAS: u32 = 256;
const TILES: u32 = 8;
/// Pixels along a side of a picture.
const SIZE: u32 = 96;

#[derive(Debug)]
pub struct DrawingCase {
    pub label: &'static str,
    pub scene: QuadMesh,
    pub camera: Camera,
    pub settings: DrawSettings,
}

/// All cases; the last one is timed.
pub fn cases(compositing: Compositing) -> Result<Vec<DrawingCase>> {
    let settings = DrawSettings { size: [SIZE, SIZE - 11], compositing, samples: 1 };
    let (in_room, away) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(1e5, -2e4, 3e5));
    let case = |label, scene: &dyn Fn(&mut Builder), camera: Camera| {
        let mut builder = Builder::new();
        scene(&mut builder);
        DrawingCase { label, scene: builder.finish(), camera, settings }
    };
    let room = |builder: &mut Builder| builder.room(DVec3::ZERO, 4.0);
    let leaves = |builder: &mut Builder| {
        builder.room(DVec3::ZERO, 4.0);
        builder.leaves(60);
    };
    let homogeneous = |builder: &mut Builder| {
        builder.room(DVec3::ZERO, 4.0);
        // Weights that differ by corner: texture coordinates are not affine in the plane of a tile.
        builder.stq =
            (0..).zip(&builder.mesh.uvs).map(|(at, uv)| uv.extend(1.0) * (1.0 + 0.3 * (at % 4) as f32)).collect();
    };
    let clipped = Lens { near_m: 1.5, far_m: 4.5, ..Lens::new(80.0) };
    let mut cases = vec![
        case("no triangle in sight", &|builder| builder.square(DVec3::Z * 2.0, 0.5, 0), looking(DVec3::ZERO, 80.0)?),
        case("room", &room, looking(in_room, 80.0)?),
        case("leaves in a room", &leaves, looking(DVec3::new(0.1, 0.2, 0.3), 80.0)?),
        case("a narrow view", &leaves, looking(DVec3::ZERO, 4.0)?),
        case("tiles beside and behind the eye", &leaves, looking(DVec3::new(3.9, 3.9, -3.9), 130.0)?),
        case("far from the origin", &|builder| builder.room(away, 4.0), looking(away + in_room, 80.0)?),
        case("near and far planes", &leaves, {
            Camera::look_at(DVec3::ZERO, DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, clipped)?
        }),
        case("an image off its axis", &leaves, looking(DVec3::ZERO, 70.0)?.off_axis([0.3, -0.2])?),
        case("homogeneous texture coordinates", &homogeneous, looking(DVec3::ZERO, 70.0)?),
        case("several samples", &leaves, looking(DVec3::new(0.1, 0.2, 0.3), 80.0)?),
        case("leaves, four times as wide", &leaves, looking(DVec3::new(-0.2, 0.1, 0.3), 80.0)?),
    ];
    cases[9].settings.samples = 2;
    cases[10].settings.size = [4 * SIZE, 4 * SIZE];
    Ok(cases)
}

#[derive(Debug, Clone)]
pub struct DrawingResult {
    pub agreement: Agreement,
    pub on_device: Drawn,
    pub on_cpu: Drawn,
}

pub fn run(gpu: &Gpu, case: &DrawingCase) -> Result<DrawingResult> {
    let on_device = GpuQuads::new(gpu, &case.scene)?.draw(&case.camera, &case.settings, &Silent)?;
    let on_cpu = draw_picture(&case.scene, &case.camera, &case.settings, &Silent)?;
    let [found, expected] = [&on_device, &on_cpu].map(|drawn| drawn.over_black(case.settings.size));
    let agreement = Agreement::of_images(&found?, &expected?, [on_device.fragments, on_cpu.fragments])?;
    Ok(DrawingResult { agreement, on_device, on_cpu })
}

/// Runs the pictures that a drawing takes part in.
pub fn test_drawing(gpu: &Gpu, drawing: &'static Drawing) -> Result<KernelReport> {
    #[cfg(feature = "epipolar")]
    if drawing.name == kernels::TRIANGLES.name {
        return super::triangles::test(gpu, drawing.name);
    }
    let mut report = KernelReport::new(drawing.name);
    // Fragments are counted by a drawing of their own where depth hides some.
    let is_painter = drawing.name == kernels::QUADS_PAINTER.name;
    let cases = cases(if is_painter { Compositing::Painter } else { Compositing::ZBuffer })?;
    for case in &cases {
        let agreement = run(gpu, case)?.agreement;
        report.inputs += 1;
        report.mismatches += agreement.mismatches();
        if agreement.mismatches() > 0 && report.first.is_none() {
            report.first = Some(format!("{}: {agreement:?}", case.label));
        }
    }
    if let Some(case) = cases.last() {
        let quads = GpuQuads::new(gpu, &case.scene)?;
        let start = Instant::now();
        quads.draw(&case.camera, &case.settings, &Silent)?;
        let pixels = f64::from(case.settings.size[0]) * f64::from(case.settings.size[1]);
        report.megapixels_per_second = pixels / 1e6 / start.elapsed().as_secs_f64().max(1e-9);
    }
    Ok(report)
}

fn looking(eye: DVec3, fov_y_deg: f64) -> Result<Camera> {
    let lens = Lens { aspect: 1.13, ..Lens::new(fov_y_deg) };
    Camera::look_at(eye, eye + DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, lens)
}

/// Tiles of an atlas of smooth colours: those of even numbers are opaque, others are leaves with soft edges.
pub(super) struct Builder {
    mesh: Mesh,
    stq: Vec<Vec3>,
    random: Random,
}

impl Builder {
    pub(super) fn new() -> Builder {
        Builder { mesh: Mesh::default(), stq: Vec::new(), random: Random::new(SEED) }
    }

    /// A number in -1..1.
    fn part(&mut self) -> f64 {
        f64::from(self.random.below(1 << 20)) / f64::from(1 << 19) - 1.0
    }

    /// A quad from a corner along two sides, with a tile of the atlas; corners of the tile are centres of texels.
    fn quad(&mut self, corner: DVec3, sides: [DVec3; 2], tile: u32) {
        let first = self.mesh.positions.len() as u32;
        let side = ATLAS / TILES;
        for [x, y] in [[0u32, 0], [1, 0], [1, 1], [0, 1]] {
            let point = corner + f64::from(x) * sides[0] + f64::from(y) * sides[1];
            // As files hold it.
            self.mesh.positions.push(point.as_vec3().as_dvec3());
            let place = [tile % TILES, tile / TILES % TILES].map(|at| (at * side) as f32 + 0.5);
            let reach = (side - 1) as f32;
            self.mesh.uvs.push(Vec2::new(place[0] + x as f32 * reach, place[1] + y as f32 * reach) / ATLAS as f32);
        }
        self.mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        self.mesh.material_of.extend([0; 2]);
    }

    /// A square across the z axis.
    fn square(&mut self, middle: DVec3, reach: f64, tile: u32) {
        let corner = middle - reach * (DVec3::X + DVec3::Y);
        self.quad(corner, [2.0 * reach * DVec3::X, 2.0 * reach * DVec3::Y], tile);
    }

    /// The sides of a cube, each of 4 x 4 opaque tiles.
    pub(super) fn room(&mut self, middle: DVec3, reach: f64) {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for side in 0..6 {
            let (across, down) = (axes[(side + 1) % 3], axes[(side + 2) % 3]);
            let normal = axes[side % 3] * if side < 3 { 1.0 } else { -1.0 };
            for at in 0..16 {
                let [x, y] = [at % 4, at / 4].map(|at| f64::from(at) / 2.0 - 1.0);
                let corner = middle + reach * (normal + x * across + y * down);
                let tile = 2 * self.random.below(TILES * TILES / 2);
                self.quad(corner, [across, down].map(|axis| axis * reach / 2.0), tile);
            }
        }
    }

    /// Leaves in all directions, from far to near.
    pub(super) fn leaves(&mut self, count: u32) {
        for at in 0..count {
            let distance = 3.5 - 2.5 * f64::from(at) / f64::from(count);
            let direction = DVec3::new(self.part(), self.part(), self.part()).normalize_or(DVec3::X);
            let across = direction.any_orthonormal_vector();
            let sides = [across, direction.cross(across) + 0.5 * self.part() * direction].map(|side| 0.7 * side);
            let tile = 2 * self.random.below(TILES * TILES / 2) + 1;
            self.quad(distance * direction - 0.5 * (sides[0] + sides[1]), sides, tile);
        }
    }

    /// The triangles alone.
    pub(super) fn into_mesh(self) -> Mesh {
        self.mesh
    }

    fn finish(self) -> QuadMesh {
        let side = ATLAS / TILES;
        let texel = |at: u32| {
            let (x, y) = (at % ATLAS, at / ATLAS);
            let tile = y / side * TILES + x / side;
            let place = [x % side, y % side].map(|at| f64::from(at) / f64::from(side - 1) - 0.5);
            let wave = |channel: u32| {
                // Neighbours differ by little, as tiles of one surface do: a pixel on their edge may show either, as devices round
                // corners to parts of a pixel.
                let turn = 0.1 * f64::from(tile % 5 + channel) + f64::from(channel + 1) * place[0] * place[1];
                (127.5 + 110.0 * turn.sin()) as u8
            };
            let edge = 0.45 - (place[0] * place[0] + place[1] * place[1]).sqrt();
            let alpha =
                if tile.is_multiple_of(2) { 255 } else { (255.0 * (0.5 + 10.0 * edge)).clamp(0.0, 255.0) as u8 };
            [wave(0), wave(1), wave(2), alpha]
        };
        let pixels = (0..ATLAS * ATLAS).map(texel).collect();
        let texture = ImageTexture { width: ATLAS, height: ATLAS, pixels, wrap: [Wrap::Clamp; 2] };
        QuadMesh { mesh: self.mesh, texture: Arc::new(texture), stq: self.stq, light: None, runs: Vec::new() }
    }
}
