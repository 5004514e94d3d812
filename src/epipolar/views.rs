//! Output views: cameras side by side on a line (Epipolar 3.1).

use glam::DVec3;

use codec::error::{Error, Result};
use codec::image::ImageProjection;
use codec::math::Camera;
use codec::math::camera::rotation;
use scene::capture::Viewpoint;

/// Maximum number of output views.
pub const MAX_VIEWS: u32 = 4096;

/// Spacing of output views along their line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// Even spacing over a length in metres.
    Baseline(f64),
    /// Even angles around the focus, over a total angle in degrees, as makers of displays specify it.
    Cone(f64),
}

/// Cameras with one orientation on a line along their right axis; view 0 is at the left.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputViews {
    /// Camera in the middle of the line.
    camera: Camera,
    pub size: [u32; 2],
    /// Positions in metres to the right of the middle, in ascending order.
    pub offsets_m: Vec<f64>,
    /// Planar distance of the plane that does not move between views; `+inf` for cameras whose windows do not shift.
    pub focus_m: f64,
}

impl OutputViews {
    /// Creates `count` views around a camera, whose aspect is that of the images if pixels are square. The focus is a planar
    /// distance in metres, above 0; `+inf` for parallel views.
    pub fn new(camera: Camera, size: [u32; 2], count: u32, spread: Spread, focus_m: f64) -> Result<OutputViews> {
        if !(1..=MAX_VIEWS).contains(&count) {
            return Err(Error::Usage(format!("{count} `views`: 1 to {MAX_VIEWS} were expected")));
        }
        if focus_m.is_nan() || focus_m <= 0.0 {
            return Err(Error::Usage(format!("a `focus` of {focus_m} m: a distance above 0 was expected")));
        }
        // Position from -1/2 at the left to 1/2 at the right.
        let place = |view: u32| if count == 1 { 0.0 } else { f64::from(view) / f64::from(count - 1) - 0.5 };
        let offset: Box<dyn Fn(u32) -> f64> = match spread {
            Spread::Baseline(metres) if metres.is_finite() && metres >= 0.0 => {
                Box::new(move |view| metres * place(view))
            }
            Spread::Baseline(metres) => {
                return Err(Error::Usage(format!("a `baseline` of {metres} m: 0 or more was expected")));
            }
            Spread::Cone(_) if !focus_m.is_finite() => {
                return Err(Error::Usage("a view cone needs a finite `focus`: set its distance".into()));
            }
            Spread::Cone(degrees) if (0.0..180.0).contains(&degrees) => {
                Box::new(move |view| focus_m * (degrees.to_radians() * place(view)).tan())
            }
            Spread::Cone(degrees) => {
                return Err(Error::Usage(format!(
                    "a view cone of {degrees} degrees: 0 to less than 180 were expected"
                )));
            }
        };
        Ok(OutputViews { camera, size, offsets_m: (0..count).map(offset).collect(), focus_m })
    }

    /// Returns the number of columns by which the window of a source in the middle is widened on each side: the distance that
    /// surfaces move between it and the views at the ends, at most half of the width. `columns_per_metre` is the maximum over all
    /// pixels.
    pub fn wider_columns(&self, columns_per_metre: f64) -> u32 {
        ((columns_per_metre * 0.5 * self.baseline_m()).ceil() as u32).min(self.size[0] / 2)
    }

    /// Returns the same views with `columns` more columns on each side.
    pub fn widened(&self, columns: u32) -> Result<OutputViews> {
        let width = self.size[0] + 2 * columns;
        let aspect = self.camera.aspect() * f64::from(width) / f64::from(self.size[0]);
        let camera = self.camera.with_aspect(aspect).off_axis(self.window_middle())?;
        Ok(OutputViews { camera, size: [width, self.size[1]], ..self.clone() })
    }

    /// Returns the same camera at other positions, which are in ascending order.
    #[must_use]
    pub fn at(&self, offsets_m: Vec<f64>) -> OutputViews {
        OutputViews { offsets_m, ..self.clone() }
    }

    /// Returns the views above each other at one position on the line, turned by 90°: from the highest down, with the columns of
    /// upright pictures as rows, from right to left. `ups_m` are their heights in metres, in ascending order.
    pub fn column(&self, offset_m: f64, ups_m: &[f64]) -> Result<OutputViews> {
        let camera = self.camera(offset_m)?.turned();
        let offsets_m = ups_m.iter().rev().map(|up_m| -up_m).collect();
        Ok(OutputViews { camera, size: [self.size[1], self.size[0]], offsets_m, focus_m: self.focus_m })
    }

    pub fn count(&self) -> u32 {
        self.offsets_m.len() as u32
    }

    /// Returns the distance from the first view to the last, in metres.
    pub fn baseline_m(&self) -> f64 {
        let [first_m, last_m] = self.ends_m();
        last_m - first_m
    }

    /// Returns the positions of the first and the last view, in metres.
    pub fn ends_m(&self) -> [f64; 2] {
        [self.offsets_m.first(), self.offsets_m.last()].map(|at| at.copied().unwrap_or(0.0))
    }

    /// Returns the same views `up_m` metres higher. The plane of focus does not move.
    pub fn raised(&self, up_m: f64) -> Result<OutputViews> {
        let [middle, down] = self.window_middle();
        let raised = self.camera.moved(-up_m * self.camera.axes()[2]);
        let camera = raised.off_axis([middle, down + up_m / self.focus_m])?;
        Ok(OutputViews { camera, ..self.clone() })
    }

    /// Returns the horizontal focal length in pixels.
    pub fn focal_pixels(&self) -> f64 {
        f64::from(self.size[0]) / (2.0 * self.camera.half()[0])
    }

    /// Returns the number of columns by which a surface at a planar distance moves per metre that the camera moves to the right.
    pub fn columns_per_metre(&self, depth_m: f64) -> f64 {
        self.focal_pixels() * (self.focus_m.recip() - depth_m.recip())
    }

    /// Returns width / height of a view as displayed.
    pub fn aspect(&self) -> f64 {
        self.camera.aspect()
    }

    /// Returns the camera `offset_m` metres to the right of the middle.
    pub fn camera(&self, offset_m: f64) -> Result<Camera> {
        let [middle, down] = self.window_middle();
        self.camera.moved_right(offset_m).off_axis([middle - offset_m / self.focus_m, down])
    }

    /// Returns the viewpoint of that camera, with the projection of its pixels.
    pub fn viewpoint(&self, offset_m: f64) -> Viewpoint {
        let [width, height] = self.size.map(f64::from);
        let [half_width, half_height] = self.camera.half();
        let [middle, down] = self.window_middle();
        let (across, along) = (width / (2.0 * half_width), height / (2.0 * half_height));
        let principal = [0.5 * width - (middle - offset_m / self.focus_m) * across, 0.5 * height - down * along];
        Viewpoint {
            position: self.eye(offset_m),
            orientation: self.camera.orientation().and_then(rotation),
            projection: ImageProjection::Pinhole {
                size: self.size,
                intrinsics: [across, along, principal[0], principal[1]],
            },
        }
    }

    pub fn eye(&self, offset_m: f64) -> DVec3 {
        self.camera.eye() + offset_m * self.camera.axes()[1]
    }

    fn window_middle(&self) -> [f64; 2] {
        let window = self.camera.window();
        [window.u, window.v].map(|[from, to]| 0.5 * (from + to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::math::Lens;

    fn camera() -> Camera {
        Camera::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, 0.0), DVec3::Y, Lens::new(60.0)).unwrap()
    }

    fn views(count: u32, spread: Spread, focus_m: f64) -> Result<OutputViews> {
        OutputViews::new(camera().with_aspect(4.0 / 3.0), [40, 30], count, spread, focus_m)
    }

    #[test]
    fn the_plane_of_focus_stands_still_and_others_move_by_their_columns() {
        for focus_m in [2.0, f64::INFINITY] {
            let views = views(5, Spread::Baseline(0.8), focus_m).unwrap();
            assert_eq!(views.offsets_m, [-0.4, -0.2, 0.0, 0.2, 0.4]);
            for depth_m in [0.5, 2.0, 7.0] {
                let point = DVec3::new(1.1, 2.05, 3.0 - depth_m);
                let column = |offset_m: f64| {
                    let viewpoint = views.viewpoint(offset_m);
                    let [column, _] = viewpoint.projection.position({
                        let from_eye = point - viewpoint.position;
                        [from_eye.x / depth_m, -from_eye.y / depth_m]
                    });
                    let camera = views.camera(offset_m).unwrap();
                    let ([share, _], _) = camera.project(point - camera.eye()).unwrap();
                    assert!((share * 40.0 - column).abs() < 1e-9);
                    column
                };
                for &offset_m in &views.offsets_m {
                    let moved = column(offset_m) - column(0.0);
                    assert!((moved - offset_m * views.columns_per_metre(depth_m)).abs() < 1e-9, "{depth_m} {offset_m}");
                }
            }
        }
    }

    #[test]
    fn raised_views_see_the_plane_of_focus_in_its_place() {
        for focus_m in [2.0, f64::INFINITY] {
            let views = views(3, Spread::Baseline(0.8), focus_m).unwrap();
            let raised = views.raised(0.25).unwrap();
            assert_eq!(raised.eye(0.4), views.eye(0.4) + DVec3::Y * 0.25);
            for depth_m in [0.5, 2.0, 7.0] {
                let point = DVec3::new(1.1, 2.05, 3.0 - depth_m);
                let row = |views: &OutputViews| {
                    let camera = views.camera(0.4).unwrap();
                    camera.project(point - camera.eye()).unwrap().0[1] * 30.0
                };
                // Moves as surfaces do to the left when the camera moves to the right.
                let moved = -0.25 * views.columns_per_metre(depth_m);
                assert!((row(&raised) - row(&views) - moved).abs() < 1e-9, "{focus_m} {depth_m}");
                let viewpoint = raised.viewpoint(0.4);
                let from_eye = point - viewpoint.position;
                let [_, of_viewpoint] = viewpoint.projection.position([from_eye.x / depth_m, -from_eye.y / depth_m]);
                assert!((of_viewpoint - row(&raised)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn widened_views_see_the_same_in_their_middle() {
        for focus_m in [2.0, f64::INFINITY] {
            let views = views(3, Spread::Baseline(0.8), focus_m).unwrap();
            let wide = views.widened(7).unwrap();
            assert_eq!(wide.size, [54, 30]);
            for at in [[0.5, 0.5], [20.0, 15.0], [39.5, 29.5]] {
                let [narrow, wider] = [(&views, at), (&wide, [at[0] + 7.0, at[1]])].map(|(views, [x, y])| {
                    let size = views.size.map(f64::from);
                    views.camera(0.4).unwrap().direction([x / size[0], y / size[1]])
                });
                assert!((narrow - wider).length() < 1e-12, "{at:?}");
            }
        }
        let views = views(3, Spread::Baseline(0.8), 2.0).unwrap();
        assert_eq!([0.0, 10.0, 12.6, 1e9].map(|columns| views.wider_columns(columns)), [0, 4, 6, 20]);
    }

    #[test]
    fn a_cone_is_even_in_its_angle() {
        let views = views(3, Spread::Cone(90.0), 2.0).unwrap();
        assert!(views.offsets_m.iter().zip([-2.0, 0.0, 2.0]).all(|(a, b)| (a - b).abs() < 1e-9));
        let one = super::tests::views(1, Spread::Baseline(3.0), 2.0).unwrap();
        assert_eq!((one.offsets_m.as_slice(), one.baseline_m()), (&[0.0][..], 0.0));
    }

    #[test]
    fn what_has_no_views_is_refused() {
        let said = |count, spread, focus_m| views(count, spread, focus_m).unwrap_err().to_string();
        assert!(said(0, Spread::Baseline(1.0), 1.0).contains("1 to 4096"));
        assert!(said(4097, Spread::Baseline(1.0), 1.0).contains("4097"));
        assert!(said(2, Spread::Baseline(-1.0), 1.0).contains("baseline"));
        assert!(said(2, Spread::Baseline(f64::NAN), 1.0).contains("baseline"));
        assert!(said(2, Spread::Baseline(1.0), 0.0).contains("focus"));
        assert!(said(2, Spread::Cone(10.0), f64::INFINITY).contains("focus"));
        assert!(said(2, Spread::Cone(180.0), 1.0).contains("180"));
    }
}
