//! Prices of symbols in bits, and coders that count or write symbols.

use crate::color::transform::coder::{Coder, number_parts};
use crate::color::transform::contexts::{TableSet, Transform};
use crate::entropy::{self, Encoder, SYMBOLS};

pub type Counts = entropy::Counts<Transform>;
pub type Prices = entropy::Prices<Transform>;
pub type PricedTables = entropy::PricedTables<Transform>;

/// Bits of a number (`Coder::number`).
#[inline(always)]
pub fn number_bits(prices: &Prices, context: usize, value: u32) -> f32 {
    let (class, _, bits) = number_parts(value);
    let length_bits = if class == SYMBOLS - 1 { 5 } else { 0 };
    prices.symbol(context, class) + (bits + length_bits) as f32
}

/// Coder that sums the bits of symbols.
#[derive(Debug)]
pub struct RateCounter<'a> {
    pub prices: &'a Prices,
    pub bits: f32,
}

impl Coder for RateCounter<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        self.bits += self.prices.symbol(context, value);
        value
    }

    fn bits(&mut self, value: u32, count: u32) -> u32 {
        self.bits += count as f32;
        value
    }
}

/// Coder that counts symbols, to select the cheapest table set and to train sets.
#[derive(Debug)]
pub struct SymbolCounter<'a>(pub &'a mut Counts);

impl Coder for SymbolCounter<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        self.0.count(context, value);
        value
    }

    fn bits(&mut self, value: u32, _: u32) -> u32 {
        value
    }
}

/// Coder that writes a substream.
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
