//! Coding sweeps, and recommendations from their points.

use std::time::Instant;

use serde_json::{Map, Value, json};

use super::args::Args;
use super::measure::Sweeping;
use super::{input, text};
use crate::report::tile_psnr;
use crate::report::tradeoff::coding::{CODING, CodingBench};
use crate::report::tradeoff::crops::Crop;
use crate::report::tradeoff::page::Extras;
use crate::report::tradeoff::plan::{self, Preset};
use crate::report::tradeoff::point::Setting;
use crate::report::tradeoff::recommend::{Demands, recommend};
use crate::report::tradeoff::store::{Store, StoredPoint};
use crate::report::tradeoff::study::{Study, all_points};
use crate::report::tradeoff::{figures, findings, json as report};
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::error::{Error, Result};
use codec::image::StreamKind;

pub fn recommend_from_folder(args: &Args, demands: &Demands) -> Result<ExitStatus> {
    let store = Store::open(&CODING, &args.output, None)?;
    let is_chosen = |row: &&StoredPoint| {
        args.stream.is_empty() || row.measured.point.stream.is_some_and(|stream| args.stream.contains(&stream))
    };
    let rows: Vec<&StoredPoint> = store.rows.iter().filter(is_chosen).collect();
    if rows.is_empty() {
        return refuse(format!(
            "{}: no points have been measured: specify footage and --sweep",
            store.path().display()
        ));
    }
    let advised = Advised::new(&rows, demands);
    if advised.json.is_empty() {
        return refuse(advised.text.trim_end());
    }
    output::print_either(args.json, &json!({ "recommended": advised.json }), || advised.text)?;
    Ok(advised.status)
}

struct Advised {
    json: Vec<Value>,
    text: String,
    status: ExitStatus,
}

impl Advised {
    fn new(rows: &[&StoredPoint], demands: &Demands) -> Advised {
        let is_unasked = |stream: &StreamKind| {
            demands.aim(*stream).is_none() && rows.iter().any(|row| row.measured.point.stream == Some(*stream))
        };
        let unasked: Vec<StreamKind> = StreamKind::ALL.into_iter().filter(is_unasked).collect();
        let advice = recommend(rows, demands);
        let is_met = advice.iter().all(|advice| advice.misses.is_empty());
        Advised {
            json: advice.iter().map(report::advice).collect(),
            text: text::advice(&advice, &unasked),
            status: if is_met { ExitStatus::Passed } else { ExitStatus::Failed },
        }
    }
}

pub fn measure(args: &Args, path: &str, demands: Option<Demands>, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    let footage = input::open(path, &args.stream, &args.fixed, global)?;
    let streams: Vec<StreamKind> = footage.input.kinds.iter().map(|(stream, _)| *stream).collect();
    let nothing = args.sweep.is_empty() && args.preset.is_none();
    // Demands without sweeps still need some points.
    let preset = args.preset.or((nothing && demands.is_some()).then_some(Preset::Quick));
    let plan = plan::plan(&streams, &args.sweep, preset, &footage.knobs)?;
    input::check(&footage.input, &all_points(&plan.studies))?;
    let made_of = footage.input.made_of;
    let mut sweeping = Sweeping::open(args, &plan.studies[0], made_of, global)?;
    implied(&plan.studies, &footage.knobs).iter().for_each(|note| global.note(note));
    sweeping.results.left_out = plan.left_out;
    // Tiles come first, so that the points get all of the remaining time.
    let tiles = plan.tiles.then(|| input::model_tiles(&footage, args.budget_seconds, global)).transpose()?;
    let tiles = tiles.and_then(|tiles| tiles.map_err(|why| sweeping.results.left_out.push(why)).ok());
    let crops = streams.iter().filter_map(|stream| Crop::choose(&footage.source, *stream).transpose());
    let crops = crops.collect::<Result<Vec<_>>>()?;
    sweeping.measure(&plan.studies, start, |work| {
        CodingBench::new(&footage.input, work).with_crops(&crops, &args.output)
    })?;
    crops.iter().try_for_each(|crop| crop.save_source(&args.output))?;
    if input::made_of(&footage.input, &footage.source)? != made_of {
        return Err(Error::invalid(format!(
            "{path}: the footage, or lightfold, changed during the measurement: measure again with --overwrite"
        )));
    }
    let mut extras = Extras {
        figures: figures::bounds(&sweeping.results),
        findings: findings::judge(&sweeping.results, tiles.as_ref()),
    };
    let mut more = Map::new();
    if let Some(tiles) = &tiles {
        extras.figures.extend(tile_psnr::figure(tiles, &footage.tiles_how));
        let mut report = tile_psnr::json(tiles);
        report["how"] = json!(footage.tiles_how);
        more.insert("tiles".to_owned(), report);
    }
    let is_of_input = |row: &&StoredPoint| row.measured.point.stream.is_some_and(|stream| streams.contains(&stream));
    let at_hand: Vec<&StoredPoint> = sweeping.store.rows.iter().filter(is_of_input).collect();
    let advised = demands.map(|demands| Advised::new(&at_hand, &demands));
    if let Some(advised) = &advised {
        more.insert("recommended".to_owned(), json!(advised.json));
    }
    let words = advised.as_ref().map_or_else(String::new, |advised| format!("\n{}", advised.text));
    sweeping.tell(&extras, more, &words)?;
    Ok(advised.map_or(ExitStatus::Passed, |advised| advised.status))
}

/// Returns a sentence for each setting that a knob requires and that was not given.
fn implied(studies: &[Study], given: &[Setting]) -> Vec<String> {
    let mut told: Vec<String> = Vec::new();
    for study in studies {
        let knobs = study.axes.iter().filter_map(|axis| CODING.knob(axis.knob));
        for (knob, (name, value)) in knobs.flat_map(|knob| knob.implies.iter().map(move |setting| (knob, setting))) {
            let is_fixed = study.fixed.iter().any(|(other, fixed)| other == name && fixed == value);
            let stream = study.stream.map_or("", StreamKind::name);
            let sentence = format!("{stream} is measured with --{name} {value}, because {} needs it", knob.name);
            if is_fixed && given.iter().all(|(other, _)| other != name) && !told.contains(&sentence) {
                told.push(sentence);
            }
        }
    }
    told
}
