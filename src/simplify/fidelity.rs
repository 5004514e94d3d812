//! Pictures of the simplified scene beside those of the capture (Seurat 7).

use glam::DVec3;
use half::f16;

use super::capture::{Capture, CaptureImage};
use super::cracks::CRACK_ALPHA;
use super::points::MergedPoint;
use super::quad_mesh::QuadMesh;
use super::raster::{Drawn, draw};
use super::region::ViewingRegion;
use super::samples::Background;
use super::tree::TreeCell;
use crate::dataset::seurat::CaptureRay;
use crate::error::Result;
use crate::evaluate::RenderedImage;
use crate::evaluate::reference::Truth;
use crate::evaluate::similarity::{Similarity, truth_codes};
use crate::image::{ColorPlane, ToneMap};
use crate::math::random::Random;
use crate::math::{Camera, Lens};
use crate::metrics::{SquaredError, U8_PEAK};
use crate::monitor::Monitor;

/// Alpha below which the released evaluator left a pixel out.
const OPAQUE_ALPHA: f32 = 1.0 - 0.5 / 255.0;
/// What it added to the PSNR: 10 log10 255.
const RELEASED_OFFSET_DB: f64 = 24.065_401_804_339_55;

/// Pictures of random poses, and their side in pixels.
const POSES: u32 = 64;
const POSE_SIDE: u32 = 256;
/// Squares of a cube face's side within which a capture saw something or not.
const SEEN_LEVEL: u32 = 5;

/// Figures of all pictures.
#[derive(Debug, Clone, Copy)]
pub struct Fidelity {
    pub similarity: Similarity,
    /// Error of the pixels that are opaque.
    opaque: SquaredError,
    pub pixels: u64,
    /// Triangles that were drawn over pixels.
    pub fragments: u64,
    pub fragments_per_pixel_max: u32,
    /// Largest mean of triangles a pixel of a picture.
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
    /// Draws the scene as an image of a capture was taken, and adds what differs. Images without a camera are left out.
    fn add(&mut self, scene: &QuadMesh, capture: &mut Capture, image: usize, background: Background) -> Result<()> {
        let CaptureImage { camera: Some(camera), size, .. } = capture.images[image] else { return Ok(()) };
        let (truth, surfaces) = truth(&capture.rays(image)?, size, background);
        let Drawn { pixels, fragments, most_fragments } = draw(scene, &camera, size);
        // Holes are black.
        let rendered = RenderedImage::of_pixels(size, pixels.iter().copied())?;
        self.similarity.merge(&Similarity::of(&rendered, &truth, ToneMap::default())?)?;
        let [shown, wanted] = [rendered.codes(ToneMap::default()), truth_codes(&truth, ToneMap::default())];
        let opaque = || pixels.iter().enumerate().filter(|(_, pixel)| pixel[3] >= OPAQUE_ALPHA).map(|(at, _)| at);
        let of = |codes: &[[u8; 3]]| opaque().flat_map(|at| codes[at]).collect::<Vec<u8>>();
        self.opaque.merge(&SquaredError::of_u8(&of(shown.data()), &of(wanted.data()))?)?;
        self.pixels += pixels.len() as u64;
        self.fragments += fragments;
        self.fragments_per_pixel_max = self.fragments_per_pixel_max.max(most_fragments);
        self.peak_overdraw = self.peak_overdraw.max(fragments as f64 / pixels.len().max(1) as f64);
        let below =
            |alpha: f32| pixels.iter().zip(&surfaces).filter(|(pixel, is)| **is && pixel[3] < alpha).count() as u64;
        self.crack_pixels += below(CRACK_ALPHA);
        self.translucent_pixels += below(OPAQUE_ALPHA);
        Ok(())
    }

    /// What the released evaluator would have printed.
    pub fn released_psnr_db(&self) -> f64 {
        self.opaque.psnr_db() + RELEASED_OFFSET_DB
    }

    pub fn overdraw_mean(&self) -> f64 {
        self.fragments as f64 / self.pixels.max(1) as f64
    }
}

/// Compares pictures of the scene with all images of a capture.
pub fn compare(
    scene: &QuadMesh,
    capture: &mut Capture,
    background: Background,
    monitor: &dyn Monitor,
) -> Result<Fidelity> {
    let mut fidelity = Fidelity::default();
    for image in 0..capture.images.len() {
        monitor.check()?;
        fidelity.add(scene, capture, image, background)?;
        monitor.advance(1);
    }
    Ok(fidelity)
}

/// Cracks and holes in pictures from random poses in the viewing region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PoseScore {
    pub poses: u32,
    /// Pixels in whose direction the capture has a surface, seen from the middle of the region.
    pub pixels: u64,
    /// Of those, the ones of less than half alpha.
    pub crack_pixels: u64,
}

/// The directions from the middle of the region in which a capture has surfaces.
#[derive(Debug)]
pub struct SeenDirections(Vec<bool>);

impl SeenDirections {
    pub fn new(points: &[MergedPoint]) -> SeenDirections {
        let mut seen = vec![false; TreeCell::count(SEEN_LEVEL)];
        for point in points {
            seen[TreeCell::containing(point.position.as_dvec3(), SEEN_LEVEL).index()] = true;
        }
        SeenDirections(seen)
    }

    fn contains(&self, direction: DVec3) -> bool {
        self.0[TreeCell::containing(direction, SEEN_LEVEL).index()]
    }
}

/// Draws the scene from random poses in the region.
pub fn random_poses(scene: &QuadMesh, region: &ViewingRegion, seen: &SeenDirections) -> Result<PoseScore> {
    let mut random = Random::new(0);
    let mut unit = || f64::from(random.word()) / f64::from(u32::MAX) * 2.0 - 1.0;
    let mut vector = || DVec3::new(unit(), unit(), unit());
    let mut score = PoseScore { poses: POSES, ..PoseScore::default() };
    let size = [POSE_SIDE; 2];
    for _ in 0..POSES {
        let mut eye = vector() * region.half;
        while !region.contains(eye) {
            eye = vector() * region.half;
        }
        let eye = region.middle + eye;
        let mut forward = vector();
        while forward.length_squared() > 1.0 || forward.x == 0.0 {
            forward = vector();
        }
        let camera = Camera::look_at(eye, eye + forward, DVec3::Y, Lens::new(90.0))?;
        let drawn = draw(scene, &camera, size);
        for (at, pixel) in (0..).zip(&drawn.pixels) {
            let centre = [at % POSE_SIDE, at / POSE_SIDE].map(|at| (f64::from(at) + 0.5) / f64::from(POSE_SIDE));
            if seen.contains(camera.direction(centre)) {
                score.pixels += 1;
                score.crack_pixels += u64::from(pixel[3] < CRACK_ALPHA);
            }
        }
    }
    Ok(score)
}

/// The picture of rays, black where there is none, and whether each pixel shows a surface.
fn truth(rays: &[CaptureRay], [width, height]: [u32; 2], background: Background) -> (Truth, Vec<bool>) {
    let mut color = ColorPlane::filled(width, height, [f16::ZERO; 3]);
    let mut surfaces = vec![false; (width * height) as usize];
    for ray in rays {
        if background == Background::Sky || ray.distance_m.is_finite() {
            let at = (ray.pixel[1] * width + ray.pixel[0]) as usize;
            color.data_mut()[at] = ray.light.map(f16::from_f32);
            surfaces[at] = true;
        }
    }
    (Truth { color, material: None }, surfaces)
}
