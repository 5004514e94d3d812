//! `render --reference`: pictures of what a dataset shows, compared with it.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::Take;
use super::options::MethodArg;
use super::pictures::PictureName;
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
use crate::report::error_picture;

/// What pictures are compared with.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Reference")]
pub struct TruthArgs {
    /// Render what this dataset's images show, and report PSNR and SSIM
    #[arg(long, value_name = "DATASET", conflicts_with_all = ["camera", "eye"])]
    pub reference: Option<PathBuf>,
    /// Only these probes of it, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',', requires = "reference", conflicts_with_all = ["camera", "eye"])]
    pub reference_probe: Vec<String>,
    /// Folder for pictures of where the errors are
    #[arg(long, value_name = "DIR", requires = "reference", conflicts_with_all = ["camera", "eye"])]
    pub error_map: Option<PathBuf>,
}

impl TruthArgs {
    /// Opens the reference, if there is one.
    ///
    /// # Errors
    /// When it cannot be read, has no such probe, or has not what a method takes.
    pub fn open(&self, method: MethodArg) -> Result<Option<TruthRun>> {
        let Some(path) = &self.reference else {
            return match method {
                MethodArg::Reproject => {
                    Err(Error::Usage("--method reproject takes its distances from --reference: name a dataset".into()))
                }
                _ => Ok(None),
            };
        };
        let reference = Reference::open(path)?;
        for name in &self.reference_probe {
            if !reference.images().iter().any(|image| image.probe == *name) {
                return Err(Error::Usage(format!("{}: no probe is named {name}", path.display())));
            }
        }
        let maps = self.error_map.as_deref().map(OutputFolder::create).transpose()?;
        Ok(Some(TruthRun {
            path: path.clone(),
            reference,
            probes: self.reference_probe.clone(),
            maps,
            method,
            all: Similarity::empty(),
            images: Vec::new(),
        }))
    }
}

/// A reference, and how far pictures were from it so far.
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
    /// What is to be rendered: the images of a probe in a frame at once.
    ///
    /// # Errors
    /// When reference and container have no frame in common.
    pub fn takes(&self, frames: Option<FrameRange>, available: FrameRange, global: &GlobalArgs) -> Result<Vec<Take>> {
        let mut takes: Vec<Take> = Vec::new();
        if let Some(asked) = frames.filter(|&frames| frames.intersect(available) != Some(frames) && !global.quiet) {
            output::note(format_args!("of the frames {asked}, those are shown that there are: {available}"));
        }
        let frames = frames.map_or(Some(available), |frames| frames.intersect(available));
        for (at, image) in self.reference.images().iter().enumerate() {
            if !self.probes.is_empty() && !self.probes.contains(&image.probe) {
                continue;
            }
            for frame in frames.and_then(|frames| frames.intersect(image.frames)).into_iter().flat_map(FrameRange::iter)
            {
                let name = PictureName { number: frame, subject: format!("{}_{}", image.probe, image.face.name()) };
                let same = |take: &&mut Take| {
                    let other = take.references.first().and_then(|&other| self.reference.images().get(other));
                    take.request.frame == frame
                        && take.size == image.size
                        && other.is_some_and(|o| o.probe == image.probe)
                };
                match takes.iter_mut().find(same) {
                    Some(take) => {
                        take.request.cameras.push(image.camera);
                        take.names.push(name);
                        take.references.push(at);
                    }
                    None => takes.push(Take {
                        request: FrameRequest { frame, cameras: vec![image.camera] },
                        names: vec![name],
                        size: image.size,
                        references: vec![at],
                    }),
                }
            }
        }
        if takes.is_empty() {
            return Err(Error::Usage(format!(
                "{}: none of the frames that are asked for is in both the reference and the container ({available})",
                self.path.display()
            )));
        }
        Ok(takes)
    }

    /// True distances of a take's pictures.
    ///
    /// # Errors
    /// When the reference has none, or they cannot be read.
    pub fn distances(&mut self, take: &Take) -> Result<VecDeque<DepthPlane>> {
        let of = |&image: &usize| {
            let distance_m = self.reference.distance_m(image, take.request.frame)?;
            distance_m.ok_or_else(|| {
                Error::Usage(format!("{}: has no depth, which --method reproject takes", self.path.display()))
            })
        };
        take.references.iter().map(of).collect()
    }

    /// Compares the pictures of a take.
    ///
    /// # Errors
    /// When an image cannot be read or a map not be written.
    pub fn compare(&mut self, take: &Take, pictures: &[RenderedImage], tone: ToneMap) -> Result<()> {
        for ((&image, name), rendered) in take.references.iter().zip(&take.names).zip(pictures) {
            let truth = self.reference.truth(image, take.request.frame)?;
            let similarity = Similarity::of(rendered, &truth, tone)?;
            self.all.merge(&similarity)?;
            let about = &self.reference.images()[image];
            let mut entry = figures(&similarity);
            entry["probe"] = json!(about.probe);
            entry["face"] = json!(about.face.name());
            entry["frame"] = json!(take.request.frame);
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

    /// Lets the maps appear.
    ///
    /// # Errors
    /// When they cannot.
    pub fn commit(&mut self) -> Result<()> {
        self.maps.take().map_or(Ok(()), OutputFolder::commit)
    }

    /// How far all pictures were from it.
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
