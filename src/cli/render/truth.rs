//! `render --reference`: renders the images of a dataset, and compares them.

use std::collections::VecDeque;
use std::path::PathBuf;

use serde::Serialize;

use super::options::{METHODS, Method, TruthArgs};
use super::pictures::{Job, PictureName};
use crate::options::word_of;
use crate::report::picture::sheet::error_picture;
use crate::{GlobalArgs, refuse};
use codec::error::{Error, Result};
use codec::image::plane::DepthPlane;
use codec::image::transfer::ToneMap;
use codec::image::{FrameRange, Plane};
use evaluate::reference::Reference;
use evaluate::similarity::{Similarity, SimilarityReport, difference, truth_codes};
use footage::files::OutputFolder;
use footage::image_files::png;
use footage::json::Number;
use render::frame_requests::FrameRequest;
use render::rendered_image::RenderedImage;

pub struct TruthRun {
    pub path: PathBuf,
    reference: Reference,
    probes: Vec<String>,
    maps: Option<OutputFolder>,
    method: Method,
    pub all: Similarity,
    images: Vec<ImageReport>,
}

#[derive(Serialize)]
struct ImageReport {
    #[serde(flatten)]
    similarity: SimilarityReport,
    probe: String,
    face: &'static str,
    frame: u32,
}

#[derive(Serialize)]
pub struct TruthReport<'a> {
    #[serde(flatten)]
    similarity: SimilarityReport,
    method: &'static str,
    mean_psnr_db: Number,
    images: &'a [ImageReport],
}

impl TruthRun {
    pub fn open(args: &TruthArgs, method: Method) -> Result<Option<TruthRun>> {
        let Some(path) = &args.reference else {
            return match method {
                Method::Reproject => refuse("--method reproject needs --reference"),
                _ => Ok(None),
            };
        };
        let reference = Reference::open(path)?;
        for name in &args.reference_probe {
            if !reference.images.iter().any(|image| image.probe == *name) {
                return refuse(format!("{}: there is no probe {name}", path.display()));
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

    pub fn jobs(&self, frames: Option<FrameRange>, available: FrameRange, global: &GlobalArgs) -> Result<Vec<Job>> {
        let mut jobs: Vec<Job> = Vec::new();
        if let Some(asked) = frames.filter(|&frames| frames.intersect(available) != Some(frames)) {
            global.note(format_args!("only {available} of frames {asked} exist"));
        }
        let frames = frames.map_or(Some(available), |frames| frames.intersect(available));
        for (at, image) in self.reference.images.iter().enumerate() {
            if !self.probes.is_empty() && !self.probes.contains(&image.probe) {
                continue;
            }
            for frame in frames.and_then(|frames| frames.intersect(image.frames)).into_iter().flat_map(FrameRange::iter)
            {
                let name = PictureName { number: frame, subject: format!("{}_{}", image.probe, image.face.name()) };
                let same = |job: &&mut Job| {
                    let other = job.references.first().and_then(|&other| self.reference.images.get(other));
                    job.request.frame == frame
                        && job.size == image.size
                        && other.is_some_and(|o| o.probe == image.probe)
                };
                match jobs.iter_mut().find(same) {
                    Some(job) => {
                        job.request.cameras.push(image.camera(frame));
                        job.names.push(name);
                        job.references.push(at);
                    }
                    None => jobs.push(Job {
                        request: FrameRequest { frame, cameras: vec![image.camera(frame)] },
                        names: vec![name],
                        size: image.size,
                        references: vec![at],
                    }),
                }
            }
        }
        if jobs.is_empty() {
            return refuse(format!(
                "{}: no selected frame is in both the reference and the input ({available})",
                self.path.display()
            ));
        }
        Ok(jobs)
    }

    pub fn distances(&mut self, job: &Job) -> Result<VecDeque<DepthPlane>> {
        let of = |&image: &usize| {
            let distance_m = self.reference.distance_m(image, job.request.frame)?;
            distance_m.ok_or_else(|| {
                Error::Usage(format!("{}: there is no depth, which --method reproject needs", self.path.display()))
            })
        };
        job.references.iter().map(of).collect()
    }

    /// Compares the pictures of a job with its references. Masks come from
    /// [`near_silhouettes`](render::march::silhouettes::near_silhouettes).
    pub fn compare(
        &mut self,
        job: &Job,
        (pictures, near_silhouettes): (&[RenderedImage], &[Option<Plane<bool>>]),
        tone: ToneMap,
    ) -> Result<()> {
        for (at, ((&image, name), rendered)) in job.references.iter().zip(&job.names).zip(pictures).enumerate() {
            let truth = self.reference.truth(image, job.request.frame)?;
            let mut similarity = Similarity::of(rendered, &truth, tone)?;
            let codes = [rendered.codes(tone), truth_codes(&truth, tone)];
            if let Some(Some(near)) = near_silhouettes.get(at) {
                similarity.add_silhouettes(codes.each_ref(), near);
            }
            self.all.merge(&similarity)?;
            let about = &self.reference.images[image];
            self.images.push(ImageReport {
                similarity: similarity.report(),
                probe: about.probe.clone(),
                face: about.face.name(),
                frame: job.request.frame,
            });
            if let Some(maps) = &self.maps {
                let [shown, wanted] = &codes;
                let title = format!("{} frame {}: {:.2} dB", name.subject, name.number, similarity.all.psnr_db());
                let sheet = error_picture(&title, [shown, wanted], &difference(shown, wanted)?)?;
                png::write_color8(&maps.work_path().join(name.png()), &sheet).map_err(|error| maps.present(error))?;
            }
        }
        Ok(())
    }

    pub fn commit(&mut self) -> Result<()> {
        self.maps.take().map_or(Ok(()), OutputFolder::commit)
    }

    pub fn report(&self) -> TruthReport<'_> {
        TruthReport {
            similarity: self.all.report(),
            method: word_of(METHODS, &self.method),
            mean_psnr_db: Number(self.all.mean_psnr_db()),
            images: &self.images,
        }
    }
}
