//! Random surfaces conditioned on measured heights.

mod lags;
mod neighbourhood;
#[cfg(test)]
mod tests;

use ndarray::Array2;
use thiserror::Error;

pub(super) use self::neighbourhood::LARGEST_DOMAIN;
pub use self::neighbourhood::NeighbourhoodSurface;
use super::GeneratorError;
use asperity_base::correlation::StationaryCovariance;
use asperity_base::distribution::{DistributionError, Marginal, standard_normal_quantile};
use asperity_base::map::{Grid, HeightMap, MapError};
use asperity_base::monitor::Cancelled;

/// Reason why a surface could not be conditioned.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConditionalError {
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
    /// A measured height is impossible under the marginal distribution.
    #[error("the height {height_m:e} m at row {row}, column {column} is impossible under the {marginal} distribution")]
    OutsideSupport {
        /// Row of the point.
        row: usize,
        /// Column of the point.
        column: usize,
        /// Height found in metre.
        height_m: f64,
        /// Name of the distribution.
        marginal: &'static str,
    },
    /// The marginal distribution is invalid.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
    /// The unconditional field could not be created.
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    /// The monitor cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Returns the map with `columns` more missing points on its left and on its right, and `rows` above and below. Filling
/// it extends the map beyond its edges.
///
/// # Errors
/// Never for a valid map.
pub fn surrounded(map: &HeightMap, columns: usize, rows: usize) -> Result<HeightMap, MapError> {
    let inner = map.grid();
    let grid = Grid::new(inner.nx() + 2 * columns, inner.ny() + 2 * rows, inner.dx_m(), inner.dy_m())?;
    let mut heights = Array2::from_elem(grid.shape(), f64::NAN);
    heights.slice_mut(ndarray::s![rows..rows + inner.ny(), columns..columns + inner.nx()]).assign(map.heights_m());
    HeightMap::new(grid, heights)
}

/// A covariance scaled to a standard deviation of 1.
struct Standardised<'a>(&'a dyn StationaryCovariance);

impl StationaryCovariance for Standardised<'_> {
    fn std_m(&self) -> f64 {
        1.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.0.correlation(dx_m, dy_m)
    }

    fn mirror_symmetric(&self) -> bool {
        self.0.mirror_symmetric()
    }
}

fn check(parameter: &'static str, value: f64, valid: bool, wanted: &'static str) -> Result<(), ConditionalError> {
    if valid { Ok(()) } else { Err(ConditionalError::Parameter { parameter, value, wanted }) }
}

/// Returns the normal scores Φ⁻¹(F(x)) of the present heights, in row order.
pub(super) fn scores(marginal: &Marginal, measured: &HeightMap) -> Result<Vec<f64>, ConditionalError> {
    marginal.check()?;
    let present = measured.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan());
    let scores = present.map(|((row, column), &height_m)| {
        let score = score(marginal, height_m);
        let outside = ConditionalError::OutsideSupport { row, column, height_m, marginal: marginal.name() };
        if score.is_finite() { Ok(score) } else { Err(outside) }
    });
    scores.collect()
}

/// Returns Φ⁻¹(F(x)), computed from the nearer tail; infinite outside the support.
fn score(marginal: &Marginal, x: f64) -> f64 {
    if let Marginal::Empirical { sorted } = marginal {
        // The last half steps are point masses at the least and the largest value.
        let (least, largest) = (sorted[0], sorted[sorted.len() - 1]);
        let half_step = 0.5 / sorted.len() as f64;
        let inside = (least..=largest).contains(&x);
        return if inside {
            standard_normal_quantile(marginal.cdf(x).clamp(half_step, 1.0 - half_step))
        } else {
            f64::NAN
        };
    }
    let (lower, upper) = (marginal.cdf(x), marginal.survival(x));
    if lower <= upper { standard_normal_quantile(lower) } else { -standard_normal_quantile(upper) }
}

/// Returns the places of the present heights, in row order.
fn places(map: &HeightMap) -> Vec<usize> {
    map.heights_m().iter().enumerate().filter(|(_, z)| !z.is_nan()).map(|(place, _)| place).collect()
}

fn map(grid: Grid, heights: Array2<f64>) -> HeightMap {
    match HeightMap::new(grid, heights) {
        Ok(map) => map,
        Err(_) => unreachable!("measured heights are present on the grid"),
    }
}
