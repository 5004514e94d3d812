//! Reads a glTF file as a [`Stage`].

use std::path::Path;
use std::sync::Arc;

use super::animation::Animation;
use super::deform::Skin;
use super::lights;
use super::materials::shaded;
use super::options::{Play, printable};
use super::stage::{Instance, Stage};
use crate::mesh::budget::{Budget, CORNER_BYTES, TRIANGLE_BYTES};
use crate::mesh::folder::Folder;
use crate::mesh::gltf::buffers::Buffers;
use crate::mesh::gltf::document::{self, Parsed};
use crate::mesh::gltf::materials::{self, Paint};
use crate::mesh::gltf::nodes::Nodes;
use crate::mesh::gltf::primitives::{self, Geometry};
use codec::error::{Error, Result};

#[derive(Debug)]
pub struct Read {
    pub stage: Stage,
    pub animations: Vec<String>,
    pub durations_s: Vec<Option<f64>>,
    /// See [`Folder::contents`].
    pub contents: String,
}

pub fn read(bytes: &[u8], path: &Path, play: Play, notes: &mut Vec<String>) -> Result<Read> {
    let Parsed { document, blob } = document::parse(bytes)?;
    let root = document.as_json();
    let mut buffers = Buffers::new(root, blob, Folder::of(path), Budget::new(bytes.len() as u64));
    let nodes = Nodes::read(&document)?;
    let paints = materials::read_all(&document, &mut buffers, notes);
    let lights = lights::read(&document, &nodes.shown)?;
    let mut skins = Vec::new();
    for skin in document.skins() {
        let read = Skin::read(&skin, &mut buffers);
        skins.push(read.map_err(|error| error.context(format!("skin {}", skin.index())))?);
    }
    let mut meshes = Meshes { known: vec![None; document.meshes().len()], paints: &paints, skipped: 0 };
    let mut instances = Vec::new();
    for node in document.nodes().filter(|node| nodes.shown[node.index()]) {
        let Some(mesh) = node.mesh() else { continue };
        let number = node.index();
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        for geometry in meshes.get(&mesh, &mut buffers)? {
            let context = |error: Error| error.context(format!("node {number}"));
            let skin = node.skin().map(|skin| skin.index()).filter(|_| !geometry.influences.is_empty());
            buffers.budget.take(geometry.triangles.len() as u64, TRIANGLE_BYTES, "triangles").map_err(context)?;
            buffers.budget.take(geometry.positions.len() as u64, CORNER_BYTES, "corners").map_err(context)?;
            if let Some(skin) = skin {
                skins[skin].check(geometry).map_err(context)?;
            }
            let weights = weights.iter().map(|&weight| f64::from(weight)).collect();
            instances.push(Instance { node: number, skin, weights, geometry: geometry.clone(), is_moving: false });
        }
    }
    if meshes.skipped > 0 {
        notes.push(format!("{} primitives of points or lines are ignored: they have no surface", meshes.skipped));
    }

    let name = |number: usize| root.animations[number].name.clone().unwrap_or_else(|| format!("animation {number}"));
    let animations: Vec<String> = (0..root.animations.len()).map(name).collect();
    let chosen = match play {
        Play::First => (!animations.is_empty()).then_some(0),
        Play::Named(name) => Some(animations.iter().position(|other| other == name).ok_or_else(|| {
            let all = animations[..animations.len().min(20)].join(", ");
            let all = if animations.is_empty() { "none".to_string() } else { all };
            let all = printable(&format!("it has {all}"));
            Error::Usage(format!("{}: there is no animation “{name}”; {all}", path.display()))
        })?),
    };
    let animation = match chosen {
        None => Animation::default(),
        Some(number) => Animation::read(&root.animations[number], root.nodes.len(), &mut buffers)
            .map_err(|error| error.context(format!("animation {number}")))?,
    };
    if let (Play::First, [first, _, ..]) = (play, animations.as_slice()) {
        let shown: String = first.chars().take(80).collect();
        notes.push(format!("only the first of {} animations is used, “{shown}”", animations.len()));
    }
    let materials = paints.into_iter().map(shaded).collect();
    let durations_s = root.animations.iter().map(|animation| stated_duration_s(root, animation)).collect();
    notes.extend(buffers.folder.notes());
    let contents = buffers.folder.contents(bytes);
    let mut stage = Stage { nodes, instances, skins, materials, lights, animation, is_moving: false };
    stage.find_moving();
    Ok(Read { stage, animations, durations_s, contents })
}

/// Returns the maximum of the key times that the file states (glTF 2.0, section 3.6.2.5).
fn stated_duration_s(root: &gltf::json::Root, animation: &gltf::json::Animation) -> Option<f64> {
    let last = |sampler: &gltf::json::animation::Sampler| {
        let max = root.accessors.get(sampler.input.value())?.max.as_ref()?;
        max.get(0)?.as_f64().filter(|time| time.is_finite())
    };
    animation.samplers.iter().map(last).try_fold(0.0, |longest: f64, time| Some(longest.max(time?)))
}

/// Meshes; each is read when the first node uses it.
struct Meshes<'a> {
    known: Vec<Option<Vec<Arc<Geometry>>>>,
    paints: &'a [Paint],
    skipped: usize,
}

impl Meshes<'_> {
    fn get(&mut self, mesh: &gltf::Mesh, buffers: &mut Buffers) -> Result<&[Arc<Geometry>]> {
        let known = &mut self.known[mesh.index()];
        if known.is_none() {
            let mut parts = Vec::new();
            for primitive in mesh.primitives() {
                let material = primitive.material().index().map_or(0, |index| index + 1);
                let read = primitives::read(&primitive, material as u32, self.paints[material].coordinates, buffers);
                let context = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
                match read.map_err(|error| error.context(context))? {
                    Some(geometry) => parts.push(Arc::new(geometry)),
                    None => self.skipped += 1,
                }
            }
            *known = Some(parts);
        }
        Ok(known.as_deref().unwrap_or_default())
    }
}
