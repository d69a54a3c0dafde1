//! Stick: the mass moves with the belt until the force reaches the limit.

use super::super::{Drive, Event, EventKind, Phase, VibrationError};
use super::{Motion, Segment, drift_rate};
use asperity_process::Fluctuation;

impl<F: Fluctuation> Motion<F> {
    /// Advances by one step of stick, to a release, a grid point of a process that depends on time, or `until`.
    pub(super) fn stick(&mut self, until: f64) -> Result<Option<Event>, VibrationError> {
        let rate = drift_rate(self.drive, self.cell.slope);
        self.segment =
            Segment { tau: self.tau, duration: 0.0, phase: Phase::Stick, m: self.m, slope: self.cell.slope, e: self.e };
        let to_grid_point = match self.drive {
            Drive::Distance => f64::INFINITY,
            Drive::Time => ((self.cell.end - self.coordinate()) / self.velocity).max(0.0),
        };
        let limit = (until - self.tau).min(to_grid_point);
        let forward = self.scaled.release(1.0, 1.0 - rate, self.e, self.tau, limit);
        let backward =
            self.scaled.release(-1.0, -1.0 - rate, self.opposite_excess(), self.tau, forward.unwrap_or(limit));
        let (h, released) = match (forward, backward) {
            (_, Some(t)) => (t, Some(Phase::OverSlip)),
            (Some(t), None) => (t, Some(Phase::Slip)),
            (None, None) => (limit, None),
        };
        self.e += self.scaled.growth(1.0, 1.0 - rate, self.tau, h);
        self.segment.duration = h;
        self.tau = if h == until - self.tau { until } else { self.tau + h };
        if self.drive == Drive::Time {
            if h >= to_grid_point && released.is_none() {
                self.next_cell()?;
                return self.stick_after_grid_point();
            }
            self.m = self.cell.at(self.coordinate());
            // Called only for its check of the friction coefficient.
            self.phase_at_rest()?;
        }
        let Some(phase) = released else { return Ok(None) };
        // At the release the excess is zero by definition.
        (self.w, self.e, self.phase) = (0.0, 0.0, phase);
        self.reached_backward = false;
        Ok(self.event(EventKind::Detach))
    }

    /// Continues after a grid point: a jump of friction may release the mass at once, with a nonzero excess.
    fn stick_after_grid_point(&mut self) -> Result<Option<Event>, VibrationError> {
        let phase = self.phase_at_rest()?;
        if phase == Phase::Stick {
            return Ok(None);
        }
        if phase == Phase::OverSlip {
            self.e = self.opposite_excess();
        }
        (self.w, self.phase) = (0.0, phase);
        self.reached_backward = false;
        Ok(self.event(EventKind::Detach))
    }
}
