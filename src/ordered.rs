//! Work on many threads whose error does not depend on which thread came first.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::error::Result;

/// What `f` makes of every job, in the order of the jobs.
///
/// # Errors
/// Of all jobs that fail, the first in order. Jobs after one that is known to have failed are left out.
pub fn try_map_ordered<J: Send, T: Send>(jobs: Vec<J>, f: impl Fn(J) -> Result<T> + Sync + Send) -> Result<Vec<T>> {
    try_map_ordered_with(jobs, || (), |(), job| f(job))
}

/// As [`try_map_ordered`], with something that successive jobs hand on to each other, made by `init` where needed.
///
/// # Errors
/// Of all jobs that fail, the first in order.
pub fn try_map_ordered_with<J: Send, T: Send, S>(
    jobs: Vec<J>,
    init: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, J) -> Result<T> + Sync + Send,
) -> Result<Vec<T>> {
    // The earliest job known to have failed: later ones are left out, earlier ones still run.
    let failed = AtomicUsize::new(usize::MAX);
    let results: Vec<Option<Result<T>>> = jobs
        .into_par_iter()
        .enumerate()
        .map_init(init, |state, (order, job)| {
            if order > failed.load(Ordering::Relaxed) {
                return None;
            }
            let result = f(state, job);
            if result.is_err() {
                failed.fetch_min(order, Ordering::Relaxed);
            }
            Some(result)
        })
        .collect();
    results.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn the_first_error_in_order_is_reported_whatever_the_threads_do() {
        for threads in [1, 4] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for _ in 0..20 {
                let job = |at: u32| {
                    if [70, 11, 200].contains(&at) { Err(Error::invalid(at.to_string())) } else { Ok(at * 2) }
                };
                let error = pool.install(|| try_map_ordered((0..300).collect(), job)).unwrap_err();
                assert_eq!(error.to_string(), "11");
                assert_eq!(pool.install(|| try_map_ordered((0..9).collect(), job)).unwrap()[8], 16);
            }
        }
    }
}
