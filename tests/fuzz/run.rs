//! Runs inputs, and checks them for panics, memory and time.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::time::Instant;

use crate::ALLOCATED;
use crate::inputs::Inputs;
use crate::targets::{Target, Verdict};

/// Maximum seconds per input: short enough to detect an input that does not end, long enough for a busy machine.
pub const MAX_SECONDS: f64 = 20.0;

/// Message and location of the last panic.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// Installs a panic hook that stores messages instead of printing them.
pub fn keep_panics() {
    std::panic::set_hook(Box::new(|info| {
        if let Ok(mut words) = PANIC.lock() {
            *words = info.to_string().replace('\n', " ");
        }
    }));
}

/// Results of running a number of inputs.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    pub execs: u64,
    pub accepted: u64,
    /// Maximum of memory relative to the bound of an input.
    pub memory_share: f64,
    /// Maximum memory of an input in bytes.
    pub memory_bytes: u64,
    pub slowest_seconds: f64,
    pub seconds: f64,
}

/// An input that caused a failure.
#[derive(Debug, Clone)]
pub struct Finding {
    pub number: u64,
    pub what: String,
}

/// Runs one input and returns the verdict, the bytes of memory, their ratio to the bound, and the seconds. Fails for a panic, or
/// if a bound is exceeded.
pub fn exec(target: &Target, input: &[u8]) -> Result<(Verdict, u64, f64, f64), String> {
    let before = ALLOCATED.current_usage();
    ALLOCATED.reset_peak_usage();
    let last_words = || PANIC.lock().map(|mut words| std::mem::take(&mut *words)).unwrap_or_default();
    last_words();
    let start = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    let seconds = start.elapsed().as_secs_f64();
    let bytes = ALLOCATED.peak_usage().saturating_sub(before) as u64;
    let verdict = result.map_err(|_| format!("panic: {}", last_words()))??;
    let words = last_words();
    if !words.is_empty() {
        return Err(format!("a panic that was caught: {words}"));
    }
    let bound = (target.bound)(input);
    if bytes > bound {
        return Err(format!("{bytes} bytes of memory for an input of {} bytes: the bound is {bound}", input.len()));
    }
    if seconds > MAX_SECONDS {
        return Err(format!("{seconds:.1} seconds for an input of {} bytes", input.len()));
    }
    Ok((verdict, bytes, bytes as f64 / bound as f64, seconds))
}

/// Runs the inputs of a generator; `started` is called with the number of each input before it runs.
pub fn run(
    target: &Target,
    inputs: &Inputs,
    numbers: impl IntoIterator<Item = u64>,
    mut started: impl FnMut(u64),
) -> (Figures, Vec<Finding>) {
    let (mut figures, mut findings) = (Figures::default(), Vec::new());
    let start = Instant::now();
    for number in numbers {
        let input = inputs.get(number);
        started(number);
        figures.execs += 1;
        match exec(target, &input) {
            Ok((verdict, bytes, share, seconds)) => {
                figures.accepted += u64::from(verdict == Verdict::Accepted);
                figures.memory_bytes = figures.memory_bytes.max(bytes);
                figures.memory_share = figures.memory_share.max(share);
                figures.slowest_seconds = figures.slowest_seconds.max(seconds);
            }
            Err(what) => findings.push(Finding { number, what }),
        }
    }
    figures.seconds = start.elapsed().as_secs_f64();
    (figures, findings)
}
