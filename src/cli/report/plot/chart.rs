//! Charts with two axes: lines with markers, points, curves and bars, with a legend beside the plot area.

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Ink, Spot, Stroke};
use super::labels::{
    LONGEST_LABEL, Labels, MARGIN, MARKER, NAME_EM, TICK_EM, TITLE_EM, name, tick, widest, write_title,
};
use super::legend::{Entry, Legend, Swatch};
use super::marker::Look;
use super::{font, palette};

const CAP: f64 = 4.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Line,
    /// Thin line through markers, for series in which the markers are the data.
    Thread,
    Points,
    Curve,
    /// Bars from the start of the vertical axis, each as wide as the distance to the next.
    Bars,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mark {
    pub x: f64,
    pub y: f64,
    /// Smallest and largest y, drawn as an error bar.
    pub spread: Option<(f64, f64)>,
    /// Short label beside the mark.
    pub name: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend. A series with an empty name has no legend entry.
    pub name: String,
    pub kind: Kind,
    pub look: Look,
    pub marks: Vec<Mark>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    pub y: f64,
    pub name: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Title of the legend, such as the knob whose values are the series' names. May be empty.
    pub legend: String,
    pub series: Vec<Series>,
    pub rules: Vec<Rule>,
    /// Points of a line without markers, such as a Pareto front. It is drawn over the lines and bars of
    /// the series, and under their markers.
    pub front: Vec<Spot>,
    /// Short names of points with explanations, listed below the legend.
    pub key: Vec<(String, String)>,
    pub key_title: String,
}

impl Chart {
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Chart {
        let (legend, key_title) = (String::new(), String::new());
        let (series, rules, front, key) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Chart { title: title.into(), x, y, legend, series, rules, front, key, key_title }
    }

    /// Draws the chart at the given size in pixels. The height grows if the legend needs it.
    pub fn draw(&self, width: u32, height: u32) -> Drawing {
        let legend = self.legend_of(f64::from(width) * 0.42);
        let height = height.max((legend.height() + 2.0 * MARGIN + TITLE_EM * 2.0).ceil() as u32);
        let mut drawing = Drawing::new(width, height, self.title.clone());
        let (right_side, legend_width) = (f64::from(width), legend.width());
        let legend_room = if legend_width > 0.0 { legend_width + 14.0 } else { 0.0 };

        let ticks_width = widest(self.y.ticks.iter().map(|(_, label)| label).chain(&self.y.infinite));
        let left = MARGIN + NAME_EM + 8.0 + ticks_width.min(LONGEST_LABEL) + 8.0;
        let right = (right_side - MARGIN - legend_room).max(left + 40.0);
        let upright = self.upright_room(right - left);
        let under = if upright > 0.0 { upright + 8.0 } else { TICK_EM + 8.0 };
        let bottom = f64::from(height) - MARGIN - NAME_EM - 8.0 - under;
        let top = MARGIN + if self.title.is_empty() { 4.0 } else { TITLE_EM + 14.0 };
        let plot = Plot { x: &self.x, y: &self.y, left, right, top, bottom };

        write_title(&mut drawing, &self.title, right_side);
        plot.grid(&mut drawing, upright);
        self.draw_data(&mut drawing, &plot);
        legend.draw(&mut drawing, [right + 14.0, plot.top]);
        drawing
    }

    fn legend_of(&self, room: f64) -> Legend {
        let of_series = self.series.iter().filter(|series| !series.name.is_empty()).map(|series| {
            let swatch = match series.kind {
                Kind::Line | Kind::Thread => Swatch::LineAndMarker(series.look),
                Kind::Points => Swatch::Marker(series.look),
                Kind::Curve => Swatch::Line(series.look.stroke(2.0)),
                Kind::Bars => Swatch::Patch(series.look.ink),
            };
            Entry { swatch, name: series.name.clone() }
        });
        let rules = self.rules.iter().map(|rule| Entry { swatch: Swatch::Line(RULE), name: rule.name.clone() });
        let entries = of_series.chain(rules).collect();
        let (title, key_title) = (self.legend.clone(), self.key_title.clone());
        Legend { title, entries, key_title, key: self.key.clone(), room }
    }

    /// Height in pixels of the x tick labels if they have to stand upright. 0 if they fit side by side.
    fn upright_room(&self, width: f64) -> f64 {
        let labels = || self.x.ticks.iter().map(|(_, label)| label);
        let is_word = |label: &String| label.chars().any(char::is_alphabetic);
        let slot = width / self.x.ticks.len().max(1) as f64 - 6.0;
        let widest = widest(labels());
        if !labels().any(is_word) || widest <= slot { 0.0 } else { widest.min(LONGEST_LABEL) }
    }

    fn draw_data(&self, drawing: &mut Drawing, plot: &Plot<'_>) {
        for rule in &self.rules {
            if let Some(place) = self.y.place(rule.y) {
                drawing.line(&[plot.at(0.0, place), plot.at(1.0, place)], RULE);
            }
        }
        for series in self.series.iter().filter(|series| series.kind == Kind::Bars) {
            plot.bars(drawing, series);
        }
        for series in &self.series {
            plot.lines(drawing, series);
        }
        self.draw_front(drawing, plot);
        let mut labels = Labels::inside([plot.left, plot.top], [plot.right, plot.bottom]);
        let mut named = Vec::new();
        for series in self.series.iter().filter(|series| !matches!(series.kind, Kind::Curve | Kind::Bars)) {
            for mark in &series.marks {
                let Some(spot) = plot.spot(mark.x, mark.y) else { continue };
                series.look.mark(drawing, spot, MARKER);
                labels.keep_off(spot, MARKER + 2.0);
                named.extend(mark.name.as_deref().map(|name| (spot, name)));
            }
        }
        for (spot, name) in named {
            labels.write(drawing, spot, name);
        }
    }

    /// Draws the line of the front. A segment with an infinite end is dotted: it has no values in between and only
    /// shows where the front continues.
    fn draw_front(&self, drawing: &mut Drawing, plot: &Plot<'_>) {
        for leg in self.front.windows(2) {
            let ends = [leg[0], leg[1]];
            let [Some(from), Some(to)] = ends.map(|[x, y]| plot.spot(x, y)) else { continue };
            let is_finite = ends.iter().flatten().all(|value| value.is_finite());
            drawing.line(&[from, to], if is_finite { Stroke::dashed(palette::FAINT_TEXT, 1.5) } else { BEYOND });
        }
    }
}

const RULE: Stroke = Stroke { ink: Ink::opaque([60, 60, 60]), width: 1.5, dash: Some([8.0, 4.0]) };
const BEYOND: Stroke = Stroke { ink: palette::FAINT_LINE, width: 1.2, dash: Some([1.5, 3.5]) };

struct Plot<'a> {
    x: &'a Axis,
    y: &'a Axis,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Plot<'_> {
    fn at(&self, x: f64, y: f64) -> Spot {
        [self.left + (self.right - self.left) * x, self.bottom - (self.bottom - self.top) * y]
    }

    fn spot(&self, x: f64, y: f64) -> Option<Spot> {
        Some(self.at(self.x.place(x)?, self.y.place(y)?))
    }

    fn bars(&self, drawing: &mut Drawing, series: &Series) {
        let places: Vec<Option<f64>> = series.marks.iter().map(|mark| self.x.place(mark.x)).collect();
        let step = places.windows(2).find_map(|pair| Some(pair[1]? - pair[0]?)).filter(|step| *step > 0.0);
        for (mark, place) in series.marks.iter().zip(&places) {
            let (Some(place), Some(top)) = (place, self.y.place(mark.y)) else { continue };
            let half = if mark.x.is_infinite() { 0.03 } else { step.unwrap_or(0.06) / 2.0 };
            let inset = 0.5 / (self.right - self.left);
            drawing.rectangle(self.at(place - half + inset, 0.0), self.at(place + half - inset, top), series.look.ink);
        }
    }

    fn lines(&self, drawing: &mut Drawing, series: &Series) {
        let width = match series.kind {
            Kind::Line => Some(1.8),
            Kind::Curve => Some(2.0),
            Kind::Thread => Some(0.9),
            Kind::Points | Kind::Bars => None,
        };
        if let Some(width) = width {
            // A line is interrupted at missing points; infinite and finite values are not joined.
            let joined = |a: &Mark, b: &Mark| {
                let alike = series.kind == Kind::Curve || a.y.is_finite() == b.y.is_finite();
                alike && self.spot(a.x, a.y).is_some() && self.spot(b.x, b.y).is_some()
            };
            for run in series.marks.chunk_by(joined) {
                let through: Vec<Spot> = run.iter().filter_map(|mark| self.spot(mark.x, mark.y)).collect();
                drawing.line(&through, series.look.stroke(width));
            }
        }
        for mark in &series.marks {
            let Some((low, high)) = mark.spread else { continue };
            let (Some(lower), Some(upper)) = (self.spot(mark.x, low), self.spot(mark.x, high)) else { continue };
            let stroke = Stroke::solid(series.look.ink, 1.2);
            drawing.line(&[lower, upper], stroke);
            // An error bar that is clipped at the border gets no cap.
            for (value, [x, end]) in [(low, lower), (high, upper)] {
                if self.y.holds(value) {
                    drawing.line(&[[x - CAP, end], [x + CAP, end]], stroke);
                }
            }
        }
    }

    fn grid(&self, drawing: &mut Drawing, upright: f64) {
        let Plot { x, y, left, right, top, bottom } = *self;
        let line = Stroke::solid(palette::GRID, 1.0);
        let beside = |label: &str| tick(label).anchor(Anchor::End);

        let mut written = f64::INFINITY;
        for (value, label) in &y.ticks {
            let Some(share) = y.place(*value) else { continue };
            let [_, height] = self.at(0.0, share);
            drawing.line(&[[left, height], [right, height]], line);
            if written - height >= TICK_EM {
                drawing.text_beside([left - 7.0, height], beside(label).fit(LONGEST_LABEL));
                written = height;
            }
        }
        if let (Some(name), Some(share)) = (&y.infinite, y.place(f64::INFINITY)) {
            let [_, height] = self.at(0.0, share);
            drawing.line(&[[left, height], [right, height]], Stroke::dashed(palette::MARK, 1.2));
            drawing.text_beside([left - 7.0, height], beside(name).ink(palette::MARK));
        }

        let under = |label: &str| tick(label).anchor(Anchor::Middle);
        let mut written = f64::NEG_INFINITY;
        for (value, label) in &x.ticks {
            let Some(share) = x.place(*value) else { continue };
            let [across, _] = self.at(share, 0.0);
            drawing.line(&[[across, top], [across, bottom]], line);
            let half = under(label).width() / 2.0;
            if upright > 0.0 && across - written >= TICK_EM {
                let text = tick(label).up().anchor(Anchor::End).fit(upright);
                drawing.text([across + TICK_EM * font::CAP_PER_EM / 2.0, bottom + 6.0], text);
                written = across;
            } else if upright <= 0.0 && across - half - written >= 5.0 {
                drawing.text([across, bottom + 5.0 + TICK_EM], under(label));
                written = across + half;
            }
        }
        if let (Some(name), Some(share)) = (&x.infinite, x.place(f64::INFINITY)) {
            let [across, _] = self.at(share, 0.0);
            drawing.text([across, bottom + 5.0 + TICK_EM], under(name).ink(palette::MARK));
        }

        drawing.line(&[[left, top], [left, bottom], [right, bottom]], Stroke::solid(palette::TEXT, 1.0));
        let lowest = f64::from(drawing.height) - MARGIN - 2.0;
        drawing.text([(left + right) / 2.0, lowest], name(&x.label, right - left + 60.0));
        drawing.text([MARGIN + NAME_EM, (top + bottom) / 2.0], name(&y.label, bottom - top + 40.0).up());
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
