//! A glTF file as parts that can be put into the world at any time.
//!
//! Enters: the bytes of a `.gltf` or `.glb` file and its folder. Leaves: a [`Stage`].

use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3};

use super::assembly::{Assembly, Channels, Part, Winding};
use super::budget::Budget;
use super::buffers::Buffers;
use super::document::{self, Parsed};
use super::folder::Folder;
use super::lights::{self, NodeLight};
use super::materials;
use super::nodes::{Local, Nodes};
use super::primitives::{self, Geometry};
use crate::error::Result;
use crate::scene::mesh::{Mesh, MeshMaterial};
use crate::scene::raycast::Light;

/// Bytes that a triangle takes in a mesh and in the tree of its boxes.
pub const TRIANGLE_BYTES: u64 = 160;
/// Bytes that a corner takes in a mesh, and on the way there.
pub const CORNER_BYTES: u64 = 80;

/// What a document shows, before it is put into the world.
#[derive(Debug)]
pub struct Stage {
    nodes: Nodes,
    instances: Vec<Instance>,
    materials: Arc<[MeshMaterial]>,
    lights: Vec<NodeLight>,
}

/// A primitive on a node.
#[derive(Debug)]
struct Instance {
    node: usize,
    geometry: Arc<Geometry>,
}

impl Stage {
    /// Reads a document.
    ///
    /// # Errors
    /// When it is broken or asks for what is not known.
    pub fn read(bytes: &[u8], path: &Path, notes: &mut Vec<String>) -> Result<Stage> {
        let Parsed { document, blob } = document::parse(bytes)?;
        let budget = Budget::new(bytes.len() as u64);
        let mut buffers = Buffers::new(document.as_json(), blob, Folder::of(path), budget);
        let nodes = Nodes::read(&document)?;
        let paints = materials::read_all(&document, &mut buffers, notes);
        let lights = lights::read(&document, &nodes.shown)?;
        let mut meshes: Vec<Option<Vec<Arc<Geometry>>>> = vec![None; document.meshes().len()];
        let mut instances = Vec::new();
        let mut skipped = 0;
        for node in document.nodes().filter(|node| nodes.shown[node.index()]) {
            let Some(mesh) = node.mesh() else { continue };
            let known = &mut meshes[mesh.index()];
            if known.is_none() {
                let mut parts = Vec::new();
                for primitive in mesh.primitives() {
                    let material = primitive.material().index().map_or(0, |index| index + 1);
                    let read =
                        primitives::read(&primitive, material as u32, paints[material].coordinates, &mut buffers);
                    let context = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
                    match read.map_err(|error| error.context(context))? {
                        Some(geometry) => parts.push(Arc::new(geometry)),
                        None => skipped += 1,
                    }
                }
                *known = Some(parts);
            }
            for geometry in known.iter().flatten() {
                let what = format_args!("node {}", node.index()).to_string();
                buffers.budget.take(geometry.triangles.len() as u64, TRIANGLE_BYTES, &what)?;
                buffers.budget.take(geometry.positions.len() as u64, CORNER_BYTES, &what)?;
                instances.push(Instance { node: node.index(), geometry: geometry.clone() });
            }
        }
        if skipped > 0 {
            notes.push(format!("{skipped} primitives of points or lines are left out: they have no surface"));
        }
        let materials = paints.into_iter().map(|paint| paint.material).collect();
        Ok(Stage { nodes, instances, materials, lights })
    }

    /// Everything that never moves.
    ///
    /// # Errors
    /// As for [`Assembly::add`].
    pub fn still(&self, notes: &mut Vec<String>) -> Result<(Mesh, Light)> {
        let locals: Vec<DMat4> = self.nodes.locals.iter().map(Local::matrix).collect();
        let to_world = self.nodes.to_world(&locals);
        let channels = self.instances.iter().fold(Channels::default(), |channels, instance| Channels {
            normals: channels.normals || !instance.geometry.normals.is_empty(),
            uvs: channels.uvs || !instance.geometry.uvs.is_empty(),
        });
        let mut assembly = Assembly::new(channels);
        for instance in &self.instances {
            add(&mut assembly, &instance.geometry, &to_world[instance.node])?;
        }
        assembly.left_out.note(notes);
        Ok((assembly.finish(self.materials.clone()), lights::place(&self.lights, &to_world)))
    }
}

/// Adds triangles that are moved as one.
fn add(assembly: &mut Assembly, geometry: &Geometry, to_world: &DMat4) -> Result<()> {
    let linear = DMat3::from_mat4(*to_world);
    let mirrored = linear.determinant() < 0.0;
    let turn = cofactors(&linear) * if mirrored { -1.0 } else { 1.0 };
    let positions: Vec<DVec3> = geometry.positions.iter().map(|p| to_world.transform_point3(p.as_dvec3())).collect();
    let normals: Vec<DVec3> = geometry.normals.iter().map(|n| turn * n.as_dvec3()).collect();
    assembly.add(&Part {
        positions: &positions,
        normals: &normals,
        uvs: &geometry.uvs,
        triangles: &geometry.triangles,
        material: geometry.material,
        winding: if mirrored { Winding::Mirrored } else { Winding::Outward },
    })
}

/// What turns normals where the matrix turns surfaces: its inverse transposed, times its determinant. It exists also
/// for what is scaled flat.
fn cofactors(matrix: &DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *matrix;
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}
