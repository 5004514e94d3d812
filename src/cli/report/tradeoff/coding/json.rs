//! JSON that only coding sweeps have: PSNR of tiles, recommendations.

use serde_json::{Map, Value, json};

use super::recommend::Advice;
use crate::report::tradeoff::json::point;
use codec::depth::tile_psnr::{BIN_DB, EXACT_DB, PsnrDistribution, TileModel, TilePsnr};
use footage::json::put;

pub fn advice(advice: &Advice<'_>) -> Value {
    json!({
        "kind": advice.row.measured.point.stream.map(|stream| stream.name()),
        "found": advice.misses.is_empty(),
        "misses": advice.misses,
        "command": advice.row.command,
        "point": point(advice.row),
    })
}

pub fn tile_psnr(found: &TilePsnr) -> Value {
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
