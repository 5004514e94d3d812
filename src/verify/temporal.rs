//! Hard cases of temporal coding (CALF 5.2; depth.md 4 and 12), with every codec that has frames.
//!
//! Each must satisfy two properties: every frame is within the bound of its source, and every legal path decodes the
//! same frames.

use crate::case::{Bound, Family, Group, HardCase, Measured};
use crate::clip::{Clip, EFFORT, Sequence, any_range, noise};
use crate::paths::paths;
use codec::depth::block_tiles::Layout;
use codec::depth::domain::{Domain, DomainKind};
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::NodeSettings;
use codec::depth::predictive::projection::Shape;
use codec::depth::{BACKGROUND_CODE, TemporalSettings};
use codec::error::Result;

/// Width and height: not multiples of 4, 8 or 16.
const SIZE: [u32; 2] = [21, 18];
const LONG: u32 = 2000;

struct Scenario {
    name: &'static str,
    frames: u32,
    settings: TemporalSettings,
    pixel: fn(frame: u32, x: u32, y: u32) -> u16,
}

fn slope(x: u32, y: u32) -> u16 {
    (20_000 + 5 * x + 2 * y) as u16
}

/// True for the pixel that moves.
fn one(x: u32, y: u32) -> bool {
    (x, y) == (9, 14)
}

const fn settings(epsilon: u16, window: u8, max_aabbs: u16, keyframe_interval: u32) -> TemporalSettings {
    TemporalSettings { window, epsilon, max_aabbs, keyframe_interval }
}

const fn scenario(
    name: &'static str,
    frames: u32,
    settings: TemporalSettings,
    pixel: fn(u32, u32, u32) -> u16,
) -> Scenario {
    Scenario { name, frames, settings, pixel }
}

/// Keyframe interval that puts all frames into one chunk.
const ALL: u32 = 100_000;

static SCENARIOS: [Scenario; 14] = [
    scenario("creep of one code a frame", LONG, settings(10, 2, 8, ALL), |frame, x, y| {
        if one(x, y) { 1000 + frame as u16 } else { slope(x, y) }
    }),
    scenario("creep up and down by one code", 600, settings(1, 3, 8, ALL), |frame, x, y| {
        if one(x, y) { 1000 + (frame % 2) as u16 } else { slope(x, y) }
    }),
    scenario("creep two up, one down", 600, settings(7, 3, 8, ALL), |frame, x, y| {
        let codes = frame / 3 + [0, 2, 1][frame as usize % 3];
        if one(x, y) { 1000 + codes as u16 } else { slope(x, y) }
    }),
    scenario("all pixels creep at paces of their own", 500, settings(20, 2, 8, 128), |frame, x, y| {
        slope(x, y) + (frame * (1 + (x + y) % 4) / 2) as u16
    }),
    scenario("creep across the last surface code", 120, settings(10, 2, 8, ALL), |frame, x, y| {
        if one(x, y) { (65_500 + frame).min(65_535) as u16 } else { slope(x, y) }
    }),
    scenario("flicker of one pixel, near and background", 200, settings(10, 2, 8, 64), |frame, x, y| {
        if one(x, y) { if frame % 2 == 0 { 0 } else { BACKGROUND_CODE } } else { slope(x, y) }
    }),
    scenario("flicker between the last surface and background", 60, settings(100, 3, 8, 64), |frame, x, y| {
        if one(x, y) { 65_534 + (frame % 2) as u16 } else { slope(x, y) }
    }),
    scenario("a cut in every frame", 40, settings(10, 2, 8, 64), |frame, x, y| {
        let level = noise([frame, 99, 99], 50_000) + noise([frame, x / 5, y / 5], 9000);
        if noise([frame, x, y], 9) == 0 { BACKGROUND_CODE } else { (level + 7 * x) as u16 }
    }),
    scenario("noise of all codes in every frame", 12, settings(0, 2, 8, 64), |frame, x, y| {
        noise([frame, x, y], 65_536) as u16
    }),
    scenario("a window longer than the sequence", 7, settings(3, 255, 8, 64), |frame, x, y| {
        slope(x, y) + if x == 2 * frame { 900 } else { 0 }
    }),
    scenario("a window longer than the chunks", 30, settings(0, 16, 8, 5), |frame, x, y| {
        slope(x, y) + if noise([frame, x, y], 20) == 0 { 3000 } else { 0 }
    }),
    scenario("a budget of one box, changes in all corners", 30, settings(0, 3, 1, ALL), |frame, x, y| {
        let corner = (x == 0 || x == SIZE[0] - 1) && (y == 0 || y == SIZE[1] - 1);
        if corner { (frame * 997) as u16 } else { slope(x, y) }
    }),
    scenario("everything changes but one pixel", 30, settings(5, 2, 8, ALL), |frame, x, y| {
        if one(x, y) { 30_000 } else { slope(x, y) + (frame * 331) as u16 }
    }),
    scenario("every frame a keyframe", 10, settings(10, 2, 8, 1), |frame, x, y| slope(x, y) + (frame * x) as u16),
];

impl Scenario {
    fn codes(&self) -> Sequence<u16> {
        Sequence::new(SIZE, self.frames, self.pixel)
    }

    /// Uses both bytes of the code: the high byte jumps, the low byte wraps.
    fn material(&self) -> Sequence<[u8; 3]> {
        Sequence::new(SIZE, self.frames, |frame, x, y| {
            let [low, high] = (self.pixel)(frame, x, y).to_le_bytes();
            [high, low, (low >> 1) ^ high]
        })
    }
}

#[derive(Clone, Copy)]
enum Codec {
    Boxes(Layout),
    /// Error bound of a node, and domain.
    Nodes(u16, DomainKind),
    Tree,
    Blocks,
    /// Error bound.
    Predictive(u16),
    Material(Layout),
}

const CODECS: [Codec; 11] = [
    Codec::Boxes(Layout::Values),
    Codec::Boxes(Layout::BlockTiles),
    Codec::Nodes(0, DomainKind::Log),
    Codec::Nodes(100, DomainKind::Log),
    Codec::Nodes(10, DomainKind::Inverse),
    Codec::Tree,
    Codec::Blocks,
    Codec::Predictive(0),
    Codec::Predictive(100),
    Codec::Material(Layout::Values),
    Codec::Material(Layout::BlockTiles),
];

impl Codec {
    fn name(self) -> String {
        match self {
            Codec::Boxes(Layout::Values) => "DAAB".into(),
            Codec::Boxes(Layout::BlockTiles) => "DAB5".into(),
            Codec::Nodes(bound, domain) => format!("DQPN, E = {bound}, {}", domain.name()),
            Codec::Tree => "DQTR".into(),
            Codec::Blocks => "DB4W".into(),
            Codec::Predictive(bound) => format!("DPRD, E = {bound}"),
            Codec::Material(Layout::Values) => "MAAB".into(),
            Codec::Material(Layout::BlockTiles) => "MAB1".into(),
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Codec::Material(_) => "of 255",
            // Plain blocks have no error bound for surfaces, but must keep the background exact.
            Codec::Blocks => "background mixed up",
            _ => "codes",
        }
    }

    /// Error bound according to formats/depth.md.
    fn bound(self, settings: TemporalSettings) -> f64 {
        match self {
            Codec::Boxes(_) => f64::from(settings.epsilon),
            Codec::Nodes(bound, _) | Codec::Predictive(bound) => f64::from(bound) + f64::from(settings.epsilon),
            Codec::Tree | Codec::Blocks => 0.0,
            Codec::Material(_) => f64::from(settings.epsilon.min(8)),
        }
    }

    fn clip(self, scenario: &Scenario) -> Result<Clip> {
        let settings @ TemporalSettings { window, epsilon, keyframe_interval, .. } = scenario.settings;
        let nodes = |bound| NodeSettings {
            window,
            epsilon,
            keyframe_interval,
            bound,
            effort: EFFORT,
            ..NodeSettings::default()
        };
        match self {
            Codec::Boxes(storage) => Clip::codes(&scenario.codes(), settings, storage),
            Codec::Nodes(bound, kind) => {
                let range = any_range()?;
                Clip::nodes(&scenario.codes(), (range, &Domain::new(kind, range)?), nodes(bound))
            }
            Codec::Tree => Clip::tree(&scenario.codes(), nodes(0)),
            Codec::Blocks => Clip::blocks(&scenario.codes(), EFFORT, keyframe_interval),
            Codec::Predictive(bound) => {
                let numbers = (bound, epsilon, keyframe_interval);
                Clip::predictive(&scenario.codes(), numbers, Shape::Planar, Decide::Mse)
            }
            Codec::Material(storage) => {
                let settings = TemporalSettings { epsilon: epsilon.min(8), ..settings };
                Clip::material(&scenario.material(), settings, storage)
            }
        }
    }

    fn largest_error(self, scenario: &Scenario) -> Result<Measured> {
        let clip = self.clip(scenario)?;
        if let Codec::Material(_) = self {
            return scenario.material().compare(clip);
        }
        let mut measured = scenario.codes().compare(clip)?;
        if let Codec::Blocks = self {
            measured.figure = f64::from(u8::from(measured.figure.is_infinite()));
        }
        Ok(measured)
    }
}

pub(super) fn cases() -> Vec<HardCase> {
    let mut cases = Vec::new();
    for codec in CODECS {
        let errors = Group::new(Family::Temporal, codec.name(), codec.unit());
        let any_path =
            Group::new(Family::Temporal, format!("{}, every legal path", codec.name()), "pictures that differ");
        for scenario in &SCENARIOS {
            let bound = Bound::AtMost(codec.bound(scenario.settings));
            cases.push(errors.case(scenario.name, bound, move || codec.largest_error(scenario)));
            cases.push(any_path.none(scenario.name, move || paths(&codec.clip(scenario)?)));
        }
    }
    cases
}
