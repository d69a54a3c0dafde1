//! Fraction of machines that vibrate under fluctuating friction, of which few are decided by ensembles.
//!
//! The margin M with constant friction is cheap, and a machine B that vibrates under fluctuating friction has roughly M < c. The
//! indicator 1(M < c) is therefore a control variate of the indicator B of N machines:
//!
//! P = mean[1(M < c) + δ/π (B − 1(M < c))]
//!
//! where δ is 1 for the machines that are decided, and π is the probability that a machine is: π = min(1, w/d) at d ranks of the margin
//! from c, with w = N/256. The difference B − 1(M < c) is rarely other than 0 far from c, so its large weights there seldom count. Draws decide
//! δ alone, so the estimate is unbiased for any c (Horvitz & Thompson). The variability of the terms between independent samples of
//! machines contains both errors, that of the sample and that of the selection.
//!
//! A search by halves finds c to within w ranks from other decisions.
//!
//! # References
//! Horvitz & Thompson, *J. Am. Stat. Assoc.* **47** (1952) 663, <https://doi.org/10.1080/01621459.1952.10483446>.

use asperity_base::blocks::Task;

use crate::monitor::{Cancelled, Monitor};

/// Number of machines over the distance in ranks from c up to which every machine is decided.
const WHOLE: usize = 256;

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
    let mut terms = vec![0.0; order.len()];
    order[..below].iter().for_each(|machine| terms[*machine] = 1.0);
    for (rank, vibrates) in decided.into_iter().zip(answers) {
        let difference = f64::from(u8::from(vibrates)) - terms[order[rank]];
        terms[order[rank]] += difference / chance(whole, rank, below);
    }
    Ok(terms)
}

/// Returns the probability that the machine of a rank is decided if `below` machines have a smaller margin than c.
fn chance(whole: usize, rank: usize, below: usize) -> f64 {
    let distance = if rank < below { below - rank } else { rank + 1 - below };
    (whole as f64 / distance as f64).min(1.0)
}

/// Returns the expected number of decisions for a number of machines, at most.
pub(in crate::study) fn decisions(machines: usize) -> usize {
    let whole = machines.div_ceil(WHOLE);
    let halvings = (machines / whole).ilog2() as usize;
    halvings + (0..machines).map(|rank| chance(whole, rank, machines / 2)).sum::<f64>().ceil() as usize
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::distribution::standard_normal_cdf;
    use crate::monitor::Silent;
    use crate::random::{standard_normal, stream};
    use crate::stats::{Moments, student_quantile};
    use asperity_testing::{covered, repetitions};

    const REPLICATES: usize = 8;

    /// Returns the mean over replicates and the half width of its 95 % interval.
    fn mean_and_half_width(terms: &[f64]) -> [f64; 2] {
        let means: Vec<f64> =
            terms.chunks(terms.len() / REPLICATES).map(|own| own.iter().sum::<f64>() / own.len() as f64).collect();
        let found = Moments::new(&means);
        let half_width = student_quantile(0.975, (REPLICATES - 1) as f64) * found.sample_std();
        [found.mean, half_width / (REPLICATES as f64).sqrt()]
    }

    #[test]
    fn intervals_cover_the_probability_and_are_three_times_narrower_than_those_of_more_ensembles() {
        // A machine vibrates if M + .15 e < c + .1 z: normal variables e of the realisations and z of other values that move the limit.
        // Then P = Φ(c/√(1 + .15² + .1²)).
        for (probability, score, narrower) in [(0.01, -2.326_347_9, 3.0), (0.05, -1.644_853_6, 2.0)] {
            let limit = score * (1.0_f64 + 0.15 * 0.15 + 0.1 * 0.1).sqrt();
            let repetitions = repetitions(100);
            let (mut held, mut half_widths, mut decided) = (0, [0.0; 2], 0);
            for seed in 0..repetitions as u64 {
                let normal = |which: u64| standard_normal(&mut stream(seed, "test", which), 8192);
                let [margins, noise, other] = [0, 1, 2].map(normal);
                let draws: Vec<f64> = normal(3).into_iter().map(standard_normal_cdf).collect();
                let vibrates = |index: usize| margins[index] + 0.15 * noise[index] < limit + 0.1 * other[index];
                let count = AtomicUsize::new(0);
                let counted = |index: usize| {
                    count.fetch_add(1, Ordering::Relaxed);
                    Ok(vibrates(index))
                };
                let [found, half_width] = mean_and_half_width(&terms(&margins, &draws, &counted, &Silent).unwrap());
                held += usize::from((found - probability).abs() <= half_width);
                decided += count.into_inner();
                let all: Vec<f64> = (0..512).map(|index| f64::from(u8::from(vibrates(index)))).collect();
                half_widths[0] += half_width;
                half_widths[1] += mean_and_half_width(&all)[1];
            }
            let case = format!("normal margins with fluctuation, P = {probability}");
            let fraction = covered("probability of vibration, few ensembles", &case, held, repetitions);
            assert!((0.9..1.0).contains(&fraction), "{fraction} at {probability}");
            assert!(half_widths[1] > narrower * half_widths[0], "{half_widths:?} at {probability}");
            assert!(decided <= repetitions * decisions(8192) && decided < repetitions * 400, "{decided}");
        }
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
