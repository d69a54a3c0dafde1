use super::*;
use asperity::contact::{Boundary, Control, HalfSpace};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::distribution::{standard_normal_cdf, standard_normal_pdf};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::random::{standard_normal, stream};
use asperity::stats::wilson_interval;
use asperity::surface::{KarhunenLoeve, ModesRoute, SpectralField};
use asperity_testing::kolmogorov_smirnov_to;

const FRESH: usize = 4000;

/// Returns samples of p(x, η) with standard normal x and noise η.
fn samples(count: usize, largest_pa: f64, pressure: impl Fn(f64, f64) -> f64) -> RotatedSamples {
    let xi = standard_normal(&mut stream(7, "surrogate test", 0), 2 * count);
    RotatedSamples {
        rows: xi[..count].iter().map(|x| vec![*x]).collect(),
        pressures_pa: xi[..count].iter().zip(&xi[count..]).map(|(x, eta)| pressure(*x, *eta)).collect(),
        fresh: (0..FRESH).map(|i| standard_normal(&mut stream(7, "surrogate fresh", i as u64), 1)).collect(),
        largest_pa,
    }
}

fn by_latent(samples: &RotatedSamples) -> Result<PressureEstimate, MethodError> {
    estimate(&LatentOverlap::new(samples, 3), samples.training(), 1)
}

fn by_two_parts(samples: &RotatedSamples) -> Result<PressureEstimate, MethodError> {
    estimate(&TwoPart::new(samples, 3), samples.training(), 1)
}

#[test]
fn the_latent_pressure_gives_a_clipped_normal_distribution() {
    let (mean, std, hardness) = (-0.3, 1.25_f64.sqrt(), 1.5);
    let samples = samples(400, hardness, |x, eta| (mean + x + 0.5 * eta).clamp(0.0, hardness));
    let found = by_latent(&samples).unwrap();
    let cdf = |p: f64| {
        if p < 0.0 {
            0.0
        } else if p >= hardness {
            1.0
        } else {
            standard_normal_cdf((p - mean) / std)
        }
    };
    let band = found.band.as_ref().unwrap();
    for (i, value) in band.values.iter().enumerate() {
        // All of 40 values at once; four standard errors each.
        let error = (band.cdf[i] - band.bias[i] - cdf(*value)).abs();
        assert!(error < 4.0 * band.standard_errors[i] + 1e-12, "{value}: {error} {}", band.standard_errors[i]);
        // The model is right: it has no bias.
        assert!(band.bias[i].abs() < 4.0 * band.standard_errors[i] + 1e-12, "{value}: {}", band.bias[i]);
    }
    // E clamp(y, 0, H) = ∫₀ᴴ P(y > t) dt = H − [(t − µ) Φ + σ φ]₀ᴴ.
    let primitive =
        |t: f64| (t - mean) * standard_normal_cdf((t - mean) / std) + std * standard_normal_pdf((t - mean) / std);
    let wanted = hardness - primitive(hardness) + primitive(0.0);
    assert!((found.mean_pa - wanted).abs() < 4.0 * found.mean_se_pa, "{} {wanted} {}", found.mean_pa, found.mean_se_pa);
    let contact = 1.0 - cdf(0.0);
    assert!(found.contact_probability_interval.unwrap().contains(contact), "{:?}", found.contact_probability_interval);
    // The sign of x nearly determines contact, so the error is smaller than that of counting.
    let counted = (contact * (1.0 - contact) / 400.0_f64).sqrt();
    assert!(found.contact_probability_se < counted, "{} {counted}", found.contact_probability_se);
    assert_eq!(found.coefficients, Some(3));
}

#[test]
fn the_two_part_model_gives_a_logistic_lognormal_distribution() {
    let odds = |x: f64| 1.0 / (1.0 + (-0.4 - 1.5 * x).exp());
    // The noise determines contact, and its remainder the pressure.
    let pressure = |x: f64, eta: f64| {
        let u = standard_normal_cdf(eta);
        if u < odds(x) { (14.0 + 0.5 * x + 0.4 * (u / odds(x) - 0.5)).exp() } else { 0.0 }
    };
    let samples = samples(600, f64::INFINITY, pressure);
    let found = by_two_parts(&samples).unwrap();
    // Quadrature on a fine grid in x.
    let nodes: Vec<f64> = (0..2000).map(|k| -5.0 + 0.005 * (f64::from(k) + 0.5)).collect();
    let over = |f: &dyn Fn(f64) -> f64| nodes.iter().map(|x| 0.005 * standard_normal_pdf(*x) * f(*x)).sum::<f64>();
    let contact = over(&odds);
    assert!((found.contact_probability - contact).abs() < 4.0 * found.contact_probability_se);
    let cdf = |p: f64| {
        let given = |x: f64| ((p.ln() - 14.0 - 0.5 * x) / 0.4 + 0.5).clamp(0.0, 1.0);
        if p <= 0.0 { 1.0 - contact } else { 1.0 - contact + over(&|x| odds(x) * given(x)) }
    };
    let band = found.band.as_ref().unwrap();
    for (i, value) in band.values.iter().enumerate() {
        let error = (band.cdf[i] - band.bias[i] - cdf(*value)).abs();
        assert!(error < 4.0 * band.standard_errors[i], "{value}: {error} {}", band.standard_errors[i]);
    }
    assert!(found.leave_one_out_error.unwrap() < 0.3);
}

#[test]
fn no_sample_in_contact_is_an_error() {
    let samples = samples(50, f64::INFINITY, |_, _| 0.0);
    let wanted = MethodError::TooFewSamples { samples: 0, wanted: LEAST_IN_CONTACT };
    assert_eq!(by_latent(&samples), Err(wanted.clone()));
    assert_eq!(by_two_parts(&samples), Err(wanted));
}

#[test]
fn with_all_samples_in_contact_the_probability_is_one_and_the_interval_is_wilsons() {
    let samples = samples(80, f64::INFINITY, |x, eta| 1e6 * (0.2 * x + 0.1 * eta).exp());
    for found in [by_latent(&samples).unwrap(), by_two_parts(&samples).unwrap()] {
        assert!(found.contact_probability > 1.0 - 1e-3, "{}", found.contact_probability);
        let interval = found.contact_probability_interval.unwrap();
        assert_eq!(interval, wilson_interval(80, 80));
        let mean = 1e6 * (0.5_f64 * 0.05).exp();
        assert!((found.mean_pa - mean).abs() < 4.0 * found.mean_se_pa, "{} {}", found.mean_pa, found.mean_se_pa);
    }
}

#[test]
fn fewer_samples_than_coefficients_lower_the_degree() {
    let mut samples = samples(14, f64::INFINITY, |x, eta| (3.0 + x + 0.3 * eta).max(0.0));
    // Eight variables at degree 3 have 165 coefficients.
    let noise = standard_normal(&mut stream(7, "surrogate test", 1), 7 * 14);
    samples.rows.iter_mut().enumerate().for_each(|(i, row)| row.extend(&noise[7 * i..7 * i + 7]));
    samples.fresh.iter_mut().for_each(|row| row.extend([0.0; 7]));
    for found in [by_latent(&samples).unwrap(), by_two_parts(&samples).unwrap()] {
        assert!(found.coefficients.unwrap() <= 3 && found.mean_se_pa > 0.0);
        assert!((found.mean_pa - 3.0).abs() < 5.0 * found.mean_se_pa, "{} {}", found.mean_pa, found.mean_se_pa);
    }
}

#[test]
fn duplicate_samples_change_the_distribution_little() {
    let once = samples(200, f64::INFINITY, |x, eta| (0.3 + x + 0.5 * eta).max(0.0));
    let mut twice = once.clone();
    twice.rows.extend(once.rows.clone());
    twice.pressures_pa.extend(once.pressures_pa.clone());
    let (first, second) = (by_latent(&once).unwrap(), by_latent(&twice).unwrap());
    assert!((first.mean_pa - second.mean_pa).abs() < first.mean_se_pa);
    let (first, second) = (by_two_parts(&once).unwrap(), by_two_parts(&twice).unwrap());
    assert!((first.mean_pa - second.mean_pa).abs() < first.mean_se_pa);
    // All samples are equal, so the functions are linearly dependent.
    let one = RotatedSamples { rows: vec![vec![0.5]; 60], pressures_pa: vec![2.0; 60], ..once };
    for found in [by_latent(&one).unwrap(), by_two_parts(&one).unwrap()] {
        assert!((found.mean_pa - 2.0).abs() < 1e-4, "{}", found.mean_pa);
    }
}

#[test]
fn variables_that_are_zero_or_missing_have_no_effect() {
    let plain = samples(300, f64::INFINITY, |_, eta| (0.3 + eta).max(0.0));
    let cdf = |p: f64| if p < 0.0 { 0.0 } else { standard_normal_cdf(p - 0.3) };
    for row in [vec![0.0, 0.0], vec![]] {
        let samples = RotatedSamples { rows: vec![row; 300], ..plain.clone() };
        let latent = by_latent(&samples).unwrap();
        assert_eq!(latent.coefficients, Some(2));
        for found in [latent, by_two_parts(&samples).unwrap()] {
            // 99.99 % point of √n D: 2.23.
            let distance = kolmogorov_smirnov_to(found.distribution.values(), found.distribution.cumulative(), cdf);
            assert!(distance < 2.23 / 300.0_f64.sqrt(), "{distance}");
        }
    }
}

#[test]
fn a_constant_pressure_is_a_point_mass() {
    // Elastic with a constant pressure; plastic with the hardness in every contact.
    let elastic = samples(60, f64::INFINITY, |_, _| 5e8);
    for found in [by_latent(&elastic).unwrap(), by_two_parts(&elastic).unwrap()] {
        assert!(
            (found.mean_pa / 5e8 - 1.0).abs() < 1e-4 && found.distribution.std() < 1e-3 * 5e8,
            "{}",
            found.distribution.std()
        );
    }
    let plastic = samples(200, 2e9, |x, eta| if x + 0.5 * eta > 0.0 { 2e9 } else { 0.0 });
    for found in [by_latent(&plastic).unwrap(), by_two_parts(&plastic).unwrap()] {
        assert!((found.contact_probability - 0.5).abs() < 4.0 * found.contact_probability_se + 0.01);
        assert!(found.distribution.quantile(1.0) <= 2e9);
    }
    // Without an elastic contact, the two-part model consists of two point masses.
    assert_eq!(by_two_parts(&plastic).unwrap().distribution.values(), [0.0, 2e9]);
}

#[test]
fn the_two_part_model_has_the_point_mass_at_the_hardness() {
    // p = e^{y/2} capped at H, y = x + η/2 + ½, in contact for y > 0: P(p = H) = P(y ≥ 2 ln H).
    let (mean, std, hardness) = (0.5, 1.25_f64.sqrt(), 2.0_f64);
    let pressure = |x: f64, eta: f64| {
        let y = mean + x + 0.5 * eta;
        if y > 0.0 { (0.5 * y).exp().min(hardness) } else { 0.0 }
    };
    let samples = samples(600, hardness, pressure);
    let found = by_two_parts(&samples).unwrap();
    let plastic = 1.0 - standard_normal_cdf((2.0 * hardness.ln() - mean) / std);
    let own = 1.0 - found.distribution.cdf_left(hardness);
    // The model is logistic, the truth normal; six hundred samples alone have a standard error of .02.
    assert!(
        plastic > 0.2 && (own - plastic).abs() < 4.0 * (plastic * (1.0 - plastic) / 600.0).sqrt(),
        "{own} {plastic}"
    );
    // Just below the hardness the probability is as small as in the exact distribution.
    let below = |fraction: f64| standard_normal_cdf((2.0 * (fraction * hardness).ln() - mean) / std);
    let gap = found.distribution.cdf_left(hardness) - found.distribution.cdf(0.95 * hardness);
    assert!((gap - (below(1.0) - below(0.95))).abs() < 0.03, "{gap}");
    assert_eq!(found.distribution.quantile(1.0), hardness);
}

#[test]
fn a_wrong_model_reports_its_bias_and_intervals_contain_the_truth() {
    // Uniform pressures that no variable predicts: the latent pressure is not normal.
    let truth = |p: f64| if p < 0.0 { 0.0 } else { (0.3 + 0.7 * p).min(1.0) };
    let samples = samples(1500, f64::INFINITY, |_, eta| ((standard_normal_cdf(eta) - 0.3) / 0.7).max(0.0));
    let found = by_latent(&samples).unwrap();
    let band = found.band.as_ref().unwrap();
    let worst = band.bias.iter().zip(&band.standard_errors).map(|(bias, se)| bias.abs() / se).fold(0.0, f64::max);
    assert!(worst > 5.0, "{worst}");
    for (i, value) in band.values.iter().enumerate() {
        let error = (band.cdf[i] - band.bias[i] - truth(*value)).abs();
        assert!(error < 4.0 * band.standard_errors[i], "{value}: {error}");
        let [low, high] = band.simultaneous(i);
        assert!(low <= truth(*value) && truth(*value) <= high);
    }
    // The standard error is about that of counting 1,500 samples.
    let counted = (0.3_f64 * 0.7 / 1500.0).sqrt();
    assert!((found.contact_probability_se / counted - 1.0).abs() < 0.1, "{}", found.contact_probability_se);
    let mean = found.mean_interval_pa().unwrap();
    assert!(mean.contains(0.35), "{mean:?}");
}

#[test]
fn estimates_do_not_depend_on_the_number_of_threads() {
    let samples = samples(150, f64::INFINITY, |x, eta| (0.3 + x + 0.5 * eta).max(0.0));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (by_latent(&samples).unwrap(), by_two_parts(&samples).unwrap()))
    };
    assert_eq!(on(1), on(2));
}

fn small_study() -> MethodComparison {
    let study = MethodComparison::new(5);
    MethodComparison {
        fine_solves: 80,
        reference_samples: 100,
        variables: 2,
        degree: 2,
        surrogate_samples: 1000,
        ..study
    }
}

fn outcome(outcomes: Vec<Outcome>, name: &str) -> Outcome {
    names().into_iter().zip(outcomes).find(|(own, _)| *own == name).unwrap().1
}

#[test]
fn cells_of_a_stationary_periodic_patch_are_pooled_and_every_method_finds_their_contact_probability() {
    let grid = Grid::with_size(12, 12, 1.0, 1.0).unwrap();
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 0.2, 0.2).unwrap();
    let surface = SpectralField::periodic(&covariance, grid);
    let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.3 };
    let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.3 }, None).unwrap();
    let outcomes = estimates(&small_study(), &problem, &Silent).unwrap();
    let reference =
        MethodComparison { seed: 6, ..small_study() }.run(&problem, &Silent).unwrap().reference.unwrap().estimate;
    let [contact, its_se] = [reference.contact_probability, reference.contact_probability_se];
    assert_eq!(outcomes.len(), PressureMethod::ALL.len() + 5);
    for (name, found) in names().into_iter().zip(outcomes) {
        let found = found.unwrap();
        let error = found.contact_probability - found.contact_probability_bias.unwrap_or(0.0) - contact;
        let se = found.contact_probability_se.hypot(its_se);
        assert!(error.abs() < 4.0 * se, "{name}: {error} ± {se}");
    }
}

#[test]
fn cells_of_a_free_patch_differ_and_are_not_pooled() {
    let grid = Grid::with_size(12, 12, 1.0, 1.0).unwrap();
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 0.2, 0.2).unwrap();
    let surface = KarhunenLoeve::new(&covariance, grid, 30, ModesRoute::Separable).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
    let study = MethodComparison { fine_solves: 150, reference_samples: 20, ..small_study() };
    let outcomes = estimates(&study, &problem, &Silent).unwrap();
    let refusal = outcome(outcomes, "pooled_sites").unwrap_err().to_string();
    assert!(refusal.contains("cells differ"), "{refusal}");
}
