//! Symbols of an open chunk, and what they cost.

use std::sync::LazyLock;

use crate::depth::predictive::contexts::CLUSTERS;
use crate::depth::predictive::tables::{CLUSTER_OF, SETS, TableSet};
use crate::entropy::distribution::SLOTS;
use crate::entropy::{Encoder, SYMBOLS};

/// Takes what a decoder will read, in its order.
pub trait Sink {
    fn symbol(&mut self, context: usize, symbol: usize);

    /// At most 24 raw bits.
    fn bits(&mut self, value: u32, count: u32);
}

/// Bits of each symbol of each cluster.
#[derive(Debug)]
pub struct Prices(Box<[[f32; SYMBOLS]; CLUSTERS]>);

impl Prices {
    /// Those of all table sets.
    pub fn all() -> &'static [Prices; SETS] {
        static ALL: LazyLock<[Prices; SETS]> = LazyLock::new(|| TableSet::all().map(Prices::new));
        &ALL
    }

    fn new(tables: TableSet) -> Prices {
        let price = |frequency: u32| (f64::from(SLOTS) / f64::from(frequency.max(1))).log2() as f32;
        let prices = tables
            .distributions()
            .each_ref()
            .map(|distribution| std::array::from_fn(|symbol| price(distribution.frequency(symbol))));
        Prices(Box::new(prices))
    }

    #[inline(always)]
    pub fn of(&self, context: usize, symbol: usize) -> f64 {
        f64::from(self.0[usize::from(CLUSTER_OF[context])][symbol])
    }
}

/// Counts bits.
#[derive(Debug)]
pub struct Pricer<'a> {
    pub prices: &'a Prices,
    pub bits: f64,
}

impl Sink for Pricer<'_> {
    #[inline(always)]
    fn symbol(&mut self, context: usize, symbol: usize) {
        self.bits += self.prices.of(context, symbol);
    }

    #[inline(always)]
    fn bits(&mut self, _value: u32, count: u32) {
        self.bits += f64::from(count);
    }
}

const RAW: u32 = 1 << 31;

/// The symbols of a chunk.
#[derive(Debug)]
pub struct Recorder {
    steps: Vec<u32>,
    pub counts: Box<[[u64; SYMBOLS]; CLUSTERS]>,
}

impl Default for Recorder {
    fn default() -> Self {
        Recorder { steps: Vec::new(), counts: Box::new([[0; SYMBOLS]; CLUSTERS]) }
    }
}

impl Sink for Recorder {
    fn symbol(&mut self, context: usize, symbol: usize) {
        self.steps.push((context << 4 | symbol) as u32);
        self.counts[usize::from(CLUSTER_OF[context])][symbol] += 1;
    }

    fn bits(&mut self, value: u32, count: u32) {
        if count > 0 {
            self.steps.push(RAW | count << 24 | value);
        }
    }
}

impl Recorder {
    pub fn held_bytes(&self) -> usize {
        self.steps.len() * size_of::<u32>()
    }

    /// The table set that codes all symbols in the fewest bits, of those with these prices.
    pub fn cheapest(&self, sets: &[Prices; SETS]) -> usize {
        let bits = |prices: &Prices| -> f64 {
            let rows = self.counts.iter().zip(prices.0.iter());
            let symbols = rows.flat_map(|(counts, prices)| counts.iter().zip(prices));
            symbols.filter(|(count, _)| **count > 0).map(|(&count, &price)| count as f64 * f64::from(price)).sum()
        };
        let bits = sets.each_ref().map(bits);
        (0..SETS).min_by(|&a, &b| bits[a].total_cmp(&bits[b])).unwrap_or(0)
    }

    /// The payload, coded with a table set.
    pub fn finish(self, set: usize) -> Vec<u8> {
        let mut out = vec![set as u8];
        let Some(tables) = TableSet::new(set) else { return out };
        let mut encoder = Encoder::default();
        for step in self.steps {
            if step & RAW != 0 {
                encoder.bits(step & 0xFF_FFFF, step >> 24 & 0x7F);
            } else {
                encoder.symbol(tables.distribution((step >> 4) as usize), (step & 15) as usize);
            }
        }
        out.extend(encoder.finish());
        out
    }
}
