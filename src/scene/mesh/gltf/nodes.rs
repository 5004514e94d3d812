//! Node hierarchy (glTF 2.0, section 3.5.3).

use glam::{DMat4, DQuat, DVec3};
use gltf::Document;
use gltf::scene::Transform;

use codec::error::{Error, Result};

/// Transform to the parent: scale, then rotation, then translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    pub translation: DVec3,
    /// Unit quaternion.
    pub rotation: DQuat,
    pub scale: DVec3,
}

/// Transform to the parent, as stored in the file.
#[derive(Debug, Clone, Copy)]
pub enum Local {
    /// May contain shear.
    Matrix(DMat4),
    /// May be animated.
    Pose(Pose),
}

impl Local {
    pub fn matrix(&self) -> DMat4 {
        match self {
            Local::Matrix(matrix) => *matrix,
            Local::Pose(Pose { translation, rotation, scale }) => {
                DMat4::from_scale_rotation_translation(*scale, *rotation, *translation)
            }
        }
    }

    /// Returns the pose. The decomposition of a matrix loses its shear.
    pub fn pose(&self) -> Pose {
        match self {
            Local::Pose(pose) => *pose,
            Local::Matrix(matrix) => {
                let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
                Pose { translation, rotation, scale }
            }
        }
    }
}

#[derive(Debug)]
pub struct Nodes {
    parents: Vec<Option<usize>>,
    /// Node indices, parents first.
    order: Vec<usize>,
    pub locals: Vec<Local>,
    /// True if the node belongs to the scene that is shown.
    pub shown: Vec<bool>,
}

impl Nodes {
    /// Reads the hierarchy. The shown scene is the default scene, or else the first; without scenes, all nodes are shown. Fails
    /// if a node has two parents or is its own ancestor.
    pub fn read(document: &Document) -> Result<Nodes> {
        let count = document.nodes().len();
        let mut parents: Vec<Option<usize>> = vec![None; count];
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut locals = Vec::with_capacity(count);
        for node in document.nodes() {
            locals.push(local(&node.transform()));
            for child in node.children() {
                let (parent, child) = (node.index(), child.index());
                if let Some(other) = parents[child].replace(parent) {
                    return Err(Error::invalid(format!(
                        "node {child} is a child of node {other} and of node {parent}"
                    )));
                }
                children[parent].push(child);
            }
        }
        let roots = (0..count).filter(|&node| parents[node].is_none());
        let order = below(roots, &children);
        if order.len() < count {
            let looped = flags(&order, count).iter().position(|met| !met).unwrap_or(0);
            return Err(Error::invalid(format!("node {looped} is its own ancestor")));
        }
        let shown = match document.default_scene().or_else(|| document.scenes().next()) {
            None => vec![true; count],
            Some(scene) => {
                let mut roots: Vec<usize> = scene.nodes().map(|node| node.index()).collect();
                roots.sort_unstable();
                roots.dedup();
                if let Some((root, parent)) = roots.iter().find_map(|&root| Some((root, parents[root]?))) {
                    let message = format!("node {root} is a root of the scene, and a child of node {parent}");
                    return Err(Error::invalid(message));
                }
                flags(&below(roots.into_iter(), &children), count)
            }
        };
        Ok(Nodes { parents, order, locals, shown })
    }

    /// Hides nodes and all their descendants.
    pub fn hide(&mut self, hidden: &[usize]) {
        let mut marked = flags(hidden, self.shown.len());
        self.spread(&mut marked);
        self.shown.iter_mut().zip(marked).for_each(|(shown, hidden)| *shown &= !hidden);
    }

    /// Adds a child of a node, and returns its index.
    pub fn add_child(&mut self, parent: usize, pose: Pose) -> usize {
        let node = self.locals.len();
        self.parents.push(Some(parent));
        self.order.push(node);
        self.locals.push(Local::Pose(pose));
        self.shown.push(self.shown[parent]);
        node
    }

    /// Returns the transforms to the world, given those to the parents.
    pub fn to_world(&self, locals: &[DMat4]) -> Vec<DMat4> {
        let mut world = locals.to_vec();
        for &node in &self.order {
            if let Some(parent) = self.parents[node] {
                world[node] = world[parent] * locals[node];
            }
        }
        world
    }

    /// Returns a node and its ancestors.
    pub fn with_ancestors(&self, node: usize) -> Vec<usize> {
        std::iter::successors(Some(node), |&node| self.parents.get(node).copied().flatten()).collect()
    }

    /// Sets the flags of all descendants of flagged nodes.
    pub fn spread(&self, marked: &mut [bool]) {
        for &node in &self.order {
            marked[node] |= self.parents[node].is_some_and(|parent| marked[parent]);
        }
    }
}

/// Returns the nodes and all their descendants, parents first.
fn below(roots: impl Iterator<Item = usize>, children: &[Vec<usize>]) -> Vec<usize> {
    let mut order: Vec<usize> = roots.collect();
    let mut at = 0;
    while at < order.len() {
        order.extend_from_slice(&children[order[at]]);
        at += 1;
    }
    order
}

fn flags(marked: &[usize], count: usize) -> Vec<bool> {
    let mut flags = vec![false; count];
    marked.iter().for_each(|&node| flags[node] = true);
    flags
}

fn local(transform: &Transform) -> Local {
    match transform {
        Transform::Matrix { matrix } => Local::Matrix(DMat4::from_cols_array_2d(&matrix.map(|c| c.map(f64::from)))),
        Transform::Decomposed { translation, rotation, scale } => Local::Pose(Pose {
            translation: DVec3::from_array(translation.map(f64::from)),
            rotation: quaternion(rotation.map(f64::from)),
            scale: DVec3::from_array(scale.map(f64::from)),
        }),
    }
}

/// Returns the normalised quaternion, or the identity if its length is 0 or not finite.
pub fn quaternion(xyzw: [f64; 4]) -> DQuat {
    let length = xyzw.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length.is_finite() && length > 0.0 { DQuat::from_array(xyzw.map(|part| part / length)) } else { DQuat::IDENTITY }
}
