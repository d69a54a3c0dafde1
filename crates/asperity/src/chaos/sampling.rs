//! Designs of experiments: where a random function is evaluated.
//!
//! A point is a function of (seed, stage, sample index, number of samples): any point can be computed alone, on any
//! thread, in any order.

mod permutation;
mod scrambled_sobol;

use rand::Rng;
use thiserror::Error;

use crate::law::standard_normal_quantile;
use crate::random::{Stream, stream};
use permutation::Permutation;
use scrambled_sobol::{MAX_DIMENSIONS, ScrambledSobol};

/// How the points of a design are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplingMethod {
    /// Independent points.
    MonteCarlo,
    /// One point in each of n strata of every coordinate, paired at random.
    ///
    /// # References
    /// McKay, Beckman & Conover, *Technometrics* **21** (1979) 239, <https://doi.org/10.1080/00401706.1979.10489755>.
    LatinHypercube,
    /// Sobol' points with Owen's nested uniform scrambling; at most 481 coordinates.
    Sobol,
}

/// Why a design could not be made.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SamplingError {
    /// A design needs at least one sample of at least one variable.
    #[error("a design of {samples} samples in {dimensions} variables is empty")]
    Empty {
        /// Samples asked for.
        samples: usize,
        /// Variables asked for.
        dimensions: usize,
    },
    /// The sequence has too few dimensions.
    #[error("Sobol' points have at most {limit} variables here; {dimensions} were asked for (use latin_hypercube)")]
    TooManyDimensions {
        /// Variables asked for.
        dimensions: usize,
        /// Variables available.
        limit: usize,
    },
    /// The sequence has too few points.
    #[error("Sobol' points number at most 2³² here; {samples} were asked for")]
    TooManySamples {
        /// Samples asked for.
        samples: usize,
    },
}

#[derive(Debug, Clone)]
enum Placement {
    Independent,
    Strata(Vec<Permutation>),
    Sobol(ScrambledSobol),
}

/// A planned set of `samples` points in `dimensions` variables.
#[derive(Debug, Clone)]
pub struct Design {
    seed: u64,
    stage: String,
    samples: usize,
    dimensions: usize,
    placement: Placement,
}

impl Design {
    /// Plans a design. Equal (seed, stage) give equal points; different stages are independent.
    ///
    /// # Errors
    /// An empty design, or more variables or samples than the method has.
    pub fn new(
        method: SamplingMethod,
        seed: u64,
        stage: &str,
        samples: usize,
        dimensions: usize,
    ) -> Result<Self, SamplingError> {
        if samples == 0 || dimensions == 0 {
            return Err(SamplingError::Empty { samples, dimensions });
        }
        let keys = format!("{stage}/keys");
        let placement = match method {
            SamplingMethod::MonteCarlo => Placement::Independent,
            SamplingMethod::LatinHypercube => Placement::Strata(
                (0..dimensions as u64)
                    .map(|dimension| Permutation::new(samples as u64, &mut stream(seed, &keys, dimension)))
                    .collect(),
            ),
            SamplingMethod::Sobol if dimensions > MAX_DIMENSIONS => {
                return Err(SamplingError::TooManyDimensions { dimensions, limit: MAX_DIMENSIONS });
            }
            SamplingMethod::Sobol if samples as u64 > 1 << 32 => {
                return Err(SamplingError::TooManySamples { samples });
            }
            SamplingMethod::Sobol => Placement::Sobol(ScrambledSobol::new(seed, &keys, dimensions)),
        };
        Ok(Self { seed, stage: stage.to_owned(), samples, dimensions, placement })
    }

    /// Number of points.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Number of variables.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Writes point `index` of the open unit cube into `point`.
    ///
    /// # Panics
    /// If the index or the length of `point` does not fit the design.
    pub fn fill_unit(&self, index: usize, point: &mut [f64]) {
        assert!(index < self.samples, "sample {index} of {}", self.samples);
        assert_eq!(point.len(), self.dimensions, "a point of another dimension");
        let mut within = stream(self.seed, &self.stage, index as u64);
        for (dimension, coordinate) in point.iter_mut().enumerate() {
            let jitter = open_unit(&mut within);
            let value = match &self.placement {
                Placement::Independent => jitter,
                Placement::Strata(permutations) => {
                    (permutations[dimension].at(index as u64) as f64 + jitter) / self.samples as f64
                }
                Placement::Sobol(sobol) => {
                    (f64::from(sobol.digits(index as u32, dimension)) + jitter) / 2.0_f64.powi(32)
                }
            };
            // Rounding can close the last stratum.
            *coordinate = value.min(1.0 - f64::EPSILON / 2.0);
        }
    }

    /// Writes the standard normal germ of sample `index` into `germ`: ξ = Φ⁻¹(u) of the unit point u.
    ///
    /// # Panics
    /// As [`Design::fill_unit`].
    pub fn fill_germ(&self, index: usize, germ: &mut [f64]) {
        self.fill_unit(index, germ);
        for xi in germ {
            *xi = standard_normal_quantile(*xi);
        }
    }

    /// Point `index` of the open unit cube.
    pub fn unit(&self, index: usize) -> Vec<f64> {
        let mut point = vec![0.0; self.dimensions];
        self.fill_unit(index, &mut point);
        point
    }

    /// The standard normal germ of sample `index`.
    pub fn germ(&self, index: usize) -> Vec<f64> {
        let mut germ = vec![0.0; self.dimensions];
        self.fill_germ(index, &mut germ);
        germ
    }
}

/// A uniform number that is exact in 53 bits and neither 0 nor 1.
fn open_unit(stream: &mut Stream) -> f64 {
    ((stream.next_u64() >> 12) as f64 + 0.5) / 2.0_f64.powi(52)
}

#[cfg(test)]
mod tests {
    use super::*;

    const METHODS: [SamplingMethod; 3] =
        [SamplingMethod::MonteCarlo, SamplingMethod::LatinHypercube, SamplingMethod::Sobol];

    fn strata(design: &Design, dimension: usize, count: usize) -> Vec<usize> {
        let mut counts = vec![0; count];
        for index in 0..count.min(design.samples()) {
            counts[(design.unit(index)[dimension] * count as f64) as usize] += 1;
        }
        counts
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_every_stratum_of_every_variable() {
        for samples in [1, 2, 7, 500] {
            let design = Design::new(SamplingMethod::LatinHypercube, 5, "lhs", samples, 9).unwrap();
            for dimension in 0..9 {
                assert_eq!(strata(&design, dimension, samples), vec![1; samples]);
            }
        }
    }

    #[test]
    fn every_dyadic_prefix_of_sobol_points_is_stratified_in_every_variable() {
        let design = Design::new(SamplingMethod::Sobol, 5, "sobol", 1000, 101).unwrap();
        for dimension in 0..101 {
            for log2 in [0, 3, 9] {
                assert_eq!(strata(&design, dimension, 1 << log2), vec![1; 1 << log2], "dimension {dimension}");
            }
        }
    }

    #[test]
    fn germs_have_the_moments_of_independent_standard_normals() {
        let (samples, dimensions) = (4000, 12);
        for method in METHODS {
            let design = Design::new(method, 11, "moments", samples, dimensions).unwrap();
            let germs: Vec<Vec<f64>> = (0..samples).map(|i| design.germ(i)).collect();
            let n = samples as f64;
            for a in 0..dimensions {
                let mean = germs.iter().map(|g| g[a]).sum::<f64>() / n;
                assert!(mean.abs() < 4.5 / n.sqrt(), "{method:?}: mean {mean}");
                for b in 0..=a {
                    let product = germs.iter().map(|g| g[a] * g[b]).sum::<f64>() / n;
                    let (wanted, variance) = if a == b { (1.0, 2.0) } else { (0.0, 1.0) };
                    let bound = 4.5 * f64::sqrt(variance / n);
                    assert!((product - wanted).abs() < bound, "{method:?}: E ξ{a} ξ{b} = {product}");
                }
            }
        }
    }

    #[test]
    fn a_point_depends_on_seed_stage_index_and_sample_size_alone() {
        for method in METHODS {
            let point = |seed, stage, index| Design::new(method, seed, stage, 100, 5).unwrap().germ(index);
            assert_eq!(point(1, "a", 17), point(1, "a", 17));
            assert_ne!(point(1, "a", 17), point(1, "a", 18));
            assert_ne!(point(1, "a", 17), point(2, "a", 17));
            assert_ne!(point(1, "a", 17), point(1, "b", 17));
        }
    }

    #[test]
    fn a_longer_monte_carlo_or_sobol_design_starts_with_the_shorter_one() {
        for method in [SamplingMethod::MonteCarlo, SamplingMethod::Sobol] {
            let short = Design::new(method, 1, "prefix", 10, 3).unwrap();
            let long = Design::new(method, 1, "prefix", 1000, 3).unwrap();
            assert!((0..10).all(|i| short.unit(i) == long.unit(i)));
        }
    }

    /// Root-mean-square error of the sample mean of f over 40 designs; E f = 0.
    fn rms_error(method: SamplingMethod, samples: usize, f: impl Fn(&[f64]) -> f64) -> f64 {
        let squares: f64 = (0..40)
            .map(|seed| {
                let design = Design::new(method, seed, "rms", samples, 3).unwrap();
                let mean = (0..samples).map(|i| f(&design.unit(i))).sum::<f64>() / samples as f64;
                mean * mean
            })
            .sum();
        (squares / 40.0).sqrt()
    }

    #[test]
    fn stratified_designs_integrate_what_they_promise() {
        let n: usize = 256;
        let additive = |u: &[f64]| u.iter().map(|x| x - 0.5).sum::<f64>();
        // Variance 3/12 for independent points; Latin hypercube variance 3/(12 n³) exactly.
        let monte_carlo = rms_error(SamplingMethod::MonteCarlo, n, additive) / (0.25 / n as f64).sqrt();
        let latin = rms_error(SamplingMethod::LatinHypercube, n, additive) / (0.25 / (n as f64).powi(3)).sqrt();
        // The relative standard error of a root-mean-square over 40 values is 1/√80; four of them.
        for ratio in [monte_carlo, latin] {
            assert!((ratio - 1.0).abs() < 4.0 / 80.0_f64.sqrt(), "ratio {ratio}");
        }
    }

    #[test]
    fn scrambled_sobol_points_gain_an_order_on_a_smooth_interaction() {
        let interaction = |u: &[f64]| (u[0] - 0.5) * (u[1] - 0.5) * 12.0 + (u[1] - 0.5) * (u[2] - 0.5) * 12.0;
        let coarse = rms_error(SamplingMethod::Sobol, 64, interaction);
        let fine = rms_error(SamplingMethod::Sobol, 1024, interaction);
        // Between the Monte Carlo order ½ and the asymptotic 3/2 (up to a logarithm); the noise of the order is 0.06.
        let order = (coarse / fine).ln() / 16.0_f64.ln();
        assert!(order > 1.0, "observed order {order:.2}");
        let latin = rms_error(SamplingMethod::LatinHypercube, 1024, interaction);
        assert!(fine < 0.3 * latin, "Sobol' {fine:.2e}, Latin hypercube {latin:.2e}");
    }

    #[test]
    fn impossible_designs_are_refused() {
        assert_eq!(
            Design::new(SamplingMethod::Sobol, 1, "x", 10, 482).unwrap_err(),
            SamplingError::TooManyDimensions { dimensions: 482, limit: 481 }
        );
        assert_eq!(
            Design::new(SamplingMethod::MonteCarlo, 1, "x", 0, 3).unwrap_err(),
            SamplingError::Empty { samples: 0, dimensions: 3 }
        );
    }
}
