//! Entropy model of the transform codec: formats/color-tables.txt (color.md 6.7).

use std::sync::LazyLock;

use crate::color::transform::contexts::{ALPHABETS, CLUSTERS, CONTEXTS, FAMILIES};
use crate::entropy::built_in::BuiltIn;
use crate::entropy::{self, Family, Model};

/// Number of built-in sets.
pub const BUILT_IN: usize = 10;

static FORMAT: BuiltIn<CONTEXTS, CLUSTERS, BUILT_IN> =
    BuiltIn::parse(include_bytes!(concat!(env!("LIGHTFOLD_FORMATS"), "/color-tables.txt")), &FAMILIES, &ALPHABETS);

/// Index of the distribution of each context.
pub static CLUSTER_OF: [u8; CONTEXTS] = FORMAT.cluster_of;

/// Entropy model of the transform codec.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transform;

pub type TableSet = entropy::TableSet<Transform>;
pub type Tables = entropy::Tables<Transform>;

impl Model for Transform {
    const TITLE: &'static str = "Entropy tables of the transform codec (color.md 6.7)";
    const FILE: &'static str = "formats/color-tables.txt";
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
