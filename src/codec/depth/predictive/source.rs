//! Sources from which the symbols of a frame are decoded.

#[cfg(feature = "encode")]
use std::cell::RefCell;

use crate::depth::predictive::contexts::Predictive;
#[cfg(feature = "encode")]
use crate::entropy::Counts;
use crate::entropy::{self, Distribution, Model};

/// Source of symbols and raw bits, in order. A clone continues at the same position.
pub trait Source: Clone {
    fn symbol(&mut self, context: usize) -> usize;

    /// Reads `count` raw bits, at most 24.
    fn bits(&mut self, count: u32) -> u32;
}

/// Source that reads a substream.
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

/// Source that counts the symbols it reads.
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
