//! Parallel maps with deterministic errors.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::error::Result;

/// Maps jobs in parallel and returns the results in the order of the jobs. On failure, returns the error of the first failed
/// job in that order; jobs after it may be skipped.
pub fn try_map_ordered<J: Send, T: Send>(jobs: Vec<J>, f: impl Fn(J) -> Result<T> + Sync + Send) -> Result<Vec<T>> {
    try_map_at_once(jobs, usize::MAX, f)
}

/// As [`try_map_ordered`], with at most `at_once` jobs in progress, including jobs that wait for their own parallel work.
pub fn try_map_at_once<J: Send, T: Send>(
    jobs: Vec<J>,
    at_once: usize,
    f: impl Fn(J) -> Result<T> + Sync + Send,
) -> Result<Vec<T>> {
    try_map_at_once_with(jobs, at_once, || (), |(), job| f(job))
}

/// As [`try_map_at_once`], with state made by `init` that consecutive jobs of a thread share.
pub fn try_map_at_once_with<J: Send, T: Send, S>(
    jobs: Vec<J>,
    at_once: usize,
    init: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, J) -> Result<T> + Sync + Send,
) -> Result<Vec<T>> {
    if jobs.len() <= 1 || rayon::current_num_threads() == 1 {
        // Runs on the caller's thread: waking another takes longer than a small job.
        let mut state = init();
        return jobs.into_iter().map(|job| f(&mut state, job)).collect();
    }
    // Index of the first failed job so far: later jobs are skipped, earlier ones still run.
    let failed = AtomicUsize::new(usize::MAX);
    let run = |state: &mut S, (order, job): (usize, J)| {
        if order > failed.load(Ordering::Relaxed) {
            return None;
        }
        let result = f(state, job);
        if result.is_err() {
            failed.fetch_min(order, Ordering::Relaxed);
        }
        Some((order, result))
    };
    if at_once >= jobs.len() {
        let results: Vec<_> = jobs.into_par_iter().enumerate().map_init(init, run).collect();
        return results.into_iter().flatten().map(|(_, result)| result).collect();
    }
    let left = Mutex::new(jobs.into_iter().enumerate());
    // The mutex is poisoned only if a thread panicked, which ends the whole map.
    let next = || left.lock().ok().and_then(|mut left| left.next());
    let mut results: Vec<(usize, Result<T>)> = (0..at_once.max(1))
        .into_par_iter()
        .with_max_len(1)
        .flat_map_iter(|_| {
            let mut state = init();
            std::iter::from_fn(|| run(&mut state, next()?)).collect::<Vec<_>>()
        })
        .collect();
    results.sort_by_key(|(order, _)| *order);
    results.into_iter().map(|(_, result)| result).collect()
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
                let error = pool.install(|| try_map_at_once((0..300).collect(), 3, job)).unwrap_err();
                assert_eq!(error.to_string(), "11");
                assert_eq!(pool.install(|| try_map_at_once((0..9).collect(), 2, job)).unwrap()[8], 16);
            }
        }
    }

    #[test]
    fn no_more_jobs_are_at_work_than_allowed_also_where_they_wait_for_work_of_their_own() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        for at_once in [1, 3] {
            let (at_work, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
            let job = |at: u64| {
                most.fetch_max(at_work.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                let sum: u64 = (0..200u64).into_par_iter().map(|n| std::hint::black_box(n * at)).sum();
                at_work.fetch_sub(1, Ordering::SeqCst);
                Ok(sum)
            };
            let done = pool.install(|| try_map_at_once((0..100).collect(), at_once, job)).unwrap();
            assert_eq!(done, (0..100).map(|at| 19_900 * at).collect::<Vec<u64>>());
            assert!((1..=at_once).contains(&most.into_inner()));
        }
    }
}
