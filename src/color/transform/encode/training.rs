//! Table sets from counts of symbols: payloads are grouped by the set that codes them in the fewest bits.

use crate::color::transform::blocks::{Block, regions};
use crate::color::transform::coder::{Coder, Reader, SourceCoder};
use crate::color::transform::contexts::CLUSTERS;
use crate::color::transform::domain::Keyed;
use crate::color::transform::encode::rate::{Costs, Counts, PricedTables};
use crate::color::transform::payload::{Layout, check_frames, holds_cells};
use crate::color::transform::region::{Region, most_items};
use crate::color::transform::tables::{BUILT_IN, CLUSTER_OF, TableSet, Tables};
use crate::entropy::{Decoder, SYMBOLS};
use crate::error::{Error, Result};

/// Most rounds of grouping.
const ROUNDS: usize = 8;
/// A trained set has seen each symbol as often as it is among so many of its cluster in the built-in sets: symbols that
/// training footage lacks occur in other footage.
const PRIOR_SYMBOLS: u64 = 64;

/// Symbols of a payload, and the size of what codes them.
#[derive(Debug)]
pub struct PayloadCounts {
    counts: Box<Counts>,
    bytes: u64,
    /// Bits of the symbols with the payload's set.
    bits: f64,
}

impl PayloadCounts {
    /// Counts a payload that was encoded with `tables`; `None` if it holds keyframes and weights.
    pub fn of<S: Keyed>(
        payload: &[u8],
        size: [usize; 2],
        frames: u32,
        tables: &PricedTables,
    ) -> Result<Option<PayloadCounts>> {
        if holds_cells(payload) {
            return Ok(None);
        }
        check_frames(frames)?;
        let Layout { header, substreams } = Layout::parse::<S>(payload, size, &tables.tables)?;
        let mut counts = empty();
        for ([_, _, width, height], substream) in regions(size).zip(substreams) {
            let bytes = &payload[substream];
            let reader = Reader { stream: Decoder::new(bytes), tables: &tables.tables.sets()[header.set] };
            let root = Block::root([width, height], frames as usize);
            let counting = CountingReader { reader, counts: &mut counts };
            Region::read_by(counting, most_items(bytes), root, &header, &S::DOMAIN).map_err(Error::invalid)?;
        }
        let bits = tables.costs[header.set].total(&counts);
        Ok(Some(PayloadCounts { counts, bytes: payload.len() as u64, bits }))
    }

    /// Memory of the counts of a payload.
    pub const BYTES: u64 = size_of::<Counts>() as u64 + size_of::<PayloadCounts>() as u64;

    pub fn symbols(&self) -> u64 {
        self.counts.as_flattened().iter().sum()
    }
}

fn empty() -> Box<Counts> {
    Box::new([[0; SYMBOLS]; CLUSTERS])
}

/// Counts of payloads, from which sets are trained.
#[derive(Debug)]
pub struct Trainer {
    payloads: Vec<PayloadCounts>,
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
    pub fn new(payloads: Vec<PayloadCounts>) -> Trainer {
        Trainer { payloads }
    }

    pub fn payloads(&self) -> &[PayloadCounts] {
        &self.payloads
    }

    /// Bytes of all payloads.
    pub fn bytes(&self) -> u64 {
        self.payloads.iter().map(|payload| payload.bytes).sum()
    }

    /// Bytes of the same symbols where each payload has the cheapest set of these tables.
    pub fn bytes_with(&self, tables: &PricedTables) -> u64 {
        let saved_bits = self.payloads.iter().map(|payload| {
            let bits = tables.costs.iter().map(|costs| costs.total(&payload.counts));
            payload.bits - bits.fold(f64::INFINITY, f64::min)
        });
        (self.bytes() as f64 - saved_bits.sum::<f64>() / 8.0).round() as u64
    }

    /// Trains `sets` table sets.
    pub fn train(&self, sets: usize) -> Vec<TableSet> {
        // The first groups are payloads in the order of their number of symbols.
        let mut order: Vec<usize> = (0..self.payloads.len()).collect();
        order.sort_by_key(|&at| (self.payloads[at].symbols(), at));
        let mut group_of = vec![0; self.payloads.len()];
        for (rank, &at) in order.iter().enumerate() {
            group_of[at] = rank * sets / order.len();
        }
        let mut trained = self.sets_of(&group_of, sets);
        for _ in 0..ROUNDS {
            let costs: Vec<Costs> = trained.iter().map(Costs::new).collect();
            let cheapest = |payload: &PayloadCounts| {
                let bits = costs.iter().map(|costs| costs.total(&payload.counts)).enumerate();
                bits.reduce(|best, next| if next.1 < best.1 { next } else { best }).map_or(0, |(set, _)| set)
            };
            let grouped: Vec<usize> = self.payloads.iter().map(cheapest).collect();
            if grouped == group_of {
                break;
            }
            group_of = grouped;
            trained = self.sets_of(&group_of, sets);
        }
        trained
    }

    fn sets_of(&self, group_of: &[usize], sets: usize) -> Vec<TableSet> {
        let mut sums: Vec<Box<Counts>> = (0..sets).map(|_| prior()).collect();
        for (payload, &group) in self.payloads.iter().zip(group_of) {
            for (sum, count) in sums[group].as_flattened_mut().iter_mut().zip(payload.counts.as_flattened()) {
                *sum += count * SCALE;
            }
        }
        sums.iter().map(|sum| TableSet::of_counts(sum)).collect()
    }
}

/// Counts of a symbol: what [`PRIOR_SYMBOLS`] are of the frequencies of all built-in sets.
const SCALE: u64 = 4096 * BUILT_IN as u64 / PRIOR_SYMBOLS;

fn prior() -> Box<Counts> {
    let mut counts = empty();
    for set in &Tables::default().sets()[..BUILT_IN] {
        for (counts, distribution) in counts.iter_mut().zip(set.distributions()) {
            for (symbol, count) in counts.iter_mut().enumerate() {
                *count += u64::from(distribution.frequency(symbol));
            }
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Payloads of one symbol of the first cluster, so many times.
    fn payloads(symbols: &[(usize, u64)]) -> Trainer {
        let payload = |&(symbol, count): &(usize, u64)| {
            let mut counts = empty();
            counts[0][symbol] = count;
            PayloadCounts { counts, bytes: 1000, bits: 8000.0 }
        };
        Trainer::new(symbols.iter().map(payload).collect())
    }

    #[test]
    fn payloads_are_grouped_by_what_they_hold() {
        let trainer = payloads(&[(0, 5000), (1, 4000), (0, 7000), (1, 9000)]);
        let [one, two] = &trainer.train(2)[..] else { panic!("two sets were expected") };
        let frequencies = |set: &TableSet| [0, 1].map(|symbol| set.distributions()[0].frequency(symbol));
        let mut found = [frequencies(one), frequencies(two)];
        found.sort_unstable();
        assert!(found[0][0] < 50 && found[0][1] > 4000 && found[1][0] > 4000 && found[1][1] < 50, "{found:?}");
        // 25,000 symbols of next to no bits are left of 32,000 bits.
        let tables = PricedTables::new(Tables::with_own(trainer.train(2)));
        assert_eq!(trainer.bytes(), 4000);
        assert!(trainer.bytes_with(&tables) < 200, "{}", trainer.bytes_with(&tables));
    }

    #[test]
    fn what_training_footage_lacks_is_as_likely_as_in_the_built_in_sets() {
        let trained = &payloads(&[(0, 1)]).train(1)[0];
        for (at, distribution) in trained.distributions().iter().enumerate().skip(1) {
            let sets = &Tables::default();
            for symbol in 0..SYMBOLS {
                let sum: u32 = sets.sets().iter().map(|set| set.distributions()[at].frequency(symbol)).sum();
                let mean = f64::from(sum) / BUILT_IN as f64;
                assert!(
                    (f64::from(distribution.frequency(symbol)) - mean).abs() <= 8.0,
                    "cluster {at}, symbol {symbol}"
                );
            }
        }
    }
}
