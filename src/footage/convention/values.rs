//! Checks depth values: invalid values, an undeclared background, near and far.

use super::finding::{Finding, Verdict, listed, percent};
use crate::dataset::{DepthRules, InvalidDepth};
use codec::image::DepthPlane;

pub const NEAR_FAR: &str = "depth.near_far";
/// Minimum share of all pixels that have exactly the largest value, for it to be an undeclared background.
const BACKGROUND_SHARE: f64 = 0.002;
/// A frequent largest value is a background if all other values are below this fraction of it.
const BACKGROUND_GAP: f32 = 0.1;
/// A frequent largest value is also a background if it is one of these common background values.
const USUAL_BACKGROUNDS: [f32; 18] = [
    100.0,
    1000.0,
    10_000.0,
    1e5,
    1e6,
    1e7,
    1e8,
    1e9,
    1e10,
    1e12,
    1e20,
    1e30,
    1e38,
    MAX_F16,
    65_535.0,
    65_536.0,
    MAX_U32,
    f32::MAX,
];
const MAX_F16: f32 = 65_504.0;
const MAX_U32: f32 = u32::MAX as f32;
/// Distance in metres from which no surface is plausible.
const ABSURD_METRES: f64 = 1e7;
/// A smaller share of invalid pixels counts as isolated errors, not as a background value.
const INVALID_SHARE: f64 = 1e-4;
/// Minimum share of surfaces outside near and far that is not accidental.
const OUTSIDE_SHARE: f64 = 0.001;
/// Integer depths that reach this many metres are probably in a smaller unit.
const WHOLE_METRES: f64 = 100.0;
/// Ratios of common units.
const SCALES: [f64; 6] = [0.001, 0.01, 0.1, 10.0, 100.0, 1000.0];

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DepthValues {
    pub pixels: u64,
    /// Number of pixels with the declared background, +inf, or a value too far for a surface.
    pub background: u64,
    /// The value too far for a surface; 0 if there is none.
    pub too_far: f32,
    pub not_a_number: u64,
    pub zero: u64,
    pub negative: u64,
    /// Number of surface pixels: finite values above zero.
    pub surfaces: u64,
    /// Number of surface pixels with an integer value.
    pub whole: u64,
    /// Smallest surface value; `None` if there is no surface.
    pub min: Option<f32>,
    pub max: f32,
    /// Number of surface pixels with exactly the value `max`.
    pub at_max: u64,
    /// Largest surface value below `max`; 0 if there is none.
    pub next_max: f32,
    /// Number of surface pixels outside the stated near and far.
    pub outside: u64,
}

/// Declared properties of depth values.
#[derive(Debug, Clone, Copy)]
pub struct Stated {
    /// Rules by which files are read.
    pub rules: DepthRules,
    /// Near and far in metres; 0 and +inf if not declared.
    pub range_m: [f64; 2],
}

impl Stated {
    fn is_outside(&self, metres: f64) -> bool {
        metres < self.range_m[0] * 0.999 || metres > self.range_m[1] * 1.001
    }
}

impl DepthValues {
    pub fn count(stored: &DepthPlane, stated: &Stated) -> DepthValues {
        let mut found = DepthValues { pixels: stored.data().len() as u64, ..DepthValues::default() };
        let farthest = stated.rules.farthest(stored);
        if farthest.is_finite() {
            found.too_far = farthest;
        }
        for &value in stored.data() {
            let value = stated.rules.units(value);
            if value >= farthest {
                found.background += 1;
            } else if value.is_nan() {
                found.not_a_number += 1;
            } else if value == 0.0 {
                found.zero += 1;
            } else if value < 0.0 {
                found.negative += 1;
            } else {
                found.surfaces += 1;
                found.whole += u64::from(value.fract() == 0.0);
                found.outside += u64::from(stated.is_outside(f64::from(value) * stated.rules.scale.abs()));
                found.min = Some(found.min.map_or(value, |min| min.min(value)));
                if value > found.max {
                    (found.next_max, found.max, found.at_max) = (found.max, value, 1);
                } else if value == found.max {
                    found.at_max += 1;
                } else {
                    found.next_max = found.next_max.max(value);
                }
            }
        }
        found
    }

    pub fn add(self, other: DepthValues) -> DepthValues {
        let (high, low) = if self.max >= other.max { (self, other) } else { (other, self) };
        let equal = high.max == low.max;
        DepthValues {
            pixels: self.pixels + other.pixels,
            background: self.background + other.background,
            too_far: self.too_far.max(other.too_far),
            not_a_number: self.not_a_number + other.not_a_number,
            zero: self.zero + other.zero,
            negative: self.negative + other.negative,
            surfaces: self.surfaces + other.surfaces,
            whole: self.whole + other.whole,
            min: self.min.into_iter().chain(other.min).reduce(f32::min),
            max: high.max,
            at_max: high.at_max + if equal { low.at_max } else { 0 },
            next_max: high.next_max.max(if equal { low.next_max } else { low.max }),
            outside: self.outside + other.outside,
        }
    }
}

pub fn check(values: &DepthValues, stated: &Stated) -> Vec<Finding> {
    vec![invalid(values, stated.rules.invalid), background(values, stated), near_far(values, stated)]
}

fn share(count: u64, values: &DepthValues) -> f64 {
    count as f64 / values.pixels.max(1) as f64
}

fn invalid(values: &DepthValues, rule: InvalidDepth) -> Finding {
    let counts = [("NaN", values.not_a_number), ("zero", values.zero), ("negative", values.negative)];
    let found: Vec<String> =
        counts.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{count} {name}")).collect();
    let all = counts.iter().map(|(_, count)| count).sum();
    let what = || format!("of {} pixels of depth {}, neither a surface nor the background", values.pixels, are(&found));
    let figures = [
        ("not_a_number", values.not_a_number as f64),
        ("zero", values.zero as f64),
        ("negative", values.negative as f64),
        ("pixels", values.pixels as f64),
    ];
    let (verdict, says) = match rule {
        _ if found.is_empty() => (Verdict::Fine, "every pixel is a surface or the background".to_owned()),
        InvalidDepth::Far => (Verdict::Fine, format!("{}; `invalid_depth` = far treats them as background", what())),
        InvalidDepth::Near => {
            (Verdict::Fine, format!("{}; `invalid_depth` = near treats them as the nearest surface", what()))
        }
        InvalidDepth::Refuse if share(all, values) < INVALID_SHARE => {
            let needed = "too few to be a background value; encode needs `invalid_depth` = far or near";
            (Verdict::Fine, format!("{}, {needed}", what()))
        }
        InvalidDepth::Refuse => {
            let advice = "name the value in \"background\", or set `invalid_depth` to far or near";
            (Verdict::Suspect, format!("{}: {advice}", what()))
        }
    };
    Finding::new("depth.values", verdict, says).with(&figures)
}

/// Formats counts with a verb: `is 1 NaN`, `are 2 NaN and 70 zero`.
fn are(found: &[String]) -> String {
    let verb = if matches!(found, [only] if only.starts_with("1 ")) { "is" } else { "are" };
    format!("{verb} {}", listed(found, "and"))
}

fn background(values: &DepthValues, stated: &Stated) -> Finding {
    let at_max = share(values.at_max, values);
    let figures = [
        ("background", share(values.background, values)),
        ("at_farthest", at_max),
        ("farthest", f64::from(values.max)),
    ];
    let max = values.max;
    let of_all = format!("{} of all pixels are the background", percent(share(values.background, values)));
    let often = at_max >= BACKGROUND_SHARE && values.at_max > 16;
    let gap = values.next_max > 0.0 && values.next_max < max * BACKGROUND_GAP;
    let usual = USUAL_BACKGROUNDS.contains(&max) || f64::from(max) * stated.rules.scale.abs() == stated.range_m[1];
    let (verdict, says) = if values.surfaces == 0 {
        (Verdict::CannotTell, "there is no surface at all".to_owned())
    } else if often && max == 1.0 {
        let buffer = "that is the depth buffer of a graphics library, not a length";
        (Verdict::Suspect, format!("no value is above 1 and {} are exactly 1: {buffer}", percent(at_max)))
    } else if often && (gap || usual) && stated.rules.disparity.is_none() {
        let exactly = format!("{} of all pixels are exactly {max}", percent(at_max));
        (Verdict::Suspect, format!("{exactly}: if nothing is there, \"background\" is {max}"))
    } else if values.too_far > 0.0 {
        (Verdict::Fine, format!("{of_all}: {:e} is too far for a surface", values.too_far))
    } else {
        (Verdict::Fine, of_all)
    };
    Finding::new("depth.background", verdict, says).with(&figures)
}

fn near_far(values: &DepthValues, stated: &Stated) -> Finding {
    let [near, far] = stated.range_m;
    let Some(nearest) = values.min else {
        return Finding::new(NEAR_FAR, Verdict::CannotTell, "there is no surface at all");
    };
    let [min, max] = [nearest, values.max].map(|value| f64::from(value) * stated.rules.scale.abs());
    let outside = values.outside as f64 / values.surfaces.max(1) as f64;
    let figures = [("nearest_m", min), ("farthest_m", max), ("outside", outside)];
    let seen = format!("surfaces lie {min:.4} m to {max:.4} m away");
    let whole = values.whole == values.surfaces && values.surfaces > 100 && nearest < values.max;
    let (verdict, says) = if max >= ABSURD_METRES {
        let like = "farther than anything that is seen: if nothing is there, name that value in \"background\"";
        (Verdict::Suspect, format!("surfaces lie {min:.4} m to {max:.1e} m away, {like}"))
    } else if whole && max >= WHOLE_METRES {
        let like = "all of them whole numbers: they look like millimetres or another small unit";
        (Verdict::Suspect, format!("{seen}, {like}"))
    } else if near == 0.0 && far.is_infinite() {
        (Verdict::Fine, format!("{seen}; no near and far are stated"))
    } else if outside < OUTSIDE_SHARE {
        (Verdict::Fine, format!("{seen}, between the stated near and far"))
    } else {
        let fits = SCALES.iter().find(|scale| min * *scale >= near * 0.999 && max * *scale <= far * 1.001);
        let guess = fits.map(|scale| format!("; depth {scale} times as large would fit")).unwrap_or_default();
        let outside = percent(outside);
        (Verdict::Suspect, format!("{seen}, {outside} of them outside the stated {near} m to {far} m{guess}"))
    };
    Finding::new(NEAR_FAR, verdict, says).with(&figures)
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::Plane;

    fn stated() -> Stated {
        let rules = DepthRules::default();
        Stated { rules, range_m: [0.0, f64::INFINITY] }
    }

    fn with_rules(change: impl Fn(&mut DepthRules)) -> Stated {
        let mut stated = stated();
        change(&mut stated.rules);
        stated
    }

    fn plane(value: impl Fn(u32) -> f32) -> DepthPlane {
        Plane::from_fn(64, 64, |x, y| value(y * 64 + x))
    }

    fn verdicts(plane: &DepthPlane, stated: &Stated) -> [Verdict; 3] {
        let found = check(&DepthValues::count(plane, stated), stated);
        [0, 1, 2].map(|at| found[at].verdict)
    }

    #[test]
    fn sums_are_what_one_count_says() {
        let whole = plane(|at| if at % 7 == 0 { 90.0 } else { at as f32 + 0.5 }.min(90.0));
        let split = |keep: bool| Plane::from_fn(64, 32, |x, y| whole.get(x, y + if keep { 0 } else { 32 }));
        let counts = [split(true), split(false)].map(|half| DepthValues::count(&half, &stated()));
        assert_eq!(counts[0].add(counts[1]), DepthValues::count(&whole, &stated()));
        assert_eq!(counts[1].add(counts[0]), DepthValues::count(&whole, &stated()));
    }

    #[test]
    fn values_that_are_no_depth_are_counted() {
        let fine = plane(|at| 1.25 + at as f32 * 0.001);
        assert_eq!(verdicts(&fine, &stated()), [Verdict::Fine; 3]);
        for odd in [f32::NAN, 0.0, -3.0] {
            let bad = plane(|at| if at == 70 { odd } else { 1.25 + at as f32 * 0.001 });
            assert_eq!(verdicts(&bad, &stated())[0], Verdict::Suspect, "{odd}");
            for invalid in [InvalidDepth::Far, InvalidDepth::Near] {
                assert_eq!(verdicts(&bad, &with_rules(|rules| rules.invalid = invalid))[0], Verdict::Fine, "{odd}");
            }
        }
        let declared = with_rules(|rules| rules.background = 0.0);
        assert_eq!(verdicts(&plane(|at| at as f32 * 0.01), &declared)[0], Verdict::Fine);
    }

    #[test]
    fn a_single_flaw_is_a_figure() {
        let found = |flaws: u64| {
            let values = DepthValues { pixels: 1_000_000, not_a_number: flaws, ..DepthValues::default() };
            check(&values, &stated()).swap_remove(0)
        };
        let one = found(1);
        assert_eq!(one.verdict, Verdict::Fine);
        assert!(one.says.starts_with("of 1000000 pixels of depth is 1 NaN,"), "{}", one.says);
        assert!(one.figures.contains(&("not_a_number", 1.0)), "{:?}", one.figures);
        assert_eq!(found(99).verdict, Verdict::Fine);
        assert_eq!(found(100).verdict, Verdict::Suspect);
    }

    #[test]
    fn backgrounds_that_nobody_declared() {
        for far in [1e9, 65_504.0, 1000.0, 500.0] {
            let bad = plane(|at| if at < 400 { far } else { 1.25 + at as f32 * 0.001 });
            assert_eq!(verdicts(&bad, &stated())[1], Verdict::Suspect, "{far}");
            let declared = with_rules(|rules| rules.background = far);
            assert_eq!(verdicts(&bad, &declared)[1], Verdict::Fine, "{far}");
        }
        // A value that is read as background is not counted as a surface.
        for far in [1e10, 1e30, f32::MAX] {
            let sky = plane(|at| if at < 400 { far } else { 1.25 + at as f32 * 0.001 });
            let found = check(&DepthValues::count(&sky, &stated()), &stated());
            assert!(found.iter().all(|finding| finding.verdict == Verdict::Fine), "{far}: {found:?}");
            assert!(found[1].says.ends_with(&format!(": {far:e} is too far for a surface")), "{}", found[1].says);
            let behind = with_rules(|rules| rules.scale = -1.0);
            assert_eq!(verdicts(&sky.map(|value| -value), &behind), [Verdict::Fine; 3], "{far}");
        }
        // A wall perpendicular to the view, the farthest surface, is not a background.
        let wall = plane(|at| (1.25 + at as f32 * 0.01).min(7.5));
        assert_eq!(verdicts(&wall, &stated())[1], Verdict::Fine);
        let buffer = plane(|at| (0.9 + at as f32 * 0.0001).min(1.0));
        assert_eq!(verdicts(&buffer, &stated())[1], Verdict::Suspect);
        assert_eq!(verdicts(&plane(|_| f32::INFINITY), &stated())[1], Verdict::CannotTell);
    }

    #[test]
    fn near_far_and_units() {
        let metres = plane(|at| 1.25 + at as f32 * 0.001);
        let stated = Stated { range_m: [1.0, 10.0], ..stated() };
        assert_eq!(verdicts(&metres, &stated)[2], Verdict::Fine);
        let millimetres = metres.map(|value| value * 1000.0);
        let found = check(&DepthValues::count(&millimetres, &stated), &stated).pop().unwrap();
        assert!(found.says.contains("0.001 times"), "{}", found.says);
        let sky = plane(|at| if at == 9 { 3e8 } else { 1.25 + at as f32 * 0.001 });
        let found = check(&DepthValues::count(&sky, &stated), &stated).pop().unwrap();
        assert!(found.verdict == Verdict::Suspect && found.says.contains("3.0e8 m"), "{}", found.says);
        let whole = plane(|at| 400.0 + (at / 2) as f32);
        let found = verdicts(&whole, &Stated { range_m: [0.0, f64::INFINITY], ..stated });
        assert_eq!(found[2], Verdict::Suspect);
        let scaled = Stated { range_m: stated.range_m, ..with_rules(|rules| rules.scale = 0.001) };
        assert_eq!(verdicts(&whole.map(|v| v + 600.0), &scaled)[2], Verdict::Fine);
    }
}
