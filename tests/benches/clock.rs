//! The clock of benches.

use std::time::Instant;

/// Seconds that this thread had a core for, where Linux tells them, so that other work matters less; else of the wall.
pub struct Clock {
    wall: Instant,
    on_core_ns: Option<u64>,
}

impl Clock {
    /// Starts it.
    pub fn start() -> Clock {
        Clock { wall: Instant::now(), on_core_ns: Self::on_core_ns() }
    }

    fn on_core_ns() -> Option<u64> {
        std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
    }

    /// Seconds since it was started.
    pub fn seconds(&self) -> f64 {
        let on_core = self.on_core_ns.zip(Self::on_core_ns()).map(|(start, end)| (end - start) as f64 / 1e9);
        on_core.filter(|&seconds| seconds > 0.0).unwrap_or_else(|| self.wall.elapsed().as_secs_f64())
    }
}
