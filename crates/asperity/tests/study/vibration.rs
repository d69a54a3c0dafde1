//! Keys of `[vibration]`: velocity laws, force, generators and drives.

use std::path::Path;
use std::sync::LazyLock;

use asperity::friction::process::{FrictionProcess, Generator, ProcessModel};
use asperity::monitor::Silent;
use asperity::study::Study;
use asperity::study::result::{MotionKind, VibrationResult};
use asperity::vibration::law::Stribeck;
use asperity::vibration::{Drive, Ensemble, EnsembleSettings, Oscillator, Parameters, VelocityLaw};
use asperity_testing::StudyText;

use crate::support::run_all;

/// The machine of the paper: N/c = .025036 m and N/(mω₀) = 7.911 m/s.
static MACHINE: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(3, &["vibration", "stated friction"])
        .with("vibration", "damping_sweep = [0.16, 0.18, 2]\ntrajectories = 20\nduration = 60.0")
        .without("vibration", &["damping_ratio", "dimensionless_belt_velocity"])
        .to_string()
});
const VELOCITY_UNIT: f64 = 2500.0 / 316.0;
const LENGTH_UNIT: f64 = 2500.0 / (316.0 * 316.0);

fn run(keys: &str) -> VibrationResult {
    run_all(&format!("{}{keys}", *MACHINE)).results.vibration.unwrap()
}

fn refused(keys: &str) -> String {
    Study::parse(&format!("{}{keys}", *MACHINE), "keys.toml").unwrap_err().to_string()
}

#[test]
fn an_exponential_law_has_its_velocity_in_si() {
    // 2ζ_H = (μ_k − μ_∞)/v₀·e^{−V/v₀}; the step from static to kinetic friction raises ζ_c above it.
    let found =
        run("damping_ratio = 0.1\nbelt_velocity = \"0.1 m/s\"\nkinetic_share = 0.9\nvelocity_law = \"exponential\"\n\
         stribeck_velocity = \"0.4 m/s\"\nhigh_speed_share = 0.6");
    let (velocity, scale) = (0.1 / VELOCITY_UNIT, 0.4 / VELOCITY_UNIT);
    let wanted = 0.5 * 0.09 * 0.4 / scale * (-velocity / scale).exp();
    assert!((found.hopf_damping_ratio.unwrap() / wanted - 1.0).abs() < 1e-12);
    assert!(found.critical_damping_ratio.unwrap() > wanted);
}

#[test]
#[ignore = "slow"]
fn the_force_acts_on_cycle_and_ensembles() {
    // Below the end of the locked cycle at ζ = .2703 there is one cycle per period of the force.
    let text = |force: &str| {
        let machine = MACHINE.replace("static_friction = 0.1", "static_friction = 0.2");
        format!("{machine}damping_ratio = 0.2\ndimensionless_belt_velocity = 0.1\n{force}")
    };
    let run = |force: &str| run_all(&text(force)).results.vibration.unwrap();
    let found = run("forcing = \"25 N\"\nforcing_frequency = \"309.68 rad/s\"");
    assert!((found.cycle.period.unwrap() * 0.98 / std::f64::consts::TAU - 1.0).abs() < 1e-9);
    let free = run("");
    // ζ_c and ζ_H ignore the force.
    assert_eq!(free.critical_damping_ratio, found.critical_damping_ratio);
    assert!(free.cycle.period != found.cycle.period);
    assert!(free.paper.motion.unwrap() != found.paper.motion.unwrap());
}

#[test]
fn overtaking_counts_as_vibration_in_every_result_of_a_study() {
    // V = 3.1416 and μ_st = .432353: at ζ = .001 and .002 the mass exceeds the velocity of the belt and never sticks.
    let machine = MACHINE
        .replace("static_friction = 0.1", "static_friction = 0.432353")
        .replace("[0.16, 0.18, 2]", "[0.001, 0.002, 2]")
        .replace("duration = 60.0", "duration = 600.0");
    for std in ["1e-6", "0.0"] {
        let machine = machine.replace("friction_std = 0.001", &format!("friction_std = {std}"));
        let text = format!("{machine}damping_ratio = 0.001\ndimensionless_belt_velocity = 3.1416\n")
            .replace("\"250 um\"", "\"250 mm\"");
        let found = run_all(&text).results.vibration.unwrap();
        let limit = found.critical_damping_ratio.unwrap();
        for damping in &found.paper.damping {
            assert_eq!(damping.kind, MotionKind::Overtaking);
            assert_eq!((damping.sustained_share, damping.vibration_share), (1.0, 1.0), "{damping:?}");
            assert!((damping.cycles_mean - 600.0 / 6.2948).abs() < 3.0, "{damping:?}");
        }
        assert_eq!(found.paper.motion.as_ref().map(|motion| motion.left_share), (std != "0.0").then_some(0.0));
        for crossing in &found.paper.crossings {
            let ratio = crossing.damping_ratio.unwrap();
            // Near the end of the cycle, transients of a motion that begins in stick last longer than the study.
            let exact = std == "0.0";
            assert!(if exact { ratio == limit } else { (ratio / limit - 1.0).abs() < 0.3 }, "{crossing:?} and {limit}");
        }
    }
}

fn machine(damping_ratio: f64, belt_velocity: f64) -> Oscillator {
    let law = VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 });
    Oscillator::new(Parameters { static_friction: 0.1, law, damping_ratio, belt_velocity, forcing: None }).unwrap()
}

#[test]
#[ignore = "slow"]
fn generators_and_drives_agree_with_the_library() {
    let oscillator = machine(0.16, 0.003);
    let ensemble = |generator, drive| {
        let model = ProcessModel {
            generator,
            least: Some(-0.9 * oscillator.law().coefficient(0.103)),
            ..ProcessModel::new("beta:2.1,5".parse().unwrap(), 0.001, 250e-6 / LENGTH_UNIT)
        };
        let process = FrictionProcess::new(model).unwrap();
        let settings = EnsembleSettings { drive, sample_capacity: 0, ..EnsembleSettings::new(20, 60.0, 3) };
        Ensemble::simulate(&oscillator, &process, &settings, &Silent).unwrap()
    };
    let recursion = Generator::Autoregressive;
    let cases = [
        ("", recursion, Drive::Distance),
        ("generator = \"renewal\"", Generator::Renewal, Drive::Distance),
        ("generator = \"jacobi\"", Generator::Jacobi, Drive::Distance),
        ("generator = \"spectral\"", Generator::Spectral { harmonics: 256 }, Drive::Distance),
        ("drive = \"time\"", recursion, Drive::Time),
    ];
    let mut counts = Vec::new();
    for (keys, generator, drive) in cases {
        let found = run(&format!("damping_ratio = 0.17\ndimensionless_belt_velocity = 0.003\n{keys}"));
        let wanted = ensemble(generator, drive);
        let damping = &found.paper.damping[0];
        assert_eq!((damping.cycles_mean, damping.cycles_se), (wanted.cycles.mean, wanted.cycles.se), "{keys}");
        counts.push(found.paper.motion.unwrap().stick_share);
    }
    // Each choice changes the motion.
    for (i, count) in counts.iter().enumerate() {
        assert!(counts[..i].iter().all(|other| other != count), "{counts:?}");
    }
}

#[test]
fn clouds_contain_the_ends_of_trajectories() {
    let text = format!("{}damping_ratio = 0.17\ndimensionless_belt_velocity = 0.003", *MACHINE);
    let outcome = run_all(&text);
    let (_, cloud) = outcome.tables.iter().find(|(name, _)| name.as_str() == "phase_cloud").unwrap();
    let column = |name| cloud.column(name).unwrap();
    assert_eq!(column("trajectory").iter().filter(|index| **index == 19.0).count(), 72);
    assert!(column("tau").iter().all(|tau| (60.0 - 1.1 * std::f64::consts::TAU..=60.0).contains(tau)));
    // Without over-slip the mass is never faster than the belt.
    assert!(column("velocity").iter().all(|velocity| *velocity <= 0.003 * (1.0 + 1e-12)));
}

#[test]
fn errors_of_velocity_laws_name_the_missing_key() {
    let base = "damping_ratio = 0.17\ndimensionless_belt_velocity = 0.003\n";
    for (keys, words) in [
        ("velocity_law = \"linear\"", "linear_weakening"),
        ("velocity_law = \"exponential\"\nhigh_speed_share = 0.5", "stribeck_velocity"),
        ("velocity_law = \"exponential\"\nstribeck_velocity = \"1 m/s\"", "high_speed_share"),
        ("kinetic_share = 1.2", "at most 1"),
        ("forcing = \"3 N\"", "forcing_frequency"),
        ("forcing_frequency = \"3 rad/s\"", "forcing"),
        ("velocity_law = \"linea\"", "linear"),
        ("high_speed_share = 0.5", "exponential"),
        ("linear_weakening = 0.5", "velocity_law = \"linear\""),
    ] {
        let message = refused(&format!("{base}{keys}"));
        assert!(message.contains(words), "{keys}: {message}");
    }
    let weibull = MACHINE.replace("beta:2.1,5", "weibull:2,1");
    let message = Study::parse(&format!("{weibull}{base}generator = \"jacobi\""), "x.toml").unwrap_err().to_string();
    assert!(message.contains("Beta"), "{message}");
}

#[test]
fn a_map_without_fluctuation_ends_with_the_cycle() {
    let base = "damping_ratio = 0.17\ndimensionless_belt_velocity = 0.003\nupscaling = \"paper\"\n";
    let map = "[vibration.map]\nover = \"damping_scatter\"\nx = [0.14, 0.28, 2]\ny = [0.0, 0.001, 1]\ndepth = 0\ntrajectories = 20";
    let text = format!("{}{base}{map}", MACHINE.replace("duration = 60.0", "duration = 600.0"));
    let study = Study::parse(&text, "map.toml").unwrap();
    let outcome = study.run(Path::new("."), None, &Silent).unwrap();
    let names = outcome.results.vibration.unwrap().map.unwrap();
    assert_eq!((names.x.as_str(), names.y.as_str()), ("damping_ratio", "friction_std"));
    let (_, points) = outcome.tables.iter().find(|(name, _)| name.as_str() == "map_points").unwrap();
    let column = |name| points.column(name).unwrap();
    let at = |damping: f64, std: f64| {
        let of = |i: &usize| (column("damping_ratio")[*i] - damping).abs() < 1e-9 && column("friction_std")[*i] == std;
        column("sustained_share")[(0..column("damping_ratio").len()).find(of).unwrap()]
    };
    // ζ_c = .2048.
    assert_eq!([at(0.14, 0.0), at(0.21, 0.0), at(0.28, 0.0)], [1.0, 0.0, 0.0]);
    assert!(at(0.14, 0.001) > 0.9 && at(0.28, 0.001) < 0.1);
    // The estimate counts the trajectories: sweeps of both upscalings, the points of the map, and about twenty
    // ensembles for the crossings of each upscaling.
    assert_eq!(study.estimate(0, 1)[0].trajectories, 2 * (2 + 20) * 20 + 6 * 20);
    for (wrong, word) in
        [("x = [0.3, 0.2, 2]", "rising"), ("x = [0.1, 0.2, 0]", "at least 1"), ("depth = 9", "at most 8")]
    {
        let key = wrong.split(' ').next().unwrap();
        let old = map.lines().find(|line| line.starts_with(key)).unwrap();
        let message = refused(&format!("{base}{}", map.replace(old, wrong)));
        assert!(message.contains(word) && message.contains("vibration.map"), "{message}");
    }
}

#[test]
fn a_machine_that_vibrates_once_started_has_its_kick_in_si() {
    let run = |damping_ratio: f64| {
        let steady = MACHINE.replace("friction_std = 0.001", "friction_std = 0.0");
        let keys = format!("damping_ratio = {damping_ratio}\ndimensionless_belt_velocity = 0.1\nstribeck = 4.2");
        run_all(&format!("{steady}{keys}")).results.vibration.unwrap()
    };
    let found = run(0.111);
    assert_eq!((found.kind, found.cycle.limit_cycle), (MotionKind::StickSlip, true));
    assert_eq!(found.steady_sliding_unstable, Some(false));
    // SciPy, DOP853 with bisection; ζ_c as published.
    assert!((found.kick_m_per_s.unwrap() / VELOCITY_UNIT - 0.0966).abs() < 2e-4, "{:?}", found.kick_m_per_s);
    assert!((found.limit_damping_ratio.unwrap() - 0.111_508_270_209_214).abs() < 1e-12);
    let unstable = run(0.1);
    assert_eq!((unstable.steady_sliding_unstable, unstable.kick_m_per_s), (Some(true), None));
    let quiet = run(0.2);
    assert_eq!((quiet.kind, quiet.kick_m_per_s, quiet.cycle.limit_cycle), (MotionKind::None, None, false));
}

#[test]
fn a_physical_stribeck_coefficient_is_the_same_law_for_every_load_mass_and_frequency() {
    let keys = format!(
        "damping_ratio = 0.1\nbelt_velocity = \"{:?} m/s\"\nstribeck = \"{:?} s/m\"",
        0.1 * VELOCITY_UNIT,
        4.2 / VELOCITY_UNIT
    );
    let steady = MACHINE.replace("friction_std = 0.001", "friction_std = 0.0");
    let of = |old: &str, new: &str| run_all(&format!("{}{keys}", steady.replace(old, new))).results.vibration.unwrap();
    // In units of the first load, X″ + 2ζX′ + X = rμ/(1 + a|V − X′|) under r times the load: ζ_c of (rμ, a, V), as
    // published.
    for (old, new, ratio, wanted) in [
        ("", "", 1.0, 0.111_508_270_209_214_07),
        ("2.5 kN", "5 kN", 2.0, 0.222_953_501_902_507_68),
        ("2.5 kN", "7.5 kN", 3.0, 0.334_272_847_322_423_26),
        ("\"1 kg\"", "\"0.5 kg\"", 2.0, 0.222_953_501_902_507_68),
        ("316 rad/s", "158 rad/s", 2.0, 0.222_953_501_902_507_68),
    ] {
        let found = of(old, new);
        let hopf = 0.5 * ratio * 4.2 * 0.1 / 1.42_f64.powi(2);
        assert!((found.hopf_damping_ratio.unwrap() - hopf).abs() < 1e-13, "{new}: {found:?}");
        assert!((found.critical_damping_ratio.unwrap() - wanted).abs() < 1e-12, "{new}: {found:?}");
    }
    // The resolved study states the physical value.
    let study = Study::parse(&format!("{steady}{keys}"), "loads.toml").unwrap();
    let resolved = toml::to_string(study.file()).unwrap();
    assert!(resolved.contains("s/m\"\n") || resolved.contains("s/mm\"\n"), "{resolved}");
    assert_eq!(Study::parse(&resolved, "resolved.toml").unwrap().file(), study.file());
    let message = refused("damping_ratio = 0.1\ndimensionless_belt_velocity = 0.1\nstribeck = \"0.13 m/s\"");
    assert!(message.contains("`m/s` is not a unit") && message.contains("0.13 s/m"), "{message}");
}

#[test]
fn a_dimensionless_law_warns_in_a_study_that_varies_the_load() {
    let map = "[vibration.map]\nover = \"velocity_load\"\nx = [0.003, 0.004, 1]\ny = [1.0, 2.0, 1]\ndepth = 0\ntrajectories = 4";
    let warnings = |law: &str| {
        let steady = MACHINE.replace("friction_std = 0.001", "friction_std = 0.0");
        let text = format!("{steady}damping_ratio = 0.17\ndimensionless_belt_velocity = 0.003\n{law}\n{map}");
        let study = Study::parse(&text, "map.toml").unwrap();
        let found = study.run(Path::new("."), None, &Silent).unwrap().results.warnings;
        // The study alone gives the warning, before it runs.
        assert_eq!(study.warnings().iter().any(|text| found.contains(text)), !found.is_empty());
        found
    };
    for law in ["stribeck = 4.2", "", "velocity_law = \"linear\"\nlinear_weakening = 0.2"] {
        let found = warnings(law);
        // 4.2 and 0.2 over 7.911 m/s.
        let physical = if law.contains("linear") { "0.02528 s/m" } else { "0.5309 s/m" };
        assert!(found.iter().any(|text| text.contains("2.5 kN") && text.contains(physical)), "{law}: {found:?}");
    }
    assert_eq!(warnings("stribeck = \"0.5309 s/m\""), Vec::<String>::new());
}
