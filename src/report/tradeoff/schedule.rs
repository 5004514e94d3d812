//! The order of runs: a first pass over all points for what is not time, then rounds of one timed run of each point, every
//! other round backwards, so that a machine that becomes slower or faster does so for all points alike.
//!
//! With a budget the first pass begins with the ends of all axes and adds values between them, coarse to fine, as long as
//! what was measured so far says that all rounds will fit. A value is added with all of its grid, or not at all.

use std::collections::BTreeMap;

use super::bench::{Bench, Cost};
use super::point::Point;
use super::store::{Row, Store};
use super::study::{Axis, Study};
use crate::error::Result;
use crate::monitor::Monitor;

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Timed runs of each point.
    pub repeats: u32,
    /// Seconds that all of it may take.
    pub budget_seconds: Option<f64>,
}

/// What was measured in the end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// The studies, without the values that did not fit into the budget.
    pub studies: Vec<Study>,
    /// What was left out, a sentence each.
    pub left_out: Vec<String>,
}

/// Runs that [`measure`] advances its monitor by at most.
pub fn runs(studies: &[Study], extent: Extent, store: &Store) -> u64 {
    let missing = |point: &Point| match store.row(point) {
        None => u64::from(extent.repeats) + 1,
        Some(_) => u64::from(extent.repeats).saturating_sub(store.runs(point) as u64),
    };
    all_points(studies).iter().map(missing).sum()
}

/// Measures the points of studies, and keeps each finished run in the store.
pub fn measure(
    studies: &[Study],
    extent: Extent,
    bench: &mut Bench<'_>,
    store: &mut Store,
    monitor: &dyn Monitor,
) -> Result<Outcome> {
    let start = bench.now_seconds();
    let mut work = Work { bench, store, monitor, extent, start, costs: BTreeMap::new() };
    let outcome = match extent.budget_seconds {
        None => {
            for point in all_points(studies) {
                work.survey(&point, studies)?;
            }
            work.rounds(studies)?;
            Outcome { studies: studies.to_vec(), left_out: Vec::new() }
        }
        Some(budget) => work.within(budget, studies)?,
    };
    // Rows that were taken over may belong to other studies now.
    for row in &mut work.store.rows {
        let names = names_of(&row.measured.point, &outcome.studies);
        if !names.is_empty() {
            row.studies = names;
        }
    }
    work.store.save()?;
    Ok(outcome)
}

/// All points of studies, each once, in the order of the studies.
pub fn all_points(studies: &[Study]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for point in studies.iter().flat_map(Study::points) {
        if !points.contains(&point) {
            points.push(point);
        }
    }
    points
}

/// Names of the studies that a point belongs to.
fn names_of(point: &Point, studies: &[Study]) -> Vec<String> {
    studies.iter().filter(|study| study.points().contains(point)).map(|study| study.name.clone()).collect()
}

struct Work<'a, 'b> {
    bench: &'a mut Bench<'b>,
    store: &'a mut Store,
    monitor: &'a dyn Monitor,
    extent: Extent,
    start: f64,
    /// Of points that were surveyed just now.
    costs: BTreeMap<Point, Cost>,
}

impl Work<'_, '_> {
    fn elapsed(&self) -> f64 {
        self.bench.now_seconds() - self.start
    }

    /// Measures all of a point that is not time, unless that is known.
    fn survey(&mut self, point: &Point, studies: &[Study]) -> Result<()> {
        if self.store.row(point).is_some() {
            return Ok(());
        }
        self.monitor.check()?;
        let (measured, cost) = self.bench.survey(point)?;
        self.costs.insert(point.clone(), cost);
        let (studies, command) = (names_of(point, studies), self.bench.command(point));
        self.store.rows.push(Row { studies, measured, command, made_of: self.bench.made_of() });
        self.store.save()?;
        self.monitor.advance(1);
        Ok(())
    }

    /// Runs each point as often as it is to be, round by round.
    fn rounds(&mut self, studies: &[Study]) -> Result<Option<u32>> {
        let points = all_points(studies);
        for round in 1..=self.extent.repeats {
            let lacks = |store: &Store, point: &Point| store.runs(point) < round as usize;
            if let Some(budget) = self.extent.budget_seconds.filter(|_| round > 1) {
                let ahead: f64 =
                    points.iter().filter(|point| lacks(self.store, point)).map(|point| self.cost(point).run).sum();
                if self.elapsed() + ahead > budget {
                    return Ok(Some(round - 1));
                }
            }
            let mut order: Vec<&Point> = points.iter().collect();
            if round % 2 == 0 {
                order.reverse();
            }
            for point in order {
                if !lacks(self.store, point) {
                    continue;
                }
                self.monitor.check()?;
                let Some(pixels) = self.store.row(point).map(|row| row.measured.pixels) else { continue };
                let [encode, decode] = self.bench.time(point, pixels)?;
                if let Some(row) = self.store.row_mut(point) {
                    row.measured.encode.runs.push(encode);
                    row.measured.decode.runs.push(decode);
                }
                self.store.save()?;
                self.monitor.advance(1);
            }
        }
        Ok(None)
    }

    /// What a point takes: as measured, or the mean of what others of its kind took.
    fn cost(&self, point: &Point) -> Cost {
        if let Some(cost) = self.costs.get(point) {
            return *cost;
        }
        let alike: Vec<&Cost> =
            self.costs.iter().filter(|(other, _)| other.kind == point.kind).map(|(_, cost)| cost).collect();
        let mean = |of: fn(&Cost) -> f64| alike.iter().map(|cost| of(cost)).sum::<f64>() / alike.len().max(1) as f64;
        Cost { survey: mean(|cost| cost.survey), run: mean(|cost| cost.run) }
    }

    /// Seconds that points still take with so many runs of each.
    fn ahead(&self, points: &[Point], repeats: u32) -> f64 {
        let of = |point: &Point| {
            let cost = self.cost(point);
            let survey = if self.store.row(point).is_some() { 0.0 } else { cost.survey };
            survey + cost.run * f64::from(repeats.saturating_sub(self.store.runs(point) as u32))
        };
        points.iter().map(of).sum()
    }

    /// Surveys points if these and all before fit into the budget, with fewer runs of each where it must be.
    fn add(&mut self, points: &[Point], accepted: &mut Vec<Point>, budget: f64, studies: &[Study]) -> Result<bool> {
        let new: Vec<Point> = points.iter().filter(|point| !accepted.contains(point)).cloned().collect();
        let fits =
            |repeats: &u32| self.elapsed() + self.ahead(accepted, *repeats) + self.ahead(&new, *repeats) <= budget;
        let Some(repeats) = (1..=self.extent.repeats).rev().find(fits) else { return Ok(false) };
        self.extent.repeats = repeats;
        for point in &new {
            self.survey(point, studies)?;
        }
        accepted.extend(new);
        Ok(true)
    }

    fn within(&mut self, budget: f64, studies: &[Study]) -> Result<Outcome> {
        let asked = self.extent.repeats;
        let mut accepted: Vec<Point> = Vec::new();
        let mut grids: Vec<Grid<'_>> = Vec::new();
        let mut left_out = Vec::new();
        for study in studies {
            let grid = Grid::new(study);
            let points = grid.reduced().points();
            // One point tells what the others take. Nothing at all would be no answer, so the first study has its ends.
            if let Some(first) =
                points.first().filter(|first| self.store.row(first).is_none() && self.elapsed() < budget)
            {
                self.survey(first, studies)?;
            }
            if self.add(&points, &mut accepted, budget, studies)? {
                grids.push(grid);
            } else if grids.is_empty() {
                self.extent.repeats = 1;
                for point in &points {
                    self.survey(point, studies)?;
                }
                accepted.extend(points);
                grids.push(grid);
            } else {
                left_out.push(format!(
                    "Study {} was left out: its {} points did not fit into {budget} s.",
                    study.name,
                    study.points().len()
                ));
            }
        }
        while grids.iter().any(|grid| grid.next.is_some()) {
            for grid in &mut grids {
                let Some((axis, value)) = grid.next else { continue };
                grid.taken[axis][value] = true;
                let fits = self.add(&grid.reduced().points(), &mut accepted, budget, studies)?;
                grid.taken[axis][value] = fits;
                grid.tried[axis][value] = true;
                grid.advance(axis);
            }
        }
        for grid in &grids {
            left_out.extend(grid.missing(budget));
        }
        let studies: Vec<Study> = grids.iter().map(Grid::reduced).collect();
        let planned = self.extent.repeats;
        let repeats = self.rounds(&studies)?.unwrap_or(planned);
        if repeats < asked {
            let runs = if repeats == 1 { "a single run".to_owned() } else { format!("{repeats} runs") };
            left_out.push(format!(
                "Times are of {runs} of each point instead of {asked}: more did not fit into {budget} s."
            ));
        }
        Ok(Outcome { studies, left_out })
    }
}

/// A study in the making: which values of each axis are taken, and which were tried.
struct Grid<'a> {
    study: &'a Study,
    taken: Vec<Vec<bool>>,
    tried: Vec<Vec<bool>>,
    /// The axis and the value to be tried next.
    next: Option<(usize, usize)>,
}

impl<'a> Grid<'a> {
    /// The ends of each axis.
    fn new(study: &'a Study) -> Grid<'a> {
        let ends = |axis: &Axis| {
            let last = axis.values.len().saturating_sub(1);
            (0..axis.values.len()).map(|at| at == 0 || at == last).collect::<Vec<_>>()
        };
        let taken: Vec<Vec<bool>> = study.axes.iter().map(ends).collect();
        let mut grid = Grid { study, tried: taken.clone(), taken, next: None };
        grid.advance(study.axes.len().saturating_sub(1));
        grid
    }

    /// Finds what to try after a value of an axis: of the next axis that has any left, the value farthest from those tried.
    fn advance(&mut self, axis: usize) {
        let count = self.study.axes.len();
        self.next =
            (1..=count).map(|step| (axis + step) % count).find_map(|axis| Some((axis, farthest(&self.tried[axis])?)));
    }

    /// The study with the values that are taken.
    fn reduced(&self) -> Study {
        let axes = self.study.axes.iter().zip(&self.taken).map(|(axis, taken)| Axis {
            knob: axis.knob,
            values: axis
                .values
                .iter()
                .zip(taken)
                .filter(|(_, taken)| **taken)
                .map(|(value, _)| value.clone())
                .collect(),
        });
        Study { axes: axes.collect(), ..self.study.clone() }
    }

    fn missing(&self, budget: f64) -> impl Iterator<Item = String> {
        self.study.axes.iter().zip(&self.taken).filter_map(move |(axis, taken)| {
            let left: Vec<_> =
                axis.values.iter().zip(taken).filter(|(_, taken)| !**taken).map(|(value, _)| value.as_str()).collect();
            (!left.is_empty()).then(|| {
                format!("Study {}: {} {} did not fit into {budget} s.", self.study.name, axis.knob, left.join(", "))
            })
        })
    }
}

/// The middle of the longest stretch of values that were not tried.
fn farthest(tried: &[bool]) -> Option<usize> {
    let mut best: Option<(usize, usize)> = None;
    let mut at = 0;
    while at < tried.len() {
        let length = tried[at..].iter().take_while(|tried| !**tried).count();
        if length > 0 && best.is_none_or(|(_, longest)| length > longest) {
            best = Some((at, length));
        }
        at += length + 1;
    }
    best.map(|(start, length)| start + (length - 1) / 2)
}

#[cfg(test)]
mod tests;
