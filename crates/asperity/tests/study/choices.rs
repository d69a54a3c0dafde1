//! Every choice of a study file, in small studies of all stages.

use asperity::study::{Stage, json_bytes};

use crate::support::{MODEL, USUAL, assert_numbers, changed, run};

#[test]
#[ignore = "slow"]
fn every_generator_boundary_control_and_distribution_gives_numbers() {
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
        let outcome = run(&changed(&MODEL, changes), Some(Stage::Pressure));
        assert_numbers(&outcome, USUAL);
        let pressure = outcome.results.pressure.unwrap();
        assert!((0.0..=1.0).contains(&pressure.contact_probability), "{changes:?}");
        assert!(pressure.methods.iter().any(|method| method.contact_probability.is_some()), "{changes:?}");
    }
    let assumptions = |generator: &str, stage| {
        let corrected = format!("\"beta:2.1,5\"\ntranslation = \"corrected\"\n{generator}");
        run(&changed(&MODEL, &[("\"normal\"", &corrected)]), Some(stage)).results.assumptions.join("\n")
    };
    // The smallest correlation of the distribution is that with its own reflection, −0.9516.
    let expansion = assumptions("", Stage::Pressure);
    assert!(
        expansion.contains("distorted beforehand") && expansion.contains("a correlation below -0.9516"),
        "{expansion}"
    );
    for stage in [Stage::Pressure, Stage::Friction] {
        let modes = assumptions("generator = \"spectral\"", stage);
        assert!(modes.matches("Corrected translation meets the correlation").count() == 1, "{modes}");
    }
    let strips: [&[(&str, &str)]; 7] = [
        &[],
        &fractal,
        &[("\"normal\"", "\"lognormal:0,0.3\"")],
        // Almost no friction, whose cycle ends at little damping.
        &[("hardness = \"2 GPa\"\n", ""), ("damping_ratio = 0.17", "damping_ratio = 0.01")],
        &[("window = ", "boundary = \"free\"\nwindow = ")],
        &[("window = ", "mean_compliance = \"20 nm/MPa\"\nwindow = ")],
        &[("duration = 40.0", "duration = 40.0\nlevel = 20.0\nupscaling = \"paper\"")],
    ];
    for changes in strips {
        let outcome = run(&changed(&MODEL, changes), Some(Stage::Vibration));
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
        &MODEL,
        &[("covariance = ", "generator = \"weierstrass_mandelbrot\"\nfractal_dimension = 2.3\ncovariance = ")],
    );
    let spectral =
        changed(&MODEL, &[("modes = 30", "generator = \"spectral\""), ("window = ", "boundary = \"free\"\nwindow = ")]);
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
fn the_deepest_percentile_is_the_operating_point_without_a_vibration_stage() {
    let outcome = run(&MODEL[..MODEL.find("[vibration]").unwrap()], Some(Stage::Friction));
    let levels = outcome.results.friction.unwrap().levels;
    assert_eq!(
        levels.iter().map(|l| (l.percentile, l.leading)).collect::<Vec<_>>(),
        [(Some(60.0), true), (Some(20.0), false)]
    );
}

#[test]
#[ignore = "slow"]
fn every_assumption_is_reported() {
    let text = changed(&MODEL, &[("[60.0, 20.0]", "[60.0, 1.0]"), ("30 kN", "2 kN")]);
    let outcome = run(&text, Some(Stage::Vibration));
    let (assumptions, warnings) = (outcome.results.assumptions.join("\n"), outcome.results.warnings.join("\n"));
    for wanted in [
        "squared exponential covariance (stated, lengths 20 µm along x and 12 µm along y) of rms height 500 nm",
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
