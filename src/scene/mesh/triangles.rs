//! A triangle mesh as plain data.

use std::collections::HashMap;

use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec4};

/// Triangles in world space. Positions are f64, because f32 would move hits on large or distant meshes by more than a depth code.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners in metres. Rays miss triangles with a corner that is not finite.
    pub positions: Vec<DVec3>,
    /// Shading normal of each corner, of any length above 0; empty for flat-shaded triangles.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of each corner, with (0, 0) at the top left of an image; may be empty.
    pub uvs: Vec<Vec2>,
    /// Linear colour and alpha of each corner, 0..=1, which multiply the base colour; may be empty.
    pub colors: Vec<Vec4>,
    /// Corner indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub material_of: Vec<u32>,
}

impl Mesh {
    /// Returns the memory of the mesh in bytes.
    pub fn bytes(&self) -> u64 {
        // Destructured so that no new field is omitted.
        let Mesh { positions, normals, uvs, colors, triangles, material_of } = self;
        let sizes = [
            size_of_val(&positions[..]),
            size_of_val(&normals[..]),
            size_of_val(&uvs[..]),
            size_of_val(&colors[..]),
            size_of_val(&triangles[..]),
            size_of_val(&material_of[..]),
        ];
        sizes.iter().sum::<usize>() as u64
    }

    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.positions[corner as usize])
    }

    /// Splits each triangle into four at the midpoints of its edges. Triangles that share an edge share its midpoint. `None` if
    /// there would be more corners than indices.
    pub fn subdivided(&self) -> Option<Mesh> {
        let mut mesh = self.clone();
        (mesh.triangles, mesh.material_of) = (Vec::with_capacity(4 * self.triangles.len()), Vec::new());
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        for (&[a, b, c], &material) in self.triangles.iter().zip(&self.material_of) {
            let mut middle = |a: u32, b: u32| {
                let next = u32::try_from(mesh.positions.len()).ok()?;
                let at = *middles.entry([a.min(b), a.max(b)]).or_insert(next);
                if at == next {
                    mesh.add_between(a as usize, b as usize);
                }
                Some(at)
            };
            let [ab, bc, ca] = [middle(a, b)?, middle(b, c)?, middle(c, a)?];
            mesh.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            mesh.material_of.extend([material; 4]);
        }
        Some(mesh)
    }

    /// Adds the midpoint of two corners.
    fn add_between(&mut self, a: usize, b: usize) {
        self.positions.push(0.5 * (self.positions[a] + self.positions[b]));
        if !self.normals.is_empty() {
            // Not normalised: normals are interpolated between corners without normalisation.
            self.normals.push(0.5 * (self.normals[a] + self.normals[b]));
        }
        if !self.uvs.is_empty() {
            self.uvs.push(0.5 * (self.uvs[a] + self.uvs[b]));
        }
        if !self.colors.is_empty() {
            self.colors.push(0.5 * (self.colors[a] + self.colors[b]));
        }
    }

    /// Returns the texture coordinates at barycentric coordinates (weights of the second and third corner); (0, 0) if the mesh
    /// has none.
    pub fn uv(&self, triangle: usize, at: DVec2) -> DVec2 {
        if self.uvs.is_empty() {
            return DVec2::ZERO;
        }
        let [a, b, c] = self.triangles[triangle].map(|corner| self.uvs[corner as usize].as_dvec2());
        a + at.x * (b - a) + at.y * (c - a)
    }

    /// Returns the interpolated colour and alpha at barycentric coordinates; `None` if the mesh has none.
    pub fn color(&self, triangle: usize, at: DVec2) -> Option<DVec4> {
        if self.colors.is_empty() {
            return None;
        }
        let [a, b, c] = self.triangles[triangle].map(|corner| self.colors[corner as usize].as_dvec4());
        Some(a + at.x * (b - a) + at.y * (c - a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_triangles_fill_one_and_share_the_middles_of_edges() {
        let mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
            normals: vec![Vec3::Z, Vec3::X, Vec3::Z, Vec3::Y],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            colors: vec![Vec4::ONE, Vec4::ZERO, Vec4::ONE, Vec4::X],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material_of: vec![3, 5],
        };
        let finer = mesh.subdivided().unwrap();
        assert_eq!((finer.triangles.len(), finer.positions.len()), (8, 9));
        assert_eq!(finer.material_of, [3, 3, 3, 3, 5, 5, 5, 5]);
        let area = |mesh: &Mesh, of: std::ops::Range<usize>| -> DVec3 {
            let cross = |at| {
                let [a, b, c] = mesh.corners(at);
                (b - a).cross(c - a)
            };
            of.map(cross).sum()
        };
        for triangle in 0..2 {
            let four = 4 * triangle..4 * triangle + 4;
            assert_eq!(area(&finer, four), area(&mesh, triangle..triangle + 1));
        }
        // The attributes at the centre of the middle triangle are those at the centre of the original triangle.
        let third = DVec2::splat(1.0 / 3.0);
        assert!((finer.uv(3, third) - mesh.uv(0, third)).length() < 1e-6);
        assert!((finer.color(3, third).unwrap() - mesh.color(0, third).unwrap()).length() < 1e-6);
        assert_eq!([finer.normals.len(), finer.uvs.len(), finer.colors.len()], [9; 3]);
    }
}
