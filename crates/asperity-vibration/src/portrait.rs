//! Sampled trajectories and phase portraits, for plots.

use serde::{Deserialize, Serialize};

use super::cycle::locate;
use super::motion::Motion;
use super::trajectory::{LARGEST_START, STEPS, start_of, started};
use super::{Drive, Event, Oscillator, Regime, TrajectorySettings, VibrationError};
use asperity_base::monitor::{Cancelled, Monitor, Silent};
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
    equally_sampled(motion, state.tau, state.tau + cycle.period, points).map(Some)
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
    equally_sampled(started(oscillator, fluctuation, settings)?, from, settings.duration, points)
}

/// Trajectory at given times, with its events.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SampledTrajectory {
    /// States at the times.
    pub points: Vec<PhasePoint>,
    /// Events in order.
    pub events: Vec<Event>,
}

impl SampledTrajectory {
    /// Simulates a mass that starts at `start` = (X, X′) at τ = 0, by default at [`Oscillator::default_start`] with the
    /// velocity of the belt, under one realisation of the friction process, to the last of the rising `times`.
    ///
    /// # Errors
    /// The times do not rise from 0 on or the start is too large. The friction coefficient does not stay positive, or a
    /// record is too short.
    pub fn simulate(
        oscillator: &Oscillator,
        fluctuation: impl Fluctuation,
        drive: Drive,
        start: Option<[f64; 2]>,
        times: &[f64],
        monitor: &dyn Monitor,
    ) -> Result<Self, VibrationError> {
        let end = times.last().copied().unwrap_or_default();
        let rises = times.is_sorted_by(|before, after| before < after);
        if !(times.first().is_some_and(|first| *first >= 0.0) && rises && end.is_finite()) {
            return Err(VibrationError::Parameter { parameter: "tau", value: end, wanted: "rising numbers from 0 on" });
        }
        let belt = oscillator.belt_velocity();
        let [displacement, velocity] = start.unwrap_or_else(|| [oscillator.default_start(), belt]);
        let settings = TrajectorySettings { duration: end, start: Some(displacement), drive };
        let displacement = start_of(oscillator, &settings)?;
        if !(-LARGEST_START..=LARGEST_START).contains(&(velocity / belt)) {
            let wanted = "finite and at most 1e9 times the velocity of the belt";
            return Err(VibrationError::Parameter { parameter: "start velocity", value: velocity, wanted });
        }
        let motion = Motion::started_at(oscillator, fluctuation, drive, [displacement, velocity])?;
        let mut events: Vec<Event> = motion.first_event().filter(|_| velocity == belt).into_iter().collect();
        let points = sampled(motion, |place| times[place], end, times.len(), monitor, |event| events.push(event))?;
        Ok(Self { points, events })
    }
}

/// Returns the states of a motion at the times `time(0)` … `time(points − 1)` up to `to`, and passes on its events.
fn sampled<F: Fluctuation>(
    mut motion: Motion<F>,
    time: impl Fn(usize) -> f64,
    to: f64,
    points: usize,
    monitor: &dyn Monitor,
    mut on_event: impl FnMut(Event),
) -> Result<Vec<PhasePoint>, VibrationError> {
    let mut portrait = Vec::with_capacity(points);
    let mut steps = 0_u32;
    while portrait.len() < points {
        steps = steps.wrapping_add(1);
        if steps.is_multiple_of(STEPS) && monitor.cancelled() {
            return Err(Cancelled.into());
        }
        motion.step(to)?.into_iter().for_each(&mut on_event);
        while portrait.len() < points && (time(portrait.len()) <= motion.tau || motion.tau >= to) {
            let tau = time(portrait.len());
            let (displacement, velocity) = motion.sample(tau);
            portrait.push(PhasePoint { tau, displacement, velocity });
        }
    }
    Ok(portrait)
}

/// Returns the states of a motion at `points` ≥ 2 equal times.
pub(super) fn equally_sampled<F: Fluctuation>(
    motion: Motion<F>,
    from: f64,
    to: f64,
    points: usize,
) -> Result<Vec<PhasePoint>, VibrationError> {
    assert!(points >= 2, "a portrait has two points at least");
    let time = |place: usize| from + (to - from) * place as f64 / (points - 1) as f64;
    sampled(motion, time, to, points, &Silent, |_| ())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EventKind, Forcing, Trajectory, limit_cycle};
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

    #[test]
    fn a_trajectory_may_start_at_any_state_and_has_the_events_of_the_simulation() {
        // Coulomb friction without damping: X′ from below the belt velocity swings about μ on a circle.
        let coulomb = Oscillator::with_stribeck(0.2, 0.0, 0.0, 1.0).unwrap();
        let times: Vec<f64> = (0..=600).map(|i| 0.01 * f64::from(i)).collect();
        let start = Some([0.7, 0.3]);
        let found = SampledTrajectory::simulate(&coulomb, Steady, Drive::Distance, start, &times, &Silent).unwrap();
        for point in &found.points {
            let (sin, cos) = point.tau.sin_cos();
            assert!((point.displacement - (0.2 + 0.5 * cos + 0.3 * sin)).abs() < 1e-12, "{point:?}");
            assert!((point.velocity - (0.3 * cos - 0.5 * sin)).abs() < 1e-12, "{point:?}");
        }
        assert!(found.events.is_empty());
        // Faster than the belt, friction pulls back until the mass has the velocity of the belt.
        let fast = SampledTrajectory::simulate(&coulomb, Steady, Drive::Distance, Some([-0.4, 1.5]), &times, &Silent);
        let fast = fast.unwrap();
        // About −0.2: X = −0.2 − 0.2 cos τ + 1.5 sin τ until X′ = 1.
        let arrival = fast.events[0];
        let (sin, cos) = arrival.tau.sin_cos();
        assert!((0.2 * sin + 1.5 * cos - 1.0).abs() < 1e-12 && arrival.kind != EventKind::Detach, "{arrival:?}");

        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let settings = TrajectorySettings { duration: 6.0, start: None, drive: Drive::Distance };
        let wanted = Trajectory::simulate(&oscillator, Steady, &settings).unwrap();
        let found = SampledTrajectory::simulate(&oscillator, Steady, Drive::Distance, None, &times, &Silent).unwrap();
        assert_eq!(found.events, wanted.events);
        for times in [&[][..], &[1.0, 1.0], &[-1.0, 2.0], &[0.0, f64::NAN]] {
            let refused = SampledTrajectory::simulate(&oscillator, Steady, Drive::Distance, None, times, &Silent);
            assert!(matches!(refused, Err(VibrationError::Parameter { parameter: "tau", .. })), "{times:?}");
        }
    }
}
