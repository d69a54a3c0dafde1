//! What the scans leave uncertain of the friction.
//!
//! Errors of the statistics of a scan have a joint distribution ([`JointErrors`]). Of all their combinations only the one counts
//! that changes friction: the errors are taken at their expected values given the change of ln μ, so that one standard normal variable
//! stands for all of them. Differences between scans are projected in the same way.

use super::responses::ContactPoints;
use crate::chaos::UncertainInput;
use crate::distribution::Marginal;
use crate::stats::Interval;
use crate::study::StudyError;
use crate::study::output::StageOutput;
use crate::study::uncertain::Place;
use crate::surface::model::{SurfaceCovariance, SurfaceModel, SurfaceModelError, Variation};
use crate::surface::pooling::{Mean, Reading, pool};
use crate::surface::scanned::{MapStatistics, ScannedSurface};
use crate::surface::uncertainty::{Estimate, JointErrors};

/// Name of the error of the statistics of the scans.
pub(super) const SCAN: &str = "surface.scan";
/// Name of the differences between scans.
pub(super) const BETWEEN_SCANS: &str = "surface.between_scans";
/// Solved points of the gradient of friction.
pub(in crate::study) const POINTS: usize = 6;
/// Change of ln μ below which an uncertain value has no effect.
const NEGLIGIBLE: f64 = 1e-9;
/// Confidence level of the pooled change, of which only the standard errors are used.
const LEVEL: f64 = 0.95;

/// Errors of ln Sq, ln Sdq and Ssk.
pub(super) type StatisticErrors = [f64; 3];

/// Quantities of the surface that are measured on the scans and not stated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub(super) rms_height: bool,
    pub(super) covariance: bool,
    pub(super) marginal: bool,
}

impl Measured {
    /// Returns a surface whose scan had statistics with these errors.
    ///
    /// # Errors
    /// No surface has these statistics.
    pub(super) fn with_errors(
        self,
        surface: &SurfaceModel,
        [height, slope, skewness]: StatisticErrors,
    ) -> Result<SurfaceModel, SurfaceModelError> {
        let length_x_m = surface.covariance().map(SurfaceCovariance::length_x_m);
        surface.varied(&Variation {
            rms_height_m: self.rms_height.then(|| surface.marginal.std() * height.exp()),
            // Slopes are heights over lengths.
            correlation_length_m: length_x_m
                .filter(|_| self.covariance)
                .map(|length_m| length_m * (height - slope).exp()),
            skewness: None,
            skewness_change: self.marginal.then_some(skewness),
        })
    }
}

/// Uncertain values that stand for the errors of the scans, with the errors at one standard deviation.
#[derive(Debug, Clone, Default)]
pub(super) struct ScanErrors {
    pub(super) inputs: Vec<(Place, UncertainInput, StatisticErrors)>,
}

impl ScanErrors {
    /// Solves strips of surfaces with other statistics, and finds what the scans leave uncertain.
    ///
    /// # Errors
    /// The strips have no solution, or the monitor cancelled.
    pub(super) fn new(
        points: &ContactPoints<'_>,
        scan: &ScannedSurface,
        output: &mut StageOutput,
    ) -> Result<Self, StudyError> {
        let scans: Vec<&MapStatistics> = match &scan.part {
            Some(part) => part.statistics.scans.iter().map(|(_, statistics)| statistics).collect(),
            None => vec![&scan.statistics],
        };
        let Some(joint) = scans.iter().map(|scan| scan.estimates.joint).collect::<Option<Vec<_>>>() else {
            output.warnings.push(
                "the scan contains too few correlation lengths for the errors of its statistics, which the verdict takes as exact"
                    .into(),
            );
            return Ok(Self::default());
        };
        let mean = mean_of(&joint);
        let mut gradient = [0.0; 3];
        for (place, slope) in gradient.iter_mut().enumerate() {
            let step = mean[place][place].sqrt();
            let at = |sign: f64| {
                let mut errors = [0.0; 3];
                errors[place] = sign * step;
                points.ln_friction(errors)
            };
            *slope = (at(1.0)? - at(-1.0)?) / (2.0 * step);
        }
        let own: Vec<f64> = joint.iter().map(|joint| quadratic(joint, &gradient).sqrt()).collect();
        let [scan_std, between_std] = match scans.len() {
            1 => [own[0], 0.0],
            _ => pooled(&scans, &own, &gradient)?,
        };
        let unit = product(&mean, &gradient).map(|error| error / quadratic(&mean, &gradient));
        let mut inputs = Vec::new();
        for (name, std, unknown) in [(SCAN, scan_std, true), (BETWEEN_SCANS, between_std, false)] {
            if let Some(place) = Place::latent(name).filter(|_| std > NEGLIGIBLE) {
                let input = UncertainInput::new(name, Marginal::STANDARD_NORMAL, unknown);
                let input = input.map_err(|error| StudyError::Verdict(error.to_string()))?;
                inputs.push((place, input, unit.map(|error| error * std)));
            }
        }
        let percent = |std: f64| crate::study::sentence::digits(100.0 * std);
        output.assumptions.push(match scans.len() {
            1 => format!(
                "The verdict is for the part with this scan. Rms height, rms slope and skewness of the surface are known from the scan with an error \
                 that changes the friction coefficient by {} % (one standard deviation, unknown). Differences between parts are not known.",
                percent(scan_std)
            ),
            count => format!(
                "Rms height, rms slope and skewness of the surface are known from {count} scans with an error that changes the friction coefficient \
                 by {} % (one standard deviation, unknown). Beyond the errors of the scans, surfaces differ by {} %, which varies from part to part.",
                percent(scan_std),
                percent(between_std)
            ),
        });
        Ok(Self { inputs })
    }
}

/// Returns the standard error of the change of ln μ that several scans determine together, and its standard deviation between them.
fn pooled(scans: &[&MapStatistics], own: &[f64], gradient: &StatisticErrors) -> Result<[f64; 2], StudyError> {
    let readings: Vec<Reading> = scans
        .iter()
        .zip(own)
        .map(|(scan, &standard_error)| {
            let parameters = &scan.parameters;
            let statistics = [parameters.sq_m.ln(), parameters.sdq.unwrap_or(1.0).ln(), parameters.ssk];
            let value = dot(&statistics, gradient);
            let interval = Interval { low: value, high: value };
            let estimate = Estimate { value, surface: value, standard_error, interval, blocks: 1.0 };
            let area_m2 = scan.present_area_m2();
            Reading { value, estimate: Some(estimate).filter(|_| standard_error > 0.0), area_m2 }
        })
        .collect();
    let pooled = pool(&readings, Mean::Arithmetic, LEVEL).map_err(|error| StudyError::Verdict(error.to_string()))?;
    Ok([pooled.standard_error, pooled.between_std.unwrap_or(0.0)])
}

fn mean_of(joint: &[JointErrors]) -> JointErrors {
    let count = joint.len() as f64;
    std::array::from_fn(|i| std::array::from_fn(|j| joint.iter().map(|own| own[i][j]).sum::<f64>() / count))
}

fn dot(a: &StatisticErrors, b: &StatisticErrors) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn product(covariance: &JointErrors, vector: &StatisticErrors) -> StatisticErrors {
    covariance.map(|row| dot(&row, vector))
}

/// Returns the variance of a linear combination of errors.
fn quadratic(covariance: &JointErrors, vector: &StatisticErrors) -> f64 {
    dot(&product(covariance, vector), vector).max(0.0)
}
