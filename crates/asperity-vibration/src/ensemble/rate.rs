//! Rates of losing and regaining vibration.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::MotionKind;
use super::super::sample_distribution::{Count, RunningMoments};
use super::passage::{KINDS, Passage};
use asperity_base::distribution::Marginal;
use asperity_base::stats::wilson_interval;

/// Least fraction of the second half of the time in vibration at which vibration counts as sustained.
const SUSTAINED: f64 = 0.5;

/// Value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// 95 % interval: of a rate exact for a Poisson count (Garwood 1936), of a fraction Wilson's.
    pub interval: [f64; 2],
}

impl Estimate {
    /// Returns the rate of `events` in the time `exposure`; none without exposure, or with one so short that rates overflow.
    pub(super) fn rate(events: u64, exposure: f64) -> Option<Self> {
        // Half the quantiles of χ², with degrees of freedom of twice the count.
        let quantile =
            |shape: f64, probability| Marginal::Gamma { shape, scale: 1.0, shift: 0.0 }.quantile(probability);
        let count = events as f64;
        let low = if events == 0 { 0.0 } else { quantile(count, 0.025) };
        let high = quantile(count + 1.0, 0.975) / exposure;
        (exposure > 0.0 && high.is_finite())
            .then_some(Self { value: count / exposure, interval: [low / exposure, high] })
    }

    /// Returns the fraction of `count` in `total`.
    pub(crate) fn fraction(count: u64, total: u64) -> Self {
        let interval = wilson_interval(count as usize, total as usize);
        Self { value: count as f64 / total as f64, interval: [interval.low, interval.high] }
    }
}

/// Passages between vibration and steady sliding over all trajectories, which start in stick, vibrating.
///
/// All kinds of vibration count: slips that reach ẋ < 0 and end in stick (cycles of stick-slip) or pass the velocity of
/// the belt without stick (overtaking). If a slip cycle attracts the motion, swings slower than the belt also count if
/// they exceed the level midway between this cycle and the border of its basin. Vibration is lost when the mass slips
/// for three natural periods without finishing a swing; the loss is dated to the end of the last swing. Vibration
/// returns at the end of the next swing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Passages {
    /// Number of trajectories.
    pub trajectories: u64,
    /// Number of exits from vibration.
    pub exits: u64,
    /// Number of returns to vibration.
    pub entries: u64,
    /// Fraction of the time in vibration.
    pub share_in_cycle: f64,
    /// Fraction of the time in each kind of motion.
    pub kinds: BTreeMap<MotionKind, f64>,
    /// Fraction of the second half of the time in vibration, over the trajectories. Its mean is φ.
    pub late_share: Count,
    /// Exits per unit of τ in vibration.
    pub exit_rate: Option<Estimate>,
    /// Entries per unit of τ out of vibration.
    pub entry_rate: Option<Estimate>,
    /// Fraction of the trajectories that leave vibration at least once.
    pub left: Estimate,
    /// Fraction of the trajectories that vibrate for at least half of the second half of their time.
    pub sustained: Estimate,
    /// Times τ of the first exit, rising, of the trajectories that leave vibration.
    pub first_exits: Vec<f64>,
    #[serde(skip)]
    sums: Sums,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sums {
    sustained: u64,
    inside: f64,
    outside: f64,
    kinds: [f64; 3],
    late: RunningMoments,
}

impl Passages {
    pub(super) const EMPTY: Self = Self {
        trajectories: 0,
        exits: 0,
        entries: 0,
        share_in_cycle: f64::NAN,
        kinds: BTreeMap::new(),
        late_share: Count { mean: f64::NAN, std: f64::NAN, se: f64::NAN },
        exit_rate: None,
        entry_rate: None,
        left: Estimate { value: f64::NAN, interval: [0.0, 1.0] },
        sustained: Estimate { value: f64::NAN, interval: [0.0, 1.0] },
        first_exits: Vec::new(),
        sums: Sums { sustained: 0, inside: 0.0, outside: 0.0, kinds: [0.0; 3], late: RunningMoments::EMPTY },
    };

    pub(super) fn add(&mut self, passage: &Passage, duration: f64) {
        self.exits += passage.exits;
        self.entries += passage.entries;
        self.first_exits.extend(passage.first_exit);
        self.trajectories += 1;
        let sums = &mut self.sums;
        sums.sustained += u64::from(passage.late_inside >= SUSTAINED * 0.5 * duration);
        sums.inside += passage.inside;
        sums.outside += passage.outside;
        sums.kinds.iter_mut().zip(passage.kinds).for_each(|(sum, time)| *sum += time);
        sums.late.add(passage.late_fraction());
    }

    /// Computes the results after the last trajectory.
    pub(super) fn finish(&mut self) {
        let Sums { sustained, inside, outside, kinds, late } = self.sums;
        self.share_in_cycle = inside / (inside + outside);
        let times = KINDS.into_iter().zip(kinds).chain([(MotionKind::None, outside)]);
        self.kinds = times.map(|(kind, time)| (kind, time / (inside + outside))).collect();
        self.late_share = Count::from_moments(&late);
        self.exit_rate = Estimate::rate(self.exits, inside);
        self.entry_rate = Estimate::rate(self.entries, outside);
        if self.trajectories > 0 {
            self.left = Estimate::fraction(self.first_exits.len() as u64, self.trajectories);
            self.sustained = Estimate::fraction(sustained, self.trajectories);
        }
        self.first_exits.sort_by(f64::total_cmp);
    }

    /// Returns the fraction of the trajectories that have not left vibration up to τ, at most their duration.
    pub fn survival(&self, tau: f64) -> Estimate {
        let gone = self.first_exits.partition_point(|exit| *exit <= tau) as u64;
        Estimate::fraction(self.trajectories - gone, self.trajectories)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survival_counts_the_trajectories_that_have_not_left_vibration() {
        let passages = Passages { trajectories: 8, first_exits: vec![1.0, 2.0, 2.0, 7.5], ..Passages::EMPTY };
        for (tau, wanted) in [(0.0, 8), (0.99, 8), (1.0, 7), (2.0, 5), (7.0, 5), (9.0, 4)] {
            let fraction = passages.survival(tau);
            assert_eq!(fraction, Estimate::fraction(wanted, 8));
            assert!(fraction.interval[0] < fraction.value && fraction.value <= fraction.interval[1]);
        }
    }

    #[test]
    fn poisson_intervals_match_the_table() {
        // Garwood, Biometrika 28 (1936) 437: 95 % limits of a mean after counts of 0, 1, 10 and 50.
        for (count, low, high) in [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.390), (50, 37.11, 65.92)] {
            let rate = Estimate::rate(count, 2.0).unwrap();
            assert_eq!(rate.value, count as f64 / 2.0);
            assert!((2.0 * rate.interval[0] - low).abs() < 5e-3 && (2.0 * rate.interval[1] - high).abs() < 5e-3);
        }
        assert_eq!([0.0, f64::NAN, 1e-320].map(|exposure| Estimate::rate(3, exposure)), [None; 3]);
    }
}
