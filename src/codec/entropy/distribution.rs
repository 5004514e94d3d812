//! Static distributions of symbols, with frequencies in 4096ths (entropy.md 2).

use crate::container::fields::Fields;
use crate::container::serialize::PutFields;
use crate::error::Result;

/// Maximum size of an alphabet.
pub const SYMBOLS: usize = 16;
pub const PRECISION: u32 = 12;
pub const SLOTS: u16 = 1 << PRECISION;

/// A distribution: symbol s has the slots `starts[s]..starts[s + 1]` of 4096.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Distribution {
    starts: [u16; SYMBOLS + 1],
}

impl Distribution {
    /// All slots belong to symbol 0.
    pub const CERTAIN: Distribution = {
        let mut starts = [SLOTS; SYMBOLS + 1];
        starts[0] = 0;
        Distribution { starts }
    };

    /// Creates a distribution from frequencies, which must sum to 4096.
    pub const fn of_frequencies(frequencies: &[u16; SYMBOLS]) -> Distribution {
        let mut starts = [0; SYMBOLS + 1];
        let mut symbol = 0;
        while symbol < SYMBOLS {
            starts[symbol + 1] = starts[symbol] + frequencies[symbol];
            symbol += 1;
        }
        assert!(starts[SYMBOLS] == SLOTS, "frequencies with a wrong sum");
        Distribution { starts }
    }

    #[inline(always)]
    pub fn start(&self, symbol: usize) -> u32 {
        u32::from(self.starts[symbol])
    }

    #[inline(always)]
    pub fn frequency(&self, symbol: usize) -> u32 {
        u32::from(self.starts[symbol + 1] - self.starts[symbol])
    }

    /// Returns the symbol of a slot.
    #[inline(always)]
    pub fn symbol(&self, slot: u16) -> usize {
        if slot < self.starts[1] {
            return 0;
        }
        // A branch-free count, which vectorises: all later symbols start after the slot.
        let [starts @ .., _] = &self.starts;
        let count = starts.iter().fold(0, |count, &start| count + i16::from(start as i16 <= slot as i16));
        count as usize - 1
    }

    pub fn starts(&self) -> &[u16; SYMBOLS + 1] {
        &self.starts
    }

    /// Reads the frequencies of all symbols of an alphabet except the last, which has the rest of 4096.
    pub fn read(fields: &mut Fields<'_>, alphabet: usize) -> Result<Distribution> {
        let mut starts = [SLOTS; SYMBOLS + 1];
        starts[0] = 0;
        for symbol in 1..alphabet {
            let start = u64::from(starts[symbol - 1]) + fields.varint()?;
            if start > u64::from(SLOTS) {
                return Err(fields.error(format!("the frequencies of a distribution sum to more than {SLOTS}")));
            }
            starts[symbol] = start as u16;
        }
        Ok(Distribution { starts })
    }

    /// Writes the distribution, as [`Distribution::read`] reads it.
    pub fn write(&self, alphabet: usize, out: &mut Vec<u8>) {
        for symbol in 0..alphabet - 1 {
            out.put_varint(self.frequency(symbol).into());
        }
    }
}

#[cfg(feature = "encode")]
mod encode {
    use super::{Distribution, SLOTS, SYMBOLS};

    impl Distribution {
        /// Returns a distribution that codes `counts` in nearly the fewest bits; each symbol of the alphabet has at least one
        /// slot.
        pub fn of_counts(counts: &[u64; SYMBOLS], alphabet: usize) -> Distribution {
            let total = counts.iter().sum::<u64>().max(1);
            let mut frequencies = [0u64; SYMBOLS];
            for (frequency, &count) in frequencies.iter_mut().zip(counts).take(alphabet) {
                *frequency = ((count * u64::from(SLOTS) + total / 2) / total).max(1);
            }
            // Corrects the rounding error of the sum in the largest frequency, where it changes the relative error least.
            let mut sum: u64 = frequencies.iter().sum();
            while sum != u64::from(SLOTS) {
                let most = |&symbol: &usize| frequencies[symbol];
                let Some(largest) = (0..alphabet).max_by_key(most) else { break };
                let missing = u64::from(SLOTS) as i64 - sum as i64;
                let change = missing.clamp(-(frequencies[largest] as i64 / 8).max(1), i64::from(SLOTS));
                frequencies[largest] = (frequencies[largest] as i64 + change) as u64;
                sum = (sum as i64 + change) as u64;
            }
            let mut starts = [SLOTS; SYMBOLS + 1];
            starts[0] = 0;
            for symbol in 1..alphabet {
                starts[symbol] = starts[symbol - 1] + frequencies[symbol - 1] as u16;
            }
            Distribution { starts }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slot_has_its_symbol_and_bytes_come_back() {
        let mut counts = [0; SYMBOLS];
        for alphabet in 2..=SYMBOLS {
            counts[alphabet - 1] = 1 << (3 * (alphabet % 5));
            let distribution = Distribution::of_counts(&counts, alphabet);
            assert_eq!((0..alphabet).map(|symbol| distribution.frequency(symbol)).sum::<u32>(), u32::from(SLOTS));
            for slot in 0..SLOTS {
                let symbol = distribution.symbol(slot);
                assert!(
                    symbol < alphabet && u32::from(slot) - distribution.start(symbol) < distribution.frequency(symbol)
                );
            }
            let mut bytes = Vec::new();
            distribution.write(alphabet, &mut bytes);
            let mut fields = Fields::new(&bytes, 0, "");
            assert_eq!(Distribution::read(&mut fields, alphabet).unwrap(), distribution);
            assert_eq!(fields.remaining(), 0);
        }
    }

    #[test]
    fn frequencies_beyond_all_slots_are_refused() {
        let mut bytes = Vec::new();
        [4000, 97].iter().for_each(|&frequency| bytes.put_varint(frequency));
        assert!(Distribution::read(&mut Fields::new(&bytes, 0, ""), 3).is_err());
    }
}
