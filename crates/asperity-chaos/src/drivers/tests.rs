use asperity_testing::{ISHIGAMI, covered, least_coverage, repetitions};

use super::*;
use crate::UncertainInput;
use asperity_base::distribution::{Marginal, standard_normal_cdf};
use std::f64::consts::PI;

/// Returns the response of single points at several.
fn each(response: impl Fn(&[f64]) -> f64 + Sync) -> impl Fn(&[Vec<f64>]) -> Vec<f64> + Sync {
    move |points| points.iter().map(|z| response(z)).collect()
}

/// Returns independent inputs with these distributions.
fn independent(texts: &[&str]) -> UncertainInputs {
    dependent(texts, &[])
}

fn dependent(texts: &[&str], spearman: &[(usize, usize, f64)]) -> UncertainInputs {
    let input =
        |(i, text): (usize, &&str)| UncertainInput::new(&format!("x{i}"), text.parse().unwrap(), false).unwrap();
    UncertainInputs::new(texts.iter().enumerate().map(input).collect(), spearman).unwrap()
}

/// Spearman's correlation of normal variables with Pearson's.
fn spearman(pearson: f64) -> f64 {
    6.0 / PI * (0.5 * pearson).asin()
}

/// Checks estimates against exact values: within four standard errors, which are at most `largest`.
fn check(estimates: &[SampleEstimate], exact: &[f64], rounding: f64, largest: f64) {
    assert_eq!(estimates.len(), exact.len());
    for (estimate, exact) in estimates.iter().zip(exact) {
        let error = (estimate.value - exact).abs();
        assert!(error < 4.0 * estimate.standard_error + rounding, "{estimate:?}, exact {exact}");
        assert!(estimate.standard_error < largest, "{estimate:?}");
        assert!(estimate.interval.contains(estimate.value));
    }
}

/// The margin ζ − b/2 of linear weakening b against damping ζ.
fn margin(x: &[f64]) -> f64 {
    x[1] - 0.5 * x[0]
}

fn machine() -> UncertainInputs {
    independent(&["normal:0.1,0.02", "normal:0.055,0.005"])
}

#[test]
fn the_margin_and_the_event_of_a_linear_machine_have_their_closed_indices() {
    let inputs = machine();
    let drivers = PickFreeze::new(1).drivers(&inputs, &each(|z| margin(&inputs.values(z)))).unwrap();
    check(&drivers.first_order, &[0.8, 0.2], 1e-12, 2e-3);
    check(&drivers.total, &[0.8, 0.2], 1e-12, 2e-3);
    assert_eq!(drivers.shapley, None);
    let event = |z: &[f64]| f64::from(u8::from(margin(&inputs.values(z)) < 0.0));
    let drivers = PickFreeze::new(1).drivers(&inputs, &each(event)).unwrap();
    // To three digits, by quadrature in another program.
    check(&drivers.first_order, &[0.581, 0.121], 5e-4, 8e-3);
    check(&drivers.total, &[0.879, 0.419], 5e-4, 8e-3);
}

#[test]
fn ishigami_has_its_closed_indices() {
    let inputs = independent(&["beta:1,1,-1,1"; 3]);
    let ishigami = |z: &[f64]| (ISHIGAMI.evaluate)(&inputs.values(z));
    for method in [SamplingMethod::Sobol, SamplingMethod::MonteCarlo] {
        let drivers = PickFreeze { method, ..PickFreeze::new(2) }.drivers(&inputs, &each(ishigami)).unwrap();
        check(&drivers.first_order, ISHIGAMI.first, 1e-8, 0.015);
        check(&drivers.total, ISHIGAMI.total, 1e-8, 0.015);
    }
}

#[test]
fn a_linear_response_to_correlated_normal_inputs_has_its_closed_drivers() {
    // x₀ + x₁ + x₂ with standard deviations 1, 1, s and the correlation ρ of x₁ and x₂ (Iooss & Prieur, Int. J.
    // Uncertain. Quantif. 9 (2019) 493, doi 10.1615/Int.J.UncertaintyQuantification.2019028372).
    let (rho, s) = (-0.6, 2.0);
    let inputs = dependent(&["normal", "normal", "normal:0,2"], &[(1, 2, spearman(rho))]);
    let drivers = PickFreeze::new(3).drivers(&inputs, &each(|z| inputs.values(z).iter().sum())).unwrap();
    let variance = 2.0 + s * s + 2.0 * rho * s;
    let part = 0.5 * rho * rho * (s * s - 1.0);
    let exact = |terms: [f64; 3]| terms.map(|term| term / variance);
    check(&drivers.first_order, &exact([1.0, (1.0 + rho * s).powi(2), (s + rho).powi(2)]), 1e-12, 3e-3);
    check(&drivers.total, &exact([1.0, 1.0 - rho * rho, s * s * (1.0 - rho * rho)]), 1e-12, 3e-3);
    let shapley = drivers.shapley.unwrap();
    check(&shapley, &exact([1.0, 1.0 + rho * s + part, s * s + rho * s - part]), 1e-12, 3e-3);
    assert!((shapley.iter().map(|effect| effect.value).sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn permutations_of_many_inputs_agree_with_the_closed_form() {
    // Σ βᵢxᵢ of nine inputs; a correlated pair has the effects β₁²(1 − ρ²/2) + ρβ₁β₂ + β₂²ρ²/2 (Owen & Prieur 2017).
    let (rho, beta) = (0.7, [1.0, 2.0, 0.5, 0.5, 0.5, 0.5, 1.0, 1.0, 0.0]);
    let inputs = dependent(&["normal"; 9], &[(0, 1, spearman(rho))]);
    let linear = |z: &[f64]| inputs.values(z).iter().zip(beta).map(|(x, b)| b * x).sum();
    let drivers = PickFreeze { points: 512, ..PickFreeze::new(4) }.drivers(&inputs, &each(linear)).unwrap();
    let variance = beta.iter().map(|b| b * b).sum::<f64>() + 2.0 * rho * beta[0] * beta[1];
    let pair = |a: f64, b: f64| a * a * (1.0 - 0.5 * rho * rho) + rho * a * b + 0.5 * b * b * rho * rho;
    let mut exact: Vec<f64> = beta.iter().map(|b| b * b / variance).collect();
    exact[..2].copy_from_slice(&[pair(1.0, 2.0) / variance, pair(2.0, 1.0) / variance]);
    let shapley = drivers.shapley.unwrap();
    check(&shapley, &exact, 1e-12, 0.015);
    assert!((shapley.iter().map(|effect| effect.value).sum::<f64>() - 1.0).abs() < 1e-12);
    check(&drivers.total[..2], &[(1.0 - rho * rho) / variance, 4.0 * (1.0 - rho * rho) / variance], 1e-12, 0.01);
}

#[test]
fn one_input_explains_everything_and_an_idle_one_nothing() {
    let single = PickFreeze::new(1).drivers(&independent(&["normal"]), &each(|z| z[0].powi(3))).unwrap();
    assert_eq!((single.first_order[0].value, single.total[0].value), (1.0, 1.0));
    let inputs = independent(&["normal"; 2]);
    let drivers = PickFreeze::new(1).drivers(&inputs, &each(|z| 5.0 + z[0])).unwrap();
    assert_eq!((drivers.first_order[0].value, drivers.total[1].interval), (1.0, Interval { low: 0.0, high: 0.0 }));
    assert!(drivers.first_order[1].interval.contains(0.0));
}

#[test]
fn a_response_without_variance_or_value_is_an_error() {
    let inputs = machine();
    let settings = PickFreeze { points: 32, ..PickFreeze::new(1) };
    assert_eq!(settings.drivers(&inputs, &each(|_| 0.3)), Err(DriverError::Constant));
    let error = settings.drivers(&inputs, &each(|z| (z[0] + 1.0).sqrt())).unwrap_err();
    assert!(matches!(&error, DriverError::NotFinite { value, z } if value.is_nan() && z[0] < -1.0), "{error}");
    assert!(matches!(settings.drivers(&independent(&[]), &each(|_| 1.0)), Err(DriverError::Design(_))));
    assert_eq!(
        settings.drivers(&independent(&["normal"; 65]), &each(|z| z[0])),
        Err(DriverError::TooManyInputs { inputs: 65 })
    );
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let mut found = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let inputs = dependent(&["normal"; 9], &[(0, 1, 0.5), (3, 7, -0.2)]);
        let response = |z: &[f64]| inputs.values(z).iter().map(|x| x.exp()).sum();
        let settings = PickFreeze { points: 128, ..PickFreeze::new(5) };
        pool.install(|| settings.drivers(&inputs, &each(response))).unwrap()
    });
    let [one, three] = &mut found;
    assert_eq!(one, three);
}

/// Returns the fraction of intervals that contain the exact value, over many seeds.
fn coverage(
    [kind, case]: [&str; 2],
    inputs: &UncertainInputs,
    method: SamplingMethod,
    response: impl Fn(&[f64]) -> f64 + Sync,
    estimates: impl Fn(Drivers) -> Vec<SampleEstimate>,
    exact: &[f64],
) -> f64 {
    let (mut held, seeds) = (0, repetitions(SEEDS));
    for seed in 0..seeds as u64 {
        let drivers = PickFreeze { method, points: 64, seed }.drivers(inputs, &each(&response)).unwrap();
        held += estimates(drivers).iter().zip(exact).filter(|(e, exact)| e.interval.contains(**exact)).count();
    }
    covered(kind, &format!("{case}, {method:?}"), held, seeds * exact.len())
}

/// Repetitions of a test.
const SEEDS: usize = 100;

#[test]
#[ignore = "slow"]
fn intervals_of_the_indices_cover() {
    let inputs = machine();
    let both = |drivers: Drivers| [drivers.first_order, drivers.total].concat();
    // b/2 and ζ have the standard deviations 0.01 and 0.005; P = Φ(−0.005/0.0111803).
    let event = |z: &[f64]| f64::from(u8::from(margin(&inputs.values(z)) < 0.0));
    let exact = event_indices();
    for method in [SamplingMethod::MonteCarlo, SamplingMethod::Sobol] {
        let found = coverage(
            ["driver of the margin", "linear margin"],
            &inputs,
            method,
            |z| margin(&inputs.values(z)),
            both,
            &[0.8, 0.2, 0.8, 0.2],
        );
        assert!(found >= least_coverage(repetitions(SEEDS)), "{method:?}, margin: {found}");
        let found = coverage(["driver of vibration", "linear margin"], &inputs, method, event, both, &exact);
        assert!(found >= least_coverage(repetitions(SEEDS)), "{method:?}, event: {found}");
    }
}

/// Returns the first-order and total indices of the event, with integrals by the trapezoidal rule.
fn event_indices() -> [f64; 4] {
    let probability = standard_normal_cdf(-0.005 / (0.01_f64.powi(2) + 0.005_f64.powi(2)).sqrt());
    // Var P[M < 0 | one input] with the standard deviations of that input and of the other.
    let first = |own: f64, other: f64| {
        let nodes = (-800..=800).map(|k| f64::from(k) * 0.01);
        let square: f64 = nodes
            .map(|g| 0.01 * Marginal::STANDARD_NORMAL.pdf(g) * standard_normal_cdf((own * g - 0.005) / other).powi(2))
            .sum();
        (square - probability * probability) / (probability * (1.0 - probability))
    };
    let (b, zeta) = (first(0.01, 0.005), first(0.005, 0.01));
    [b, zeta, 1.0 - zeta, 1.0 - b]
}

#[test]
#[ignore = "slow"]
fn intervals_of_shapley_effects_cover() {
    let (rho, s) = (0.5_f64, 2.0_f64);
    let inputs = dependent(&["normal", "normal:0,2"], &[(0, 1, spearman(rho))]);
    let variance = 1.0 + s * s + 2.0 * rho * s;
    let own = (1.0 - 0.5 * rho * rho + rho * s + 0.5 * s * s * rho * rho) / variance;
    let found = coverage(
        ["Shapley effect", "correlated sum"],
        &inputs,
        SamplingMethod::Sobol,
        |z| inputs.values(z).iter().sum(),
        |drivers| drivers.shapley.unwrap(),
        &[own, 1.0 - own],
    );
    assert!(found >= least_coverage(repetitions(SEEDS)), "{found}");
}

/// m + a u₀ + b u₁ + c v with unknown u₀, u₁ and varying v, all standard normal.
fn linear(x: &[f64]) -> f64 {
    0.5 + 0.6 * x[0] + 0.8 * x[1] + 0.7 * x[2]
}

fn unknowns(spearman: &[(usize, usize, f64)]) -> UncertainInputs {
    let input = |unknown| UncertainInput::new("x", Marginal::STANDARD_NORMAL, unknown).unwrap();
    UncertainInputs::new(vec![input(true), input(true), input(false)], spearman).unwrap()
}

#[test]
fn probabilities_over_unknowns_have_their_closed_form() {
    let z95 = 1.644_853_626_951_472_7;
    let rho: f64 = 0.4;
    for (inputs, rho) in [(unknowns(&[]), 0.0), (unknowns(&[(0, 1, spearman(rho))]), rho)] {
        let response = |z: &[f64]| linear(&inputs.values(z));
        let found = NestedSampling::new(1).probability_over_unknowns(&inputs, &each(response)).unwrap().unwrap();
        // Φ(−(0.5 + s g)/0.7) at the quantiles of g; the unknown part has the standard deviation s.
        let s = (1.0 + 2.0 * rho * 0.48).sqrt();
        for (found, g) in [(found.q05, z95), (found.q50, 0.0), (found.q95, -z95)] {
            let exact = standard_normal_cdf(-(0.5 + s * g) / 0.7);
            // Errors of the inner probability and of the rank among the outer points, if both were independent draws.
            let inner = (exact * (1.0 - exact) / 1024.0).sqrt();
            let density =
                s / 0.7 * Marginal::STANDARD_NORMAL.pdf((0.5 + s * g) / 0.7) / Marginal::STANDARD_NORMAL.pdf(g);
            let tail = standard_normal_cdf(g);
            let outer = density * (tail * (1.0 - tail) / 1024.0).sqrt();
            assert!((found - exact).abs() < 3.0 * inner.hypot(outer), "ρ = {rho}: {found}, exact {exact}");
        }
        assert_eq!(found.effects.len(), 2);
        for (effect, (own, other)) in found.effects.iter().zip([(0.6, 0.8), (0.8, 0.6)]) {
            // The other unknown has the mean ρg and the variance 1 − ρ² given this one.
            let rest = (other * other * (1.0 - rho * rho) + 0.49_f64).sqrt();
            let exact = |g: f64| standard_normal_cdf(-(0.5 + (own + rho * other) * g) / rest);
            for (found, g) in [(effect.probability_at_q05, -z95), (effect.probability_at_q95, z95)] {
                let error = (exact(g) * (1.0 - exact(g)) / 16_384.0).sqrt();
                assert!((found - exact(g)).abs() < 3.0 * error, "{effect:?}, exact {}", exact(g));
            }
        }
    }
}

#[test]
fn a_probability_without_varying_inputs_is_zero_or_one() {
    let input = UncertainInput::new("u", Marginal::STANDARD_NORMAL, true).unwrap();
    let inputs = UncertainInputs::new(vec![input], &[]).unwrap();
    let sampling = NestedSampling::new(1);
    let found = sampling.probability_over_unknowns(&inputs, &each(|z| z[0] - 1.0)).unwrap().unwrap();
    assert_eq!((found.q05, found.q50, found.q95), (0.0, 1.0, 1.0));
    let effect = found.effects[0];
    assert_eq!((effect.input, effect.probability_at_q05, effect.probability_at_q95), (0, 1.0, 0.0));
    assert_eq!(sampling.probability_over_unknowns(&machine(), &each(|z| z[0])), Ok(None));
    assert!(sampling.probability_over_unknowns(&inputs, &each(|z| z[0].ln())).is_err());
}
