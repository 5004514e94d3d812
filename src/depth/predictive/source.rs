//! What a frame's symbols are decoded from.

#[cfg(feature = "encode")]
use std::cell::RefCell;

use crate::depth::predictive::tables::Predictive;
#[cfg(feature = "encode")]
use crate::entropy::Counts;
use crate::entropy::{self, Distribution, Model};

/// Symbols and raw bits in their order. A clone goes on from the same place.
pub trait Source: Clone {
    fn symbol(&mut self, context: usize) -> usize;

    /// At most 24 raw bits.
    fn bits(&mut self, count: u32) -> u32;
}

/// A substream.
#[derive(Clone)]
pub struct Reader<'a> {
    pub stream: entropy::Decoder<'a>,
    pub tables: &'a [Distribution],
}

impl Source for Reader<'_> {
    #[inline(always)]
    fn symbol(&mut self, context: usize) -> usize {
        self.stream.symbol(&self.tables[Predictive::cluster_of(context)])
    }

    #[inline(always)]
    fn bits(&mut self, count: u32) -> u32 {
        self.stream.bits(count)
    }
}

/// Counts the symbols that it reads.
#[cfg(feature = "encode")]
#[derive(Clone)]
pub struct Counting<'a> {
    pub reader: Reader<'a>,
    pub counts: &'a RefCell<Counts<Predictive>>,
}

#[cfg(feature = "encode")]
impl Source for Counting<'_> {
    fn symbol(&mut self, context: usize) -> usize {
        let symbol = self.reader.symbol(context);
        self.counts.borrow_mut().count(context, symbol);
        symbol
    }

    fn bits(&mut self, count: u32) -> u32 {
        self.reader.bits(count)
    }
}
