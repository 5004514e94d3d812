//! One mesh of many parts.
//!
//! Enters: parts as a file has them, already in the world. Leaves: a [`Mesh`] without what rays cannot meet: triangles
//! with a corner that is not finite, or without area.

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::triangles::Mesh;

/// A part of a scene at one moment.
#[derive(Debug)]
pub struct Part<'a> {
    /// Corners in the world, metres.
    pub positions: &'a [DVec3],
    /// Normals of the corners, of any length; empty for a part that is flat.
    pub normals: &'a [DVec3],
    /// Texture coordinates, or empty.
    pub uvs: &'a [Vec2],
    /// Colours of the corners, or empty.
    pub colors: &'a [Vec4],
    /// Corners of the triangles, all of them within `positions`.
    pub triangles: &'a [[u32; 3]],
    /// Index of the material.
    pub material: u32,
    /// Whether corners run the other way round, as in a mirror.
    pub winding: Winding,
}

/// Which way round the corners of triangles are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Winding {
    /// Counter-clockwise from outside.
    Outward,
    /// Clockwise.
    Mirrored,
}

/// What a mesh holds for each corner besides its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Channels {
    /// Normals: some part has some. Parts without any are cut into single triangles, so that they are flat.
    pub normals: bool,
    /// Texture coordinates: some part has some.
    pub uvs: bool,
    /// Colours: some part has some. Others are white.
    pub colors: bool,
}

/// Triangles that were left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// A corner is not finite.
    pub not_finite: usize,
    /// No area.
    pub no_area: usize,
}

impl LeftOut {
    /// More of it.
    pub fn add(&mut self, other: LeftOut) {
        self.not_finite += other.not_finite;
        self.no_area += other.no_area;
    }

    /// Sentences about it, if there is anything.
    pub fn note(&self, notes: &mut Vec<String>) {
        if self.not_finite > 0 {
            notes.push(format!("{} triangles are left out: a corner is not a finite number", self.not_finite));
        }
        if self.no_area > 0 {
            notes.push(format!("{} triangles are left out: they have no area", self.no_area));
        }
    }
}

/// A mesh in the making.
#[derive(Debug)]
pub struct Assembly {
    mesh: Mesh,
    channels: Channels,
    /// What was left out so far.
    pub left_out: LeftOut,
}

const UNUSED: u32 = u32::MAX;

impl Assembly {
    /// An empty mesh.
    pub fn new(channels: Channels) -> Assembly {
        Assembly { mesh: Mesh::default(), channels, left_out: LeftOut::default() }
    }

    /// Adds a part. What [`super::budget`] allows has fewer corners than there are numbers for them.
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

    /// Normal of a triangle that can be met, length 1.
    fn face_normal(&mut self, [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
        if ![a, b, c].iter().all(|corner| corner.is_finite()) {
            self.left_out.not_finite += 1;
            return None;
        }
        let across = (b - a).cross(c - a);
        if !across.is_finite() {
            self.left_out.not_finite += 1;
            return None;
        }
        // Divided by its size first: squares of what is tiny or huge are 0 or infinite.
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

    /// The mesh.
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
