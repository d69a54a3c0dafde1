//! Levels of contact: load against depth, and the results and sentences of a study about them.

use std::sync::{Arc, LazyLock};

use asperity::contact::{Boundary, Control, HalfSpace, Solver};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::friction::law::BowdenTabor;
use asperity::friction::load_curve::{LoadCurve, LoadPoint};
use asperity::friction::strip::{SolvedStrips, StripProblem, Strips};
use asperity::friction::window::Window;
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::study::result::Prescribed;
use asperity::study::{Outcome, Stage, Study};
use asperity::surface::SpectralField;
use asperity_testing::StudyText;

use crate::support;

const MODULUS_PA: f64 = 230e9;

/// Runs a test with strips of 256 × 16 cells.
fn with_strips<R>(realisations: usize, test: impl FnOnce(&Strips<'_>) -> R) -> R {
    let grid = Grid::new(256, 16, 2e-6, 2e-6).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 0.5e-6, 12e-6).unwrap();
    let surface = SpectralField::periodic(&covariance, grid);
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, MODULUS_PA);
    let half_space = HalfSpace::new(grid, MODULUS_PA, Boundary::Periodic { mean_compliance_m_per_pa }).unwrap();
    let problem = StripProblem {
        valid_share: 0.95,
        half_space,
        window: Window::new(40e-6, grid).unwrap(),
        law: Arc::new(BowdenTabor { shear_strength_pa: 385e6 }),
        hardness_pa: Some(2e9),
        solver: Solver { tolerance: 1e-6, ..Solver::default() },
    };
    test(&problem.strips(&surface, realisations, 5))
}

fn planes(strips: &Strips<'_>, heights_m: &[f64]) -> Vec<SolvedStrips> {
    let controls: Vec<Control> = heights_m.iter().map(|&height_m| Control::Plane { height_m }).collect();
    strips.solve(&controls, &Silent).unwrap().into_iter().map(Result::unwrap).collect()
}

#[test]
fn the_load_curve_lies_between_its_levels_and_inverts_itself() {
    with_strips(6, |strips| {
        // Heights of the plane in units of Sq = 0.5 µm; every other one defines the curve.
        let heights_m: Vec<f64> = (0..9).map(|k| 0.5e-6 * (1.5 - 0.25 * f64::from(k))).collect();
        let levels = planes(strips, &heights_m);
        let curve = LoadCurve::from_points(levels.iter().step_by(2).map(LoadPoint::from_strips).collect()).unwrap();
        for level in levels.iter().skip(1).step_by(2) {
            let between = curve.mean_pressure_pa(level.penetration_m).unwrap();
            println!("{:e}: {between:e} for {:e}", level.penetration_m, level.mean_pressure_pa);
            assert!((between / level.mean_pressure_pa - 1.0).abs() < 0.05);
            assert!((curve.penetration_m(between).unwrap() - level.penetration_m).abs() < 1e-15);
        }
        let last = LoadPoint::from_strips(&levels[8]);
        assert!(curve.mean_pressure_pa(1.01 * last.penetration_m).is_err());
    });
}

#[test]
fn the_interval_of_a_load_is_a_student_interval_of_the_logarithm() {
    with_strips(3, |strips| {
        let mut level = planes(strips, &[0.3e-6]).remove(0);
        assert_eq!(level.strip_pressures_pa.len(), 3);
        (level.mean_pressure_pa, level.strip_pressures_pa) = (2.0, vec![1.0, 2.0, 3.0]);
        // t = 4.302653 with two degrees of freedom, standard error 1/√3.
        let factor = (4.302_653 / (2.0 * 3.0_f64.sqrt())).exp();
        let interval = LoadPoint::from_strips(&level).interval;
        assert!((interval.low * factor / 2.0 - 1.0).abs() < 1e-6 && (interval.high / factor / 2.0 - 1.0).abs() < 1e-6);
        level.strip_pressures_pa = vec![2.0; 3];
        let exact = LoadPoint::from_strips(&level).interval;
        assert_eq!((exact.low, exact.high), (2.0, 2.0));
    });
}

static STUDY: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(11, &["surface", "material", "friction"])
        .with("surface", "covariance = \"squared_exponential\"\nrms_height = \"0.5 um\"")
        .with("surface", "correlation_length = [\"12 um\", \"12 um\"]")
        .with("friction", "strip = [\"640 um\", \"32 um\"]\npoints = [320, 16]\nwindow = \"60 um\"")
        .with("friction", "percentiles = [20.0]\nrealisations = 4\ntolerance = 1e-5")
        .to_string()
});

fn run(more: &str) -> Outcome {
    support::run(&format!("{}{more}", *STUDY), Some(Stage::Friction))
}

#[test]
#[ignore = "slow"]
fn percentile_pressure_and_penetration_levels_work_with_both_upscalings() {
    let outcome = run("mean_pressures = [\"50 MPa\", \"500 MPa\"]\npenetrations = [\"1.2 um\"]\n\
                                  nominal_area = \"833 mm^2\"\n");
    let friction = outcome.results.friction.unwrap();
    let kinds: Vec<Prescribed> = friction.levels.iter().map(|level| level.control).collect();
    assert_eq!(
        kinds,
        [Prescribed::Percentile, Prescribed::MeanPressure, Prescribed::MeanPressure, Prescribed::Penetration]
    );
    assert_eq!(friction.levels.iter().map(|l| l.percentile).collect::<Vec<_>>(), [Some(20.0), None, None, None]);
    for (level, wanted) in friction.levels[1..3].iter().zip([50e6, 500e6]) {
        assert!((level.mean_pressure_pa / wanted - 1.0).abs() < 1e-4);
    }
    assert!((friction.levels[3].penetration_m / 1.2e-6 - 1.0).abs() < 1e-9);
    let curve = &outcome.tables["friction_load_curve"];
    for column in ["penetration_m", "mean_pressure_pa", "low", "high", "contact_fraction"] {
        assert_eq!(curve.column(column).unwrap().len(), 4, "{column}");
    }
    assert!(curve.column("penetration_m").unwrap().is_sorted());
    assert!(outcome.tables["friction_trace"].column("mu_pressure_5e8_pa").is_some());
    // The level with the highest pressure is the operating point.
    let leading = friction.levels.iter().find(|level| level.leading).unwrap();
    assert!(friction.levels.iter().all(|level| level.mean_pressure_pa <= leading.mean_pressure_pa));
    for level in &friction.levels {
        let upscaling = &level.process.upscaling;
        assert_eq!(upscaling.paper.std, level.process.at_mean_load.std);
        assert!((upscaling.area.windows - 833e-6 / (60e-6 * 32e-6)).abs() < 1.0);
        let least = upscaling.paper.std / upscaling.area.windows.sqrt();
        assert!(upscaling.area.std >= least * (1.0 - 1e-9) && upscaling.area.std < 3.0 * least);
    }
    assert!(outcome.results.assumptions.iter().any(|sentence| sentence.contains("highest point of each strip")));
    // If no area is stated, the study uses a pad's area and reports it.
    let silent = run("").results;
    assert_eq!(silent.friction.unwrap().levels[0].process.upscaling.area.nominal_area_m2, 833e-6);
    assert!(silent.assumptions.iter().any(|sentence| sentence.contains("No nominal area is stated")));
}

#[test]
#[ignore = "slow"]
fn light_contact_has_no_variance_of_the_quotient_and_one_friction_coefficient() {
    // 3 MPa as on a brake pad: windows with one or two contacts; 5 GPa: hundreds of contact cells in every window.
    let more = "mean_pressures = [\"3 MPa\", \"5 GPa\"]\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                damping_ratio = 0.17\nnormal_force = \"2.5 kN\"\nnominal_area = \"833 mm^2\"\nbelt_velocity = \"23.7 mm/s\"\n\
                trajectories = 2\nduration = 20.0\ndamping_sweep = [0.1, 0.2, 2]\n";
    // Plastic contact has the friction τ/H in every window.
    let text = support::changed(&STUDY, &[("hardness = \"2 GPa\"\n", "")]) + more;
    let outcome = support::run_all(&text);
    let (friction, vibration) = (outcome.results.friction.unwrap(), outcome.results.vibration.unwrap());
    let [_, light, firm, nominal] = &friction.levels[..] else { panic!("four levels") };
    for level in [light, nominal] {
        assert!(level.no_variance.as_ref().unwrap().contains("fewer than 30 contact cells"), "{level:?}");
        let moments = [level.std, level.coefficient_of_variation, level.skewness, level.excess_kurtosis];
        assert_eq!(moments, [None; 4]);
        assert_eq!((level.mean_interval, level.std_interval, level.correlation_length_m), (None, None, None));
        assert!(level.marginal.is_none() && level.gof.is_none() && level.return_levels.is_empty());
        // At the mean load all moments exist.
        assert!(level.process.at_mean_load.std > 0.0 && level.process.at_mean_load.marginal.is_some());
    }
    assert!(firm.no_variance.is_none() && firm.std.unwrap() > 0.0 && firm.marginal.is_some(), "{firm:?}");
    let point = &friction.operating_point;
    assert_eq!((point.level.as_str(), point.percentile), ("the nominal pressure", None));
    assert!((point.mean_pressure_pa / (2500.0 / 833e-6) - 1.0).abs() < 1e-4);
    // Level, machine and file have the same coefficient.
    let process = outcome.friction_process.unwrap();
    assert!(nominal.leading && point.mean == nominal.process.at_mean_load.mean);
    assert_eq!((point.mean, point.mean), (vibration.static_friction, process.mean));
    assert_eq!((point.std, point.std_nominal_area), (vibration.paper.friction_std, vibration.area.friction_std));
    assert_eq!(point.contact_fraction, nominal.contact_fraction);
    let warnings = outcome.results.warnings.join("\n");
    let said = "and the quotient F/N of single windows has no variance";
    assert!(
        warnings.lines().any(|line| line.starts_with("at the nominal pressure,") && line.ends_with(said)),
        "{warnings}"
    );
}

#[test]
#[ignore = "slow"]
fn a_study_selects_friction_law_and_window() {
    let level = |more: &str| {
        let results = run(more).results;
        (results.friction.unwrap().levels.remove(0), results.assumptions.join("\n"))
    };
    let (sheared, words) = level("");
    assert!(
        words.contains("shear-dominated") && words.contains("a window of 60 µm × the width of the strip"),
        "{words}"
    );
    let (dependent, words) = level("law = \"pressure_dependent\"\npressure_coefficient = 0.05\n");
    assert!((dependent.process.at_mean_load.mean - sheared.process.at_mean_load.mean - 0.05).abs() < 1e-12, "{words}");
    assert!((dependent.process.at_mean_load.std / sheared.process.at_mean_load.std - 1.0).abs() < 1e-9);
    let (ploughing, words) = level("law = \"adhesion_ploughing\"\n");
    assert!(ploughing.process.at_mean_load.mean > sheared.process.at_mean_load.mean && words.contains("plough"));
    let (coulomb, _) = level("law = \"coulomb\"\ncoefficient = 0.3\n");
    assert!((coulomb.mean.unwrap() - 0.3).abs() < 1e-12 && coulomb.std == Some(0.0));
    // The same strips: narrower windows vary more about the same mean.
    let (narrow, words) = level("window_width = \"8 um\"\n");
    assert!(words.contains("60 µm × 8 µm, 4 side by side"), "{words}");
    // Four tracks add up to the wide window, except for the smallest area N/H of each track, which can only add.
    let more = narrow.process.at_mean_load.mean / sheared.process.at_mean_load.mean - 1.0;
    assert!((-1e-12..5e-3).contains(&more), "{more:e}");
    assert!(narrow.process.at_mean_load.std > 1.3 * sheared.process.at_mean_load.std);
    let (ellipse, words) = level("window_shape = \"ellipse\"\n");
    assert!(words.contains("an elliptic window"), "{words}");
    assert!(ellipse.process.at_mean_load.std > sheared.process.at_mean_load.std);
    assert!(ellipse.process.correlation_length_without_window_m.is_some());
}

#[test]
fn invalid_keys_are_errors_with_their_line() {
    let lines = STUDY.lines().count();
    for (more, line, wanted) in [
        ("law = \"bowden\"", 1, "bowden"),
        ("law = \"coulomb\"", 1, "needs its μ"),
        ("law = \"coulomb\"\ncoefficient = -0.1", 2, "positive"),
        ("law = \"pressure_dependent\"", 1, "needs its α"),
        ("window_width = \"40 um\"", 1, "at most as wide as the strip"),
        ("window_width = \"2 um\"", 1, "at least two cells"),
        ("mean_pressures = [\"1 MPa\", \"2 GPa\"]", 1, "hardness"),
        ("mean_pressures = [\"1 MPa\", \"1e6 Pa\"]", 1, "twice"),
        ("penetrations = [\"-1 um\"]", 1, "positive"),
        ("nominal_area = \"0 mm^2\"", 1, "positive"),
        ("window_shape = \"circle\"", 1, "circle"),
    ] {
        let error = Study::parse(&format!("{}{more}\n", *STUDY), "study.toml").unwrap_err();
        assert!(error.message.contains(wanted), "{more}: {error}");
        // The error of a missing key names the line of its section.
        assert!(error.line == lines + line || error.message.contains("needs its"), "{more}: {error}");
    }
    let soft = STUDY.replace("hardness = \"2 GPa\"\n", "");
    let error = Study::parse(&format!("{soft}law = \"adhesion_ploughing\"\n"), "study.toml").unwrap_err();
    assert!(error.message.contains("needs the hardness"), "{error}");
    let none = STUDY.replace("percentiles = [20.0]", "percentiles = []");
    assert!(Study::parse(&none, "study.toml").unwrap_err().message.contains("at least one level"));
    assert!(Study::parse(&format!("{none}penetrations = [\"1 um\"]\n"), "study.toml").is_ok());
    let idle = Study::parse(&format!("{}coefficient = 0.2\npressure_coefficient = 0.1\n", *STUDY), "study.toml");
    let idle = idle.unwrap().file().keys_without_effect();
    assert_eq!(idle.len(), 2, "{idle:?}");
    assert!(idle[0].contains("pressure_coefficient has no effect") && idle[1].contains("[friction] coefficient"));
}
