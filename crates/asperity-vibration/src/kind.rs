//! Kinds of motion.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Kind of motion that an oscillator settles into. Every kind except [`MotionKind::None`] is vibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// The mass sticks to the belt in every period.
    StickSlip,
    /// The mass passes the velocity of the belt (the relative velocity changes its sign) and never sticks.
    Overtaking,
    /// The mass stays slower than the belt throughout the period.
    SlipCycle,
    /// Steady sliding.
    None,
}

impl MotionKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::StickSlip, Self::Overtaking, Self::SlipCycle, Self::None];

    /// Returns the name in results and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::StickSlip => "stick_slip",
            Self::Overtaking => "overtaking",
            Self::SlipCycle => "slip_cycle",
            Self::None => "none",
        }
    }

    /// Returns whether the motion is vibration.
    pub fn is_vibration(self) -> bool {
        self != Self::None
    }
}

impl fmt::Display for MotionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_match_the_serialised_form() {
        for kind in MotionKind::ALL {
            assert_eq!(serde_json::to_string(&kind).unwrap(), format!("\"{}\"", kind.name()));
        }
    }
}
