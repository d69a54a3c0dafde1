//! Whole pressure fields of samples within a memory limit.

use serde::{Deserialize, Serialize};

use asperity_base::map::Grid;
use asperity_contact::{HalfSpace, Solution};

/// Sums count in units of E*/2⁴⁰, because integers add up to the same value in any order.
const UNITS: f64 = (1_u64 << 40) as f64;

/// Sums over all samples, and the fields of the leading samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FieldSamples {
    pub(super) grid: Grid,
    unit_pa: f64,
    /// Number of samples in which each cell is in contact, row by row.
    pub(super) in_contact: Vec<u32>,
    /// Sum of the pressures of each cell in units.
    sums: Vec<u64>,
    /// Fields of the leading samples: pressure in pascal in contact, minus the gap in metre out of contact.
    pub(super) kept: Vec<Vec<f32>>,
}

impl FieldSamples {
    pub(super) fn new(half_space: &HalfSpace) -> Self {
        let grid = half_space.grid();
        Self {
            grid,
            unit_pa: half_space.modulus_pa() / UNITS,
            in_contact: vec![0; grid.points()],
            sums: vec![0; grid.points()],
            kept: Vec::new(),
        }
    }

    /// Adds one sample.
    pub(super) fn add(&mut self, field: Field) {
        for (cell, p) in field.contact_pa {
            self.in_contact[cell] += 1;
            self.sums[cell] += (p / self.unit_pa).round() as u64;
        }
        self.kept.extend(field.kept);
    }

    /// Returns the sum of the pressures of a cell in pascal.
    pub(super) fn sum_pa(&self, cell: usize) -> f64 {
        self.unit_pa * self.sums[cell] as f64
    }
}

/// Whole pressure field of one sample.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Field {
    /// Cells in contact, row by row, with their pressures in pascal.
    contact_pa: Vec<(usize, f64)>,
    kept: Option<Vec<f32>>,
}

impl Field {
    /// Bytes of one point in contact.
    pub(super) const POINT_BYTES: usize = size_of::<(usize, f64)>() + size_of::<f32>();

    /// Extracts the field of a solution; `keep` if it is one of the leading samples.
    pub(super) fn new(solution: &Solution, keep: bool) -> Self {
        let cells = solution.pressure_pa().iter().copied().enumerate();
        Self { contact_pa: cells.filter(|(_, p)| *p > 0.0).collect(), kept: keep.then(|| signed(solution)) }
    }
}

/// Returns the pressure in pascal in contact and minus the gap in metre out of contact.
fn signed(solution: &Solution) -> Vec<f32> {
    let gap_m = solution.gap_m();
    let cells = solution.pressure_pa().iter().zip(&gap_m);
    cells.map(|(p, gap)| if *p > 0.0 { *p as f32 } else { -*gap as f32 }).collect()
}
