//! Table sets from counts of symbols: cells are grouped by the set that codes them in the fewest bits.

use crate::color::transform::contexts::CLUSTERS;
use crate::color::transform::encode::rate::{Costs, Counts};
use crate::color::transform::tables::TableSet;
use crate::entropy::SYMBOLS;

/// Rounds of grouping.
const ROUNDS: usize = 8;

/// Counts of cells, from which sets are trained.
#[derive(Debug, Default)]
pub struct Trainer {
    cells: Vec<Box<Counts>>,
}

impl Trainer {
    pub fn add(&mut self, counts: Box<Counts>) {
        self.cells.push(counts);
    }

    /// `sets` table sets, or as many as there are cells.
    pub fn train(&self, sets: usize) -> Vec<TableSet> {
        // The first groups are cells in the order of their number of symbols.
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        order.sort_by_key(|&cell| (self.cells[cell].as_flattened().iter().sum::<u64>(), cell));
        let mut group_of = vec![0; self.cells.len()];
        for (rank, &cell) in order.iter().enumerate() {
            group_of[cell] = rank * sets / self.cells.len().max(1);
        }
        let mut trained = self.sets_of(&group_of, sets);
        for _ in 0..ROUNDS {
            let costs: Vec<Costs> = trained.iter().map(Costs::new).collect();
            for (group, counts) in group_of.iter_mut().zip(&self.cells) {
                let bits = costs.iter().map(|costs| costs.total(counts));
                let cheapest = bits.enumerate().reduce(|best, next| if next.1 < best.1 { next } else { best });
                *group = cheapest.map_or(0, |(set, _)| set);
            }
            trained = self.sets_of(&group_of, sets);
        }
        trained
    }

    fn sets_of(&self, group_of: &[usize], sets: usize) -> Vec<TableSet> {
        let of_group = |group| {
            let mut sum: Box<Counts> = Box::new([[0; SYMBOLS]; CLUSTERS]);
            for (counts, _) in self.cells.iter().zip(group_of).filter(|(_, of)| **of == group) {
                for (sum, count) in sum.as_flattened_mut().iter_mut().zip(counts.as_flattened()) {
                    *sum += count;
                }
            }
            TableSet::of_counts(&sum)
        };
        (0..sets).map(of_group).collect()
    }
}
