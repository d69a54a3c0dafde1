//! What is prescribed at a level of the friction stage.

use crate::contact::Control;
use crate::distribution::Marginal;
use crate::study::file::FrictionSection;
use crate::study::pressure_stage::plane;
use crate::study::result::Prescribed;
use crate::study::sentence;

/// What is prescribed at a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LevelControl {
    /// One plane in space, above which this percentage of the ensemble's heights lies.
    Percentile(f64),
    /// The mean pressure on every strip, in pascal.
    MeanPressure(f64),
    /// The depth of the plane below the highest point of every strip, in metre.
    Penetration(f64),
    /// The mean pressure that the normal force makes on the nominal area, in pascal.
    Nominal(f64),
}

/// Which level leads: is shown in full, and handed to the vibration stage.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lead {
    /// The one pressed hardest: there is no vibration stage.
    Deepest,
    /// The percentile that the study names.
    Percentile(f64),
    /// One more level, at this mean pressure in pascal.
    NominalPressure(f64),
}

impl LevelControl {
    /// The levels that a section states, and the one at the nominal pressure where it leads.
    pub(super) fn of(section: &FrictionSection, lead: Lead) -> Vec<Self> {
        let percentiles = section.percentiles().iter().map(|percent| Self::Percentile(*percent));
        let pressures = section.mean_pressures.iter().map(|pressure| Self::MeanPressure(pressure.0));
        let penetrations = section.penetrations.iter().map(|depth| Self::Penetration(depth.0));
        let nominal = match lead {
            Lead::NominalPressure(pascal) => Some(Self::Nominal(pascal)),
            _ => None,
        };
        percentiles.chain(pressures).chain(penetrations).chain(nominal).collect()
    }

    /// What the solver is told; `marginal` is the law of the ensemble's heights.
    pub(super) fn contact(self, marginal: &Marginal) -> Control {
        match self {
            Self::Percentile(percent) => plane(marginal, percent),
            Self::MeanPressure(pascal) | Self::Nominal(pascal) => Control::MeanPressure { pascal },
            Self::Penetration(metre) => Control::Penetration { metre },
        }
    }

    /// The level in words.
    pub(super) fn name(self) -> String {
        match self {
            Self::Percentile(percent) => format!("percentile {percent}"),
            Self::MeanPressure(pascal) => format!("the mean pressure {}", sentence::si(pascal, "Pa")),
            Self::Penetration(metre) => format!("the penetration {}", sentence::si(metre, "m")),
            Self::Nominal(_) => "the nominal pressure".into(),
        }
    }

    /// Its name in results.
    pub(super) fn key(self) -> Prescribed {
        match self {
            Self::Percentile(_) => Prescribed::Percentile,
            Self::MeanPressure(_) | Self::Nominal(_) => Prescribed::MeanPressure,
            Self::Penetration(_) => Prescribed::Penetration,
        }
    }

    /// Its column in the table of traces.
    pub(super) fn column(self) -> String {
        match self {
            Self::Percentile(percent) => format!("mu_p{percent}").replace('.', "_"),
            Self::MeanPressure(pascal) => format!("mu_pressure_{pascal:e}_pa"),
            Self::Penetration(metre) => format!("mu_penetration_{metre:e}_m"),
            Self::Nominal(_) => "mu_load".into(),
        }
    }

    /// The percentile, where it is one.
    pub(super) fn percentile(self) -> Option<f64> {
        if let Self::Percentile(percent) = self { Some(percent) } else { None }
    }
}

impl Lead {
    /// Index of the level that leads, of levels with these mean pressures in pascal.
    pub(super) fn among(self, levels: &[(LevelControl, f64)]) -> usize {
        let deepest = || (0..levels.len()).max_by(|a, b| levels[*a].1.total_cmp(&levels[*b].1));
        let wanted = match self {
            Self::Deepest => None,
            Self::Percentile(percent) => levels.iter().position(|(level, _)| level.percentile() == Some(percent)),
            Self::NominalPressure(pascal) => {
                levels.iter().position(|(level, _)| *level == LevelControl::Nominal(pascal))
            }
        };
        wanted.or_else(deepest).unwrap_or(0)
    }
}
