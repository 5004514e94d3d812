//! Selection within budgets, of which overdraw is measured on the selected tiles (Seurat 4).

use super::budgets::{Budgets, Use};
use super::candidates::CandidateLevel;
use super::cost::{CostModel, TilingCost, VIEWS, ViewShares};
use super::overdraw::{OverdrawMeter, ViewOverdraw, peak};
use super::selection::{INFEASIBLE, Problem, Selection};
use super::tiles::TileSet;
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Maximum number of selections whose overdraw is measured.
const ROUNDS: u32 = 8;
/// Part of the allowed overdraw that is enough where it limits.
const ENOUGH: f64 = 0.97;
/// Part by which each round lowers capacities, so that overdraw falls below its budget.
const STEP: f64 = 0.005;
/// Capacity of a view whose overdraw does not limit. Finite, because a price of 0 times infinity is no number.
const UNLIMITED: f64 = 1e12;

/// Tilings from which tiles are selected.
pub struct Budgeted<'a> {
    pub levels: &'a [CandidateLevel],
    pub costs: &'a [Vec<Vec<TilingCost>>],
    pub shares: &'a ViewShares,
    pub model: &'a CostModel,
    pub meter: &'a OverdrawMeter,
    /// Budgets of the scene, which selections may leave a part of.
    pub budgets: Budgets,
    /// Maximum number of iterations of a selection, and the relative gap that ends them.
    pub effort: (usize, f64),
}

/// Selected tiles.
pub struct BudgetedTiles {
    pub selection: Selection,
    pub tiles: TileSet,
    /// Capacities for the budgets of the scene. Those of views are in units of estimates.
    pub capacity: Use,
}

impl Budgeted<'_> {
    /// Selects the tiles of lowest energy that leave a fraction of the budgets, of overdraw as measured. Estimates of each view are
    /// scaled by what was measured of the selection before.
    ///
    /// # Errors
    /// [`Error::Usage`] if no tiling keeps the budgets; [`Error::Interrupted`] if the monitor is interrupted.
    pub fn select(&self, left: f64, monitor: &dyn Monitor) -> Result<BudgetedTiles> {
        let budgets = &self.budgets.scaled(1.0 - left);
        let first_level = self.levels.first().map_or(0, |level| level.level);
        let mut capacity = budgets.capacity();
        capacity[2..].fill(UNLIMITED);
        let (mut best, mut least): (Option<BudgetedTiles>, f64) = (None, f64::INFINITY);
        for round in 0..ROUNDS {
            let (iterations, gap) = self.effort;
            let problem = Problem::new(self.costs, first_level, self.shares, budgets).with_views(&capacity);
            let mut selection = match problem.solve(iterations, gap, monitor) {
                Ok(selection) => selection,
                Err(Error::Usage(_)) if best.is_some() => break,
                Err(error) => return Err(error),
            };
            let tiles = TileSet::new(&selection.tilings, self.levels, self.model);
            let views = self.meter.measure(&tiles)?;
            let overdraw = peak(&views);
            least = least.min(overdraw);
            let is_limited = selection.prices[2..].iter().any(|price| *price > 0.0);
            let is_better = best.as_ref().is_none_or(|best| selection.primal < best.selection.primal);
            capacity = scaled(budgets, &selection.used, &views);
            if overdraw <= budgets.peak_overdraw {
                if is_better {
                    selection.capacity = capacity;
                    let capacity = scaled(&self.budgets, &selection.used, &views);
                    best = Some(BudgetedTiles { selection, tiles, capacity });
                }
                if !is_limited || overdraw >= ENOUGH * budgets.peak_overdraw {
                    break;
                }
            }
            capacity[2..].iter_mut().for_each(|capacity| *capacity *= 1.0 - STEP * f64::from(round));
        }
        best.ok_or_else(|| {
            Error::Usage(format!(
                "{INFEASIBLE} the budget of peak overdraw: {least:.2} is the least that was measured: increase it"
            ))
        })
    }
}

/// Returns capacities in units of estimates, at which views with as much overdraw as measured reach the budget.
fn scaled(budgets: &Budgets, used: &Use, views: &ViewOverdraw) -> Use {
    let mut capacity = budgets.capacity();
    for at in 0..VIEWS {
        if views[at] > 0.0 {
            capacity[2 + at] *= used[2 + at] / views[at];
        }
    }
    capacity
}
