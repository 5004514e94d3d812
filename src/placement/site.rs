//! A scene over frames, as cameras meet it: what is seen from where, and where there is room for one.
//!
//! Enters: the scene at a few moments, and points on its surfaces. Leaves: [`View`]s of positions, and whether a position
//! lies in the open.
//!
//! Surfaces have two sides. Which of them are meant, a mesh does not tell: a wall may be a sheet that is seen from both, and
//! some files are turned inside out. So the candidates decide ([`Site::facets`]): each side of a point that any of them sees
//! is a facet, and of a point that none sees the front. The inside of a solid, which nobody sees, is none.

use glam::DVec3;
use rayon::prelude::*;

use super::objective::{Facet, View};
use super::region::Region;
use super::sequence;
use super::surface::{self, SurfacePoint};
use crate::error::{Error, Result};
use crate::mesh::{AxisBox, Ray};
use crate::scene::{HitSurface, SceneAtTime, Shape};

/// Directions that are looked in to find out whether a position is inside something.
const FEELERS: usize = 26;
/// Points whose bits one job finds out, a multiple of 64.
const JOB: usize = 512;

/// A scene at a few moments, with points on its surfaces.
#[derive(Debug)]
pub struct Site {
    moments: Vec<SceneAtTime>,
    /// Points of all moments, those of one after those of the other.
    points: Vec<SurfacePoint>,
    /// Moment and weight of each point.
    of_points: Vec<(usize, f64)>,
}

/// The sides of points that are meant, and where their points are in the [`Site`].
#[derive(Debug)]
pub struct Facets {
    /// The facets, those that a candidate sees before the others.
    pub facets: Vec<Facet>,
    /// Index of each one's point.
    points: Vec<usize>,
    /// Moment of each.
    moments: Vec<usize>,
}

impl Site {
    /// Spreads `points` points over the surfaces of all moments, as many on each; each moment is the same part of the time.
    ///
    /// # Errors
    /// When there is no surface at any moment.
    pub fn new(moments: Vec<SceneAtTime>, points: usize) -> Result<Site> {
        let each = points.div_ceil(moments.len().max(1)).max(1);
        let mut site = Site { moments: Vec::new(), points: Vec::new(), of_points: Vec::new() };
        for (at, scene) in moments.iter().enumerate() {
            let found = surface::spread(scene, each, (at * each) as u64);
            site.of_points.extend(found.points.iter().map(|_| (at, found.area_of_each)));
            site.points.extend(found.points);
        }
        let all: f64 = site.of_points.iter().map(|(_, weight)| weight).sum();
        if !(all > 0.0 && all.is_finite()) {
            return Err(Error::invalid("the scene has no surface that cameras could see"));
        }
        site.of_points.iter_mut().for_each(|(_, weight)| *weight /= all);
        site.moments = moments;
        Ok(site)
    }

    /// The moments.
    pub fn moments(&self) -> &[SceneAtTime] {
        &self.moments
    }

    /// The points.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// A box around the points.
    pub fn bounds(&self) -> AxisBox {
        let points = || self.points.iter().map(|at| at.point);
        AxisBox { min: points().fold(DVec3::INFINITY, DVec3::min), max: points().fold(DVec3::NEG_INFINITY, DVec3::max) }
    }

    /// Whether a position is outside everything solid at each moment, and along no feeler nearer than `clearance_m` to a
    /// surface.
    ///
    /// It is taken to be inside where more than half of the feelers first meet the back of something. Flat rectangles have no
    /// back.
    pub fn is_open(&self, position: DVec3, clearance_m: f64) -> bool {
        self.moments.iter().all(|scene| {
            let mut backs = 0;
            for feeler in 0..FEELERS {
                let Some(ray) = Ray::new(position, sequence::on_sphere(feeler, FEELERS)) else { return false };
                if let Some((distance, side)) = first_met(scene, &ray) {
                    if distance < clearance_m {
                        return false;
                    }
                    backs += usize::from(side == Side::Back);
                }
            }
            2 * backs <= FEELERS
        })
    }

    /// Which points each position sees, from either side; one bit for each.
    pub fn sights(&self, positions: &[DVec3], each_done: &(dyn Fn() -> Result<()> + Sync)) -> Result<Vec<Vec<u64>>> {
        let all = |position: &DVec3| {
            each_done()?;
            let is_seen = |at: usize| self.moments[self.of_points[at].0].sees(*position, self.points[at].point);
            Ok(words(self.points.len(), is_seen))
        };
        positions.par_iter().map(all).collect()
    }

    /// The sides of points that are meant, as candidates and their sights decide.
    pub fn facets(&self, candidates: &[DVec3], sights: &[Vec<u64>], viewer_distance_m: &ViewerDistance<'_>) -> Facets {
        let sides = |(at, on): (usize, &SurfacePoint)| {
            let who = candidates.iter().zip(sights).filter(|(_, seen)| seen[at / 64] >> (at % 64) & 1 == 1);
            let (mut front, mut back) = (0, 0);
            for (position, _) in who {
                let height = (*position - on.point).dot(on.normal);
                front += usize::from(height > 0.0);
                back += usize::from(height < 0.0);
            }
            let weight = self.of_points[at].1;
            let viewer_distance_m = viewer_distance_m.at(on.point);
            let side = |normal: DVec3, seers: usize| {
                (seers > 0, at, Facet { point: on.point, normal, weight, viewer_distance_m })
            };
            [(front > 0 || back == 0).then(|| side(on.normal, front)), (back > 0).then(|| side(-on.normal, back))]
        };
        let sides: Vec<[Option<(bool, usize, Facet)>; 2]> = self.points.par_iter().enumerate().map(sides).collect();
        let mut sides: Vec<(bool, usize, Facet)> = sides.into_iter().flatten().flatten().collect();
        // Those that are seen lie together: groups of them are small, and bounds of gains tight.
        sides.sort_by_key(|(is_seen, ..)| !is_seen);
        let mut found = Facets { facets: Vec::new(), points: Vec::new(), moments: Vec::new() };
        for (_, at, facet) in sides {
            found.facets.push(facet);
            found.points.push(at);
            found.moments.push(self.of_points[at].0);
        }
        // Where a sheet has two sides, there is more surface than area of points.
        let all: f64 = found.facets.iter().map(|facet| facet.weight).sum();
        found.facets.iter_mut().for_each(|facet| facet.weight /= all);
        found
    }

    /// The view of a position whose sight is known.
    pub fn view(&self, facets: &Facets, position: DVec3, sight: &[u64]) -> View {
        let sees = |at: usize| {
            let point = facets.points[at];
            sight[point / 64] >> (point % 64) & 1 == 1 && is_above(&facets.facets[at], position)
        };
        View { position, seen: words(facets.facets.len(), sees) }
    }

    /// The view of any position.
    pub fn look(&self, facets: &Facets, position: DVec3) -> View {
        let is_seen = |at: usize| {
            let facet = &facets.facets[at];
            is_above(facet, position) && self.moments[facets.moments[at]].sees(position, facet.point)
        };
        let count = facets.facets.len();
        let jobs: Vec<usize> = (0..count).step_by(JOB).collect();
        let parts: Vec<Vec<u64>> =
            jobs.into_par_iter().map(|from| words(JOB.min(count - from), |at| is_seen(from + at))).collect();
        View { position, seen: parts.concat() }
    }
}

/// `Z(x)` (CALF 4.1): the distance from a point to the region of viewers, and no less than a smallest distance.
#[derive(Debug, Clone, Copy)]
pub struct ViewerDistance<'a> {
    /// Where viewers are.
    pub region: &'a Region,
    /// Metres.
    pub least_m: f64,
}

impl ViewerDistance<'_> {
    /// Metres.
    pub fn at(&self, point: DVec3) -> f64 {
        self.region.distance_m(point).max(self.least_m)
    }
}

fn is_above(facet: &Facet, position: DVec3) -> bool {
    (position - facet.point).dot(facet.normal) > 0.0
}

fn words(count: usize, is_set: impl Fn(usize) -> bool) -> Vec<u64> {
    let word = |from: usize| {
        let bits = from..count.min(from + 64);
        bits.fold(0, |word, at| word | u64::from(is_set(at)) << (at - from))
    };
    (0..count).step_by(64).map(word).collect()
}

/// A side of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// Outside.
    Front,
    /// Inside.
    Back,
}

/// Metres to the first surface along a ray, and which side of it is met.
fn first_met(scene: &SceneAtTime, ray: &Ray) -> Option<(f64, Side)> {
    let is_near = |at: &usize| scene.objects()[*at].bounds().intersect(ray, 0.0).is_some();
    let hit = scene.first_hit(ray, (0..scene.objects().len()).filter(is_near))?;
    let normal = match hit.surface {
        HitSurface::Object { index, .. } if matches!(scene.objects()[index].shape(), Shape::Quad(_)) => {
            return Some((hit.distance, Side::Front));
        }
        HitSurface::Object { normal, .. } => normal,
        HitSurface::Mesh { index, at } => {
            let [a, b, c] = scene.meshes()[index].mesh().corners(at.triangle);
            (b - a).cross(c - a)
        }
    };
    Some((hit.distance, if normal.dot(ray.direction()) > 0.0 { Side::Back } else { Side::Front }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mesh::Mesh;
    use crate::scene::{Light, Material, Object, Quad, SceneMesh, Sphere, Texture};

    fn object(shape: Shape) -> Object {
        Object::new(shape, Material::diffuse(Texture::Solid(DVec3::ONE)))
    }

    fn scene(shapes: &[Shape]) -> SceneAtTime {
        SceneAtTime::new(shapes.iter().map(|shape| object(*shape)).collect(), Light::default())
    }

    fn ball() -> Shape {
        Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 })
    }

    fn facets_of(site: &Site, candidates: &[DVec3]) -> Facets {
        let sights = site.sights(candidates, &|| Ok(())).unwrap();
        let region = Region::parse(&["-3,-3,-3,3,3,3"]).unwrap();
        site.facets(candidates, &sights, &ViewerDistance { region: &region, least_m: 0.25 })
    }

    #[test]
    fn the_inside_of_solids_is_not_open() {
        let solid = Shape::AxisBox(AxisBox { min: DVec3::splat(3.0), max: DVec3::splat(4.0) });
        let site = Site::new(vec![scene(&[ball(), solid])], 100).unwrap();
        let open = |x: f64| site.is_open(DVec3::splat(x), 0.01);
        assert_eq!([0.0, 0.4, 0.7, 2.0, 2.999, 3.5, 5.0].map(open), [false, false, true, true, false, false, true]);
        // A room is the inside of no solid, whichever way its walls are turned.
        let wall = |corner: DVec3, u: DVec3, v: DVec3| Shape::Quad(Quad { corner, u, v });
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
        let walls = [(DVec3::ZERO, x, y), (z, x, y), (DVec3::ZERO, y, z), (x, y, z), (DVec3::ZERO, z, x), (y, z, x)];
        let room = scene(&walls.map(|(corner, u, v)| wall(corner, u, v)));
        assert!(Site::new(vec![room], 100).unwrap().is_open(DVec3::splat(0.4), 0.01));
    }

    #[test]
    fn what_moves_is_in_the_way_at_any_moment() {
        let moved = Shape::Sphere(Sphere { center: DVec3::X * 5.0, radius: 1.0 });
        let site = Site::new(vec![scene(&[ball()]), scene(&[moved])], 100).unwrap();
        let open = |x: f64| site.is_open(DVec3::X * x, 0.01);
        assert_eq!([0.2, 2.5, 5.2].map(open), [false, true, false]);
        assert_eq!(site.points().len(), 100);
    }

    #[test]
    fn a_ball_has_one_side_and_a_sheet_two() {
        let candidates = [DVec3::Y * 3.0, DVec3::NEG_Y * 3.0, DVec3::X * 3.0];
        let site = Site::new(vec![scene(&[ball()])], 500).unwrap();
        let facets = facets_of(&site, &candidates);
        assert_eq!(facets.facets.len(), 500);
        assert!(facets.facets.iter().all(|facet| facet.normal.dot(facet.point) > 0.99));
        let sheet = Quad { corner: DVec3::new(-1.0, 0.0, -1.0), u: DVec3::X * 2.0, v: DVec3::Z * 2.0 };
        let site = Site::new(vec![scene(&[Shape::Quad(sheet)])], 500).unwrap();
        assert_eq!(facets_of(&site, &candidates).facets.len(), 1000);
        let below = facets_of(&site, &candidates[..1]);
        assert!(below.facets.len() == 500 && below.facets.iter().all(|facet| facet.normal == DVec3::Y));
        assert!((below.facets.iter().map(|facet| facet.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_camera_sees_the_cap_of_a_ball() {
        let site = Site::new(vec![scene(&[ball()])], 2000).unwrap();
        let camera = DVec3::Y * 2.0;
        let facets = facets_of(&site, &[camera, DVec3::NEG_Y * 2.0, DVec3::X * 2.5]);
        let view = site.look(&facets, camera);
        // From twice the radius, all above half the radius: a quarter of the ball.
        for (at, facet) in facets.facets.iter().enumerate().filter(|(_, facet)| (facet.point.y - 0.5).abs() > 1e-3) {
            assert_eq!(view.seen[at / 64] >> (at % 64) & 1 == 1, facet.point.y > 0.5, "{facet:?}");
            assert_eq!(facet.viewer_distance_m, 0.25);
        }
        let sights = site.sights(&[camera], &|| Ok(())).unwrap();
        assert_eq!(site.view(&facets, camera, &sights[0]), view);
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
            let site = Site::new(vec![scene], 300).unwrap();
            let facets = facets_of(&site, &[DVec3::splat(3.0), DVec3::splat(-3.0)]);
            assert_eq!(facets.facets.len(), 300);
            assert!(facets.facets.iter().all(|facet| facet.normal.dot(facet.point) > 0.0));
            assert!(site.is_open(DVec3::splat(1.5), 0.01));
            // Turned inside out, it is a room.
            assert_eq!(site.is_open(DVec3::splat(0.2), 0.01), flip);
        }
    }

    #[test]
    fn nothing_is_refused() {
        let error = Site::new(vec![scene(&[])], 100).unwrap_err();
        assert!(error.to_string().contains("no surface"));
    }
}
