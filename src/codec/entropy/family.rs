//! Symbol families: contexts, and the distributions that they share.

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
