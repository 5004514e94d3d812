//! Rays against meshes.
//!
//! Enters: a [`Mesh`]. Leaves: the nearest triangle along a ray, or whether there is any.
//!
//! The tree is the compressed wide one of `obvhs`, in f32, over boxes in coordinates of the mesh's own centre and size,
//! so that it makes no difference where the mesh lies and how large it is. The boxes are a little too large, by more
//! than all roundings on the way come to: the tree only says which triangles to try. Whether a ray meets them, and
//! where, `triangle` decides in f64 on the corners as they are; the answers are those of trying all triangles,
//! bit for bit.

mod build;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;

use super::mesh::{Mesh, Optics};
use super::primitive::{AxisBox, Ray};
use super::triangle::RayFrame;

/// How much larger boxes are than what they hold, in half sizes of the mesh, on each side.
const INFLATION: f64 = 2e-6;
/// How far before the first possible hit the walk begins, in half sizes of the mesh: `obvhs` takes boxes that end
/// within 1e-4 for missed.
const LEAD: f64 = 2.5e-4;
/// From farther than this many half sizes away, f64 resolves less than the boxes are too large by, and all triangles
/// are tried.
const FAR: f64 = 1e9;
/// Triangles with a coordinate beyond it are left out, in metres: products of three stay finite.
const LARGEST_M: f64 = 1e90;

/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshHit {
    /// Metres along the ray.
    pub distance: f64,
    /// Index of the triangle; the lowest of those that are equally near.
    pub triangle: usize,
    /// Weights of its second and third corner.
    pub barycentric: DVec2,
}

/// What stops a ray that asks whether there is anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stops {
    /// Every surface.
    Everything,
    /// Every surface but clear glass, as for light.
    Opaque,
}

/// A mesh that rays can be asked of.
#[derive(Debug, Clone)]
pub struct MeshBvh {
    mesh: Mesh,
    tree: CwBvh,
    /// Triangles in the order of the tree's leaves.
    leaves: Vec<Leaf>,
    /// Around all triangles that can be met.
    bounds: Option<AxisBox>,
    /// The same, inflated.
    clip: AxisBox,
    center: DVec3,
    /// Half of the longest edge of the bounds, metres.
    half_size: f64,
}

/// What the walk needs of a triangle, in one place.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    corners: [DVec3; 3],
    triangle: u32,
    paint: Paint,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Paint {
    Solid,
    /// Its texture decides.
    Holes,
    Glass,
    GlassWithHoles,
}

/// Whether a walk goes on, and how far along the ray it looks from now on.
enum Walk {
    On,
    Until(f64),
    Stop,
}

impl MeshBvh {
    /// Builds the tree. Triangles that are not finite, or have no area, are never met.
    pub fn new(mesh: Mesh) -> MeshBvh {
        let paints: Vec<Paint> = mesh
            .materials
            .iter()
            .map(|material| match (material.alpha_cutoff, material.optics) {
                (None, Optics::Glass { .. }) => Paint::Glass,
                (None, _) => Paint::Solid,
                (Some(_), Optics::Glass { .. }) => Paint::GlassWithHoles,
                (Some(_), _) => Paint::Holes,
            })
            .collect();
        let leaves: Vec<Leaf> = (0..mesh.triangles.len())
            .filter_map(|triangle| {
                let corners = mesh.corners(triangle);
                let paint = mesh.material_of.get(triangle).and_then(|&index| paints.get(index as usize));
                let paint = paint.copied().unwrap_or(Paint::Solid);
                sound(&corners).then_some(Leaf { corners, triangle: triangle as u32, paint })
            })
            .collect();
        let bounds = AxisBox::around(leaves.iter().flat_map(|leaf| leaf.corners));
        let (center, half_size) = bounds.map_or((DVec3::ZERO, 1.0), |bounds| {
            (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min).max_element())
        });
        let AxisBox { min, max } = bounds.unwrap_or(AxisBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY });
        let margin = 2.0 * INFLATION * half_size;
        let mut built = MeshBvh {
            mesh,
            tree: CwBvh::default(),
            leaves,
            bounds,
            clip: AxisBox { min: min - margin, max: max + margin },
            center,
            half_size,
        };
        let boxes: Vec<Aabb> = built.leaves.iter().map(|leaf| built.leaf_box(&leaf.corners)).collect();
        built.tree = build::tree(&boxes);
        built.leaves = built.tree.primitive_indices.iter().map(|&index| built.leaves[index as usize]).collect();
        built.tree.primitive_indices = Vec::new();
        built
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The smallest box around all triangles that can be met; `None` where there are none.
    pub fn bounds(&self) -> Option<AxisBox> {
        self.bounds
    }

    /// The nearest triangle beyond `min_distance` along the ray, from either side. Holes of a material's alpha are
    /// passed through.
    pub fn nearest(&self, ray: &Ray, min_distance: f64) -> Option<MeshHit> {
        self.nearest_before(ray, min_distance, f64::INFINITY)
    }

    /// [`Self::nearest`] where only what is nearer than `max_distance` counts.
    pub(super) fn nearest_before(&self, ray: &Ray, min_distance: f64, max_distance: f64) -> Option<MeshHit> {
        let frame = RayFrame::new(ray);
        let mut best: Option<MeshHit> = None;
        let mut limit = max_distance;
        self.walk(ray, min_distance, max_distance, |leaf| {
            let Some((distance, barycentric)) = frame.meet(&leaf.corners) else { return Walk::On };
            let triangle = leaf.triangle as usize;
            let nearer = distance < limit || distance == limit && best.is_some_and(|best| triangle < best.triangle);
            // Asked this way round, NaN is a miss.
            if !(nearer && distance > min_distance) || self.hole(leaf, barycentric) {
                return Walk::On;
            }
            best = Some(MeshHit { distance, triangle, barycentric });
            limit = distance;
            Walk::Until(distance)
        });
        best
    }

    /// Whether any triangle lies between `min_distance` and `max_distance` along the ray. Holes of a material's alpha
    /// are passed through, glass is not.
    pub fn occluded(&self, ray: &Ray, min_distance: f64, max_distance: f64) -> bool {
        self.stopped(ray, [min_distance, max_distance], Stops::Everything)
    }

    /// Whether something stops the ray within the range of metres.
    pub(super) fn stopped(&self, ray: &Ray, range: [f64; 2], by: Stops) -> bool {
        let [min_distance, max_distance] = range;
        let frame = RayFrame::new(ray);
        let mut found = false;
        self.walk(ray, min_distance, max_distance, |leaf| {
            if by == Stops::Opaque && matches!(leaf.paint, Paint::Glass | Paint::GlassWithHoles) {
                return Walk::On;
            }
            match frame.meet(&leaf.corners) {
                Some((distance, at)) if distance > min_distance && distance < max_distance && !self.hole(leaf, at) => {
                    found = true;
                    Walk::Stop
                }
                _ => Walk::On,
            }
        });
        found
    }

    /// Whether the triangle has a hole there.
    fn hole(&self, leaf: &Leaf, at: DVec2) -> bool {
        if matches!(leaf.paint, Paint::Solid | Paint::Glass) {
            return false;
        }
        self.mesh.is_hole(leaf.triangle as usize, at)
    }

    /// Shows `visit` every triangle that the ray may meet between the two distances, and some that it does not.
    fn walk(&self, ray: &Ray, min_distance: f64, max_distance: f64, mut visit: impl FnMut(&Leaf) -> Walk) {
        let from_center = ray.origin() - self.center;
        if from_center.abs().max_element() > FAR * self.half_size {
            for leaf in &self.leaves {
                if let Walk::Stop = visit(leaf) {
                    return;
                }
            }
            return;
        }
        let (enters, leaves) = self.clip.slabs(ray);
        let (enter, leave) = (enters.max_element(), leaves.min_element());
        let inside = enter <= leave && leave > min_distance && enter < max_distance;
        if !inside || self.tree.nodes.is_empty() {
            return;
        }
        let start = enter.max(min_distance) - LEAD * self.half_size;
        let scale = self.half_size.recip();
        // Rounded up, and then some.
        let limit = |distance: f64| ((distance - start) * scale) as f32 * (1.0 + 1e-6) + 4e-6;
        // The sum turns −0 into 0, whose inverse has the sign that boxes expect.
        let direction = ray.direction().as_vec3a() + Vec3A::ZERO;
        let origin = ((from_center + start * ray.direction()) * scale).as_vec3a();
        let mut walk_ray = obvhs::ray::Ray::new(origin, direction, 0.0, limit(max_distance));
        let octant = octant(direction);
        let mut stack = [(0_u32, 0_u32); build::MAX_DEPTH];
        let mut held = 0;
        // Index of the first of some sibling nodes, and a bit for each that is to be visited: the highest first.
        let (mut base, mut bits) = (0, 1_u32 << 31);
        loop {
            let bit = 31 - bits.leading_zeros();
            bits &= !(1 << bit);
            if bits >> 24 != 0 {
                stack[held] = (base, bits);
                held += 1;
            }
            let slot = (bit - 24) ^ (octant & 7);
            // Siblings that are nodes, not leaves, are marked in the lowest byte.
            let before = (bits & 0xff & !(u32::MAX << slot)).count_ones();
            let node = &self.tree.nodes[(base + before) as usize];
            let met = node.intersect_ray(&walk_ray, octant);
            let mut triangles = met & 0x00ff_ffff;
            while triangles != 0 {
                let index = node.primitive_base_idx + triangles.trailing_zeros();
                triangles &= triangles - 1;
                match visit(&self.leaves[index as usize]) {
                    Walk::On => {}
                    Walk::Until(distance) => walk_ray.tmax = limit(distance),
                    Walk::Stop => return,
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

    /// A triangle's box in the tree's coordinates.
    fn leaf_box(&self, corners: &[DVec3; 3]) -> Aabb {
        let local = corners.map(|corner| (corner - self.center) / self.half_size);
        let [a, b, c] = local;
        Aabb::new((a.min(b).min(c) - INFLATION).as_vec3a(), (a.max(b).max(c) + INFLATION).as_vec3a())
    }
}

/// Whether a triangle can be met: finite, and with an area.
fn sound([a, b, c]: &[DVec3; 3]) -> bool {
    // Asked this way round, NaN is too large.
    let in_range = [a, b, c].iter().all(|corner| corner.is_finite() && corner.abs().max_element() <= LARGEST_M);
    in_range && (b - a).cross(c - a) != DVec3::ZERO
}

/// In which order `obvhs` visits the children of a node.
fn octant(direction: Vec3A) -> u32 {
    let forward = |axis: usize| u32::from(direction[axis] >= 0.0);
    (forward(0) << 2 | forward(1) << 1 | forward(2)) * 0x0101_0101
}
