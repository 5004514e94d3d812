//! Balls of glass, as wholes (CALF 6.1): where they stand, and what is around them.
//!
//! Enters: active views. Leaves: the balls that the views' glass texels lie on, each with a view from its centre.
//!
//! They cost more than a small picture does. So none are made for a picture with nothing in sight that sends rays on ([`in_sight`]):
//! its rays end where they meet the first surface. That is asked of texels alone, and so is the same on all devices.
//!
//! A ball shows above all what it hides, and turns errors of its shape into larger ones of the ray. So texels of glass that
//! lie on one ball have it fitted to all of them, which is far better than the few texels around a point; and a view from the centre of
//! the ball (`surroundings`) says what the rays that leave it meet, also where no view sees it but through the ball.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::image::cube::Face;
use crate::march::active_views::{ActiveView, ActiveViews, Evidence};
use crate::march::pyramid::ViewPyramids;
use crate::march::ray::Steps;
use crate::march::specular::environment::surroundings;
use crate::march::specular::normal::SAME_PATCH;
use crate::march::specular::solid::Ball;
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::streams::convert::IOR_RANGE;
use crate::views::light_field::{BACKGROUND, ColorCoding, FaceTexels, UNKNOWN, View, has_specular_weight};

/// A ball is fitted to at least so many texels that are connected in an image.
pub const LEAST_TEXELS: usize = 32;
/// At most so many balls are known as wholes, those with the most texels in one image: each has a view of its own.
pub const MOST_BALLS: usize = 16;
/// At most so many pieces of glass are looked at for whether they are such balls.
pub const MOST_CANDIDATES: usize = 256;
/// Texels lie on a ball where they are at most so far from it, in parts of its radius.
pub const ON_BALL: f64 = 0.02;
/// A ball fits where so many of its texels lie on it.
pub const FITTING: f64 = 0.95;
/// Texels must reach over so much of the radius: a flat piece has a ball of any size.
pub const LEAST_REACH: f64 = 0.5;
/// Whether no view sees past a ball is asked at this part of its radius.
pub const WITHIN: f32 = 0.7;
/// No ball is smaller, in metres: steps around it would not be told apart.
pub const LEAST_RADIUS_M: f32 = 1e-6;
/// A point belongs to a ball where it is at most so far from its surface, in parts of its radius.
pub const NEAR_BALL: f32 = 0.03;
/// A texel is in sight where so many widths of it from its centre are: colours and materials are interpolated.
pub const MARGIN_TEXELS: f64 = 4.0;
/// Points lie in a plane where the determinant of their spread, whose trace is 1, is below this. A cap that reaches over
/// [`LEAST_REACH`] of the radius has more than 1e-4.
pub const IN_PLANE: f64 = 1e-9;

/// A ball of glass.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassBall {
    /// Where it is.
    pub ball: Ball,
    /// Index of refraction, 1 to 3.
    pub ior: f32,
    /// What is seen from its centre, along the world's axes. Its position means nothing: all is relative to the eye.
    pub view: View,
    pyramids: Arc<ViewPyramids>,
}

/// The balls of glass of some active views.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassBalls {
    /// The balls, the one with the most texels first.
    pub balls: Vec<GlassBall>,
    coding: ColorCoding,
}

impl GlassBalls {
    /// Finds the balls that views see. `camera_weights` are those of [`crate::march::interpolate::camera_weights`].
    ///
    /// # Errors
    /// When the monitor says to stop.
    pub fn of(views: &ActiveViews<'_>, camera_weights: &[f32], monitor: &dyn Monitor) -> Result<GlassBalls> {
        let balls = fitted(views, monitor)?.into_iter().enumerate();
        let with_view = |(at, (ball, ior)): (usize, (Ball, f32))| {
            // Numbers of probes begin at the other end.
            let mut view = surroundings((views, camera_weights), (ball, ior), monitor)?;
            view.probe = usize::MAX - at;
            let pyramids = Arc::new(ViewPyramids::of(&view));
            Ok(GlassBall { ball, ior, view, pyramids })
        };
        Ok(GlassBalls { balls: balls.map(with_view).collect::<Result<_>>()?, coding: views.coding })
    }

    /// The balls that a picture of these views needs: none where nothing that sends rays on is in the camera's sight.
    ///
    /// # Errors
    /// When the monitor says to stop.
    pub fn shown(
        views: &ActiveViews<'_>,
        camera_weights: &[f32],
        camera: &Camera,
        monitor: &dyn Monitor,
    ) -> Result<GlassBalls> {
        monitor.check()?;
        match in_sight(views, camera) {
            true => GlassBalls::of(views, camera_weights, monitor),
            false => Ok(GlassBalls::none(views.coding)),
        }
    }

    /// None at all.
    pub fn none(coding: ColorCoding) -> GlassBalls {
        GlassBalls { balls: Vec::new(), coding }
    }

    /// The ball whose surface is at a point, in metres from the eye.
    pub fn at(&self, point: glam::Vec3) -> Option<usize> {
        self.balls.iter().position(|GlassBall { ball, .. }| {
            ((point - ball.centre).length() - ball.radius_m).abs() <= NEAR_BALL * ball.radius_m
        })
    }

    /// The view from the centre of each ball, alone.
    pub fn around(&self) -> Vec<ActiveViews<'_>> {
        self.balls.iter().map(|ball| ActiveViews { views: vec![ball.around()], coding: self.coding }).collect()
    }
}

impl GlassBall {
    /// The view from its centre, as the eye has it.
    pub fn around(&self) -> ActiveView<'_> {
        ActiveView::new(&self.view, Arc::clone(&self.pyramids), self.ball.centre)
    }
}

/// Whether a texel that sends rays on, of mirror or glass, may be in a camera's picture, hidden or not.
pub fn in_sight(views: &ActiveViews<'_>, camera: &Camera) -> bool {
    let [forward, right, down] = camera.axes();
    let window = camera.window();
    let edges = [window.u, window.v].map(|edges| edges.map(|edge| (edge, (1.0 + edge * edge).sqrt())));
    let near_picture = |point: DVec3, margin_m: f64| {
        let depth_m = point.dot(forward);
        let beside_m = [point.dot(right), point.dot(down)];
        depth_m >= -margin_m
            && beside_m.iter().zip(edges).all(|(beside_m, [low, high])| {
                // Distances from the planes of the picture's edges.
                beside_m - high.0 * depth_m <= high.1 * margin_m && low.0 * depth_m - beside_m <= low.1 * margin_m
            })
    };
    faces(views).into_par_iter().any(|(active, face, texels)| {
        let scale = f64::from(texels.map.scale[0].abs().min(texels.map.scale[1].abs()));
        texels.material.as_ref().is_some_and(|material| {
            (0..material.len()).filter(|&at| has_specular_weight(&material[at])).any(|at| {
                let margin_m = || MARGIN_TEXELS / (f64::from(texels.inverse_depth[at]) * scale);
                texel_point(active, face, texels, at).is_some_and(|point| near_picture(point, margin_m()))
            })
        })
    })
}

/// The images that have texels which send rays on, each with its view and its number.
pub(crate) fn faces<'a>(views: &'a ActiveViews<'a>) -> Vec<(&'a ActiveView<'a>, usize, &'a FaceTexels)> {
    let of_view = |active: &'a ActiveView<'a>| {
        let faces = active.view.faces.iter().enumerate();
        faces.filter_map(move |(face, texels)| texels.as_ref().map(|texels| (active, face, texels)))
    };
    let all = views.views.iter().flat_map(of_view);
    all.filter(|(_, _, texels)| texels.is_specular && !texels.is_in_backend()).collect()
}

/// The distance of the steps by which what is around a ball is looked for: some texels of `size` a face wide.
pub(crate) fn steps_around(views: &ActiveViews<'_>, ball: &Ball, size: u32) -> Steps {
    let near_m = ball.radius_m * 2.0 / size as f32;
    Steps::new(96, near_m, views.far_m() + ball.centre.length(), 8)
}

/// The centre of a texel on the surface that it shows, in metres from the eye. None where it shows none.
pub(crate) fn texel_point(active: &ActiveView<'_>, face: usize, texels: &FaceTexels, at: usize) -> Option<DVec3> {
    let inverse = texels.inverse_depth[at];
    if inverse == BACKGROUND || inverse == UNKNOWN {
        return None;
    }
    let width = texels.size[0] as usize;
    let centre = [at % width, at / width].map(|at| at as f32 + 0.5);
    let local = texels.map.direction(Face::from_index(face as u8)?, centre).as_dvec3() / f64::from(inverse);
    let point = active.probe_from_world.as_dmat3().transpose() * local + active.from_eye.as_dvec3();
    point.is_finite().then_some(point)
}

/// Whether a texel is of glass.
pub(crate) fn is_glass(texels: &FaceTexels, at: usize) -> bool {
    texels.material.as_ref().is_some_and(|material| material[at][1] > 0)
}

/// Points that may lie on one ball.
struct Cluster {
    points: Vec<DVec3>,
    /// Sum of the indices of refraction.
    ior_sum: f64,
    /// Centres of the views that see them.
    seen_from: Vec<DVec3>,
    centre: DVec3,
    radius_m: f64,
    /// Points that it was fitted to.
    fitted: usize,
}

impl Cluster {
    fn new(points: Vec<DVec3>, ior_sum: f64, seen_from: DVec3) -> Cluster {
        let seen_from = vec![seen_from];
        Cluster { points, ior_sum, seen_from, centre: DVec3::ZERO, radius_m: 0.0, fitted: 0 }
    }

    /// The part of some points that lies on the ball.
    fn fitting(&self, points: &[DVec3]) -> f64 {
        let far_m = ON_BALL * self.radius_m;
        let near = points.iter().filter(|point| ((**point - self.centre).length() - self.radius_m).abs() <= far_m);
        near.count() as f64 / points.len() as f64
    }

    /// Fits the ball to the points; false where none fits.
    fn fit(&mut self) -> bool {
        self.fitted = self.points.len();
        let Some((centre, radius_m)) = fit(&self.points) else { return false };
        (self.centre, self.radius_m) = (centre, radius_m);
        let [low, high] = [DVec3::min, DVec3::max].map(|of| self.points.iter().copied().reduce(of).unwrap_or_default());
        let is_outside = |from: &DVec3| (*from - centre).length() > radius_m;
        (high - low).length() >= LEAST_REACH * radius_m
            && self.fitting(&self.points) >= FITTING
            && self.seen_from.iter().all(is_outside)
    }
}

/// The balls of glass texels with their indices of refraction.
fn fitted(views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Vec<(Ball, f32)>> {
    let of_face = |(active, face, texels): (&ActiveView<'_>, usize, &FaceTexels)| {
        monitor.check()?;
        Ok(connected(active, face, texels))
    };
    let found: Vec<Vec<Cluster>> = faces(views).into_par_iter().map(of_face).collect::<Result<_>>()?;
    let mut pieces: Vec<Cluster> = found.into_iter().flatten().collect();
    pieces.sort_by_key(|piece: &Cluster| std::cmp::Reverse(piece.points.len()));
    let mut clusters: Vec<Cluster> = Vec::new();
    for mut piece in pieces {
        monitor.check()?;
        let is_room = clusters.len() < MOST_CANDIDATES;
        match clusters.iter_mut().find(|cluster| cluster.fitting(&piece.points) >= FITTING) {
            Some(cluster) => {
                cluster.points.append(&mut piece.points);
                cluster.seen_from.append(&mut piece.seen_from);
                cluster.ior_sum += piece.ior_sum;
                // Else pieces of a texel each would take a time that grows as their number squared.
                if cluster.points.len() >= 2 * cluster.fitted {
                    cluster.fit();
                }
            }
            None if is_room && piece.points.len() >= LEAST_TEXELS && piece.fit() => {
                clusters.push(piece);
            }
            None => {}
        }
    }
    let of_cluster = |mut cluster: Cluster| {
        let fits = cluster.fit();
        let ball = Ball { centre: cluster.centre.as_vec3(), radius_m: cluster.radius_m as f32 };
        let is_outside = ball.radius_m >= LEAST_RADIUS_M && ball.centre.length() > ball.radius_m;
        let ior = (cluster.ior_sum / cluster.points.len() as f64) as f32;
        (fits && is_outside && is_whole(views, &ball)).then_some((ball, ior))
    };
    Ok(clusters.into_iter().filter_map(of_cluster).take(MOST_BALLS).collect())
}

/// Whether no view sees past what should be within a ball.
fn is_whole(views: &ActiveViews<'_>, ball: &Ball) -> bool {
    (0..27).all(|at| {
        let way = glam::Vec3::new((at % 3) as f32, (at / 3 % 3) as f32, (at / 9) as f32) - 1.0;
        let point = ball.centre + WITHIN * ball.radius_m * way.normalize_or_zero();
        views.views.iter().all(|view| view.evidence(point) != Evidence::Open)
    })
}

/// The glass texels of an image that are beside each other and at much the same depth.
fn connected(active: &ActiveView<'_>, face: usize, texels: &FaceTexels) -> Vec<Cluster> {
    let Some(material) = &texels.material else { return Vec::new() };
    let [width, height] = texels.size.map(|size| size as usize);
    // Mirrors alone need no list.
    if !(0..material.len()).any(|at| is_glass(texels, at)) {
        return Vec::new();
    }
    let mut taken: Vec<bool> = (0..material.len()).map(|at| !is_glass(texels, at)).collect();
    let mut found = Vec::new();
    for start in 0..taken.len() {
        if std::mem::replace(&mut taken[start], true) {
            continue;
        }
        let (mut open, mut points, mut ior_sum) = (vec![start], Vec::new(), 0.0);
        while let Some(at) = open.pop() {
            let Some(point) = texel_point(active, face, texels, at) else { continue };
            points.push(point);
            let part = f64::from(material[at][2]) / 255.0;
            ior_sum += f64::from(IOR_RANGE[0]) + part * f64::from(IOR_RANGE[1] - IOR_RANGE[0]);
            let (column, row) = (at % width, at / width);
            let beside = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then(|| at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < height).then(|| at + width),
            ];
            for next in beside.into_iter().flatten() {
                let [a, b] = [at, next].map(|at| texels.inverse_depth[at]);
                if !taken[next] && (a - b).abs() <= SAME_PATCH * a.max(b) {
                    taken[next] = true;
                    open.push(next);
                }
            }
        }
        if !points.is_empty() {
            found.push(Cluster::new(points, ior_sum, active.from_eye.as_dvec3()));
        }
    }
    found
}

/// Centre and radius of the ball that points lie on, by least squares of |x − centre|² − radius². None where they lie in a
/// plane, or nearly ([`IN_PLANE`]).
fn fit(points: &[DVec3]) -> Option<(DVec3, f64)> {
    let count = points.len() as f64;
    let middle = points.iter().copied().sum::<DVec3>() / count;
    // In units of how far they are from their middle: nothing else tells what is small.
    let unit_m = (points.iter().map(|point| (*point - middle).length_squared()).sum::<f64>() / count).sqrt();
    let (mut spread, mut pull) = (DMat3::ZERO, DVec3::ZERO);
    for point in points {
        let from = (*point - middle) / unit_m;
        spread += DMat3::from_cols(from * from.x, from * from.y, from * from.z);
        pull += 0.5 * from.length_squared() * from;
    }
    (spread, pull) = (spread * count.recip(), pull / count);
    // Also where all points are one, and nothing is a number.
    if spread.determinant().is_nan() || spread.determinant() < IN_PLANE {
        return None;
    }
    let to_centre = spread.inverse() * pull;
    // The mean square of the distances from the middle is 1.
    let radius_m = unit_m * (to_centre.length_squared() + 1.0).sqrt();
    let centre = middle + unit_m * to_centre;
    (centre.is_finite() && radius_m.is_finite() && radius_m > 0.0).then_some((centre, radius_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use crate::error::Error;
    use crate::image::transfer::{ToneMap, Transfer};
    use crate::march::interpolate::camera_weights;
    use crate::march::synthetic::{Made, field};
    use crate::math::Lens;
    use crate::monitor::Silent;
    use crate::views::light_field::LightField;

    const AWAY_M: f64 = 3.0;
    const RADIUS_M: f64 = 0.5;

    fn balls(field: &LightField, views: &[usize]) -> GlassBalls {
        let views = ActiveViews::new(field, views, DVec3::ZERO);
        GlassBalls::of(&views, &camera_weights(&views), &Silent).unwrap()
    }

    /// Beads of glass around a probe, and where they are.
    fn beads(count: usize) -> (LightField, Vec<DVec3>) {
        // Turned by the golden angle from one to the next.
        let centre = |at: usize| {
            let y = 1.0 - (2 * at + 1) as f64 / count as f64;
            let (sin, cos) = (2.399_963_23 * at as f64).sin_cos();
            AWAY_M * DVec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin)
        };
        let centres: Vec<DVec3> = (0..count).map(centre).collect();
        let radii = vec![RADIUS_M; count];
        (field(vec![glass(&centres, &radii)], CODING), centres)
    }

    const CODING: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });

    /// What a probe in the origin sees of balls of glass before nothing.
    fn glass(centres: &[DVec3], radii_m: &[f64]) -> View {
        let sight = |direction: DVec3| {
            let met_m = |(centre, radius_m): (&DVec3, &f64)| {
                let along = centre.dot(direction);
                let squared = radius_m * radius_m - (centre.length_squared() - along * along);
                (along > 0.0 && squared > 0.0).then(|| along - squared.sqrt())
            };
            centres.iter().zip(radii_m).find_map(met_m).map(|distance_m| (distance_m, [50; 3]))
        };
        let mut view = Made::new(DVec3::ZERO, 64).cube(CODING, &sight);
        for texels in view.faces.iter_mut().flatten() {
            let glass = |&inverse: &f32| if inverse == BACKGROUND { [0; 4] } else { [0, 255, 64, 0] };
            texels.material = Some(texels.inverse_depth.iter().map(glass).collect());
            texels.update_specular();
        }
        view
    }

    #[test]
    fn beads_are_found_up_to_a_number() {
        for count in [1, 5, MOST_BALLS, MOST_BALLS + 4] {
            let (field, centres) = beads(count);
            let found = balls(&field, &[0]);
            assert_eq!(found.balls.len(), count.min(MOST_BALLS));
            for GlassBall { ball, ior, .. } in &found.balls {
                let off_m = |centre: &DVec3| (*centre - ball.centre.as_dvec3()).length();
                assert_eq!(centres.iter().filter(|centre| off_m(centre) < 1e-3).count(), 1, "{ball:?}");
                assert!((f64::from(ball.radius_m) - RADIUS_M).abs() < 1e-3 && (1.0..=3.0).contains(ior), "{ball:?}");
            }
        }
    }

    /// A second view sees past all balls but the smallest.
    #[test]
    fn what_is_not_whole_keeps_no_ball_out() {
        let (_, mut centres) = beads(2 * MOST_BALLS + 1);
        centres.swap(0, 2 * MOST_BALLS);
        let mut radii = vec![0.4; centres.len()];
        radii[2 * MOST_BALLS] = 0.3;
        let small = [centres[2 * MOST_BALLS]];
        let field = field(vec![glass(&centres, &radii), glass(&small, &[0.3])], CODING);
        assert_eq!(balls(&field, &[0]).balls.len(), MOST_BALLS);
        let found = balls(&field, &[0, 1]);
        let [GlassBall { ball, .. }] = &found.balls[..] else { panic!("{:?}", found.balls.len()) };
        assert!(ball.centre.distance(small[0].as_vec3()) < 1e-3 && (ball.radius_m - 0.3).abs() < 1e-3, "{ball:?}");
    }

    #[test]
    fn balls_are_made_where_some_are_in_sight() {
        let field = field(vec![glass(&[DVec3::new(0.0, 0.0, -AWAY_M)], &[RADIUS_M])], CODING);
        let views = ActiveViews::new(&field, &[0], DVec3::ZERO);
        let seen = |target: DVec3, lens: Lens| {
            let camera = Camera::look_at(DVec3::ZERO, target, DVec3::Y, lens).unwrap();
            let shown = GlassBalls::shown(&views, &[1.0], &camera, &Silent).unwrap();
            assert_eq!(shown.balls.len() == 1, in_sight(&views, &camera));
            in_sight(&views, &camera)
        };
        assert!(seen(DVec3::NEG_Z, Lens::new(10.0)) && seen(DVec3::new(1.0, 0.0, -1.0), Lens::new(90.0)));
        assert!(!seen(DVec3::Z, Lens::new(170.0)) && !seen(DVec3::X, Lens::new(90.0)));
        assert!(
            !seen(DVec3::new(1.0, 0.0, -1.0), Lens::new(40.0)) && !seen(DVec3::new(0.0, 1.0, -1.0), Lens::new(40.0))
        );
        // Wider than high.
        let wide = Lens { aspect: 4.0, ..Lens::new(40.0) };
        assert!(seen(DVec3::new(1.0, 0.0, -1.0), wide) && !seen(DVec3::new(0.0, 1.0, -1.0), wide));
        assert!(!in_sight(
            &ActiveViews { views: Vec::new(), coding: CODING },
            &Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, wide).unwrap()
        ));
    }

    /// Stops when it was asked so often.
    struct Stops {
        asked: AtomicUsize,
        after: usize,
    }

    impl Monitor for Stops {
        fn advance(&self, _steps: u64) {}

        fn interrupted(&self) -> bool {
            self.asked.fetch_add(1, Ordering::Relaxed) >= self.after
        }
    }

    #[test]
    fn balls_stop_when_they_are_told_to() {
        let (field, _) = beads(1);
        let views = ActiveViews::new(&field, &[0], DVec3::ZERO);
        let with = |after: usize| {
            let monitor = Stops { asked: AtomicUsize::new(0), after };
            (GlassBalls::of(&views, &[1.0], &monitor), monitor.asked.into_inner())
        };
        let (all, asked) = with(usize::MAX);
        // For each row of the view from the centre, at least.
        assert!(all.is_ok() && asked > 6 * 64, "{asked}");
        for after in [0, 1, asked / 2, asked - 1] {
            assert!(matches!(with(after).0, Err(Error::Interrupted)), "{after} of {asked}");
        }
    }

    #[test]
    fn fits_know_no_size() {
        // A cap that reaches over half the radius, and a plane.
        let cap = |at: usize| {
            let [x, y] = [at % 9, at / 9].map(|at| (at as f64 - 4.0) / 20.0);
            DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
        };
        for size in [1e-30, 1e-5, 1.0, 1e5, 1e30] {
            let middle = size * DVec3::new(3.0, -2.0, 7.0);
            let points: Vec<DVec3> = (0..81).map(|at| middle + size * cap(at)).collect();
            let (centre, radius_m) = fit(&points).unwrap();
            assert!((centre - middle).length() < 1e-9 * size && (radius_m / size - 1.0).abs() < 1e-9, "{size}");
            let flat: Vec<DVec3> = points.iter().map(|point| point.with_z(point.x + 0.3 * point.y)).collect();
            assert_eq!((fit(&flat), fit(&flat[..1])), (None, None), "{size}");
        }
        assert_eq!(fit(&[]), None);
    }
}
