//! Fraction of machines that vibrate under fluctuating friction, of which few are decided by ensembles.
//!
//! The margin M with constant friction is cheap, and the smaller it is, the likelier does a machine vibrate under fluctuating friction.
//! The probability h(M) that it does is therefore a control variate of the indicator B of N machines:
//!
//! P = mean[h(M) + δ/π (B − h(M))]
//!
//! where δ is 1 for the machines that are decided, and π is the probability that a machine is: π = min(1, w/d + 1/32) at d ranks of the
//! margin from c, with w = N/512. Where fluctuation hardly matters, B changes from 1 to 0 at c and the difference B − h is 0 far from c.
//! Where it dominates, B differs from h everywhere, and no weight 1/π is above 32. A search by halves finds c to within w ranks.
//!
//! Draws decide δ alone, so the estimate is unbiased for any h that other machines determine (Horvitz & Thompson): isotonic regression
//! on the decided machines of even index gives h for those of odd index, and the reverse. The variability of the terms between
//! independent samples of machines contains both errors, that of the sample and that of the selection.
//!
//! # References
//! Horvitz & Thompson, *J. Am. Stat. Assoc.* **47** (1952) 663, <https://doi.org/10.1080/01621459.1952.10483446>.

use asperity_base::blocks::Task;
use asperity_base::numeric::isotonic;

use crate::monitor::{Cancelled, Monitor};

/// Number of machines over the distance in ranks from c up to which every machine is decided.
const WHOLE: usize = 512;
/// Least probability that a machine is decided.
pub(super) const LEAST_CHANCE: f64 = 1.0 / 32.0;

/// Returns the term of each machine in the estimate of the probability, given the margins, one draw from (0, 1) per machine, and which
/// machines vibrate.
///
/// # Errors
/// The decision of a machine was cancelled.
pub(super) fn terms(
    margins: &[f64],
    draws: &[f64],
    vibrates: &(dyn Fn(usize) -> Result<bool, Cancelled> + Sync),
    monitor: &dyn Monitor,
) -> Result<Vec<f64>, Cancelled> {
    let mut order: Vec<usize> = (0..margins.len()).collect();
    order.sort_by(|a, b| margins[*a].total_cmp(&margins[*b]));
    let (mut low, mut high) = (0, order.len());
    let whole = order.len().div_ceil(WHOLE);
    while high - low > whole {
        let middle = low.midpoint(high);
        if vibrates(order[middle])? {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    let below = low.midpoint(high);
    let decided: Vec<usize> =
        (0..order.len()).filter(|&rank| draws[order[rank]] < chance(whole, rank, below)).collect();
    let task = Task::new(monitor, "verdict: decided machines", decided.len());
    let answers = task.map(decided.len(), |place| vibrates(order[decided[place]]))?;
    let decided: Vec<Decided> = decided
        .into_iter()
        .zip(answers)
        .map(|(rank, vibrates)| Decided { rank, vibrates, weight: 1.0 / chance(whole, rank, below) })
        .collect();
    let mut terms = vec![0.0; order.len()];
    order[..below].iter().for_each(|machine| terms[*machine] = 1.0);
    for half in 0..2 {
        let is_own = |rank: usize| order[rank] % 2 == half;
        let others: Vec<&Decided> = decided.iter().filter(|machine| !is_own(machine.rank)).collect();
        let quiet = isotonic(others.iter().map(|machine| [f64::from(u8::from(!machine.vibrates)), machine.weight]));
        let Some(last) = quiet.len().checked_sub(1) else { continue };
        for rank in (0..order.len()).filter(|rank| is_own(*rank)) {
            terms[order[rank]] = 1.0 - quiet[others.partition_point(|other| other.rank < rank).min(last)];
        }
    }
    for Decided { rank, vibrates, weight } in decided {
        let term = &mut terms[order[rank]];
        *term += weight * (f64::from(u8::from(vibrates)) - *term);
    }
    Ok(terms)
}

/// Machine that an ensemble decided.
struct Decided {
    /// Rank of its margin.
    rank: usize,
    vibrates: bool,
    /// One over the probability that it is decided.
    weight: f64,
}

/// Returns the probability that the machine of a rank is decided if `below` machines have a smaller margin than c.
fn chance(whole: usize, rank: usize, below: usize) -> f64 {
    let distance = if rank < below { below - rank } else { rank + 1 - below };
    (whole as f64 / distance as f64 + LEAST_CHANCE).min(1.0)
}

/// Returns the expected number of decisions for a number of machines, at most.
pub(super) fn decisions(machines: usize) -> usize {
    let whole = machines.div_ceil(WHOLE);
    let halvings = (machines / whole).ilog2() as usize;
    halvings + (0..machines).map(|rank| chance(whole, rank, machines / 2)).sum::<f64>().ceil() as usize
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::distribution::{standard_normal_cdf, standard_normal_quantile};
    use crate::monitor::Silent;
    use crate::random::{standard_normal, stream};
    use crate::stats::{Moments, student_95};
    use asperity_testing::{covered, repetitions};

    const REPLICATES: usize = 8;

    /// Returns the mean over replicates and the half width of its 95 % interval.
    fn mean_and_half_width(terms: &[f64]) -> [f64; 2] {
        let means: Vec<f64> =
            terms.chunks(terms.len() / REPLICATES).map(|own| own.iter().sum::<f64>() / own.len() as f64).collect();
        let found = Moments::new(&means);
        let half_width = student_95(REPLICATES) * found.sample_std();
        [found.mean, half_width / (REPLICATES as f64).sqrt()]
    }

    /// Probabilities with the standard deviations of the noise of a realisation relative to those of the margin, and the number of ensembles
    /// whose intervals are wider: nine and four times 512, and where fluctuation dominates the 256 that are decided everywhere.
    const CASES: [(f64, f64, f64); 6] = [
        (0.01, 0.15, 4608.0),
        (0.05, 0.15, 2048.0),
        (0.05, 1.0, 256.0),
        (0.3, 1.0, 256.0),
        (0.05, 4.0, 256.0),
        (0.3, 4.0, 256.0),
    ];

    #[test]
    #[ignore = "slow"]
    fn intervals_cover_the_probability_and_are_as_narrow_as_those_of_many_ensembles() {
        // A machine vibrates if M + s e < c + .1 z: normal variables e of the realisations and z of other values that move the limit.
        // Then P = Φ(c/√(1 + s² + .1²)).
        let mut all_covered = true;
        for (probability, noise_std, ensembles) in CASES {
            let limit = standard_normal_quantile(probability) * (1.0 + noise_std * noise_std + 0.1 * 0.1).sqrt();
            let repetitions = repetitions(40);
            let (mut held, mut square_half_widths, mut decided) = (0, 0.0, 0);
            for seed in 0..repetitions as u64 {
                let normal = |which: u64| standard_normal(&mut stream(seed, "test", which), 8192);
                let [margins, noise, other] = [0, 1, 2].map(normal);
                let draws: Vec<f64> = normal(3).into_iter().map(standard_normal_cdf).collect();
                let vibrates = |index: usize| margins[index] + noise_std * noise[index] < limit + 0.1 * other[index];
                let count = AtomicUsize::new(0);
                let counted = |index: usize| {
                    count.fetch_add(1, Ordering::Relaxed);
                    Ok(vibrates(index))
                };
                let [found, half_width] = mean_and_half_width(&terms(&margins, &draws, &counted, &Silent).unwrap());
                held += usize::from((found - probability).abs() <= half_width);
                decided += count.into_inner();
                square_half_widths += half_width * half_width;
            }
            let case = format!("normal margins with fluctuation of {noise_std}, P = {probability}");
            let fraction = covered("probability of vibration, few ensembles", &case, held, repetitions);
            let error = (0.95 * 0.05 / repetitions as f64).sqrt();
            assert!(fraction > 0.95 - 3.0 * error, "{fraction} in {case}");
            all_covered &= fraction == 1.0;
            let factor = student_95(REPLICATES);
            let all = factor * factor * probability * (1.0 - probability);
            let as_many = all / (square_half_widths / repetitions as f64);
            assert!(as_many > ensembles, "as narrow as those of {as_many} in {case}");
            assert!(decided <= repetitions * decisions(8192) && decisions(8192) < 500, "{decided}");
        }
        assert!(!all_covered, "the intervals are too wide");
    }

    #[test]
    fn the_mean_does_not_depend_on_the_machines_that_are_decided() {
        // 1,000 selections of the same machines, of which every tenth vibrates whatever its margin.
        let margins: Vec<f64> = (0..512).map(f64::from).collect();
        let vibrates = |index: usize| Ok((index < 40) != index.is_multiple_of(10));
        let wanted = (0..512).filter(|index| vibrates(*index).unwrap()).count() as f64 / 512.0;
        let means: Vec<f64> = (0..1000)
            .map(|seed| {
                let draws: Vec<f64> =
                    standard_normal(&mut stream(seed, "test", 0), 512).into_iter().map(standard_normal_cdf).collect();
                terms(&margins, &draws, &vibrates, &Silent).unwrap().iter().sum::<f64>() / 512.0
            })
            .collect();
        let found = Moments::new(&means);
        assert!((found.mean - wanted).abs() < 3.0 * found.standard_error(), "{} instead of {wanted}", found.mean);
    }

    #[test]
    fn one_machine_is_decided() {
        for vibrates in [false, true] {
            assert_eq!(terms(&[0.0], &[0.5], &|_| Ok(vibrates), &Silent).unwrap(), [f64::from(u8::from(vibrates))]);
        }
    }
}
