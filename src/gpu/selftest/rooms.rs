//! Textured rooms and leaves for testing the drawings.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use super::SEED;
use codec::math::random::Random;
use scene::mesh::{ImageTexture, Mesh, Wrap};
use simplify::quad_mesh::QuadMesh;

/// Width and height of the atlas in texels; it has 8 x 8 tiles of 32 x 32 texels.
const ATLAS: u32 = 256;
const TILES: u32 = 8;

/// Builds a mesh and its atlas of smooth colours: tiles with even indices are opaque, the others are leaves with soft edges.
pub(super) struct Builder {
    pub(super) mesh: Mesh,
    pub(super) stq: Vec<Vec3>,
    random: Random,
}

impl Builder {
    pub(super) fn new() -> Builder {
        Builder { mesh: Mesh::default(), stq: Vec::new(), random: Random::new(SEED) }
    }

    /// Returns a random number in -1..1.
    fn part(&mut self) -> f64 {
        f64::from(self.random.below(1 << 20)) / f64::from(1 << 19) - 1.0
    }

    /// Adds a quad, given a corner and two sides, with a tile of the atlas. The quad's corners map to centres of texels.
    fn quad(&mut self, corner: DVec3, sides: [DVec3; 2], tile: u32) {
        let first = self.mesh.positions.len() as u32;
        let side = ATLAS / TILES;
        for [x, y] in [[0u32, 0], [1, 0], [1, 1], [0, 1]] {
            let point = corner + f64::from(x) * sides[0] + f64::from(y) * sides[1];
            // Round to single precision, as in files.
            self.mesh.positions.push(point.as_vec3().as_dvec3());
            let place = [tile % TILES, tile / TILES % TILES].map(|at| (at * side) as f32 + 0.5);
            let reach = (side - 1) as f32;
            self.mesh.uvs.push(Vec2::new(place[0] + x as f32 * reach, place[1] + y as f32 * reach) / ATLAS as f32);
        }
        self.mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        self.mesh.material_of.extend([0; 2]);
    }

    /// Adds a square perpendicular to the z axis.
    pub(super) fn square(&mut self, middle: DVec3, reach: f64, tile: u32) {
        let corner = middle - reach * (DVec3::X + DVec3::Y);
        self.quad(corner, [2.0 * reach * DVec3::X, 2.0 * reach * DVec3::Y], tile);
    }

    /// Adds the six sides of a cube, each of 4 x 4 opaque tiles.
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

    /// Adds leaves in all directions, from far to near.
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

    /// Returns the mesh without the texture.
    pub(super) fn into_mesh(self) -> Mesh {
        self.mesh
    }

    pub(super) fn finish(self) -> QuadMesh {
        let side = ATLAS / TILES;
        let texel = |at: u32| {
            let (x, y) = (at % ATLAS, at / ATLAS);
            let tile = y / side * TILES + x / side;
            let place = [x % side, y % side].map(|at| f64::from(at) / f64::from(side - 1) - 0.5);
            let wave = |channel: u32| {
                // Neighbouring tiles differ little, as tiles of one surface do. A pixel on their common edge may show either of
                // them, because devices round corners to fractions of a pixel.
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
