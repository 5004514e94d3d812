//! The viewing region: the space in which the eye may be (Seurat 3).

use glam::DVec3;

use scene::placement::Region;

/// Half of the edge of the sky's cube while tiles are fitted, in region radii: 200 m for a region of 0.5 m.
const SKY_RADII: f64 = 400.0;
/// Half of the edge of the sky's cube in a scene, in distances of the farthest surface. Viewers fit their clip planes and their
/// first view to the bounding box.
const SKY_SURFACES: f64 = 4.0;
/// Minimum of the same in region radii: the sky shifts by up to 1/8 radian as seen from the region.
const MIN_SKY_RADII: f64 = 8.0;
/// Radius of a region without extent, as a fraction of the distance of the nearest surface.
const RADIUS_WITHOUT_EXTENT: f64 = 0.1;

/// Number of steps in which a point of the box around a region is moved into the region.
const EYE_STEPS: u32 = 32;

#[derive(Debug, Clone)]
pub struct ViewingRegion {
    /// Centre of the region in metres, the origin of all fitted geometry.
    pub middle: DVec3,
    /// Half of the edges of the box around the region.
    pub half: DVec3,
    /// The region itself; `None` if it is the box.
    given: Option<Region>,
}

impl ViewingRegion {
    /// Creates a viewing region from a given region.
    pub fn given(region: Region) -> ViewingRegion {
        let bounds = region.bounds();
        let (middle, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
        ViewingRegion { middle, half, given: Some(region) }
    }

    /// Creates a viewing region that is the box around cameras.
    pub fn around(eyes: impl Iterator<Item = DVec3>) -> ViewingRegion {
        let (min, max) =
            eyes.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), eye| (min.min(eye), max.max(eye)));
        ViewingRegion { middle: 0.5 * (min + max), half: 0.5 * (max - min), given: None }
    }

    pub fn has_extent(&self) -> bool {
        self.radius() > 0.0
    }

    /// Grows a region without extent to a cube, whose radius is a tenth of the distance of the nearest surface.
    pub fn grow(&mut self, nearest_m: f64) {
        let radius = if nearest_m.is_finite() { RADIUS_WITHOUT_EXTENT * nearest_m } else { RADIUS_WITHOUT_EXTENT };
        self.half = DVec3::splat(radius / 3f64.sqrt());
        self.given = None;
    }

    /// Returns the distance from the centre, in metres, within which there is no tile: 1% of the radius (Seurat 4.2).
    pub fn min_m(&self) -> f64 {
        0.01 * self.radius()
    }

    /// Returns the distance from the centre to the corners, in metres.
    pub fn radius(&self) -> f64 {
        self.half.length()
    }

    /// Returns the distance in metres by which eyes in the region are beside a line through its centre, in root mean square over eyes
    /// and directions.
    pub fn offset_m(&self) -> f64 {
        // Along each axis a third of the square of the half side; of its length, two thirds are across the line.
        (2.0f64 / 9.0).sqrt() * self.radius()
    }

    /// Returns the corners and the centre of the box around the region, and the centres of its edges and sides, relative to its
    /// centre.
    pub fn border(&self) -> Vec<DVec3> {
        let steps = [-1.0, 0.0, 1.0];
        let signs =
            steps.into_iter().flat_map(|x| steps.into_iter().flat_map(move |y| steps.map(|z| DVec3::new(x, y, z))));
        distinct(signs.map(|sign| sign * self.half))
    }

    /// Returns the points of [`Self::border`] and those halfway to the corners, moved towards the centre into the region.
    pub fn eyes(&self) -> Vec<DVec3> {
        let into = |point: DVec3| {
            let steps = (0..=EYE_STEPS).map(|step| point * (1.0 - f64::from(step) / f64::from(EYE_STEPS)));
            let region = self.given.as_ref();
            steps.into_iter().find(|&at| region.is_none_or(|region| region.contains(self.middle + at)))
        };
        let border = self.border();
        let halfway = border.iter().filter(|at| at.abs() == self.half).map(|&corner| 0.5 * corner);
        distinct(border.iter().copied().chain(halfway).filter_map(into))
    }

    /// Returns true if a point, relative to the centre, is inside.
    pub fn contains(&self, from_middle: DVec3) -> bool {
        match &self.given {
            Some(region) => region.contains(self.middle + from_middle),
            None => from_middle.abs().cmplt(self.half).all(),
        }
    }

    /// Returns true if an eye, relative to the centre, may be at this position. A region without extent along an axis admits
    /// eyes, too.
    pub fn admits(&self, eye: DVec3) -> bool {
        match &self.given {
            Some(region) => region.contains(self.middle + eye),
            None => eye.abs().cmple(self.half).all(),
        }
    }

    /// Returns the greatest coordinate, in metres, of an end of a ray relative to the centre; `None` if it lies on the cube of the
    /// sky.
    pub fn surface_m(&self, end: DVec3) -> Option<f64> {
        Some(end.abs().max_element()).filter(|&metres| metres < 0.999 * SKY_RADII * self.radius())
    }

    /// Returns half of the edge of the sky's cube in a scene, in metres, given the greatest coordinate of surfaces and eyes; 0 for
    /// none.
    pub fn scene_sky_m(&self, farthest_m: f64) -> f64 {
        let fitted_m = SKY_RADII * self.radius();
        if farthest_m <= 0.0 {
            return fitted_m;
        }
        (SKY_SURFACES * farthest_m).max(MIN_SKY_RADII * self.radius()).min(fitted_m)
    }

    /// Returns the distance in metres along a ray, from a point relative to the centre, to the cube of the sky.
    pub fn to_sky(&self, origin: DVec3, direction: DVec3) -> f64 {
        let half = SKY_RADII * self.radius();
        let along = |axis: usize| match direction[axis] {
            0.0 => f64::INFINITY,
            step => (half.copysign(step) - origin[axis]) / step,
        };
        along(0).min(along(1)).min(along(2))
    }

    /// Returns a distance in metres within which no ray of unit direction from a point reaches the cube of the sky.
    pub fn before_sky(&self, origin: DVec3) -> f64 {
        0.999 * (SKY_RADII * self.radius() - origin.abs().max_element())
    }
}

/// Removes duplicates: boxes without extent along an axis have equal corners.
fn distinct(points: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    points.fold(Vec::new(), |mut all, point| {
        if !all.contains(&point) {
            all.push(point);
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_have_a_middle_and_a_sky() {
        let mut region = ViewingRegion::around([DVec3::ONE, DVec3::new(3.0, 1.0, 1.0)].into_iter());
        assert_eq!((region.middle, region.radius()), (DVec3::new(2.0, 1.0, 1.0), 1.0));
        assert_eq!(region.to_sky(DVec3::X, DVec3::X), 399.0);
        assert_eq!(region.to_sky(DVec3::X, DVec3::new(-0.6, 0.8, 0.0)), 500.0);
        assert!(region.before_sky(DVec3::X) < region.to_sky(DVec3::X, DVec3::X) && region.before_sky(DVec3::X) > 398.0);
        assert_eq!([DVec3::new(3.0, -9.0, 1.0), DVec3::X * 400.0].map(|end| region.surface_m(end)), [Some(9.0), None]);
        assert_eq!([0.0, 0.5, 10.0, 300.0].map(|farthest| region.scene_sky_m(farthest)), [400.0, 8.0, 40.0, 400.0]);
        assert_eq!((region.border().len(), region.eyes().len()), (3, 5));
        assert!(region.admits(DVec3::X) && !region.contains(DVec3::X) && !region.admits(DVec3::Y));
        let ball = ViewingRegion::given(Region::parse(&["sphere:1,2,3,0.5"]).unwrap());
        assert!(ball.contains(DVec3::X * 0.49) && !ball.contains(DVec3::splat(0.4)));
        assert!(ball.has_extent() && region.has_extent());
        region = ViewingRegion::around([DVec3::ONE].into_iter());
        assert!(!region.has_extent());
        region.grow(5.0);
        assert!((region.radius() - 0.5).abs() < 1e-12);
    }
}
