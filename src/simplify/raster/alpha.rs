//! Rasteriser of alpha alone: how far each pixel is covered.

use rayon::prelude::*;

use super::texels::Texels;
use super::{Compositing, DrawSettings, ROWS_A_JOB, Raster};
use crate::quad_mesh::QuadMesh;
use codec::math::Camera;

/// Centre of a pixel.
const MIDDLE: [f64; 2] = [0.5; 2];

/// Alpha of a picture, which is drawn again as texels become opaque.
pub struct AlphaRaster {
    raster: Raster,
    alpha: Vec<f32>,
}

impl AlphaRaster {
    /// Creates a picture without triangles: all pixels are transparent.
    pub fn new(scene: &QuadMesh, camera: &Camera, size: [u32; 2]) -> AlphaRaster {
        let settings = DrawSettings { size, compositing: Compositing::Painter, samples: 1 };
        let raster = Raster::new(scene, camera, &settings);
        AlphaRaster { raster, alpha: vec![0.0; size[0] as usize * size[1] as usize] }
    }

    /// Returns the alpha of all pixels, in row-major order. It equals that of [`super::draw`] where that is below `enough`, which
    /// is below 1, and is at least `enough` elsewhere. Rows that had enough before are not drawn again, so texels of the scene
    /// may only have become less transparent.
    pub fn draw(&mut self, scene: &QuadMesh, enough: f32) -> &[f32] {
        let (texels, raster) = (Texels::new(scene), &self.raster);
        let pixels_a_job = (raster.settings.size[0] * ROWS_A_JOB).max(1) as usize;
        let jobs = self.alpha.par_chunks_mut(pixels_a_job).enumerate();
        jobs.for_each(|(job, alpha)| raster.cover(job, &texels, enough, alpha));
        &self.alpha
    }
}

impl Raster {
    /// Draws the alpha of the rows of a job, except for rows that have `enough`.
    fn cover(&self, job: usize, texels: &Texels, enough: f32, alpha: &mut [f32]) {
        let ([first, end], width) = (self.rows_of(job), self.settings.size[0]);
        // Returns the number of pixels to draw in a row, 0 if all have `enough`.
        let open_pixels = |row: &mut [f32]| {
            let is_left = row.iter().all(|alpha| *alpha >= enough);
            if !is_left {
                row.fill(0.0);
            }
            if is_left { 0 } else { row.len() }
        };
        let mut open: Vec<usize> = alpha.chunks_exact_mut(width as usize).map(open_pixels).collect();
        for &at in self.of_job[job].iter().rev() {
            let triangle = &self.triangles[at as usize];
            for row in triangle.rows[0].max(first)..triangle.rows[1].min(end) {
                let of_job = (row - first) as usize;
                if open[of_job] == 0 {
                    continue;
                }
                let span = triangle.span(row, width, MIDDLE);
                let [s, t, q] = triangle.stq.map(|axis| axis.row(f64::from(row) + MIDDLE[1]));
                let pixels = &mut alpha[of_job * width as usize..][span.start as usize..span.end as usize];
                for (x, alpha) in span.zip(pixels).filter(|(_, alpha)| **alpha < enough) {
                    let x = f64::from(x) + MIDDLE[0];
                    let texel = if triangle.is_opaque {
                        1.0
                    } else {
                        let scale = 1.0 / q.at(x);
                        texels.alpha([s.at(x) * scale, t.at(x) * scale])
                    };
                    *alpha += (1.0 - *alpha) * texel;
                    open[of_job] -= usize::from(*alpha >= enough);
                }
            }
        }
    }
}
