//! Cameras of glTF 2.0 (sections 3.10 and 3.11): static nodes, and nodes that are animated or have an animated ancestor. They
//! look along −Z with +Y up.
//!
//! A time of `frame / fps` seconds is a frame. Files hold single precision. The format has no off-axis frusta and no animated
//! fields of view.

use glam::{DMat4, DQuat};
use gltf::camera::Projection;
use serde_json::{Value, json};

use super::document::{Content, FileCamera, FileCameras, WriteSettings, Written, axes_of, check_count, of_camera};
use super::poses::{Track, poses, tracks};
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::Camera;
use render::camera_path::TimedCamera;
use scene::mesh::budget::Budget;
use scene::mesh::folder::Folder;
use scene::mesh::gltf::buffers::Buffers;
use scene::mesh::gltf::document::{self, Parsed};
use scene::mesh::gltf::nodes::{Local, Nodes};
use scene::mesh::gltf::write::{binary_file, perspective};
use scene::model::animation::{Animation, Channel};

/// Tolerance between the time of a key and a frame, in frames.
const NEAR_FRAME: f64 = 1e-3;
/// Frames per second where neither the film nor the caller states them.
const DEFAULT_FPS: f64 = 24.0;

pub fn read(content: &Content<'_>) -> Result<FileCameras> {
    let Parsed { document, blob, .. } = document::parse(content.bytes)?;
    let root = document.as_json();
    let budget = Budget::new(content.bytes.len() as u64);
    let mut buffers = Buffers::new(root, blob, Folder::of(content.path), budget);
    let nodes = Nodes::read(&document)?;
    let mut found = FileCameras::default();
    let with_cameras: Vec<_> =
        document.nodes().filter(|node| nodes.shown[node.index()] && node.camera().is_some()).collect();
    if with_cameras.is_empty() {
        return Ok(found);
    }
    let read = |animation| Animation::read(animation, root.nodes.len(), &mut buffers);
    let animations = root.animations.iter().map(read).collect::<Result<Vec<_>>>()?;
    let fps = content.settings.fps.unwrap_or(DEFAULT_FPS);
    for node in with_cameras {
        let Some(lens) = node.camera() else { continue };
        let name = node.name().map_or_else(|| node.index().to_string(), str::to_owned);
        let mut chain = nodes.with_ancestors(node.index());
        chain.reverse();
        let channels = channels_of(&animations, &chain, &name, &mut found.notes);
        let moving = Moving { nodes: &nodes, chain, channels, fps };
        let poses = moving.poses(&lens.projection(), found.cameras.len());
        let named = |(camera, frames)| FileCamera {
            name: node.name().unwrap_or_default().to_owned(),
            size: None,
            timed: TimedCamera { camera, frames },
        };
        found.add(&name, poses.map(|poses| poses.into_iter().map(named).collect()));
    }
    Ok(found)
}

/// Returns the channels of all animations that move nodes of a chain; of two that move the same property, the first.
fn channels_of(animations: &[Animation], chain: &[usize], name: &str, notes: &mut Vec<String>) -> Vec<Channel> {
    let mut all: Vec<Channel> = Vec::new();
    for (at, animation) in animations.iter().enumerate() {
        let own: Vec<&Channel> = animation.channels.iter().filter(|channel| chain.contains(&channel.node)).collect();
        let is_same = |a: &Channel, b: &Channel| a.node == b.node && a.property == b.property;
        if own.iter().any(|channel| all.iter().any(|other| is_same(channel, other))) {
            notes.push(format!("animation {at} of camera {name} was left out: an earlier one moves the same node"));
            continue;
        }
        all.extend(own.into_iter().cloned());
    }
    all
}

/// A node with its ancestors, each the parent of the next, and the channels that move them.
struct Moving<'a> {
    nodes: &'a Nodes,
    chain: Vec<usize>,
    channels: Vec<Channel>,
    fps: f64,
}

impl Moving<'_> {
    /// Returns the camera at the end of the chain: one, or one for each frame of its animation. `count` is the number of poses
    /// of other cameras.
    fn poses(&self, lens: &Projection<'_>, count: usize) -> Result<Vec<(Camera, Option<FrameRange>)>> {
        let Projection::Perspective(lens) = lens else { return Err(Error::unsupported("it is orthographic")) };
        let (half_v, aspect) = ((f64::from(lens.yfov()) / 2.0).tan(), f64::from(lens.aspect_ratio().unwrap_or(1.0)));
        let at = |time_s: f64| -> Result<Camera> {
            let (eye, axes) = axes_of(&to_world(self.nodes, &self.chain, &self.channels, time_s))?;
            Camera::with_window(eye, axes, [half_v * aspect, half_v], [0.0; 2])
        };
        let ends = self.channels.iter().map(Channel::ends_s).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        let Some([first_s, last_s]) = ends else { return Ok(vec![(at(0.0)?, None)]) };
        let first = (first_s * self.fps - NEAR_FRAME).ceil().max(0.0);
        let last = (last_s * self.fps + NEAR_FRAME).floor().max(first);
        if last > f64::from(u32::MAX) {
            return Err(Error::unsupported(format!("its animation ends after {last_s} seconds")));
        }
        check_count(count, last - first + 1.0)?;
        let frames = first as u32..=last as u32;
        frames
            .map(|at_frame| {
                let range = FrameRange { first: at_frame, last: at_frame };
                Ok((at(f64::from(at_frame) / self.fps)?, Some(range)))
            })
            .collect()
    }
}

/// Returns the world matrix at a time of the last node of `chain`, in which each node is a child of the previous one.
fn to_world(nodes: &Nodes, chain: &[usize], channels: &[Channel], time_s: f64) -> DMat4 {
    let local = |&node: &usize| {
        let mut own = channels.iter().filter(|channel| channel.node == node).peekable();
        if own.peek().is_none() {
            return nodes.locals[node].matrix();
        }
        let mut pose = nodes.locals[node].pose();
        own.for_each(|channel| channel.move_pose(time_s, &mut pose));
        Local::Pose(pose).matrix()
    };
    chain.iter().map(local).fold(DMat4::IDENTITY, |world, local| world * local)
}

/// Writes a `.glb` file.
pub fn write(cameras: &[FileCamera], settings: &WriteSettings) -> Result<Written> {
    let mut file = Parts::default();
    for track in tracks(&poses(cameras)?) {
        file.add(&track, settings.fps).map_err(of_camera(&track.name))?;
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "lightfold" },
        "scene": 0,
        "scenes": [{ "nodes": (0..file.nodes.len()).collect::<Vec<usize>>() }],
        "nodes": file.nodes,
        "cameras": file.cameras,
    });
    if !file.channels.is_empty() {
        root["animations"] = json!([{ "channels": file.channels, "samplers": file.samplers }]);
        root["accessors"] = file.accessors.into();
        root["bufferViews"] = file.views.into();
    }
    let mut bytes = Vec::new();
    binary_file(root, &file.bytes, &mut bytes)?;
    Ok(Written::File(bytes))
}

#[derive(Default)]
struct Parts {
    nodes: Vec<Value>,
    cameras: Vec<Value>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    bytes: Vec<u8>,
}

impl Parts {
    fn add(&mut self, Track { name, keys }: &Track, fps: f64) -> Result<()> {
        let Some((_, first)) = keys.first() else { return Ok(()) };
        if keys.iter().any(|(_, camera)| camera.middle() != [0.0; 2]) {
            return Err(Error::unsupported("glTF cannot store its off-axis window: use transforms, colmap or usd"));
        }
        let is_same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b;
        let changes =
            |(_, camera): &(Option<u32>, Camera)| (0..2).any(|axis| !is_same(camera.half()[axis], first.half()[axis]));
        if keys.iter().any(changes) {
            return Err(Error::unsupported("glTF cannot store its animated field of view: use usd"));
        }
        let node = self.nodes.len();
        let turn = first.orientation().unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let [camera, translation] = [json!(self.cameras.len()), json!(first.eye().to_array())];
        self.nodes.push(json!({ "name": name, "camera": camera, "translation": translation, "rotation": turn }));
        self.cameras.push(json!({ "name": name, "type": "perspective", "perspective": perspective(first) }));
        let frames: Option<Vec<u32>> = keys.iter().map(|(frame, _)| *frame).collect();
        let Some(frames) = frames else { return Ok(()) };
        let times: Vec<f32> = frames.iter().map(|&frame| (f64::from(frame) / fps) as f32).collect();
        if !times.is_sorted_by(|a, b| a < b) {
            return Err(Error::unsupported("its frames are too close to each other for single-precision times"));
        }
        let input = self.accessor("SCALAR", &times);
        let eyes: Vec<f32> =
            keys.iter().flat_map(|(_, camera)| camera.eye().to_array()).map(|part| part as f32).collect();
        let mut turns: Vec<f32> = Vec::new();
        let mut before = DQuat::IDENTITY;
        for (_, camera) in keys {
            let turn = camera.orientation().map_or(DQuat::IDENTITY, DQuat::from_array);
            // A quaternion and its negative are the same rotation; the one nearer to the previous pose is chosen.
            let turn = if turn.dot(before) < 0.0 { -turn } else { turn };
            turns.extend(turn.to_array().map(|part| part as f32));
            before = turn;
        }
        for (path, kind, values) in [("translation", "VEC3", eyes), ("rotation", "VEC4", turns)] {
            let output = self.accessor(kind, &values);
            let sampler = self.samplers.len();
            self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
            self.channels.push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
        }
        Ok(())
    }

    /// Adds values; returns the index of their accessor.
    fn accessor(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 1,
        };
        let length = 4 * values.len();
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": length }));
        self.bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let view = self.views.len() - 1;
        let mut accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": values.len() / width, "type": kind });
        if let ("SCALAR", Some(first), Some(last)) = (kind, values.first(), values.last()) {
            accessor["min"] = json!([first]);
            accessor["max"] = json!([last]);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
