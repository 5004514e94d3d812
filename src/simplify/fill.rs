//! Fills budgets that a selection leaves unused (Seurat 4.3 leaves them).
//!
//! Prices select all tilings of about the same worth at once, so that the best feasible selection at any scale of prices may be far
//! from the budgets. Parts of a selection at lower prices are exchanged one by one.

use super::selection::{CONSTRAINTS, Problem, SelectedTiling, Solution, Use};

/// A part of the trees in which two selections differ.
struct Exchange {
    /// Ranges of tilings in both selections.
    ranges: [std::ops::Range<usize>; 2],
    /// What the exchange uses in addition.
    used: Use,
    /// Saved energy by price of what is used; `+inf` if nothing is paid.
    worth: f64,
}

/// Exchanges parts of a feasible selection for those of another one, the best first, as long as the selection stays feasible.
pub(super) fn fill(problem: &Problem<'_>, selection: &mut Solution, other: &Solution, prices: &Use) {
    let mut exchanges = exchanges(problem, [&selection.tilings, &other.tilings], prices);
    exchanges.sort_by(|a, b| b.worth.total_cmp(&a.worth));
    let mut taken: Vec<Exchange> = Vec::new();
    for exchange in exchanges {
        let used: Use = std::array::from_fn(|at| selection.used[at] + exchange.used[at]);
        if problem.is_feasible(&used) {
            selection.used = used;
            taken.push(exchange);
        }
    }
    if taken.is_empty() {
        return;
    }
    taken.sort_by_key(|exchange| exchange.ranges[0].start);
    let (mut tilings, mut next) = (Vec::new(), 0);
    for Exchange { ranges: [mine, of_other], .. } in taken {
        tilings.extend_from_slice(&selection.tilings[next..mine.start]);
        tilings.extend_from_slice(&other.tilings[of_other]);
        next = mine.end;
    }
    tilings.extend_from_slice(&selection.tilings[next..]);
    selection.tilings = tilings;
    // Sums are taken anew, because differences are rounded.
    (selection.energy, selection.used) = cost(problem, &selection.tilings);
}

/// Returns the parts in which the second selection has less energy than the first.
fn exchanges(problem: &Problem<'_>, tilings: [&[SelectedTiling]; 2], prices: &Use) -> Vec<Exchange> {
    let mut found = Vec::new();
    let mut next = [0, 0];
    // Both are in depth-first order and cover the same points, so that one of the next cells contains the other.
    while let (Some(a), Some(b)) = (tilings[0].get(next[0]), tilings[1].get(next[1])) {
        let outer = if a.cell.level < b.cell.level { a.cell } else { b.cell };
        let ranges = [0, 1].map(|of| {
            let inside = tilings[of][next[of]..].iter().take_while(|tiling| outer.contains(tiling.cell)).count();
            next[of]..next[of] + inside
        });
        if ranges.iter().any(|range| range.is_empty()) {
            break;
        }
        next = [ranges[0].end, ranges[1].end];
        let [(before, of_first), (after, of_second)] = [0, 1].map(|of| cost(problem, &tilings[of][ranges[of].clone()]));
        let used: Use = std::array::from_fn(|at| of_second[at] - of_first[at]);
        let paid: f64 = used.iter().zip(prices).map(|(used, price)| used * price).sum();
        let saved = before - after;
        if saved > 0.0 {
            let worth = if paid > 0.0 { saved / paid } else { f64::INFINITY };
            found.push(Exchange { ranges, used, worth });
        }
    }
    found
}

/// Returns the energy and use of tilings.
fn cost(problem: &Problem<'_>, tilings: &[SelectedTiling]) -> (f64, Use) {
    tilings.iter().fold((0.0, [0.0; CONSTRAINTS]), |(energy, used), tiling| {
        let (more, of_tiling) = problem.cost_of(*tiling);
        (energy + more, std::array::from_fn(|at| used[at] + of_tiling[at]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::{TilingCost, ViewShares};
    use crate::selection::Budgets;
    use crate::tree::TreeCell;
    use codec::monitor::Silent;

    /// Two levels below all roots: one tile in a root; in each of its children one, with an energy that grows with the root.
    fn costs() -> Vec<Vec<Vec<TilingCost>>> {
        let cost = |energy: f64| vec![TilingCost { energy, triangles: 2.0, area: 1e-3, worst_area: 1e-3 }];
        let of_children = |index: usize| cost(0.25 + 0.01 * (index / 4) as f64);
        vec![(0..6).map(|_| cost(2.0)).collect(), (0..24).map(of_children).collect()]
    }

    #[test]
    fn what_prices_leave_is_filled_with_the_best_exchanges() {
        let (costs, shares) = (costs(), ViewShares::of_trees());
        // All roots have 12 triangles, and dividing one takes 6 more: 24 allow two, which no prices select alone if all are alike.
        let capacity = Budgets { triangles: 24.0, area: 1.0, peak_overdraw: 10.0 }.capacity();
        let problem = Problem::new(&costs, 0, &shares, capacity);
        let found = problem.solve(50, 0.0, &Silent).unwrap();
        let of_root = |root: TreeCell| found.tilings.iter().filter(|tiling| root.contains(tiling.cell)).count();
        assert_eq!(TreeCell::ROOTS.map(of_root), [4, 4, 1, 1, 1, 1]);
        assert!((found.primal - (4.0 * 2.0 + 4.0 * 0.25 + 4.0 * 0.26)).abs() < 1e-12 && found.used[0] == 24.0);
        let (energy, used) = cost(&problem, &found.tilings);
        assert_eq!((energy, used[0]), (found.primal, found.used[0]));
    }
}
