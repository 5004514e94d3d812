//! Charts of camera placement, like CALF's figures 3 and 4.
//!
//! Input: coverage after each placed camera. Output: drawings.

use super::plot::Drawing;
use super::plot::axis::Axis;
use super::plot::chart::{Chart, Kind, Mark, Series};
use super::plot::marker::Look;
use scene::placement::{Figures, Lighting};

const MAX_MARKERS: usize = 40;
const SIZE: [u32; 2] = [860, 420];
const REACHABLE_SURFACE: &str = "% of the surface that is reachable";

#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    pub lighting: Lighting,
    pub scene: String,
    pub rate_per_m: f64,
    pub figures: Vec<Figures>,
    pub reachable: Figures,
}

/// Returns the chart of coverage within and beyond the viewer distance for the first curve, the convergence chart of
/// all curves and, if there are curves of several k, their chart, with their names.
pub fn all(curves: &[Curve], decays: &[Curve]) -> Vec<(&'static str, Drawing)> {
    let first = curves.first().map(|curve| ("coverage", coverage(curve)));
    let all = ("convergence", convergence(curves));
    let decay = (!decays.is_empty()).then(|| ("decay", decay(decays)));
    first.into_iter().chain([all]).chain(decay).collect()
}

fn words(lighting: Lighting) -> String {
    match lighting {
        Lighting::Diffuse => "diffuse".to_owned(),
        Lighting::Specular { theta_deg } => format!("specular, θ = {theta_deg}°"),
    }
}

/// Converts a share of surfaces or directions to percent of what all candidates together see. The region limits the
/// latter.
fn percent(share: f64, reachable: f64) -> f64 {
    if reachable > 0.0 { 100.0 * share / reachable } else { 0.0 }
}

fn series(name: String, number: usize, figures: &[Figures], value: impl Fn(&Figures) -> f64) -> Series {
    let mark = |(at, figures): (usize, &Figures)| Mark { x: (at + 1) as f64, y: value(figures), ..Mark::default() };
    // The curve starts at (0, 0): no camera, no coverage.
    let marks = std::iter::once(Mark::default()).chain(figures.iter().enumerate().map(mark)).collect();
    let kind = if figures.len() <= MAX_MARKERS { Kind::Line } else { Kind::Curve };
    Series { name, kind, look: Look::of(number), marks }
}

/// Horizontal dashed line at the reachable share, in the colour of series `number`.
fn level(name: String, number: usize, percent: f64, cameras: usize) -> Series {
    let mark = |x: f64| Mark { x, y: percent, ..Mark::default() };
    let look = Look::of(number).dashed([6.0, 4.0]);
    Series { name, kind: Kind::Curve, look, marks: vec![mark(0.0), mark(cameras as f64)] }
}

fn max_cameras(curves: &[Curve]) -> usize {
    curves.iter().map(|curve| curve.figures.len()).max().unwrap_or(0).max(1)
}

/// Returns a chart of shares in percent over the number of cameras.
fn chart(title: String, legend: String, up: &str, curves: &[Curve], series: Vec<Series>) -> Drawing {
    let x = Axis::linear("cameras", [0.0, max_cameras(curves) as f64]);
    Chart { series, legend, ..Chart::new(title, x, Axis::linear(up, [0.0, 100.0])) }.draw(SIZE[0], SIZE[1])
}

/// Returns CALF figure 3. For specular surfaces coverage counts directions, which have no viewer distance.
fn coverage(curve: &Curve) -> Drawing {
    let Curve { figures, reachable, .. } = curve;
    let of_surface = |share: f64| percent(share, reachable.seen);
    let of_directions = |share: f64| percent(share, reachable.coverage);
    let series = match curve.lighting {
        Lighting::Diffuse => vec![
            series("seen".into(), 0, figures, |figures| of_surface(figures.seen)),
            series("seen, weighted".into(), 1, figures, |figures| of_surface(figures.weighted)),
            series("within viewer distance".into(), 2, figures, |figures| of_surface(figures.within)),
            level("within, reachable".into(), 2, of_surface(reachable.within), figures.len()),
        ],
        Lighting::Specular { .. } => vec![
            series("directions".into(), 0, figures, |figures| of_directions(figures.coverage)),
            series("surface seen".into(), 1, figures, |figures| of_surface(figures.seen)),
        ],
    };
    let up = if curve.lighting == Lighting::Diffuse { REACHABLE_SURFACE } else { "% of what is reachable" };
    let title = format!("Coverage of {} by cameras, {}", curve.scene, words(curve.lighting));
    let legend =
        format!("k = {:.3} per metre; {:.1}% of all surface is reachable", curve.rate_per_m, 100.0 * reachable.seen);
    chart(title, legend, up, std::slice::from_ref(curve), series)
}

/// Returns CALF figure 4.
fn convergence(curves: &[Curve]) -> Drawing {
    let scene = curves.first().map_or("", |curve| curve.scene.as_str());
    let line = |(number, curve): (usize, &Curve)| {
        series(words(curve.lighting), number, &curve.figures, |figures| {
            percent(figures.coverage, curve.reachable.coverage)
        })
    };
    let series = curves.iter().enumerate().map(line).collect();
    chart(format!("Convergence in {scene}"), "Lighting".to_owned(), "% of reachable coverage", curves, series)
}

/// Returns CALF figure 3 for several k: the share of the surface that is seen, and that is seen from within the viewer
/// distance.
fn decay(curves: &[Curve]) -> Drawing {
    let scene = curves.first().map_or("", |curve| curve.scene.as_str());
    let each = || curves.iter().enumerate();
    let of_surface = |curve: &Curve, share: f64| percent(share, curve.reachable.seen);
    let seen = each().map(|(number, curve)| {
        let name = format!("k = {}, seen", curve.rate_per_m);
        series(name, number, &curve.figures, |figures| of_surface(curve, figures.seen))
    });
    let within = each().map(|(number, curve)| {
        let name = format!("k = {}, within", curve.rate_per_m);
        let line = series(name, number, &curve.figures, |figures| of_surface(curve, figures.within));
        Series { look: Look::of(number).dashed([6.0, 4.0]), ..line }
    });
    let (title, legend) = (format!("Coverage of {scene} by cameras and k"), "k per metre; viewer distance".to_owned());
    chart(title, legend, REACHABLE_SURFACE, curves, seen.chain(within).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::drawing::Shape;

    fn curve(lighting: Lighting, shares: &[f64]) -> Curve {
        let figures = |share: f64| Figures { coverage: share, seen: share, weighted: 0.9 * share, within: 0.5 * share };
        Curve {
            lighting,
            scene: "dragon.glb".into(),
            rate_per_m: 0.5,
            figures: shares.iter().map(|share| figures(*share)).collect(),
            reachable: figures(0.98),
        }
    }

    #[test]
    fn each_curve_has_a_line_through_all_cameras() {
        let curves =
            [curve(Lighting::Diffuse, &[0.5, 0.8, 0.9]), curve(Lighting::Specular { theta_deg: 50.0 }, &[0.3; 7])];
        let figures = all(&curves, &[]);
        assert_eq!(figures.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["coverage", "convergence"]);
        let lines = |drawing: &Drawing, points: usize| {
            let is = |shape: &&Shape| matches!(shape, Shape::Line { through, .. } if through.len() == points);
            drawing.shapes.iter().filter(is).count()
        };
        assert!(lines(&figures[0].1, 4) >= 3);
        assert!(lines(&figures[1].1, 8) >= 1 && lines(&figures[1].1, 4) >= 1);
        let texts = texts(&figures[1].1);
        assert!(texts.contains(&"diffuse") && texts.contains(&"specular, θ = 50°"), "{texts:?}");
    }

    #[test]
    fn a_single_camera_is_a_chart_too() {
        assert_eq!(all(&[curve(Lighting::Diffuse, &[1.0])], &[]).len(), 2);
    }

    fn texts(drawing: &Drawing) -> Vec<&str> {
        drawing
            .shapes
            .iter()
            .filter_map(|shape| if let Shape::Text { text, .. } = shape { Some(text.text.as_str()) } else { None })
            .collect()
    }

    #[test]
    fn each_k_has_a_line_of_what_is_seen_and_one_within() {
        let of = |rate_per_m: f64| Curve { rate_per_m, ..curve(Lighting::Diffuse, &[0.5, 0.7]) };
        let figures = all(&[of(1.0)], &[of(0.5), of(2.0)]);
        let found = figures.iter().find(|(name, _)| *name == "decay").unwrap();
        let texts = texts(&found.1);
        for line in ["k = 0.5, seen", "k = 0.5, within", "k = 2, seen", "k = 2, within"] {
            assert!(texts.contains(&line), "{texts:?}");
        }
    }

    #[test]
    fn shares_are_of_what_is_reachable_and_specular_is_of_directions() {
        let highest = |drawing: &Drawing, points: usize| {
            let lines = drawing.shapes.iter().filter_map(|shape| match shape {
                Shape::Line { through, .. } if through.len() == points => Some(through.clone()),
                _ => None,
            });
            lines.flatten().map(|point| point[1]).fold(f64::INFINITY, f64::min)
        };
        let mut few = curve(Lighting::Specular { theta_deg: 50.0 }, &[0.02, 0.04]);
        few.reachable = few.figures[1];
        let mut many = curve(Lighting::Specular { theta_deg: 50.0 }, &[0.45, 0.9]);
        many.reachable = many.figures[1];
        // Cameras in the region can see at most 4% of the surface.
        let [few, many] = [few, many].map(|curve| all(&[curve], &[]));
        assert_eq!(highest(&few[1].1, 3), highest(&many[1].1, 3));
        assert!(texts(&few[0].1).contains(&"directions") && texts(&few[0].1).contains(&"100"));
        assert!(texts(&few[0].1).iter().any(|text| text.contains("4.0% of all surface is reachable")));
    }
}
