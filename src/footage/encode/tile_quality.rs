//! PSNR of modelling functions on 8x8 tiles of depth (GDC figure 6).

use std::collections::BTreeMap;

use serde::Serialize;

use crate::encode::EncodeSettings;
use crate::encode::depth_range::{ProbeDepth, depth_of_probe};
use crate::encode::plan::{GroupPlan, Plan};
use crate::encode::source::{FrameSource, name_frame};
use crate::json::Number;
use codec::depth::Quantiser;
use codec::depth::domain::Domain;
use codec::depth::tile_psnr::{BIN_DB, EXACT_DB, PsnrDistribution, TILE_SIDE, TileModel, TilePsnr};
use codec::error::Result;
use codec::image::StreamKind;
use codec::monitor::Monitor;
use codec::ordered::try_map_ordered;
use codec::streams::convert;

/// Number of images that [`measure`] advances its monitor by.
pub fn images(source: &dyn FrameSource) -> u64 {
    let of_depth = EncodeSettings { kinds: vec![StreamKind::Depth], ..EncodeSettings::default() };
    Plan::new(source, &of_depth).images()
}

/// Fits each modelling function to every 8x8 tile of all depth images, without an error bound. Of the settings only near, far,
/// domain and effort are used.
pub fn measure(source: &dyn FrameSource, settings: &EncodeSettings, monitor: &dyn Monitor) -> Result<TilePsnr> {
    let mut found = TilePsnr::default();
    let all_kinds = EncodeSettings { kinds: StreamKind::ALL.to_vec(), ..settings.clone() };
    let plan = Plan::new(source, &all_kinds);
    for groups in (0..source.probes().len()).map(|probe| plan.depth_of(probe)).filter(|groups| !groups.is_empty()) {
        let ProbeDepth { range, scanned, .. } = depth_of_probe(&plan, &groups, None, monitor)?;
        let mut kept = scanned.map(|scanned| scanned.kept).unwrap_or_default();
        let (quantiser, domain) = (Quantiser::new(range), Domain::new(settings.depth.domain, range)?);
        for GroupPlan { at, group, .. } in groups {
            for frame in group.frames.iter() {
                monitor.check()?;
                let planes = match kept.remove(&(at, frame)) {
                    Some(planes) => planes,
                    None => source.read_depth(group, frame)?,
                };
                for plane in &planes {
                    let codes = convert::depth_codes(plane, &quantiser)
                        .map_err(|error| error.context(name_frame(source, group, frame)))?;
                    let rows = (0..codes.height() as usize).step_by(TILE_SIDE).collect();
                    let measured = try_map_ordered(rows, |y| {
                        monitor.check()?;
                        let how = (&domain, settings.depth.effort);
                        Ok(TilePsnr::of_row(codes.data(), codes.width() as usize, y, how))
                    })?;
                    measured.iter().for_each(|row| found.add(row));
                    monitor.advance(1);
                }
            }
        }
    }
    Ok(found)
}

/// JSON report of the PSNR of tiles. The keys of the maps are model names.
#[derive(Debug, Serialize)]
pub struct TileQualityReport {
    tiles: u64,
    seconds: f64,
    psnr_db: BTreeMap<&'static str, PsnrReport>,
    max_error_codes: u16,
    histogram: HistogramReport,
    exact_counts_as_db: f64,
}

#[derive(Debug, Serialize)]
struct PsnrReport {
    mean: f64,
    min: Number,
    p05: Number,
    p50: Number,
    p95: Number,
    exact_tiles: u64,
    unmodelled_tiles: u64,
}

#[derive(Debug, Serialize)]
struct HistogramReport {
    bin_db: usize,
    first_db: usize,
    tiles: BTreeMap<&'static str, Vec<u64>>,
}

impl TileQualityReport {
    pub fn new(found: &TilePsnr, seconds: f64) -> TileQualityReport {
        TileQualityReport {
            tiles: found.tiles(),
            seconds,
            psnr_db: by_model(|model| PsnrReport::new(found.of(model))),
            max_error_codes: found.bc4w_max_error,
            histogram: HistogramReport {
                bin_db: BIN_DB,
                first_db: 0,
                tiles: by_model(|model| found.of(model).histogram()),
            },
            exact_counts_as_db: EXACT_DB,
        }
    }
}

impl PsnrReport {
    fn new(psnr: &PsnrDistribution) -> PsnrReport {
        PsnrReport {
            mean: psnr.mean_db(),
            min: Number(psnr.min_db),
            p05: Number(psnr.quantile_db(0.05)),
            p50: Number(psnr.quantile_db(0.5)),
            p95: Number(psnr.quantile_db(0.95)),
            exact_tiles: psnr.exact,
            unmodelled_tiles: psnr.unmodelled,
        }
    }
}

fn by_model<T>(value: impl Fn(TileModel) -> T) -> BTreeMap<&'static str, T> {
    TileModel::ALL.into_iter().map(|model| (model.name(), value(model))).collect()
}
