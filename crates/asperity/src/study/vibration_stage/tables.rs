//! Tables of the vibration stage.

use crate::distribution::Marginal;
use crate::friction::process::FrictionProcess;
use crate::monitor::Monitor;
use crate::stats::Histogram;
use crate::study::Table;
use crate::study::result::{DisplacementHistogram, EnsembleResult, PhaseCloud, Portrait, Survival};
use crate::vibration::{
    EnsembleSettings, Estimate, Oscillator, Passages, PhasePoint, SampleDistribution, VibrationError, phase_cloud,
};

/// Number of times at which the surviving fraction is tabulated.
const SURVIVAL_POINTS: usize = 201;

/// Returns the ensembles over the damping ratio; what they have in common does not name the upscaling.
pub(super) fn damping_table(paper: &EnsembleResult, area: &EnsembleResult) -> Table {
    const COMMON: [&str; 2] = ["damping_ratio", "cycles_deterministic"];
    let columns = [("paper", paper), ("area", area)].map(|(upscaling, result)| {
        let columns = Table::of(&result.damping).into_columns().into_iter();
        columns.map(move |(name, values)| match COMMON.contains(&name.as_str()) {
            true => (name, values),
            false => (format!("{upscaling}_{name}"), values),
        })
    });
    let [paper, area] = columns;
    Table::new(paper.chain(area.filter(|(name, _)| !COMMON.contains(&name.as_str()))))
}

/// Returns a histogram of points and the normal density of equal mean and standard deviation; `None` for too few
/// points.
pub fn points_table(points: &SampleDistribution) -> Option<Table> {
    let histogram = Histogram::new(&points.sample).ok()?;
    let centres = histogram.centres();
    let normal = Marginal::normal(points.mean, points.std).ok();
    let normal_density = normal.map_or_else(Vec::new, |normal| centres.iter().map(|x| normal.pdf(*x)).collect());
    let curves = DisplacementHistogram {
        displacement: centres.into(),
        density: histogram.density().into(),
        normal_density: normal_density.into(),
    };
    Some(curves.into())
}

/// Returns the fraction of the trajectories that have never left vibration over time, with 95 % intervals: `tau`,
/// `share`, `share_low`, `share_high`.
pub fn survival_table(passages: &Passages, duration: f64) -> Table {
    let time = |i: usize| duration * i as f64 / (SURVIVAL_POINTS - 1) as f64;
    let fractions: Vec<Estimate> = (0..SURVIVAL_POINTS).map(|i| passages.survival(time(i))).collect();
    let column = |of: fn(&Estimate) -> f64| fractions.iter().map(of).collect();
    Table::from(Survival {
        tau: (0..SURVIVAL_POINTS).map(time).collect(),
        share: column(|fraction| fraction.value),
        share_low: column(|fraction| fraction.interval[0]),
        share_high: column(|fraction| fraction.interval[1]),
    })
}

/// Returns a phase portrait: `tau`, `displacement`, `velocity`.
pub fn portrait_table(points: &[PhasePoint]) -> Table {
    let column = |of: fn(&PhasePoint) -> f64| points.iter().map(of).collect();
    Table::from(Portrait {
        tau: column(|p| p.tau),
        displacement: column(|p| p.displacement),
        velocity: column(|p| p.velocity),
    })
}

/// Returns the ends of the first `most` trajectories of an ensemble, slightly more than a natural period of each,
/// without failed ones: `trajectory` and the columns of [`portrait_table`].
///
/// # Errors
/// Settings out of range, or cancelled.
pub fn cloud_table(
    oscillator: &Oscillator,
    process: &FrictionProcess,
    settings: &EnsembleSettings,
    most: usize,
    monitor: &dyn Monitor,
) -> Result<Table, VibrationError> {
    let curves = phase_cloud(oscillator, process, settings, most, monitor)?;
    let numbered = curves.into_iter().enumerate();
    let points: Vec<(usize, PhasePoint)> =
        numbered.flat_map(|(index, curve)| curve.into_iter().flatten().map(move |point| (index, point))).collect();
    let column = |of: fn(&PhasePoint) -> f64| points.iter().map(|(_, point)| of(point)).collect();
    Ok(Table::from(PhaseCloud {
        trajectory: points.iter().map(|(index, _)| *index as f64).collect(),
        tau: column(|p| p.tau),
        displacement: column(|p| p.displacement),
        velocity: column(|p| p.velocity),
    }))
}
