//! Charts of placed cameras, as CALF's figures 3 and 4 have them.
//!
//! Enters: what each camera added to coverage. Leaves: drawings.

use super::plot::Drawing;
use super::plot::axis::Axis;
use super::plot::chart::{Chart, Kind, Mark, Series};
use super::plot::marker::Look;
use crate::placement::{Figures, Lighting};

const MOST_MARKERS: usize = 40;
const SIZE: [u32; 2] = [860, 420];

#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    pub lighting: Lighting,
    pub scene: String,
    pub rate_per_m: f64,
    pub figures: Vec<Figures>,
    pub reachable: Figures,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    pub name: &'static str,
    pub drawing: Drawing,
}

/// Coverage within and beyond the viewer distance for the first curve, how all of them converge, and the curves of several k
/// where there are any.
pub fn all(curves: &[Curve], decays: &[Curve]) -> Vec<Figure> {
    let first = curves.first().map(|curve| Figure { name: "coverage", drawing: coverage(curve) });
    let all = Figure { name: "convergence", drawing: convergence(curves) };
    let decay = (!decays.is_empty()).then(|| Figure { name: "decay", drawing: decay(decays) });
    first.into_iter().chain([all]).chain(decay).collect()
}

fn words(lighting: Lighting) -> String {
    match lighting {
        Lighting::Diffuse => "diffuse".to_owned(),
        Lighting::Specular { theta_deg } => format!("specular, θ = {theta_deg}°"),
    }
}

fn series(name: String, number: usize, figures: &[Figures], value: impl Fn(&Figures) -> f64) -> Series {
    let mark =
        |(at, figures): (usize, &Figures)| Mark { x: (at + 1) as f64, y: 100.0 * value(figures), ..Mark::default() };
    // From no camera, which covers nothing.
    let marks = std::iter::once(Mark::default()).chain(figures.iter().enumerate().map(mark)).collect();
    let kind = if figures.len() <= MOST_MARKERS { Kind::Line } else { Kind::Curve };
    Series { name, kind, look: Look::of(number), marks }
}

/// What is reachable, in the colour of the series of a number.
fn level(name: String, number: usize, share: f64, cameras: usize) -> Series {
    let mark = |x: f64| Mark { x, y: 100.0 * share, ..Mark::default() };
    let look = Look::of(number).dashed([6.0, 4.0]);
    Series { name, kind: Kind::Curve, look, marks: vec![mark(0.0), mark(cameras as f64)] }
}

fn most_cameras(curves: &[Curve]) -> usize {
    curves.iter().map(|curve| curve.figures.len()).max().unwrap_or(0).max(1)
}

/// A chart of shares over cameras. The axis of shares ends at 100%, or at what is shown where that is little.
fn chart(title: String, legend: String, up: &str, curves: &[Curve], series: Vec<Series>) -> Drawing {
    let most = series.iter().flat_map(|series| &series.marks).map(|mark| mark.y).fold(0.0, f64::max);
    let top = if most > 0.0 && most < 50.0 { most } else { 100.0 };
    let x = Axis::linear("cameras", [0.0, most_cameras(curves) as f64]);
    Chart { series, legend, ..Chart::new(title, x, Axis::linear(up, [0.0, top])) }.draw(SIZE[0], SIZE[1])
}

/// Figure 3. Coverage of specular surfaces is of directions, which have no viewer distance.
fn coverage(curve: &Curve) -> Drawing {
    let figures = &curve.figures;
    let series = match curve.lighting {
        Lighting::Diffuse => vec![
            series("seen".into(), 0, figures, |figures| figures.seen),
            series("seen, weighted".into(), 1, figures, |figures| figures.weighted),
            series("within viewer distance".into(), 2, figures, |figures| figures.within),
            level("seen, reachable".into(), 0, curve.reachable.seen, figures.len()),
            level("within, reachable".into(), 2, curve.reachable.within, figures.len()),
        ],
        Lighting::Specular { .. } => vec![
            series("directions".into(), 0, figures, |figures| figures.coverage),
            series("surface seen".into(), 1, figures, |figures| figures.seen),
            level("directions, reachable".into(), 0, curve.reachable.coverage, figures.len()),
            level("surface, reachable".into(), 1, curve.reachable.seen, figures.len()),
        ],
    };
    let up = if curve.lighting == Lighting::Diffuse { "% of all surface" } else { "% of all" };
    let title = format!("Coverage of {} by cameras, {}", curve.scene, words(curve.lighting));
    chart(title, format!("k = {:.3} per metre", curve.rate_per_m), up, std::slice::from_ref(curve), series)
}

/// Figure 4.
fn convergence(curves: &[Curve]) -> Drawing {
    let scene = curves.first().map_or("", |curve| curve.scene.as_str());
    let each = || curves.iter().enumerate();
    let lines =
        each().map(|(number, curve)| series(words(curve.lighting), number, &curve.figures, |figures| figures.coverage));
    let reachable = each().map(|(number, curve)| {
        let name = format!("{}, reachable", curve.lighting.name());
        level(name, number, curve.reachable.coverage, most_cameras(curves))
    });
    let series = lines.chain(reachable).collect();
    chart(format!("Convergence in {scene}"), "Lighting".to_owned(), "coverage (%)", curves, series)
}

/// Figure 3 for several k: what is seen at all, and from within the viewer distance.
fn decay(curves: &[Curve]) -> Drawing {
    let scene = curves.first().map_or("", |curve| curve.scene.as_str());
    let each = || curves.iter().enumerate();
    let seen = each().map(|(number, curve)| {
        series(format!("k = {}, seen", curve.rate_per_m), number, &curve.figures, |figures| figures.seen)
    });
    let within = each().map(|(number, curve)| {
        let name = format!("k = {}, within", curve.rate_per_m);
        let line = series(name, number, &curve.figures, |figures| figures.within);
        Series { look: Look::of(number).dashed([6.0, 4.0]), ..line }
    });
    let (title, legend) = (format!("Coverage of {scene} by cameras and k"), "k per metre; viewer distance".to_owned());
    chart(title, legend, "% of all surface", curves, seen.chain(within).collect())
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
        assert_eq!(figures.iter().map(|figure| figure.name).collect::<Vec<_>>(), ["coverage", "convergence"]);
        let lines = |drawing: &Drawing, points: usize| {
            let is = |shape: &&Shape| matches!(shape, Shape::Line { through, .. } if through.len() == points);
            drawing.shapes.iter().filter(is).count()
        };
        assert!(lines(&figures[0].drawing, 4) >= 3);
        assert!(lines(&figures[1].drawing, 8) >= 1 && lines(&figures[1].drawing, 4) >= 1);
        let texts = texts(&figures[1].drawing);
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
        let found = figures.iter().find(|figure| figure.name == "decay").unwrap();
        let texts = texts(&found.drawing);
        for line in ["k = 0.5, seen", "k = 0.5, within", "k = 2, seen", "k = 2, within"] {
            assert!(texts.contains(&line), "{texts:?}");
        }
    }

    #[test]
    fn little_coverage_fills_the_chart_and_specular_is_of_directions() {
        let mut few = curve(Lighting::Specular { theta_deg: 50.0 }, &[0.02, 0.04]);
        few.reachable = few.figures[1];
        let figures = all(&[few.clone()], &[]);
        for figure in &figures {
            assert!(!texts(&figure.drawing).contains(&"100"), "{}", figure.name);
        }
        assert!(texts(&figures[0].drawing).contains(&"directions"));
        few.reachable.coverage = 0.9;
        assert!(texts(&all(&[few], &[])[0].drawing).contains(&"100"));
    }
}
