//! Several estimates of one law, each from the same number of contact solutions, against their own reference.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use thiserror::Error;

use crate::chaos::distance::{kolmogorov_smirnov, wasserstein_1};
use crate::chaos::{Basis, BasisError, Design, DistanceError, RegressionError, SamplingError, SamplingMethod, StepLaw};
use crate::monitor::{Cancelled, Monitor};
use crate::pressure::controlled;
use crate::pressure::expansion::{self, Response};
use crate::pressure::local::LocalVariables;
use crate::pressure::{Failure, Observation, PressureError, Problem, Samples, solve};

/// How the law of the pressure is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The empirical law of independent samples.
    MonteCarlo,
    /// The empirical law of a Latin hypercube.
    LatinHypercube,
    /// The empirical law of scrambled Sobol' points.
    Sobol,
    /// Eq. (8): a chaos expansion of the pressure in contact in the leading germ variables, on the Latin hypercube.
    PolynomialChaos,
    /// Eq. (9): the same of the logarithm of the pressure in contact.
    PolynomialChaosLog,
    /// Ours: the Monte Carlo samples, corrected by an expansion of the latent pressure in the local heights that serves
    /// as control variate.
    Default,
}

impl Method {
    /// All methods, in the order of reports.
    pub const ALL: [Self; 6] = [
        Self::MonteCarlo,
        Self::LatinHypercube,
        Self::Sobol,
        Self::PolynomialChaos,
        Self::PolynomialChaosLog,
        Self::Default,
    ];

    /// The name in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MonteCarlo => "monte_carlo",
            Self::LatinHypercube => "latin_hypercube",
            Self::Sobol => "sobol",
            Self::PolynomialChaos => "polynomial_chaos",
            Self::PolynomialChaosLog => "polynomial_chaos_log",
            Self::Default => "default",
        }
    }
}

/// What is estimated how well: sizes of the runs. Runs of one seed are independent of each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Study {
    /// Seed of all runs.
    pub seed: u64,
    /// Contact solutions of each method.
    pub fine_solves: usize,
    /// Contact solutions of the Monte Carlo reference.
    pub reference_samples: usize,
    /// Variables of the expansions: leading germ variables, or local variables of the default method.
    pub variables: usize,
    /// Total degree of the expansions; for the default method the largest one tried.
    pub degree: usize,
    /// Evaluations of an expansion on fresh germs.
    pub surrogate_samples: usize,
    /// Least share of converged contact problems in a run.
    pub valid_share: f64,
}

/// A law and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The law of the pressure in pascal, with its atom at 0.
    pub law: StepLaw,
    /// P(contact). For the paper's expansions it is K/K_t, whatever part of the expansion is clipped to 0.
    pub contact_probability: f64,
    /// Its standard error (see [`Samples::contact_probability_se`]).
    pub contact_probability_se: f64,
    /// Number of coefficients of the expansion, if any.
    pub coefficients: Option<usize>,
    /// Mean square leave-one-out error of the expanded quantity over its variance, if any. Above 1 the expansion
    /// predicts worse than the mean.
    pub leave_one_out_error: Option<f64>,
}

/// Why a method has no estimate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MethodError {
    /// The expansion could not be fitted to the samples in contact.
    #[error("no expansion: {0}")]
    Regression(#[from] RegressionError),
    /// The basis could not be made.
    #[error("no expansion: {0}")]
    Basis(#[from] BasisError),
    /// The design does not exist.
    #[error(transparent)]
    Sampling(#[from] SamplingError),
    /// A law could not be made from its values.
    #[error(transparent)]
    Law(#[from] DistanceError),
    /// The expansion of the logarithm exceeds the largest floating-point number.
    #[error("the expansion overflows on {overflowed} of {evaluations} fresh germs")]
    Overflow {
        /// Germs on which it overflows.
        overflowed: usize,
        /// Germs evaluated.
        evaluations: usize,
    },
    /// Too few of the fresh maps are complete.
    #[error("only {valid} of {maps} fresh maps have local variables")]
    FreshMaps {
        /// Maps with local variables.
        valid: usize,
        /// Maps generated.
        maps: usize,
    },
    /// Neither the pressure nor the gap varies, or too few samples exist to see it.
    #[error("the samples show no variation that an expansion could explain")]
    NoVariation,
}

/// Distances between an estimated law and the reference law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Kolmogorov–Smirnov distance.
    pub ks_distance: f64,
    /// Wasserstein-1 distance divided by the standard deviation of the reference law, atom at 0 included; `None` when that
    /// is 0.
    pub wasserstein_1_over_std: Option<f64>,
}

/// One method's answer.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodResult {
    /// The method.
    pub method: Method,
    /// Contact solutions on which it rests, failed ones included.
    pub fine_solves: usize,
    /// Those without an answer.
    pub failures: Vec<Failure>,
    /// The estimate with its distances from the reference, or why there is none.
    pub outcome: Result<(Estimate, Comparison), MethodError>,
}

/// The Monte Carlo law that the methods are measured against.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Contact solutions, failed ones included.
    pub samples: usize,
    /// Those without an answer.
    pub failures: Vec<Failure>,
    /// The empirical law in pascal.
    pub law: StepLaw,
    /// P(contact).
    pub contact_probability: f64,
    /// Its standard error.
    pub contact_probability_se: f64,
    /// 95 % point 1.358/√n of the Kolmogorov–Smirnov distance between the reference and the true law: smaller
    /// distances are not resolved.
    pub ks_resolution: f64,
}

/// Everything a study of one pressure found.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// The reference.
    pub reference: Reference,
    /// One entry for each of [`Method::ALL`].
    pub methods: Vec<MethodResult>,
}

impl Study {
    /// The customary sizes: 500 solutions for each method, 5,000 for the reference, total degree 3 in 8 variables.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            fine_solves: 500,
            reference_samples: 5000,
            variables: 8,
            degree: 3,
            surrogate_samples: 10_000,
            valid_share: 0.95,
        }
    }

    /// Estimates the law of the pressure of `problem` by every method.
    ///
    /// # Errors
    /// A size is out of range, too few contact problems of a run converged, or the monitor cancelled.
    pub fn run(&self, problem: &Problem<'_>, monitor: &dyn Monitor) -> Result<Results, PressureError> {
        self.validate(problem)?;
        let reference = self.sample(problem, SamplingMethod::MonteCarlo, "pressure/reference", monitor)?;
        let reference = Reference {
            samples: reference.posed(),
            law: reference.law()?,
            contact_probability: reference.contact_probability(),
            contact_probability_se: reference.contact_probability_se(),
            ks_resolution: 1.358 / (reference.len() as f64).sqrt(),
            failures: reference.failures().to_vec(),
        };
        let monte_carlo = self.sample(problem, SamplingMethod::MonteCarlo, "pressure/monte_carlo", monitor)?;
        let latin = self.sample(problem, SamplingMethod::LatinHypercube, "pressure/latin_hypercube", monitor)?;
        let sobol = match self.sample(problem, SamplingMethod::Sobol, "pressure/sobol", monitor) {
            Err(PressureError::Sampling(reason)) => Err(MethodError::from(reason)),
            Err(error) => return Err(error),
            Ok(samples) => Ok(samples),
        };
        let fresh = self.fresh_germs(self.variables)?;
        let basis = Basis::hermite(self.variables, self.degree)?;
        let mut methods = Vec::with_capacity(Method::ALL.len());
        for method in Method::ALL {
            let (samples, estimate) = match method {
                Method::MonteCarlo => (Some(&monte_carlo), Ok(empirical(&monte_carlo)?)),
                Method::LatinHypercube => (Some(&latin), Ok(empirical(&latin)?)),
                Method::Sobol => match &sobol {
                    Ok(samples) => (Some(samples), Ok(empirical(samples)?)),
                    Err(reason) => (None, Err(reason.clone())),
                },
                Method::PolynomialChaos => {
                    (Some(&latin), expansion::estimate(Response::Pressure, &latin, basis.clone(), &fresh))
                }
                Method::PolynomialChaosLog => {
                    (Some(&latin), expansion::estimate(Response::Logarithm, &latin, basis.clone(), &fresh))
                }
                Method::Default => {
                    (Some(&monte_carlo), self.local_variables(problem, &monte_carlo, monitor)?.estimate(self, problem))
                }
            };
            methods.push(MethodResult {
                method,
                fine_solves: samples.map_or(0, Samples::posed),
                failures: samples.map_or_else(Vec::new, |samples| samples.failures().to_vec()),
                outcome: estimate.map(|estimate| {
                    let comparison = Comparison::between(&estimate.law, &reference.law);
                    (estimate, comparison)
                }),
            });
        }
        Ok(Results { reference, methods })
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
        at_least("reference_samples", self.reference_samples, 2, "at least 2")?;
        at_least("surrogate_samples", self.surrogate_samples, 2, "at least 2")?;
        at_least("variables", self.variables, 1, "at least 1")?;
        if self.variables > problem.surface().germ_len() {
            return Err(PressureError::Parameter {
                parameter: "variables",
                value: self.variables as f64,
                wanted: "at most the number of germ variables of the surface",
            });
        }
        if !(self.valid_share > 0.0 && self.valid_share <= 1.0) {
            return Err(PressureError::Parameter {
                parameter: "valid_share",
                value: self.valid_share,
                wanted: "above 0 and at most 1",
            });
        }
        Ok(())
    }

    fn sample(
        &self,
        problem: &Problem<'_>,
        method: SamplingMethod,
        stage: &str,
        monitor: &dyn Monitor,
    ) -> Result<Samples, PressureError> {
        let samples = if stage.ends_with("reference") { self.reference_samples } else { self.fine_solves };
        solve(problem, method, self.seed, stage, samples, self.valid_share, monitor)
    }

    /// Germs on which expansions are evaluated.
    fn fresh_germs(&self, variables: usize) -> Result<Vec<Vec<f64>>, PressureError> {
        let design = self.fresh_design("pressure/expansion", variables)?;
        Ok((0..design.samples()).map(|i| design.germ(i)).collect())
    }

    fn fresh_design(&self, stage: &str, variables: usize) -> Result<Design, PressureError> {
        Ok(Design::new(SamplingMethod::MonteCarlo, self.seed, stage, self.surrogate_samples, variables)?)
    }

    /// Local variables of the solved samples and of fresh maps.
    fn local_variables(
        &self,
        problem: &Problem<'_>,
        samples: &Samples,
        monitor: &dyn Monitor,
    ) -> Result<Local, PressureError> {
        let separations_m = samples.observations().iter().map(|o| o.separation_m);
        let local = LocalVariables::new(problem, self.variables, separations_m.sum::<f64>() / samples.len() as f64);
        let design = self.fresh_design("pressure/local", problem.surface().germ_len())?;
        let (solved, total) = (samples.len(), samples.len() + design.samples());
        let done = AtomicUsize::new(0);
        let rows: Vec<Option<Vec<f64>>> = (0..total)
            .into_par_iter()
            .map(|i| {
                if monitor.cancelled() {
                    return Err(Cancelled);
                }
                let germ = if i < solved { samples.germ(i) } else { design.germ(i - solved) };
                let row = local.of(&problem.surface().generate(&germ));
                monitor.progress("pressure/local", done.fetch_add(1, Ordering::Relaxed) + 1, total);
                Ok(row)
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut rows = rows.into_iter();
        let (fine, observed) = samples
            .observations()
            .iter()
            .zip(rows.by_ref().take(solved))
            .filter_map(|(observation, row)| Some((row?, *observation)))
            .unzip();
        Ok(Local { fine, observed, fresh: rows.flatten().collect(), maps: design.samples() })
    }
}

/// What the default method is estimated from.
struct Local {
    fine: Vec<Vec<f64>>,
    observed: Vec<Observation>,
    fresh: Vec<Vec<f64>>,
    /// Fresh maps generated.
    maps: usize,
}

impl Local {
    fn estimate(&self, study: &Study, problem: &Problem<'_>) -> Result<Estimate, MethodError> {
        let (valid, maps) = (self.fresh.len(), self.maps);
        if (valid as f64) < study.valid_share * maps as f64 {
            return Err(MethodError::FreshMaps { valid, maps });
        }
        let latent = controlled::latent(&self.observed);
        controlled::estimate(&self.fine, &latent, &self.fresh, study.degree, problem.hardness_pa())
    }
}

/// The empirical law of a run.
fn empirical(samples: &Samples) -> Result<Estimate, PressureError> {
    Ok(Estimate {
        law: samples.law()?,
        contact_probability: samples.contact_probability(),
        contact_probability_se: samples.contact_probability_se(),
        coefficients: None,
        leave_one_out_error: None,
    })
}

impl Comparison {
    fn between(law: &StepLaw, reference: &StepLaw) -> Self {
        let std = reference.std();
        Self {
            ks_distance: kolmogorov_smirnov(law, reference),
            wasserstein_1_over_std: (std > 0.0).then(|| wasserstein_1(law, reference) / std),
        }
    }
}

impl Results {
    /// The estimate of one method, if it has one.
    pub fn estimate(&self, method: Method) -> Option<&(Estimate, Comparison)> {
        self.methods.iter().find(|result| result.method == method)?.outcome.as_ref().ok()
    }

    /// `points` pressures in pascal, equally spaced from 0 to the largest of the reference.
    pub fn common_grid_pa(&self, points: usize) -> Vec<f64> {
        let largest = self.reference.law.quantile(1.0);
        (0..points).map(|i| largest * i as f64 / (points.max(2) - 1) as f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::distance::kolmogorov_smirnov_to;
    use crate::contact::{Boundary, Control, HalfSpace};
    use crate::law::standard_normal_cdf;
    use crate::map::{Grid, HeightMap};
    use crate::monitor::Silent;
    use crate::pressure::testing::{Shape, gaussian_surface};
    use crate::surface::RandomSurface;

    fn small_study() -> Study {
        let study = Study::new(5);
        Study { fine_solves: 120, reference_samples: 400, variables: 3, degree: 2, surrogate_samples: 2000, ..study }
    }

    /// A faint wave that rides on a normal mean height is in full contact or in none, and a periodic half-space answers
    /// its mean overlap by p = (ξσ − d)/K₀: the law of the pressure is known.
    fn shifted_wave(plane_m: f64, check: impl Fn(&Problem<'_>, &dyn Fn(f64) -> f64)) {
        let (std_m, compliance) = (2e-6, 4e-15);
        let grid = Grid::covering(8, 8, 1e-4, 1e-4).unwrap();
        let wave = Shape::new(grid, std_m, |x, _| 1e-12 * (std::f64::consts::TAU * x / 1e-4).cos());
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: compliance };
        let half_space = HalfSpace::new(grid, 2e11, boundary).unwrap();
        let problem = Problem::new(&wave, &half_space, Control::Plane { height_m: plane_m }, None).unwrap();
        check(&problem, &|p_pa| {
            if p_pa < 0.0 { 0.0 } else { standard_normal_cdf((plane_m + compliance * p_pa) / std_m) }
        });
    }

    #[test]
    fn every_sampler_finds_the_known_law_of_a_shifted_wave() {
        shifted_wave(0.7e-6, |problem, cdf| {
            let results = Study { variables: 1, ..small_study() }.run(problem, &Silent).unwrap();
            let left = |p: f64| if p <= 0.0 { 0.0 } else { cdf(p) };
            // 99.99 % point of √n D: 2.23.
            let distance = kolmogorov_smirnov_to(&results.reference.law, cdf, left);
            assert!(distance < 2.23 / 400.0_f64.sqrt(), "reference {distance:.4}");
            for method in [Method::MonteCarlo, Method::LatinHypercube, Method::Sobol, Method::Default] {
                let (estimate, _) = results.estimate(method).unwrap();
                let distance = kolmogorov_smirnov_to(&estimate.law, cdf, left);
                assert!(distance < 2.23 / 120.0_f64.sqrt(), "{} {distance:.4}", method.name());
                let error = estimate.contact_probability - (1.0 - cdf(0.0));
                assert!(error.abs() < 4.0 * estimate.contact_probability_se, "{} {error:.4}", method.name());
            }
            // In one variable both stratified designs put the atom in its place to within one stratum.
            for method in [Method::LatinHypercube, Method::Sobol] {
                let error = results.estimate(method).unwrap().0.contact_probability - (1.0 - cdf(0.0));
                assert!(error.abs() <= 1.0 / 64.0, "{} {error:.4}", method.name());
            }
        });
    }

    #[test]
    fn the_papers_expansion_finds_a_linear_pressure_and_counts_its_atom_twice() {
        shifted_wave(0.7e-6, |problem, cdf| {
            let study = Study { variables: 1, degree: 1, surrogate_samples: 20_000, ..small_study() };
            let results = study.run(problem, &Silent).unwrap();
            let (estimate, _) = results.estimate(Method::PolynomialChaos).unwrap();
            // In contact p is exactly linear in ξ, up to the faint wave ...
            assert!(estimate.leave_one_out_error.unwrap() < 1e-8);
            // ... but germs out of contact enter F_c as well: F(0) = 1 − P + P·Φ(d/σ).
            let p = estimate.contact_probability;
            let wanted = 1.0 - p + p * cdf(0.0);
            let bound = 4.0 * p * (0.25_f64 / 20_000.0).sqrt() + 1e-3;
            assert!((estimate.law.cdf(0.0) - wanted).abs() < bound, "{} {wanted}", estimate.law.cdf(0.0));
        });
    }

    #[test]
    fn a_centre_cell_is_in_contact_at_most_half_the_time_at_the_median_plane() {
        let (surface, half_space) = gaussian_surface(16, 30);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let results = small_study().run(&problem, &Silent).unwrap();
        let reference = &results.reference;
        assert!(reference.contact_probability < 0.5 + 4.0 * reference.contact_probability_se);
        assert!(reference.contact_probability > 0.02);
        let (controlled, _) = results.estimate(Method::Default).unwrap();
        let (plain, _) = results.estimate(Method::MonteCarlo).unwrap();
        assert!(controlled.contact_probability_se < 0.8 * plain.contact_probability_se);
        let error = controlled.contact_probability - reference.contact_probability;
        let se = controlled.contact_probability_se.hypot(reference.contact_probability_se);
        assert!(error.abs() < 4.0 * se, "{error:.4} ± {se:.4}");
        let grid_pa = results.common_grid_pa(11);
        assert_eq!((grid_pa[0], grid_pa[10]), (0.0, reference.law.quantile(1.0)));
    }

    #[test]
    fn too_few_samples_in_contact_are_a_recorded_reason() {
        let (surface, half_space) = gaussian_surface(16, 30);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let study = Study { fine_solves: 60, variables: 8, degree: 3, ..small_study() };
        let results = study.run(&problem, &Silent).unwrap();
        let latin = results.estimate(Method::LatinHypercube).unwrap();
        let in_contact = (latin.0.contact_probability * 60.0).round() as usize;
        for method in [Method::PolynomialChaos, Method::PolynomialChaosLog] {
            let result = results.methods.iter().find(|r| r.method == method).unwrap();
            let wanted = RegressionError::TooFewSamples { samples: in_contact, coefficients: 165 };
            assert_eq!(result.outcome.as_ref().unwrap_err(), &MethodError::Regression(wanted));
            assert_eq!(result.fine_solves, 60);
        }
    }

    #[test]
    fn a_study_is_the_same_on_one_thread_and_on_two() {
        let (surface, half_space) = gaussian_surface(16, 30);
        let control = Control::MeanPressure { pascal: 0.02 };
        let problem = Problem::new(&surface, &half_space, control, Some(2.0)).unwrap();
        let study = Study { fine_solves: 60, reference_samples: 60, surrogate_samples: 500, ..small_study() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| study.run(&problem, &Silent)).unwrap()
        };
        assert_eq!(on(1), on(2));
    }

    #[test]
    fn more_germ_variables_than_sobol_points_have_are_a_recorded_reason() {
        /// A germ whose tail is idle.
        struct LongGerm<'a>(&'a dyn RandomSurface);
        impl RandomSurface for LongGerm<'_> {
            fn germ_len(&self) -> usize {
                2000
            }
            fn grid(&self) -> Grid {
                self.0.grid()
            }
            fn generate(&self, germ: &[f64]) -> HeightMap {
                self.0.generate(&germ[..self.0.germ_len()])
            }
        }
        let (surface, half_space) = gaussian_surface(8, 6);
        let surface = LongGerm(&surface);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let sizes = Study { fine_solves: 40, reference_samples: 40, surrogate_samples: 100, ..small_study() };
        let results = sizes.run(&problem, &Silent).unwrap();
        let sobol = results.methods.iter().find(|r| r.method == Method::Sobol).unwrap();
        let wanted = SamplingError::TooManyDimensions { dimensions: 2000, limit: 1867 };
        assert_eq!(sobol.outcome, Err(MethodError::Sampling(wanted)));
        assert_eq!(sobol.fine_solves, 0);
        assert!(results.estimate(Method::LatinHypercube).is_some());
    }

    #[test]
    fn sizes_out_of_range_are_refused() {
        let (surface, half_space) = gaussian_surface(8, 4);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let error = Study { variables: 5, ..small_study() }.run(&problem, &Silent).unwrap_err();
        assert!(matches!(error, PressureError::Parameter { parameter: "variables", .. }));
        let error = Study { valid_share: 0.0, ..small_study() }.run(&problem, &Silent).unwrap_err();
        assert!(matches!(error, PressureError::Parameter { parameter: "valid_share", .. }));
    }
}
