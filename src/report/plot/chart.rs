//! Charts with two axes: lines with markers, points, curves and bars, with a legend beside the data.

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Ink, Spot, Stroke, Text};
use super::font::{self, Weight};
use super::labels::Labels;
use super::legend::{self, Entry};
use super::marker::Look;
use super::palette;
use super::style::{MARGIN, MARKER, NAME_EM, TICK_EM, TITLE_EM};

/// Half the width of the ends of bars of spreads, in pixels.
const CAP: f64 = 4.0;
/// Longest tick label that stands upright, in pixels.
const LONGEST_UPRIGHT: f64 = 110.0;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A line through markers.
    Line,
    /// A thin line through markers, where the markers are what counts.
    Thread,
    /// Markers alone.
    Points,
    /// A line alone.
    Curve,
    /// Bars from the beginning of the vertical axis, as wide as the distance to the next one.
    Bars,
}

/// A point of a series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mark {
    pub x: f64,
    pub y: f64,
    /// Least and largest y, for a bar of its spread.
    pub spread: Option<(f64, f64)>,
    /// Written beside it, short.
    pub name: Option<String>,
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend calls it; it has no entry there if this is empty.
    pub name: String,
    /// How it is drawn.
    pub kind: Kind,
    /// Colour and marker.
    pub look: Look,
    /// In the order of the line.
    pub marks: Vec<Mark>,
}

/// A line across the chart at a value.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Where, on the vertical axis.
    pub y: f64,
    /// What the legend calls it.
    pub name: String,
}

/// A chart with two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// What the names in the legend are, such as the knob whose values they are; may be empty.
    pub legend: String,
    /// What is drawn, the last on top.
    pub series: Vec<Series>,
    /// Lines across.
    pub rules: Vec<Rule>,
    /// A line through these, without markers and under those of the series, such as a Pareto front.
    pub front: Vec<Spot>,
    /// Short names of points and what they stand for, listed under the legend.
    pub key: Vec<(String, String)>,
    pub key_title: String,
}

impl Chart {
    /// A chart without anything in it.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Chart {
        Chart {
            title: title.into(),
            x,
            y,
            legend: String::new(),
            series: Vec::new(),
            rules: Vec::new(),
            front: Vec::new(),
            key: Vec::new(),
            key_title: String::new(),
        }
    }

    /// Draws it in a size in pixels; it becomes higher where its legend needs the room.
    pub fn draw(&self, width: u32, height: u32) -> Drawing {
        let legend = self.legend_of(f64::from(width) * 0.42);
        let height = height.max((legend.height() + 2.0 * MARGIN + TITLE_EM * 2.0).ceil() as u32);
        let mut drawing = Drawing::new(width, height, self.title.clone());
        let (right_side, legend_width) = (f64::from(width), legend.width());
        let legend_room = if legend_width > 0.0 { legend_width + 14.0 } else { 0.0 };

        let widest = self.y.ticks.iter().map(|(_, label)| font::width(label, TICK_EM, Weight::Regular));
        let infinite = self.y.infinite.iter().map(|name| font::width(name, TICK_EM, Weight::Regular));
        let ticks_width = widest.chain(infinite).fold(0.0, f64::max).min(LONGEST_UPRIGHT);
        let left = MARGIN + NAME_EM + 8.0 + ticks_width + 8.0;
        let right = (right_side - MARGIN - legend_room).max(left + 40.0);
        let upright = self.upright_room(right - left);
        let under = if upright > 0.0 { upright + 8.0 } else { TICK_EM + 8.0 };
        let bottom = f64::from(height) - MARGIN - NAME_EM - 8.0 - under;
        let top = MARGIN + if self.title.is_empty() { 4.0 } else { TITLE_EM + 14.0 };
        let plot = Plot { left, right, top, bottom };

        drawing.text(
            [MARGIN, MARGIN + TITLE_EM],
            Text::new(&self.title, TITLE_EM).bold().ink(palette::TEXT).fit(right_side - 2.0 * MARGIN),
        );
        plot.grid(&mut drawing, &self.x, &self.y, upright);
        self.draw_data(&mut drawing, &plot);
        legend::draw(&legend, &mut drawing, [right + 14.0, plot.top]);
        drawing
    }

    fn legend_of(&self, room: f64) -> legend::Legend {
        let of_series = self.series.iter().filter(|series| !series.name.is_empty()).map(|series| {
            let swatch = match series.kind {
                Kind::Line | Kind::Thread => legend::Swatch::LineAndMarker(series.look),
                Kind::Points => legend::Swatch::Marker(series.look),
                Kind::Curve => legend::Swatch::Line(series.look.stroke(2.0)),
                Kind::Bars => legend::Swatch::Patch(series.look.ink),
            };
            Entry { swatch, name: series.name.clone() }
        });
        let rules = self.rules.iter().map(|rule| Entry { swatch: legend::Swatch::Line(RULE), name: rule.name.clone() });
        legend::Legend {
            title: self.legend.clone(),
            entries: of_series.chain(rules).collect(),
            key_title: self.key_title.clone(),
            key: self.key.clone(),
            room,
        }
    }

    /// How high tick labels of the axis across stand, where they do not fit side by side; 0 where they do.
    fn upright_room(&self, width: f64) -> f64 {
        let is_word = |label: &str| label.chars().any(char::is_alphabetic);
        if !self.x.ticks.iter().any(|(_, label)| is_word(label)) {
            return 0.0;
        }
        let slot = width / self.x.ticks.len().max(1) as f64 - 6.0;
        let widest =
            self.x.ticks.iter().map(|(_, label)| font::width(label, TICK_EM, Weight::Regular)).fold(0.0, f64::max);
        if widest <= slot { 0.0 } else { widest.min(LONGEST_UPRIGHT) }
    }

    fn draw_data(&self, drawing: &mut Drawing, plot: &Plot) {
        let at = |x: f64, y: f64| Some(plot.at(self.x.place(x)?, self.y.place(y)?));
        for rule in &self.rules {
            if let Some(place) = self.y.place(rule.y) {
                drawing.line(&[plot.at(0.0, place), plot.at(1.0, place)], RULE);
            }
        }
        for series in self.series.iter().filter(|series| series.kind == Kind::Bars) {
            self.bars(drawing, plot, series);
        }
        for series in &self.series {
            self.lines(drawing, plot, series);
        }
        self.draw_front(drawing, plot);
        let mut labels = Labels::inside([plot.left, plot.top], [plot.right, plot.bottom]);
        let mut named = Vec::new();
        for series in self.series.iter().filter(|series| !matches!(series.kind, Kind::Curve | Kind::Bars)) {
            for mark in &series.marks {
                let Some(spot) = at(mark.x, mark.y) else { continue };
                series.look.mark(drawing, spot, MARKER);
                labels.keep_off(spot, MARKER + 2.0);
                named.extend(mark.name.as_deref().map(|name| (spot, name)));
            }
        }
        for (spot, name) in named {
            labels.write(drawing, spot, name);
        }
    }

    /// The front's line. Between two values that are not both finite there is nothing that it could show; it only tells
    /// where the front goes on, and is dotted.
    fn draw_front(&self, drawing: &mut Drawing, plot: &Plot) {
        for leg in self.front.windows(2) {
            let ends = [leg[0], leg[1]];
            let [Some(from), Some(to)] = ends.map(|[x, y]| Some(plot.at(self.x.place(x)?, self.y.place(y)?))) else {
                continue;
            };
            let is_finite = ends.iter().flatten().all(|value| value.is_finite());
            drawing.line(&[from, to], if is_finite { Stroke::dashed(palette::FAINT_TEXT, 1.5) } else { BEYOND });
        }
    }

    fn bars(&self, drawing: &mut Drawing, plot: &Plot, series: &Series) {
        let places: Vec<Option<f64>> = series.marks.iter().map(|mark| self.x.place(mark.x)).collect();
        let step = places.windows(2).find_map(|pair| Some(pair[1]? - pair[0]?)).filter(|step| *step > 0.0);
        for (mark, place) in series.marks.iter().zip(&places) {
            let (Some(place), Some(top)) = (place, self.y.place(mark.y)) else { continue };
            let half = if mark.x.is_infinite() { 0.03 } else { step.unwrap_or(0.06) / 2.0 };
            let inset = 0.5 / (plot.right - plot.left);
            drawing.rectangle(plot.at(place - half + inset, 0.0), plot.at(place + half - inset, top), series.look.ink);
        }
    }

    fn lines(&self, drawing: &mut Drawing, plot: &Plot, series: &Series) {
        let at = |x: f64, y: f64| Some(plot.at(self.x.place(x)?, self.y.place(y)?));
        let width = match series.kind {
            Kind::Line => Some(1.8),
            Kind::Curve => Some(2.0),
            Kind::Thread => Some(0.9),
            Kind::Points | Kind::Bars => None,
        };
        if let Some(width) = width {
            // A line ends where a point is missing, and markers at what is infinite are not joined with others.
            let joined = |a: &&Mark, b: &&Mark| {
                let alike = series.kind == Kind::Curve || a.y.is_finite() == b.y.is_finite();
                alike && at(a.x, a.y).is_some() && at(b.x, b.y).is_some()
            };
            let marks: Vec<&Mark> = series.marks.iter().collect();
            for run in marks.chunk_by(joined) {
                let through: Vec<Spot> = run.iter().filter_map(|mark| at(mark.x, mark.y)).collect();
                drawing.line(&through, series.look.stroke(width));
            }
        }
        for mark in &series.marks {
            let Some((low, high)) = mark.spread else { continue };
            let (Some(lower), Some(upper)) = (at(mark.x, low), at(mark.x, high)) else { continue };
            let stroke = Stroke::solid(series.look.ink, 1.2);
            drawing.line(&[lower, upper], stroke);
            // A bar that is cut at the border has no end there.
            for (value, [x, end]) in [(low, lower), (high, upper)] {
                if self.y.holds(value) {
                    drawing.line(&[[x - CAP, end], [x + CAP, end]], stroke);
                }
            }
        }
    }
}

/// The line of a [`Rule`].
const RULE: Stroke = Stroke { ink: Ink::opaque([60, 60, 60]), width: 1.5, dash: Some([8.0, 4.0]) };

/// A leg of a front to or from what is infinite.
const BEYOND: Stroke = Stroke { ink: palette::FAINT_LINE, width: 1.2, dash: Some([1.5, 3.5]) };

/// The rectangle that data is drawn in.
struct Plot {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Plot {
    /// A place from shares of both axes.
    fn at(&self, x: f64, y: f64) -> Spot {
        [self.left + (self.right - self.left) * x, self.bottom - (self.bottom - self.top) * y]
    }

    fn grid(&self, drawing: &mut Drawing, x: &Axis, y: &Axis, upright: f64) {
        let middle = [(self.left + self.right) / 2.0, (self.top + self.bottom) / 2.0];
        let tick = |label: &str| Text::new(label, TICK_EM).ink(palette::TEXT);
        let line = Stroke::solid(palette::GRID, 1.0);

        let mut written = f64::INFINITY;
        for (value, label) in &y.ticks {
            let Some(share) = y.place(*value) else { continue };
            let [_, height] = self.at(0.0, share);
            drawing.line(&[[self.left, height], [self.right, height]], line);
            if written - height >= TICK_EM {
                let text = tick(label).anchor(Anchor::End).fit(LONGEST_UPRIGHT);
                drawing.text_beside([self.left - 7.0, height], text);
                written = height;
            }
        }
        if let (Some(name), Some(share)) = (&y.infinite, y.place(f64::INFINITY)) {
            let [_, height] = self.at(0.0, share);
            drawing.line(&[[self.left, height], [self.right, height]], Stroke::dashed(palette::MARK, 1.2));
            drawing.text_beside([self.left - 7.0, height], tick(name).anchor(Anchor::End).ink(palette::MARK));
        }

        let mut written = f64::NEG_INFINITY;
        for (value, label) in &x.ticks {
            let Some(share) = x.place(*value) else { continue };
            let [across, _] = self.at(share, 0.0);
            drawing.line(&[[across, self.top], [across, self.bottom]], line);
            if upright > 0.0 {
                if across - written >= TICK_EM {
                    let text = tick(label).up().anchor(Anchor::End).fit(upright);
                    drawing.text([across + TICK_EM * font::CAP_PER_EM / 2.0, self.bottom + 6.0], text);
                    written = across;
                }
                continue;
            }
            let text = tick(label).anchor(Anchor::Middle);
            let half = text.width() / 2.0;
            if across - half - written >= 5.0 {
                written = across + half;
                drawing.text([across, self.bottom + 5.0 + TICK_EM], text);
            }
        }
        if let (Some(name), Some(share)) = (&x.infinite, x.place(f64::INFINITY)) {
            let [across, _] = self.at(share, 0.0);
            let text = tick(name).anchor(Anchor::Middle).ink(palette::MARK);
            drawing.text([across, self.bottom + 5.0 + TICK_EM], text);
        }

        let axis = Stroke::solid(palette::TEXT, 1.0);
        drawing.line(&[[self.left, self.top], [self.left, self.bottom], [self.right, self.bottom]], axis);
        let name =
            |label: &str, room: f64| Text::new(label, NAME_EM).ink(palette::TEXT).anchor(Anchor::Middle).fit(room);
        let under = f64::from(drawing.height) - MARGIN - 2.0;
        drawing.text([middle[0], under], name(&x.label, self.right - self.left + 60.0));
        drawing.text([MARGIN + NAME_EM, middle[1]], name(&y.label, self.bottom - self.top + 40.0).up());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::drawing::Shape;

    fn lines(chart: &Chart) -> Vec<(Vec<Spot>, Stroke)> {
        let shapes = chart.draw(400, 300).shapes.into_iter();
        let lines = shapes.filter_map(|shape| match shape {
            Shape::Line { through, stroke } => Some((through, stroke)),
            _ => None,
        });
        lines.collect()
    }

    #[test]
    fn a_bar_that_is_cut_has_no_end_at_the_border() {
        let look = Look::of(0);
        let caps = |spread: (f64, f64)| {
            let mark = Mark { x: 1.0, y: 5.0, spread: Some(spread), name: None };
            let series = vec![Series { name: String::new(), kind: Kind::Points, look, marks: vec![mark] }];
            let chart = Chart { series, ..Chart::new("", Axis::linear("", [0.0, 2.0]), Axis::linear("", [0.0, 10.0])) };
            let is_cap = |through: &[Spot]| through[0][1] == through[1][1];
            lines(&chart).iter().filter(|(through, stroke)| stroke.ink == look.ink && is_cap(through)).count()
        };
        assert_eq!([caps((4.0, 6.0)), caps((4.0, 10.0)), caps((4.0, 11.0)), caps((-1.0, 11.0))], [2, 2, 1, 0]);
    }

    #[test]
    fn the_front_to_what_is_infinite_is_dotted() {
        let y = Axis::without_zero("", [40.0, 60.0]).with_infinite("lossless");
        let front = vec![[1.0, 40.0], [2.0, 60.0], [3.0, f64::INFINITY]];
        let chart = Chart { front, ..Chart::new("", Axis::linear("", [0.0, 4.0]), y) };
        let of = |ink| lines(&chart).iter().filter(|(_, stroke)| stroke.ink == ink && stroke.width > 1.1).count();
        assert!(of(palette::FAINT_TEXT) > 5 && of(BEYOND.ink) > 5, "{:?}", lines(&chart));
        let finite = Chart { front: chart.front[..2].to_vec(), ..chart.clone() };
        assert!(lines(&finite).iter().all(|(_, stroke)| stroke.ink != BEYOND.ink));
    }

    #[test]
    fn threads_join_marks_thinly_and_points_are_not_joined() {
        let joined = |kind: Kind| {
            let marks = [1.0, 2.0, 3.0].map(|x| Mark { x, y: x, ..Mark::default() }).to_vec();
            let look = Look::of(0);
            let series = vec![Series { name: String::new(), kind, look, marks }];
            let chart = Chart { series, ..Chart::new("", Axis::linear("", [0.0, 4.0]), Axis::linear("", [0.0, 4.0])) };
            let own = lines(&chart).into_iter().filter(|(_, stroke)| stroke.ink == look.ink);
            own.map(|(through, stroke)| (through.len(), stroke.width)).collect::<Vec<_>>()
        };
        assert_eq!(joined(Kind::Thread), [(3, 0.9)]);
        assert_eq!(joined(Kind::Points), []);
    }
}
