//! FSE codes (RFC 8878, 4.1): distributions of symbols, and their decoding tables.

use super::bits::{BackwardBits, ForwardBits, damaged};
use crate::error::Result;

/// Entry of a decoding table: the symbol of a state, and the next state as a base plus `bits` bits.
#[derive(Debug, Clone, Copy, Default)]
pub struct Row {
    pub symbol: u8,
    bits: u8,
    base: u16,
}

/// Maximum accuracy, which is log2 of the table size, and maximum number of symbols of a code.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    pub accuracy: u32,
    pub symbols: usize,
}

#[derive(Debug, Clone)]
pub struct Table {
    accuracy: u32,
    rows: Vec<Row>,
}

impl Table {
    /// Builds the code of a single symbol, which takes no bits.
    pub fn of_one(symbol: u8) -> Self {
        Table { accuracy: 0, rows: vec![Row { symbol, bits: 0, base: 0 }] }
    }

    /// Builds the code of a distribution whose magnitudes sum to 2^accuracy; −1 is a probability below 1.
    pub fn new(accuracy: u32, counts: &[i16]) -> Self {
        let size = 1usize << accuracy;
        let mut rows = vec![Row::default(); size];
        let mut high = size;
        for (symbol, _) in counts.iter().enumerate().filter(|(_, count)| **count == -1) {
            high -= 1;
            rows[high].symbol = symbol as u8;
        }
        let step = (size >> 1) + (size >> 3) + 3;
        let mut at = 0;
        for (symbol, &count) in counts.iter().enumerate() {
            for _ in 0..count.max(0) {
                rows[at].symbol = symbol as u8;
                at = (at + step) & (size - 1);
                while at >= high {
                    at = (at + step) & (size - 1);
                }
            }
        }
        let mut next: Vec<u32> = counts.iter().map(|count| count.unsigned_abs().into()).collect();
        for row in &mut rows {
            let state = &mut next[usize::from(row.symbol)];
            let bits = accuracy - state.ilog2();
            (row.bits, row.base) = (bits as u8, ((*state << bits) - size as u32) as u16);
            *state += 1;
        }
        Table { accuracy, rows }
    }

    /// Reads a distribution. Returns its code and the number of bytes read.
    pub fn read(bytes: &[u8], limits: Limits) -> Result<(Table, usize)> {
        let mut bits = ForwardBits::new(bytes);
        let accuracy = bits.take(4)? + 5;
        if accuracy > limits.accuracy {
            return Err(damaged(format_args!("a table of {accuracy} bits, {} at most", limits.accuracy)));
        }
        let mut counts: Vec<i16> = Vec::with_capacity(limits.symbols);
        let mut left = (1i32 << accuracy) + 1;
        while left > 1 && counts.len() < limits.symbols {
            let width = 32 - left.leading_zeros();
            let (half, low) = (1 << (width - 1), (1 << width) - 1 - left);
            let mut value = bits.take(width - 1)? as i32;
            if value >= low && bits.take(1)? == 1 {
                value += half - low;
            }
            let count = value - 1;
            counts.push(count as i16);
            left -= count.abs();
            let mut repeat = if count == 0 { 3 } else { 0 };
            while repeat == 3 {
                repeat = bits.take(2)?;
                counts.resize(counts.len() + repeat as usize, 0);
            }
        }
        if left != 1 || counts.len() > limits.symbols {
            return Err(damaged("the probabilities of a table have a wrong sum"));
        }
        Ok((Table::new(accuracy, &counts), bits.used_bytes()))
    }

    /// Reads the initial state.
    pub fn start(&self, bits: &mut BackwardBits<'_>) -> usize {
        bits.take(self.accuracy) as usize
    }

    #[inline]
    pub fn row(&self, state: usize) -> Row {
        self.rows[state]
    }
}

impl Row {
    #[inline]
    pub fn next(self, bits: &mut BackwardBits<'_>) -> usize {
        usize::from(self.base) + bits.take(self.bits.into()) as usize
    }
}
