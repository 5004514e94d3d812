//! The order of runs: a first pass over all points for what is not time, then rounds of one timed run of each point, every
//! other round backwards, so that a machine that becomes slower or faster does so for all points alike.
//!
//! With a budget the first pass begins with the ends of all axes and adds values between them, coarse to fine, as long as
//! what was measured so far says that all rounds will fit. A value is added with all of its grid, or not at all.

use std::collections::BTreeMap;

use super::bench::Bench;
use super::point::Point;
use super::store::{Row, Store};
use super::study::{Axis, Study};
use crate::error::{Error, Result};
use crate::monitor::Monitor;

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Timed runs of each point.
    pub repeats: u32,
    /// When all of it is to be done, in seconds since the program began.
    pub budget_seconds: Option<f64>,
}

/// What was measured in the end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// The studies, without the values that did not fit into the budget.
    pub studies: Vec<Study>,
    /// What was left out, a sentence each.
    pub left_out: Vec<String>,
    /// Points that failed, and what was said of it. The next time they are tried again.
    pub failed: Vec<(Point, String)>,
}

/// Runs that [`measure`] advances its monitor by at most.
pub fn runs(studies: &[Study], extent: Extent, store: &Store) -> u64 {
    let missing = |point: &Point| match store.row(point) {
        None => u64::from(extent.repeats) + 1,
        Some(_) => u64::from(extent.repeats).saturating_sub(store.runs(point) as u64),
    };
    all_points(studies).iter().map(missing).sum()
}

/// Measures the points of studies, and keeps each finished run in the store. A point that fails leaves a hole.
///
/// # Errors
/// When the user asks to stop, when the store or a process fails, and when every point did: then what the first one said.
pub fn measure(
    studies: &[Study],
    extent: Extent,
    bench: &mut Bench<'_>,
    store: &mut Store,
    monitor: &dyn Monitor,
) -> Result<Outcome> {
    let mut work = Work {
        bench,
        store,
        monitor,
        extent,
        surveys: BTreeMap::new(),
        runs: BTreeMap::new(),
        failed: Vec::new(),
        did_anything: false,
    };
    let (studies, left_out) = match extent.budget_seconds {
        None => {
            for point in all_points(studies) {
                work.survey(&point, studies)?;
            }
            work.rounds(studies)?;
            (studies.to_vec(), Vec::new())
        }
        Some(budget) => work.within(budget, studies)?,
    };
    let Work { store, failed, .. } = work;
    let told = failed.iter().map(|(point, error)| (point.clone(), error.to_string())).collect();
    if all_points(&studies).iter().all(|point| store.runs(point) == 0)
        && let Some((_, first)) = failed.into_iter().next()
    {
        return Err(first);
    }
    // Rows that were taken over may belong to more studies now.
    for row in &mut store.rows {
        for name in names_of(&row.measured.point, &studies) {
            if !row.studies.contains(&name) {
                row.studies.push(name);
            }
        }
    }
    store.save()?;
    Ok(Outcome { studies, left_out, failed: told })
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
    /// Seconds that the first pass took, of points of which it was done just now.
    surveys: BTreeMap<Point, f64>,
    /// Seconds that a timed run takes, of the same points and those that were timed just now.
    runs: BTreeMap<Point, f64>,
    /// Points that failed.
    failed: Vec<(Point, Error)>,
    /// Whether any point was surveyed or timed just now.
    did_anything: bool,
}

impl Work<'_, '_> {
    fn elapsed(&self) -> f64 {
        self.bench.now_seconds()
    }

    /// Whether so many seconds more are too many.
    fn is_too_long(&self, seconds: f64) -> bool {
        self.extent.budget_seconds.is_some_and(|budget| self.elapsed() + seconds > budget)
    }

    fn has_failed(&self, point: &Point) -> bool {
        self.failed.iter().any(|(failed, _)| failed == point)
    }

    /// Keeps the error of a point; those that are not the point's own end everything.
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

    /// Measures all of a point that is not time, unless that is known.
    fn survey(&mut self, point: &Point, studies: &[Study]) -> Result<()> {
        if self.store.row(point).is_some() || self.has_failed(point) {
            return Ok(());
        }
        self.monitor.check()?;
        self.did_anything = true;
        let done = self.bench.survey(point);
        let Some((measured, cost)) = self.settle(point, done)? else {
            self.monitor.advance(u64::from(self.extent.repeats) + 1);
            return Ok(());
        };
        self.surveys.insert(point.clone(), cost.survey);
        self.runs.insert(point.clone(), cost.run);
        let (studies, command) = (names_of(point, studies), self.bench.command(point));
        self.store.rows.push(Row { studies, measured, command, made_of: self.bench.made_of() });
        self.store.save()?;
        self.monitor.advance(1);
        Ok(())
    }

    /// One timed run of a point that was surveyed.
    fn time(&mut self, point: &Point) -> Result<()> {
        self.monitor.check()?;
        let Some(passes) = self.store.row(point).map(|row| row.measured.decode_passes) else { return Ok(()) };
        self.did_anything = true;
        let start = self.elapsed();
        let done = self.bench.time(point, passes);
        if let Some([encode, decode]) = self.settle(point, done)? {
            self.runs.insert(point.clone(), self.elapsed() - start);
            if let Some(row) = self.store.row_mut(point) {
                row.measured.encode.runs.push(encode);
                row.measured.decode.runs.push(decode);
            }
            self.store.save()?;
        }
        self.monitor.advance(1);
        Ok(())
    }

    /// Runs each point as often as it is to be, round by round, as far as the budget goes.
    fn rounds(&mut self, studies: &[Study]) -> Result<()> {
        let points = all_points(studies);
        for round in 1..=self.extent.repeats {
            let lacks = |point: &&Point| !self.has_failed(point) && self.store.runs(point) < round as usize;
            let mut order: Vec<&Point> = points.iter().filter(lacks).collect();
            if round > 1 && self.is_too_long(order.iter().map(|point| self.run_seconds(point)).sum()) {
                return Ok(());
            }
            if round % 2 == 0 {
                order.reverse();
            }
            for point in order {
                // One run of one point there is always: nothing at all would be no answer.
                let is_any = points.iter().any(|point| self.store.runs(point) > 0);
                if !is_any || !self.is_too_long(self.run_seconds(point)) {
                    self.time(point)?;
                }
            }
        }
        Ok(())
    }

    /// Seconds of a timed run of a point, where they are known: from just now, or from the medians of a run before.
    fn known_run(&self, point: &Point) -> Option<f64> {
        let kept = || {
            let measured = &self.store.row(point)?.measured;
            let passes = f64::from(measured.decode_passes) + 1.0;
            Some(measured.encode.median()? + measured.decode.median()? * passes)
        };
        self.runs.get(point).copied().or_else(kept)
    }

    /// Seconds of the first pass of a point, likewise.
    fn known_survey(&self, point: &Point) -> Option<f64> {
        let kept = || {
            let measured = &self.store.row(point)?.measured;
            // It encodes twice or more, compares and packs; each takes about as long.
            Some(measured.encode.median()? * 4.0 + measured.decode.median()? * 2.0)
        };
        self.surveys.get(point).copied().or_else(kept)
    }

    fn run_seconds(&self, point: &Point) -> f64 {
        self.estimate(point, |point| self.known_run(point))
    }

    /// What a point takes: as known, or the mean of what others of its kind took, or of any kind.
    fn estimate(&self, point: &Point, known: impl Fn(&Point) -> Option<f64>) -> f64 {
        let mean = |alike: &dyn Fn(&Point) -> bool| {
            let points = self.store.rows.iter().map(|row| &row.measured.point).filter(|other| alike(other));
            let seconds: Vec<f64> = points.filter_map(&known).collect();
            (!seconds.is_empty()).then(|| seconds.iter().sum::<f64>() / seconds.len() as f64)
        };
        let of_kind = || mean(&|other| other.kind == point.kind);
        known(point).or_else(of_kind).or_else(|| mean(&|_| true)).unwrap_or(0.0)
    }

    /// Seconds that points still take with so many runs of each.
    fn ahead(&self, points: &[Point], repeats: u32) -> f64 {
        let of = |point: &Point| {
            if self.has_failed(point) {
                return 0.0;
            }
            let survey = match self.store.row(point) {
                Some(_) => 0.0,
                None => self.estimate(point, |point| self.known_survey(point)),
            };
            match repeats.saturating_sub(self.store.runs(point) as u32) {
                0 => survey,
                runs => survey + self.run_seconds(point) * f64::from(runs),
            }
        };
        points.iter().map(of).sum()
    }

    /// Whether nothing of a point has to be measured for it to have one run.
    fn is_there(&self, point: &Point) -> bool {
        self.has_failed(point) || self.store.runs(point) > 0
    }

    /// Runs of each point with which points, and those accepted before, fit into the budget. What is there already does.
    fn repeats_that_fit(&self, new: &[Point], accepted: &[Point]) -> Option<u32> {
        let fits = |repeats: &u32| !self.is_too_long(self.ahead(accepted, *repeats) + self.ahead(new, *repeats));
        let there = new.iter().all(|point| self.is_there(point)).then_some(1);
        (1..=self.extent.repeats).rev().find(fits).or(there)
    }

    /// Surveys points if these and all before fit into the budget, with fewer runs of each where it must be.
    fn add(&mut self, points: &[Point], accepted: &mut Vec<Point>, studies: &[Study]) -> Result<bool> {
        let new: Vec<Point> = points.iter().filter(|point| !accepted.contains(point)).cloned().collect();
        let before = self.extent.repeats;
        loop {
            // Each point that is surveyed tells more.
            let Some(repeats) = self.repeats_that_fit(&new, accepted) else {
                self.extent.repeats = before;
                return Ok(false);
            };
            self.extent.repeats = repeats;
            let lacks = |point: &&Point| self.store.row(point).is_none() && !self.has_failed(point);
            let Some(next) = new.iter().find(lacks) else { break };
            self.survey(next, studies)?;
        }
        accepted.extend(new);
        Ok(true)
    }

    /// Finds out what points take, by the first of them that does not fail; returns it.
    fn probe(&mut self, points: &[Point], studies: &[Study]) -> Result<Option<Point>> {
        for (at, point) in points.iter().enumerate() {
            if at > 0 && self.is_too_long(0.0) {
                break;
            }
            self.survey(point, studies)?;
            if self.known_run(point).is_none() && !self.has_failed(point) {
                self.time(point)?;
            }
            if self.known_run(point).is_some() {
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
            let mut grid = Grid::new(study);
            let points = grid.reduced().points();
            let is_first = grids.is_empty();
            let hopeful = is_first || self.repeats_that_fit(&points, &accepted).is_some();
            let probed = if hopeful { self.probe(&points, studies)? } else { None };
            if self.add(&points, &mut accepted, studies)? {
                grids.push(grid);
            } else if let Some(point) = probed.filter(|_| is_first) {
                // Nothing at all would be no answer, so the first study has one point.
                grid.only(&point);
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
        while grids.iter().any(|grid| grid.next.is_some()) {
            for grid in &mut grids {
                let Some((axis, value)) = grid.next else { continue };
                grid.taken[axis][value] = true;
                let fits = self.add(&grid.reduced().points(), &mut accepted, studies)?;
                grid.taken[axis][value] = fits;
                grid.tried[axis][value] = true;
                grid.advance(axis);
            }
        }
        for grid in &grids {
            left_out.extend(grid.missing(budget));
        }
        let studies: Vec<Study> = grids.iter().map(Grid::reduced).collect();
        self.rounds(&studies)?;
        left_out.extend(self.shortfall(&studies, asked, budget));
        Ok((studies, left_out))
    }

    /// What the budget left of the rounds, in sentences.
    fn shortfall(&self, studies: &[Study], asked: u32, budget: f64) -> Vec<String> {
        let mut told = Vec::new();
        let points: Vec<Point> = all_points(studies).into_iter().filter(|point| !self.has_failed(point)).collect();
        let (timed, untimed): (Vec<&Point>, Vec<&Point>) = points.iter().partition(|point| self.store.runs(point) > 0);
        if !untimed.is_empty() {
            let names: Vec<String> = untimed.iter().map(|point| point.to_string()).collect();
            told.push(format!("Not timed, since it did not fit into {budget} s: {}.", names.join("; ")));
        }
        let runs = || timed.iter().map(|point| self.store.runs(point).min(asked as usize));
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
        if self.did_anything && self.is_too_long(0.0) {
            told.push(format!("It took {:.1} s instead of {budget} s.", self.elapsed()));
        }
        told
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

    /// Nothing but a point.
    fn only(&mut self, point: &Point) {
        let of = |axis: &Axis| axis.values.iter().map(|value| point.value(axis.knob) == Some(value)).collect();
        self.taken = self.study.axes.iter().map(of).collect();
        self.tried = self.taken.clone();
        self.advance(self.study.axes.len().saturating_sub(1));
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

/// The last value, or else the middle of the longest stretch of values that were not tried.
fn farthest(tried: &[bool]) -> Option<usize> {
    if tried.last() == Some(&false) {
        return Some(tried.len() - 1);
    }
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
