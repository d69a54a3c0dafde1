//! The headline answers of a page.

use asperity_results::{
    DampingResult, EnsembleResult, FrictionResult, ModeCouplingResult, MotionKind, Pair, PressureResult, RoughBody,
    VibrationResult,
};

use crate::Run;
use crate::cells::shown;
use crate::format::{Dimension, significant};
use crate::page::answer::Answer;
use crate::page::friction::place;
use crate::page::{mode_coupling, parameters};
use crate::verdict::is_exact;
use crate::words::capitalised;

/// Largest fraction of the deterministic cycles at which a resolved effect is called negligible.
const NEGLIGIBLE: f64 = 0.01;
/// Largest half width of an interval around zero, as a fraction of the deterministic cycles, at which there is no effect. A wider
/// interval is inconclusive.
const NARROW: f64 = 0.1;

/// Returns the answers of a run without a verdict.
pub(super) fn answers(run: &Run) -> Vec<Answer> {
    let results = &run.results;
    let vibration = results.vibration.as_ref();
    [
        contact(run),
        results.friction.as_ref().map(friction),
        vibration.map(vibrates),
        results.mode_coupling.as_ref().map(coupled),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Answers at the operating point if there is one, otherwise at the level of the pressure stage.
fn contact(run: &Run) -> Option<Answer> {
    let question = "How likely is contact at a point?";
    let pressure = run.results.pressure.as_ref();
    if let Some(friction) = &run.results.friction {
        let point = &friction.operating_point;
        let also = pressure.map_or(String::new(), |pressure| {
            format!(" At a point of a random patch, {}, it is {}.", patch_level(run), patch_probability(pressure))
        });
        let probability = shown(Dimension::None, point.contact_fraction, point.contact_fraction_interval);
        return Some(Answer {
            question,
            answer: format!("P(contact) = {probability}"),
            detail: format!(
                "At the operating point ({}): contact area over nominal area of the strips; brackets are the 95 % interval.{also}",
                place(friction)
            ),
        });
    }
    let pressure = pressure?;
    Some(Answer {
        question,
        answer: format!("P(contact) = {}", patch_probability(pressure)),
        detail: format!(
            "At a point of a random patch, {}; from {}; brackets are the 95 % interval.",
            patch_level(run),
            pressure.origin()
        ),
    })
}

/// Formats the contact probability of the pressure stage with its 95 % interval.
fn patch_probability(pressure: &PressureResult) -> String {
    shown(Dimension::None, pressure.contact_probability, pressure.contact_probability_interval)
}

/// Describes the level of the pressure stage.
fn patch_level(run: &Run) -> String {
    let stated = |key: &str| {
        let input = run.inputs.iter().find(|input| input.section == "pressure" && input.key == key)?;
        Some(input.value.trim().to_owned())
    };
    match (stated("percentile"), stated("penetration"), stated("mean_pressure")) {
        (Some(percent), ..) if percent.parse() == Ok(50.0) => "with the plane at the median height".to_owned(),
        (Some(percent), ..) => format!("with the plane below {percent} % of the heights"),
        (_, Some(depth), _) => format!("with the plane {depth} below the highest point"),
        (.., Some(pressure)) => format!("pressed with {pressure}"),
        _ => "at the level of the pressure stage".to_owned(),
    }
}

fn friction(friction: &FrictionResult) -> Answer {
    let point = &friction.operating_point;
    let brackets = if point.mean_interval.is_some() { "; brackets are the 95 % interval" } else { "" };
    let parts = match friction.body {
        RoughBody::Track => "",
        RoughBody::Slider => " between parts (the slider is rough, and the friction of a part is constant)",
        RoughBody::Both => " between parts and along the path (both bodies are rough)",
    };
    let of_scan = point.mean_of_scan.map_or_else(String::new, |mean| {
        format!(" The scan itself, pressed like the random strips, has {}.", significant(mean, 4))
    });
    let mean = shown(Dimension::None, point.mean, point.mean_interval);
    Answer {
        question: "What is the friction coefficient?",
        answer: if point.resolved {
            format!("μ = {mean}")
        } else {
            format!("Not resolved: about {mean}; see the warnings")
        },
        detail: format!(
            "At the operating point ({}){brackets}.{of_scan} Standard deviation{parts}: {} for a window of {}, {} over the nominal area.",
            place(friction),
            significant(point.std, 2),
            Dimension::Length.show_short(friction.window_m),
            significant(point.std_nominal_area, 2)
        ),
    }
}

/// Returns height and correlation lengths of the surface in a sentence.
pub(super) fn of_surface(run: &Run) -> Option<String> {
    let surface = run.results.surface.as_ref()?;
    let value = |key: &str| parameters::value(&surface.measured, key);
    let Some(height) = value("Sq_m") else {
        let covariance = surface.covariance.as_ref()?;
        return Some(format!("A stated surface with Sq = {}.", Dimension::Length.show_short(covariance.std_m)));
    };
    let lengths = [value("correlation_length_x_m"), value("correlation_length_y_m")];
    let lengths = match lengths {
        [Some(x), Some(y)] => format!("; heights are correlated over {x} along x and {y} along y"),
        _ => String::new(),
    };
    Some(format!("Sq = {height}{lengths}."))
}

/// Returns the contact area at the operating point, and the contact probability at a point of a patch, in two sentences.
pub(super) fn of_pressure(run: &Run, pressure: &PressureResult) -> String {
    let area = run.results.friction.as_ref().map_or_else(String::new, |friction| {
        let point = &friction.operating_point;
        let fraction = shown_percent(point.contact_fraction, point.contact_fraction_interval);
        format!("At the operating point ({}), {fraction} of the nominal area is in contact. ", place(friction))
    });
    let point = format!(
        "Point of a random patch, {}: estimated probability of contact {}.",
        patch_level(run),
        shown_percent(pressure.contact_probability, pressure.contact_probability_interval)
    );
    area + &point
}

/// Formats a fraction with its interval in percent.
fn shown_percent(fraction: f64, interval: Option<Pair>) -> String {
    shown(Dimension::Other("%"), 100.0 * fraction, interval.map(|ends| ends.map(|end| 100.0 * end)))
}

/// Returns the friction coefficient at the operating point in a sentence.
pub(super) fn of_friction(result: &FrictionResult) -> String {
    let point = &result.operating_point;
    let window = Dimension::Length.show_short(result.window_m);
    let std = significant(point.std, 2);
    format!("{}; it differs by ± {std} from window to window of {window}.", friction(result).answer)
}

/// Returns whether the machine vibrates, and the damping that stops it, in a sentence.
pub(super) fn of_vibration(run: &Run, vibration: &VibrationResult) -> String {
    let is_centre = run.results.verdict.as_ref().is_some_and(|verdict| !is_exact(verdict));
    let fluctuates = run.results.verdict.as_ref().is_some_and(|verdict| verdict.friction_fluctuates);
    let values = match (is_centre, fluctuates) {
        (true, true) => "With all uncertain values at their centres and without the fluctuation of friction: ",
        (true, false) => "With all uncertain values at their centres: ",
        (false, true) => "Without the fluctuation of friction: ",
        (false, false) => "",
    };
    let limit = vibration
        .limit_damping_ratio
        .map_or(String::new(), |limit| format!(" No vibration persists above ζ = {}.", significant(limit, 4)));
    let cause = if run.results.friction.is_some() { "roughness" } else { "the fluctuation of friction" };
    let roughness = roughness(vibration, cause).map_or(String::new(), |effect| format!(" {effect}."));
    format!("{values}{}.{limit}{roughness}", vibration_answer(vibration))
}

/// Returns whether steady sliding is stable in a sentence.
pub(super) fn of_mode_coupling(run: &Run, result: &ModeCouplingResult) -> String {
    let is_centre = run.results.verdict.as_ref().is_some_and(|verdict| !is_exact(verdict));
    let values = if is_centre { "With all uncertain values at their centres: " } else { "" };
    format!("{values}{}.", mode_coupling::answer(result))
}

/// Answers whether the machine vibrates without fluctuation of friction, and what starts the vibration.
pub fn vibration_answer(vibration: &VibrationResult) -> String {
    match (vibration.cycle.limit_cycle, vibration.steady_sliding_unstable, vibration.kick_m_per_s) {
        (false, Some(_), _) => "No: every motion ends in steady sliding".into(),
        (false, None, _) => "No: no limit cycle is reached from stick".into(),
        (true, Some(true), _) => "Yes: steady sliding is unstable".into(),
        (true, Some(false), Some(kick)) => format!(
            "Yes, once started (from standstill or by a kick of {}); steady sliding alone stays quiet",
            Dimension::Velocity.show(kick)
        ),
        (true, _, _) => "Yes: a limit cycle is reached from stick".into(),
    }
}

fn vibrates(vibration: &VibrationResult) -> Answer {
    let kind = match vibration.kind {
        MotionKind::StickSlip => " The motion is stick-slip: the mass sticks to the belt in every period.",
        MotionKind::Overtaking => " The mass overtakes the belt in every period and never sticks.",
        MotionKind::SlipCycle => " The mass stays slower than the belt and never sticks.",
        MotionKind::Flutter | MotionKind::Divergence | MotionKind::None => "",
    };
    let period = vibration.cycle.period.map_or(String::new(), |t| format!(" The period is {}/ω₀.", significant(t, 4)));
    let detail = format!(
        "Without fluctuation of friction at the study’s damping ζ = {}.{kind}{period}",
        significant(vibration.damping_ratio, 4)
    );
    Answer { question: "Does it vibrate?", answer: vibration_answer(vibration), detail }
}

fn coupled(found: &ModeCouplingResult) -> Answer {
    let critical = found.critical_friction.map_or_else(
        || "No friction coefficient makes it unstable.".to_owned(),
        |critical| format!("The critical coefficient is {}.", significant(critical, 4)),
    );
    let detail = format!("With the mean friction coefficient μ = {}. {critical}", significant(found.friction, 4));
    Answer { question: "Does it squeal by mode coupling?", answer: mode_coupling::answer(found).into(), detail }
}

/// Returns the entry with the nearest damping ratio.
fn nearest(upscaling: &EnsembleResult, damping: f64) -> Option<&DampingResult> {
    let away = |entry: &DampingResult| (entry.damping_ratio - damping).abs();
    upscaling.damping.iter().min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// Returns what the cause of the fluctuation, such as roughness, does to the vibration at the damping ratio of the sweep that is nearest to the study's, in a phrase.
fn roughness(vibration: &VibrationResult, cause: &str) -> Option<String> {
    let own = vibration.of_study();
    let entry = nearest(own, vibration.damping_ratio)?;
    let (lost, [low, high]) = (entry.difference_mean, entry.difference_interval);
    // Beyond the critical damping the deterministic count is zero, so the sweep's largest count sets the scale.
    let scale = own.damping.iter().map(|entry| entry.cycles_deterministic).fold(0, u64::max) as f64;
    let unresolved = low <= 0.0 && high >= 0.0;
    let narrow = low.abs().max(high.abs()) <= NARROW * scale;
    Some(if unresolved && !narrow {
        format!("No effect of {cause} is resolved: more trajectories are needed")
    } else if unresolved || lost.abs() <= NEGLIGIBLE * scale {
        format!("{} has no effect at the scale of your machine", capitalised(cause.to_owned()))
    } else if lost < 0.0 {
        format!("{} adds {} cycles", capitalised(cause.to_owned()), significant(-lost, 3))
    } else {
        let of = significant(entry.cycles_deterministic as f64, 4);
        format!("{} costs {} of {of} cycles", capitalised(cause.to_owned()), significant(lost, 3))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const VANISHES: &str = "Roughness has no effect at the scale of your machine";
    use asperity_results::{CycleResult, OperatingPoint, Results, VerdictResult};

    fn vibration(damping: Vec<DampingResult>) -> VibrationResult {
        let area = EnsembleResult { damping, ..EnsembleResult::default() };
        VibrationResult { damping_ratio: 0.17, area, ..VibrationResult::default() }
    }

    fn entry(damping_ratio: f64, cycles: u64, difference_mean: f64, difference_interval: [f64; 2]) -> DampingResult {
        let cycles_deterministic = cycles;
        DampingResult {
            damping_ratio,
            cycles_deterministic,
            difference_mean,
            difference_interval,
            ..DampingResult::default()
        }
    }

    fn answer(damping: Vec<DampingResult>) -> String {
        roughness(&vibration(damping), "roughness").unwrap()
    }

    #[test]
    fn the_effect_vanishes_for_an_interval_around_zero_and_for_a_tiny_loss() {
        assert_eq!(answer(vec![entry(0.17, 99, 3.0, [-0.5, 6.5])]), VANISHES);
        assert_eq!(answer(vec![entry(0.17, 99, 0.4, [0.3, 0.5])]), VANISHES);
        assert!(answer(vec![entry(0.17, 99, 15.0, [-20.0, 50.0])]).starts_with("No effect of roughness is resolved"));
        assert_eq!(answer(vec![entry(0.17, 99, 29.5, [28.9, 30.1])]), "Roughness costs 29.5 of 99 cycles");
        assert_eq!(answer(vec![entry(0.25, 0, -17.2, [-18.0, -16.0])]), "Roughness adds 17.2 cycles");
    }

    #[test]
    fn the_answer_is_taken_at_the_damping_nearest_to_the_study() {
        let sweep = [
            entry(0.05, 90, 40.0, [39.0, 41.0]),
            entry(0.175, 99, 20.0, [19.0, 21.0]),
            entry(0.3, 0, -5.0, [-6.0, -4.0]),
        ];
        assert_eq!(answer(sweep.into()), "Roughness costs 20 of 99 cycles");
    }

    #[test]
    fn the_cause_of_the_fluctuation_and_the_central_values_are_named() {
        let vibration = vibration(vec![entry(0.17, 101, 29.8, [28.9, 30.1])]);
        let verdict = VerdictResult { friction_fluctuates: true, evaluations: 64, ..VerdictResult::default() };
        let run = Run { results: Results { verdict: Some(verdict), ..Results::default() }, ..Run::default() };
        let words = of_vibration(&run, &vibration);
        assert!(words.ends_with("The fluctuation of friction costs 29.8 of 101 cycles."), "{words}");
        let centre = "With all uncertain values at their centres";
        assert!(words.starts_with(&format!("{centre} and without the fluctuation of friction: No")), "{words}");
        let words = of_mode_coupling(&run, &ModeCouplingResult::default());
        assert!(words.starts_with(&format!("{centre}: No")), "{words}");
    }

    #[test]
    fn there_is_no_answer_without_results() {
        assert!(answers(&Run::default()).is_empty());
        let vibration = Some(VibrationResult::default());
        let found = answers(&Run { results: Results { vibration, ..Results::default() }, ..Run::default() });
        assert_eq!(found.iter().map(|answer| answer.question).collect::<Vec<_>>(), ["Does it vibrate?"]);
    }

    #[test]
    fn the_answer_distinguishes_vibration_once_started_unstable_sliding_and_no_vibration() {
        let of = |limit_cycle: bool, unstable: Option<bool>, kick: Option<f64>, kind: MotionKind| {
            let vibration = VibrationResult {
                damping_ratio: 0.11,
                kind,
                steady_sliding_unstable: unstable,
                kick_m_per_s: kick,
                cycle: CycleResult { limit_cycle, period: Some(6.3), ..CycleResult::default() },
                ..VibrationResult::default()
            };
            let results = Results { vibration: Some(vibration), ..Results::default() };
            let found = answers(&Run { results, ..Run::default() });
            assert_eq!(found[0].question, "Does it vibrate?");
            (found[0].answer.replace('\u{a0}', " "), found[0].detail.clone())
        };
        let (answer, detail) = of(true, Some(false), Some(0.0032), MotionKind::SlipCycle);
        assert_eq!(
            answer,
            "Yes, once started (from standstill or by a kick of 3.2 mm/s); steady sliding alone stays quiet"
        );
        assert!(detail.contains("slower than the belt"), "{detail}");
        assert_eq!(of(true, Some(true), None, MotionKind::StickSlip).0, "Yes: steady sliding is unstable");
        assert!(of(true, Some(true), None, MotionKind::Overtaking).1.contains("overtakes the belt"));
        assert!(of(false, Some(false), None, MotionKind::None).0.starts_with("No: every motion"));
        // A machine under a force.
        assert!(of(true, None, None, MotionKind::StickSlip).0.starts_with("Yes: a limit cycle"));
    }

    #[test]
    fn friction_and_contact_are_given_at_the_operating_point() {
        let operating_point = OperatingPoint {
            level: "the nominal pressure".into(),
            mean_pressure_pa: 3e6,
            contact_fraction: 0.0143,
            contact_fraction_interval: Some([0.014, 0.0146]),
            mean: 0.204_07,
            mean_interval: Some([0.2027, 0.2055]),
            std: 0.0087,
            std_nominal_area: 6.4e-5,
            resolved: true,
            ..OperatingPoint::default()
        };
        let pressure = PressureResult {
            contact_probability: 0.2202,
            contact_probability_interval: Some([0.209, 0.2314]),
            reference_samples: 5000,
            ..PressureResult::default()
        };
        let friction = FrictionResult { window_m: 6e-4, operating_point, ..FrictionResult::default() };
        let results = Results { pressure: Some(pressure), friction: Some(friction), ..Results::default() };
        let inputs = vec![crate::Input { section: "pressure".into(), key: "percentile".into(), value: "50.0".into() }];
        let mut run = Run { results, inputs, ..Run::default() };
        let plain = |text: &str| text.replace('\u{a0}', " ");
        let found = answers(&run);
        assert_eq!(plain(&found[0].answer), "P(contact) = 0.01430 [0.01400, 0.01460]");
        assert!(plain(&found[0].detail).contains("the nominal pressure, 3 MPa"), "{:?}", found[0]);
        assert!(
            plain(&found[0].detail)
                .contains("of a random patch, with the plane at the median height, it is 0.220 [0.209, 0.231].")
        );
        assert_eq!(plain(&found[1].answer), "μ = 0.2041 [0.2027, 0.2055]");
        assert!(plain(&found[1].detail).contains("0.0087 for a window of 600 µm"), "{:?}", found[1]);
        // Without a friction stage the level of the patches is named.
        run.results.friction = None;
        let found = answers(&run);
        assert_eq!(plain(&found[0].answer), "P(contact) = 0.220 [0.209, 0.231]");
        assert!(
            plain(&found[0].detail)
                .starts_with("At a point of a random patch, with the plane at the median height; from 5000 contact solutions of the reference run;"),
            "{:?}",
            found[0]
        );
    }
}
