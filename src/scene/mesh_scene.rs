//! A mesh with the materials used for shading, and its bounding volume hierarchy.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::mesh::{Bvh, ImageTexture, Material as PlainMaterial, Mesh, Ray, TriangleHit};

/// Specular transport at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Optics {
    #[default]
    Opaque,
    Mirror {
        /// Linear reflectance, 0..=1.
        tint: DVec3,
    },
    /// Clear glass: reflection and refraction by Fresnel's equations.
    Glass {
        /// Index of refraction, at least 1.
        ior: f64,
        /// Linear transmittance, 0..=1.
        tint: DVec3,
    },
}

/// A highlight by the normalised Phong model: `weight · (n + 2)/2 · cosⁿ` of the angle to the mirror direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Phong {
    /// Linear weight, 0..=1; zero for a matte surface.
    pub weight: DVec3,
    /// n, at least 1.
    pub exponent: f64,
}

/// Material of triangles for shading.
#[derive(Debug, Clone, Default)]
pub struct MeshMaterial {
    /// Material as in the file, except that the base colour is that of the diffuse part. Metalness, roughness, reflectance,
    /// index of refraction and transmission are not used; the fields below replace them.
    pub plain: PlainMaterial,
    pub phong: Phong,
    /// The part of the highlight's weight that is a metal's base colour; vertex colours multiply it.
    pub metal: DVec3,
    pub optics: Optics,
}

/// A mesh that rays can be traced against. Rays pass through alpha-tested holes.
#[derive(Debug, Clone)]
pub struct SceneMesh {
    pub mesh: Mesh,
    pub materials: Arc<[MeshMaterial]>,
    pub bvh: Bvh,
    /// True if any material has holes, and if any is glass.
    has_holes: bool,
    has_glass: bool,
}

impl SceneMesh {
    pub fn new(mesh: Mesh, materials: Arc<[MeshMaterial]>) -> SceneMesh {
        let bvh = Bvh::new((0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)));
        let has_holes = materials.iter().any(|material| material.plain.alpha_cutoff.is_some());
        let has_glass = materials.iter().any(|material| matches!(material.optics, Optics::Glass { .. }));
        SceneMesh { mesh, materials, bvh, has_holes, has_glass }
    }

    /// Returns the bytes of its triangles.
    pub fn bytes(&self) -> u64 {
        self.mesh.bytes() + self.bvh.bytes()
    }

    /// Returns the textures of its materials, with repetitions.
    pub fn textures(&self) -> impl Iterator<Item = &Arc<ImageTexture>> {
        self.materials
            .iter()
            .flat_map(move |material| [&material.plain.base_texture, &material.plain.emissive_texture])
            .flatten()
    }

    /// Returns the nearest triangle strictly within the range, in metres; both sides count.
    pub fn nearest(&self, ray: &Ray, range: Range<f64>) -> Option<TriangleHit> {
        self.bvh.nearest(ray, range, |hit| !self.is_hole(hit.triangle, hit.barycentric))
    }

    /// True if any triangle lies strictly within the range, in metres.
    pub fn occluded(&self, ray: &Ray, range: Range<f64>) -> bool {
        self.bvh.any(ray, range, |hit| !self.is_hole(hit.triangle, hit.barycentric))
    }

    /// [`Self::occluded`] for light, which passes through clear glass.
    pub(super) fn casts_shadow(&self, ray: &Ray, range: Range<f64>) -> bool {
        self.bvh.any(ray, range, |hit| !self.is_glass(hit.triangle) && !self.is_hole(hit.triangle, hit.barycentric))
    }

    /// Returns the material of a triangle; `None` if its index is not in the list of materials.
    pub fn material(&self, triangle: usize) -> Option<&MeshMaterial> {
        self.materials.get(*self.mesh.material_of.get(triangle)? as usize)
    }

    /// True if the material has a hole at barycentric coordinates, as for [`Mesh::uv`].
    pub fn is_hole(&self, triangle: usize, at: DVec2) -> bool {
        if !self.has_holes {
            return false;
        }
        let Some(material) = self.material(triangle).map(|material| &material.plain) else { return false };
        let Some(cutoff) = material.alpha_cutoff else { return false };
        let mut alpha = material.alpha;
        if let Some(texture) = &material.base_texture {
            alpha *= texture.sample(self.mesh.uv(triangle, at)).1;
        }
        if let Some(color) = self.mesh.color(triangle, at) {
            alpha *= color.w;
        }
        alpha < cutoff
    }

    /// True if any material is a mirror or glass.
    pub fn has_optics(&self) -> bool {
        self.materials.iter().any(|material| material.optics != Optics::Opaque)
    }

    fn is_glass(&self, triangle: usize) -> bool {
        self.has_glass
            && self.material(triangle).is_some_and(|material| matches!(material.optics, Optics::Glass { .. }))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::mesh::bvh::tests::{Numbers, brute_force};
    use crate::mesh::{ImageTexture, Wrap};

    #[test]
    #[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
    fn hits_in_files_equal_brute_force() {
        let meshes = std::path::Path::new(option_env!("LIGHTFOLD_DATA").unwrap_or("no data")).join("meshes");
        for file in ["sponza.glb", "dragon.glb", "bunny.obj"] {
            let (model, _) = crate::Model::open(&meshes.join(file), Default::default()).unwrap();
            let scene = model.at(0.0);
            let bounds = scene.bounds.unwrap();
            let mut numbers = Numbers::new(7);
            let mut anywhere = || 0.5 * (bounds.min + bounds.max) + 0.5 * (bounds.max - bounds.min) * numbers.point();
            let mut hits = 0;
            for mesh in &scene.meshes {
                let triangles: Vec<_> = (0..mesh.mesh.triangles.len()).map(|at| mesh.mesh.corners(at)).collect();
                for _ in 0..60 {
                    let (from, to) = (anywhere(), anywhere());
                    let ray = Ray::new(from, to - from).unwrap();
                    let expected = brute_force(&triangles, &ray, 0.0..f64::INFINITY);
                    assert_eq!(mesh.bvh.all(&ray, 0.0..f64::INFINITY), expected, "{file} {from} {to}");
                    let solid = |hit: &&TriangleHit| !mesh.is_hole(hit.triangle, hit.barycentric);
                    assert_eq!(mesh.nearest(&ray, 0.0..f64::INFINITY), expected.iter().find(solid).copied());
                    hits += usize::from(!expected.is_empty());
                }
            }
            assert!(hits > 10, "{file}: {hits}");
        }
    }

    #[test]
    fn glass_stops_rays_but_not_light_and_holes_stop_neither() {
        let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let behind: Vec<DVec3> = square.iter().map(|corner| corner - DVec3::Z).collect();
        let with = |material: MeshMaterial| {
            let mesh = Mesh {
                positions: [square.clone(), behind.clone()].concat(),
                uvs: vec![Vec2::ZERO; 8],
                triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
                material_of: vec![0, 0, 1, 1],
                ..Mesh::default()
            };
            SceneMesh::new(mesh, [material, MeshMaterial::default()].into())
        };
        let ray = Ray::new(DVec3::new(0.7, 0.2, 1.0), DVec3::NEG_Z).unwrap();
        let sees = |mesh: &SceneMesh| mesh.nearest(&ray, 0.0..f64::INFINITY).unwrap().triangle;
        let opaque = PlainMaterial { alpha_cutoff: Some(0.5), ..PlainMaterial::default() };
        let masked = |plain| MeshMaterial { plain, ..MeshMaterial::default() };
        let holes = |alpha| masked(PlainMaterial { alpha, ..opaque.clone() });
        assert_eq!(sees(&with(holes(0.6))), 0);
        assert_eq!(sees(&with(holes(0.4))), 2);
        assert!(!with(holes(0.4)).occluded(&ray, 0.0..1.5));
        assert!(with(holes(0.4)).occluded(&ray, 0.0..2.5));
        let texture = Arc::new(ImageTexture { width: 1, height: 1, pixels: vec![[255; 4]], wrap: [Wrap::Repeat; 2] });
        assert_eq!(sees(&with(masked(PlainMaterial { base_texture: Some(texture), ..holes(0.6).plain }))), 0);
        let glass =
            with(MeshMaterial { optics: Optics::Glass { ior: 1.5, tint: DVec3::ONE }, ..MeshMaterial::default() });
        assert_eq!(sees(&glass), 0);
        assert!(glass.occluded(&ray, 0.0..1.5));
        assert!(!glass.casts_shadow(&ray, 0.0..1.5));
        assert!(glass.casts_shadow(&ray, 0.0..2.5));
    }
}
