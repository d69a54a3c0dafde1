use super::*;

const METHODS: [SamplingMethod; 4] = [
    SamplingMethod::MonteCarlo,
    SamplingMethod::LatinHypercube,
    SamplingMethod::MaximinLatinHypercube,
    SamplingMethod::Sobol,
];

fn strata(design: &Design, dimension: usize, count: usize) -> Vec<usize> {
    let mut counts = vec![0; count];
    for index in 0..count.min(design.samples()) {
        counts[(design.unit(index)[dimension] * count as f64) as usize] += 1;
    }
    counts
}

#[test]
fn a_latin_hypercube_has_one_point_in_every_stratum_of_every_variable() {
    for samples in [1, 2, 7, 500] {
        for method in [SamplingMethod::LatinHypercube, SamplingMethod::MaximinLatinHypercube] {
            let design = Design::new(method, 5, "lhs", samples, 9).unwrap();
            for dimension in 0..9 {
                assert_eq!(strata(&design, dimension, samples), vec![1; samples]);
            }
        }
    }
}

#[test]
fn strata_of_a_table_equal_those_computed_for_each_point() {
    let (few, many) = (9, MAX_TABLE / 7 + 1);
    let [table, computed] = [few, many].map(|n| Design::new(SamplingMethod::LatinHypercube, 5, "lhs", 7, n).unwrap());
    assert!(matches!(&table.placement, Placement::Table(_)));
    assert!(matches!(&computed.placement, Placement::Strata(kept) if kept.is_empty()));
    for sample in 0..7 {
        let mut point = vec![0.0; few];
        computed.fill_unit(sample, &mut point);
        assert_eq!(point, table.unit(sample));
    }
}

#[test]
fn many_samples_of_few_variables_keep_their_permutations() {
    let samples = 1 << 17;
    let design = Design::new(SamplingMethod::LatinHypercube, 5, "lhs", samples, 2).unwrap();
    assert!(matches!(&design.placement, Placement::Strata(kept) if kept.len() == 2));
    assert_eq!(strata(&design, 1, samples), vec![1; samples]);
}

#[test]
fn leading_variables_equal_those_of_the_whole_point() {
    for method in METHODS {
        let design = Design::new(method, 3, "leading", 20, 12).unwrap();
        assert!((0..20).all(|sample| design.leading_xi(sample, 5) == design.xi(sample)[..5]));
    }
}

#[test]
fn every_dyadic_prefix_of_sobol_points_is_stratified_in_every_variable() {
    let design = Design::new(SamplingMethod::Sobol, 5, "sobol", 1000, 101).unwrap();
    for dimension in 0..101 {
        for log2 in [0, 3, 9] {
            assert_eq!(strata(&design, dimension, 1 << log2), vec![1; 1 << log2], "dimension {dimension}");
        }
    }
}

#[test]
fn xi_samples_have_the_moments_of_independent_standard_normals() {
    let (samples, dimensions) = (2000, 12);
    for method in METHODS {
        let design = Design::new(method, 11, "moments", samples, dimensions).unwrap();
        let xi_samples: Vec<Vec<f64>> = (0..samples).map(|i| design.xi(i)).collect();
        let n = samples as f64;
        for a in 0..dimensions {
            let mean = xi_samples.iter().map(|g| g[a]).sum::<f64>() / n;
            assert!(mean.abs() < 4.5 / n.sqrt(), "{method:?}: mean {mean}");
            for b in 0..=a {
                let product = xi_samples.iter().map(|g| g[a] * g[b]).sum::<f64>() / n;
                let (wanted, variance) = if a == b { (1.0, 2.0) } else { (0.0, 1.0) };
                let bound = 4.5 * f64::sqrt(variance / n);
                assert!((product - wanted).abs() < bound, "{method:?}: E ξ{a} ξ{b} = {product}");
            }
        }
    }
}

#[test]
fn a_point_depends_only_on_seed_stage_index_and_sample_size() {
    for method in METHODS {
        let point = |seed, stage, index| Design::new(method, seed, stage, 100, 5).unwrap().xi(index);
        assert_eq!(point(1, "a", 17), point(1, "a", 17));
        assert_ne!(point(1, "a", 17), point(1, "a", 18));
        assert_ne!(point(1, "a", 17), point(2, "a", 17));
        assert_ne!(point(1, "a", 17), point(1, "b", 17));
    }
}

#[test]
fn a_longer_monte_carlo_or_sobol_design_starts_with_the_shorter_one() {
    for method in [SamplingMethod::MonteCarlo, SamplingMethod::Sobol] {
        let short = Design::new(method, 1, "prefix", 10, 3).unwrap();
        let long = Design::new(method, 1, "prefix", 1000, 3).unwrap();
        assert!((0..10).all(|i| short.unit(i) == long.unit(i)));
    }
}

/// Returns the root-mean-square error of the sample mean of f over 40 designs; E f = 0.
fn rms_error(method: SamplingMethod, samples: usize, f: impl Fn(&[f64]) -> f64) -> f64 {
    let squares: f64 = (0..40)
        .map(|seed| {
            let design = Design::new(method, seed, "rms", samples, 3).unwrap();
            let mean = (0..samples).map(|i| f(&design.unit(i))).sum::<f64>() / samples as f64;
            mean * mean
        })
        .sum();
    (squares / 40.0).sqrt()
}

#[test]
fn stratified_designs_integrate_with_the_expected_accuracy() {
    let n: usize = 256;
    let additive = |u: &[f64]| u.iter().map(|x| x - 0.5).sum::<f64>();
    // Variance 3/12 for independent points; Latin hypercube variance 3/(12 n³) exactly.
    let monte_carlo = rms_error(SamplingMethod::MonteCarlo, n, additive) / (0.25 / n as f64).sqrt();
    let latin = rms_error(SamplingMethod::LatinHypercube, n, additive) / (0.25 / (n as f64).powi(3)).sqrt();
    // The relative standard error of a root-mean-square over 40 values is 1/√80; four of them.
    for ratio in [monte_carlo, latin] {
        assert!((ratio - 1.0).abs() < 4.0 / 80.0_f64.sqrt(), "ratio {ratio}");
    }
}

#[test]
fn scrambled_sobol_points_gain_an_order_on_a_smooth_interaction() {
    let interaction = |u: &[f64]| (u[0] - 0.5) * (u[1] - 0.5) * 12.0 + (u[1] - 0.5) * (u[2] - 0.5) * 12.0;
    let coarse = rms_error(SamplingMethod::Sobol, 64, interaction);
    let fine = rms_error(SamplingMethod::Sobol, 1024, interaction);
    // Between the Monte Carlo order ½ and the asymptotic 3/2 (up to a logarithm); the noise of the order is 0.06.
    let order = (coarse / fine).ln() / 16.0_f64.ln();
    assert!(order > 1.0, "observed order {order:.2}");
    let latin = rms_error(SamplingMethod::LatinHypercube, 1024, interaction);
    assert!(fine < 0.3 * latin, "Sobol' {fine:.2e}, Latin hypercube {latin:.2e}");
}

#[test]
fn impossible_designs_are_refused() {
    assert_eq!(
        Design::new(SamplingMethod::Sobol, 1, "x", 10, 1868).unwrap_err(),
        SamplingError::TooManyDimensions { dimensions: 1868, limit: 1867 }
    );
    assert_eq!(
        Design::new(SamplingMethod::MaximinLatinHypercube, 1, "x", 2001, 2).unwrap_err(),
        SamplingError::TooManyForMaximin { samples: 2001, limit: 2000 }
    );
    assert_eq!(
        Design::new(SamplingMethod::MonteCarlo, 1, "x", 0, 3).unwrap_err(),
        SamplingError::Empty { samples: 0, dimensions: 3 }
    );
}

#[test]
fn a_thousand_and_more_variables_have_sobol_points() {
    let design = Design::new(SamplingMethod::Sobol, 5, "sobol", 256, 1867).unwrap();
    for dimension in [480, 481, 1000, 1110, 1111, 1500, 1866] {
        for log2 in [0, 3, 8] {
            assert_eq!(strata(&design, dimension, 1 << log2), vec![1; 1 << log2], "dimension {dimension}");
        }
    }
}

fn least_distance(design: &Design) -> f64 {
    let points: Vec<Vec<f64>> = (0..design.samples()).map(|i| design.unit(i)).collect();
    let mut least = f64::INFINITY;
    for (i, a) in points.iter().enumerate() {
        for b in &points[..i] {
            least = least.min(a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum());
        }
    }
    least.sqrt()
}

#[test]
fn maximin_points_keep_more_distance_than_those_of_a_hundred_latin_hypercubes() {
    for (samples, dimensions) in [(20, 2), (100, 4), (200, 10)] {
        let least = |method, seed| least_distance(&Design::new(method, seed, "lhs", samples, dimensions).unwrap());
        let plain = (0..100).map(|seed| least(SamplingMethod::LatinHypercube, seed)).fold(0.0, f64::max);
        let found = least(SamplingMethod::MaximinLatinHypercube, 0);
        assert!(found > plain, "{samples} × {dimensions}: {found}, best of a hundred {plain}");
    }
}

#[test]
#[ignore = "slow"]
fn replicates_are_independent_and_their_spread_is_the_standard_error() {
    // f has mean 0 and an interaction, which no design of 64 points integrates exactly.
    let f = |u: &[f64]| (u[0] - 0.5) + 12.0 * (u[1] - 0.5) * (u[2] - 0.5);
    for method in METHODS {
        let (groups, replicates) = (60, 10);
        let (mut squares, mut beyond, mut neighbours) = (0.0, 0, 0.0);
        for seed in 0..groups {
            let design = Design::new(method, seed, "replicated", 64, 3).unwrap();
            let means: Vec<f64> = (0..replicates)
                .map(|r| design.replicate(r).unwrap())
                .map(|design| (0..64).map(|i| f(&design.unit(i))).sum::<f64>() / 64.0)
                .collect();
            let mean = means.iter().sum::<f64>() / 10.0;
            let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 9.0;
            // The 97.5 % point of Student's distribution with 9 degrees of freedom.
            beyond += usize::from(mean.abs() > 2.262 * (variance / 10.0).sqrt());
            squares += means.iter().map(|m| m * m).sum::<f64>();
            neighbours += means.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        }
        // Correlation of neighbours: standard error 1/√540. Misses: 3 expected, standard deviation 1.7.
        let correlation = neighbours / 9.0 / (squares / 10.0);
        assert!(correlation.abs() < 4.0 / 540.0_f64.sqrt(), "{method:?}: correlation {correlation}");
        assert!(beyond <= 9, "{method:?}: {beyond} of {groups} intervals miss the mean");
    }
}

#[test]
fn the_first_replicate_is_the_design() {
    for method in METHODS {
        let design = Design::new(method, 4, "same", 30, 3).unwrap();
        assert_eq!(design.replicate(0).unwrap().xi(7), design.xi(7));
        assert_ne!(design.replicate(1).unwrap().xi(7), design.xi(7));
        assert_eq!(design.replicate(1).unwrap().xi(7), design.replicate(1).unwrap().xi(7));
    }
}
