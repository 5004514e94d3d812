//! Reader of entropy tables in the text form of formats/color-tables.txt (entropy.md 4). It parses the built-in sets at
//! compile time, and the own sets of a stream in an encoder.

use crate::entropy::distribution::SLOTS;
use crate::entropy::{Distribution, Family, SYMBOLS};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    Character,
    End,
    TooLarge {
        most: u16,
    },
    /// A frequency of 0: an encoder needs at least 1 for each symbol.
    NoFrequency,
    /// Frequencies that do not sum to 4096.
    Sum(u32),
}

/// Keeps the first fault and its line; values that are read after it have no meaning. Functions at compile time cannot use
/// `?`.
#[derive(Debug)]
pub struct TextReader<'a> {
    text: &'a [u8],
    at: usize,
    line: usize,
    fault: Option<Fault>,
}

impl<'a> TextReader<'a> {
    pub const fn new(text: &'a [u8]) -> TextReader<'a> {
        TextReader { text, at: 0, line: 1, fault: None }
    }

    /// Returns the first fault and its line.
    pub const fn fault(&self) -> Option<(Fault, usize)> {
        match self.fault {
            Some(fault) => Some((fault, self.line)),
            None => None,
        }
    }

    pub const fn line(&self) -> usize {
        self.line
    }

    /// True if only whitespace and comments remain.
    pub const fn is_at_end(&mut self) -> bool {
        let mut in_comment = false;
        while self.fault.is_none() && self.at < self.text.len() {
            match self.text[self.at] {
                b'\n' => {
                    in_comment = false;
                    self.line += 1;
                }
                b'#' => in_comment = true,
                byte if in_comment || byte.is_ascii_whitespace() => {}
                _ => return false,
            }
            self.at += 1;
        }
        self.at == self.text.len()
    }

    /// Reads the cluster of a context of `family`; returns its index among the clusters of all families.
    pub const fn cluster(&mut self, family: Family) -> u8 {
        (family.first_cluster + self.number(family.clusters as u16 - 1) as usize) as u8
    }

    /// Reads the distributions of all clusters; `alphabets` has their alphabet sizes.
    pub const fn set<const CLUSTERS: usize>(&mut self, alphabets: &[u8; CLUSTERS]) -> [Distribution; CLUSTERS] {
        let mut set = [Distribution::CERTAIN; CLUSTERS];
        let mut cluster = 0;
        while cluster < CLUSTERS && self.fault.is_none() {
            set[cluster] = self.distribution(alphabets[cluster] as usize);
            cluster += 1;
        }
        set
    }

    pub const fn distribution(&mut self, alphabet: usize) -> Distribution {
        let mut frequencies = [0; SYMBOLS];
        let (mut symbol, mut sum) = (0, 0);
        while symbol < alphabet {
            frequencies[symbol] = self.number(SLOTS);
            if frequencies[symbol] == 0 {
                self.refuse(Fault::NoFrequency);
            }
            sum += frequencies[symbol] as u32;
            symbol += 1;
        }
        if sum != SLOTS as u32 {
            self.refuse(Fault::Sum(sum));
            return Distribution::CERTAIN;
        }
        Distribution::of_frequencies(&frequencies)
    }

    const fn number(&mut self, most: u16) -> u16 {
        if self.is_at_end() {
            self.refuse(Fault::End);
        }
        let start = self.at;
        let mut value: u32 = 0;
        while self.fault.is_none() && self.at < self.text.len() && self.text[self.at].is_ascii_digit() {
            value = value.saturating_mul(10).saturating_add((self.text[self.at] - b'0') as u32);
            self.at += 1;
        }
        if self.at == start {
            self.refuse(Fault::Character);
        } else if value > most as u32 {
            self.refuse(Fault::TooLarge { most });
        }
        if self.fault.is_some() { 0 } else { value as u16 }
    }

    const fn refuse(&mut self, fault: Fault) {
        if self.fault.is_none() {
            self.fault = Some(fault);
        }
    }
}

/// Content of a table file of the format: the distribution of each context, and the built-in sets.
pub struct BuiltIn<const CONTEXTS: usize, const CLUSTERS: usize, const SETS: usize> {
    pub cluster_of: [u8; CONTEXTS],
    pub sets: [[Distribution; CLUSTERS]; SETS],
}

impl<const CONTEXTS: usize, const CLUSTERS: usize, const SETS: usize> BuiltIn<CONTEXTS, CLUSTERS, SETS> {
    /// Parses a table file. Fails at compile time if the text is malformed.
    pub const fn parse(text: &[u8], families: &[Family], alphabets: &[u8; CLUSTERS]) -> Self {
        let mut reader = TextReader::new(text);
        let mut cluster_of = [0; CONTEXTS];
        let mut family = 0;
        while family < families.len() {
            let mut at = 0;
            while at < families[family].contexts {
                cluster_of[families[family].first_context + at] = reader.cluster(families[family]);
                at += 1;
            }
            family += 1;
        }
        let mut sets = [[Distribution::CERTAIN; CLUSTERS]; SETS];
        let mut set = 0;
        while set < SETS {
            sets[set] = reader.set(alphabets);
            set += 1;
        }
        assert!(reader.is_at_end() && reader.fault().is_none(), "a file of entropy tables that breaks its format");
        BuiltIn { cluster_of, sets }
    }
}
