//! Durations of stages.
//!
//! Some stages run scanline by scanline on the same threads: masks during acquisition; lines, winners and radiance during
//! interpolation. Threads measure the time that they spend in each stage, and elapsed time is divided in that proportion, so that
//! the durations of all stages add up to that of the run.

use std::time::{Duration, Instant};

use serde::Serialize;

use codec::math::add_members;
use footage::json;

/// A duration for each stage: elapsed time, or the sum over all threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Stages {
    /// Surfaces of source views, their radiance, and the choice of source positions (3.3.1).
    #[serde(serialize_with = "json::seconds")]
    pub acquire: Duration,
    /// Tests of which hidden surfaces an output view may see (3.4.1, 3.4.2).
    #[serde(serialize_with = "json::seconds")]
    pub mask: Duration,
    /// Conversion of active pixels to lines and runs of lines (3.3.2, 3.4.3).
    #[serde(serialize_with = "json::seconds")]
    pub filter: Duration,
    /// Winners of pixels (3.3.2), and assembly of views.
    #[serde(serialize_with = "json::seconds")]
    pub interpolate: Duration,
    /// Radiance of pixels, with highlights (3.5).
    #[serde(serialize_with = "json::seconds")]
    pub light: Duration,
    /// Filling of pixels that lines do not show (7.1).
    #[serde(serialize_with = "json::seconds")]
    pub fill: Duration,
}

add_members!(Stages: acquire, mask, filter, interpolate, light, fill);

impl Stages {
    pub fn sum(&self) -> Duration {
        let Stages { acquire, mask, filter, interpolate, light, fill } = *self;
        [acquire, mask, filter, interpolate, light, fill].into_iter().sum()
    }

    /// Returns the durations with acquisition and interpolation divided among the stages that run on the same threads, in
    /// proportion to the thread time of each.
    #[must_use]
    pub fn divided(self, threads: &Stages) -> Stages {
        let [acquire, mask] = shares(self.acquire, [threads.acquire, threads.mask]);
        let [interpolate, filter, light] =
            shares(self.interpolate, [threads.interpolate, threads.filter, threads.light]);
        Stages { acquire, mask, filter, interpolate, light, fill: self.fill }
    }
}

/// Divides a duration in proportion to others. If these are 0, the first part gets all of it.
fn shares<const N: usize>(whole: Duration, of: [Duration; N]) -> [Duration; N] {
    let sum = of.iter().sum::<Duration>().as_secs_f64();
    let mut shares = of.map(|part| if sum > 0.0 { whole.mul_f64(part.as_secs_f64() / sum) } else { Duration::ZERO });
    shares[0] = whole.saturating_sub(shares[1..].iter().sum());
    shares
}

/// Stopwatch that returns the time since its last reading.
pub struct Lap(Instant);

impl Lap {
    pub fn begin() -> Lap {
        Lap(Instant::now())
    }

    pub fn time(&mut self) -> Duration {
        let now = Instant::now();
        now.duration_since(std::mem::replace(&mut self.0, now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_of_the_same_threads_share_what_passed_and_nothing_is_lost() {
        let of = |[acquire, mask, filter, interpolate, light, fill]: [u64; 6]| {
            let [acquire, mask, filter, interpolate, light, fill] =
                [acquire, mask, filter, interpolate, light, fill].map(Duration::from_millis);
            Stages { acquire, mask, filter, interpolate, light, fill }
        };
        let passed = of([1000, 0, 0, 800, 0, 5]);
        let divided = passed.divided(&of([1500, 500, 100, 200, 500, 0]));
        assert_eq!(divided, of([750, 250, 100, 200, 500, 5]));
        assert_eq!(divided.sum(), passed.sum());
        assert_eq!(passed.divided(&Stages::default()), passed);
    }
}
