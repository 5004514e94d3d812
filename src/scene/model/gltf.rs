//! Reads a glTF file as a [`Stage`].

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::animation::Animation;
use super::deform::Skin;
use super::lights;
use super::materials::shaded;
use super::options::{Play, printable};
use super::stage::{Instance, Stage};
use crate::mesh::budget::{Budget, CORNER_BYTES, TRIANGLE_BYTES};
use crate::mesh::folder::Folder;
use crate::mesh::gltf::buffers::Buffers;
use crate::mesh::gltf::document::{self, Parsed, Transforms};
use crate::mesh::gltf::materials::{self, Paint};
use crate::mesh::gltf::nodes::{Nodes, Pose, quaternion};
use crate::mesh::gltf::primitives::{self, Geometry};
use codec::error::{Error, Result};
use footage::account::Account;

#[derive(Debug)]
pub struct Read {
    pub stage: Stage,
    pub animations: Vec<String>,
    pub durations_s: Vec<Option<f64>>,
    /// See [`Folder::contents`].
    pub contents: String,
}

pub fn read(bytes: &[u8], path: &Path, play: Play, account: &mut Account) -> Result<Read> {
    let Parsed { document, blob, hidden, instanced, ignored } = document::parse(bytes)?;
    let notes = &mut account.left_out;
    notes.extend(ignored.iter().map(|name| format!("the extension {name} is ignored")));
    let root = document.as_json();
    let mut buffers = Buffers::new(root, blob, Folder::of(path), Budget::new(bytes.len() as u64));
    let mut nodes = Nodes::read(&document)?;
    nodes.hide(&hidden);
    let paints = materials::read_all(&document, &mut buffers, notes);
    let lights = lights::read(&document, &nodes.shown)?;
    let mut skins = Vec::new();
    for skin in document.skins() {
        let read = Skin::read(&skin, &mut buffers);
        skins.push(read.map_err(|error| error.context(format!("skin {}", skin.index())))?);
    }
    let mut meshes = Meshes { known: vec![None; document.meshes().len()], paints: &paints, skipped: 0 };
    let mut instances = Vec::new();
    let mut copies = BTreeMap::new();
    for (node, transforms) in &instanced {
        let poses = instance_poses(transforms, &mut buffers).map_err(|error| error.context(format!("node {node}")))?;
        copies.insert(*node, poses.into_iter().map(|pose| nodes.add_child(*node, pose)).collect::<Vec<_>>());
    }
    for node in document.nodes().filter(|node| nodes.shown[node.index()]) {
        let Some(mesh) = node.mesh() else { continue };
        let number = node.index();
        let places = copies.remove(&number).unwrap_or_else(|| vec![number]);
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        for geometry in meshes.get(&mesh, &mut buffers)? {
            let context = |error: Error| error.context(format!("node {number}"));
            let skin = node.skin().map(|skin| skin.index()).filter(|_| !geometry.influences.is_empty());
            let count = places.len() as u64;
            let (triangles, corners) = (geometry.triangles.len() as u64, geometry.positions.len() as u64);
            buffers.budget.take(count * triangles, TRIANGLE_BYTES, "triangles").map_err(context)?;
            buffers.budget.take(count * corners, CORNER_BYTES, "corners").map_err(context)?;
            if let Some(skin) = skin {
                skins[skin].check(geometry).map_err(context)?;
            }
            let weights: Vec<f64> = weights.iter().map(|&weight| f64::from(weight)).collect();
            instances.extend(places.iter().map(|&node| Instance {
                node,
                skin,
                weights: weights.clone(),
                geometry: geometry.clone(),
                is_moving: false,
            }));
        }
    }
    if meshes.skipped > 0 {
        notes.push(format!("{} primitives of points or lines are ignored: they have no surface", meshes.skipped));
    }

    let name = |number: usize| root.animations[number].name.clone().unwrap_or_else(|| format!("animation {number}"));
    let animations: Vec<String> = (0..root.animations.len()).map(name).collect();
    let of_name = |name: &str| animations.iter().position(|other| other == name);
    let chosen = match play {
        Play::All => 0..animations.len(),
        Play::Named(name) => match of_name(name) {
            Some(at) => at..at + 1,
            None => {
                let all = animations[..animations.len().min(20)].join(", ");
                let all = if animations.is_empty() { "none".to_string() } else { all };
                let all = printable(&format!("it has {all}"));
                return Err(Error::Usage(format!("{}: there is no animation “{name}”; {all}", path.display())));
            }
        },
    };
    let (animation, left_out) = together(chosen.clone(), &mut buffers)?;
    let why = |at: usize| match chosen.contains(&at) {
        true => "others move the same nodes; choose one by its name",
        false => "another was chosen",
    };
    let silent = (0..animations.len()).filter(|at| !chosen.contains(at) || left_out.contains(at));
    notes.extend(silent.map(|at| {
        let shown: String = animations[at].chars().take(80).collect();
        format!("the animation “{shown}” was left out: {}", why(at))
    }));
    let played = (0..animations.len()).filter(|at| chosen.contains(at) && !left_out.contains(at));
    let played: Vec<String> = played.map(|at| animations[at].clone()).collect();
    let materials = paints.into_iter().map(shaded).collect();
    let durations_s = root.animations.iter().map(|animation| stated_duration_s(root, animation)).collect();
    notes.extend(buffers.folder.notes());
    let contents = buffers.folder.contents(bytes);
    add_nodes(account, &document, &nodes);
    account.add("animation", played);
    account.add("file", buffers.folder.files());
    let mut stage = Stage { nodes, instances, skins, materials, lights, animation, is_moving: false };
    stage.find_moving();
    Ok(Read { stage, animations, durations_s, contents })
}

/// Adds the nodes with meshes and lights that are shown, and their materials; nodes that are not shown and cameras are left out.
fn add_nodes(account: &mut Account, document: &::gltf::Document, nodes: &Nodes) {
    let name = |node: &::gltf::Node| node.name().map_or_else(|| format!("node {}", node.index()), str::to_owned);
    let is_shown = |node: &::gltf::Node| nodes.shown[node.index()];
    let is_drawn = |node: &::gltf::Node| node.mesh().is_some() || node.light().is_some();
    let with_mesh = || document.nodes().filter(|node| is_shown(node) && node.mesh().is_some());
    account.add("node", with_mesh().map(|node| name(&node)));
    let material = |material: &::gltf::Material| {
        Some(material.name().map_or(format!("material {}", material.index()?), str::to_owned))
    };
    let meshes = || with_mesh().filter_map(|node| node.mesh());
    let shown: BTreeSet<usize> = meshes().map(|mesh| mesh.index()).collect();
    let of_meshes =
        meshes().flat_map(|mesh| mesh.primitives().map(|primitive| primitive.material()).collect::<Vec<_>>());
    let painted: BTreeSet<Option<usize>> = of_meshes.map(|material| material.index()).collect();
    let (used, unused): (Vec<_>, Vec<_>) = document.materials().partition(|one| painted.contains(&one.index()));
    account.add("material", used.iter().filter_map(material));
    let unused = unused.iter().filter_map(material);
    account
        .left_out
        .extend(unused.map(|name| format!("the material {name} was left out: nothing that is shown has it")));
    for mesh in document.meshes().filter(|mesh| !shown.contains(&mesh.index())) {
        let name = mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
        account.left_out.push(format!("the mesh {name} was left out: no node shows it"));
    }
    account
        .add("light", document.nodes().filter(|node| is_shown(node) && node.light().is_some()).map(|node| name(&node)));
    let hidden = document.nodes().filter(|node| is_drawn(node) && !is_shown(node));
    account.left_out.extend(hidden.map(|node| format!("{} is hidden, or not in the scene that is shown", name(&node))));
    let cameras = document.nodes().filter(|node| node.camera().is_some());
    account
        .left_out
        .extend(cameras.map(|node| format!("the camera {} is ignored: lightfold cameras reads it", name(&node))));
}

/// Joins animations that move different nodes or properties. Returns the numbers of those that are left out because an earlier
/// one moves the same property of a node.
fn together(chosen: Range<usize>, buffers: &mut Buffers) -> Result<(Animation, Vec<usize>)> {
    let root = buffers.root;
    let (mut all, mut left_out, mut taken) = (Animation::default(), Vec::new(), BTreeSet::new());
    for number in chosen {
        let context = |error: Error| error.context(format!("animation {number}"));
        let animation = Animation::read(&root.animations[number], root.nodes.len(), buffers).map_err(context)?;
        let targets: Vec<(usize, u8)> =
            animation.channels.iter().map(|channel| (channel.node, channel.property as u8)).collect();
        if targets.iter().any(|target| taken.contains(target)) {
            left_out.push(number);
            continue;
        }
        taken.extend(targets);
        all.duration_s = all.duration_s.max(animation.duration_s);
        all.channels.extend(animation.channels);
    }
    Ok((all, left_out))
}

/// Returns the transforms of the instances of a mesh, relative to its node (EXT_mesh_gpu_instancing).
fn instance_poses(transforms: &Transforms, buffers: &mut Buffers) -> Result<Vec<Pose>> {
    let translations = transforms.translation.map(|at| buffers.floats::<3>(at)).transpose()?;
    let rotations = transforms.rotation.map(|at| buffers.floats::<4>(at)).transpose()?;
    let scales = transforms.scale.map(|at| buffers.floats::<3>(at)).transpose()?;
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let count = counts.into_iter().flatten().max().unwrap_or(0);
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(Error::invalid("its instances have lists of different lengths"));
    }
    let vector = |list: &Option<Vec<[f32; 3]>>, at: usize, usual: DVec3| {
        list.as_ref().map_or(usual, |list| DVec3::from_array(list[at].map(f64::from)))
    };
    let pose = |at: usize| Pose {
        translation: vector(&translations, at, DVec3::ZERO),
        rotation: rotations.as_ref().map_or(DQuat::IDENTITY, |list| quaternion(list[at].map(f64::from))),
        scale: vector(&scales, at, DVec3::ONE),
    };
    Ok((0..count).map(pose).collect())
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
