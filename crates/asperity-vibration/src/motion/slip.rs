//! Slip: a Taylor step and its end.

use super::super::arrival::Turning;
use super::super::weakening::Loading;
use super::super::{Drive, Event, EventKind, Phase, VibrationError};
use super::{Motion, Segment};
use asperity_process::Fluctuation;

/// Reason for the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cut {
    /// The reach of the series or the requested time.
    None,
    /// An arrival at v_rel = 0.
    Arrival,
    /// A grid point of the friction process.
    GridPoint,
    /// A point of a tabulated law, at this W.
    Point(f64),
}

/// Number of points at which the friction coefficient is checked when a bound does not decide its sign.
const POSITIVITY_POINTS: usize = 32;

impl<F: Fluctuation> Motion<F> {
    /// Advances by one step of slip, to an arrival at v_rel = 0, a grid point, the reach of the series, or `until`.
    pub(super) fn slip(&mut self, until: f64) -> Result<Option<Event>, VibrationError> {
        let direction = self.phase.direction();
        let remaining = until - self.tau;
        // The process depends on the sliding distance or on time.
        let (stretch, drift) = match self.drive {
            Drive::Distance => (self.cell.slope, 0.0),
            Drive::Time => (0.0, self.cell.slope),
        };
        let loading = Loading {
            base: direction - drift,
            kappa: 1.0 + stretch,
            swing: direction * self.scaled.amplitude * self.scaled.frequency,
            frequency: self.scaled.frequency,
            phase: self.scaled.frequency * self.tau,
        };
        self.weakening.select(self.w, self.e, &loading);
        let (estimate, to_grid_point) = self.horizon();
        // Slightly longer, so that the grid point is inside the step.
        let wanted = remaining.min(if self.drive == Drive::Time { estimate } else { 1.1 * estimate });
        self.segment =
            Segment { tau: self.tau, duration: 0.0, phase: self.phase, m: self.m, slope: self.cell.slope, e: self.e };
        self.series.expand(&self.weakening, &loading, self.w, self.e, wanted);
        let (h, turning) = (self.series.reach(wanted), Turning::new(&self.weakening, &loading));
        if self.drive == Drive::Distance
            && to_grid_point.is_finite()
            && let Some(t) = self.series.near_distance(to_grid_point, h, estimate)
        {
            let (w, e) = self.series.state(t);
            let a = self.weakening.acceleration(w, e);
            if self.series.stays(&turning, t, w, a) {
                return self.finish_slip(t, (w, e, a), Cut::GridPoint, (until, turning.is_simple(t)));
            }
        }
        // Arrivals are searched before grid points: after an arrival the distance would run backwards.
        let reached = self.series.first_arrival(&self.weakening, &turning, h);
        let (mut h, mut cut) = (reached.t, if reached.arrived { Cut::Arrival } else { Cut::None });
        if let Some(bounds) = self.weakening.bounds()
            && let Some((t, level)) = self.series.first_exit(bounds, h)
        {
            (h, cut) = (t, Cut::Point(level));
        }
        if self.drive == Drive::Time {
            if cut != Cut::Arrival && h >= to_grid_point {
                cut = Cut::GridPoint;
            }
        } else if to_grid_point.is_finite() && self.series.distance(h).0 >= to_grid_point {
            (h, cut) = (self.series.time_of_distance(to_grid_point, h), Cut::GridPoint);
        }
        let (w, e) = reached.state.filter(|_| h == reached.t).unwrap_or_else(|| self.series.state(h));
        let w = match cut {
            Cut::Arrival => 0.0,
            Cut::Point(level) => level,
            Cut::None | Cut::GridPoint => w.max(0.0),
        };
        self.finish_slip(h, (w, e, self.weakening.acceleration(w, e)), cut, (until, turning.is_simple(h)))
    }

    /// Returns the approximate time to the next grid point and the distance to it, in scaled distance or in time
    /// depending on [`Drive`].
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

    /// Moves to the end of a step of length h, where W, e and W′ are given. In a simple step W has at most one
    /// extremum.
    #[inline]
    fn finish_slip(
        &mut self,
        h: f64,
        (w, e, a): (f64, f64, f64),
        cut: Cut,
        (until, simple): (f64, bool),
    ) -> Result<Option<Event>, VibrationError> {
        let (arrived, crossed) = (cut == Cut::Arrival, cut == Cut::GridPoint);
        let [before, slope] = self.series.start();
        // A force may turn W more than once in a step.
        let turns = self.scaled.amplitude > 0.0 || ((slope > 0.0 || before == 0.0) && (arrived || a < 0.0));
        let m_before = self.m;
        self.segment.duration = h;
        self.tau = if h == until - self.tau { until } else { self.tau + h };
        (self.w, self.e) = (w, e);
        if crossed && self.drive == Drive::Distance {
            self.sliding_distance = self.cell.end;
        } else {
            self.sliding_distance += self.velocity * self.series.distance(h).0;
        }
        self.m = if crossed { self.cell.right } else { self.cell.at(self.coordinate()) };
        if self.phase == Phase::Slip && !self.reached_backward {
            self.reached_backward = self.w > 1.0 || ((turns || !simple) && self.series.exceeds(1.0, h));
        }
        self.check_friction(before, m_before, h, turns)?;
        if arrived {
            return self.arrive();
        }
        if crossed {
            self.next_cell()?;
            // At rest exactly at the grid point, the friction after it determines the phase.
            if self.w == 0.0 && self.e < 0.0 {
                return self.decide_at_rest();
            }
        }
        Ok(None)
    }

    /// Fails if the friction coefficient is not positive everywhere in the last step.
    #[inline]
    fn check_friction(&self, w_before: f64, m_before: f64, h: f64, turns: bool) -> Result<(), VibrationError> {
        // Most laws are positive at any speed; with m ≥ 0 the coefficient is then positive too.
        if self.law.is_positive() && m_before >= 0.0 && self.m >= 0.0 {
            return Ok(());
        }
        let fastest = if turns { self.series.ceiling(h) } else { w_before.max(self.w) };
        if self.law.least_coefficient(self.velocity * fastest) + m_before.min(self.m) > 0.0 {
            return Ok(());
        }
        let whole = self.series.distance(h).0;
        for i in 0..=POSITIVITY_POINTS {
            let fraction = i as f64 / POSITIVITY_POINTS as f64;
            let w = self.series.state(fraction * h).0;
            let distance = self.series.distance(fraction * h).0;
            let moved = match self.drive {
                Drive::Distance => distance / whole.max(f64::MIN_POSITIVE),
                Drive::Time => fraction,
            };
            let fluctuation = m_before + moved * (self.m - m_before);
            let coefficient = self.law.coefficient(self.velocity * w.max(0.0)) + fluctuation;
            if coefficient <= 0.0 {
                return Err(VibrationError::FrictionNotPositive {
                    coefficient,
                    fluctuation,
                    tau: self.segment.tau + fraction * h,
                    sliding_distance: self.sliding_distance - self.velocity * (whole - distance),
                });
            }
        }
        Ok(())
    }

    /// Decides at zero relative speed: stick if the force is within the limit, otherwise slip continues.
    fn arrive(&mut self) -> Result<Option<Event>, VibrationError> {
        // An arrival has W′ = e + jump ≤ 0; any other value is rounding at a grazing arrival.
        self.e = self.e.min(-self.weakening.jump);
        self.decide_at_rest()
    }

    /// Decides the phase of a slipping mass at W = 0 whose force is too small to continue slip in its direction.
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
