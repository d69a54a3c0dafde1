//! Levels of contact: prescribed quantities, and the level of operation.

use asperity_base::sentence;
use asperity_contact::Control;
use serde::Serialize;

/// Prescribed quantity of a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum LevelControl {
    /// One plane in space, with this percentage of the ensemble's heights above it.
    Percentile(f64),
    /// Mean pressure on every strip in pascal.
    MeanPressure(f64),
    /// Depth of the plane below the highest point of every strip in metre.
    Penetration(f64),
    /// Mean pressure of the normal force on the nominal area in pascal.
    Nominal(f64),
}

/// Level at which the friction is reported in full and passed on to the vibration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum OperatingLevel {
    /// Level of the largest mean pressure.
    Deepest,
    /// Level of this percentile.
    Percentile(f64),
    /// Further level at this nominal pressure in pascal.
    NominalPressure(f64),
}

impl LevelControl {
    /// Returns the control of the contact solver; `height_quantile_m` is the quantile of the ensemble's heights in metre at a
    /// probability.
    pub fn contact(self, height_quantile_m: impl Fn(f64) -> f64) -> Control {
        match self {
            Self::Percentile(percent) => Control::Plane { height_m: height_quantile_m(1.0 - percent / 100.0) },
            Self::MeanPressure(pascal) | Self::Nominal(pascal) => Control::MeanPressure { pascal },
            Self::Penetration(metre) => Control::Penetration { metre },
        }
    }

    /// Returns the prescribed number: per cent, pascal or metre.
    pub fn value(self) -> f64 {
        let (Self::Percentile(value) | Self::MeanPressure(value) | Self::Penetration(value) | Self::Nominal(value)) =
            self;
        value
    }

    /// Returns a name for sentences.
    pub fn name(self) -> String {
        match self {
            Self::Percentile(percent) => format!("percentile {percent}"),
            Self::MeanPressure(pascal) => format!("the mean pressure {}", sentence::si(pascal, "Pa")),
            Self::Penetration(metre) => format!("the penetration {}", sentence::si(metre, "m")),
            Self::Nominal(_) => "the nominal pressure".into(),
        }
    }

    /// Returns the percentile; `None` for the other controls.
    pub fn percentile(self) -> Option<f64> {
        if let Self::Percentile(percent) = self { Some(percent) } else { None }
    }
}

impl OperatingLevel {
    /// Returns the index of the operating level among levels with these mean pressures in pascal.
    pub fn index_in(self, levels: &[(LevelControl, f64)]) -> usize {
        let is_wanted = |level: LevelControl| match self {
            Self::Deepest => false,
            Self::Percentile(percent) => level.percentile() == Some(percent),
            Self::NominalPressure(pascal) => level == LevelControl::Nominal(pascal),
        };
        let deepest = || (0..levels.len()).max_by(|a, b| levels[*a].1.total_cmp(&levels[*b].1));
        levels.iter().position(|(level, _)| is_wanted(*level)).or_else(deepest).unwrap_or(0)
    }
}
