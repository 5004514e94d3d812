//! Symbol counts, and the price of symbols in bits.

use std::marker::PhantomData;
use std::sync::LazyLock;

use crate::entropy::distribution::SLOTS;
use crate::entropy::{Distribution, Model, SYMBOLS, TableSet, Tables};

/// Number of each symbol, by distribution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counts<M>(Box<[[u64; SYMBOLS]]>, PhantomData<M>);

impl<M: Model> Default for Counts<M> {
    fn default() -> Self {
        Counts(vec![[0; SYMBOLS]; M::ALPHABETS.len()].into(), PhantomData)
    }
}

impl<M: Model> Counts<M> {
    /// Size in bytes.
    pub const BYTES: u64 = (M::ALPHABETS.len() * size_of::<[u64; SYMBOLS]>()) as u64;

    #[inline(always)]
    pub fn count(&mut self, context: usize, symbol: usize) {
        self.0[M::cluster_of(context)][symbol] += 1;
    }

    /// Adds `factor` times the counts of `other`.
    pub fn add(&mut self, other: &Counts<M>, factor: u64) {
        for (sum, count) in self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()) {
            *sum += factor * count;
        }
    }

    /// Number of all symbols.
    pub fn total(&self) -> u64 {
        self.0.as_flattened().iter().sum()
    }

    /// Symbol counts of each distribution.
    pub fn by_cluster(&self) -> &[[u64; SYMBOLS]] {
        &self.0
    }

    pub fn by_cluster_mut(&mut self) -> &mut [[u64; SYMBOLS]] {
        &mut self.0
    }

    /// Returns the table set that is fitted to the counts.
    pub fn fitted(&self) -> TableSet<M> {
        let fit = |(counts, &alphabet): (&[u64; SYMBOLS], &u8)| Distribution::of_counts(counts, alphabet.into());
        TableSet::new(&self.0.iter().zip(M::ALPHABETS).map(fit).collect::<Vec<_>>())
    }
}

/// Price in bits of each symbol of each distribution of a table set.
#[derive(Debug, Clone)]
pub struct Prices<M>(Box<[[f32; SYMBOLS]]>, PhantomData<M>);

/// Price in bits of a symbol that a distribution cannot code; too high to be chosen.
const IMPOSSIBLE: f32 = 1000.0;

/// log2 of 1 to 4096, with arithmetic that is the same on all machines.
fn log2(value: u32) -> f32 {
    let whole = value.ilog2();
    let mut mantissa = f64::from(value) / f64::from(1u32 << whole);
    let (mut fraction, mut bit) = (0.0, 0.5);
    for _ in 0..20 {
        mantissa *= mantissa;
        if mantissa >= 2.0 {
            mantissa /= 2.0;
            fraction += bit;
        }
        bit /= 2.0;
    }
    (f64::from(whole) + fraction) as f32
}

impl<M: Model> Prices<M> {
    pub fn new(set: &TableSet<M>) -> Prices<M> {
        static BY_FREQUENCY: LazyLock<Vec<f32>> = LazyLock::new(|| {
            let price = |frequency| if frequency > 0 { 12.0 - log2(frequency) } else { IMPOSSIBLE };
            (0..=SLOTS.into()).map(price).collect()
        });
        let price = |frequency: u32| BY_FREQUENCY[frequency as usize];
        let of = |distribution: &Distribution| std::array::from_fn(|symbol| price(distribution.frequency(symbol)));
        Prices(set.distributions().iter().map(of).collect(), PhantomData)
    }

    #[inline(always)]
    pub fn symbol(&self, context: usize, symbol: usize) -> f32 {
        self.0[M::cluster_of(context)][symbol]
    }

    /// Bits of all counted symbols.
    pub fn total(&self, counts: &Counts<M>) -> f64 {
        let bits = |(counts, prices): (&[u64; SYMBOLS], &[f32; SYMBOLS])| -> f64 {
            counts.iter().zip(prices).map(|(&count, &price)| count as f64 * f64::from(price)).sum()
        };
        counts.0.iter().zip(self.0.iter()).map(bits).sum()
    }
}

/// Table sets with the prices of their symbols; computed once for all units.
#[derive(Debug)]
pub struct PricedTables<M> {
    pub tables: Tables<M>,
    pub prices: Vec<Prices<M>>,
}

impl<M: Model> PricedTables<M> {
    pub fn new(tables: Tables<M>) -> PricedTables<M> {
        let prices = tables.sets().iter().map(Prices::new).collect();
        PricedTables { tables, prices }
    }

    /// Returns the table set that codes the symbols in the fewest bits (the first, if equal), and the bits.
    pub fn cheapest(&self, counts: &Counts<M>) -> (usize, f64) {
        cheapest(&self.prices, counts)
    }
}

/// Returns the index of the prices that give the fewest bits for the symbols (the first, if equal), and the bits.
pub fn cheapest<M: Model>(prices: &[Prices<M>], counts: &Counts<M>) -> (usize, f64) {
    let bits = prices.iter().map(|prices| prices.total(counts)).enumerate();
    bits.reduce(|best, next| if next.1 < best.1 { next } else { best }).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_right() {
        for value in 1..=4096 {
            assert!((f64::from(log2(value)) - f64::from(value).log2()).abs() < 1e-5);
        }
    }
}
