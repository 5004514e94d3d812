//! Built-in entropy tables: a file of the format, parsed at compile time.

use crate::entropy::text_reader::TextReader;
use crate::entropy::{Distribution, Family};

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
