//! Entropy model of predictive depth: formats/depth-tables.txt (depth.md 15.8).

use std::sync::LazyLock;

use crate::depth::predictive::contexts::{ALPHABETS, CLUSTERS, CONTEXTS, FAMILIES};
use crate::entropy::built_in::BuiltIn;
use crate::entropy::{self, Family, Model};

/// Number of built-in table sets.
pub const BUILT_IN: usize = 9;

static FORMAT: BuiltIn<CONTEXTS, CLUSTERS, BUILT_IN> =
    BuiltIn::parse(include_bytes!(concat!(env!("LIGHTFOLD_FORMATS"), "/depth-tables.txt")), &FAMILIES, &ALPHABETS);

static CLUSTER_OF: [u8; CONTEXTS] = FORMAT.cluster_of;

/// Entropy model of predictive depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Predictive;

pub type TableSet = entropy::TableSet<Predictive>;
pub type Tables = entropy::Tables<Predictive>;

impl Model for Predictive {
    const TITLE: &'static str = "Entropy tables of predictive depth (depth.md 15.8)";
    const FILE: &'static str = "formats/depth-tables.txt";
    const FAMILIES: &'static [Family] = &FAMILIES;
    const ALPHABETS: &'static [u8] = &ALPHABETS;

    #[inline(always)]
    fn cluster_of(context: usize) -> usize {
        CLUSTER_OF[context].into()
    }

    fn built_in() -> &'static Tables {
        static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables::of_format(&FORMAT.sets));
        &TABLES
    }
}
