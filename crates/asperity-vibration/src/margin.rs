//! Distance of a machine's damping from the damping at which its vibration ends.

use crate::critical::limit_above;
use crate::{Oscillator, VibrationError, critical_damping};

/// Margins of the damping ratio of an oscillator without fluctuation and forcing. A machine with a negative margin vibrates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampingMargins {
    /// ζ − ζ_v: negative if a machine vibrates whose motion begins in stick.
    pub from_stick: f64,
    /// ζ − ζ_H: negative if a machine vibrates that slides steadily at first.
    pub from_steady_sliding: f64,
}

impl DampingMargins {
    /// Computes the margins of an oscillator, ignoring its forcing.
    ///
    /// # Errors
    /// The search for a limit failed.
    pub fn new(oscillator: &Oscillator) -> Result<Self, VibrationError> {
        let ends = critical_damping(oscillator)?;
        let damping = oscillator.damping_ratio();
        Ok(Self {
            from_stick: damping - limit_above(oscillator, &ends)?,
            from_steady_sliding: damping - ends.hopf_damping_ratio,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Linear;
    use crate::tests::machine;
    use crate::{VelocityLaw, limit_damping};

    #[test]
    fn a_jump_of_friction_separates_the_margins() {
        // Closed form for a jump of .05 at V = .05 and a weakening b = .1: ζ_v = .05782911613766 + b/2, ζ_H = b/2.
        let law = VelocityLaw::Linear(Linear { kinetic: 0.25, slope: 0.1 });
        let of = |damping_ratio| {
            let law = law.clone();
            machine(0.3, law, damping_ratio, 0.05)
        };
        for damping in [0.0, 0.04, 0.08, 0.2] {
            let margins = DampingMargins::new(&of(damping)).unwrap();
            assert!((margins.from_stick - (damping - 0.107_829_116_137_66)).abs() < 1e-12, "{margins:?}");
            assert!((margins.from_steady_sliding - (damping - 0.05)).abs() < 1e-15, "{margins:?}");
            assert_eq!(margins.from_stick, damping - limit_damping(&of(0.3)).unwrap());
        }
    }
}
