//! Stopwatch of the benchmarks.

use std::time::Instant;

/// Stopwatch of the time that this thread ran on a core, where Linux reports it, so that other processes affect it less;
/// otherwise of wall-clock time.
pub struct Clock {
    wall: Instant,
    on_core_ns: Option<u64>,
}

impl Clock {
    /// Starts the stopwatch.
    pub fn start() -> Clock {
        Clock { wall: Instant::now(), on_core_ns: Self::on_core_ns() }
    }

    fn on_core_ns() -> Option<u64> {
        std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
    }

    /// Returns the seconds since the start.
    pub fn seconds(&self) -> f64 {
        let on_core = self.on_core_ns.zip(Self::on_core_ns()).map(|(start, end)| (end - start) as f64 / 1e9);
        on_core.filter(|&seconds| seconds > 0.0).unwrap_or_else(|| self.wall.elapsed().as_secs_f64())
    }
}
