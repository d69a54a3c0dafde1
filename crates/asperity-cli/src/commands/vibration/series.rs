//! Results of the library as tables of a report folder.

use std::f64::consts::TAU;

use asperity::friction::process::FrictionProcess;
use asperity::law::Marginal;
use asperity::monitor::{Cancelled, Monitor};
use asperity::stats::Histogram;
use asperity::study::Table;
use asperity::vibration::{
    EnsembleSettings, Method, Oscillator, PhasePoint, SampleLaw, TrajectorySettings, VibrationError, cycle_portrait,
    trajectory_portrait,
};
use rayon::prelude::*;

/// Points of a drawn limit cycle.
const CYCLE_POINTS: usize = 600;
/// Trajectories of a cloud, points of each, and the time τ that they cover: a little more than a natural period.
const CLOUD: usize = 200;
const CLOUD_POINTS: usize = 72;
const CLOUD_SPAN: f64 = 1.1 * TAU;

/// A phase portrait.
pub(super) fn portrait(points: &[PhasePoint]) -> Table {
    let column = |of: fn(&PhasePoint) -> f64| points.iter().map(of).collect::<Vec<f64>>();
    Table::new([
        ("tau", column(|p| p.tau)),
        ("displacement", column(|p| p.displacement)),
        ("velocity", column(|p| p.velocity)),
    ])
}

/// The limit cycle without fluctuation, if there is one.
pub(super) fn cycle(oscillator: &Oscillator) -> Result<Option<(&'static str, Table)>, VibrationError> {
    Ok(cycle_portrait(oscillator, CYCLE_POINTS)?.map(|points| ("limit_cycle", portrait(&points))))
}

/// The end of the first trajectories of an ensemble, without those that it leaves out.
pub(super) fn cloud(
    oscillator: &Oscillator,
    process: &FrictionProcess,
    settings: &EnsembleSettings,
    monitor: &dyn Monitor,
) -> Result<Table, VibrationError> {
    let EnsembleSettings { duration, start, drive, seed, .. } = *settings;
    let followed = TrajectorySettings { duration, start, drive, method: Method::Taylor };
    let from = (duration - CLOUD_SPAN).max(0.0);
    let curves: Vec<Result<Vec<PhasePoint>, VibrationError>> = (0..settings.trajectories.min(CLOUD))
        .into_par_iter()
        .map(|index| {
            if monitor.cancelled() {
                return Err(Cancelled.into());
            }
            trajectory_portrait(oscillator, process.path(seed, index as u64), &followed, from, CLOUD_POINTS)
        })
        .collect();
    let mut columns = [(); 4].map(|()| Vec::with_capacity(CLOUD * CLOUD_POINTS));
    for (index, curve) in curves.into_iter().enumerate() {
        let points = match curve {
            Ok(points) => points,
            Err(VibrationError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(_) => continue,
        };
        for point in points {
            let row = [index as f64, point.tau, point.displacement, point.velocity];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
    }
    Ok(Table::new(["trajectory", "tau", "displacement", "velocity"].into_iter().zip(columns)))
}

/// Histogram of points beside the normal density of equal mean and standard deviation; none of too few points.
pub(super) fn histogram(points: &SampleLaw) -> Option<Table> {
    let histogram = Histogram::of(&points.sample).ok()?;
    let centres = histogram.centres();
    let mut columns = vec![("density", histogram.density())];
    if let Ok(normal) = Marginal::normal(points.mean, points.std) {
        columns.push(("normal_density", centres.iter().map(|x| normal.pdf(*x)).collect()));
    }
    columns.push(("displacement", centres));
    Some(Table::new(columns).led_by("displacement"))
}
