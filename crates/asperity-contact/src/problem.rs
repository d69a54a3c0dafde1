//! A contact problem: a rough map, a half-space, a prescribed load or position, and a hardness.

use ndarray::Array2;

use crate::error::positive;
use crate::{Boundary, ContactError, Control, HalfSpace};

/// Largest prescribed quantity, and the inverse of the least.
const MOST: f64 = 1e100;

/// A contact problem: heights, a half-space, a prescribed quantity, and the hardness.
#[derive(Debug, Clone, Copy)]
pub struct ContactProblem<'a> {
    half_space: &'a HalfSpace,
    heights_m: &'a Array2<f64>,
    control: Control,
    hardness_pa: Option<f64>,
    mean_height_m: f64,
    rms_height_m: f64,
    highest_m: f64,
}

impl<'a> ContactProblem<'a> {
    /// Creates a problem; `hardness_pa = None` is elastic.
    ///
    /// # Errors
    /// Heights are missing, all equal, or rougher or smoother than can be computed (1e-50 m to 1e50 m rms); the map does not fit the half-space; a prescribed
    /// value is out of range; the mean pressure is not below the hardness; or the plane overlaps a periodic half-space
    /// of zero mean compliance.
    pub fn new(
        half_space: &'a HalfSpace,
        heights_m: &'a Array2<f64>,
        control: Control,
        hardness_pa: Option<f64>,
    ) -> Result<Self, ContactError> {
        let (rows, columns) = heights_m.dim();
        let (ny, nx) = half_space.grid().shape();
        if (rows, columns) != (ny, nx) {
            return Err(ContactError::Shape { rows, columns, ny, nx });
        }
        let missing = heights_m.iter().filter(|z| !z.is_finite()).count();
        if missing > 0 {
            return Err(ContactError::Missing { missing, points: heights_m.len() });
        }
        let points = heights_m.len() as f64;
        let mean_height_m = heights_m.sum() / points;
        let variance = heights_m.iter().map(|z| (z - mean_height_m).powi(2)).sum::<f64>() / points;
        let highest_m = heights_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest_m = heights_m.iter().copied().fold(f64::INFINITY, f64::min);
        // The variance of equal heights is the rounding error of the mean.
        if highest_m - lowest_m <= 4.0 * f64::EPSILON * highest_m.abs().max(lowest_m.abs()) {
            return Err(ContactError::Flat);
        }
        let rms_height_m = variance.sqrt();
        positive("rms height", rms_height_m, "m", 1e50)?;
        let problem = Self { half_space, heights_m, control, hardness_pa, mean_height_m, rms_height_m, highest_m };
        problem.validated()
    }

    fn validated(self) -> Result<Self, ContactError> {
        if let Some(hardness_pa) = self.hardness_pa {
            positive("hardness", hardness_pa, "Pa", MOST)?;
        }
        match self.control {
            Control::Plane { height_m } if !(0.0..=MOST).contains(&height_m.abs()) => {
                let (parameter, unit, wanted) = ("height of the plane", "m", "between −1e100 m and 1e100 m");
                return Err(ContactError::Parameter { parameter, value: height_m, unit, wanted });
            }
            Control::Penetration { metre } if !(0.0..=MOST).contains(&metre) => {
                let (parameter, unit, wanted) = ("penetration", "m", "between 0 and 1e100 m");
                return Err(ContactError::Parameter { parameter, value: metre, unit, wanted });
            }
            Control::Percentile { percent } if !(0.0..=100.0).contains(&percent) => {
                let (parameter, unit, wanted) = ("percentile", "%", "between 0 and 100");
                return Err(ContactError::Parameter { parameter, value: percent, unit, wanted });
            }
            Control::MeanPressure { pascal } => positive("mean pressure", pascal, "Pa", MOST)?,
            Control::Load { newton } => {
                positive("load", newton, "N", MOST)?;
                positive("mean pressure", newton / self.half_space.grid().area_m2(), "Pa", MOST)?;
            }
            Control::MeanGap { metre } => positive("mean gap", metre, "m", MOST)?,
            _ => {}
        }
        if let (Some(mean_pressure_pa), Some(hardness_pa)) = (self.mean_pressure_pa(), self.hardness_pa)
            && mean_pressure_pa >= hardness_pa
        {
            return Err(ContactError::Overloaded { mean_pressure_pa, hardness_pa });
        }
        let rigid_mean = self.half_space.boundary() == Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };
        if rigid_mean && self.plane_m().is_some_and(|plane_m| plane_m < self.highest_m) {
            return Err(ContactError::Unbounded);
        }
        Ok(self)
    }

    /// Returns the half-space.
    pub fn half_space(&self) -> &'a HalfSpace {
        self.half_space
    }

    /// Returns a mean compliance of zero in m/Pa on the periodic boundary; the free boundary has no separate mean mode.
    pub(super) fn rigid_mean_m_per_pa(&self) -> Option<f64> {
        matches!(self.half_space.boundary(), Boundary::Periodic { .. }).then_some(0.0)
    }

    /// Returns the undeformed heights in metre.
    pub fn heights_m(&self) -> &'a Array2<f64> {
        self.heights_m
    }

    /// Returns the prescribed quantity.
    pub fn control(&self) -> Control {
        self.control
    }

    /// Hardness in pascal, the upper bound of the pressure, if there is one.
    pub fn hardness_pa(&self) -> Option<f64> {
        self.hardness_pa
    }

    /// Returns the mean of the heights in metre.
    pub fn mean_height_m(&self) -> f64 {
        self.mean_height_m
    }

    /// Returns the standard deviation of the heights in metre, the scale of the normalised residuals.
    pub fn rms_height_m(&self) -> f64 {
        self.rms_height_m
    }

    /// Returns the highest point in metre.
    pub fn highest_m(&self) -> f64 {
        self.highest_m
    }

    /// Returns the height of the plane in metre, if the control prescribes it.
    pub fn plane_m(&self) -> Option<f64> {
        match self.control {
            Control::Plane { height_m } => Some(height_m),
            Control::Penetration { metre } => Some(self.highest_m - metre),
            Control::Percentile { percent } => {
                let mut sorted: Vec<f64> = self.heights_m.iter().copied().collect();
                sorted.sort_unstable_by(f64::total_cmp);
                let position = (1.0 - percent / 100.0) * (sorted.len() - 1) as f64;
                let below = position.floor() as usize;
                let above = (below + 1).min(sorted.len() - 1);
                Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below]))
            }
            _ => None,
        }
    }

    /// Returns the mean pressure in pascal, if the control prescribes it.
    pub fn mean_pressure_pa(&self) -> Option<f64> {
        match self.control {
            Control::MeanPressure { pascal } => Some(pascal),
            Control::Load { newton } => Some(newton / self.half_space.grid().area_m2()),
            _ => None,
        }
    }
}
