//! Spheres as refractive proxies, fitted to refractive texels.
//!
//! Takes active views. Returns the spheres on which connected refractive texels lie, with maps of their environments.

mod environment;
mod plane_extrapolation;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::march::specular::normal::SAME_PATCH;
use crate::march::specular::proxy::{ProxyProvider, reach_m};
use crate::march::{ActiveViews, Occupancy, Proxy, SpecularImage, Sphere, ViewPyramids};
use codec::error::Result;
use codec::monitor::Monitor;
use codec::streams::convert::IOR_RANGE;

use plane_extrapolation::Spread;

pub use environment::MAX_TEXELS;

/// Minimum number of connected texels of an image to which a sphere is fitted.
pub const MIN_TEXELS: usize = 32;
/// Maximum number of proxies; those with the most texels in one image are kept.
pub const MAX_PROXIES: usize = 16;
/// Maximum number of clusters to which spheres are fitted.
pub const MAX_CANDIDATES: usize = 256;
/// Maximum distance of an inlier from a sphere, as a fraction of its radius.
pub const ON_SPHERE: f64 = 0.02;
/// Minimum fraction of inliers of a fit.
pub const INLIERS: f64 = 0.95;
/// Minimum extent of the texels as a fraction of the radius: spheres of any size fit a flat cluster.
pub const MIN_EXTENT: f64 = 0.5;
/// Fraction of the radius at which the occupancy of a sphere is tested.
pub const WITHIN: f32 = 0.7;
/// Minimum radius in metres: steps around a smaller sphere would coincide.
pub const MIN_RADIUS_M: f32 = 1e-6;
/// Points are coplanar if the determinant of their covariance, scaled to a trace of 1, is below this. That of a cap over
/// [`MIN_EXTENT`] of the radius is more than 1e-4.
pub const IN_PLANE: f64 = 1e-9;

#[derive(Debug, Clone, Copy, Default)]
pub struct SphereFit;

impl ProxyProvider for SphereFit {
    fn proxies(&self, views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Vec<Proxy>> {
        let with_environment = |(at, Refractor { sphere, ior }): (usize, Refractor)| {
            let mut environment = environment::map(views, sphere, ior, monitor)?;
            // Probe indices of environment maps count down from the maximum.
            environment.probe = usize::MAX - at;
            let pyramids = Arc::new(ViewPyramids::of(&environment));
            Ok(Proxy { sphere, ior, reach_m: reach_m(views, &sphere), environment, pyramids })
        };
        refractors(views, monitor)?.into_iter().enumerate().map(with_environment).collect()
    }
}

/// Images whose texels are fitted.
type Images<'a> = [SpecularImage<'a>];

struct Cluster {
    /// Image indices, each at most once, and the indices of texels. Points are recomputed for each fit, because they would take
    /// six times as many bytes.
    parts: Vec<(usize, Vec<u32>)>,
    /// Number of texels of all parts. A cluster may join millions of single texels, so counting them each time would take
    /// quadratic time.
    len: usize,
    ior_sum: f64,
    /// Positions of the views that see the cluster, in metres relative to the eye.
    seen_from: Vec<DVec3>,
    sphere: FittedSphere,
    /// Number of texels of the last fit.
    fitted: usize,
}

impl Cluster {
    fn new((number, image): (usize, &SpecularImage<'_>), texels: Vec<u32>) -> Cluster {
        Cluster {
            len: texels.len(),
            ior_sum: texels.iter().map(|&at| ior(image, at as usize)).sum(),
            seen_from: vec![image.view.from_eye.as_dvec3()],
            parts: vec![(number, texels)],
            sphere: FittedSphere::default(),
            fitted: 0,
        }
    }

    /// Adds the texels to the first cluster whose sphere they lie on. Returns false if there is none.
    fn join(&self, clusters: &mut [Cluster], images: &Images<'_>) -> bool {
        let Some(cluster) = clusters.iter_mut().find(|cluster| cluster.inliers(self, images) >= INLIERS) else {
            return false;
        };
        for ((number, texels), from) in self.parts.iter().zip(&self.seen_from) {
            match cluster.parts.iter_mut().find(|(held, _)| held == number) {
                Some((_, held)) => held.extend(texels),
                None => {
                    cluster.parts.push((*number, texels.clone()));
                    cluster.seen_from.push(*from);
                }
            }
        }
        cluster.len += self.len;
        cluster.ior_sum += self.ior_sum;
        // Refitting for every texel would take quadratic time.
        if cluster.len >= 2 * cluster.fitted {
            cluster.fit(images);
        }
        true
    }

    fn points<'a>(&'a self, images: &'a Images<'_>) -> impl Iterator<Item = DVec3> + Clone + 'a {
        let of_part = |(image, texels): &'a (usize, Vec<u32>)| {
            let image = &images[*image];
            texels.iter().filter_map(move |&at| image.point(at as usize))
        };
        self.parts.iter().flat_map(of_part)
    }

    /// Returns the fraction of a cluster's texels that lie on the sphere of this one.
    fn inliers(&self, of: &Cluster, images: &Images<'_>) -> f64 {
        let FittedSphere { centre, radius_m } = self.sphere;
        let near = |point: &DVec3| ((*point - centre).length() - radius_m).abs() <= ON_SPHERE * radius_m;
        of.points(images).filter(near).count() as f64 / of.len as f64
    }

    /// Fits the sphere to the points. Returns false if none fits.
    fn fit(&mut self, images: &Images<'_>) -> bool {
        self.fitted = self.len;
        let Some(sphere) = fit(self.points(images)) else { return false };
        self.sphere = sphere;
        let FittedSphere { centre, radius_m } = sphere;
        let [low, high] = [DVec3::min, DVec3::max].map(|of| self.points(images).reduce(of).unwrap_or_default());
        let is_outside = |from: &DVec3| (*from - centre).length() > radius_m;
        (high - low).length() >= MIN_EXTENT * radius_m
            && self.inliers(self, images) >= INLIERS
            && self.seen_from.iter().all(is_outside)
    }
}

struct Refractor {
    sphere: Sphere,
    ior: f32,
}

fn refractors(views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Vec<Refractor>> {
    let images = SpecularImage::all(views);
    let of_image = |(number, image): (usize, &SpecularImage<'_>)| {
        monitor.check()?;
        Ok(connected(number, image))
    };
    let found: Vec<Connected> = images.par_iter().enumerate().map(of_image).collect::<Result<_>>()?;
    let (large, small): (Vec<_>, Vec<_>) = found.into_iter().map(|Connected { large, small }| (large, small)).unzip();
    let mut large: Vec<Cluster> = large.into_iter().flatten().collect();
    large.sort_by_key(|part: &Cluster| std::cmp::Reverse(part.len));
    let mut clusters: Vec<Cluster> = Vec::new();
    for mut part in large {
        monitor.check()?;
        if !part.join(&mut clusters, &images) && clusters.len() < MAX_CANDIDATES && part.fit(&images) {
            clusters.push(part);
        }
    }
    // Small parts also join in order of size, largest first.
    let lengths = if clusters.is_empty() { 0..0 } else { 1..MIN_TEXELS };
    for len in lengths.rev() {
        for (image, small) in images.iter().zip(&small).enumerate().map(|(at, (image, small))| ((at, image), small)) {
            monitor.check()?;
            for texels in small.of_len(len) {
                Cluster::new(image, texels.to_vec()).join(&mut clusters, &images);
            }
        }
    }
    let of_cluster = |mut cluster: Cluster| {
        let fits = cluster.fit(&images);
        let FittedSphere { centre, radius_m } = cluster.sphere;
        let sphere = Sphere { centre: centre.as_vec3(), radius_m: radius_m as f32 };
        let is_outside = sphere.radius_m >= MIN_RADIUS_M && sphere.centre.length() > sphere.radius_m;
        let ior = (cluster.ior_sum / cluster.len as f64) as f32;
        (fits && is_outside && is_occupied(views, &sphere)).then_some(Refractor { sphere, ior })
    };
    Ok(clusters.into_iter().filter_map(of_cluster).take(MAX_PROXIES).collect())
}

/// True if no view sees empty space inside a sphere.
fn is_occupied(views: &ActiveViews<'_>, sphere: &Sphere) -> bool {
    (0..27).all(|at| {
        let way = Vec3::new((at % 3) as f32, (at / 3 % 3) as f32, (at / 9) as f32) - 1.0;
        let point = sphere.centre + WITHIN * sphere.radius_m * way.normalize_or_zero();
        views.views.iter().all(|view| view.occupancy(point) != Occupancy::Empty)
    })
}

/// Connected refractive texels of an image.
#[derive(Default)]
struct Connected {
    /// Parts that a sphere may be fitted to.
    large: Vec<Cluster>,
    small: SmallParts,
}

/// Parts of fewer texels than [`MIN_TEXELS`], which can only join others. Every texel can be such a part, so
/// they share one list.
#[derive(Default)]
struct SmallParts {
    texels: Vec<u32>,
    /// End of each part in `texels`.
    ends: Vec<u32>,
}

impl SmallParts {
    fn push(&mut self, texels: &[u32]) {
        self.texels.extend(texels);
        self.ends.push(self.texels.len() as u32);
    }

    /// Returns the parts of `len` texels.
    fn of_len(&self, len: usize) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        let ranges = starts.zip(&self.ends).map(|(&start, &end)| start as usize..end as usize);
        ranges.filter(move |range| range.len() == len).map(|range| &self.texels[range])
    }
}

/// Returns the index of refraction of a texel.
fn ior(image: &SpecularImage<'_>, at: usize) -> f64 {
    let part = image.texels.material.as_ref().map_or(0.0, |material| f64::from(material[at][2]) / 255.0);
    f64::from(IOR_RANGE[0]) + part * f64::from(IOR_RANGE[1] - IOR_RANGE[0])
}

/// Returns the connected refractive texels of an image: adjacent texels with similar depths.
fn connected(number: usize, image: &SpecularImage<'_>) -> Connected {
    let texels = image.texels;
    let mut found = Connected::default();
    let Some(material) = &texels.material else { return found };
    let [width, height] = texels.size.map(|size| size as usize);
    // An image with only mirrors needs no list.
    if !(0..material.len()).any(|at| image.is_refractive(at)) {
        return found;
    }
    let mut taken: Vec<bool> = (0..material.len()).map(|at| !image.is_refractive(at)).collect();
    let mut members = Vec::new();
    for start in 0..taken.len() {
        if std::mem::replace(&mut taken[start], true) {
            continue;
        }
        let mut stack = vec![start as u32];
        members.clear();
        while let Some(at) = stack.pop().map(|at| at as usize) {
            if image.point(at).is_none() {
                continue;
            }
            members.push(at as u32);
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
                    stack.push(next as u32);
                }
            }
        }
        match members.len() {
            0 => {}
            1..MIN_TEXELS => found.small.push(&members),
            _ => found.large.push(Cluster::new((number, image), members.clone())),
        }
    }
    found
}

/// Centre and radius of a sphere, in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct FittedSphere {
    centre: DVec3,
    radius_m: f64,
}

/// Fits a sphere to points by least squares of |x − centre|² − radius². None if the points are coplanar ([`IN_PLANE`]).
fn fit(points: impl Iterator<Item = DVec3> + Clone) -> Option<FittedSphere> {
    let Spread { middle, unit_m, covariance } = Spread::of(points.clone());
    // NaN if all points coincide.
    if covariance.determinant().is_nan() || covariance.determinant() < IN_PLANE {
        return None;
    }
    let pull = |sum: DVec3, point: DVec3| {
        let from = (point - middle) / unit_m;
        sum + 0.5 * from.length_squared() * from
    };
    let to_centre = covariance.inverse() * (points.clone().fold(DVec3::ZERO, pull) / points.count() as f64);
    let radius_m = unit_m * (to_centre.length_squared() + 1.0).sqrt();
    let centre = middle + unit_m * to_centre;
    (centre.is_finite() && radius_m.is_finite() && radius_m > 0.0).then_some(FittedSphere { centre, radius_m })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use crate::march::specular::proxy::{Proxies, has_specular_in_frustum, proxies_in_sight};
    use crate::march::synthetic::SyntheticProbe;
    use crate::march::tests::field;
    use crate::views::light_field::{BACKGROUND, ColorCoding, LightField, View};
    use codec::error::Error;
    use codec::image::transfer::{ToneMap, Transfer};
    use codec::math::{Camera, Lens};
    use codec::monitor::Silent;

    const AWAY_M: f64 = 3.0;
    const RADIUS_M: f64 = 0.5;

    fn proxies(field: &LightField, views: &[usize]) -> Proxies {
        let views = ActiveViews::new(field, views, DVec3::ZERO);
        Proxies::of(&SphereFit, &views, &Silent).unwrap()
    }

    /// Refractive spheres around a probe, and their centres.
    fn beads(count: usize) -> (LightField, Vec<DVec3>) {
        // Each centre is rotated from the previous one by the golden angle.
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

    /// A view at the origin, of refractive spheres in front of the background.
    fn glass(centres: &[DVec3], radii_m: &[f64]) -> View {
        let sight = |direction: DVec3| {
            let met_m = |(centre, radius_m): (&DVec3, &f64)| {
                let along = centre.dot(direction);
                let squared = radius_m * radius_m - (centre.length_squared() - along * along);
                (along > 0.0 && squared > 0.0).then(|| along - squared.sqrt())
            };
            centres.iter().zip(radii_m).find_map(met_m).map(|distance_m| (distance_m, [50; 3]))
        };
        let mut view = SyntheticProbe::new(DVec3::ZERO, 64).cube(CODING, &sight);
        for texels in view.faces.iter_mut().flatten() {
            let glass = |&inverse: &f32| if inverse == BACKGROUND { [0; 4] } else { [0, 255, 64, 0] };
            texels.material = Some(texels.inverse_depth.iter().map(glass).collect());
            texels.update_specular();
        }
        view
    }

    #[test]
    fn spheres_are_found_up_to_a_limit() {
        for count in [1, 5, MAX_PROXIES, MAX_PROXIES + 4] {
            let (field, centres) = beads(count);
            let found = proxies(&field, &[0]);
            assert_eq!(found.proxies.len(), count.min(MAX_PROXIES));
            for Proxy { sphere, ior, .. } in &found.proxies {
                let off_m = |centre: &DVec3| (*centre - sphere.centre.as_dvec3()).length();
                assert_eq!(centres.iter().filter(|centre| off_m(centre) < 1e-3).count(), 1, "{sphere:?}");
                assert!(
                    (f64::from(sphere.radius_m) - RADIUS_M).abs() < 1e-3 && (1.0..=3.0).contains(ior),
                    "{sphere:?}"
                );
            }
        }
    }

    /// A second view sees past all spheres but the smallest.
    #[test]
    fn spheres_with_empty_space_count_not_as_found() {
        let (_, mut centres) = beads(2 * MAX_PROXIES + 1);
        centres.swap(0, 2 * MAX_PROXIES);
        let mut radii = vec![0.4; centres.len()];
        radii[2 * MAX_PROXIES] = 0.3;
        let small = [centres[2 * MAX_PROXIES]];
        let field = field(vec![glass(&centres, &radii), glass(&small, &[0.3])], CODING);
        assert_eq!(proxies(&field, &[0]).proxies.len(), MAX_PROXIES);
        let found = proxies(&field, &[0, 1]);
        let [Proxy { sphere, .. }] = &found.proxies[..] else { panic!("{:?}", found.proxies.len()) };
        assert!(
            sphere.centre.distance(small[0].as_vec3()) < 1e-3 && (sphere.radius_m - 0.3).abs() < 1e-3,
            "{sphere:?}"
        );
    }

    #[test]
    fn proxies_are_made_where_specular_texels_are_in_the_frustum() {
        let field = field(vec![glass(&[DVec3::new(0.0, 0.0, -AWAY_M)], &[RADIUS_M])], CODING);
        let views = ActiveViews::new(&field, &[0], DVec3::ZERO);
        let seen = |target: DVec3, lens: Lens| {
            let camera = Camera::look_at(DVec3::ZERO, target, DVec3::Y, lens).unwrap();
            let shown = proxies_in_sight(&SphereFit, &views, &camera, &Silent).unwrap();
            assert_eq!(shown.proxies.len() == 1, has_specular_in_frustum(&views, &camera));
            has_specular_in_frustum(&views, &camera)
        };
        assert!(seen(DVec3::NEG_Z, Lens::new(10.0)) && seen(DVec3::new(1.0, 0.0, -1.0), Lens::new(90.0)));
        assert!(!seen(DVec3::Z, Lens::new(170.0)) && !seen(DVec3::X, Lens::new(90.0)));
        assert!(
            !seen(DVec3::new(1.0, 0.0, -1.0), Lens::new(40.0)) && !seen(DVec3::new(0.0, 1.0, -1.0), Lens::new(40.0))
        );
        // A camera wider than high.
        let wide = Lens { aspect: 4.0, ..Lens::new(40.0) };
        assert!(seen(DVec3::new(1.0, 0.0, -1.0), wide) && !seen(DVec3::new(0.0, 1.0, -1.0), wide));
        assert!(!has_specular_in_frustum(
            &ActiveViews { views: Vec::new(), coding: CODING },
            &Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, wide).unwrap()
        ));
    }

    /// Monitor that interrupts after this number of checks.
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
    fn fitting_stops_on_request() {
        let (field, _) = beads(1);
        let views = ActiveViews::new(&field, &[0], DVec3::ZERO);
        let with = |after: usize| {
            let monitor = Stops { asked: AtomicUsize::new(0), after };
            (Proxies::of(&SphereFit, &views, &monitor), monitor.asked.into_inner())
        };
        let (all, asked) = with(usize::MAX);
        // At least one check per row of the environment map.
        assert!(all.is_ok() && asked > 6 * 64, "{asked}");
        for after in [0, 1, asked / 2, asked - 1] {
            assert!(matches!(with(after).0, Err(Error::Interrupted)), "{after} of {asked}");
        }
    }

    #[test]
    fn fits_are_scale_free() {
        // A cap over half the radius, and a plane.
        let cap = |at: usize| {
            let [x, y] = [at % 9, at / 9].map(|at| (at as f64 - 4.0) / 20.0);
            DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
        };
        for size in [1e-30, 1e-5, 1.0, 1e5, 1e30] {
            let middle = size * DVec3::new(3.0, -2.0, 7.0);
            let points: Vec<DVec3> = (0..81).map(|at| middle + size * cap(at)).collect();
            let FittedSphere { centre, radius_m } = fit(points.iter().copied()).unwrap();
            assert!((centre - middle).length() < 1e-9 * size && (radius_m / size - 1.0).abs() < 1e-9, "{size}");
            let flat: Vec<DVec3> = points.iter().map(|point| point.with_z(point.x + 0.3 * point.y)).collect();
            assert_eq!((fit(flat.iter().copied()), fit(flat.iter().copied().take(1))), (None, None), "{size}");
        }
        assert_eq!(fit(std::iter::empty()), None);
    }
}
