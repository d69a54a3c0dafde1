//! Monitors that cancel.

use std::sync::atomic::{AtomicUsize, Ordering};

use asperity_base::monitor::Monitor;

/// Monitor that cancels immediately.
#[derive(Debug, Clone, Copy, Default)]
pub struct AlwaysCancelled;

impl Monitor for AlwaysCancelled {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        true
    }
}

/// Monitor that cancels after a number of queries and counts progress reports.
#[derive(Debug)]
pub struct CancelAfter {
    left: AtomicUsize,
    reports: AtomicUsize,
}

impl CancelAfter {
    /// Creates a monitor that answers `queries` queries before it cancels.
    pub fn new(queries: usize) -> Self {
        Self { left: AtomicUsize::new(queries), reports: AtomicUsize::new(0) }
    }

    /// Returns the number of progress reports.
    pub fn reports(&self) -> usize {
        self.reports.load(Ordering::Relaxed)
    }
}

impl Monitor for CancelAfter {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {
        self.reports.fetch_add(1, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        let left = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| Some(n.saturating_sub(1)));
        left == Ok(0)
    }
}
