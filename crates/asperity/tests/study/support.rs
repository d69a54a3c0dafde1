//! Small studies that several tests share, and checks of their results.

use std::path::Path;
use std::sync::LazyLock;

use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::random;
use asperity::study::{Outcome, Results, Stage, Study, StudyError, json_bytes};
use asperity::surface::{RandomSurface, SpectralField};
use asperity_formats::Scan;
use asperity_testing::{METHODS, StudyText};
use ndarray::Array2;
use serde_json::Value;

/// A model instead of a scan; every stage, small and of unusual sizes.
pub(crate) static MODEL: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(11, &["surface", "material", "pressure", "friction", "vibration"])
        .with("surface", "covariance = \"squared_exponential\"\nrms_height = \"0.5 um\"")
        .with("surface", "correlation_length = [\"20 um\", \"12 um\"]\nmodes = 30")
        .with("pressure", "size = [\"90 um\", \"70 um\"]\npoints = [21, 17]\nfine_solves = 30")
        .with("pressure", METHODS)
        .with("pressure", "reference_samples = 40\nvariables = 2\ndegree = 1")
        .with("friction", "strip = [\"1 mm\", \"31 um\"]\npoints = [301, 11]\nwindow = \"99 um\"")
        .with("friction", "percentiles = [60.0, 20.0]\nrealisations = 3")
        .with("vibration", "normal_force = \"30 kN\"\ndamping_sweep = [0.1, 0.5, 2]\ntrajectories = 3")
        .with("vibration", "duration = 40.0")
        .to_string()
});

/// Returns the same study from `scan.npy`.
pub(crate) fn measured() -> String {
    changed(
        &MODEL,
        &[
            ("covariance = \"squared_exponential\"", "file = \"scan.npy\"\npixel_size = [\"2 um\", \"2 um\"]"),
            ("marginal = \"normal\"\n", ""),
            ("rms_height = \"0.5 um\"\n", ""),
            ("correlation_length = [\"20 um\", \"12 um\"]\n", ""),
        ],
    )
}

/// Returns a text with replacements, each of which must apply.
pub(crate) fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// Parses a study.
pub(crate) fn study(text: &str) -> Study {
    Study::parse(text, "study.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Runs a study whose files lie in `folder`; with `only`, one stage and the stages it needs.
pub(crate) fn run_in(folder: &Path, text: &str, only: Option<Stage>) -> Result<Outcome, StudyError> {
    study(text).run(folder, only, &Silent)
}

/// Runs a study without files; with `only`, one stage and the stages it needs.
pub(crate) fn run(text: &str, only: Option<Stage>) -> Outcome {
    run_in(Path::new("."), text, only).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Runs all stages of a study without files.
pub(crate) fn run_all(text: &str) -> Outcome {
    run(text, None)
}

/// Draws a periodic rough map with a pitch of 2 µm, heights in metre.
pub(crate) fn rough(nx: usize, ny: usize, rms_m: f64, length_m: f64) -> Array2<f64> {
    let grid = Grid::new(nx, ny, 2e-6, 2e-6).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, rms_m, length_m).unwrap();
    let field = SpectralField::periodic(&covariance, grid);
    let xi = random::standard_normal(&mut random::stream(3, "scan", 0), field.xi_len());
    field.generate(&xi).heights_m().clone()
}

/// Creates a folder with the heights as `scan.npy`.
pub(crate) fn folder_with(heights_m: Array2<f64>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    asperity_formats::write(&Scan::new(heights_m, None), &folder.path().join("scan.npy")).unwrap();
    folder
}

/// Collects the paths of all nulls.
fn nulls(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Null => found.push(path.to_owned()),
        Value::Array(items) => items.iter().for_each(|item| nulls(item, path, found)),
        // A method without an estimate has a reason.
        Value::Object(entries)
            if ["failure", "reason"].iter().any(|key| entries.get(*key).is_some_and(Value::is_string)) => {}
        Value::Object(entries) => {
            // A method without intervals has a reason.
            let reasoned = entries.get("interval_failure").is_some_and(Value::is_string);
            // So has a quotient F/N without variance.
            let heavy_tailed = entries.get("no_variance").is_some_and(Value::is_string);
            let known = |key: &str| {
                !(reasoned && INTERVALS.iter().any(|part| key.contains(part))
                    || heavy_tailed && VARIANCES.contains(&key))
            };
            let entries = entries.iter().filter(|(key, _)| known(key));
            entries.for_each(|(key, item)| nulls(item, &format!("{path}/{key}"), found));
        }
        _ => {}
    }
}

/// Parts of the keys that a method without intervals leaves undefined.
const INTERVALS: [&str; 4] = ["interval", "_se", "band_factor", "quantiles"];

/// Keys that a quotient F/N without variance leaves undefined.
const VARIANCES: [&str; 6] =
    ["std", "coefficient_of_variation", "skewness", "excess_kurtosis", "correlation_length_m", "marginal"];

/// Returns whether an undefined number belongs to an interval of friction: small strips have too few correlation
/// lengths for intervals of moments, lengths and distributions, and constant friction has none. Only a rough slider has parts.
fn interval_of_friction(path: &str) -> bool {
    path.starts_with("/friction/")
        && (path.ends_with("/no_variance")
            || path.ends_with("/between_parts_std")
            || path.ends_with("_interval")
            || path.contains("/gof")
            || path.contains("/marginal_parameter_intervals/"))
}

/// Asserts that only numbers that may be undefined are null.
pub(crate) fn assert_numbers(outcome: &Outcome, undefined: &[&str]) {
    let bytes = json_bytes(&outcome.results).unwrap();
    assert_eq!(serde_json::from_slice::<Results>(&bytes).unwrap(), outcome.results, "results are read back as written");
    let json: Value = serde_json::from_slice(&bytes).unwrap();
    let mut found = Vec::new();
    nulls(&json, "", &mut found);
    // A small map has too few correlation lengths for intervals; a statistic with one null has two.
    let statistic = |path: &str| path.strip_suffix("_interval").or_else(|| path.strip_suffix("_se")).map(str::to_owned);
    let surface = &json["surface"];
    // A free strip has no mean compliance and no contact stiffness.
    let is_free = json["friction"]["mean_compliance_m_per_pa"].is_null();
    found.retain(|path| {
        let own = statistic(path).and_then(|own| own.strip_prefix("/surface/").map(str::to_owned));
        let absent =
            |own: String| surface[format!("{own}_interval")].is_null() && surface[format!("{own}_se")].is_null();
        let stiffness = is_free && path.starts_with("/friction/operating_point/contact_stiffness");
        !own.is_some_and(absent)
            && !interval_of_friction(path)
            && !stiffness
            && !undefined.iter().any(|allowed| path.ends_with(allowed))
    });
    assert!(found.is_empty(), "null: {found:?}");
    for sentence in outcome.results.assumptions.iter().chain(&outcome.results.warnings) {
        assert!(!sentence.contains("NaN") && !sentence.contains("inf "), "{sentence}");
    }
}

/// Suffixes of keys that the model study leaves undefined: parameters of other models, methods that failed for lack of
/// samples, and results that need a limit cycle or an expansion.
pub(crate) const USUAL: &[&str] = &[
    // Methods that need no correction, and methods with intervals.
    "contact_probability_bias",
    "mean_bias_pa",
    "interval_failure",
    // No kick is needed if steady sliding is unstable.
    "/kick_m_per_s",
    "/smoothness",
    "/hurst",
    "/misfit",
    "/slope_ratio",
    // A surface without a scan, or without a hardness.
    "/mean_of_scan",
    "/scan",
    "/saturation",
    "/order",
    "/slope_cutoff_m",
    "/karhunen_loeve",
    "/percentile",
    "/level_percentile",
    "/failure",
    "/coefficients",
    "/leave_one_out_error",
    "/separation_m",
    "/mean_compliance_m_per_pa",
    "/beta",
    // Without a hardness, and without a scan.
    "/plastic_floor",
    "/band_end_m",
    // Too few separate peaks.
    "/tail",
    // No scaling range, and too few points.
    "/fractal_dimension",
    "/hurst_range_low_m",
    "/hurst_range_high_m",
    "/normality_p",
    // Fewer than five strips; and a cycle that is never lost, or that never exists.
    "/correlation_without_window_agreement_p",
    "/exit_rate",
    "/exit_rate_interval",
    "/entry_rate",
    "/entry_rate_interval",
];
