//! Cameras of Seurat manifests: the ray through a pixel centre, and the position of a stored depth on it.
//!
//! Matrices follow OpenGL: eye space is right-handed, clip coordinates −w to w cover the image from left to right and from bottom
//! to top, and window depth 0 to 1 is clip depth −w to w. Multiples of a matrix describe the same camera.

use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4, Vec4Swizzles};
use serde::Serialize;

use codec::error::{Error, Result};
use codec::math::{Camera, Lens};

/// Minimum determinant of an invertible matrix that is scaled so that the largest entry of each column is 1.
const MIN_DETERMINANT: f64 = 1e-10;
/// Entries smaller than this fraction of the last entry of their row are rounding errors of 0.
const ROUNDING: f64 = 1e-9;
/// If the w of an unprojected point is below this fraction of its terms, it is 0 up to rounding of 64-bit sums.
const INFINITE_W: f64 = 1e-12;
/// As [`INFINITE_W`], for negative w: matrices rounded to 32 bits put a distant far plane slightly beyond infinity.
const BEYOND_INFINITY: f64 = 1e-6;
/// Maximum relative change of length by a pose that counts as a rotation, so that its rounding does not change a stored distance.
const RIGID: f64 = 1e-12;
/// Maximum cosine of the angle between rows and columns of an image without skew.
const MAX_SKEW: f64 = 1e-6;

/// Quantity of a stored depth. For every type, 0 and +inf mean infinitely far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum DepthType {
    /// Window depth, 0 to 1.
    #[serde(rename = "WINDOW_Z")]
    WindowZ,
    /// Distance from the eye plane along −z of eye space.
    #[serde(rename = "EYE_Z")]
    EyeZ,
    /// Distance in eye space along the ray: from the centre of projection, or for an orthographic camera from the eye plane.
    #[serde(rename = "RAY_DEPTH")]
    RayDepth,
}

impl DepthType {
    pub const ALL: [DepthType; 3] = [DepthType::WindowZ, DepthType::EyeZ, DepthType::RayDepth];

    /// Returns the name used in manifests.
    pub fn name(self) -> &'static str {
        match self {
            DepthType::WindowZ => "WINDOW_Z",
            DepthType::EyeZ => "EYE_Z",
            DepthType::RayDepth => "RAY_DEPTH",
        }
    }
}

/// The matrices of a camera, each with 16 numbers in row-major order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraMatrices {
    pub clip_from_eye: [f64; 16],
    pub world_from_eye: [f64; 16],
}

/// World-space ray of a pixel, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRay {
    /// Centre of the camera. For an orthographic camera, a point on the eye plane, or for [`DepthType::WindowZ`] on the near
    /// plane, which may be behind the eye.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Distance from the origin to the surface, positive; +inf if infinitely far.
    pub distance_m: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Sight {
    Perspective(Pencil),
    Orthographic,
}

/// The rays of a perspective camera in eye space.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pencil {
    centre: DVec3,
    /// The direction of the ray at clip coordinates (x, y) is this matrix times (x, y, 1). The largest entry of its last column
    /// is 1, so that directions on cube faces are bit-identical to [`codec::image::Face::direction`].
    steps: DMat3,
    /// A point on the ray is centre + step · unit / w, where w belongs to its unprojected clip coordinates and is the reciprocal
    /// of its clip w, positive in front of the camera.
    unit: f64,
}

/// A validated camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeuratCamera {
    size: [u32; 2],
    depth_type: DepthType,
    eye_from_clip: DMat4,
    sight: Sight,
    world_from_eye: DAffine3,
}

impl SeuratCamera {
    /// Creates a camera; `size` is the width and height of the image in pixels. Fails if a matrix is singular, or the pose has a
    /// perspective row.
    pub fn new(size: [u32; 2], depth_type: DepthType, matrices: &CameraMatrices) -> Result<SeuratCamera> {
        let clip_from_eye = row_major(&matrices.clip_from_eye);
        let eye_from_clip = inverse(clip_from_eye).ok_or_else(|| {
            Error::invalid("clip_from_eye_matrix is singular: the inverse of a projection was expected to exist")
        })?;
        Ok(SeuratCamera {
            size,
            depth_type,
            eye_from_clip,
            sight: sight(clip_from_eye.row(3), eye_from_clip)?,
            world_from_eye: pose(row_major(&matrices.world_from_eye))?,
        })
    }

    /// Width and height of the image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    pub fn depth_type(&self) -> DepthType {
        self.depth_type
    }

    pub fn is_orthographic(&self) -> bool {
        self.sight == Sight::Orthographic
    }

    /// Centre of projection, or for an orthographic camera the origin of eye space; in world space, in metres.
    pub fn position(&self) -> DVec3 {
        let eye = match self.sight {
            Sight::Perspective(pencil) => pencil.centre,
            Sight::Orthographic => DVec3::ZERO,
        };
        self.world_from_eye.transform_point3(eye)
    }

    /// Returns the ray through the centre of a pixel, row 0 at the top, with the distance of a stored depth along it. Fails if
    /// the depth is invalid; the error states why.
    pub fn ray(&self, pixel: [u32; 2], depth: f32) -> Result<PixelRay> {
        let depth_type = self.depth_type.name();
        if depth.is_nan() {
            return Err(Error::invalid(format!("{depth_type} is not a number")));
        }
        if depth < 0.0 {
            return Err(Error::invalid(format!("{depth_type} is {depth}, 0 or more was expected")));
        }
        if self.depth_type == DepthType::WindowZ && depth > 1.0 && depth.is_finite() {
            return Err(Error::invalid(format!("{depth_type} is {depth}, 0 to 1 was expected")));
        }
        let depth = (depth > 0.0 && depth.is_finite()).then_some(f64::from(depth));
        let share = |axis: usize| (2.0 * f64::from(pixel[axis]) + 1.0) / f64::from(self.size[axis]) - 1.0;
        let at = self.eye_from_clip * DVec4::new(share(0), -share(1), 0.0, 1.0);
        let along = match self.sight {
            Sight::Perspective(pencil) => {
                self.perspective_ray(pencil, pencil.steps * DVec3::new(share(0), -share(1), 1.0), at.w, depth)?
            }
            Sight::Orthographic => self.orthographic_ray(at, depth)?,
        };
        let origin = self.world_from_eye.transform_point3(along.origin);
        let step = self.world_from_eye.transform_vector3(along.step);
        let length = step.length();
        let direction = step / length;
        if !(origin.is_finite() && direction.is_normalized()) {
            return Err(Error::invalid("the ray through it is not finite: matrices of moderate numbers were expected"));
        }
        let stretch = length / along.step.length();
        let stretch = if (stretch - 1.0).abs() < RIGID { 1.0 } else { stretch };
        // Clamp a distance that underflows 64 bits, so that it stays positive.
        let distance_m = (along.distance * stretch).max(f64::MIN_POSITIVE);
        Ok(PixelRay { origin, direction, distance_m })
    }

    /// `middle_w` is the w of the unprojected point at clip depth 0; `depth` is `None` if infinitely far.
    fn perspective_ray(&self, pencil: Pencil, step: DVec3, middle_w: f64, depth: Option<f64>) -> Result<EyeRay> {
        if self.depth_type == DepthType::EyeZ && step.z >= 0.0 {
            return Err(Error::invalid("EYE_Z is a distance along -z of eye space, but its ray goes along +z"));
        }
        let distance = match (depth, self.depth_type) {
            (None, _) => f64::INFINITY,
            (Some(depth), DepthType::WindowZ) => {
                let last = self.eye_from_clip.row(3);
                let clip_z = 2.0 * depth - 1.0;
                let terms = last.w.abs() + last.xyz().abs().element_sum();
                match middle_w + clip_z * last.z {
                    w if w > INFINITE_W * terms => pencil.unit / w * step.length(),
                    w if w >= -BEYOND_INFINITY * terms => f64::INFINITY,
                    _ => return Err(Error::invalid(format!("WINDOW_Z {depth} lies behind the camera"))),
                }
            }
            (Some(depth), DepthType::EyeZ) => match (depth + pencil.centre.z) / -step.z {
                steps if steps > 0.0 => steps * step.length(),
                _ => return Err(Error::invalid(format!("EYE_Z {depth} lies behind the camera"))),
            },
            (Some(depth), DepthType::RayDepth) => depth,
        };
        Ok(EyeRay { origin: pencil.centre, step, distance })
    }

    fn orthographic_ray(&self, at: DVec4, depth: Option<f64>) -> Result<EyeRay> {
        // Step from one clip depth to the next; both points have the same w.
        let step = self.eye_from_clip.z_axis.xyz() / at.w;
        let middle = at.xyz() / at.w;
        if self.depth_type == DepthType::WindowZ {
            let distance = depth.map_or(f64::INFINITY, |depth| 2.0 * depth * step.length());
            return Ok(EyeRay { origin: middle - step, step, distance });
        }
        if step.z == 0.0 {
            return Err(Error::invalid(format!("{} needs a ray along z of eye space", self.depth_type.name())));
        }
        let origin = middle - step * (middle.z / step.z);
        let step = if step.z > 0.0 { -step } else { step };
        let slant = if self.depth_type == DepthType::EyeZ { step.length() / step.z.abs() } else { 1.0 };
        Ok(EyeRay { origin, step, distance: depth.map_or(f64::INFINITY, |depth| depth * slant) })
    }

    /// Returns the camera of a perspective image whose rows and columns are orthogonal; the image may be mirrored. Near and far
    /// are those of [`Lens::new`].
    pub fn perspective(&self) -> Option<Camera> {
        let Sight::Perspective(Pencil { steps, .. }) = self.sight else { return None };
        let [across, upward, middle] =
            [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| self.world_from_eye.transform_vector3(step));
        let (right, down) = (across.try_normalize()?, (-upward).try_normalize()?);
        if right.dot(down).abs() > MAX_SKEW {
            return None;
        }
        let normal = right.cross(down).try_normalize()?;
        let forward = if normal.dot(middle) < 0.0 { -normal } else { normal };
        let planar = forward.dot(middle);
        let half = [across.length() / planar, upward.length() / planar];
        let lens = Lens { aspect: half[0] / half[1], ..Lens::new(2.0 * half[1].atan().to_degrees()) };
        let camera = Camera::with_axes(self.position(), [forward, right, down], lens).ok()?;
        camera.off_axis([right.dot(middle) / planar, down.dot(middle) / planar]).ok()
    }
}

/// A ray in eye space.
struct EyeRay {
    origin: DVec3,
    /// Direction of any length.
    step: DVec3,
    /// Distance from the origin to the surface.
    distance: f64,
}

fn row_major(numbers: &[f64; 16]) -> DMat4 {
    DMat4::from_cols_array(numbers).transpose()
}

/// Returns the largest power of two that is at most the largest entry; dividing by it is exact.
fn magnitude(entries: impl IntoIterator<Item = f64>) -> f64 {
    let largest = entries.into_iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits())
}

/// Returns a positive multiple of the inverse whose largest entry is 1 to 2; `None` for a singular matrix, as determined by the
/// determinant of the scaled matrix.
fn inverse(matrix: DMat4) -> Option<DMat4> {
    let reciprocal = |vector: DVec4| 1.0 / magnitude(vector.to_array());
    let of_rows = DVec4::from_array([0, 1, 2, 3].map(|row| reciprocal(matrix.row(row))));
    let rows = DMat4::from_diagonal(of_rows) * matrix;
    let of_columns = DVec4::from_array([0, 1, 2, 3].map(|column| reciprocal(rows.col(column))));
    if !(of_rows.is_finite() && of_columns.is_finite()) {
        return None;
    }
    let columns = DMat4::from_diagonal(of_columns);
    let scaled = rows * columns;
    if !scaled.is_finite() || scaled.determinant().abs() < MIN_DETERMINANT {
        return None;
    }
    // A common factor of all entries does not change the projection; remove it to avoid overflow.
    let of_rows = of_rows / of_rows.max_element();
    let of_columns = of_columns / of_columns.max_element();
    let inverse = DMat4::from_diagonal(of_columns) * scaled.inverse() * DMat4::from_diagonal(of_rows);
    Some(inverse * (1.0 / magnitude(inverse.to_cols_array()))).filter(|inverse| inverse.is_finite())
}

/// Determines the type of projection. `w_row` is the last row of `clip_from_eye`.
fn sight(w_row: DVec4, eye_from_clip: DMat4) -> Result<Sight> {
    if w_row.xyz().abs().max_element() <= ROUNDING * w_row.w.abs() {
        return Ok(Sight::Orthographic);
    }
    // The rays of all pixels meet at the point with clip x, y and w equal to 0.
    let meeting = eye_from_clip.z_axis;
    let centre = meeting.xyz() / meeting.w;
    if meeting.w.abs() <= INFINITE_W * meeting.xyz().length() || !centre.is_finite() {
        return Err(Error::invalid("clip_from_eye_matrix is neither a perspective nor an orthographic projection"));
    }
    let step = |axis: DVec4| axis.xyz() - axis.w * centre;
    let middle = step(eye_from_clip.w_axis);
    let unit = middle.abs().max_element();
    let [across, upward] = [eye_from_clip.x_axis, eye_from_clip.y_axis].map(|axis| step(axis) / unit);
    let steps = DMat3::from_cols(across, upward, middle / unit);
    if !steps.is_finite() {
        return Err(Error::invalid("clip_from_eye_matrix has no ray at the image's centre"));
    }
    Ok(Sight::Perspective(Pencil { centre, steps, unit }))
}

fn pose(matrix: DMat4) -> Result<DAffine3> {
    let last = matrix.row(3);
    if last.w == 0.0 || last.xyz().abs().max_element() > ROUNDING * last.w.abs() {
        return Err(Error::invalid("the last row of world_from_eye_matrix must be 0, 0, 0, w with w other than 0"));
    }
    let affine =
        DAffine3 { matrix3: DMat3::from_mat4(matrix) * (1.0 / last.w), translation: matrix.w_axis.xyz() / last.w };
    let unit = |axis: DVec3| axis.normalize_or_zero();
    let [x, y, z] = [affine.matrix3.x_axis, affine.matrix3.y_axis, affine.matrix3.z_axis].map(unit);
    if !affine.is_finite() || x.dot(y.cross(z)).abs() < MIN_DETERMINANT {
        return Err(Error::invalid("world_from_eye_matrix is singular or too large: a pose was expected"));
    }
    Ok(affine)
}

#[cfg(test)]
mod tests;
