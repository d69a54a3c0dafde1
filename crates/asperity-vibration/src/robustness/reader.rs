//! Second evaluation of a friction process, independent of the motion.

use std::collections::VecDeque;

use asperity_process::{Cell, Fluctuation};

/// Evaluates m(s) near a coordinate that does not decrease.
pub(super) struct ProcessReader<F> {
    fluctuation: F,
    /// Cells and their start coordinates.
    cells: VecDeque<(f64, Cell)>,
    end: f64,
    pub(super) cells_read: u64,
    /// Largest |dm/ds| so far.
    pub(super) steepest: f64,
}

impl<F: Fluctuation> ProcessReader<F> {
    pub(super) fn new(fluctuation: F) -> Self {
        Self { fluctuation, cells: VecDeque::new(), end: 0.0, cells_read: 0, steepest: 0.0 }
    }

    /// Discards the cells before a coordinate.
    pub(super) fn forget(&mut self, before: f64) {
        while self.cells.front().is_some_and(|(_, cell)| cell.end < before) {
            self.cells.pop_front();
        }
    }

    /// Returns the least and largest m within `around` of a coordinate: two levels where m jumps.
    pub(super) fn range(&mut self, coordinate: f64, around: f64) -> (f64, f64) {
        let (low, high) = ((coordinate - around).max(0.0), coordinate + around);
        while self.end <= high {
            let cell = self.fluctuation.next_cell().unwrap();
            self.cells.push_back((self.end, cell));
            self.end = cell.end;
            self.cells_read += 1;
            self.steepest = self.steepest.max(cell.slope().abs());
        }
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for (start, cell) in self.cells.iter().filter(|(start, cell)| *start <= high && cell.end >= low) {
            for place in [low.max(*start), high.min(cell.end)] {
                let m = if place == cell.end { cell.right } else { cell.left + cell.slope() * (place - start) };
                range = (range.0.min(m), range.1.max(m));
            }
        }
        range
    }
}
