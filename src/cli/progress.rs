//! Progress on a terminal, and Ctrl-C.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::cli::{GlobalArgs, refuse};
use crate::error::Result;
use crate::monitor::Monitor;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// A progress bar, on terminals only, that reports SIGINT and SIGTERM.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    pub fn start(global: &GlobalArgs, what: &'static str, steps: u64) -> Result<Progress> {
        // Set once per process.
        match ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed)) {
            Ok(()) | Err(ctrlc::Error::MultipleHandlers) => {}
            Err(error) => return refuse(format!("no handler for Ctrl-C could be set: {error}")),
        }
        let visible = !global.quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {rate} eta {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .with_key("rate", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
                // Errors are not shown.
                let _ = text.write_str(&rate(state.per_sec()));
            });
        let bar = ProgressBar::with_draw_target(Some(steps), target).with_style(style).with_message(what);
        Ok(Progress { bar })
    }

    /// Sets the number of steps, where it follows from what is read first. Reading does not count.
    pub fn set_steps(&self, steps: u64) {
        self.bar.set_length(steps);
        self.bar.set_position(0);
        self.bar.reset_eta();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Monitor for Progress {
    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }

    fn interrupted(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}

/// Steps per second, with one decimal if few: `0.4/s`, `35/s`.
fn rate(per_second: f64) -> String {
    if per_second < 9.95 { format!("{per_second:.1}/s") } else { format!("{per_second:.0}/s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_have_one_decimal_at_most() {
        assert_eq!(
            [0.0, 0.4321, 9.94, 9.97, 35.4321, 1234.5678].map(rate),
            ["0.0/s", "0.4/s", "9.9/s", "10/s", "35/s", "1235/s"]
        );
    }
}
