//! How often the cycle is lost and found.

use serde::{Deserialize, Serialize};

use super::passage::Passage;
use crate::law::Marginal;
use crate::stats::wilson_interval;

/// Share of the second half that a sustained cycle holds at least.
const SUSTAINED: f64 = 0.5;

/// Events per unit of τ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Events per time.
    pub value: f64,
    /// 95 % interval of a Poisson count, exact (Garwood 1936).
    pub interval: [f64; 2],
}

impl Rate {
    /// The rate of `events` in the time `exposure`; none without exposure.
    pub(super) fn of(events: u64, exposure: f64) -> Option<Self> {
        if exposure.is_nan() || exposure <= 0.0 {
            return None;
        }
        // Half the quantiles of χ² with twice the count of degrees of freedom.
        let quantile =
            |shape: f64, probability| Marginal::Gamma { shape, scale: 1.0, shift: 0.0 }.quantile(probability);
        let count = events as f64;
        let low = if events == 0 { 0.0 } else { quantile(count, 0.025) };
        Some(Self { value: count / exposure, interval: [low / exposure, quantile(count + 1.0, 0.975) / exposure] })
    }
}

/// A share of the trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// The share.
    pub value: f64,
    /// 95 % interval (Wilson).
    pub interval: [f64; 2],
}

impl Share {
    pub(in crate::vibration) fn of(count: u64, total: u64) -> Self {
        let interval = wilson_interval(count as usize, total as usize);
        Self { value: count as f64 / total as f64, interval: [interval.low, interval.high] }
    }
}

/// First passages between the cycle and steady sliding, over all trajectories, which begin on the cycle.
///
/// The cycle is lost when the mass slips for three natural periods without finishing a slip to ẋ < 0; it was left with the last
/// one. It is found again with the end of the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Passages {
    /// Trajectories that are counted.
    pub trajectories: u64,
    /// Ways out of the cycle.
    pub exits: u64,
    /// Ways back.
    pub entries: u64,
    /// Share of the time in the cycle.
    pub share_in_cycle: f64,
    /// Exits per time in the cycle.
    pub exit_rate: Option<Rate>,
    /// Entries per time out of it.
    pub entry_rate: Option<Rate>,
    /// Share of the trajectories that leave the cycle at all.
    pub left: Share,
    /// Share of the trajectories that are in the cycle for at least half of the second half of their time.
    pub sustained: Share,
    /// Times τ at which trajectories leave the cycle first, rising; those that do not are no part.
    pub first_exits: Vec<f64>,
    #[serde(skip)]
    sums: Sums,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sums {
    sustained: u64,
    inside: f64,
    outside: f64,
}

impl Passages {
    pub(super) const EMPTY: Self = Self {
        trajectories: 0,
        exits: 0,
        entries: 0,
        share_in_cycle: f64::NAN,
        exit_rate: None,
        entry_rate: None,
        left: Share { value: f64::NAN, interval: [0.0, 1.0] },
        sustained: Share { value: f64::NAN, interval: [0.0, 1.0] },
        first_exits: Vec::new(),
        sums: Sums { sustained: 0, inside: 0.0, outside: 0.0 },
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
    }

    /// Draws the conclusions after the last trajectory.
    pub(super) fn conclude(&mut self) {
        let Sums { sustained, inside, outside } = self.sums;
        self.share_in_cycle = inside / (inside + outside);
        self.exit_rate = Rate::of(self.exits, inside);
        self.entry_rate = Rate::of(self.entries, outside);
        if self.trajectories > 0 {
            self.left = Share::of(self.first_exits.len() as u64, self.trajectories);
            self.sustained = Share::of(sustained, self.trajectories);
        }
        self.first_exits.sort_by(f64::total_cmp);
    }

    /// Share of the trajectories that have not left the cycle up to τ, at most their duration.
    pub fn survival(&self, tau: f64) -> Share {
        let gone = self.first_exits.partition_point(|exit| *exit <= tau) as u64;
        Share::of(self.trajectories - gone, self.trajectories)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_survives_in_what_has_not_left_it() {
        let passages = Passages { trajectories: 8, first_exits: vec![1.0, 2.0, 2.0, 7.5], ..Passages::EMPTY };
        for (tau, wanted) in [(0.0, 8), (0.99, 8), (1.0, 7), (2.0, 5), (7.0, 5), (9.0, 4)] {
            let share = passages.survival(tau);
            assert_eq!(share, Share::of(wanted, 8));
            assert!(share.interval[0] < share.value && share.value <= share.interval[1]);
        }
    }

    #[test]
    fn poisson_intervals_are_the_tabulated_ones() {
        // Garwood, Biometrika 28 (1936) 437: 95 % limits of a mean after counts of 0, 1, 10 and 50.
        for (count, low, high) in [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.390), (50, 37.11, 65.92)] {
            let rate = Rate::of(count, 2.0).unwrap();
            assert_eq!(rate.value, count as f64 / 2.0);
            assert!((2.0 * rate.interval[0] - low).abs() < 5e-3 && (2.0 * rate.interval[1] - high).abs() < 5e-3);
        }
        assert_eq!(Rate::of(3, 0.0), None);
    }
}
