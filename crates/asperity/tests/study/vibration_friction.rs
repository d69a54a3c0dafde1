//! Friction of the vibration stage: constant, computed, stated, clipped, or read from a file.

use std::fs;
use std::path::Path;

use asperity::friction::upscaling::{exponential, variance_reduction};
use asperity::study::{FailureKind, Stage, Study};

use crate::support::{MODEL, USUAL, assert_numbers, changed, run, run_in};

#[test]
fn constant_friction_is_valid_in_every_stage() {
    let stated = changed(&MODEL[..MODEL.find("[surface]").unwrap()], &[])
        + &MODEL[MODEL.find("[vibration]").unwrap()..]
        + "static_friction = 0.2\nfriction_std = 0.0\nfriction_correlation_length = \"250 um\"\nfriction_marginal = \"normal\"\n";
    // A material that yields immediately, and stated friction without fluctuation.
    let soft = changed(
        &MODEL,
        &[
            ("\"2 GPa\"", "\"0.02 Pa\""),
            ("\"385 MPa\"", "\"0.004 Pa\""),
            ("\"30 kN\"", "\"0.001 uN\""),
            ("duration = 40.0", "duration = 40.0\nlevel = 60.0"),
        ],
    );
    for text in [stated, soft] {
        let outcome = run(&text, Some(Stage::Vibration));
        let undefined = [
            USUAL,
            &[
                "/skewness",
                "/excess_kurtosis",
                "/correlation_length_m",
                "/marginal",
                "/normality_p",
                "reattachment/mean",
                "reattachment/std",
                "release/mean",
                "release/std",
                "/motion",
                "/correlation_families_told_apart",
                "/correlation_length_without_window_m",
                "/correlation_without_window_fit_p",
                "/correlation_without_window_model",
                "/correlation_length_without_window_m_interval",
                "/window_only",
                "/level_mean_pressure_pa",
                "/period",
                "/slip_duration",
                "/reattachment_displacement",
                "/displacement_min",
                "/displacement_max",
                "/velocity_min",
            ],
        ]
        .concat();
        assert_numbers(&outcome, &undefined);
        let vibration = outcome.results.vibration.unwrap();
        assert!((vibration.static_friction - 0.2).abs() < 1e-12);
        for ensemble in [&vibration.paper, &vibration.area] {
            assert!(ensemble.friction_std == 0.0, "{:e}", ensemble.friction_std);
            assert!(ensemble.damping.iter().all(|d| d.difference_mean == 0.0 && d.difference_interval == [0.0, 0.0]));
        }
        assert!(vibration.marginal.is_none());
        assert!(outcome.results.assumptions.iter().any(|sentence| sentence.contains("is constant at 0.2")));
    }
}

#[test]
#[ignore = "slow"]
fn the_oscillator_uses_the_operating_point_in_its_own_units() {
    let text = changed(&MODEL, &[("dimensionless_belt_velocity = 0.003", "belt_velocity = \"20 mm/s\"")]);
    for (level, percentile) in [("", None), ("level = 20.0\n", Some(20.0))] {
        let results = run(&(text.clone() + level), Some(Stage::Vibration)).results;
        let (friction, vibration) = (results.friction.unwrap(), results.vibration.unwrap());
        let leading = friction.levels.iter().find(|level| level.leading).unwrap();
        let process = &leading.process.at_mean_load;
        assert_eq!((leading.percentile, vibration.level_percentile), (percentile, percentile));
        assert_eq!(vibration.static_friction, process.mean);
        assert_eq!(vibration.paper.friction_std, process.std);
        assert_eq!(vibration.friction_correlation_length_m, process.correlation_length_m);
        // λ = ℓ_μ c/N with c = mω₀², V = v_b m ω₀/N.
        let length = process.correlation_length_m.unwrap() * 316.0 * 316.0 / 30e3;
        assert!((vibration.correlation_length.unwrap() / length - 1.0).abs() < 1e-12);
        assert!((vibration.belt_velocity / (20e-3 * 316.0 / 30e3) - 1.0).abs() < 1e-12);
        let own_length_m = leading.process.correlation_length_without_window_m.unwrap();
        let kept = variance_reduction(friction.window_m, friction.window_width_m, 833e-6, &exponential(own_length_m));
        assert_eq!(vibration.variance_reduction, kept);
    }
}

/// Returns a study with stated friction of this standard deviation and nominal area.
fn stated(std: &str, area: &str) -> String {
    let text = "seed = 11\n".to_owned() + &MODEL[MODEL.find("[vibration]").unwrap()..];
    changed(&text, &[("\"833 mm^2\"", &format!("\"{area}\""))])
        + &format!(
            "static_friction = 0.2\nfriction_std = {std}\nfriction_correlation_length = \"250 um\"\n\
             friction_marginal = \"beta:2.1,5\"\n"
        )
}

#[test]
fn friction_is_clipped_to_stay_positive_and_refused_above_five_percent() {
    let refused = |text: &str| {
        let error = run_in(Path::new("."), text, None).unwrap_err();
        assert!(error.kind() == FailureKind::Configuration && error.to_string().contains("allow_clipping"), "{error}");
        error.to_string()
    };
    let text = stated("0.15", "1 um^2");
    // The fraction of Beta(2.1, 5) with standard deviation 0.15 below −0.9 times the smallest kinetic coefficient,
    // 0.2/(1 + 4.2 (V + 0.2 + m)) at the fastest slip, with V = 0.003 and m the fluctuation that one value in 10,000
    // exceeds. The distribution has the mean .295775 and the standard deviation .160359.
    let beta: asperity::distribution::Marginal = "beta:2.1,5".parse().unwrap();
    let largest = 0.15 * (beta.quantile(0.9999) - 0.295_775) / 0.160_359;
    let kinetic = 0.2 / (1.0 + 4.2 * (0.003 + 0.2 + largest));
    let fraction = beta.cdf(0.295_775 - 0.9 * kinetic / 0.15 * 0.160_359);
    let message = refused(&text);
    assert!(fraction > 0.05 && message.contains(&format!("{:.1}", 100.0 * fraction)), "{fraction}: {message}");
    let wild = run(&format!("{text}allow_clipping = true\n"), None).results;
    let warnings = wild.warnings.join("\n");
    for name in ["paper", "area"] {
        assert!(warnings.contains(&format!("with the {name} upscaling")), "{warnings}");
    }
    assert!(warnings.contains("clipped to stay positive; variability is understated"), "{warnings}");
    // Faster slips than expected clip more; the moments of the distribution have six digits.
    assert!(wild.vibration.as_ref().unwrap().paper.clipped_fraction >= fraction * (1.0 - 1e-4));
    // An area smaller than one window keeps the window's standard deviation and distribution.
    let vibration = wild.vibration.unwrap();
    assert_eq!((vibration.variance_reduction, vibration.area.friction_std), (1.0, vibration.paper.friction_std));
    assert_eq!(vibration.area, vibration.paper);
    // Over the nominal area the same fluctuation averages out; only the single window of the paper upscaling is
    // clipped, for comparison.
    let averaged = run(&stated("0.15", "833 mm^2"), None).results;
    assert!(
        averaged.warnings.iter().any(|warning| warning.contains("with the paper upscaling")),
        "{:?}",
        averaged.warnings
    );
    assert_eq!(averaged.vibration.unwrap().area.clipped_fraction, 0.0);
    let calm = run(&stated("0.001", "833 mm^2"), None).results;
    assert!(calm.warnings.is_empty(), "{:?}", calm.warnings);
    assert!(calm.assumptions.iter().any(|sentence| sentence.contains("the distribution becomes normal")));
}

#[test]
#[ignore = "slow"]
fn a_study_that_reads_the_process_of_another_gives_the_same_vibration() {
    let whole = run(&MODEL, Some(Stage::Vibration));
    let process = whole.friction_process.clone().unwrap();
    let (friction, vibration) = (whole.results.friction.unwrap(), whole.results.vibration.unwrap());
    let leading = &friction.levels.iter().find(|level| level.leading).unwrap().process.at_mean_load;
    assert_eq!((process.mean, process.std), (leading.mean, leading.std));
    assert_eq!(process.averaged_over_m, Some([friction.window_m, friction.strip_width_m]));
    assert_eq!(process.correlation.unwrap().window_m, Some(friction.window_m));
    // a in s/m, times N/(mω₀).
    assert!((process.stribeck_s_per_m.unwrap() * 30e3 / 316.0 / 4.2 - 1.0).abs() < 1e-12);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("process.json"), process.to_json().unwrap()).unwrap();
    let reads = "seed = 11\n".to_owned()
        + &MODEL[MODEL.find("[vibration]").unwrap()..]
        + "friction_process = \"process.json\"\n";
    let outcome = run_in(folder.path(), &reads, None).unwrap();
    assert!(outcome.friction_process.is_none());
    let read = outcome.results.vibration.unwrap();
    assert_eq!(
        asperity::study::result::VibrationResult { level_percentile: vibration.level_percentile, ..read },
        vibration
    );

    // Another process: other Stribeck curve, smooth correlation, unknown area.
    let mut other = process;
    other.stribeck_s_per_m = Some(0.03);
    other.averaged_over_m = None;
    other.mean_pressure_pa = None;
    let shape = asperity::friction::process::CorrelationShape::SquaredExponential;
    other.correlation.as_mut().unwrap().shape = shape;
    fs::write(folder.path().join("process.json"), other.to_json().unwrap()).unwrap();
    let results = run_in(folder.path(), &reads, None).unwrap().results;
    let vibration = results.vibration.unwrap();
    assert_eq!((vibration.variance_reduction, &vibration.area), (1.0, &vibration.paper));
    let warnings = results.warnings.join("\n");
    assert!(warnings.contains("Stribeck") && warnings.contains("does not say over which area"), "{warnings}");

    // Invalid files, and studies that state the friction twice.
    fs::write(folder.path().join("process.json"), "{\"format\": 3}").unwrap();
    for (text, wanted) in [
        (reads.clone(), "process.json: not a friction process"),
        (reads.replace("process.json", "no.json"), "no such file"),
    ] {
        let error = run_in(folder.path(), &text, None).unwrap_err();
        assert!(error.kind() == FailureKind::Input && error.to_string().contains(wanted), "{error}");
    }
    for text in [
        stated("0.1", "833 mm^2") + "friction_process = \"process.json\"\n",
        MODEL.clone() + "friction_process = \"process.json\"\n",
    ] {
        let error = Study::parse(&text, "study.toml").unwrap_err();
        assert!(error.message.contains("friction_process") && error.message.contains("remove one"), "{error}");
    }
}
