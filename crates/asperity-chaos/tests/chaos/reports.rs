//! Cases that users of other programs reported; docs/validation/reports.md lists them.

use asperity_chaos::{
    Basis, Candidates, Design, DriverError, Expansion, IndexError, LeastSquares, MultiIndexSet, PickFreeze,
    PolynomialFamily, RegressionError, Resamples, SamplingMethod, SparseError, SparseRegression, UncertainInput,
    UncertainInputs,
};
use asperity_testing::ISHIGAMI;

/// Returns independent inputs with these distributions.
fn inputs(distributions: &[&str]) -> UncertainInputs {
    let input =
        |(i, text): (usize, &&str)| UncertainInput::new(&format!("x{i}"), text.parse().unwrap(), false).unwrap();
    UncertainInputs::new(distributions.iter().enumerate().map(input).collect(), &[]).unwrap()
}

/// Returns standard variables of these families by the design.
fn points(method: SamplingMethod, seed: u64, samples: usize, families: &[PolynomialFamily]) -> Vec<Vec<f64>> {
    let design = Design::new(method, seed, "reports", samples, families.len()).unwrap();
    (0..samples)
        .map(|i| design.unit(i).iter().zip(families).map(|(u, family)| family.from_unit(*u)).collect())
        .collect()
}

#[test]
fn a_constant_output_has_no_variance_and_no_indices() {
    // SALib #344.
    let constant = |points: &[Vec<f64>]| vec![192.53; points.len()];
    let refused = PickFreeze::new(1).drivers(&inputs(&["normal"; 3]), &constant);
    assert_eq!(refused, Err(DriverError::Constant));
    let xi = points(SamplingMethod::Sobol, 1, 64, &[PolynomialFamily::Hermite; 3]);
    let (basis, values) = (Basis::hermite(3, 2).unwrap(), constant(&xi));
    let (expansion, _) = Expansion::fit(basis.clone(), &xi, &values).unwrap();
    assert_eq!((expansion.mean(), expansion.variance()), (192.53, 0.0));
    let fit = |rows: &[usize]| {
        let xi: Vec<&[f64]> = rows.iter().map(|row| xi[*row].as_slice()).collect();
        Expansion::fit(basis.clone(), &xi, &vec![192.53; rows.len()]).map(|(expansion, _)| expansion)
    };
    let resamples = Resamples { count: 50, level: 0.95, seed: 1 };
    assert_eq!(resamples.sobol_indices(values.len(), &[], &fit), Err(IndexError::Constant));
}

#[test]
fn a_product_of_lognormal_variables_has_its_closed_indices() {
    // SALib #102: S = (e^{σᵢ²} − 1)/(e^{Σσ²} − 1), T = 1 − (e^{Σσ² − σᵢ²} − 1)/(e^{Σσ²} − 1).
    let first = [0.066_879, 0.271_576, 0.626_685];
    let total = [0.076_164, 0.300_138, 0.658_815];
    let product = |z: &[f64]| (0.1 * z[0] + 0.2 * z[1] + 0.3 * z[2]).exp();
    // The terms above degree eight contain less than 1e-10 of the variance.
    let xi = points(SamplingMethod::Sobol, 1, 1024, &[PolynomialFamily::Hermite; 3]);
    let values: Vec<f64> = xi.iter().map(|z| product(z)).collect();
    let (expansion, _) = Expansion::fit(Basis::hermite(3, 8).unwrap(), &xi, &values).unwrap();
    let found = [(expansion.first_order_indices(), first), (expansion.total_indices(), total)];
    for (found, wanted) in found.into_iter().flat_map(|(found, wanted)| found.into_iter().zip(wanted)) {
        assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
    }
    let inputs = inputs(&["normal"; 3]);
    let each = |points: &[Vec<f64>]| points.iter().map(|z| product(z)).collect();
    let drivers = PickFreeze::new(1).drivers(&inputs, &each).unwrap();
    for (estimates, wanted) in [(drivers.first_order, first), (drivers.total, total)] {
        for (estimate, wanted) in estimates.iter().zip(wanted) {
            assert!((estimate.value - wanted).abs() < 4.0 * estimate.standard_error + 1e-6, "{estimate:?} {wanted}");
        }
    }
}

#[test]
fn the_interval_of_an_index_that_is_zero_contains_zero() {
    // SALib #601, chaospy #365: the first-order index of the third variable of Ishigami's function.
    let inputs = inputs(&["beta:1,1,-1,1"; 3]);
    let ishigami = |points: &[Vec<f64>]| points.iter().map(|z| (ISHIGAMI.evaluate)(&inputs.values(z))).collect();
    let drivers = PickFreeze::new(2).drivers(&inputs, &ishigami).unwrap();
    assert!(drivers.first_order[2].interval.contains(0.0), "{:?}", drivers.first_order[2]);
    for (estimate, wanted) in drivers.first_order.iter().zip(ISHIGAMI.first) {
        assert!((estimate.value - wanted).abs() < 4.0 * estimate.standard_error + 1e-8, "{estimate:?} {wanted}");
    }
}

#[test]
fn as_many_terms_as_points_have_no_error_estimate() {
    // OpenTURNS #2982.
    let xi = points(SamplingMethod::LatinHypercube, 1, 10, &[PolynomialFamily::Hermite; 3]);
    let basis = Basis::hermite(3, 2).unwrap();
    assert_eq!(basis.len(), 10);
    let values: Vec<f64> = xi.iter().map(|z| z[0] + z[1] * z[2]).collect();
    let refused = RegressionError::TooFewSamples { samples: 10, coefficients: 10 };
    assert_eq!(Expansion::fit(basis.clone(), &xi, &values).unwrap_err(), refused);
    let matrix = basis.design_matrix(&xi);
    assert_eq!(LeastSquares::new(matrix.clone()).unwrap_err(), refused);
    // The sparse regression keeps one sample for the error.
    let fit = SparseRegression::default().select(&Candidates::new(matrix.view()).unwrap(), &values).unwrap();
    assert!(fit.terms.len() < 10 && fit.cross_validated.is_finite());
    assert!(fit.leave_one_out.relative_error.is_none_or(f64::is_finite));
}

#[test]
fn few_samples_give_a_model_that_varies_or_an_error() {
    // OpenTURNS #2495: Ishigami's function at 60 points, 165 candidates.
    let families = vec![PolynomialFamily::Legendre; 3];
    let basis = Basis::new(MultiIndexSet::total_degree(3, 8).unwrap(), families.clone()).unwrap();
    let mut models = 0;
    for seed in 0..50 {
        let xi = points(SamplingMethod::LatinHypercube, seed, 60, &families);
        let values: Vec<f64> = xi.iter().map(|x| (ISHIGAMI.evaluate)(x)).collect();
        let matrix = basis.design_matrix(&xi);
        match SparseRegression::default().select(&Candidates::new(matrix.view()).unwrap(), &values) {
            Ok(fit) => {
                let variance = Expansion::new(basis.clone(), fit.dense(basis.len())).variance();
                assert!(variance > 0.0 && fit.cross_validated < 1.0, "{seed}: {variance}, {}", fit.cross_validated);
                assert!(fit.leave_one_out.relative_error.is_none_or(f64::is_finite));
                models += 1;
            }
            Err(SparseError::NothingPredicts { .. }) => {}
            Err(error) => panic!("{seed}: {error}"),
        }
    }
    assert!(models > 0);
}
