//! Machines of several tests.

use crate::{Oscillator, Parameters, VelocityLaw};

/// Returns a machine without forcing.
pub(crate) fn machine(static_friction: f64, law: VelocityLaw, damping_ratio: f64, belt_velocity: f64) -> Oscillator {
    Oscillator::new(Parameters { static_friction, law, damping_ratio, belt_velocity, forcing: None }).unwrap()
}
