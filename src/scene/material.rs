//! Materials of analytic shapes. Textures are functions of the point alone, in object coordinates in metres.

use glam::DVec3;

use super::mesh_scene::{Optics, Phong};

/// A pattern of albedos in linear Rec. 709, 0..=1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texture {
    Solid(DVec3),
    Checker {
        colors: [DVec3; 2],
        /// Edge of a cube, metres.
        size: f64,
    },
    Stripes {
        colors: [DVec3; 2],
        /// Direction across the stripes; its length is the number of stripes per metre.
        wave: DVec3,
    },
    /// Rows of bricks of varying brightness in mortar, along the two axes perpendicular to the normal.
    Bricks {
        /// Mean brick colour and mortar colour.
        colors: [DVec3; 2],
        /// Length and height of a brick including its mortar, metres.
        size: [f64; 2],
        /// Width of the mortar, metres.
        joint: f64,
    },
}

impl Texture {
    pub fn albedo(&self, point: DVec3, normal: DVec3) -> DVec3 {
        match *self {
            Texture::Solid(color) => color,
            Texture::Checker { colors, size } => {
                // Shifted by half a cube, so that faces at multiples of the size do not lie on the border between two cubes.
                let cell = (point / size + 0.5).floor();
                colors[parity(cell.x + cell.y + cell.z)]
            }
            Texture::Stripes { colors, wave } => colors[parity(point.dot(wave).floor())],
            Texture::Bricks { colors, size, joint } => {
                let (along, up) = across(point, normal);
                let row = (up / size[1]).floor();
                let shifted = along / size[0] + 0.5 * parity(row) as f64;
                let column = shifted.floor();
                let in_mortar = (shifted - column) * size[0] < joint || up - row * size[1] < joint;
                if in_mortar { colors[1] } else { colors[0] * (0.75 + 0.5 * cell_noise(column, row)) }
            }
        }
    }
}

/// Returns the two coordinates perpendicular to the dominant axis of the normal: (horizontal, vertical) on walls, (x, z) on
/// floors.
fn across(point: DVec3, normal: DVec3) -> (f64, f64) {
    let n = normal.abs();
    if n.y >= n.x && n.y >= n.z {
        (point.x, point.z)
    } else if n.x >= n.z {
        (point.z, point.y)
    } else {
        (point.x, point.y)
    }
}

/// Returns 1 for an odd whole number, 0 for an even one. The cast saturates only far outside any scene.
fn parity(whole: f64) -> usize {
    (whole as i64 & 1) as usize
}

/// Returns a fixed number in 0..1 for each brick: an integer hash, the same on every machine.
fn cell_noise(column: f64, row: f64) -> f64 {
    // The casts saturate only far outside any scene.
    let mut h = (column as i32 as u32).wrapping_mul(0x9e37_79b1) ^ (row as i32 as u32).wrapping_mul(0x85eb_ca77);
    h = (h ^ (h >> 15)).wrapping_mul(0xc2b2_ae3d);
    h ^= h >> 13;
    f64::from(h >> 8) / f64::from(1_u32 << 24)
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Diffuse albedo.
    pub texture: Texture,
    /// Emitted linear radiance.
    pub emission: DVec3,
    pub phong: Phong,
    pub optics: Optics,
}

impl Material {
    pub fn diffuse(texture: Texture) -> Self {
        Material { texture, emission: DVec3::ZERO, phong: Phong::default(), optics: Optics::Opaque }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_repeat() {
        let checker = Texture::Checker { colors: [DVec3::ZERO, DVec3::ONE], size: 0.5 };
        let at = |x: f64| checker.albedo(DVec3::new(x, 0.0, 0.0), DVec3::Y);
        assert_eq!((at(0.0), at(0.5), at(1.0), at(-0.5)), (DVec3::ZERO, DVec3::ONE, DVec3::ZERO, DVec3::ONE));
        let stripes = Texture::Stripes { colors: [DVec3::ZERO, DVec3::ONE], wave: DVec3::X * 2.0 };
        let at = |x: f64| stripes.albedo(DVec3::new(x, 0.0, 0.0), DVec3::Y);
        assert_eq!((at(0.1), at(0.6), at(1.1), at(-0.1)), (DVec3::ZERO, DVec3::ONE, DVec3::ZERO, DVec3::ONE));
    }

    #[test]
    fn bricks_have_mortar_and_vary() {
        let wall = Texture::Bricks { colors: [DVec3::splat(0.4), DVec3::ONE], size: [0.4, 0.2], joint: 0.02 };
        let at = |z: f64, y: f64| wall.albedo(DVec3::new(-4.0, y, z), DVec3::X);
        assert_eq!(at(0.2, 0.01), DVec3::ONE);
        assert_eq!(at(0.01, 0.1), DVec3::ONE);
        let bricks: Vec<f64> = (0..50).map(|i| at(0.2 + 0.4 * f64::from(i), 0.1).x).collect();
        assert!(bricks.iter().all(|&b| (0.3..=0.5).contains(&b)));
        assert!(bricks.windows(2).filter(|pair| pair[0] != pair[1]).count() > 40);
    }
}
