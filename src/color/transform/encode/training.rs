//! Table sets from counts of symbols: cells are grouped by the set that codes them in the fewest bits.

use crate::color::transform::blocks::{Block, regions};
use crate::color::transform::coder::{Coder, Reader, SourceCoder};
use crate::color::transform::contexts::CLUSTERS;
use crate::color::transform::domain::Keyed;
use crate::color::transform::encode::rate::{Costs, Counts};
use crate::color::transform::payload::{Layout, holds_cells};
use crate::color::transform::region::Region;
use crate::color::transform::tables::{CLUSTER_OF, TableSet, Tables};
use crate::entropy::{Decoder, SYMBOLS};
use crate::error::{Error, Result};

/// Rounds of grouping.
const ROUNDS: usize = 8;

/// Counts of cells, from which sets are trained.
#[derive(Debug, Default)]
pub struct Trainer {
    cells: Vec<Box<Counts>>,
}

/// Counts the symbols that it reads.
struct CountingReader<'a> {
    reader: Reader<'a>,
    counts: &'a mut Counts,
}

impl Coder for CountingReader<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        let symbol = self.reader.symbol(context, value);
        self.counts[usize::from(CLUSTER_OF[context])][symbol] += 1;
        symbol
    }

    fn bits(&mut self, value: u32, count: u32) -> u32 {
        self.reader.bits(value, count)
    }
}

impl SourceCoder for CountingReader<'_> {
    fn is_short(&self) -> bool {
        self.reader.is_short()
    }

    fn is_finished(&self) -> bool {
        self.reader.is_finished()
    }
}

impl Trainer {
    /// Counts the symbols of a payload that was encoded with `tables`.
    pub fn add<S: Keyed>(&mut self, payload: &[u8], size: [usize; 2], frames: u32, tables: &Tables) -> Result<()> {
        if holds_cells(payload) {
            return Ok(());
        }
        let Layout { header, substreams } = Layout::parse::<S>(payload, size, tables)?;
        let mut counts: Box<Counts> = Box::new([[0; SYMBOLS]; CLUSTERS]);
        for ([_, _, width, height], substream) in regions(size).zip(substreams) {
            let stream = Decoder::new(&payload[substream]);
            let reader = Reader { stream, tables: &tables.sets()[header.set] };
            let root = Block::root([width, height], frames as usize);
            Region::read_by(CountingReader { reader, counts: &mut counts }, u64::MAX, root, &header, &S::DOMAIN)
                .map_err(Error::invalid)?;
        }
        self.cells.push(counts);
        Ok(())
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
