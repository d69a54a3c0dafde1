//! The verdict: how probable vibration is over the uncertain values of a study, what decides it, and what changes it.

mod answers;
mod area;
mod assumed;
mod axis;
mod changed;
#[cfg(test)]
mod closed_forms;
mod cost;
mod decided;
mod drivers;
mod dynamics;
mod expansion;
mod fluctuating;
mod judge;
mod machines;
mod map;
mod margins;
mod plastic;
mod points;
mod probability;
mod remedies;
mod replicates;
mod responses;
pub(super) mod rests_on;
mod sampled;
mod scan;
mod sharing;
mod turning;
mod vibrating;

use self::assumed::Ends;
pub(super) use self::cost::cost;
use self::drivers::MarginModel;
use self::dynamics::Dynamics;
use self::fluctuating::HALF;
use self::judge::{Judge, is_negligible};
use self::machines::{Machine, Machines};
use self::points::ContactPoints;
use self::probability::{Estimator, Probability};
use self::responses::FrictionResponses;
use self::sampled::Sampled;
use self::scan::errors::ScanErrors;
use self::turning::{margins_between, turning_points};
use self::vibrating::{samples_table, vibrating_machines};
use crate::chaos::UncertainInput;
use crate::choice::Choice;
use crate::friction::WindowFriction;
use crate::monitor::Monitor;
use crate::stats::{Interval, quantile_sorted};
use crate::study::check::VerdictStudy;
use crate::study::output::StageOutput;
use crate::study::result::{
    ErrorCause, ErrorSource, MarginQuantile, NominalMachine, Pair, RestsOn, TurningPoint, VerdictResult,
};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{Study, StudyError, sentence};

/// Probabilities of the quantiles of the margin.
const MARGIN_PROBABILITIES: [f64; 7] = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];
/// Probabilities for which the event has drivers.
const EVENT_RANGE: std::ops::Range<f64> = 0.05..0.95;
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
    let contact = surface.filter(|_| window.computed);
    let contact =
        contact.map(|surface| Contact::new(whole, study, surface, window, monitor, &mut output)).transpose()?;
    let (study, responses, scan_error) = match &contact {
        Some(contact) => (&contact.study, contact.responses.as_ref(), contact.scan_error),
        None => (study, None, 0.0),
    };
    let machines = Machines::new(study, window, responses, seed);
    let nominal = unforced(&machines)?;
    let judge = Judge::new(study, window, &nominal, seed, monitor);
    output.assumptions.extend(judge.assumptions());
    let (threshold, fluctuates) = (study.threshold, judge.fluctuates());
    // The sample decides both events, all other machines the one of the study. A single machine has all trajectories.
    let levels = if machines.variables() == 0 { &[][..] } else { &[threshold, HALF][..] };
    let evaluate = |machine: &Machine, index: usize| judge.evaluate(machine, index, levels);
    let decide = |machine: &Machine, index: usize| judge.evaluate(machine, index, &[threshold]);
    let most = if machines.variables() == 0 { 1 } else { study.evaluations };
    let sampled = Sampled::until(&machines, &evaluate, study.half_width, most, monitor)?;
    let (failed, first_failure) = without_answer(&sampled, study.valid_fraction, &mut output)?;
    let estimator = Estimator {
        machines: &machines,
        sampled: &sampled,
        responses,
        scan_error,
        seed,
        monitor,
        evaluations: sampled.machines.len(),
        warnings: Vec::new(),
    };
    let probabilities = Probabilities::new(estimator, fluctuates, &mut output)?;
    let found = &probabilities.above_threshold;
    output.warnings.extend(wide(found, study.half_width));
    let vibrates = evaluate(&nominal, 0).map_err(StudyError::Verdict)?.vibrates;
    let (remedies, warnings) =
        remedies::remedies(&machines, study, (&decide, fluctuates), probabilities.friction_error, seed, monitor)?;
    output.warnings.extend(warnings);
    let rests_on = rests_on::rests_on(whole, study, window, fluctuates);
    let (probability, share, sampled) = (found, &probabilities.share, &sampled);
    let ends = Ends { study, machines: &machines, sampled, probability, share, evaluate: &evaluate, monitor };
    let (assumed, warnings) = ends.assumed(&rests_on)?;
    output.warnings.extend(warnings);
    let mut result = VerdictResult {
        model: nominal.dynamics.model(),
        vibration_threshold: threshold,
        friction_fluctuates: fluctuates,
        friction: responses.map(|responses| responses.result.clone()),
        failed_samples: failed,
        first_failure,
        duration_s: judge.duration_s,
        leaves_out_fluctuation: judge.friction_fluctuates && judge.is_coupled,
        nominal: NominalMachine {
            damping_margin_interval: margins_between(&machines, window.mean_errors.whole),
            ..nominal.dynamics.nominal(vibrates, &nominal.inputs.scales)?
        },
        if_vibrating: vibrating_machines(&machines, sampled, monitor)?,
        margin_quantiles: margin_quantiles(sampled),
        remedies,
        turning_points: turns(&machines, &nominal, vibrates, &rests_on)?,
        friction_unresolved: !window.mean_errors.unresolved.is_empty(),
        unresolved_by: window.mean_errors.unresolved.clone(),
        rests_on,
        assumed,
        ..probabilities.result()
    };
    output.tables.push((VERDICT_SAMPLES, samples_table(&machines, sampled, monitor)?));
    let population = Population { study, window, machines: &machines, nominal: &nominal, sampled, judge: &judge };
    population.explain(found, &mut result, &mut output)?;
    let friction = whole.friction.as_ref().filter(|_| window.computed);
    output.assumptions.extend(friction.and_then(|friction| plastic::plastic_sentence(friction, window)));
    result.assumptions.clone_from(&output.assumptions);
    Ok(Verdict { result, output })
}

/// Contact of a machine whose friction depends on uncertain values.
struct Contact {
    /// The study with the uncertain values that follow from the scans.
    study: VerdictStudy,
    responses: Option<FrictionResponses>,
    /// See [`Estimator::scan_error`].
    scan_error: f64,
}

impl Contact {
    /// Solves the contact at points of the uncertain values, and expands its friction in them.
    fn new(
        whole: &Study,
        study: &VerdictStudy,
        surface: &SurfaceStage,
        window: &WindowFriction,
        monitor: &dyn Monitor,
        output: &mut StageOutput,
    ) -> Result<Self, StudyError> {
        let (scan, mean_errors) = (ScanErrors::default(), &window.mean_errors);
        let mut points = ContactPoints { study: whole, surface, central: &study.central, scan, mean_errors, monitor };
        let in_mean = mean_errors.scan > 0.0 && scan::is_in_mean(whole, study);
        if study.scan_errors && !in_mean {
            points.scan = ScanErrors::new(&points, output)?;
        }
        let scan_error = if study.scan_errors && points.scan.inputs.is_empty() { mean_errors.scan } else { 0.0 };
        let mut latent: Vec<_> = points.scan.inputs.iter().map(|(place, input, _)| (*place, input.clone())).collect();
        let cut_off = if study.scan_errors { machines::cut_off(window) } else { Ok(None) };
        for other in [machines::between_parts(window), cut_off] {
            latent.extend(other.map_err(|error| StudyError::Verdict(error.to_string()))?);
        }
        let study = study.with_latent(latent);
        if let Some(place) = study.proportional.filter(|place| whole.varies(&place.name())) {
            output.assumptions.push(format!(
                "The friction coefficient is proportional to the {} (`{}`), whose effect needs no further solution.",
                place.key().label,
                place.name()
            ));
        }
        let responses = expansion::expand_friction(&points, &study, window, monitor, output)?;
        Ok(Self { study, responses, scan_error })
    }
}

/// Returns the turning points of a machine of exact values whose friction is resolved.
fn turns(
    machines: &Machines<'_>,
    nominal: &Machine,
    vibrates: bool,
    rests_on: &[RestsOn],
) -> Result<Vec<TurningPoint>, StudyError> {
    let resolved = machines.variables() == 0 && machines.mean_errors().unresolved.is_empty();
    // Where friction fluctuates, the margin of its mean may not decide.
    match resolved && vibrates == nominal.dynamics.margins()?.from_stick.is_sign_negative() {
        true => Ok(turning_points(machines, nominal, rests_on)?),
        false => Ok(Vec::new()),
    }
}

/// Returns the machine with all values at their centres, which must not be forced.
fn unforced(machines: &Machines<'_>) -> Result<Machine, StudyError> {
    let nominal = machines.nominal().map_err(StudyError::Verdict)?;
    match &nominal.dynamics {
        Dynamics::StickSlip(oscillator) if oscillator.forcing().is_some() => Err(StudyError::ForcedVerdict),
        _ => Ok(nominal),
    }
}

/// Probabilities of vibration.
struct Probabilities {
    above_threshold: Probability,
    /// Expected fraction of the time.
    share: Probability,
    half: Probability,
    /// `None` with fluctuation.
    from_steady_sliding: Option<Probability>,
    evaluations: usize,
    /// Relative standard error of the mean friction.
    friction_error: f64,
}

impl Probabilities {
    fn new(mut estimator: Estimator<'_>, fluctuates: bool, output: &mut StageOutput) -> Result<Self, StudyError> {
        let [above_threshold, share, half] = estimator.of_vibration(fluctuates)?;
        let from_steady_sliding = (!fluctuates).then(|| estimator.of_steady_sliding()).transpose()?;
        output.warnings.append(&mut estimator.warnings);
        let (evaluations, friction_error) = (estimator.evaluations, estimator.friction_error());
        Ok(Self { above_threshold, share, half, from_steady_sliding, evaluations, friction_error })
    }

    /// Returns a result with the probabilities alone.
    fn result(&self) -> VerdictResult {
        let (found, sliding) = (&self.above_threshold, self.from_steady_sliding.as_ref());
        VerdictResult {
            probability: found.value,
            probability_interval: pair(&found.interval),
            expected_vibration_share: self.share.value,
            expected_vibration_share_interval: pair(&self.share.interval),
            probability_half: self.half.value,
            probability_half_interval: pair(&self.half.interval),
            error_sources: error_sources(&found.sources),
            probability_from_steady_sliding: sliding.map(|sliding| sliding.value),
            probability_from_steady_sliding_interval: sliding.map(|sliding| pair(&sliding.interval)),
            evaluations: self.evaluations,
            ..VerdictResult::default()
        }
    }
}

/// Returns the number of sampled machines without an answer, and the reason of the first, with a warning.
///
/// # Errors
/// Less than a fraction `least` of the machines have an answer.
fn without_answer(
    sampled: &Sampled,
    least: f64,
    output: &mut StageOutput,
) -> Result<(usize, Option<String>), StudyError> {
    let (all, valid) = (sampled.machines.len(), sampled.valid().count());
    let first = sampled.machines.iter().find_map(|machine| machine.as_ref().err().cloned());
    let Some(reason) = &first else { return Ok((0, None)) };
    let failed = all - valid;
    if (valid as f64) < least * all as f64 {
        return Err(StudyError::Verdict(format!(
            "{failed} of {all} sampled machines have no answer; the first because {reason}"
        )));
    }
    let machines = sentence::count(failed, "sampled machine has", "sampled machines have");
    output.warnings.push(format!("{machines} no answer and are left out; the first because {reason}"));
    Ok((failed, first))
}

fn margin_quantiles(sampled: &Sampled) -> Vec<MarginQuantile> {
    let mut margins: Vec<f64> = sampled.valid().map(|machine| machine.margins.from_stick).collect();
    margins.sort_by(f64::total_cmp);
    let quantile = |probability| MarginQuantile { probability, damping_margin: quantile_sorted(&margins, probability) };
    MARGIN_PROBABILITIES.map(quantile).to_vec()
}

/// Machines of a verdict.
struct Population<'a> {
    study: &'a VerdictStudy,
    window: &'a WindowFriction,
    machines: &'a Machines<'a>,
    nominal: &'a Machine,
    sampled: &'a Sampled,
    judge: &'a Judge<'a>,
}

impl Population<'_> {
    /// Adds to the result how the probability depends on the duration, on the area that acts as one, on two remedies and on the uncertain
    /// values.
    fn explain(
        &self,
        found: &Probability,
        result: &mut VerdictResult,
        output: &mut StageOutput,
    ) -> Result<(), StudyError> {
        let &Self { study, window, machines, nominal, sampled, judge } = self;
        let (seed, monitor) = (judge.seed, judge.monitor);
        output.warnings.extend(judge.changes_later(machines, sampled, found.interval)?);
        let fluctuates = judge.one_window_fluctuates;
        if fluctuates || !is_negligible(window, window.between_parts_std) {
            let decide = |machine: &Machine, index: usize| judge.evaluate(machine, index, &[study.threshold]);
            result.area_as_one = area::area_as_one(machines, nominal, sampled, found, &decide, fluctuates, monitor)?;
            output.tables.extend(result.area_as_one.as_deref().map(area::table));
        }
        if let Some(map) = map::map(machines, study, judge.friction_fluctuates, seed, monitor)? {
            result.map = Some(map.result);
            output.warnings.extend(map.warning);
            output.tables.push(map.contours);
        }
        self.decompose(result, output)
    }

    /// Adds the drivers and the effects of unknown values.
    fn decompose(&self, result: &mut VerdictResult, output: &mut StageOutput) -> Result<(), StudyError> {
        let seed = self.judge.seed;
        // An exact probability is the same for all unknown values.
        if result.probability_interval[0] == result.probability_interval[1]
            && self.machines.inputs().inputs().iter().any(UncertainInput::is_unknown)
        {
            result.probability_range = Some(result.probability_interval);
        }
        if let Some(model) = MarginModel::new(self.machines, self.sampled, self.judge.fluctuates())? {
            result.drivers = model.margin_drivers(self.machines, seed)?;
            if EVENT_RANGE.contains(&result.probability) {
                result.event_drivers = model.event_drivers(self.machines, seed)?;
            }
            if let Some((quantiles, guesses)) = model.over_unknowns(self.machines, seed)? {
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
        Ok(())
    }
}

fn number(is_true: bool) -> f64 {
    f64::from(u8::from(is_true))
}

fn pair(interval: &Interval) -> Pair {
    [interval.low, interval.high]
}

/// Returns the parts of an interval; none of an exact probability.
fn error_sources(sources: &[(ErrorCause, f64)]) -> Vec<ErrorSource> {
    let stated = sources.iter().filter(|(_, half_width)| *half_width > 0.0);
    stated.map(|&(source, half_width)| ErrorSource { source, half_width }).collect()
}

/// Returns a warning if the interval of a probability is wider than was asked for.
fn wide(found: &Probability, half_width: f64) -> Option<String> {
    let Interval { low, high } = found.interval;
    let (cause, _) = found.sources.first().filter(|_| 0.5 * (high - low) > half_width)?;
    Some(format!(
        "the interval of the probability is wider than ± {} %, most of all because of {}; {}",
        sentence::digits(100.0 * half_width),
        cause.words(),
        cause.remedy()
    ))
}
