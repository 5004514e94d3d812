//! Pictures of the simplified scene beside those of the capture (Seurat 7).

use super::cracks::CRACK_ALPHA;
use super::quad_mesh::QuadMesh;
use super::raster::{Drawn, draw};
use crate::error::Result;
use crate::evaluate::RenderedImage;
use crate::evaluate::reference::Reference;
use crate::evaluate::similarity::{Similarity, truth_codes};
use crate::image::ToneMap;
use crate::metrics::{SquaredError, U8_PEAK};

/// Alpha below which the released evaluator left a pixel out.
const OPAQUE_ALPHA: f32 = 1.0 - 0.5 / 255.0;
/// What it added to the PSNR: 10 log10 255.
const RELEASED_OFFSET_DB: f64 = 24.065_401_804_339_55;

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
    /// Draws the scene as an image of a capture was taken, and adds what differs.
    pub fn add(&mut self, scene: &QuadMesh, reference: &mut Reference, image: usize, frame: u32) -> Result<()> {
        let (camera, size) = (reference.images[image].camera, reference.images[image].size);
        let truth = reference.truth(image, frame)?;
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
        self.crack_pixels += pixels.iter().filter(|pixel| pixel[3] < CRACK_ALPHA).count() as u64;
        self.translucent_pixels += pixels.iter().filter(|pixel| pixel[3] < OPAQUE_ALPHA).count() as u64;
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
