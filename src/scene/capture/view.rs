//! Captures one image of a scene. Colour is averaged over each pixel. Depth, normal and material are those of the ray through
//! the pixel's centre, without filtering, so they disagree with colour at edges, as in the output of other renderers. With one
//! sample, all passes use the same ray. Ray directions have length 1; planar depth is the distance divided by
//! `ImageProjection::ray_length_factor`.

use std::ops::Range;

use half::f16;
use rayon::prelude::*;

use super::images::Images;
use super::pixels::{PixelTracer, Viewpoint, halves};
use super::reference::{Copied, Reference};
use super::samples::SamplePattern;
use crate::{Hit, OPAQUE, SceneAtTime};
use codec::error::{Error, Result};
use codec::image::DepthKind;
use codec::image::plane::Plane;
use codec::monitor::Monitor;

/// Maximum width and height of an image: a face of 16,384² pixels takes 2.5 GiB for colour and depth.
pub const MAX_FACE_SIZE: u32 = 16_384;

/// Width and height of the pixel tiles that share a list of candidate objects.
const TILE: u32 = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Pass {
    /// Linear Rec. 709 radiance, averaged over the pixel.
    Color,
    /// Depth in metres, `+inf` for the background.
    Depth,
    /// Shading normal in world axes, length 1; zero for the background.
    Normal,
    /// Weight of reflection, weight of refraction, index of refraction; 0, 0, 1 for the background.
    Material,
}

impl Pass {
    pub const ALL: [Pass; 4] = [Pass::Color, Pass::Depth, Pass::Normal, Pass::Material];

    /// Returns the name used in file names.
    pub fn name(self) -> &'static str {
        match self {
            Pass::Color => "color",
            Pass::Depth => "depth",
            Pass::Normal => "normal",
            Pass::Material => "material",
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct PassSettings<'a> {
    pub passes: &'a [Pass],
    /// Positions of the colour samples.
    pub samples: &'a SamplePattern,
    /// `Planar` is only legal for flat images.
    pub depth: DepthKind,
    /// Far distance in metres; farther surfaces are background in all passes but colour.
    pub far_m: f64,
}

impl PassSettings<'_> {
    fn wants(&self, pass: Pass) -> bool {
        self.passes.contains(&pass)
    }

    /// Returns the camera rays per pixel, without reflected, refracted and shadow rays.
    pub fn rays_per_pixel(&self) -> u64 {
        let color = if self.wants(Pass::Color) { self.samples.points.len() as u64 } else { 0 };
        let centre = self.passes.iter().any(|pass| *pass != Pass::Color);
        color + u64::from(centre && !(color > 0 && self.samples.is_centre()))
    }
}

/// Captures an image. The result does not depend on the number of threads.
pub fn capture_view(
    scene: &SceneAtTime,
    from: &Viewpoint,
    settings: &PassSettings<'_>,
    monitor: &dyn Monitor,
) -> Result<Images> {
    capture_view_after(None, scene, from, settings, monitor)
}

/// [`capture_view`] with a reference from the same viewpoint with the same settings, from which equal parts are copied. The
/// result does not depend on the reference.
pub fn capture_view_after(
    reference: Option<Reference<'_>>,
    scene: &SceneAtTime,
    from: &Viewpoint,
    settings: &PassSettings<'_>,
    monitor: &dyn Monitor,
) -> Result<Images> {
    let [width, height] = from.projection.size();
    if [width, height].iter().any(|&side| side == 0 || side > MAX_FACE_SIZE) {
        return Err(Error::Usage(format!(
            "an image has 1 to {MAX_FACE_SIZE} pixels a side, not {}",
            if width == height { width.to_string() } else { format!("{width}x{height}") }
        )));
    }
    if !from.position.is_finite() {
        return Err(Error::Usage(format!("a probe's position must be finite, not {}", from.position)));
    }
    if settings.depth == DepthKind::Planar && from.projection.axes().is_none() {
        return Err(Error::Usage("equirectangular images have no planar depth: use distance".into()));
    }
    let wants = |pass| settings.wants(pass);
    let mut images = Images {
        color: wants(Pass::Color).then(|| Plane::filled(width, height, [f16::ZERO; 3])),
        depth: wants(Pass::Depth).then(|| Plane::filled(width, height, f32::INFINITY)),
        normal: wants(Pass::Normal).then(|| Plane::filled(width, height, [0.0; 3])),
        material: wants(Pass::Material).then(|| Plane::filled(width, height, [0.0; 3])),
    };
    let reference = reference.filter(|reference| reference.images.shape() == images.shape());
    let copied = reference.and_then(|reference| Copied::new(&reference, scene));
    let capture = ImageCapture { pixels: PixelTracer::new(scene, from), settings, copied };
    bands(&mut images, [width, height]).into_par_iter().try_for_each(|band| {
        monitor.check()?;
        capture.capture_band(band);
        Ok(())
    })?;
    Ok(images)
}

/// A band of rows of all planes.
struct Band<'a> {
    top: u32,
    /// Position of the first pixel in the image.
    start: usize,
    rows: u32,
    color: Option<&'a mut [[f16; 3]]>,
    depth: Option<&'a mut [f32]>,
    normal: Option<&'a mut [[f32; 3]]>,
    material: Option<&'a mut [[f32; 3]]>,
}

impl Band<'_> {
    /// Copies pixels, given by their positions in the band, from images with the same planes.
    fn copy(&mut self, from: &Images, pixels: Range<usize>) {
        let start = self.start;
        let source = start + pixels.start..start + pixels.end;
        copy(&mut self.color, &from.color, &pixels, &source);
        copy(&mut self.depth, &from.depth, &pixels, &source);
        copy(&mut self.normal, &from.normal, &pixels, &source);
        copy(&mut self.material, &from.material, &pixels, &source);
    }
}

fn copy<T: Copy>(band: &mut Option<&mut [T]>, from: &Option<Plane<T>>, to: &Range<usize>, source: &Range<usize>) {
    if let (Some(band), Some(plane)) = (band, from)
        && let (Some(to), Some(source)) = (band.get_mut(to.clone()), plane.data().get(source.clone()))
    {
        to.copy_from_slice(source);
    }
}

fn bands(images: &mut Images, [width, height]: [u32; 2]) -> Vec<Band<'_>> {
    let pixels = width as usize * TILE as usize;
    let mut color = images.color.as_mut().map(|plane| plane.data_mut().chunks_mut(pixels));
    let mut depth = images.depth.as_mut().map(|plane| plane.data_mut().chunks_mut(pixels));
    let mut normal = images.normal.as_mut().map(|plane| plane.data_mut().chunks_mut(pixels));
    let mut material = images.material.as_mut().map(|plane| plane.data_mut().chunks_mut(pixels));
    let band = |top: u32| Band {
        top,
        start: top as usize * width as usize,
        rows: TILE.min(height - top),
        color: color.as_mut().and_then(Iterator::next),
        depth: depth.as_mut().and_then(Iterator::next),
        normal: normal.as_mut().and_then(Iterator::next),
        material: material.as_mut().and_then(Iterator::next),
    };
    (0..height).step_by(TILE as usize).map(band).collect()
}

struct ImageCapture<'a> {
    pixels: PixelTracer<'a>,
    settings: &'a PassSettings<'a>,
    copied: Option<Copied<'a>>,
}

impl ImageCapture<'_> {
    fn capture_band(&self, mut band: Band<'_>) {
        let [width, _] = self.pixels.from.projection.size();
        for left in (0..width).step_by(TILE as usize) {
            let right = (left + TILE).min(width);
            let [from, to] = [[left, band.top], [right, band.top + band.rows]].map(|at| at.map(f64::from));
            let outside = self.pixels.outside(from, to);
            let candidates = self.pixels.inside(&outside);
            if let Some(copied) = &self.copied
                && copied.covers(self.pixels.scene, &outside, &candidates)
            {
                let rows = (0..band.rows as usize).map(|row| row * width as usize);
                rows.for_each(|row| band.copy(copied.images, row + left as usize..row + right as usize));
                continue;
            }
            for row in 0..band.rows {
                for col in left..right {
                    let pixel = row as usize * width as usize + col as usize;
                    self.capture_pixel([col, band.top + row], &candidates, &mut band, pixel);
                }
            }
        }
    }

    fn capture_pixel(&self, [col, row]: [u32; 2], candidates: &[usize], band: &mut Band<'_>, pixel: usize) {
        let (x, y) = (f64::from(col) + 0.5, f64::from(row) + 0.5);
        let mut centre = None;
        if let Some(color) = &mut band.color {
            if self.settings.samples.is_centre() {
                let hit = self.pixels.trace([x, y], candidates);
                color[pixel] = halves(hit.color);
                centre = Some(hit);
            } else {
                color[pixel] = self.pixels.color([col, row].map(f64::from), self.settings.samples, candidates);
            }
        }
        if band.depth.is_none() && band.normal.is_none() && band.material.is_none() {
            return;
        }
        let seen = centre.unwrap_or_else(|| self.centre([x, y], candidates));
        let near = seen.distance <= self.settings.far_m;
        if let Some(depth) = &mut band.depth {
            let metres = match self.settings.depth {
                DepthKind::Distance => seen.distance,
                DepthKind::Planar => seen.distance / self.pixels.from.projection.unproject([x, y]).length(),
            };
            // Depths that underflow become the smallest normal number, not 0.
            depth[pixel] = if near { (metres as f32).max(f32::MIN_POSITIVE) } else { f32::INFINITY };
        }
        if let Some(normal) = &mut band.normal {
            normal[pixel] = if near { seen.normal.as_vec3().to_array() } else { [0.0; 3] };
        }
        if let Some(material) = &mut band.material {
            material[pixel] = (if near { seen.optics } else { OPAQUE }).map(|value| value as f32);
        }
    }

    /// Traces the ray through the centre of a pixel; shades the hit only if normals or materials are requested.
    fn centre(&self, at: [f64; 2], candidates: &[usize]) -> Hit {
        if self.settings.wants(Pass::Normal) || self.settings.wants(Pass::Material) {
            return self.pixels.trace(at, candidates);
        }
        let first = self.pixels.scene.first_hit(&self.pixels.ray(at), candidates.iter().copied());
        Hit { distance: first.map_or(f64::INFINITY, |first| first.distance), ..Hit::NOTHING }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{DemoKind, DemoScene, trace};
    use codec::image::{Face, ImageProjection};
    use codec::monitor::Silent;

    fn settings<'a>(passes: &'a [Pass], samples: &'a SamplePattern) -> PassSettings<'a> {
        PassSettings { passes, samples, depth: DepthKind::Distance, far_m: f64::INFINITY }
    }

    const TURN: [f64; 4] = [0.1, -0.7, 0.3, 0.640_312_423_743_284_9];

    #[test]
    fn every_window_sees_what_single_rays_see() {
        let scene = DemoScene::new(DemoKind::Courtyard).at(1.3);
        let samples = SamplePattern::new(1).unwrap();
        let turn = codec::math::camera::rotation(TURN);
        let projections = [
            ImageProjection::cube_face(Face::Ny, 37),
            ImageProjection::Equirect { size: [70, 35] },
            ImageProjection::Equirect { size: [16, 8] },
            ImageProjection::Pinhole { size: [50, 20], intrinsics: [30.0, 33.0, 26.0, 9.0] },
        ];
        for (projection, orientation) in
            projections.into_iter().flat_map(|projection| [(projection, None), (projection, turn)])
        {
            for position in [DVec3::new(0.1, 1.4, 0.2), DVec3::new(-3.0, 1.0, 3.0), DVec3::new(-1.0, 9.0, 0.0)] {
                let from = Viewpoint { position, orientation, projection };
                let images = capture_view(&scene, &from, &settings(&Pass::ALL, &samples), &Silent).unwrap();
                let (color, depth, normal) = (images.color.unwrap(), images.depth.unwrap(), images.normal.unwrap());
                let [width, height] = projection.size();
                for (col, row) in (0..height).flat_map(|row| (0..width).map(move |col| (col, row))) {
                    let direction = from.turned(projection.pixel_direction(col, row));
                    // Rotating a direction changes its length by a rounding error.
                    let hit = trace(&scene, position, direction);
                    let found = f64::from(depth.get(col, row));
                    assert!(
                        found == hit.distance || (found / hit.distance - 1.0).abs() < 1e-6,
                        "{projection:?} {col} {row}"
                    );
                    let of_normal = normal.get(col, row).map(f64::from);
                    assert!((DVec3::from_array(of_normal) - hit.normal).length() < 1e-5, "{projection:?} {col} {row}");
                    if orientation.is_none() {
                        assert_eq!(color.get(col, row), hit.color.to_array().map(f16::from_f64));
                    }
                }
            }
        }
    }

    #[test]
    fn one_sample_is_the_centre_and_depth_does_not_depend_on_samples() {
        let scene = DemoScene::new(DemoKind::Courtyard).at(0.2);
        let from = Viewpoint {
            position: DVec3::new(0.0, 1.5, 0.0),
            orientation: None,
            projection: ImageProjection::cube_face(Face::Pz, 40),
        };
        let patterns = [1, 3, 16].map(|count| SamplePattern::new(count).unwrap());
        let all = patterns
            .each_ref()
            .map(|samples| capture_view(&scene, &from, &settings(&Pass::ALL, samples), &Silent).unwrap());
        for images in &all {
            assert_eq!((&images.depth, &images.normal), (&all[0].depth, &all[0].normal));
        }
        assert_ne!(all[1].color, all[2].color);
        let depth = capture_view(&scene, &from, &settings(&[Pass::Depth], &patterns[2]), &Silent).unwrap();
        assert_eq!((depth.depth, depth.color), (all[0].depth.clone(), None));
        let rays = |passes: &[Pass], at: usize| settings(passes, &patterns[at]).rays_per_pixel();
        assert_eq!([rays(&Pass::ALL, 0), rays(&Pass::ALL, 1), rays(&[Pass::Color], 2)], [1, 4, 16]);
        assert_eq!([rays(&[Pass::Depth], 2), rays(&[Pass::Color, Pass::Depth], 2)], [1, 17]);
    }

    #[test]
    fn light_stays_finite() {
        assert_eq!(halves(DVec3::new(1e9, 65_504.0, 0.5)).map(f16::to_f32), [65_504.0, 65_504.0, 0.5]);
    }

    #[test]
    fn planar_depth_and_far() {
        let scene = DemoScene::new(DemoKind::Courtyard).at(0.0);
        let samples = SamplePattern::new(1).unwrap();
        let projection = ImageProjection::cube_face(Face::Ny, 64);
        let from = Viewpoint { position: DVec3::new(0.0, 1.5, 0.0), orientation: None, projection };
        let planar = PassSettings { depth: DepthKind::Planar, ..settings(&[Pass::Depth], &samples) };
        let depth = capture_view(&scene, &from, &planar, &Silent).unwrap().depth.unwrap();
        // The ground is 1.5 m below, so its planar depth is 1.5 m in every direction.
        assert!((depth.get(20, 30) - 1.5).abs() < 1e-6);
        let distances =
            capture_view(&scene, &from, &settings(&[Pass::Depth], &samples), &Silent).unwrap().depth.unwrap();
        for (col, row) in (0..64).flat_map(|row| (0..64).map(move |col| (col, row))) {
            let factor = projection.ray_length_factor(col, row);
            let (found, expected) = (f64::from(depth.get(col, row)), f64::from(distances.get(col, row)) / factor);
            assert!(found == expected || (found - expected).abs() < 1e-6, "{col} {row}: {found} {expected}");
        }
        let clipped = PassSettings { far_m: 1.6, ..settings(&Pass::ALL, &samples) };
        let whole = capture_view(&scene, &from, &settings(&Pass::ALL, &samples), &Silent).unwrap();
        let images = capture_view(&scene, &from, &clipped, &Silent).unwrap();
        assert_eq!(images.color, whole.color);
        let (depth, normal) = (images.depth.unwrap(), images.normal.unwrap());
        let all = whole.depth.unwrap();
        assert!(depth.data().iter().any(|d| d.is_finite()) && depth.data().contains(&f32::INFINITY));
        for ((depth, normal), all) in depth.data().iter().zip(normal.data()).zip(all.data()) {
            assert_eq!(*depth, if *all <= 1.6 { *all } else { f32::INFINITY });
            assert_eq!(*normal == [0.0; 3], *all > 1.6);
        }
        let panorama = Viewpoint { projection: ImageProjection::Equirect { size: [8, 4] }, ..from };
        assert!(capture_view(&scene, &panorama, &planar, &Silent).is_err());
    }
}
