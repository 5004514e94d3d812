//! Skins and morph targets (glTF 2.0, sections 3.7.2.2 and 3.7.3).

use glam::{DMat3, DMat4, DVec3};

use crate::mesh::assembly::Winding;
use crate::mesh::gltf::buffers::Buffers;
use crate::mesh::gltf::primitives::{Geometry, Influences};
use codec::error::{Error, Result};

#[derive(Debug)]
pub struct Skin {
    /// Indices of nodes.
    pub joints: Vec<usize>,
    inverse_bind: Vec<DMat4>,
}

impl Skin {
    pub fn read(skin: &gltf::Skin, buffers: &mut Buffers) -> Result<Skin> {
        let joints: Vec<usize> = skin.joints().map(|node| node.index()).collect();
        let mut inverse_bind = vec![DMat4::IDENTITY; joints.len()];
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let read = buffers.floats::<16>(accessor.index())?;
            if read.len() < joints.len() {
                return Err(Error::invalid(format!("{} matrices for {} joints", read.len(), joints.len())));
            }
            for (matrix, read) in inverse_bind.iter_mut().zip(read) {
                *matrix = DMat4::from_cols_array(&read.map(f64::from));
            }
        }
        Ok(Skin { joints, inverse_bind })
    }

    /// Returns the transforms of the joints from the bind pose to the world.
    pub fn matrices(&self, to_world: &[DMat4]) -> Vec<DMat4> {
        self.joints.iter().zip(&self.inverse_bind).map(|(&joint, inverse)| to_world[joint] * *inverse).collect()
    }

    pub fn check(&self, geometry: &Geometry) -> Result<()> {
        for Influences { joints, weights } in &geometry.influences {
            let used = joints.as_flattened().iter().zip(weights.as_flattened()).filter(|(_, weight)| **weight > 0.0);
            if let Some(most) = used.map(|(joint, _)| *joint).max().filter(|&most| most as usize >= self.joints.len()) {
                let count = self.joints.len();
                return Err(Error::invalid(format!("a vertex refers to joint {most}, but there are {count}")));
            }
        }
        Ok(())
    }
}

#[derive(Debug, Clone, Copy)]
pub enum Carrier<'a> {
    Node(&'a DMat4),
    Joints(&'a [DMat4]),
}

/// A mesh in world space.
#[derive(Debug)]
pub struct Placed {
    pub positions: Vec<DVec3>,
    /// Not normalised; empty if the mesh has no normals.
    pub normals: Vec<DVec3>,
    pub winding: Winding,
}

/// Applies morph targets, then the transform of the node or the skin.
pub fn place(geometry: &Geometry, weights: &[f64], carrier: Carrier) -> Placed {
    let mut positions: Vec<DVec3> = geometry.positions.iter().map(|v| v.as_dvec3()).collect();
    let mut normals: Vec<DVec3> = geometry.normals.iter().map(|v| v.as_dvec3()).collect();
    for (target, &weight) in geometry.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        positions.iter_mut().zip(&target.positions).for_each(|(at, by)| *at += weight * by.as_dvec3());
        normals.iter_mut().zip(&target.normals).for_each(|(at, by)| *at += weight * by.as_dvec3());
    }
    let winding = match carrier {
        Carrier::Joints(joints) if !joints.is_empty() && !geometry.influences.is_empty() => {
            for (corner, position) in positions.iter_mut().enumerate() {
                let matrix = blend(&geometry.influences, corner, joints);
                *position = matrix.transform_point3(*position);
                if let Some(normal) = normals.get_mut(corner) {
                    *normal = turn(&DMat3::from_mat4(matrix)) * *normal;
                }
            }
            winding(&DMat3::from_mat4(joints[0]))
        }
        Carrier::Joints(_) => Winding::Outward,
        Carrier::Node(matrix) => {
            let linear = DMat3::from_mat4(*matrix);
            let turn = turn(&linear);
            positions.iter_mut().for_each(|at| *at = matrix.transform_point3(*at));
            normals.iter_mut().for_each(|normal| *normal = turn * *normal);
            winding(&linear)
        }
    };
    Placed { positions, normals, winding }
}

/// Returns the weighted mean of the matrices of a corner's joints, with normalised weights; the matrix of the first joint if
/// all weights are 0.
fn blend(influences: &[Influences], corner: usize, joints: &[DMat4]) -> DMat4 {
    let (mut matrix, mut sum) = (DMat4::ZERO, 0.0);
    for set in influences {
        for (&joint, &weight) in set.joints[corner].iter().zip(&set.weights[corner]) {
            if weight > 0.0
                && let Some(one) = joints.get(joint as usize)
            {
                matrix += *one * f64::from(weight);
                sum += f64::from(weight);
            }
        }
    }
    let first = influences.first().and_then(|set| joints.get(set.joints[corner][0] as usize));
    if sum > 0.0 { matrix * (1.0 / sum) } else { first.copied().unwrap_or(joints[0]) }
}

/// Returns the transform of normals up to scale: the inverse transpose as cofactors, which also exist for singular matrices.
fn turn(matrix: &DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *matrix;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if matrix.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}

fn winding(matrix: &DMat3) -> Winding {
    if matrix.determinant() < 0.0 { Winding::Mirrored } else { Winding::Outward }
}
