//! Measures the PSNR of each modelling function on tiles of 8x8 pixels, without an error bound (GDC figure 6).
//!
//! Input: pictures of codes. Output: the distribution of PSNR for each function except raw, which is exact.

use crate::depth::bc4w::search;
use crate::depth::biquadratic::Biquadratic;
use crate::depth::biquadratic::fit::Order;
use crate::depth::block::{Accuracy, Block};
use crate::depth::domain::Domain;
use crate::depth::mode_decision::psnr_db;
use crate::depth::platelet::Platelet;
use crate::effort::Effort;

pub const TILE_LEVEL: u8 = 1;
pub const TILE_SIDE: usize = 8;
/// Value of an exact tile in a mean, in dB: the PSNR of one pixel off by one code.
pub const EXACT_DB: f64 = 114.391_265_8;
/// Width of the bins of [`PsnrDistribution::histogram`] in dB.
pub const BIN_DB: usize = 5;
/// Number of bins from 0 dB on; the last ends above [`EXACT_DB`].
pub const BIN_COUNT: usize = 23;
const STEPS_PER_DB: usize = 100;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TileModel {
    Bc4w,
    Platelet,
    Biquadratic,
    /// Platelet or biquadratic, whichever has the lower squared error: the choice without BC4w.
    PlateletOrBiquadratic,
    /// Whichever of the three functions has the lowest squared error.
    BestOf,
}

impl TileModel {
    pub const ALL: [TileModel; 5] = [
        TileModel::Bc4w,
        TileModel::Platelet,
        TileModel::Biquadratic,
        TileModel::PlateletOrBiquadratic,
        TileModel::BestOf,
    ];

    pub fn name(self) -> &'static str {
        match self {
            TileModel::Bc4w => "bc4w",
            TileModel::Platelet => "platelet",
            TileModel::Biquadratic => "biquadratic",
            TileModel::PlateletOrBiquadratic => "platelet_or_biquadratic",
            TileModel::BestOf => "best_of",
        }
    }
}

/// Distribution of the PSNR of tiles, in dB of 16-bit codes. Memory does not depend on the number of tiles.
#[derive(Debug, Clone, PartialEq)]
pub struct PsnrDistribution {
    /// Number of tiles by PSNR in steps of 1/100 dB, from 0 dB on.
    steps: Vec<u64>,
    pub exact: u64,
    /// Number of tiles that cannot be modelled, such as background mixed with a surface; their PSNR is 0.
    pub unmodelled: u64,
    pub tiles: u64,
    sum_db: f64,
    /// Minimum PSNR in dB; infinite if all tiles are exact.
    pub min_db: f64,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct TilePsnr {
    models: [PsnrDistribution; 5],
    /// Maximum error in codes of any pixel of the BC4w blocks.
    pub bc4w_max_error: u16,
}

impl Default for PsnrDistribution {
    fn default() -> Self {
        let steps = vec![0; BIN_COUNT * BIN_DB * STEPS_PER_DB];
        PsnrDistribution { steps, exact: 0, unmodelled: 0, tiles: 0, sum_db: 0.0, min_db: f64::INFINITY }
    }
}

impl PsnrDistribution {
    fn count(&mut self, accuracy: Option<Accuracy>, pixels: usize) {
        let db = accuracy.map_or(0.0, |accuracy| psnr_db(accuracy.squared_error, pixels).max(0.0));
        self.tiles += 1;
        self.unmodelled += u64::from(accuracy.is_none());
        self.sum_db += db.min(EXACT_DB);
        self.min_db = self.min_db.min(db);
        if db.is_finite() {
            let last = self.steps.len() - 1;
            self.steps[((db * STEPS_PER_DB as f64) as usize).min(last)] += 1;
        } else {
            self.exact += 1;
        }
    }

    fn add(&mut self, other: &PsnrDistribution) {
        self.steps.iter_mut().zip(&other.steps).for_each(|(count, other)| *count += other);
        self.exact += other.exact;
        self.unmodelled += other.unmodelled;
        self.tiles += other.tiles;
        self.sum_db += other.sum_db;
        self.min_db = self.min_db.min(other.min_db);
    }

    /// Returns the mean in dB. Exact tiles count as [`EXACT_DB`], those that cannot be modelled as 0.
    pub fn mean_db(&self) -> f64 {
        self.sum_db / self.tiles.max(1) as f64
    }

    /// Returns the lowest PSNR in dB, rounded down to 1/100 dB, that `share` (0 to 1) of the tiles do not exceed.
    pub fn quantile_db(&self, share: f64) -> f64 {
        let rank = ((self.tiles as f64 * share).ceil() as u64).max(1);
        let mut below = 0;
        let step = self.steps.iter().position(|&count| {
            below += count;
            below >= rank
        });
        step.map_or(f64::INFINITY, |step| step as f64 / STEPS_PER_DB as f64)
    }

    /// Returns the number of tiles in bins of [`BIN_DB`] from 0 dB on, without exact tiles.
    pub fn histogram(&self) -> Vec<u64> {
        self.steps.chunks(BIN_DB * STEPS_PER_DB).map(|steps| steps.iter().sum()).collect()
    }
}

impl TilePsnr {
    /// Measures the row of tiles from pixel row `y` on, a multiple of 8.
    pub fn of_row(picture: &[u16], width: usize, y: usize, (domain, effort): (&Domain, Effort)) -> TilePsnr {
        let mut found = TilePsnr::default();
        for x in (0..width).step_by(TILE_SIDE) {
            found.count(&Block::of(picture, width, TILE_LEVEL, [x, y]), domain, effort);
        }
        found
    }

    fn count(&mut self, block: &Block<'_>, domain: &Domain, effort: Effort) {
        let (_, bc4w) = search::encode(block, effort);
        let platelet = Platelet::fit(block, domain, u16::MAX).map(|(_, accuracy)| accuracy);
        let biquadratic = Biquadratic::fit(block, domain, u16::MAX, Order::Full).map(|(_, accuracy)| accuracy);
        let each = [Some(bc4w), platelet, biquadratic];
        let best = |of: &[Option<Accuracy>]| of.iter().flatten().min_by_key(|of| of.squared_error).copied();
        let combined = [best(&each[1..]), best(&each)];
        for (model, accuracy) in self.models.iter_mut().zip(each.into_iter().chain(combined)) {
            model.count(accuracy, block.pixel_count());
        }
        self.bc4w_max_error = self.bc4w_max_error.max(bc4w.max_error);
    }

    pub fn add(&mut self, other: &TilePsnr) {
        self.models.iter_mut().zip(&other.models).for_each(|(model, other)| model.add(other));
        self.bc4w_max_error = self.bc4w_max_error.max(other.bc4w_max_error);
    }

    pub fn tiles(&self) -> u64 {
        self.of(TileModel::Bc4w).tiles
    }

    pub fn of(&self, model: TileModel) -> &PsnrDistribution {
        &self.models[model as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(picture: &[u16], width: usize) -> TilePsnr {
        let domain = Domain::log();
        let mut all = TilePsnr::default();
        for y in (0..picture.len() / width).step_by(TILE_SIDE) {
            all.add(&TilePsnr::of_row(picture, width, y, (&domain, Effort::Fast)));
        }
        all
    }

    #[test]
    fn an_exact_tile_counts_as_the_least_error_in_means_and_as_infinite_elsewhere() {
        let least = psnr_db(1, 64);
        assert!((least - EXACT_DB).abs() < 1e-6, "{least}");
        let found = measure(&[1000; 20 * 12], 20);
        assert_eq!(found.tiles(), 3 * 2);
        let flat = found.of(TileModel::Biquadratic);
        assert_eq!((flat.exact, flat.unmodelled), (6, 0));
        assert!((flat.mean_db() - EXACT_DB).abs() < 1e-9);
        assert_eq!([flat.min_db, flat.quantile_db(0.05), flat.quantile_db(0.95)], [f64::INFINITY; 3]);
        assert_eq!(flat.histogram(), [0; BIN_COUNT]);
    }

    #[test]
    fn a_tile_of_background_and_surface_is_no_biquadratic() {
        let mut picture = [500; 64];
        // Every other pixel, so that no line separates them.
        picture.iter_mut().step_by(2).for_each(|code| *code = u16::MAX);
        let found = measure(&picture, 8);
        for model in [TileModel::Platelet, TileModel::Biquadratic, TileModel::PlateletOrBiquadratic] {
            let none = found.of(model);
            assert_eq!((none.unmodelled, none.mean_db(), none.min_db), (1, 0.0, 0.0), "{}", model.name());
            assert_eq!(none.histogram()[0], 1);
        }
        assert_eq!(found.of(TileModel::BestOf), found.of(TileModel::Bc4w));
        assert!(found.of(TileModel::Bc4w).min_db > 40.0);
    }

    #[test]
    fn of_two_functions_the_closer_counts() {
        // The platelet fits the edge, the biquadratic the curved surface.
        let edge: Vec<u16> = (0..64).map(|at| if at % 8 > 3 { 9000 } else { 4000 + at / 8 }).collect();
        let curved: Vec<u16> = (0..64).map(|at| 20_000 + (at % 8) * (at % 8) * 9 + (at / 8) * (at / 8) * 5).collect();
        for (picture, model) in [(edge, TileModel::Platelet), (curved, TileModel::Biquadratic)] {
            let found = measure(&picture, 8);
            assert_eq!(found.of(TileModel::PlateletOrBiquadratic), found.of(model), "{}", model.name());
            let [one, other] = [TileModel::Platelet, TileModel::Biquadratic].map(|model| found.of(model).mean_db());
            assert!((one - other).abs() > 3.0, "{one} {other}");
        }
    }

    #[test]
    fn quantiles_are_ranks() {
        let mut found = PsnrDistribution::default();
        let of = |squared_error| Some(Accuracy { max_error: 1, squared_error });
        for squared_error in [0, 64, 640, 6400] {
            found.count(of(squared_error), 64);
        }
        assert_eq!([0.01, 0.25, 0.5, 0.75].map(|share| found.quantile_db(share)), [76.32, 76.32, 86.32, 96.32]);
        assert_eq!(found.quantile_db(0.76), f64::INFINITY);
        assert_eq!(found.histogram().iter().sum::<u64>(), 3);
    }
}
