//! Figure 3 of the paper: moments of friction against penetration.

use std::fs;
use std::path::PathBuf;

use asperity::monitor::Silent;
use asperity::study::StudyFile;
use asperity::study::result::LevelResult;

/// A moment and its standard error, from half the width of its 95 % interval.
type Known = (f64, f64);

fn known(value: f64, interval: Option<[f64; 2]>) -> Known {
    let [low, high] = interval.unwrap();
    (value, (high - low) / (2.0 * 1.96))
}

/// Asserts that a moment falls from level to level within two standard errors, and by more than that from the second to
/// the last. At the first level some windows carry almost no load, so a few strips do not determine its standard
/// deviation.
fn falls(name: &str, levels: &[Known]) {
    for pair in levels.windows(2) {
        let ((before, before_se), (after, after_se)) = (pair[0], pair[1]);
        assert!(after - before < 2.0 * before_se.hypot(after_se), "{name} rises from {before} to {after}");
    }
    let ((first, first_se), (last, last_se)) = (levels[1], levels[levels.len() - 1]);
    assert!(
        first - last > 2.0 * first_se.hypot(last_se),
        "{name} does not fall: {first} ± {first_se}, {last} ± {last_se}"
    );
}

#[test]
#[ignore = "slow"]
fn mean_std_and_variation_of_friction_fall_with_penetration_and_the_skewness_is_positive() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../studies/paper_fig3.toml");
    let study = StudyFile::parse(&fs::read_to_string(&path).unwrap(), "paper_fig3.toml").unwrap();
    let outcome = study.check().unwrap().run(path.parent().unwrap(), None, &Silent).unwrap();
    let friction = outcome.results.friction.unwrap();
    let percentiles: Vec<f64> = friction.levels.iter().map(|level| level.percentile.unwrap()).collect();
    assert_eq!(percentiles, [5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0]);
    let at_mean_load =
        |level: &LevelResult| known(level.process.at_mean_load.mean, level.process.at_mean_load.mean_interval);
    falls("mean", &friction.levels.iter().map(at_mean_load).collect::<Vec<_>>());
    // At the lightest level windows with few contacts may leave F/N without a variance.
    let varied = &friction.levels[usize::from(friction.levels[0].std.is_none())..];
    let std = |level: &LevelResult| known(level.std.unwrap(), level.std_interval);
    let variation =
        |level: &LevelResult| known(level.coefficient_of_variation.unwrap(), level.coefficient_of_variation_interval);
    falls("std", &varied.iter().map(std).collect::<Vec<_>>());
    falls("CoV", &varied.iter().map(variation).collect::<Vec<_>>());
    for level in varied {
        // Skewness > −2 standard errors: positive or undetermined.
        let reach = level.skewness_interval.map_or(0.0, |[low, high]| (high - low) / 1.96);
        assert!(level.skewness.unwrap() > -reach, "{:?}", level.skewness);
        // τ_max/H.
        assert!(level.mean.unwrap() > 0.19245);
        // Correlation lengths of 20 µm under windows of 75 to 600 µm: the correlation is due to the windows alone.
        assert_eq!(level.process.window_only, Some(true), "at {:?}", level.percentile);
        // ℓ of an exponential fitted to the triangular correlation of a 600 µm window: 322–368 µm; 3 standard errors of
        // 16 strips.
        let length_m = level.process.at_mean_load.correlation_length_m.unwrap();
        let [low, high] = level.process.at_mean_load.correlation_length_m_interval.unwrap();
        let reach_m = 1.5 * (high - low) / 1.96;
        assert!(length_m > 322e-6 - reach_m && length_m < 368e-6 + reach_m, "{length_m:e} ± {reach_m:e}");
    }
    // The report states boundary, mean compliance and window.
    let said = outcome.results.assumptions.join(" ");
    assert!(said.contains("periodic, of mean compliance 8.276 nm/MPa") && said.contains("600.6 µm"), "{said}");
    assert_eq!(friction.mean_compliance_m_per_pa.map(|c| (c * 1e18).round()), Some(8276.0));
}
