//! Progress and cancellation.

use crate::error::{Error, Result};

/// Receives progress, and may cancel. Implemented by the caller.
pub trait Monitor: Sync {
    /// Reports `steps` completed steps.
    fn advance(&self, steps: u64);

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

/// Ignores progress and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        false
    }
}
