//! Confidence intervals of surface statistics from one map.
//!
//! A map is one sample of a stationary random surface and contains a limited number of correlation lengths. To first
//! order the error of a statistic is the sum of the contributions of all places of the map, its influences. Influences
//! are summed on cells of half a correlation length. The variance of their total is estimated from the products over
//! pairs of cells under a flat-top window. The variance lost with the removed form is restored, with its own influence.
//! Intervals are Student's with the number of blocks as degrees of freedom, on a scale on which the spread hardly
//! depends on the statistic, or corrected for the skewness of the pivot. Intervals of correlation lengths invert a
//! test; Sk, Spk and Svk are bootstrapped.
//!
//! The coverage of the intervals was measured: `docs/validation/statistics.md`.

mod cells;
mod estimate;
mod heights;
mod lengths;
mod material;
#[cfg(test)]
mod tests;
mod window;

use thiserror::Error;

pub use self::estimate::{Estimate, Values};

use self::cells::Cells;
use self::heights::{FITTED, HeightSums, Removal, sdq, sdq_influence};
use self::lengths::Lengths;
use self::material::Draws;
use self::window::Window;
use super::level::Level;
use asperity_base::correlation::Axis;
use asperity_base::map::HeightMap;
use asperity_base::stats::{Interval, Moments};

/// Least number of correlation areas l_x l_y of a map, and per coefficient of the removed form. With fewer the
/// intervals are too narrow, as measured on maps of 8 to 24 lengths a side and forms of degree 3 to 8.
const LEAST_AREAS: f64 = 400.0;
const LEAST_AREAS_PER_TERM: f64 = 100.0;
/// Largest fraction of the variance that the form may have removed.
const LARGEST_REMOVED: f64 = 0.3;

/// Estimates of the statistics of a map; `None` if the map contains too few correlation lengths.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimates {
    /// Arithmetical mean height Sa in metre.
    pub sa_m: Option<Estimate>,
    /// Root-mean-square height Sq in metre.
    pub sq_m: Option<Estimate>,
    /// Skewness Ssk.
    pub ssk: Option<Estimate>,
    /// Kurtosis Sku.
    pub sku: Option<Estimate>,
    /// Root-mean-square gradient Sdq.
    pub sdq: Option<Estimate>,
    /// Autocorrelation length Sal in metre.
    pub sal_m: Option<Estimate>,
    /// Core height Sk in metre.
    pub sk_m: Option<Estimate>,
    /// Reduced peak height Spk in metre.
    pub spk_m: Option<Estimate>,
    /// Reduced dale height Svk in metre.
    pub svk_m: Option<Estimate>,
    /// 1/e correlation length along x in metre.
    pub correlation_length_x_m: Option<Estimate>,
    /// 1/e correlation length along y in metre.
    pub correlation_length_y_m: Option<Estimate>,
    /// Joint errors of Sq, Sdq and Ssk.
    pub joint: Option<JointErrors>,
}

/// Covariance matrix of the errors of ln Sq, ln Sdq and Ssk of one map as estimates for the surface.
pub type JointErrors = [[f64; 3]; 3];

impl Estimates {
    /// Returns names as in tables and JSON, and estimates.
    pub fn named(&self) -> [(&'static str, Option<Estimate>); 11] {
        [
            ("Sa_m", self.sa_m),
            ("Sq_m", self.sq_m),
            ("Ssk", self.ssk),
            ("Sku", self.sku),
            ("Sdq", self.sdq),
            ("Sal_m", self.sal_m),
            ("Sk_m", self.sk_m),
            ("Spk_m", self.spk_m),
            ("Svk_m", self.svk_m),
            ("correlation_length_x_m", self.correlation_length_x_m),
            ("correlation_length_y_m", self.correlation_length_y_m),
        ]
    }
}

/// Reason why no estimates could be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum UncertaintyError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
}

/// Settings of the estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Confidence level of the intervals, between 0 and 1.
    pub level: f64,
    /// Free coefficients of the form that was removed from the map: 1 for the mean, 3 for a plane; see
    /// [`removed_terms`].
    pub removed_terms: usize,
    /// Number of bootstrap resamples for Sk, Spk and Svk.
    pub resamples: usize,
    /// Seed of the bootstrap.
    pub seed: u64,
}

impl Default for Uncertainty {
    fn default() -> Self {
        Self { level: 0.95, removed_terms: 1, resamples: 300, seed: 0 }
    }
}

/// Returns the number of free coefficients of a form.
pub fn removed_terms(level: Level) -> usize {
    match level {
        Level::None | Level::Mean => 1,
        Level::Plane => 3,
        Level::Quadratic => 6,
        Level::Polynomial(degree) => (usize::from(degree) + 1) * (usize::from(degree) + 2) / 2,
        Level::Cylinder => 5,
        Level::Sphere => 4,
    }
}

impl Uncertainty {
    /// Estimates the statistics of a map from its values.
    ///
    /// # Errors
    /// A confidence level outside (0, 1), or fewer than two resamples.
    pub fn of(&self, map: &HeightMap, values: &Values) -> Result<Estimates, UncertaintyError> {
        self.check()?;
        let Some(basis) = self.basis(map, values) else { return Ok(Estimates::default()) };
        let Basis { cells, sums, window, removal, tail } = &basis;
        let tail = *tail;
        let lengths = Lengths::new(cells, window, sums, removal, tail);
        let draws = Draws { seed: self.seed, resamples: self.resamples, tail };
        let [sk_m, spk_m, svk_m] = material::core(cells, window, sums, values, removal.fraction, &draws);
        let lengths_m = values.lengths_m();
        let slope_influence = sdq_influence(cells);
        let halved = |influence: &[f64]| influence.iter().map(|own| 0.5 * own).collect::<Vec<f64>>();
        let joint = window.covariance(
            &[halved(&sums.restored_sq_influence(removal)), halved(&slope_influence), sums.ssk_influence(values.ssk)],
            FITTED,
        );
        Ok(Estimates {
            joint,
            sa_m: sums.sa(window, values.sa_m, removal, tail),
            sq_m: sums.sq(window, values.sq_m, removal, tail),
            ssk: sums.ssk(window, values.ssk, values.sku, tail),
            sku: sums.sku(window, values.ssk, values.sku, tail),
            sdq: sdq(window, &slope_influence, values.sdq, tail),
            sal_m: lengths.sal(values.sal_m, lengths_m),
            sk_m,
            spk_m,
            svk_m,
            correlation_length_x_m: lengths.along(Axis::X, values.correlation_length_x_m),
            correlation_length_y_m: lengths.along(Axis::Y, values.correlation_length_y_m),
        })
    }

    /// Returns confidence intervals of the surface's correlation at given lags along x and along y, in points; `None`
    /// if the map contains too few correlation lengths. Each interval covers its own lag, not all of them
    /// simultaneously.
    ///
    /// # Errors
    /// The errors of [`Uncertainty::of`].
    ///
    /// # Panics
    /// If a lag is not less than the points of the map along its axis.
    pub fn correlation(
        &self,
        map: &HeightMap,
        values: &Values,
        lags: [&[usize]; 2],
    ) -> Result<[Vec<Option<Interval>>; 2], UncertaintyError> {
        self.check()?;
        let Some(basis) = self.basis(map, values) else { return Ok(lags.map(|lags| vec![None; lags.len()])) };
        let lengths = Lengths::new(&basis.cells, &basis.window, &basis.sums, &basis.removal, basis.tail);
        let [x, y] = lags;
        Ok([
            x.iter().map(|lag| lengths.correlation((*lag as isize, 0))).collect(),
            y.iter().map(|lag| lengths.correlation((0, *lag))).collect(),
        ])
    }

    fn check(&self) -> Result<(), UncertaintyError> {
        if !(self.level > 0.0 && self.level < 1.0) {
            let wanted = "between 0 and 1";
            return Err(UncertaintyError::Parameter { parameter: "confidence level", value: self.level, wanted });
        }
        if self.resamples < 2 {
            let value = self.resamples as f64;
            return Err(UncertaintyError::Parameter { parameter: "number of resamples", value, wanted: "at least 2" });
        }
        Ok(())
    }

    /// Computes the common basis of all estimates; `None` if the map contains too few correlation lengths for any.
    fn basis(&self, map: &HeightMap, values: &Values) -> Option<Basis> {
        let least = LEAST_AREAS.max(LEAST_AREAS_PER_TERM * self.removed_terms as f64);
        // A lay that does not decay has no length along it. Then only the blocks across the lay count.
        if values.areas_in(map).is_some_and(|areas| areas < least) {
            return None;
        }
        let mean_m = Moments::from_values(map.heights_m().iter().copied()).mean;
        let cells = Cells::cut(map, mean_m, values.sq_m, values.lengths_m())?;
        let sums = HeightSums::of(&cells);
        let window = Window::new(cells.rows, cells.columns, cells.step, cells.length, &sums.fraction);
        let removal = Removal::of(&window, &sums, self.removed_terms as f64);
        let tail = 0.5 * (1.0 - self.level);
        (removal.fraction <= LARGEST_REMOVED).then_some(Basis { cells, sums, window, removal, tail })
    }
}

/// Map divided into cells, and the sums over them.
struct Basis {
    cells: Cells,
    sums: HeightSums,
    window: Window,
    removal: Removal,
    /// Probability beyond either end of an interval.
    tail: f64,
}
