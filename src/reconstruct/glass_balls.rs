//! Balls of glass, as wholes (CALF 6.1): where they stand, and what is around them.
//!
//! Enters: active views. Leaves: the balls that the views' glass texels lie on, each with a view from its centre.
//!
//! A ball shows above all what it hides, and turns errors of its shape into larger ones of the ray. So texels of glass that
//! lie on one ball have it fitted to all of them, which is far better than the few texels around a point; and a view from the centre of
//! the ball (`surroundings`) says what the rays that leave it meet, also where no view sees it but through the ball.

use glam::{DMat3, DVec3};

use crate::image::cube::Face;
use crate::reconstruct::active_views::{ActiveView, ActiveViews, Evidence};
use crate::reconstruct::light_field::{BACKGROUND, ColorCoding, FaceTexels, UNKNOWN, View};
use crate::reconstruct::march::Steps;
use crate::reconstruct::normal::SAME_PATCH;
use crate::reconstruct::solid::Ball;
use crate::reconstruct::surroundings::surroundings;
use crate::video::convert::IOR_RANGE;

/// A ball is fitted to at least so many texels that are connected in an image.
pub const LEAST_TEXELS: usize = 32;
/// At most so many balls are known as wholes, those with the most texels in one image: each has a view of its own.
pub const MOST_BALLS: usize = 16;
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

/// A ball of glass.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassBall {
    /// Where it is.
    pub ball: Ball,
    /// Index of refraction, 1 to 3.
    pub ior: f32,
    /// What is seen from its centre, along the world's axes. Its position means nothing: all is relative to the eye.
    pub view: View,
}

/// The balls of glass of some active views.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassBalls {
    /// The balls, the one with the most texels first.
    pub balls: Vec<GlassBall>,
    coding: ColorCoding,
}

impl GlassBalls {
    /// Finds the balls that views see. `camera_weights` are those of [`super::interpolate::camera_weights`].
    pub fn of(views: &ActiveViews<'_>, camera_weights: &[f32]) -> GlassBalls {
        let balls = fitted(views).into_iter().enumerate();
        let with_view = |(at, (ball, ior)): (usize, (Ball, f32))| {
            // Numbers of probes begin at the other end.
            let mut view = surroundings(views, camera_weights, (ball, ior));
            view.probe = usize::MAX - at;
            GlassBall { ball, ior, view }
        };
        GlassBalls { balls: balls.map(with_view).collect(), coding: views.coding }
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
        let alone = |ball| ActiveViews { views: vec![from_centre(ball)], coding: self.coding };
        self.balls.iter().map(alone).collect()
    }
}

/// The view from the centre of a ball.
pub fn from_centre(of: &GlassBall) -> ActiveView<'_> {
    ActiveView {
        view: &of.view,
        from_eye: of.ball.centre,
        probe_from_world: glam::Mat3::IDENTITY,
        greatest_inverse_depth: of.view.greatest_inverse_depth(),
    }
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
    let [forward, right, down] = Face::from_index(face as u8)?.axes();
    let width = texels.size[0] as usize;
    let [u, v] = [0, 1].map(|axis| {
        let place = [at % width, at / width][axis] as f64 + 0.5;
        (place - f64::from(texels.centre[axis])) / f64::from(texels.scale[axis])
    });
    let local = (forward + u * right + v * down) / f64::from(inverse);
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
}

impl Cluster {
    /// The part of some points that lies on the ball.
    fn fitting(&self, points: &[DVec3]) -> f64 {
        let far_m = ON_BALL * self.radius_m;
        let near = points.iter().filter(|point| ((**point - self.centre).length() - self.radius_m).abs() <= far_m);
        near.count() as f64 / points.len() as f64
    }

    /// Fits the ball to the points; false where none fits.
    fn fit(&mut self) -> bool {
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
fn fitted(views: &ActiveViews<'_>) -> Vec<(Ball, f32)> {
    let mut pieces = Vec::new();
    for active in &views.views {
        for (face, texels) in active.view.faces.iter().enumerate() {
            if let Some(texels) = texels.as_ref().filter(|texels| texels.calls_for_effects) {
                pieces.extend(connected(active, face, texels));
            }
        }
    }
    pieces.sort_by_key(|piece: &Cluster| std::cmp::Reverse(piece.points.len()));
    let mut clusters: Vec<Cluster> = Vec::new();
    for mut piece in pieces {
        let has_room = clusters.len() < MOST_BALLS;
        match clusters.iter_mut().find(|cluster| cluster.fitting(&piece.points) >= FITTING) {
            Some(cluster) => {
                cluster.points.append(&mut piece.points);
                cluster.seen_from.append(&mut piece.seen_from);
                cluster.ior_sum += piece.ior_sum;
                cluster.fit();
            }
            None if has_room && piece.points.len() >= LEAST_TEXELS && piece.fit() => {
                clusters.push(piece);
            }
            None => {}
        }
    }
    let of_cluster = |cluster: &mut Cluster| {
        let ball = Ball { centre: cluster.centre.as_vec3(), radius_m: cluster.radius_m as f32 };
        let is_outside = ball.radius_m >= LEAST_RADIUS_M && ball.centre.length() > ball.radius_m;
        let ior = (cluster.ior_sum / cluster.points.len() as f64) as f32;
        (cluster.fit() && is_outside && is_whole(views, &ball)).then_some((ball, ior))
    };
    clusters.iter_mut().filter_map(of_cluster).collect()
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
            let seen_from = vec![active.from_eye.as_dvec3()];
            found.push(Cluster { points, ior_sum, seen_from, centre: DVec3::ZERO, radius_m: 0.0 });
        }
    }
    found
}

/// Centre and radius of the ball that points lie on, by least squares of |x − centre|² − radius². None where they lie in a
/// plane.
fn fit(points: &[DVec3]) -> Option<(DVec3, f64)> {
    let count = points.len() as f64;
    let middle = points.iter().copied().sum::<DVec3>() / count;
    let (mut spread, mut pull, mut squares) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for point in points {
        let from = *point - middle;
        let square = from.length_squared();
        spread += DMat3::from_cols(from * from.x, from * from.y, from * from.z);
        pull += 0.5 * square * from;
        squares += square;
    }
    let to_centre = spread.inverse() * pull;
    let radius_m = (to_centre.length_squared() + squares / count).sqrt();
    (to_centre.is_finite() && radius_m.is_finite() && radius_m > 0.0).then_some((middle + to_centre, radius_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::transfer::ToneMap;
    use crate::reconstruct::interpolate::camera_weights;
    use crate::reconstruct::light_field::LightField;
    use crate::reconstruct::made::{Made, field};

    const AWAY_M: f64 = 3.0;
    const RADIUS_M: f64 = 0.5;

    /// Beads of glass around a probe, and where they are.
    fn beads(count: usize) -> (LightField, Vec<DVec3>) {
        // Turned by the golden angle from one to the next.
        let centre = |at: usize| {
            let y = 1.0 - (2 * at + 1) as f64 / count as f64;
            let (sin, cos) = (2.399_963_23 * at as f64).sin_cos();
            AWAY_M * DVec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin)
        };
        let centres: Vec<DVec3> = (0..count).map(centre).collect();
        let sight = |direction: DVec3| {
            let met_m = |centre: &DVec3| {
                let along = centre.dot(direction);
                let squared = RADIUS_M * RADIUS_M - (centre.length_squared() - along * along);
                (along > 0.0 && squared > 0.0).then(|| along - squared.sqrt())
            };
            centres.iter().find_map(met_m).map(|distance_m| (distance_m, [50; 3]))
        };
        let coding = ColorCoding::Codes(ToneMap::default());
        let mut view = Made::new(DVec3::ZERO, 64).cube(coding, &sight);
        for texels in view.faces.iter_mut().flatten() {
            let glass = |&inverse: &f32| if inverse == BACKGROUND { [0; 4] } else { [0, 255, 64, 0] };
            texels.material = Some(texels.inverse_depth.iter().map(glass).collect());
            texels.material_changed();
        }
        (field(vec![view], coding), centres)
    }

    #[test]
    fn beads_are_found_up_to_a_number() {
        for count in [1, 5, MOST_BALLS, MOST_BALLS + 4] {
            let (field, centres) = beads(count);
            let views = ActiveViews::new(&field, &[0], DVec3::ZERO);
            let found = GlassBalls::of(&views, &camera_weights(&views));
            assert_eq!(found.balls.len(), count.min(MOST_BALLS));
            for GlassBall { ball, ior, .. } in &found.balls {
                let off_m = |centre: &DVec3| (*centre - ball.centre.as_dvec3()).length();
                assert_eq!(centres.iter().filter(|centre| off_m(centre) < 1e-3).count(), 1, "{ball:?}");
                assert!((f64::from(ball.radius_m) - RADIUS_M).abs() < 1e-3 && (1.0..=3.0).contains(ior), "{ball:?}");
            }
        }
    }
}
