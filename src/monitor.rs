//! Progress and cancellation.

use crate::error::{Error, Result};

/// Receives progress, and may cancel. Implemented by the caller.
pub trait Monitor: Sync {
    /// Reports `steps` completed steps.
    fn advance(&self, steps: u64);

    /// Begins a stage of so many steps, which `advance` counts until [`Self::end_stage`]; then the work before goes on.
    fn begin_stage(&self, _name: &'static str, _steps: u64) {}

    /// Ends the stage that was begun last.
    fn end_stage(&self) {}

    /// Whether to stop.
    fn interrupted(&self) -> bool;

    /// Called in long loops.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if interrupted.
    fn check(&self) -> Result<()> {
        if self.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// Counts no steps of its own, and stops with another monitor.
pub(crate) struct Uncounted<'a>(pub &'a dyn Monitor);

impl Monitor for Uncounted<'_> {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        self.0.interrupted()
    }
}

/// Ignores progress and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        false
    }
}
