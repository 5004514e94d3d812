//! Point splatting (CALF 7.3).
//!
//! Takes active views and a camera. Returns a rendered image. Each surface texel is projected into one pixel, where the nearest
//! point wins; background texels are behind all surfaces. Pixels without a point are holes. Points have no partial coverage:
//! texels with an alpha below a half are skipped, and others are opaque.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::march::{
    ActiveView, ActiveViews, ClipPlanes, Counters, PictureOptions, Pyramids, RenderSettings, Rendered, Renderer, Stage,
    light_of,
};
use crate::rendered_image::{BackgroundFill, HoleFill, RenderedImage};
use crate::views::{BACKGROUND, FaceTexels, UNKNOWN};
use codec::error::Result;
use codec::image::Face;
use codec::math::Camera;
use codec::monitor::Monitor;

/// Minimum alpha of a texel that is drawn.
const MIN_ALPHA: f32 = 0.5;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    /// Distance from the eye in metres; `+inf` for the background.
    distance_m: f32,
    color: Vec3,
}

/// Renders every texel as a point.
#[derive(Debug, Clone, Default)]
pub struct SplatRenderer {
    pub options: PictureOptions,
}

impl Renderer for SplatRenderer {
    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views = ActiveViews::with_pyramids(stage.field, &Pyramids::default(), stage.views, camera.eye());
        splat(&views, camera, &self.options.settings(&views), monitor)
    }
}

/// Renders by splatting. Uses the settings `size`, `holes`, `background`, and the first and last of the distances. A point covers
/// one pixel, regardless of the number of samples. Of points at the same distance the first wins, in the order of views, faces
/// and texels. The monitor advances by the number of rows after all points are drawn.
pub fn splat(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let [width, height] = settings.size;
    let clip = ClipPlanes::of(camera);
    let mut shown: Vec<Option<Point>> = vec![None; width as usize * height as usize];
    for view in &views.views {
        for (number, face) in view.view.faces.iter().enumerate() {
            let (Some(face), Some(number)) = (face, Face::from_index(number as u8)) else { continue };
            monitor.check()?;
            let image = Image { view, face, number, clip };
            let row = |row: u32| -> Vec<_> {
                (0..face.size[0]).filter_map(|column| image.point([column, row], camera, settings)).collect()
            };
            // Points are projected in parallel and depth-tested in order.
            let rows: Vec<Vec<(usize, Point)>> = (0..face.size[1]).into_par_iter().map(row).collect();
            for (at, point) in rows.into_iter().flatten() {
                let nearer = |held: Point| point.distance_m < held.distance_m;
                if shown[at].is_none_or(nearer) {
                    shown[at] = Some(point);
                }
            }
        }
    }
    monitor.advance(height.into());
    let counters = Counters {
        primary_rays: shown.len() as u64,
        hole_rays: shown.iter().filter(|point| point.is_none()).count() as u64,
        background_rays: shown.iter().flatten().filter(|point| point.distance_m.is_infinite()).count() as u64,
        ..Counters::default()
    };
    let is_transparent = settings.background == BackgroundFill::Transparent;
    let is_shown = |point: &Point| !is_transparent || point.distance_m.is_finite();
    let alpha_of = |shown: &[Option<Point>]| -> Vec<f32> {
        shown.iter().map(|point| f32::from(u8::from(point.as_ref().is_some_and(is_shown)))).collect()
    };
    let unfilled = alpha_of(&shown);
    if settings.holes != HoleFill::Blank {
        fill(&mut shown, settings.size);
    }
    let alpha = if settings.holes == HoleFill::Behind { alpha_of(&shown) } else { unfilled };
    let light =
        |point: Option<Point>| point.filter(is_shown).map_or(Vec3::ZERO, |point| light_of(views.coding, point.color));
    let pixels = shown.into_iter().zip(alpha).map(|(point, alpha)| light(point).extend(alpha).to_array());
    Ok(Rendered { image: RenderedImage::of_pixels(settings.size, pixels)?, counters })
}

struct Image<'a> {
    view: &'a ActiveView<'a>,
    face: &'a FaceTexels,
    number: Face,
    clip: Option<ClipPlanes>,
}

impl Image<'_> {
    /// Returns the pixel index and the point of a texel. None if the point is outside the image, the range of distances or the
    /// clip planes, and for unknown and transparent texels.
    fn point(&self, [column, row]: [u32; 2], camera: &Camera, settings: &RenderSettings) -> Option<(usize, Point)> {
        let Image { view, face, number, clip } = self;
        let texel = row as usize * face.size[0] as usize + column as usize;
        let inverse_depth = face.inverse_depth[texel];
        if inverse_depth == UNKNOWN || face.alpha(texel) < MIN_ALPHA {
            return None;
        }
        let centre = [column, row].map(|at| at as f32 + 0.5);
        let direction = view.probe_from_world.transpose() * face.map.direction(*number, centre);
        let (from_eye, distance_m) = if inverse_depth == BACKGROUND {
            (direction, f32::INFINITY)
        } else {
            let from_eye = view.from_eye + direction / inverse_depth;
            let distance_m = from_eye.length();
            let distances_m = &settings.steps.distances_m;
            if !(*distances_m.first()?..=*distances_m.last()?).contains(&distance_m) {
                return None;
            }
            (from_eye, distance_m)
        };
        let ([x, y], depth_m) = camera.project(DVec3::from(from_eye))?;
        if distance_m.is_finite() && clip.is_some_and(|clip| !clip.contains(depth_m as f32)) {
            return None;
        }
        let pixel = |at: f64, size: u32| {
            let at = (at * f64::from(size)).floor();
            (at >= 0.0 && at < f64::from(size)).then_some(at as usize)
        };
        let at = pixel(y, settings.size[1])? * settings.size[0] as usize + pixel(x, settings.size[0])?;
        Some((at, Point { distance_m, color: face.color.get(texel) }))
    }
}

/// Fills holes from adjacent pixels, breadth first.
fn fill(shown: &mut [Option<Point>], [width, height]: [u32; 2]) {
    let (width, height) = (width as usize, height as usize);
    let mut border: Vec<usize> = (0..shown.len()).filter(|&at| shown[at].is_some()).collect();
    while !border.is_empty() {
        let mut next = Vec::new();
        for at in border {
            let (x, y) = (at % width, at / width);
            for (x, y) in [(x, y.wrapping_sub(1)), (x.wrapping_sub(1), y), (x + 1, y), (x, y + 1)] {
                let beside = y.wrapping_mul(width).wrapping_add(x);
                if x < width && y < height && shown[beside].is_none() {
                    shown[beside] = shown[at];
                    next.push(beside);
                }
            }
        }
        border = next;
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::march::ray::Steps;
    use crate::march::settings::{Acceleration, Refinements, SpecularMode};
    use crate::march::synthetic::set_alpha;
    use crate::views::light_field::{ColorCoding, ColorTexels, LightField, View};
    use codec::image::transfer::{ToneMap, Transfer};
    use codec::math::Lens;
    use codec::monitor::Silent;

    const CODING: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Linear, exposure_ev: 0.0 });

    /// A perspective view of three texels that looks along −Z with a horizontal field of view of 90 degrees.
    fn view(position: DVec3, inverse_depth: [f32; 3], gray: [u8; 3]) -> View {
        let map = codec::image::TexelMap { scale: [1.5, 1.5], centre: [1.5, 0.5] };
        let mut face = FaceTexels::unknown([3, 1], map, CODING);
        face.inverse_depth = inverse_depth.to_vec();
        face.color = ColorTexels::Codes(gray.map(|code| [code, code, code, 0]).to_vec());
        let faces = [None, None, None, None, None, None, Some(face)];
        let (near_m, far_m) = (0.1, 100.0);
        View { name: "a".into(), probe: 0, position, probe_from_world: DMat3::IDENTITY, near_m, far_m, faces }
    }

    /// Returns the codes and alpha of an image rendered from the origin with the same field of view.
    fn shown(views: Vec<View>, holes: HoleFill) -> (Vec<u8>, Vec<f32>) {
        shown_between(views, holes, [0.0, f64::INFINITY])
    }

    /// Like [`shown`], with near and far planes of the camera.
    fn shown_between(views: Vec<View>, holes: HoleFill, range_m: [f64; 2]) -> (Vec<u8>, Vec<f32>) {
        let field = LightField { views, coding: CODING };
        let all: Vec<usize> = (0..field.views.len()).collect();
        let active = ActiveViews::new(&field, &all, DVec3::ZERO);
        let lens = Lens { aspect: 3.0, ..Lens::new(2.0 * (1f64 / 3.0).atan().to_degrees()) };
        let lens = Lens { near_m: range_m[0], far_m: range_m[1], ..lens };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        let settings = RenderSettings {
            size: [3, 1],
            steps: Steps::new(4, 0.5, 50.0, 0),
            samples: 1,
            holes,
            background: BackgroundFill::Opaque,
            specular: SpecularMode::None,
            max_bounces: 0,
            acceleration: Acceleration::None,
            refinements: Refinements::NONE,
        };
        let rendered = splat(&active, &camera, &settings, &Silent).unwrap();
        let codes = rendered.image.color.data().iter().map(|[light, ..]| (light * 255.0).round() as u8).collect();
        let holes = rendered.image.alpha.data().iter().filter(|alpha| **alpha == 0.0).count() as u64;
        assert_eq!((rendered.counters.hole_rays, rendered.counters.primary_rays), (holes, 3));
        (codes, rendered.image.alpha.data().to_vec())
    }

    #[test]
    fn the_nearest_point_wins_whatever_the_order() {
        let [near, far] = [view(DVec3::ZERO, [0.5; 3], [10, 20, 30]), view(DVec3::ZERO, [0.25; 3], [40, 50, 60])];
        for views in [vec![near.clone(), far.clone()], vec![far.clone(), near]] {
            assert_eq!(shown(views, HoleFill::Blank), (vec![10, 20, 30], vec![1.0; 3]));
        }
        // At equal distances the first point wins.
        let views = vec![far.clone(), view(DVec3::ZERO, [0.25; 3], [1, 2, 3])];
        assert_eq!(shown(views, HoleFill::Blank).0, [40, 50, 60]);
        // A texel with an alpha below a half is skipped.
        let mut glass = view(DVec3::ZERO, [0.5; 3], [10, 20, 30]);
        let mut alpha = [127, 128, 255].into_iter();
        set_alpha(&mut glass, |_, _| alpha.next().unwrap());
        assert_eq!(shown(vec![glass, far.clone()], HoleFill::Blank), (vec![40, 20, 30], vec![1.0; 3]));
        // Background is behind all surfaces, even if its view comes first.
        let views =
            vec![view(DVec3::ZERO, [BACKGROUND; 3], [7, 8, 9]), view(DVec3::ZERO, [0.25, UNKNOWN, 0.25], [40, 50, 60])];
        assert_eq!(shown(views, HoleFill::Blank).0, [40, 8, 60]);
    }

    #[test]
    fn planes_of_the_camera_leave_points_out_and_no_background() {
        let views = || {
            let near = view(DVec3::ZERO, [0.5, BACKGROUND, 0.5], [10, 20, 30]);
            vec![near, view(DVec3::ZERO, [0.25; 3], [40, 50, 60])]
        };
        assert_eq!(shown_between(views(), HoleFill::Blank, [1.9, 5.0]).0, [10, 50, 30]);
        assert_eq!(shown_between(views(), HoleFill::Blank, [2.1, 5.0]).0, [40, 50, 60]);
        assert_eq!(shown_between(views(), HoleFill::Blank, [0.0, 3.9]).0, [10, 20, 30]);
        assert_eq!(shown_between(views(), HoleFill::Blank, [2.1, 3.9]), (vec![0, 20, 0], vec![0.0, 1.0, 0.0]));
    }

    #[test]
    fn points_move_by_their_depth_and_leave_holes() {
        // Moving the view 2/3 m to the right moves a point by one pixel at depth 1, and by a quarter of a pixel at depth 4.
        let moved = |inverse: f32| vec![view(DVec3::new(2.0 / 3.0, 0.0, 0.0), [inverse; 3], [10, 20, 30])];
        assert_eq!(shown(moved(1.0), HoleFill::Blank), (vec![0, 10, 20], vec![0.0, 1.0, 1.0]));
        assert_eq!(shown(moved(1.0), HoleFill::Nearest), (vec![10, 10, 20], vec![0.0, 1.0, 1.0]));
        assert_eq!(shown(moved(0.25), HoleFill::Blank).0, [10, 20, 30]);
        // Points nearer than the first step, farther than the last one, and behind the eye.
        let near = vec![view(DVec3::ZERO, [4.0; 3], [10, 20, 30])];
        assert_eq!(shown(near, HoleFill::Nearest), (vec![0; 3], vec![0.0; 3]));
        assert_eq!(shown(moved(0.01), HoleFill::Blank).1, [0.0; 3]);
        let behind = vec![view(DVec3::new(0.0, 0.0, 5.0), [0.5; 3], [10, 20, 30])];
        assert_eq!(shown(behind, HoleFill::Blank).1, [0.0; 3]);
    }
}
