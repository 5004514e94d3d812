//! How long work tells that it goes on, and learns that it should not.

use crate::error::{Error, Result};

/// Watches a command at work. Implemented by the command line; everything below only calls it.
pub trait Monitor: Sync {
    /// `steps` more of the announced work are done.
    fn advance(&self, steps: u64);

    /// Whether the user has asked to stop.
    fn interrupted(&self) -> bool;

    /// An error once the user has asked to stop; long loops call it.
    fn check(&self) -> Result<()> {
        if self.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// Watches nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn advance(&self, _steps: u64) {}

    fn interrupted(&self) -> bool {
        false
    }
}
