//! Symbols of an open chunk, and what they cost.

use std::sync::{Arc, LazyLock};

use crate::depth::predictive::tables::{Predictive, Tables};
use crate::entropy::{self, Encoder};

pub type Counts = entropy::Counts<Predictive>;
pub type Prices = entropy::Prices<Predictive>;
pub type PricedTables = entropy::PricedTables<Predictive>;

/// The built-in sets are priced once.
pub fn priced(tables: &Tables) -> Arc<PricedTables> {
    static BUILT_IN: LazyLock<Arc<PricedTables>> = LazyLock::new(|| Arc::new(PricedTables::new(Tables::default())));
    if tables.own().is_empty() { BUILT_IN.clone() } else { Arc::new(PricedTables::new(tables.clone())) }
}

/// Takes what a decoder will read, in its order.
pub trait Sink {
    fn symbol(&mut self, context: usize, symbol: usize);

    /// At most 24 raw bits.
    fn bits(&mut self, value: u32, count: u32);
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
        self.bits += f64::from(self.prices.symbol(context, symbol));
    }

    #[inline(always)]
    fn bits(&mut self, _value: u32, count: u32) {
        self.bits += f64::from(count);
    }
}

const RAW: u32 = 1 << 31;

/// The symbols of a chunk.
#[derive(Debug, Default)]
pub struct Recorder {
    steps: Vec<u32>,
    pub counts: Counts,
}

impl Sink for Recorder {
    fn symbol(&mut self, context: usize, symbol: usize) {
        self.steps.push((context << 4 | symbol) as u32);
        self.counts.count(context, symbol);
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

    /// The payload, coded with the cheapest table set.
    pub fn finish(self, tables: &PricedTables) -> Vec<u8> {
        let set = tables.cheapest(&self.counts).0;
        let (mut out, tables) = (vec![set as u8], &tables.tables.sets()[set]);
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
