//! A scene at a fixed time: nearest hit of a ray, and visibility between two points.
//!
//! A ray in a scene always gives the same bits, so surfaces that neither move nor change illumination are bit-identical over
//! time. Static objects are in meshes that all times share; moving ones get a new bounding volume hierarchy for each time.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::shadow_cube::ShadowCube;
use super::shadow_grid::ShadowGrid;
use super::{Light, Object, SceneMesh};
use crate::mesh::{AxisBox, Bvh, ImageTexture, Intersection, Ray, TriangleHit};

/// Returns the offset of ray origins from the surface that they leave, in metres, for a scene that is `size` metres across:
/// 1e-6 m from 1 to 100 m, 1e-6 of the size of smaller scenes, 1e-8 of the size of larger ones.
fn lift_m(size: f64) -> f64 {
    if size < 1.0 { 1e-6 * size } else { f64::max(1e-6, 1e-8 * size) }
}

/// Selects the rays that are cast for illumination.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightRays {
    /// True if suns and lamps cast shadows.
    pub shadows: bool,
    /// Number of ambient occlusion rays per point; 0 disables ambient occlusion.
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
    /// One per sun.
    pub(super) shadows: Vec<ShadowGrid>,
    /// One per lamp.
    pub(super) lamp_shadows: Vec<ShadowCube>,
    /// Runs of objects with a box around them.
    clusters: Vec<Cluster>,
    /// The smallest box around the boxes of all finite objects and meshes; `None` for an empty scene.
    pub bounds: Option<AxisBox>,
    /// Diagonal of the bounds, metres.
    size: f64,
    lift: f64,
}

/// A run of consecutive objects.
#[derive(Debug, Clone)]
struct Cluster {
    objects: Range<usize>,
    /// Union of the bounding boxes of the objects, enlarged by a margin that exceeds the rounding errors of the intersection test.
    bounds: AxisBox,
}

impl Cluster {
    /// Number of objects: few enough that most rays miss most clusters, if neighbours in the list are neighbours in space.
    const SIZE: usize = 8;

    fn all(objects: &[Object]) -> Vec<Cluster> {
        let cluster = |(number, run): (usize, &[Object])| {
            let joined = run.iter().map(|object| object.bounds).reduce(AxisBox::join)?;
            let margin = f64::max(1e-4, 1e-9 * joined.min.abs().max(joined.max.abs()).max_element());
            let start = number * Self::SIZE;
            let bounds = AxisBox { min: joined.min - margin, max: joined.max + margin };
            Some(Cluster { objects: start..start + run.len(), bounds })
        };
        objects.chunks(Self::SIZE).enumerate().filter_map(cluster).collect()
    }
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
        /// Unit normal, pointing out of the solid.
        normal: DVec3,
    },
    Mesh {
        index: usize,
        at: TriangleHit,
    },
}

impl SceneAtTime {
    /// Returns the bytes of its meshes and their textures, counting each texture once.
    pub fn bytes(&self) -> u64 {
        let textures = self.meshes.iter().flat_map(|mesh| mesh.textures());
        let sizes: BTreeMap<*const ImageTexture, u64> =
            textures.map(|texture| (Arc::as_ptr(texture), size_of_val(&texture.pixels[..]) as u64)).collect();
        self.meshes.iter().map(|mesh| mesh.bytes()).chain(sizes.into_values()).sum()
    }

    /// Creates a scene of `objects`. If two are equally far along a ray, the first is hit.
    pub fn new(objects: Vec<Object>, light: Light) -> Self {
        Self::with_meshes(objects, Vec::new(), light)
    }

    pub fn with_meshes(objects: Vec<Object>, meshes: Vec<Arc<SceneMesh>>, light: Light) -> Self {
        let shadows = light.suns.iter().map(|sun| ShadowGrid::new(&objects, sun.direction)).collect();
        let lamp_shadows = light.lamps.iter().map(|lamp| ShadowCube::new(&objects, lamp)).collect();
        let boxes = objects.iter().map(|object| object.bounds).chain(meshes.iter().filter_map(|mesh| mesh.bvh.bounds));
        let clusters = Cluster::all(&objects);
        // Shapes that are not finite are invisible; excluding them keeps the size finite.
        let boxes = boxes.filter(|bounds| bounds.min.is_finite() && bounds.max.is_finite());
        let bounds = boxes.reduce(AxisBox::join);
        let size = bounds.map_or(0.0, |bounds| (bounds.max - bounds.min).length().min(f64::MAX));
        SceneAtTime {
            objects,
            meshes,
            light,
            light_rays: LightRays::default(),
            shadows,
            lamp_shadows,
            clusters,
            bounds,
            size,
            lift: lift_m(size),
        }
    }

    #[must_use]
    pub fn with_light_rays(self, light_rays: LightRays) -> SceneAtTime {
        SceneAtTime { light_rays, ..self }
    }

    /// True if no surface lies between two points, both of which may be on a surface: hits closer to either point than the
    /// offset of ray origins (`lift_m`, and at least 1e-13 of the point's largest coordinate) are ignored. Glass occludes,
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

    /// Returns the distance in metres within which surfaces occlude ambient light: a tenth of the scene's diagonal.
    pub(super) fn occlusion_reach(&self) -> f64 {
        0.1 * self.size
    }

    /// Returns the squared distance from a lamp, in m², below which it gets no brighter: (10 cm)², less in scenes of less than
    /// a metre.
    pub(super) fn lamp_core(&self) -> f64 {
        0.01 * self.size.min(1.0).powi(2)
    }

    /// Returns the offset of a ray that leaves the surface at `point`, metres: larger far from the origin, where f64 is less
    /// precise.
    pub(super) fn lift(&self, point: DVec3) -> f64 {
        self.lift.max(1e-13 * point.abs().max_element())
    }

    /// Returns the nearest hit among all meshes and the `candidates` (ascending indices of objects). If several are equally
    /// near, objects precede meshes, then the lowest index wins.
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

    /// Returns the indices, in order, of the objects that a ray may hit.
    pub(super) fn on_path(&self, ray: &Ray) -> impl Iterator<Item = usize> {
        let is_met = |cluster: &&Cluster| {
            let slabs = cluster.bounds.slabs(ray);
            // Not `<=`: boxes that are not finite are met.
            !(slabs.enter() > slabs.leave() || slabs.leave() < 0.0)
        };
        self.clusters.iter().filter(is_met).flat_map(|cluster| cluster.objects.clone())
    }

    /// Returns all hits along a ray, by distance, among all meshes and the `candidates`. Of several equally near hits, only the
    /// one that [`Self::first_hit`] returns is included.
    pub fn all_hits(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Vec<FirstHit> {
        let of_mesh = |(index, mesh): (usize, &Arc<SceneMesh>)| {
            let found = mesh.bvh.all(ray, 0.0..f64::INFINITY);
            let solid: Vec<_> = found.into_iter().filter(|hit| !mesh.is_hole(hit.triangle, hit.barycentric)).collect();
            solid.into_iter().map(move |at| FirstHit { distance: at.distance, surface: HitSurface::Mesh { index, at } })
        };
        self.with_objects(self.meshes.iter().enumerate().flat_map(of_mesh), ray, candidates)
    }

    /// Merges hits of triangles with those of the `candidates`, as [`Self::all_hits`] does.
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
        // The sort is stable: objects precede meshes.
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        hits.dedup_by(|later, first| later.distance == first.distance);
        hits
    }

    /// Returns the hit of a ray on a triangle, given by its index over all meshes, and whether the triangle has a hole there.
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
    use crate::mesh::Mesh;
    use crate::{DemoKind, DemoScene, MeshMaterial};
    use codec::math::random::Random;

    /// Depth peeling (Epipolar listings 3.1 to 3.3): repeatedly finds the nearest surface behind the last one.
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
        // Sheets of triangles, two of them in the same plane.
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
