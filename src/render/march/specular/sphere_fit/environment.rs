//! Local environment map of a refractive sphere: a view from its centre.
//!
//! Takes active views that all see the sphere from outside. Returns a view with a depth and a colour in every texel.
//!
//! Directions in which views see a surface take its depth and colour. The other directions, behind the sphere, are hidden, and
//! they are most of what the sphere shows. Their depths are those of extrapolated planes, or else interpolated from their
//! neighbours. Their colours are those that views see through the sphere: the ray of each refractive texel is traced to the
//! environment, where the texel's colour is splatted.

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::plane_extrapolation::{Edge, Plane, nearest_inverse, planes};
use crate::march::intersect::intersect;
use crate::march::specular::proxy::NEAR_SURFACE;
use crate::march::specular::solid::{Exit, refract};
use crate::march::{
    Acceleration, ActiveView, ActiveViews, Counters, HOLE_DIFFERENCE, Ray, SpecularImage, Sphere, Steps, StepsFrom,
    Taps, ViewPyramids, background_color, fresnel, intersect_from, patch, surface_color,
};
use crate::views::{BACKGROUND, ColorCoding, ColorTexels, FaceTexels, View};
use codec::error::Result;
use codec::image::{Face, TexelMap};
use codec::monitor::Monitor;

/// Maximum width of a face, in texels.
pub const MAX_TEXELS: u32 = 128;
/// Minimum fraction of the light that a splatted texel refracts straight through.
pub const MIN_THROUGH: f32 = 0.5;
/// Maximum number of points to which planes are fitted, in quadratic time.
pub const MAX_EDGES: usize = 4096;
/// Splats are weighted by this power of the view's camera weight: refracted light differs more between views than surfaces do.
pub const NEARNESS: i32 = 4;

/// Six faces of a cube, row by row: sums of weighted values, and sums of their weights.
struct Cube {
    size: usize,
    sums: Vec<Vec3>,
    weights: Vec<f32>,
}

impl Cube {
    fn empty(size: usize) -> Cube {
        Cube { size, sums: vec![Vec3::ZERO; 6 * size * size], weights: vec![0.0; 6 * size * size] }
    }

    fn add(&mut self, at: usize, value: Vec3, weight: f32) {
        self.sums[at] += weight * value;
        self.weights[at] += weight;
    }

    /// Returns weighted means; where the sum of weights is below 1, coarser images fill in the rest (pull-push).
    fn filled(&self) -> Vec<Vec3> {
        let size = self.size;
        if size == 1 {
            let all = self.sums.iter().copied().sum::<Vec3>() / self.weights.iter().sum::<f32>().max(f32::MIN_POSITIVE);
            let value = |(sum, &weight): (&Vec3, &f32)| if weight > 0.0 { *sum / weight } else { all };
            return self.sums.iter().zip(&self.weights).map(value).collect();
        }
        let mut coarse = Cube::empty(size / 2);
        for (at, (&sum, &weight)) in self.sums.iter().zip(&self.weights).enumerate() {
            let (row, column) = (at / size, at % size);
            // Faces are stacked vertically, with an even number of rows each.
            let above = row / 2 * coarse.size + column / 2;
            coarse.sums[above] += sum;
            coarse.weights[above] += weight;
        }
        for (sum, weight) in coarse.sums.iter_mut().zip(&mut coarse.weights).filter(|(_, weight)| **weight > 1.0) {
            (*sum, *weight) = (*sum / *weight, 1.0);
        }
        let below = coarse.filled();
        let smooth = |at: usize| {
            let (face, row, column) = (at / (size * size), at / size % size, at % size);
            let get = |row: usize, column: usize| below[(face * size + row) / 2 * coarse.size + column / 2];
            let last = size - 1;
            let beside = get(row.saturating_sub(1), column)
                + get((row + 1).min(last), column)
                + get(row, column.saturating_sub(1))
                + get(row, (column + 1).min(last));
            (beside + 4.0 * get(row, column)) / 8.0
        };
        let value = |at: usize| match self.weights[at] {
            weight if weight >= 1.0 => self.sums[at] / weight,
            weight => self.sums[at] + (1.0 - weight) * smooth(at),
        };
        (0..self.sums.len()).into_par_iter().map(value).collect()
    }
}

/// Surface or background that views see in a direction from the sphere.
#[derive(Clone, Copy)]
struct Seen {
    /// Metres from the centre; infinite for background.
    distance_m: f32,
    color: Vec3,
}

/// Computes the environment map of a sphere with an index of refraction.
pub fn map(views: &ActiveViews<'_>, sphere: Sphere, ior: f32, monitor: &dyn Monitor) -> Result<View> {
    let of_views = views.views.iter().flat_map(|view| view.view.faces.iter().flatten().map(|face| face.size[0]));
    let size = of_views.max().unwrap_or(1).clamp(1, MAX_TEXELS).next_power_of_two();
    let far_m = views.far_m() + sphere.centre.length();
    // Steps are a few texels of the map wide.
    let steps = Steps::new(96, sphere.radius_m * 2.0 / size as f32, far_m, 8);
    // Colours are written at the end; their coding does not matter before.
    let face = FaceTexels::unknown([size; 2], TexelMap::cube_face([size; 2]), ColorCoding::Light);
    let search = Search { views, sphere, steps: &steps, face: &face, monitor };
    let known = search.all_known()?;
    let (name, probe, near_m) = ("environment".into(), usize::MAX, sphere.radius_m);
    let mut view = View { name, probe, near_m, far_m, ..View::default() };
    put_depths(&mut view, &known, &planes(&search.edges(&known)?, monitor)?, &face);
    let colors = search.colors(&known, &view, ior)?;
    for (texels, colors) in view.faces.iter_mut().flatten().zip(colors.chunks((size * size) as usize)) {
        texels.color = coded(colors, views.coding);
    }
    Ok(view)
}

/// Returns the direction of a texel. `at` is its index over all faces, which have the size of `face`.
fn direction(at: usize, face: &FaceTexels) -> Vec3 {
    let [width, height] = face.size.map(|size| size as usize);
    let centre = [at % width, at / width % height].map(|at| at as f32 + 0.5);
    face.map.direction(Face::CUBE[at / (width * height)], centre)
}

struct Search<'a> {
    views: &'a ActiveViews<'a>,
    sphere: Sphere,
    steps: &'a Steps,
    /// Size and projection of the faces of the map.
    face: &'a FaceTexels,
    monitor: &'a dyn Monitor,
}

impl Search<'_> {
    fn all_known(&self) -> Result<Vec<Option<Seen>>> {
        let [width, height] = self.face.size.map(|size| size as usize);
        let row = |row: usize| -> Result<Vec<Option<Seen>>> {
            self.monitor.check()?;
            let known = |at: usize| self.known(direction(at, self.face).normalize());
            Ok((row * width..(row + 1) * width).map(known).collect())
        };
        Ok((0..6 * height).into_par_iter().map(row).collect::<Result<Vec<_>>>()?.concat())
    }

    /// Returns the surface or background that views see in a direction. The ray starts on the sphere and is marched from the
    /// first point that is empty in a view. None if no view sees anything.
    fn known(&self, direction: Vec3) -> Option<Seen> {
        let Search { views, sphere: Sphere { centre, radius_m }, steps, .. } = *self;
        let ray = Ray { origin: centre + radius_m * direction, direction };
        let first = steps.distances_m.iter().position(|&distance_m| !views.is_surface(ray.at(distance_m)))?;
        let from = StepsFrom { steps, first };
        match intersect_from(Acceleration::Pyramid, views, &ray, from, &mut Counters::default()) {
            Some(distance_m) => surface_color(views, ray.at(distance_m))
                .filter(|seen| seen.difference <= HOLE_DIFFERENCE + steps.uncertainty())
                .map(|seen| Seen { distance_m: radius_m + distance_m, color: seen.color }),
            None => {
                background_color(views, direction).map(|seen| Seen { distance_m: f32::INFINITY, color: seen.color })
            }
        }
    }

    /// Returns surface points next to hidden texels, evenly subsampled to [`MAX_EDGES`].
    fn edges(&self, known: &[Option<Seen>]) -> Result<Vec<Edge>> {
        let size = self.face.size[0] as usize;
        let at_edge = |&at: &usize| {
            let (row, column) = (at / size % size, at % size);
            let beside = [
                (column > 0, -1),
                (column + 1 < size, 1),
                (row > 0, -(size as isize)),
                (row + 1 < size, size as isize),
            ];
            let next = |&(there, by): &(bool, isize)| there.then(|| at.checked_add_signed(by)).flatten();
            beside.iter().filter_map(next).any(|next| known[next].is_none())
        };
        let edge = |at: usize| {
            let point = known[at]?.distance_m * direction(at, self.face).normalize();
            let normal = patch(self.views, self.sphere.centre + point)?.normal;
            Some(Edge { point, normal })
        };
        let is_seen = |at: &usize| known[*at].is_some_and(|seen| seen.distance_m.is_finite());
        let beside: Vec<usize> = (0..known.len()).filter(is_seen).filter(at_edge).collect();
        self.monitor.check()?;
        let some: Vec<usize> = beside.iter().copied().step_by(beside.len().div_ceil(MAX_EDGES).max(1)).collect();
        Ok(some.into_par_iter().filter_map(edge).collect())
    }

    /// Returns the ray that leaves the sphere straight through, and its fraction of the light.
    fn through(&self, ray: &Ray, ior: f32) -> Option<Exit> {
        let entry = self.sphere.entry(ray)?;
        let normal = self.sphere.normal(entry)?;
        let entering = 1.0 - fresnel(-ray.direction.dot(normal), ior);
        let inside = Ray { origin: entry, direction: refract(ray.direction, normal, ior.recip())? };
        let origin = inside.at(self.sphere.exit_m(&inside)?);
        let normal = self.sphere.normal(origin)?;
        let direction = refract(inside.direction, -normal, ior)?;
        let part = entering * (1.0 - fresnel(direction.dot(normal), ior));
        Some(Exit { ray: Ray { origin, direction }, part })
    }

    fn colors(&self, known: &[Option<Seen>], view: &View, ior: f32) -> Result<Vec<Vec3>> {
        let Search { views, sphere, steps, monitor, .. } = *self;
        let from_centre = ActiveView::new(view, ViewPyramids::of(view).into(), sphere.centre);
        let alone = ActiveViews { views: vec![from_centre], coding: views.coding };
        let mut cube = Cube::empty(self.face.size[0] as usize);
        for (at, known) in known.iter().enumerate() {
            if let Some(seen) = known {
                cube.add(at, seen.color, 1.0);
            }
        }
        let greatest = views.views.iter().map(|view| view.camera_weight).fold(f32::MIN_POSITIVE, f32::max);
        for image in SpecularImage::all(views) {
            let nearness = (image.view.camera_weight / greatest).powi(NEARNESS);
            let splat = |at: usize| {
                let point = image.point(at).filter(|_| image.is_refractive(at))?.as_vec3();
                let off_m = ((point - sphere.centre).length() - sphere.radius_m).abs();
                if off_m > NEAR_SURFACE * sphere.radius_m {
                    return None;
                }
                let ray = Ray { origin: point, direction: (point - image.view.from_eye).try_normalize()? };
                let exit = self.through(&ray, ior).filter(|exit| exit.part >= MIN_THROUGH)?;
                let hit = intersect(Acceleration::Pyramid, &alone, &exit.ray, steps, &mut Counters::default());
                let end = hit.map_or(exit.ray.direction, |hit_m| alone.views[0].local(exit.ray.at(hit_m)));
                Some((view.project(end)?, exit.part, image.texels.color.get(at)))
            };
            let [width, height] = image.texels.size.map(|size| size as usize);
            let of_row = |row: usize| -> Result<Vec<_>> {
                monitor.check()?;
                Ok((row * width..(row + 1) * width).filter_map(splat).collect())
            };
            let of_rows: Vec<Vec<_>> = (0..height).into_par_iter().map(of_row).collect::<Result<_>>()?;
            for (end, part, color) in of_rows.into_iter().flatten() {
                let Some(onto) = &view.faces[end.face] else { continue };
                let taps = Taps::around(end.at, onto);
                for (texel, weight) in taps.texels.into_iter().zip(taps.weights) {
                    let at = end.face * onto.inverse_depth.len() + texel;
                    if known[at].is_none() {
                        cube.add(at, color, weight * part * nearness);
                    }
                }
            }
        }
        Ok(cube.filled())
    }
}

/// Writes the depths of the map. Hidden texels take the depths of planes, or else are interpolated in inverse distance.
fn put_depths(view: &mut View, known: &[Option<Seen>], planes: &[Plane], like: &FaceTexels) {
    let size = like.size[0];
    let mut cube = Cube::empty(size as usize);
    for (at, known) in known.iter().enumerate() {
        let extrapolated = || nearest_inverse(planes, direction(at, like).normalize());
        if let Some(inverse) = known.map(|seen| seen.distance_m.recip()).or_else(extrapolated) {
            cube.add(at, Vec3::splat(inverse), 1.0);
        }
    }
    let inverse = cube.filled();
    for (face, inverse) in inverse.chunks((size * size) as usize).enumerate() {
        let mut texels = like.clone();
        for (at, inverse) in inverse.iter().enumerate() {
            let stretch = texels.map.ray_length_factor(at as u32 % size, at as u32 / size);
            texels.inverse_depth[at] = if inverse.x > 0.0 { inverse.x * stretch } else { BACKGROUND };
        }
        view.faces[face] = Some(texels);
    }
}

fn coded(colors: &[Vec3], coding: ColorCoding) -> ColorTexels {
    match coding {
        ColorCoding::Codes(_) => {
            let code = |part: f32| (255.0 * part).round() as u8;
            ColorTexels::Codes(colors.iter().map(|color| color.extend(0.0).to_array().map(code)).collect())
        }
        ColorCoding::Light => {
            ColorTexels::Light(colors.iter().map(|color| color.extend(0.0).to_array().map(f16::from_f32)).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::monitor::Silent;

    #[test]
    fn missing_texels_are_filled_from_around() {
        let size = 16;
        let mut cube = Cube::empty(size);
        // One face has a missing centre, with red on its left and green on its right; all other faces are unknown.
        for at in 0..size * size {
            let (row, column) = (at / size, at % size);
            if !(4..12).contains(&column) || !(4..12).contains(&row) {
                cube.add(at, if column < 8 { Vec3::X } else { Vec3::Y }, 2.0);
            }
        }
        let filled = cube.filled();
        assert_eq!((filled[0], filled[size - 1]), (Vec3::X, Vec3::Y));
        for value in &filled {
            assert!((value.element_sum() - 1.0).abs() < 1e-5 && value.min_element() >= 0.0, "{value}");
        }
        let (left, right) = (filled[8 * size + 5], filled[8 * size + 10]);
        assert!(left.x > 0.6 && right.y > 0.6, "{left} {right}");
        assert!((filled[5 * size * size].x - 0.5).abs() < 1e-5);
        // Without any known texel the result is 0, not NaN.
        assert!(Cube::empty(4).filled().iter().all(|value| *value == Vec3::ZERO));
    }

    #[test]
    fn light_is_refracted_through_a_sphere() {
        let sphere = Sphere { centre: Vec3::new(0.0, 0.0, -3.0), radius_m: 1.0 };
        let views = ActiveViews { views: Vec::new(), coding: ColorCoding::Light };
        let steps = Steps::new(4, 0.1, 1.0, 0);
        let face = &FaceTexels::unknown([1; 2], TexelMap::cube_face([1; 2]), ColorCoding::Light);
        let search = Search { views: &views, sphere, steps: &steps, face, monitor: &Silent };
        let through = |x: f32, ior| {
            let ray = Ray { origin: Vec3::X * x, direction: Vec3::NEG_Z };
            search.through(&ray, ior).map(|exit| (exit.ray, exit.part))
        };
        let (straight, part) = through(0.0, 1.5).unwrap();
        assert_eq!((straight.origin, straight.direction), (Vec3::NEG_Z * 4.0, Vec3::NEG_Z));
        assert!((part - 0.96 * 0.96).abs() < 1e-4);
        // The ray is rotated by twice the difference of the angles outside and inside.
        let (bent, _) = through(0.6, 1.5).unwrap();
        let turn = 2.0 * (0.6f32.asin() - 0.4f32.asin());
        assert!((bent.direction.angle_between(Vec3::NEG_Z) - turn).abs() < 1e-3 && bent.direction.x < 0.0);
        let (same, part) = through(0.6, 1.0).unwrap();
        assert!(same.direction.distance(Vec3::NEG_Z) < 1e-3 && part > 0.999);
        assert!(through(1.1, 1.5).is_none());
    }
}
