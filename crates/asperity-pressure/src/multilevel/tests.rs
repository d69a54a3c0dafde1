use rayon::prelude::*;

use super::*;
use asperity_base::distribution::{standard_normal_cdf, standard_normal_quantile};
use asperity_base::random::{standard_normal, stream};
use asperity_testing::covered;

/// Mean of q = q₁ + 0.3 η₂ − 0.2 with a coarse model q₁ = u + 0.5 η₁. All variables are normal, and u is one of two
/// known ones.
const MEAN: f64 = -0.2;

fn std() -> f64 {
    (1.0_f64 + 0.25 + 0.09).sqrt()
}

fn level_samples(repeat: u64, fine: usize, coarse: usize) -> LevelSamples {
    let draw = |stage| standard_normal(&mut stream(repeat, stage, 0), coarse);
    let (u, idle, first, second) = (draw("u"), draw("idle"), draw("first"), draw("second"));
    let coarser: Vec<f64> = u.iter().zip(&first).map(|(u, eta)| u + 0.5 * eta).collect();
    let quantity = coarser.iter().zip(&second).take(fine).map(|(q, eta)| q + 0.3 * eta + MEAN).collect();
    let normal = u.iter().zip(&idle).map(|(a, b)| vec![*a, *b]).collect();
    LevelSamples { xi: normal, values: vec![coarser, quantity], covariates: vec![vec![Vec::new(); coarse]] }
}

fn settings(seed: u64, least: f64) -> Settings {
    Settings { seed, degree: 2, fitted: true, least, largest: f64::INFINITY }
}

#[test]
fn without_models_the_distribution_is_the_empirical_one() {
    let mut levels = level_samples(1, 200, 200);
    (levels.values, levels.xi) = (vec![levels.values[1].clone()], vec![Vec::new(); 200]);
    let found = estimate(&levels, &settings(1, 0.0)).unwrap();
    let values: Vec<f64> = levels.values[0].iter().map(|q| q.max(0.0)).collect();
    let empirical = DiscreteDistribution::empirical(&values).unwrap();
    for t in empirical.values() {
        assert!((found.distribution.cdf(*t) - empirical.cdf(*t)).abs() < 1e-12);
    }
    assert!((found.mean - empirical.mean()).abs() < 1e-12);
    // Wider by Student's factor with about a hundred degrees of freedom.
    let widening = found.mean_se / (empirical.std() / 199.0_f64.sqrt());
    assert!((1.0..1.03).contains(&widening), "{widening}");
    let p = empirical.cdf(0.0);
    assert!((found.band.standard_errors[0] - (p * (1.0 - p) / 199.0).sqrt()).abs() < 1e-12);
}

#[test]
fn unit_weights_give_the_telescoping_sum() {
    let (fine, coarse) = (150, 600);
    let levels = level_samples(3, fine, coarse);
    let found = estimate(&levels, &Settings { fitted: false, ..settings(1, f64::NEG_INFINITY) }).unwrap();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let [first, second] = [&levels.values[0], &levels.values[1]];
    assert!((found.mean - (mean(second) - mean(&first[..fine]) + mean(first))).abs() < 1e-12);
    let fraction = |values: &[f64], t: f64| values.iter().filter(|q| **q <= t).count() as f64 / values.len() as f64;
    for (t, cdf) in found.band.values.iter().zip(&found.band.cdf) {
        let wanted = fraction(second, *t) - fraction(&first[..fine], *t) + fraction(first, *t);
        assert!((cdf - wanted).abs() < 1e-12, "{t}: {cdf} {wanted}");
    }
}

#[test]
#[ignore = "slow"]
fn intervals_and_bands_cover_the_true_values_at_their_level() {
    let (fine, coarse, repeats) = (250, 750, 1000);
    let truth = |t: f64| standard_normal_cdf((t - MEAN) / std());
    let density = (-0.5 * (MEAN / std()).powi(2)).exp() / std::f64::consts::TAU.sqrt();
    let mean = std() * density + MEAN * (1.0 - truth(0.0));
    type Row = ([bool; 6], [f64; 4]);
    let rows: Vec<Row> = (0..repeats)
        .into_par_iter()
        .map(|repeat| {
            let levels = level_samples(repeat, fine, coarse);
            let found = estimate(&levels, &settings(repeat, 0.0)).unwrap();
            let holds = |[low, high]: [f64; 2], value: f64| low <= value && value <= high;
            let at_zero = holds(found.band.pointwise(0), truth(0.0));
            let all =
                (0..found.band.values.len()).all(|i| holds(found.band.simultaneous(i), truth(found.band.values[i])));
            let inside = (found.mean - mean).abs() <= 1.96 * found.mean_se;
            let free = estimate(&levels, &settings(repeat, f64::NEG_INFINITY)).unwrap();
            let quantile = |probability: f64| {
                let wanted = MEAN + std() * standard_normal_quantile(probability);
                free.band.quantile(&free.distribution, probability).interval.contains(wanted)
            };
            let errors =
                [found.band.cdf[0] - truth(0.0), found.band.standard_errors[0], found.mean - mean, found.mean_se];
            ([at_zero, inside, quantile(0.1), quantile(0.5), quantile(0.9), all], errors)
        })
        .collect();
    let names = ["P(contact)", "mean", "10 %", "50 %", "90 %", "simultaneous band"];
    for (k, name) in names.iter().enumerate() {
        let held = rows.iter().filter(|row| row.0[k]).count();
        let fraction = match k {
            1 => covered("mean of a property of the contact", "normal values, clipped", held, rows.len()),
            2..5 => {
                covered("quantile of a property of the contact", &format!("normal values, {name}"), held, rows.len())
            }
            _ => held as f64 / rows.len() as f64,
        };
        // A fraction of .95 has a standard error of .007.
        assert!(fraction >= 0.93 && (k == 5 || fraction <= 0.97), "{name}: {fraction}");
    }
    let rms = |k: usize| (rows.iter().map(|row| row.1[k].powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
    assert!((rms(0) / rms(1) - 1.0).abs() < 0.1, "{} {}", rms(0), rms(1));
    assert!((rms(2) / rms(3) - 1.0).abs() < 0.1, "{} {}", rms(2), rms(3));
    // Without clipping, the variance of the mean would be .09/fine + .25/coarse; clipping reduces all terms.
    let monte_carlo = truth(0.0) * (1.0 - truth(0.0)) / fine as f64;
    assert!(rms(0).powi(2) < 0.6 * monte_carlo, "{} {}", rms(0).powi(2), monte_carlo);
    let bias = rows.iter().map(|row| row.1[0]).sum::<f64>() / rows.len() as f64;
    assert!(bias.abs() < 4.0 * rms(0) / (rows.len() as f64).sqrt(), "{bias}");
}

#[test]
fn uninformative_models_cost_little_and_cause_no_bias() {
    let repeats = 200;
    let errors: Vec<[f64; 2]> = (0..repeats)
        .into_par_iter()
        .map(|repeat| {
            let mut levels = level_samples(repeat, 200, 600);
            levels.values[0] = standard_normal(&mut stream(repeat, "nonsense", 0), 600);
            levels.xi.iter_mut().for_each(|row| row.truncate(0));
            let found = estimate(&levels, &settings(repeat, 0.0)).unwrap();
            [found.band.cdf[0] - standard_normal_cdf(-MEAN / std()), found.band.standard_errors[0]]
        })
        .collect();
    let rms = |k: usize| (errors.iter().map(|row| row[k].powi(2)).sum::<f64>() / f64::from(repeats as u32)).sqrt();
    let p = standard_normal_cdf(-MEAN / std());
    let monte_carlo = (p * (1.0 - p) / 200.0).sqrt();
    // The relative standard error of a root mean square of 200 values is 1/20.
    assert!(rms(0) < 1.2 * monte_carlo && rms(1) > 0.9 * monte_carlo, "{} {} {monte_carlo}", rms(0), rms(1));
}

#[test]
fn predictors_do_not_depend_on_the_values_of_their_own_fold() {
    let levels = level_samples(2, 100, 200);
    let mut other = levels.clone();
    other.values[1].iter_mut().skip(3).step_by(FOLDS).for_each(|q| *q += 100.0);
    let predictions = |levels: &LevelSamples, fold: usize| -> Vec<f64> {
        let (fold, _) = Fold::fit(levels, fold, &settings(1, 0.0)).unwrap();
        let normal = |i: usize| fold.normal.as_ref().unwrap().predict(&levels.xi[i]);
        (0..200).flat_map(|i| [fold.predictors[0].predict(&levels.row(0, i)), normal(i)]).collect()
    };
    assert_eq!(predictions(&levels, 3), predictions(&other, 3));
    assert_ne!(predictions(&levels, 2), predictions(&other, 2));
}

#[test]
fn equal_values_and_duplicate_samples_are_accepted() {
    let equal = LevelSamples {
        xi: vec![vec![0.0]; 40],
        values: vec![vec![1.0; 40], vec![2.0; 20]],
        covariates: vec![vec![Vec::new(); 40]],
    };
    let found = estimate(&equal, &settings(1, 0.0)).unwrap();
    assert_eq!(found.distribution.values(), [2.0]);
    assert!((found.mean - 2.0).abs() < 1e-12 && found.mean_se < 1e-7);
    let mut doubled = level_samples(5, 60, 120);
    for i in 0..30 {
        doubled.values[0][2 * i + 1] = doubled.values[0][2 * i];
        doubled.values[1][2 * i + 1] = doubled.values[1][2 * i];
        doubled.xi[2 * i + 1] = doubled.xi[2 * i].clone();
    }
    assert!(estimate(&doubled, &settings(1, 0.0)).unwrap().mean_se > 0.0);
    let never = LevelSamples { xi: vec![Vec::new(); 40], values: vec![vec![-1.0; 40]], covariates: Vec::new() };
    let found = estimate(&never, &settings(1, 0.0)).unwrap();
    assert_eq!((found.distribution.cdf(0.0), found.mean, found.band.standard_errors[0]), (1.0, 0.0, 0.0));
    let few = LevelSamples { xi: vec![Vec::new(); 4], values: vec![vec![1.0; 4]], covariates: Vec::new() };
    assert_eq!(estimate(&few, &settings(1, 0.0)).unwrap_err(), MethodError::TooFewSamples { samples: 4, wanted: 10 });
}

#[test]
fn thresholds_and_nodes_have_equal_numbers_of_draws_between_them() {
    let uniform = |count: usize, stage| -> Vec<f64> {
        let normal = standard_normal(&mut stream(1, stage, 0), count);
        normal
            .into_iter()
            .map(|z| (1.25 * asperity_base::distribution::standard_normal_cdf(z) - 0.25).max(0.0))
            .collect()
    };
    let (fine, drawn) = (uniform(3000, "fine"), uniform(60_000, "drawn"));
    let settings = Settings { largest: 2.0, ..settings(1, 0.0) };
    let found = thresholds(&fine, &drawn, &settings);
    assert!(found[0] == 0.0 && found.is_sorted_by(|a, b| a < b) && found.len() > 900 && found.len() <= THRESHOLDS + 2);
    // Within the bounds, at most a five-hundredth of the draws lies between two thresholds. No draw is at the upper bound.
    let inside: Vec<f64> = drawn.iter().copied().filter(|q| *q > 0.0).collect();
    let below = |t: f64| inside.iter().filter(|q| **q <= t).count();
    let most = found.windows(2).map(|pair| below(pair[1]) - below(pair[0])).max().unwrap();
    assert!(most <= inside.len() / 490, "{most}");
    assert_eq!(found.last(), fine.iter().chain(&drawn).max_by(|a, b| a.total_cmp(b)));
    let nodes = nodes(&found, &drawn, &fine, &settings);
    assert!(nodes[0] == 0.0 && nodes.len() > NODES - 4 && nodes.len() <= NODES, "{}", nodes.len());
    for pair in nodes.windows(2) {
        let fraction = (below(pair[1]) - below(pair[0])) as f64 / inside.len() as f64;
        assert!((fraction * (NODES - 1) as f64 - 1.0).abs() < 0.2, "{fraction}");
    }
    // Enough fine samples on both sides.
    assert!(nodes[1..].iter().all(|t| fine.iter().filter(|q| *q > t).count() >= RARE));
    // With a fraction of the values at an upper bound, that bound is a threshold but no node.
    let capped = Settings { largest: 0.9, ..settings };
    let cap = |values: &[f64]| values.iter().map(|q| q.min(0.9)).collect::<Vec<f64>>();
    let (fine, drawn) = (cap(&fine), cap(&drawn));
    let found = thresholds(&fine, &drawn, &capped);
    assert_eq!(found.last(), Some(&0.9));
    assert!(super::nodes(&found, &drawn, &fine, &capped).iter().all(|t| *t < 0.9));
}

#[test]
fn folds_share_the_samples_and_golden_points_fill_the_interval() {
    for count in [0, 1, 7, 50, 101] {
        let sizes: Vec<usize> = (0..FOLDS).map(|fold| fold_size(fold, count)).collect();
        let wanted: Vec<usize> = (0..FOLDS).map(|fold| (0..count).filter(|i| i % FOLDS == fold).count()).collect();
        assert_eq!(sizes, wanted);
    }
    let mut points: Vec<f64> = (0..100).map(golden).collect();
    points.sort_by(f64::total_cmp);
    // No gap of a golden sequence is wider than about φ²/n.
    assert!(points.windows(2).all(|pair| pair[1] - pair[0] < 0.027) && points[0] < 0.027 && points[99] > 0.973);
    assert_eq!([0.0, 0.49, 0.99, 1.0].map(|fraction| pick(&[1.0, 2.0, 3.0], fraction)), [1.0, 2.0, 3.0, 3.0]);
}
