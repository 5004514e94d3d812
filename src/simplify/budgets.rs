//! Budgets of drawing, and what tiles use of them (Seurat 4).

use super::cost::{TilingCost, VIEWS};
use super::tree::TreeCell;

/// Limits of the drawing cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budgets {
    pub triangles: f64,
    /// Area in units of the whole sphere.
    pub area: f64,
    /// Limit of the mean overdraw of each view.
    pub peak_overdraw: f64,
}

/// Number of constraints: triangles, area, and the overdraw of each view.
pub const CONSTRAINTS: usize = 2 + VIEWS;
pub type Use = [f64; CONSTRAINTS];

impl Budgets {
    pub fn capacity(&self) -> Use {
        let mut capacity = [self.peak_overdraw; CONSTRAINTS];
        (capacity[0], capacity[1]) = (self.triangles, self.area);
        capacity
    }

    pub fn scaled(&self, by: f64) -> Budgets {
        Budgets { triangles: by * self.triangles, area: by * self.area, peak_overdraw: by * self.peak_overdraw }
    }
}

/// Adds `times` the cost of a tile or tiling of a cell.
pub fn add_cost(used: &mut Use, shares: &[(u8, f32)], cost: &TilingCost, times: f64) {
    used[0] += times * cost.triangles;
    used[1] += times * cost.area;
    for &(view, share) in shares {
        used[2 + usize::from(view)] += times * cost.worst_area * f64::from(share);
    }
}

pub fn keeps(used: &Use, capacity: &Use) -> bool {
    used.iter().zip(capacity).all(|(used, capacity)| *used <= capacity * (1.0 + 1e-12))
}

/// Selected tiling of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SelectedTiling {
    pub cell: TreeCell,
    /// Index into the tilings of the cell.
    pub tiling: usize,
}
