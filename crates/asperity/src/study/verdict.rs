//! The verdict: how probable vibration is over the uncertain values of a study, what decides it, and what changes it.

mod answers;
pub(super) mod area;
pub(super) mod assumed;
pub(super) mod axis;
mod changed;
#[cfg(test)]
mod closed_forms;
pub(super) mod decided;
mod drivers;
mod dynamics;
pub(super) mod expansion;
mod fluctuating;
mod machines;
pub(super) mod map;
pub(super) mod margins;
mod plastic;
pub(super) mod points;
mod probability;
pub(super) mod remedies;
pub(super) mod replicates;
mod responses;
pub(super) mod rests_on;
pub(super) mod sampled;
pub(super) mod scan;
mod sharing;
pub(super) mod vibrating;

use std::borrow::Cow;

use self::assumed::Ends;
use self::drivers::MarginModel;
use self::dynamics::Dynamics;
use self::fluctuating::{HALF, NEGLIGIBLE_STD, Wanted};
use self::machines::{Machine, Machines};
use self::points::ContactPoints;
use self::probability::{Estimator, Event, Probability};

use self::sampled::{Evaluated, Sampled};
use self::scan::errors::ScanErrors;
use self::vibrating::{samples_table, vibrating_machines};
use crate::chaos::UncertainInput;
use crate::friction::WindowFriction;
use crate::monitor::Monitor;
use crate::stats::{Interval, quantile_sorted};
use crate::study::output::StageOutput;
use crate::study::result::{ErrorSource, MarginQuantile, ModelResult, Pair, VerdictResult};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{Study, StudyError, sentence};

/// Probabilities of the quantiles of the margin.
const MARGIN_PROBABILITIES: [f64; 7] = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];
/// Probabilities for which the event has drivers.
const EVENT_RANGE: std::ops::Range<f64> = 0.05..0.95;
/// Factor of the duration after which the probability is computed again.
pub(super) const LATER: usize = 4;
/// Fraction of unexplained variance above which there is a warning.
const UNEXPLAINED: f64 = 0.05;

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
    let mut study = Cow::Borrowed(study);
    let (mut responses, mut scan_error) = (None, 0.0);
    if let Some(surface) = surface.filter(|_| window.computed) {
        let central = study.central.clone();
        let (scan, mean_errors) = (ScanErrors::default(), &window.mean_errors);
        let mut points = ContactPoints { study: whole, surface, central: &central, scan, mean_errors, monitor };
        if study.scan_errors {
            points.scan = ScanErrors::new(&points, &mut output)?;
        }
        scan_error = if study.scan_errors && points.scan.inputs.is_empty() { mean_errors.scan } else { 0.0 };
        let mut latent: Vec<_> = points.scan.inputs.iter().map(|(place, input, _)| (*place, input.clone())).collect();
        let cut_off = if study.scan_errors { machines::cut_off(window) } else { Ok(None) };
        for other in [machines::between_parts(window), cut_off] {
            latent.extend(other.map_err(|error| StudyError::Verdict(error.to_string()))?);
        }
        study = Cow::Owned(study.with_latent(latent));
        responses = expansion::expand_friction(&points, &study, window, monitor, &mut output)?;
    }
    let study = &*study;
    let machines = Machines::new(study, window, responses.as_ref(), seed);
    let nominal = machines.nominal().map_err(StudyError::Verdict)?;
    if let Dynamics::StickSlip(oscillator) = &nominal.dynamics
        && oscillator.forcing().is_some()
    {
        return Err(StudyError::ForcedVerdict);
    }
    let model = nominal.dynamics.model();
    let duration_s = study.duration_s.unwrap_or(nominal.study.duration * nominal.study.scales.time_s());
    let is_coupled = model == ModelResult::ModeCoupling;
    let is_negligible = |window: &WindowFriction, std: f64| std < NEGLIGIBLE_STD * window.mean;
    let upscaled_std = nominal.window.upscaled_std(nominal.study.upscaling);
    let friction_fluctuates = !is_negligible(&nominal.window, upscaled_std);
    let fluctuates = friction_fluctuates && !is_coupled;
    let one_window_fluctuates = !is_negligible(window, window.std) && !is_coupled;
    if is_coupled {
        output.assumptions.push(
            "The verdict on mode coupling counts a machine as vibrating if its steady sliding is unstable at the mean friction coefficient, \
             however its motion begins; the margin is μ_c − μ."
                .into(),
        );
        if friction_fluctuates {
            output.assumptions.push("The verdict on mode coupling leaves out the fluctuation of friction.".into());
        }
    }
    let threshold = study.threshold;
    let evaluate_until = |machine: &Machine, index: usize, wanted: Wanted<'_>| {
        let evaluated = Evaluated::constant_friction(machine)?;
        let found = fluctuating::fraction(machine, wanted, seed.wrapping_add(index as u64), monitor)?;
        Ok(found.map_or(evaluated, |fraction| evaluated.with_fraction(fraction, threshold)))
    };
    // The sample decides both events, all other machines the one of the study. A single machine has all trajectories.
    let levels = if machines.variables() == 0 { &[][..] } else { &[threshold, HALF][..] };
    let evaluate = |machine: &Machine, index: usize| evaluate_until(machine, index, Wanted { duration_s, levels });
    let decide =
        |machine: &Machine, index: usize| evaluate_until(machine, index, Wanted { duration_s, levels: &[threshold] });
    let most = if machines.variables() == 0 { 1 } else { study.evaluations };
    let sampled = Sampled::until(&machines, &evaluate, study.half_width, most, monitor)?;
    let valid = sampled.valid().count();
    let failed = sampled.machines.len() - valid;
    let first_failure = sampled.machines.iter().find_map(|machine| machine.as_ref().err().cloned());
    if (valid as f64) < study.valid_fraction * sampled.machines.len() as f64 {
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
    let mut estimator = Estimator {
        machines: &machines,
        sampled: &sampled,
        responses: responses.as_ref(),
        scan_error,
        seed,
        monitor,
        evaluations: sampled.machines.len(),
        warnings: Vec::new(),
    };
    let from_stick = |value| Event { value, margin: |margins| margins.from_stick, by_margin: !fluctuates };
    let found = estimator.probability(&from_stick(|machine| number(machine.vibrates)))?;
    let (share, half, sliding) = if fluctuates {
        let share = estimator.probability(&from_stick(|machine| machine.fraction))?;
        let half = estimator.probability(&from_stick(|machine| number(machine.fraction >= HALF)))?;
        (share, half, None)
    } else {
        let sliding = estimator.probability(&Event {
            value: |machine| number(machine.margins.from_steady_sliding < 0.0),
            margin: |margins| margins.from_steady_sliding,
            by_margin: true,
        })?;
        (found.clone(), found.clone(), Some(sliding))
    };
    let Probability { value: probability, interval, sources } = &found;
    let (evaluations, friction_error) = (estimator.evaluations, estimator.friction_error());
    output.warnings.append(&mut estimator.warnings);
    if let Some((source, _)) = sources.first().filter(|_| 0.5 * (interval.high - interval.low) > study.half_width) {
        output.warnings.push(limit(source, study.half_width));
    }
    let mut margins: Vec<f64> = sampled.valid().map(|machine| machine.margins.from_stick).collect();
    margins.sort_by(f64::total_cmp);
    let margin_quantiles = MARGIN_PROBABILITIES
        .map(|probability| MarginQuantile { probability, damping_margin: quantile_sorted(&margins, probability) });
    let vibrates = evaluate(&nominal, 0).map_err(StudyError::Verdict)?.vibrates;
    let (remedies, warnings) =
        remedies::remedies(&machines, study, (&decide, fluctuates), friction_error, seed, monitor)?;
    output.warnings.extend(warnings);
    let rests_on = rests_on::rests_on(whole, study, window, fluctuates);
    let ends = Ends {
        study,
        machines: &machines,
        sampled: &sampled,
        probability: &found,
        share: &share,
        evaluate: &evaluate,
        monitor,
    };
    let (assumed, warnings) = ends.assumed(&rests_on)?;
    output.warnings.extend(warnings);
    let mut result = VerdictResult {
        model,
        vibration_threshold: threshold,
        friction_fluctuates: fluctuates,
        probability: *probability,
        probability_interval: pair(interval),
        expected_vibration_share: share.value,
        expected_vibration_share_interval: pair(&share.interval),
        probability_half: half.value,
        probability_half_interval: pair(&half.interval),
        error_sources: error_sources(sources),
        friction: responses.as_ref().map(|responses| responses.result.clone()),
        probability_from_steady_sliding: sliding.as_ref().map(|sliding| sliding.value),
        probability_from_steady_sliding_interval: sliding.as_ref().map(|sliding| pair(&sliding.interval)),
        evaluations,
        failed_samples: failed,
        first_failure,
        duration_s,
        leaves_out_fluctuation: friction_fluctuates && is_coupled,
        nominal: nominal.dynamics.nominal(vibrates, &nominal.study.scales)?,
        if_vibrating: vibrating_machines(&machines, &sampled, monitor)?,
        margin_quantiles: margin_quantiles.to_vec(),
        remedies,
        friction_unresolved: !window.mean_errors.resolved,
        rests_on,
        assumed,
        ..VerdictResult::default()
    };
    output.tables.push((VERDICT_SAMPLES, samples_table(&machines, &sampled, monitor)?));
    if fluctuates {
        let later = sampled.later(
            &machines,
            &|machine, index| {
                let wanted = Wanted { duration_s: LATER as f64 * duration_s, levels: &[threshold] };
                Ok(evaluate_until(machine, index, wanted)?.vibrates)
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
    if one_window_fluctuates || !is_negligible(window, window.between_parts_std) {
        result.area_as_one =
            area::area_as_one(&machines, &nominal, &sampled, &found, &decide, one_window_fluctuates, monitor)?;
        output.tables.extend(result.area_as_one.as_deref().map(area::table));
    }
    if let Some(map) = map::map(&machines, study, friction_fluctuates, seed, monitor)? {
        result.map = Some(map.result);
        output.warnings.extend(map.warning);
        output.tables.push(map.contours);
    }
    // An exact probability is the same for all unknown values.
    if interval.low == interval.high && machines.inputs().inputs().iter().any(UncertainInput::is_unknown) {
        result.probability_range = Some(pair(interval));
    }
    if let Some(model) = MarginModel::new(&machines, &sampled, fluctuates)? {
        result.drivers = model.margin_drivers(&machines, seed)?;
        if EVENT_RANGE.contains(probability) {
            result.event_drivers = model.event_drivers(&machines, seed)?;
        }
        if let Some((quantiles, guesses)) = model.over_unknowns(&machines, seed)? {
            result.probability_range = Some([quantiles.q05, quantiles.q95]);
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
    let friction = whole.friction.as_ref().filter(|_| window.computed);
    output.assumptions.extend(friction.and_then(|friction| plastic::plastic_sentence(friction, window)));
    result.assumptions.clone_from(&output.assumptions);
    Ok(Verdict { result, output })
}

fn number(is_true: bool) -> f64 {
    f64::from(u8::from(is_true))
}

fn pair(interval: &Interval) -> Pair {
    [interval.low, interval.high]
}

/// Returns the parts of an interval; none of an exact probability.
fn error_sources(sources: &[(&str, f64)]) -> Vec<ErrorSource> {
    let stated = sources.iter().filter(|(_, half_width)| *half_width > 0.0);
    stated.map(|&(source, half_width)| ErrorSource { source: source.into(), half_width }).collect()
}

/// Returns a warning which says what keeps the interval wider than was asked for.
fn limit(source: &str, half_width: f64) -> String {
    let (cause, remedy) = match source {
        "machines" => ("the number of machines", "raise `evaluations` in [verdict]"),
        "strips" => ("the number of strips", "raise `realisations` in [friction]"),
        "scan" => ("the size of the scan", "take a larger one"),
        "grid" => ("the pitch of the strips", "raise `points` in [friction]"),
        "model" => {
            ("the difference between random strips and scan", "take a larger scan, or remove more form (`level`)")
        }
        _ => {
            ("the expansion of friction in the uncertain values", "state narrower distributions or ranges of remedies")
        }
    };
    format!(
        "the interval of the probability is wider than ± {} %, most of all because of {cause}; {remedy}",
        sentence::digits(100.0 * half_width)
    )
}

#[cfg(test)]
mod tests {
    use super::limit;

    #[test]
    fn a_wide_interval_names_the_key_that_narrows_it() {
        for (source, remedy) in [
            ("machines", "raise `evaluations` in [verdict]"),
            ("strips", "raise `realisations` in [friction]"),
            ("scan", "take a larger one"),
            ("grid", "raise `points` in [friction]"),
            ("model", "take a larger scan"),
            ("expansion", "state narrower distributions"),
        ] {
            let warning = limit(source, 0.02);
            assert!(warning.contains("wider than ± 2 %") && warning.contains(remedy), "{warning}");
        }
    }
}
