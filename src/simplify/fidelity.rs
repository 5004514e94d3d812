//! Comparison of pictures of the simplified scene with those of the capture (Seurat 7).

use std::time::Duration;

use glam::DVec3;
use half::f16;
use rayon::prelude::*;

use super::capture::{Capture, CaptureImage, ImageRays};
use super::cracks::{CRACK_ALPHA, OPAQUE_ALPHA, covered};
use super::gaps::SeenDirections;
use super::memory;
use super::quad_mesh::QuadMesh;
use super::raster::{Drawn, draw};
use super::region::ViewingRegion;
use super::samples::Background;
use super::settings::Settings;
use codec::error::Result;
use codec::image::{ColorPlane, Plane, ToneMap};
use codec::math::random::Random;
use codec::math::{Camera, Lens};
use codec::metrics::{SquaredError, U8_PEAK};
use codec::monitor::Monitor;
use evaluate::reference::Truth;
use evaluate::similarity::{Similarity, truth_codes};
use render::rendered_image::RenderedImage;

/// Decibels that the released evaluator added to the PSNR: 10 log10 255.
const RELEASED_OFFSET_DB: f64 = 24.065_401_804_339_55;

/// Number of pictures from random poses, and their side in pixels.
const POSES: u32 = 64;
const POSE_SIDE: u32 = 256;
/// Maximum number of random positions tried for each pose.
const TRIES: u32 = 10_000;

/// Comparison of a scene with its capture.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation {
    pub fidelity: Fidelity,
    pub poses: PoseScore,
    pub duration: Duration,
}

/// Measures over all pictures.
#[derive(Debug, Clone, Copy)]
pub struct Fidelity {
    pub similarity: Similarity,
    /// Error of the opaque pixels. The released evaluator left out the others.
    opaque: SquaredError,
    pub pixels: u64,
    /// Number of triangles drawn over pixels.
    pub fragments: u64,
    pub fragments_per_pixel_max: u32,
    /// Maximum over all pictures of the mean number of triangles per pixel.
    pub peak_overdraw: f64,
    pub crack_pixels: u64,
    pub translucent_pixels: u64,
}

impl Default for Fidelity {
    fn default() -> Fidelity {
        Fidelity {
            similarity: Similarity::empty(),
            opaque: SquaredError::empty(U8_PEAK),
            pixels: 0,
            fragments: 0,
            fragments_per_pixel_max: 0,
            peak_overdraw: 0.0,
            crack_pixels: 0,
            translucent_pixels: 0,
        }
    }
}

impl Fidelity {
    /// Draws the scene from the camera of a captured image, and adds the differences. Images without a camera are skipped.
    fn add(&mut self, scene: &QuadMesh, image: &CaptureImage, rays: &ImageRays, background: Background) -> Result<()> {
        let Some(compared) = Compared::new(scene, image, rays, background)? else { return Ok(()) };
        let Compared { similarity, shown, wanted, surfaces, drawn, overdraw } = compared;
        let Drawn { pixels, fragments, max_fragments } = drawn;
        self.similarity.merge(&similarity)?;
        let opaque = || pixels.iter().enumerate().filter(|(_, pixel)| pixel[3] >= OPAQUE_ALPHA).map(|(at, _)| at);
        let of = |codes: &[[u8; 3]]| opaque().flat_map(|at| codes[at]).collect::<Vec<u8>>();
        self.opaque.merge(&SquaredError::of_u8(&of(shown.data()), &of(wanted.data()))?)?;
        self.pixels += pixels.len() as u64;
        self.fragments += fragments;
        self.fragments_per_pixel_max = self.fragments_per_pixel_max.max(max_fragments);
        self.peak_overdraw = self.peak_overdraw.max(overdraw);
        let below =
            |alpha: f32| pixels.iter().zip(&surfaces).filter(|(pixel, is)| **is && pixel[3] < alpha).count() as u64;
        self.crack_pixels += below(CRACK_ALPHA);
        self.translucent_pixels += below(OPAQUE_ALPHA);
        Ok(())
    }

    fn merge(&mut self, other: &Fidelity) -> Result<()> {
        self.similarity.merge(&other.similarity)?;
        self.opaque.merge(&other.opaque)?;
        self.pixels += other.pixels;
        self.fragments += other.fragments;
        self.fragments_per_pixel_max = self.fragments_per_pixel_max.max(other.fragments_per_pixel_max);
        self.peak_overdraw = self.peak_overdraw.max(other.peak_overdraw);
        self.crack_pixels += other.crack_pixels;
        self.translucent_pixels += other.translucent_pixels;
        Ok(())
    }

    /// Returns the PSNR that the released evaluator would have printed, in decibels.
    pub fn released_psnr_db(&self) -> f64 {
        self.opaque.psnr_db() + RELEASED_OFFSET_DB
    }

    pub fn overdraw_mean(&self) -> f64 {
        self.fragments as f64 / self.pixels.max(1) as f64
    }
}

/// A picture of the scene, compared with an image of a capture.
#[derive(Debug)]
pub struct Compared {
    pub similarity: Similarity,
    /// Display codes of the picture and of the image.
    pub shown: Plane<[u8; 3]>,
    pub wanted: Plane<[u8; 3]>,
    /// For each pixel of the image, true if it shows a surface.
    surfaces: Vec<bool>,
    drawn: Drawn,
    /// Mean number of triangles per pixel.
    pub overdraw: f64,
}

impl Compared {
    /// Draws the scene from the camera of a captured image; `None` if the image has no camera.
    pub fn new(
        scene: &QuadMesh,
        image: &CaptureImage,
        rays: &ImageRays,
        background: Background,
    ) -> Result<Option<Compared>> {
        let CaptureImage { camera: Some(camera), size, .. } = *image else { return Ok(None) };
        let (truth, surfaces) = truth(rays, size, background);
        let drawn = draw(scene, &camera, size);
        // Holes are black.
        let rendered = RenderedImage::of_pixels(size, drawn.pixels.iter().copied())?;
        let tone = ToneMap::default();
        let (shown, wanted) = (rendered.codes(tone), truth_codes(&truth, tone));
        Ok(Some(Compared {
            similarity: Similarity::of_codes([&shown, &wanted], &rendered.alpha, None)?,
            shown,
            wanted,
            surfaces,
            overdraw: drawn.fragments as f64 / drawn.pixels.len().max(1) as f64,
            drawn,
        }))
    }
}

/// Compares pictures of the scene with all images of a capture.
pub fn compare(
    scene: &QuadMesh,
    capture: &mut Capture,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Fidelity> {
    let mut fidelity = Fidelity::default();
    let texels = scene.texture.pixels.len() as u64;
    let at_once = memory::compared_at_once(capture, texels, settings.memory)?;
    let mut read = |first: usize| -> Result<Vec<(CaptureImage, ImageRays)>> {
        let images = first..(first + at_once).min(capture.images.len());
        images.map(|image| Ok((capture.images[image].clone(), capture.rays(image)?))).collect()
    };
    let one = |(image, rays): &(CaptureImage, ImageRays)| {
        monitor.advance(1);
        let mut fidelity = Fidelity::default();
        fidelity.add(scene, image, rays, settings.background)?;
        Ok(fidelity)
    };
    let (mut first, mut next) = (0, read(0)?);
    while !next.is_empty() {
        monitor.check()?;
        first += next.len();
        // The next images are read in parallel.
        let compare = || next.par_iter().map(one).collect::<Result<Vec<Fidelity>>>();
        let (compared, following) = rayon::join(compare, || read(first));
        for found in compared? {
            fidelity.merge(&found)?;
        }
        next = following?;
    }
    Ok(fidelity)
}

/// Cracks and holes in pictures from random poses in the viewing region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PoseScore {
    pub poses: u32,
    /// Number of pixels in whose direction the capture has a surface, as seen from the centre of the region.
    pub pixels: u64,
    /// Number of these pixels whose alpha is below one half.
    pub crack_pixels: u64,
}

/// Draws the scene from random poses in the region, and counts cracks.
pub fn random_poses(scene: &QuadMesh, region: &ViewingRegion, seen: &SeenDirections) -> Result<PoseScore> {
    let mut random = Random::new(0);
    let mut unit = || f64::from(random.word()) / f64::from(u32::MAX) * 2.0 - 1.0;
    let mut vector = || DVec3::new(unit(), unit(), unit());
    let mut score = PoseScore::default();
    let size = [POSE_SIDE; 2];
    for _ in 0..POSES {
        // If the region is a small part of its box, no position may be found.
        let eyes = (0..TRIES).map(|_| vector() * region.half);
        let Some(eye) = eyes.into_iter().find(|&eye| region.admits(eye)) else { break };
        let eye = region.middle + eye;
        let mut forward = vector();
        while forward.length_squared() > 1.0 || forward.x == 0.0 {
            forward = vector();
        }
        // The camera cannot be created if the eye is so far away that adjacent floats are metres apart.
        let Ok(camera) = Camera::look_at(eye, eye + forward, DVec3::Y, Lens::new(90.0)) else { break };
        score.poses += 1;
        for (at, is_covered) in (0..).zip(covered(scene, &camera, size, CRACK_ALPHA)) {
            let centre = [at % POSE_SIDE, at / POSE_SIDE].map(|at| (f64::from(at) + 0.5) / f64::from(POSE_SIDE));
            if seen.contains(camera.direction(centre)) {
                score.pixels += 1;
                score.crack_pixels += u64::from(!is_covered);
            }
        }
    }
    Ok(score)
}

/// Returns the picture of rays, black where there is no ray, and true for each pixel that shows a surface.
fn truth(rays: &ImageRays, [width, height]: [u32; 2], background: Background) -> (Truth, Vec<bool>) {
    let mut color = ColorPlane::filled(width, height, [f16::ZERO; 3]);
    let mut surfaces = vec![false; (width * height) as usize];
    for ray in rays.iter() {
        if background == Background::Sky || ray.distance_m.is_finite() {
            let at = (ray.pixel[1] * width + ray.pixel[0]) as usize;
            color.data_mut()[at] = ray.light.map(f16::from_f32);
            surfaces[at] = true;
        }
    }
    (Truth { color, material: None }, surfaces)
}
