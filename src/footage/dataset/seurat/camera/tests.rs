use super::*;
use codec::image::Face;

const SIZE: [u32; 2] = [5, 4];
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Edges of the image at distance 1, or of an orthographic image; near and far.
#[derive(Debug, Clone, Copy)]
struct Window {
    x: [f64; 2],
    y: [f64; 2],
    near: f64,
    far: f64,
}

impl Window {
    fn perspective(self) -> [f64; 16] {
        let Window { x: [l, r], y: [b, t], near, far } = self;
        let (c, d) = match far.is_finite() {
            true => (-(far + near) / (far - near), -2.0 * far * near / (far - near)),
            false => (-1.0, -2.0 * near),
        };
        let (w, h) = (r - l, t - b);
        [2.0 / w, 0.0, (r + l) / w, 0.0, 0.0, 2.0 / h, (t + b) / h, 0.0, 0.0, 0.0, c, d, 0.0, 0.0, -1.0, 0.0]
    }

    fn orthographic(self) -> [f64; 16] {
        let Window { x: [l, r], y: [b, t], near, far } = self;
        let (w, h, d) = (r - l, t - b, far - near);
        let (x, y, z) = (-(r + l) / w, -(t + b) / h, -(far + near) / d);
        [2.0 / w, 0.0, 0.0, x, 0.0, 2.0 / h, 0.0, y, 0.0, 0.0, -2.0 / d, z, 0.0, 0.0, 0.0, 1.0]
    }

    /// Returns the point where the ray of a pixel meets the window, in eye space without z.
    fn at(self, [col, row]: [u32; 2]) -> [f64; 2] {
        let share = |at: u32, size: u32| (f64::from(at) + 0.5) / f64::from(size);
        let [across, down] = [share(col, SIZE[0]), share(row, SIZE[1])];
        [self.x[0] + across * (self.x[1] - self.x[0]), self.y[1] - down * (self.y[1] - self.y[0])]
    }
}

/// Poses with a rotation and a translation: rigid, scaled by two, and mirrored.
fn poses() -> [[f64; 16]; 3] {
    let (s, c) = 0.7f64.sin_cos();
    let turned = [c, 0.0, s, 1.5, 0.0, 1.0, 0.0, -2.0, -s, 0.0, c, 40.0, 0.0, 0.0, 0.0, 1.0];
    let scaled = [2.0 * c, -2.0 * s, 0.0, 0.1, 2.0 * s, 2.0 * c, 0.0, 0.2, 0.0, 0.0, 2.0, 0.3, 0.0, 0.0, 0.0, 1.0];
    let mirrored = [-c, 0.0, -s, 1.5, 0.0, 1.0, 0.0, -2.0, -s, 0.0, c, 40.0, 0.0, 0.0, 0.0, 1.0];
    [turned, scaled, mirrored]
}

fn multiplied(matrix: [f64; 16], factor: f64) -> [f64; 16] {
    matrix.map(|entry| entry * factor)
}

fn camera(depth_type: DepthType, clip_from_eye: [f64; 16], world_from_eye: [f64; 16]) -> SeuratCamera {
    SeuratCamera::new(SIZE, depth_type, &CameraMatrices { clip_from_eye, world_from_eye }).unwrap()
}

/// Transforms a point by a matrix in row-major order and divides by w.
fn transformed(matrix: &[f64; 16], point: DVec3) -> DVec3 {
    let row = |row: usize| DVec3::from_slice(&matrix[4 * row..]).dot(point) + matrix[4 * row + 3];
    DVec3::new(row(0), row(1), row(2)) / row(3)
}

/// Maximum rounding error of a number of at most 1 as a 32-bit float.
const HALF_ULP_OF_ONE: f64 = 1.0 / (1u64 << 25) as f64;

/// Stores the depth of a point on the ray of each pixel and reads it back. `eye_point` returns the point of a pixel at a distance
/// from the eye plane, `metres_per_window` the derivative of that distance with respect to window depth.
fn round_trips(
    clip_from_eye: [f64; 16],
    eye_point: impl Fn([u32; 2], f64) -> DVec3,
    metres_per_window: impl Fn(f64) -> f64,
    orthographic_near: Option<f64>,
) {
    for world_from_eye in poses() {
        let scale = DVec3::new(world_from_eye[0], world_from_eye[4], world_from_eye[8]).length();
        for factor in [1.0, 2.0] {
            for depth_type in DepthType::ALL {
                let camera = camera(depth_type, multiplied(clip_from_eye, factor), multiplied(world_from_eye, factor));
                for (pixel, planar) in [([0, 0], 0.5), ([4, 3], 3.0), ([2, 1], 17.0), ([1, 3], 60.0)] {
                    let eye = eye_point(pixel, planar);
                    // Distance of the first point of the ray from the eye plane, and length of the ray per metre of distance from
                    // that plane.
                    let start = match (orthographic_near, depth_type) {
                        (None, _) => DVec3::ZERO,
                        (Some(near), DepthType::WindowZ) => eye_point(pixel, near),
                        (Some(_), _) => eye_point(pixel, 0.0),
                    };
                    let from_plane = match orthographic_near {
                        None => eye.length(),
                        Some(_) => eye.distance(eye_point(pixel, 0.0)),
                    };
                    let slant = from_plane / planar;
                    let (stored, bound) = match depth_type {
                        DepthType::WindowZ => {
                            let window = 0.5 + 0.5 * transformed(&clip_from_eye, eye).z;
                            (window, metres_per_window(planar) * HALF_ULP_OF_ONE * slant)
                        }
                        DepthType::EyeZ => (planar, planar * 2.0 * HALF_ULP_OF_ONE * slant),
                        DepthType::RayDepth => (from_plane, from_plane * 2.0 * HALF_ULP_OF_ONE),
                    };
                    let ray = camera.ray(pixel, stored as f32).unwrap();
                    let (expected, origin) = (transformed(&world_from_eye, eye), transformed(&world_from_eye, start));
                    let found = ray.origin + ray.direction * ray.distance_m;
                    let bound = 1.01 * scale * bound + 1e-9 * expected.length();
                    let error = found.distance(expected);
                    assert!(error <= bound, "{depth_type:?} {pixel:?} {planar}: {found} {expected}: {error} > {bound}");
                    assert!(ray.origin.distance(origin) < 1e-9, "{depth_type:?} {pixel:?}: {} {origin}", ray.origin);
                    assert!((ray.direction.length() - 1.0).abs() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn perspective_depths_come_back() {
    let centred = Window { x: [-1.0, 1.0], y: [-0.75, 0.75], near: 0.1, far: 100.0 };
    let off_axis = Window { x: [0.2, 1.4], y: [-1.5, -0.25], ..centred };
    let mirrored = Window { x: [1.0, -1.0], ..centred };
    for window in [centred, off_axis, mirrored] {
        for far in [100.0, f64::INFINITY] {
            let window = Window { far, ..window };
            let eye_point = |pixel, planar: f64| {
                let [x, y] = window.at(pixel);
                DVec3::new(x, y, -1.0) * planar
            };
            let metres_per_window = |planar: f64| planar * planar * (1.0 / window.near - 1.0 / far);
            round_trips(window.perspective(), eye_point, metres_per_window, None);
        }
    }
}

#[test]
fn orthographic_depths_come_back() {
    for (near, far) in [(0.1, 100.0), (-80.0, 80.0)] {
        let window = Window { x: [-2.0, 3.0], y: [-1.0, 1.0], near, far };
        let eye_point = |pixel, planar: f64| {
            let [x, y] = window.at(pixel);
            DVec3::new(x, y, -planar)
        };
        round_trips(window.orthographic(), eye_point, |_| far - near, Some(near));
    }
}

#[test]
fn a_slanted_orthographic_image_is_measured_along_its_rays() {
    // Rays have the direction (0.5, 0, -1): image x is eye-space x plus half of eye-space z.
    let mut matrix = Window { x: [-2.0, 3.0], y: [-1.0, 1.0], near: 0.0, far: 10.0 }.orthographic();
    matrix[2] = 0.5 * matrix[0];
    for (depth_type, depth) in [(DepthType::WindowZ, 0.2), (DepthType::EyeZ, 2.0), (DepthType::RayDepth, 5f32.sqrt())] {
        let ray = camera(depth_type, matrix, IDENTITY).ray([0, 0], depth).unwrap();
        let expected = DVec3::new(-1.5, 0.75, 0.0);
        assert!(ray.origin.distance(expected) < 1e-12, "{depth_type:?} {ray:?}");
        assert!((ray.distance_m - 5f64.sqrt()).abs() < 1e-6, "{depth_type:?} {ray:?}");
        assert!(ray.direction.distance(DVec3::new(1.0, 0.0, -2.0).normalize()) < 1e-12, "{depth_type:?} {ray:?}");
    }
}

#[test]
fn depths_without_a_point() {
    let window = Window { x: [-1.0, 1.0], y: [-1.0, 1.0], near: 0.1, far: f64::INFINITY };
    let orthographic = Window { far: 10.0, ..window }.orthographic();
    for depth_type in DepthType::ALL {
        for matrix in [window.perspective(), orthographic] {
            let camera = camera(depth_type, matrix, poses()[0]);
            let known = camera.ray([1, 2], 0.25).unwrap();
            for depth in [0.0, -0.0, f32::INFINITY] {
                let ray = camera.ray([1, 2], depth).unwrap();
                assert_eq!(ray, PixelRay { distance_m: f64::INFINITY, ..known });
            }
            for (depth, says) in [(f32::NAN, "not a number"), (-1.0, "-1"), (f32::NEG_INFINITY, "-inf")] {
                let error = camera.ray([1, 2], depth).unwrap_err().to_string();
                assert!(error.contains(says) && error.contains(depth_type.name()), "{error}");
            }
            let least = camera.ray([1, 2], f32::from_bits(1)).unwrap().distance_m;
            assert!(least > 0.0 && least < known.distance_m, "{depth_type:?} {least}");
            let beyond = camera.ray([1, 2], 1.0 + f32::EPSILON);
            assert_eq!(beyond.is_err(), depth_type == DepthType::WindowZ);
        }
    }
}

#[test]
fn the_far_plane_may_be_at_infinity_or_a_rounding_beyond() {
    let far = |matrix| camera(DepthType::WindowZ, matrix, IDENTITY).ray([0, 0], 1.0).unwrap().distance_m;
    let window = Window { x: [-1.0, 1.0], y: [-1.0, 1.0], near: 0.1, far: f64::INFINITY };
    assert_eq!(far(window.perspective()), f64::INFINITY);
    assert_eq!(far(multiplied(window.perspective(), 1.0 / 3.0)), f64::INFINITY);
    let mut rounded = window.perspective();
    rounded[10] = -f64::from(1.0f32.next_down());
    assert_eq!(far(rounded), f64::INFINITY);
    rounded[10] = -f64::from(1.0f32.next_up());
    assert!(far(rounded) > 1e6 && far(rounded).is_finite());
    rounded[10] = -0.9;
    let error = camera(DepthType::WindowZ, rounded, IDENTITY).ray([0, 0], 1.0).unwrap_err().to_string();
    assert!(error.contains("behind the camera"), "{error}");
}

#[test]
fn cameras_that_are_none_are_refused() {
    let window = Window { x: [-1.0, 1.0], y: [-1.0, 1.0], near: 0.1, far: 10.0 };
    let refused = |clip_from_eye, world_from_eye| {
        let matrices = CameraMatrices { clip_from_eye, world_from_eye };
        SeuratCamera::new(SIZE, DepthType::EyeZ, &matrices).unwrap_err().to_string()
    };
    let changed = |matrix: [f64; 16], entries: &[(usize, f64)]| {
        entries.iter().fold(matrix, |mut matrix, &(at, value)| {
            matrix[at] = value;
            matrix
        })
    };
    let perspective = window.perspective();
    let counting: [f64; 16] = std::array::from_fn(|at| at as f64);
    let flat = changed(perspective, &[(11, 0.0)]);
    for matrix in [[0.0; 16], counting, flat, [1e308; 16], changed(IDENTITY, &[(15, 0.0)])] {
        assert!(refused(matrix, IDENTITY).contains("clip_from_eye_matrix is singular"), "{matrix:?}");
    }
    for matrix in [changed(IDENTITY, &[(10, 0.0)]), changed(IDENTITY, &[(4, 1.0), (5, 0.0)])] {
        assert!(refused(perspective, matrix).contains("world_from_eye_matrix is singular"), "{matrix:?}");
    }
    for matrix in [[0.0; 16], changed(IDENTITY, &[(15, 0.0)]), changed(IDENTITY, &[(14, 0.5)])] {
        assert!(refused(perspective, matrix).contains("last row of world_from_eye_matrix"), "{matrix:?}");
    }
    // Clip w is x: rays neither meet in a point nor are parallel.
    let neither = changed(IDENTITY, &[(12, 1.0), (15, 2.0)]);
    assert!(refused(neither, IDENTITY).contains("neither"), "{}", refused(neither, IDENTITY));
}

#[test]
fn extreme_but_regular_matrices_are_cameras() {
    let window = Window { x: [-1.0, 1.0], y: [-1.0, 1.0], near: 1e-6, far: 1e6 };
    let mut distant = IDENTITY;
    (distant[3], distant[7]) = (1e7, -1e7);
    let ray = camera(DepthType::RayDepth, window.perspective(), distant).ray([0, 0], 3.0).unwrap();
    assert!((ray.distance_m - 3.0).abs() < 1e-12);
    let small = multiplied(window.perspective(), 1e-200);
    let ray = camera(DepthType::EyeZ, small, distant).ray([0, 0], 3.0).unwrap();
    assert!((ray.distance_m - 3.0 * DVec3::new(0.8, 0.75, 1.0).length()).abs() < 1e-12);
    let mut large = IDENTITY;
    large[0] = 1e300;
    let matrices = CameraMatrices { clip_from_eye: window.perspective(), world_from_eye: large };
    let error = SeuratCamera::new(SIZE, DepthType::RayDepth, &matrices).unwrap_err().to_string();
    assert!(error.contains("too large"), "{error}");
}

#[test]
fn eye_z_is_not_measured_behind_the_camera() {
    let mut backward = Window { x: [-1.0, 1.0], y: [-1.0, 1.0], near: 0.1, far: 10.0 }.perspective();
    // Clip w is +z.
    (backward[10], backward[14]) = (-backward[10], 1.0);
    let ray = camera(DepthType::RayDepth, backward, IDENTITY).ray([2, 1], 3.0).unwrap();
    assert!(ray.direction.z > 0.9, "{ray:?}");
    let error = camera(DepthType::EyeZ, backward, IDENTITY).ray([2, 1], 3.0).unwrap_err().to_string();
    assert!(error.contains("goes along +z"), "{error}");
}

#[test]
fn plain_perspective_cameras_have_the_same_rays() {
    let window = Window { x: [0.2, 1.4], y: [-1.5, -0.25], near: 0.1, far: 100.0 };
    for world_from_eye in poses() {
        let camera = camera(DepthType::RayDepth, multiplied(window.perspective(), 2.0), world_from_eye);
        let plain = camera.perspective().unwrap();
        assert!(plain.eye().distance(camera.position()) < 1e-12);
        for pixel in [[0, 0], [4, 0], [2, 3]] {
            let share = [0, 1].map(|axis| (f64::from(pixel[axis]) + 0.5) / f64::from(SIZE[axis]));
            let ray = camera.ray(pixel, 1.0).unwrap();
            assert!(plain.direction(share).distance(ray.direction) < 1e-12, "{pixel:?}");
        }
    }
    assert!(camera(DepthType::EyeZ, window.orthographic(), IDENTITY).perspective().is_none());
    let mut skewed = window.perspective();
    skewed[1] = 0.1;
    assert!(camera(DepthType::EyeZ, skewed, IDENTITY).perspective().is_none());
}

#[test]
fn cube_faces_have_the_rays_of_the_image_model_to_the_bit() {
    let side = 7;
    for (near, far) in [(0.1, 100.0), (0.03, f64::INFINITY), (1e-3, 5e4)] {
        let clip_from_eye = Window { x: [-1.0, 1.0], y: [-1.0, 1.0], near, far }.perspective();
        for face in Face::CUBE {
            let [forward, right, down] = face.axes();
            let mut world_from_eye = IDENTITY;
            for (column, axis) in [right, -down, -forward, DVec3::new(1.3, -0.7, 4.1)].into_iter().enumerate() {
                (0..3).for_each(|row| world_from_eye[4 * row + column] = axis[row]);
            }
            let matrices = CameraMatrices { clip_from_eye, world_from_eye };
            let camera = SeuratCamera::new([side; 2], DepthType::RayDepth, &matrices).unwrap();
            for (col, row) in (0..side).flat_map(|row| (0..side).map(move |col| (col, row))) {
                let ray = camera.ray([col, row], 3.7).unwrap();
                let step = face.direction(col, row, side);
                let expected = PixelRay {
                    origin: DVec3::new(1.3, -0.7, 4.1),
                    direction: step / step.length(),
                    distance_m: f64::from(3.7f32),
                };
                assert_eq!(ray, expected, "{face:?} {col} {row}");
            }
        }
    }
}

#[test]
fn the_released_test_manifest_has_a_camera() {
    // The identity as an orthographic projection, and a pose that is 2 times the identity matrix.
    let camera = camera(DepthType::EyeZ, IDENTITY, multiplied(IDENTITY, 2.0));
    assert!(camera.is_orthographic() && camera.position() == DVec3::ZERO);
    let ray = camera.ray([0, 0], 1.0).unwrap();
    assert_eq!(ray, PixelRay { origin: DVec3::new(-0.8, 0.75, 0.0), direction: DVec3::NEG_Z, distance_m: 1.0 });
}
