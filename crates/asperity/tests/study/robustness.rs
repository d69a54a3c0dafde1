//! Studies off the beaten track: every choice of a study file, awkward scans, and what is refused.

use std::fs;
use std::path::Path;

use asperity::correlation::{CorrelationModel, Covariance};
use asperity::friction::upscaling::{exponential, variance_reduction};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::random;
use asperity::study::{FailureKind, Outcome, Results, Stage, Study, StudyError, json_bytes};
use asperity::surface::{RandomSurface, SpectralField};
use asperity_formats::Scan;
use ndarray::Array2;
use serde_json::Value;

/// A model instead of a scan; every stage, small and of awkward sizes.
const MODEL: &str = r#"
seed = 11
[surface]
covariance = "squared_exponential"
marginal = "normal"
rms_height = "0.5 um"
correlation_length = ["20 um", "12 um"]
modes = 30
[material]
youngs_modulus = "210 GPa"
hardness = "2 GPa"
shear_strength = "385 MPa"
[pressure]
size = ["90 um", "70 um"]
points = [21, 17]
percentile = 50.0
fine_solves = 30
reference_samples = 40
variables = 2
degree = 1
[friction]
strip = ["1 mm", "31 um"]
points = [301, 11]
window = "99 um"
percentiles = [60.0, 20.0]
realisations = 3
[vibration]
mass = "1 kg"
natural_frequency = "316 rad/s"
damping_ratio = 0.17
normal_force = "30 kN"
nominal_area = "833 mm^2"
dimensionless_belt_velocity = 0.003
damping_sweep = [0.1, 0.5, 2]
trajectories = 3
duration = 40.0
"#;

/// The same from `scan.npy`.
fn measured() -> String {
    changed(
        MODEL,
        &[
            ("covariance = \"squared_exponential\"", "file = \"scan.npy\"\npixel_size = [\"2 um\", \"2 um\"]"),
            ("marginal = \"normal\"\n", ""),
            ("rms_height = \"0.5 um\"\n", ""),
            ("correlation_length = [\"20 um\", \"12 um\"]\n", ""),
        ],
    )
}

fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

fn study(text: &str) -> Study {
    Study::parse(text, "study.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn run_in(folder: &Path, text: &str, only: Option<Stage>) -> Result<Outcome, StudyError> {
    study(text).run(folder, only, &Silent)
}

fn run(text: &str, only: Option<Stage>) -> Outcome {
    run_in(Path::new("."), text, only).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn rough(nx: usize, ny: usize, length_m: f64) -> Array2<f64> {
    let grid = Grid::new(nx, ny, 2e-6, 2e-6).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 0.5e-6, length_m).unwrap();
    let field = SpectralField::periodic(&covariance, grid);
    let germ = random::standard_normal(&mut random::stream(3, "scan", 0), field.xi_len());
    field.generate(&germ).heights_m().clone()
}

fn folder_with(heights_m: Array2<f64>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    asperity_formats::write(&Scan::new(heights_m, None), &folder.path().join("scan.npy")).unwrap();
    folder
}

/// Paths of all nulls.
fn nulls(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Null => found.push(path.to_owned()),
        Value::Array(items) => items.iter().for_each(|item| nulls(item, path, found)),
        // A method without an estimate says why.
        Value::Object(entries)
            if ["failure", "reason"].iter().any(|key| entries.get(*key).is_some_and(Value::is_string)) => {}
        Value::Object(entries) => {
            // So does one without intervals.
            let reasoned = entries.get("interval_failure").is_some_and(Value::is_string);
            // And a quotient F/N without variance.
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

/// Parts of the names of what a method without intervals lacks.
const INTERVALS: [&str; 4] = ["interval", "_se", "band_factor", "quantiles"];

/// What a quotient F/N without variance lacks.
const VARIANCES: [&str; 6] =
    ["std", "coefficient_of_variation", "skewness", "excess_kurtosis", "correlation_length_m", "marginal"];

/// Small strips hold too few correlation lengths for intervals of moments, lengths and laws, and constant friction has none.
fn interval_of_friction(path: &str) -> bool {
    path.starts_with("/friction/")
        && (path.ends_with("/no_variance")
            || path.ends_with("_interval")
            || path.contains("/gof")
            || path.contains("/marginal_parameter_intervals/"))
}

/// No number is null but those that may be undefined.
fn assert_numbers(outcome: &Outcome, undefined: &[&str]) {
    let bytes = json_bytes(&outcome.results).unwrap();
    assert_eq!(serde_json::from_slice::<Results>(&bytes).unwrap(), outcome.results, "results are read back as written");
    let json: Value = serde_json::from_slice(&bytes).unwrap();
    let mut found = Vec::new();
    nulls(&json, "", &mut found);
    // A small map holds too few correlation lengths for intervals, and a statistic with one null has two.
    let statistic = |path: &str| path.strip_suffix("_interval").or_else(|| path.strip_suffix("_se")).map(str::to_owned);
    let surface = &json["surface"];
    found.retain(|path| {
        let own = statistic(path).and_then(|own| own.strip_prefix("/surface/").map(str::to_owned));
        let absent =
            |own: String| surface[format!("{own}_interval")].is_null() && surface[format!("{own}_se")].is_null();
        !own.is_some_and(absent)
            && !interval_of_friction(path)
            && !undefined.iter().any(|allowed| path.ends_with(allowed))
    });
    assert!(found.is_empty(), "null: {found:?}");
    for sentence in outcome.results.assumptions.iter().chain(&outcome.results.warnings) {
        assert!(!sentence.contains("NaN") && !sentence.contains("inf "), "{sentence}");
    }
}

/// What the model study leaves undefined: parameters of other models, methods that failed for want of samples, and what
/// needs a limit cycle or an expansion.
const USUAL: &[&str] = &[
    // Methods that need no correction, and those with intervals.
    "contact_probability_bias",
    "mean_bias_pa",
    "interval_failure",
    // No kick is needed where steady sliding is unstable.
    "/kick_m_per_s",
    "/smoothness",
    "/hurst",
    "/misfit",
    "/slope_ratio",
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
    // Fewer than five strips; and a cycle that is never lost, or never there.
    "/correlation_without_window_agreement_p",
    "/exit_rate",
    "/exit_rate_interval",
    "/entry_rate",
    "/entry_rate_interval",
];

#[test]
#[ignore = "slow"]
fn every_generator_boundary_control_and_law_runs_to_numbers() {
    let fractal = [
        ("covariance = \"squared_exponential\"\n", "generator = \"weierstrass_mandelbrot\"\nfractal_dimension = 2.3\n"),
        ("marginal = \"normal\"\n", ""),
        ("correlation_length = [\"20 um\", \"12 um\"]\n", ""),
        ("points = [21, 17]", "points = [11, 9]"),
    ];
    let patches: [&[(&str, &str)]; 8] = [
        &fractal,
        &[("modes = 30", "generator = \"spectral\"")],
        &[("\"squared_exponential\"", "\"exponential\""), ("[pressure]", "[pressure]\nboundary = \"periodic\"")],
        &[
            ("\"squared_exponential\"", "\"matern\"\nsmoothness = 1.5"),
            ("percentile = 50.0", "mean_pressure = \"80 MPa\""),
        ],
        &[
            ("\"squared_exponential\"", "\"self_affine\"\nhurst = 0.8"),
            ("percentile = 50.0", "penetration = \"0.7 um\""),
        ],
        &[("\"normal\"", "\"beta:5,2.1\"\ntranslation = \"corrected\"")],
        &[("hardness = \"2 GPa\"\n", "")],
        // More variables than the expansion has modes.
        &[("modes = 30", "modes = 3"), ("variables = 2", "variables = 9")],
    ];
    for changes in patches {
        let outcome = run(&changed(MODEL, changes), Some(Stage::Pressure));
        assert_numbers(&outcome, USUAL);
        let pressure = outcome.results.pressure.unwrap();
        assert!((0.0..=1.0).contains(&pressure.contact_probability), "{changes:?}");
        assert!(pressure.methods.iter().any(|method| method.contact_probability.is_some()), "{changes:?}");
    }
    let told = |generator: &str, stage| {
        let corrected = format!("\"beta:2.1,5\"\ntranslation = \"corrected\"\n{generator}");
        run(&changed(MODEL, &[("\"normal\"", &corrected)]), Some(stage)).results.assumptions.join("\n")
    };
    // The least correlation of the law is that of its own reflection, −0.9516.
    let expansion = told("", Stage::Pressure);
    assert!(
        expansion.contains("distorted beforehand") && expansion.contains("a correlation below -0.9516"),
        "{expansion}"
    );
    for stage in [Stage::Pressure, Stage::Friction] {
        let modes = told("generator = \"spectral\"", stage);
        assert!(modes.matches("Corrected translation meets the correlation").count() == 1, "{modes}");
    }
    let strips: [&[(&str, &str)]; 7] = [
        &[],
        &fractal,
        &[("\"normal\"", "\"lognormal:0,0.3\"")],
        // Hardly any friction, whose cycle needs as little damping.
        &[("hardness = \"2 GPa\"\n", ""), ("damping_ratio = 0.17", "damping_ratio = 0.01")],
        &[("window = ", "boundary = \"free\"\nwindow = ")],
        &[("window = ", "mean_compliance = \"20 nm/MPa\"\nwindow = ")],
        &[("duration = 40.0", "duration = 40.0\nlevel = 20.0\nupscaling = \"paper\"")],
    ];
    for changes in strips {
        let outcome = run(&changed(MODEL, changes), Some(Stage::Vibration));
        assert_numbers(&outcome, USUAL);
        let results = outcome.results;
        let levels = results.friction.unwrap().levels;
        assert_eq!(levels.iter().filter(|level| level.leading).count(), 1, "{changes:?}");
        let elastic = changes.iter().any(|(from, _)| from.contains("hardness"));
        let least = if elastic { 0.0 } else { 0.1925 * (1.0 - 1e-12) };
        assert!(levels.iter().all(|level| level.mean.is_none_or(|mean| mean >= least)), "{changes:?}");
        assert!(results.vibration.unwrap().area.friction_std > 0.0, "{changes:?}");
    }
}

#[test]
#[ignore = "slow"]
fn random_surfaces_give_the_same_bytes_on_one_and_two_threads() {
    let fractal = changed(
        MODEL,
        &[("covariance = ", "generator = \"weierstrass_mandelbrot\"\nfractal_dimension = 2.3\ncovariance = ")],
    );
    let spectral =
        changed(MODEL, &[("modes = 30", "generator = \"spectral\""), ("window = ", "boundary = \"free\"\nwindow = ")]);
    for text in [fractal, spectral].map(|text| changed(&text, &[("[21, 17]", "[11, 9]")])) {
        let [one, two] = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&text, None))
        });
        assert_eq!(json_bytes(&one.results).unwrap(), json_bytes(&two.results).unwrap());
        assert!(one.tables.iter().all(|(name, table)| table.to_csv().unwrap() == two.tables[name].to_csv().unwrap()));
        assert_eq!(one.fields.len(), two.fields.len());
    }
}

#[test]
#[ignore = "slow"]
fn weierstrass_mandelbrot_needs_a_dimension_and_says_so() {
    // White noise shows no scaling range.
    let noise = random::standard_normal(&mut random::stream(8, "noise", 0), 64 * 64);
    let folder = folder_with(Array2::from_shape_vec((64, 64), noise).unwrap().mapv(|z| 1e-6 * z));
    let text = changed(&measured(), &[("modes = 30", "generator = \"weierstrass_mandelbrot\"")]);
    let outcome = run_in(folder.path(), &text, Some(Stage::Surface));
    if let Err(error) = &outcome {
        assert!(error.to_string().contains("fractal_dimension"), "{error}");
        assert_eq!(error.kind(), FailureKind::Configuration);
    } else {
        let surface = outcome.unwrap().results.surface.unwrap();
        assert!(surface.scan().unwrap().fractal_dimension.is_some());
    }
    // A stated one will do, and no covariance is made up.
    let stated = changed(&text, &[("generator", "fractal_dimension = 2.5\ngenerator")]);
    let outcome = run_in(folder.path(), &stated, Some(Stage::Friction)).unwrap();
    assert!(outcome.results.surface.as_ref().unwrap().covariance.is_none());
    assert!(outcome.tables["height_acf"].column("fit_x").is_none());
    assert!(outcome.results.assumptions.iter().any(|sentence| sentence.contains("fractal dimension 2.5 (stated)")));
}

#[test]
#[ignore = "slow"]
fn a_scan_may_come_with_stated_covariance_rms_height_law_and_form() {
    let folder = folder_with(rough(96, 80, 16e-6));
    for level in ["none", "mean", "plane", "quadratic"] {
        let text = changed(&measured(), &[("[surface]", &format!("[surface]\nlevel = \"{level}\""))]);
        assert_numbers(&run_in(folder.path(), &text, Some(Stage::Surface)).unwrap(), USUAL);
    }
    let text = changed(
        &measured(),
        &[(
            "[surface]",
            "[surface]\ncovariance = \"exponential\"\ncorrelation_length = [\"9 um\", \"8 um\"]\nrms_height = \"2 um\"\n\
             marginal = \"beta:2.1,5\"",
        )],
    );
    let outcome = run_in(folder.path(), &text, Some(Stage::Friction)).unwrap();
    assert_numbers(&outcome, USUAL);
    let surface = outcome.results.surface.unwrap();
    let covariance = surface.covariance.as_ref().unwrap();
    assert_eq!((covariance.model.as_str(), covariance.std_m, covariance.length_y_m), ("exponential", 2e-6, 8e-6));
    // The scan's own statistics stay what they are.
    assert!(surface.scan().unwrap().Sq_m < 1e-6);
}

#[test]
#[ignore = "slow"]
fn the_scan_s_own_covariance_serves_every_stage_and_says_what_was_changed() {
    let folder = folder_with(rough(96, 80, 16e-6));
    for (generator, boundary) in [("karhunen_loeve", "free"), ("spectral", "periodic")] {
        let own = format!("[surface]\ncovariance = \"empirical\"\ngenerator = \"{generator}\"");
        let text = changed(
            &measured(),
            &[("[surface]", &own), ("[friction]", &format!("[friction]\nboundary = \"{boundary}\""))],
        );
        let outcome = run_in(folder.path(), &text, Some(Stage::Friction)).unwrap();
        assert_numbers(&outcome, USUAL);
        let surface = outcome.results.surface.unwrap();
        let covariance = surface.covariance.as_ref().unwrap();
        assert_eq!(covariance.model, "empirical");
        // The same standard deviation, by way of the standardised distribution of the heights.
        assert!((covariance.std_m / surface.scan().unwrap().Sq_m - 1.0).abs() < 1e-12);
        // Its length is that at which the scan's own correlation falls to 1/e, but for the mean that was put back.
        let length_m = surface.scan().unwrap().correlation_length_x_m.unwrap();
        assert!((covariance.length_x_m / length_m - 1.0).abs() < 0.1, "{} {length_m}", covariance.length_x_m);
        let report = covariance.empirical.as_ref().unwrap();
        assert!(report.clipping_change < 0.1 && report.mean_share < 0.2, "{report:?}");
        assert!(
            outcome.results.assumptions.iter().any(|sentence| sentence.contains("the covariance of the scan itself"))
        );
        let table = &outcome.tables["height_acf"];
        let (own, met) = (table.column("acf_x").unwrap(), table.column("fit_x").unwrap());
        assert!((own[1] - met[1]).abs() < 0.05 && met[0] == 1.0);
    }
    // A model has no such report, and results that say nothing of it.
    let outcome = run(MODEL, Some(Stage::Surface));
    let json: Value = serde_json::from_slice(&json_bytes(&outcome.results).unwrap()).unwrap();
    assert!(json["surface"]["covariance"]["model"] == "squared_exponential");
    assert!(json["surface"]["covariance"].get("empirical").is_none());
}

#[test]
fn the_pixel_size_of_a_scan_is_overridden_with_a_warning_and_never_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let scan = Scan::new(rough(64, 64, 16e-6), Some((2e-6, 2e-6)));
    asperity_formats::write(&scan, &folder.path().join("scan.x3p")).unwrap();
    let text = changed(&measured(), &[("scan.npy", "scan.x3p"), ("[\"2 um\", \"2 um\"]", "[\"4 um\", \"2 um\"]")]);
    let outcome = run_in(folder.path(), &text, Some(Stage::Surface)).unwrap();
    assert_eq!(outcome.results.surface.unwrap().scan().unwrap().dx_m, 4e-6);
    let warning = outcome.results.warnings.iter().find(|warning| warning.contains("pixel size")).unwrap();
    assert!(warning.contains("2 µm × 2 µm") && warning.contains("4 µm × 2 µm"), "{warning}");
    // An array file states none.
    let folder = folder_with(rough(64, 64, 16e-6));
    let text = changed(&measured(), &[("pixel_size = [\"2 um\", \"2 um\"]", "")]);
    let error = run_in(folder.path(), &text, Some(Stage::Surface)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::Input);
    assert!(error.to_string().contains("scan.npy"), "{error}");
}

#[test]
fn the_unit_of_the_heights_of_a_scan_without_one_is_the_study_s() {
    // The same heights in metre and, without a word of it, in micrometre.
    let of = |factor: f64, unit: &str| {
        let folder = folder_with(rough(64, 64, 16e-6) * factor);
        let text = changed(&measured(), &[("scan.npy\"", &format!("scan.npy\"\n{unit}"))]);
        let outcome = run_in(folder.path(), &text, Some(Stage::Surface)).unwrap();
        (outcome.results.surface.unwrap().scan().unwrap().Sq_m, outcome.results.warnings.join("\n"))
    };
    // Without the unit the heights span metres on a field of 128 µm.
    let ((metre, _), (_, doubt)) = (of(1.0, ""), of(1e6, ""));
    assert!(doubt.contains("more than the field of view, 128 µm; check the units"), "{doubt}");
    let (micrometre, none) = of(1e6, "height_unit = \"um\"");
    assert!(!none.contains("field of view"), "{none}");
    assert!((micrometre / metre - 1.0).abs() < 1e-12, "{micrometre:e}, not {metre:e}");
}

#[test]
fn a_scan_without_any_complete_profile_has_everything() {
    let mut heights = rough(96, 96, 16e-6);
    (0..96).for_each(|i| heights[[i, (7 * i) % 96]] = f64::NAN);
    let folder = folder_with(heights);
    let outcome = run_in(folder.path(), &measured(), Some(Stage::Surface)).unwrap();
    assert_numbers(&outcome, USUAL);
    assert!(outcome.tables.contains_key("height_psd") && outcome.tables.contains_key("height_acf"));
    assert_eq!(outcome.results.surface.unwrap().scan().unwrap().missing_points, 96);
}

#[test]
#[ignore = "slow"]
fn tiny_noisy_or_still_correlated_scans_are_unusable_input_or_warned_about() {
    let noise = random::standard_normal(&mut random::stream(8, "noise", 0), 64 * 64);
    let noise = Array2::from_shape_vec((64, 64), noise).unwrap().mapv(|z| 1e-6 * z);
    let folder = folder_with(noise);
    let outcome = run_in(folder.path(), &measured(), Some(Stage::Surface)).unwrap();
    let warnings = outcome.results.warnings.join("\n");
    assert!(warnings.contains("less than 1/e") && warnings.contains("noise"), "{warnings}");
    // Roughness longer than the map: the fit is told to rest on next to nothing.
    let folder = folder_with(rough(64, 64, 400e-6));
    let text = changed(&measured(), &[("[surface]", "[surface]\nlevel = \"mean\"")]);
    match run_in(folder.path(), &text, Some(Stage::Surface)) {
        Ok(outcome) => {
            let warnings = outcome.results.warnings.join("\n");
            assert!(warnings.contains("correlation lengths long"), "{warnings}");
        }
        Err(error) => assert_eq!(error.kind(), FailureKind::Input, "{error}"),
    }
    for size in [2, 3, 8] {
        let folder = folder_with(rough(64, 64, 8e-6).slice(ndarray::s![..size, ..size]).to_owned());
        let text = changed(
            &measured(),
            &[("[surface]", "[surface]\ncovariance = \"exponential\"\ncorrelation_length = [\"9 um\", \"8 um\"]")],
        );
        match run_in(folder.path(), &text, Some(Stage::Surface)) {
            Ok(outcome) => assert!(outcome.results.surface.unwrap().scan().unwrap().Sq_m > 0.0),
            Err(error) => assert_eq!(error.kind(), FailureKind::Input, "{size}: {error}"),
        }
    }
}

#[test]
fn failures_have_their_kind() {
    let unloaded = changed(MODEL, &[("[60.0, 20.0]", "[0.0001]"), ("duration = 40.0", "level = 0.0001")]);
    let error = run_in(Path::new("."), &unloaded, Some(Stage::Friction)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::NotConverged);
    assert!(error.to_string().contains("percentile 0.0001") && error.to_string().contains("carry load"), "{error}");
    // A patch has no more modes than points: the others are told, not missed.
    let many = changed(MODEL, &[("modes = 30", "modes = 100000")]);
    let results = run_in(Path::new("."), &many, Some(Stage::Pressure)).unwrap().results;
    assert!(results.warnings.iter().any(|warning| warning.contains("100000")), "{:?}", results.warnings);
    assert_eq!(results.surface.unwrap().karhunen_loeve.unwrap().modes, 21 * 17);
    let impossible = changed(MODEL, &[("realisations = 3", "realisations = 3\ntolerance = 1e-30")]);
    let error = run_in(Path::new("."), &impossible, Some(Stage::Friction)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::NotConverged, "{error}");
    assert!(error.to_string().contains("percentile 60"), "{error}");
    let deep = changed(MODEL, &[("degree = 1", "degree = 60"), ("variables = 2", "variables = 30")]);
    let error = Study::parse(&deep, "study.toml").unwrap_err();
    assert!(error.message.contains("60") && error.message.contains("terms"), "{error}");
}

#[test]
fn constant_friction_is_an_answer_at_every_link() {
    let stated = changed(&MODEL[..MODEL.find("[surface]").unwrap()], &[])
        + &MODEL[MODEL.find("[vibration]").unwrap()..]
        + "static_friction = 0.2\nfriction_std = 0.0\nfriction_correlation_length = \"250 um\"\nfriction_marginal = \"normal\"\n";
    // A material that yields at once, and stated friction without scatter.
    let soft = changed(
        MODEL,
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
fn the_deepest_percentile_leads_without_a_vibration_stage_whatever_its_place() {
    let outcome = run(&MODEL[..MODEL.find("[vibration]").unwrap()], Some(Stage::Friction));
    let levels = outcome.results.friction.unwrap().levels;
    assert_eq!(
        levels.iter().map(|l| (l.percentile, l.leading)).collect::<Vec<_>>(),
        [(Some(60.0), true), (Some(20.0), false)]
    );
}

#[test]
#[ignore = "slow"]
fn every_reading_is_told() {
    let text = changed(MODEL, &[("[60.0, 20.0]", "[60.0, 1.0]"), ("30 kN", "2 kN")]);
    let outcome = run(&text, Some(Stage::Vibration));
    let (assumptions, warnings) = (outcome.results.assumptions.join("\n"), outcome.results.warnings.join("\n"));
    for wanted in [
        "squared_exponential covariance (stated, lengths 20 µm along x and 12 µm along y) of rms height 500 nm",
        "μ = τ_max A_c/N with τ_max = 385 MPa",
        "3 strips of 1 mm × 31 µm (periodic, of mean compliance",
        "a correlation length is only stated with its window",
        "at the mean load",
        "one window carries the whole normal force of 2 kN",
        "square nominal area of 833 mm^2",
    ] {
        assert!(assumptions.contains(wanted), "{wanted} not in\n{assumptions}");
    }
    assert!(
        warnings.contains("at the nominal pressure") && warnings.contains("fewer than 30 contact cells"),
        "{warnings}"
    );
    let named = changed(&text, &[("duration = 40.0", "duration = 40.0\nlevel = 60.0")]);
    let warnings = run(&named, Some(Stage::Vibration)).results.warnings.join("\n");
    assert!(warnings.contains("percentile 60, whose mean pressure of"), "{warnings}");
}

#[test]
fn a_key_without_effect_is_warned_about() {
    let text = changed(
        MODEL,
        &[("modes = 30", "modes = 30\nhurst = 0.8"), ("[pressure]", "[pressure]\nmean_compliance = \"20 nm/MPa\"")],
    );
    let idle = study(&text).file().keys_without_effect();
    assert_eq!(idle.len(), 2, "{idle:?}");
    assert!(idle[0].contains("hurst") && idle[1].contains("[pressure] mean_compliance"), "{idle:?}");
    assert_eq!(run(&text, Some(Stage::Surface)).results.warnings[..2], idle);
    assert!(study(MODEL).file().keys_without_effect().is_empty());
}

#[test]
fn errors_point_at_their_line_in_any_layout() {
    let line_of = |from: &str| MODEL[..MODEL.find(from).unwrap()].lines().count() + 1;
    for (from, to, line, wanted) in [
        // Arrays over several lines, inline tables, dotted keys.
        ("[\"20 um\", \"12 um\"]", "[\n\"20 um\",\n\"12\"\n]", line_of("correlation_length") + 2, "no unit"),
        ("[60.0, 20.0]", "[\n60.0,\n\"20\"]", line_of("percentiles") + 2, "is not a number"),
        ("[60.0, 20.0]", "[60.0, 60.0]", line_of("percentiles"), "60 twice"),
        ("[60.0, 20.0]", "[]", line_of("percentiles"), "at least one"),
        ("points = [21, 17]", "points = [21]", line_of("points = [21"), "length"),
        ("points = [21, 17]", "points = [21, 1]", line_of("points = [21"), "at least 2"),
        ("modes = 30", "modes = 30\nmodes = 31", line_of("modes") + 1, "duplicate key"),
        ("modes = 30", "modes = -1", line_of("modes"), "-1"),
        ("seed = 11", "seed = 1.5", 2, "1.5"),
        ("degree = 1", "\"degree\" = 1\n'percentile' = 10", line_of("degree") + 1, "duplicate key"),
        ("99 um", "0.5 mm", line_of("window"), "ten windows"),
        ("damping_ratio = 0.17", "damping_ratio = -0.1", line_of("damping_ratio"), "zero or a positive value"),
        ("[0.1, 0.5, 2]", "[0.5, 0.1, 2]", line_of("damping_sweep"), "end above the start"),
        ("\"833 mm^2\"", "\"1 mm^2\"", line_of("nominal_area"), "not below the hardness"),
        ("duration = 40.0", "duration = 40.0\nlevel = 33.0", line_of("duration") + 1, "33"),
        ("\"normal\"", "\"lognormal:0,-1\"", line_of("marginal"), "marginal"),
    ] {
        let text = changed(MODEL, &[(from, to)]);
        for text in [text.clone(), text.replace('\n', "\r\n"), format!("\u{feff}{text}")] {
            let error = Study::parse(&text, "study.toml").unwrap_err();
            assert_eq!(error.line, line, "{from} → {to}: {error}");
            assert!(error.message.contains(wanted), "{from} → {to}: {error}");
        }
    }
    let surface = &MODEL[MODEL.find("[surface]").unwrap()..MODEL.find("[material]").unwrap()];
    let inline = "surface = { covariance = \"exponential\", marginal = \"normal\", rms_height = \"-1 um\", \
                  correlation_length = [\"1 um\", \"1 um\"] }\n";
    let dotted = "surface.covariance = \"exponential\"\nsurface.marginal = \"normal\"\nsurface.rms_height = \"-1 um\"\n\
                  surface.correlation_length = [\"1 um\", \"1 um\"]\n";
    for (layout, line) in [(inline, 3), (dotted, 5)] {
        let error = Study::parse(&changed(MODEL, &[(surface, layout)]), "study.toml").unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.message.contains("positive"), "{error}");
    }
}

#[test]
fn a_missing_scan_is_input_and_names_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let error = run_in(folder.path(), &measured(), None).unwrap_err();
    assert_eq!(error.kind(), FailureKind::Input);
    assert!(error.to_string().contains("scan.npy"), "{error}");
    fs::write(folder.path().join("scan.npy"), b"not an array").unwrap();
    assert_eq!(run_in(folder.path(), &measured(), None).unwrap_err().kind(), FailureKind::Input);
}

#[test]
#[ignore = "slow"]
fn the_oscillator_takes_the_leading_level_in_its_own_units() {
    let text = changed(MODEL, &[("dimensionless_belt_velocity = 0.003", "belt_velocity = \"20 mm/s\"")]);
    for (level, percentile) in [("", None), ("level = 20.0\n", Some(20.0))] {
        let results = run(&(text.clone() + level), Some(Stage::Vibration)).results;
        let (friction, vibration) = (results.friction.unwrap(), results.vibration.unwrap());
        let leading = friction.levels.iter().find(|level| level.leading).unwrap();
        let process = &leading.at_mean_load;
        assert_eq!((leading.percentile, vibration.level_percentile), (percentile, percentile));
        assert_eq!(vibration.static_friction, process.mean);
        assert_eq!(vibration.paper.friction_std, process.std);
        assert_eq!(Some(vibration.friction_correlation_length_m), process.correlation_length_m);
        // λ = ℓ_μ c/N with c = mω₀², V = v_b m ω₀/N.
        let length = vibration.friction_correlation_length_m * 316.0 * 316.0 / 30e3;
        assert!((vibration.correlation_length / length - 1.0).abs() < 1e-12);
        assert!((vibration.belt_velocity / (20e-3 * 316.0 / 30e3) - 1.0).abs() < 1e-12);
        let own_length_m = leading.correlation_length_without_window_m.unwrap();
        let kept = variance_reduction(friction.window_m, friction.window_width_m, 833e-6, &exponential(own_length_m));
        assert_eq!(vibration.variance_reduction, kept);
    }
}

/// Stated friction of this standard deviation and nominal area.
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
    // The fraction of Beta(2.1, 5) with standard deviation 0.15 below −0.9 times the least kinetic coefficient, which is
    // 0.2/(1 + 4.2 (V + 0.2 + m)) at the fastest slip, V = 0.003 and m the fluctuation that one value in 10,000 exceeds. The law
    // has the mean .295775 and the standard deviation .160359.
    let beta: asperity::law::Marginal = "beta:2.1,5".parse().unwrap();
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
    // Faster slips than expected clip more; the moments of the law have six digits.
    assert!(wild.vibration.as_ref().unwrap().paper.clipped_fraction >= fraction * (1.0 - 1e-4));
    // An area below one window keeps the window's scatter and law.
    let vibration = wild.vibration.unwrap();
    assert_eq!((vibration.variance_reduction, vibration.area.friction_std), (1.0, vibration.paper.friction_std));
    assert_eq!(vibration.area, vibration.paper);
    // Over the nominal area the same scatter averages out; one window that carries all is clipped, for comparison only.
    let averaged = run(&stated("0.15", "833 mm^2"), None).results;
    assert!(
        averaged.warnings.iter().any(|warning| warning.contains("with the paper upscaling")),
        "{:?}",
        averaged.warnings
    );
    assert_eq!(averaged.vibration.unwrap().area.clipped_fraction, 0.0);
    let calm = run(&stated("0.001", "833 mm^2"), None).results;
    assert!(calm.warnings.is_empty(), "{:?}", calm.warnings);
    assert!(calm.assumptions.iter().any(|sentence| sentence.contains("its law becomes normal")));
}

#[test]
#[ignore = "slow"]
fn a_study_that_reads_the_process_of_another_finds_the_same_vibration() {
    let whole = run(MODEL, Some(Stage::Vibration));
    let process = whole.friction_process.clone().unwrap();
    let (friction, vibration) = (whole.results.friction.unwrap(), whole.results.vibration.unwrap());
    let leading = &friction.levels.iter().find(|level| level.leading).unwrap().at_mean_load;
    assert_eq!((process.mean, process.std), (leading.mean, leading.std));
    assert_eq!(process.averaged_over_m, Some([friction.window_m, friction.strip_width_m]));
    assert_eq!(process.correlation.unwrap().window_m, Some(friction.window_m));
    // a per metre and second, times N/(mω₀).
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

    // A process of its own: other Stribeck curve, smooth correlation, area not known.
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

    // Files that are none, and studies that say it twice.
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
        MODEL.to_owned() + "friction_process = \"process.json\"\n",
    ] {
        let error = Study::parse(&text, "study.toml").unwrap_err();
        assert!(error.message.contains("friction_process") && error.message.contains("remove one"), "{error}");
    }
}
