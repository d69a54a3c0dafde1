//! Evaluated machines, and the probability that one vibrates.

use asperity_base::blocks::Task;
use serde::{Deserialize, Serialize};

use super::dynamics::Margins;
use super::machines::{Machine, Machines};
use super::replicates::Mean;
use crate::monitor::{Cancelled, Monitor};
use crate::stats::{Interval, NORMAL_95};
use crate::vibration::Count;

/// Number of machines of the first round; each further round doubles the number.
const FIRST_ROUND: usize = 2048;

/// Largest number of machines that are followed for a longer time.
pub(super) const LATER: usize = 256;
/// Largest number of machines that are evaluated with another friction.
const SHIFTED: usize = 4096;

/// Evaluated machine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Evaluated {
    pub(super) margins: Margins,
    /// Fraction φ of the second half of the duration in vibration if its motion begins in stick, the mean over realisations of friction; 0 or 1
    /// without fluctuation.
    pub(super) fraction: f64,
    /// Standard error of φ.
    pub(super) fraction_se: f64,
    /// Whether φ is above the threshold of the study.
    pub(super) vibrates: bool,
}

impl Evaluated {
    /// Returns the same machine with the fraction φ under fluctuating friction.
    pub(super) fn with_fraction(self, fraction: Count, threshold: f64) -> Self {
        Self { fraction: fraction.mean, fraction_se: fraction.se, vibrates: fraction.mean > threshold, ..self }
    }

    /// Returns the machine's answer without fluctuation of friction.
    pub(super) fn constant_friction(machine: &Machine) -> Result<Self, String> {
        let margins = machine.dynamics.margins().map_err(|error| error.to_string())?;
        let vibrates = margins.from_stick < 0.0;
        Ok(Self { margins, fraction: f64::from(u8::from(vibrates)), fraction_se: 0.0, vibrates })
    }
}

/// Evaluates a machine, given its index in the sample.
pub(super) type Evaluate<'a> = dyn Fn(&Machine, usize) -> Result<Evaluated, String> + Sync + 'a;

/// Returns the number of machines after the round that begins with number `from`.
fn end_of_round(from: usize, most: usize) -> usize {
    FIRST_ROUND.max(2 * from).min(most)
}

/// Returns the largest number of machines that the interval of a probability may need.
pub(super) fn largest_number(half_width: f64, most: usize) -> usize {
    let widest = (0.5 * NORMAL_95 / half_width).powi(2);
    let mut number = end_of_round(0, most);
    while number < most && (number as f64) < widest {
        number = end_of_round(number, most);
    }
    number
}

/// Returns whether `all` independent machines have the half width for every probability in an interval. If the width of the interval
/// decided, sampling would stop more often where it is too narrow by chance, and too few intervals would cover the probability.
fn is_narrow(interval: Interval, all: usize, half_width: f64) -> bool {
    let widest = 0.5_f64.clamp(interval.low, interval.high);
    NORMAL_95 * (widest * (1.0 - widest) / all as f64).sqrt() <= half_width
}

/// Evaluated samples in their order.
#[derive(Debug, Clone, Default)]
pub(super) struct Sampled {
    pub(super) machines: Vec<Result<Evaluated, String>>,
}

impl Sampled {
    /// Evaluates machines until the interval of the probability is narrow enough.
    pub(super) fn until(
        machines: &Machines<'_>,
        evaluate: &Evaluate<'_>,
        half_width: f64,
        most: usize,
        monitor: &dyn Monitor,
    ) -> Result<Self, Cancelled> {
        let mut sampled = Self::default();
        while sampled.machines.len() < most {
            let from = sampled.machines.len();
            let to = end_of_round(from, most);
            let task = Task::new(monitor, "verdict", to - from);
            sampled.machines.extend(task.try_map(to - from, |place| {
                let index = from + place;
                Ok::<_, Cancelled>(
                    machines.at(&machines.variables_of(index)).and_then(|machine| evaluate(&machine, index)),
                )
            })?);
            if is_narrow(sampled.probability().interval(), to, half_width) {
                break;
            }
        }
        Ok(sampled)
    }

    /// Returns the change of the fraction of machines with a negative margin if the same samples have another friction, which does not
    /// fluctuate.
    pub(super) fn change(
        &self,
        machines: &Machines<'_>,
        margin: fn(&Margins) -> f64,
        monitor: &dyn Monitor,
    ) -> Result<f64, Cancelled> {
        let count = self.machines.len().min(SHIFTED);
        let task = Task::new(monitor, "verdict: friction error", count);
        let vibrates = task.map(count, |index| {
            let machine = machines.at(&machines.variables_of(index));
            let evaluated = machine.and_then(|machine| Evaluated::constant_friction(&machine));
            Ok::<bool, Cancelled>(evaluated.is_ok_and(|machine| margin(&machine.margins) < 0.0))
        })?;
        let after = vibrates.into_iter().filter(|vibrates| *vibrates).count();
        let before = self.machines[..count].iter().flatten().filter(|machine| margin(&machine.margins) < 0.0).count();
        Ok((after as f64 - before as f64) / count as f64)
    }

    /// Returns the fraction of vibrating machines after a longer time: the difference over the first samples is added to the
    /// probability.
    pub(super) fn later(
        &self,
        machines: &Machines<'_>,
        vibrates: &(dyn Fn(&Machine, usize) -> Result<bool, String> + Sync),
        monitor: &dyn Monitor,
    ) -> Result<f64, Cancelled> {
        let count = self.machines.len().min(LATER);
        let task = Task::new(monitor, "verdict: longer duration", count);
        let changes = task.map(count, |index| {
            let machine = machines.at(&machines.variables_of(index));
            let later = machine.and_then(|machine| vibrates(&machine, index));
            Ok::<f64, Cancelled>(match (&self.machines[index], later) {
                (Ok(before), Ok(later)) => f64::from(u8::from(later)) - f64::from(u8::from(before.vibrates)),
                _ => 0.0,
            })
        })?;
        Ok(self.probability().value + changes.iter().sum::<f64>() / count as f64)
    }

    /// Returns the samples with an answer.
    pub(super) fn valid(&self) -> impl Iterator<Item = &Evaluated> {
        self.machines.iter().flatten()
    }

    /// Returns the mean of a value between 0 and 1 over the samples with an answer.
    pub(super) fn mean(&self, value: impl Fn(&Evaluated) -> f64) -> Mean {
        let values = self.machines.iter().enumerate();
        Mean::new(values.filter_map(|(index, machine)| Some((index, value(machine.as_ref().ok()?)))))
    }

    /// Returns the fraction of vibrating machines.
    pub(super) fn probability(&self) -> Mean {
        self.mean(|machine| f64::from(u8::from(machine.vibrates)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::{standard_normal_cdf, standard_normal_quantile};
    use crate::monitor::Silent;
    use crate::study::Study;
    use crate::study::verdict::machines::tests::{LINEAR, constant, stated};
    use crate::study::verdict::replicates::{REPLICATES, designs};
    use asperity_testing::covered;

    #[test]
    fn an_interval_is_narrow_if_each_of_its_probabilities_has_the_half_width() {
        // 1.96² p (1 − p)/n is 0.05² at 384.1 machines for p = 1/2, and at 245.9 for p = 0.8.
        for (low, high, enough) in [(0.4, 0.6, 385), (0.8, 0.9, 246), (0.1, 0.2, 246)] {
            let narrow = |all| is_narrow(Interval { low, high }, all, 0.05);
            assert!(narrow(enough) && !narrow(enough - 1), "{low} {high}");
        }
    }

    #[test]
    fn the_change_by_another_machine_is_that_of_its_margins() {
        let (study, window) = stated(LINEAR);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let sampled = Sampled::until(&machines, &constant, 1e-3, SHIFTED, &Silent).unwrap();
        assert_eq!(sampled.machines.len(), SHIFTED);
        for (weakening, shift) in [("0.104", 0.002), ("0.1", 0.0), ("0.09", -0.005)] {
            let other = LINEAR.replace("\"0.1 ±", &format!("\"{weakening} ±"));
            let study = Study::parse(&other, "study.toml").unwrap();
            let others = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
            let change = sampled.change(&others, |margins| margins.from_stick, &Silent).unwrap();
            let below =
                |limit: f64| sampled.mean(|machine| f64::from(u8::from(machine.margins.from_stick < limit))).value;
            let wanted = below(shift) - below(0.0);
            assert!(
                (change - wanted).abs() < 1e-12 && (wanted == 0.0) == (shift == 0.0),
                "{change} instead of {wanted}"
            );
        }
    }

    #[test]
    fn a_longer_duration_adds_the_machines_that_vibrate_later() {
        // A machine vibrates later if ζ − b/2 is below .005.
        let (study, window) = stated(LINEAR);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let sampled = Sampled::until(&machines, &constant, 1e-3, LATER, &Silent).unwrap();
        assert_eq!(sampled.machines.len(), LATER);
        let below = |limit: f64| sampled.mean(|machine| f64::from(u8::from(machine.margins.from_stick < limit))).value;
        let vibrates =
            |machine: &Machine, _: usize| Ok(Evaluated::constant_friction(machine)?.margins.from_stick < 0.005);
        let later = sampled.later(&machines, &vibrates, &Silent).unwrap();
        assert!((later - below(0.005)).abs() < 1e-12 && later > below(0.0) + 0.1, "{later} and {}", below(0.0));
    }

    /// Returns the interval at which sampling stops, and the number of samples.
    fn stopped(variables: usize, vibrates: &dyn Fn(&[f64]) -> bool, half_width: f64, seed: u64) -> (Interval, usize) {
        const MOST: usize = 1 << 16;
        let designs = designs(variables, MOST, seed, "test").unwrap();
        let point = |index: usize| designs[index % REPLICATES].xi(index / REPLICATES);
        let (mut values, mut all) = (Vec::new(), 0);
        loop {
            let to = end_of_round(all, MOST);
            values.extend((all..to).map(|index| (index, f64::from(u8::from(vibrates(&point(index)))))));
            all = to;
            let interval = Mean::new(values.iter().copied()).interval();
            if is_narrow(interval, all, half_width) || all == MOST {
                return (interval, all);
            }
        }
    }

    /// Returns the fraction of intervals that cover the probability, and their mean half width over the one that the error of the estimates
    /// requires.
    fn coverage(
        case: &str,
        (variables, probability, half_width): (usize, f64, f64),
        vibrates: &dyn Fn(&[f64]) -> bool,
        repetitions: u64,
    ) -> [f64; 2] {
        let found: Vec<_> = (0..repetitions).map(|seed| stopped(variables, vibrates, half_width, seed)).collect();
        let held = found.iter().filter(|(interval, _)| interval.contains(probability)).count();
        let count = repetitions as f64;
        let error = |interval: &Interval| (0.5 * (interval.low + interval.high) - probability).powi(2);
        let std = (found.iter().map(|(interval, _)| error(interval)).sum::<f64>() / count).sqrt();
        let half = found.iter().map(|(interval, _)| 0.5 * (interval.high - interval.low)).sum::<f64>() / count;
        [covered("probability of vibration", case, held, found.len()), half / (NORMAL_95 * std)]
    }

    /// Returns whether the mean of the variables, a standard normal variable after scaling, is below the quantile of a probability.
    fn below_plane(probability: f64) -> impl Fn(&[f64]) -> bool {
        let quantile = standard_normal_quantile(probability);
        move |point| point.iter().sum::<f64>() < quantile * (point.len() as f64).sqrt()
    }

    /// Returns whether the first two variables are outside the circle that they leave with a probability.
    fn outside_circle(probability: f64) -> impl Fn(&[f64]) -> bool {
        move |point| point[0].hypot(point[1]) > (-2.0 * probability.ln()).sqrt()
    }

    #[test]
    fn intervals_of_replicates_cover_the_probability_and_are_not_too_wide() {
        for variables in [1, 3] {
            let case = format!("plane, {variables} values");
            let [covered, width] = coverage(&case, (variables, 0.327, 0.03), &below_plane(0.327), 60);
            assert!(
                covered >= 0.95 - 3.0 * (0.95 * 0.05 / 60.0_f64).sqrt() && width < 3.0,
                "{case}: {covered} {width}"
            );
        }
    }

    #[test]
    #[ignore = "slow"]
    fn intervals_cover_the_probability_although_sampling_stops_when_they_are_narrow() {
        type Case = (String, (usize, f64, f64), Box<dyn Fn(&[f64]) -> bool>);
        let mut cases: Vec<Case> = Vec::new();
        for variables in [1, 2, 3, 6] {
            for (probability, half_width) in [(0.03, 0.02), (0.101, 0.01), (0.327, 0.02), (0.47, 0.015), (0.903, 0.02)]
            {
                let settings = (variables, probability, half_width);
                cases.push((format!("plane of {settings:?}"), settings, Box::new(below_plane(probability))));
            }
        }
        for (variables, probability, half_width) in [(2, 0.03, 0.02), (2, 0.45, 0.015), (5, 0.2, 0.02)] {
            let settings = (variables, probability, half_width);
            cases.push((format!("circle of {settings:?}"), settings, Box::new(outside_circle(probability))));
        }
        // Fluctuation of friction decides independently of the values: the fractional part of a large multiple is a random number.
        for probability in [0.006_f64, 0.03, 0.4] {
            let vibrates = move |point: &[f64]| (standard_normal_cdf(point[0]) * 1e9).fract() < probability;
            let settings = (2, probability, 0.02);
            cases.push((format!("chance of {settings:?}"), settings, Box::new(vibrates)));
        }
        for (case, settings, vibrates) in cases {
            let [covered, width] = coverage(&case, settings, &*vibrates, 1000);
            assert!(covered >= 0.93 && width < 3.0, "{case}: coverage {covered}, {width} times as wide as the error");
        }
    }
}
