//! Tile statistics, within a share of the time budget.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::input::Footage;
use crate::GlobalArgs;
use crate::progress::Progress;
use codec::depth::tile_psnr::TilePsnr;
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use footage::encode::tile_quality;

/// Share of the budget that the statistics may take. The points get the rest.
const SHARE: f64 = 1.0 / 3.0;

/// Message for statistics omitted for lack of time.
const LATE: &str = "The statistics of tiles were left out: they did not fit into a third of the budget.";

/// Monitor that interrupts work which will not finish in time.
struct Until<'a> {
    progress: &'a dyn Monitor,
    start: Instant,
    most: Option<Duration>,
    steps: u64,
    done: AtomicU64,
}

impl Until<'_> {
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

/// Measures the PSNR of all depth tiles by modelling function. The inner error states why there is no result.
pub fn measure(
    footage: &Footage,
    budget_seconds: Option<f64>,
    global: &GlobalArgs,
) -> Result<Result<TilePsnr, String>> {
    let steps = tile_quality::images(&footage.source);
    let progress = Progress::start(global, "modelling tiles", steps)?;
    let most = budget_seconds.map(|seconds| Duration::from_secs_f64((seconds * SHARE).min(1e9)));
    let until = Until { progress: &progress, start: Instant::now(), most, steps, done: AtomicU64::new(0) };
    match tile_quality::measure(&footage.source, &footage.tiles, &until) {
        Ok(tiles) => Ok(Ok(tiles)),
        Err(Error::Interrupted) if progress.interrupted() => Err(Error::Interrupted),
        Err(Error::Interrupted) => Ok(Err(LATE.to_owned())),
        Err(error) => Ok(Err(format!("The statistics of tiles failed: {error}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::monitor::Silent;

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
