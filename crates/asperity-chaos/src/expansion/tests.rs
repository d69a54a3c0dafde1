use super::*;
use crate::{Candidates, Design, MultiIndexSet, PolynomialFamily, SamplingMethod, SparseRegression, Truncation};
use asperity_base::random;
use asperity_testing::{BOREHOLE, ISHIGAMI, SOBOL_G};
use rand::RngExt;

/// Returns the expansion of f over a Sobol' design, where f is a function of the standard variables.
fn expand(
    families: &[PolynomialFamily],
    degree: usize,
    samples: usize,
    f: impl Fn(&[f64]) -> f64,
) -> (Expansion, LeastSquaresFit) {
    let set = MultiIndexSet::total_degree(families.len(), degree).unwrap();
    let basis = Basis::new(set, families.to_vec()).unwrap();
    let design = Design::new(SamplingMethod::Sobol, 3, "expansion", samples, families.len()).unwrap();
    let xi_samples: Vec<Vec<f64>> = (0..samples)
        .map(|i| design.unit(i).iter().zip(families).map(|(u, family)| family.from_unit(*u)).collect())
        .collect();
    let response: Vec<f64> = xi_samples.iter().map(|xi| f(xi)).collect();
    Expansion::fit(basis, &xi_samples, &response).unwrap()
}

#[test]
fn a_polynomial_is_recovered_with_its_moments_and_indices() {
    // f = 2 + ξ₁ + 3 ξ₁ ξ₂ + (ξ₂² − 1): variance 1 + 9 + 2.
    let (expansion, _) =
        expand(&[PolynomialFamily::Hermite; 2], 3, 64, |x| 2.0 + x[0] + 3.0 * x[0] * x[1] + x[1] * x[1] - 1.0);
    assert!((expansion.mean() - 2.0).abs() < 1e-12);
    assert!((expansion.variance() - 12.0).abs() < 1e-11);
    let first = expansion.first_order_indices();
    let total = expansion.total_indices();
    for (found, wanted) in [(first[0], 1.0), (first[1], 2.0), (total[0], 10.0), (total[1], 11.0)] {
        assert!((found - wanted / 12.0).abs() < 1e-12);
    }
    assert!((expansion.evaluate(&[0.5, -1.5]) - (2.0 + 0.5 - 2.25 + 1.25)).abs() < 1e-12);
}

#[test]
fn many_xi_samples_give_the_values_of_single_ones() {
    let (expansion, _) = expand(&[PolynomialFamily::Hermite; 3], 3, 80, |x| (x[0] + 0.3 * x[1]).sin() + x[2]);
    let xi_samples: Vec<[f64; 3]> = (0..50).map(|i| [0.1 * f64::from(i), -0.03 * f64::from(i), 0.5]).collect();
    let alone: Vec<f64> = xi_samples.iter().map(|g| expansion.evaluate(g)).collect();
    assert_eq!(expansion.evaluate_many(&xi_samples), alone);
}

#[test]
fn the_exponential_of_a_normal_variable_has_its_closed_coefficients() {
    let sigma = 0.5_f64;
    let (expansion, _) = expand(&[PolynomialFamily::Hermite], 12, 2048, |x| (sigma * x[0]).exp());
    // Orthonormal: c_n = e^{σ²/2} σⁿ/√n!. The first coefficient left out, c₁₃ = 1.8e-9, bounds the aliasing.
    let mut closed = (0.5 * sigma * sigma).exp();
    for n in 0..=6 {
        assert!((expansion.coefficients()[n] - closed).abs() < 1e-8, "c_{n}");
        closed *= sigma / ((n + 1) as f64).sqrt();
    }
}

#[test]
fn ishigami_has_its_published_indices() {
    let (expansion, fit) = expand(&[PolynomialFamily::Legendre; 3], 12, 1024, ISHIGAMI.evaluate);
    // The least smooth part, 7 sin² πx = 3.5 − 3.5 cos 2πx, leaves a variance fraction of 2e-5 beyond degree 12.
    assert!(fit.leave_one_out.relative_error.unwrap() < 1e-3);
    assert!((expansion.variance() / ISHIGAMI.variance - 1.0).abs() < 1e-3, "{}", expansion.variance());
    let first = expansion.first_order_indices();
    assert!((first[0] - 0.313_905_19).abs() < 1e-3, "{first:?}");
    assert!((first[1] - 0.442_411_14).abs() < 1e-3, "{first:?}");
    assert!(first[2] < 1e-4);
    assert!((expansion.subset_index(&[0, 2]) - 0.243_683_66).abs() < 1e-3);
}

#[test]
fn the_borehole_has_its_published_moments_and_indices() {
    let mut families = [PolynomialFamily::Legendre; 8];
    families[0] = PolynomialFamily::Hermite;
    families[1] = PolynomialFamily::Hermite;
    let (expansion, _) = expand(&families, 4, 1500, BOREHOLE.evaluate);
    assert!((expansion.mean() / BOREHOLE.mean - 1.0).abs() < 5e-4, "mean {}", expansion.mean());
    assert!((expansion.variance() / BOREHOLE.variance - 1.0).abs() < 2e-3, "variance {}", expansion.variance());
    for (found, wanted) in expansion.first_order_indices().iter().zip(BOREHOLE.first) {
        assert!((found - wanted).abs() < 5e-4, "first {:?}", expansion.first_order_indices());
    }
    for (found, wanted) in expansion.total_indices().iter().zip(BOREHOLE.total) {
        assert!((found - wanted).abs() < 5e-4, "total {:?}", expansion.total_indices());
    }
}

#[test]
fn the_sobol_g_function_comes_within_its_known_truncation() {
    // Degree 6 keeps 5/64 + 1/256 + 13/128² of the variance 1/12 of |x|, which is 99.4 %, and less of products. The
    // variables with a = 99 contribute a fraction of 3e-4 and are left out.
    let (expansion, _) = expand(&[PolynomialFamily::Legendre; 4], 6, 2000, SOBOL_G.evaluate);
    for (found, wanted) in expansion.first_order_indices().iter().zip(SOBOL_G.first) {
        assert!((found - wanted).abs() < 0.01, "{:?}", expansion.first_order_indices());
    }
    assert!((expansion.variance() / 0.465_424_431_902_206_7 - 1.0).abs() < 0.03, "{}", expansion.variance());
}

#[test]
fn a_constant_response_has_one_coefficient_and_no_indices() {
    for value in [0.0, 0.1, -1e300, 5e-324] {
        let (expansion, fit) = expand(&[PolynomialFamily::Hermite; 3], 3, 50, |_| value);
        assert_eq!((expansion.mean(), expansion.variance(), fit.leave_one_out.relative_error), (value, 0.0, None));
        assert!(expansion.first_order_indices().iter().chain(&expansion.total_indices()).all(|index| index.is_nan()));
    }
}

#[test]
fn fewer_samples_than_coefficients_are_refused() {
    let basis = Basis::hermite(8, 3).unwrap();
    let xi_samples = vec![vec![0.0; 8]; 165];
    let error = Expansion::fit(basis, &xi_samples, &[0.0; 165]).unwrap_err();
    assert_eq!(error, RegressionError::TooFewSamples { samples: 165, coefficients: 165 });
}

fn normal_xi_samples(points: usize, variables: usize) -> Vec<Vec<f64>> {
    let design = Design::new(SamplingMethod::MonteCarlo, 8, "germs", points, variables).unwrap();
    (0..points).map(|i| design.xi(i)).collect()
}

/// Returns coefficients between −1 and 1; every third one is zero.
fn coefficients(count: usize) -> Vec<f64> {
    (0..count).map(|k| if k % 3 == 1 { 0.0 } else { (1.7 * k as f64 + 0.3).sin() }).collect()
}

/// Compares values of expansions on several kinds of sets with the sum over `Basis::fill`.
#[test]
fn nested_sums_are_the_sums_of_all_terms() {
    let families = |variables: usize| -> Vec<PolynomialFamily> {
        (0..variables)
            .map(|i| if i % 3 == 2 { PolynomialFamily::Legendre } else { PolynomialFamily::Hermite })
            .collect()
    };
    let sets = [
        MultiIndexSet::total_degree(1, 0).unwrap(),
        MultiIndexSet::total_degree(1, 9).unwrap(),
        MultiIndexSet::total_degree(8, 3).unwrap(),
        MultiIndexSet::total_degree(4, 7).unwrap(),
        MultiIndexSet::total_degree(40, 2).unwrap(),
        MultiIndexSet::truncated(12, &Truncation { q: 0.6, ..Truncation::total_degree(6) }).unwrap(),
        MultiIndexSet::from_rows(4, [[0, 0, 0, 0], [0, 3, 1, 2], [0, 0, 0, 5], [0, 3, 1, 0], [1, 1, 1, 1]]).unwrap(),
    ];
    for set in sets {
        let basis = Basis::new(set.clone(), families(set.variables())).unwrap();
        let c = coefficients(basis.len());
        let xi_samples = normal_xi_samples(37, set.variables());
        let matrix = basis.design_matrix(&xi_samples);
        let values = Expansion::new(basis, c.clone()).evaluate_many(&xi_samples);
        for (row, value) in matrix.rows().into_iter().zip(values) {
            let terms = || row.iter().zip(&c).map(|(psi, c)| psi * c);
            let (wanted, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
            assert!((value - wanted).abs() <= 1e-14 * size, "{} terms: {value}, wanted {wanted}", set.len());
        }
    }
}

#[test]
fn a_value_depends_only_on_its_xi() {
    let basis = Basis::hermite(5, 4).unwrap();
    let c = coefficients(basis.len());
    let expansion = Expansion::new(basis, c);
    let xi_samples = normal_xi_samples(3000, 5);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let values = pool(1).install(|| expansion.evaluate_many(&xi_samples));
    assert_eq!(pool(3).install(|| expansion.evaluate_many(&xi_samples)), values);
    assert_eq!(xi_samples.iter().map(|xi| expansion.evaluate(xi)).collect::<Vec<_>>(), values);
    assert!(expansion.evaluate_many::<[f64; 5]>(&[]).is_empty());
}

#[test]
#[should_panic(expected = "4 normal variables for 5 variables")]
fn a_xi_that_is_too_short_is_a_mistake() {
    Expansion::new(Basis::hermite(5, 0).unwrap(), vec![1.0]).evaluate_many(&[vec![0.0; 5], vec![0.0; 4]]);
}

#[test]
fn closed_indices_are_sums_over_all_subsets() {
    let basis = Basis::hermite(4, 4).unwrap();
    let c = coefficients(basis.len());
    let expansion = Expansion::new(basis, c);
    let index = |subset: &[usize]| expansion.subset_index(subset);
    let wanted =
        index(&[0]) + index(&[2]) + index(&[3]) + index(&[0, 2]) + index(&[2, 3]) + index(&[0, 3]) + index(&[0, 2, 3]);
    assert!((expansion.closed_index(&[3, 0, 2]) - wanted).abs() < 1e-14);
    assert!((expansion.closed_index(&[3, 0, 2]) + expansion.total_indices()[1] - 1.0).abs() < 1e-14);
    assert_eq!(expansion.closed_index(&[]), 0.0);
    assert_eq!(expansion.first_order_indices()[2], expansion.closed_index(&[2]));
}

/// Returns ψ_n(x) from the explicit sums of powers, of He_n/√n! or of √(2n+1) P_n.
fn explicit(family: PolynomialFamily, n: usize, x: f64) -> f64 {
    let factorial = |k: usize| (1..=k).map(|k| k as f64).product::<f64>();
    let term = |k: usize| {
        let power = (-1.0_f64).powi(k as i32) * x.powi((n - 2 * k) as i32) / factorial(n - 2 * k) / factorial(k);
        match family {
            PolynomialFamily::Hermite => power * factorial(n).sqrt() / 2.0_f64.powi(k as i32),
            PolynomialFamily::Legendre => {
                power * (2.0 * n as f64 + 1.0).sqrt() * factorial(2 * n - 2 * k)
                    / factorial(n - k)
                    / 2.0_f64.powi(n as i32)
            }
        }
    };
    (0..=n / 2).map(term).sum()
}

/// Returns a truncated set, or any of its terms in any order after the constant.
fn random_set(rng: &mut random::Stream, variables: usize, degree: usize) -> MultiIndexSet {
    let truncation = Truncation {
        degree,
        q: if rng.random() { 1.0 } else { rng.random_range(0.4..1.0) },
        interaction_order: rng.random::<bool>().then(|| rng.random_range(1..=variables)),
        degree_limits: rng.random::<bool>().then(|| (0..variables).map(|_| rng.random_range(0..=degree)).collect()),
    };
    let set = MultiIndexSet::truncated(variables, &truncation).unwrap();
    if rng.random() {
        return set;
    }
    let mut chosen: Vec<usize> = (1..set.len()).filter(|_| rng.random()).collect();
    chosen.sort_by_cached_key(|_| rng.random::<u64>());
    set.select(&[vec![0], chosen].concat()).unwrap()
}

#[test]
fn random_polynomials_are_recovered_with_their_moments_and_indices() {
    for case in 0..40 {
        let rng = &mut random::stream(12, "random polynomials", case);
        let variables = rng.random_range(1..=4_usize);
        let degree = rng.random_range(1..=[10, 8, 6, 5][variables - 1]);
        let families: Vec<_> = (0..variables)
            .map(|_| if rng.random() { PolynomialFamily::Hermite } else { PolynomialFamily::Legendre })
            .collect();
        let set = random_set(rng, variables, degree);
        if set.len() == 1 {
            continue;
        }
        let coefficients = random::standard_normal(rng, set.len());
        let rows: Vec<Vec<u16>> = (0..set.len()).map(|term| set.at(term)).collect();
        let f = |x: &[f64]| -> f64 {
            let factor = |(i, n): (usize, &u16)| explicit(families[i], usize::from(*n), x[i]);
            let term = |row: &Vec<u16>| row.iter().enumerate().map(factor).product::<f64>();
            rows.iter().zip(&coefficients).map(|(row, c)| c * term(row)).sum()
        };
        let samples = 3 * set.len() + 20;
        let mut points = || -> Vec<Vec<f64>> {
            let mut point = || families.iter().map(|family| family.from_unit(rng.random_range(1e-6..1.0))).collect();
            (0..samples).map(|_| point()).collect()
        };
        let (fitted, others) = (points(), points());
        let response: Vec<f64> = fitted.iter().map(|x| f(x)).collect();
        let basis = Basis::new(set, families.clone()).unwrap();
        let design = basis.design_matrix(&fitted);
        let sparse = SparseRegression::default().select(&Candidates::new(design.view()).unwrap(), &response).unwrap();
        let sparse = Expansion::new(basis.clone(), sparse.dense(basis.len()));
        let parts = |belongs: &dyn Fn(&[u16]) -> bool| -> f64 {
            rows[1..].iter().zip(&coefficients[1..]).filter(|(row, _)| belongs(row)).map(|(_, c)| c * c).sum()
        };
        let variance = parts(&|_| true);
        for found in [Expansion::fit(basis, &fitted, &response).unwrap().0, sparse] {
            let same = |found: f64, wanted: f64, scale: f64| {
                assert!((found - wanted).abs() <= 1e-10 * scale, "{case}: {found}, not {wanted}");
            };
            found.coefficients().iter().zip(&coefficients).for_each(|(c, wanted)| same(*c, *wanted, variance.sqrt()));
            same(found.mean(), coefficients[0], variance.sqrt());
            same(found.variance(), variance, variance);
            for i in 0..variables {
                let alone = parts(&|row| row[i] > 0 && row.iter().filter(|n| **n > 0).count() == 1);
                same(found.first_order_indices()[i], alone / variance, 1.0);
                same(found.total_indices()[i], parts(&|row| row[i] > 0) / variance, 1.0);
                same(
                    found.closed_index(&[i, 0]),
                    parts(&|row| (1..variables).all(|j| j == i || row[j] == 0)) / variance,
                    1.0,
                );
            }
            let largest = others.iter().map(|x| f(x).abs()).fold(0.0, f64::max);
            others.iter().zip(found.evaluate_many(&others)).for_each(|(x, value)| same(value, f(x), largest));
        }
    }
}
