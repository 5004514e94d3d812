//! Improves a selection within the budgets that it leaves unused, beyond Seurat 4.3.
//!
//! Prices select all tilings of about the same worth at once, so that the best feasible selection at any scale of prices may be far
//! from the budgets. Parts of a selection at lower prices are exchanged one by one.

use super::budgets::{CONSTRAINTS, SelectedTiling, Use, keeps};

/// A part of the trees in which two selections differ.
struct Exchange {
    /// Ranges of tilings in both selections.
    ranges: [std::ops::Range<usize>; 2],
    /// Resources that the exchange takes, less those that it frees.
    used: Use,
    /// Saved energy by price of what is used; `+inf` if nothing is paid.
    worth: f64,
}

/// Exchanges parts of the first of two selections, which is feasible, for those of the second, the best first, as long as capacities are
/// kept. Returns all tilings; `None` if nothing is exchanged.
///
/// Both selections are in depth-first order and cover the same points. `cost` returns the energy and use of a tiling.
pub fn filled(
    tilings: [&[SelectedTiling]; 2],
    cost: impl Fn(SelectedTiling) -> (f64, Use),
    capacity: &Use,
    prices: &Use,
) -> Option<Vec<SelectedTiling>> {
    let [first, second] = tilings;
    let mut exchanges = exchanges(tilings, &cost, prices);
    exchanges.sort_by(|a, b| b.worth.total_cmp(&a.worth));
    let (_, mut used) = total(first, &cost);
    exchanges.retain(|exchange| {
        let after: Use = std::array::from_fn(|at| used[at] + exchange.used[at]);
        let is_taken = keeps(&after, capacity);
        if is_taken {
            used = after;
        }
        is_taken
    });
    exchanges.sort_by_key(|exchange| exchange.ranges[0].start);
    let (mut all, mut next) = (Vec::new(), 0);
    for Exchange { ranges: [mine, of_other], .. } in &exchanges {
        all.extend_from_slice(&first[next..mine.start]);
        all.extend_from_slice(&second[of_other.clone()]);
        next = mine.end;
    }
    all.extend_from_slice(&first[next..]);
    (!exchanges.is_empty()).then_some(all)
}

/// Returns the parts in which the second selection has less energy than the first.
fn exchanges(
    tilings: [&[SelectedTiling]; 2],
    cost: impl Fn(SelectedTiling) -> (f64, Use),
    prices: &Use,
) -> Vec<Exchange> {
    let mut found = Vec::new();
    let mut next = [0, 0];
    // One of the next cells contains the other, because both contain the next point.
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
        let [(before, of_first), (after, of_second)] =
            [0, 1].map(|of: usize| total(&tilings[of][ranges[of].clone()], &cost));
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
pub fn total(tilings: &[SelectedTiling], cost: impl Fn(SelectedTiling) -> (f64, Use)) -> (f64, Use) {
    tilings.iter().fold((0.0, [0.0; CONSTRAINTS]), |(energy, used), tiling| {
        let (more, of_tiling) = cost(*tiling);
        (energy + more, std::array::from_fn(|at| used[at] + of_tiling[at]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::TreeCell;

    fn of_level(level: u32) -> Vec<SelectedTiling> {
        let below = |root: TreeCell| if level == 0 { vec![root] } else { root.children().to_vec() };
        TreeCell::ROOTS.into_iter().flat_map(below).map(|cell| SelectedTiling { cell, tiling: 0 }).collect()
    }

    #[test]
    fn what_prices_leave_is_filled_with_the_best_exchanges() {
        // Dividing a root saves less energy the later it comes, and takes 6 triangles more.
        let cost = |SelectedTiling { cell, .. }: SelectedTiling| {
            let energy = if cell.level == 0 { 2.0 } else { 0.25 + 0.01 * f64::from(cell.face as u32) };
            let mut used = [0.0; CONSTRAINTS];
            used[0] = 2.0;
            (energy, used)
        };
        let mut prices = [0.0; CONSTRAINTS];
        prices[0] = 0.1;
        let divided = |triangles: f64| {
            let mut capacity = [1.0; CONSTRAINTS];
            capacity[0] = triangles;
            let all = filled([&of_level(0), &of_level(1)], cost, &capacity, &prices)?;
            assert!(total(&all, cost).1[0] <= triangles);
            Some(TreeCell::ROOTS.map(|root| all.iter().filter(|tiling| root.contains(tiling.cell)).count()))
        };
        assert_eq!(divided(25.0), Some([4, 4, 1, 1, 1, 1]));
        assert_eq!(divided(48.0), Some([4; 6]));
        assert_eq!(divided(17.0), None);
        // Nothing is exchanged for more energy.
        assert!(filled([&of_level(1), &of_level(0)], cost, &[1e9; CONSTRAINTS], &prices).is_none());
    }
}
