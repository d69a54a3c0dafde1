//! The verdict: how probable vibration is over the uncertain values of a study, what decides it, and what changes it.

mod drivers;
mod fluctuating;
mod machines;
mod remedies;
mod responses;
mod sampled;
mod vibrating;

use self::drivers::MarginModel;
use self::machines::{Machine, Machines, NoAnswer};
use self::responses::FrictionResponses;
use self::sampled::{Evaluated, Sampled};
use self::vibrating::{samples_table, vibrating_machines};
use crate::chaos::rare::{self, RareError, SmallProbability, small_probability};
use crate::friction::{RoughBody, WindowFriction};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::{Interval, NORMAL_95, quantile_sorted, wilson_interval};
use crate::study::output::StageOutput;
use crate::study::result::{MarginQuantile, NominalMachine, VerdictResult};
use crate::study::surface_stage::SurfaceStage;
use crate::study::vibration_stage::kind_result;
use crate::study::{Study, StudyError, sentence};
use crate::vibration::{DampingMargins, limit_cycle, limit_damping, smallest_kick};

/// Probabilities of the quantiles of the margin.
const MARGIN_PROBABILITIES: [f64; 7] = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];
/// Probabilities for which the event has drivers.
const EVENT_RANGE: std::ops::Range<f64> = 0.05..0.95;
/// Standard deviation of friction over its mean below which friction counts as constant.
const NEGLIGIBLE_STD: f64 = 1e-6;
/// Factor of the duration after which the probability is computed again.
const LATER: f64 = 4.0;
/// Fraction of unexplained variance above which there is a warning.
const UNEXPLAINED: f64 = 0.05;
/// Smallest number of machines on each side below which the probability is computed as a small one.
const FEW: usize = 40;
/// Smallest fraction of machines that must have an answer.
const VALID_FRACTION: f64 = 0.95;

/// Name of the table of the sampled machines.
pub const VERDICT_SAMPLES: &str = "verdict_samples";

/// Output of the verdict.
pub(super) struct Verdict {
    pub(super) result: VerdictResult,
    pub(super) output: StageOutput,
}

/// Computes the verdict of a study. `window` is the friction of the machine with all values at their centres.
pub(super) fn run(
    whole: &Study,
    surface: Option<&SurfaceStage>,
    window: &WindowFriction,
    monitor: &dyn Monitor,
) -> Result<Verdict, StudyError> {
    let Some(study) = &whole.verdict else { return Err(StudyError::NoStage("vibration")) };
    let (seed, mut output) = (whole.seed(), StageOutput::default());
    let responses = match surface.filter(|_| window.computed) {
        Some(surface) => FrictionResponses::learn(whole, study, surface, monitor, &mut output)?,
        None => None,
    };
    if surface.is_some_and(|surface| surface.measured.is_some()) && window.computed {
        output.assumptions.push("The verdict takes the statistics of the scan as exact.".into());
    }
    if whole.friction.as_ref().is_some_and(|friction| friction.body != RoughBody::Track) && window.computed {
        output.warnings.push(
            "the probability of vibration leaves out that the friction of rough sliders differs from part to part; state \
             `static_friction` with this standard deviation in a study with [vibration] alone"
                .into(),
        );
    }
    let machines = Machines::new(study, window, responses.as_ref(), seed);
    let nominal = machines.nominal().map_err(StudyError::Verdict)?;
    if nominal.oscillator.forcing().is_some() {
        return Err(StudyError::ForcedVerdict);
    }
    let duration_s = study.duration_s.unwrap_or(nominal.study.duration * nominal.study.scales.time_s());
    let fluctuates = window.std > NEGLIGIBLE_STD * window.mean;
    let evaluate = |machine: &Machine, index: usize| {
        let mut evaluated = Evaluated::constant_friction(machine)?;
        if fluctuates {
            let seed = seed.wrapping_add(index as u64);
            if let Some(vibrates) = fluctuating::vibrates(machine, duration_s, seed, monitor)? {
                evaluated.vibrates = vibrates;
            }
        }
        Ok(evaluated)
    };
    let most = if machines.variables() == 0 { 1 } else { study.evaluations };
    let sampled = Sampled::until(&machines, &evaluate, study.half_width, most, monitor)?;
    let valid = sampled.valid().count();
    let failed = sampled.machines.len() - valid;
    let first_failure = sampled.machines.iter().find_map(|machine| machine.as_ref().err().cloned());
    if (valid as f64) < VALID_FRACTION * sampled.machines.len() as f64 {
        let reason = first_failure.unwrap_or_default();
        return Err(StudyError::Verdict(format!(
            "{failed} of {} sampled machines have no answer; the first because {reason}",
            sampled.machines.len()
        )));
    }
    if let Some(reason) = &first_failure {
        let machines = sentence::count(failed, "sampled machine has", "sampled machines have");
        output.warnings.push(format!("{machines} no answer and are left out; the first because {reason}"));
    }
    let mut evaluations = sampled.machines.len();
    let mut probability_of = |vibrates: fn(&Evaluated) -> bool, margin: fn(&DampingMargins) -> f64, exact: bool| {
        let (vibrating, all) = sampled.count(vibrates);
        let share = vibrating as f64 / all as f64;
        if machines.variables() == 0 {
            return Ok((share, Interval { low: share, high: share }));
        }
        let few = vibrating.min(all - vibrating) < FEW;
        if !(few && exact) {
            return Ok((share, wilson_interval(vibrating, all)));
        }
        // The complement of an almost certain event is a small probability.
        let sign = if 2 * vibrating < all { 1.0 } else { -1.0 };
        let response = |variables: &[f64]| {
            let evaluated = machines.at(variables).and_then(|machine| Evaluated::constant_friction(&machine));
            evaluated.map(|machine| sign * margin(&machine.margins)).map_err(NoAnswer)
        };
        let settings = rare::Settings::new(seed);
        let (small, Interval { low, high }, spent) =
            match small_probability(machines.variables(), &response, &settings, monitor) {
                Ok(SmallProbability::Estimate(found)) => (found.probability, found.interval, found.evaluations),
                Ok(SmallProbability::Bound(bound)) => {
                    (0.0, Interval { low: 0.0, high: bound.probability }, bound.evaluations)
                }
                Err(RareError::Cancelled) => return Err(Cancelled.into()),
                Err(error) => {
                    output.warnings.push(format!("the interval of the small probability is wide: {error}"));
                    return Ok((share, wilson_interval(vibrating, all)));
                }
            };
        evaluations += spent;
        Ok::<_, StudyError>(if sign > 0.0 {
            (small, Interval { low, high })
        } else {
            (1.0 - small, Interval { low: 1.0 - high, high: 1.0 - low })
        })
    };
    let (probability, interval) =
        probability_of(|machine| machine.vibrates, |margins| margins.from_stick, !fluctuates)?;
    let interval = match &responses {
        Some(responses) => {
            let shift = NORMAL_95 * responses.mean_error;
            let shifted = |shift: f64| sampled.shifted(&machines.with_friction_factor(shift.exp()), monitor);
            widened(interval, probability, [shifted(-shift)?, shifted(shift)?])
        }
        None => interval,
    };
    let (from_sliding, sliding_interval) = probability_of(
        |machine| machine.margins.from_steady_sliding < 0.0,
        |margins| margins.from_steady_sliding,
        true,
    )?;
    let mut margins: Vec<f64> = sampled.valid().map(|machine| machine.margins.from_stick).collect();
    margins.sort_by(f64::total_cmp);
    let margin_quantiles = MARGIN_PROBABILITIES
        .map(|probability| MarginQuantile { probability, damping_margin: quantile_sorted(&margins, probability) });
    let mut result = VerdictResult {
        probability,
        probability_interval: [interval.low, interval.high],
        probability_from_steady_sliding: from_sliding,
        probability_from_steady_sliding_interval: [sliding_interval.low, sliding_interval.high],
        evaluations,
        failed_samples: failed,
        first_failure,
        duration_s,
        nominal: nominal_machine(&nominal, evaluate(&nominal, 0).map_err(StudyError::Verdict)?.vibrates)?,
        if_vibrating: vibrating_machines(&machines, &sampled, monitor)?,
        margin_quantiles: margin_quantiles.to_vec(),
        remedies: remedies::remedies(&machines, study, &evaluate, fluctuates, seed, monitor)?,
        ..VerdictResult::default()
    };
    output.tables.push((VERDICT_SAMPLES, samples_table(&machines, &sampled, monitor)?));
    if fluctuates {
        let later = sampled.later(
            &machines,
            &|machine, index| {
                let seed = seed.wrapping_add(index as u64);
                fluctuating::vibrates(machine, LATER * duration_s, seed, monitor)
                    .map(|vibrates| vibrates.unwrap_or(false))
            },
            monitor,
        )?;
        if !interval.contains(later) {
            output.warnings.push(format!(
                "the probability depends on the duration: after four times as long it is {} %",
                sentence::digits(100.0 * later)
            ));
        }
    }
    if let Some(model) = MarginModel::new(&machines, &sampled, fluctuates)? {
        result.drivers = model.margin_drivers(&machines, seed)?;
        if EVENT_RANGE.contains(&probability) {
            result.event_drivers = model.event_drivers(&machines, seed)?;
        }
        if let Some((quantiles, guesses)) = model.over_unknowns(&machines, seed)? {
            (result.probability_over_unknowns, result.guesses) = (Some(quantiles), guesses);
        }
        if model.unexplained > UNEXPLAINED {
            output.warnings.push(format!(
                "the expansion of the margin leaves {} % of its variance unexplained; drivers and the effects of unknown values are \
                 as uncertain",
                sentence::digits(100.0 * model.unexplained)
            ));
        }
    }
    Ok(Verdict { result, output })
}

/// Returns the interval of a probability with the error of the friction, given the probabilities at both ends of the interval of
/// friction. Both errors are independent.
fn widened(interval: Interval, probability: f64, shifted: [f64; 2]) -> Interval {
    let [least, most] = [shifted[0].min(shifted[1]), shifted[0].max(shifted[1])];
    let below = (probability - interval.low).hypot((probability - least).max(0.0));
    let above = (interval.high - probability).hypot((most - probability).max(0.0));
    Interval { low: (probability - below).max(0.0), high: (probability + above).min(1.0) }
}

/// Returns the answer of the machine with all values at their centres.
fn nominal_machine(machine: &Machine, vibrates: bool) -> Result<NominalMachine, StudyError> {
    let oscillator = &machine.oscillator;
    let limit_damping_ratio = limit_damping(oscillator)?;
    let velocity_scale = machine.study.scales.velocity_m_per_s();
    Ok(NominalMachine {
        vibrates,
        kind: kind_result(limit_cycle(oscillator)?.kind()),
        steady_sliding_unstable: oscillator.sliding_is_unstable(),
        kick_m_per_s: smallest_kick(oscillator)?.map(|kick| kick * velocity_scale),
        limit_damping_ratio,
        damping_margin: oscillator.damping_ratio() - limit_damping_ratio,
    })
}
