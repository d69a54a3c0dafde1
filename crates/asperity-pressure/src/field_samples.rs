//! Whole pressure fields of samples within a memory limit.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use ndarray::Array2;

use asperity_base::map::Grid;
use asperity_contact::{HalfSpace, Solution};

/// Sums count in units of E*/2⁴⁰, because integers add up to the same value in any order.
const UNITS: f64 = (1_u64 << 40) as f64;

/// Sums over samples that are solved on any thread.
#[derive(Debug)]
pub(super) struct FieldSums {
    grid: Grid,
    unit_pa: f64,
    in_contact: Vec<AtomicU32>,
    sums: Vec<AtomicU64>,
}

impl FieldSums {
    pub(super) fn new(half_space: &HalfSpace) -> Self {
        let grid = half_space.grid();
        Self {
            grid,
            unit_pa: half_space.modulus_pa() / UNITS,
            in_contact: (0..grid.points()).map(|_| AtomicU32::new(0)).collect(),
            sums: (0..grid.points()).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// Adds one sample.
    pub(super) fn add(&self, pressure_pa: &Array2<f64>) {
        let cells = self.in_contact.iter().zip(&self.sums).zip(pressure_pa);
        for ((count, sum), p) in cells.filter(|(_, p)| **p > 0.0) {
            count.fetch_add(1, Ordering::Relaxed);
            sum.fetch_add((p / self.unit_pa).round() as u64, Ordering::Relaxed);
        }
    }
}

/// Sums over all samples, and the fields of the leading samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FieldSamples {
    pub(super) grid: Grid,
    /// Number of samples in which each cell is in contact, row by row.
    pub(super) in_contact: Vec<u32>,
    /// Sum of the pressures of each cell in pascal.
    pub(super) sums_pa: Vec<f64>,
    /// Fields of the leading samples: pressure in pascal in contact, minus the gap in metre out of contact.
    pub(super) kept: Vec<Vec<f32>>,
}

impl FieldSamples {
    pub(super) fn new(sums: FieldSums) -> Self {
        let unit_pa = sums.unit_pa;
        Self {
            grid: sums.grid,
            in_contact: sums.in_contact.into_iter().map(AtomicU32::into_inner).collect(),
            sums_pa: sums.sums.into_iter().map(|sum| unit_pa * sum.into_inner() as f64).collect(),
            kept: Vec::new(),
        }
    }
}

/// Returns the pressure in pascal in contact and minus the gap in metre out of contact.
pub(super) fn signed(solution: &Solution) -> Vec<f32> {
    let gap_m = solution.gap_m();
    let cells = solution.pressure_pa().iter().zip(&gap_m);
    cells.map(|(p, gap)| if *p > 0.0 { *p as f32 } else { -*gap as f32 }).collect()
}
