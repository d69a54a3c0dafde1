//! Test whether cells have equal distributions.

use ndarray::Array2;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::{MethodError, Samples};
use asperity_base::numeric::symmetric_eigen;

/// Number of cells along either side that are compared, and the same for few samples.
const LATTICE: usize = 4;
const SMALL_LATTICE: usize = 2;
/// Number of samples per cell that the large lattice requires.
const SAMPLES_PER_CELL: usize = 10;
/// Fraction of the variance of the cells below which differences count as constant.
const ROUNDING: f64 = 1e-9;
/// Significance level below which cells are not pooled.
const LEVEL: f64 = 0.05;

/// Test of equal contact probabilities and equal mean pressures in the cells of a lattice.
///
/// Samples are independent, but the cells of one sample are not. The test uses Hotelling's T² of the differences
/// between cells with their covariance, which is approximately χ²-distributed, and F-distributed for few samples. A
/// p-value is the probability of such differences between cells of equal distribution; a large value does not prove
/// equality. Contact probabilities require about five contacts per cell.
///
/// # References
/// H. Hotelling, *Ann. Math. Statist.* **2** (1931) 360, <https://doi.org/10.1214/aoms/1177732979>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homogeneity {
    /// Number of cells compared.
    pub cells: usize,
    /// Number of independent samples.
    pub samples: usize,
    /// p-value of equal contact probabilities.
    pub contact_p_value: f64,
    /// p-value of equal mean pressures.
    pub mean_p_value: f64,
    /// p-value of both: twice the smaller one, at most 1.
    pub p_value: f64,
}

impl Homogeneity {
    /// Tests the kept sites of the samples, `shape` (rows, columns).
    ///
    /// # Errors
    /// There are too few samples.
    pub(super) fn from_sites(samples: &Samples, shape: (usize, usize)) -> Result<Self, MethodError> {
        let sites = samples.sites();
        let large = LATTICE * LATTICE * SAMPLES_PER_CELL;
        let lattice = if sites.len() >= large { LATTICE } else { SMALL_LATTICE };
        let wanted = SMALL_LATTICE * SMALL_LATTICE * SAMPLES_PER_CELL;
        if sites.len() < wanted {
            return Err(MethodError::TooFewSamples { samples: sites.len(), wanted });
        }
        // Equally spaced from the first cell on, also across a periodic edge.
        let places = |count: usize| -> Vec<usize> {
            let mut places: Vec<usize> = (0..lattice).map(|i| i * count / lattice).collect();
            places.dedup();
            places
        };
        let (rows, columns) = (places(shape.0), places(shape.1));
        let cells: Vec<usize> = rows.iter().flat_map(|r| columns.iter().map(move |c| r * shape.1 + c)).collect();
        let of = |value: &dyn Fn(f32) -> f64| -> f64 {
            let vectors: Vec<Vec<f64>> =
                sites.iter().map(|field| cells.iter().map(|cell| value(field[*cell])).collect()).collect();
            p_value(&vectors)
        };
        let contact_p_value = of(&|p| if p > 0.0 { 1.0 } else { 0.0 });
        let mean_p_value = of(&|p| f64::from(p));
        let p_value = (2.0 * contact_p_value.min(mean_p_value)).min(1.0);
        Ok(Self { cells: cells.len(), samples: sites.len(), contact_p_value, mean_p_value, p_value })
    }

    /// Returns whether the samples are consistent with equal cells at the 5 % level.
    pub fn is_plausible(&self) -> bool {
        self.p_value >= LEVEL
    }
}

/// Returns the p-value of equal means of the components of independent vectors.
fn p_value(vectors: &[Vec<f64>]) -> f64 {
    let (n, m) = (vectors.len() as f64, vectors[0].len());
    let mut variance = 0.0;
    for j in 0..m {
        let mean = vectors.iter().map(|v| v[j]).sum::<f64>() / n;
        variance += vectors.iter().map(|v| (v[j] - mean).powi(2)).sum::<f64>() / (n * m as f64);
    }
    let differences: Vec<Vec<f64>> = vectors
        .iter()
        .map(|v| {
            let mean = v.iter().sum::<f64>() / m as f64;
            v.iter().map(|x| x - mean).collect()
        })
        .collect();
    let means: Vec<f64> = (0..m).map(|j| differences.iter().map(|d| d[j]).sum::<f64>() / n).collect();
    let covariance = Array2::from_shape_fn((m, m), |(i, j)| {
        differences.iter().map(|d| (d[i] - means[i]) * (d[j] - means[j])).sum::<f64>() / (n - 1.0)
    });
    let Ok(eigen) = symmetric_eigen(covariance) else { return f64::NAN };
    let (mut statistic, mut degrees) = (0.0, 0.0);
    for k in 0..m {
        let along: f64 = (0..m).map(|i| eigen.vectors[[k, i]] * means[i]).sum();
        let spread = eigen.values[k];
        if spread > ROUNDING * variance {
            statistic += n * along * along / spread;
            degrees += 1.0;
        } else if along * along > ROUNDING * variance {
            // The difference is the same in all samples.
            return 0.0;
        }
    }
    if degrees == 0.0 {
        return 1.0;
    }
    let ratio = statistic * (n - degrees) / (degrees * (n - 1.0));
    FisherSnedecor::new(degrees, n - degrees).map_or(f64::NAN, |distribution| distribution.sf(ratio))
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    /// Returns vectors whose components have most of their noise in common.
    fn vectors(number: u64, count: usize, shift: f64) -> Vec<Vec<f64>> {
        (0..count as u64)
            .map(|i| {
                let xi = standard_normal(&mut stream(3, "homogeneity", 1000 * number + i), 5);
                (0..4).map(|j| 3.0 * xi[4] + xi[j] + if j == 2 { shift } else { 0.0 }).collect()
            })
            .collect()
    }

    #[test]
    fn p_values_of_equal_cells_are_uniform() {
        let mut found: Vec<f64> = (0..200).map(|number| p_value(&vectors(number, 60, 0.0))).collect();
        found.sort_by(f64::total_cmp);
        let far = |i: usize| (found[i] - (i as f64 + 0.5) / 200.0).abs();
        // 99.9 % point of √n D: 1.95.
        let distance = (0..200).map(far).fold(0.0, f64::max);
        assert!(distance < 1.95 / 200.0_f64.sqrt(), "{distance}");
    }

    #[test]
    fn a_shift_below_the_common_noise_is_found() {
        // One cell in four is shifted by 0.5: T² is about n · 0.25 · ¾ = 28 with three degrees of freedom.
        assert!(p_value(&vectors(0, 150, 0.5)) < 1e-3);
    }

    #[test]
    fn constant_differences_are_certain_and_absent_ones_have_no_estimate() {
        let equal: Vec<Vec<f64>> = vectors(0, 50, 0.0).iter().map(|v| vec![v[0]; 4]).collect();
        assert_eq!(p_value(&equal), 1.0);
        let apart: Vec<Vec<f64>> = equal.iter().map(|v| vec![v[0], v[0], v[0] + 1.0, v[0]]).collect();
        assert_eq!(p_value(&apart), 0.0);
        assert_eq!(p_value(&vec![vec![0.0; 4]; 50]), 1.0);
    }
}
