//! Designs of experiments: points at which a random function is evaluated.
//!
//! A point is a function of (seed, stage, sample index, number of samples). Any point can be computed alone, on any
//! thread, in any order.
//!
//! # Standard errors
//!
//! The points of a stratified design are not independent, so their standard deviation does not estimate the error of
//! their mean. [`Design::replicate`] creates independent randomisations of a design. The standard deviation of the
//! means of r randomisations (for instance ten), divided by √r, is the standard error of their mean with r − 1 degrees
//! of freedom.
//!
//! # Maximin Latin hypercubes
//!
//! The seed draws a Latin hypercube. Exchanges of two strata of one variable then reduce φ = Σ_{i<j} d_ij^{−16}, where
//! d_ij is the distance of the cell centres of points i and j. This is the criterion of Morris and Mitchell, which
//! tends to the smallest distance of all pairs as the power grows. One partner of each exchange belongs to a pair with
//! the smallest distance. The points are uniform in their cells, as in every Latin hypercube. Means of sums of
//! functions of one variable are unbiased; means of interactions may have a small bias because close points are
//! avoided.

mod maximin;
mod permutation;
mod scrambled_sobol;

use rand::Rng;
use thiserror::Error;

use asperity_base::blocks;
use asperity_base::choice;
use asperity_base::distribution::standard_normal_quantile;
use asperity_base::random::{Stream, stream};
use maximin::{MAX_SAMPLES, maximin_strata};
use permutation::Permutation;
use scrambled_sobol::{MAX_DIMENSIONS, ScrambledSobol};

/// Largest table of strata that a Latin hypercube keeps, in entries of two bytes.
const MAX_TABLE: usize = 1 << 21;
/// Largest number of variables whose permutations are kept where the table is too large; others are made anew for each point.
const KEPT_PERMUTATIONS: usize = 64;

choice! {
    /// Placement of the points of a design.
    pub enum SamplingMethod: "sampler" {
        /// Independent points.
        MonteCarlo = "monte_carlo",
        /// One point in each of n strata of every coordinate, paired at random.
        ///
        /// # References
        /// McKay, Beckman & Conover, *Technometrics* **21** (1979) 239, <https://doi.org/10.1080/00401706.1979.10489755>.
        LatinHypercube = "latin_hypercube",
        /// Latin hypercube with a large minimum distance between points, of at most 2,000 samples.
        ///
        /// See [`maximin`](self#maximin-latin-hypercubes).
        ///
        /// # References
        /// Morris & Mitchell, *J. Stat. Plan. Inference* **43** (1995) 381, <https://doi.org/10.1016/0378-3758(94)00035-T>.
        MaximinLatinHypercube = "maximin_latin_hypercube",
        /// Sobol' points with Owen's nested uniform scrambling; at most 1,867 coordinates.
        Sobol = "sobol",
    }
}

/// Reason why a design could not be created.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
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
    /// The table of distances would be too large.
    #[error(
        "maximin Latin hypercubes have at most {limit} samples here; {samples} were asked for (use latin_hypercube)"
    )]
    TooManyForMaximin {
        /// Samples asked for.
        samples: usize,
        /// Samples available.
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
    /// Permutations of the strata of all variables, or of none: they need a kilobyte each.
    Strata(Vec<Permutation>),
    /// Strata of each sample, sample by sample.
    Table(Vec<u16>),
    Sobol(ScrambledSobol),
}

/// Planned set of `samples` points in `dimensions` variables.
#[derive(Debug, Clone)]
pub struct Design {
    method: SamplingMethod,
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
    /// The design is empty, or has more variables or samples than the method supports.
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
            SamplingMethod::LatinHypercube
                if samples <= usize::from(u16::MAX) && samples.saturating_mul(dimensions) <= MAX_TABLE =>
            {
                Placement::Table(latin_strata(seed, stage, samples, dimensions))
            }
            SamplingMethod::LatinHypercube => {
                let kept = if dimensions <= KEPT_PERMUTATIONS { dimensions } else { 0 };
                Placement::Strata((0..kept).map(|dimension| permutation(seed, stage, samples, dimension)).collect())
            }
            SamplingMethod::MaximinLatinHypercube if samples > MAX_SAMPLES => {
                return Err(SamplingError::TooManyForMaximin { samples, limit: MAX_SAMPLES });
            }
            SamplingMethod::MaximinLatinHypercube => {
                Placement::Table(maximin_strata(samples, dimensions, &mut stream(seed, &keys, 0)))
            }
            SamplingMethod::Sobol if dimensions > MAX_DIMENSIONS => {
                return Err(SamplingError::TooManyDimensions { dimensions, limit: MAX_DIMENSIONS });
            }
            SamplingMethod::Sobol if samples as u64 > 1 << 32 => {
                return Err(SamplingError::TooManySamples { samples });
            }
            SamplingMethod::Sobol => Placement::Sobol(ScrambledSobol::new(seed, &keys, dimensions)),
        };
        Ok(Self { method, seed, stage: stage.to_owned(), samples, dimensions, placement })
    }

    /// Returns an independent randomisation of the design with the same size.
    ///
    /// Number 0 is the design itself; number r > 0 is the design of the stage `"<stage>/replicate <r>"`.
    ///
    /// # Errors
    /// No error occurs for a design that could be created.
    pub fn replicate(&self, number: usize) -> Result<Self, SamplingError> {
        if number == 0 {
            return Ok(self.clone());
        }
        let stage = format!("{}/replicate {number}", self.stage);
        Self::new(self.method, self.seed, &stage, self.samples, self.dimensions)
    }

    /// Returns the number of points.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Returns the number of variables.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Writes point `index` of the open unit cube into `point`, or its leading coordinates if `point` is shorter.
    ///
    /// # Panics
    /// If the design has no such point, or `point` has more coordinates than it.
    pub fn fill_unit(&self, index: usize, point: &mut [f64]) {
        assert!(index < self.samples, "sample {index} of {}", self.samples);
        assert!(point.len() <= self.dimensions, "{} coordinates of {}", point.len(), self.dimensions);
        let mut within = stream(self.seed, &self.stage, index as u64);
        for (dimension, coordinate) in point.iter_mut().enumerate() {
            let jitter = open_unit(&mut within);
            let value = match &self.placement {
                Placement::Independent => jitter,
                Placement::Strata(permutations) => {
                    let stratum = match permutations.get(dimension) {
                        Some(permutation) => permutation.at(index as u64),
                        None => permutation(self.seed, &self.stage, self.samples, dimension).at(index as u64),
                    };
                    (stratum as f64 + jitter) / self.samples as f64
                }
                Placement::Table(strata) => {
                    (f64::from(strata[index * self.dimensions + dimension]) + jitter) / self.samples as f64
                }
                Placement::Sobol(sobol) => {
                    (f64::from(sobol.digits(index as u32, dimension)) + jitter) / 2.0_f64.powi(32)
                }
            };
            // Rounding can reach the upper end of the last stratum.
            *coordinate = value.min(1.0 - f64::EPSILON / 2.0);
        }
    }

    /// Writes the standard normal variables ξ = Φ⁻¹(u) of sample `index` into `xi`, where u is the point of the unit
    /// cube; only the leading variables if `xi` is shorter.
    ///
    /// # Panics
    /// See [`Design::fill_unit`].
    pub fn fill_xi(&self, index: usize, xi: &mut [f64]) {
        self.fill_unit(index, xi);
        for xi in xi {
            *xi = standard_normal_quantile(*xi);
        }
    }

    /// Returns point `index` of the open unit cube.
    pub fn unit(&self, index: usize) -> Vec<f64> {
        let mut point = vec![0.0; self.dimensions];
        self.fill_unit(index, &mut point);
        point
    }

    /// Returns the standard normal variables ξ of sample `index`.
    pub fn xi(&self, index: usize) -> Vec<f64> {
        self.leading_xi(index, self.dimensions)
    }

    /// Returns the leading `variables` entries of ξ of sample `index`, which take no time for the others.
    ///
    /// # Panics
    /// See [`Design::fill_unit`].
    pub fn leading_xi(&self, index: usize, variables: usize) -> Vec<f64> {
        let mut xi = vec![0.0; variables];
        self.fill_xi(index, &mut xi);
        xi
    }
}

/// Returns the strata of each sample of a Latin hypercube, sample by sample.
fn latin_strata(seed: u64, stage: &str, samples: usize, dimensions: usize) -> Vec<u16> {
    let columns: Vec<Vec<u16>> = blocks::map(0..dimensions, |dimension| {
        let permutation = permutation(seed, stage, samples, dimension);
        (0..samples).map(|index| permutation.at(index as u64) as u16).collect()
    });
    (0..samples).flat_map(|index| columns.iter().map(move |column| column[index])).collect()
}

/// Returns the permutation of the strata of a variable of a Latin hypercube.
fn permutation(seed: u64, stage: &str, samples: usize, dimension: usize) -> Permutation {
    Permutation::new(samples as u64, &mut stream(seed, &format!("{stage}/keys"), dimension as u64))
}

/// Returns a uniform number with 53 exact bits that is neither 0 nor 1.
fn open_unit(stream: &mut Stream) -> f64 {
    ((stream.next_u64() >> 12) as f64 + 0.5) / 2.0_f64.powi(52)
}

#[cfg(test)]
mod tests;
