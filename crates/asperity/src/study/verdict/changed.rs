//! Probability that the sampled machines vibrate after a change.
//!
//! The changed machines are fewer than those of the verdict, and the verdict's answers for these machines are known. With the indicator B
//! of the changed machines, the indicator K of the verdict and its probability P, a control variate gives the changed probability:
//!
//! mean[B] + β (P − mean[K]),  β = cov(B, K)/var(K)
//!
//! The fraction of the time in vibration is estimated in the same way.

use asperity_base::blocks::Task;

use super::machines::Machines;
use super::probability::Probability;
use super::replicates::Mean;
use super::sampled::{Evaluate, Evaluated, Sampled};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::Interval;

/// Machine with its number, and its answers after the change and in the verdict.
pub(super) type Pair = (usize, [Evaluated; 2]);

/// Returns the answers of the changed machines. Sampling ends after the `first` machines if all vibrate or none does, and after `most`
/// otherwise. Machines without an answer are left out.
pub(super) fn pairs(
    changed: &Machines<'_>,
    sampled: &Sampled,
    numbers: [usize; 2],
    evaluate: &Evaluate<'_>,
    monitor: &dyn Monitor,
) -> Result<Vec<Pair>, Cancelled> {
    let answers = |index: usize| {
        let known = *sampled.machines[index].as_ref().ok()?;
        let machine = changed.at(&changed.variables_of(index)).ok()?;
        Some([evaluate(&machine, index).ok()?, known])
    };
    paired(numbers.map(|number| number.min(sampled.machines.len())), &answers, monitor)
}

fn paired(
    [first, most]: [usize; 2],
    answers: &(dyn Fn(usize) -> Option<[Evaluated; 2]> + Sync),
    monitor: &dyn Monitor,
) -> Result<Vec<Pair>, Cancelled> {
    let mut pairs: Vec<Pair> = Vec::new();
    let task = Task::new(monitor, "verdict: changed machines", most);
    for (from, to) in [(0, first), (first, most)] {
        let found = task.map(to - from, |place| Ok::<_, Cancelled>(answers(from + place)))?;
        pairs.extend(found.into_iter().enumerate().filter_map(|(place, pair)| Some((from + place, pair?))));
        if pairs.windows(2).all(|two| two[0].1[0].vibrates == two[1].1[0].vibrates) {
            // The other machines are not needed.
            task.advance(most - to);
            break;
        }
    }
    Ok(pairs)
}

/// Returns the mean of a value between 0 and 1 over the changed machines with its interval, given the mean of the verdict. The answer for
/// exact values has no error.
pub(super) fn controlled(
    pairs: &[Pair],
    value: impl Fn(&Evaluated) -> f64,
    verdict: &Probability,
    is_exact: bool,
) -> (f64, Interval) {
    let mean = |of: &dyn Fn([f64; 2]) -> f64| {
        pairs.iter().map(|(_, pair)| of(pair.each_ref().map(&value))).sum::<f64>() / pairs.len() as f64
    };
    let [row, known] = [mean(&|[row, _]| row), mean(&|[_, known]| known)];
    let variance = mean(&|[_, other]| (other - known).powi(2));
    let slope =
        if variance > f64::EPSILON { mean(&|[own, other]| (own - row) * (other - known)) / variance } else { 0.0 };
    let rest = Mean::new(pairs.iter().map(|(index, [own, other])| (*index, value(own) - slope * value(other))));
    let value = (rest.value + slope * verdict.value).clamp(0.0, 1.0);
    if is_exact {
        return (value, Interval { low: value, high: value });
    }
    let whole = 0.5 * slope.abs() * (verdict.interval.high - verdict.interval.low);
    (value, Mean { value, half_width: rest.half_width.hypot(whole) }.interval())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use crate::study::verdict::dynamics::Margins;

    /// Returns a machine that vibrates for a fraction of the time.
    fn evaluated(fraction: f64) -> Evaluated {
        let margins = Margins { from_stick: 0.0, from_steady_sliding: 0.0 };
        Evaluated { margins, fraction, fraction_se: 0.0, vibrates: fraction > 0.1 }
    }

    fn answer(vibrates: bool) -> Evaluated {
        evaluated(f64::from(u8::from(vibrates)))
    }

    #[test]
    fn machines_that_follow_the_verdict_have_its_probability_and_its_error() {
        // Half of the 64 machines vibrate; the verdict, with .4, is known better.
        let interval = Interval { low: 0.39, high: 0.41 };
        let verdict = Probability { value: 0.4, interval, sources: Vec::new() };
        let pairs = |answers: fn(usize) -> [bool; 2]| {
            (0..64).map(|index| (index, answers(index).map(answer))).collect::<Vec<Pair>>()
        };
        let equal = pairs(|index| [(index / 8).is_multiple_of(2); 2]);
        let (value, found) = controlled(&equal, |machine| machine.fraction, &verdict, false);
        assert!((value - 0.4).abs() < 1e-12 && found.low < 0.39 && found.low > 0.34, "{value} {found:?}");
        // Machines without a relation to the verdict keep their own fraction: a quarter, and none.
        let free = pairs(|index| [(index / 16).is_multiple_of(4), (index / 8).is_multiple_of(2)]);
        assert!((controlled(&free, |machine| machine.fraction, &verdict, false).0 - 0.25).abs() < 1e-12);
        let none = pairs(|index| [false, (index / 8).is_multiple_of(2)]);
        let exact = controlled(&none, |machine| machine.fraction, &verdict, true);
        assert_eq!(exact, (0.0, Interval { low: 0.0, high: 0.0 }));
        // A fraction of the time that is .1 larger than half of that of the verdict: .1 + .4/2.
        let shifted: Vec<Pair> = (0..64).map(|index| (index, index as f64 / 64.0)).map(half_and_tenth).collect();
        let (value, found) = controlled(&shifted, |machine| machine.fraction, &verdict, false);
        assert!((value - 0.3).abs() < 1e-12 && found.contains(0.3), "{value} {found:?}");
    }

    fn half_and_tenth((index, known): (usize, f64)) -> Pair {
        (index, [evaluated(0.1 + 0.5 * known), evaluated(known)])
    }

    /// Returns how many machines vibrate, and how many have an answer.
    fn counted(numbers: [usize; 2], answers: &(dyn Fn(usize) -> Option<[bool; 2]> + Sync)) -> (usize, usize) {
        let pairs = paired(numbers, &|index| Some(answers(index)?.map(answer)), &Silent).unwrap();
        (pairs.iter().filter(|(_, [changed, _])| changed.vibrates).count(), pairs.len())
    }

    #[test]
    fn sampling_ends_early_where_all_machines_have_the_same_answer() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        // The answers of the machines from number 4 on differ from the first; number 2 has none.
        for (first, rest, wanted) in [(true, false, (3, 3)), (false, true, (0, 3)), (true, true, (3, 3))] {
            let asked = AtomicUsize::new(0);
            let vibrates = |index: usize| {
                asked.fetch_add(1, Ordering::Relaxed);
                (index != 2).then_some([if index < 4 { first } else { rest }, index == 0])
            };
            assert_eq!(counted([4, 10], &vibrates), wanted);
            assert_eq!(asked.into_inner(), 4);
        }
        let mixed = |index: usize| (index != 2).then_some([index.is_multiple_of(2), false]);
        assert_eq!(counted([4, 10], &mixed), (4, 9));
    }
}
