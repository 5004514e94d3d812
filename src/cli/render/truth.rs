//! `render --reference`: renders the images of a dataset, and compares them.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::job::Job;
use super::options::MethodArg;
use super::pictures::PictureName;
use super::truth_args::TruthArgs;
use crate::cli::GlobalArgs;
use crate::cli::output;
use crate::error::{Error, Result};
use crate::evaluate::frame_requests::FrameRequest;
use crate::evaluate::reference::Reference;
use crate::evaluate::rendered_image::RenderedImage;
use crate::evaluate::similarity::{Similarity, difference, truth_codes};
use crate::files::OutputFolder;
use crate::image::FrameRange;
use crate::image::plane::DepthPlane;
use crate::image::png;
use crate::image::transfer::ToneMap;
use crate::report::picture::error_picture;

/// A reference, and the similarity of the images so far.
pub struct TruthRun {
    path: PathBuf,
    reference: Reference,
    probes: Vec<String>,
    maps: Option<OutputFolder>,
    method: MethodArg,
    all: Similarity,
    images: Vec<Value>,
}

impl TruthRun {
    /// Opens the reference, if there is one.
    ///
    /// # Errors
    /// When it cannot be read, has no such probe, or lacks what a method needs.
    pub fn open(args: &TruthArgs, method: MethodArg) -> Result<Option<TruthRun>> {
        let Some(path) = &args.reference else {
            return match method {
                MethodArg::Reproject => Err(Error::Usage("--method reproject needs --reference".into())),
                _ => Ok(None),
            };
        };
        let reference = Reference::open(path)?;
        for name in &args.reference_probe {
            if !reference.images().iter().any(|image| image.probe == *name) {
                return Err(Error::Usage(format!("{}: no probe is named {name}", path.display())));
            }
        }
        let maps = args.error_map.as_deref().map(OutputFolder::create).transpose()?;
        Ok(Some(TruthRun {
            path: path.clone(),
            reference,
            probes: args.reference_probe.clone(),
            maps,
            method,
            all: Similarity::empty(),
            images: Vec::new(),
        }))
    }

    /// A job for each probe and frame.
    ///
    /// # Errors
    /// When reference and container have no frame in common.
    pub fn jobs(&self, frames: Option<FrameRange>, available: FrameRange, global: &GlobalArgs) -> Result<Vec<Job>> {
        let mut jobs: Vec<Job> = Vec::new();
        if let Some(asked) = frames.filter(|&frames| frames.intersect(available) != Some(frames) && !global.quiet) {
            output::note(format_args!("of frames {asked} only {available} exist"));
        }
        let frames = frames.map_or(Some(available), |frames| frames.intersect(available));
        for (at, image) in self.reference.images().iter().enumerate() {
            if !self.probes.is_empty() && !self.probes.contains(&image.probe) {
                continue;
            }
            for frame in frames.and_then(|frames| frames.intersect(image.frames)).into_iter().flat_map(FrameRange::iter)
            {
                let name = PictureName { number: frame, subject: format!("{}_{}", image.probe, image.face.name()) };
                let same = |job: &&mut Job| {
                    let other = job.references.first().and_then(|&other| self.reference.images().get(other));
                    job.request.frame == frame
                        && job.size == image.size
                        && other.is_some_and(|o| o.probe == image.probe)
                };
                match jobs.iter_mut().find(same) {
                    Some(job) => {
                        job.request.cameras.push(image.camera);
                        job.names.push(name);
                        job.references.push(at);
                    }
                    None => jobs.push(Job {
                        request: FrameRequest { frame, cameras: vec![image.camera] },
                        names: vec![name],
                        size: image.size,
                        references: vec![at],
                    }),
                }
            }
        }
        if jobs.is_empty() {
            return Err(Error::Usage(format!(
                "{}: no selected frame is in both the reference and the container ({available})",
                self.path.display()
            )));
        }
        Ok(jobs)
    }

    /// True distances of a job's images.
    ///
    /// # Errors
    /// When the reference has none, or they cannot be read.
    pub fn distances(&mut self, job: &Job) -> Result<VecDeque<DepthPlane>> {
        let of = |&image: &usize| {
            let distance_m = self.reference.distance_m(image, job.request.frame)?;
            distance_m.ok_or_else(|| {
                Error::Usage(format!("{}: has no depth, which --method reproject needs", self.path.display()))
            })
        };
        job.references.iter().map(of).collect()
    }

    /// Compares the images of a job.
    ///
    /// # Errors
    /// When an image cannot be read or a map not be written.
    pub fn compare(&mut self, job: &Job, pictures: &[RenderedImage], tone: ToneMap) -> Result<()> {
        for ((&image, name), rendered) in job.references.iter().zip(&job.names).zip(pictures) {
            let truth = self.reference.truth(image, job.request.frame)?;
            let similarity = Similarity::of(rendered, &truth, tone)?;
            self.all.merge(&similarity)?;
            let about = &self.reference.images()[image];
            let mut entry = figures(&similarity);
            entry["probe"] = json!(about.probe);
            entry["face"] = json!(about.face.name());
            entry["frame"] = json!(job.request.frame);
            self.images.push(entry);
            if let Some(maps) = &self.maps {
                let shown = rendered.codes(tone);
                let wanted = truth_codes(&truth, tone);
                let title = format!("{} frame {}: {:.2} dB", name.subject, name.number, similarity.all.psnr_db());
                let sheet = error_picture::draw(&title, [&shown, &wanted], &difference(&shown, &wanted)?)?;
                png::write_color8(&maps.work_path().join(format!("{}.{:04}.png", name.subject, name.number)), &sheet)
                    .map_err(|error| maps.present(error))?;
            }
        }
        Ok(())
    }

    /// Commits the error maps.
    ///
    /// # Errors
    /// When they cannot.
    pub fn commit(&mut self) -> Result<()> {
        self.maps.take().map_or(Ok(()), OutputFolder::commit)
    }

    /// Similarity of all images.
    pub fn all(&self) -> &Similarity {
        &self.all
    }

    /// The dataset.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All figures.
    pub fn json(&self) -> Value {
        let mut report = figures(&self.all);
        report["method"] = json!(self.method.name());
        report["mean_psnr_db"] = output::json_number(self.all.mean_psnr_db());
        report["images"] = self.images.clone().into();
        report
    }
}

fn figures(similarity: &Similarity) -> Value {
    let mut report = json!({
        "psnr_db": output::json_number(similarity.all.psnr_db()),
        "psnr_db_seen": output::json_number(similarity.seen.psnr_db()),
        "ssim": similarity.ssim(),
        "hole_percent": similarity.hole_percent(),
    });
    let effects = [
        ("psnr_hvs_m_db", similarity.psnr_hvs_m_db()),
        ("psnr_db_effects", similarity.effects_psnr_db()),
        ("psnr_db_mirrors", similarity.mirrors_psnr_db()),
        ("psnr_db_glass", similarity.glass_psnr_db()),
    ];
    for (key, value) in effects {
        if let Some(value) = value {
            report[key] = output::json_number(value);
        }
    }
    report
}
