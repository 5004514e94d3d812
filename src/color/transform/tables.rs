//! Entropy tables (color.md 6.7): which contexts share a distribution, the built-in distributions, and those that a stream
//! brings along.

use std::sync::{Arc, LazyLock};

use crate::color::transform::contexts::{ALPHABETS, CLUSTERS, CONTEXTS, FAMILIES};
use crate::container::fields::Fields;
use crate::entropy::Distribution;
use crate::entropy::text_reader::TextReader;
use crate::error::Result;

/// Built-in sets.
pub const BUILT_IN: usize = 4;
/// Most sets that a stream brings along.
pub const MOST_OWN: usize = 8;

/// What formats/color-tables.txt says.
struct BuiltIn {
    cluster_of: [u8; CONTEXTS],
    sets: [[Distribution; CLUSTERS]; BUILT_IN],
}

static BUILT_IN_TABLES: BuiltIn = {
    let mut reader = TextReader::new(include_bytes!("../../../formats/color-tables.txt"));
    let mut cluster_of = [0; CONTEXTS];
    let mut family = 0;
    while family < FAMILIES.len() {
        let mut at = 0;
        while at < FAMILIES[family].contexts {
            cluster_of[FAMILIES[family].first_context + at] = reader.cluster(FAMILIES[family]);
            at += 1;
        }
        family += 1;
    }
    let mut sets = [[Distribution::CERTAIN; CLUSTERS]; BUILT_IN];
    let mut set = 0;
    while set < BUILT_IN {
        sets[set] = reader.set(&ALPHABETS);
        set += 1;
    }
    assert!(reader.is_at_end() && reader.fault().is_none(), "formats/color-tables.txt breaks color.md 6.7");
    BuiltIn { cluster_of, sets }
};

/// Distribution of each context.
pub static CLUSTER_OF: [u8; CONTEXTS] = BUILT_IN_TABLES.cluster_of;

/// Distributions of all clusters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableSet(Arc<[Distribution; CLUSTERS]>);

impl TableSet {
    pub fn new(distributions: [Distribution; CLUSTERS]) -> TableSet {
        TableSet(Arc::new(distributions))
    }

    #[inline(always)]
    pub fn distribution(&self, context: usize) -> &Distribution {
        &self.0[usize::from(CLUSTER_OF[context])]
    }

    pub fn distributions(&self) -> &[Distribution; CLUSTERS] {
        &self.0
    }

    fn read(fields: &mut Fields<'_>) -> Result<TableSet> {
        let mut distributions = [Distribution::CERTAIN; CLUSTERS];
        for (distribution, alphabet) in distributions.iter_mut().zip(ALPHABETS) {
            *distribution = Distribution::read(fields, alphabet.into())?;
        }
        Ok(TableSet::new(distributions))
    }
}

/// The sets that payloads of a stream name: the built-in ones, then the stream's own.
#[derive(Debug, Clone)]
pub struct Tables {
    sets: Arc<Vec<TableSet>>,
}

impl PartialEq for Tables {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.sets, &other.sets) || self.sets == other.sets
    }
}

impl Default for Tables {
    fn default() -> Self {
        static DEFAULT: LazyLock<Tables> = LazyLock::new(|| Tables::with_own(Vec::new()));
        DEFAULT.clone()
    }
}

impl Tables {
    pub fn with_own(own: Vec<TableSet>) -> Tables {
        static SHARED: LazyLock<[TableSet; BUILT_IN]> = LazyLock::new(|| BUILT_IN_TABLES.sets.map(TableSet::new));
        Tables { sets: Arc::new(SHARED.iter().cloned().chain(own).collect()) }
    }

    pub fn sets(&self) -> &[TableSet] {
        &self.sets
    }

    /// Sets that are not built in.
    pub fn own(&self) -> &[TableSet] {
        &self.sets[BUILT_IN..]
    }

    /// Reads the number of a stream's own sets, and the sets.
    pub fn read(fields: &mut Fields<'_>) -> Result<Tables> {
        let count = usize::from(fields.u8()?);
        if count > MOST_OWN {
            return Err(fields.error(format!("{count} table sets, at most {MOST_OWN} are legal")));
        }
        if count == 0 {
            return Ok(Tables::default());
        }
        Ok(Tables::with_own((0..count).map(|_| TableSet::read(fields)).collect::<Result<_>>()?))
    }

    /// The reverse of [`Tables::read`].
    pub fn write(&self, out: &mut Vec<u8>) {
        out.push(self.own().len() as u8);
        for set in self.own() {
            for (distribution, alphabet) in set.distributions().iter().zip(ALPHABETS) {
                distribution.write(alphabet.into(), out);
            }
        }
    }
}

#[cfg(feature = "encode")]
mod encode {
    use super::TableSet;
    use crate::color::transform::contexts::{ALPHABETS, CLUSTERS};
    use crate::entropy::{Distribution, SYMBOLS};

    impl TableSet {
        /// The set that suits counts of symbols by cluster.
        pub fn of_counts(counts: &[[u64; SYMBOLS]; CLUSTERS]) -> TableSet {
            let mut distributions = [Distribution::CERTAIN; CLUSTERS];
            for ((distribution, counts), alphabet) in distributions.iter_mut().zip(counts).zip(ALPHABETS) {
                *distribution = Distribution::of_counts(counts, alphabet.into());
            }
            TableSet::new(distributions)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contexts_share_distributions_of_their_family_and_every_symbol_has_a_slot() {
        for family in FAMILIES {
            let clusters = family.first_cluster..family.first_cluster + family.clusters;
            let contexts = family.first_context..family.first_context + family.contexts;
            assert!(contexts.clone().all(|context| clusters.contains(&usize::from(CLUSTER_OF[context]))));
            for set in Tables::default().sets() {
                for distribution in &set.distributions()[clusters.clone()] {
                    assert!((0..family.alphabet).all(|symbol| distribution.frequency(symbol) > 0));
                    assert_eq!((0..family.alphabet).map(|symbol| distribution.frequency(symbol)).sum::<u32>(), 4096);
                }
            }
        }
    }

    #[test]
    fn own_sets_come_back() {
        let own = Tables::default().sets()[..2].to_vec();
        let tables = Tables::with_own(own);
        let mut bytes = Vec::new();
        tables.write(&mut bytes);
        let mut fields = Fields::new(&bytes, 0, "");
        assert_eq!(Tables::read(&mut fields).unwrap(), tables);
        assert_eq!(fields.remaining(), 0);
        assert!(Tables::read(&mut Fields::new(&[9], 0, "")).is_err());
        assert!(Tables::read(&mut Fields::new(&bytes[..bytes.len() - 1], 0, "")).is_err());
    }
}
