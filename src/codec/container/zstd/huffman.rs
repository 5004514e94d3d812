//! Huffman codes of literals (RFC 8878, 4.2).

use super::bits::{BackwardBits, damaged};
use super::fse;
use crate::error::Result;

/// Maximum code length in bits.
const MAX_BITS: u32 = 11;
const ROWS: usize = 1 << MAX_BITS;
/// Maximum number of weights in a description; the weight of the last symbol follows from them.
const MAX_WEIGHTS: usize = 255;
const WEIGHT_LIMITS: fse::Limits = fse::Limits { accuracy: 6, symbols: 256 };

/// Decoding table, indexed by the next 11 bits: the symbol times 16, plus the length of its code in bits.
pub struct Table(Box<[u16; ROWS]>);

impl Table {
    /// Reads a table description. Returns its code and the number of bytes read.
    pub fn read(bytes: &[u8]) -> Result<(Table, usize)> {
        let early = || damaged("a Huffman table ends early");
        let (&head, rest) = bytes.split_first().ok_or_else(early)?;
        let count = usize::from(head.saturating_sub(127));
        let size = if count > 0 { count.div_ceil(2) } else { head.into() };
        let packed = rest.get(..size).ok_or_else(early)?;
        let weights = match count {
            0 => compressed_weights(packed)?,
            _ => packed.iter().flat_map(|byte| [byte >> 4, byte & 15]).take(count).collect(),
        };
        Ok((Table::of_weights(weights)?, 1 + size))
    }

    fn of_weights(mut weights: Vec<u8>) -> Result<Table> {
        let illegal = || damaged("a Huffman table is illegal");
        if weights.iter().any(|weight| u32::from(*weight) > MAX_BITS) {
            return Err(illegal());
        }
        let total: u32 = weights.iter().filter(|weight| **weight > 0).map(|weight| 1 << (weight - 1)).sum();
        let longest = 32 - total.leading_zeros();
        let rest = (1 << longest) - total;
        weights.push(32 - rest.leading_zeros() as u8);
        // Without a symbol of the maximum length, the code would be one of fewer bits.
        let is_deepest = weights.contains(&1);
        if total == 0 || longest > MAX_BITS || !rest.is_power_of_two() || !is_deepest {
            return Err(illegal());
        }
        let mut rows = Box::new([0; ROWS]);
        let mut at = 0;
        for weight in 1..=longest {
            let length = longest + 1 - weight;
            for symbol in (0..weights.len()).filter(|symbol| u32::from(weights[*symbol]) == weight) {
                let end = at + (ROWS >> length);
                rows[at..end].fill((symbol as u16) << 4 | length as u16);
                at = end;
            }
        }
        Ok(Table(rows))
    }

    /// Decodes a stream, which must fill `out` exactly.
    pub fn decode(&self, bytes: &[u8], out: &mut [u8]) -> Result<()> {
        let mut bits = BackwardBits::new(bytes)?;
        // A word has the bits of at least five codes.
        for symbols in out.chunks_mut(5) {
            let mut word = bits.peek();
            let mut used = 0;
            for symbol in symbols {
                let row = self.0[(word >> (64 - MAX_BITS)) as usize % ROWS];
                *symbol = (row >> 4) as u8;
                let length = u32::from(row & 15);
                word <<= length;
                used += length;
            }
            bits.skip(used);
        }
        if bits.left() != 0 {
            return Err(damaged("a stream of literals has a wrong length"));
        }
        Ok(())
    }
}

/// Reads weights in an FSE code with two interleaved states.
fn compressed_weights(packed: &[u8]) -> Result<Vec<u8>> {
    let (table, used) = fse::Table::read(packed, WEIGHT_LIMITS)?;
    let mut bits = BackwardBits::new(&packed[used..])?;
    let mut states = [table.start(&mut bits), table.start(&mut bits)];
    if bits.left() < 0 {
        return Err(damaged("the weights of a Huffman table end early"));
    }
    let mut weights = Vec::with_capacity(MAX_WEIGHTS + 1);
    loop {
        let row = table.row(states[0]);
        weights.push(row.symbol);
        if weights.len() >= MAX_WEIGHTS {
            return Err(damaged("a Huffman table has too many weights"));
        }
        states = [states[1], row.next(&mut bits)];
        if bits.left() < 0 {
            weights.push(table.row(states[0]).symbol);
            return Ok(weights);
        }
    }
}
