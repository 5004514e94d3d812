//! Bits of symbols, and coders that count or write them.

use crate::color::transform::coder::{Coder, number_parts};
use crate::color::transform::contexts::CLUSTERS;
use crate::color::transform::tables::{CLUSTER_OF, TableSet, Tables};
use crate::entropy::{Encoder, SYMBOLS};

/// Symbols by cluster.
pub type Counts = [[u64; SYMBOLS]; CLUSTERS];

/// Bits of each symbol of each distribution of a set.
#[derive(Debug, Clone)]
pub struct Costs(Box<[[f32; SYMBOLS]; CLUSTERS]>);

/// Bits of a symbol that a distribution does not have: never worth it.
const IMPOSSIBLE: f32 = 1000.0;

/// log2 of 1 to 4096 by arithmetic that is the same on all machines.
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

impl Costs {
    pub fn new(set: &TableSet) -> Costs {
        let mut costs = Box::new([[IMPOSSIBLE; SYMBOLS]; CLUSTERS]);
        for (costs, distribution) in costs.iter_mut().zip(set.distributions()) {
            for (symbol, cost) in costs.iter_mut().enumerate() {
                let frequency = distribution.frequency(symbol);
                if frequency > 0 {
                    *cost = 12.0 - log2(frequency);
                }
            }
        }
        Costs(costs)
    }

    #[inline(always)]
    pub fn symbol(&self, context: usize, symbol: usize) -> f32 {
        self.0[usize::from(CLUSTER_OF[context])][symbol]
    }

    /// Bits of a number (`Coder::number`).
    #[inline(always)]
    pub fn number(&self, context: usize, value: u32) -> f32 {
        let (class, _, bits) = number_parts(value);
        let length_bits = if class == SYMBOLS - 1 { 5 } else { 0 };
        self.symbol(context, class) + (bits + length_bits) as f32
    }

    /// Bits of all symbols that were counted.
    pub fn total(&self, counts: &Counts) -> f64 {
        let bits = |(counts, costs): (&[u64; SYMBOLS], &[f32; SYMBOLS])| -> f64 {
            counts.iter().zip(costs).map(|(&count, &cost)| count as f64 * f64::from(cost)).sum()
        };
        counts.iter().zip(self.0.iter()).map(bits).sum()
    }
}

/// Table sets with the bits of their symbols; made once for all cells.
#[derive(Debug)]
pub struct PricedTables {
    pub tables: Tables,
    pub costs: Vec<Costs>,
}

impl PricedTables {
    pub fn new(tables: Tables) -> PricedTables {
        let costs = tables.sets().iter().map(Costs::new).collect();
        PricedTables { tables, costs }
    }
}

/// Counts bits.
#[derive(Debug)]
pub struct RateCounter<'a> {
    pub costs: &'a Costs,
    pub bits: f32,
}

impl Coder for RateCounter<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        self.bits += self.costs.symbol(context, value);
        value
    }

    fn bits(&mut self, value: u32, count: u32) -> u32 {
        self.bits += count as f32;
        value
    }
}

/// Counts symbols, from which the cheapest table set is chosen and sets are trained.
#[derive(Debug)]
pub struct SymbolCounter<'a>(pub &'a mut Counts);

impl Coder for SymbolCounter<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        self.0[usize::from(CLUSTER_OF[context])][value] += 1;
        value
    }

    fn bits(&mut self, value: u32, _: u32) -> u32 {
        value
    }
}

/// Writes a substream.
pub struct Writer<'a> {
    pub stream: Encoder,
    pub tables: &'a TableSet,
}

impl Coder for Writer<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        self.stream.symbol(self.tables.distribution(context), value);
        value
    }

    fn bits(&mut self, value: u32, count: u32) -> u32 {
        self.stream.bits(value, count);
        value
    }
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
