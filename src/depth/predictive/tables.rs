//! The distributions of all contexts: formats/depth-tables.txt (depth.md 15.8).

use crate::depth::predictive::contexts::{ALPHABETS, CLUSTERS, CONTEXTS, FAMILIES};
use crate::entropy::Distribution;
use crate::entropy::text_reader::TextReader;

/// Table sets that payloads name.
pub const SETS: usize = 8;

struct BuiltIn {
    cluster_of: [u8; CONTEXTS],
    sets: [[Distribution; CLUSTERS]; SETS],
}

static BUILT_IN: BuiltIn = {
    let mut reader = TextReader::new(include_bytes!("../../../formats/depth-tables.txt"));
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
    let mut sets = [[Distribution::CERTAIN; CLUSTERS]; SETS];
    let mut set = 0;
    while set < SETS {
        sets[set] = reader.set(&ALPHABETS);
        set += 1;
    }
    assert!(reader.is_at_end() && reader.fault().is_none(), "formats/depth-tables.txt breaks depth.md 15.8");
    BuiltIn { cluster_of, sets }
};

/// Distribution of each context.
pub static CLUSTER_OF: [u8; CONTEXTS] = BUILT_IN.cluster_of;

/// A set of distributions.
#[derive(Debug, Clone, Copy)]
pub struct TableSet(&'static [Distribution; CLUSTERS]);

impl TableSet {
    /// `set` is below [`SETS`].
    pub fn new(set: usize) -> Option<TableSet> {
        BUILT_IN.sets.get(set).map(TableSet)
    }

    pub fn all() -> [TableSet; SETS] {
        BUILT_IN.sets.each_ref().map(TableSet)
    }

    #[inline(always)]
    pub fn distribution(self, context: usize) -> &'static Distribution {
        &self.0[usize::from(CLUSTER_OF[context])]
    }

    pub fn distributions(self) -> &'static [Distribution; CLUSTERS] {
        self.0
    }
}
