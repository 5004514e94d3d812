//! Bounding volume hierarchy over triangles: nearest hit, any hit and all hits of a ray; distance of a point.
//!
//! The tree is the compressed wide BVH of `obvhs`, in f32, in coordinates relative to the centre and half size of the mesh. Its
//! boxes are inflated by more than the rounding errors of a traversal. The tree only selects candidates: whether and where a ray
//! hits a triangle is computed by `triangle` in f64 on the original corners. Results therefore equal those of testing every
//! triangle, bit for bit.

mod build;
#[cfg(test)]
pub(crate) mod tests;

use std::cmp::Ordering;
use std::ops::Range;

use glam::{DVec2, DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;

use super::ray::{AxisBox, Ray};
use super::triangle::{self, RayFrame};

/// Inflation of boxes on each side, in half sizes of the mesh.
const INFLATION: f64 = 2e-6;
/// Distance before the first possible hit at which traversal starts, in half sizes: `obvhs` misses boxes that end within 1e-4.
const LEAD: f64 = 2.5e-4;
/// Distance from the centre, in half sizes, beyond which f64 resolves less than the inflation. For rays from farther away all
/// triangles are tested.
const FAR: f64 = 1e9;
/// Like [`FAR`], for distances of points, which are compared squared.
const FAR_POINT: f64 = 1e6;
/// Maximum coordinate of a triangle, in metres. Products of three coordinates up to this are finite; triangles beyond it are
/// skipped.
const LARGEST_M: f64 = 1e90;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Metres along the ray.
    pub distance: f64,
    pub triangle: usize,
    /// Barycentric weights of the second and third corner.
    pub barycentric: DVec2,
}

#[derive(Debug, Clone)]
pub struct Bvh {
    tree: CwBvh,
    /// Triangles in the order of the tree's leaves.
    leaves: Vec<Leaf>,
    /// The smallest box around all triangles that have area.
    pub bounds: Option<AxisBox>,
    /// `bounds`, inflated.
    clip: AxisBox,
    center: DVec3,
    /// Half of the longest edge of the box around all triangles, in metres.
    half_size: f64,
}

#[derive(Debug, Clone, Copy)]
struct Leaf {
    corners: [DVec3; 3],
    triangle: u32,
    has_area: bool,
}

impl Leaf {
    fn hit(&self, frame: &RayFrame) -> Option<TriangleHit> {
        let (distance, barycentric) = frame.intersect(&self.corners).filter(|_| self.has_area)?;
        Some(TriangleHit { distance, triangle: self.triangle as usize, barycentric })
    }
}

/// Result of a visit: continue the traversal, continue up to a distance, or end.
enum Visit {
    Continue,
    UpTo(f64),
    End,
}

impl Bvh {
    /// Returns the memory of the tree in bytes.
    pub fn bytes(&self) -> u64 {
        let CwBvh { nodes, primitive_indices, .. } = &self.tree;
        (size_of_val(&nodes[..]) + size_of_val(&primitive_indices[..]) + size_of_val(&self.leaves[..])) as u64
    }

    /// Builds the tree. Triangles that are not finite are skipped; rays miss triangles without area.
    pub fn new(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Bvh {
        let leaves: Vec<Leaf> = (0..)
            .zip(triangles)
            .filter(|(_, corners)| is_in_range(corners))
            .map(|(triangle, corners)| Leaf { corners, triangle, has_area: triangle::has_area(&corners) })
            .collect();
        let with_area = leaves.iter().filter(|leaf| leaf.has_area);
        let bounds = AxisBox::around(with_area.flat_map(|leaf| leaf.corners));
        let (center, half_size) = AxisBox::around(leaves.iter().flat_map(|leaf| leaf.corners))
            .map_or((DVec3::ZERO, 1.0), |all| (0.5 * (all.min + all.max), 0.5 * (all.max - all.min).max_element()));
        let AxisBox { min, max } = bounds.unwrap_or(AxisBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY });
        let margin = 2.0 * INFLATION * half_size;
        let clip = AxisBox { min: min - margin, max: max + margin };
        let mut bvh = Bvh { tree: CwBvh::default(), leaves, bounds, clip, center, half_size };
        let boxes: Vec<Aabb> = bvh.leaves.iter().map(|leaf| bvh.leaf_box(&leaf.corners)).collect();
        bvh.tree = build::tree(&boxes);
        bvh.leaves = bvh.tree.primitive_indices.iter().map(|&index| bvh.leaves[index as usize]).collect();
        bvh.tree.primitive_indices = Vec::new();
        bvh
    }

    /// Returns the hit of a ray on one triangle, at a distance of either sign, with the same bits as [`Self::all`].
    pub fn hit_of(ray: &Ray, triangle: usize, corners: [DVec3; 3]) -> Option<TriangleHit> {
        if !is_in_range(&corners) || !triangle::has_area(&corners) {
            return None;
        }
        let (distance, barycentric) = RayFrame::new(ray).intersect(&corners)?;
        Some(TriangleHit { distance, triangle, barycentric })
    }

    /// Returns the nearest accepted hit strictly within the range of distances, on either side of a triangle. Of equally near
    /// triangles, the one with the lowest index is hit.
    pub fn nearest(&self, ray: &Ray, range: Range<f64>, accept: impl Fn(&TriangleHit) -> bool) -> Option<TriangleHit> {
        let mut best: Option<TriangleHit> = None;
        let mut limit = range.end;
        self.walk(ray, &range, |hit| {
            let is_nearer =
                hit.distance < limit || hit.distance == limit && best.is_some_and(|best| hit.triangle < best.triangle);
            // Written so that NaN is a miss.
            if !(is_nearer && hit.distance > range.start && accept(&hit)) {
                return Visit::Continue;
            }
            best = Some(hit);
            limit = hit.distance;
            Visit::UpTo(limit)
        });
        best
    }

    /// True if there is an accepted hit strictly within the range of distances.
    pub fn any(&self, ray: &Ray, range: Range<f64>, accept: impl Fn(&TriangleHit) -> bool) -> bool {
        let mut found = false;
        self.walk(ray, &range, |hit| {
            found = hit.distance > range.start && hit.distance < range.end && accept(&hit);
            if found { Visit::End } else { Visit::Continue }
        });
        found
    }

    /// Returns all hits strictly within the range of distances, one per triangle, ordered by distance and then by index.
    pub fn all(&self, ray: &Ray, range: Range<f64>) -> Vec<TriangleHit> {
        let mut hits = Vec::new();
        self.walk(ray, &range, |hit| {
            hits.extend(Some(hit).filter(|hit| hit.distance > range.start && hit.distance < range.end));
            Visit::Continue
        });
        hits.sort_unstable_by(|a, b| {
            let by_distance = a.distance.partial_cmp(&b.distance).unwrap_or(Ordering::Equal);
            by_distance.then(a.triangle.cmp(&b.triangle))
        });
        hits
    }

    /// Returns the metres from a point to the nearest triangle; `+inf` without triangles.
    pub fn distance_m(&self, point: DVec3) -> f64 {
        let to_leaf = |leaf: &Leaf| triangle::distance_squared(leaf.corners, point);
        let local = (point - self.center) / self.half_size;
        let is_near = local.abs().max_element() <= FAR_POINT;
        if !is_near || self.tree.nodes.is_empty() {
            return self.leaves.iter().map(to_leaf).fold(f64::INFINITY, f64::min).sqrt();
        }
        let mut best = f64::INFINITY;
        // Minimum squared distance in half sizes, node, and child of the node.
        let mut open = Vec::new();
        let expand = |node: usize, open: &mut Vec<(f64, usize, usize)>| {
            let first = open.len();
            let children = (0..8).filter(|&child| !self.tree.nodes[node].is_child_empty(child));
            open.extend(children.map(|child| {
                let Aabb { min, max, .. } = self.tree.nodes[node].child_aabb(child);
                (local.distance_squared(local.clamp(min.as_dvec3(), max.as_dvec3())), node, child)
            }));
            open[first..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        };
        expand(0, &mut open);
        while let Some((least, node, child)) = open.pop() {
            if least * (self.half_size * self.half_size) >= best {
                continue;
            }
            let parent = &self.tree.nodes[node];
            if parent.is_leaf(child) {
                let (first, count) = parent.child_primitives(child);
                let leaves = &self.leaves[first as usize..(first + count) as usize];
                best = leaves.iter().map(to_leaf).fold(best, f64::min);
            } else {
                expand(parent.child_node_index(child) as usize, &mut open);
            }
        }
        best.sqrt()
    }

    /// Visits all hits within the range, and some outside of it.
    fn walk(&self, ray: &Ray, range: &Range<f64>, mut visit: impl FnMut(TriangleHit) -> Visit) {
        let frame = RayFrame::new(ray);
        let mut visit = |leaf: &Leaf| leaf.hit(&frame).map_or(Visit::Continue, &mut visit);
        let from_center = ray.origin() - self.center;
        if from_center.abs().max_element() > FAR * self.half_size {
            for leaf in &self.leaves {
                if let Visit::End = visit(leaf) {
                    return;
                }
            }
            return;
        }
        let slabs = self.clip.slabs(ray);
        let (enter, leave) = (slabs.enter(), slabs.leave());
        let is_met = enter <= leave && leave > range.start && enter < range.end;
        if !is_met || self.tree.nodes.is_empty() {
            return;
        }
        let start = enter.max(range.start) - LEAD * self.half_size;
        let scale = self.half_size.recip();
        // Rounded up, with a margin.
        let limit = |distance: f64| ((distance - start) * scale) as f32 * (1.0 + 1e-6) + 4e-6;
        // The sum turns −0 into 0, whose inverse has the sign that the box test expects.
        let direction = ray.direction().as_vec3a() + Vec3A::ZERO;
        let origin = ((from_center + start * ray.direction()) * scale).as_vec3a();
        let mut walk_ray = obvhs::ray::Ray::new(origin, direction, 0.0, limit(range.end));
        let octant = octant(direction);
        let mut stack = [(0_u32, 0_u32); build::MAX_DEPTH];
        let mut held = 0;
        // Index of the first of several sibling nodes, and one bit per sibling to visit, highest first.
        let (mut base, mut bits) = (0, 1_u32 << 31);
        loop {
            let bit = 31 - bits.leading_zeros();
            bits &= !(1 << bit);
            if bits >> 24 != 0 {
                stack[held] = (base, bits);
                held += 1;
            }
            let slot = (bit - 24) ^ (octant & 7);
            // The lowest byte marks the siblings that are inner nodes.
            let before = (bits & 0xff & !(u32::MAX << slot)).count_ones();
            let node = &self.tree.nodes[(base + before) as usize];
            let met = node.intersect_ray(&walk_ray, octant);
            let mut triangles = met & 0x00ff_ffff;
            while triangles != 0 {
                let index = node.primitive_base_idx + triangles.trailing_zeros();
                triangles &= triangles - 1;
                match visit(&self.leaves[index as usize]) {
                    Visit::Continue => {}
                    Visit::UpTo(distance) => walk_ray.tmax = limit(distance),
                    Visit::End => return,
                }
            }
            (base, bits) = (node.child_base_idx, met & 0xff00_0000 | u32::from(node.imask));
            if bits >> 24 == 0 {
                if held == 0 {
                    return;
                }
                held -= 1;
                (base, bits) = stack[held];
            }
        }
    }

    /// Returns the box of a triangle in the coordinates of the tree.
    fn leaf_box(&self, corners: &[DVec3; 3]) -> Aabb {
        let half_size = self.half_size.max(f64::MIN_POSITIVE);
        let [a, b, c] = corners.map(|corner| (corner - self.center) / half_size);
        Aabb::new((a.min(b).min(c) - INFLATION).as_vec3a(), (a.max(b).max(c) + INFLATION).as_vec3a())
    }
}

fn is_in_range(corners: &[DVec3; 3]) -> bool {
    // Written so that NaN is out of range.
    corners.iter().all(|corner| corner.is_finite() && corner.abs().max_element() <= LARGEST_M)
}

/// Returns the order in which `obvhs` visits the children of a node.
fn octant(direction: Vec3A) -> u32 {
    let forward = |axis: usize| u32::from(direction[axis] >= 0.0);
    (forward(0) << 2 | forward(1) << 1 | forward(2)) * 0x0101_0101
}
