//! Dense output inside the last step.

use super::super::polynomial::{self, bracketed_zero};
use super::super::structure::tangent::Step;
use super::super::{Drive, Phase};
use super::{Motion, Segment, drift_rate};
use asperity_process::Fluctuation;

impl<F: Fluctuation> Motion<F> {
    /// Returns (X, X′) at a time inside the last step.
    pub(crate) fn sample(&self, tau: f64) -> (f64, f64) {
        let Segment { tau: start, phase, m, slope, e, .. } = self.segment;
        let t = tau - start;
        if phase == Phase::Stick {
            let drift = match self.drive {
                Drive::Distance => 0.0,
                Drive::Time => slope * self.velocity * t,
            };
            let excess = e + self.scaled.growth(1.0, 1.0 - drift_rate(self.drive, slope), start, t);
            return (self.displacement_of(tau, phase, excess, m + drift), self.velocity);
        }
        let (w, e) = self.series.state(t);
        let moved = match self.drive {
            Drive::Distance => self.series.distance(t).0,
            Drive::Time => t,
        };
        let m = m + slope * self.velocity * moved;
        (self.displacement_of(tau, phase, e, m), self.velocity * (1.0 - phase.direction() * w))
    }

    /// Returns the times in the last step at which X′ is zero or extreme, and its ends. Displacement and velocity have
    /// their extremes there.
    pub(crate) fn turning_times(&self) -> Vec<f64> {
        let Segment { tau, duration, phase, .. } = self.segment;
        let mut cuts = vec![0.0];
        if phase != Phase::Stick {
            cuts.extend(self.series.extrema(duration));
        }
        cuts.push(duration);
        if phase == Phase::Slip {
            // W is monotonic between the cuts and passes 1, where X′ = 0, at most once in each interval.
            for i in 1..cuts.len() {
                let (low, high) = (cuts[i - 1], cuts[i]);
                let excess = |t| {
                    let (w, slope) = polynomial::value_and_slope(self.series.w(), t);
                    (w - 1.0, slope)
                };
                let (first, last) = (excess(low).0, excess(high).0);
                if first * last < 0.0 {
                    cuts.push(bracketed_zero(excess, low, high, first > 0.0, 0.5 * (low + high)));
                }
            }
        }
        cuts.into_iter().map(|t| tau + t).collect()
    }

    /// Returns whether W exceeded a level in the last step, if the mass was slower than the belt.
    pub(crate) fn exceeds(&self, level: f64) -> bool {
        let Segment { duration, phase, .. } = self.segment;
        phase == Phase::Slip && (self.w > level || self.series.exceeds(level, duration))
    }

    /// Returns the last time in the last step at which the mass turned from moving backwards to moving forward. Returns
    /// none if the mass does not move forward in slip at the end.
    pub(crate) fn turned_forward(&self) -> Option<f64> {
        let Segment { tau, duration, phase, .. } = self.segment;
        if phase != Phase::Slip || self.w >= 1.0 {
            return None;
        }
        let excess = |t| {
            let (w, slope) = polynomial::value_and_slope(self.series.w(), t);
            (w - 1.0, slope)
        };
        // W is monotonic between its extrema.
        let mut high = duration;
        for low in self.series.extrema(duration).into_iter().rev().chain([0.0]) {
            if excess(low).0 >= 0.0 {
                return Some(tau + bracketed_zero(excess, low, high, true, 0.5 * (low + high)));
            }
            high = low;
        }
        None
    }

    /// Returns the last step, if it was slip or over-slip.
    pub(crate) fn slip_step(&self) -> Option<Step<'_>> {
        let Segment { duration: length, phase, .. } = self.segment;
        (phase != Phase::Stick).then_some(Step { series: &self.series, length })
    }

    /// Returns whether W passed a minimum above zero in the last step: W fell at its start and rises at its end.
    pub(crate) fn passed_minimum(&self) -> bool {
        self.segment.phase == Phase::Slip
            && self.phase == Phase::Slip
            && self.series.w()[1] < 0.0
            && self.weakening.acceleration(self.w, self.e) > 0.0
    }

    /// Returns whether the mass, without forcing and fluctuation, slides steadily within the tolerance (W = 1, W′ = 0)
    /// or creeps there.
    pub(crate) fn has_settled(&self, tolerance: f64) -> bool {
        let rate = self.weakening.acceleration(self.w, self.e);
        let settled = (self.w - 1.0).abs() < tolerance && rate.abs() < tolerance;
        self.phase == Phase::Slip && (settled || self.weakening.creeps(self.w, rate))
    }
}
