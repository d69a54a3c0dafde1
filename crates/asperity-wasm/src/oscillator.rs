//! Stick-slip of a mass on a belt.

use asperity_base::monitor::Monitor;
use asperity_base::stats::Histogram;
use asperity_process::{FrictionProcess, ProcessModel};
use asperity_report::live;
use asperity_vibration::law::Stribeck;
use asperity_vibration::{
    Drive, EnsembleSettings, Oscillator, Parameters, PhasePoint, Regime, Scales, VibrationError, accept_clipping,
    clipped_to_positive, cycle_portrait, limit_cycle, limit_damping, phase_cloud, smallest_kick,
};
use serde::Deserialize;
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

use crate::answer::{Answer, Failure, read};
use crate::monitor::Progress;

/// Number of trajectories of the phase cloud.
const CLOUD: usize = 30;

/// Machine with the paper's friction law μ_st/(1 + a|v|), and the fluctuation of its friction.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Machine {
    mass_kg: f64,
    natural_frequency_rad_per_s: f64,
    normal_force_n: f64,
    damping_ratio: f64,
    belt_velocity_m_per_s: f64,
    static_friction: f64,
    stribeck_s_per_m: f64,
    friction_correlation_length_m: f64,
    friction_std: f64,
    marginal: String,
}

/// Converts a machine to the variables of the oscillator: `parameters` of [`cycle`], `process` of [`ensemble`], and the
/// units `length_m`, `time_s` and `velocity_m_per_s`.
#[wasm_bindgen]
pub fn dimensionless(machine: &str) -> Result<Answer, JsError> {
    Ok(scaled(machine)?)
}

/// Finds the motion from a start in stick, with the keys of `asperity vibration cycle --json` but for the kick. The
/// arrays `displacement` and `velocity` are `points` of its phase portrait, empty without a cycle.
#[wasm_bindgen]
pub fn cycle(parameters: &str, points: usize) -> Result<Answer, JsError> {
    Ok(motion(parameters, points)?)
}

/// Finds the damping ratios at which vibration ends, with the keys of `asperity vibration critical-damping --json`,
/// and the smallest kick of steady sliding that starts vibration.
#[wasm_bindgen]
pub fn limits(parameters: &str) -> Result<Answer, JsError> {
    Ok(ends_of_vibration(parameters)?)
}

/// Simulates many trajectories over a random friction fluctuation, with keys of `asperity vibration ensemble --json` and
/// the `reattachment_displacement` without fluctuation.
///
/// Arrays: `reattachment` and `reattachment_density` (histogram of the displacements at re-attachment), and
/// `displacement` and `velocity`, the ends of the first trajectories, 72 points and an undefined one of each.
#[wasm_bindgen]
pub fn ensemble(request: &str) -> Result<Answer, JsError> {
    Ok(simulated(request, &Progress)?)
}

/// Draws a phase portrait as SVG: the arrays of [`cycle`] and [`ensemble`], the units of both, and the velocity of the belt in SI.
#[wasm_bindgen]
#[must_use]
pub fn portrait(
    displacement: &[f64],
    velocity: &[f64],
    runs_displacement: &[f64],
    runs_velocity: &[f64],
    length_m: f64,
    velocity_m_per_s: f64,
    belt_velocity_m_per_s: f64,
) -> String {
    let [x, runs_x] = [displacement, runs_displacement].map(|values| multiplied(values, length_m));
    let [v, runs_v] = [velocity, runs_velocity].map(|values| multiplied(values, velocity_m_per_s));
    live::portrait([&x, &v], [&runs_x, &runs_v], belt_velocity_m_per_s)
}

/// Draws the histogram of an [`ensemble`] as SVG, with the displacement at re-attachment without fluctuation.
#[wasm_bindgen]
#[must_use]
pub fn reattachment(centres: &[f64], density: &[f64], without: Option<f64>, length_m: f64) -> String {
    let (centres, density) = (multiplied(centres, length_m), multiplied(density, 1.0 / length_m));
    live::reattachment(&centres, &density, without.map(|value| value * length_m))
}

fn multiplied(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|value| factor * value).collect()
}

pub(crate) fn scaled(machine: &str) -> Result<Answer, Failure> {
    let machine: Machine = read(machine)?;
    let scales = Scales::new(machine.mass_kg, machine.natural_frequency_rad_per_s, machine.normal_force_n)?;
    let (length_m, velocity_m_per_s) = (scales.length_m(), scales.velocity_m_per_s());
    let parameters = Parameters {
        static_friction: machine.static_friction,
        law: Stribeck { kinetic: machine.static_friction, decay: machine.stribeck_s_per_m * velocity_m_per_s }.into(),
        damping_ratio: machine.damping_ratio,
        belt_velocity: machine.belt_velocity_m_per_s / velocity_m_per_s,
        forcing: None,
    };
    let correlation_length = machine.friction_correlation_length_m / length_m;
    Answer::new(&json!({
        "parameters": parameters,
        "process": ProcessModel::new(machine.marginal.parse()?, machine.friction_std, correlation_length),
        "length_m": length_m,
        "time_s": scales.time_s(),
        "velocity_m_per_s": velocity_m_per_s,
    }))
}

/// Reads the parameters of an oscillator. They may have a `friction_factor`, by which all friction coefficients are multiplied.
fn oscillator(parameters: &str) -> Result<Oscillator, Failure> {
    moved(read(parameters)?)
}

fn moved(mut parameters: Value) -> Result<Oscillator, Failure> {
    let factor = parameters.as_object_mut().and_then(|keys| keys.remove("friction_factor")?.as_f64()).unwrap_or(1.0);
    let mut parameters: Parameters = read(&parameters.to_string())?;
    parameters.static_friction *= factor;
    parameters.law = parameters.law.with_coefficients(|coefficient| factor * coefficient)?;
    Ok(Oscillator::new(parameters)?)
}

/// Returns the displacements and the velocities of a portrait.
fn columns<'a>(portrait: impl IntoIterator<Item = &'a PhasePoint>) -> (Vec<f64>, Vec<f64>) {
    portrait.into_iter().map(|point| (point.displacement, point.velocity)).unzip()
}

pub(crate) fn motion(parameters: &str, points: usize) -> Result<Answer, Failure> {
    let oscillator = oscillator(parameters)?;
    let regime = limit_cycle(&oscillator)?;
    let cycle = regime.cycle();
    let portrait = match regime {
        Regime::Cycle(_) => cycle_portrait(&oscillator, points.max(2))?.unwrap_or_default(),
        Regime::Sliding | Regime::Irregular(_) => Vec::new(),
    };
    let (displacement, velocity) = columns(&portrait);
    let unstable = oscillator.forcing().is_none().then(|| oscillator.sliding_is_unstable());
    let answer = Answer::new(&json!({
        "kind": regime.kind().name(),
        "steady_sliding_unstable": unstable,
        "limit_cycle": cycle.is_some(),
        "period": cycle.map(|c| c.period),
        "slip_duration": cycle.map(|c| c.slip_duration),
        "reattachment_displacement": cycle.and_then(|c| c.reattachment_displacement),
        "displacement_min": cycle.map(|c| c.displacement_min),
        "displacement_max": cycle.map(|c| c.displacement_max),
        "velocity_min": cycle.map(|c| c.velocity_min),
    }))?;
    Ok(answer.with("displacement", displacement).with("velocity", velocity))
}

pub(crate) fn ends_of_vibration(parameters: &str) -> Result<Answer, Failure> {
    let oscillator = oscillator(parameters)?.with_forcing(None)?;
    let critical = asperity_vibration::critical_damping(&oscillator)?;
    let limit = match limit_damping(&oscillator) {
        Err(VibrationError::NotFound { .. }) => None,
        limit => Some(limit?),
    };
    Answer::new(&json!({
        "critical_damping_ratio": critical.critical_damping_ratio,
        "hopf_damping_ratio": critical.hopf_damping_ratio,
        "limit_damping_ratio": limit,
        "kick": smallest_kick(&oscillator)?,
    }))
}

/// Settings of an ensemble.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    parameters: Value,
    process: ProcessModel,
    #[serde(default)]
    drive: Drive,
    trajectories: usize,
    duration: f64,
    seed: u64,
}

fn simulated(request: &str, monitor: &dyn Monitor) -> Result<Answer, Failure> {
    let request: Request = read(request)?;
    let oscillator = moved(request.parameters)?;
    let model = clipped_to_positive(&oscillator, request.process, 1.0);
    let clipped_fraction = model.clipped_fraction();
    let process = FrictionProcess::new(model)?;
    accept_clipping(clipped_fraction, false).map_err(|error| {
        Failure(format!("{error}; lower the variability of friction or its weakening with velocity"))
    })?;
    let settings = EnsembleSettings {
        drive: request.drive,
        ..EnsembleSettings::new(request.trajectories, request.duration, request.seed)
    };
    let found = asperity_vibration::Ensemble::simulate(&oscillator, &process, &settings, monitor)?;
    let cloud = phase_cloud(&oscillator, &process, &settings, CLOUD, monitor)?;
    // An undefined point separates the trajectories.
    let gap = PhasePoint { tau: f64::NAN, displacement: f64::NAN, velocity: f64::NAN };
    let (displacement, velocity) = columns(cloud.iter().flatten().flat_map(|run| run.iter().chain([&gap])));
    let histogram = Histogram::new(&found.reattachments.sample).ok();
    let passages = &found.passages;
    let regime = limit_cycle(&oscillator)?;
    let answer = Answer::new(&json!({
        "kind": regime.kind().name(),
        "reattachment_displacement": regime.cycle().and_then(|cycle| cycle.reattachment_displacement),
        "trajectories": found.trajectories,
        "failures": found.failures.len(),
        "first_failure": found.failures.first().map(|failure| &failure.reason),
        "cycles_mean": found.cycles.mean,
        "cycles_se": found.cycles.se,
        "cycles_deterministic": found.cycles_deterministic,
        "difference_mean": found.difference_mean,
        "difference_mean_interval": found.difference_interval,
        "reattachment_count": found.reattachments.count,
        "reattachment_mean": found.reattachments.mean,
        "reattachment_std": found.reattachments.std,
        "reattachment_skewness": found.reattachments.skewness,
        "period_mean": found.periods.mean,
        "period_std": found.periods.std,
        "kind_shares": passages.kinds,
        "vibration_share": passages.late_share.mean,
        "vibration_share_se": passages.late_share.se,
        "sustained_share": passages.sustained.value,
        "sustained_share_interval": passages.sustained.interval,
        "clipped_fraction": clipped_fraction,
    }))?;
    Ok(answer
        .with("reattachment", histogram.as_ref().map(Histogram::centres).unwrap_or_default())
        .with("reattachment_density", histogram.as_ref().map(Histogram::density).unwrap_or_default())
        .with("displacement", displacement)
        .with("velocity", velocity))
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::monitor::Silent;

    /// Machine of figure 5 of the paper: one kilogram, so that V = 0.003 and λ = 0.01.
    const MACHINE: &str = r#"{"mass_kg": 1.0, "natural_frequency_rad_per_s": 316.0, "normal_force_n": 2500.0,
        "damping_ratio": 0.17, "belt_velocity_m_per_s": 0.023734177215189875, "static_friction": 0.1,
        "stribeck_s_per_m": 0.530880, "friction_correlation_length_m": 250.36052e-6,
        "friction_std": 0.001, "marginal": "beta:2.1,5"}"#;

    fn numbers(answer: &Answer) -> Value {
        serde_json::from_str(&answer.json()).unwrap()
    }

    fn parameters() -> Value {
        numbers(&scaled(MACHINE).unwrap())["parameters"].take()
    }

    /// Request for an ensemble of the machine with a standard deviation of friction.
    fn request(friction_std: f64, trajectories: usize, duration: f64) -> Value {
        let mut process = numbers(&scaled(MACHINE).unwrap())["process"].take();
        process["std"] = friction_std.into();
        json!({"parameters": parameters(), "process": process, "trajectories": trajectories, "duration": duration, "seed": 1})
    }

    #[test]
    fn the_paper_s_machine_has_the_paper_s_cycle() {
        let scaled = numbers(&scaled(MACHINE).unwrap());
        assert!((scaled["parameters"]["belt_velocity"].as_f64().unwrap() - 0.003).abs() < 1e-9);
        assert!((scaled["process"]["correlation_length"].as_f64().unwrap() - 0.01).abs() < 1e-7);
        let mut found = motion(&parameters().to_string(), 400).unwrap();
        let period = numbers(&found)["period"].as_f64().unwrap();
        assert!((period - 6.372_163_483_739_709).abs() < 1e-6, "period {period}");
        assert_eq!((found.take("displacement").len(), found.take("velocity").len()), (400, 400));
        let limits = numbers(&ends_of_vibration(&parameters().to_string()).unwrap());
        let critical = limits["critical_damping_ratio"].as_f64().unwrap();
        assert!((critical - 0.204_830_150_584).abs() < 1e-6, "critical damping ratio {critical}");
    }

    #[test]
    fn another_friction_is_another_belt_velocity_and_stribeck_coefficient() {
        // X and V per μ: with the friction 2μ, the machine is that of V/2 and 2a.
        let (mut twice, mut slow) = (parameters(), parameters());
        twice["friction_factor"] = 2.0.into();
        slow["belt_velocity"] = (0.5 * slow["belt_velocity"].as_f64().unwrap()).into();
        slow["law"]["stribeck"]["decay"] = (2.0 * slow["law"]["stribeck"]["decay"].as_f64().unwrap()).into();
        let period = |machine: &Value| numbers(&motion(&machine.to_string(), 10).unwrap())["period"].as_f64().unwrap();
        assert!((period(&twice) - period(&slow)).abs() < 1e-9, "{} {}", period(&twice), period(&slow));
    }

    #[test]
    fn an_ensemble_counts_the_cycles_of_the_paper_s_machine() {
        let mut found = simulated(&request(0.001, 40, 637.2).to_string(), &Silent).unwrap();
        let numbers = numbers(&found);
        // 8,000 paths of two independent codes: 69.20 ± 0.07.
        let (mean, se) = (numbers["cycles_mean"].as_f64().unwrap(), numbers["cycles_se"].as_f64().unwrap());
        assert!((mean - 69.2).abs() < 4.0 * se && se < 2.0, "{mean} ± {se}");
        let density = found.take("reattachment_density");
        let centres = found.take("reattachment");
        let area: f64 = density.iter().sum::<f64>() * (centres[1] - centres[0]);
        assert!((area - 1.0).abs() < 1e-12, "area {area}");
        assert_eq!(found.take("velocity").len(), CLOUD * 73);
    }

    #[test]
    fn an_unknown_key_and_a_large_fluctuation_are_errors_in_words() {
        assert!(motion(r#"{"damping": 0.1}"#, 10).unwrap_err().0.contains("unknown field `damping`"));
        assert!(simulated(&request(0.5, 4, 10.0).to_string(), &Silent).unwrap_err().0.contains("clipped"));
    }
}
