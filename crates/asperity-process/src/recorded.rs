//! Given fluctuations: a record, or zero.

use super::model::check_step;
use super::{Cell, EqualCells, Fluctuation, ProcessError};

/// Zero fluctuation, m = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Steady;

impl Fluctuation for Steady {
    #[inline]
    fn next_cell(&mut self) -> Option<Cell> {
        Some(Cell { end: f64::INFINITY, length: f64::INFINITY, left: 0.0, right: 0.0 })
    }
}

/// Recorded fluctuation, piecewise linear through values at equal distances.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedProcess {
    step: f64,
    values: Vec<f64>,
}

impl RecordedProcess {
    /// Creates a record from the values m(0), m(h), m(2h), …: at least two, all finite, with h between 1e-15 and 1e15.
    pub fn new(step: f64, values: Vec<f64>) -> Result<Self, ProcessError> {
        check_step(step)?;
        if values.len() < 2 {
            let (parameter, value) = ("number of recorded friction values", values.len() as f64);
            return Err(ProcessError::Parameter { parameter, value, wanted: "at least 2" });
        }
        if let Some(&value) = values.iter().find(|v| !v.is_finite()) {
            return Err(ProcessError::Parameter { parameter: "recorded friction value", value, wanted: "finite" });
        }
        Ok(Self { step, values })
    }

    /// Returns the distance between the values.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Returns the values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Returns the record from its start.
    pub fn path(&self) -> RecordedPath<'_> {
        RecordedPath { cells: EqualCells::new(self.step), rest: self.values.iter() }
    }
}

/// Reader of a [`RecordedProcess`].
#[derive(Debug, Clone)]
pub struct RecordedPath<'a> {
    cells: EqualCells,
    rest: std::slice::Iter<'a, f64>,
}

impl Fluctuation for RecordedPath<'_> {
    #[inline]
    fn next_cell(&mut self) -> Option<Cell> {
        let left = match self.cells.last {
            Some(left) => left,
            None => *self.rest.next()?,
        };
        let right = *self.rest.next()?;
        Some(self.cells.close(left, right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_once_and_then_ends() {
        let record = RecordedProcess::new(0.5, vec![1.0, -2.0, 4.0]).unwrap();
        let mut path = record.path();
        let first = Cell { end: 0.5, length: 0.5, left: 1.0, right: -2.0 };
        let second = Cell { end: 1.0, length: 0.5, left: -2.0, right: 4.0 };
        assert_eq!([path.next_cell(), path.next_cell(), path.next_cell()], [Some(first), Some(second), None]);
        assert_eq!(second.slope(), 12.0);
        assert_eq!(Steady.next_cell().map(|cell| (cell.end, cell.slope())), Some((f64::INFINITY, 0.0)));
    }

    #[test]
    fn invalid_records_are_refused() {
        for (step, values) in [
            (0.0, vec![1.0, 2.0]),
            (1e-300, vec![1.0, 2.0]),
            (1.0, vec![1.0]),
            (1.0, vec![1.0, f64::NAN]),
            (f64::NAN, vec![1.0; 3]),
        ] {
            assert!(RecordedProcess::new(step, values).is_err());
        }
    }
}
