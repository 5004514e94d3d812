//! Progress on a terminal, and Ctrl-C.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::GlobalArgs;
use crate::error::{Error, Result};
use crate::monitor::Monitor;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// A bar on standard error, drawn only on a terminal, that stops work on SIGINT and SIGTERM.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Starts a bar of `steps` steps of `what`.
    pub fn start(global: &GlobalArgs, what: &'static str, steps: u64) -> Result<Progress> {
        // A second command in one process (as in tests) keeps the first handler.
        match ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed)) {
            Ok(()) | Err(ctrlc::Error::MultipleHandlers) => {}
            Err(error) => return Err(Error::Usage(format!("no handler for Ctrl-C could be set: {error}"))),
        }
        let visible = !global.quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {per_sec} eta {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(steps), target).with_style(style).with_message(what);
        Ok(Progress { bar })
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
