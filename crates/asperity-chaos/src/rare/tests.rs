use super::*;
use asperity_base::distribution::standard_normal_cdf;
use asperity_base::monitor::Silent;
use asperity_base::stats::Interval;
use asperity_testing::{covered, least_coverage, repetitions};
use rayon::prelude::*;

type LimitFunction = dyn Fn(&[f64]) -> f64 + Sync + Send;

/// Limit state with its probability.
struct Case {
    name: String,
    variables: usize,
    g: Box<LimitFunction>,
    probability: f64,
}

fn case(name: &str, variables: usize, probability: f64, g: impl Fn(&[f64]) -> f64 + Sync + Send + 'static) -> Case {
    Case { name: format!("{name}, n = {variables}"), variables, g: Box::new(g), probability }
}

fn linear(variables: usize, beta: f64) -> Case {
    let scale = (variables as f64).sqrt();
    case(&format!("linear {beta}"), variables, standard_normal_cdf(-beta), move |z| {
        beta - z.iter().sum::<f64>() / scale
    })
}

/// Returns z·a and z·b for two orthonormal vectors that involve all (an even number of) variables.
fn two(z: &[f64]) -> [f64; 2] {
    let scale = (z.len() as f64).sqrt();
    let odd: f64 = z.iter().skip(1).step_by(2).sum();
    let even: f64 = z.iter().step_by(2).sum();
    [(even + odd) / scale, (even - odd) / scale]
}

/// Integrates over [a, b] by Simpson's rule.
fn integral(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = 20_000;
    let h = (b - a) / n as f64;
    (0..=n).map(|i| f(a + i as f64 * h) * [2.0, 4.0][i % 2]).sum::<f64>() * h / 3.0 - (f(a) + f(b)) * h / 3.0
}

/// Fails where u > β + κ s with s = |z|² − u², χ² distributed with n − 1 degrees of freedom.
fn parabola(variables: usize, beta: f64, curvature: f64) -> Case {
    let degrees = (variables - 1) as f64;
    // s = r²; the density of r is proportional to r^(n−2) exp(−r²/2).
    let density =
        |r: f64| if variables == 2 { (-r * r / 2.0).exp() } else { r.powf(degrees - 1.0) * (-r * r / 2.0).exp() };
    let all = integral(0.0, 20.0, density);
    let failing = integral(0.0, 20.0, |r| density(r) * standard_normal_cdf(-(beta + curvature * r * r)));
    case(&format!("parabola {beta} {curvature}"), variables, failing / all, move |z| {
        let u = two(z)[0];
        beta - u + curvature * (z.iter().map(|z| z * z).sum::<f64>() - u * u)
    })
}

/// Series system of four branches, moved outwards by `shift`.
///
/// Waarts, *Structural reliability using finite element methods*, Delft University Press 2000.
fn four_branches(variables: usize, shift: f64) -> Case {
    let (a, b) = (3.0 + shift, 3.5 + shift);
    let density = asperity_base::distribution::standard_normal_pdf;
    let between = integral(-b, b, |v| density(v) * 2.0 * standard_normal_cdf(-(a + 0.2 * v * v)));
    case(&format!("four branches {shift}"), variables, 2.0 * standard_normal_cdf(-b) + between, move |z| {
        let [u, v] = two(z);
        (a + 0.2 * v * v - u.abs()).min(2.0_f64.sqrt() * (b - v.abs()))
    })
}

/// Lognormal resistance less lognormal load: fails where 0.2 z₂ − 0.1 z₁ > 0.2236 β.
fn resistance_and_load(beta: f64) -> Case {
    let deviation = 0.2_f64.hypot(0.1);
    case(&format!("resistance {beta}"), 2, standard_normal_cdf(-beta), move |z| {
        (deviation * beta + 0.1 * z[0]).exp() - (0.2 * z[1]).exp()
    })
}

/// Parallel system: fails where both parts fail.
fn both(variables: usize) -> Case {
    case("both of two", variables, standard_normal_cdf(-2.0) * standard_normal_cdf(-2.5), |z| {
        let [u, v] = two(z);
        (2.0 - u).max(2.5 - v)
    })
}

/// Estimates of `replicates` seeds.
fn estimates(case: &Case, replicates: u64) -> Vec<SmallProbability> {
    let g = |z: &[f64]| Ok::<f64, ()>((case.g)(z));
    (0..replicates)
        .into_par_iter()
        .map(|seed| small_probability(case.variables, &g, &Settings::new(seed), &Silent).unwrap())
        .collect()
}

/// Prints and returns the fraction of intervals that contain the probability, and the root mean square of the relative errors.
fn summary(case: &Case, found: &[SmallProbability]) -> [f64; 2] {
    let mean = |f: &dyn Fn(&SmallProbability) -> f64| found.iter().map(f).sum::<f64>() / found.len() as f64;
    let held = found.iter().filter(|found| found.interval.contains(case.probability)).count();
    let problem = format!("{}, P = {:.1e}", case.name, case.probability);
    let covered = covered("small probability of vibration", &problem, held, found.len());
    let error = mean(&|found| (found.probability / case.probability - 1.0).powi(2)).sqrt();
    let (ratio, evaluations) =
        (mean(&|found| found.probability / case.probability), mean(&|found| found.evaluations as f64));
    println!("{problem}: mean ratio {ratio:.3}, error {error:.3}, covered {covered:.3}, {evaluations:.0} evaluations");
    [covered, error]
}

#[test]
#[ignore = "slow"]
fn intervals_cover_the_probability() {
    for case in [
        linear(1, 3.0),
        linear(2, 2.0),
        linear(2, 4.753),
        linear(10, 3.0),
        linear(30, 4.0),
        parabola(2, 3.0, 0.1),
        parabola(10, 3.0, 0.1),
        resistance_and_load(4.0),
        four_branches(2, 0.0),
        four_branches(10, 1.0),
        both(2),
    ] {
        let count = repetitions(100);
        let [covered, error] = summary(&case, &estimates(&case, count as u64));
        assert!(covered >= least_coverage(count) && error < 0.17, "{}: {covered}, {error}", case.name);
    }
}

#[test]
fn estimates_agree_with_closed_forms() {
    for case in [linear(2, 4.0), four_branches(10, 0.0), both(2)] {
        let found = &estimates(&case, 1)[0];
        let ratio = found.probability / case.probability;
        // Twice the half width of a 95 % interval is exceeded with a probability below 1e-3.
        let factor = found.interval.high / found.probability;
        assert!(ratio.ln().abs() < 2.0 * factor.ln() && factor < 1.6, "{}: {found:?}", case.name);
    }
}

#[test]
fn the_stated_evaluations_are_those_of_the_limit_state() {
    // A probability of 2e-4, which is found, and one of 1e-23, of which one replicate gives a bound.
    for (beta, most) in [(3.5, 5000 + 2500), (10.0, 4500)] {
        let count = std::sync::atomic::AtomicUsize::new(0);
        let g = |z: &[f64]| {
            count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Ok::<f64, ()>(beta - z[0].tanh() * 0.5 - z[0] - 0.2 * (5.0 * z[1]).sin().powi(2))
        };
        let settings = Settings { most_evaluations: 5000, ..Settings::new(1) };
        let stated = small_probability(2, &g, &settings, &Silent).unwrap().evaluations;
        let count = count.into_inner();
        assert!(stated == count && count <= most, "{stated} stated, {count} made, {most} expected at most");
    }
}

/// M = ζ − b/2 with b ~ N(0.1, 0.02) and ζ ~ N(mean, 0.005) is normal.
fn margin(mean: f64) -> (f64, impl Fn(&[f64]) -> Result<f64, ()> + Sync) {
    let exact = standard_normal_cdf(-(mean - 0.05) / 0.01_f64.hypot(0.005));
    (exact, move |z: &[f64]| Ok(mean + 0.005 * z[1] - 0.5 * (0.1 + 0.02 * z[0])))
}

#[test]
fn margins_of_a_machine_have_narrow_intervals() {
    for mean in [0.09, 0.105] {
        let (exact, g) = margin(mean);
        let found = small_probability(2, &g, &Settings::new(3), &Silent).unwrap();
        let Interval { low, high } = found.interval;
        assert!(low > 0.0 && low < exact && exact < high && high < 3.0 * low, "{exact:e} {found:?}");
    }
}

#[test]
fn the_samples_give_the_probability_of_a_shifted_limit_state() {
    for mean in [0.09, 0.105] {
        let (exact, g) = margin(mean);
        let found = small_probability(2, &g, &Settings::new(3), &Silent).unwrap();
        for shift in [-0.02, -0.004, 0.0, 0.004] {
            let (wanted, shifted) = margin(mean + shift);
            let ratio = found.of_other(&shifted, &Silent).unwrap() / found.probability;
            let error = ratio / (wanted / exact) - 1.0;
            assert!(error.abs() < 0.25, "{mean} {shift}: {ratio} instead of {}", wanted / exact);
        }
    }
    // Samples without failures give those of a limit state with some.
    let (_, far) = margin(0.2);
    let found = small_probability(2, &far, &Settings::new(3), &Silent).unwrap();
    assert_eq!(found.of_other(&far, &Silent).unwrap(), 0.0);
    let (wanted, near) = margin(0.06);
    let shifted = found.of_other(&near, &Silent).unwrap();
    assert!((shifted / wanted - 1.0).abs() < 0.5, "{shifted} instead of {wanted}");
}

#[test]
fn without_failures_there_is_a_bound() {
    let flat = |_: &[f64]| Ok::<f64, ()>(1.0);
    let far = |z: &[f64]| Ok::<f64, ()>(40.0 - z[0]);
    // Φ(−40) is below the smallest number.
    for (g, most) in [(&flat as &LimitState<'_, ()>, 0.01), (&far, 1e-8)] {
        let found = small_probability(2, g, &Settings::new(1), &Silent).unwrap();
        let Interval { low, high } = found.interval;
        assert!(found.probability == 0.0 && low == 0.0 && high > 0.0 && high < most, "{found:?}");
    }
}

#[test]
fn errors_name_their_reason() {
    let settings = Settings::new(1);
    let fails = |z: &[f64]| if z[0] > 2.0 { Err("too large") } else { Ok(3.0 - z[0]) };
    assert_eq!(small_probability(2, &fails, &settings, &Silent), Err(RareError::Evaluation("too large")));
    let undefined = |z: &[f64]| Ok::<f64, ()>((2.0 - z[0]).sqrt());
    assert!(matches!(small_probability(1, &undefined, &settings, &Silent), Err(RareError::NotANumber { .. })));
    let g = |z: &[f64]| Ok::<f64, ()>(2.0 - z[0]);
    for wrong in [
        Settings { coefficient_of_variation: 0.0, ..settings },
        Settings { coefficient_of_variation: f64::NAN, ..settings },
    ] {
        assert!(matches!(small_probability(1, &g, &wrong, &Silent), Err(RareError::Setting { .. })), "{wrong:?}");
    }
    assert!(matches!(small_probability(0, &g, &settings, &Silent), Err(RareError::Setting { .. })));
    struct Cancels;
    impl Monitor for Cancels {
        fn progress(&self, _what: &str, _done: usize, _total: usize) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    assert_eq!(small_probability(1, &g, &settings, &Cancels), Err(RareError::Cancelled));
}
