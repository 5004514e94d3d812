//! Reports as JSON, under the names that the CSV file has.

use serde_json::{Map, Value, json};

use super::findings::{self, Finding};
use super::knob;
use super::point::{Measured, Point};
use super::recommend::Advice;
use super::store::{self, FIGURES, Figure, Row};
use super::study::{Results, Study};
use crate::depth::tile_psnr::{BIN_DB, EXACT_DB, PsnrDistribution, TileModel, TilePsnr};

/// All of a report; `rows` are those of its points.
pub fn report(results: &Results, rows: &[&Row]) -> Value {
    let mut report = json!({
        "input": results.input,
        "command_line": results.command_line,
        "machine": results.machine,
        "version": env!("CARGO_PKG_VERSION"),
        "weights": { "compression": results.weights.compression, "decoding": results.weights.decoding },
        "studies": results.studies.iter().map(study).collect::<Vec<_>>(),
        "points": rows.iter().map(|row| point(row)).collect::<Vec<_>>(),
        "findings": findings::judge(results).iter().map(Finding::json).collect::<Vec<_>>(),
        "left_out": results.left_out,
    });
    if let Some(tiles) = &results.tiles {
        report["tiles"] = tile_psnr(tiles);
        report["tiles"]["how"] = json!(results.tiles_how);
    }
    report
}

/// A point with all of its figures.
pub fn point(row: &Row) -> Value {
    let mut value = figures(&row.measured);
    value["studies"] = json!(row.studies);
    value["command"] = json!(row.command);
    value
}

/// Advice, with the point that it speaks of.
pub fn advice(advice: &Advice<'_>, row: &Row) -> Value {
    json!({
        "kind": advice.point.point.kind.name(),
        "found": advice.misses.is_empty(),
        "misses": advice.misses,
        "command": row.command,
        "point": point(row),
    })
}

fn figures(measured: &Measured) -> Value {
    let mut value = json!({ "kind": measured.point.kind.name(), "settings": settings(&measured.point) });
    for &name in FIGURES {
        value[name] = match store::figure(measured, name) {
            Figure::None => continue,
            Figure::Count(count) => json!(count),
            Figure::Number(number) => json_number(number),
            Figure::Runs(runs) => json!(runs),
        };
    }
    value
}

fn settings(point: &Point) -> Map<String, Value> {
    point.settings.iter().map(|(name, value)| (knob::json_key(name).to_owned(), json!(value))).collect()
}

fn study(study: &Study) -> Value {
    let fixed: Map<_, _> =
        study.fixed.iter().map(|(name, value)| (knob::json_key(name).to_owned(), json!(value))).collect();
    json!({
        "name": study.name,
        "title": study.title,
        "kind": study.kind.name(),
        "axes": study.axes.iter().map(|axis| json!({ "knob": axis.knob, "values": axis.values })).collect::<Vec<_>>(),
        "fixed": fixed,
    })
}

/// PSNR of tiles by modelling function.
pub fn tile_psnr(found: &TilePsnr) -> Value {
    let model = |psnr: &PsnrDistribution| {
        json!({
            "mean_db": psnr.mean_db(),
            "min_db": json_number(psnr.min_db()),
            "p05_db": json_number(psnr.quantile_db(0.05)),
            "p50_db": json_number(psnr.quantile_db(0.5)),
            "p95_db": json_number(psnr.quantile_db(0.95)),
            "exact_tiles": psnr.exact,
            "unmodelled_tiles": psnr.unmodelled,
            "histogram": psnr.histogram(),
        })
    };
    let models: Map<_, _> = TileModel::ALL.into_iter().map(|of| (of.name().to_owned(), model(found.of(of)))).collect();
    json!({ "count": found.tiles(), "bin_db": BIN_DB, "exact_counts_as_db": EXACT_DB, "models": models })
}

fn json_number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}
