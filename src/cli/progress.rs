//! Progress as a bar on a terminal or as lines for programs, and handling of Ctrl-C.

use std::io::{IsTerminal, Write};

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde::Serialize;

use crate::global::ProgressForm;
use crate::{GlobalArgs, refuse};
use codec::error::Result;
use codec::monitor::Monitor;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Minimum time between lines.
const PAUSE: Duration = Duration::from_millis(500);

/// Shows progress, and reports SIGINT and SIGTERM.
#[derive(Debug)]
pub struct Progress {
    /// Counts steps even if it is not drawn.
    bar: ProgressBar,
    lines: Option<Lines>,
    /// Stack of stages. The last is the current one; the others continue when it ends.
    stages: Mutex<Vec<Stage>>,
}

#[derive(Debug, Clone, Copy)]
struct Stage {
    name: &'static str,
    /// Number of steps done when a nested stage began, and number of all steps.
    steps: [u64; 2],
}

impl Progress {
    pub fn start(global: &GlobalArgs, what: &'static str, steps: u64) -> Result<Progress> {
        // The handler is set once per process.
        match ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed)) {
            Ok(()) | Err(ctrlc::Error::MultipleHandlers) => {}
            Err(error) => return refuse(format!("cannot set a handler for Ctrl-C: {error}")),
        }
        let is_drawn = global.progress == ProgressForm::Auto && !global.quiet && std::io::stderr().is_terminal();
        let target = if is_drawn { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {rate} eta {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .with_key("rate", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
                // Errors are not shown.
                let _ = text.write_str(&rate(state.per_sec()));
            });
        let bar = ProgressBar::with_draw_target(Some(steps), target).with_style(style).with_message(what);
        let lines = match global.progress {
            ProgressForm::Auto | ProgressForm::None => None,
            ProgressForm::Json => Some(LineForm::Json),
            ProgressForm::OpenJd if global.has_result_on_stdout => Some(LineForm::OpenJdOnStderr),
            ProgressForm::OpenJd => Some(LineForm::OpenJd),
        };
        let lines = lines.map(|form| Lines { form, begun: Instant::now(), last: Mutex::new(None) });
        let stages = Mutex::new(vec![Stage { name: what, steps: [0, steps] }]);
        let progress = Progress { bar, lines, stages };
        progress.tell(false);
        Ok(progress)
    }

    /// Sets the number of steps if it is known only after reading. Restarts the count at 0.
    pub fn set_steps(&self, steps: u64) {
        self.bar.set_length(steps);
        self.bar.set_position(0);
        self.bar.reset_eta();
    }

    fn tell(&self, is_last: bool) {
        if let Some(lines) = &self.lines {
            let stage = self.stages().last().map_or("", |stage| stage.name);
            lines.tell(stage, [self.bar.position(), self.bar.length().unwrap_or(0)], is_last);
        }
    }

    fn stages(&self) -> MutexGuard<'_, Vec<Stage>> {
        self.stages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Continues a stage.
    fn show(&self, Stage { name, steps: [done, total] }: Stage) {
        self.bar.set_message(name);
        self.bar.set_length(total);
        self.bar.set_position(done);
        self.bar.reset_eta();
        self.tell(true);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.tell(true);
        self.bar.finish_and_clear();
    }
}

impl Monitor for Progress {
    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
        self.tell(false);
    }

    fn begin_stage(&self, name: &'static str, steps: u64) {
        let stage = Stage { name, steps: [0, steps] };
        {
            let mut stages = self.stages();
            if let Some(before) = stages.last_mut() {
                before.steps = [self.bar.position(), self.bar.length().unwrap_or(0)];
            }
            stages.push(stage);
        }
        self.show(stage);
    }

    fn end_stage(&self) {
        self.tell(true);
        let before = {
            let mut stages = self.stages();
            if stages.len() < 2 {
                return;
            }
            stages.pop();
            stages.last().copied()
        };
        if let Some(before) = before {
            self.show(before);
        }
    }

    fn interrupted(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}

/// Progress as lines of text.
#[derive(Debug)]
struct Lines {
    form: LineForm,
    begun: Instant,
    last: Mutex<Option<Line>>,
}

/// A written line: its time, the stage, and its steps.
#[derive(Debug, Clone, Copy)]
struct Line {
    at: Instant,
    stage: &'static str,
    steps: [u64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LineForm {
    Json,
    OpenJd,
    OpenJdOnStderr,
}

#[derive(Serialize)]
struct JsonLine {
    stage: &'static str,
    done: u64,
    total: u64,
    seconds: f64,
}

impl Lines {
    /// Writes the progress of the stage, unless a line was written within [`PAUSE`]. The first line and, if it has
    /// changed, the last line are always written.
    fn tell(&self, stage: &'static str, steps: [u64; 2], is_last: bool) {
        // Other threads need not wait for the lock: only one of them writes.
        let guard = if is_last { self.last.lock().ok() } else { self.last.try_lock().ok() };
        let Some(mut last) = guard else { return };
        let is_due = last.is_none_or(|line| match is_last {
            true => (line.stage, line.steps) != (stage, steps),
            false => line.at.elapsed() >= PAUSE,
        });
        if !is_due {
            return;
        }
        *last = Some(Line { at: Instant::now(), stage, steps });
        let text = self.text(stage, steps);
        // Errors are ignored: progress is optional.
        let _ = match self.form {
            LineForm::OpenJd => std::io::stdout().lock().write_all(text.as_bytes()),
            LineForm::Json | LineForm::OpenJdOnStderr => std::io::stderr().lock().write_all(text.as_bytes()),
        };
    }

    fn text(&self, stage: &'static str, [done, total]: [u64; 2]) -> String {
        if self.form == LineForm::Json {
            let seconds = (self.begun.elapsed().as_secs_f64() * 1000.0).round() / 1000.0;
            let line = serde_json::to_string(&JsonLine { stage, done, total, seconds });
            return line.map_or_else(|_| String::new(), |line| line + "\n");
        }
        let percent = if total == 0 { 0.0 } else { 100.0 * done.min(total) as f64 / total as f64 };
        format!("openjd_progress: {percent:.1}\nopenjd_status: {stage} {done}/{total}\n")
    }
}

/// Monitor that interrupts work which will not finish in time.
pub struct Until<'a> {
    progress: &'a dyn Monitor,
    start: Instant,
    most: Option<Duration>,
    steps: u64,
    done: AtomicU64,
}

impl<'a> Until<'a> {
    pub fn new(progress: &'a dyn Monitor, most: Option<Duration>, steps: u64) -> Until<'a> {
        Until { progress, start: Instant::now(), most, steps, done: AtomicU64::new(0) }
    }

    /// True if the time is exceeded, or will be at the rate of the steps so far.
    fn is_late(&self) -> bool {
        let Some(most) = self.most else { return false };
        let (spent, done) = (self.start.elapsed(), self.done.load(Ordering::Relaxed));
        let all = spent.as_secs_f64() * self.steps as f64 / done.max(1) as f64;
        spent > most || (done > 0 && all > most.as_secs_f64())
    }
}

impl Monitor for Until<'_> {
    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        self.progress.advance(steps);
    }

    fn interrupted(&self) -> bool {
        self.progress.interrupted() || self.is_late()
    }
}

/// Formats steps per second, with one decimal if few: `0.4/s`, `35/s`.
fn rate(per_second: f64) -> String {
    if per_second < 9.95 { format!("{per_second:.1}/s") } else { format!("{per_second:.0}/s") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::monitor::Silent;

    #[test]
    fn rates_have_one_decimal_at_most() {
        assert_eq!(
            [0.0, 0.4321, 9.94, 9.97, 35.4321, 1234.5678].map(rate),
            ["0.0/s", "0.4/s", "9.9/s", "10/s", "35/s", "1235/s"]
        );
    }

    #[test]
    fn lines_tell_stage_and_steps() {
        let lines = |form| Lines { form, begun: Instant::now(), last: Mutex::new(None) };
        let json: serde_json::Value = serde_json::from_str(&lines(LineForm::Json).text("encoding", [12, 96])).unwrap();
        assert_eq!((&json["stage"], &json["done"], &json["total"]), (&"encoding".into(), &12.into(), &96.into()));
        assert!(json["seconds"].as_f64().is_some_and(|seconds| seconds >= 0.0));
        let openjd = lines(LineForm::OpenJd);
        assert_eq!(openjd.text("encoding", [12, 96]), "openjd_progress: 12.5\nopenjd_status: encoding 12/96\n");
        assert_eq!(openjd.text("encoding", [0, 0]), "openjd_progress: 0.0\nopenjd_status: encoding 0/0\n");
    }

    #[test]
    fn what_will_be_late_is_stopped_after_its_first_step() {
        let until = |most: Option<u64>, steps: u64| {
            let start = Instant::now().checked_sub(Duration::from_secs(10)).unwrap();
            Until { progress: &Silent, start, most: most.map(Duration::from_secs), steps, done: AtomicU64::new(0) }
        };
        let of = until(Some(100), 50);
        assert!(!of.interrupted());
        of.advance(1);
        assert!(of.interrupted(), "50 steps of 10 s are more than 100 s");
        of.advance(9);
        assert!(!of.interrupted());
        assert!(until(Some(9), 50).interrupted());
        let free = until(None, 50);
        free.advance(1);
        assert!(!free.interrupted());
    }
}
