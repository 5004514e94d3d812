//! A scene at several time samples, with points on its surfaces: visibility from candidates, and free space.
//!
//! A mesh does not specify which sides of its surfaces are visible: a sheet is seen from both sides, and some files are inside
//! out. The candidates therefore decide. Each side of a point that any candidate sees becomes a surfel; of a point that no
//! candidate sees, the front does. The inside of a solid does not become a surfel.

use glam::DVec3;
use rayon::prelude::*;

use super::objective::{Surfel, VisibleSet};
use super::region::Region;
use super::sequence;
use super::surface::{self, SurfacePoint};
use crate::mesh::{AxisBox, Ray};
use crate::{FirstHit, HitSurface, SceneAtTime, Shape};
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Number of directions tested to determine whether a position is inside a solid.
const DIRECTIONS: usize = 26;
/// Number of points of a parallel job, a multiple of 64.
const JOB: usize = 512;

#[derive(Debug)]
pub struct SampledScene {
    times: Vec<SceneAtTime>,
    /// Points of all time samples, one time sample after the other.
    points: Vec<SamplePoint>,
}

/// A point on a surface at one time sample, and its fraction of all area and time.
#[derive(Debug)]
struct SamplePoint {
    on: SurfacePoint,
    time: usize,
    weight: f64,
}

/// Surfels: the visible sides of points.
#[derive(Debug, Default)]
pub struct Surfels {
    /// Surfels that a candidate sees come first.
    pub surfels: Vec<Surfel>,
    /// Index of the point of each surfel.
    points: Vec<usize>,
}

impl SampledScene {
    /// Distributes `points` points evenly over all time samples. Fails if there is no surface.
    pub fn new(times: Vec<SceneAtTime>, points: usize) -> Result<SampledScene> {
        let each = points.div_ceil(times.len().max(1)).max(1);
        let mut points = Vec::new();
        for (time, scene) in times.iter().enumerate() {
            let found = surface::sample(scene, each, (time * each) as u64);
            let weight = found.area_of_each;
            points.extend(found.points.into_iter().map(|on| SamplePoint { on, time, weight }));
        }
        let all: f64 = points.iter().map(|point| point.weight).sum();
        if !(all > 0.0 && all.is_finite()) {
            return Err(Error::invalid("the scene has no surface for cameras to cover"));
        }
        points.iter_mut().for_each(|point| point.weight /= all);
        Ok(SampledScene { times, points })
    }

    pub fn point_count(&self) -> usize {
        self.points.len()
    }

    pub fn bounds(&self) -> AxisBox {
        let bounds = AxisBox::around(self.points.iter().map(|point| point.on.point));
        bounds.unwrap_or(AxisBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY })
    }

    /// Returns true if a position is outside of solids at each time sample, and at least `clearance_m` from surfaces in all
    /// tested directions.
    ///
    /// A position is inside if more than half of the rays first hit a back face. (A winding number would require closed meshes.)
    pub fn is_free(&self, position: DVec3, clearance_m: f64) -> bool {
        self.times.iter().all(|scene| {
            let mut backs = 0;
            for direction in 0..DIRECTIONS {
                let Some(ray) = Ray::new(position, sequence::on_sphere(direction, DIRECTIONS)) else { return false };
                let is_near = |at: &usize| scene.objects[*at].bounds.intersect(&ray, 0.0).is_some();
                let candidates = (0..scene.objects.len()).filter(is_near);
                let Some(hit) = scene.first_hit(&ray, candidates) else { continue };
                if hit.distance < clearance_m {
                    return false;
                }
                backs += usize::from(is_back(scene, &hit, &ray));
            }
            2 * backs <= DIRECTIONS
        })
    }

    /// Returns the points that each position sees from either side, one bit each.
    pub fn visibility(&self, positions: &[DVec3], monitor: &dyn Monitor) -> Result<Vec<Vec<u64>>> {
        let all = |position: &DVec3| {
            monitor.advance(1);
            monitor.check()?;
            Ok(words(self.points.len(), |at| self.sees(*position, at)))
        };
        positions.par_iter().map(all).collect()
    }

    fn sees(&self, position: DVec3, point: usize) -> bool {
        let SamplePoint { on, time, .. } = &self.points[point];
        self.times[*time].sees(position, on.point)
    }

    /// Returns the surfels, given the points that each candidate sees. `Z(x)` (CALF 4.1) is the distance from a point to the
    /// region, and at least `min_m`.
    pub fn surfels(&self, candidates: &[DVec3], visibility: &[Vec<u64>], region: &Region, min_m: f64) -> Surfels {
        let sides = |(at, SamplePoint { on, weight, .. }): (usize, &SamplePoint)| {
            let who = candidates.iter().zip(visibility).filter(|(_, seen)| seen[at / 64] >> (at % 64) & 1 == 1);
            let (mut front, mut back) = (0, 0);
            for (position, _) in who {
                let height = (*position - on.point).dot(on.normal);
                front += usize::from(height > 0.0);
                back += usize::from(height < 0.0);
            }
            let viewer_distance_m = region.distance_m(on.point).max(min_m);
            let surfel = |normal: DVec3| Surfel { point: on.point, normal, weight: *weight, viewer_distance_m };
            let front_side = (front > 0 || back == 0).then(|| (front > 0, surfel(on.normal)));
            [front_side, (back > 0).then(|| (true, surfel(-on.normal)))]
        };
        let sides: Vec<[Option<(bool, Surfel)>; 2]> = self.points.par_iter().enumerate().map(sides).collect();
        let mut found = Surfels::default();
        // Visible surfels are kept together, so that their groups are small and bounds of gains are tight.
        for of_visible in [true, false] {
            for (point, side) in sides.iter().enumerate().flat_map(|(point, both)| both.map(|side| (point, side))) {
                if let Some((_, surfel)) = side.filter(|(is_seen, _)| *is_seen == of_visible) {
                    found.surfels.push(surfel);
                    found.points.push(point);
                }
            }
        }
        // Sheets with two sides have more surface than the area of the points.
        let all: f64 = found.surfels.iter().map(|surfel| surfel.weight).sum();
        found.surfels.iter_mut().for_each(|surfel| surfel.weight /= all);
        found
    }

    /// Returns the visible set of a position whose visible points are known.
    pub fn visible_of_points(&self, surfels: &Surfels, position: DVec3, visibility: &[u64]) -> VisibleSet {
        let sees = |at: usize| {
            let point = surfels.points[at];
            visibility[point / 64] >> (point % 64) & 1 == 1 && is_above(&surfels.surfels[at], position)
        };
        VisibleSet { position, seen: words(surfels.surfels.len(), sees) }
    }

    pub fn visible_set(&self, surfels: &Surfels, position: DVec3) -> VisibleSet {
        let is_seen = |at: usize| is_above(&surfels.surfels[at], position) && self.sees(position, surfels.points[at]);
        let count = surfels.surfels.len();
        let jobs: Vec<usize> = (0..count).step_by(JOB).collect();
        let parts: Vec<Vec<u64>> =
            jobs.into_par_iter().map(|from| words(JOB.min(count - from), |at| is_seen(from + at))).collect();
        VisibleSet { position, seen: parts.concat() }
    }
}

fn is_above(surfel: &Surfel, position: DVec3) -> bool {
    (position - surfel.point).dot(surfel.normal) > 0.0
}

fn words(count: usize, is_set: impl Fn(usize) -> bool) -> Vec<u64> {
    let word = |from: usize| {
        let bits = from..count.min(from + 64);
        bits.fold(0, |word, at| word | u64::from(is_set(at)) << (at - from))
    };
    (0..count).step_by(64).map(word).collect()
}

/// Returns true if a ray hits the back of a surface. Flat rectangles have no back.
fn is_back(scene: &SceneAtTime, hit: &FirstHit, ray: &Ray) -> bool {
    let normal = match hit.surface {
        HitSurface::Object { index, .. } if matches!(scene.objects[index].shape, Shape::Quad(_)) => return false,
        HitSurface::Object { normal, .. } => normal,
        HitSurface::Mesh { index, at } => {
            let [a, b, c] = scene.meshes[index].mesh.corners(at.triangle);
            (b - a).cross(c - a)
        }
    };
    normal.dot(ray.direction()) > 0.0
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mesh::Mesh;
    use crate::{Light, Material, Object, Quad, SceneMesh, Sphere, Texture};
    use codec::monitor::Silent;

    fn object(shape: Shape) -> Object {
        Object::new(shape, Material::diffuse(Texture::Solid(DVec3::ONE)))
    }

    fn scene(shapes: &[Shape]) -> SceneAtTime {
        SceneAtTime::new(shapes.iter().map(|shape| object(*shape)).collect(), Light::default())
    }

    fn ball() -> Shape {
        Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 })
    }

    fn surfels_of(sampled: &SampledScene, candidates: &[DVec3]) -> Surfels {
        let visibility = sampled.visibility(candidates, &Silent).unwrap();
        let region = Region::parse(&["-3,-3,-3,3,3,3"]).unwrap();
        sampled.surfels(candidates, &visibility, &region, 0.25)
    }

    #[test]
    fn the_inside_of_solids_is_not_open() {
        let solid = Shape::AxisBox(AxisBox { min: DVec3::splat(3.0), max: DVec3::splat(4.0) });
        let sampled = SampledScene::new(vec![scene(&[ball(), solid])], 100).unwrap();
        let open = |x: f64| sampled.is_free(DVec3::splat(x), 0.01);
        assert_eq!([0.0, 0.4, 0.7, 2.0, 2.999, 3.5, 5.0].map(open), [false, false, true, true, false, false, true]);
        // A room is not the inside of a solid, whichever way its walls are turned.
        let wall = |corner: DVec3, u: DVec3, v: DVec3| Shape::Quad(Quad { corner, u, v });
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
        let walls = [(DVec3::ZERO, x, y), (z, x, y), (DVec3::ZERO, y, z), (x, y, z), (DVec3::ZERO, z, x), (y, z, x)];
        let room = scene(&walls.map(|(corner, u, v)| wall(corner, u, v)));
        assert!(SampledScene::new(vec![room], 100).unwrap().is_free(DVec3::splat(0.4), 0.01));
    }

    #[test]
    fn what_moves_is_in_the_way_at_any_time() {
        let moved = Shape::Sphere(Sphere { center: DVec3::X * 5.0, radius: 1.0 });
        let sampled = SampledScene::new(vec![scene(&[ball()]), scene(&[moved])], 100).unwrap();
        let open = |x: f64| sampled.is_free(DVec3::X * x, 0.01);
        assert_eq!([0.2, 2.5, 5.2].map(open), [false, true, false]);
        assert_eq!(sampled.point_count(), 100);
    }

    #[test]
    fn a_ball_has_one_side_and_a_sheet_two() {
        let candidates = [DVec3::Y * 3.0, DVec3::NEG_Y * 3.0, DVec3::X * 3.0];
        let sampled = SampledScene::new(vec![scene(&[ball()])], 500).unwrap();
        let surfels = surfels_of(&sampled, &candidates);
        assert_eq!(surfels.surfels.len(), 500);
        assert!(surfels.surfels.iter().all(|surfel| surfel.normal.dot(surfel.point) > 0.99));
        let sheet = Quad { corner: DVec3::new(-1.0, 0.0, -1.0), u: DVec3::X * 2.0, v: DVec3::Z * 2.0 };
        let sampled = SampledScene::new(vec![scene(&[Shape::Quad(sheet)])], 500).unwrap();
        assert_eq!(surfels_of(&sampled, &candidates).surfels.len(), 1000);
        let below = surfels_of(&sampled, &candidates[..1]);
        assert!(below.surfels.len() == 500 && below.surfels.iter().all(|surfel| surfel.normal == DVec3::Y));
        assert!((below.surfels.iter().map(|surfel| surfel.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_camera_sees_the_cap_of_a_ball() {
        let sampled = SampledScene::new(vec![scene(&[ball()])], 2000).unwrap();
        let camera = DVec3::Y * 2.0;
        let surfels = surfels_of(&sampled, &[camera, DVec3::NEG_Y * 2.0, DVec3::X * 2.5]);
        let visible = sampled.visible_set(&surfels, camera);
        // A camera at twice the radius sees everything above half the radius: a quarter of the ball.
        for (at, surfel) in surfels.surfels.iter().enumerate().filter(|(_, surfel)| (surfel.point.y - 0.5).abs() > 1e-3)
        {
            assert_eq!(visible.seen[at / 64] >> (at % 64) & 1 == 1, surfel.point.y > 0.5, "{surfel:?}");
            assert_eq!(surfel.viewer_distance_m, 0.25);
        }
        let visibility = sampled.visibility(&[camera], &Silent).unwrap();
        assert_eq!(sampled.visible_of_points(&surfels, camera, &visibility[0]), visible);
    }

    #[test]
    fn a_mesh_that_is_inside_out_still_has_an_outside() {
        let positions = AxisBox { min: DVec3::NEG_ONE, max: DVec3::ONE }.corners().to_vec();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = |flip: bool| -> Vec<[u32; 3]> {
            let pair = |&[a, b, c, d]: &[u32; 4]| if flip { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] };
            quads.iter().flat_map(pair).collect()
        };
        for flip in [false, true] {
            let mesh = Mesh { positions: positions.clone(), triangles: triangles(flip), ..Mesh::default() };
            let scene =
                SceneAtTime::with_meshes(vec![], vec![Arc::new(SceneMesh::new(mesh, [].into()))], Light::default());
            let sampled = SampledScene::new(vec![scene], 300).unwrap();
            let surfels = surfels_of(&sampled, &[DVec3::splat(3.0), DVec3::splat(-3.0)]);
            assert_eq!(surfels.surfels.len(), 300);
            assert!(surfels.surfels.iter().all(|surfel| surfel.normal.dot(surfel.point) > 0.0));
            assert!(sampled.is_free(DVec3::splat(1.5), 0.01));
            // Turned inside out, the box is a room.
            assert_eq!(sampled.is_free(DVec3::splat(0.2), 0.01), flip);
        }
    }

    #[test]
    fn nothing_is_refused() {
        let error = SampledScene::new(vec![scene(&[])], 100).unwrap_err();
        assert!(error.to_string().contains("no surface"));
    }
}
