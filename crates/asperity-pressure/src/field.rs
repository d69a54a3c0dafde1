//! Distributions of the pressures of all cells.

use ndarray::{Array2, ArrayView2};

use crate::field_samples::FieldSamples;
use crate::homogeneity::Homogeneity;
use crate::nested::kappa_pa_per_m;
use crate::{MethodError, Samples};
use asperity_base::blocks;
use asperity_base::map::Grid;
use asperity_base::stats::wilson_interval;
use asperity_chaos::{Basis, LeastSquares, RegressionError, number_of_terms};

/// Memory limit for kept fields, in bytes: 32,768 samples of 64 × 64 cells, 512 of 512 × 512.
pub(super) const FIELD_BYTES: usize = 1 << 29;
/// Probabilities of the quantile maps.
const QUANTILES: [f64; 3] = [0.1, 0.5, 0.9];
/// Minimum number of samples per coefficient of an expansion of all cells.
const SAMPLES_PER_TERM: usize = 2;

/// Distributions of the pressures of all cells, from the independent samples of [`PressureMethod::MonteCarlo`](crate::PressureMethod).
///
/// Contact probabilities and means use all samples. Whole fields are kept for as many leading samples as fit into 512
/// MiB; standard errors, quantiles and expansions use those samples.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldDistributions {
    /// Grid; maps have its shape, row by row.
    pub grid: Grid,
    /// Number of samples.
    pub samples: usize,
    /// Number of samples with whole fields.
    pub kept_samples: usize,
    /// P(contact) of each cell.
    pub contact_probability: Array2<f64>,
    /// Lower end of the pointwise 95 % interval (Wilson) of P(contact) of each cell.
    pub contact_probability_low: Array2<f64>,
    /// Upper end of the interval.
    pub contact_probability_high: Array2<f64>,
    /// Mean pressure E p of each cell in pascal.
    pub mean_pa: Array2<f64>,
    /// Standard error of the mean in pascal.
    pub mean_se_pa: Array2<f64>,
    /// Maps of the 10, 50 and 90 % quantiles.
    pub quantiles: Vec<QuantileMap>,
    /// Expansion of each cell in the leading variables ξ, or the reason why there is none.
    pub global: Result<GlobalExpansion, MethodError>,
    /// Test whether the cells have equal distributions, or the reason why it failed.
    pub homogeneity: Result<Homogeneity, MethodError>,
}

/// Quantile of every cell.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantileMap {
    /// Probability.
    pub probability: f64,
    /// Smallest pressure in pascal at which F reaches the probability.
    pub pressure_pa: Array2<f64>,
}

/// Chaos expansions of the pressures of all cells in the leading variables ξ, by one factorisation.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalExpansion {
    /// Number of leading variables ξ.
    pub variables: usize,
    /// Total degree with the smallest mean error.
    pub degree: usize,
    /// Number of coefficients per cell.
    pub coefficients: usize,
    /// Mean square leave-one-out error of each cell's pressure, continued below zero by the gap, divided by its
    /// variance; NaN if it does not vary. Above 1 the expansion predicts worse than the mean.
    pub leave_one_out_error: Array2<f64>,
}

impl FieldDistributions {
    /// Computes the distributions from samples with kept fields; `None` without fields.
    ///
    /// The expansion has up to `degree` in `variables` variables. The test of homogeneity uses the kept `sites` (rows,
    /// columns).
    pub(super) fn new(samples: &Samples, variables: usize, degree: usize, sites: (usize, usize)) -> Option<Self> {
        let fields = samples.fields()?;
        let (grid, count) = (fields.grid, samples.len());
        let shape = grid.shape();
        let map =
            |value: &dyn Fn(usize) -> f64| Array2::from_shape_fn(shape, |(row, column)| value(row * shape.1 + column));
        let interval = |i: usize| wilson_interval(fields.in_contact[i] as usize, count);
        let mut distributions = Self {
            grid,
            samples: count,
            kept_samples: fields.kept.len(),
            contact_probability: map(&|i| f64::from(fields.in_contact[i]) / count as f64),
            contact_probability_low: map(&|i| interval(i).low),
            contact_probability_high: map(&|i| interval(i).high),
            mean_pa: map(&|i| fields.sum_pa(i) / count as f64),
            mean_se_pa: Array2::from_elem(shape, f64::NAN),
            quantiles: Vec::new(),
            global: global(samples, fields, variables, degree),
            homogeneity: Homogeneity::from_sites(samples, sites),
        };
        distributions.add_spread(fields);
        Some(distributions)
    }

    /// Computes quantiles and standard errors.
    fn add_spread(&mut self, fields: &FieldSamples) {
        let (ny, nx) = self.grid.shape();
        let kept = fields.kept.len();
        if kept < 2 {
            return;
        }
        let of_cell = |row: usize, column: usize| -> [f64; QUANTILES.len() + 1] {
            let mut pressures: Vec<f32> = fields.kept.iter().map(|field| field[row * nx + column].max(0.0)).collect();
            let mean = pressures.iter().map(|p| f64::from(*p)).sum::<f64>() / kept as f64;
            let square = pressures.iter().map(|p| (f64::from(*p) - mean).powi(2)).sum::<f64>() / (kept - 1) as f64;
            pressures.sort_by(f32::total_cmp);
            let mut found = [(square / self.samples as f64).sqrt(); QUANTILES.len() + 1];
            for (value, probability) in found.iter_mut().zip(QUANTILES) {
                *value = f64::from(pressures[((probability * kept as f64).ceil() as usize).clamp(1, kept) - 1]);
            }
            found
        };
        let rows: Vec<Vec<[f64; QUANTILES.len() + 1]>> =
            blocks::map(0..ny, |row| (0..nx).map(|column| of_cell(row, column)).collect());
        let map = |k: usize| Array2::from_shape_fn((ny, nx), |(row, column)| rows[row][column][k]);
        self.quantiles = QUANTILES
            .iter()
            .enumerate()
            .map(|(k, probability)| QuantileMap { probability: *probability, pressure_pa: map(k) })
            .collect();
        self.mean_se_pa = map(QUANTILES.len());
    }
}

/// Fits the expansion of every cell, with the degree up to `degree` whose error averaged over the cells is smallest.
fn global(
    samples: &Samples,
    fields: &FieldSamples,
    variables: usize,
    degree: usize,
) -> Result<GlobalExpansion, MethodError> {
    let kept = fields.kept.len();
    let xi_samples: Vec<Vec<f64>> = samples.leading_xi(variables).into_iter().take(kept).collect();
    let kappa = kappa_pa_per_m(samples.observations());
    let enough = |degree: &usize| number_of_terms(variables, *degree).is_some_and(|n| n * SAMPLES_PER_TERM <= kept);
    let mut best: Option<(f64, GlobalExpansion)> = None;
    for degree in (1..=degree).take_while(enough) {
        let basis = Basis::hermite(variables, degree)?;
        let squares = LeastSquares::new(basis.design_matrix(&xi_samples))?;
        let leave_one_out_error = error_map(&squares, fields, kappa)?;
        let known: Vec<f64> = leave_one_out_error.iter().copied().filter(|error| !error.is_nan()).collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        if best.as_ref().is_none_or(|(least, _)| mean < *least) {
            let coefficients = basis.len();
            best = Some((mean, GlobalExpansion { variables, degree, coefficients, leave_one_out_error }));
        }
    }
    let too_few = RegressionError::TooFewSamples { samples: kept, coefficients: variables + 1 };
    best.map(|(_, found)| found).ok_or_else(|| too_few.into())
}

/// Returns the relative leave-one-out error of every cell.
fn error_map(squares: &LeastSquares, fields: &FieldSamples, kappa: f64) -> Result<Array2<f64>, RegressionError> {
    let (ny, nx) = fields.grid.shape();
    // Row by row, so that not all cells are in double precision at once.
    let errors: Result<Vec<Vec<f64>>, RegressionError> = blocks::map(0..ny, |row| {
        let latent = Array2::from_shape_fn((fields.kept.len(), nx), |(k, column)| {
            let value = f64::from(fields.kept[k][row * nx + column]);
            if value > 0.0 { value } else { kappa * value }
        });
        relative_errors(squares, latent.view())
    });
    let errors = errors?;
    Ok(Array2::from_shape_fn((ny, nx), |(row, column)| errors[row][column]))
}

fn relative_errors(squares: &LeastSquares, responses: ArrayView2<'_, f64>) -> Result<Vec<f64>, RegressionError> {
    let errors = squares.fit_many(responses)?.relative_errors;
    // The variance of equal values may be rounding.
    let varies = responses.columns().into_iter().map(|column| column.iter().any(|value| *value != column[0]));
    Ok(errors.into_iter().zip(varies).map(|(error, varies)| error.filter(|_| varies).unwrap_or(f64::NAN)).collect())
}

#[cfg(test)]
mod tests;
