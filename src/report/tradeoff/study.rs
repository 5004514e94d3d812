//! Grids of knob values, and what came of measuring them.

use super::point::{Measured, Point};
use crate::dataset::stream::StreamKind;
use crate::depth::tile_psnr::TilePsnr;

/// A knob and the values that it is given in turn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// The knob's name.
    pub knob: &'static str,
    /// Values, in the order of reports.
    pub values: Vec<String>,
}

impl Axis {
    /// The values as numbers, where all of them are (`16`, `0.1%`).
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(|value| super::knob::number(value)).collect()
    }
}

/// A grid of settings for one kind of stream: every value of every axis with every value of the others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Study {
    /// A short name for files: lower case, words joined by hyphens, unique among the studies of a report.
    pub name: String,
    /// What is looked at, such as `Boxes of depth (CALF figure 7)`.
    pub title: String,
    /// The kind of stream.
    pub kind: StreamKind,
    /// What is varied; the first two with more than one value are those of heat maps.
    pub axes: Vec<Axis>,
    /// Settings of all points that are not usual ones.
    pub fixed: Vec<(&'static str, String)>,
}

impl Study {
    /// All points, the last axis fastest.
    pub fn points(&self) -> Vec<Point> {
        let grid = product(&self.fixed, &self.axes);
        grid.into_iter().map(|settings| Point::new(self.kind, settings)).collect()
    }

    /// The axes with more than one value.
    pub fn varied(&self) -> Vec<&Axis> {
        self.axes.iter().filter(|axis| axis.values.len() > 1).collect()
    }
}

/// Some settings with every value of every axis, the last axis fastest.
pub fn product<'a>(
    settings: &[(&'static str, String)],
    axes: impl IntoIterator<Item = &'a Axis>,
) -> Vec<Vec<(&'static str, String)>> {
    axes.into_iter().fold(vec![settings.to_vec()], |grid, axis| {
        let with = |settings: &Vec<(&'static str, String)>, value: &String| {
            settings.iter().cloned().chain([(axis.knob, value.clone())]).collect::<Vec<_>>()
        };
        grid.iter().flat_map(|settings| axis.values.iter().map(move |value| with(settings, value))).collect()
    })
}

/// How much size and decoding time count in a score; together 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Of bytes.
    pub compression: f64,
    /// Of decoding time.
    pub decoding: f64,
}

impl Default for Weights {
    /// Those of CALF's figures 7 and 8.
    fn default() -> Weights {
        Weights { compression: 0.25, decoding: 0.75 }
    }
}

/// All that a report shows.
#[derive(Debug, Clone)]
pub struct Results {
    /// The footage, as the user named it.
    pub input: String,
    /// The command line that made the report.
    pub command_line: String,
    /// The machine: processor, threads, memory, system, and the graphics device where one decoded.
    pub machine: String,
    /// What was swept. A point may belong to several studies.
    pub studies: Vec<Study>,
    /// What was measured of each point, each once.
    pub measured: Vec<Measured>,
    /// PSNR of tiles of depth by modelling function, where it was measured.
    pub tiles: Option<TilePsnr>,
    /// How those tiles were modelled, by the values of the options, such as `effort fast, domain log`; empty where they were
    /// not.
    pub tiles_how: String,
    /// What is missing, for want of time or because it failed, a sentence each.
    pub left_out: Vec<String>,
    /// Weights of the score.
    pub weights: Weights,
}

impl Results {
    /// What was measured of a point.
    pub fn of(&self, point: &Point) -> Option<&Measured> {
        self.measured.iter().find(|measured| measured.point == *point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_has_every_value_with_every_other_the_last_axis_fastest() {
        let axis =
            |knob, values: &[&str]| Axis { knob, values: values.iter().map(|value| value.to_string()).collect() };
        let axes = [axis("max-error", &["1", "2"]), axis("depth-tile", &["3", "4"])];
        let all = product(&[("effort", "fast".to_owned())], &axes);
        let all: Vec<_> = all.iter().filter_map(|settings| super::super::point::words(settings)).collect();
        assert_eq!(
            all.join(", "),
            "effort=fast max-error=1 depth-tile=3, effort=fast max-error=1 depth-tile=4, \
            effort=fast max-error=2 depth-tile=3, effort=fast max-error=2 depth-tile=4"
        );
        assert_eq!(product(&[], &[] as &[Axis]), [vec![]]);
        assert!(product(&[], &[axis("max-error", &[])]).is_empty());
    }
}
