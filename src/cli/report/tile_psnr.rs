//! PSNR of tiles of 8x8 pixels by modelling function: histograms above, sorted curves below (GDC figure 6).

use serde_json::{Map, Value, json};

use super::plot::Figure;
use super::plot::axis::Axis;
use super::plot::chart::{Chart, Kind, Mark, Series};
use super::plot::labels::sheet;
use super::plot::marker::Look;
use codec::depth::tile_psnr::{BIN_COUNT, BIN_DB, EXACT_DB, PsnrDistribution, TILE_SIDE, TileModel, TilePsnr};
use footage::json::put;

const HISTOGRAM: [u32; 2] = [340, 280];
const CURVES: [u32; 2] = [1732, 400];
/// Number of points of a sorted curve.
const QUANTILES: u32 = 400;

/// Returns the figure of the tiles. `how` describes the modelling settings. `None` without tiles.
pub fn figure(tiles: &TilePsnr, how: &str) -> Option<Figure> {
    if tiles.tiles() == 0 {
        return None;
    }
    let shares = |psnr: &PsnrDistribution| -> Vec<(f64, f64)> {
        let percent = |count: u64| 100.0 * count as f64 / psnr.tiles.max(1) as f64;
        let bins = psnr.histogram().into_iter().enumerate();
        let bins = bins.map(|(bin, count)| ((bin as f64 + 0.5) * BIN_DB as f64, percent(count)));
        bins.chain([(f64::INFINITY, percent(psnr.exact))]).collect()
    };
    let highest = TileModel::ALL.iter().flat_map(|model| shares(tiles.of(*model))).map(|(_, share)| share);
    let y = Axis::linear("tiles (%)", highest.chain([0.0]));
    let top = (BIN_COUNT * BIN_DB) as f64;
    let db = || Axis::between("PSNR (dB)", 0.0, top, 20.0).with_infinite("exact");

    let mark = |(x, y): (f64, f64)| Mark { x, y, ..Mark::default() };
    let histogram = |(at, model): (usize, TileModel)| {
        let psnr = tiles.of(model);
        let marks = shares(psnr).into_iter().map(mark).collect();
        let title = format!("{}: mean {:.1} dB", words(model), psnr.mean_db());
        let series = vec![Series { name: String::new(), kind: Kind::Bars, look: Look::of(at), marks }];
        Chart { series, ..Chart::new(title, db(), y.clone()) }.draw(HISTOGRAM[0], HISTOGRAM[1])
    };
    let histograms = TileModel::ALL.into_iter().enumerate().map(histogram).collect();

    let curve = |(at, model): (usize, TileModel)| {
        let psnr = tiles.of(model);
        let shares = (0..=QUANTILES).map(|step| f64::from(step) / f64::from(QUANTILES));
        let marks = shares.map(|share| mark((100.0 * share, psnr.quantile_db(share)))).collect();
        // The curve of the best of several functions coincides with one of theirs, and so do the two combined curves:
        // dashes keep the curves below visible.
        let look = match model {
            TileModel::PlateletOrBiquadratic => Look::of(at).dashed([11.0, 6.0]),
            TileModel::BestOf => Look::of(at).dashed([5.0, 9.0]),
            TileModel::Bc4w | TileModel::Platelet | TileModel::Biquadratic => Look::of(at),
        };
        Series { name: words(model).to_owned(), kind: Kind::Curve, look, marks }
    };
    let across = Axis::between("tiles, sorted by PSNR (%)", 0.0, 100.0, 10.0);
    let chart = Chart {
        series: TileModel::ALL.into_iter().enumerate().map(curve).collect(),
        legend: "Function".to_owned(),
        ..Chart::new("PSNR of all tiles, sorted", across, db())
    };
    let curves = chart.draw(CURVES[0], CURVES[1]);

    let unmodelled = TileModel::ALL.map(|model| (model, tiles.of(model).unmodelled)).into_iter();
    let unmodelled = unmodelled.filter(|(_, count)| *count > 0);
    let unmodelled: Vec<String> = unmodelled.map(|(model, count)| format!("{} {count}", words(model))).collect();
    let none = match unmodelled.is_empty() {
        true => String::new(),
        false => format!(" Tiles that a function cannot model at all count as 0 dB: {}.", unmodelled.join(", ")),
    };
    let caption = format!(
        "How near each modelling function comes to {} tiles of {TILE_SIDE}x{TILE_SIDE} depths without any bound, with {how}. \
         Above, the part of the tiles in each {BIN_DB} dB; below, the tiles of each function sorted by their PSNR, \
         combinations of functions dashed. Exact tiles have a \
         place of their own, and count in the means as the least error that a tile can have.{none}",
        tiles.tiles()
    );
    let subtitle =
        format!("{} tiles of {TILE_SIDE}x{TILE_SIDE} depths, {how}, PSNR in 16-bit logarithmic codes", tiles.tiles());
    let drawing = sheet("Tiles by modelling function (GDC figure 6)", &[subtitle], vec![histograms, vec![curves]]);
    Some(Figure { name: "tile-psnr".to_owned(), caption, drawing })
}

fn words(model: TileModel) -> &'static str {
    match model {
        TileModel::Bc4w => "BC4w",
        TileModel::Platelet => "platelet",
        TileModel::Biquadratic => "biquadratic",
        TileModel::PlateletOrBiquadratic => "platelet or biquadratic",
        TileModel::BestOf => "best of all",
    }
}

pub fn json(found: &TilePsnr) -> Value {
    let model = |psnr: &PsnrDistribution| {
        let mut model = json!({
            "mean_db": psnr.mean_db(),
            "exact_tiles": psnr.exact,
            "unmodelled_tiles": psnr.unmodelled,
            "histogram": psnr.histogram(),
        });
        put(&mut model, "min_db", psnr.min_db);
        for (key, share) in [("p05_db", 0.05), ("p50_db", 0.5), ("p95_db", 0.95)] {
            put(&mut model, key, psnr.quantile_db(share));
        }
        model
    };
    let models: Map<_, _> = TileModel::ALL.into_iter().map(|of| (of.name().to_owned(), model(found.of(of)))).collect();
    json!({ "count": found.tiles(), "bin_db": BIN_DB, "exact_counts_as_db": EXACT_DB, "models": models })
}
