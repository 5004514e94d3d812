//! Selection of tilings under budgets (Seurat 4.3).
//!
//! Takes the costs of all tilings. Returns a set of cells that covers all points, and one tiling for each of them, with the
//! lowest energy found that keeps all budgets.
//!
//! The method is Lagrangian relaxation: budgets become prices, for which recursion over the trees finds the best valid tiling.
//! Subgradient ascent updates the prices; each feasible tiling on the way is a primal solution. Finally prices are scaled, first
//! by powers of two and then by bisection, until the tiling is feasible.

use rayon::prelude::*;

use super::budgets::{Budgets, CONSTRAINTS, SelectedTiling, Use, add_cost, keeps};
use super::cost::{TilingCost, ViewShares};
use super::fill::{filled, total};
use super::tree::{MAX_LEVEL, TreeCell};
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Start of the messages about budgets that cannot be kept.
pub(super) const INFEASIBLE: &str = "no selection of tiles meets";

/// Returns true if a message, of this process or of another one, reports that budgets cannot be kept.
pub fn says_infeasible(message: &str) -> bool {
    message.contains(INFEASIBLE)
}

/// Maximum number of rounds that search for prices at which a tiling is feasible.
const FEASIBILITY_ROUNDS: usize = 100;
/// Fraction of the total worth of all budgets below which a budget does not limit a selection: its price approaches 0 without
/// reaching it.
const MIN_WORTH: f64 = 0.01;
/// Number of iterations after which the best prices so far are scaled until the selection is feasible.
const REPAIR_INTERVAL: usize = 25;

/// Bounds of the energy of the best selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub dual: f64,
    /// Energy of the best feasible selection so far; `+inf` if there is none.
    pub primal: f64,
}

#[derive(Debug, Clone)]
pub struct Selection {
    pub tilings: Vec<SelectedTiling>,
    /// Energy of the selection.
    pub primal: f64,
    /// Lower bound of the energy of valid tilings that keep the budgets of the problem.
    pub dual: f64,
    /// Prices of the resources at which the dual was reached.
    pub prices: Use,
    pub iterations: usize,
    /// Bounds before the first iteration and after each.
    pub convergence: Vec<Bounds>,
    pub used: Use,
    pub capacity: Use,
}

impl Selection {
    /// Returns the relative gap between primal and dual.
    pub fn gap(&self) -> f64 {
        if self.primal > 0.0 { ((self.primal - self.dual) / self.primal).max(0.0) } else { 0.0 }
    }

    /// Returns the names of the budgets that have a price: if they were larger, the energy would be lower. Empty if no valid
    /// tiling has less energy.
    pub fn limits(&self) -> Vec<&'static str> {
        let worth: Use = std::array::from_fn(|at| self.prices[at] * self.capacity[at]);
        let worth = [("triangles", worth[0]), ("area", worth[1]), ("peak_overdraw", worth[2..].iter().sum())];
        let all: f64 = worth.iter().map(|(_, worth)| worth).sum();
        worth.into_iter().filter(|(_, worth)| *worth > MIN_WORTH * all).map(|(name, _)| name).collect()
    }
}

/// Selection problem: costs by level and cell. Levels count from 0, and those below the first with tilings are empty.
pub struct Problem<'a> {
    costs: &'a [Vec<Vec<TilingCost>>],
    first_level: u32,
    shares: &'a ViewShares,
    budgets: Budgets,
    capacity: Use,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Choice {
    /// The cell has no points.
    Empty,
    Children,
    Tiling(u8),
}

/// A valid selection.
struct Solution {
    /// Sum of the energies, and of the prices of the resources used.
    priced: f64,
    /// Selected tilings in a depth-first traversal.
    tilings: Vec<SelectedTiling>,
    energy: f64,
    used: Use,
}

impl<'a> Problem<'a> {
    pub fn new(
        costs: &'a [Vec<Vec<TilingCost>>],
        first_level: u32,
        shares: &'a ViewShares,
        budgets: &Budgets,
    ) -> Problem<'a> {
        Problem { costs, first_level, shares, budgets: *budgets, capacity: budgets.capacity() }
    }

    /// Sets the capacities of views at which they reach the budget of overdraw. Costs are estimates, and other than what is measured.
    pub fn with_views(mut self, capacity: &Use) -> Problem<'a> {
        self.capacity[2..].copy_from_slice(&capacity[2..]);
        self
    }

    /// Returns the energy and use of a selected tiling.
    fn cost_of(&self, SelectedTiling { cell, tiling }: SelectedTiling) -> (f64, Use) {
        let cost = &self.of_cell(cell)[tiling];
        let mut used = [0.0; CONSTRAINTS];
        add_cost(&mut used, self.shares.of(cell.level, cell.index()), cost, 1.0);
        (cost.energy, used)
    }

    fn last_level(&self) -> u32 {
        self.first_level + self.costs.len() as u32 - 1
    }

    fn of_cell(&self, cell: TreeCell) -> &[TilingCost] {
        match cell.level.checked_sub(self.first_level) {
            Some(at) => self.costs.get(at as usize).map_or(&[], |level| &level[cell.index()]),
            None => &[],
        }
    }

    /// Returns the valid tiling with the smallest sum of energy and price. Prices are per unit of a resource.
    fn best(&self, prices: &Use, energy_weight: f64) -> Solution {
        let mut choices: Vec<Vec<Choice>> = Vec::new();
        let mut below: Vec<f64> = Vec::new();
        for level in (0..=self.last_level()).rev() {
            let choose = |index: usize| {
                let cell = TreeCell::at(level, index);
                let mut best = (f64::INFINITY, Choice::Empty);
                if !below.is_empty() {
                    let children = cell.children().map(|child| below[child.index()]);
                    let is_empty = children.iter().all(|cost| cost.is_nan());
                    let sum: f64 = children.iter().filter(|cost| !cost.is_nan()).sum();
                    if !is_empty {
                        best = (sum, Choice::Children);
                    }
                }
                let tilings = self.of_cell(cell);
                if !tilings.is_empty() {
                    let of_views = self.shares.of(level, index).iter();
                    let price: f64 =
                        of_views.map(|&(view, share)| prices[2 + usize::from(view)] * f64::from(share)).sum();
                    for (at, cost) in tilings.iter().enumerate() {
                        let TilingCost { energy, triangles, area, worst_area } = cost;
                        let sum =
                            energy_weight * energy + prices[0] * triangles + prices[1] * area + price * worst_area;
                        if sum <= best.0 {
                            best = (sum, Choice::Tiling(at as u8));
                        }
                    }
                }
                if best.1 == Choice::Empty { (f64::NAN, Choice::Empty) } else { best }
            };
            let (costs, chosen) = (0..TreeCell::count(level)).into_par_iter().map(choose).unzip();
            below = costs;
            choices.push(chosen);
        }
        choices.reverse();
        let priced = below.iter().filter(|cost| !cost.is_nan()).sum();
        let mut solution = Solution { priced, tilings: Vec::new(), energy: 0.0, used: [0.0; CONSTRAINTS] };
        let mut open: Vec<TreeCell> = TreeCell::ROOTS.into_iter().rev().collect();
        while let Some(cell) = open.pop() {
            match choices[cell.level as usize][cell.index()] {
                Choice::Empty => {}
                Choice::Children => open.extend(cell.children().into_iter().rev()),
                Choice::Tiling(tiling) => {
                    solution.tilings.push(SelectedTiling { cell, tiling: usize::from(tiling) });
                    let cost = &self.of_cell(cell)[usize::from(tiling)];
                    solution.energy += cost.energy;
                    add_cost(&mut solution.used, self.shares.of(cell.level, cell.index()), cost, 1.0);
                }
            }
        }
        solution
    }

    fn is_feasible(&self, used: &Use) -> bool {
        keeps(used, &self.capacity)
    }

    /// Returns a lower bound of the energy of valid tilings within the budgets: the Lagrangian at any prices of at least 0.
    pub fn bound(&self, prices: &Use) -> f64 {
        self.bound_of(&self.best(prices, 1.0), prices)
    }

    fn bound_of(&self, solution: &Solution, prices: &Use) -> f64 {
        solution.priced - prices.iter().zip(&self.capacity).map(|(price, capacity)| price * capacity).sum::<f64>()
    }

    /// Solves the problem in at most `iterations` iterations, or until the relative gap is at most `gap`.
    ///
    /// # Errors
    /// [`Error::Usage`] if no tiling keeps the budgets; [`Error::Interrupted`] if the monitor is interrupted.
    pub fn solve(&self, iterations: usize, gap: f64, monitor: &dyn Monitor) -> Result<Selection> {
        let mut prices = [0.0; CONSTRAINTS];
        let free = self.best(&prices, 1.0);
        if free.tilings.is_empty() || self.is_feasible(&free.used) {
            let dual = free.priced;
            let primal = free.energy;
            return Ok(self.selection(free, vec![Bounds { dual, primal }], prices));
        }
        let mut best_prices = prices;
        let mut dual = free.priced;
        let mut primal: Option<Solution> = None;
        // A first feasible selection bounds how far the dual can rise.
        let first = self.first_prices(free.energy)?;
        self.feasible_scale(&first, &mut primal).ok_or_else(|| self.infeasible())?;
        let upper = |primal: &Option<Solution>| primal.as_ref().map_or(f64::INFINITY, |primal| primal.energy);
        let mut convergence = vec![Bounds { dual, primal: upper(&primal) }];
        let (mut factor, mut without_progress) = (1.0, 0);
        for iteration in 0..iterations {
            monitor.check()?;
            let solution = self.best(&prices, 1.0);
            let bound = self.bound_of(&solution, &prices);
            if bound > dual {
                (dual, best_prices) = (bound, prices);
                without_progress = 0;
            } else {
                without_progress += 1;
            }
            if iteration % REPAIR_INTERVAL == REPAIR_INTERVAL - 1 {
                self.feasible_scale(&best_prices, &mut primal);
            }
            // Relative excess of each resource.
            let excess: Vec<f64> =
                solution.used.iter().zip(&self.capacity).map(|(used, capacity)| used / capacity - 1.0).collect();
            if self.is_feasible(&solution.used) && primal.as_ref().is_none_or(|primal| solution.energy < primal.energy)
            {
                primal = Some(solution);
            }
            let upper = upper(&primal);
            convergence.push(Bounds { dual, primal: upper });
            if upper - dual <= gap * upper {
                break;
            }
            if without_progress >= 8 {
                (factor, without_progress) = (0.7 * factor, 0);
                prices = best_prices;
                if factor < 1e-4 {
                    break;
                }
                continue;
            }
            // Prices stay at 0 while their resources are not exceeded.
            let moves = |at: usize| excess[at] > 0.0 || prices[at] > 0.0;
            let squares: f64 = (0..CONSTRAINTS).filter(|&at| moves(at)).map(|at| excess[at] * excess[at]).sum();
            if squares <= 0.0 {
                break;
            }
            let step = factor * (upper.min(4.0 * dual.abs() + 1e-300) - bound).max(1e-3 * dual.abs()) / squares;
            for at in 0..CONSTRAINTS {
                prices[at] = (prices[at] + step * excess[at] / self.capacity[at]).max(0.0);
            }
        }
        self.feasible_scale(&best_prices, &mut primal);
        let primal = primal.ok_or_else(|| self.infeasible())?;
        if let Some(last) = convergence.last_mut() {
            last.primal = primal.energy;
        }
        Ok(self.selection(primal, convergence, best_prices))
    }

    /// Returns prices at which the tiling of lowest price is feasible. Multiplicative weights raise the prices of resources that
    /// are exceeded, and lower the others. The prices are normalised so that all budgets together cost `energy`.
    fn first_prices(&self, energy: f64) -> Result<Use> {
        let mut weights = [1.0; CONSTRAINTS];
        for _ in 0..FEASIBILITY_ROUNDS {
            let mut prices: Use = std::array::from_fn(|at| weights[at] / self.capacity[at]);
            let used = self.best(&prices, 0.0).used;
            if self.is_feasible(&used) {
                let sum: f64 = weights.iter().sum();
                prices.iter_mut().for_each(|price| *price *= energy.max(1e-12) / sum);
                return Ok(prices);
            }
            for at in 0..CONSTRAINTS {
                let excess = used[at] / self.capacity[at] - 1.0;
                weights[at] = (weights[at] * excess.clamp(-0.5, 1.0).exp()).max(1e-9);
            }
            let most = weights.iter().copied().fold(0.0, f64::max);
            weights.iter_mut().for_each(|weight| *weight /= most);
        }
        Err(self.infeasible())
    }

    /// Finds the smallest scale of prices at which the selection is feasible, by doubling and bisection. Keeps the best selection
    /// on the way in `primal`, and fills it with parts of the last one that was not feasible.
    fn feasible_scale(&self, prices: &Use, primal: &mut Option<Solution>) -> Option<f64> {
        let mut beyond: Option<Solution> = None;
        let mut try_scale = |scale: f64| {
            let solution = self.best(&prices.map(|price| scale * price), 1.0);
            let feasible = self.is_feasible(&solution.used);
            if !feasible {
                beyond = Some(solution);
            } else if primal.as_ref().is_none_or(|primal| solution.energy < primal.energy) {
                *primal = Some(solution);
            }
            feasible
        };
        let mut prices_up = 1.0;
        let mut feasible = None;
        for _ in 0..60 {
            if try_scale(prices_up) {
                feasible = Some(prices_up);
                break;
            }
            prices_up *= 2.0;
        }
        let mut high = feasible?;
        let mut low = if high > 1.0 { 0.5 * high } else { 0.0 };
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if try_scale(middle) { high = middle } else { low = middle }
        }
        if let (Some(primal), Some(beyond)) = (primal, beyond) {
            let tilings = [&primal.tilings[..], &beyond.tilings];
            if let Some(tilings) = filled(tilings, |tiling| self.cost_of(tiling), &self.capacity, prices) {
                (primal.energy, primal.used) = total(&tilings, |tiling| self.cost_of(tiling));
                primal.tilings = tilings;
            }
        }
        Some(high)
    }

    /// Returns an error that names a budget that cannot be kept, and the smallest value that would be enough.
    fn infeasible(&self) -> Error {
        let mut worst: Option<(f64, usize, f64)> = None;
        for at in 0..CONSTRAINTS {
            let mut prices = [0.0; CONSTRAINTS];
            prices[at] = 1.0;
            let least = self.best(&prices, 0.0).used[at];
            let ratio = least / self.capacity[at];
            if worst.is_none_or(|(most, ..)| ratio > most) {
                worst = Some((ratio, at, least));
            }
        }
        let (ratio, at, least) = worst.unwrap_or((0.0, 0, 0.0));
        let (name, least) = match at {
            0 => ("triangles", least.ceil()),
            1 => ("area", (least * 1e4).ceil() / 1e4),
            _ => ("peak overdraw", (ratio * self.budgets.peak_overdraw * 1e4).ceil() / 1e4),
        };
        Error::Usage(match ratio > 1.0 {
            true => format!("{INFEASIBLE} the budget of {name}: the minimum is {least}"),
            false => {
                format!("{INFEASIBLE} all budgets at once; {name} alone needs {least}: increase it or another budget")
            }
        })
    }

    fn selection(&self, solution: Solution, convergence: Vec<Bounds>, prices: Use) -> Selection {
        let Solution { tilings, energy, used, .. } = solution;
        let dual = convergence.last().map_or(f64::NEG_INFINITY, |bounds| bounds.dual);
        let iterations = convergence.len().saturating_sub(1);
        Selection { tilings, primal: energy, dual, prices, iterations, convergence, used, capacity: self.capacity }
    }
}

const _: () = assert!(MAX_LEVEL <= 10);

#[cfg(test)]
mod tests {
    use super::*;
    use codec::math::random::Random;
    use codec::monitor::Silent;

    const LEVELS: u32 = 3;

    /// Returns costs of the cells below the first root: three tilings of the root, two of each child, one or none of each of
    /// their children.
    fn costs(seed: u64) -> Vec<Vec<Vec<TilingCost>>> {
        let mut random = Random::new(seed);
        let mut unit = || f64::from(random.word()) / f64::from(u32::MAX);
        let of_level = |level: u32| -> Vec<Vec<TilingCost>> {
            let below = 1usize << (2 * level);
            let of_cell = |cell: usize| {
                let count = if cell >= below || (level == 2 && cell % 5 == 3) { 0 } else { 3 - level as usize };
                (1..=count)
                    .map(|tiles| TilingCost {
                        energy: unit() * 10.0 / (tiles as f64 * f64::from(level + 1)),
                        triangles: 2.0 * tiles as f64,
                        area: tiles as f64 / (6.0 * below as f64),
                        worst_area: tiles as f64 * (1.0 + 0.2 * unit()) / below as f64,
                    })
                    .collect()
            };
            (0..TreeCell::count(level)).map(of_cell).collect()
        };
        (0..LEVELS).map(of_level).collect()
    }

    /// Returns the energy and use of every valid selection below a cell; empty if the cell has no points.
    fn all(problem: &Problem<'_>, cell: TreeCell) -> Vec<(f64, Use)> {
        let mut found: Vec<(f64, Use)> = Vec::new();
        for cost in problem.of_cell(cell) {
            let mut used = [0.0; CONSTRAINTS];
            add_cost(&mut used, problem.shares.of(cell.level, cell.index()), cost, 1.0);
            found.push((cost.energy, used));
        }
        if cell.level + 1 < LEVELS {
            let mut joined = vec![(0.0, [0.0; CONSTRAINTS])];
            for child in cell.children().map(|child| all(problem, child)).into_iter().filter(|child| !child.is_empty())
            {
                let both =
                    |(a, b): (&(f64, Use), &(f64, Use))| (a.0 + b.0, std::array::from_fn(|at| a.1[at] + b.1[at]));
                joined = joined.iter().flat_map(|a| child.iter().map(move |b| both((a, b)))).collect();
            }
            found.extend(joined);
        }
        found
    }

    #[test]
    fn selections_keep_budgets_and_come_close_to_the_best_of_all() {
        let shares = ViewShares::of_trees();
        let (mut exact, mut cases) = (0, 0);
        for seed in 0..12 {
            let costs = costs(seed);
            for triangles in [2.0, 8.0, 14.0, 22.0, 1000.0] {
                let budgets = Budgets { triangles, area: 0.4, peak_overdraw: 2.5 };
                let problem = Problem::new(&costs, 0, &shares, &budgets);
                let every = all(&problem, TreeCell::ROOTS[0]);
                let best = every.iter().filter(|(_, used)| problem.is_feasible(used)).map(|(energy, _)| *energy);
                let best = best.fold(f64::INFINITY, f64::min);
                let found = problem.solve(400, 0.0, &Silent).unwrap();
                let energy: f64 =
                    found.tilings.iter().map(|chosen| problem.of_cell(chosen.cell)[chosen.tiling].energy).sum();
                assert!((energy - found.primal).abs() < 1e-12);
                assert!(keeps(&found.used, &budgets.capacity()));
                assert!(found.dual <= best + 1e-9 && best <= found.primal + 1e-9, "{found:?} {best}");
                assert!((problem.bound(&found.prices) - found.dual).abs() <= 1e-9);
                // Prices found for smaller budgets also give a bound for larger ones.
                let larger = Problem::new(&costs, 0, &shares, &budgets.scaled(1.25));
                let least = every.iter().filter(|(_, used)| larger.is_feasible(used)).map(|(energy, _)| *energy);
                assert!(larger.bound(&found.prices) <= least.fold(f64::INFINITY, f64::min) + 1e-9);
                cases += 1;
                exact += u32::from(found.primal <= best + 1e-9);
            }
        }
        // The relaxation has a gap if there are few tilings to choose from.
        assert!(exact * 10 >= cases * 7, "{exact} of {cases}");
    }

    /// Returns costs of three levels below one root: one tiling of one tile in each cell, with these energies.
    fn of_levels(energies: [f64; 3]) -> Vec<Vec<Vec<TilingCost>>> {
        let of = |level: u32| {
            let cost = TilingCost { energy: energies[level as usize], triangles: 2.0, area: 1e-3, worst_area: 1e-3 };
            let of_root = |index| TreeCell::at(level, index).face == TreeCell::ROOTS[0].face;
            (0..TreeCell::count(level)).map(|index| if of_root(index) { vec![cost] } else { Vec::new() }).collect()
        };
        (0..3).map(of).collect()
    }

    #[test]
    fn cells_are_divided_twice_though_dividing_them_once_is_worse() {
        // Energy 10 for one tile, 12 for 4, 0.16 for 16: a comparison of each cell with only its children would stop at the
        // first.
        let (costs, shares) = (of_levels([10.0, 3.0, 0.01]), ViewShares::of_trees());
        let solve = |triangles: f64| {
            let budgets = Budgets { triangles, area: 1.0, peak_overdraw: 10.0 };
            Problem::new(&costs, 0, &shares, &budgets).solve(400, 0.0, &Silent).unwrap()
        };
        let fine = solve(32.0);
        assert!(fine.tilings.len() == 16 && (fine.primal - 0.16).abs() < 1e-12, "{fine:?}");
        let coarse = solve(2.0);
        assert_eq!(coarse.primal, 10.0);
        assert_eq!((fine.limits(), coarse.limits()), (vec![], vec!["triangles"]));
        let small = Budgets { triangles: 32.0, area: 0.004, peak_overdraw: 10.0 };
        let found = Problem::new(&costs, 0, &shares, &small).solve(400, 0.0, &Silent).unwrap();
        assert_eq!((found.tilings.len(), found.limits()), (1, vec!["area"]));
    }

    #[test]
    fn bounds_approach_each_other() {
        let (costs, shares) = (costs(3), ViewShares::of_trees());
        let budgets = Budgets { triangles: 14.0, area: 0.4, peak_overdraw: 2.5 };
        let found = Problem::new(&costs, 0, &shares, &budgets).solve(200, 0.0, &Silent).unwrap();
        assert_eq!(found.convergence.len(), found.iterations + 1);
        assert!(found.convergence.is_sorted_by(|a, b| a.dual <= b.dual && a.primal >= b.primal));
        let last = found.convergence[found.iterations];
        assert_eq!((last.dual, last.primal), (found.dual, found.primal));
        assert!(found.convergence.iter().all(|bounds| bounds.dual <= bounds.primal + 1e-9));
    }

    #[test]
    fn a_budget_that_cannot_be_kept_is_named_with_the_least_that_can() {
        let (costs, shares) = (costs(1), ViewShares::of_trees());
        let said = |budgets: Budgets| {
            Problem::new(&costs, 0, &shares, &budgets).solve(50, 0.0, &Silent).unwrap_err().to_string()
        };
        let wide = Budgets { triangles: 1e9, area: 1e9, peak_overdraw: 1e9 };
        let few = said(Budgets { triangles: 1.0, ..wide });
        assert!(few.contains("triangles") && few.ends_with("is 2"), "{few}");
        let small = said(Budgets { area: 1e-9, ..wide });
        assert!(small.contains("area") && small.ends_with("is 0.1355"), "{small}");
        assert!(said(Budgets { peak_overdraw: 1e-9, ..wide }).contains("peak overdraw"));
    }
}
