//! One trajectory under one realisation of the friction process.

use serde::{Deserialize, Serialize};

use super::motion::Motion;
use super::{Drive, Event, EventKind, Oscillator, VibrationError, positive};
use crate::friction::process::Fluctuation;

/// How a mass is followed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrajectorySettings {
    /// Time τ to follow.
    pub duration: f64,
    /// Displacement X at τ = 0, at the velocity of the belt; none: [`Oscillator::default_start`].
    pub start: Option<f64>,
    /// What the friction process is a function of.
    pub drive: Drive,
}

/// Counts of finished slips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Slips {
    /// Slips that reached ẋ < 0: the cycles.
    pub cycles: u64,
    /// Slips that stuck again before ẋ = 0.
    pub micro_slips: u64,
}

/// The events of one trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    /// Events in order.
    pub events: Vec<Event>,
    /// Finished slips.
    pub slips: Slips,
}

impl Trajectory {
    /// Follows a mass from rest on the belt under one realisation of m(s).
    ///
    /// Fails if the friction coefficient does not stay positive or a record is too short.
    pub fn simulate(
        oscillator: &Oscillator,
        fluctuation: impl Fluctuation,
        settings: &TrajectorySettings,
    ) -> Result<Self, VibrationError> {
        let mut events = Vec::new();
        let slips = follow(oscillator, fluctuation, settings, |event, _| events.push(event))?;
        Ok(Self { events, slips })
    }
}

/// Follows a mass and shows every event with the counts so far.
pub(super) fn follow(
    oscillator: &Oscillator,
    fluctuation: impl Fluctuation,
    settings: &TrajectorySettings,
    mut show: impl FnMut(Event, Slipped),
) -> Result<Slips, VibrationError> {
    positive("duration", settings.duration)?;
    let start = settings.start.unwrap_or_else(|| oscillator.default_start());
    let mut motion = Motion::new(oscillator, fluctuation, settings.drive, start)?;
    let mut slips = Slips::default();
    if let Some(event) = motion.first_event() {
        show(event, Slipped::Not);
    }
    while motion.tau < settings.duration {
        let Some(event) = motion.step(settings.duration)? else { continue };
        let mut slipped = Slipped::Not;
        if event.kind == EventKind::Restick {
            if motion.reached_backward {
                slips.cycles += 1;
                slipped = Slipped::Cycle;
            } else {
                slips.micro_slips += 1;
                slipped = Slipped::Micro;
            }
        }
        show(event, slipped);
    }
    Ok(slips)
}

/// What an event finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slipped {
    /// No slip.
    Not,
    /// A slip that reached ẋ < 0.
    Cycle,
    /// A slip that did not.
    Micro,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::process::RecordedProcess;

    #[test]
    fn a_frozen_realisation_gives_its_reference_events() {
        let Ok(folder) = std::env::var("ASPERITY_REFERENCE") else { return };
        let folder = std::path::Path::new(&folder).join("vibration");
        let reference: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(folder.join("frozen.json")).unwrap()).unwrap();
        // Numbers are stored as text with all their digits.
        let number = |key: &str| reference[key].to_string().trim_matches('"').parse::<f64>().unwrap();
        let values = doubles(&std::fs::read(folder.join("frozen_mu.npy")).unwrap());
        let oscillator = Oscillator::stribeck(number("mus"), number("a"), number("z"), number("nu")).unwrap();
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

    /// Little-endian doubles of a one-dimensional .npy file.
    fn doubles(bytes: &[u8]) -> Vec<f64> {
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        bytes[header..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }
}
