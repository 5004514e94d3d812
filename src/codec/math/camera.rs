//! A camera in the world: right-handed, +Y up, metres. Perspective, or an equirectangular panorama of longitude and latitude.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};

use super::frustum::{Frustum, Window};
use crate::error::{Error, Result};

/// Tolerance of the length of a quaternion and of orthonormal axes.
const UNIT_TOLERANCE: f64 = 1e-3;
/// Minimum sine of the angle between the viewing direction and up.
const MIN_UP_SINE: f64 = 1e-9;

/// Field of view and clip planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Vertical field of view in degrees, above 0 and below 180.
    pub fov_y_deg: f64,
    /// Image width over image height, above 0.
    pub aspect: f64,
    /// Near plane of surfaces, in metres along the viewing axis: at least 0.
    pub near_m: f64,
    /// Far plane of surfaces, in metres along the viewing axis: above `near_m`, may be `+inf`. It does not clip the
    /// background.
    pub far_m: f64,
}

impl Lens {
    pub fn new(fov_y_deg: f64) -> Lens {
        Lens { fov_y_deg, aspect: 1.0, near_m: 0.0, far_m: f64::INFINITY }
    }
}

/// An equirectangular image. With an offset, the eye moves on a circle with the longitude and stays beside the viewing
/// direction: one eye of omnidirectional stereo.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Panorama {
    /// Longitudes of the left and the right edge in radians: 0 is forward, positive is to the right. All latitudes are
    /// covered.
    longitudes: [f64; 2],
    /// Metres from the axis to the eye, to the right of the viewing direction.
    offset_m: f64,
    /// True if latitude runs along the rows of the image, from up to down, and longitude along its columns.
    is_transposed: bool,
}

/// A camera with valid parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: DVec3,
    /// Forward, right and down: orthogonal, of length 1.
    axes: [DVec3; 3],
    /// Half the width and half the height of the image at distance 1.
    half: [f64; 2],
    /// Centre of the image at distance 1, to the right and down: 0 unless the window is off-axis.
    middle: [f64; 2],
    depth_m: [f64; 2],
    panorama: Option<Panorama>,
}

impl Camera {
    /// Returns a camera at `eye` that looks at `target`, with `up` above its horizon.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, lens: Lens) -> Result<Camera> {
        for (what, point) in [("eye", eye), ("look-at point", target), ("up direction", up)] {
            check_finite(what, point)?;
        }
        let forward = (target - eye).try_normalize().ok_or_else(|| {
            let (eye, target) = (eye.to_array(), target.to_array());
            Error::Usage(format!(
                "the camera at {eye:?} looks at {target:?}, which is the same point or too far away: move one of them"
            ))
        })?;
        let up_unit = up.try_normalize().unwrap_or(DVec3::ZERO);
        let right = forward.cross(up_unit);
        if right.length() < MIN_UP_SINE {
            return Err(Error::Usage(format!(
                "the camera looks along {forward}, and its up direction {up} is zero or parallel to that: use another \
                up direction"
            )));
        }
        let right = right.normalize();
        Self::new(eye, [forward, right, forward.cross(right)], lens)
    }

    /// Returns a camera at `eye`: the camera that looks along −Z with +Y up, rotated by the quaternion x, y, z, w.
    pub fn oriented(eye: DVec3, orientation: [f64; 4], lens: Lens) -> Result<Camera> {
        check_finite("eye", eye)?;
        let turn = rotation(orientation).ok_or_else(|| {
            Error::Usage(format!("a camera's orientation must be a quaternion of length 1, not {orientation:?}"))
        })?;
        Self::new(eye, [DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y].map(|axis| turn * axis), lens)
    }

    /// Returns a camera with the axes forward, right and down. With mirrored axes, such as those of cube faces, it has no
    /// [`Camera::orientation`].
    pub fn with_axes(eye: DVec3, axes: [DVec3; 3], lens: Lens) -> Result<Camera> {
        check_finite("eye", eye)?;
        let turn = DMat3::from_cols(axes[0], axes[1], axes[2]);
        let deviation = (turn * turn.transpose() - DMat3::IDENTITY).to_cols_array();
        if !deviation.iter().all(|part| part.abs() <= UNIT_TOLERANCE) {
            return Err(Error::Usage(format!(
                "a camera's axes must have length 1 and be at right angles to each other, not {axes:?}"
            )));
        }
        Self::new(eye, axes, lens)
    }

    /// Returns a pinhole camera from axes as of [`Self::with_axes`], width and height of the image, and fx, fy, cx, cy, all
    /// in pixels.
    pub fn pinhole(eye: DVec3, axes: [DVec3; 3], size: [f64; 2], [fx, fy, cx, cy]: [f64; 4]) -> Result<Camera> {
        let [width, height] = size;
        let half = [width / 2.0 / fx, height / 2.0 / fy];
        let middle = [(width / 2.0 - cx) / fx, (height / 2.0 - cy) / fy];
        Camera::with_window(eye, axes, half, middle)
    }

    /// Returns a camera from axes as of [`Self::with_axes`], half the width and half the height of its image at distance 1,
    /// and the centre of the image at distance 1, to the right and down.
    pub fn with_window(eye: DVec3, axes: [DVec3; 3], half: [f64; 2], middle: [f64; 2]) -> Result<Camera> {
        let lens = Lens { aspect: half[0] / half[1], ..Lens::new(2.0 * half[1].atan().to_degrees()) };
        // `half` is set directly, without the rounding error of the angle.
        Camera { half, ..Camera::with_axes(eye, axes, lens)? }.off_axis(middle)
    }

    /// Returns fx, fy, cx, cy in pixels, for an image of this width and height.
    pub fn intrinsics(&self, [width, height]: [f64; 2]) -> [f64; 4] {
        let [fx, fy] = [width / 2.0 / self.half[0], height / 2.0 / self.half[1]];
        [fx, fy, width / 2.0 - self.middle[0] * fx, height / 2.0 - self.middle[1] * fy]
    }

    /// Field of view, aspect and clip planes. An off-axis window is not included.
    pub fn lens(&self) -> Lens {
        let [near_m, far_m] = self.depth_m;
        let fov_y_deg = 2.0 * self.half[1].atan().to_degrees();
        Lens { fov_y_deg, aspect: self.half[0] / self.half[1], near_m, far_m }
    }

    /// Centre of the image at distance 1, to the right and down.
    pub fn middle(&self) -> [f64; 2] {
        self.middle
    }

    fn new(eye: DVec3, axes: [DVec3; 3], lens: Lens) -> Result<Camera> {
        let Lens { fov_y_deg, aspect, near_m, far_m } = lens;
        if !(fov_y_deg > 0.0 && fov_y_deg < 180.0) {
            return Err(Error::Usage(format!("a field of view of {fov_y_deg} degrees must lie between 0 and 180")));
        }
        let tangent = (fov_y_deg.to_radians() / 2.0).tan();
        let half = [tangent * aspect, tangent];
        if !(aspect > 0.0 && half.iter().all(|half| half.is_finite() && *half > 0.0)) {
            return Err(Error::Usage(format!("aspect ratio {aspect}: a number above 0 was expected")));
        }
        if !(near_m >= 0.0 && near_m < far_m) {
            return Err(Error::Usage(format!("camera range of {near_m} m to {far_m} m: 0 <= near < far was expected")));
        }
        Ok(Camera { eye, axes, half, middle: [0.0; 2], depth_m: [near_m, far_m], panorama: None })
    }

    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    pub fn axes(&self) -> [DVec3; 3] {
        self.axes
    }

    pub fn half(&self) -> [f64; 2] {
        self.half
    }

    /// Rectangle of the image at distance 1, u to the right and v down.
    pub fn window(&self) -> Window {
        let edges = |axis: usize| [self.middle[axis] - self.half[axis], self.middle[axis] + self.half[axis]];
        Window { u: edges(0), v: edges(1) }
    }

    /// Returns the camera with an off-axis window: `middle` is the centre of the image at distance 1, to the right and down.
    pub fn off_axis(self, middle: [f64; 2]) -> Result<Camera> {
        match middle.iter().all(|at| at.is_finite()) {
            true => Ok(Camera { middle, ..self }),
            false => Err(Error::Usage(format!("the image centre of a camera must be finite, not {middle:?}"))),
        }
    }

    /// Quaternion for [`Camera::oriented`]; `None` for the identity.
    pub fn orientation(&self) -> Option<[f64; 4]> {
        let [forward, right, down] = self.axes;
        let turn = DQuat::from_mat3(&DMat3::from_cols(right, -down, -forward)).normalize();
        (turn != DQuat::IDENTITY).then(|| turn.to_array())
    }

    /// Returns the panorama of `longitudes_deg` degrees of longitude, above 0 and up to 360, around the viewing direction,
    /// and of all latitudes. The eye is `offset_m` metres to the right of each direction.
    #[must_use]
    pub fn as_panorama(self, longitudes_deg: f64, offset_m: f64) -> Camera {
        let half = longitudes_deg.to_radians() / 2.0;
        Camera { panorama: Some(Panorama { longitudes: [-half, half], offset_m, is_transposed: false }), ..self }
    }

    pub fn is_panorama(&self) -> bool {
        self.panorama.is_some()
    }

    /// True if the columns of the image have different eyes.
    pub fn has_moving_eye(&self) -> bool {
        self.panorama.is_some_and(|panorama| panorama.offset_m != 0.0)
    }

    /// Returns column `at` of the `of` columns of a panorama, seen from the eye of its centre. The column's image is a row:
    /// up to down becomes left to right. Other cameras are returned unchanged.
    #[must_use]
    pub fn column(&self, at: u32, of: u32) -> Camera {
        let Some(Panorama { longitudes: [left, right], offset_m, .. }) = self.panorama else { return *self };
        let edge = |at: f64| left + (right - left) * at / f64::from(of);
        let (sine, cosine) = edge(f64::from(at) + 0.5).sin_cos();
        let beside = cosine * self.axes[1] - sine * self.axes[0];
        let longitudes = [f64::from(at), f64::from(at) + 1.0].map(edge);
        let panorama = Some(Panorama { longitudes, offset_m: 0.0, is_transposed: true });
        Camera { eye: self.eye + offset_m * beside, panorama, ..*self }
    }

    /// Returns six cameras of 90 degrees with the same eye: right, left, up, down, front and back. The lower edge of up and
    /// the upper edge of down meet front.
    pub fn cube(&self) -> [Camera; 6] {
        let [forward, right, down] = self.axes;
        let sides = [
            [right, -forward, down],
            [-right, forward, down],
            [-down, right, forward],
            [down, right, -forward],
            [forward, right, down],
            [-forward, -right, down],
        ];
        sides.map(|axes| Camera { axes, half: [1.0; 2], middle: [0.0; 2], panorama: None, ..*self })
    }

    /// Direction, of length 1, of a position in the image: 0 to 1 from left to right, and from top to bottom.
    pub fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [forward, right, down] = self.axes;
        if let Some(Panorama { longitudes: [first, last], is_transposed, .. }) = self.panorama {
            let [x, y] = if is_transposed { [y, x] } else { [x, y] };
            let (sine, cosine) = (first + (last - first) * x).sin_cos();
            let (up, level) = ((0.5 - y) * PI).sin_cos();
            return level * (cosine * forward + sine * right) - up * down;
        }
        let at = |axis: usize, share: f64| self.middle[axis] + (2.0 * share - 1.0) * self.half[axis];
        (forward + at(0, x) * right + at(1, y) * down).normalize()
    }

    /// Projects a point relative to the eye. Returns its position in the image, 0 to 1 as for [`Self::direction`], and its
    /// planar depth; `None` behind the eye. For perspective cameras only.
    pub fn project(&self, from_eye: DVec3) -> Option<([f64; 2], f64)> {
        let [deep, right, down] = self.axes.map(|axis| from_eye.dot(axis));
        let plane = [right / deep, down / deep];
        let at = [0, 1].map(|axis| 0.5 + 0.5 * (plane[axis] - self.middle[axis]) / self.half[axis]);
        (deep > 0.0 && at.iter().all(|at| at.is_finite())).then_some((at, deep))
    }

    /// Frustum without near and far planes.
    pub fn sight_lines(&self) -> Frustum {
        Camera { depth_m: [0.0, f64::INFINITY], ..*self }.frustum()
    }

    /// Near and far planes, in metres along the viewing axis.
    pub fn depth_m(&self) -> [f64; 2] {
        self.depth_m
    }

    /// True if the near or the far plane clips anything.
    pub fn has_range(&self) -> bool {
        self.depth_m != [0.0, f64::INFINITY]
    }

    /// Image width over image height. A panorama has the aspect of pixels with the same number of degrees both ways.
    pub fn aspect(&self) -> f64 {
        match self.panorama {
            Some(Panorama { longitudes: [left, right], .. }) => (right - left) / PI,
            None => self.half[0] / self.half[1],
        }
    }

    /// Returns the camera with an image of another width; `aspect`, above 0, is width over height.
    #[must_use]
    pub fn with_aspect(self, aspect: f64) -> Camera {
        let half = [self.half[1] * aspect, self.half[1]];
        Camera { half, middle: [self.middle[0] * half[0] / self.half[0], self.middle[1]], ..self }
    }

    /// Returns the camera moved to its right; to its left if `metres` is negative.
    #[must_use]
    pub fn moved_right(self, metres: f64) -> Camera {
        self.moved(self.axes[1] * metres)
    }

    #[must_use]
    pub fn moved(self, by_m: DVec3) -> Camera {
        Camera { eye: self.eye + by_m, ..self }
    }

    /// Returns the camera turned by 90° around its viewing axis: its right axis is the former down axis.
    #[must_use]
    pub fn turned(self) -> Camera {
        let [forward, right, down] = self.axes;
        let ([half_u, half_v], [u, v]) = (self.half, self.middle);
        Camera { axes: [forward, down, -right], half: [half_v, half_u], middle: [v, -u], ..self }
    }

    /// Returns the camera whose images are mirrored, left to right.
    #[must_use]
    pub fn mirrored(self) -> Camera {
        let [forward, right, down] = self.axes;
        Camera { axes: [forward, -right, down], middle: [-self.middle[0], self.middle[1]], ..self }
    }

    /// Frustum of the image. That of a panorama is unsound: all tests report that it is intersected.
    pub fn frustum(&self) -> Frustum {
        let depth_m = if self.is_panorama() { [f64::NAN; 2] } else { self.depth_m };
        Frustum::new(self.eye, self.axes, self.window(), depth_m)
    }
}

/// Returns the rotation of a quaternion x, y, z, w; `None` unless its length is 1 within `UNIT_TOLERANCE`.
pub fn rotation(orientation: [f64; 4]) -> Option<DQuat> {
    let quaternion = DQuat::from_array(orientation);
    ((quaternion.length() - 1.0).abs() <= UNIT_TOLERANCE).then(|| quaternion.normalize())
}

fn check_finite(what: &str, value: DVec3) -> Result<()> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(Error::Usage(format!("the camera's {what} must be finite, not {value}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_those_of_a_picture() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::new(0.0, 0.0, -5.0), DVec3::Y, Lens::new(60.0)).unwrap();
        assert_eq!(camera.axes(), [DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y]);
        let same = Camera::oriented(DVec3::ZERO, [0.0, 0.0, 0.0, 1.0], Lens::new(60.0)).unwrap();
        assert_eq!(same, camera);
        // A quarter turn to the left about +Y looks along −X.
        let half = 0.5f64.sqrt();
        let turned = Camera::oriented(DVec3::X, [0.0, half, 0.0, half], Lens::new(60.0)).unwrap();
        let looking = Camera::look_at(DVec3::X, DVec3::new(-3.0, 0.0, 0.0), DVec3::Y, Lens::new(60.0)).unwrap();
        for (a, b) in turned.axes().into_iter().zip(looking.axes()) {
            assert!((a - b).length() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn axes_may_be_mirrored_but_not_skewed() {
        let mirrored = [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y];
        let camera = Camera::with_axes(DVec3::Y, mirrored, Lens::new(90.0)).unwrap();
        assert!((camera.direction([1.0, 0.5]) - DVec3::new(1.0, 0.0, -1.0).normalize()).length() < 1e-12);
        assert!((camera.direction([0.5, 1.0]) - DVec3::new(1.0, -1.0, 0.0).normalize()).length() < 1e-12);
        for axes in [[DVec3::X, DVec3::X, DVec3::Y], [DVec3::X * 2.0, DVec3::Y, DVec3::Z], [DVec3::NAN; 3]] {
            assert!(
                Camera::with_axes(DVec3::Y, axes, Lens::new(90.0)).unwrap_err().to_string().contains("right angles")
            );
        }
    }

    #[test]
    fn an_off_axis_window_is_a_part_of_a_wider_image() {
        let wide = Camera::oriented(DVec3::ONE, [0.0, 0.0, 0.0, 1.0], Lens::new(90.0)).unwrap();
        let narrow = Lens::new(2.0 * 0.25f64.atan().to_degrees());
        let centred = Camera::oriented(DVec3::ONE, [0.0, 0.0, 0.0, 1.0], narrow).unwrap();
        assert_eq!(centred.off_axis([0.0; 2]).unwrap(), centred);
        // A quarter of the width, around (0.7, 0.4) of the wide image.
        let part = centred.off_axis([0.4, -0.2]).unwrap();
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.3, 0.8)] {
            let in_wide = [0.7 + 0.25 * (x - 0.5), 0.4 + 0.25 * (y - 0.5)];
            let direction = part.direction([x, y]);
            assert!((direction - wide.direction(in_wide)).length() < 1e-12);
            let ([found_x, found_y], deep) = part.project(direction * 3.0).unwrap();
            assert!((found_x - x).abs() < 1e-12 && (found_y - y).abs() < 1e-12 && deep > 0.0);
            assert!(part.frustum().contains_direction(part.direction([0.98 * x + 0.01, 0.98 * y + 0.01])));
        }
        assert!(!part.frustum().contains_direction(part.direction([1.01, 0.5])));
        assert!(centred.off_axis([f64::NAN, 0.0]).is_err());
    }

    #[test]
    fn cameras_that_see_nothing_are_refused() {
        let (eye, target) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, 4.0));
        let lens = Lens::new(90.0);
        let look = |eye, target, up, lens| Camera::look_at(eye, target, up, lens).map_err(|error| error.to_string());
        assert!(look(eye, target, DVec3::Y, lens).is_ok());
        assert!(look(eye, eye, DVec3::Y, lens).unwrap_err().contains("same point or too far"));
        assert!(look(eye, target, DVec3::Z * 7.0, lens).unwrap_err().contains("use another up"));
        assert!(look(eye, target, DVec3::ZERO, lens).unwrap_err().contains("use another up"));
        assert!(look(DVec3::NAN, target, DVec3::Y, lens).unwrap_err().contains("eye must be finite"));
        assert!(look(eye, DVec3::INFINITY, DVec3::Y, lens).unwrap_err().contains("look-at point must be finite"));
        for fov_y_deg in [0.0, -1.0, 180.0, 400.0, f64::NAN, f64::INFINITY] {
            let said = look(eye, target, DVec3::Y, Lens { fov_y_deg, ..lens }).unwrap_err();
            assert!(said.contains("between 0 and 180"), "{said}");
        }
        for aspect in [0.0, -2.0, f64::NAN, f64::INFINITY] {
            assert!(look(eye, target, DVec3::Y, Lens { aspect, ..lens }).unwrap_err().contains("aspect ratio"));
        }
        for (near_m, far_m) in [(-1.0, 5.0), (2.0, 2.0), (3.0, 1.0), (f64::NAN, 1.0), (0.0, f64::NAN)] {
            assert!(look(eye, target, DVec3::Y, Lens { near_m, far_m, ..lens }).unwrap_err().contains("near < far"));
        }
        for orientation in [[0.0; 4], [1.0; 4], [f64::NAN, 0.0, 0.0, 1.0]] {
            let said = Camera::oriented(eye, orientation, lens).unwrap_err().to_string();
            assert!(said.contains("quaternion of length 1"), "{said}");
        }
    }

    #[test]
    fn panoramas_see_longitude_and_latitude() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let camera = Camera::oriented(eye, [0.0, 0.0, 0.0, 1.0], Lens::new(60.0)).unwrap();
        let all = camera.as_panorama(360.0, 0.0);
        assert_eq!((all.aspect(), camera.as_panorama(180.0, 0.03).aspect()), (2.0, 1.0));
        assert!(all.is_panorama() && !all.has_moving_eye() && !camera.is_panorama());
        for (column, row) in [(0, 0), (31, 7), (63, 31), (40, 16)] {
            let at = [(f64::from(column) + 0.5) / 64.0, (f64::from(row) + 0.5) / 32.0];
            let (lon, lat) = ((2.0 * at[0] - 1.0) * PI, (0.5 - at[1]) * PI);
            let expected = DVec3::new(lon.sin() * lat.cos(), lat.sin(), -lon.cos() * lat.cos());
            assert!((all.direction(at) - expected).length() < 1e-12);
            // The eye is beside the direction, orthogonal to the direction and to the axis.
            let strip = camera.as_panorama(360.0, 0.03).column(column, 64);
            assert!((strip.direction([at[1], 0.5]) - expected).length() < 1e-12);
            let beside = (strip.eye() - eye) / 0.03;
            assert!((beside.length() - 1.0).abs() < 1e-9 && beside.y == 0.0 && beside.dot(expected).abs() < 1e-9);
            assert!(expected.cross(DVec3::Y).dot(beside) > 0.0, "to the right");
        }
        // Its unsound frustum intersects everything.
        assert!(!all.frustum().is_sound());
    }

    #[test]
    fn six_cameras_see_all_around() {
        let lens = Lens::new(50.0);
        let camera = Camera::look_at(DVec3::ONE, DVec3::new(3.0, 2.0, -1.0), DVec3::Y, lens).unwrap();
        let [forward, right, down] = camera.axes();
        let cube = camera.cube();
        for (face, axis) in cube.iter().zip([right, -right, -down, down, forward, -forward]) {
            assert!((face.direction([0.5; 2]) - axis).length() < 1e-12);
        }
        let meets = |a: usize, at: [f64; 2], b: usize, there: [f64; 2]| {
            let apart = cube[a].direction(at) - cube[b].direction(there);
            assert!(apart.length() < 1e-12, "{a} {b}: {apart}");
        };
        for share in [0.0, 0.3, 1.0] {
            meets(4, [1.0, share], 0, [0.0, share]);
            meets(4, [0.0, share], 1, [1.0, share]);
            meets(4, [share, 0.0], 2, [share, 1.0]);
            meets(4, [share, 1.0], 3, [share, 0.0]);
            meets(5, [0.0, share], 0, [1.0, share]);
        }
        assert!(cube.iter().all(|face| face.orientation().is_some() && face.eye() == DVec3::ONE));
    }
}
