//! Quality of interpolated views compared with ray casting, view by view: PSNR, SSIM, PSNR-HVS-M and MSE, with and
//! without hole filling, as a table and as means with ranges; and error maps (figures 4.19 to 4.35 and tables 4.4 to
//! 4.6 of de Quilletes).

use std::path::Path;

use half::f16;
use serde::Serialize;

use super::picture::sheet::error_picture;
use codec::error::Result;
use codec::image::{Plane, ToneMap};
use epipolar::pipeline::Picture;
use evaluate::reference::Truth;
use evaluate::similarity::{Similarity, difference, truth_codes};
use footage::files::OutputFolder;
use footage::image_files::png;
use footage::json::Number;

/// Quality figures of all compared views.
#[derive(Debug, Default)]
pub struct Quality {
    rows: Vec<Row>,
    /// Folder of error maps, if requested.
    maps: Option<OutputFolder>,
}

#[derive(Debug, Clone)]
struct Row {
    frame: u32,
    view: usize,
    filled: Figures,
    unfilled: Figures,
    holes_percent: f64,
}

#[derive(Debug, Clone, Copy)]
struct Figures {
    psnr_db: f64,
    ssim: f64,
    psnr_hvs_m_db: f64,
    mse: f64,
}

impl Figures {
    fn of(similarity: &Similarity) -> Figures {
        Figures {
            psnr_db: similarity.all.psnr_db(),
            ssim: similarity.ssim().unwrap_or(f64::NAN),
            psnr_hvs_m_db: similarity.hvs.psnr_db().unwrap_or(f64::NAN),
            mse: similarity.all.mse(),
        }
    }
}

/// Mean and range of a figure over all views. The PSNR of an exact picture is infinite and does not enter the mean.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Spread {
    mean: Number,
    min: Number,
    max: Number,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Spread {
        let finite = values.clone().filter(|value| value.is_finite());
        let count = finite.clone().count();
        let mean =
            if count == 0 { values.clone().next().unwrap_or(f64::NAN) } else { finite.sum::<f64>() / count as f64 };
        Spread {
            mean: Number(mean),
            min: Number(values.clone().fold(f64::INFINITY, f64::min)),
            max: Number(values.fold(f64::NEG_INFINITY, f64::max)),
        }
    }
}

#[derive(Debug, Serialize)]
pub struct QualityReport {
    psnr_db: Spread,
    ssim: Spread,
    psnr_hvs_m_db: Spread,
    mse: Spread,
}

impl Quality {
    /// Creates an empty table. If a folder is named, error maps are written, too.
    pub fn new(maps: Option<&Path>) -> Result<Quality> {
        Ok(Quality { rows: Vec::new(), maps: maps.map(OutputFolder::create).transpose()? })
    }

    pub fn add(&mut self, (frame, view): (u32, usize), picture: &Picture, color: Plane<[f16; 3]>) -> Result<()> {
        let truth = Truth { color, material: None };
        let of = |image| Similarity::of(image, &truth, ToneMap::default());
        let unfilled = picture.unfilled.as_ref().unwrap_or(&picture.filled);
        let (filled, unfilled) = (of(&picture.filled)?, of(unfilled)?);
        if let Some(maps) = &self.maps {
            let (shown, wanted) = (picture.filled.codes(ToneMap::default()), truth_codes(&truth, ToneMap::default()));
            let title = format!("view {view}, frame {frame}: {:.2} dB", filled.all.psnr_db());
            let sheet = error_picture(&title, [&shown, &wanted], &difference(&shown, &wanted)?)?;
            let path = maps.work_path().join(format!("view_{view:04}.{frame:04}.png"));
            png::write_color8(&path, &sheet).map_err(|error| maps.present(error))?;
        }
        self.rows.push(Row {
            frame,
            view,
            filled: Figures::of(&filled),
            unfilled: Figures::of(&unfilled),
            holes_percent: unfilled.hole_percent(),
        });
        Ok(())
    }

    /// Moves the finished folder of error maps into place.
    pub fn commit(&mut self) -> Result<()> {
        self.maps.take().map_or(Ok(()), OutputFolder::commit)
    }

    /// Returns the figures with hole filling, then those without. `None` if no view was compared.
    pub fn reports(&self) -> Option<[QualityReport; 2]> {
        let report = |of: fn(&Row) -> Figures| {
            let spread = |figure: fn(Figures) -> f64| Spread::of(self.rows.iter().map(move |row| figure(of(row))));
            QualityReport {
                psnr_db: spread(|figures| figures.psnr_db),
                ssim: spread(|figures| figures.ssim),
                psnr_hvs_m_db: spread(|figures| figures.psnr_hvs_m_db),
                mse: spread(|figures| figures.mse),
            }
        };
        (!self.rows.is_empty()).then(|| [report(|row| row.filled), report(|row| row.unfilled)])
    }

    /// Returns the table as CSV with one row per view.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "frame,view,psnr_db,ssim,psnr_hvs_m_db,mse,holes_percent,psnr_db_without_fill,ssim_without_fill\n",
        );
        for row in &self.rows {
            let Figures { psnr_db, ssim, psnr_hvs_m_db, mse } = row.filled;
            text += &format!(
                "{},{},{psnr_db:.3},{ssim:.5},{psnr_hvs_m_db:.3},{mse:.4},{:.4},{:.3},{:.5}\n",
                row.frame, row.view, row.holes_percent, row.unfilled.psnr_db, row.unfilled.ssim
            );
        }
        text
    }
}

impl QualityReport {
    pub fn text(&self) -> String {
        let QualityReport { psnr_db, ssim, psnr_hvs_m_db, .. } = self;
        format!(
            "PSNR {:.2} dB (least {:.2}), SSIM {:.4}, PSNR-HVS-M {:.2} dB",
            psnr_db.mean.0, psnr_db.min.0, ssim.mean.0, psnr_hvs_m_db.mean.0
        )
    }
}
