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
    /// Placing cameras in a scene ([`super::placement`]).
    Place,
    /// Rendering what a left-out probe shows ([`super::rendering`]).
    Render,
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
    /// The value that stands for leaving the option out, where none that the option takes does.
    pub without: Option<&'static str>,
    /// What it is where it is not given, for people.
    pub default: &'static str,
    /// What is swept where no values are given.
    pub usual: &'static [&'static str],
}

use StreamKind::{Color, Depth, Material};

const ALL: &[StreamKind] = &[Color, Depth, Material];

/// All knobs of encoding and decoding, in the order of reports.
pub const KNOBS: &[Knob] = &[
    Knob {
        name: "depth-codec",
        label: "depth codec",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "quadtree",
        usual: &["quadtree", "aabb", "bc4w"],
    },
    Knob {
        name: "depth-window",
        label: "depth window (frames)",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "2",
        usual: &["1", "2", "4", "8", "16"],
    },
    Knob {
        name: "max-aabbs",
        label: "AABB limit",
        kinds: &[Depth, Material],
        stage: Stage::Encode,
        implies: &[("depth-codec", "aabb")],
        without: None,
        default: "8",
        usual: &["1", "2", "4", "8", "16"],
    },
    Knob {
        name: "update-threshold",
        label: "update threshold (codes)",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "0, with bc5 100",
        usual: &["0", "10", "30", "100"],
    },
    Knob {
        name: "max-error",
        label: "error bound E (codes)",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "100",
        usual: &["0", "10", "25", "50", "100", "200", "400", "800"],
    },
    Knob {
        name: "max-error-relative",
        label: "error bound (relative to the depth)",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "as max-error",
        usual: &["0%", "0.05%", "0.1%", "0.2%", "0.5%"],
    },
    Knob {
        name: "depth-domain",
        label: "domain of functions",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "log",
        usual: &["log", "linear", "inverse"],
    },
    Knob {
        name: "optimize",
        label: "optimization goal",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "quality",
        usual: &["quality", "size"],
    },
    Knob {
        name: "min-children",
        label: "children changed before one function is tried",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "3",
        usual: &["1", "2", "3", "4"],
    },
    Knob {
        name: "depth-block",
        label: "depth blocks",
        kinds: &[Depth],
        stage: Stage::Encode,
        implies: &[("depth-codec", "aabb")],
        without: None,
        default: "none",
        usual: &["none", "bc5"],
    },
    Knob {
        name: "depth-tile",
        label: "tile size (pixels)",
        kinds: &[Depth, Material],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "half of the face",
        usual: &["32", "64", "128", "256"],
    },
    Knob {
        name: "keyframe-interval",
        label: "keyframe interval (frames)",
        kinds: &[Depth, Material],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "64",
        usual: &["4", "8", "16", "32", "64"],
    },
    Knob {
        name: "color-cell",
        label: "cell size (pixels)",
        kinds: &[Color],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "64",
        usual: &["8", "16", "32", "64", "128"],
    },
    Knob {
        name: "psnr",
        label: "PSNR threshold (dB)",
        kinds: &[Color],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "50, in blocks as psnr-final",
        usual: &["30", "35", "40", "45", "50"],
    },
    Knob {
        name: "color-block",
        label: "colour blocks",
        kinds: &[Color],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "none",
        usual: &["none", "bc1", "bc7"],
    },
    Knob {
        name: "psnr-final",
        label: "PSNR threshold in blocks (dB)",
        kinds: &[Color],
        stage: Stage::Encode,
        implies: &[("color-block", "bc7")],
        without: None,
        default: "30 for bc1, else 40",
        usual: &["30", "35", "40", "45"],
    },
    Knob {
        name: "keyframe-reach",
        label: "keyframe reach (pictures)",
        kinds: &[Color],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "64",
        usual: &["4", "16", "64", "256"],
    },
    Knob {
        name: "material-error",
        label: "error bound of material (steps of 8 bits)",
        kinds: &[Material],
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "0",
        usual: &["0", "2", "4", "8", "16"],
    },
    Knob {
        name: "effort",
        label: "effort",
        kinds: ALL,
        stage: Stage::Encode,
        implies: &[],
        without: None,
        default: "normal",
        usual: &["fast", "normal"],
    },
    Knob {
        name: "lzma2",
        label: "LZMA2 level",
        kinds: ALL,
        stage: Stage::Encode,
        implies: &[],
        without: Some("none"),
        default: "none",
        usual: &["none", "1", "6", "9"],
    },
    Knob {
        name: "threads",
        label: "threads",
        kinds: ALL,
        stage: Stage::Both,
        implies: &[],
        without: None,
        default: "all",
        usual: &["1", "2", "4"],
    },
    Knob {
        name: "device",
        label: "device",
        kinds: ALL,
        stage: Stage::Decode,
        implies: &[],
        without: None,
        default: "cpu",
        usual: &["cpu", "gpu"],
    },
];

/// Former names of knobs: still accepted, and the keys in JSON.
const FORMER_NAMES: &[(&str, &str)] = &[
    ("cell", "color-cell"),
    ("decide", "optimize"),
    ("epsilon", "update-threshold"),
    ("error", "max-error"),
    ("error-relative", "max-error-relative"),
];

/// The knob of a name.
pub fn find(name: &str) -> Option<&'static Knob> {
    let name = FORMER_NAMES.iter().find(|(former, _)| *former == name).map_or(name, |(_, now)| *now);
    KNOBS.iter().find(|knob| knob.name == name)
}

/// The key of a knob in JSON: the first name that it had.
pub fn json_key(name: &'static str) -> &'static str {
    FORMER_NAMES.iter().find(|(_, now)| *now == name).map_or(name, |(former, _)| former)
}

impl Knob {
    /// The option with a value, as a command line has it; none for the value that leaves it out.
    pub fn option(&self, value: &str) -> Option<String> {
        (self.without != Some(value)).then(|| format!("--{}={value}", self.name))
    }

    /// Whether streams of a kind depend on it.
    pub fn concerns(&self, kind: StreamKind) -> bool {
        self.kinds.contains(&kind)
    }

    /// Whether it says nothing about a single kind: such knobs join every study.
    pub fn is_general(&self) -> bool {
        self.kinds == ALL
    }
}

/// A value as a number, where it is one: `16`, `0.5`, `0.1%` (which is 0.1).
pub fn number(value: &str) -> Option<f64> {
    value.strip_suffix('%').unwrap_or(value).parse().ok().filter(|number: &f64| number.is_finite())
}
