//! Progress and cancellation.

use crate::error::{Error, Result};

/// Receives progress and can cancel an operation. Implemented by the caller.
pub trait Monitor: Sync {
    /// Reports `steps` completed steps.
    fn advance(&self, steps: u64);

    /// Begins a stage of `steps` steps. `advance` counts its steps until [`Self::end_stage`], and those of the enclosing work
    /// after it.
    fn begin_stage(&self, _name: &'static str, _steps: u64) {}

    /// Ends the stage that was begun last.
    fn end_stage(&self) {}

    /// True if the operation should stop.
    fn interrupted(&self) -> bool;

    /// Checks for cancellation; called in long loops.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if interrupted.
    fn check(&self) -> Result<()> {
        if self.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// Monitor that discards progress and is interrupted with another monitor.
pub struct Uncounted<'a>(pub &'a dyn Monitor);

impl Monitor for Uncounted<'_> {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        self.0.interrupted()
    }
}

/// Monitor that ignores progress and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        false
    }
}
