//! The table of knobs: every option that trades accuracy, bytes or time, by the name that it has on the command line.

use crate::dataset::stream::StreamKind;

/// The command that a knob is an option of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Encoding.
    Encode,
    /// Decoding.
    Decode,
    /// Both, as an option of every command.
    Both,
}

/// An option that trades accuracy, bytes or time.
#[derive(Debug, Clone, Copy)]
pub struct Knob {
    /// The option without its dashes, which is the name everywhere.
    pub name: &'static str,
    /// What reports call it, with its unit.
    pub label: &'static str,
    /// Kinds of streams that it changes.
    pub kinds: &'static [StreamKind],
    /// The command that it is an option of.
    pub stage: Stage,
    /// Settings without which it means nothing, given along unless they are swept or fixed themselves.
    pub implies: &'static [(&'static str, &'static str)],
    /// What is swept where no values are given.
    pub usual: &'static [&'static str],
}

use StreamKind::{Color, Depth, Material};

const ALL: &[StreamKind] = &[Color, Depth, Material];

/// All knobs, in the order of reports.
pub const KNOBS: &[Knob] = &[
    Knob {
        name: "depth-codec",
        label: "depth codec",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        usual: &["quadtree", "aabb", "bc4w"],
    },
    Knob {
        name: "depth-window",
        label: "depth window (frames)",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        usual: &["1", "2", "4", "8", "16"],
    },
    Knob {
        name: "max-aabbs",
        label: "AABB limit",
        kinds: &[Depth, Material],
        stage: Stage::Encode,
        implies: &[("depth-codec", "aabb")],
        usual: &["1", "2", "4", "8", "16"],
    },
    Knob { name: "threads", label: "threads", kinds: ALL, stage: Stage::Both, implies: &[], usual: &["1", "2"] },
    Knob { name: "device", label: "device", kinds: ALL, stage: Stage::Decode, implies: &[], usual: &["cpu", "gpu"] },
];

/// The knob of a name.
pub fn find(name: &str) -> Option<&'static Knob> {
    KNOBS.iter().find(|knob| knob.name == name)
}
