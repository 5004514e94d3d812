//! Normal and curvature of a surface point, estimated from the depths around it (CALF 6.1).
//!
//! Each view that sees the point fits a quadratic polynomial to the inverse planar depths of 5 × 5 or 3 × 3 texels. Planes are
//! linear in inverse planar depth, so they are fitted exactly. At an edge it fits a plane to the texels of the same surface.
//! Normals of views are averaged with the weights of their colours times the cosine of the viewing angle: the few texels of one
//! view are too noisy, and a mirror doubles the error.

use glam::Vec3;

use crate::march::{ActiveView, ActiveViews, DEPTH_EPSILON};
use crate::views::{BACKGROUND, FaceTexels, UNKNOWN};
use codec::image::Face;

/// Maximum difference of log depths at which a view sees a point.
pub const SAME_SURFACE: f32 = 0.02;
/// Maximum number of texels of a fit on each side of its centre: 5 × 5.
pub const MAX_REACH: i32 = 2;
/// Maximum relative residual of a polynomial: slightly more than the quantisation of depth codes.
pub const FIT: f32 = 0.01;
/// Maximum relative difference of the inverse depths of adjacent texels of one surface.
pub const SAME_PATCH: f32 = 0.03;
/// Maximum difference of the sums of weights, in 255ths, of texels of one solid.
pub const SAME_MATERIAL: i32 = 64;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Unit normal in world axes, on the side of the views.
    pub normal: Vec3,
    /// Rotation of the normal in radians per metre: 1 over the radius of a sphere, 0 for a flat surface, below 0 for a concave
    /// one. None if too few texels are known.
    pub curvature: Option<f32>,
    /// Width in metres of a texel of the view with the maximum weight.
    pub texel_m: f32,
}

/// Returns the surface at a point. None if no view has a fit.
pub fn patch(views: &ActiveViews<'_>, point: Vec3) -> Option<Patch> {
    let (mut normal, mut curvature, mut bent, mut best) = (Vec3::ZERO, 0.0, 0.0, [0.0, 0.0]);
    for view in &views.views {
        let Some(seen) = of_view(view, view.local(point)) else { continue };
        let weight = view.camera_weight * seen.facing / (seen.difference + DEPTH_EPSILON);
        normal += weight * (view.probe_from_world.transpose() * seen.normal);
        if let Some(bend) = seen.curvature {
            curvature += weight * bend;
            bent += weight;
        }
        if weight > best[0] {
            best = [weight, seen.texel_m];
        }
    }
    let normal = normal.try_normalize()?;
    Some(Patch { normal, curvature: (bent > 0.0).then(|| curvature / bent), texel_m: best[1] })
}

/// Surface estimate of one view, in the view's axes.
#[derive(Debug, Clone, Copy)]
struct Local {
    normal: Vec3,
    curvature: Option<f32>,
    texel_m: f32,
    /// Difference of the log depths of the fit and of the point.
    difference: f32,
    /// Cosine of the angle between the normal and the direction to the viewpoint.
    facing: f32,
}

fn of_view(view: &ActiveView<'_>, local: Vec3) -> Option<Local> {
    let at = view.view.project(local)?;
    let face = view.view.faces[at.face].as_ref()?;
    let texel = [0, 1].map(|axis| (at.at[axis].max(0.0) as u32).min(face.size[axis] - 1));
    let offset = [0, 1].map(|axis| at.at[axis] - (texel[axis] as f32 + 0.5));
    let solid = solid(face, texel[1] as usize * face.size[0] as usize + texel[0] as usize);
    let image = Image { face, number: Face::from_index(at.face as u8)?, texel, solid };
    let fit = image.fit()?;
    let difference = (fit.value(offset) / at.inverse_depth).ln().abs();
    if difference.is_nan() || difference > SAME_SURFACE {
        return None;
    }
    let normal = image.normal(&fit, offset)?;
    let facing = -normal.dot(local.normalize_or_zero());
    let curvature = if fit.bends { image.curvature(&fit) } else { None };
    let texel_m = 1.0 / (at.inverse_depth * face.map.scale[0].abs().min(face.map.scale[1].abs()));
    (facing > 0.0).then_some(Local { normal, curvature, texel_m, difference, facing })
}

/// Inverse depth around the centre of a texel, in texels: `c[0] + c[1]x + c[2]y + c[3]x² + c[4]xy + c[5]y²`.
#[derive(Debug, Clone, Copy)]
struct Fit {
    c: [f32; 6],
    /// True if the quadratic terms are known.
    bends: bool,
}

impl Fit {
    fn value(&self, [x, y]: [f32; 2]) -> f32 {
        let c = &self.c;
        c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y
    }

    fn slope(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let c = &self.c;
        [c[1] + 2.0 * c[3] * x + c[4] * y, c[2] + c[4] * x + 2.0 * c[5] * y]
    }
}

struct Image<'a> {
    face: &'a FaceTexels,
    number: Face,
    texel: [u32; 2],
    /// See [`solid`].
    solid: Option<i32>,
}

impl Image<'_> {
    fn place(&self, offset: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|axis| self.texel[axis] as f32 + 0.5 + offset[axis])
    }

    /// Returns the unit normal. The surface has `inverse depth = normal · (u, v, 1)`, up to the length of the normal.
    fn normal(&self, fit: &Fit, offset: [f32; 2]) -> Option<Vec3> {
        let [u, v] = self.face.map.plane(self.place(offset));
        let [x, y] = fit.slope(offset);
        let [by_u, by_v] = [x * self.face.map.scale[0], y * self.face.map.scale[1]];
        let ahead = fit.value(offset) - by_u * u - by_v * v;
        let [forward, right, down] = self.number.axes().map(|axis| axis.as_vec3());
        (-(by_u * right + by_v * down + ahead * forward)).try_normalize()
    }

    fn point(&self, fit: &Fit, offset: [f32; 2]) -> Vec3 {
        self.face.map.direction(self.number, self.place(offset)) / fit.value(offset)
    }

    /// Returns the rotation of the normal per metre, measured over two texels along each axis.
    fn curvature(&self, fit: &Fit) -> Option<f32> {
        let (mut turned, mut moved) = (0.0, 0.0);
        for [a, b] in [[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]] {
            let along = self.point(fit, b) - self.point(fit, a);
            turned += along.dot(self.normal(fit, b)? - self.normal(fit, a)?);
            moved += along.length_squared();
        }
        let curvature = turned / moved;
        curvature.is_finite().then_some(curvature)
    }

    /// Returns the inverse depth of a neighbour that may belong to the same surface.
    fn get(&self, x: i32, y: i32) -> Option<f32> {
        let column = self.texel[0].checked_add_signed(x).filter(|&column| column < self.face.size[0])?;
        let row = self.texel[1].checked_add_signed(y).filter(|&row| row < self.face.size[1])?;
        let at = row as usize * self.face.size[0] as usize + column as usize;
        let inverse = self.face.inverse_depth[at];
        let same = match (self.solid, solid(self.face, at)) {
            (Some(a), Some(b)) => (a - b).abs() <= SAME_MATERIAL,
            _ => true,
        };
        (same && inverse != BACKGROUND && inverse != UNKNOWN).then_some(inverse)
    }

    fn fit(&self) -> Option<Fit> {
        self.get(0, 0)?;
        (1..=MAX_REACH).rev().find_map(|reach| self.bent(reach)).or_else(|| self.flat())
    }

    /// Fits a quadratic polynomial by least squares to a complete square of (2·reach + 1)² texels. None if the residual is too
    /// large.
    fn bent(&self, reach: i32) -> Option<Fit> {
        let side = (2 * reach + 1) as f32;
        // Sums of x² and of (x² − mean)² over a row.
        let sum = |term: fn(f32, f32) -> f32, mean: f32| (-reach..=reach).map(|x| term(x as f32, mean)).sum::<f32>();
        let squares = sum(|x, _| x * x, 0.0);
        let mean_square = squares / side;
        let fourths = sum(|x, mean| (x * x - mean) * (x * x - mean), mean_square);
        let mut sums = [0.0; 6];
        for y in -reach..=reach {
            for x in -reach..=reach {
                let inverse = self.get(x, y)?;
                let (x, y) = (x as f32, y as f32);
                let basis = [1.0, x, y, x * x - mean_square, x * y, y * y - mean_square];
                for (sum, base) in sums.iter_mut().zip(basis) {
                    *sum += base * inverse;
                }
            }
        }
        let norms = [side * side, side * squares, side * squares, side * fourths, squares * squares, side * fourths];
        let mut c = [0, 1, 2, 3, 4, 5].map(|at| sums[at] / norms[at]);
        c[0] -= mean_square * (c[3] + c[5]);
        let fit = Fit { c, bends: true };
        let far = FIT * c[0];
        for y in -reach..=reach {
            for x in -reach..=reach {
                if (self.get(x, y)? - fit.value([x as f32, y as f32])).abs() > far {
                    return None;
                }
            }
        }
        Some(fit)
    }

    /// Fits a plane through the centre of 3 × 3 texels to those with a similar inverse depth.
    fn flat(&self) -> Option<Fit> {
        let middle = self.get(0, 0)?;
        let (mut xx, mut xy, mut yy, mut xd, mut yd) = (0.0f32, 0.0f32, 0.0f32, 0.0f32, 0.0f32);
        for y in -1..=1 {
            for x in -1..=1 {
                let Some(inverse) = self.get(x, y).filter(|other| (other - middle).abs() <= SAME_PATCH * middle) else {
                    continue;
                };
                let (x, y, difference) = (x as f32, y as f32, inverse - middle);
                xx += x * x;
                xy += x * y;
                yy += y * y;
                xd += x * difference;
                yd += y * difference;
            }
        }
        let determinant = xx * yy - xy * xy;
        if determinant < 0.5 {
            return None;
        }
        let c = [middle, (xd * yy - yd * xy) / determinant, (yd * xx - xd * xy) / determinant, 0.0, 0.0, 0.0];
        Some(Fit { c, bends: false })
    }
}

/// Returns the sum of the weights of a texel, in 255ths.
fn solid(face: &FaceTexels, at: usize) -> Option<i32> {
    face.material.as_ref().map(|texels| i32::from(texels[at][0]) + i32::from(texels[at][1]))
}
