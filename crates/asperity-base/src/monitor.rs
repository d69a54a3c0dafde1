//! Progress reports and cancellation of long computations.
//!
//! The library uses no clock, terminal or signal handler: a front end passes a [`Monitor`].

use std::fmt;

/// Observer of a long computation.
pub trait Monitor: Sync {
    /// Reports that `done` of `total` blocks of the task `what` are finished. Called from any thread, in any order.
    fn progress(&self, what: &str, done: usize, total: usize);

    /// Returns whether the computation should stop at the next block.
    fn cancelled(&self) -> bool;
}

/// Monitor that ignores progress and never cancels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        false
    }
}

/// Monitor that forwards cancellation but not the progress of inner loops.
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

/// Cancellation of a computation by its [`Monitor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Cancelled {}
