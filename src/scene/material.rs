//! Materials of analytic shapes. Textures are functions of the point alone, in object coordinates in metres.

use glam::DVec3;

use super::mesh_scene::{Optics, Phong};
use super::noise::{cell_noise, fractal, smooth};

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
    /// Wooden planks along the first of the two axes perpendicular to the normal; each has its own brightness and grain.
    Planks {
        /// Early wood, and late wood and joints.
        colors: [DVec3; 2],
        /// Length and width of a plank including its joint, metres.
        size: [f64; 2],
        /// Width of the joint, metres.
        joint: f64,
    },
    /// Smooth noise between two colours: plaster, stone, foliage.
    Mottled {
        colors: [DVec3; 2],
        /// Size of the largest stains, metres.
        size: f64,
    },
    /// Square tiles with a diamond in a ring, on a plane perpendicular to an axis.
    Tiles {
        /// Ground, ornament and joint.
        colors: [DVec3; 3],
        /// Edge of a tile including its joint, metres.
        size: f64,
        /// Width of the joint, metres.
        joint: f64,
    },
    /// Striped cloth with visible threads.
    Cloth {
        colors: [DVec3; 2],
        /// Direction across the stripes; its length is the number of stripes per metre.
        wave: DVec3,
        /// Direction along the stripes; its length is the number of threads per metre.
        weft: DVec3,
    },
    /// Line segments with round ends on a plain ground, such as lettering.
    Strokes {
        /// Ground and strokes.
        colors: [DVec3; 2],
        /// Ends of the segments in metres along the two axes perpendicular to the normal.
        segments: &'static [Segment],
        /// Width of a stroke, metres.
        width: f64,
    },
}

/// Two ends of a line segment.
pub type Segment = [[f64; 2]; 2];

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
            Texture::Planks { colors, size, joint } => planks(across(point, normal), colors, size, joint),
            Texture::Mottled { colors, size } => {
                let (along, up) = across(point, normal);
                colors[0].lerp(colors[1], fractal(along / size, up / size))
            }
            Texture::Tiles { colors, size, joint } => tiles(across(point, normal), colors, size, joint),
            Texture::Cloth { colors, wave, weft } => {
                let (stripe, thread) = (point.dot(wave), point.dot(weft));
                // Threads are darker towards their edges.
                let shade = 1.0 - 0.35 * (2.0 * thread.rem_euclid(1.0) - 1.0).powi(2);
                colors[parity(stripe.floor())] * (shade * (0.9 + 0.2 * smooth(stripe * 1.7, thread * 0.23)))
            }
            Texture::Strokes { colors, segments, width } => {
                let (along, up) = across(point, normal);
                let near = |segment: &Segment| squared_distance([along, up], segment) < 0.25 * width * width;
                colors[usize::from(segments.iter().any(near))]
            }
        }
    }
}

fn planks((along, up): (f64, f64), colors: [DVec3; 2], size: [f64; 2], joint: f64) -> DVec3 {
    let row = (up / size[1]).floor();
    let shifted = along / size[0] + cell_noise(row, 17.0);
    let column = shifted.floor();
    if (shifted - column) * size[0] < joint || up - row * size[1] < joint {
        return 0.3 * colors[1];
    }
    let own = cell_noise(column, row);
    // Annual rings are bent slowly along the plank; fibres are a hundred times as long as wide.
    let (along, up) = (along + 31.0 * own, up + 7.0 * own);
    let ring = 22.0 * up + 2.2 * smooth(1.1 * along, 5.0 * up);
    let late = (ring - ring.floor()).powi(2);
    let fibre = smooth(4.0 * along, 260.0 * up);
    colors[0].lerp(colors[1], 0.65 * late + 0.35 * fibre) * (0.8 + 0.4 * own)
}

fn tiles((along, up): (f64, f64), colors: [DVec3; 3], size: f64, joint: f64) -> DVec3 {
    let (column, row) = ((along / size).floor(), (up / size).floor());
    let (x, y) = (along - column * size, up - row * size);
    if x < joint || y < joint {
        return colors[2];
    }
    // From the middle of the tile, in half tiles.
    let [x, y] = [x, y].map(|at| ((at - 0.5 * joint) / (0.5 * size) - 1.0).abs());
    let (radius, diamond) = (x.hypot(y), x + y);
    let corner = (1.0 - x).hypot(1.0 - y);
    let is_ornament = diamond < 0.34 || (0.56..0.72).contains(&radius) || corner < 0.3;
    colors[usize::from(is_ornament)] * (0.9 + 0.2 * cell_noise(column, row))
}

fn squared_distance(point: [f64; 2], [from, to]: &Segment) -> f64 {
    let [along, to_point] = [*to, point].map(|end| [end[0] - from[0], end[1] - from[1]]);
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    // A segment without length is a dot.
    let share = (dot(to_point, along) / dot(along, along).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let off = [to_point[0] - share * along[0], to_point[1] - share * along[1]];
    dot(off, off)
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

    #[test]
    fn planks_have_joints_and_differ() {
        let floor = Texture::Planks { colors: [DVec3::ONE, DVec3::splat(0.5)], size: [1.0, 0.1], joint: 0.01 };
        let at = |x: f64, z: f64| floor.albedo(DVec3::new(x, 2.0, z), DVec3::Y).x;
        assert_eq!(at(0.4, 0.005), 0.15);
        let across: Vec<f64> = (0..40).map(|row| at(0.4, 0.05 + 0.1 * f64::from(row))).collect();
        assert!(across.iter().all(|&albedo| (0.4..=1.2).contains(&albedo) || albedo == 0.15), "{across:?}");
        assert!(across.windows(2).all(|pair| pair[0] != pair[1]));
        // The grain runs along the planks.
        let changes = |step: [f64; 2]| (at(0.42, 0.05) - at(0.42 + step[0], 0.05 + step[1])).abs();
        assert!(changes([0.004, 0.0]) < 0.5 * changes([0.0, 0.004]), "{:?}", [[0.004, 0.0], [0.0, 0.004]].map(changes));
    }

    #[test]
    fn noise_stays_between_its_colors() {
        let plaster = Texture::Mottled { colors: [DVec3::splat(0.2), DVec3::splat(0.6)], size: 0.3 };
        let all: Vec<f64> =
            (0..900).map(|i| plaster.albedo(DVec3::new(0.07 * f64::from(i), 0.3, 1.0), DVec3::Z).x).collect();
        let [low, high] = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| all.iter().copied().reduce(of).unwrap());
        assert!((0.2..0.35).contains(&low) && (0.45..0.6).contains(&high), "{low} {high}");
    }

    #[test]
    fn tiles_and_cloth_repeat() {
        let tiles = Texture::Tiles { colors: [DVec3::X, DVec3::Y, DVec3::Z], size: 0.1, joint: 0.01 };
        let at = |x: f64, y: f64| tiles.albedo(DVec3::new(x, y, 0.0), DVec3::Z);
        for [x, y] in [[0.0, 0.0], [0.2, -0.3]] {
            assert_eq!(at(x + 0.005, y + 0.05), DVec3::Z);
            assert!(at(x + 0.055, y + 0.055).y > 0.5 && at(x + 0.075, y + 0.055).x > 0.5);
        }
        let cloth = Texture::Cloth { colors: [DVec3::X, DVec3::Y], wave: DVec3::X * 5.0, weft: DVec3::Y * 100.0 };
        let at = |x: f64| cloth.albedo(DVec3::new(x, 0.005, 0.0), DVec3::Z);
        assert!(at(0.1).x > 0.5 && at(0.3).y > 0.5 && at(0.5).x > 0.5 && at(-0.1).y > 0.5);
    }

    #[test]
    fn strokes_have_round_ends() {
        const LINES: [Segment; 2] = [[[0.0, 0.0], [1.0, 0.0]], [[3.0, 1.0], [3.0, 1.0]]];
        let sign = Texture::Strokes { colors: [DVec3::ZERO, DVec3::ONE], segments: &LINES, width: 0.2 };
        let at = |x: f64, y: f64| sign.albedo(DVec3::new(x, y, 5.0), DVec3::Z) == DVec3::ONE;
        assert!(at(0.5, 0.09) && at(-0.09, 0.0) && at(3.0, 1.09) && at(2.93, 0.93));
        assert!(!at(0.5, 0.11) && !at(-0.08, 0.08) && !at(1.5, 0.0) && !at(2.91, 0.91));
    }
}
