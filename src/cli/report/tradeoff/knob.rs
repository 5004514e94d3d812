//! Knobs: options that trade quality, bytes or time, under their command-line names.

use codec::image::StreamKind;

/// Command that a knob is an option of.
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
    /// Option name without dashes.
    pub name: &'static str,
    /// Former name of the option: still accepted, and the key in CSV and JSON.
    pub former: Option<&'static str>,
    pub label: &'static str,
    /// Kinds of streams that it affects. Empty in sweeps whose points have no stream.
    pub streams: &'static [StreamKind],
    pub stage: Stage,
    /// Settings that it requires. They are added unless they are swept or fixed.
    pub implies: &'static [(&'static str, &'static str)],
    /// Value that stands for omitting the option, if the option itself has no such value.
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

    /// Returns the key in CSV and JSON.
    pub fn key(&self) -> &'static str {
        self.former.unwrap_or(self.name)
    }

    pub fn usual_values(&self) -> Vec<String> {
        self.usual.iter().map(|value| (*value).to_owned()).collect()
    }

    /// Returns the option with a value. `None` for the value that stands for omitting the option.
    pub fn option(&self, value: &str) -> Option<String> {
        (self.without != Some(value)).then(|| format!("--{}={value}", self.name))
    }

    /// True if points of a kind of stream depend on the knob.
    pub fn concerns(&self, stream: Option<StreamKind>) -> bool {
        stream.is_none_or(|stream| self.streams.contains(&stream))
    }

    /// True if all kinds of streams depend on the knob. Such knobs join every study.
    pub fn is_general(&self) -> bool {
        self.streams == ALL_STREAMS
    }
}

/// Parses a value as a number: `16`, `0.5`, `0.1%` (which is 0.1).
pub fn number(value: &str) -> Option<f64> {
    value.strip_suffix('%').unwrap_or(value).parse().ok().filter(|number: &f64| number.is_finite())
}
