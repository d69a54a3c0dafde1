//! Trajectory under one realisation of the friction process.

use serde::{Deserialize, Serialize};

use super::motion::Motion;
use super::{Drive, Event, EventKind, Oscillator, VibrationError, positive};
use asperity_base::monitor::{Cancelled, Monitor, Silent};
use asperity_process::Fluctuation;

/// Largest displacement at the start in units of μ_st + 2ζV; the rounding of a larger one would change the first slip.
pub(super) const LARGEST_START: f64 = 1e9;

/// Settings of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrajectorySettings {
    /// Duration τ.
    pub duration: f64,
    /// Displacement X at τ = 0, at the velocity of the belt; [`Oscillator::default_start`] if none.
    pub start: Option<f64>,
    /// Independent variable of the friction process.
    pub drive: Drive,
}

/// Counts of finished slips. A slip ends when the mass sticks, or when it returns from over-slip without stick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Slips {
    /// Slips that reached ẋ < 0: the cycles.
    pub cycles: u64,
    /// Slips that stuck again before ẋ = 0.
    pub micro_slips: u64,
}

/// Events of one trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    /// Events in order.
    pub events: Vec<Event>,
    /// Finished slips.
    pub slips: Slips,
}

impl Trajectory {
    /// Simulates a mass from rest on the belt under one realisation of m(s).
    ///
    /// Fails if the friction coefficient does not stay positive or a record is too short.
    pub fn simulate(
        oscillator: &Oscillator,
        fluctuation: impl Fluctuation,
        settings: &TrajectorySettings,
    ) -> Result<Self, VibrationError> {
        let mut events = Events(Vec::new());
        let slips = follow(oscillator, fluctuation, settings, f64::INFINITY, &Silent, &mut events)?;
        Ok(Self { events: events.0, slips })
    }
}

/// Returns the motion at τ = 0.
pub(super) fn started<F: Fluctuation>(
    oscillator: &Oscillator,
    fluctuation: F,
    settings: &TrajectorySettings,
) -> Result<Motion<F>, VibrationError> {
    positive("duration", settings.duration)?;
    Motion::new(oscillator, fluctuation, settings.drive, start_of(oscillator, settings)?)
}

/// Returns the displacement X at τ = 0.
pub(super) fn start_of(oscillator: &Oscillator, settings: &TrajectorySettings) -> Result<f64, VibrationError> {
    let start = settings.start.unwrap_or_else(|| oscillator.default_start());
    let unit = oscillator.static_friction() + 2.0 * oscillator.damping_ratio() * oscillator.belt_velocity();
    if start.abs() <= LARGEST_START * unit {
        Ok(start)
    } else {
        let wanted = "finite and at most 1e9 times μ_st + 2ζV";
        Err(VibrationError::Parameter { parameter: "start", value: start, wanted })
    }
}

/// Number of steps between two checks of the monitor.
pub(super) const STEPS: u32 = 16_384;

/// Receives the events of one trajectory.
pub(super) trait Observer {
    /// Receives an event and the kind of slip that it finished.
    fn on_event(&mut self, event: Event, slipped: Slipped);

    /// Receives the time at which a swing of the velocity past the swing level ended, X′ = 0.
    fn on_swing(&mut self, _tau: f64) {}
}

/// Ignores all events.
pub(super) struct NoObserver;

impl Observer for NoObserver {
    fn on_event(&mut self, _: Event, _: Slipped) {}
}

/// Stores all events.
struct Events(Vec<Event>);

impl Observer for Events {
    fn on_event(&mut self, event: Event, _: Slipped) {
        self.0.push(event);
    }
}

/// Follows a mass, passes its events to `observer` and counts its slips.
///
/// The observer also receives the swings of the velocity during which W = |v_rel|/V exceeds `swing_level`, unless they end in stick
/// or over-slip; see [`super::settled::swing_level`].
pub(super) fn follow(
    oscillator: &Oscillator,
    fluctuation: impl Fluctuation,
    settings: &TrajectorySettings,
    swing_level: f64,
    monitor: &dyn Monitor,
    observer: &mut impl Observer,
) -> Result<Slips, VibrationError> {
    let mut motion = started(oscillator, fluctuation, settings)?;
    let mut slips = Slips::default();
    if let Some(event) = motion.first_event() {
        observer.on_event(event, Slipped::Not);
    }
    let mut swings = false;
    let mut steps = 0_u32;
    while motion.tau < settings.duration {
        steps = steps.wrapping_add(1);
        if steps.is_multiple_of(STEPS) && monitor.cancelled() {
            return Err(Cancelled.into());
        }
        if let Some(event) = motion.step(settings.duration)? {
            let slipped = Slipped::new(event.kind, motion.is_over_slipping(), motion.reached_backward);
            if slipped != Slipped::Not {
                motion.reached_backward = false;
            }
            slips.add(slipped);
            observer.on_event(event, slipped);
            swings = false;
        } else if swing_level.is_finite() {
            swings |= motion.exceeds(swing_level);
            if swings && let Some(tau) = motion.turned_forward() {
                observer.on_swing(tau);
                swings = false;
            }
        }
    }
    Ok(slips)
}

/// Kind of slip that an event finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slipped {
    /// No slip.
    Not,
    /// A slip that reached ẋ < 0.
    Cycle,
    /// A slip that did not.
    Micro,
}

impl Slipped {
    /// Returns the kind of slip that an event finished, given whether the mass is now faster than the belt and whether it moved
    /// backwards since its last slip was finished.
    #[inline(always)]
    pub(super) fn new(kind: EventKind, over_slips: bool, reached_backward: bool) -> Self {
        match kind {
            EventKind::Restick if !reached_backward => Self::Micro,
            EventKind::Restick => Self::Cycle,
            // Over-slip may still end in stick, so the slip before it ends with it.
            EventKind::Reverse if !over_slips && reached_backward => Self::Cycle,
            EventKind::Reverse | EventKind::Detach => Self::Not,
        }
    }
}

impl Slips {
    /// Counts a finished slip.
    #[inline(always)]
    pub(super) fn add(&mut self, slipped: Slipped) {
        match slipped {
            Slipped::Not => {}
            Slipped::Cycle => self.cycles += 1,
            Slipped::Micro => self.micro_slips += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Linear;
    use crate::tests::machine;
    use crate::{VelocityLaw, limit_cycle, trajectory_portrait};
    use asperity_process::{FrictionProcess, ProcessModel, RecordedProcess, Steady};

    #[test]
    fn a_frozen_realisation_gives_its_reference_events() {
        let Ok(folder) = std::env::var("ASPERITY_REFERENCE") else {
            println!("skipped: ASPERITY_REFERENCE names no folder");
            return;
        };
        let folder = std::path::Path::new(&folder).join("vibration");
        let reference: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(folder.join("frozen.json")).unwrap()).unwrap();
        // Numbers are stored as text with all their digits.
        let number = |key: &str| reference[key].to_string().trim_matches('"').parse::<f64>().unwrap();
        let values = doubles(&std::fs::read(folder.join("frozen_mu.npy")).unwrap());
        let oscillator = Oscillator::with_stribeck(number("mus"), number("a"), number("z"), number("nu")).unwrap();
        let process = RecordedProcess::new(number("h_s"), values).unwrap();
        let settings =
            TrajectorySettings { duration: number("tau_end"), start: Some(number("X_start")), drive: Drive::Distance };
        let found = Trajectory::simulate(&oscillator, process.path(), &settings).unwrap();
        let wanted = reference["events_mp"].as_array().unwrap();
        let mut worst = 0.0_f64;
        for (event, wanted) in found.events.iter().zip(wanted) {
            let text = |i: usize| wanted[i].as_str().unwrap();
            assert_eq!(event.kind.code(), text(0));
            for (value, i) in [(event.tau, 1), (event.displacement, 2), (event.sliding_distance, 3)] {
                worst = worst.max((value - text(i).parse::<f64>().unwrap()).abs());
            }
        }
        assert!(worst < 1e-10, "largest difference {worst:e}");
        println!("largest difference {worst:e}");
        assert_eq!(Some(found.slips.cycles), reference["counts"]["macro_slips_Vmin_negative"].as_u64());
        let sticks = found.events.iter().filter(|e| e.kind == EventKind::Restick).count() as u64;
        assert_eq!(Some(sticks), reference["counts"]["reattachments"].as_u64());
    }

    fn noisy(std: f64, index: u64) -> RecordedProcess {
        let model = ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01);
        let process = FrictionProcess::new(model).unwrap();
        let mut path = process.path(21, index);
        RecordedProcess::new(process.step(), (0..8000).map(|_| path.next_value()).collect()).unwrap()
    }

    #[test]
    fn a_slip_is_a_cycle_if_the_mass_moves_backwards_in_it() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let process = noisy(0.006, 0);
        for drive in [Drive::Distance, Drive::Time] {
            let settings = TrajectorySettings { duration: 300.0, start: None, drive };
            let trajectory = Trajectory::simulate(&oscillator, process.path(), &settings).unwrap();
            let portrait = trajectory_portrait(&oscillator, process.path(), &settings, 0.0, 300_001).unwrap();
            let mut counted = Slips::default();
            for pair in trajectory.events.windows(2).filter(|pair| pair[1].kind == EventKind::Restick) {
                let inside = portrait.iter().filter(|p| p.tau > pair[0].tau && p.tau < pair[1].tau);
                let slowest = inside.map(|p| p.velocity).fold(f64::INFINITY, f64::min);
                if slowest < 0.0 { counted.cycles += 1 } else { counted.micro_slips += 1 }
            }
            assert_eq!(trajectory.slips, counted);
            assert!(counted.cycles > 10 && counted.micro_slips > 0, "{drive:?}: {counted:?}");
        }
    }

    #[test]
    fn a_record_that_ends_and_friction_without_sign_are_errors() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let settings = TrajectorySettings { duration: 60.0, start: None, drive: Drive::Distance };
        let run = |values: Vec<f64>| {
            Trajectory::simulate(&oscillator, RecordedProcess::new(0.01, values).unwrap().path(), &settings)
        };
        assert!(matches!(run(vec![0.0; 4]), Err(VibrationError::ProcessTooShort { .. })));
        assert!(matches!(run(vec![-0.11; 60]), Err(VibrationError::FrictionNotPositive { tau: 0.0, .. })));
        let falling = (0..60).map(|i| -0.005 * f64::from(i)).collect();
        assert!(matches!(run(falling), Err(VibrationError::FrictionNotPositive { tau, .. }) if tau > 1.0));
        for start in [f64::NAN, -1e160, -1e10, 1e50, f64::INFINITY] {
            let error =
                Trajectory::simulate(&oscillator, Steady, &TrajectorySettings { start: Some(start), ..settings });
            assert!(matches!(error, Err(VibrationError::Parameter { parameter: "start", .. })), "{start}: {error:?}");
        }
        // A linear law has no positive value at the speed of the mass.
        let law = VelocityLaw::Linear(Linear { kinetic: 0.4, slope: 0.3 });
        let fast = limit_cycle(&machine(0.4, law, 0.1, 1.0));
        let Err(error @ VibrationError::FrictionNotPositive { .. }) = fast else { panic!("{fast:?}") };
        assert!(error.to_string().contains("slope"), "{error}");
    }

    /// Returns the little-endian doubles of a one-dimensional .npy file.
    fn doubles(bytes: &[u8]) -> Vec<f64> {
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        bytes[header..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }
}
