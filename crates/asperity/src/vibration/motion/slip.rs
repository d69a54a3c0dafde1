//! Slip: a Taylor step and its cuts.

use super::super::series::Loading;
use super::super::{Drive, Event, EventKind, Phase, VibrationError};
use super::{Motion, Segment};
use crate::friction::process::Fluctuation;

/// Points at which the friction coefficient is checked when a bound does not settle its sign.
const POSITIVITY_POINTS: usize = 32;

impl<F: Fluctuation> Motion<F> {
    /// One step of slip, to an arrival at v_rel = 0, a knot, the reach of the series, or `until`.
    pub(super) fn slip(&mut self, until: f64) -> Result<Option<Event>, VibrationError> {
        let direction = self.phase.direction();
        let remaining = until - self.tau;
        let (estimate, to_knot) = self.horizon();
        // A little more, so that the knot is inside the step.
        let wanted = remaining.min(if self.drive == Drive::Time { estimate } else { 1.1 * estimate });
        // The process changes with the sliding distance, or by itself.
        let (stretch, drift) = match self.drive {
            Drive::Distance => (self.cell.slope, 0.0),
            Drive::Time => (0.0, self.cell.slope),
        };
        let loading = Loading {
            base: direction - drift,
            kappa: 1.0 + stretch,
            swing: direction * self.sway.amplitude * self.sway.frequency,
            frequency: self.sway.frequency,
            phase: self.sway.frequency * self.tau,
        };
        self.segment =
            Segment { tau: self.tau, duration: 0.0, phase: self.phase, m: self.m, slope: self.cell.slope, e: self.e };
        self.series.expand(&self.weakening, &loading, self.w, self.e, wanted);
        let mut h = self.series.reach(wanted);
        // First the arrival, then the knot: past an arrival the distance would run backwards.
        let mut arrived = false;
        if let Some(t) = self.series.first_arrival(h) {
            (h, arrived) = (t, true);
        }
        let mut crossed = false;
        if self.drive == Drive::Time {
            crossed = !arrived && h >= to_knot;
        } else if to_knot.is_finite() && self.series.distance(h).0 >= to_knot {
            h = self.series.time_of_distance(to_knot, h, estimate);
            (crossed, arrived) = (true, false);
        }
        self.finish_slip(h, crossed, arrived, until)
    }

    /// About how long it takes to the next knot, and how far it is: in scaled distance or in time, after [`Drive`].
    #[inline]
    fn horizon(&self) -> (f64, f64) {
        let left = (self.cell.end - self.coordinate()) / self.velocity;
        if self.drive == Drive::Time {
            return (left.max(0.0), left.max(0.0));
        }
        if left == f64::INFINITY {
            return (left, left);
        }
        // At constant acceleration.
        let acceleration = self.weakening.acceleration(self.w, self.e);
        let discriminant = self.w * self.w + 2.0 * acceleration * left;
        (if discriminant > 0.0 { 2.0 * left / (self.w + discriminant.sqrt()) } else { f64::INFINITY }, left)
    }

    /// Moves to the end of a step of the length h.
    #[inline]
    fn finish_slip(
        &mut self,
        h: f64,
        crossed: bool,
        arrived: bool,
        until: f64,
    ) -> Result<Option<Event>, VibrationError> {
        let (before, rising) = (self.w, self.series.w()[1] > 0.0 || self.series.w()[0] == 0.0);
        let m_before = self.m;
        let (w, e) = self.series.state(h);
        self.segment.duration = h;
        self.tau = if h == until - self.tau { until } else { self.tau + h };
        self.e = e;
        self.w = if arrived { 0.0 } else { w.max(0.0) };
        if crossed && self.drive == Drive::Distance {
            self.sliding_distance = self.cell.end;
        } else {
            self.sliding_distance += self.velocity * self.series.distance(h).0;
        }
        self.m = if crossed { self.cell.right } else { self.cell.at(self.coordinate()) };
        let turns = rising && (arrived || self.weakening.acceleration(self.w, self.e) < 0.0);
        if self.phase == Phase::Slip && !self.reached_backward {
            self.reached_backward = self.w > 1.0
                || (turns
                    && self.series.ceiling(h) > 1.0
                    && self.series.first_extremum(h).is_some_and(|t| self.series.state(t).0 > 1.0));
        }
        self.check_friction(before, m_before, h, turns)?;
        if arrived {
            return self.arrive();
        }
        if crossed {
            self.next_cell()?;
            // At rest on the very knot the friction behind it decides.
            if self.w == 0.0 && self.e < 0.0 {
                return self.decide_at_rest();
            }
        }
        Ok(None)
    }

    /// Refuses a friction coefficient that is not positive somewhere in the last step.
    #[inline]
    fn check_friction(&self, w_before: f64, m_before: f64, h: f64, turns: bool) -> Result<(), VibrationError> {
        let fastest = if turns { self.series.ceiling(h) } else { w_before.max(self.w) };
        if self.law.coefficient(self.velocity * fastest) + m_before.min(self.m) > 0.0 {
            return Ok(());
        }
        for i in 0..=POSITIVITY_POINTS {
            let share = i as f64 / POSITIVITY_POINTS as f64;
            let w = self.series.state(share * h).0;
            let moved = match self.drive {
                Drive::Distance => self.series.distance(share * h).0 / self.series.distance(h).0.max(f64::MIN_POSITIVE),
                Drive::Time => share,
            };
            let coefficient = self.law.coefficient(self.velocity * w.max(0.0)) + m_before + moved * (self.m - m_before);
            if coefficient <= 0.0 {
                return Err(VibrationError::FrictionNotPositive {
                    coefficient,
                    tau: self.segment.tau + share * h,
                    sliding_distance: self.sliding_distance,
                });
            }
        }
        Ok(())
    }

    /// The relative speed is zero: stick if the force is within the limit, else slip on.
    fn arrive(&mut self) -> Result<Option<Event>, VibrationError> {
        // An arrival has W′ = e + jump ≤ 0; anything else is rounding at a grazing arrival.
        self.e = self.e.min(-self.weakening.jump);
        self.decide_at_rest()
    }

    /// What a mass does that slipped, is at W = 0 and lacks the force to slip on in its direction.
    fn decide_at_rest(&mut self) -> Result<Option<Event>, VibrationError> {
        if self.phase == Phase::OverSlip {
            self.e = self.opposite_excess();
        }
        self.phase = self.phase_at_rest()?;
        if self.phase == Phase::OverSlip {
            self.e = self.opposite_excess();
        }
        if self.phase == Phase::Stick { Ok(self.event(EventKind::Restick)) } else { Ok(self.event(EventKind::Reverse)) }
    }
}
