//! What a tribologist wants to know first.

use serde_json::Value;

use super::friction::{operating_point, place};
use super::json::shown;
use super::method_name;
use super::tables::list;
use super::vibration::difference;
use crate::Run;
use crate::format::{significant, with_error};

/// Up to this share of the deterministic cycles an effect is called negligible even where it is resolved.
const NEGLIGIBLE: f64 = 0.01;
/// Up to this share an interval around zero says that there is no effect; a wider one says that nothing is known.
const NARROW: f64 = 0.1;
const VANISHES: &str = "The paper’s effect vanishes at your scale";

/// A question, its short answer, and what qualifies it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Answer {
    pub(super) question: &'static str,
    pub(super) answer: String,
    pub(super) detail: String,
}

/// The answers that the results hold.
pub(super) fn answers(run: &Run) -> Vec<Answer> {
    let results = &run.results;
    [contact(run), friction(&results["friction"]), squeal(run), damping(run), roughness(run)]
        .into_iter()
        .flatten()
        .collect()
}

/// At the operating point, where there is one; otherwise at the level of the pressure stage.
fn contact(run: &Run) -> Option<Answer> {
    let question = "How likely is contact at a point?";
    let patch = patch_contact(run);
    let point = operating_point(&run.results["friction"]).filter(|point| point["contact_fraction"].is_number());
    if let Some(point) = point {
        let also = patch.map_or(String::new(), |(probability, level, _)| format!(" {level}, it is {probability}."));
        return Some(Answer {
            question,
            answer: format!("P(contact) = {}", shown(&point, "contact_fraction")),
            detail: format!(
                "At the operating point ({}): contact area over nominal area of the strips; brackets hold the 95 % interval.{also}",
                place(&point)
            ),
        });
    }
    let (probability, level, origin) = patch?;
    let answer = format!("P(contact) = {probability}");
    Some(Answer { question, answer, detail: format!("{level}. {origin}; ± is one standard error.") })
}

/// The contact probability of the pressure stage with its standard error, its level, and where it is from.
fn patch_contact(run: &Run) -> Option<(String, String, String)> {
    let pressure = &run.results["pressure"];
    let known = |entry: &&Value| entry["contact_probability"].is_number();
    let solves =
        |entry: &Value, key: &str| entry[key].as_u64().map_or(String::new(), |n| format!(", {n} contact solutions"));
    // The reference run stands in the stage itself; without it, the first method that has an answer.
    let (entry, origin) = match Some(pressure).filter(known) {
        Some(stage) => (stage, format!("Reference run by Monte Carlo{}", solves(stage, "reference_samples"))),
        None => {
            let methods = list(&pressure["methods"]);
            let named = |name: &str| methods.iter().filter(known).find(|method| method["name"] == name);
            let method = named("reference").or(named("monte_carlo")).or(methods.iter().find(known))?;
            let name = method_name(method["name"].as_str().unwrap_or("unnamed"));
            (method, format!("Method: {name}{}", solves(method, "fine_solves")))
        }
    };
    let probability = entry["contact_probability"].as_f64()?;
    let error = entry["contact_probability_se"].as_f64().unwrap_or(f64::NAN);
    let stated = |key: &str| {
        let input = run.inputs.iter().find(|input| input.section == "pressure" && input.key == key)?;
        Some(input.value.trim().to_owned())
    };
    let level = match (stated("percentile"), stated("penetration"), stated("mean_pressure")) {
        (Some(percent), ..) if percent.parse() == Ok(50.0) => "With the plane at the median height".to_owned(),
        (Some(percent), ..) => format!("With the plane below {percent} % of the heights"),
        (_, Some(depth), _) => format!("With the plane {depth} below the highest point"),
        (.., Some(pressure)) => format!("At a mean pressure of {pressure}"),
        _ => "At the level of the pressure stage".to_owned(),
    };
    Some((with_error(probability, error), level, origin))
}

fn friction(friction: &Value) -> Option<Answer> {
    let point = operating_point(friction).filter(|point| point["mean"].is_number())?;
    let window = friction["window_m"]
        .as_f64()
        .map_or("one window".into(), |w| format!("a window of {}", crate::format::Dimension::Length.show(w)));
    let std = |key: &str| point[key].as_f64().map(|std| significant(std, 2));
    let scatter = match (std("std"), std("std_nominal_area")) {
        (Some(own), Some(area)) => format!(" Standard deviation: {own} for {window}, {area} over the nominal area."),
        (Some(own), None) => format!(" Standard deviation: {own} for {window}."),
        _ => String::new(),
    };
    let brackets = if point["mean_interval"].is_array() { "; brackets hold the 95 % interval" } else { "" };
    Some(Answer {
        question: "Which friction coefficient follows?",
        answer: format!("μ = {}", shown(&point, "mean")),
        detail: format!("At the operating point ({}){brackets}.{scatter}", place(&point)),
    })
}

/// The damping ratio of the study, from the results or its inputs.
fn operating_damping(run: &Run) -> Option<f64> {
    run.results["vibration"]["damping_ratio"].as_f64().or_else(|| {
        let input = run.inputs.iter().find(|input| input.section == "vibration" && input.key == "damping_ratio")?;
        input.value.trim().parse().ok()
    })
}

fn squeal(run: &Run) -> Option<Answer> {
    let cycle = &run.results["vibration"]["cycle"];
    let exists = cycle["limit_cycle"].as_bool()?;
    let at = operating_damping(run)
        .map_or(String::new(), |zeta| format!(" at the study’s damping ζ = {}", significant(zeta, 4)));
    let (answer, detail) = if exists {
        let period =
            cycle["period"].as_f64().map_or(String::new(), |t| format!(" with the period {}/ω₀", significant(t, 4)));
        ("Yes: a stick-slip limit cycle exists", format!("Without roughness{at}{period}."))
    } else {
        ("No: no stick-slip limit cycle", format!("Without roughness{at}."))
    };
    Some(Answer { question: "Does it squeal?", answer: answer.into(), detail })
}

fn damping(run: &Run) -> Option<Answer> {
    let vibration = &run.results["vibration"];
    let critical = vibration["critical_damping_ratio"].as_f64()?;
    let hopf = vibration["hopf_damping_ratio"].as_f64().map_or(String::new(), |hopf| {
        format!(" Steady sliding loses its stability below ζ = {} (Hopf point).", significant(hopf, 5))
    });
    let margin = operating_damping(run).map_or(String::new(), |zeta| {
        let side = if zeta < critical { "below" } else { "above" };
        format!(" The study’s ζ = {} lies {} {side} it.", significant(zeta, 4), significant((zeta - critical).abs(), 2))
    });
    Some(Answer {
        question: "Which damping ends it?",
        answer: format!("ζ = {}", significant(critical, 5)),
        detail: format!("Above this damping ratio no stick-slip cycle exists.{hopf}{margin}"),
    })
}

/// The entry whose damping ratio is nearest to the study's, or the first.
fn nearest(upscaling: &Value, damping: Option<f64>) -> Option<&Value> {
    let entries = list(&upscaling["damping"]);
    let Some(damping) = damping else { return entries.first() };
    let away = |entry: &Value| entry["damping_ratio"].as_f64().map_or(f64::INFINITY, |zeta| (zeta - damping).abs());
    entries.iter().min_by(|a, b| away(a).total_cmp(&away(b)))
}

fn roughness(run: &Run) -> Option<Answer> {
    let vibration = &run.results["vibration"];
    let study = operating_damping(run);
    let entry = nearest(&vibration["area"], study)?;
    let lost = entry["difference_mean"].as_f64()?;
    let (limits, text) = difference(run, "area", entry);
    let deterministic = entry["cycles_deterministic"].as_f64();
    // Beyond the critical damping the deterministic count is zero, so the sweep's largest count sets the scale.
    let counts = list(&vibration["area"]["damping"]).iter().filter_map(|entry| entry["cycles_deterministic"].as_f64());
    let scale = counts.fold(0.0, f64::max);
    let unresolved = limits.is_some_and(|(low, high)| low <= 0.0 && high >= 0.0);
    let narrow = limits.is_some_and(|(low, high)| low.abs().max(high.abs()) <= NARROW * scale);
    let (answer, reason) = if unresolved && narrow {
        (VANISHES.to_owned(), " (the 95 % interval holds zero)")
    } else if unresolved {
        let answer = "No effect is resolved: more trajectories are needed".to_owned();
        (answer, " (the 95 % interval holds zero, but is wide)")
    } else if lost.abs() <= NEGLIGIBLE * scale {
        (VANISHES.to_owned(), " (no more than 1 % of the cycles)")
    } else if lost < 0.0 {
        (format!("It adds {} cycles", significant(-lost, 3)), "")
    } else {
        let of = deterministic.map_or(String::new(), |m| format!(" of {}", significant(m, 4)));
        (format!("It costs {}{of} cycles", significant(lost, 3)), "")
    };
    let at = entry["damping_ratio"].as_f64().map_or(String::new(), |zeta| {
        let near = study.is_some_and(|study| (study - zeta).abs() > 1e-9);
        let near = if near { ", in the sweep the nearest to the study’s" } else { "" };
        format!(" at ζ = {}{near}", significant(zeta, 4))
    });
    let paper = nearest(&vibration["paper"], entry["damping_ratio"].as_f64())
        .filter(|paper| paper["difference_mean"].is_number() && paper["damping_ratio"] == entry["damping_ratio"])
        .map_or(String::new(), |paper| {
            let (_, text) = difference(run, "paper", paper);
            format!(" If one window carried the whole normal force, as in the paper, it would be {text}.")
        });
    Some(Answer {
        question: "What does roughness do to the vibration?",
        answer,
        detail: format!("Cycles lost with μ averaged over the nominal contact area{at}: {text}{reason}.{paper}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn run(area: Value) -> Run {
        let results = json!({"vibration": {"damping_ratio": 0.17, "area": {"damping": area}}});
        Run { results, ..Run::default() }
    }

    fn answer(area: Value) -> Answer {
        roughness(&run(area)).unwrap()
    }

    #[test]
    fn an_interval_around_zero_or_a_tiny_loss_means_that_the_effect_vanishes() {
        let unresolved = json!([{"damping_ratio": 0.17, "cycles_deterministic": 99, "difference_mean": 3.0,
                                 "difference_mean_interval": [-0.5, 6.5]}]);
        assert_eq!(answer(unresolved).answer, VANISHES);
        let tiny = json!([{"damping_ratio": 0.17, "cycles_deterministic": 99, "difference_mean": 0.4,
                           "difference_mean_interval": [0.3, 0.5]}]);
        assert_eq!(answer(tiny).answer, VANISHES);
        let wide = json!([{"damping_ratio": 0.17, "cycles_deterministic": 99, "difference_mean": 15.0,
                           "difference_mean_interval": [-20.0, 50.0]}]);
        assert!(answer(wide).answer.starts_with("No effect is resolved"));
        let clear = json!([{"damping_ratio": 0.17, "cycles_deterministic": 99, "difference_mean": 29.5,
                            "difference_mean_interval": [28.9, 30.1]}]);
        assert_eq!(answer(clear).answer, "It costs 29.5 of 99 cycles");
        let added = json!([{"damping_ratio": 0.25, "cycles_deterministic": 0, "difference_mean": -17.2}]);
        assert_eq!(answer(added).answer, "It adds 17.2 cycles");
    }

    #[test]
    fn the_answer_is_taken_at_the_damping_nearest_to_the_study() {
        let sweep = json!([{"damping_ratio": 0.05, "cycles_deterministic": 90, "difference_mean": 40.0},
                           {"damping_ratio": 0.175, "cycles_deterministic": 99, "difference_mean": 20.0},
                           {"damping_ratio": 0.3, "cycles_deterministic": 0, "difference_mean": -5.0}]);
        assert!(answer(sweep).detail.contains("ζ = 0.175"));
    }

    #[test]
    fn nothing_is_answered_without_results() {
        assert!(answers(&Run::default()).is_empty());
        let nulls = json!({"pressure": {"methods": [{"name": "sobol", "contact_probability": null}]},
                           "vibration": {"cycle": {"limit_cycle": null}, "critical_damping_ratio": null}});
        assert!(answers(&Run { results: nulls, ..Run::default() }).is_empty());
    }

    #[test]
    fn a_run_of_an_older_version_answers_with_its_leading_level() {
        let results = json!({"friction": {"levels": [
            {"percentile": 50.0, "mean_pressure_pa": 1e9, "mean": 0.2, "std": 0.01},
            {"percentile": null, "mean_pressure_pa": 3e6, "mean": 0.3312, "std": 0.0123}]}});
        let found = answers(&Run { results, ..Run::default() });
        let plain = |text: &str| text.replace('\u{a0}', " ");
        assert_eq!(plain(&found[0].answer), "μ = 0.3312");
        assert!(plain(&found[0].detail).contains("3 MPa"));
    }

    #[test]
    fn friction_and_contact_are_those_of_the_operating_point() {
        let results = json!({
            "pressure": {"contact_probability": 0.2202, "contact_probability_se": 0.0057},
            "friction": {
                "window_m": 6e-4,
                "operating_point": {"level": "the nominal pressure", "mean_pressure_pa": 3e6, "contact_fraction": 0.0143,
                    "contact_fraction_interval": [0.014, 0.0146], "mean": 0.204_07, "mean_interval": [0.2027, 0.2055],
                    "std": 0.0087, "std_nominal_area": 6.4e-5},
                "levels": [{"leading": true, "mean_pressure_pa": 3e6, "mean": 0.2173, "std": null}]}});
        let inputs = vec![crate::Input { section: "pressure".into(), key: "percentile".into(), value: "50.0".into() }];
        let mut run = Run { results, inputs, ..Run::default() };
        let plain = |text: &str| text.replace('\u{a0}', " ");
        let found = answers(&run);
        assert_eq!(plain(&found[0].answer), "P(contact) = 0.01430 [0.01400, 0.01460]");
        assert!(plain(&found[0].detail).contains("the nominal pressure, 3 MPa"), "{:?}", found[0]);
        assert!(plain(&found[0].detail).contains("With the plane at the median height, it is 0.2202 ± 0.0057."));
        assert_eq!(plain(&found[1].answer), "μ = 0.2041 [0.2027, 0.2055]");
        assert!(plain(&found[1].detail).contains("0.0087 for a window of 600 µm"), "{:?}", found[1]);
        // Without a friction stage the level of the patches is named.
        run.results["friction"] = Value::Null;
        let found = answers(&run);
        assert_eq!(plain(&found[0].answer), "P(contact) = 0.2202 ± 0.0057");
        assert!(plain(&found[0].detail).starts_with("With the plane at the median height."), "{:?}", found[0]);
    }
}
