//! A single description of the syntax for both directions: a coder takes the value to write, or returns the value that it
//! reads.

use crate::color::transform::contexts::TableSet;
use crate::entropy;

pub trait Coder {
    /// Codes a symbol and returns it; a decoder ignores `value`.
    fn symbol(&mut self, context: usize, value: usize) -> usize;

    /// Codes `count` raw bits, at most 24, and returns them.
    fn bits(&mut self, value: u32, count: u32) -> u32;

    fn flag(&mut self, context: usize, value: bool) -> bool {
        self.symbol(context, usize::from(value)) == 1
    }

    /// Codes a number of at most 2²³ + 24 as a symbol and raw bits (color.md 6.6, numbers), and returns it.
    #[inline(always)]
    fn number(&mut self, context: usize, value: u32) -> u32 {
        let (class, low, bits) = number_parts(value);
        match self.symbol(context, class) {
            class @ 0..=11 => class as u32,
            class @ 12..=14 => {
                let bits = class as u32 - 11;
                (1 << bits) + 10 + self.bits(low, bits)
            }
            _ => {
                let bits = self.bits(bits, 5).min(MAX_NUMBER_BITS);
                (1 << bits) + 25 + self.bits(low, bits)
            }
        }
    }
}

/// Raw bits of the largest number.
const MAX_NUMBER_BITS: u32 = 22;

/// Class of a number, its raw bits, and their count.
#[inline(always)]
pub fn number_parts(value: u32) -> (usize, u32, u32) {
    match value {
        0..=11 => (value as usize, 0, 0),
        12..=25 => {
            let bits = (value - 10).ilog2();
            (bits as usize + 11, value - 10 - (1 << bits), bits)
        }
        _ => {
            let bits = (value - 25).ilog2();
            (15, value - 25 - (1 << bits), bits)
        }
    }
}

/// Coder that reads the symbols of a region.
pub struct Reader<'a> {
    pub stream: entropy::Decoder<'a>,
    pub tables: &'a TableSet,
}

impl Coder for Reader<'_> {
    #[inline(always)]
    fn symbol(&mut self, context: usize, _: usize) -> usize {
        self.stream.symbol(self.tables.distribution(context))
    }

    #[inline(always)]
    fn bits(&mut self, _: u32, count: u32) -> u32 {
        self.stream.bits(count)
    }
}

/// A coder that reads.
pub trait SourceCoder: Coder {
    /// True if the coder has read past the end.
    fn is_short(&self) -> bool;

    /// True if the coder has read everything, and nothing past the end.
    fn is_finished(&self) -> bool;
}

impl SourceCoder for Reader<'_> {
    fn is_short(&self) -> bool {
        self.stream.is_short()
    }

    fn is_finished(&self) -> bool {
        self.stream.finished()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Tape {
        written: Vec<u32>,
        read: Option<usize>,
    }

    impl Tape {
        fn pass(&mut self, value: u32) -> u32 {
            match &mut self.read {
                Some(at) => {
                    *at += 1;
                    self.written[*at - 1]
                }
                None => {
                    self.written.push(value);
                    value
                }
            }
        }
    }

    impl Coder for Tape {
        fn symbol(&mut self, _: usize, value: usize) -> usize {
            self.pass(value as u32) as usize
        }

        fn bits(&mut self, value: u32, count: u32) -> u32 {
            assert!(value < 1 << count);
            self.pass(value)
        }
    }

    #[test]
    fn numbers_come_back() {
        let numbers: Vec<u32> = (0..200).chain([1000, 65535, (1 << 22) + 25, (1 << 23) + 24]).collect();
        let mut tape = Tape::default();
        numbers.iter().for_each(|&number| assert_eq!(tape.number(0, number), number));
        tape.read = Some(0);
        numbers.iter().for_each(|&number| assert_eq!(tape.number(0, 0), number));
    }
}
