//! Symbols of an open chunk and their cost in bits.

use std::sync::{Arc, LazyLock};

use crate::depth::predictive::contexts::{CONTEXTS, Predictive, Tables};
use crate::entropy::{self, Encoder};

pub type Counts = entropy::Counts<Predictive>;
pub type Prices = entropy::Prices<Predictive>;
pub type PricedTables = entropy::PricedTables<Predictive>;

/// Returns table sets with their prices. Prices of the built-in sets are computed once.
pub fn priced(tables: &Tables) -> Arc<PricedTables> {
    static BUILT_IN: LazyLock<Arc<PricedTables>> = LazyLock::new(|| Arc::new(PricedTables::new(Tables::default())));
    if tables.own().is_empty() { BUILT_IN.clone() } else { Arc::new(PricedTables::new(tables.clone())) }
}

/// Receiver of symbols and raw bits in the order of decoding.
pub trait Sink {
    fn symbol(&mut self, context: usize, symbol: usize);

    /// Takes the `count` low bits of `value` as raw bits, at most 24.
    fn bits(&mut self, value: u32, count: u32);
}

/// Sink that sums the cost in bits.
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

/// A recorded step is a 16-bit word: a context and its symbol, or, with this flag, raw bits. More than 11 raw bits follow in the
/// next word, more than 16 in the next two.
const RAW: u16 = 1 << 15;
const SHORT_BITS: u32 = 11;
const LONG: u16 = 15 << SHORT_BITS;

const _: () = assert!(CONTEXTS << 4 <= RAW as usize);

/// Sink that stores the symbols of a chunk and counts them.
#[derive(Debug, Default)]
pub struct Recorder {
    steps: Vec<u16>,
    pub counts: Counts,
}

impl Sink for Recorder {
    fn symbol(&mut self, context: usize, symbol: usize) {
        self.steps.push((context << 4 | symbol) as u16);
        self.counts.count(context, symbol);
    }

    fn bits(&mut self, value: u32, count: u32) {
        match count {
            0 => {}
            1..=SHORT_BITS => self.steps.push(RAW | (count << SHORT_BITS | value) as u16),
            _ if count <= 16 => self.steps.extend([RAW | LONG | count as u16, value as u16]),
            _ => self.steps.extend([RAW | LONG | count as u16, (value >> 16) as u16, value as u16]),
        }
    }
}

impl Recorder {
    pub fn held_bytes(&self) -> usize {
        self.steps.len() * size_of::<u16>()
    }

    /// Returns the payload, coded with the cheapest table set.
    pub fn finish(self, tables: &PricedTables) -> Vec<u8> {
        let set = tables.cheapest(&self.counts).0;
        let (mut out, tables) = (vec![set as u8], &tables.tables.sets()[set]);
        let mut encoder = Encoder::default();
        let mut steps = self.steps.into_iter();
        while let Some(step) = steps.next() {
            let low = u32::from(step & ((1 << SHORT_BITS) - 1));
            if step & RAW == 0 {
                encoder.symbol(tables.distribution((step >> 4).into()), (step & 15).into());
            } else if step & LONG == LONG {
                let value = steps
                    .by_ref()
                    .take(if low > 16 { 2 } else { 1 })
                    .fold(0, |value, word| value << 16 | u32::from(word));
                encoder.bits(value, low);
            } else {
                encoder.bits(low, u32::from(step & LONG) >> SHORT_BITS);
            }
        }
        out.extend(encoder.finish());
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payload_has_symbols_and_raw_bits_of_any_length() {
        let tables = priced(&Tables::default());
        let mut recorder = Recorder::default();
        for count in 0..=24 {
            recorder.symbol(0, 1);
            for value in [0, 1, (1u32 << count) - 1, (1 << count) / 3] {
                recorder.bits(value & ((1 << count) - 1), count);
            }
        }
        let set = tables.cheapest(&recorder.counts).0;
        let mut plain = Encoder::default();
        for count in 0..=24 {
            plain.symbol(tables.tables.sets()[set].distribution(0), 1);
            for value in [0, 1, (1u32 << count) - 1, (1 << count) / 3] {
                plain.bits(value & ((1 << count) - 1), count);
            }
        }
        assert_eq!(recorder.finish(&tables), [vec![set as u8], plain.finish()].concat());
    }
}
