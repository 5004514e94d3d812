//! `inspect SCENE`: how large a scene is, what it is made of, and which animations its file has.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::Arc;

use serde_json::{Value, json};

use super::Args;
use crate::cli::{ExitStatus, GlobalArgs, output};
use crate::error::{Error, Result};
use crate::report::{Column, Table};
use crate::scene::{MeshMaterial, Scene, SceneAtTime};

/// An animation's name, if it has one, and its seconds, if they are known.
type Animation = (Option<String>, Option<f64>);

/// What is told of a scene, at its beginning where it moves.
struct Facts {
    /// Least and greatest corner, metres.
    bounds_m: Option<[[f64; 3]; 2]>,
    counts: [(&'static str, usize); 6],
    animations: Vec<Animation>,
    notes: Vec<String>,
}

/// Tells what a scene is.
pub fn run(args: &Args, name: &str, global: &GlobalArgs) -> Result<ExitStatus> {
    let chosen =
        !args.selection.probe.is_empty() || !args.selection.face.is_empty() || !args.selection.stream.is_empty();
    if chosen
        || args.streams
        || args.per_frame
        || args.frames.is_some()
        || args.verify
        || args.csv
        || args.plot.is_some()
    {
        return Err(Error::Usage(format!(
            "{name}: of a scene there is one table, or --json; leave out the other options"
        )));
    }
    let (scene, notes) = Scene::open(name)?;
    let facts = Facts { notes, ..Facts::of(&scene) };
    if args.json {
        return output::print_json(&facts.json(name)).map(|()| ExitStatus::Passed);
    }
    if !global.quiet {
        facts.notes.iter().for_each(output::note);
    }
    output::print_text(&facts.text(name)).map(|()| ExitStatus::Passed)
}

impl Facts {
    fn of(scene: &Scene) -> Facts {
        let moment = scene.at(0.0);
        let materials = materials(&moment);
        let images = materials.iter().flat_map(|material| [&material.base_texture, &material.emissive_texture]);
        let textures: BTreeSet<_> = images.flatten().map(Arc::as_ptr).collect();
        Facts {
            bounds_m: moment.bounds().map(|bounds| [bounds.min.to_array(), bounds.max.to_array()]),
            counts: [
                ("triangles", moment.meshes().iter().map(|mesh| mesh.mesh().triangles.len()).sum()),
                ("objects", moment.objects().len()),
                ("materials", materials.len()),
                ("textures", textures.len()),
                ("suns", moment.light().suns.len()),
                ("lamps", moment.light().lamps.len()),
            ],
            animations: animations(scene),
            notes: Vec::new(),
        }
    }

    fn json(&self, name: &str) -> Value {
        let animations: Vec<Value> =
            self.animations.iter().map(|(name, length)| json!({ "name": name, "duration_s": length })).collect();
        let mut value = json!({
            "scene": name,
            "bounds_m": self.bounds_m.map(|[min, max]| json!({ "min": min, "max": max })),
            "animations": animations,
            "notes": self.notes,
        });
        for (what, count) in self.counts {
            value[what] = count.into();
        }
        value
    }

    fn text(&self, name: &str) -> String {
        let mut out = format!("{name}\n");
        if let Some([min, max]) = self.bounds_m {
            let point = |point: [f64; 3]| point.map(|value| format!("{value:.3}")).join(", ");
            let size = [0, 1, 2].map(|axis| max[axis] - min[axis]);
            let _ = writeln!(
                out,
                "{} to {}, {} m in x, y, z",
                point(min),
                point(max),
                size.map(|m| format!("{m:.3}")).join(" x ")
            );
        }
        let mut table = Table::new(&[Column::Left("What"), Column::Right("Count")]);
        for (what, count) in self.counts {
            table.row([what.to_owned(), count.to_string()]);
        }
        let _ = write!(out, "\n{table}");
        if self.animations.is_empty() {
            out.push_str("\nNothing moves\n");
            return out;
        }
        let mut table = Table::new(&[Column::Left("Animation"), Column::Right("Seconds")]);
        for (name, length) in &self.animations {
            let length = length.map_or("-".to_owned(), |length| format!("{length:.3}"));
            table.row([name.clone().unwrap_or_else(|| "(without a name)".to_owned()), length]);
        }
        let _ = write!(out, "\n{table}");
        out
    }
}

/// Materials of triangles that there are, each once.
fn materials(moment: &SceneAtTime) -> Vec<&MeshMaterial> {
    let mut found = Vec::new();
    let mut known = BTreeSet::new();
    for mesh in moment.meshes() {
        let used: BTreeSet<u32> = mesh.mesh().material_of.iter().copied().collect();
        for material in used.into_iter().filter_map(|number| mesh.materials().get(number as usize)) {
            // What moves and what does not share one list.
            if known.insert(std::ptr::from_ref(material)) {
                found.push(material);
            }
        }
    }
    found
}

fn animations(scene: &Scene) -> Vec<Animation> {
    // Names are those of the file, and a terminal would obey some.
    let plain = |name: &str| name.replace(char::is_control, "?");
    match scene {
        Scene::Procedural(_) if scene.duration_s() > 0.0 => vec![(None, Some(scene.duration_s()))],
        Scene::Procedural(_) => Vec::new(),
        Scene::Model(model) => {
            let named = model.animations().iter().zip(model.durations_s());
            named.map(|(name, length)| (Some(plain(name)), *length)).collect()
        }
    }
}
