//! Evaluated machines, and the probability that one vibrates.

use asperity_base::blocks::Task;
use serde::{Deserialize, Serialize};

use super::dynamics::Margins;
use super::machines::{Machine, Machines};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::{Interval, NORMAL_95, wilson_interval};

/// Number of machines of the first round; each further round doubles the number.
const FIRST_ROUND: usize = 2048;

/// Largest number of machines that are followed for a longer time.
pub(in crate::study) const LATER: usize = 256;
/// Largest number of machines that are evaluated with another friction.
const SHIFTED: usize = 4096;

/// Evaluated machine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Evaluated {
    pub(super) margins: Margins,
    /// Whether it vibrates if its motion begins in stick.
    pub(super) vibrates: bool,
}

impl Evaluated {
    /// Returns the machine's answer without fluctuation of friction.
    pub(super) fn constant_friction(machine: &Machine) -> Result<Self, String> {
        let margins = machine.dynamics.margins().map_err(|error| error.to_string())?;
        Ok(Self { margins, vibrates: margins.from_stick < 0.0 })
    }
}

/// Evaluates a machine, given its index in the sample.
pub(super) type Evaluate<'a> = dyn Fn(&Machine, usize) -> Result<Evaluated, String> + Sync + 'a;

/// Returns the number of machines after the round that begins with number `from`.
fn end_of_round(from: usize, most: usize) -> usize {
    FIRST_ROUND.max(2 * from).min(most)
}

/// Returns the largest number of machines that the interval of a probability may need.
pub(in crate::study) fn largest_number(half_width: f64, most: usize) -> usize {
    let widest = (0.5 * NORMAL_95 / half_width).powi(2);
    let mut number = end_of_round(0, most);
    while number < most && (number as f64) < widest {
        number = end_of_round(number, most);
    }
    number
}

/// Returns whether the interval of `all` machines has the half width for every probability in it. If the fraction itself decided,
/// sampling would stop more often where the fraction is wrong, and too few intervals would cover the probability.
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
            if is_narrow(sampled.probability().1, to, half_width) {
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
        Ok(self.probability().0 + changes.iter().sum::<f64>() / count as f64)
    }

    /// Returns the samples with an answer.
    pub(super) fn valid(&self) -> impl Iterator<Item = &Evaluated> {
        self.machines.iter().flatten()
    }

    /// Returns the number of samples with an answer for which a property holds, and the number of all.
    pub(super) fn count(&self, holds: impl Fn(&Evaluated) -> bool) -> (usize, usize) {
        (self.valid().filter(|machine| holds(machine)).count(), self.valid().count())
    }

    /// Returns the fraction of vibrating machines with its 95 % interval.
    pub(super) fn probability(&self) -> (f64, Interval) {
        let (vibrating, all) = self.count(|machine| machine.vibrates);
        (vibrating as f64 / all as f64, wilson_interval(vibrating, all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::standard_normal_cdf;
    use crate::monitor::Silent;
    use crate::random::{standard_normal, stream};
    use crate::study::Study;
    use crate::study::verdict::machines::tests::{LINEAR, stated_window};
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
        let study = Study::parse(LINEAR, "study.toml").unwrap();
        let window = stated_window(&study);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let evaluate = |machine: &Machine, _: usize| Evaluated::constant_friction(machine);
        let sampled = Sampled::until(&machines, &evaluate, 1e-3, SHIFTED, &Silent).unwrap();
        assert_eq!(sampled.machines.len(), SHIFTED);
        for (weakening, shift) in [("0.104", 0.002), ("0.1", 0.0), ("0.09", -0.005)] {
            let other = LINEAR.replace("\"0.1 ±", &format!("\"{weakening} ±"));
            let study = Study::parse(&other, "study.toml").unwrap();
            let others = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
            let change = sampled.change(&others, |margins| margins.from_stick, &Silent).unwrap();
            let below = |limit: f64| sampled.count(|machine| machine.margins.from_stick < limit).0 as f64;
            let wanted = (below(shift) - below(0.0)) / SHIFTED as f64;
            assert!(
                (change - wanted).abs() < 1e-12 && (wanted == 0.0) == (shift == 0.0),
                "{change} instead of {wanted}"
            );
        }
    }

    #[test]
    fn a_longer_duration_adds_the_machines_that_vibrate_later() {
        // A machine vibrates later if ζ − b/2 is below .005.
        let study = Study::parse(LINEAR, "study.toml").unwrap();
        let window = stated_window(&study);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let evaluate = |machine: &Machine, _: usize| Evaluated::constant_friction(machine);
        let sampled = Sampled::until(&machines, &evaluate, 1e-3, LATER, &Silent).unwrap();
        assert_eq!(sampled.machines.len(), LATER);
        let below = |limit: f64| {
            let (below, all) = sampled.count(|machine| machine.margins.from_stick < limit);
            below as f64 / all as f64
        };
        let vibrates =
            |machine: &Machine, _: usize| Ok(Evaluated::constant_friction(machine)?.margins.from_stick < 0.005);
        let later = sampled.later(&machines, &vibrates, &Silent).unwrap();
        assert!((later - below(0.005)).abs() < 1e-12 && later > below(0.0) + 0.1, "{later} and {}", below(0.0));
    }

    /// Returns the interval at which sampling stops, and the number of samples.
    fn stopped(probability: f64, half_width: f64, replicate: u64) -> (Interval, usize) {
        let rng = &mut stream(7, "test", replicate);
        let (mut vibrating, mut all) = (0, 0);
        loop {
            let to = end_of_round(all, 1 << 16);
            let normal = standard_normal(rng, to - all);
            vibrating += normal.into_iter().filter(|g| standard_normal_cdf(*g) < probability).count();
            all = to;
            let interval = wilson_interval(vibrating, all);
            if is_narrow(interval, all, half_width) || all == 1 << 16 {
                return (interval, all);
            }
        }
    }

    #[test]
    #[ignore = "slow"]
    fn intervals_cover_the_probability_although_sampling_stops_when_they_are_narrow() {
        for (probability, half_width) in [
            (0.03, 0.01),
            (0.1, 0.012),
            (0.327, 0.02),
            (0.327, 0.01),
            (0.44, 0.0153),
            (0.47, 0.0153),
            (0.5, 0.0153),
            (0.9, 0.01),
        ] {
            let replicates: Vec<_> = (0..1000).map(|replicate| stopped(probability, half_width, replicate)).collect();
            let held = replicates.iter().filter(|(i, _)| i.low <= probability && probability <= i.high).count();
            let case = format!("sampled until ± {half_width}, P = {probability}");
            let fraction = covered("probability of vibration", &case, held, replicates.len());
            assert!(fraction >= 0.93, "{case}: {fraction}");
            for (interval, all) in replicates {
                // The interval of as many independent samples with the true fraction.
                let ideal = 2.0 * 1.96 * (probability * (1.0 - probability) / all as f64).sqrt();
                assert!(interval.high - interval.low <= 1.5 * ideal, "{interval:?} after {all}");
            }
        }
    }
}
