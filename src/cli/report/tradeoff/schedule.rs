//! Order of runs: first a survey of all points, then rounds of one timed run of each point. Every other round is in
//! reverse order, so that drift of the machine's speed affects all points alike.
//!
//! The default settings are the first point. With a budget, the surveys begin with the defaults and the ends of all
//! axes, and add values between them, coarse to fine, as long as two runs of each point are expected to fit: a single time
//! under load says little. A value is added for its whole grid, or not at all.

use std::collections::{BTreeMap, VecDeque};

use serde::Serialize;

use super::point::Point;
use super::runner::{Bench, Cost, Survey};
use super::store::{Store, StoredPoint};
use super::study::{Axis, Study, all_points};
use crate::child::Runner;
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Minimum number of runs of each point, if requested, before a budget is spent on more values.
const MIN_REPEATS: u32 = 2;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    pub repeats: u32,
    /// Time by which everything must be finished, in seconds since the program began.
    pub budget_seconds: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// The studies, without the values that did not fit into the budget.
    pub studies: Vec<Study>,
    pub left_out: Vec<String>,
    /// Points that failed. A later process tries them again.
    pub failed: Vec<FailedPoint>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailedPoint {
    pub point: String,
    pub error: String,
    /// True if the settings admit no result (see [`Bench::is_infeasible`]).
    pub is_infeasible: bool,
}

/// Returns the maximum number of runs by which [`measure`] advances its monitor.
pub fn runs(studies: &[Study], extent: Extent, store: &Store) -> u64 {
    let survey = |study: &Study| 1 + u64::from(extent.repeats.saturating_sub(study.sweep.survey_runs));
    let missing = |point: &Point| match store.row(point) {
        None => studies.first().map_or(0, survey),
        Some(_) => u64::from(extent.repeats).saturating_sub(store.runs(point) as u64),
    };
    all_points(studies).iter().map(missing).sum()
}

/// Measures the points of studies and saves each finished run to the store. A point that fails is left out. Fails with
/// the first error if every point fails.
pub fn measure<'a>(studies: &[Study], extent: Extent, lab: Lab<'a>, monitor: &'a dyn Monitor) -> Result<Schedule> {
    let mut work = Measurement {
        lab,
        monitor,
        extent,
        min_repeats: 1,
        known: BTreeMap::new(),
        failed: Vec::new(),
        is_prepared: false,
    };
    let (studies, left_out) = match extent.budget_seconds {
        None => {
            all_points(studies).iter().try_for_each(|point| work.survey(point, studies))?;
            work.rounds(studies)?;
            (studies.to_vec(), Vec::new())
        }
        Some(budget) => work.within(budget, studies)?,
    };
    let Measurement { lab: Lab { store, bench, .. }, failed, .. } = work;
    let told = failed.iter().map(|(point, error)| FailedPoint {
        point: point.to_string(),
        error: error.to_string(),
        is_infeasible: bench.is_infeasible(error),
    });
    let told = told.collect();
    if all_points(&studies).iter().all(|point| store.runs(point) == 0)
        && let Some((_, first)) = failed.into_iter().next()
    {
        return Err(first);
    }
    // Rows from an earlier file may belong to more studies now.
    for row in &mut store.rows {
        for name in names_of(&row.measured.point, &studies) {
            if !row.studies.contains(&name) {
                row.studies.push(name);
            }
        }
    }
    store.save()?;
    Ok(Schedule { studies, left_out, failed: told })
}

fn names_of(point: &Point, studies: &[Study]) -> Vec<String> {
    studies.iter().filter(|study| study.points().contains(point)).map(|study| study.name.clone()).collect()
}

pub struct Lab<'a> {
    pub runner: &'a dyn Runner,
    pub bench: &'a mut dyn Bench,
    pub store: &'a mut Store,
}

struct Measurement<'a> {
    lab: Lab<'a>,
    monitor: &'a dyn Monitor,
    extent: Extent,
    /// Number of runs of each point without which no further points are added.
    min_repeats: u32,
    known: BTreeMap<Point, Cost>,
    failed: Vec<(Point, Error)>,
    /// True if this process has measured anything.
    is_prepared: bool,
}

impl Measurement<'_> {
    fn elapsed(&self) -> f64 {
        self.lab.runner.now_seconds()
    }

    fn is_too_long(&self, seconds: f64) -> bool {
        self.extent.budget_seconds.is_some_and(|budget| self.elapsed() + seconds > budget)
    }

    fn has_failed(&self, point: &Point) -> bool {
        self.failed.iter().any(|(failed, _)| failed == point)
    }

    /// Records the error of a point. Interruption and I/O errors end the sweep.
    fn settle<T>(&mut self, point: &Point, done: Result<T>) -> Result<Option<T>> {
        match done {
            Ok(done) => Ok(Some(done)),
            Err(error @ (Error::Interrupted | Error::Io { .. })) => Err(error),
            Err(error) => {
                self.failed.push((point.clone(), error));
                Ok(None)
            }
        }
    }

    /// Surveys a point, unless it is surveyed already.
    fn survey(&mut self, point: &Point, studies: &[Study]) -> Result<()> {
        if self.lab.store.row(point).is_some() || self.has_failed(point) {
            return Ok(());
        }
        self.prepare()?;
        let done = self.lab.bench.survey(self.lab.runner, point);
        let Some(Survey { measured, cost }) = self.settle(point, done)? else {
            self.monitor.advance(u64::from(self.extent.repeats) + 1);
            return Ok(());
        };
        self.known.insert(point.clone(), cost);
        let Lab { bench, store, .. } = &mut self.lab;
        let (command, made_of) = (bench.command(point), bench.made_of());
        store.rows.push(StoredPoint { studies: names_of(point, studies), measured, command, made_of });
        store.save()?;
        self.monitor.advance(1);
        Ok(())
    }

    fn prepare(&mut self) -> Result<()> {
        self.monitor.check()?;
        if !self.is_prepared {
            self.lab.bench.prepare(self.lab.runner)?;
            self.is_prepared = true;
        }
        Ok(())
    }

    fn time(&mut self, point: &Point) -> Result<()> {
        let Some(row) = self.lab.store.row(point) else { return Ok(()) };
        let mut measured = row.measured.clone();
        self.prepare()?;
        let start = self.elapsed();
        let done = self.lab.bench.time(self.lab.runner, &mut measured);
        if self.settle(point, done)?.is_some() {
            let run = self.elapsed() - start;
            let cost = self.known.get(point).copied().or_else(|| self.lab.bench.cost(&measured));
            let survey = cost.map_or(run, |cost| cost.survey);
            self.known.insert(point.clone(), Cost { survey, run });
            if let Some(row) = self.lab.store.row_mut(point) {
                row.measured = measured;
            }
            self.lab.store.save()?;
        }
        self.monitor.advance(1);
        Ok(())
    }

    /// Runs each point up to the requested number of times, round by round, within the budget.
    fn rounds(&mut self, studies: &[Study]) -> Result<()> {
        let points = all_points(studies);
        for round in 1..=self.extent.repeats {
            let lacks = |point: &&Point| !self.has_failed(point) && self.lab.store.runs(point) < round as usize;
            let mut order: Vec<&Point> = points.iter().filter(lacks).collect();
            if round > 1 && self.is_too_long(order.iter().map(|point| self.estimate(point).run).sum()) {
                return Ok(());
            }
            if round % 2 == 0 {
                order.reverse();
            }
            for point in order {
                // At least one run of one point is always made, so that there is a result.
                let is_any = points.iter().any(|point| self.lab.store.runs(point) > 0);
                if !is_any || !self.is_too_long(self.estimate(point).run) {
                    self.time(point)?;
                }
            }
        }
        Ok(())
    }

    fn known_cost(&self, point: &Point) -> Option<Cost> {
        let earlier = || self.lab.bench.cost(&self.lab.store.row(point)?.measured);
        self.known.get(point).copied().or_else(earlier)
    }

    /// Returns the known cost of a point, or the mean cost of points of the same kind of stream, or of all points.
    fn estimate(&self, point: &Point) -> Cost {
        let mean = |alike: &dyn Fn(&Point) -> bool| {
            let points = self.lab.store.rows.iter().map(|row| &row.measured.point).filter(|other| alike(other));
            let costs: Vec<Cost> = points.filter_map(|point| self.known_cost(point)).collect();
            let mean = |of: fn(&Cost) -> f64| costs.iter().map(of).sum::<f64>() / costs.len() as f64;
            (!costs.is_empty()).then(|| Cost { survey: mean(|cost| cost.survey), run: mean(|cost| cost.run) })
        };
        let alike = || mean(&|other| other.stream == point.stream);
        self.known_cost(point).or_else(alike).or_else(|| mean(&|_| true)).unwrap_or_default()
    }

    /// Returns the estimated remaining seconds of points with `repeats` runs each.
    fn ahead(&self, points: &[Point], repeats: u32) -> f64 {
        let of = |point: &Point| {
            if self.has_failed(point) {
                return 0.0;
            }
            let (cost, runs) = (self.estimate(point), repeats.saturating_sub(self.lab.store.runs(point) as u32));
            let survey = if self.lab.store.row(point).is_some() { 0.0 } else { cost.survey };
            survey + cost.run * f64::from(runs)
        };
        points.iter().map(of).sum()
    }

    /// Returns the number of runs per point with which the new and the accepted points fit into the budget. New points
    /// that are all measured already always fit.
    fn repeats_that_fit(&self, new: &[Point], accepted: &[Point]) -> Option<u32> {
        let fits = |repeats: &u32| !self.is_too_long(self.ahead(accepted, *repeats) + self.ahead(new, *repeats));
        let is_there = |point: &Point| self.has_failed(point) || self.lab.store.runs(point) > 0;
        let there = new.iter().all(is_there).then_some(1);
        (self.min_repeats..=self.extent.repeats).rev().find(fits).or(there)
    }

    /// Surveys points if they and all accepted points fit into the budget, if necessary with fewer runs of each.
    /// Returns false if they do not fit.
    fn add(&mut self, points: &[Point], accepted: &mut Vec<Point>, studies: &[Study]) -> Result<bool> {
        let new: Vec<Point> = points.iter().filter(|point| !accepted.contains(point)).cloned().collect();
        let before = self.extent.repeats;
        loop {
            // Each surveyed point improves the estimate.
            let Some(repeats) = self.repeats_that_fit(&new, accepted) else {
                self.extent.repeats = before;
                return Ok(false);
            };
            self.extent.repeats = repeats;
            let lacks = |point: &&Point| self.lab.store.row(point).is_none() && !self.has_failed(point);
            let Some(next) = new.iter().find(lacks) else { break };
            self.survey(next, studies)?;
        }
        accepted.extend(new);
        Ok(true)
    }

    /// Measures the cost of points with the first one that does not fail, and returns that point.
    fn probe(&mut self, points: &[Point], studies: &[Study]) -> Result<Option<Point>> {
        for (at, point) in points.iter().enumerate() {
            if at > 0 && self.is_too_long(0.0) {
                break;
            }
            self.survey(point, studies)?;
            if self.known_cost(point).is_none() && !self.has_failed(point) {
                self.time(point)?;
            }
            if self.known_cost(point).is_some() {
                return Ok(Some(point.clone()));
            }
        }
        Ok(None)
    }

    fn within(&mut self, budget: f64, studies: &[Study]) -> Result<(Vec<Study>, Vec<String>)> {
        let asked = self.extent.repeats;
        let mut accepted: Vec<Point> = Vec::new();
        let mut grids: Vec<Grid<'_>> = Vec::new();
        let mut left_out = Vec::new();
        for study in studies {
            let is_end = |axis: &Axis, at| at == 0 || at + 1 == axis.values.len() || Some(at) == study.default_at(axis);
            let mut grid = Grid::new(study, is_end);
            let points = all_points(&[grid.reduced()]);
            let is_first = grids.is_empty();
            let hopeful = is_first || self.repeats_that_fit(&points, &accepted).is_some();
            let probed = if hopeful { self.probe(&points, studies)? } else { None };
            if self.add(&points, &mut accepted, studies)? {
                grids.push(grid);
            } else if let Some(point) = probed.filter(|_| is_first) {
                // The first study always gets one point, so that there is a result.
                grid = Grid::new(study, |axis, at| point.value(axis.knob) == Some(&axis.values[at]));
                if !self.add(std::slice::from_ref(&point), &mut accepted, studies)? {
                    self.extent.repeats = 1;
                    accepted.push(point);
                }
                grids.push(grid);
            } else {
                left_out.push(format!(
                    "Study {} was left out: its {} points did not fit into {budget} s.",
                    study.name,
                    study.points().len()
                ));
            }
        }
        self.min_repeats = asked.min(MIN_REPEATS);
        while grids.iter().any(|grid| !grid.next.is_empty()) {
            for grid in &mut grids {
                let Some((axis, value)) = grid.next.pop_front() else { continue };
                grid.taken[axis][value] = true;
                grid.taken[axis][value] = self.add(&grid.reduced().points(), &mut accepted, studies)?;
            }
        }
        left_out.extend(grids.iter().flat_map(|grid| grid.missing(budget)));
        let studies: Vec<Study> = grids.iter().map(Grid::reduced).collect();
        self.rounds(&studies)?;
        left_out.extend(self.shortfall(&studies, asked, budget));
        Ok((studies, left_out))
    }

    /// Returns sentences that describe the runs omitted because of the budget.
    fn shortfall(&self, studies: &[Study], asked: u32, budget: f64) -> Vec<String> {
        let mut told = Vec::new();
        let points = all_points(studies).into_iter().filter(|point| !self.has_failed(point));
        let (timed, untimed): (Vec<Point>, Vec<Point>) = points.partition(|point| self.lab.store.runs(point) > 0);
        if !untimed.is_empty() {
            let names: Vec<String> = untimed.iter().map(Point::to_string).collect();
            told.push(format!("Not timed, since it did not fit into {budget} s: {}.", names.join("; ")));
        }
        let runs = || timed.iter().map(|point| self.lab.store.runs(point).min(asked as usize));
        if let (Some(least), Some(most)) = (runs().min(), runs().max())
            && least < asked as usize
        {
            let runs = match (least, most) {
                (1, 1) => "a single run".to_owned(),
                _ if least == most => format!("{least} runs"),
                _ => format!("{least} to {most} runs"),
            };
            told.push(format!(
                "Times are of {runs} of each point instead of {asked}: more did not fit into {budget} s."
            ));
        }
        if self.is_prepared && self.is_too_long(0.0) {
            told.push(format!("It took {:.1} s instead of {budget} s.", self.elapsed()));
        }
        told
    }
}

/// Study under construction: the values of each axis that are taken, and those to try, coarse to fine.
struct Grid<'a> {
    study: &'a Study,
    taken: Vec<Vec<bool>>,
    /// Indices of axes and values.
    next: VecDeque<(usize, usize)>,
}

impl<'a> Grid<'a> {
    fn new(study: &'a Study, chosen: impl Fn(&Axis, usize) -> bool) -> Grid<'a> {
        let of_axis = |axis: &Axis| (0..axis.values.len()).map(|at| chosen(axis, at)).collect();
        let taken: Vec<Vec<bool>> = study.axes.iter().map(of_axis).collect();
        let (count, mut tried, mut next) = (taken.len(), taken.clone(), VecDeque::new());
        // After a value of an axis, the untried value farthest from the tried ones, on the next axis that has any.
        let mut order = (0..count).chain(0..count);
        while let Some((axis, value)) = order.find_map(|axis| Some((axis, farthest(&tried[axis])?))) {
            tried[axis][value] = true;
            next.push_back((axis, value));
            order = (axis + 1..count).chain(0..axis + 1);
        }
        Grid { study, taken, next }
    }

    fn axes(&self, are_taken: bool) -> impl Iterator<Item = Axis> {
        self.study.axes.iter().zip(&self.taken).map(move |(axis, taken)| {
            let values = axis.values.iter().zip(taken).filter(|(_, taken)| **taken == are_taken);
            Axis { knob: axis.knob, values: values.map(|(value, _)| value.clone()).collect() }
        })
    }

    fn reduced(&self) -> Study {
        Study { axes: self.axes(true).collect(), ..self.study.clone() }
    }

    fn missing(&self, budget: f64) -> impl Iterator<Item = String> {
        self.axes(false).filter(|axis| !axis.values.is_empty()).map(move |Axis { knob, values }| {
            format!("Study {}: {knob} {} did not fit into {budget} s.", self.study.name, values.join(", "))
        })
    }
}

/// Returns the last value if it is untried, else the middle of the longest run of untried values.
fn farthest(tried: &[bool]) -> Option<usize> {
    if tried.last() == Some(&false) {
        return Some(tried.len() - 1);
    }
    let places: Vec<usize> = (0..tried.len()).collect();
    let runs = places.chunk_by(|a, b| tried[*a] == tried[*b]).filter(|run| !tried[run[0]]);
    // Of runs of equal length, takes the first.
    let longest = runs.rev().max_by_key(|run| run.len())?;
    Some(longest[(longest.len() - 1) / 2])
}

#[cfg(test)]
mod tests;
