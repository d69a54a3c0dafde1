//! Probability that a machine vibrates, with its interval.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::dynamics::Margins;
use super::fluctuating::HALF;
use super::machines::{Machines, NoAnswer};
use super::number;
use super::replicates::Mean;
use super::responses::FrictionResponses;
use super::sampled::{Evaluated, Sampled};
use crate::chaos::rare::{RareError, Settings, SmallProbability, small_probability};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::{Interval, NORMAL_95};
use crate::study::StudyError;
use crate::study::result::ErrorCause;

/// Smallest number of machines on each side below which the probability is computed as a small one.
const FEW: f64 = 40.0;
/// Relative difference of margins that rounding and the search for a limit may leave.
const ROUNDING: f64 = 1e-9;

/// Event that a machine vibrates, or the fraction of the time in which it does.
pub(super) struct Event {
    /// 1 if the event occurs and 0 if it does not, or the fraction.
    pub(super) value: fn(&Evaluated) -> f64,
    pub(super) margin: fn(&Margins) -> f64,
    /// Whether the sign of the margin decides.
    pub(super) by_margin: bool,
}

/// Probability with its 95 % interval, and how far it would reach from the probability with each cause alone.
#[derive(Debug, Clone)]
pub(super) struct Probability {
    pub(super) value: f64,
    pub(super) interval: Interval,
    pub(super) sources: Vec<(ErrorCause, f64)>,
}

/// Probabilities over the sampled machines.
pub(super) struct Estimator<'a> {
    pub(super) machines: &'a Machines<'a>,
    pub(super) sampled: &'a Sampled,
    pub(super) responses: Option<&'a FrictionResponses>,
    /// Relative standard error of the mean friction by the limited scan, unless it is among the uncertain values.
    pub(super) scan_error: f64,
    pub(super) seed: u64,
    pub(super) monitor: &'a dyn Monitor,
    /// Number of machines that were evaluated for small probabilities.
    pub(super) evaluations: usize,
    pub(super) warnings: Vec<String>,
}

impl Estimator<'_> {
    /// Estimates the probabilities that a machine which begins in stick vibrates for more than the threshold, its expected fraction of the time,
    /// and the probability of half of the time. Without fluctuation all are equal.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub(super) fn of_vibration(&mut self, fluctuates: bool) -> Result<[Probability; 3], StudyError> {
        let from_stick = |value| Event { value, margin: |margins| margins.from_stick, by_margin: !fluctuates };
        let found = self.probability(&from_stick(|machine| number(machine.vibrates)))?;
        if !fluctuates {
            return Ok([found.clone(), found.clone(), found]);
        }
        let share = self.probability(&from_stick(|machine| machine.fraction))?;
        let half = self.probability(&from_stick(|machine| number(machine.fraction >= HALF)))?;
        Ok([found, share, half])
    }

    /// Estimates the probability that a machine which slides steadily at first vibrates; its friction does not fluctuate.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub(super) fn of_steady_sliding(&mut self) -> Result<Probability, StudyError> {
        self.probability(&Event {
            value: |machine| number(machine.margins.from_steady_sliding < 0.0),
            margin: |margins| margins.from_steady_sliding,
            by_margin: true,
        })
    }

    /// Estimates the probability of an event. A small one, or the complement of one that is almost certain, comes from subset
    /// simulation.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub(super) fn probability(&mut self, event: &Event) -> Result<Probability, StudyError> {
        let mean = self.sampled.mean(event.value);
        let (value, mut interval, small) = if self.machines.variables() == 0 {
            // The fraction of the time of one machine has the error of its trajectories; an event has none.
            let error = self.sampled.valid().map(|machine| machine.fraction_se).fold(0.0, f64::max);
            let half_width = if mean.value.fract() == 0.0 { 0.0 } else { NORMAL_95 * error };
            (mean.value, Mean { half_width, ..mean }.interval(), None)
        } else if event.by_margin && self.is_constant(event) {
            (mean.value, Interval { low: mean.value, high: mean.value }, None)
        } else {
            let all = self.sampled.valid().count() as f64;
            let is_complement = mean.value >= 0.5;
            let few = mean.value.min(1.0 - mean.value) * all < FEW && event.by_margin;
            let small = if few { self.small(event, is_complement)? } else { None };
            let (value, interval) = match &small {
                Some(small) => (small.found.probability, small.found.interval),
                None => (mean.value, mean.interval()),
            };
            (value, interval, small)
        };
        let of_machines = (interval.high - value).max(value - interval.low);
        let mut sources = if of_machines > 0.0 { vec![(ErrorCause::Machines, of_machines)] } else { Vec::new() };
        for (cause, error) in self.independent_errors() {
            // A bound holds for any friction near this one.
            if small.is_some() && value == 0.0 {
                continue;
            }
            let mut shifted = [value; 2];
            for (shifted, sign) in shifted.iter_mut().zip([-1.0, 1.0]) {
                *shifted = self.shifted(event, value, small.as_ref(), (sign * NORMAL_95 * error).exp())?;
            }
            sources.push((cause, farthest(value, shifted)));
            interval = widened(interval, value, shifted, small.is_some());
        }
        for (cause, factors) in self.machines.mean_errors().computational() {
            if factors == [1.0; 2] {
                continue;
            }
            let mut shifted = [value; 2];
            for (shifted, factor) in shifted.iter_mut().zip(factors).filter(|(_, factor)| *factor != 1.0) {
                *shifted = self.shifted(event, value, small.as_ref(), factor)?;
            }
            sources.push((cause, farthest(value, shifted)));
            interval = extended(interval, value, shifted, small.is_some());
        }
        if self.machines.variables() == 0 && event.by_margin {
            // The errors of one machine decide together.
            let [low, high] = self.machines.mean_errors().whole;
            let shifted = [self.shifted(event, value, None, low)?, self.shifted(event, value, None, high)?];
            interval = extended(interval, value, shifted, false);
        }
        sources.sort_by(|a, b| b.1.total_cmp(&a.1));
        if small.is_some_and(|small| small.is_complement) {
            let interval = Interval { low: 1.0 - interval.high, high: 1.0 - interval.low };
            return Ok(Probability { value: 1.0 - value, interval, sources });
        }
        Ok(Probability { value, interval, sources })
    }

    /// Returns the causes and relative standard errors of the mean friction that are independent of each other.
    fn independent_errors(&self) -> Vec<(ErrorCause, f64)> {
        let own = self.machines.mean_errors();
        let [strips, expansion] =
            self.responses.map_or([own.strips, 0.0], |found| [found.strips_error, found.expansion_error]);
        let strips = strips.hypot(own.halved_strips);
        let mut errors =
            vec![(ErrorCause::Strips, strips), (ErrorCause::Expansion, expansion), (ErrorCause::Scan, self.scan_error)];
        errors.retain(|(_, error)| *error > 0.0);
        errors
    }

    /// Returns the probability of an event with another friction of all machines; of its complement, if that is small.
    fn shifted(&mut self, event: &Event, value: f64, small: Option<&Small>, factor: f64) -> Result<f64, StudyError> {
        let machines = self.machines.with_friction_factor(factor);
        let Some(Small { found, is_complement }) = small else {
            return Ok(value + self.sampled.change(&machines, event.margin, self.monitor)?);
        };
        let margin = LimitState::new(&machines, event, *is_complement);
        let shifted = found.of_other(&|variables| margin.at(variables), self.monitor);
        self.evaluations += margin.evaluations.into_inner();
        Ok(self.answered(shifted)?.unwrap_or(value))
    }

    /// Returns the relative standard error of the mean friction.
    pub(super) fn friction_error(&self) -> f64 {
        self.independent_errors().into_iter().fold(0.0, |all, (_, error)| all.hypot(error))
    }

    /// Returns whether no value changes the margin, up to rounding.
    fn is_constant(&self, event: &Event) -> bool {
        let margins = self.sampled.valid().map(|machine| (event.margin)(&machine.margins));
        let [low, high] =
            margins.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], margin| [low.min(margin), high.max(margin)]);
        high - low <= ROUNDING * low.abs().min(high.abs())
    }

    /// Returns the small probability of an event, or of its complement; `None` with a warning if there is no estimate.
    fn small(&mut self, event: &Event, is_complement: bool) -> Result<Option<Small>, StudyError> {
        let (margin, settings) = (LimitState::new(self.machines, event, is_complement), Settings::new(self.seed));
        let found =
            small_probability(self.machines.variables(), &|variables| margin.at(variables), &settings, self.monitor);
        self.evaluations += margin.evaluations.into_inner();
        Ok(self.answered(found)?.map(|found| Small { found, is_complement }))
    }

    /// Returns the answer of an estimator, or `None` with a warning if there is none.
    fn answered<T>(&mut self, found: Result<T, RareError<NoAnswer>>) -> Result<Option<T>, Cancelled> {
        match found {
            Ok(found) => Ok(Some(found)),
            Err(RareError::Cancelled) => Err(Cancelled),
            Err(error) => {
                // Both probabilities, and each shift of friction, may fail for one reason.
                let warning = format!("the interval of the small probability is wide: {error}");
                if !self.warnings.contains(&warning) {
                    self.warnings.push(warning);
                }
                Ok(None)
            }
        }
    }
}

/// Small probability of an event, or of its complement.
struct Small {
    found: SmallProbability,
    is_complement: bool,
}

/// Margin of machines, which is negative where the event, or its complement, occurs.
struct LimitState<'a> {
    machines: &'a Machines<'a>,
    margin: fn(&Margins) -> f64,
    sign: f64,
    evaluations: AtomicUsize,
}

impl<'a> LimitState<'a> {
    fn new(machines: &'a Machines<'a>, event: &Event, is_complement: bool) -> Self {
        let sign = if is_complement { -1.0 } else { 1.0 };
        Self { machines, margin: event.margin, sign, evaluations: AtomicUsize::new(0) }
    }

    fn at(&self, variables: &[f64]) -> Result<f64, NoAnswer> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let machine = self.machines.at(variables).and_then(|machine| Evaluated::constant_friction(&machine));
        machine.map(|machine| self.sign * (self.margin)(&machine.margins)).map_err(NoAnswer)
    }
}

/// Returns the distance from a probability to the farther of two others.
fn farthest(probability: f64, others: [f64; 2]) -> f64 {
    others.map(|other| (other - probability).abs()).into_iter().fold(0.0, f64::max)
}

/// Returns the interval of a probability extended by a bias of the friction, given the probabilities at both ends of the bias. A bias of
/// a small probability is relative.
fn extended(interval: Interval, probability: f64, shifted: [f64; 2], is_small: bool) -> Interval {
    let [least, most] = [shifted[0].min(shifted[1]).min(probability), shifted[0].max(shifted[1]).max(probability)];
    let Interval { low, high } = interval;
    if is_small && probability > 0.0 {
        return Interval { low: low * (least / probability), high: (high * (most / probability)).min(1.0) };
    }
    Interval { low: (low - (probability - least)).max(0.0), high: (high + (most - probability)).min(1.0) }
}

/// Returns the interval of a probability with the error of the friction, given the probabilities at both ends of the interval of
/// friction. Both errors are independent; those of small probabilities are relative.
fn widened(interval: Interval, probability: f64, shifted: [f64; 2], is_small: bool) -> Interval {
    let [least, most] = [shifted[0].min(shifted[1]), shifted[0].max(shifted[1])];
    if is_small && probability > 0.0 && least > 0.0 && interval.low > 0.0 {
        let distance = |end: f64| (end / probability).ln();
        let below = distance(interval.low).hypot(distance(least).min(0.0));
        let above = distance(interval.high).hypot(distance(most).max(0.0));
        return Interval { low: probability * (-below).exp(), high: (probability * above.exp()).min(1.0) };
    }
    let below = (probability - interval.low).hypot((probability - least).max(0.0));
    let above = (interval.high - probability).hypot((most - probability).max(0.0));
    Interval { low: (probability - below).max(0.0), high: (probability + above).min(1.0) }
}

#[cfg(test)]
mod tests {
    use super::super::machines::tests::{LINEAR, constant, stated, stated_window};
    use super::super::responses::tests::of_powers;
    use super::*;
    use crate::distribution::{Marginal, standard_normal_cdf};
    use crate::friction::{MeanErrors, StatedFriction, WindowFriction};
    use crate::monitor::Silent;
    use crate::study::Study;

    const EVENT: Event = Event { value: |m| m.fraction, margin: |m| m.from_stick, by_margin: true };

    fn estimator<'a>(
        machines: &'a Machines<'a>,
        sampled: &'a Sampled,
        responses: Option<&'a FrictionResponses>,
    ) -> Estimator<'a> {
        let (evaluations, warnings) = (0, Vec::new());
        Estimator { machines, sampled, responses, scan_error: 0.0, seed: 1, monitor: &Silent, evaluations, warnings }
    }

    #[test]
    fn a_margin_that_no_value_changes_gives_an_exact_probability() {
        // Friction is stated and does not fluctuate, so the nominal area has no effect. The limit of the damping ratio is b/2.
        for (damping, wanted) in [("0.049", 1.0), ("0.051", 0.0)] {
            let text = LINEAR.replace("833 mm^2", "833 ± 20 mm^2").replace("\"0.1 ± 0.02\"", "0.1");
            let (study, window) = stated(&text.replace("\"0.055 ± 0.005\"", damping));
            let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
            let sampled = Sampled::until(&machines, &constant, 0.02, 64, &Silent).unwrap();
            let mut estimator = estimator(&machines, &sampled, None);
            let found = estimator.probability(&EVENT).unwrap();
            assert_eq!((found.value, found.interval), (wanted, Interval { low: wanted, high: wanted }));
            assert_eq!((estimator.evaluations, found.sources.len()), (0, 0));
        }
    }

    #[test]
    fn a_bias_extends_the_interval_to_its_side() {
        let close = |found: Interval, [low, high]: [f64; 2]| {
            assert!((found.low - low).abs() < 1e-12 && (found.high - high).abs() < 1e-12, "{found:?}");
        };
        let interval = Interval { low: 0.47, high: 0.53 };
        close(extended(interval, 0.5, [0.5, 0.7], false), [0.47, 0.73]);
        close(extended(interval, 0.5, [0.9, 0.4], false), [0.37, 0.93]);
        close(extended(Interval { low: 0.8e-5, high: 1.25e-5 }, 1e-5, [1e-5, 3e-5], true), [0.8e-5, 3.75e-5]);
        // A bound, after which the friction of the other end makes the event almost certain.
        close(extended(Interval { low: 0.0, high: 1e-4 }, 0.0, [0.0, 0.99], true), [0.0, 0.9901]);
    }

    #[test]
    fn an_exact_machine_is_undecided_within_the_whole_error_of_its_friction() {
        // It vibrates if its friction exceeds 0.2.
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.2229535019025\n\
                    normal_force = \"2.5 kN\"\nnominal_area = \"64 mm^2\"\ndimensionless_belt_velocity = 0.1\nstribeck = 4.2\n\
                    static_friction = 0.19\nfriction_std = 0\n";
        for (whole, wanted) in [([0.9, 1.04], [0.0; 2]), ([0.9, 1.06], [0.0, 1.0])] {
            let (study, mut window) = stated(text);
            window.mean_errors.whole = whole;
            let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
            let sampled = Sampled::until(&machines, &constant, 0.02, 1, &Silent).unwrap();
            let Interval { low, high } = estimator(&machines, &sampled, None).probability(&EVENT).unwrap().interval;
            assert_eq!([low, high], wanted, "{whole:?}");
        }
    }

    #[test]
    #[ignore = "slow"]
    fn a_common_error_of_friction_shifts_all_machines() {
        // A machine vibrates if its friction exceeds 0.2, at which ζ is its limit; an error multiplies the friction of all machines.
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.2229535019025\n\
                    normal_force = \"2.5 kN\"\nnominal_area = \"64 mm^2\"\ndimensionless_belt_velocity = 0.1\nstribeck = 4.2\n\
                    static_friction = \"0.19 ± 0.01\"\nfriction_std = 0\n";
        let study = Study::parse(text, "study.toml").unwrap();
        let errors =
            MeanErrors { halved_strips: 0.002, grid: [1.0, 1.04], model: [0.97, 1.0], ..MeanErrors::default() };
        let window = WindowFriction { mean_errors: errors, ..stated_window(&study) };
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let sampled = Sampled::until(&machines, &constant, 0.02, 4096, &Silent).unwrap();
        let estimator = |scan_error| Estimator { scan_error, ..estimator(&machines, &sampled, None) };
        let Probability { value, interval, sources } = estimator(0.0).probability(&EVENT).unwrap();
        // The limit is reached at μ = 0.2: P[μ f > 0.2].
        let at = |factor: f64| standard_normal_cdf((0.19 - 0.2 / factor) / 0.01);
        let [less, central, more] = [0.97, 1.0, 1.04].map(at);
        assert!((value - central).abs() < 0.01, "{value} instead of {central}");
        assert!(
            (interval.low - less).abs() < 0.03 && (interval.high - more).abs() < 0.03,
            "{interval:?}: {less} {more}"
        );
        for (cause, wanted) in [(ErrorCause::Grid, more - central), (ErrorCause::Model, central - less)] {
            let own = sources.iter().find(|(source, _)| *source == cause).unwrap().1;
            assert!((own - wanted).abs() < 0.01, "{cause}: {own} instead of {wanted}");
        }
        let wider = estimator(0.01).probability(&EVENT).unwrap();
        for (cause, error) in [(ErrorCause::Strips, 0.002), (ErrorCause::Scan, 0.01)] {
            let [less, more] = [-error, error].map(|error: f64| at((NORMAL_95 * error).exp()));
            let own = wider.sources.iter().find(|(source, _)| *source == cause).unwrap().1;
            assert!((own - farthest(central, [less, more])).abs() < 0.01, "{cause}: {own}");
        }
        assert!(wider.interval.high > interval.high + 0.02, "{:?} {interval:?}", wider.interval);
    }

    #[test]
    fn errors_of_a_small_probability_are_relative() {
        let interval = Interval { low: 0.8e-5, high: 1.25e-5 };
        // Friction alone gives a factor of 2: ln² 2 and ln² 1.25 add up.
        let found = widened(interval, 1e-5, [2e-5, 0.5e-5], true);
        let factor = 2.0_f64.ln().hypot(1.25_f64.ln()).exp();
        assert!((found.high / (1e-5 * factor) - 1.0).abs() < 1e-12 && (found.low * factor / 1e-5 - 1.0).abs() < 1e-12);
        let found = widened(Interval { low: 0.47, high: 0.53 }, 0.5, [0.54, 0.46], false);
        assert!((found.low - 0.45).abs() < 1e-12 && (found.high - 0.55).abs() < 1e-12);
    }

    #[test]
    #[ignore = "slow"]
    fn errors_of_friction_count_with_the_change_of_the_probability() {
        // A machine vibrates if μ > 0.2, the friction at which ζ is its limit. μ = 0.2 E/(385 GPa) with a normal modulus E; an error of
        // 1.96·2 % multiplies it, which moves the limit of τ.
        let factor = (0.02 * NORMAL_95).exp();
        for (central, std) in [(385.0, 30.0), (300.0, 20.0), (470.0, 20.0)] {
            let text = "seed = 1\n[surface]\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"\ncovariance = \"exponential\"\n\
                        marginal = \"normal\"\n[material]\nyoungs_modulus = \"MODULUS GPa\"\nshear_strength = \"385 MPa\"\n[friction]\n\
                        [vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.2229535019025\n\
                        normal_force = \"2.5 kN\"\nnominal_area = \"64 mm^2\"\ndimensionless_belt_velocity = 0.1\nstribeck = 4.2\n";
            let text = text.replace("MODULUS", &format!("{central} ± {std}"));
            let study = Study::parse(&text, "study.toml").unwrap();
            let mut responses = of_powers(&study);
            (responses.strips_error, responses.expansion_error) = (0.02, 0.0);
            let stated = StatedFriction {
                mean: 0.2 * central / 385.0,
                std: 0.0,
                length_m: 1e-3,
                marginal: Marginal::STANDARD_NORMAL,
                window_m: [1e-3; 2],
            };
            let window = WindowFriction { computed: true, ..WindowFriction::from_statement(stated, 64e-6, Some(4.2)) };
            let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, Some(&responses), 1);
            let sampled = Sampled::until(&machines, &constant, 0.02, 4096, &Silent).unwrap();
            let mut estimator = estimator(&machines, &sampled, Some(&responses));
            let Probability { value, interval, sources } = estimator.probability(&EVENT).unwrap();
            let at = |factor: f64| standard_normal_cdf((central - 385.0 / factor) / std);
            let [least, wanted, most] = [at(1.0 / factor), at(1.0), at(factor)];
            let is_small = wanted.min(1.0 - wanted) < 0.01;
            // A small probability has a coefficient of variation of 0.1, and the effects of the errors follow it.
            let tolerance = if is_small { 0.25 * wanted.min(1.0 - wanted) } else { 0.01 };
            assert!((value - wanted).abs() < tolerance, "{value} instead of {wanted}");
            let ratio = match is_small {
                true if wanted > 0.9 => (1.0 - value) / (1.0 - wanted),
                true => value / wanted,
                false => 1.0,
            };
            let own = sources.iter().find(|(source, _)| *source == ErrorCause::Strips).unwrap().1;
            let reach = ratio * farthest(wanted, [least, most]);
            assert!((own / reach - 1.0).abs() < if is_small { 0.3 } else { 0.15 }, "{own} instead of {reach}");
            assert!(sources.iter().all(|(source, _)| *source != ErrorCause::Expansion), "{sources:?}");
            assert!(sources.is_sorted_by(|a, b| a.1 >= b.1), "{sources:?}");
            // The errors of the machines widen the interval little.
            for (end, wanted) in [(interval.low, least), (interval.high, most)] {
                let [end, wanted] = if wanted > 0.9 { [1.0 - end, 1.0 - wanted] } else { [end, wanted] };
                // The fewer samples are left at an end, the larger is its error.
                let tolerance = if is_small { 0.25 + 0.1 * (end / value.min(1.0 - value)).ln().abs() } else { 0.06 };
                assert!((end / (ratio * wanted)).ln().abs() < tolerance, "{end} instead of {wanted}");
            }
            assert_eq!(estimator.evaluations > 0, is_small);
            assert!(estimator.warnings.is_empty(), "{:?}", estimator.warnings);
        }
    }
}
