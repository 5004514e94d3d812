//! A scene frozen at one time: nearest hit of a ray, and visibility between two points.
//!
//! The same scene and ray give the same bits, so that what neither moves nor is relit is exactly static. Static objects
//! are in meshes that all times share; moving ones get a new tree for each time.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use super::shadow_grid::ShadowGrid;
use super::{Light, Object, SceneMesh};
use crate::mesh::{AxisBox, Bvh, ImageTexture, Intersection, Ray, TriangleHit};

/// Offset of ray origins from the surface that they leave, in metres, for a scene that is `size` metres across: a
/// micrometre from 1 to 100 m, a millionth of smaller scenes, a hundred-millionth of larger ones.
fn lift_m(size: f64) -> f64 {
    if size < 1.0 { 1e-6 * size } else { f64::max(1e-6, 1e-8 * size) }
}

/// Which rays light costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightRays {
    /// Whether suns and lamps cast shadows.
    pub shadows: bool,
    /// Rays that measure how open the surroundings of a point are to ambient light; 0 for none, where all are.
    pub occlusion: u32,
}

impl Default for LightRays {
    fn default() -> Self {
        LightRays { shadows: true, occlusion: 0 }
    }
}

#[derive(Debug, Clone)]
pub struct SceneAtTime {
    pub objects: Vec<Object>,
    pub meshes: Vec<Arc<SceneMesh>>,
    pub light: Light,
    pub light_rays: LightRays,
    /// One for each sun.
    pub(super) shadows: Vec<ShadowGrid>,
    /// The smallest box around the boxes of all objects and meshes; `None` for an empty scene.
    pub bounds: Option<AxisBox>,
    /// Diagonal of the bounds, metres.
    size: f64,
    lift: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Metres along the ray.
    pub distance: f64,
    pub surface: HitSurface,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HitSurface {
    Object {
        index: usize,
        /// Length 1, out of the solid.
        normal: DVec3,
    },
    Mesh {
        index: usize,
        at: TriangleHit,
    },
}

impl SceneAtTime {
    /// Memory that its meshes and their textures take, each texture once.
    pub fn bytes(&self) -> u64 {
        let textures = self.meshes.iter().flat_map(|mesh| mesh.textures());
        let sizes: BTreeMap<*const ImageTexture, u64> =
            textures.map(|texture| (Arc::as_ptr(texture), size_of_val(&texture.pixels[..]) as u64)).collect();
        self.meshes.iter().map(|mesh| mesh.bytes()).chain(sizes.into_values()).sum()
    }

    /// A scene of `objects`. Of two that are equally far along a ray, the first is hit.
    pub fn new(objects: Vec<Object>, light: Light) -> Self {
        Self::with_meshes(objects, Vec::new(), light)
    }

    pub fn with_meshes(objects: Vec<Object>, meshes: Vec<Arc<SceneMesh>>, light: Light) -> Self {
        let shadows = light.suns.iter().map(|sun| ShadowGrid::new(&objects, sun.direction)).collect();
        let boxes = objects.iter().map(|object| object.bounds).chain(meshes.iter().filter_map(|mesh| mesh.bvh.bounds));
        // Shapes that are not finite are invisible, and must not spoil what depends on the size.
        let boxes = boxes.filter(|bounds| bounds.min.is_finite() && bounds.max.is_finite());
        let bounds = boxes.reduce(AxisBox::join);
        let size = bounds.map_or(0.0, |bounds| (bounds.max - bounds.min).length().min(f64::MAX));
        SceneAtTime {
            objects,
            meshes,
            light,
            light_rays: LightRays::default(),
            shadows,
            bounds,
            size,
            lift: lift_m(size),
        }
    }

    #[must_use]
    pub fn with_light_rays(self, light_rays: LightRays) -> SceneAtTime {
        SceneAtTime { light_rays, ..self }
    }

    /// Whether no surface lies between two points, both of which may be on a surface: hits within the offset of ray
    /// origins (`lift_m`, and at least 1e-13 of the point's largest coordinate) of either are ignored. Glass occludes,
    /// holes in textures do not. Points that are not finite are not visible.
    pub fn sees(&self, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        let length = way.length();
        if !length.is_finite() {
            return false;
        }
        let ends = [self.lift(from), length - self.lift(to)];
        if ends[0] >= ends[1] {
            return true;
        }
        let ray = Ray::from_unit(from, way / length);
        let hidden = self.objects.iter().any(|object| {
            object.bounds.intersect(&ray, 0.0).is_some()
                && object.shape.intersect(&ray, ends[0]).is_some_and(|hit| hit.distance < ends[1])
        });
        !hidden && !self.meshes.iter().any(|mesh| mesh.occluded(&ray, ends[0]..ends[1]))
    }

    /// Metres within which surfaces occlude ambient light: a tenth of the scene's diagonal.
    pub(super) fn occlusion_reach(&self) -> f64 {
        0.1 * self.size
    }

    /// Square metres around a lamp within which it becomes no brighter: 10 cm, less in scenes of less than a metre.
    pub(super) fn lamp_core(&self) -> f64 {
        0.01 * self.size.min(1.0).powi(2)
    }

    /// Offset of a ray that leaves the surface at `point`, metres: larger far from the origin, where f64 resolves less.
    pub(super) fn lift(&self, point: DVec3) -> f64 {
        self.lift.max(1e-13 * point.abs().max_element())
    }

    /// The nearest hit among all meshes and the `candidates` (indices of objects, rising); of equally near ones, objects
    /// before meshes, then the lower index.
    pub fn first_hit(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Option<FirstHit> {
        let mut first: Option<FirstHit> = None;
        for index in candidates {
            if let Some(Intersection { distance, normal }) = self.objects[index].shape.intersect(ray, 0.0)
                && first.is_none_or(|first| distance < first.distance)
            {
                first = Some(FirstHit { distance, surface: HitSurface::Object { index, normal } });
            }
        }
        for (index, mesh) in self.meshes.iter().enumerate() {
            let limit = first.map_or(f64::INFINITY, |first| first.distance);
            if let Some(at) = mesh.nearest(ray, 0.0..limit) {
                first = Some(FirstHit { distance: at.distance, surface: HitSurface::Mesh { index, at } });
            }
        }
        first
    }

    /// All hits along a ray by distance, among all meshes and the `candidates`: of equally near ones, the one that [`Self::first_hit`]
    /// answers.
    pub fn all_hits(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Vec<FirstHit> {
        let of_mesh = |(index, mesh): (usize, &Arc<SceneMesh>)| {
            let found = mesh.bvh.all(ray, 0.0..f64::INFINITY);
            let solid: Vec<_> = found.into_iter().filter(|hit| !mesh.is_hole(hit.triangle, hit.barycentric)).collect();
            solid.into_iter().map(move |at| FirstHit { distance: at.distance, surface: HitSurface::Mesh { index, at } })
        };
        self.with_objects(self.meshes.iter().enumerate().flat_map(of_mesh), ray, candidates)
    }

    /// Hits of triangles and those of the `candidates`, as [`Self::all_hits`].
    pub fn with_objects(
        &self,
        of_triangles: impl IntoIterator<Item = FirstHit>,
        ray: &Ray,
        candidates: impl IntoIterator<Item = usize>,
    ) -> Vec<FirstHit> {
        let mut hits = Vec::new();
        for index in candidates {
            let mut passed = 0.0;
            while let Some(Intersection { distance, normal }) = self.objects[index].shape.intersect(ray, passed)
                && distance > passed
            {
                hits.push(FirstHit { distance, surface: HitSurface::Object { index, normal } });
                passed = distance;
            }
        }
        hits.extend(of_triangles);
        // Stable: objects first, then meshes.
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        hits.dedup_by(|later, first| later.distance == first.distance);
        hits
    }

    /// Where a ray meets a triangle, by its number among those of all meshes, and whether there is a hole.
    pub fn hit_of_triangle(&self, ray: &Ray, mut number: usize) -> Option<(FirstHit, bool)> {
        for (index, mesh) in self.meshes.iter().enumerate() {
            let count = mesh.mesh.triangles.len();
            if number < count {
                let at = Bvh::hit_of(ray, number, mesh.mesh.corners(number)).filter(|hit| hit.distance > 0.0)?;
                let hit = FirstHit { distance: at.distance, surface: HitSurface::Mesh { index, at } };
                return Some((hit, mesh.is_hole(number, at.barycentric)));
            }
            number -= count;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::mesh::Mesh;
    use crate::scene::{DemoKind, DemoScene, MeshMaterial};

    /// Depth peeling (Epipolar listings 3.1 to 3.3): again and again the nearest surface behind the last one.
    fn peeled(scene: &SceneAtTime, ray: &Ray) -> Vec<FirstHit> {
        let mut layers: Vec<FirstHit> = Vec::new();
        loop {
            let last = layers.last().map_or(0.0, |hit| hit.distance);
            let mut next: Option<FirstHit> = None;
            for (index, object) in scene.objects.iter().enumerate() {
                if let Some(Intersection { distance, normal }) = object.shape.intersect(ray, last)
                    && distance > last
                    && next.is_none_or(|next| distance < next.distance)
                {
                    next = Some(FirstHit { distance, surface: HitSurface::Object { index, normal } });
                }
            }
            for (index, mesh) in scene.meshes.iter().enumerate() {
                let limit = next.map_or(f64::INFINITY, |next| next.distance);
                if let Some(at) = mesh.nearest(ray, last..limit) {
                    next = Some(FirstHit { distance: at.distance, surface: HitSurface::Mesh { index, at } });
                }
            }
            match next {
                Some(next) => layers.push(next),
                None => return layers,
            }
        }
    }

    #[test]
    fn all_hits_are_the_layers_of_depth_peeling() {
        // Sheets of triangles, two of them in one plane.
        let corner = |x: f64, z: f64| DVec3::new(x, 0.5 * x, z);
        let sheet = |z: f64| [corner(-9.0, z), corner(9.0, z), DVec3::new(0.0, 18.0, z)];
        let sheets = [-1.0, -1.0, -2.5, -2.5f64.next_down(), -4.0].map(sheet);
        let mesh = Mesh {
            positions: sheets.concat(),
            triangles: (0..5).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect(),
            material_of: vec![0; 5],
            ..Mesh::default()
        };
        let mesh = Arc::new(SceneMesh::new(mesh, [MeshMaterial::default()].into()));
        let built_in = DemoScene::new(DemoKind::Courtyard).at(0.0);
        let scene = SceneAtTime::with_meshes(built_in.objects.clone(), vec![mesh], built_in.light.clone());
        let mut random = Random::new(3);
        let mut unit = || f64::from(random.word()) / f64::from(u32::MAX) - 0.5;
        let mut most = 0;
        for _ in 0..2000 {
            let origin = DVec3::new(2.0 * unit(), 1.5 + unit(), 2.0 * unit());
            let Some(ray) = Ray::new(origin, DVec3::new(unit(), unit(), unit())) else { continue };
            let found = scene.all_hits(&ray, 0..scene.objects.len());
            assert_eq!(found, peeled(&scene, &ray), "{origin} {}", ray.direction());
            assert_eq!(found.first().copied(), scene.first_hit(&ray, 0..scene.objects.len()));
            most = most.max(found.len());
        }
        assert!(most >= 6, "{most}");
    }
}
