//! A hierarchy of nodes with meshes, skins, lights and an animation: the contents of a scene file at any time.

use std::sync::Arc;

use gltf::json::animation::Property;

use super::animation::Animation;
use super::deform::{self, Carrier, Skin};
use super::lights::{self, NodeLight};
use crate::mesh::Mesh;
use crate::mesh::assembly::{Assembly, Channels, LeftOut, Part};
use crate::mesh::gltf::nodes::{Local, Nodes};
use crate::mesh::gltf::primitives::Geometry;
use crate::{Light, MeshMaterial, SceneMesh};

/// A primitive on a node.
#[derive(Debug)]
pub struct Instance {
    pub node: usize,
    pub skin: Option<usize>,
    /// Weights of the morph targets, unless animated.
    pub weights: Vec<f64>,
    pub geometry: Arc<Geometry>,
    /// True if the animation moves it; set by [`Stage::find_moving`].
    pub is_moving: bool,
}

#[derive(Debug)]
pub struct Stage {
    pub nodes: Nodes,
    pub instances: Vec<Instance>,
    pub skins: Vec<Skin>,
    pub materials: Arc<[MeshMaterial]>,
    pub lights: Vec<NodeLight>,
    pub animation: Animation,
    /// True if the animation moves anything, including lights.
    pub is_moving: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    Still,
    Moving,
}

/// Some of the instances at one time.
#[derive(Debug)]
pub struct Shown {
    pub mesh: Mesh,
    /// All lights.
    pub light: Light,
    pub left_out: LeftOut,
}

impl Stage {
    /// Adds the materials to a mesh; `None` for a mesh without triangles.
    pub fn scene_mesh(&self, mesh: Mesh) -> Option<Arc<SceneMesh>> {
        (!mesh.triangles.is_empty()).then(|| Arc::new(SceneMesh::new(mesh, self.materials.clone())))
    }

    /// Determines which instances the animation moves. A channel of constant value moves nothing.
    pub fn find_moving(&mut self) {
        let mut nodes = vec![false; self.nodes.locals.len()];
        let mut morphs = nodes.clone();
        for channel in self.animation.channels.iter().filter(|channel| !channel.is_constant()) {
            let morphing = channel.property == Property::MorphTargetWeights;
            (if morphing { &mut morphs } else { &mut nodes })[channel.node] = true;
        }
        self.nodes.spread(&mut nodes);
        let skins: Vec<bool> = self.skins.iter().map(|skin| skin.joints.iter().any(|&joint| nodes[joint])).collect();
        self.is_moving = self.lights.iter().any(|light| nodes[light.node]);
        for instance in &mut self.instances {
            let carried = instance.skin.map_or(nodes[instance.node], |skin| skins[skin]);
            instance.is_moving = carried || (morphs[instance.node] && !instance.geometry.targets.is_empty());
            self.is_moving |= instance.is_moving;
        }
    }

    /// Returns the static or moving instances, and all lights, at a time in seconds.
    pub fn at(&self, time_s: f64, which: Which) -> Shown {
        let mut poses: Vec<Local> = self.nodes.locals.clone();
        for channel in &self.animation.channels {
            if channel.property != Property::MorphTargetWeights {
                let mut pose = poses[channel.node].pose();
                channel.move_pose(time_s, &mut pose);
                poses[channel.node] = Local::Pose(pose);
            }
        }
        let locals: Vec<_> = poses.iter().map(Local::matrix).collect();
        let to_world = self.nodes.to_world(&locals);
        let joints: Vec<_> = self.skins.iter().map(|skin| skin.matrices(&to_world)).collect();
        let weights = self.animation.channels.iter().filter(|channel| channel.property == Property::MorphTargetWeights);
        let mut morphed = vec![None; self.nodes.locals.len()];
        weights.for_each(|channel| morphed[channel.node] = Some(channel.curve.at(time_s)));

        let meant = self.instances.iter().filter(|instance| instance.is_moving == (which == Which::Moving));
        let channels = meant.clone().fold(Channels::default(), |channels, instance| Channels {
            normals: channels.normals || !instance.geometry.normals.is_empty(),
            uvs: channels.uvs || !instance.geometry.uvs.is_empty(),
            colors: channels.colors || !instance.geometry.colors.is_empty(),
        });
        let mut assembly = Assembly::new(channels);
        for Instance { node, skin, weights, geometry, .. } in meant {
            let carrier = match skin {
                Some(skin) => Carrier::Joints(&joints[*skin]),
                None => Carrier::Node(&to_world[*node]),
            };
            let placed = deform::place(geometry, morphed[*node].as_ref().unwrap_or(weights), carrier);
            assembly.add(&Part {
                positions: &placed.positions,
                normals: &placed.normals,
                uvs: &geometry.uvs,
                colors: &geometry.colors,
                triangles: &geometry.triangles,
                material: geometry.material,
                winding: placed.winding,
            });
        }
        let left_out = assembly.left_out;
        Shown { mesh: assembly.finish(), light: lights::place(&self.lights, &to_world), left_out }
    }
}
