//! Verdicts of studies with uncertain values against closed forms.

use std::fs;

use asperity_testing::StudyText;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Finished, folder_with_study, json_of, run_in};

/// A machine with linear weakening b and no jump of friction: it vibrates if ζ < b/2, from stick and from steady sliding.
pub(crate) const MACHINE: &str = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
                       nominal_area = \"833 mm^2\"\nstatic_friction = 0.3\nfriction_std = 0\n";

/// Runs `asperity verdict` on a machine with further lines.
pub(crate) fn run(lines: &str) -> Finished {
    run_in(folder_with_study(&format!("{MACHINE}{lines}")).path(), "verdict study.toml --json")
}

fn verdict(lines: &str) -> Value {
    run(lines).json(0)
}

/// The machine with normal b and ζ.
const LINEAR: &str = "dimensionless_belt_velocity = 0.1\nvelocity_law = \"linear\"\nlinear_weakening = \"0.1 ± 0.02\"\n\
                      damping_ratio = \"0.055 ± 0.005\"\n";

/// Returns the verdict of the machine with normal b and another ζ.
fn linear(damping: &str, more: &str) -> Value {
    verdict(&format!("{}{more}", LINEAR.replace("\"0.055 ± 0.005\"", damping)))
}

pub(crate) fn pair(value: &Value) -> [f64; 2] {
    [value[0].as_f64().unwrap(), value[1].as_f64().unwrap()]
}

/// Asserts that an interval contains a number.
pub(crate) fn contains(interval: &Value, wanted: f64) {
    let [low, high] = pair(interval);
    assert!(low <= wanted && wanted <= high, "{low} to {high} does not contain {wanted}");
}

#[test]
#[ignore = "slow"]
fn a_linear_law_has_the_probability_drivers_and_remedies_of_the_closed_form() {
    // M = ζ − b/2 ~ N(.005, .0111803).
    let found = linear(
        "\"0.055 ± 0.005\"",
        "[verdict]\nremedies = [{ input = \"vibration.damping_ratio\", range = [0.01, 0.5] }, \
         { input = \"vibration.linear_weakening\", range = [0.01, 0.2] }]\n",
    );
    for key in ["probability", "probability_from_steady_sliding"] {
        contains(&found[format!("{key}_interval")], 0.327_360_4);
        assert!((found[key].as_f64().unwrap() - 0.327_360_4).abs() < 0.02, "{found}");
    }
    let [low, high] = pair(&found["probability_interval"]);
    assert!(high - low <= 0.04);
    let index = |list: &str, input: usize, key: &str| found[list][input][key].as_f64().unwrap();
    for (input, margin, [first, total]) in [(0, 0.2, [0.119, 0.419]), (1, 0.8, [0.581, 0.879])] {
        assert!((index("drivers", input, "first_order") - margin).abs() < 0.005, "{found}");
        assert!((index("drivers", input, "total") - margin).abs() < 0.005, "{found}");
        assert!((index("event_drivers", input, "first_order") - first).abs() < 0.015, "{found}");
        assert!((index("event_drivers", input, "total") - total).abs() < 0.015, "{found}");
        // The range of a normal margin narrows with its standard deviation.
        assert!((index("drivers", input, "range_reduction") - (1.0 - (1.0 - margin).sqrt())).abs() < 0.03, "{found}");
    }
    let wanted = [[0.068_390_0, 0.076_009_4], [0.073_220_0, 0.057_981_3]];
    for (remedy, wanted) in found["remedies"].as_array().unwrap().iter().zip(wanted) {
        for (reach, wanted) in remedy["reach"].as_array().unwrap().iter().zip(wanted) {
            contains(&reach["value_interval"], wanted);
            assert!((reach["value"].as_f64().unwrap() - wanted).abs() < 1e-3, "{found}");
            assert_eq!(reach["friction_coefficient"], 0.3);
        }
    }
    assert_eq!(found["nominal"]["vibrates"], false);
    assert!((found["nominal"]["damping_margin"].as_f64().unwrap() - 0.005).abs() < 1e-12);
    // At P = 1 % b is .058 ± .02.
    let warnings = found["warnings"].as_array().unwrap();
    assert!(warnings.len() == 1 && warnings[0].as_str().unwrap().contains("of it lies beyond"), "{warnings:?}");
}

#[test]
#[ignore = "slow"]
fn more_damping_never_makes_vibration_more_probable() {
    let laws = [
        "velocity_law = \"stribeck\"\nstribeck = \"4 ± 1\"\n",
        "velocity_law = \"linear\"\nlinear_weakening = \"0.1 ± 0.03\"\n",
        "velocity_law = \"exponential\"\nstribeck_velocity = \"0.4 ± 0.05 m/s\"\nhigh_speed_share = 0.6\n",
    ];
    for law in laws {
        for belt in [0.003, 0.3] {
            let mut last = [1.0_f64; 2];
            for damping in ["\"0.05 ± 0.01\"", "\"0.2 ± 0.02\"", "3"] {
                let machine = format!("dimensionless_belt_velocity = {belt}\n{law}damping_ratio = {damping}\n");
                let found = verdict(&format!("{machine}[verdict]\nevaluations = 1000\n"));
                let [low, high] = pair(&found["probability_interval"]);
                let probability = found["probability"].as_f64().unwrap();
                let name =
                    format!("{law}belt {belt}, damping {damping}: {probability} from {low} to {high} after {last:?}");
                assert!(
                    (0.0..=1.0).contains(&low) && low <= probability && probability <= high && high <= 1.0,
                    "{name}"
                );
                assert!(low <= last[0] && probability <= last[1], "{name}");
                last = [probability, high];
            }
            assert!(last[0] < 1e-3, "{law} belt {belt}: {last:?} at a damping ratio of 3");
        }
    }
}

#[test]
#[ignore = "slow"]
fn small_probabilities_have_both_ends_of_their_interval_above_zero() {
    for (damping, wanted) in [("\"0.09 ± 0.005\"", 1.733e-4), ("\"0.105 ± 0.005\"", 4.342e-7)] {
        let found = linear(damping, "");
        contains(&found["probability_interval"], wanted);
        let [low, high] = pair(&found["probability_interval"]);
        assert!(low > 0.0 && high < 3.0 * low, "{low} to {high}");
        assert!(found["sentence"].as_str().unwrap().contains("fewer than 1 in 1,000"), "{found}");
    }
}

#[test]
#[ignore = "slow"]
fn a_machine_far_from_the_limit_has_a_small_bound_from_one_replicate() {
    // M = ζ − b/2 ~ N(.15, .0111803) is negative with a probability of 1e-40.
    let found = linear("\"0.2 ± 0.005\"", "");
    let [low, high] = pair(&found["probability_interval"]);
    assert!(found["probability"] == 0.0 && low == 0.0 && 0.0 < high && high < 1e-8, "{low} to {high}");
    assert!(found["evaluations"].as_u64().unwrap() <= 4096 + 2 * 4600, "{}", found["evaluations"]);
}

#[test]
fn coupled_modes_leave_out_the_fluctuation_of_friction_and_state_it() {
    let coupled = |std: &str| {
        let machine = MACHINE.replace("friction_std = 0\n", std);
        let lines = "model = \"mode_coupling\"\nbelt_velocity = \"0.5 m/s\"\ndamping_ratio = 0.02\n[verdict]\nremedies = [\
                     { input = \"vibration.damping_ratio\", range = [0.01, 0.1] }, \
                     { input = \"vibration.static_friction\", range = [0.5, 0.8] }]\n";
        run_in(folder_with_study(&format!("{machine}{lines}")).path(), "verdict study.toml --json").json(0)
    };
    let constant = coupled("friction_std = 0\n");
    let mean =
        coupled("friction_std = 0.01\nfriction_correlation_length = \"250 um\"\nfriction_marginal = \"normal\"\n");
    for (found, wanted) in [(&constant, false), (&mean, true)] {
        assert!(
            found["leaves_out_fluctuation"] == wanted && found["map"]["leaves_out_fluctuation"] == wanted,
            "{found}"
        );
        assert_eq!(found["sentence"].as_str().unwrap().contains("its fluctuation along the path is left out"), wanted);
        assert_eq!(found["assumptions"].to_string().contains("leaves out the fluctuation of friction"), wanted);
    }
    assert_eq!((&constant["probability"], &constant["remedies"]), (&mean["probability"], &mean["remedies"]));
}

#[test]
#[ignore = "slow"]
fn a_jump_and_a_falling_law_separate_stick_from_steady_sliding() {
    // A jump of .05 at V = .05 with a weakening b: ζ_v = .0578291 + b/2, ζ_H = b/2.
    let jump = verdict(
        "dimensionless_belt_velocity = 0.05\nvelocity_law = \"linear\"\nlinear_weakening = \"0.1 ± 0.02\"\n\
         kinetic_share = 0.8333333333333334\ndamping_ratio = \"0.1 ± 0.005\"\n",
    );
    contains(&jump["probability_interval"], 0.7581);
    contains(&jump["probability_from_steady_sliding_interval"], 3.9e-6);
    let falling = "dimensionless_belt_velocity = 0.1\nstribeck = 4.2\ndamping_ratio = 0.21\n";
    let machine = MACHINE.replace("static_friction = 0.3", "static_friction = \"0.2 ± 0.02\"");
    let folder = folder_with_study(&format!("{machine}{falling}"));
    let ended = run_in(folder.path(), "verdict study.toml --json");
    let found = ended.json(0);
    contains(&found["probability_interval"], 0.7195);
    contains(&found["probability_from_steady_sliding_interval"], 0.4673);
    // The same verdict is part of a run.
    let run = run_in(folder.path(), "run study.toml --out run --only verdict");
    assert_eq!(run.code, 0, "{run:?}");
    let results = json_of(&folder.path().join("run/results.json"));
    assert_eq!(results["verdict"]["probability"], found["probability"]);
    let resolved = fs::read_to_string(folder.path().join("run/study.toml")).unwrap();
    assert!(resolved.contains("static_friction = \"0.2 ± 0.02\""), "{resolved}");
    let threads = run_in(folder.path(), "verdict study.toml --json --threads 1");
    assert_eq!(threads.stdout, ended.stdout);
}

#[test]
#[ignore = "slow"]
fn slip_cycles_of_a_table_end_at_the_loss_of_stability() {
    // μ = .3 + .1 exp(−(v/.08)²) at V = .056: the grazing point .418 is below ζ_H = .536 (published), and slip cycles last to about there.
    // Coefficients count relative to the first, .4, and static friction is .3: limits are three quarters of these.
    let unit_m_per_s = 2500.0 / 316.0;
    let points: Vec<String> = (0..=80)
        .map(|k| f64::from(k) * 0.005)
        .map(|v| format!("[\"{:?} m/s\", {:?}]", v * unit_m_per_s, 0.3 + 0.1 * (-(v / 0.08).powi(2)).exp()))
        .collect();
    let found = verdict(&format!(
        "dimensionless_belt_velocity = 0.056\nvelocity_law = \"table\"\nfriction_table = [{}]\n\
         damping_ratio = \"0.375 ± 0.027\"\n",
        points.join(", ")
    ));
    let limit = found["nominal"]["limit_damping_ratio"].as_f64().unwrap();
    assert!((0.4012..0.405).contains(&limit), "{limit}");
    // P[ζ < .402] = Φ(1).
    for key in ["probability_interval", "probability_from_steady_sliding_interval"] {
        contains(&found[key], 0.8413);
    }
    assert!(found["if_vibrating"]["kinds"]["slip_cycle"].as_f64().unwrap() > 0.5, "{found}");
}

#[test]
#[ignore = "slow"]
fn samples_are_exported_with_their_kind_and_margin() {
    let folder = folder_with_study(&format!("{MACHINE}{LINEAR}"));
    let found = run_in(folder.path(), "verdict study.toml --export-samples samples.csv --json").json(0);
    let text = fs::read_to_string(folder.path().join("samples.csv")).unwrap();
    let mut rows = text.lines();
    let header = "kind,vibration.damping_ratio,vibration.linear_weakening,friction_coefficient,damping_margin";
    assert_eq!(rows.next(), Some(header));
    let (mut vibrating, mut all) = (0, 0);
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        let [damping, weakening, friction, margin] =
            [1, 2, 3, 4].map(|place: usize| cells[place].parse::<f64>().unwrap());
        assert!((margin - (damping - 0.5 * weakening)).abs() < 1e-12 && friction == 0.3, "{row}");
        assert_eq!(cells[0], if margin < 0.0 { "stick_slip" } else { "none" });
        (vibrating, all) = (vibrating + usize::from(margin < 0.0), all + 1);
    }
    assert_eq!(found["probability"], vibrating as f64 / all as f64);
    let shown = run_in(folder.path(), "verdict study.toml").stdout;
    assert!(shown.starts_with(found["sentence"].as_str().unwrap()), "{shown}");
    assert!(shown.contains("weakening of friction with speed") && !shown.contains('{'), "{shown}");
}

#[test]
fn a_run_prints_the_sentence_of_its_verdict() {
    let lines = format!("{}[verdict]\nevaluations = 1000\n", LINEAR.replace("\"0.1 ± 0.02\"", "0.1"));
    let folder = folder_with_study(&format!("{MACHINE}{lines}"));
    let found = run_in(folder.path(), "verdict study.toml --json").json(0);
    let shown = run_in(folder.path(), "run study.toml --out run");
    assert!(shown.code == 0 && shown.stdout.contains(found["sentence"].as_str().unwrap()), "{shown:?}");
    // The study leaves out one number with a range.
    assert_eq!(found["assumed"].as_array().unwrap().len(), 1);
    assert_eq!((&found["assumed"][0]["range"], &found["assumed"][0]["value"]), (&vec![0.9, 1.0].into(), &1.0.into()));
    assert_eq!(found["assumed"][0]["probability_at"][1], found["probability"]);
    let lines: Vec<&str> = shown.stdout.lines().filter(|line| line.contains("(kinetic_share), assumed 1: ")).collect();
    assert!(lines.len() == 1 && lines[0].starts_with("Not stated"), "{shown:?}");
    let [.., error, report] = &shown.stdout.lines().collect::<Vec<_>>()[..] else { panic!("{shown:?}") };
    let machines = 100.0 * found["error_sources"][0]["half_width"].as_f64().unwrap();
    assert!(error.contains(&format!("the number of machines, up to {machines:.2} ")), "{error}");
    assert!(error.contains("lower `half_width`") && report.starts_with("Report: run/report.html"), "{shown:?}");
}

#[test]
fn a_vibrating_machine_has_the_frequency_and_the_amplitudes_of_the_closed_form() {
    // Coulomb friction without damping, Δ = μ_s − μ_k = .1 and V = .05: slip is a circle of the radius A = √(Δ² + V²) from which the
    // belt cuts a chord at X′ = V.
    let found = verdict(
        "dimensionless_belt_velocity = 0.05\nvelocity_law = \"linear\"\nlinear_weakening = 0\nkinetic_share = 0.6666666666666666\ndamping_ratio = 0\n",
    );
    let (omega, jump, belt) = (316.0, 0.1_f64, 0.05);
    let (radius, length) = (jump.hypot(belt), 2500.0 / (omega * omega));
    let period = std::f64::consts::TAU + 2.0 * (jump / belt - (jump / belt).atan());
    for (key, wanted) in [
        ("frequency_hz", omega / period),
        ("velocity_amplitude_m_per_s", 0.5 * (radius + belt) * length * omega),
        ("displacement_amplitude_m", radius * length),
    ] {
        let number = found["if_vibrating"][key]["q50"].as_f64().unwrap();
        assert!((number / wanted - 1.0).abs() < 1e-9, "{key}: {number} instead of {wanted}");
    }
}

#[test]
fn machines_without_an_answer_are_counted_and_left_out() {
    let lines = "dimensionless_belt_velocity = 0.1\nvelocity_law = \"linear\"\nlinear_weakening = { lognormal = [0.1, 1.2] }\n\
                 damping_ratio = 0.5\n[verdict]\nduration = \"2 s\"\n";
    let folder = folder_with_study(&format!("{MACHINE}{lines}"));
    let found = run_in(folder.path(), "verdict study.toml --export-samples samples.csv --json").json(0);
    let text = fs::read_to_string(folder.path().join("samples.csv")).unwrap();
    let weakening: Vec<f64> = text.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
    // A linear law with a steep slope falls below zero: the machines of the largest slopes have no answer.
    let steepest = weakening.iter().copied().fold(0.0, f64::max);
    let failed = found["failed_samples"].as_u64().unwrap() as usize;
    let sampled = failed + weakening.len();
    let wanted = asperity::distribution::standard_normal_cdf(-(steepest / 0.1).ln() / 1.2);
    assert!((failed as f64 / sampled as f64 - wanted).abs() < 2.0 / sampled as f64, "{failed} of {sampled}, {wanted}");
    assert!(found["first_failure"].as_str().unwrap().contains("must stay positive"), "{found}");
    let warnings: Vec<&str> =
        found["warnings"].as_array().unwrap().iter().map(|warning| warning.as_str().unwrap()).collect();
    assert!(warnings[0].starts_with(&format!("{failed} sampled machines have no answer")), "{warnings:?}");
    assert!(warnings.iter().enumerate().all(|(i, warning)| !warnings[..i].contains(warning)), "{warnings:?}");
    // The number of machines is the only source of error.
    let [low, high] = pair(&found["probability_interval"]);
    let sources = found["error_sources"].as_array().unwrap();
    assert_eq!((sources.len(), &sources[0]["source"]), (1, &"machines".into()));
    assert!((sources[0]["half_width"].as_f64().unwrap() - 0.5 * (high - low)).abs() < 1e-12, "{found}");
    assert_eq!(found["duration_s"], 2.0);
    // Fewer answers than the study asks for are none; a narrower interval than the machines give has a warning.
    for (before, after, code, message) in [
        ("valid_share = 0.999\n", "", 4, format!("{failed} of {sampled} sampled machines have no answer")),
        (
            "",
            "half_width = 0.002\nevaluations = 2048\n",
            0,
            "the interval of the probability is wider than ± 0.2 %".into(),
        ),
    ] {
        fs::write(folder.path().join("study.toml"), format!("{before}{MACHINE}{lines}{after}")).unwrap();
        let ended = run_in(folder.path(), "verdict study.toml --json");
        assert_eq!(ended.code, code, "{ended:?}");
        assert!(ended.stderr.contains(&message), "{message}: {ended:?}");
    }
}

#[test]
#[ignore = "slow"]
fn unknown_values_give_a_range_of_probabilities() {
    // Given ζ, P = Φ((.1 − 2ζ)/.02).
    let found = linear("{ normal = [0.055, 0.005], unknown = true }", "");
    let quantile = |score: f64| asperity::distribution::standard_normal_cdf(-(0.01 + 0.01 * score) / 0.02);
    let wanted = [quantile(1.644_853_6), quantile(0.0), quantile(-1.644_853_6)];
    for (key, wanted) in ["q05", "q50", "q95"].into_iter().zip(wanted) {
        let value = found["probability_over_unknowns"][key].as_f64().unwrap();
        assert!((value - wanted).abs() < 0.005, "{key}: {value} instead of {wanted}");
    }
    let over = &found["probability_over_unknowns"];
    assert_eq!(pair(&found["probability_range"]).map(Value::from), [over["q05"].clone(), over["q95"].clone()]);
    assert!(found["sentence"].as_str().unwrap().contains("depending on the unknown damping ratio"), "{found}");
    let guess = &found["guesses"][0];
    assert_eq!(guess["input"], "vibration.damping_ratio");
    assert!((guess["probability_at_q05"].as_f64().unwrap() - wanted[2]).abs() < 0.005, "{guess}");
    assert!((guess["probability_at_q95"].as_f64().unwrap() - wanted[0]).abs() < 0.005, "{guess}");
}

/// A machine whose friction comes from the contact of a stated surface, without its Stribeck coefficient.
fn contact(youngs_modulus: &str, shear_strength: &str, stribeck: &str) -> String {
    let material =
        format!("youngs_modulus = \"{youngs_modulus}\"\nhardness = \"100 MPa\"\nshear_strength = \"{shear_strength}\"");
    let friction = "strip = [\"2 mm\", \"80 um\"]\npoints = [256, 16]\nwindow = \"200 um\"\nrealisations = 4";
    let machine = format!("damping_ratio = 0.22295350190250\ndimensionless_belt_velocity = 0.1\nstribeck = {stribeck}");
    StudyText::new(5, &["surface", "material", "friction", "vibration"])
        .with("surface", "covariance = \"squared_exponential\"\ngenerator = \"spectral\"")
        .with("material", &material)
        .with("friction", friction)
        .with("vibration", &machine)
        .to_string()
}

/// Lines of a friction law with the friction of Bowden and Tabor, but which does not state that it is proportional to the shear strength.
const EXPANDED: &str = "[friction]\nlaw = \"pressure_dependent\"\npressure_coefficient = 0.0\n";

/// Runs the verdict of nearly rigid bodies with this shear strength and Stribeck coefficient.
fn plastic(shear_strength: &str, stribeck: &str) -> Value {
    let folder = folder_with_study(&contact("1e9 GPa", shear_strength, stribeck).replace("[friction]\n", EXPANDED));
    run_in(folder.path(), "verdict study.toml --json").json(0)
}

#[test]
#[ignore = "slow"]
fn the_shear_strength_of_plastic_contacts_decides_through_the_whole_chain() {
    // Nearly rigid bodies touch at the hardness everywhere, so μ = τ/H. ζ = .2229535019 is the limit of μ = .2 (published), and the
    // limit rises with μ: P = P[τ > 20 MPa] = Φ(½).
    let found = plastic("21 ± 2 MPa", "4.2");
    contains(&found["probability_interval"], 0.691_462_5);
    assert_eq!(found["drivers"][0]["input"], "material.shear_strength");
    assert!(found["drivers"][0]["first_order"].as_f64().unwrap() > 0.999, "{found}");
    // Friction is learnt as a function of it. A hardness everywhere leaves hardly an error.
    assert_eq!(found["friction"]["inputs"], serde_json::json!(["material.shear_strength"]));
    assert!((0.0..1e-3).contains(&found["friction"]["standard_error"].as_f64().unwrap()), "{found}");
    let statement = "The friction coefficient as a function of material.shear_strength is expanded from ";
    let assumptions = |found: &Value| found["assumptions"].to_string();
    assert!(assumptions(&found).contains(statement), "{found}");
    // The law of Bowden and Tabor is proportional to it, without further solutions.
    let folder = folder_with_study(&contact("1e9 GPa", "21 ± 2 MPa", "4.2"));
    let scaled = run_in(folder.path(), "verdict study.toml --json").json(0);
    contains(&scaled["probability_interval"], 0.691_462_5);
    assert!(
        (scaled["probability"].as_f64().unwrap() - found["probability"].as_f64().unwrap()).abs() < 1e-3,
        "{scaled}"
    );
    assert!(scaled["friction"].is_null() && assumptions(&scaled).contains("is proportional to the shear strength"));
}

#[test]
#[ignore = "slow"]
fn small_probabilities_through_the_whole_chain_are_those_of_the_shear_strength() {
    // P[τ > 20 MPa] = Φ(−5) lies beyond the range on which friction is learnt.
    let found = plastic("15 ± 1 MPa", "4.2");
    contains(&found["probability_interval"], 2.866_516e-7);
    let [low, high] = pair(&found["probability_interval"]);
    assert!(low > 0.0 && high < 3.0 * low, "{low} to {high}");
}

#[test]
#[ignore = "slow"]
fn an_uncertain_law_decides_over_computed_friction() {
    // The limit rises with the Stribeck coefficient: P = P[a > 4.2] = Φ(½), in either unit. 1 m/s is mω₀/N = .1264 of the unit of velocity.
    for stribeck in ["\"4.4 ± 0.4\"", "\"0.55616 ± 0.05056 s/m\""] {
        let found = plastic("20 MPa", stribeck);
        contains(&found["probability_interval"], 0.691_462_5);
        assert_eq!(found["drivers"][0]["input"], "vibration.stribeck");
    }
}

#[test]
#[ignore = "slow"]
fn the_map_of_two_inputs_and_its_contours_are_the_closed_form() {
    let remedies = "[verdict]\nremedies = [{ input = \"vibration.damping_ratio\", range = [0.03, 0.15] }, \
                    { input = \"vibration.linear_weakening\", range = [0.08, 0.2] }]\n";
    let folder = folder_with_study(&format!("{MACHINE}{LINEAR}{remedies}"));
    let found = run_in(folder.path(), "run study.toml --out run --only verdict --json").json(0)["verdict"].clone();
    // M = ζ − b/2 is normal about the difference of the central values; verdict/map.rs compares each probability.
    let std = 0.005_f64.hypot(0.01);
    let map = &found["map"];
    let values = |axis: &str| -> Vec<f64> {
        map[axis]["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    let (damping, weakening) = (values("x"), values("y"));
    assert_eq!(
        (&map["x"]["input"], &map["y"]["input"]),
        (&"vibration.damping_ratio".into(), &"vibration.linear_weakening".into())
    );
    assert_eq!((damping[0], damping[16], weakening[0], weakening[16]), (0.03, 0.15, 0.08, 0.2));
    assert!((damping[4] - 0.06).abs() < 1e-12 && (weakening[4] - 0.11).abs() < 1e-12, "{map}");
    assert_eq!(map["leaves_out_fluctuation"], false);
    let text = fs::read_to_string(folder.path().join("run/tables/verdict_map_contours.csv")).unwrap();
    let mut rows = text.lines();
    assert_eq!(rows.next(), Some("level,line,vibration.damping_ratio,vibration.linear_weakening"));
    let contours: Vec<[f64; 3]> = rows
        .map(|row| {
            let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            [cells[0], cells[2], cells[3]]
        })
        .collect();
    for (level, quantile, tolerance) in [(0.01, 2.326_347_9, 0.1), (0.05, 1.644_853_6, 0.05), (0.5, 0.0, 0.02)] {
        let line: Vec<&[f64; 3]> = contours.iter().filter(|point| point[0] == level).collect();
        assert!(line.len() > 16, "{} points at {level}", line.len());
        for [_, damping, weakening] in &line {
            let margin = (damping - 0.5 * weakening) / std;
            assert!((margin - quantile).abs() < tolerance, "{margin} at {damping}, {weakening}");
        }
        // The remedies keep the other value at .1 and .055.
        for remedy in found["remedies"].as_array().unwrap() {
            let reach = remedy["reach"].as_array().unwrap().iter().find(|reach| reach["probability"] == level);
            let Some(value) = reach.and_then(|reach| reach["value"].as_f64()) else { continue };
            let (own, other, at) =
                if remedy["input"] == "vibration.damping_ratio" { (1, 2, 0.1) } else { (2, 1, 0.055) };
            let Some(pair) = line.windows(2).find(|pair| (pair[0][other] < at) != (pair[1][other] < at)) else {
                continue;
            };
            let fraction = (at - pair[0][other]) / (pair[1][other] - pair[0][other]);
            let crossing = pair[0][own] + fraction * (pair[1][own] - pair[0][own]);
            assert!((crossing - value).abs() < 2.0 * tolerance * std, "{crossing} instead of {value}");
        }
    }
    let figure = fs::read_to_string(folder.path().join("run/figures/verdict_map.svg")).unwrap();
    for text in ["Damping ratio, central value", "Weakening of friction with speed, central value", ">5 %<", ">now<"] {
        assert!(figure.contains(text), "{text} is missing");
    }
}

/// The paper's machine with friction that fluctuates three times as much.
fn fluctuating(damping: &str, upscaling: &str) -> Value {
    let machine =
        format!("damping_ratio = {damping}\nstribeck = 4.2\nfriction_std = 0.003\nupscaling = \"{upscaling}\"");
    let study = StudyText::new(1, &["vibration", "stated friction"])
        .with("vibration", &machine)
        .with("verdict", "duration = \"0.6 s\"");
    run_in(folder_with_study(&study.to_string()).path(), "verdict study.toml --json").json(0)
}

#[test]
fn one_window_is_the_papers_verdict_and_the_nominal_area_that_of_the_area() {
    // Without fluctuation the machine vibrates below ζ = .2048301505845 (published); the fluctuation of one window makes it vibrate above.
    let [paper, area] = ["paper", "area"].map(|upscaling| fluctuating("0.23", upscaling));
    let rows = area["area_as_one"].as_array().unwrap();
    let last = rows.len() - 1;
    assert_eq!(Some(rows), paper["area_as_one"].as_array());
    assert_eq!((&rows[0]["probability"], &rows[last]["probability"]), (&paper["probability"], &area["probability"]));
    assert_eq!((&paper["probability"], &area["probability"]), (&1.0.into(), &0.0.into()));
    let number = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    // The window is 75 µm × 600 µm.
    assert_eq!(number(0, "windows"), 1.0);
    assert!((number(last, "windows") - 833e-6 / (75e-6 * 600e-6)).abs() < 1e-6, "{rows:?}");
    for row in 0..last {
        let std = number(row, "friction_std") * number(row, "windows").sqrt();
        assert!((std - 0.003).abs() < 1e-15, "{rows:?}");
    }
    // Windows that depend on each other average less.
    assert!(number(last, "friction_std") * number(last, "windows").sqrt() > 0.003);
}

#[test]
#[ignore = "slow"]
fn plastic_contact_says_that_the_roughness_does_not_matter() {
    let assumptions = |youngs_modulus: &str| {
        let folder = folder_with_study(&contact(youngs_modulus, "21 MPa", "4.2"));
        run_in(folder.path(), "verdict study.toml --json").json(0)["assumptions"].to_string()
    };
    let plastic = assumptions("1e9 GPa");
    assert!(plastic.contains("Friction is τ/H here") && plastic.contains("above τ/H = 0.21."), "{plastic}");
    // Slopes of .07 at E* = 1 GPa give pressures below the hardness of 100 MPa.
    let elastic = assumptions("1 GPa");
    assert!(!elastic.contains("Friction is τ/H here"), "{elastic}");
}

#[test]
fn a_check_states_the_machines_and_contact_solutions_of_the_verdict() {
    let folder = TempDir::new().unwrap();
    let estimate = |study: String| {
        fs::write(folder.path().join("study.toml"), study).unwrap();
        let found = run_in(folder.path(), "check study.toml --json").json(0);
        found["estimate"].as_array().unwrap().last().unwrap().clone()
    };
    let law = "dimensionless_belt_velocity = 0.1\nvelocity_law = \"linear\"\nlinear_weakening = \"0.1 ± 0.02\"\ndamping_ratio = 0.055\n";
    let stated = estimate(format!("{MACHINE}{law}[verdict]\nremedies = []\n"));
    assert_eq!((&stated["stage"], &stated["contact_solutions"]), (&"verdict".into(), &0.into()));
    // 4,096 machines have a half width of at most .0153 at any probability, and each has a limit cycle in the table of samples.
    // 256 have the low end of `kinetic_share`.
    assert_eq!((&stated["machines"], &stated["trajectories"]), (&8448.into(), &0.into()));
    // 4,096 more have the limits for a change of damping, which is computed unless the study says otherwise; that of the load takes more.
    let usual = estimate(format!("{MACHINE}{law}"));
    assert!(usual["machines"].as_u64().unwrap() > 8448 + 4096, "{usual}");
    // 10 points of one value, with 4 strips each.
    let computed = estimate(contact("1e9 GPa", "21 ± 2 MPa", "4.2").replace("[friction]\n", EXPANDED));
    assert_eq!(computed["contact_solutions"], 40);
    assert_eq!(estimate(contact("1e9 GPa", "21 ± 2 MPa", "4.2"))["contact_solutions"], 0);
    // Plastic windows hardly fluctuate over the nominal area; one window does.
    let one_window =
        contact("1e9 GPa", "21 ± 2 MPa", "4.2").replace("[vibration]\n", "[vibration]\nupscaling = \"paper\"\n");
    assert_eq!(computed["trajectories"], 0);
    assert!(estimate(one_window.clone())["trajectories"].as_u64().unwrap() > 0);
    assert!(computed["core_s"].as_f64().unwrap() > 0.0);
    fs::write(folder.path().join("study.toml"), one_window.replace("[friction]\n", EXPANDED)).unwrap();
    let text = run_in(folder.path(), "check study.toml --show").stdout;
    assert!(
        text.contains("# verdict: about 8192 machines, about") && text.contains("about 40 contact solutions"),
        "{text:.400}"
    );
    // A machine of exact values is one machine, its limit cycle counts as another, and so does the low end of `kinetic_share`.
    let exact = estimate(contact("1e9 GPa", "21 MPa", "4.2"));
    assert_eq!(
        (&exact["stage"], &exact["machines"], &exact["contact_solutions"]),
        (&"verdict".into(), &3.into(), &0.into())
    );
}
