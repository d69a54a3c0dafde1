//! Sampled phase portraits, for plots.

use serde::{Deserialize, Serialize};

use super::cycle::locate;
use super::motion::Motion;
use super::trajectory::started;
use super::{Oscillator, Regime, TrajectorySettings, VibrationError};
use asperity_process::{Fluctuation, Steady};

/// Point of a phase portrait.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PhasePoint {
    /// Time τ.
    pub tau: f64,
    /// Displacement X.
    pub displacement: f64,
    /// Velocity X′.
    pub velocity: f64,
}

/// Returns one period of the limit cycle at `points` ≥ 2 equal times, from detachment to detachment if it sticks; none
/// without a cycle.
pub fn cycle_portrait(oscillator: &Oscillator, points: usize) -> Result<Option<Vec<PhasePoint>>, VibrationError> {
    let (Regime::Cycle(cycle), state) = locate(oscillator)? else { return Ok(None) };
    let motion = Motion::from_slip(oscillator, Steady, state)?;
    sampled(motion, state.tau, state.tau + cycle.period, points).map(Some)
}

/// Returns one trajectory at `points` ≥ 2 equal times from τ = `from` to the end.
///
/// Fails like [`super::Trajectory::simulate`], and if `from` is not between 0 and the duration.
pub fn trajectory_portrait(
    oscillator: &Oscillator,
    fluctuation: impl Fluctuation,
    settings: &TrajectorySettings,
    from: f64,
    points: usize,
) -> Result<Vec<PhasePoint>, VibrationError> {
    if !(from >= 0.0 && from < settings.duration && settings.duration.is_finite()) {
        return Err(VibrationError::Parameter { parameter: "from", value: from, wanted: "between 0 and the duration" });
    }
    sampled(started(oscillator, fluctuation, settings)?, from, settings.duration, points)
}

pub(super) fn sampled<F: Fluctuation>(
    mut motion: Motion<F>,
    from: f64,
    to: f64,
    points: usize,
) -> Result<Vec<PhasePoint>, VibrationError> {
    assert!(points >= 2, "a portrait has two points at least");
    let time = |i: usize| from + (to - from) * i as f64 / (points - 1) as f64;
    let mut portrait = Vec::with_capacity(points);
    while portrait.len() < points {
        motion.step(to)?;
        while portrait.len() < points && (time(portrait.len()) <= motion.tau || motion.tau >= to) {
            let tau = time(portrait.len());
            let (displacement, velocity) = motion.sample(tau);
            portrait.push(PhasePoint { tau, displacement, velocity });
        }
    }
    Ok(portrait)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Drive, Forcing, Trajectory, limit_cycle};
    use asperity_process::RecordedProcess;

    #[test]
    fn the_portrait_of_a_cycle_closes_and_touches_its_extremes() {
        let free = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let forced = Oscillator::with_stribeck(0.2, 4.2, 0.2, 0.1)
            .unwrap()
            .with_forcing(Some(Forcing { amplitude: 0.01, frequency: 0.98 }))
            .unwrap();
        for oscillator in [free, forced] {
            let cycle = *limit_cycle(&oscillator).unwrap().cycle().unwrap();
            let portrait = cycle_portrait(&oscillator, 4001).unwrap().unwrap();
            let (first, last) = (portrait[0], portrait[4000]);
            assert!((last.tau - first.tau - cycle.period).abs() < 1e-12);
            assert!((last.displacement - first.displacement).abs() < 1e-11);
            assert!((first.velocity - oscillator.belt_velocity()).abs() < 1e-15);
            // Between samples the extreme may be missed by half the curvature times a quarter of the squared spacing.
            let spacing = cycle.period / 4000.0;
            let highest = portrait.iter().map(|p| p.displacement).fold(f64::NEG_INFINITY, f64::max);
            let lowest = portrait.iter().map(|p| p.displacement).fold(f64::INFINITY, f64::min);
            let slowest = portrait.iter().map(|p| p.velocity).fold(f64::INFINITY, f64::min);
            let hidden = spacing * spacing * oscillator.static_friction();
            for (found, wanted) in
                [(highest, cycle.displacement_max), (lowest, cycle.displacement_min), (slowest, cycle.velocity_min)]
            {
                assert!((found - wanted).abs() < hidden, "{found} and {wanted}");
            }
            // The velocity is the derivative of the displacement, except at the two kinks of the velocity.
            let wrong = portrait
                .windows(3)
                .filter(|w| {
                    let slope = (w[2].displacement - w[0].displacement) / (2.0 * spacing);
                    (slope - w[1].velocity).abs() > 10.0 * hidden
                })
                .count();
            assert!(wrong <= 4, "{wrong} points");
        }
    }

    #[test]
    fn a_portrait_passes_through_the_events_of_its_trajectory_for_any_drive() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let values = (0..4000).map(|i| 0.002 * (f64::from(i) * 0.7).sin()).collect();
        let process = RecordedProcess::new(0.0005, values).unwrap();
        for drive in [Drive::Distance, Drive::Time] {
            let settings = TrajectorySettings { duration: 60.0, start: None, drive };
            let trajectory = Trajectory::simulate(&oscillator, process.path(), &settings).unwrap();
            let points = 6001;
            let portrait = trajectory_portrait(&oscillator, process.path(), &settings, 0.0, points).unwrap();
            assert!(trajectory.events.len() > 10);
            for event in &trajectory.events {
                let left = ((event.tau / 60.0) * (points - 1) as f64) as usize;
                let (a, b) = (portrait[left], portrait[left + 1]);
                let fraction = (event.tau - a.tau) / (b.tau - a.tau);
                let x = a.displacement + fraction * (b.displacement - a.displacement);
                // Error of a chord of spacing 0.01 in an orbit with accelerations below 0.01.
                assert!((x - event.displacement).abs() < 2e-7, "{drive:?}: {x} and {event:?}");
            }
        }
    }
}
