//! Quantisation of metres to codes and back (depth.md 2), and the decoders' logarithm (arithmetic.md 7), compared with
//! a reference in binary64.
//!
//! The reference is independent of the code under test: it computes its logarithm with its own series.

use rayon::prelude::*;

use crate::case::{Bound, Family, Group, HardCase, Measured};
use crate::clip::{Clip, EFFORT, Sequence};
use codec::decode::Picture;
use codec::depth::domain::{Domain, DomainKind, integer_log2};
use codec::depth::node_encoder::NodeSettings;
use codec::depth::quantise::FAR_CODE;
use codec::depth::{BACKGROUND_CODE, DepthRange, Quantiser};
use codec::error::{Error, Result};

/// Name, near and far in metres.
const RANGES: [(&str, f32, f32); 14] = [
    ("near = far", 3.0, 3.0),
    ("far = near + 1 ulp", 1.0, 1.000_000_1),
    ("far / near = 1 + 1e-6", 1.0, 1.000_001),
    ("far / near = 1 + 1e-5", 700.0, 700.007),
    ("far / near = 1.0035", 2.0, 2.007),
    ("0.5 m to 37.25 m", 0.5, 37.25),
    ("1 mm to 1 km", 0.001, 1000.0),
    ("far / near = 1e12", 1e-6, 1e6),
    ("denormal metres", 1e-45, 1e-40),
    ("denormal to normal", 1e-40, 1e-36),
    ("smallest normal to 1 m", f32::MIN_POSITIVE, 1.0),
    ("least float to greatest", 1e-45, f32::MAX),
    ("1e30 m to the greatest float", 1e30, f32::MAX),
    ("greatest float alone", f32::MAX, f32::MAX),
];

/// A probe of 2 m to 20 m with one outlier pixel that is nearer or farther.
const STRAYS: [(&str, f32, f32); 8] = [
    ("a stray at the least float", 1e-45, 20.0),
    ("a stray at 1e-40 m", 1e-40, 20.0),
    ("a stray at the smallest normal", f32::MIN_POSITIVE, 20.0),
    ("a stray at 1e-6 m", 1e-6, 20.0),
    ("a stray at 1 cm", 0.01, 20.0),
    ("a stray at 9e9 m", 2.0, 9e9),
    ("a stray at the greatest float", 2.0, f32::MAX),
    ("strays at both ends", 1e-40, 1e30),
];
/// Error bounds in codes.
const BOUNDS: [u16; 5] = [0, 1, 100, 1000, 20_000];

/// Error in codes of two binary64 logarithms, each off by at most four ulps: 65534 · 8 · 2^-52.
const LOG_ROUNDING: f64 = 65534.0 * 8.0 * f64::EPSILON;
/// Relative rounding error of binary32: 2^-24.
const FLOAT_ROUNDING: f64 = 1.0 / 16_777_216.0;
/// Relative rounding error of near · exp(log) in binary64: an argument of up to 180, off by four ulps, and two
/// operations.
const EXP_ROUNDING: f64 = (180.0 * 4.0 + 4.0) * f64::EPSILON;
const DOMAIN_RATIOS: [f32; 6] = [1.0035, 1.5, 74.5, 4000.0, 1e6, 1e12];

/// Computes ln(z / near) for 0 < near <= z as 2 artanh((z − near) / (z + near)), after extracting factors of two.
/// Floats are exact in binary64, and so is their difference if they are close.
fn log_ratio(z: f32, near: f32) -> f64 {
    let (z, near) = (f64::from(z), f64::from(near));
    let doublings = (z / near).log2().floor().max(0.0);
    let scaled = near * doublings.exp2();
    let t = (z - scaled) / (z + scaled);
    let square = t * t;
    // t| is at most 1/3: each term is 9 times smaller than the one before, and the thirtieth is below 1e-29 of the first.
    let series = (0..30).rev().fold(0.0, |sum, k| sum * square + 1.0 / f64::from(2 * k + 1));
    doublings * std::f64::consts::LN_2 + 2.0 * t * series
}

#[derive(Clone, Copy)]
struct Reference {
    range: DepthRange,
    span: f64,
}

impl Reference {
    fn new(near: f32, far: f32) -> Result<Reference> {
        Ok(Reference { range: DepthRange::new(near, far)?, span: log_ratio(far, near) })
    }

    fn code(self, z: f32) -> f64 {
        if self.span == 0.0 { 0.0 } else { log_ratio(z, self.range.near_m()) / self.span * f64::from(FAR_CODE) }
    }

    fn half_step(self) -> f64 {
        self.span * (0.5 + LOG_ROUNDING) / f64::from(FAR_CODE)
    }

    /// Returns the floats within 3 ulps of every boundary between codes, ascending, and both ends of the range.
    fn around_boundaries(self) -> Vec<f32> {
        let (near, far) = (self.range.near_m().to_bits(), self.range.far_m().to_bits());
        let mut bits = vec![near, far];
        for code in 1..=FAR_CODE {
            let log = self.span * (f64::from(code) - 0.5) / f64::from(FAR_CODE);
            let middle =
                ((f64::from(self.range.near_m()) * log.exp()) as f32).clamp(self.range.near_m(), self.range.far_m());
            bits.extend((0..=6).map(|step| (middle.to_bits() + step).saturating_sub(3).clamp(near, far)));
        }
        bits.sort_unstable();
        bits.dedup();
        bits.into_iter().map(f32::from_bits).collect()
    }
}

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Quantisation, pipeline, unit);
    let mut cases = Vec::new();
    let codes = group("metres to code, at every boundary ± 3 ulp", "codes");
    let forms = group("table against formula, at every boundary ± 3 ulp", "codes that differ");
    let order = group("order of metres and of codes", "descents");
    let ends = group("ends, background and what is no depth", "wrong answers");
    for (name, near, far) in RANGES {
        // Rounding to a code is at most half a code. With a single code nothing is rounded.
        let half = if near == far { 0.0 } else { 0.5 + LOG_ROUNDING };
        cases.push(codes.case(name, Bound::AtMost(half), move || code_error(Reference::new(near, far)?)));
        cases.push(forms.none(name, move || forms_differ(Reference::new(near, far)?)));
        cases.push(order.none(name, move || descents(Reference::new(near, far)?)));
        cases.push(ends.none(name, move || wrong_ends(Reference::new(near, far)?)));
        cases.push(round_trip(name, near, far));
    }
    let stated = group("metres off by codes, against the stated percent", "of the stated error");
    for (name, near, far) in RANGES.into_iter().chain(STRAYS) {
        cases.push(stated.case(name, Bound::AtMost(1.0), move || stated_error(Reference::new(near, far)?)));
    }
    let refused = group("ranges that are none", "accepted");
    cases.push(refused.none("zero, negative, swapped, infinite, NaN", ranges_accepted));
    // The chord of log2(1 + x) over 1/256 is off by at most h²/8 · log2(e); table and interpolation each round by half
    // a unit of 2^-24.
    let chord = std::f64::consts::LOG2_E / (8.0 * 65536.0) + FLOAT_ROUNDING;
    // For numbers of more than 24 bits the format keeps the leading bit and the 23 bits after it, and truncates the
    // rest.
    let cut = std::f64::consts::LOG2_E * 2.0 * FLOAT_ROUNDING;
    let log2 = group("integer log2 against binary64", "log2");
    cases.push(log2.case("all Q8 values, 1 to 2^24 - 1", Bound::AtMost(chord), || Ok(log2_error((1 << 24) - 1, 1))));
    cases.push(log2.case("up to 2^32 - 1", Bound::AtMost(chord + cut), || Ok(log2_error(u32::MAX, 4093))));
    let domain = group("value of a function to code, against binary64", "of what Q8 allows");
    let nodes = group("metres through DQPN, E = 100", "of the promise");
    for kind in [DomainKind::Linear, DomainKind::Inverse] {
        for ratio in DOMAIN_RATIOS {
            let name = format!("{}, far / near = {ratio}", kind.name());
            cases.push(domain.case(name, Bound::AtMost(1.0), move || domain_error(kind, ratio)));
        }
    }
    for kind in DomainKind::ALL {
        for (name, near, far) in RANGES.into_iter().filter(|&(_, near, far)| far / near > 1.0034) {
            let name = format!("{}, {name}", kind.name());
            cases.push(
                nodes.case(name, Bound::AtMost(1.0), move || metres_through_nodes(kind, Reference::new(near, far)?)),
            );
        }
    }
    cases
}

fn code_error(reference: Reference) -> Result<Measured> {
    let quantiser = Quantiser::new(reference.range);
    let mut worst = Measured::nothing();
    for z in reference.around_boundaries() {
        let code = quantiser.code(z).map_or(f64::NAN, f64::from);
        worst.greatest((code - reference.code(z)).abs(), || format!("{z:e} m became code {code}"));
    }
    Ok(worst)
}

/// Returns the largest relative error of floats whose codes are off by a full bound, as a fraction of the stated error.
/// NaN if the stated error does not convert back to at least that many codes, or to codes that exceed it.
fn stated_error(reference: Reference) -> Result<Measured> {
    let range = reference.range;
    let quantiser = Quantiser::new(range);
    let mut worst = Measured::nothing();
    for bound in BOUNDS {
        let stated = range.relative_error(bound);
        // Allows for rounding in the last digits of the binary64 statement and of the code looked up in a table.
        let allowed = stated * (1.0 + 1e-9) + 65534.0 * f64::EPSILON;
        for z in reference.around_boundaries() {
            let Some(code) = quantiser.code(z) else { return Err(Error::invalid("a depth without a code")) };
            for shown in [code.saturating_sub(bound), (code + bound.min(FAR_CODE - code)).min(FAR_CODE)] {
                let error = (f64::from(range.metres(shown)) - f64::from(z)).abs() / f64::from(z);
                let part = if allowed > 0.0 { error / allowed } else { error };
                worst.greatest(part, || format!("{z:e} m, {bound} codes off"));
            }
        }
        let codes = range.codes_within(stated);
        if codes.is_none_or(|codes| codes < bound && reference.span > 0.0 || range.relative_error(codes) > stated) {
            worst.greatest(f64::NAN, || format!("{stated} became {codes:?} codes, not {bound}"));
        }
    }
    Ok(worst)
}

fn forms_differ(reference: Reference) -> Result<Measured> {
    let (range, quantiser) = (reference.range, Quantiser::new(reference.range));
    let mut wrong = Measured::count(0);
    let (low, high) = (range.near_m().to_bits(), range.far_m().to_bits());
    let stride = ((high - low) / 200_000).max(1) as usize;
    let between = (low..=high).step_by(stride).map(f32::from_bits);
    for z in reference.around_boundaries().into_iter().chain(between) {
        wrong.count_if(quantiser.code(z) != Some(range.code(z)), || format!("{z:e} m"));
    }
    Ok(wrong)
}

fn descents(reference: Reference) -> Result<Measured> {
    let (range, quantiser) = (reference.range, Quantiser::new(reference.range));
    let mut wrong = Measured::count(0);
    let mut last = Some(0);
    for z in reference.around_boundaries() {
        let code = quantiser.code(z);
        wrong.count_if(code.is_none() || code < last, || format!("code {code:?} at {z:e} m after {last:?}"));
        last = code;
    }
    for code in 1..=FAR_CODE {
        wrong.count_if(range.metres(code) < range.metres(code - 1), || format!("metres of code {code}"));
    }
    Ok(wrong)
}

fn wrong_ends(reference: Reference) -> Result<Measured> {
    let (range, quantiser) = (reference.range, Quantiser::new(reference.range));
    let far_code = if range.near_m() == range.far_m() { 0 } else { FAR_CODE };
    let next = |z: f32| f32::from_bits(z.to_bits() + 1);
    let before = |z: f32| f32::from_bits(z.to_bits() - 1);
    // Values outside the range are rejected, not clamped.
    let below = before(range.near_m());
    let asked = [
        (range.near_m(), Some(0)),
        (range.far_m(), Some(far_code)),
        (f32::INFINITY, Some(BACKGROUND_CODE)),
        (0.0, Some(0)),
        (below, if below == 0.0 { Some(0) } else { None }),
        (next(range.far_m()), if range.far_m() == f32::MAX { Some(BACKGROUND_CODE) } else { None }),
        (f32::NAN, None),
        (f32::NEG_INFINITY, None),
        (-range.near_m(), None),
    ];
    let mut wrong = Measured::count(0);
    for (z, code) in asked {
        wrong.count_if(quantiser.code(z) != code, || format!("code of {z:e} m"));
    }
    for (code, z) in [(0, range.near_m()), (FAR_CODE, range.far_m()), (BACKGROUND_CODE, f32::INFINITY)] {
        wrong.count_if(range.metres(code) != z, || format!("metres of {code}"));
    }
    Ok(wrong)
}

/// Returns a case for the error of metres converted to a code and back: relative to the distance where floats have
/// constant relative precision, else as a fraction of the allowed error.
fn round_trip(name: &str, near: f32, far: f32) -> HardCase {
    let pipeline = "metres to code to metres";
    if near < f32::MIN_POSITIVE {
        let group = Group::new(Family::Quantisation, pipeline, "of half a step and half an ulp");
        return group.case(name, Bound::AtMost(1.0), move || {
            let reference = Reference::new(near, far)?;
            let half = reference.half_step().exp_m1() + EXP_ROUNDING;
            // Floats below 2^-126 have constant spacing.
            let ulp = |z: f64| (z * 2.0 * FLOAT_ROUNDING).max(f64::from(f32::from_bits(1)));
            let allowed = |z: f64| z * half + ulp(z * (1.0 + half)) / 2.0;
            back_and_forth(reference, |z, error| error / allowed(z))
        });
    }
    let group = Group::new(Family::Quantisation, pipeline, "of the distance");
    let span = log_ratio(far, near);
    let half = (span * (0.5 + LOG_ROUNDING) / f64::from(FAR_CODE)).exp_m1() + EXP_ROUNDING;
    // With a single code for all surfaces, metres are restored exactly.
    let bound = if near == far { 0.0 } else { half + FLOAT_ROUNDING * (1.0 + half) };
    group.case(name, Bound::AtMost(bound), move || back_and_forth(Reference::new(near, far)?, |z, error| error / z))
}

fn back_and_forth(reference: Reference, figure: impl Fn(f64, f64) -> f64) -> Result<Measured> {
    let quantiser = Quantiser::new(reference.range);
    let mut worst = Measured::nothing();
    for z in reference.around_boundaries() {
        let back = quantiser.code(z).map_or(f64::NAN, |code| f64::from(reference.range.metres(code)));
        let source = f64::from(z);
        worst.greatest(figure(source, (back - source).abs()), || format!("{z:e} m became {back:e} m"));
    }
    Ok(worst)
}

fn ranges_accepted() -> Result<Measured> {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let nears = [0.0, -0.0, -1.0, 2.0, 1.0, inf, nan, 1.0, nan, 0.0];
    let fars = [1.0, 1.0, 1.0, 1.0, inf, inf, 1.0, nan, nan, 0.0];
    let accepted = nears.into_iter().zip(fars).filter(|&(near, far)| DepthRange::new(near, far).is_ok());
    // A range too narrow for the integer logarithm supports only the log domain.
    let kinds = [DomainKind::Linear, DomainKind::Inverse].into_iter();
    let short =
        kinds.filter(|&kind| DepthRange::new(1.0, 1.000_001).and_then(|range| Domain::new(kind, range)).is_ok());
    Ok(Measured::count((accepted.count() + short.count()) as u64))
}

fn log2_error(last: u32, stride: usize) -> Measured {
    const PART: u32 = 1 << 20;
    let of_part = |part: u32| {
        let (first, end) = ((part * PART).max(1), part.saturating_mul(PART).saturating_add(PART - 1).min(last));
        let mut worst = Measured::nothing();
        for value in (first..=end).step_by(stride).chain([end]) {
            let error = (f64::from(integer_log2(value)) * FLOAT_ROUNDING - f64::from(value).log2()).abs();
            worst.greatest(error, || format!("log2 of {value}"));
        }
        worst
    };
    (0..=last / PART).into_par_iter().map(of_part).reduce(Measured::nothing, Measured::join)
}

/// Converts the function value of each depth, rounded to Q14, to a code, and compares with the code of the depth.
/// Returns the error as a fraction of what rounding the value to Q8, the table and the code allow.
fn domain_error(kind: DomainKind, ratio: f32) -> Result<Measured> {
    let domain = Domain::new(kind, DepthRange::new(1.0, ratio)?)?;
    let ratio = f64::from(ratio);
    let span = ratio.ln();
    let codes = |log: f64| log / span * f64::from(FAR_CODE);
    // In Q8: the largest value, the value at the other end, and the latter as stored in the header.
    let top = 65535.0 * 256.0;
    let small = top / ratio;
    let end = codes((small.round().max(1.0) / small).ln().abs());
    let table = codes(2.0 * std::f64::consts::LN_2 * 2.9e-6);
    let mut worst = Measured::nothing();
    for code in 0..=FAR_CODE {
        let log = span * f64::from(code) / f64::from(FAR_CODE);
        let value = match kind {
            DomainKind::Inverse => top / log.exp(),
            _ => small * log.exp(),
        };
        let found = domain.code_of((value * 64.0).round() as i32);
        // Rounded to nearest in Q14, then in Q8. A value below half a unit is not representable.
        let rounding = 0.5 + 1.0 / 128.0;
        let gap = codes((value / (value - rounding).max(1.0 - rounding)).ln());
        let allowed = 0.5 + LOG_ROUNDING + gap + end + table;
        // The inverse of far must never decode as background.
        let background = found == BACKGROUND_CODE && value >= 1.0;
        let error = if background { f64::INFINITY } else { f64::from(found.abs_diff(code)) };
        // Inverse values that round to nothing decode as background: no surface is modelled at such distances.
        if value >= 1.0 {
            worst.greatest(error / allowed, || format!("code {code} became {found}"));
        }
    }
    Ok(worst)
}

/// Encodes surfaces from near to far with the default codec. Returns the relative error as a fraction of (E + 1/2 codes
/// and one float rounding).
fn metres_through_nodes(kind: DomainKind, reference: Reference) -> Result<Measured> {
    const SIDE: u32 = 48;
    let settings = NodeSettings { effort: EFFORT, ..NodeSettings::default() };
    let range = reference.range;
    let quantiser = Quantiser::new(range);
    // Slopes from near to far, linear in depth, in its logarithm and in its inverse, and an edge to the background.
    let (near, far) = (f64::from(range.near_m()), f64::from(range.far_m()));
    let metres = Sequence::new([SIDE, SIDE], 3, |frame, x, y| {
        let t = f64::from(x + frame) / f64::from(SIDE + 2);
        let z = match y / 16 {
            0 => near + (far - near) * t,
            1 => near * (reference.span * t).exp(),
            _ if x == SIDE - 1 => f64::INFINITY,
            _ => 1.0 / (1.0 / near + (1.0 / far - 1.0 / near) * t),
        };
        if z == f64::INFINITY { f32::INFINITY } else { (z as f32).clamp(range.near_m(), range.far_m()) }
    });
    let codes = |frame: &Vec<f32>| frame.iter().map(|&z| quantiser.code(z)).collect::<Option<Vec<_>>>();
    let frames = metres.frames.iter().map(codes).collect::<Option<Vec<_>>>();
    let frames = frames.ok_or_else(|| Error::invalid("a depth outside of its own range"))?;
    let source = Sequence { size: metres.size, frames };
    let clip = Clip::nodes(&source, (range, &Domain::new(kind, range)?), settings)?;
    let reach = reference.span * (f64::from(settings.bound) + 0.5 + LOG_ROUNDING) / f64::from(FAR_CODE);
    let part = reach.exp_m1() + EXP_ROUNDING;
    let mut worst = Measured::nothing();
    clip.show(|frame, picture| {
        let Picture::Depth(shown) = picture else { return Err(Error::invalid("depth was expected")) };
        for (&code, &z) in shown.data().iter().zip(&metres.frames[frame]) {
            let back = range.metres(code);
            let least = f64::from(f32::from_bits(1));
            let allowed = f64::from(z) * part + (f64::from(z) * (1.0 + part) * 2.0 * FLOAT_ROUNDING).max(least) / 2.0;
            let error = (f64::from(back) - f64::from(z)).abs();
            let share = if back == z { 0.0 } else { error / allowed };
            worst.greatest(share, || format!("frame {frame}: {z:e} m became {back:e} m"));
        }
        Ok(())
    })?;
    Ok(worst.with_clip(clip))
}
