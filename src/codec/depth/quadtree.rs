//! Builds the partial quadtree over the leaves that a frame must send, bottom up (GDC 3, 6.4; depth.md 7).
//!
//! Input: a picture of codes and its dirty leaves. Output: for each place with dirty leaves the best function within the bound,
//! if any. A place is tried only if enough of its children are dirty and each of these has one function: if no function fits a
//! part of a surface, one rarely fits the whole, and large nodes take the most time.

use std::collections::HashMap;

use crate::depth::block::Block;
use crate::depth::mode_decision::{Approximation, Modelling, decide};
use crate::depth::nodes::{Grid, Node, Place, raw};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Leaf {
    /// Need not be sent. A coarser node may cover the leaf, with codes within the bound.
    #[default]
    Free,
    Dirty,
    /// Must not be covered, because another node holds the leaf.
    Held,
}

#[derive(Debug, Clone, Copy)]
pub struct DirtyLeaves<'a> {
    pub picture: &'a [u16],
    pub grid: Grid,
    /// Leaves row by row; [`Grid::leaves`] returns the number of columns and rows.
    pub leaves: &'a [Leaf],
}

/// Approximations of a frame by place: the intermediate form. Raw leaves are not included, because their codes are those of the
/// picture.
pub type Tree = HashMap<Place, Approximation>;

#[derive(Debug, Clone, Default)]
pub struct Known {
    pub tree: Tree,
    /// True for leaves that were dirty when the tree was built, row by row. A place whose dirty leaves are all among them is not
    /// searched again: if the tree has no entry for it, no function was found.
    pub leaves: Vec<bool>,
}

#[derive(Debug, Clone, Copy)]
pub struct Build<'a> {
    pub modelling: Modelling<'a>,
    /// Minimum number of dirty children, 1 to 4, for which their parent is tried.
    pub min_children: u8,
    pub known: Option<&'a Known>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Visited {
    /// No leaf of the place is dirty, and a node may cover it.
    Free,
    /// No leaf of the place is dirty, and one is held by another node.
    Held,
    One,
    Many,
}

impl DirtyLeaves<'_> {
    pub fn block(&self, place: Place) -> Block<'_> {
        Block::of(self.picture, self.grid.width as usize, place.level, place.pixel())
    }

    pub fn any(&self, place: Place) -> bool {
        self.grid.leaf_rows(place).any(|row| self.leaves[row].contains(&Leaf::Dirty))
    }

    fn all_among(&self, place: Place, others: &[bool]) -> bool {
        self.grid.leaf_rows(place).all(|row| {
            let others = others.get(row.clone()).unwrap_or_default();
            let mut pairs = self.leaves[row].iter().zip(others);
            !others.is_empty() && pairs.all(|(&leaf, &other)| leaf != Leaf::Dirty || other)
        })
    }

    fn leaf(&self, place: Place) -> Leaf {
        self.leaves[usize::from(place.y) * self.grid.leaves()[0] + usize::from(place.x)]
    }
}

pub fn build(dirty: &DirtyLeaves<'_>, settings: &Build<'_>) -> Tree {
    let mut builder = Builder { dirty, settings, tree: Tree::new() };
    builder.visit(dirty.grid.root());
    builder.tree
}

/// Returns the flat form: the coarsest nodes of the tree that cover all dirty leaves, and raw leaves where the tree has no node.
/// Nodes are in the order of the walk and do not overlap (GDC 4).
pub fn flatten(dirty: &DirtyLeaves<'_>, tree: &Tree) -> Vec<Node> {
    let mut nodes = Vec::new();
    flatten_place(dirty, tree, dirty.grid.root(), &mut nodes);
    nodes
}

fn flatten_place(dirty: &DirtyLeaves<'_>, tree: &Tree, place: Place, nodes: &mut Vec<Node>) {
    if !dirty.grid.has(place) {
        return;
    }
    if let Some(found) = tree.get(&place) {
        nodes.push(found.node);
    } else if place.level > 0 {
        place.children().into_iter().for_each(|child| flatten_place(dirty, tree, child, nodes));
    } else if dirty.leaf(place) == Leaf::Dirty {
        nodes.push(Node { place, coefficients: raw::encode(&dirty.block(place)) });
    }
}

struct Builder<'a> {
    dirty: &'a DirtyLeaves<'a>,
    settings: &'a Build<'a>,
    tree: Tree,
}

impl Builder<'_> {
    fn visit(&mut self, place: Place) -> Visited {
        if place.level == 0 {
            return match self.dirty.leaf(place) {
                Leaf::Free => Visited::Free,
                Leaf::Held => Visited::Held,
                Leaf::Dirty => Visited::One,
            };
        }
        let mut children = Vec::with_capacity(4);
        for child in place.children() {
            if self.dirty.grid.has(child) {
                children.push(self.visit(child));
            }
        }
        let dirty = children.iter().filter(|child| matches!(child, Visited::One | Visited::Many)).count();
        if dirty == 0 {
            return if children.contains(&Visited::Held) { Visited::Held } else { Visited::Free };
        }
        // If no single function fits a part of a surface, none is tried for the whole.
        let possible = children.iter().all(|child| matches!(child, Visited::One | Visited::Free));
        if possible && dirty >= children.len().min(usize::from(self.settings.min_children)) {
            let block = self.dirty.block(place);
            let modelling = &self.settings.modelling;
            let found = match self.settings.known {
                Some(known) => match known.tree.get(&place) {
                    Some(known) => known.rounded(&block, modelling),
                    None if self.dirty.all_among(place, &known.leaves) => None,
                    None => decide(&block, place, modelling),
                },
                None => decide(&block, place, modelling),
            };
            if let Some(found) = found {
                self.tree.insert(place, found);
                return Visited::One;
            }
        }
        Visited::Many
    }
}
