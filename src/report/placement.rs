//! Charts of placed cameras, as CALF's figures 3 and 4 have them.
//!
//! Enters: what each camera added to coverage. Leaves: drawings.

use super::plot::Drawing;
use super::plot::axis::Axis;
use super::plot::chart::{Chart, Kind, Mark, Series};
use super::plot::marker::Look;
use crate::placement::{Figures, Lighting};

/// Cameras up to which each has a marker.
const MOST_MARKERS: usize = 40;
/// Size of a chart in pixels.
const SIZE: [u32; 2] = [860, 420];

/// How cameras converge for one lighting.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Which.
    pub lighting: Lighting,
    /// What they were placed in, as the user names it.
    pub scene: String,
    /// k, per metre.
    pub rate_per_m: f64,
    /// After each camera.
    pub figures: Vec<Figures>,
    /// What can be covered at all.
    pub reachable: Figures,
}

/// A picture of placed cameras.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its files, without an ending.
    pub name: &'static str,
    /// The picture.
    pub drawing: Drawing,
}

/// Coverage within and beyond the viewer distance for the first curve, and how all of them converge.
pub fn all(curves: &[Curve]) -> Vec<Figure> {
    let first = curves.first().map(|curve| Figure { name: "coverage", drawing: coverage(curve) });
    let all = Figure { name: "convergence", drawing: convergence(curves) };
    first.into_iter().chain([all]).collect()
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

fn axes(curves: &[Curve], up: &str) -> (Axis, Axis) {
    (Axis::linear("cameras", [0.0, most_cameras(curves) as f64]), Axis::linear(up, [0.0, 100.0]))
}

/// Figure 3.
fn coverage(curve: &Curve) -> Drawing {
    let (x, y) = axes(std::slice::from_ref(curve), "% of all surface");
    let figures = &curve.figures;
    let chart = Chart {
        series: vec![
            series("seen".into(), 0, figures, |figures| figures.seen),
            series("seen, weighted".into(), 1, figures, |figures| figures.weighted),
            series("within viewer distance".into(), 2, figures, |figures| figures.within),
            level("seen, reachable".into(), 0, curve.reachable.seen, figures.len()),
            level("within, reachable".into(), 2, curve.reachable.within, figures.len()),
        ],
        legend: format!("k = {:.3} per metre", curve.rate_per_m),
        ..Chart::new(format!("Coverage of {} by cameras, {}", curve.scene, words(curve.lighting)), x, y)
    };
    chart.draw(SIZE[0], SIZE[1])
}

/// Figure 4.
fn convergence(curves: &[Curve]) -> Drawing {
    let (x, y) = axes(curves, "coverage (%)");
    let scene = curves.first().map_or("", |curve| curve.scene.as_str());
    let of = |(number, curve): (usize, &Curve)| {
        series(words(curve.lighting), number, &curve.figures, |figures| figures.coverage)
    };
    let reachable = |(number, curve): (usize, &Curve)| {
        let name = format!("{}, reachable", curve.lighting.name());
        level(name, number, curve.reachable.coverage, most_cameras(curves))
    };
    let each = || curves.iter().enumerate();
    let chart = Chart {
        series: each().map(of).chain(each().map(reachable)).collect(),
        legend: "Lighting".to_owned(),
        ..Chart::new(format!("Convergence in {scene}"), x, y)
    };
    chart.draw(SIZE[0], SIZE[1])
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
        let figures = all(&curves);
        assert_eq!(figures.iter().map(|figure| figure.name).collect::<Vec<_>>(), ["coverage", "convergence"]);
        let lines = |drawing: &Drawing, points: usize| {
            let is = |shape: &&Shape| matches!(shape, Shape::Line { through, .. } if through.len() == points);
            drawing.shapes.iter().filter(is).count()
        };
        assert!(lines(&figures[0].drawing, 4) >= 3);
        assert!(lines(&figures[1].drawing, 8) >= 1 && lines(&figures[1].drawing, 4) >= 1);
        let texts: Vec<&str> = figures[1]
            .drawing
            .shapes
            .iter()
            .filter_map(|shape| if let Shape::Text { text, .. } = shape { Some(text.text.as_str()) } else { None })
            .collect();
        assert!(texts.contains(&"diffuse") && texts.contains(&"specular, θ = 50°"), "{texts:?}");
    }

    #[test]
    fn a_single_camera_is_a_chart_too() {
        assert_eq!(all(&[curve(Lighting::Diffuse, &[1.0])]).len(), 2);
    }
}
