//! Effect of each value on the margin and the event, and how much a measurement of it narrows the margin.

use super::machines::Machines;
use super::sampled::Sampled;
use crate::chaos::{
    Basis, DriverError, Drivers, Expansion, NestedSampling, PickFreeze, ProbabilityOverUnknowns, SampleEstimate,
};
use crate::random;
use crate::stats::quantile_sorted;
use crate::study::StudyError;
use crate::study::result::{Driver, Guess, Pair, Quantiles};
use asperity_base::numeric::dot;

/// Largest number of samples to which the margin is fitted.
const MOST_SAMPLES: usize = 4096;
/// Number of samples per term of the expansion.
const SAMPLES_PER_TERM: usize = 3;
/// Largest degree of the expansion.
const MOST_DEGREE: usize = 6;
/// Values of one input, and machines at each of them, from which the range of the margin is computed.
const KNOWN_VALUES: usize = 64;
const MACHINES: usize = 512;
/// Least number of machines that vibrate, and of those that do not, from which the effect of the fluctuation of friction is estimated.
const LEAST_OF_EACH: f64 = 40.0;
/// Standard errors beyond which an estimated effect is more than chance.
const STANDARD_ERRORS: f64 = 3.0;
/// Stream of their standard normal variables.
const STREAM: &str = "study/verdict/known";

/// The margin of the sampled machines as an expansion in the standard normal variables.
pub(super) struct MarginModel {
    expansion: Expansion,
    /// Effect of the fluctuation of friction: change of the margin per standard normal variable.
    effect: Vec<f64>,
    /// Fraction of the variance that the expansion does not explain.
    pub(super) unexplained: f64,
    /// Margin below which machines vibrate: 0, or with fluctuating friction the margin that as many machines are below as vibrate.
    threshold: f64,
}

impl MarginModel {
    /// Fits the margin, with the [effect](effect_of_fluctuation) of the fluctuation of friction if there is one; `None` if no value is uncertain, or no expansion predicts the margin better than its mean.
    pub(super) fn new(
        machines: &Machines<'_>,
        sampled: &Sampled,
        fluctuates: bool,
    ) -> Result<Option<Self>, StudyError> {
        let variables = machines.variables();
        if variables == 0 {
            return Ok(None);
        }
        let valid = (0..sampled.machines.len().min(MOST_SAMPLES)).filter_map(|index| {
            let machine = sampled.machines[index].as_ref().ok()?;
            Some((machines.variables_of(index), (machine.margins.from_stick, machine.vibrates)))
        });
        let (points, answers): (Vec<Vec<f64>>, Vec<(f64, bool)>) = valid.unzip();
        let (mut margins, vibrates): (Vec<f64>, Vec<bool>) = answers.into_iter().unzip();
        let mut best: Option<(Expansion, f64)> = None;
        for degree in 1..=MOST_DEGREE {
            let Ok(basis) = Basis::hermite(variables, degree) else { break };
            if SAMPLES_PER_TERM * basis.len() > points.len() {
                break;
            }
            let (expansion, fit) = Expansion::fit(basis, &points, &margins)?;
            let Some(error) = fit.leave_one_out.relative_error else { break };
            if best.as_ref().is_none_or(|(_, least)| error < *least) {
                best = Some((expansion, error));
            }
        }
        let Some((expansion, unexplained)) = best.filter(|(_, error)| *error < 1.0) else { return Ok(None) };
        let mut model = Self { expansion, effect: vec![0.0; variables], unexplained, threshold: 0.0 };
        if fluctuates {
            model.effect = effect_of_fluctuation(&points, &margins, &vibrates);
            margins.iter_mut().zip(&points).for_each(|(margin, point)| *margin += dot(&model.effect, point));
            margins.sort_by(f64::total_cmp);
            let (first, last) = (margins[0], margins[margins.len() - 1]);
            // If all of the machines vibrate, or none, the error of the expansion moves no machine across the threshold.
            model.threshold = match sampled.probability().value {
                0.0 => first - (last - first),
                1.0 => last + (last - first),
                probability => quantile_sorted(&margins, probability),
            };
        }
        Ok(Some(model))
    }

    fn margins(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let mut margins = self.expansion.evaluate_many(points);
        let change = |(margin, variables): (&mut f64, &Vec<f64>)| {
            *margin = *margin + dot(&self.effect, variables) - self.threshold;
        };
        margins.iter_mut().zip(points).for_each(change);
        margins
    }

    /// Returns the sensitivity of the margin.
    pub(super) fn margin_drivers(&self, machines: &Machines<'_>, seed: u64) -> Result<Vec<Driver>, DriverError> {
        let drivers = PickFreeze::new(seed).drivers(machines.inputs(), &|points| self.margins(points))?;
        let reductions = self.range_reductions(machines, seed);
        let mut results = self.results(machines, &drivers);
        results.iter_mut().zip(reductions).for_each(|(driver, reduction)| driver.range_reduction = Some(reduction));
        Ok(results)
    }

    /// Returns the sensitivity of the event that a machine vibrates.
    pub(super) fn event_drivers(&self, machines: &Machines<'_>, seed: u64) -> Result<Vec<Driver>, DriverError> {
        let event = |points: &[Vec<f64>]| {
            let margins = self.margins(points).into_iter();
            margins.map(|margin| if margin < 0.0 { 1.0 } else { 0.0 }).collect()
        };
        Ok(self.results(machines, &PickFreeze::new(seed).drivers(machines.inputs(), &event)?))
    }

    fn results(&self, machines: &Machines<'_>, drivers: &Drivers) -> Vec<Driver> {
        // A fraction ε of the variance beyond the expansion changes an index by at most ε.
        let wide = |estimate: &SampleEstimate| -> Pair {
            let interval = estimate.interval;
            [(interval.low - self.unexplained).max(0.0), (interval.high + self.unexplained).min(1.0)]
        };
        let inputs = machines.inputs().inputs().iter().enumerate();
        inputs
            .map(|(place, input)| Driver {
                input: input.name().into(),
                first_order: drivers.first_order[place].value,
                first_order_interval: wide(&drivers.first_order[place]),
                total: drivers.total[place].value,
                total_interval: wide(&drivers.total[place]),
                shapley: drivers.shapley.as_ref().map(|shapley| shapley[place].value),
                shapley_interval: drivers.shapley.as_ref().map(|shapley| wide(&shapley[place])),
                range_reduction: None,
            })
            .collect()
    }

    /// Returns for each input the fraction by which the 5–95 % range of the margin narrows on average once the input is known.
    fn range_reductions(&self, machines: &Machines<'_>, seed: u64) -> Vec<f64> {
        let (inputs, variables) = (machines.inputs(), machines.variables());
        let draws: Vec<Vec<f64>> = (0..MACHINES)
            .map(|index| random::standard_normal(&mut random::stream(seed, STREAM, index as u64), variables))
            .collect();
        let range = |points: &[Vec<f64>]| {
            let mut margins = self.margins(points);
            margins.sort_by(f64::total_cmp);
            quantile_sorted(&margins, 0.95) - quantile_sorted(&margins, 0.05)
        };
        let whole = range(&draws);
        let reduction = |input: usize| {
            let order: Vec<usize> =
                std::iter::once(input).chain((0..variables).filter(|other| *other != input)).collect();
            let redraw = inputs.redraw(&order);
            let ranges = (0..KNOWN_VALUES).map(|known| {
                let probability = (known as f64 + 0.5) / KNOWN_VALUES as f64;
                let point = inputs.point_with(input, probability);
                let redrawn = draws.iter().map(|fresh| redraw.last(variables - 1, &point, fresh));
                range(&redrawn.collect::<Vec<_>>())
            });
            1.0 - ranges.sum::<f64>() / KNOWN_VALUES as f64 / whole
        };
        (0..variables).map(reduction).collect()
    }

    /// Returns the quantiles of the probability over the unknown values, and the effect of each of them; `None` if no value is
    /// unknown.
    pub(super) fn over_unknowns(
        &self,
        machines: &Machines<'_>,
        seed: u64,
    ) -> Result<Option<(Quantiles, Vec<Guess>)>, DriverError> {
        let inputs = machines.inputs();
        let found = NestedSampling::new(seed).probability_over_unknowns(inputs, &|points| self.margins(points))?;
        Ok(found.map(|ProbabilityOverUnknowns { q05, q50, q95, effects }| {
            let guesses = effects.into_iter().map(|effect| Guess {
                input: inputs.inputs()[effect.input].name().into(),
                probability_at_q05: effect.probability_at_q05,
                probability_at_q95: effect.probability_at_q95,
            });
            (Quantiles { q05, q50, q95 }, guesses.collect())
        }))
    }
}

/// Returns the change of the margin M per standard normal variable ξ such that the machines that vibrate under fluctuating friction are
/// those with the smallest margins; zero if M alone explains them.
///
/// If a machine vibrates (B = 1) below a limit of a linear function of ξ, cov(B, ξ) has the direction of its gradient (Stein). So has the
/// covariance of 1(M < c) with that of M, where as many machines are below c as vibrate. The change turns the gradient of M from the
/// second direction to the first, so values on which M does not depend, such as the standard deviation of friction, count as much as
/// they decide.
///
/// # References
/// Stein, *Ann. Stat.* **9** (1981) 1135, <https://doi.org/10.1214/aos/1176345632>.
fn effect_of_fluctuation(points: &[Vec<f64>], margins: &[f64], vibrates: &[bool]) -> Vec<f64> {
    let (all, variables) = (points.len() as f64, points[0].len());
    let number = |is_true: bool| f64::from(u8::from(is_true));
    let events: Vec<f64> = vibrates.iter().copied().map(number).collect();
    let count = events.iter().sum::<f64>();
    if count.min(all - count) < LEAST_OF_EACH {
        return vec![0.0; variables];
    }
    let mut sorted = margins.to_vec();
    sorted.sort_by(f64::total_cmp);
    let limit = quantile_sorted(&sorted, count / all);
    let below: Vec<f64> = margins.iter().map(|margin| number(*margin < limit)).collect();
    let covariance = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / all;
        let product = |k: usize| points.iter().zip(values).map(|(point, value)| point[k] * (value - mean)).sum::<f64>();
        (0..variables).map(|k| product(k) / all).collect()
    };
    let [of_margin, of_event, of_below] = [margins, &events, &below].map(covariance);
    let different = events.iter().zip(&below).filter(|(event, below)| event != below).count() as f64;
    let chance = STANDARD_ERRORS * different.sqrt() / all;
    // Chance shortens a covariance; only what is perpendicular to the other turns it.
    let along = dot(&of_event, &of_below) / dot(&of_below, &of_below);
    if of_event.iter().zip(&of_below).all(|(event, below)| (event - along * below).abs() <= chance) {
        return vec![0.0; variables];
    }
    let length = |vector: &[f64]| dot(vector, vector).sqrt();
    let (scale, event_length, below_length) = (length(&of_margin), length(&of_event), length(&of_below));
    let change = |(event, below): (&f64, &f64)| scale * (below / below_length - event / event_length);
    of_event.iter().zip(&of_below).map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use crate::study::verdict::machines::Machine;
    use crate::study::verdict::machines::tests::{LINEAR, stated};
    use crate::study::verdict::sampled::Evaluated;

    #[test]
    fn variance_beyond_the_expansion_widens_the_intervals_of_the_drivers() {
        let (study, window) = stated(LINEAR);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        // A margin of .2 + .6 x + .8 y, which has the indices .36 and .64.
        let points: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i / 3) - 1.0, f64::from(i % 3) - 1.0]).collect();
        let margins: Vec<f64> = points.iter().map(|[x, y]| 0.2 + 0.6 * x + 0.8 * y).collect();
        let (expansion, _) = Expansion::fit(Basis::hermite(2, 1).unwrap(), &points, &margins).unwrap();
        let model = MarginModel { expansion, effect: vec![0.0; 2], unexplained: 0.1, threshold: 0.3 };
        assert!((model.margins(&[vec![1.0; 2]])[0] - 1.3).abs() < 1e-12);
        let drivers = model.margin_drivers(&machines, 1).unwrap();
        assert_eq!(drivers.len(), 2);
        for (driver, index) in drivers.iter().zip([0.36, 0.64]) {
            for [low, high] in [driver.first_order_interval, driver.total_interval] {
                assert!((low - (index - 0.1)).abs() < 0.02 && (high - (index + 0.1)).abs() < 0.02, "{driver:?}");
            }
        }
    }

    #[test]
    fn the_range_narrows_on_average_over_the_known_values() {
        let (study, window) = stated(LINEAR);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        // A margin of y (1 + x/2), whose range is proportional to |1 + x/2| once x is known, and to |y/2| once y is.
        let points: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i / 3) - 1.0, f64::from(i % 3) - 1.0]).collect();
        let margins: Vec<f64> = points.iter().map(|[x, y]| y * (1.0 + 0.5 * x)).collect();
        let (expansion, _) = Expansion::fit(Basis::hermite(2, 2).unwrap(), &points, &margins).unwrap();
        let model = MarginModel { expansion, effect: vec![0.0; 2], unexplained: 0.0, threshold: 0.0 };
        let reductions = model.range_reductions(&machines, 1);
        // ⟨|1 + x/2|⟩ = 1.0085 and ⟨|y/2|⟩ = 0.3989; ranges of 512 machines have errors of some 5 %.
        let ratio = (1.0 - reductions[0]) / (1.0 - reductions[1]);
        assert!((ratio / (1.0085 / 0.3989) - 1.0).abs() < 0.1, "{reductions:?}");
    }

    #[test]
    fn the_margin_turns_to_the_direction_of_the_machines_that_vibrate() {
        let points: Vec<Vec<f64>> =
            (0..4096).map(|index| random::standard_normal(&mut random::stream(1, "turn", index), 3)).collect();
        let margins: Vec<f64> = points.iter().map(|x| 5.0 + 2.0 * (0.6 * x[0] + 0.8 * x[1])).collect();
        let vibrates = |along: [f64; 3], limit: f64| -> Vec<bool> {
            points.iter().map(|point| dot(&along, point) < limit).collect()
        };
        // From (.6, .8, 0) to (.36, .48, .8), both of length 2, and to the opposite of the third variable.
        for (along, wanted) in [([0.36, 0.48, 0.8], [-0.48, -0.64, 1.6]), ([0.0, 0.0, -1.0], [-1.2, -1.6, -2.0])] {
            for limit in [-0.9, 0.4] {
                let found = effect_of_fluctuation(&points, &margins, &vibrates(along, limit));
                let is_near = |(a, b): (&f64, f64)| (a - b).abs() < 0.15;
                assert!(found.iter().zip(wanted).all(is_near), "{found:?} instead of {wanted:?}");
            }
        }
        // Some decisions of ensembles are wrong by chance.
        let mut by_margin = vibrates([0.6, 0.8, 0.0], -0.5);
        by_margin.iter_mut().step_by(40).for_each(|vibrates| *vibrates = !*vibrates);
        assert_eq!(effect_of_fluctuation(&points, &margins, &by_margin), [0.0; 3]);
        // 40 machines that vibrate, or that do not, are enough.
        let rare = vibrates([0.0, 0.0, -1.0], -2.0);
        let end = (1..4096).find(|end| rare[..*end].iter().filter(|vibrates| **vibrates).count() == 40).unwrap();
        let others: Vec<bool> = rare.iter().map(|vibrates| !vibrates).collect();
        for machines in [rare, others] {
            let effect = |end: usize| effect_of_fluctuation(&points[..end], &margins[..end], &machines[..end]);
            assert!(effect(end) != [0.0; 3] && effect(end - 1) == [0.0; 3], "{end}");
        }
    }

    #[test]
    #[ignore = "slow"]
    fn values_that_act_through_the_fluctuation_of_friction_are_drivers() {
        // M = ζ − b/2 has the standard deviation .005 √5 and no part from the static friction, whose variable x changes the limit of
        // vibration by .02: M + .02 x has the variance (.25 + 1 + 4) 1e-4.
        let (study, window) = stated(
            &LINEAR.replace("static_friction = 0.3", "static_friction = { normal = [0.3, 0.01], unknown = true }"),
        );
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let place =
            |name: &str| machines.inputs().inputs().iter().position(|input| input.name().ends_with(name)).unwrap();
        let [friction, damping, weakening] = ["static_friction", "damping_ratio", "linear_weakening"].map(place);
        let model = |effect: f64, limit: f64| {
            let evaluate = |machine: &Machine, index: usize| {
                let mut evaluated = Evaluated::constant_friction(machine)?;
                let x = machines.variables_of(index)[friction];
                evaluated.vibrates = evaluated.margins.from_stick + effect * x < limit;
                Ok(evaluated)
            };
            let sampled = Sampled::until(&machines, &evaluate, 1e-9, 4096, &Silent).unwrap();
            MarginModel::new(&machines, &sampled, true).unwrap().unwrap()
        };
        let changed = model(0.02, 0.0);
        let drivers = changed.margin_drivers(&machines, 1).unwrap();
        for (input, wanted) in [(friction, 4.0), (damping, 0.25), (weakening, 1.0)] {
            assert!((drivers[input].first_order - wanted / 5.25).abs() < 0.03, "{drivers:?}");
        }
        let events = changed.event_drivers(&machines, 1).unwrap();
        assert!(events[friction].total > 0.7 && events[damping].total < 0.3, "{events:?}");
        // At the quantile z of the unknown friction P = Φ(−(.005 + .02 z)/(.005 √5)).
        let (quantiles, guesses) = changed.over_unknowns(&machines, 1).unwrap().unwrap();
        let wanted = |z: f64| crate::distribution::standard_normal_cdf(-(0.005 + 0.02 * z) / (0.005 * 5.0_f64.sqrt()));
        for (found, z) in [(quantiles.q95, -1.6449), (quantiles.q50, 0.0), (guesses[0].probability_at_q95, 1.6449)] {
            assert!((found - wanted(z)).abs() < 0.05, "{found} instead of {}", wanted(z));
        }
        // Without an effect, and with few machines that vibrate, the margin alone counts.
        assert_eq!(model(0.0, 0.004).effect, [0.0; 3]);
        assert_eq!(model(0.02, -0.07).effect, [0.0; 3]);
    }
}
