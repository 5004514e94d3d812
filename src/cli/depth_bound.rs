//! Text about the depth error bound, and about the outlier pixels that increase it.

use codec::depth::quantise::{metres_in_words, rounded_up};
use codec::error::{counted, escaped};
use footage::depth_bound::{DepthBound, STATED_DISTANCES_M};
use footage::encode::{NamedPixel, NamedStrays, ProbePrecision};

/// Maximum number of probes that get a line each.
pub const FEW_PROBES: usize = 4;

pub fn percent(bound: &DepthBound) -> String {
    bound.percent().map_or_else(|| "-".into(), |percent| format!("{}%", rounded_up(percent)))
}

/// Formats metres, or millimetres for small errors, rounded up to two digits.
pub fn length(metres: f64) -> String {
    if metres < 0.1 { format!("{} mm", rounded_up(1000.0 * metres)) } else { format!("{} m", rounded_up(metres)) }
}

/// Describes the bound in percent, and in metres at those of the stated distances that are between near and far.
pub fn words(bound: &DepthBound) -> String {
    let Some(share) = bound.share() else { return "no bound on the error".into() };
    let (within, outside): (Vec<f32>, Vec<f32>) =
        STATED_DISTANCES_M.into_iter().partition(|&distance| bound.metres_at(distance).is_some());
    let at = |distance: &f32| format!("{} at {distance} m", length(share * f64::from(*distance)));
    let metres: Vec<String> = within.iter().map(at).collect();
    let outside: Vec<String> = outside.iter().map(ToString::to_string).collect();
    let no_surface = match outside.join(", ") {
        none if none.is_empty() => none,
        distances => format!("; no surface at {distances} m"),
    };
    let metres = if metres.is_empty() { String::new() } else { format!(", {}", metres.join(", ")) };
    format!("within {} of the distance{metres}{no_surface}", percent(bound))
}

/// Returns a line for each probe, or for the worst and the best if there are more than `most`.
pub fn lines(probes: &[(&str, DepthBound)], most: usize) -> Vec<String> {
    let line = |(probe, bound): &(&str, DepthBound)| format!("depth of {}: {}", escaped(probe), words(bound));
    if probes.len() <= most {
        return probes.iter().map(line).collect();
    }
    let share = |known: &(&str, DepthBound)| known.1.share().unwrap_or(f64::INFINITY);
    let by_share = |a: &&(&str, DepthBound), b: &&(&str, DepthBound)| share(a).total_cmp(&share(b));
    let (best, worst) = (probes.iter().min_by(by_share), probes.iter().max_by(by_share));
    let named = [("worst", worst), ("best", best)].into_iter().filter_map(|(what, known)| Some((what, known?)));
    named.map(|(what, known)| format!("{what} of {} probes: {}", probes.len(), line(known))).collect()
}

/// Describes the outlier pixels, their effect on the bound, and the options that exclude them.
pub fn stray_words(probe: &ProbePrecision, strays: &NamedStrays) -> String {
    let NamedStrays { pixels, of_pixels, first, without } = strays;
    let place = |pixel: &NamedPixel| {
        let NamedPixel { file, frame, face, x, y, depth_m } = pixel;
        let depth = metres_in_words(depth_m.0 as f32);
        let file = file.as_ref().map_or_else(String::new, |file| format!("{}, ", file.display()));
        format!("{depth} m in {file}frame {frame}, {face}, pixel ({x}, {y})")
    };
    let places: Vec<String> = first.iter().map(place).collect();
    let (range, all) = (probe.bound.range, without.range);
    let (is_near, is_far) = (all.near_m() > range.near_m(), all.far_m() < range.far_m());
    let near = is_near.then(|| format!("--near {}", metres_in_words(all.near_m())));
    let far = is_far.then(|| format!("--far {}", metres_in_words(all.far_m())));
    let ends: Vec<String> = near.into_iter().chain(far).collect();
    let precision = match (probe.bound.share(), without.share()) {
        (Some(with), Some(without)) => {
            format!("{}% of the distance instead of {}%", rounded_up(100.0 * with), rounded_up(100.0 * without))
        }
        _ => "larger steps between codes".into(),
    };
    let more = if *pixels > first.len() as u64 { ", and others" } else { "" };
    format!(
        "probe {}: {} of {of_pixels} widen the depth range and reduce its precision ({precision}): {}{more}; {} with \
        --invalid-depth near (clamp to that distance) or far (background) excludes them",
        probe.probe,
        counted(*pixels, "depth pixel"),
        places.join("; "),
        ends.join(" "),
    )
}
