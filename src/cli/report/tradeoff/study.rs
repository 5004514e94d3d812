//! Grids of knob values, and the results of measuring them.

use serde::{Serialize, Serializer};

use super::kind::SweepKind;
use super::point::{Measured, Point, Setting, number};
use codec::image::StreamKind;

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Axis {
    pub knob: &'static str,
    pub values: Vec<String>,
}

impl Axis {
    /// Returns the values as numbers (`16`, `0.1%`). `None` if any value is not a number.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(|value| number(value)).collect()
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// Short name for files: lower case, words joined by hyphens, unique among the studies of a report.
    pub name: String,
    pub title: String,
    #[serde(skip)]
    pub sweep: &'static SweepKind,
    #[serde(rename = "kind", serialize_with = "stream_name")]
    pub stream: Option<StreamKind>,
    /// Varied knobs. The first two with more than one value are the axes of heat maps.
    pub axes: Vec<Axis>,
    /// Settings of all points that differ from the defaults.
    #[serde(serialize_with = "as_map")]
    pub fixed: Vec<Setting>,
}

fn stream_name<S: Serializer>(stream: &Option<StreamKind>, to: S) -> Result<S::Ok, S::Error> {
    stream.map(StreamKind::name).serialize(to)
}

fn as_map<S: Serializer>(settings: &[Setting], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(settings.iter().map(|(name, value)| (name, value)))
}

impl Study {
    /// Returns all points; the last axis varies fastest.
    pub fn points(&self) -> Vec<Point> {
        let grid = product(&self.fixed, &self.axes);
        grid.into_iter().map(|settings| Point::new(self.sweep, self.stream, settings)).collect()
    }

    /// Returns the index of the knob's default among the values of its axis.
    pub fn default_at(&self, axis: &Axis) -> Option<usize> {
        let default = self.sweep.knob(axis.knob)?.default;
        let is_default =
            |value: &String| value == default || number(value).is_some_and(|of| number(default) == Some(of));
        axis.values.iter().position(is_default)
    }

    /// Returns the point of the default settings, if the grid contains it.
    pub fn default_point(&self) -> Option<Point> {
        let at_default = |axis: &Axis| {
            let value = axis.values[self.default_at(axis)?].clone();
            Some(Axis { knob: axis.knob, values: vec![value] })
        };
        let axes = self.axes.iter().map(at_default).collect::<Option<Vec<Axis>>>()?;
        Study { axes, ..self.clone() }.points().into_iter().next()
    }

    pub fn varied(&self) -> Vec<&Axis> {
        self.axes.iter().filter(|axis| axis.values.len() > 1).collect()
    }

    pub fn label(&self, axis: &Axis) -> &'static str {
        self.sweep.knob(axis.knob).map_or(axis.knob, |knob| knob.label)
    }
}

pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Returns all points of studies, each once: those of the default settings first, then in the order of the studies.
pub fn all_points(studies: &[Study]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for point in studies.iter().filter_map(Study::default_point).chain(studies.iter().flat_map(Study::points)) {
        if !points.contains(&point) {
            points.push(point);
        }
    }
    points
}

/// Returns the Cartesian product of the axes' values, appended to `settings`; the last axis varies fastest.
pub fn product<'a>(settings: &[Setting], axes: impl IntoIterator<Item = &'a Axis>) -> Vec<Vec<Setting>> {
    axes.into_iter().fold(vec![settings.to_vec()], |grid, axis| {
        let with = |settings: &Vec<Setting>, value: &String| {
            settings.iter().cloned().chain([(axis.knob, value.clone())]).collect::<Vec<_>>()
        };
        grid.iter().flat_map(|settings| axis.values.iter().map(move |value| with(settings, value))).collect()
    })
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Weights {
    pub compression: f64,
    pub decoding: f64,
}

impl Default for Weights {
    /// Weights of CALF figures 7 and 8.
    fn default() -> Weights {
        Weights { compression: 0.25, decoding: 0.75 }
    }
}

#[derive(Debug, Clone, Serialize)]
pub struct Results {
    #[serde(skip)]
    pub sweep: &'static SweepKind,
    pub input: String,
    #[serde(skip)]
    pub about: String,
    pub command_line: String,
    pub machine: String,
    pub studies: Vec<Study>,
    #[serde(skip)]
    pub measured: Vec<Measured>,
    /// Commands of the measured points, in their order; fewer if they are not known.
    #[serde(skip)]
    pub point_commands: Vec<String>,
    pub left_out: Vec<String>,
    pub weights: Weights,
    /// Example commands, by what they make.
    #[serde(skip)]
    pub commands: Vec<(&'static str, String)>,
}

impl Results {
    pub fn of(&self, point: &Point) -> Option<&Measured> {
        self.measured.iter().find(|measured| measured.point == *point)
    }

    /// Returns the command that makes a measured point, where it is known.
    pub fn command_of(&self, point: &Measured) -> Option<&str> {
        let at = self.measured.iter().position(|of| of.point == point.point)?;
        self.point_commands.get(at).map(String::as_str).filter(|line| !line.is_empty())
    }

    /// Returns the kinds of streams of the points, in order. `None` stands for points without a stream.
    pub fn streams(&self) -> Vec<Option<StreamKind>> {
        let all = StreamKind::ALL.into_iter().map(Some).chain([None]);
        all.filter(|stream| self.measured.iter().any(|of| of.point.stream == *stream)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::point::words;

    #[test]
    fn a_product_has_every_value_with_every_other_the_last_axis_fastest() {
        let axis =
            |knob, values: &[&str]| Axis { knob, values: values.iter().map(|value| value.to_string()).collect() };
        let axes = [axis("max-error", &["1", "2"]), axis("depth-tile", &["3", "4"])];
        let all = product(&[("effort", "fast".to_owned())], &axes);
        let all: Vec<_> = all.iter().filter_map(|settings| words(settings)).collect();
        assert_eq!(
            all.join(", "),
            "effort=fast max-error=1 depth-tile=3, effort=fast max-error=1 depth-tile=4, \
            effort=fast max-error=2 depth-tile=3, effort=fast max-error=2 depth-tile=4"
        );
        assert_eq!(product(&[], &[] as &[Axis]), [vec![]]);
        assert!(product(&[], &[axis("max-error", &[])]).is_empty());
    }
}
