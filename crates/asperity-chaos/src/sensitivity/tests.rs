use asperity_testing::{BOREHOLE, ISHIGAMI, SOBOL_G, SOBOL_G_PARAMETERS, covered, repetitions};

use super::*;
use crate::{Basis, Design, MultiIndexSet, PolynomialFamily, RegressionError, SamplingMethod};

/// Returns the rows of a Monte Carlo design and the values of the function there.
fn sampled(
    families: &[PolynomialFamily],
    samples: usize,
    seed: u64,
    f: impl Fn(&[f64]) -> f64,
) -> (Vec<Vec<f64>>, Vec<f64>) {
    let design = Design::new(SamplingMethod::MonteCarlo, seed, "indices", samples, families.len()).unwrap();
    let xi_samples: Vec<Vec<f64>> = (0..samples)
        .map(|i| design.unit(i).iter().zip(families).map(|(u, family)| family.from_unit(*u)).collect())
        .collect();
    let values = xi_samples.iter().map(|xi| f(xi)).collect();
    (xi_samples, values)
}

fn fitted(
    basis: &Basis,
    xi_samples: &[Vec<f64>],
    values: &[f64],
    rows: &[usize],
) -> Result<Expansion, RegressionError> {
    let xi_samples: Vec<&[f64]> = rows.iter().map(|&row| xi_samples[row].as_slice()).collect();
    let values: Vec<f64> = rows.iter().map(|&row| values[row]).collect();
    Expansion::fit(basis.clone(), &xi_samples, &values).map(|(expansion, _)| expansion)
}

/// Returns indices with 99 % intervals, and the relative leave-one-out error.
fn estimated(basis: &Basis, xi_samples: &[Vec<f64>], values: &[f64], closed: &[&[usize]]) -> (IndexEstimates, f64) {
    let resamples = Resamples { count: 200, level: 0.99, seed: 4 };
    let estimates =
        resamples.sobol_indices(values.len(), closed, &|rows| fitted(basis, xi_samples, values, rows)).unwrap();
    let (_, fit) = Expansion::fit(basis.clone(), xi_samples, values).unwrap();
    (estimates, fit.leave_one_out.relative_error.unwrap())
}

/// Asserts that a value lies within an interval widened by the variance fraction that the terms leave out.
fn assert_held(name: &str, estimates: &[SampleEstimate], truths: &[f64], truncation: f64) {
    for (variable, (estimate, truth)) in estimates.iter().zip(truths).enumerate() {
        let Interval { low, high } = estimate.interval;
        let held = (low - truncation..=high + truncation).contains(truth);
        assert!(held, "{name} {variable}: {truth} is not in {estimate:?}, truncation {truncation:.1e}");
    }
}

#[test]
fn intervals_cover_the_ishigami_indices() {
    // Terms of x₁ and x₃ up to degrees 9 and 4, and of x₂ up to 12.
    let rows = (0..10).flat_map(|a| (0..5).map(move |c| [a, 0, c])).chain((1..13).map(|b| [0, b, 0]));
    let basis = Basis::new(MultiIndexSet::from_rows(3, rows).unwrap(), vec![PolynomialFamily::Legendre; 3]).unwrap();
    let (xi_samples, values) = sampled(&[PolynomialFamily::Legendre; 3], 250, 1, ISHIGAMI.evaluate);
    let (estimates, truncation) = estimated(&basis, &xi_samples, &values, &[&[0, 2]]);
    assert!(truncation < 1e-3, "{truncation}");
    assert_held("first", &estimates.first_order, ISHIGAMI.first, truncation);
    assert_held("total", &estimates.total, ISHIGAMI.total, truncation);
    assert_held("closed", &estimates.closed, &[0.557_588_86], truncation);
}

/// Returns V_u/V of the Sobol' g function, for terms of total degree 4 alone or for the whole function.
///
/// The Legendre polynomials of degree 2 and 4 contain 15/16 and 3/64 of the variance 1/3 of 2|x| − 1.
fn sobol_g_parts(a: &[f64], truncated: bool) -> impl Fn(usize) -> f64 {
    let fractions = [(0_usize, 1.0), (2, 15.0 / 16.0 / 3.0), (4, 3.0 / 64.0 / 3.0)];
    let part = {
        let a = a.to_vec();
        move |subset: usize| -> f64 {
            let active: Vec<f64> =
                (0..a.len()).filter(|i| subset >> i & 1 == 1).map(|i| (1.0 + a[i]).powi(-2)).collect();
            if !truncated {
                return active.iter().map(|w| w / 3.0).product();
            }
            (0..3_usize.pow(active.len() as u32))
                .map(|code| (0..active.len()).map(|k| fractions[code / 3_usize.pow(k as u32) % 3]).collect::<Vec<_>>())
                .filter(|choice| choice.iter().all(|s| s.0 > 0) && choice.iter().map(|s| s.0).sum::<usize>() <= 4)
                .map(|choice| choice.iter().zip(&active).map(|(s, w)| s.1 * w).product::<f64>())
                .sum()
        }
    };
    let variance: f64 = (1..1 << a.len()).map(&part).sum();
    move |subset| part(subset) / variance
}

#[test]
#[ignore = "slow"]
fn intervals_cover_the_sobol_g_indices_at_their_level() {
    let a = SOBOL_G_PARAMETERS;
    let (exact, projected) = (sobol_g_parts(&a, false), sobol_g_parts(&a, true));
    assert!((exact(1) - SOBOL_G.first[0]).abs() < 1e-9 && (exact(2) - SOBOL_G.first[1]).abs() < 1e-9);
    let basis = Basis::new(MultiIndexSet::total_degree(4, 4).unwrap(), vec![PolynomialFamily::Legendre; 4]).unwrap();
    let (mut held, datasets) = (0, repetitions(25));
    for seed in 0..datasets as u64 {
        let (xi_samples, values) = sampled(&[PolynomialFamily::Legendre; 4], 400, seed, SOBOL_G.evaluate);
        let resamples = Resamples { count: 100, level: 0.95, seed };
        let estimates =
            resamples.sobol_indices(400, &[&[0, 1]], &|rows| fitted(&basis, &xi_samples, &values, rows)).unwrap();
        for (variable, estimate) in estimates.first_order.iter().enumerate() {
            held += usize::from(estimate.interval.contains(projected(1 << variable)));
            let truncation = (projected(1 << variable) - exact(1 << variable)).abs();
            let miss = (estimate.value - exact(1 << variable)).abs();
            assert!(miss <= truncation + 4.5 * estimate.standard_error, "{variable}: {miss}, {estimate:?}");
        }
        held += usize::from(estimates.closed[0].interval.contains(projected(1) + projected(2) + projected(3)));
    }
    let fraction = covered("Sobol' index of an expansion", "Sobol' g, degree 4, 400 samples", held, 5 * datasets);
    // 125 intervals, dependent within a data set; 119 are expected to contain the truth.
    assert!(fraction >= 106.0 / 125.0, "{fraction} of the intervals contain the index of the truncated function");
}

#[test]
fn intervals_cover_the_borehole_indices() {
    let mut families = [PolynomialFamily::Legendre; 8];
    families[0] = PolynomialFamily::Hermite;
    families[1] = PolynomialFamily::Hermite;
    let basis = Basis::new(MultiIndexSet::total_degree(8, 2).unwrap(), families.to_vec()).unwrap();
    let (xi_samples, values) = sampled(&families, 250, 2, BOREHOLE.evaluate);
    let (estimates, truncation) = estimated(&basis, &xi_samples, &values, &[]);
    assert!(truncation < 5e-3, "{truncation}");
    assert_held("first", &estimates.first_order, BOREHOLE.first, truncation);
    assert_held("total", &estimates.total, BOREHOLE.total, truncation);
}

#[test]
fn statistics_are_the_moments_and_the_indices() {
    let basis = Basis::hermite(3, 4).unwrap();
    let coefficients = (0..basis.len()).map(|term| 1.0 / (1.0 + term as f64)).collect();
    let expansion = Expansion::new(basis, coefficients);
    let found = expansion.statistics();
    assert_eq!(found[..2], [expansion.mean(), expansion.variance()]);
    assert_eq!(found[2..5], expansion.first_order_indices());
    assert_eq!(found[5..8], expansion.total_indices());
    for (own, other) in [(0, 1), (0, 2), (1, 2)] {
        let wanted = expansion.subset_index(&[own, other]);
        for place in [3 * own + other, 3 * other + own] {
            assert!(wanted > 0.0 && (found[8 + place] / wanted - 1.0).abs() < 1e-14);
        }
    }
    assert!((0..3).all(|own| found[8 + 4 * own].is_nan()));
}

#[test]
fn jackknife_intervals_cover_the_moments_and_indices_of_ishigami() {
    let families = [PolynomialFamily::Legendre; 3];
    let set = MultiIndexSet::total_degree(3, 6).unwrap();
    let basis = Basis::new(set, families.to_vec()).unwrap();
    let (mean, variance, datasets) = (ISHIGAMI.mean, ISHIGAMI.variance, 40);
    let truths = [&[mean, variance], ISHIGAMI.first, ISHIGAMI.total].concat();
    let mut held = [0; 8];
    for seed in 0..datasets {
        let (xi_samples, values) = sampled(&families, 600, seed, ISHIGAMI.evaluate);
        let (_, fit, intervals) = Expansion::fit_with_intervals(basis.clone(), &xi_samples, &values).unwrap();
        let intervals = intervals.unwrap();
        for ((held, interval), truth) in held.iter_mut().zip(&intervals).zip(&truths) {
            *held += u64::from(interval.contains(*truth));
        }
        // Most of it is what the terms leave out.
        assert!(fit.leave_one_out.relative_error.unwrap() < 0.05);
        let width = |place: usize| intervals[place].high - intervals[place].low;
        assert!(width(0) < 0.1 * mean && width(1) < 0.3 * variance && (2..8).all(|place| width(place) < 0.2));
    }
    assert!(held.iter().all(|held| 10 * held >= 9 * datasets), "{held:?}");
}

#[test]
fn missing_intervals_have_a_reason() {
    let basis = Basis::hermite(2, 3).unwrap();
    let (xi_samples, values) = sampled(&[PolynomialFamily::Hermite; 2], 11, 3, |x| x[0]);
    let resamples = Resamples { count: 40, ..Resamples::new(1) };
    let indices = |values: &[f64]| resamples.sobol_indices(11, &[], &|rows| fitted(&basis, &xi_samples, values, rows));
    assert!(matches!(indices(&values), Err(IndexError::TooManyFailures { resamples: 40, .. })));
    // Few samples differ from the others, and some resamples have none of them.
    let rare: Vec<f64> = (0..40).map(|place| f64::from(u8::from(place < 2))).collect();
    let (basis, (xi_samples, _)) =
        (Basis::hermite(1, 1).unwrap(), sampled(&[PolynomialFamily::Hermite], 40, 3, |x| x[0]));
    let found = Resamples::new(1).sobol_indices(40, &[], &|rows| fitted(&basis, &xi_samples, &rare, rows));
    let Err(IndexError::TooManyFailures { failed, first, .. }) = found else { panic!("{found:?}") };
    // A resample leaves both out with the probability (38/40)⁴⁰ = 0.129.
    assert!((90..170).contains(&failed), "{failed}");
    assert_eq!(first, None);
    let error = resamples.sobol_indices(1, &[], &|_| Err(())).unwrap_err();
    assert_eq!(error, IndexError::Resamples(ResamplesError::Samples { samples: 1 }));
    let refused = |resamples: Resamples| resamples.sobol_indices(9, &[], &|_| Err(())).unwrap_err();
    let few = Resamples { count: 3, ..resamples };
    assert_eq!(refused(few), IndexError::Resamples(ResamplesError::Count { count: 3 }));
    let sure = Resamples { level: 1.0, ..resamples };
    assert_eq!(refused(sure), IndexError::Resamples(ResamplesError::Level { level: 1.0 }));
    assert_eq!(resamples.sobol_indices(2, &[], &|_| Err(())), Err(IndexError::Fit(())));
    let flat = |_: &[usize]| Ok::<_, ()>(Expansion::new(Basis::hermite(1, 0).unwrap(), vec![1.0]));
    assert_eq!(resamples.sobol_indices(2, &[], &flat), Err(IndexError::Constant));
}
