//! Hard cases of footage with few codes, which predictive depth codes as levels (depth.md 15.2). Decoding must be
//! lossless.

use crate::case::{Bound, Family, Group, HardCase, Measured};
use crate::clip::{Clip, Sequence, noise};
use crate::paths::paths;
use codec::depth::BACKGROUND_CODE;
use codec::depth::mode_decision::Decide;
use codec::depth::predictive::levels;
use codec::depth::quantise::FAR_CODE;
use codec::error::Result;

/// Width and height: not multiples of 4, and at least as many pixels as the maximum number of levels.
const SIZE: [u32; 2] = [83, 50];
const FRAMES: u32 = 5;
/// Maximum number of levels of a stream, as codes count.
const MAX_LEVELS: u32 = levels::MAX_LEVELS as u32;

struct Footage {
    name: &'static str,
    /// Number of levels, and the code of each.
    count: u32,
    code: fn(number: u32) -> u32,
    /// Index of the level that a pixel shows. `None` for background.
    number: fn(count: u32, place: [u32; 3]) -> Option<u32>,
}

/// A random level that changes every frame; one pixel in seven is background.
fn changing_noise(count: u32, place: [u32; 3]) -> Option<u32> {
    (noise(place, 7) > 0).then(|| noise([place[0] + 100, place[1], place[2]], count))
}

/// All levels in pixel order; every other frame in reverse order.
fn in_order(count: u32, [frame, x, y]: [u32; 3]) -> Option<u32> {
    let number = (x + SIZE[0] * y) % count;
    Some(if frame % 2 == 0 { number } else { count - 1 - number })
}

/// A slope of levels with sensor-like noise of one level up or down, and a moving hole.
fn slope(count: u32, place @ [frame, x, y]: [u32; 3]) -> Option<u32> {
    let is_hole = (x + frame) % 29 < 3 && y % 17 < 9;
    (!is_hole).then(|| ((x + 2 * y) / 5 + noise(place, 3)).min(count - 1))
}

static FOOTAGE: [Footage; 12] = [
    Footage { name: "one level, without background", count: 1, code: |_| 31_000, number: |_, _| Some(0) },
    Footage { name: "one level, in noise of background", count: 1, code: |_| 31_000, number: changing_noise },
    Footage { name: "one level, the first code", count: 1, code: |_| 0, number: changing_noise },
    Footage { name: "one level, the last code", count: 1, code: |_| FAR_CODE.into(), number: changing_noise },
    Footage { name: "two levels, codes 0 and 65534", count: 2, code: |at| at * 65_534, number: changing_noise },
    Footage {
        name: "two levels, each frame all of one",
        count: 2,
        code: |at| at * 65_534,
        number: |_, at| Some(at[0] % 2),
    },
    Footage { name: "4096 levels from code 0", count: MAX_LEVELS, code: |at| at, number: in_order },
    Footage {
        name: "4096 levels up to code 65534",
        count: MAX_LEVELS,
        code: |at| 65_534 - MAX_LEVELS + 1 + at,
        number: in_order,
    },
    Footage {
        name: "4096 levels, sixteen codes apart, in noise",
        count: MAX_LEVELS,
        code: |at| 16 * at,
        number: changing_noise,
    },
    Footage { name: "adjacent codes in noise", count: 9, code: |at| 20_000 + at, number: changing_noise },
    Footage { name: "codes far apart in noise", count: 60, code: |at| 17 * at * at + 7, number: changing_noise },
    Footage { name: "a slope of a sensor", count: 45, code: |at| 4000 + at * (900 + 7 * at), number: slope },
];

impl Footage {
    fn codes(&self) -> Vec<u16> {
        (0..self.count).map(|number| (self.code)(number) as u16).collect()
    }

    fn source(&self) -> Sequence<u16> {
        let codes = self.codes();
        Sequence::new(SIZE, FRAMES, |frame, x, y| {
            (self.number)(self.count, [frame, x, y]).map_or(BACKGROUND_CODE, |number| codes[number as usize])
        })
    }

    fn largest_error(&self) -> Result<Measured> {
        let source = self.source();
        let of = |decide| source.compare(Clip::levels(&source, self.codes(), decide)?);
        Ok(of(Decide::Mse)?.join(of(Decide::Size)?))
    }
}

pub(super) fn cases() -> Vec<HardCase> {
    let exact = Group::new(Family::Temporal, "DPRD by level", "codes");
    let any_path = Group::new(Family::Temporal, "DPRD by level, every legal path", "pictures that differ");
    let mut cases = Vec::new();
    for footage in &FOOTAGE {
        cases.push(exact.case(footage.name, Bound::AtMost(0.0), move || footage.largest_error()));
        let run = move || paths(&Clip::levels(&footage.source(), footage.codes(), Decide::Mse)?);
        cases.push(any_path.none(footage.name, run));
    }
    cases
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn footage_shows_its_levels_and_nothing_else() {
        for footage in &FOOTAGE {
            let shown: BTreeSet<u16> = footage.source().frames.into_iter().flatten().collect();
            let levels: BTreeSet<u16> = footage.codes().into_iter().collect();
            assert_eq!(levels.len(), footage.count as usize, "{}", footage.name);
            assert!(!levels.contains(&BACKGROUND_CODE), "{}", footage.name);
            let surfaces: BTreeSet<u16> = shown.into_iter().filter(|&code| code != BACKGROUND_CODE).collect();
            assert!(surfaces.is_subset(&levels), "{}", footage.name);
            assert!(2 * surfaces.len() > levels.len(), "{}: {} levels shown", footage.name, surfaces.len());
        }
    }
}
