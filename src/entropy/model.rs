//! Entropy models: the contexts of a codec's symbols, the distributions that they share, and the table sets of its format.

use std::fmt::Debug;

use crate::entropy::tables::Tables;
use crate::entropy::text_reader::TextReader;
use crate::entropy::{Distribution, Family};

/// The entropy model of a codec.
pub trait Model: Debug + Clone + Copy + PartialEq + Eq + Send + Sync + 'static {
    /// What [`Model::FILE`] is called in its first line.
    const TITLE: &'static str;
    /// The file of the format that has the contexts' distributions and the built-in sets.
    const FILE: &'static str;
    const FAMILIES: &'static [Family];
    /// Values of the symbols of each distribution.
    const ALPHABETS: &'static [u8];

    /// The distribution of a context.
    fn cluster_of(context: usize) -> usize;

    /// The built-in sets alone.
    fn built_in() -> &'static Tables<Self>;
}

/// What a file of the format says: the distribution of each context, and the built-in sets.
pub struct BuiltIn<const CONTEXTS: usize, const CLUSTERS: usize, const SETS: usize> {
    pub cluster_of: [u8; CONTEXTS],
    pub sets: [[Distribution; CLUSTERS]; SETS],
}

impl<const CONTEXTS: usize, const CLUSTERS: usize, const SETS: usize> BuiltIn<CONTEXTS, CLUSTERS, SETS> {
    /// Fails at compile time if the text is not of this form.
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

#[cfg(test)]
mod tests {
    use super::Model;
    use crate::color::transform::tables::Transform;
    use crate::depth::predictive::tables::Predictive;

    #[test]
    fn contexts_share_distributions_of_their_family_and_every_symbol_has_a_slot() {
        check::<Transform>();
        check::<Predictive>();
    }

    fn check<M: Model>() {
        for family in M::FAMILIES {
            let clusters = family.first_cluster..family.first_cluster + family.clusters;
            let mut contexts = family.first_context..family.first_context + family.contexts;
            assert!(contexts.all(|context| clusters.contains(&M::cluster_of(context))));
            for set in M::built_in().sets() {
                for distribution in &set.distributions()[clusters.clone()] {
                    assert!((0..family.alphabet).all(|symbol| distribution.frequency(symbol) > 0));
                    assert_eq!((0..family.alphabet).map(|symbol| distribution.frequency(symbol)).sum::<u32>(), 4096);
                }
            }
        }
    }
}
