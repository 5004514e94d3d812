//! Captures: images with colour and depth, as rays, from a dataset, a container or a Seurat manifest (Seurat 3).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::DVec3;
use half::slice::HalfFloatSliceExt;

use codec::error::{Error, Result};
use codec::image::{DepthPlane, MaterialPlane, NormalPlane, ReadLimits};
use codec::math::Camera;
use evaluate::reference::Reference;
use footage::account::Account;
use footage::dataset::seurat::{CaptureRay, SeuratCapture, SeuratView, is_manifest};

#[derive(Debug, Clone)]
pub struct CaptureImage {
    /// Probe, face and frame, or the path in the manifest.
    pub name: String,
    pub eye: DVec3,
    pub size: [u32; 2],
    /// `None` for orthographic images and for images with skew, which are not compared with pictures of the scene.
    pub camera: Option<Camera>,
}

impl CaptureImage {
    pub fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

/// Surface properties of an image other than colour and depth, by pixel.
#[derive(Debug, Default)]
pub struct Surfaces {
    pub normal: Option<NormalPlane>,
    /// Weights of reflection and refraction, and index of refraction.
    pub material: Option<MaterialPlane>,
}

#[derive(Debug)]
enum Rays {
    /// Images of one frame, by their indices.
    Reference {
        reference: Box<Reference>,
        indices: Vec<usize>,
        frame: u32,
    },
    Manifest(SeuratCapture),
    /// Rays of each image.
    Memory(Vec<Vec<CaptureRay>>),
}

/// All images of a capture, which are read one by one.
#[derive(Debug)]
pub struct Capture {
    rays: Rays,
    pub images: Vec<CaptureImage>,
    /// Maximum relative error of distances; `None` if it is unknown.
    pub relative_depth_error: Option<f64>,
    /// Notes on the input, as sentences.
    pub notes: Vec<String>,
}

impl Capture {
    /// Opens a dataset, a container or a Seurat manifest. The default is the first frame; a manifest has only one.
    pub fn open(path: &Path, frame: Option<u32>) -> Result<Capture> {
        if !is_manifest(path) {
            return Capture::new(Reference::open(path)?, frame).map_err(|error| error.in_file(path));
        }
        let capture = SeuratCapture::open(path)?;
        if let Some(frame) = frame.filter(|&frame| frame != 0) {
            return Err(Error::Usage(format!("there is no frame {frame}: a Seurat manifest has one")).in_file(path));
        }
        if capture.views.is_empty() {
            return Err(Error::invalid("the manifest has no view; at least one was expected").in_file(path));
        }
        let image = |view: &SeuratView| CaptureImage {
            name: view.json_path(),
            eye: view.camera.position(),
            size: view.size(),
            camera: view.perspective(),
        };
        let images: Vec<CaptureImage> = capture.views.iter().map(image).collect();
        let mut notes = capture.notes.clone();
        let without = images.iter().filter(|image| image.camera.is_none()).count();
        if without > 0 {
            notes.push(format!(
                "pictures are not compared with {without} of {} views: they are not perspective",
                images.len()
            ));
        }
        Ok(Capture { rays: Rays::Manifest(capture), images, relative_depth_error: Some(0.0), notes })
    }

    /// Creates a capture of the images of one frame, by default the first.
    pub fn new(reference: Reference, frame: Option<u32>) -> Result<Capture> {
        let first = reference.images.iter().map(|image| image.frames.first).min().unwrap_or(0);
        let frame = frame.unwrap_or(first);
        let all = reference.images.iter().enumerate();
        let indices: Vec<usize> = all.filter(|(_, image)| image.frames.contains(frame)).map(|(at, _)| at).collect();
        if indices.is_empty() {
            let last = reference.images.iter().map(|image| image.frames.last).max().unwrap_or(0);
            return Err(Error::Usage(format!("there is no image of frame {frame}; the frames are {first} to {last}")));
        }
        let image = |&at: &usize| {
            let image = &reference.images[at];
            CaptureImage {
                name: format!("probe {}, {}, frame {frame}", image.probe, image.face.name()),
                eye: image.camera(frame).eye(),
                size: image.size,
                camera: Some(image.camera(frame)),
            }
        };
        let images = indices.iter().map(image).collect();
        let relative_depth_error = reference.relative_depth_error();
        let rays = Rays::Reference { reference: Box::new(reference), indices, frame };
        Ok(Capture { rays, images, relative_depth_error, notes: Vec::new() })
    }

    /// Creates a capture of images in memory, with the rays of each.
    pub fn of_rays(images: impl IntoIterator<Item = (CaptureImage, Vec<CaptureRay>)>) -> Capture {
        let (images, rays) = images.into_iter().unzip();
        Capture { rays: Rays::Memory(rays), images, relative_depth_error: Some(0.0), notes: Vec::new() }
    }

    /// Returns the number of positions of cameras.
    pub fn eye_count(&self) -> usize {
        self.images.iter().map(|image| image.eye.to_array().map(f64::to_bits)).collect::<BTreeSet<_>>().len()
    }

    /// Returns the account of the input: its images, and of a dataset files, channels and probes. Other frames are left out.
    pub fn account(&self) -> Result<Account> {
        let mut account = match &self.rays {
            Rays::Reference { reference, frame, .. } => reference.account(*frame)?,
            Rays::Manifest(capture) => capture.account(),
            Rays::Memory(_) => Account::default(),
        };
        account.add("image", self.images.iter().map(|image| image.name.clone()));
        Ok(account)
    }

    /// Returns the number of the frame that the images show.
    pub fn frame(&self) -> u32 {
        match &self.rays {
            Rays::Reference { frame, .. } => *frame,
            Rays::Manifest(_) | Rays::Memory(_) => 0,
        }
    }

    /// Returns all image files of the input, including those of other frames.
    pub fn all_files(&self) -> Vec<PathBuf> {
        match &self.rays {
            Rays::Reference { reference, .. } => reference.all_files(),
            Rays::Manifest(_) | Rays::Memory(_) => self.files(),
        }
    }

    /// Returns the files of the images, in no particular order.
    pub fn files(&self) -> Vec<PathBuf> {
        match &self.rays {
            Rays::Reference { reference, frame, .. } => reference.files(*frame),
            Rays::Manifest(capture) => {
                let of = |view: &SeuratView| [view.color.path.clone(), view.depth.path.clone()];
                capture.views.iter().flat_map(of).collect()
            }
            Rays::Memory(_) => Vec::new(),
        }
    }

    /// Reads the rays of an image, in row-major order.
    pub fn rays(&mut self, image: usize) -> Result<ImageRays> {
        Ok(ImageRays(match &mut self.rays {
            Rays::Manifest(capture) => RaysOfImage::Listed(capture.views[image].read(&ReadLimits::default())?),
            Rays::Reference { reference, indices, frame } => of_reference(reference, indices[image], *frame)?,
            Rays::Memory(rays) => RaysOfImage::Listed(rays[image].clone()),
        }))
    }

    /// Reads the rays of an image without colour, which is not read if it is in an image of its own.
    pub fn rays_without_light(&mut self, image: usize) -> Result<ImageRays> {
        match &mut self.rays {
            Rays::Reference { reference, indices, frame } => {
                let (camera, distances_m) = distances(reference, indices[image], *frame)?;
                Ok(ImageRays(RaysOfImage::Planes { camera: Box::new(camera), distances_m, light: Vec::new() }))
            }
            Rays::Manifest(_) | Rays::Memory(_) => self.rays(image),
        }
    }

    /// Reads the normals and the material of an image, if the capture has them.
    pub fn surfaces(&mut self, image: usize) -> Result<Surfaces> {
        match &mut self.rays {
            Rays::Manifest(_) | Rays::Memory(_) => Ok(Surfaces::default()),
            Rays::Reference { reference, indices, frame } => {
                let (image, frame) = (indices[image], *frame);
                let normal = reference.normal(image, frame)?;
                Ok(Surfaces { normal, material: reference.truth(image, frame)?.material })
            }
        }
    }

    /// Adds the name of the image's depth file to an error, if depth is in a file of its own.
    pub fn in_file(&self, image: usize, error: Error) -> Error {
        match &self.rays {
            Rays::Manifest(capture) => error.in_file(&capture.views[image].depth.path),
            Rays::Reference { .. } | Rays::Memory(_) => error,
        }
    }

    /// Returns the maximum over all images of the number of pixels per unit of the plane at distance 1 from the camera. An image
    /// without a camera counts as a face of a cube.
    pub fn pixels_per_unit(&self) -> f64 {
        let half = |image: &CaptureImage| image.camera.map_or(1.0, |camera| camera.half()[1]);
        self.images.iter().map(|image| f64::from(image.size[1]) / (2.0 * half(image))).fold(1.0, f64::max)
    }

    /// Returns the distance in metres to the nearest sample of all images; `+inf` if all of them show the sky.
    pub fn nearest_m(&mut self) -> Result<f64> {
        let mut nearest = f64::INFINITY;
        for image in 0..self.images.len() {
            nearest = self.rays_without_light(image)?.iter().map(|ray| ray.distance_m).fold(nearest, f64::min);
        }
        Ok(nearest)
    }
}

/// Rays of one image, in row-major order.
#[derive(Debug)]
pub struct ImageRays(RaysOfImage);

#[derive(Debug)]
enum RaysOfImage {
    Listed(Vec<CaptureRay>),
    /// One ray per pixel.
    Planes {
        camera: Box<Camera>,
        distances_m: DepthPlane,
        /// Linear RGB. Empty, which is black, if it was not read.
        light: Vec<[f32; 3]>,
    },
}

impl ImageRays {
    pub fn iter(&self) -> impl Iterator<Item = CaptureRay> {
        self.of_pixels(|_| true)
    }

    /// Returns the rays of the pixels that `is_wanted` selects by column and row.
    pub fn of_pixels(&self, is_wanted: impl Fn([u32; 2]) -> bool) -> impl Iterator<Item = CaptureRay> {
        let count = match &self.0 {
            RaysOfImage::Listed(rays) => rays.len(),
            RaysOfImage::Planes { distances_m, .. } => distances_m.data().len(),
        };
        (0..count).filter(move |&at| is_wanted(self.pixel(at))).map(|at| self.at(at))
    }

    fn pixel(&self, at: usize) -> [u32; 2] {
        match &self.0 {
            RaysOfImage::Listed(rays) => rays[at].pixel,
            RaysOfImage::Planes { distances_m, .. } => {
                let width = distances_m.width();
                [at as u32 % width, at as u32 / width]
            }
        }
    }

    fn at(&self, at: usize) -> CaptureRay {
        match &self.0 {
            RaysOfImage::Listed(rays) => rays[at],
            RaysOfImage::Planes { camera, distances_m, light } => {
                let pixel = self.pixel(at);
                let [column, row] = pixel.map(|at| f64::from(at) + 0.5);
                let [width, height] = [distances_m.width(), distances_m.height()].map(f64::from);
                CaptureRay {
                    pixel,
                    origin: camera.eye(),
                    direction: camera.direction([column / width, row / height]),
                    distance_m: f64::from(distances_m.data()[at]),
                    light: light.get(at).copied().unwrap_or_default(),
                    alpha: 1.0,
                }
            }
        }
    }
}

fn of_reference(reference: &mut Reference, image: usize, frame: u32) -> Result<RaysOfImage> {
    let truth = reference.truth(image, frame)?;
    let (camera, distances_m) = distances(reference, image, frame)?;
    let mut light = vec![[0.0; 3]; truth.color.data().len()];
    truth.color.data().as_flattened().convert_to_f32_slice(light.as_flattened_mut());
    if distances_m.data().len() != light.len() {
        return Err(Error::invalid(format!("image {image} has colour and depth of different sizes")));
    }
    Ok(RaysOfImage::Planes { camera: Box::new(camera), distances_m, light })
}

fn distances(reference: &mut Reference, image: usize, frame: u32) -> Result<(Camera, DepthPlane)> {
    let distances_m = reference.distance_m(image, frame)?.ok_or_else(|| {
        let named = &reference.images[image];
        Error::Usage(format!(
            "probe {}, {}: the image has no depth, which simplification needs",
            named.probe,
            named.face.name()
        ))
    })?;
    Ok((reference.images[image].camera(frame), distances_m))
}
