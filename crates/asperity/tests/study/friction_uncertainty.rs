//! Friction of surfaces with uncertain parameters, compared with closed forms.

use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use asperity::monitor::Monitor;
use asperity::study::Outcome;
use asperity::study::result::{UncertainResponse, UncertaintyResult};
use asperity::study::{Stage, Study, StudyError};
use asperity_testing::StudyText;

use crate::support;

static STUDY: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(5, &["surface", "material", "friction"])
        .with("surface", "covariance = \"squared_exponential\"\nrms_height = \"0.5 um\"\ngenerator = \"spectral\"")
        .with("surface", "correlation_length = \"16 um\"")
        .with("friction", "strip = [\"1024 um\", \"64 um\"]\npoints = [512, 32]\npercentiles = []")
        .with("friction", "mean_pressures = [\"300 MPa\"]\nrealisations = 4")
        .with("friction.uncertainty", "rms_height = \"5 %\"\ncorrelation_length = \"10 %\"")
        .with("friction.uncertainty", "points = 24\nrealisations = 8")
        .without("material", &["hardness"])
        .to_string()
});

fn run(text: &str) -> Outcome {
    support::run(text, Some(Stage::Friction))
}

fn uncertainty(outcome: &Outcome) -> &UncertaintyResult {
    outcome.results.friction.as_ref().unwrap().uncertainty.as_ref().unwrap()
}

fn named<'a>(responses: &'a [UncertainResponse], name: &str) -> &'a UncertainResponse {
    responses.iter().find(|response| response.name == name).unwrap()
}

#[test]
#[ignore = "slow"]
fn at_light_load_the_indices_are_those_of_the_slope() {
    // Elastic contact of small area: A/A₀ ∝ p̄/(E* h'rms), so μ = τA/N ∝ 1/h'rms ∝ ℓ/Sq. The variance of ln μ is the
    // sum of the variances of ln ℓ and ln Sq.
    // Eight correlation lengths across; on narrower strips the periodic covariance has a kink that adds slopes.
    let text = STUDY
        .replace("64 um", "128 um")
        .replace("[512, 32]", "[512, 64]")
        .replace("points = 24\nrealisations = 8", "points = 12\nrealisations = 16");
    let outcome = run(&text);
    assert!(
        outcome.results.warnings.iter().all(|warning| !warning.contains("clipped")),
        "{:?}",
        outcome.results.warnings
    );
    let found = uncertainty(&outcome);
    let level = &found.levels[0];
    assert_eq!((found.points, found.realisations, level.mean_pressure_pa), (12, 16, Some(300e6)));
    assert!(outcome.results.friction.as_ref().unwrap().levels[0].contact_fraction < 0.06);
    let mean = named(&level.at_mean_load, "mean");
    println!("{mean:#?}");
    let (height, length) = (0.05_f64.powi(2).ln_1p(), 0.1_f64.powi(2).ln_1p());
    let share = (height + length).exp_m1();
    for (index, first) in mean.sobol.iter().zip([height.exp_m1() / share, length.exp_m1() / share]) {
        // The length also changes the number of cells in a contact, which changes the area by about one per cent.
        let allowed = 0.03;
        let within = |[low, high]: [f64; 2], value: f64| (low - allowed..=high + allowed).contains(&value);
        assert!(within(index.first_interval, first), "{first} {index:?}");
        assert!((index.first - first).abs() < 0.06 && index.total >= index.first - 1e-12, "{first} {index:?}");
    }
    // The area grows slightly less than the load, which reduces the variance.
    let variation = mean.std.unwrap() / mean.value.unwrap() / share.sqrt();
    assert!((0.8..1.05).contains(&variation), "{variation}");
    // All surfaces have the same strips: their common deviation moves the mean and adds little to the variance.
    assert!(mean.noise_share.unwrap() < 0.1 && mean.noise_standard_error.unwrap() > 0.0);
    assert!(mean.loo_error.unwrap() < 0.1);
    let [low, high] = mean.interval.unwrap();
    let ratio = (high / low).ln() / (4.0 * 1.96 * (height + length).sqrt() / 2.0);
    assert!((0.75..1.1).contains(&ratio), "{ratio}");
    // The tables agree with the results.
    let table = &outcome.tables["friction_sensitivity"];
    let total = table.column("mean_total_correlation_length").unwrap()[0];
    assert_eq!(total, named(&level.at_mean_load, "mean").sobol[1].total);
    assert_eq!(
        outcome.tables["friction_uncertainty"].column("mean").unwrap()[0],
        named(&level.responses, "mean").value.unwrap()
    );
}

#[test]
#[ignore = "slow"]
fn the_std_in_full_contact_is_proportional_to_the_heights() {
    // In full contact μ̄ = τ/p̄ for any surface, and the load of a window is linear in the heights: the standard
    // deviation at the mean load is proportional to Sq.
    let text = STUDY.replace("300 MPa", "200 GPa").replace("correlation_length = \"10 %\"\n", "");
    let outcome = run(&text);
    assert!((outcome.results.friction.as_ref().unwrap().levels[0].contact_fraction - 1.0).abs() < 1e-12);
    let level = &uncertainty(&outcome).levels[0];
    let mean = named(&level.at_mean_load, "mean");
    assert!((mean.value.unwrap() / (385e6 / 200e9) - 1.0).abs() < 1e-5, "{mean:?}");
    assert!(mean.std.unwrap() < 1e-6 * mean.value.unwrap() && mean.sobol.is_empty());
    assert_eq!((mean.noise_share, mean.loo_error), (Some(0.0), Some(0.0)));
    let std = named(&level.at_mean_load, "std");
    let variation = std.std.unwrap() / std.value.unwrap();
    assert!((variation / 0.05 - 1.0).abs() < 5e-3, "{variation}");
    assert!(std.loo_error.unwrap() < 1e-3 && (std.sobol[0].total - 1.0).abs() < 1e-9);
    // An error of the strips by a factor looks like an influence of the parameter, so the index is a positive fraction.
    let relative = std.noise_standard_error.unwrap() / std.value.unwrap();
    assert!((std.noise_share.unwrap() / (relative * relative) - 1.0).abs() < 0.02, "{std:?}");
    let [low, high] = std.interval.unwrap();
    let sigma = 0.05_f64.powi(2).ln_1p().sqrt();
    assert!(((high / low).ln() / (2.0 * 1.96 * sigma) - 1.0).abs() < 0.02, "{low} {high}");
}

#[test]
fn friction_independent_of_the_surface_has_no_indices() {
    // Coulomb's law: μ does not depend on the contact.
    let text = STUDY.replace("[friction]\n", "[friction]\nlaw = \"coulomb\"\ncoefficient = 0.2\n");
    let outcome = run(&text);
    let level = &uncertainty(&outcome).levels[0];
    let mean = named(&level.responses, "mean");
    assert!((mean.value.unwrap() - 0.2).abs() < 1e-12);
    assert_eq!((mean.std, mean.sobol.len(), mean.loo_error), (Some(0.0), 0, Some(0.0)));
    assert!(mean.reason.as_ref().unwrap().contains("does not depend"));
    let length = named(&level.responses, "correlation_length_m");
    assert_eq!((length.value, length.std, length.interval), (None, None, None));
    assert!(length.reason.as_ref().unwrap().contains("undefined"));
}

#[test]
#[ignore = "slow"]
fn the_levels_equal_those_of_the_study_without_uncertainty() {
    let (with, without) = (run(&STUDY), run(STUDY.split("[friction.uncertainty]").next().unwrap()));
    let (with, without) = (with.results.friction.unwrap(), without.results.friction.unwrap());
    assert_eq!(with.levels, without.levels);
    assert!(without.uncertainty.is_none());
}

#[test]
#[ignore = "slow"]
fn skewness_and_percentiles_can_be_combined() {
    let text = STUDY
        .replace("percentiles = []", "percentiles = [20.0]")
        .replace("mean_pressures = [\"300 MPa\"]\n", "")
        .replace("correlation_length = \"10 %\"", "skewness = 0.3")
        .replace("points = 24", "points = 12");
    let outcome = run(&text);
    let found = uncertainty(&outcome);
    assert_eq!(found.parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["rms_height", "skewness"]);
    assert_eq!((found.parameters[1].mean, found.parameters[1].std), (0.0, 0.3));
    assert_eq!((found.levels[0].percentile, found.levels[0].mean_pressure_pa), (Some(20.0), None));
    let told = outcome
        .results
        .assumptions
        .iter()
        .any(|words| words.contains("Johnson") && words.contains("each surface's own"));
    assert!(told, "{:?}", outcome.results.assumptions);
}

#[test]
fn impossible_values_are_errors_that_name_their_line() {
    let section = STUDY.lines().position(|line| line == "[friction.uncertainty]").unwrap() + 1;
    for (from, to, line, wanted) in [
        ("rms_height = \"5 %\"", "rms_height = \"-5 %\"", 1, "above 0 %"),
        ("rms_height = \"5 %\"", "rms_height = \"-1 um\"", 1, "positive"),
        ("rms_height = \"5 %\"", "rms_hight = \"5 %\"", 1, "did you mean `rms_height`?"),
        ("rms_height = \"5 %\"", "rms_height = \"measured\"", 1, "state a standard deviation"),
        ("rms_height = \"5 %\"", "rms_height = 0.05", 1, "such as \"5 %\""),
        ("correlation_length = \"10 %\"", "correlation_length = \"ten\"", 2, "does not start with a number"),
        ("correlation_length = \"10 %\"", "skewness = -0.1", 2, "above 0"),
        ("correlation_length = \"10 %\"", "skewness = \"measured\"", 2, "state a standard deviation"),
        ("points = 24", "points = 11", 3, "at least 12"),
        ("realisations = 8", "realisations = 2", 4, "at least 4"),
        ("rms_height = \"5 %\"\ncorrelation_length = \"10 %\"\n", "", 0, "no parameter is uncertain"),
    ] {
        assert!(STUDY.contains(from), "{from}");
        let error = Study::parse(&STUDY.replace(from, to), "study.toml").unwrap_err();
        assert!(error.line == section + line && error.message.contains(wanted), "{from} → {to}: {error}");
    }
    // Writing the study and parsing it again preserves it.
    let study = Study::parse(&STUDY, "study.toml").unwrap();
    let written = toml::to_string(study.file()).unwrap();
    assert_eq!(Study::parse(&written, "written").unwrap().file(), study.file());
}

/// Monitor that cancels once the uncertainty analysis has begun.
struct CancelDuringUncertainty(AtomicUsize);

impl Monitor for CancelDuringUncertainty {
    fn progress(&self, what: &str, done: usize, total: usize) {
        if what == "friction uncertainty" {
            assert_eq!(total, 24 * 8);
            self.0.fetch_max(done, Ordering::Relaxed);
        }
    }

    fn cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }
}

#[test]
fn the_uncertainty_analysis_can_be_cancelled() {
    let study = Study::parse(&STUDY, "study.toml").unwrap();
    let monitor = CancelDuringUncertainty(AtomicUsize::new(0));
    let error = study.run(Path::new("."), Some(Stage::Friction), &monitor).unwrap_err();
    assert!(matches!(error, StudyError::Cancelled(_)), "{error}");
    assert!(monitor.0.load(Ordering::Relaxed) < 24 * 8);
}
