//! Samples of a capture (Seurat 3): rays from inside the viewing region, with the surface that each meets and its light.
//!
//! Enters: the images of a dataset, one at a time. Leaves: samples relative to the middle of the region.

use glam::DVec3;

use super::region::ViewingRegion;
use crate::error::{Error, Result};
use crate::evaluate::reference::Reference;

/// A ray: its origin and where it ends, relative to the middle of the region in metres, and linear light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    pub origin: DVec3,
    pub end: DVec3,
    pub color: [f32; 3],
}

/// The images of one frame of a dataset.
#[derive(Debug)]
pub struct Capture<'a> {
    pub reference: &'a mut Reference,
    /// Indices of its images that have the frame.
    pub images: Vec<usize>,
    pub frame: u32,
}

impl<'a> Capture<'a> {
    pub fn new(reference: &'a mut Reference, frame: u32) -> Result<Capture<'a>> {
        let all = reference.images.iter().enumerate();
        let images: Vec<usize> = all.filter(|(_, image)| image.frames.contains(frame)).map(|(at, _)| at).collect();
        match images.is_empty() {
            true => Err(Error::Usage(format!("there is no image of frame {frame}"))),
            false => Ok(Capture { reference, images, frame }),
        }
    }

    /// Centres of all images' cameras, in metres.
    pub fn eyes(&self) -> impl Iterator<Item = DVec3> {
        self.images.iter().map(|&image| self.reference.images[image].camera.eye())
    }

    /// Pixels of an image along a unit of the plane at distance 1 from its camera: the most of all images.
    pub fn pixels_per_unit(&self) -> f64 {
        let of = |&image: &usize| {
            let image = &self.reference.images[image];
            f64::from(image.size[1]) / (2.0 * image.camera.half()[1])
        };
        self.images.iter().map(of).fold(1.0, f64::max)
    }

    /// Metres to the nearest sample of all images, `+inf` where all show the sky.
    pub fn nearest_m(&mut self) -> Result<f64> {
        let mut nearest = f64::INFINITY;
        for image in self.images.clone() {
            let distances = self.reference.distance_m(image, self.frame)?.ok_or_else(no_depth)?;
            nearest = distances.data().iter().copied().map(f64::from).fold(nearest, f64::min);
        }
        Ok(nearest)
    }

    /// The samples of one image, row by row. Those of the sky lie on a cube around the region. A sample in the region is an
    /// error that names the pixel.
    pub fn samples(&mut self, image: usize, region: &ViewingRegion) -> Result<Vec<Sample>> {
        let (camera, [width, height]) = (self.reference.images[image].camera, self.reference.images[image].size);
        let truth = self.reference.truth(image, self.frame)?;
        let distances = self.reference.distance_m(image, self.frame)?.ok_or_else(no_depth)?;
        let origin = camera.eye() - region.middle;
        let mut samples = Vec::with_capacity(distances.data().len());
        for row in 0..height {
            for column in 0..width {
                let centre = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                let direction = camera.direction([centre[0] / f64::from(width), centre[1] / f64::from(height)]);
                let metres = f64::from(distances.get(column, row)).min(region.to_sky(origin, direction));
                let end = origin + metres * direction;
                if region.contains(end) {
                    let named = &self.reference.images[image];
                    return Err(Error::Usage(format!(
                        "probe {}, {}, frame {}, pixel ({column}, {row}): a surface at {metres:.3} m lies in the viewing \
                         region; give a smaller `region`, without surfaces in it",
                        named.probe,
                        named.face.name(),
                        self.frame
                    )));
                }
                let color = truth.color.get(column, row).map(|light| light.to_f32());
                samples.push(Sample { origin, end, color });
            }
        }
        Ok(samples)
    }
}

fn no_depth() -> Error {
    Error::Usage("an image has no depth: simplification needs colour and depth of each".into())
}
