//! Fluctuation that ends when the computation is cancelled.

use super::{Cell, Fluctuation};
use asperity_base::monitor::Monitor;

/// Number of cells between two checks of the monitor: about a millisecond.
const CHECK_INTERVAL: u32 = 16_384;

/// Fluctuation that ends once its monitor cancels, so that a path over billions of grid points need not be followed to
/// its end. The motion then fails as on a record that is too short; the caller checks the monitor to distinguish the
/// two cases.
pub struct Cancellable<'a, F> {
    fluctuation: F,
    monitor: &'a dyn Monitor,
    left: u32,
}

impl<'a, F> Cancellable<'a, F> {
    /// Wraps `fluctuation`, which then ends when `monitor` cancels.
    pub fn new(fluctuation: F, monitor: &'a dyn Monitor) -> Self {
        Self { fluctuation, monitor, left: CHECK_INTERVAL }
    }
}

impl<F: Fluctuation> Fluctuation for Cancellable<'_, F> {
    // A cell in registers: one that is returned through memory stalls the loops over paths.
    #[inline(always)]
    fn next_cell(&mut self) -> Option<Cell> {
        self.left -= 1;
        if self.left == 0 {
            if self.monitor.cancelled() {
                self.left = 1;
                return None;
            }
            self.left = CHECK_INTERVAL;
        }
        self.fluctuation.next_cell()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::{FrictionProcess, ProcessModel};

    struct Switch(AtomicBool);

    impl Monitor for Switch {
        fn progress(&self, _: &str, _: usize, _: usize) {}

        fn cancelled(&self) -> bool {
            self.0.load(Ordering::Relaxed)
        }
    }

    #[test]
    fn the_fluctuation_is_unchanged_until_the_monitor_cancels() {
        let process = FrictionProcess::new(ProcessModel::new("normal".parse().unwrap(), 1e-3, 0.01)).unwrap();
        let monitor = Switch(AtomicBool::new(false));
        let (mut bare, mut watched) = (process.path(1, 2), Cancellable::new(process.path(1, 2), &monitor));
        for _ in 0..3 * CHECK_INTERVAL {
            assert_eq!(watched.next_cell(), bare.next_cell());
        }
        monitor.0.store(true, Ordering::Relaxed);
        let left = (0..=CHECK_INTERVAL).find(|_| watched.next_cell().is_none());
        assert!(left.is_some());
        assert_eq!((watched.next_cell(), watched.next_cell()), (None, None));
    }
}
