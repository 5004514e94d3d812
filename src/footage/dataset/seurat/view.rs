//! A view of a Seurat capture: the images of one camera, read as rays.

use std::array::from_fn;
use std::path::{Path, PathBuf};

use glam::DVec3;
use half::f16;

use super::camera::SeuratCamera;
use crate::dataset::pixels::pixel;
use crate::image_files::{exr, png};
use codec::error::{Error, Result};
use codec::image::transfer::srgb16;
use codec::image::{Plane, ReadLimits};
use codec::math::Camera;

/// Channel names of PNG files.
const PNG_CHANNELS: [&str; 4] = ["R", "G", "B", "A"];
const PNG_ALPHA: usize = 3;

/// Ray of a pixel that is a sample, with the surface that it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaptureRay {
    /// Column and row; row 0 is at the top.
    pub pixel: [u32; 2],
    /// Origin in metres.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Distance from the origin to the surface, positive; +inf if infinitely far.
    pub distance_m: f64,
    /// Linear RGB, finite, with half-float precision.
    pub light: [f32; 3],
    /// Alpha, above 0 and at most 1.
    pub alpha: f32,
}

/// Source of the values of a channel.
#[derive(Debug, Clone, PartialEq)]
pub enum Channel {
    /// One value for all pixels.
    Constant(f32),
    /// The channel with this name in the file.
    Named(String),
}

impl Channel {
    pub fn name(&self) -> Option<&str> {
        match self {
            Channel::Constant(_) => None,
            Channel::Named(name) => Some(name),
        }
    }
}

/// Channels of an image file.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageFile<const N: usize> {
    /// Path of the file; not read if all channels are constants.
    pub path: PathBuf,
    pub channels: [Channel; N],
}

impl<const N: usize> ImageFile<N> {
    fn is_read(&self) -> bool {
        self.channels.iter().any(|channel| channel.name().is_some())
    }
}

/// An image with depth, and its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct SeuratView {
    /// Index of the view group, and index of the view within it.
    pub place: [usize; 2],
    pub camera: SeuratCamera,
    /// Red, green, blue and alpha.
    pub color: ImageFile<4>,
    pub depth: ImageFile<1>,
}

impl SeuratView {
    /// Path of the view in the manifest.
    pub fn json_path(&self) -> String {
        let [group, view] = self.place;
        format!("view_groups[{group}].views[{view}]")
    }

    /// Width and height of the images in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.camera.size()
    }

    /// Returns the camera of a perspective image whose rows and columns are orthogonal.
    pub fn perspective(&self) -> Option<Camera> {
        self.camera.perspective()
    }

    /// Reads the image files. The size of a file is checked against the manifest before its pixels are read.
    pub fn image(&self, limits: &ReadLimits) -> Result<ViewImage<'_>> {
        if !self.color.is_read() && !self.depth.is_read() {
            return Err(Error::invalid(format!(
                "{}.depth_image_file: all channels are constants, at least one of a file was expected",
                self.json_path()
            )));
        }
        let slot = |channel, holds| Slot { channel, holds };
        let ([red, green, blue, alpha], [depth]) = (&self.color.channels, &self.depth.channels);
        let [red, green, blue] = [red, green, blue].map(|channel| slot(channel, Holds::Light));
        let [alpha, depth] = [alpha, depth].map(|channel| slot(channel, Holds::Number));
        let is_one_file = self.color.path == self.depth.path && self.color.is_read() && self.depth.is_read();
        let values = if is_one_file {
            Values::OfOneFile(self.read_file(&self.color.path, [red, green, blue, alpha, depth], limits)?)
        } else {
            let color = self.read_file(&self.color.path, [red, green, blue, alpha], limits)?;
            Values::OfTwoFiles(color, self.read_file(&self.depth.path, [depth], limits)?)
        };
        Ok(ViewImage { view: self, values })
    }

    /// Reads the rays of all samples, row by row.
    pub fn read(&self, limits: &ReadLimits) -> Result<Vec<CaptureRay>> {
        let image = self.image(limits)?;
        let mut rays = Vec::new();
        for row in 0..self.size()[1] {
            rays.extend(image.row(row)?);
        }
        Ok(rays)
    }

    fn read_file<const N: usize>(&self, path: &Path, slots: [Slot<'_>; N], limits: &ReadLimits) -> Result<Layers<N>> {
        let constants = slots.map(|slot| match slot.channel {
            Channel::Constant(value) => Some(*value),
            Channel::Named(_) => None,
        });
        let Some(any) = slots.iter().find_map(|slot| slot.channel.name()) else {
            return Ok(Layers { constants, pixels: None });
        };
        let read = || {
            let is_png = png::has_codes(path);
            let size = if is_png { png::read_size(path, limits) } else { exr::read_size(path, limits) }?;
            self.check_size(size)?;
            let pixels = if is_png {
                read_png(path, slots, limits)
            } else {
                // Slots of constants repeat a channel that is read anyway.
                exr::read_channels(path, slots.map(|slot| slot.channel.name().unwrap_or(any)), limits)
            }?;
            self.check_size((pixels.width(), pixels.height()))?;
            Ok(pixels)
        };
        let pixels = read().map_err(|error: Error| error.in_file(path).context(self.json_path()))?;
        Ok(Layers { constants, pixels: Some(pixels) })
    }

    fn check_size(&self, (width, height): (u32, u32)) -> Result<()> {
        let expected = self.size();
        if [width, height] == expected {
            return Ok(());
        }
        let [expected_width, expected_height] = expected;
        Err(Error::invalid(format!(
            "the image is {width}x{height} pixels, image_width and image_height are {expected_width} and {expected_height}"
        )))
    }
}

#[derive(Clone, Copy)]
enum Holds {
    Light,
    Number,
}

/// A per-pixel value and the channel that it is read from.
#[derive(Clone, Copy)]
struct Slot<'a> {
    channel: &'a Channel,
    holds: Holds,
}

/// Reads slots of a PNG file: linear RGB from sRGB codes, other values as fractions of the largest code.
fn read_png<const N: usize>(path: &Path, slots: [Slot<'_>; N], limits: &ReadLimits) -> Result<Plane<[f32; N]>> {
    let mut sources = [None; N];
    for (source, slot) in sources.iter_mut().zip(&slots) {
        let Some(name) = slot.channel.name() else { continue };
        let index = PNG_CHANNELS.iter().position(|channel| *channel == name);
        *source = Some(index.ok_or_else(|| {
            Error::invalid(format!("the channels of a PNG file are {}, there is no {name}", PNG_CHANNELS.join(", ")))
        })?);
    }
    let srgb = srgb16();
    let codes = png::read_rgba16(path, limits)?;
    Ok(codes.map(|codes| {
        from_fn(|at| match (sources[at], slots[at].holds) {
            (None, _) => 0.0,
            (Some(PNG_ALPHA), _) | (Some(_), Holds::Number) => {
                let code = sources[at].map_or(0, |source| codes[source]);
                (f64::from(code) / 65535.0) as f32
            }
            (Some(source), Holds::Light) => srgb[codes[source] as usize].to_f32(),
        })
    }))
}

#[derive(Debug)]
struct Layers<const N: usize> {
    constants: [Option<f32>; N],
    /// Pixels of the file; `None` if all channels are constants.
    pixels: Option<Plane<[f32; N]>>,
}

impl<const N: usize> Layers<N> {
    fn at(&self, [col, row]: [u32; 2]) -> [f32; N] {
        let stored = self.pixels.as_ref().map_or([0.0; N], |pixels| pixels.get(col, row));
        from_fn(|at| self.constants[at].unwrap_or(stored[at]))
    }
}

#[derive(Debug)]
enum Values {
    /// Red, green, blue, alpha and depth.
    OfOneFile(Layers<5>),
    OfTwoFiles(Layers<4>, Layers<1>),
}

/// The decoded images of a view.
#[derive(Debug)]
pub struct ViewImage<'a> {
    view: &'a SeuratView,
    values: Values,
}

impl ViewImage<'_> {
    /// Returns the rays of the samples of a row, 0 at the top. A pixel with an alpha of 0 is not a sample.
    pub fn row(&self, row: u32) -> Result<Vec<CaptureRay>> {
        let [width, _] = self.view.size();
        let mut rays = Vec::new();
        for col in 0..width {
            rays.extend(self.ray([col, row])?);
        }
        Ok(rays)
    }

    fn ray(&self, at: [u32; 2]) -> Result<Option<CaptureRay>> {
        let (color, alpha, depth) = match &self.values {
            Values::OfOneFile(layers) => {
                let [r, g, b, alpha, depth] = layers.at(at);
                ([r, g, b], alpha, depth)
            }
            Values::OfTwoFiles(color, depth) => {
                let ([r, g, b, alpha], [depth]) = (color.at(at), depth.at(at));
                ([r, g, b], alpha, depth)
            }
        };
        if alpha == 0.0 {
            return Ok(None);
        }
        let place = || {
            let index = at[1] as usize * self.view.size()[0] as usize + at[0] as usize;
            format!("{}: {}", self.view.json_path(), pixel(index, self.view.size()[0]))
        };
        if alpha.is_nan() || alpha < 0.0 {
            let message = format!("{}: alpha is {alpha}, 0 to 1 was expected", place());
            return Err(Error::invalid(message).in_file(&self.view.color.path));
        }
        let light = color.map(f16::from_f32);
        if light.iter().any(|value| value.is_nan()) {
            let message = format!("{}: colour is not a number", place());
            return Err(Error::invalid(message).in_file(&self.view.color.path));
        }
        let ray = self.view.camera.ray(at, depth);
        let ray = ray.map_err(|error| error.context(place()).in_file(&self.view.depth.path))?;
        Ok(Some(CaptureRay {
            pixel: at,
            origin: ray.origin,
            direction: ray.direction,
            distance_m: ray.distance_m,
            light: light.map(|value| value.clamp(f16::MIN, f16::MAX).to_f32()),
            alpha: alpha.min(1.0),
        }))
    }
}

#[cfg(test)]
mod tests;
