//! Joins parts in world space into one [`Mesh`], without triangles that rays cannot hit: those with a corner that is not finite,
//! and those without area.

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::triangles::Mesh;
use codec::error::counted;

#[derive(Debug)]
pub struct Part<'a> {
    /// World space, metres.
    pub positions: &'a [DVec3],
    /// Normals of any length; empty for a flat-shaded part.
    pub normals: &'a [DVec3],
    pub uvs: &'a [Vec2],
    pub colors: &'a [Vec4],
    pub triangles: &'a [[u32; 3]],
    pub material: u32,
    pub winding: Winding,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Winding {
    /// Counter-clockwise seen from outside.
    Outward,
    /// Clockwise seen from outside.
    Mirrored,
}

/// Vertex attributes of a mesh: those that any of its parts has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Channels {
    /// Parts without normals get separate corners for each triangle.
    pub normals: bool,
    pub uvs: bool,
    /// Parts without colours are white.
    pub colors: bool,
}

/// Numbers of omitted triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    pub not_finite: usize,
    pub no_area: usize,
}

impl LeftOut {
    pub fn add(&mut self, other: LeftOut) {
        self.not_finite += other.not_finite;
        self.no_area += other.no_area;
    }

    pub fn note(&self, notes: &mut Vec<String>) {
        let why = ["with a vertex that is not finite", "without area"];
        for (count, why) in [self.not_finite, self.no_area].into_iter().zip(why).filter(|(count, _)| *count > 0) {
            notes.push(format!("left out: {} {why}", counted(count as u64, "triangle")));
        }
    }
}

#[derive(Debug)]
pub struct Assembly {
    mesh: Mesh,
    channels: Channels,
    pub left_out: LeftOut,
}

const UNUSED: u32 = u32::MAX;

impl Assembly {
    pub fn new(channels: Channels) -> Assembly {
        Assembly { mesh: Mesh::default(), channels, left_out: LeftOut::default() }
    }

    /// Adds a part. Corner indices fit into `u32`, because [`super::budget`] allows no more corners.
    pub fn add(&mut self, part: &Part) {
        let smooth = self.channels.normals && !part.normals.is_empty();
        let welded = smooth || !self.channels.normals;
        let mut numbers = vec![UNUSED; if welded { part.positions.len() } else { 0 }];
        for &triangle in part.triangles {
            let corners = triangle.map(|corner| part.positions[corner as usize]);
            let Some(across) = self.face_normal(corners) else { continue };
            let facing = if part.winding == Winding::Mirrored { -across } else { across };
            let mut made = triangle.map(|corner| {
                let at = corner as usize;
                if welded && numbers[at] != UNUSED {
                    return numbers[at];
                }
                let normal = part.normals.get(at).and_then(|normal| normal.try_normalize()).unwrap_or(facing);
                let number = self.push(part.positions[at], normal.as_vec3(), part.uvs.get(at).copied());
                if self.channels.colors {
                    self.mesh.colors.push(part.colors.get(at).copied().unwrap_or(Vec4::ONE));
                }
                if welded {
                    numbers[at] = number;
                }
                number
            });
            if part.winding == Winding::Mirrored {
                made.swap(1, 2);
            }
            self.mesh.triangles.push(made);
            self.mesh.material_of.push(part.material);
        }
    }

    /// Returns the unit normal of a triangle. Counts a triangle that is not finite or has no area, and returns none.
    fn face_normal(&mut self, [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
        let across = (b - a).cross(c - a);
        if ![a, b, c, across].iter().all(|vector| vector.is_finite()) {
            self.left_out.not_finite += 1;
            return None;
        }
        // Scaled first, because squares of tiny or huge components underflow or overflow.
        let normal = (across / across.abs().max_element()).try_normalize();
        self.left_out.no_area += usize::from(normal.is_none());
        normal
    }

    fn push(&mut self, position: DVec3, normal: Vec3, uv: Option<Vec2>) -> u32 {
        let number = self.mesh.positions.len() as u32;
        self.mesh.positions.push(position);
        if self.channels.normals {
            self.mesh.normals.push(normal);
        }
        if self.channels.uvs {
            self.mesh.uvs.push(uv.filter(|uv| uv.is_finite()).unwrap_or(Vec2::ZERO));
        }
        number
    }

    pub fn finish(mut self) -> Mesh {
        self.mesh.positions.shrink_to_fit();
        self.mesh.normals.shrink_to_fit();
        self.mesh.uvs.shrink_to_fit();
        self.mesh.colors.shrink_to_fit();
        self.mesh.triangles.shrink_to_fit();
        self.mesh.material_of.shrink_to_fit();
        self.mesh
    }
}
