//! Entropy models: the contexts of a codec's symbols, the distributions that they share, and table sets: the built-in ones of
//! a format and a stream's own ones (entropy.md 4).

use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;

use crate::container::fields::Fields;
use crate::entropy::Distribution;
use crate::error::Result;

/// Maximum number of a stream's own sets.
pub const MAX_OWN: usize = 8;

/// Symbols of one kind: number of contexts, size of the alphabet, and the distributions (clusters) that the contexts share.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    pub first_context: usize,
    pub contexts: usize,
    pub alphabet: usize,
    pub first_cluster: usize,
    pub clusters: usize,
}

impl Family {
    /// Creates the first family of a codec.
    pub const fn first(contexts: usize, alphabet: usize, clusters: usize) -> Family {
        Family { first_context: 0, contexts, alphabet, first_cluster: 0, clusters }
    }

    /// Creates a family whose contexts and clusters are numbered after those of `before`.
    pub const fn after(before: Family, contexts: usize, alphabet: usize, clusters: usize) -> Family {
        Family {
            first_context: before.first_context + before.contexts,
            contexts,
            alphabet,
            first_cluster: before.first_cluster + before.clusters,
            clusters,
        }
    }

    /// Alphabet size of each cluster of all families of a codec.
    pub const fn alphabets<const CLUSTERS: usize>(families: &[Family]) -> [u8; CLUSTERS] {
        let mut alphabets = [0; CLUSTERS];
        let mut at = 0;
        while at < families.len() {
            let mut cluster = 0;
            while cluster < families[at].clusters {
                alphabets[families[at].first_cluster + cluster] = families[at].alphabet as u8;
                cluster += 1;
            }
            at += 1;
        }
        alphabets
    }
}

/// The entropy model of a codec.
pub trait Model: Debug + Clone + Copy + PartialEq + Eq + Send + Sync + 'static {
    /// First line of [`Model::FILE`], up to its colon.
    const TITLE: &'static str;
    /// File of the format with the distribution of each context and the built-in sets.
    const FILE: &'static str;
    const FAMILIES: &'static [Family];
    /// Alphabet size of each distribution.
    const ALPHABETS: &'static [u8];

    /// Returns the index of the distribution of a context.
    fn cluster_of(context: usize) -> usize;

    /// Returns the built-in sets, without own ones.
    fn built_in() -> &'static Tables<Self>;
}

/// A table set: all distributions of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableSet<M>(Arc<[Distribution]>, PhantomData<M>);

impl<M: Model> TableSet<M> {
    /// Creates a set; the number of distributions must be that of the model.
    pub fn new(distributions: &[Distribution]) -> TableSet<M> {
        debug_assert_eq!(distributions.len(), M::ALPHABETS.len());
        TableSet(distributions.into(), PhantomData)
    }

    #[inline(always)]
    pub fn distribution(&self, context: usize) -> &Distribution {
        &self.0[M::cluster_of(context)]
    }

    pub fn distributions(&self) -> &[Distribution] {
        &self.0
    }

    fn read(fields: &mut Fields<'_>) -> Result<TableSet<M>> {
        let read = |&alphabet: &u8| Distribution::read(fields, alphabet.into());
        Ok(TableSet(M::ALPHABETS.iter().map(read).collect::<Result<_>>()?, PhantomData))
    }
}

/// Table sets that payloads of a stream refer to: the built-in ones, then the stream's own.
#[derive(Debug, Clone)]
pub struct Tables<M> {
    sets: Arc<Vec<TableSet<M>>>,
    built_in: usize,
}

impl<M: Model> PartialEq for Tables<M> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.sets, &other.sets) || self.sets == other.sets
    }
}

impl<M: Model> Eq for Tables<M> {}

impl<M: Model> Default for Tables<M> {
    fn default() -> Self {
        M::built_in().clone()
    }
}

impl<M: Model> Tables<M> {
    /// Creates the built-in sets of a model, for [`Model::built_in`].
    pub fn of_format<const CLUSTERS: usize>(sets: &[[Distribution; CLUSTERS]]) -> Tables<M> {
        let tables = Tables::of_sets(sets.iter().map(|set| TableSet::new(set)).collect());
        Tables { built_in: sets.len(), ..tables }
    }

    /// Creates tables of these sets only, without the built-in ones.
    pub fn of_sets(sets: Vec<TableSet<M>>) -> Tables<M> {
        Tables { sets: Arc::new(sets), built_in: 0 }
    }

    pub fn with_own(own: Vec<TableSet<M>>) -> Tables<M> {
        let Tables { sets, built_in } = M::built_in();
        Tables { sets: Arc::new(sets.iter().cloned().chain(own).collect()), built_in: *built_in }
    }

    pub fn sets(&self) -> &[TableSet<M>] {
        &self.sets
    }

    /// Returns the sets that are not built in.
    pub fn own(&self) -> &[TableSet<M>] {
        &self.sets[self.built_in..]
    }

    /// Reads `count` own sets of a stream.
    pub fn read(fields: &mut Fields<'_>, count: u8) -> Result<Tables<M>> {
        let count = usize::from(count);
        if count > MAX_OWN {
            return Err(fields.error(format!("{count} table sets, at most {MAX_OWN} are legal")));
        }
        if count == 0 {
            return Ok(Tables::default());
        }
        Ok(Tables::with_own((0..count).map(|_| TableSet::read(fields)).collect::<Result<_>>()?))
    }

    /// Number of own sets.
    pub fn own_count(&self) -> u8 {
        self.own().len() as u8
    }

    /// Writes the own sets, as [`Tables::read`] reads them.
    pub fn write(&self, out: &mut Vec<u8>) {
        for set in self.own() {
            for (distribution, &alphabet) in set.distributions().iter().zip(M::ALPHABETS) {
                distribution.write(alphabet.into(), out);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transform::contexts::Transform;
    use crate::depth::predictive::contexts::Predictive;

    #[test]
    fn own_sets_come_back() {
        check::<Transform>();
        check::<Predictive>();
    }

    fn check<M: Model>() {
        let own = Tables::<M>::default().sets()[..2].to_vec();
        let tables = Tables::with_own(own);
        let mut bytes = Vec::new();
        tables.write(&mut bytes);
        let mut fields = Fields::new(&bytes, 0, "");
        assert_eq!(Tables::<M>::read(&mut fields, 2).unwrap(), tables);
        assert_eq!(fields.remaining(), 0);
        assert!(Tables::<M>::read(&mut Fields::new(&bytes, 0, ""), 9).is_err());
        assert!(Tables::<M>::read(&mut Fields::new(&bytes[..bytes.len() - 1], 0, ""), 2).is_err());
    }

    #[test]
    fn contexts_share_distributions_of_their_family_and_every_symbol_has_a_slot() {
        check_model::<Transform>();
        check_model::<Predictive>();
    }

    fn check_model<M: Model>() {
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
