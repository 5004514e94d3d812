//! Knobs: options that trade quality, bytes or time, by the names that they have on the command line.

use crate::image::StreamKind;

/// The command that a knob is an option of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Encode,
    Decode,
    /// Encoding and decoding.
    Both,
    Place,
    Render,
    Simplify,
    Interpolate,
}

impl Stage {
    pub fn name(self) -> &'static str {
        match self {
            Stage::Encode => "encode",
            Stage::Decode => "decode",
            Stage::Both => "both",
            Stage::Place => "place",
            Stage::Render => "render",
            Stage::Simplify => "simplify",
            Stage::Interpolate => "interpolate",
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Knob {
    /// The option without its dashes.
    pub name: &'static str,
    /// The option's first name: still accepted, and the key in CSV and JSON.
    pub former: Option<&'static str>,
    pub label: &'static str,
    /// Kinds of streams that it changes; empty where points have none.
    pub streams: &'static [StreamKind],
    pub stage: Stage,
    /// Settings that it requires, added unless they are swept or fixed.
    pub implies: &'static [(&'static str, &'static str)],
    /// The value that stands for leaving the option out, if the option itself has no such value.
    pub without: Option<&'static str>,
    pub default: &'static str,
    pub usual: &'static [&'static str],
}

pub const ALL_STREAMS: &[StreamKind] = &StreamKind::ALL;

impl Knob {
    pub const fn new(
        stage: Stage,
        name: &'static str,
        label: &'static str,
        default: &'static str,
        usual: &'static [&'static str],
    ) -> Knob {
        Knob { name, former: None, label, streams: &[], stage, implies: &[], without: None, default, usual }
    }

    pub const fn of(self, streams: &'static [StreamKind]) -> Knob {
        Knob { streams, ..self }
    }

    pub const fn with(self, implies: &'static [(&'static str, &'static str)]) -> Knob {
        Knob { implies, ..self }
    }

    pub const fn formerly(self, name: &'static str) -> Knob {
        Knob { former: Some(name), ..self }
    }

    /// The key in CSV and JSON.
    pub fn key(&self) -> &'static str {
        self.former.unwrap_or(self.name)
    }

    pub fn usual_values(&self) -> Vec<String> {
        self.usual.iter().map(|value| (*value).to_owned()).collect()
    }

    /// The option with a value; none for the value that stands for leaving it out.
    pub fn option(&self, value: &str) -> Option<String> {
        (self.without != Some(value)).then(|| format!("--{}={value}", self.name))
    }

    /// Whether points of a kind of stream depend on it.
    pub fn concerns(&self, stream: Option<StreamKind>) -> bool {
        stream.is_none_or(|stream| self.streams.contains(&stream))
    }

    /// Whether all kinds of streams depend on it: such knobs join every study.
    pub fn is_general(&self) -> bool {
        self.streams == ALL_STREAMS
    }
}

/// A value as a number: `16`, `0.5`, `0.1%` (which is 0.1).
pub fn number(value: &str) -> Option<f64> {
    value.strip_suffix('%').unwrap_or(value).parse().ok().filter(|number: &f64| number.is_finite())
}
