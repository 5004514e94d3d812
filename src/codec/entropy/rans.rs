//! rANS with a 32-bit state and renormalisation by 16 bits (entropy.md 3).
//!
//! Based on: Jarek Duda, *Asymmetric numeral systems*, 2013. The decoder reads forwards; the encoder writes backwards.

use crate::entropy::distribution::{Distribution, PRECISION};

/// Lower bound of the state: between symbols it is in 2¹⁶..2³².
pub const LOW: u32 = 1 << 16;
/// Maximum number of raw bits that are read at once.
const RAW_BITS: u32 = 12;

/// Position of a decoder in its bytes, for [`Decoder::resume`].
#[derive(Debug, Clone, Copy)]
pub struct Mark {
    state: u32,
    /// Number of unread bytes.
    left: usize,
    missing: bool,
}

#[derive(Debug, Clone)]
pub struct Decoder<'a> {
    state: u32,
    words: &'a [u8],
    /// True if a word was read past the end.
    missing: bool,
}

impl<'a> Decoder<'a> {
    /// Starts at the first byte. A substream of fewer than four bytes is a state in short form, without words. A substream
    /// with a state below [`LOW`], which no encoder writes, counts as too short.
    pub fn new(bytes: &'a [u8]) -> Self {
        match bytes.split_first_chunk() {
            Some((state, words)) => {
                let state = u32::from_le_bytes(*state);
                Decoder { state, words, missing: state < LOW }
            }
            None => {
                let short = bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte));
                Decoder { state: LOW + short, words: &[], missing: false }
            }
        }
    }

    pub fn mark(&self) -> Mark {
        Mark { state: self.state, left: self.words.len(), missing: self.missing }
    }

    /// Continues at the position of another decoder of the same bytes.
    pub fn resume(bytes: &'a [u8], mark: Mark) -> Self {
        let words = bytes.len().checked_sub(mark.left).and_then(|at| bytes.get(at..)).unwrap_or_default();
        Decoder { state: mark.state, words, missing: mark.missing }
    }

    #[inline(always)]
    pub fn symbol(&mut self, distribution: &Distribution) -> usize {
        let slot = self.state & ((1 << PRECISION) - 1);
        let symbol = distribution.symbol(slot as u16);
        let frequency = distribution.frequency(symbol);
        self.state = frequency.wrapping_mul(self.state >> PRECISION).wrapping_add(slot - distribution.start(symbol));
        self.renormalise();
        symbol
    }

    /// Reads `count` raw bits, at most 24.
    #[inline(always)]
    pub fn bits(&mut self, count: u32) -> u32 {
        if count <= RAW_BITS {
            return self.few_bits(count);
        }
        let high = self.few_bits(count - RAW_BITS);
        high << RAW_BITS | self.few_bits(RAW_BITS)
    }

    /// Reads at most [`RAW_BITS`] raw bits.
    #[inline(always)]
    fn few_bits(&mut self, count: u32) -> u32 {
        let value = self.state & ((1 << count) - 1);
        self.state >>= count;
        self.renormalise();
        value
    }

    #[inline(always)]
    fn renormalise(&mut self) {
        if self.state < LOW {
            let word = match self.words.split_first_chunk() {
                Some((word, rest)) => {
                    self.words = rest;
                    u16::from_le_bytes(*word)
                }
                None => {
                    self.missing = true;
                    0
                }
            };
            self.state = self.state << 16 | u32::from(word);
        }
    }

    /// Remaining information in bits, with a fraction: log₂ of the state over that of [`LOW`], and 16 for each unread word.
    pub fn bits_left(&self) -> f64 {
        f64::from(self.state.max(1)).log2() - f64::from(LOW).log2() + 8.0 * self.words.len() as f64
    }

    /// True if the decoder has read past the end.
    pub fn is_short(&self) -> bool {
        self.missing
    }

    /// True if the substream ends at this position: all words are read, none was missing, and the state is the encoder's
    /// initial state.
    pub fn finished(&self) -> bool {
        self.state == LOW && self.words.is_empty() && !self.missing
    }
}

/// A coded symbol or value, in decoding order.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, Copy)]
enum Step {
    Symbol { start: u16, frequency: u16 },
    Raw { value: u16, count: u8 },
}

#[cfg(feature = "encode")]
#[derive(Debug, Default)]
pub struct Encoder {
    steps: Vec<Step>,
}

#[cfg(feature = "encode")]
impl Encoder {
    /// Appends a symbol, whose frequency must be above 0.
    pub fn symbol(&mut self, distribution: &Distribution, symbol: usize) {
        let (start, frequency) = (distribution.start(symbol) as u16, distribution.frequency(symbol) as u16);
        self.steps.push(Step::Symbol { start, frequency });
    }

    /// Appends `count` raw bits, at most 24.
    pub fn bits(&mut self, value: u32, count: u32) {
        if count > RAW_BITS {
            self.bits(value >> RAW_BITS, count - RAW_BITS);
            self.bits(value & ((1 << RAW_BITS) - 1), RAW_BITS);
        } else if count > 0 {
            self.steps.push(Step::Raw { value: value as u16, count: count as u8 });
        }
    }

    pub fn finish(self) -> Vec<u8> {
        let mut state = u64::from(LOW);
        let mut words = Vec::new();
        for step in self.steps.iter().rev() {
            let limit = match *step {
                Step::Symbol { frequency, .. } => u64::from(frequency) << (32 - PRECISION),
                Step::Raw { count, .. } => 1 << (32 - count),
            };
            if state >= limit {
                words.push(state as u16);
                state >>= 16;
            }
            state = match *step {
                Step::Symbol { start, frequency } => {
                    let frequency = u64::from(frequency);
                    (state / frequency) << PRECISION | (state % frequency + u64::from(start))
                }
                Step::Raw { value, count } => state << count | u64::from(value),
            };
        }
        let state = state as u32;
        if words.is_empty() && state - LOW < 1 << 24 {
            let mut short = (state - LOW).to_le_bytes().to_vec();
            while short.last() == Some(&0) {
                short.pop();
            }
            return short;
        }
        let mut out = state.to_le_bytes().to_vec();
        words.iter().rev().for_each(|word| out.extend_from_slice(&word.to_le_bytes()));
        out
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::entropy::SYMBOLS;

    fn skewed(alphabet: usize) -> Distribution {
        let mut counts = [0; SYMBOLS];
        (0..alphabet).for_each(|symbol| counts[symbol] = 1 << (2 * (alphabet - symbol)));
        Distribution::of_counts(&counts, alphabet)
    }

    #[test]
    fn symbols_and_raw_bits_come_back_and_the_end_is_known() {
        let distributions: Vec<_> = (2..=SYMBOLS).map(skewed).collect();
        for length in [0usize, 1, 2, 3, 10, 5000] {
            let step = |at: usize| {
                let noise = (at as u32).wrapping_mul(2_654_435_761) >> 7;
                let which = noise as usize % distributions.len();
                (which, (noise >> 5).leading_zeros() as usize % (which + 2), noise & 0xfff, noise % 25)
            };
            let mut encoder = Encoder::default();
            for (which, symbol, value, count) in (0..length).map(step) {
                encoder.symbol(&distributions[which], symbol);
                encoder.bits(value & ((1 << count) - 1), count);
            }
            let bytes = encoder.finish();
            let mut decoder = Decoder::new(&bytes);
            for (which, symbol, value, count) in (0..length).map(step) {
                decoder = Decoder::resume(&bytes, decoder.mark());
                assert_eq!(decoder.symbol(&distributions[which]), symbol);
                assert_eq!(decoder.bits(count), value & ((1 << count) - 1));
            }
            assert!(decoder.finished());
            assert_eq!(bytes.is_empty(), length == 0);
        }
    }

    #[test]
    fn a_state_that_no_encoder_leaves_is_no_start() {
        for state in [0, 1, LOW - 1].map(u32::to_le_bytes) {
            let mut decoder = Decoder::new(&state);
            assert!(decoder.is_short());
            (0..40).for_each(|_| _ = decoder.bits(1));
            assert!(!decoder.finished());
        }
        assert!(Decoder::new(&LOW.to_le_bytes()).finished());
    }

    #[test]
    fn a_substream_that_is_cut_does_not_end() {
        let distribution = skewed(5);
        let mut encoder = Encoder::default();
        (0..100).for_each(|at| encoder.symbol(&distribution, at % 5));
        let bytes = encoder.finish();
        let ends = |bytes: &[u8]| {
            let mut decoder = Decoder::new(bytes);
            (0..100).for_each(|_| _ = decoder.symbol(&distribution));
            decoder.finished()
        };
        assert!(ends(&bytes));
        assert!(!ends(&bytes[..bytes.len() - 2]));
        assert!(!ends(&[&bytes[..], &[0, 0]].concat()));
    }
}
