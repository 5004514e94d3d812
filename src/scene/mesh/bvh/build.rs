//! Builds the tree top-down by the surface area heuristic. Nodes that are deep or whose primitives have the same centre are split
//! into halves of equal count instead, so that the depth is at most 60 and the time O(n log n) for any input. The bottom-up
//! builder of `obvhs` joins only one pair of concentric boxes per pass, which takes quadratic time and unbounded recursion
//! (copies of a triangle, nested shells). The tree does not depend on the number of threads.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;

/// Levels below the root that are split by the heuristic; at most 32 levels of halves follow.
const GUIDED_LEVELS: u32 = 28;
/// Maximum path length of the tree.
pub(super) const MAX_DEPTH: usize = GUIDED_LEVELS as usize + 32;
/// Number of bins along each axis of a node.
const BINS: usize = 16;
/// Minimum number of primitives of a node that is built in parallel.
const PARALLEL: usize = 8192;
/// Maximum number of primitives in a leaf of the wide tree.
const LEAF: u32 = 3;

/// Builds the tree over finite boxes. Its `primitive_indices` are the primitives in the order of its leaves.
pub(super) fn tree(boxes: &[Aabb]) -> CwBvh {
    if boxes.is_empty() {
        return CwBvh::default();
    }
    let mut order: Vec<Item> =
        boxes.iter().enumerate().map(|(index, &bounds)| Item { bounds, index: index as u32 }).collect();
    let mut nodes = vec![Bvh2Node::default(); 2 * boxes.len() - 1];
    if let Some((root, below)) = nodes.split_first_mut() {
        divide(&mut order, root, below, Place { primitive: 0, below: 1, level: 0 });
    }
    let binary = Bvh2 {
        nodes,
        primitive_indices: order.iter().map(|item| item.index).collect(),
        children_are_ordered_after_parents: true,
        max_depth: MAX_DEPTH,
        ..Bvh2::default()
    };
    bvh2_to_cwbvh(&binary, LEAF, true, false)
}

#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    index: u32,
}

impl Item {
    /// Returns twice the centre.
    fn middle(&self) -> Vec3A {
        self.bounds.min + self.bounds.max
    }
}

/// Position of a node in the arrays, and its level.
#[derive(Clone, Copy)]
struct Place {
    primitive: u32,
    /// Index of the first node below it.
    below: u32,
    level: u32,
}

/// Makes `root` the node of all `items`, and fills `below`, which holds exactly the nodes under `root`.
fn divide(items: &mut [Item], root: &mut Bvh2Node, below: &mut [Bvh2Node], place: Place) {
    let bounds = items.iter().fold(Aabb::empty(), |bounds, item| bounds.union(&item.bounds));
    let ([left, right, rest @ ..], true) = (below, items.len() > 1) else {
        *root = Bvh2Node::new(bounds, 1, place.primitive);
        return;
    };
    *root = Bvh2Node::new(bounds, 0, place.below);
    let parallel = items.len() >= PARALLEL;
    let count = split(items, place.level);
    let (first, second) = items.split_at_mut(count);
    let (below_first, below_second) = rest.split_at_mut(2 * count - 2);
    let level = place.level + 1;
    let at_first = Place { primitive: place.primitive, below: place.below + 2, level };
    let at_second = Place { primitive: place.primitive + count as u32, below: place.below + 2 * count as u32, level };
    let mut run_first = || divide(first, left, below_first, at_first);
    let mut run_second = || divide(second, right, below_second, at_second);
    if parallel {
        rayon::join(run_first, run_second);
    } else {
        run_first();
        run_second();
    }
}

/// Moves the items of the first child to the front and returns their number: at least one, but not all.
fn split(items: &mut [Item], level: u32) -> usize {
    let (low, high) = items.iter().fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), item| {
        (low.min(item.middle()), high.max(item.middle()))
    });
    let extent = high - low;
    if items.len() > 2
        && level < GUIDED_LEVELS
        && extent.max_element() > 0.0
        && let Some((axis, bin)) = best_cut(items, low, extent)
    {
        let scale = bins_per_unit(extent)[axis];
        let in_first = |item: &Item| bin_of(item.middle()[axis] - low[axis], scale) < bin;
        return partition(items, in_first);
    }
    let axis = extent.max_position();
    let half = items.len() / 2;
    items
        .select_nth_unstable_by(half, |a, b| a.middle()[axis].total_cmp(&b.middle()[axis]).then(a.index.cmp(&b.index)));
    half
}

fn bins_per_unit(extent: Vec3A) -> Vec3A {
    // On an axis without extent, all items fall into bin 0.
    Vec3A::splat(BINS as f32) / extent.max(Vec3A::splat(1e-30))
}

/// Returns the bin of an offset. The cast to an integer saturates.
fn bin_of(offset: f32, scale: f32) -> usize {
    ((offset * scale) as usize).min(BINS - 1)
}

/// Returns the axis and bin of the cut with minimum cost: half of the surface area times the number of primitives, summed over
/// both sides.
fn best_cut(items: &[Item], low: Vec3A, extent: Vec3A) -> Option<(usize, usize)> {
    let scale = bins_per_unit(extent);
    let mut bins = [[(Aabb::empty(), 0_u32); BINS]; 3];
    for item in items {
        let at = (item.middle() - low) * scale;
        for axis in 0..3 {
            let bin = &mut bins[axis][(at[axis] as usize).min(BINS - 1)];
            bin.0 = bin.0.union(&item.bounds);
            bin.1 += 1;
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut above = [0.0_f32; BINS];
        let (mut bounds, mut count) = (Aabb::empty(), 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.union(&bins[bin].0);
            count += bins[bin].1;
            above[bin] = if count == 0 { f32::INFINITY } else { bounds.half_area() * count as f32 };
        }
        let (mut bounds, mut count) = (Aabb::empty(), 0);
        for bin in 1..BINS {
            bounds = bounds.union(&bins[bin - 1].0);
            count += bins[bin - 1].1;
            let cost = if count == 0 { f32::INFINITY } else { bounds.half_area() * count as f32 + above[bin] };
            if cost.is_finite() && best.is_none_or(|best| cost < best.0) {
                best = Some((cost, axis, bin));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}

/// Moves items for which `first` is true to the front and returns their number. The order is deterministic.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for index in 0..items.len() {
        if first(&items[index]) {
            items.swap(count, index);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::bvh::tests::Numbers;

    fn around(center: Vec3A, half: f32) -> Aabb {
        Aabb::new(center - half, center + half)
    }

    /// Checks that every primitive lies in one leaf, and returns the length of the longest path.
    fn check(boxes: &[Aabb]) -> usize {
        let tree = tree(boxes);
        let mut seen = tree.primitive_indices.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..boxes.len() as u32));
        let mut deepest = 0;
        let mut open = vec![(0_usize, 1_usize)];
        while let Some((node, depth)) = open.pop() {
            deepest = deepest.max(depth);
            let node = &tree.nodes[node];
            for child in (0..8).filter(|&child| !node.is_child_empty(child) && !node.is_leaf(child)) {
                open.push((node.child_node_index(child) as usize, depth + 1));
            }
        }
        deepest
    }

    #[test]
    fn depth_is_bounded_however_boxes_lie() {
        assert_eq!(check(&[around(Vec3A::ZERO, 1.0)]), 1);
        let same = vec![around(Vec3A::splat(0.3), 0.1); 50_000];
        assert!(check(&same) <= 20);
        let nested: Vec<Aabb> = (0..50_000).map(|i| around(Vec3A::ZERO, 1e-5 * (i + 1) as f32)).collect();
        assert!(check(&nested) <= 20);
        // Positions shrink geometrically, so that every guided cut separates only a few boxes.
        let shrinking: Vec<Aabb> = (0..200).map(|i| around(Vec3A::X * 0.5_f32.powi(i / 2), 1e-9)).collect();
        assert!(check(&shrinking) <= MAX_DEPTH);
        let strip: Vec<Aabb> = (0..1 << 16).map(|i| around(Vec3A::X * (i as f32 / 65536.0), 0.5 / 65536.0)).collect();
        assert!(check(&strip) <= 20);
    }

    #[test]
    fn threads_do_not_matter() {
        let mut numbers = Numbers::new(1);
        let boxes: Vec<Aabb> = (0..40_000).map(|_| around(numbers.point().as_vec3a(), 0.001)).collect();
        let trees = [1, 3].map(|threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| tree(&boxes))
        });
        assert_eq!(trees[0], trees[1]);
    }
}
