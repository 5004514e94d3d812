//! How far a point is from triangles, and how often a ray goes out through them.
//!
//! Enters: triangles in metres. Leaves: the distance to the nearest of them, and signed crossings, found by a tree of boxes.

use glam::DVec3;

use crate::scene::{AxisBox, Ray, RayFrame};

/// Triangles of a leaf, at most.
const LEAF: usize = 4;

/// Triangles in a tree of boxes, each node cut at the median of its longest side.
#[derive(Debug, Clone)]
pub struct TriangleTree {
    triangles: Vec<[DVec3; 3]>,
    /// Every node before its children, the nearer half of the triangles first.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone)]
struct Node {
    min: DVec3,
    max: DVec3,
    /// First of its triangles, and how many; none in a node with children.
    leaf: Option<(usize, usize)>,
    /// Index of the second child; the first follows the node.
    second: usize,
}

impl TriangleTree {
    /// Builds the tree. Triangles with corners that are not finite are left out.
    pub fn new(mut triangles: Vec<[DVec3; 3]>) -> TriangleTree {
        triangles.retain(|corners| corners.iter().all(|corner| corner.is_finite()));
        let mut nodes = Vec::new();
        let count = triangles.len();
        if count > 0 {
            build(&mut nodes, &mut triangles, 0);
        }
        TriangleTree { triangles, nodes }
    }

    /// Metres from a point to the nearest triangle, `+inf` without any.
    pub fn distance_m(&self, point: DVec3) -> f64 {
        let mut best = f64::INFINITY;
        let mut open = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(at) = open.pop() {
            let node = &self.nodes[at];
            if box_distance_squared(node, point) >= best {
                continue;
            }
            match node.leaf {
                Some((first, count)) => {
                    for corners in &self.triangles[first..first + count] {
                        best = best.min(triangle_distance_squared(*corners, point));
                    }
                }
                None => {
                    let children = [at + 1, node.second];
                    let [a, b] = children.map(|child| box_distance_squared(&self.nodes[child], point));
                    open.extend(if a <= b { [children[1], children[0]] } else { children });
                }
            }
        }
        best.sqrt()
    }

    /// How many more triangles a ray leaves by their front than by their back: the winding number of closed meshes around its
    /// origin. Every triangle counts, also where several lie in one place. `None` where one is met within `border_m` of the
    /// origin, on either side of it.
    pub fn winding(&self, ray: &Ray, border_m: f64) -> Option<i64> {
        let frame = RayFrame::new(ray);
        let mut winding = 0;
        let mut open = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(at) = open.pop() {
            let node = &self.nodes[at];
            if (AxisBox { min: node.min, max: node.max }).intersect(ray, -border_m).is_none() {
                continue;
            }
            let Some((first, count)) = node.leaf else {
                open.extend([at + 1, node.second]);
                continue;
            };
            for corners in &self.triangles[first..first + count] {
                let Some((distance, _)) = frame.meet(corners).filter(|(distance, _)| *distance >= -border_m) else {
                    continue;
                };
                if distance <= border_m {
                    return None;
                }
                let [a, b, c] = corners;
                winding += if (*b - *a).cross(*c - *a).dot(ray.direction()) > 0.0 { 1 } else { -1 };
            }
        }
        Some(winding)
    }
}

fn build(nodes: &mut Vec<Node>, triangles: &mut [[DVec3; 3]], first: usize) {
    let corners = || triangles.iter().flatten();
    let min = corners().fold(DVec3::INFINITY, |min, corner| min.min(*corner));
    let max = corners().fold(DVec3::NEG_INFINITY, |max, corner| max.max(*corner));
    let at = nodes.len();
    let leaf = (triangles.len() <= LEAF).then_some((first, triangles.len()));
    nodes.push(Node { min, max, leaf, second: 0 });
    if leaf.is_some() {
        return;
    }
    let axis = (max - min).max_position();
    let middle = |corners: &[DVec3; 3]| corners.iter().map(|corner| corner[axis]).sum::<f64>();
    let half = triangles.len() / 2;
    triangles.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    let (low, high) = triangles.split_at_mut(half);
    build(nodes, low, first);
    nodes[at].second = nodes.len();
    build(nodes, high, first + half);
}

fn box_distance_squared(node: &Node, point: DVec3) -> f64 {
    (node.min - point).max(point - node.max).max(DVec3::ZERO).length_squared()
}

/// To the triangle's plane where the point lies above it, else to the nearest edge.
fn triangle_distance_squared([a, b, c]: [DVec3; 3], point: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let above = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) >= 0.0;
    if above(a, b) && above(b, c) && above(c, a) && normal.length_squared() > 0.0 {
        let height = (point - a).dot(normal.normalize());
        return height * height;
    }
    let edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        (point - (from + share.clamp(0.0, 1.0) * along)).length_squared()
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::super::sequence::in_cube;
    use super::*;

    #[test]
    fn the_tree_finds_what_trying_all_finds() {
        let corner = |at: u64| in_cube(at) * 4.0 - 2.0;
        let triangles: Vec<[DVec3; 3]> =
            (0..300).map(|at| [0, 1, 2].map(|c| corner(at) + 0.3 * in_cube(900 + 3 * at + c))).collect();
        let tree = TriangleTree::new(triangles.clone());
        for point in (5000..5400).map(|at| in_cube(at) * 8.0 - 4.0) {
            let all = triangles.iter().map(|t| triangle_distance_squared(*t, point)).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.distance_m(point), all.sqrt());
        }
    }

    #[test]
    fn distances_to_plane_edge_and_corner() {
        let tree = TriangleTree::new(vec![[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::NAN; 3]]);
        let at = |x: f64, y: f64, z: f64| tree.distance_m(DVec3::new(x, y, z));
        assert_eq!([at(0.25, 0.25, -3.0), at(0.5, -2.0, 0.0), at(4.0, 0.0, 4.0)], [3.0, 2.0, 5.0]);
        assert_eq!(TriangleTree::new(vec![]).distance_m(DVec3::ZERO), f64::INFINITY);
        // A triangle without area is its edges.
        assert_eq!(TriangleTree::new(vec![[DVec3::ZERO, DVec3::X, DVec3::X]]).distance_m(DVec3::Y), 1.0);
    }
}
