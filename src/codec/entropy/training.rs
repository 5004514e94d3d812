//! Trains table sets from symbol counts: payloads are grouped by the set that codes them in the fewest bits.

use crate::entropy::prices::cheapest;
use crate::entropy::{Counts, Model, PricedTables, Prices, TableSet, Tables};

/// Maximum iterations of grouping.
const ROUNDS: usize = 8;
/// Weight, in symbols per cluster, of the built-in sets as a prior of a trained set: symbols that are missing in the training
/// footage occur in other footage.
const PRIOR_SYMBOLS: u64 = 64;

/// Symbol counts of a payload, and its size.
#[derive(Debug)]
pub struct PayloadCounts<M> {
    pub counts: Counts<M>,
    pub bytes: u64,
    /// Bits of the symbols with the payload's own table set.
    pub bits: f64,
}

/// Symbol counts of payloads, from which sets are trained.
#[derive(Debug)]
pub struct Trainer<M> {
    payloads: Vec<PayloadCounts<M>>,
}

impl<M: Model> Trainer<M> {
    pub fn new(payloads: Vec<PayloadCounts<M>>) -> Trainer<M> {
        Trainer { payloads }
    }

    pub fn payloads(&self) -> &[PayloadCounts<M>] {
        &self.payloads
    }

    pub fn symbols(&self) -> u64 {
        self.payloads.iter().map(|payload| payload.counts.total()).sum()
    }

    /// Total bytes of all payloads.
    pub fn bytes(&self) -> u64 {
        self.payloads.iter().map(|payload| payload.bytes).sum()
    }

    /// Total bytes if each payload uses the cheapest set of these tables.
    pub fn bytes_with(&self, tables: &PricedTables<M>) -> u64 {
        let saved_bits = self.payloads.iter().map(|payload| payload.bits - tables.cheapest(&payload.counts).1);
        (self.bytes() as f64 - saved_bits.sum::<f64>() / 8.0).round() as u64
    }

    /// Trains `sets` table sets.
    pub fn train(&self, sets: usize) -> Vec<TableSet<M>> {
        // The initial groups are payloads sorted by their number of symbols.
        let mut order: Vec<usize> = (0..self.payloads.len()).collect();
        order.sort_by_key(|&at| (self.payloads[at].counts.total(), at));
        let mut group_of = vec![0; self.payloads.len()];
        for (rank, &at) in order.iter().enumerate() {
            group_of[at] = rank * sets / order.len();
        }
        let mut trained = self.sets_of(&group_of, sets);
        for _ in 0..ROUNDS {
            let prices: Vec<Prices<M>> = trained.iter().map(Prices::new).collect();
            let grouped: Vec<usize> =
                self.payloads.iter().map(|payload| cheapest(&prices, &payload.counts).0).collect();
            if grouped == group_of {
                break;
            }
            group_of = grouped;
            trained = self.sets_of(&group_of, sets);
        }
        trained
    }

    fn sets_of(&self, group_of: &[usize], sets: usize) -> Vec<TableSet<M>> {
        let built_in = Tables::<M>::default();
        let mut sums = vec![prior(&built_in); sets];
        // The prior has 4096 counts per built-in set and cluster, and weighs as much as PRIOR_SYMBOLS symbols.
        let scale = 4096 * built_in.sets().len() as u64 / PRIOR_SYMBOLS;
        for (payload, &group) in self.payloads.iter().zip(group_of) {
            sums[group].add(&payload.counts, scale);
        }
        sums.iter().map(Counts::fitted).collect()
    }
}

fn prior<M: Model>(built_in: &Tables<M>) -> Counts<M> {
    let mut prior = Counts::default();
    for set in built_in.sets() {
        for (counts, distribution) in prior.by_cluster_mut().iter_mut().zip(set.distributions()) {
            for (symbol, count) in counts.iter_mut().enumerate() {
                *count += u64::from(distribution.frequency(symbol));
            }
        }
    }
    prior
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transform::contexts::Transform;
    use crate::depth::predictive::contexts::Predictive;
    use crate::entropy::SYMBOLS;

    /// Payloads that have `count` times one symbol of the first cluster.
    fn payloads(symbols: &[(usize, u64)]) -> Trainer<Transform> {
        let payload = |&(symbol, count): &(usize, u64)| {
            let mut counts = Counts::default();
            counts.by_cluster_mut()[0][symbol] = count;
            PayloadCounts { counts, bytes: 1000, bits: 8000.0 }
        };
        Trainer::new(symbols.iter().map(payload).collect())
    }

    #[test]
    fn payloads_are_grouped_by_what_they_hold() {
        let trainer = payloads(&[(0, 5000), (1, 4000), (0, 7000), (1, 9000)]);
        let [one, two] = &trainer.train(2)[..] else { panic!("two sets were expected") };
        let frequencies = |set: &TableSet<_>| [0, 1].map(|symbol| set.distributions()[0].frequency(symbol));
        let mut found = [frequencies(one), frequencies(two)];
        found.sort_unstable();
        assert!(found[0][0] < 50 && found[0][1] > 4000 && found[1][0] > 4000 && found[1][1] < 50, "{found:?}");
        // The payloads have 32,000 bits; with the trained sets, 25,000 symbols take nearly none.
        let tables = PricedTables::new(Tables::with_own(trainer.train(2)));
        assert_eq!(trainer.bytes(), 4000);
        assert!(trainer.bytes_with(&tables) < 200, "{}", trainer.bytes_with(&tables));
    }

    #[test]
    fn what_training_footage_lacks_is_as_likely_as_in_the_built_in_sets() {
        check_prior::<Transform>();
        check_prior::<Predictive>();
    }

    fn check_prior<M: Model>() {
        let mut counts = Counts::<M>::default();
        counts.by_cluster_mut()[0][0] = 1;
        let trained = &Trainer::new(vec![PayloadCounts { counts, bytes: 1000, bits: 8000.0 }]).train(1)[0];
        let tables = Tables::<M>::default();
        for (at, distribution) in trained.distributions().iter().enumerate().skip(1) {
            for symbol in 0..SYMBOLS {
                let sum: u32 = tables.sets().iter().map(|set| set.distributions()[at].frequency(symbol)).sum();
                let mean = f64::from(sum) / tables.sets().len() as f64;
                assert!(
                    (f64::from(distribution.frequency(symbol)) - mean).abs() <= 8.0,
                    "cluster {at}, symbol {symbol}"
                );
            }
        }
    }
}
