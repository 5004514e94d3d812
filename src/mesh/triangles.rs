//! A triangle mesh as plain data.

use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec4};

/// Triangles in world space. Positions are f64: f32 would move hits of large or distant meshes by more than a depth
/// code.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners, metres. Rays miss triangles with a corner that is not finite.
    pub positions: Vec<DVec3>,
    /// Shading normal of each corner, of any length above 0; empty for flat triangles.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of each corner, (0, 0) the top left of an image, or empty.
    pub uvs: Vec<Vec2>,
    /// Colour and alpha of each corner, linear, 0..=1, which multiply the base colour; or empty.
    pub colors: Vec<Vec4>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub material_of: Vec<u32>,
}

impl Mesh {
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.positions[corner as usize])
    }

    /// Texture coordinates at barycentric coordinates (weights of the second and third corner); (0, 0) without any.
    pub fn uv(&self, triangle: usize, at: DVec2) -> DVec2 {
        if self.uvs.is_empty() {
            return DVec2::ZERO;
        }
        let [a, b, c] = self.triangles[triangle].map(|corner| self.uvs[corner as usize].as_dvec2());
        a + at.x * (b - a) + at.y * (c - a)
    }

    /// Interpolated colour and alpha at barycentric coordinates; `None` without any.
    pub fn color(&self, triangle: usize, at: DVec2) -> Option<DVec4> {
        if self.colors.is_empty() {
            return None;
        }
        let [a, b, c] = self.triangles[triangle].map(|corner| self.colors[corner as usize].as_dvec4());
        Some(a + at.x * (b - a) + at.y * (c - a))
    }
}
