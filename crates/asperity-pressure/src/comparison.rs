//! Estimates of one distribution by several methods with the same number of contact solutions, compared with a
//! reference.

use crate::estimate::{MOST_POOLED, PressureEstimate, ReferenceDistances};
use crate::expansion::{self, Response};
use crate::field::{FIELD_BYTES, FieldDistributions};
use crate::nested::{CoarseSolves, NestedSamples, Quantity};
use crate::sample::Sampling;
use crate::sensitivity::{self, Sensitivity};
use crate::surrogate::{RotatedSamples, TrainingSamples};
use crate::{Failure, MethodError, PressureError, PressureMethod, Problem, QuantileResult, Samples, solve};
use asperity_base::monitor::Monitor;
use asperity_base::stats::{Interval, NORMAL_95, VALID_FRACTION};
use asperity_chaos::{Basis, Design, DiscreteDistribution, SamplingMethod};

use PressureMethod::{LatinHypercube, PolynomialChaosLocal, Sobol};

/// Probabilities of the reported quantiles.
const PROBABILITIES: [f64; 3] = [0.1, 0.5, 0.9];
/// Number of independent randomisations of stratified designs.
const REPLICATES: usize = 10;
/// Number of sites along either side whose pressures are pooled.
const SITES: usize = 16;

/// Settings of a comparison of methods: sizes of the runs. Runs of one seed are independent of each other.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodComparison {
    /// Seed of all runs.
    pub seed: u64,
    /// Methods beside [`PressureMethod::Default`], which is always used. With others, a reference is computed, too.
    pub methods: Vec<PressureMethod>,
    /// Number of contact solutions of each method.
    pub fine_solves: usize,
    /// Number of contact solutions of the Monte Carlo reference.
    pub reference_samples: usize,
    /// Number of leading variables ξ of the expansions of eq. (8) and (9).
    pub variables: usize,
    /// Total degree of these expansions.
    pub degree: usize,
    /// Number of evaluations of an expansion on fresh samples.
    pub surrogate_samples: usize,
    /// Smallest fraction of converged contact problems in a run.
    pub valid_fraction: f64,
    /// Whether the stiffness of contacts is one of the scalars. This costs one more linear problem for each Monte Carlo
    /// and each coarse solution and changes nothing else.
    pub stiffness: bool,
}

/// Result of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodResult {
    /// Method.
    pub method: PressureMethod,
    /// Number of its contact solutions, including failed ones.
    pub fine_solves: usize,
    /// Further solutions on coarser grids.
    pub coarse_solves: Vec<CoarseSolves>,
    /// Failed samples.
    pub failures: Vec<Failure>,
    /// Estimate with its distances from the reference, if there is one, or the reason why there is no estimate.
    pub outcome: Result<(PressureEstimate, Option<ReferenceDistances>), MethodError>,
}

/// Distribution of a scalar of the whole contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarResult {
    /// Scalar.
    pub quantity: Quantity,
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_se: f64,
    /// 95 % interval of the mean within the possible values.
    pub mean_interval: Interval,
    /// Distribution, estimated as by [`PressureMethod::Default`].
    pub distribution: DiscreteDistribution,
    /// 95 % intervals of the 10, 50 and 90 % quantiles.
    pub quantiles: Vec<QuantileResult>,
}

/// Monte Carlo distribution with which the methods are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Number of contact solutions, including failed ones.
    pub samples: usize,
    /// Failed samples.
    pub failures: Vec<Failure>,
    /// Number of cells of each solution whose pressures are pooled; more than one if the surface is stationary.
    pub sites: usize,
    /// Estimate.
    pub estimate: PressureEstimate,
    /// Upper 95 % limit of the Kolmogorov–Smirnov distance to the true distribution. Smaller distances of other
    /// distributions are not resolved.
    pub ks_resolution: f64,
}

/// Results of a comparison of methods.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonResults {
    /// Reference; `None` without other methods than [`PressureMethod::Default`].
    pub reference: Option<Reference>,
    /// Result of each method, in the order of [`PressureMethod::ALL`].
    pub methods: Vec<MethodResult>,
    /// Distributions of scalars of the whole contact.
    pub scalars: Vec<ScalarResult>,
    /// Distributions of the pressures of all cells.
    pub fields: Option<FieldDistributions>,
    /// Sensitivity indices.
    pub sensitivities: Vec<Sensitivity>,
}

impl MethodComparison {
    /// Creates the customary settings: all methods, 500 solutions for each, 5,000 for the reference, total degree 3 in 8
    /// variables.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            methods: PressureMethod::ALL.to_vec(),
            fine_solves: 500,
            reference_samples: 5000,
            variables: 8,
            degree: 3,
            surrogate_samples: 10_000,
            valid_fraction: VALID_FRACTION,
            stiffness: false,
        }
    }

    /// Estimates the distribution of the pressure of `problem` by every method.
    ///
    /// # Errors
    /// A size is out of range, too few contact problems of a run converged, or the monitor cancelled.
    pub fn run(&self, problem: &Problem<'_>, monitor: &dyn Monitor) -> Result<ComparisonResults, PressureError> {
        self.solve(problem, monitor)?.results(monitor)
    }

    /// Solves the contact problems that the methods share.
    ///
    /// # Errors
    /// See [`MethodComparison::run`].
    #[doc(hidden)]
    pub fn solve<'a>(&self, problem: &Problem<'a>, monitor: &dyn Monitor) -> Result<Solutions<'a>, PressureError> {
        self.validate(problem)?;
        let largest_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
        // The problem from which scalars are estimated.
        let whole = if self.stiffness { problem.with_stiffness() } else { *problem };
        let stride = site_stride(problem);
        let reference = PressureMethod::are_compared(&self.methods).then(|| {
            let stage = "pressure/reference";
            let sampling = Sampling::monte_carlo(self.seed, stage, self.reference_samples, self.valid_fraction);
            let site_stride = problem.cells_are_alike().then_some(stride);
            solve(problem, Sampling { site_stride, ..sampling }, monitor)
        });
        let monte_carlo = {
            let sampling =
                Sampling::monte_carlo(self.seed, "pressure/monte_carlo", self.fine_solves, self.valid_fraction);
            let kept = Sampling { site_stride: Some(stride), field_bytes: Some(FIELD_BYTES), ..sampling };
            solve(&whole, kept, monitor)
        };
        let stratified = |method, stage| {
            let sampling = Sampling::monte_carlo(self.seed, stage, self.fine_solves, self.valid_fraction);
            method_error(solve(problem, Sampling { method, replicates: REPLICATES, ..sampling }, monitor))
        };
        let [has_latin, has_sobol] = stratified_designs(&self.methods);
        let latin = has_latin.then(|| stratified(SamplingMethod::LatinHypercube, "pressure/latin_hypercube"));
        let sobol = has_sobol.then(|| stratified(SamplingMethod::Sobol, "pressure/sobol"));
        // None of these rounds needs another, so all are begun before the first that is not complete ends the computation.
        let reference = reference.transpose()?.map(|samples| self.reference(&samples, largest_pa)).transpose()?;
        let (monte_carlo, latin, sobol) = (monte_carlo?, latin.transpose()?, sobol.transpose()?);
        let site_shape = site_shape(problem, stride);
        let fields = FieldDistributions::new(&monte_carlo, self.variables, self.degree, site_shape);
        let monte_carlo = monte_carlo.without_fields();
        let nested = method_error(NestedSamples::solve(&whole, &monte_carlo, self.seed, monitor))?;
        let fresh = |variables| self.fresh_design("pressure/surrogate", variables);
        let rotated =
            self.methods.contains(&PolynomialChaosLocal).then(|| RotatedSamples::new(problem, &monte_carlo, fresh));
        let rotated = rotated.map(method_error).transpose()?;
        Ok(Solutions {
            settings: self.clone(),
            problem: *problem,
            reference,
            fields,
            monte_carlo,
            latin,
            sobol,
            nested,
            rotated,
        })
    }

    /// Estimates the distribution by [`PressureMethod::Default`] alone, without a reference. Also returns the numbers of
    /// solutions on coarser grids.
    ///
    /// # Errors
    /// See [`MethodComparison::run`] and [`MethodError`].
    pub fn estimate_default(
        &self,
        problem: &Problem<'_>,
        monitor: &dyn Monitor,
    ) -> Result<(PressureEstimate, Vec<CoarseSolves>), PressureError> {
        self.validate(problem)?;
        let sampling = Sampling::monte_carlo(self.seed, "pressure/monte_carlo", self.fine_solves, self.valid_fraction);
        let samples = solve(problem, sampling, monitor)?;
        let nested = NestedSamples::solve(problem, &samples, self.seed, monitor)?;
        Ok((nested.estimate_pressure(problem, self.seed, true, true)?, nested.coarse_solves(problem)))
    }

    fn reference(&self, samples: &Samples, largest_pa: f64) -> Result<Reference, PressureError> {
        let sites = samples.sites().first().map_or(0, Vec::len);
        let estimate = if sites > 0 {
            PressureEstimate::from_sites(samples, largest_pa, self.seed)?
        } else {
            PressureEstimate::from_independent(samples, largest_pa, self.seed)?
        };
        let ks_resolution = match &estimate.band {
            Some(band) if sites > 0 => {
                band.simultaneous_factor * band.standard_errors.iter().copied().fold(0.0, f64::max)
            }
            _ => 1.358 / (samples.len() as f64).sqrt(),
        };
        let failures = samples.failures().to_vec();
        Ok(Reference { samples: samples.posed(), failures, sites: sites.max(1), estimate, ks_resolution })
    }

    /// Returns the distributions of the scalars; failed ones are left out.
    fn scalars(&self, problem: &Problem<'_>, nested: &NestedSamples) -> Vec<ScalarResult> {
        let scalar = |quantity: Quantity| {
            let found = nested.estimate(quantity, problem, self.seed).ok()?;
            let [least, largest] = quantity.bounds(problem);
            let half = NORMAL_95 * found.mean_se;
            let possible = |value: f64| value.clamp(least, largest);
            Some(ScalarResult {
                quantity,
                mean: possible(found.mean),
                mean_se: found.mean_se,
                mean_interval: Interval { low: possible(found.mean - half), high: possible(found.mean + half) },
                quantiles: PROBABILITIES.into_iter().map(|p| found.band.quantile(&found.distribution, p)).collect(),
                distribution: found.distribution.clone(),
            })
        };
        Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Pressure).filter_map(scalar).collect()
    }

    fn validate(&self, problem: &Problem<'_>) -> Result<(), PressureError> {
        let at_least = |parameter, value: usize, least: usize, wanted| {
            if value >= least {
                Ok(())
            } else {
                Err(PressureError::Parameter { parameter, value: value as f64, wanted })
            }
        };
        at_least("fine_solves", self.fine_solves, 2, "at least 2")?;
        if PressureMethod::are_compared(&self.methods) {
            at_least("reference_samples", self.reference_samples, 2, "at least 2")?;
        }
        at_least("surrogate_samples", self.surrogate_samples, 2, "at least 2")?;
        at_least("variables", self.variables, 1, "at least 1")?;
        if self.variables > problem.surface().xi_len() {
            return Err(PressureError::Parameter {
                parameter: "variables",
                value: self.variables as f64,
                wanted: "at most the number of normal variables of the surface",
            });
        }
        if !(self.valid_fraction > 0.0 && self.valid_fraction <= 1.0) {
            return Err(PressureError::Parameter {
                parameter: "valid_share",
                value: self.valid_fraction,
                wanted: "above 0 and at most 1",
            });
        }
        Ok(())
    }

    /// Returns the samples ξ on which expansions are evaluated.
    fn fresh_xi(&self, variables: usize) -> Result<Vec<Vec<f64>>, PressureError> {
        let design = self.fresh_design("pressure/expansion", variables)?;
        Ok((0..design.samples()).map(|i| design.xi(i)).collect())
    }

    fn fresh_design(&self, stage: &str, variables: usize) -> Result<Design, PressureError> {
        Ok(Design::new(SamplingMethod::MonteCarlo, self.seed, stage, self.surrogate_samples, variables)?)
    }
}

/// Contact solutions shared by the methods of a comparison.
#[doc(hidden)]
#[derive(Debug)]
pub struct Solutions<'a> {
    settings: MethodComparison,
    problem: Problem<'a>,
    reference: Option<Reference>,
    fields: Option<FieldDistributions>,
    /// Independent samples, with the pressures of many cells.
    pub monte_carlo: Samples,
    latin: Option<Result<Samples, MethodError>>,
    sobol: Option<Result<Samples, MethodError>>,
    /// Independent samples with further samples on coarse grids, or the reason why there are none.
    pub nested: Result<NestedSamples, MethodError>,
    /// Independent samples in normal variables rotated to the cell, or the reason why there are none; `None` if no method uses them.
    pub rotated: Option<Result<RotatedSamples, MethodError>>,
}

impl Solutions<'_> {
    /// Estimates the distribution of the pressure by every method.
    ///
    /// # Errors
    /// A distribution could not be created from its values.
    pub fn results(self, monitor: &dyn Monitor) -> Result<ComparisonResults, PressureError> {
        let mut methods = Vec::with_capacity(PressureMethod::ALL.len());
        let wanted =
            |method: &&PressureMethod| **method == PressureMethod::Default || self.settings.methods.contains(*method);
        for &method in PressureMethod::ALL.iter().filter(wanted) {
            let task = format!("pressure/distribution/{}", method.name());
            monitor.progress(&task, 0, 1);
            let samples = match method.design() {
                LatinHypercube => solved(self.latin.as_ref()).ok(),
                Sobol => solved(self.sobol.as_ref()).ok(),
                _ => Some(&self.monte_carlo),
            };
            methods.push(MethodResult {
                method,
                fine_solves: samples.map_or(0, Samples::posed),
                coarse_solves: match &self.nested {
                    Ok(nested) if method == PressureMethod::Default => nested.coarse_solves(&self.problem),
                    _ => Vec::new(),
                },
                failures: samples.map_or_else(Vec::new, |samples| samples.failures().to_vec()),
                outcome: method_error(self.estimate(method))?.map(|estimate| {
                    let distances = |reference: &Reference| {
                        ReferenceDistances::between(&estimate.distribution, &reference.estimate.distribution)
                    };
                    let comparison = self.reference.as_ref().map(distances);
                    (estimate, comparison)
                }),
            });
            monitor.progress(&task, 1, 1);
        }
        let Self { settings, problem, monte_carlo, .. } = &self;
        let scalars = self.nested.as_ref().map_or_else(|_| Vec::new(), |nested| settings.scalars(problem, nested));
        let sensitivities =
            sensitivity::estimate(problem, monte_carlo, settings.variables, settings.degree, settings.seed);
        Ok(ComparisonResults { reference: self.reference, methods, scalars, fields: self.fields, sensitivities })
    }

    fn estimate(&self, method: PressureMethod) -> Result<PressureEstimate, PressureError> {
        let &MethodComparison { seed, variables, degree, .. } = &self.settings;
        let largest_pa = self.problem.hardness_pa().unwrap_or(f64::INFINITY);
        let replicated = |samples: &Option<Result<Samples, MethodError>>| {
            PressureEstimate::from_replicates(solved(samples.as_ref())?, largest_pa, seed)
        };
        let expanded = |response| {
            let latin = solved(self.latin.as_ref())?;
            let (xi_samples, pressures_pa) = (latin.leading_xi(variables), latin.pressures_pa());
            let groups: Vec<usize> = (0..latin.len()).map(|position| latin.replicate_of(position)).collect();
            let fresh = self.settings.fresh_xi(variables)?;
            let evaluations = fresh.len();
            let training =
                TrainingSamples { pressures_pa: &pressures_pa, groups: Some(&groups), evaluations, largest_pa };
            let basis = Basis::hermite(variables, degree)?;
            Ok(expansion::estimate(response, &xi_samples, training, basis, &fresh, seed)?)
        };
        match method {
            PressureMethod::MonteCarlo => PressureEstimate::from_independent(&self.monte_carlo, largest_pa, seed),
            PressureMethod::LatinHypercube => replicated(&self.latin),
            PressureMethod::Sobol => replicated(&self.sobol),
            PressureMethod::PolynomialChaos => expanded(Response::Pressure),
            PressureMethod::PolynomialChaosLog => expanded(Response::Logarithm),
            PressureMethod::PolynomialChaosLocal => {
                let rotated = solved(self.rotated.as_ref())?;
                if rotated.variables() == 0 {
                    return Err(MethodError::NoVariables.into());
                }
                let basis = Basis::hermite(rotated.variables(), degree).map_err(MethodError::from)?;
                let (rows, training) = (&rotated.rows, rotated.training());
                Ok(expansion::estimate(Response::Pressure, rows, training, basis, &rotated.fresh, seed)?)
            }
            PressureMethod::Default => {
                let nested = self.nested.as_ref().map_err(Clone::clone)?;
                Ok(nested.estimate_pressure(&self.problem, seed, true, true)?)
            }
        }
    }
}

/// Returns whether methods need Latin hypercubes, and Sobol' points, beside the independent samples of the default.
pub fn stratified_designs(methods: &[PressureMethod]) -> [bool; 2] {
    [LatinHypercube, Sobol].map(|design| methods.iter().any(|method| method.design() == design))
}

/// Returns the samples of a method that is asked for.
fn solved<T>(samples: Option<&Result<T, MethodError>>) -> Result<&T, MethodError> {
    match samples {
        Some(samples) => samples.as_ref().map_err(Clone::clone),
        None => unreachable!("the samples of all methods that are asked for are solved"),
    }
}

/// Returns the stride of the cells whose pressures are pooled.
fn site_stride(problem: &Problem<'_>) -> usize {
    let (ny, nx) = problem.half_space().grid().shape();
    stride(nx, ny)
}

/// Returns the rows and columns of the sites.
fn site_shape(problem: &Problem<'_>, stride: usize) -> (usize, usize) {
    let (ny, nx) = problem.half_space().grid().shape();
    (ny.div_ceil(stride), nx.div_ceil(stride))
}

fn stride(nx: usize, ny: usize) -> usize {
    (nx.min(ny) / SITES).max(1)
}

/// Returns the largest number of pressures that a reference of `samples` solutions on a periodic patch of points (x, y) pools.
pub fn pooled_pressures([nx, ny]: [usize; 2], samples: usize) -> usize {
    let stride = stride(nx, ny);
    (nx.div_ceil(stride) * ny.div_ceil(stride)).saturating_mul(samples).min(MOST_POOLED)
}

/// Separates the errors of a method from other errors.
fn method_error<T>(outcome: Result<T, PressureError>) -> Result<Result<T, MethodError>, PressureError> {
    match outcome {
        Ok(found) => Ok(Ok(found)),
        Err(PressureError::Method(reason)) => Ok(Err(reason)),
        Err(PressureError::Sampling(reason)) => Ok(Err(reason.into())),
        Err(error) => Err(error),
    }
}

impl ComparisonResults {
    /// Returns the estimate of one method, if it has one.
    pub fn estimate(&self, method: PressureMethod) -> Option<&(PressureEstimate, Option<ReferenceDistances>)> {
        self.methods.iter().find(|result| result.method == method)?.outcome.as_ref().ok()
    }

    /// Returns the estimate of the reference or, without one, that of [`PressureMethod::Default`].
    ///
    /// # Errors
    /// The reason why there is no estimate.
    pub fn answer(&self) -> Result<&PressureEstimate, MethodError> {
        let default = self.methods.iter().find(|result| result.method == PressureMethod::Default);
        match (&self.reference, default) {
            (Some(reference), _) => Ok(&reference.estimate),
            (None, Some(result)) => result.outcome.as_ref().map(|(estimate, _)| estimate).map_err(Clone::clone),
            (None, None) => unreachable!("the default method is always used"),
        }
    }
}

#[cfg(test)]
mod tests;
