//! Builds studies from swept knobs and presets. Knobs that are swept together make one study per kind of stream: the
//! grid of all their values.

use super::kind::{CODING, KINDS, Knob, PLACEMENT, PresetAxis, PresetStudy, SweepKind};
use super::point::Setting;
use super::study::{Axis, Study, capital};
use codec::error::{Error, Result};
use codec::image::StreamKind;

#[derive(Debug, Clone)]
pub struct Sweep {
    /// First kind of sweep that has the knob.
    pub kind: &'static SweepKind,
    pub knob: &'static Knob,
    pub values: Vec<String>,
    /// False for the usual values.
    pub given: bool,
}

impl Sweep {
    /// Parses `knob=v1,v2`, or `knob` for the usual values. Does not check the values.
    pub fn parse(text: &str) -> Result<Sweep, String> {
        let (name, values) = text.split_once('=').map_or((text, None), |(name, values)| (name, Some(values)));
        let name = name.trim().trim_start_matches("--");
        let (kind, knob) = KINDS.iter().find_map(|kind| Some((&***kind, kind.knob(name)?))).ok_or_else(|| {
            let names = KINDS.map(|kind| format!("of {}: {}", kind.doing, kind.knob_names()));
            format!("'{name}' is not a knob; knobs {}", names.join("; "))
        })?;
        let given = values.is_some();
        let values = values.map_or_else(
            || knob.usual_values(),
            |values| values.split(',').map(|value| value.trim().to_owned()).collect(),
        );
        if values.iter().any(String::is_empty) {
            return Err(format!("{name} has an empty value; {name}={} was expected", knob.usual.join(",")));
        }
        if let Some(twice) = (1..values.len()).find(|&at| values[..at].contains(&values[at])) {
            return Err(format!("{name} has the value {} twice", values[twice]));
        }
        Ok(Sweep { kind, knob, values, given })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// The studies of CALF figures 7 and 8 and GDC figures 5, 6 and 8.
    Paper,
    /// Studies of `Paper` with fewer values.
    Quick,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub studies: Vec<Study>,
    /// True if depth tiles are to be modelled with each function (GDC figure 6).
    pub tiles: bool,
    /// One sentence for each study of the preset whose stream the input lacks.
    pub left_out: Vec<String>,
}

fn preset_study(of: &PresetStudy, stream: StreamKind, preset: Preset, fixed: &[Setting]) -> Result<Study> {
    let values = |axis: &PresetAxis| if preset == Preset::Quick { axis.quick } else { axis.paper };
    let axis =
        |axis: &PresetAxis| Axis { knob: axis.knob, values: values(axis).split(',').map(str::to_owned).collect() };
    let is_reduced = of.axes.iter().any(|axis| values(axis) != axis.paper);
    let few = if is_reduced { ", few values" } else { "" };
    let study = Study {
        name: of.name.to_owned(),
        title: format!("{} ({}{few})", of.title, of.figures),
        sweep: &CODING,
        stream: Some(stream),
        axes: of.axes.iter().map(axis).collect(),
        fixed: of.fixed.iter().map(|&(name, value)| (name, value.to_owned())).collect(),
    };
    with_fixed(study, fixed)
}

/// Builds the studies: those of the preset first, then one of the swept knobs for each kind of stream. `wanted` are the
/// kinds of streams of the input that were selected, `fixed` the settings of all points.
pub fn plan(wanted: &[StreamKind], sweeps: &[Sweep], preset: Option<Preset>, fixed: &[Setting]) -> Result<Plan> {
    let mut plan = Plan { studies: Vec::new(), tiles: false, left_out: Vec::new() };
    for (study, preset) in CODING.presets.iter().filter_map(|study| Some((study, preset?))) {
        let streams = study.axes.iter().filter_map(|axis| CODING.knob(axis.knob)).flat_map(|knob| &knob.streams);
        let Some(&stream) = streams.into_iter().next() else { continue };
        if wanted.contains(&stream) {
            plan.studies.push(preset_study(study, stream, preset, fixed)?);
        } else {
            let (name, stream) = (study.name, stream.name());
            plan.left_out.push(format!("Study {name} was left out: no {stream} stream was chosen or is there."));
        }
    }
    plan.tiles = preset == Some(Preset::Paper) && wanted.contains(&StreamKind::Depth);
    plan.studies.extend(swept(wanted, sweeps, fixed)?);
    if plan.studies.is_empty() {
        return Err(Error::Usage(match plan.left_out.is_empty() {
            true => "nothing to measure: add --sweep or --preset".to_owned(),
            false => "nothing to measure: the input has no streams of the kinds that the preset measures".to_owned(),
        }));
    }
    Ok(plan)
}

/// Returns a study of the swept knobs for each kind of stream that they affect.
fn swept(wanted: &[StreamKind], sweeps: &[Sweep], fixed: &[Setting]) -> Result<Vec<Study>> {
    refuse_twice(sweeps)?;
    let of_a_kind: Vec<_> = sweeps.iter().filter(|sweep| !sweep.knob.is_general()).collect();
    for Sweep { kind, knob, .. } in &of_a_kind {
        if wanted.iter().any(|kind| knob.concerns(Some(*kind))) {
            continue;
        }
        let kinds: Vec<_> = knob.streams.iter().map(|kind| kind.name()).collect();
        let why = match **kind == *PLACEMENT {
            true => "it is for placing cameras: use a scene instead of footage".to_owned(),
            false => format!("it is for {} streams, and none is selected or exists", kinds.join(" and ")),
        };
        return Err(Error::Usage(format!("sweep of {}: {why}", knob.name)));
    }
    let study = |&kind: &StreamKind| {
        let own = sweeps.iter().filter(|sweep| sweep.knob.concerns(Some(kind)));
        let axis = |sweep: &Sweep| Axis { knob: sweep.knob.name, values: sweep.values.clone() };
        let mut axes: Vec<Axis> = own.map(axis).collect();
        // Stream-specific knobs come first: the first two axes are those of heat maps.
        axes.sort_by_key(|axis| CODING.knob(axis.knob).is_some_and(Knob::is_general));
        // The name contains the swept knobs, so that sweeps of different knobs into one folder keep all their pictures.
        let knobs = axes.iter().map(|axis| axis.knob);
        let name = std::iter::once(kind.name()).chain(knobs).collect::<Vec<_>>().join("-");
        let title = title(&CODING, kind.name(), &axes);
        let study = Study { name, title, sweep: &CODING, stream: Some(kind), axes, fixed: Vec::new() };
        with_fixed(study, fixed)
    };
    let is_swept = |kind: &&StreamKind| match of_a_kind.is_empty() {
        true => !sweeps.is_empty(),
        false => of_a_kind.iter().any(|sweep| sweep.knob.concerns(Some(**kind))),
    };
    wanted.iter().filter(is_swept).map(study).collect()
}

fn refuse_twice(sweeps: &[Sweep]) -> Result<()> {
    match (1..sweeps.len()).find(|&at| sweeps[..at].iter().any(|other| other.knob.name == sweeps[at].knob.name)) {
        None => Ok(()),
        Some(twice) => Err(Error::Usage(format!(
            "sweep of {}: given twice: list all values in one sweep",
            sweeps[twice].knob.name
        ))),
    }
}

/// Returns the single study of a sweep kind whose points have no stream.
pub fn grid(kind: &'static SweepKind, sweeps: &[Sweep]) -> Result<Study> {
    refuse_twice(sweeps)?;
    let axis = |sweep: &Sweep| {
        let name = sweep.knob.name;
        let knob = kind.knob(name).ok_or_else(|| {
            Error::Usage(format!("sweep of {name}: no knob of {}, which has {}", kind.stem, kind.knob_names()))
        })?;
        // The usual values of a knob may differ between kinds.
        let values = if sweep.given { sweep.values.clone() } else { knob.usual_values() };
        Ok(Axis { knob: knob.name, values })
    };
    let axes = sweeps.iter().map(axis).collect::<Result<Vec<Axis>>>()?;
    if axes.is_empty() {
        return Err(Error::Usage(format!(
            "nothing to measure: add --sweep with knobs of {}: {}",
            kind.stem,
            kind.knob_names()
        )));
    }
    let title = title(kind, kind.stem, &axes);
    Ok(Study { name: kind.stem.to_owned(), title, sweep: kind, stream: None, axes, fixed: Vec::new() })
}

/// Returns, for example, `Depth: AABB limit × threads`.
fn title(kind: &SweepKind, of: &str, axes: &[Axis]) -> String {
    let labels: Vec<_> = axes.iter().filter_map(|axis| Some(kind.knob(axis.knob)?.label)).collect();
    format!("{}: {}", capital(of), labels.join(" × "))
}

/// Adds the given settings, then those that the study and its knobs require, unless they are given.
fn with_fixed(study: Study, given: &[Setting]) -> Result<Study> {
    let Study { sweep, stream, axes, .. } = &study;
    let concerns = |name: &str| sweep.knob(name).is_some_and(|knob| knob.concerns(*stream));
    let is_swept = |name: &str| axes.iter().any(|axis| axis.knob == name);
    // Skips knobs that imply another value than the study's, such as --depth-domain in a study of a codec other than
    // the quadtree.
    let is_of_another =
        |(name, value): &(&str, &str)| study.fixed.iter().any(|(own, fixed)| own == name && fixed != value);
    let fits = |name: &str| sweep.knob(name).is_none_or(|knob| !knob.implies.iter().any(is_of_another));
    let mut fixed: Vec<Setting> = given.iter().filter(|(name, _)| concerns(name) && fits(name)).cloned().collect();
    if let Some((name, _)) = fixed.iter().find(|(name, _)| is_swept(name)) {
        return Err(Error::Usage(format!(
            "--{name}: study {} sweeps it, so it cannot be fixed: leave it out",
            study.name
        )));
    }
    // If knobs imply different values, that of the later knob in the table applies.
    let knobs = sweep.knobs.iter().rev().filter(|knob| is_swept(knob.name));
    let implied = knobs.flat_map(|knob| knob.implies.iter().map(|&(name, value)| (name, value.to_owned())));
    for (name, value) in study.fixed.iter().cloned().chain(implied) {
        if !is_swept(name) && concerns(name) && fixed.iter().all(|(other, _)| *other != name) {
            fixed.push((name, value));
        }
    }
    Ok(Study { fixed, ..study })
}

#[cfg(test)]
mod tests {
    use super::*;
    use StreamKind::{Color, Depth, Material};

    fn of(kinds: &[StreamKind], sweeps: &[&str], fixed: &[(&'static str, &str)]) -> Result<Plan> {
        let sweeps: Vec<_> = sweeps.iter().map(|text| Sweep::parse(text).unwrap()).collect();
        let fixed: Vec<_> = fixed.iter().map(|&(name, value)| (name, value.to_owned())).collect();
        plan(kinds, &sweeps, None, &fixed)
    }

    fn points(study: &Study) -> Vec<String> {
        let words = |settings: &[(&str, String)]| {
            settings.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
        };
        study.points().iter().map(|point| words(&point.settings)).collect()
    }

    #[test]
    fn sweeps_are_parsed_or_refused_in_words() {
        let sweep = Sweep::parse("psnr=30, 40").unwrap();
        assert_eq!((sweep.knob.name, sweep.values.join("|")), ("psnr", "30|40".to_owned()));
        assert_eq!(Sweep::parse("color-cell").unwrap().values, ["8", "16", "32", "64", "128"]);
        assert!(sweep.given && !Sweep::parse("color-cell").unwrap().given);
        assert!(Sweep::parse("cells=8").unwrap_err().contains("'cells' is not a knob; knobs of coding: depth-codec, "));
        assert!(Sweep::parse("color-cell=8,,16").unwrap_err().contains("empty value"));
        assert!(Sweep::parse("color-cell=").unwrap_err().contains("empty value"));
        assert!(Sweep::parse("color-cell=8,16,8").unwrap_err().contains("value 8 twice"));
    }

    #[test]
    fn a_grid_for_each_kind_with_general_knobs_in_each() {
        let plan = of(&[Color, Depth], &["threads=1,2", "psnr=40", "max-aabbs=1,4"], &[]).unwrap();
        assert_eq!(
            plan.studies.iter().map(|study| study.name.as_str()).collect::<Vec<_>>(),
            ["color-psnr-threads", "depth-max-aabbs-threads"]
        );
        assert_eq!(points(&plan.studies[0]), ["psnr=40 threads=1", "psnr=40 threads=2"]);
        let depth = points(&plan.studies[1]);
        assert_eq!(depth.len(), 4);
        assert_eq!(depth[1], "depth-codec=aabb max-aabbs=1 threads=2");
        assert_eq!(plan.studies[1].title, "Depth: AABB limit × threads");
    }

    #[test]
    fn general_knobs_alone_are_swept_on_every_kind() {
        let plan = of(&[Color, Depth, Material], &["effort"], &[]).unwrap();
        assert_eq!(plan.studies.len(), 3);
        assert_eq!(points(&plan.studies[2]), ["effort=fast", "effort=normal"]);
    }

    #[test]
    fn implied_settings_give_way_to_swept_and_fixed_ones_and_to_other_kinds() {
        let swept = of(&[Depth], &["max-aabbs=2", "depth-codec=quadtree,aabb"], &[]).unwrap();
        assert_eq!(points(&swept.studies[0])[0], "depth-codec=quadtree max-aabbs=2");
        let fixed = of(&[Depth], &["max-aabbs=2"], &[("depth-codec", "bc4w")]).unwrap();
        assert_eq!(points(&fixed.studies[0]), ["depth-codec=bc4w max-aabbs=2"]);
        let material = of(&[Material], &["max-aabbs=2"], &[("psnr", "40")]).unwrap();
        assert_eq!(points(&material.studies[0]), ["max-aabbs=2"]);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let said = |plan: Result<Plan>| plan.unwrap_err().to_string();
        assert!(said(of(&[Depth], &["psnr"], &[])).contains("color streams"));
        assert!(said(of(&[Color], &["psnr=1", "psnr=2"], &[])).contains("given twice"));
        assert!(said(of(&[Color], &["psnr"], &[("psnr", "40")])).contains("cannot be fixed"));
        assert!(said(of(&[Color], &[], &[])).contains("nothing to measure"));
    }

    #[test]
    fn the_presets_are_grids_of_the_figures_and_skip_kinds_that_are_missing() {
        let both = &[Color, Depth];
        let paper = plan(both, &[], Some(Preset::Paper), &[]).unwrap();
        let counts: Vec<_> = paper.studies.iter().map(|study| (study.name.as_str(), study.points().len())).collect();
        assert_eq!(counts, [("boxes", 25), ("cells", 25), ("bound", 8), ("predictive", 8), ("codecs", 1)]);
        assert!(paper.tiles && paper.left_out.is_empty());
        assert_eq!(points(&paper.studies[0])[0], "depth-codec=aabb depth-window=1 max-aabbs=1");
        let inverse = plan(both, &[], Some(Preset::Paper), &[("depth-domain", "inverse".to_owned())]).unwrap();
        let of_domain = inverse.studies.iter().filter(|study| points(study)[0].contains("depth-domain=inverse"));
        assert_eq!(of_domain.map(|study| study.name.as_str()).collect::<Vec<_>>(), ["boxes", "bound", "codecs"]);
        let color = plan(&[Color], &[], Some(Preset::Paper), &[]).unwrap();
        assert_eq!((color.studies.len(), color.left_out.len(), color.tiles), (1, 4, false));
        let quick = plan(both, &[], Some(Preset::Quick), &[]).unwrap();
        for (few, all) in quick.studies.iter().zip(&paper.studies) {
            let all = points(all);
            assert!(points(few).iter().all(|point| all.contains(point)), "{}", few.name);
        }
    }
}
