//! Frame pacing: mean and percentiles of frame times.

use serde::Serialize;

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Pacing {
    pub mean_ms: f64,
    pub p50_ms: f64,
    pub p95_ms: f64,
    pub max_ms: f64,
}

impl Pacing {
    /// Computes the statistics of times; 0 if there are none. A percentile is the smallest time that this fraction of frames does
    /// not exceed.
    pub fn of(times_ms: &[f64]) -> Pacing {
        let mut sorted = times_ms.to_vec();
        sorted.sort_by(f64::total_cmp);
        let Some(&max_ms) = sorted.last() else { return Pacing::default() };
        let percentile = |percent: usize| sorted[(sorted.len() * percent).div_ceil(100).max(1) - 1];
        Pacing {
            mean_ms: sorted.iter().sum::<f64>() / sorted.len() as f64,
            p50_ms: percentile(50),
            p95_ms: percentile(95),
            max_ms,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FramePacing {
    /// Update and rendering together.
    #[serde(flatten)]
    pub frame: Pacing,
    /// Selection of views and units, decoding, and transfer of changes to the renderer.
    #[serde(rename = "update_ms")]
    pub update: Pacing,
    #[serde(rename = "render_ms")]
    pub render: Pacing,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_times_of_frames() {
        assert_eq!(Pacing::of(&[]), Pacing::default());
        let one = Pacing::of(&[3.0]);
        assert_eq!([one.mean_ms, one.p50_ms, one.p95_ms, one.max_ms], [3.0; 4]);
        let times: Vec<f64> = (0..100).map(|at| f64::from(at * 37 % 100 + 1)).collect();
        let pacing = Pacing::of(&times);
        assert_eq!([pacing.mean_ms, pacing.p50_ms, pacing.p95_ms, pacing.max_ms], [50.5, 50.0, 95.0, 100.0]);
        let few = Pacing::of(&[4.0, 1.0, 2.0]);
        assert_eq!([few.p50_ms, few.p95_ms], [2.0, 4.0]);
    }
}
