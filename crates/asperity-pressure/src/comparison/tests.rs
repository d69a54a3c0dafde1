use super::*;
use crate::sensitivity::VariableSet;
use crate::testing::{Shape, gaussian_surface};
use asperity_base::correlation::{CorrelationModel, Covariance};
use asperity_base::distribution::standard_normal_cdf;
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::Silent;
use asperity_chaos::{RegressionError, SamplingError};
use asperity_contact::{Boundary, Control, HalfSpace};
use asperity_surface::{RandomSurface, SpectralField};
use asperity_testing::kolmogorov_smirnov_to;

fn small_comparison() -> MethodComparison {
    let comparison = MethodComparison::new(5);
    MethodComparison {
        fine_solves: 120,
        reference_samples: 400,
        variables: 3,
        degree: 2,
        surrogate_samples: 2000,
        ..comparison
    }
}

/// Checks a case of known distribution.
///
/// A faint wave on a normal mean height is in full contact or in none, and a periodic half-space responds to its mean
/// overlap with p = (ξσ − d)/K₀.
fn shifted_wave(plane_m: f64, check: impl Fn(&Problem<'_>, &dyn Fn(f64) -> f64)) {
    let (std_m, compliance) = (2e-6, 4e-15);
    let grid = Grid::with_size(8, 8, 1e-4, 1e-4).unwrap();
    let wave = Shape::new(grid, std_m, |x, _| 1e-12 * (std::f64::consts::TAU * x / 1e-4).cos());
    let boundary = Boundary::Periodic { mean_compliance_m_per_pa: compliance };
    let half_space = HalfSpace::new(grid, 2e11, boundary).unwrap();
    let problem = Problem::new(&wave, &half_space, Control::Plane { height_m: plane_m }, None).unwrap();
    check(&problem, &|p_pa| {
        if p_pa < 0.0 { 0.0 } else { standard_normal_cdf((plane_m + compliance * p_pa) / std_m) }
    });
}

#[test]
fn every_sampler_finds_the_known_distribution_of_a_shifted_wave() {
    shifted_wave(0.7e-6, |problem, cdf| {
        let results = MethodComparison { variables: 1, ..small_comparison() }.run(problem, &Silent).unwrap();
        let distance = |found: &DiscreteDistribution| kolmogorov_smirnov_to(found.values(), found.cumulative(), cdf);
        // 99.99 % point of √n D: 2.23.
        let reference = distance(&results.reference.as_ref().unwrap().estimate.distribution);
        assert!(reference < 2.23 / 400.0_f64.sqrt(), "reference {reference:.4}");
        for method in
            [PressureMethod::MonteCarlo, PressureMethod::LatinHypercube, PressureMethod::Sobol, PressureMethod::Default]
        {
            let (estimate, _) = results.estimate(method).unwrap();
            let distance = distance(&estimate.distribution);
            assert!(distance < 2.23 / 120.0_f64.sqrt(), "{} {distance:.4}", method.name());
            let error = estimate.contact_probability - (1.0 - cdf(0.0));
            assert!(error.abs() < 4.0 * estimate.contact_probability_se, "{} {error:.4}", method.name());
        }
        // In one variable, each of the ten designs of twelve samples places the point mass to within one stratum.
        for method in [PressureMethod::LatinHypercube, PressureMethod::Sobol] {
            let error = results.estimate(method).unwrap().0.contact_probability - (1.0 - cdf(0.0));
            assert!(error.abs() <= 1.0 / 12.0, "{} {error:.4}", method.name());
        }
    });
}

#[test]
fn the_published_expansion_finds_a_linear_pressure_and_counts_its_point_mass_twice() {
    shifted_wave(0.7e-6, |problem, cdf| {
        let comparison = MethodComparison { variables: 1, degree: 1, surrogate_samples: 20_000, ..small_comparison() };
        let results = comparison.run(problem, &Silent).unwrap();
        let (estimate, _) = results.estimate(PressureMethod::PolynomialChaos).unwrap();
        // In contact p is exactly linear in ξ, up to the faint wave.
        assert!(estimate.leave_one_out_error.unwrap() < 1e-8);
        // Samples out of contact enter F_c as well: F(0) = 1 − P + P·Φ(d/σ).
        let p = estimate.contact_probability;
        let wanted = 1.0 - p + p * cdf(0.0);
        let bound = 4.0 * p * (0.25_f64 / 20_000.0).sqrt() + 1e-3;
        assert!((estimate.distribution.cdf(0.0) - wanted).abs() < bound, "{} {wanted}", estimate.distribution.cdf(0.0));
    });
}

#[test]
fn a_centre_cell_is_in_contact_at_most_half_the_time_at_the_median_plane() {
    let (surface, half_space) = gaussian_surface(16, 30);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let results = small_comparison().run(&problem, &Silent).unwrap();
    let reference = results.reference.as_ref().unwrap();
    assert!(reference.estimate.contact_probability < 0.5 + 4.0 * reference.estimate.contact_probability_se);
    assert!(reference.estimate.contact_probability > 0.02);
    let (controlled, _) = results.estimate(PressureMethod::Default).unwrap();
    let (plain, _) = results.estimate(PressureMethod::MonteCarlo).unwrap();
    assert!(controlled.contact_probability_se < 0.8 * plain.contact_probability_se);
    let error = controlled.contact_probability - reference.estimate.contact_probability;
    let se = controlled.contact_probability_se.hypot(reference.estimate.contact_probability_se);
    assert!(error.abs() < 4.0 * se, "{error:.4} ± {se:.4}");
}

#[test]
fn every_statistic_of_every_method_keeps_to_the_hardness() {
    let (surface, half_space) = gaussian_surface(16, 30);
    let hardness = 1.3;
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, Some(hardness)).unwrap();
    let sizes = MethodComparison { fine_solves: 200, ..small_comparison() };
    let results = sizes.run(&problem, &Silent).unwrap();
    let within = |what: &str, method: &str, values: &[f64]| {
        assert!(values.iter().all(|p| (0.0..=hardness).contains(p)), "{what} by {method}: {values:?}");
    };
    let found = results.methods.iter().filter_map(|r| Some((r.method.name(), &r.outcome.as_ref().ok()?.0)));
    let mut methods = 0;
    for (name, estimate) in found.chain([("reference", &results.reference.as_ref().unwrap().estimate)]) {
        methods += 1;
        within("distribution", name, &[estimate.distribution.quantile(0.0), estimate.distribution.quantile(1.0)]);
        let mean = estimate.mean_interval_pa().unwrap();
        within("mean", name, &[estimate.mean_pa, mean.low, mean.high]);
        within("band", name, &estimate.band.as_ref().unwrap().values);
        for probability in PROBABILITIES {
            let interval = estimate.quantile_interval_pa(probability).unwrap();
            within("quantile", name, &[estimate.distribution.quantile(probability), interval.low, interval.high]);
        }
    }
    assert_eq!(methods, PressureMethod::ALL.len() + 1);
    // Scalars of the contact respect their own limits.
    for (quantity, largest) in [(Quantity::ContactFraction, 1.0), (Quantity::MeanPressure, hardness)] {
        let scalar = scalar(&results, quantity).unwrap();
        let values =
            [scalar.mean, scalar.mean_interval.low, scalar.mean_interval.high, scalar.distribution.quantile(1.0)];
        assert!(values.iter().all(|value| (0.0..=largest).contains(value)), "{scalar:?}");
    }
}

#[test]
#[ignore = "slow"]
fn cells_of_a_free_patch_differ_and_the_height_of_the_cell_matters_most() {
    let (surface, half_space) = gaussian_surface(16, 30);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let sizes = MethodComparison { fine_solves: 400, reference_samples: 100, ..small_comparison() };
    let results = sizes.run(&problem, &Silent).unwrap();
    let fields = results.fields.as_ref().unwrap();
    let p_value = fields.homogeneity.as_ref().unwrap().p_value;
    assert!(p_value < 0.05, "{p_value}");
    // The same samples, evaluated for the cell alone.
    let (plain, _) = results.estimate(PressureMethod::MonteCarlo).unwrap();
    assert_eq!(fields.contact_probability[[8, 8]], plain.contact_probability);
    assert!((fields.mean_pa[[8, 8]] - plain.mean_pa).abs() < 1e-6 * plain.mean_pa);
    let explained = |set: VariableSet| {
        let wanted = |s: &&Sensitivity| (s.quantity, s.variables) == (Quantity::Pressure, set);
        results.sensitivities.iter().find(wanted).unwrap().outcome.as_ref().unwrap()
    };
    let (local, global) = (explained(VariableSet::Local), explained(VariableSet::Global));
    assert_eq!(local.names[0], "height of the cell");
    assert!(local.indices.total[1..].iter().all(|other| other.value < local.indices.total[0].value));
    // Three leading modes explain less of one cell than its own surroundings.
    assert!(local.cross_validated_error.unwrap() < global.cross_validated_error.unwrap());
}

#[test]
fn cells_of_a_stationary_periodic_patch_are_pooled() {
    let grid = Grid::with_size(16, 16, 1.0, 1.0).unwrap();
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 0.2, 0.2).unwrap();
    let surface = SpectralField::periodic(&covariance, grid);
    let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.3 };
    let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.3 }, None).unwrap();
    assert!(problem.cells_are_alike());
    let sizes = MethodComparison { fine_solves: 170, reference_samples: 170, ..small_comparison() };
    let results = sizes.run(&problem, &Silent).unwrap();
    let homogeneity = results.fields.as_ref().unwrap().homogeneity.as_ref().unwrap();
    assert_eq!((homogeneity.cells, homogeneity.samples), (16, 170));
    assert!(homogeneity.p_value > 1e-3, "{homogeneity:?}");
    // The reference pools the cells of each solution.
    assert_eq!(results.reference.as_ref().unwrap().sites, 256);
    let (plain, reference) =
        (&results.estimate(PressureMethod::MonteCarlo).unwrap().0, &results.reference.as_ref().unwrap().estimate);
    let se = plain.contact_probability_se.hypot(reference.contact_probability_se);
    assert!((plain.contact_probability - reference.contact_probability).abs() < 4.0 * se);
    assert!(reference.contact_probability_se < 0.6 * plain.contact_probability_se);
    let (local, comparison) = results.estimate(PressureMethod::PolynomialChaosLocal).unwrap();
    assert!(local.band.is_some() && local.mean_se_pa > 0.0 && comparison.as_ref().unwrap().ks_distance < 0.3);
}

#[test]
fn too_few_samples_in_contact_are_a_recorded_reason() {
    let (surface, half_space) = gaussian_surface(16, 30);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let comparison = MethodComparison { fine_solves: 60, variables: 8, degree: 3, ..small_comparison() };
    let results = comparison.run(&problem, &Silent).unwrap();
    let latin = results.estimate(PressureMethod::LatinHypercube).unwrap();
    let in_contact = (latin.0.contact_probability * 60.0).round() as usize;
    for method in [PressureMethod::PolynomialChaos, PressureMethod::PolynomialChaosLog] {
        let result = results.methods.iter().find(|r| r.method == method).unwrap();
        let wanted = RegressionError::TooFewSamples { samples: in_contact, coefficients: 165 };
        assert_eq!(result.outcome.as_ref().unwrap_err(), &MethodError::Regression(wanted));
        assert_eq!(result.fine_solves, 60);
    }
}

#[test]
fn more_xi_variables_than_sobol_points_have_are_a_recorded_reason() {
    /// Surface with unused trailing variables ξ.
    struct LongXi<'a>(&'a dyn RandomSurface);
    impl RandomSurface for LongXi<'_> {
        fn xi_len(&self) -> usize {
            2000
        }
        fn grid(&self) -> Grid {
            self.0.grid()
        }
        fn generate(&self, xi: &[f64]) -> HeightMap {
            self.0.generate(&xi[..self.0.xi_len()])
        }
    }
    let (surface, half_space) = gaussian_surface(8, 6);
    let surface = LongXi(&surface);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let sizes =
        MethodComparison { fine_solves: 40, reference_samples: 40, surrogate_samples: 100, ..small_comparison() };
    let results = sizes.run(&problem, &Silent).unwrap();
    let sobol = results.methods.iter().find(|r| r.method == PressureMethod::Sobol).unwrap();
    let wanted = SamplingError::TooManyDimensions { dimensions: 2000, limit: 1867 };
    assert_eq!(sobol.outcome, Err(MethodError::Sampling(wanted)));
    assert_eq!(sobol.fine_solves, 0);
    assert!(results.estimate(PressureMethod::LatinHypercube).is_some());
}

#[test]
fn sizes_out_of_range_are_rejected() {
    let (surface, half_space) = gaussian_surface(8, 4);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let error = MethodComparison { variables: 5, ..small_comparison() }.run(&problem, &Silent).unwrap_err();
    assert!(matches!(error, PressureError::Parameter { parameter: "variables", .. }));
    let error = MethodComparison { valid_fraction: 0.0, ..small_comparison() }.run(&problem, &Silent).unwrap_err();
    assert!(matches!(error, PressureError::Parameter { parameter: "valid_share", .. }));
}

#[test]
fn a_coarse_model_of_one_height_is_excluded() {
    // Every fourth point of the wave is a crest.
    let grid = Grid::new(32, 32, 1.0, 1.0).unwrap();
    let wave = Shape::new(grid, 1.0, |x, _| (std::f64::consts::FRAC_PI_2 * (x - 0.5)).cos());
    let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 1.0 };
    let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
    let problem = Problem::new(&wave, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let comparison = MethodComparison { fine_solves: 60, variables: 1, ..small_comparison() };
    let (estimate, coarse) = comparison.estimate_default(&problem, &Silent).unwrap();
    assert!(coarse.iter().all(|model| model.shape != (8, 8)), "{coarse:?}");
    // A crest touches when ξ > −1.
    let error = estimate.contact_probability - standard_normal_cdf(1.0);
    assert!(error.abs() < 4.0 * (0.16 * 0.84_f64 / 60.0).sqrt(), "{error}");
    let few = MethodComparison { fine_solves: 4, ..comparison };
    assert!(matches!(
        few.estimate_default(&problem, &Silent),
        Err(PressureError::Method(MethodError::TooFewSamples { .. }))
    ));
}

fn scalar(results: &ComparisonResults, quantity: Quantity) -> Option<&ScalarResult> {
    results.scalars.iter().find(|scalar| scalar.quantity == quantity)
}

#[test]
fn the_stiffness_of_a_shifted_wave_is_that_of_its_mean_mode_or_none() {
    shifted_wave(0.7e-6, |problem, cdf| {
        let results =
            MethodComparison { variables: 1, stiffness: true, ..small_comparison() }.run(problem, &Silent).unwrap();
        let stiffness = scalar(&results, Quantity::Stiffness).unwrap();
        // Mean compliance 4e-15 m/Pa.
        let wanted = (1.0 - cdf(0.0)) / 4e-15;
        assert!((stiffness.mean - wanted).abs() < 4.0 * stiffness.mean_se, "{stiffness:?}");
        assert!(stiffness.mean_se < 0.5 * wanted);
        assert_eq!((stiffness.distribution.quantile(0.1), stiffness.distribution.quantile(0.9)), (0.0, 1.0 / 4e-15));
    });
}

#[test]
#[ignore = "slow"]
fn the_stiffness_is_one_more_scalar_and_changes_nothing_else() {
    let (surface, half_space) = gaussian_surface(16, 30);
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.3 }, Some(2.0)).unwrap();
    let comparison =
        MethodComparison { fine_solves: 200, reference_samples: 60, surrogate_samples: 500, ..small_comparison() };
    let without = comparison.run(&problem, &Silent).unwrap();
    let with = MethodComparison { stiffness: true, ..comparison }.run(&problem, &Silent).unwrap();
    let stiffness = scalar(&with, Quantity::Stiffness).unwrap();
    assert!(scalar(&without, Quantity::Stiffness).is_none());
    // Independent samples of the same contacts, without a model.
    let sampling = Sampling::monte_carlo(77, "stiffness", 2000, 0.95);
    let samples = solve(&problem.with_stiffness(), sampling, &Silent).unwrap();
    let values: Vec<f64> = samples.observations().iter().map(|o| o.stiffness_pa_per_m.unwrap()).collect();
    let plain = DiscreteDistribution::empirical(&values).unwrap();
    let se = stiffness.mean_se.hypot(plain.std() / (values.len() as f64).sqrt());
    assert!((stiffness.mean - plain.mean()).abs() < 4.0 * se, "{} {} ± {se}", stiffness.mean, plain.mean());
    // Coarse grids and the variables ξ reduce the variance.
    assert!(stiffness.mean_se < 0.9 * plain.std() / 200.0_f64.sqrt(), "{} {}", stiffness.mean_se, plain.std());
    let rest: Vec<ScalarResult> =
        with.scalars.iter().filter(|scalar| scalar.quantity != Quantity::Stiffness).cloned().collect();
    assert_eq!(ComparisonResults { scalars: rest, ..with }, without);
}
