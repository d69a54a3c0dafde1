//! How long calls report progress and learn that they should stop.
//!
//! The library owns no clock, no terminal and no signal handler: a front end passes a [`Monitor`].

use std::fmt;

/// Watches a long computation from outside.
pub trait Monitor: Sync {
    /// `done` of `total` blocks of the task `what` are finished. Called from any thread, in any order.
    fn progress(&self, what: &str, done: usize, total: usize);

    /// Returns whether the computation should stop at the next block.
    fn cancelled(&self) -> bool;
}

/// Watches nothing and never cancels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        false
    }
}

/// Hands on that another monitor cancels, and keeps the progress of inner loops from it.
#[derive(Clone, Copy)]
pub struct Quiet<'a>(pub &'a dyn Monitor);

impl Monitor for Quiet<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl fmt::Debug for Quiet<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Quiet")
    }
}

/// The computation was stopped by its [`Monitor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Cancelled {}
