//! Uncertainty of friction due to the limited scans of both bodies.
//!
//! Errors of the statistics of a scan have a joint distribution ([`JointErrors`]). Of all their combinations only the one counts
//! that changes friction: the errors are taken at their expected values given the change of ln μ, so that this change stands for all of
//! them. Differences between scans are projected in the same way. The scans of the surface and of the counterface have
//! independent errors, so each body has its own variables.

mod body;
pub(super) mod errors;

use self::body::Body;
use self::errors::{ScanErrors, StatisticErrors};
use super::points::ContactPoints;
use crate::chaos::UncertainInput;
use crate::distribution::Marginal;
use crate::stats::Interval;
use crate::study::check::VerdictStudy;
use crate::study::output::StageOutput;
use crate::study::uncertain::Place;
use crate::study::{Study, StudyError};
use crate::surface::pooling::{Mean, Reading, pool};
use crate::surface::profile::ProfileStatistics;
use crate::surface::scanned::{MapStatistics, ScannedSurface};
use crate::surface::uncertainty::{Estimate, JointErrors};
use asperity_base::numeric::dot;

/// Key of the error of the statistics of the scans of a body.
const SCAN: &str = "scan";
/// Key of the differences between the scans of a body.
const BETWEEN_SCANS: &str = "between_scans";
/// Solved points of the gradient of friction, for each body with a scan.
pub(super) const POINTS: usize = 6;
/// Change of ln μ below which an uncertain value has no effect.
const NEGLIGIBLE: f64 = 1e-9;
/// Standard deviation of ln μ up to which the errors of the scans are a factor of the friction coefficient, whatever the other values are.
/// Terms of second order are its square.
const FACTOR: f64 = 0.005;
/// Confidence level of the pooled change, of which only the standard errors are used.
const LEVEL: f64 = 0.95;

/// Returns whether the error of the mean friction by the pressed scan can stand for all errors of the scans, without further solutions: of a
/// machine of exact values, of whose bodies one is scanned once.
pub(super) fn is_in_mean(whole: &Study, study: &VerdictStudy) -> bool {
    let file = whole.file();
    let scans = file.surface.as_ref().map_or(0, |surface| surface.files().len());
    let others = file.counterface.as_ref().map_or(0, |counterface| counterface.files().len());
    study.places.is_empty() && scans == 1 && others == 0
}

/// Returns whether a value is the change of ln μ by the errors of scans, or by differences between them.
pub(super) fn is_change(place: Place) -> bool {
    [SCAN, BETWEEN_SCANS].contains(&place.key().name)
}

impl ScanErrors {
    /// Returns whether a value is a small change of ln μ by the errors of the scans, which needs no solved points.
    pub(super) fn is_factor(&self, place: Place) -> bool {
        self.inputs.iter().any(|(own, input, _)| *own == place && input.marginal().std() <= FACTOR)
    }

    /// Solves strips of bodies with other statistics, and finds what the scans leave uncertain.
    ///
    /// # Errors
    /// The strips have no solution, or the monitor cancelled.
    pub(super) fn new(points: &ContactPoints<'_>, output: &mut StageOutput) -> Result<Self, StudyError> {
        let mut found = Self::default();
        for body in [Body::Surface, Body::Counterface] {
            let scans = body.scans(points.surface);
            if !scans.is_empty() {
                let ln_friction = |errors| points.ln_friction(body.alone(errors));
                found.add(body, &scans, &ln_friction, points.mean_errors.scan, output)?;
            }
        }
        let file = points.study.file();
        if let Some((surface, counterface)) = file.surface.as_ref().zip(file.counterface.as_ref())
            && surface.files().iter().any(|file| counterface.files().contains(file))
        {
            output.warnings.push(
                "surface and counterface have a scan in common; its errors count as independent for the two bodies, which understates them"
                    .into(),
            );
        }
        Ok(found)
    }

    /// Adds what the scans of one body leave uncertain. `ln_friction` returns ln μ with errors of its statistics, and `error_of_parts` is the
    /// relative standard error of μ by the differences between the parts of the surface's scan.
    fn add(
        &mut self,
        body: Body,
        scans: &[Measurement],
        ln_friction: &dyn Fn(StatisticErrors) -> Result<f64, StudyError>,
        error_of_parts: f64,
        output: &mut StageOutput,
    ) -> Result<(), StudyError> {
        let Some(joint) = scans.iter().map(|scan| scan.joint).collect::<Option<Vec<_>>>() else {
            let instead = match body {
                Body::Surface if error_of_parts > 0.0 => "; the differences between its parts stand for them",
                _ => ", which the verdict takes as exact",
            };
            let text =
                format!("the scan contains too few correlation lengths for the errors of its statistics{instead}");
            output.warnings.push(body.warning(&text));
            return Ok(());
        };
        let mean = mean_of(&joint);
        let gradient = gradient(&mean, ln_friction)?;
        let own: Vec<f64> = joint.iter().map(|joint| quadratic(joint, &gradient).sqrt()).collect();
        let [scan_std, between_std] = match scans.len() {
            1 => [own[0], 0.0],
            _ => pooled(scans, &own, &gradient)?,
        };
        let unit = expected_errors(&mean, &gradient);
        for (key, std, unknown) in [(SCAN, scan_std, true), (BETWEEN_SCANS, between_std, false)] {
            let name = format!("{}.{key}", body.section());
            if let Some(place) = Place::latent(&name).filter(|_| std > NEGLIGIBLE) {
                let marginal = Marginal::Normal { mean: 0.0, std };
                let input = UncertainInput::new(&name, marginal, unknown);
                let input = input.map_err(|error| StudyError::Verdict(error.to_string()))?;
                self.inputs.push((place, input, body.alone(unit)));
            }
        }
        output.assumptions.push(body.sentence(scans.len(), scan_std, between_std));
        Ok(())
    }
}

/// Statistics of one scan or profile that friction depends on.
#[derive(Debug, Clone, Copy)]
struct Measurement {
    /// ln Sq, ln Sdq and Ssk.
    statistics: StatisticErrors,
    joint: Option<JointErrors>,
    area_m2: f64,
}

impl Measurement {
    fn new(map: &MapStatistics) -> Self {
        let parameters = &map.parameters;
        let statistics = [parameters.sq_m.ln(), parameters.sdq.unwrap_or(1.0).ln(), parameters.ssk];
        Self { statistics, joint: map.estimates.joint, area_m2: map.present_area_m2() }
    }

    /// Returns the scan, or all scans of the part.
    fn all_of(scan: &ScannedSurface) -> Vec<Self> {
        match &scan.part {
            Some(part) => part.statistics.scans.iter().map(|(_, statistics)| Self::new(statistics)).collect(),
            None => vec![Self::new(&scan.statistics)],
        }
    }

    /// Returns a profile, whose area is that of a line: it is the only measurement of its body.
    fn of_profile(profile: &ProfileStatistics) -> Self {
        let statistics = [profile.rq_m.ln(), profile.rdq.unwrap_or(1.0).ln(), profile.rsk];
        Self { statistics, joint: profile.joint, area_m2: 0.0 }
    }
}

/// Returns the gradient of ln μ with respect to the statistics of a scan, from differences over two standard errors.
fn gradient(
    mean: &JointErrors,
    ln_friction: &dyn Fn(StatisticErrors) -> Result<f64, StudyError>,
) -> Result<StatisticErrors, StudyError> {
    let mut gradient = [0.0; 3];
    for (place, slope) in gradient.iter_mut().enumerate() {
        let step = mean[place][place].sqrt();
        let at = |sign: f64| {
            let mut errors = [0.0; 3];
            errors[place] = sign * step;
            ln_friction(errors)
        };
        *slope = (at(1.0)? - at(-1.0)?) / (2.0 * step);
    }
    Ok(gradient)
}

/// Returns the expected errors given that ln μ is higher by 1: Σg/(gᵀΣg).
fn expected_errors(mean: &JointErrors, gradient: &StatisticErrors) -> StatisticErrors {
    product(mean, gradient).map(|error| error / quadratic(mean, gradient))
}

/// Returns the standard error of the change of ln μ that several scans determine together, and its standard deviation between them.
fn pooled(scans: &[Measurement], own: &[f64], gradient: &StatisticErrors) -> Result<[f64; 2], StudyError> {
    let readings: Vec<Reading> = scans
        .iter()
        .zip(own)
        .map(|(scan, &standard_error)| {
            let value = dot(&scan.statistics, gradient);
            let interval = Interval { low: value, high: value };
            let estimate = Estimate { value, surface: value, standard_error, interval, blocks: 1.0 };
            let estimate = Some(estimate).filter(|_| standard_error > 0.0);
            Reading { value, estimate, area_m2: scan.area_m2 }
        })
        .collect();
    let pooled = pool(&readings, Mean::Arithmetic, LEVEL).map_err(|error| StudyError::Verdict(error.to_string()))?;
    Ok([pooled.standard_error, pooled.between_std.unwrap_or(0.0)])
}

fn mean_of(joint: &[JointErrors]) -> JointErrors {
    let count = joint.len() as f64;
    std::array::from_fn(|i| std::array::from_fn(|j| joint.iter().map(|own| own[i][j]).sum::<f64>() / count))
}

fn product(covariance: &JointErrors, vector: &StatisticErrors) -> StatisticErrors {
    covariance.map(|row| dot(&row, vector))
}

/// Returns the variance of a linear combination of errors.
fn quadratic(covariance: &JointErrors, vector: &StatisticErrors) -> f64 {
    dot(&product(covariance, vector), vector).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Grid, HeightMap};
    use crate::random::stream;
    use crate::surface::preparation::Preparation;
    use asperity_testing::filtered_noise;
    use ndarray::Array2;

    /// Returns the scan of a random map with Gaussian spectrum, times a factor.
    fn scan(index: u64, factor: f64) -> ScannedSurface {
        let grid = Grid::new(128, 128, 1e-6, 1e-6).unwrap();
        let noise = filtered_noise(grid, &mut stream(3, "scan", index), |x, y| (-(x * x + y * y) / 800.0).exp());
        let heights_m = Array2::from_shape_vec(grid.shape(), noise).unwrap() * (factor * 1e-7);
        let map = HeightMap::new(grid, heights_m).unwrap();
        ScannedSurface::new(Preparation::default().apply(map).unwrap()).unwrap()
    }

    /// Returns the uncertain values of a body whose friction is inversely proportional to the slopes.
    fn elastic(body: Body, scan: &ScannedSurface) -> (ScanErrors, StageOutput) {
        let (mut found, mut output) = (ScanErrors::default(), StageOutput::default());
        found.add(body, &Measurement::all_of(scan), &|[_, slope, _]| Ok(-slope), 0.0, &mut output).unwrap();
        (found, output)
    }

    #[test]
    fn errors_along_the_gradient_have_the_variance_of_a_linear_friction() {
        let mean = [[4e-4, 1e-4, 2e-4], [1e-4, 9e-4, -1e-4], [2e-4, -1e-4, 25e-4]];
        let slopes = [0.2, -0.7, 0.05];
        let gradient = gradient(&mean, &|errors| Ok(0.3 + dot(&errors, &slopes))).unwrap();
        gradient.iter().zip(slopes).for_each(|(found, wanted)| assert!((found - wanted).abs() < 1e-12, "{found}"));
        // gᵀΣg, written out.
        let variance = 0.04 * 4e-4 + 0.49 * 9e-4 + 0.0025 * 25e-4 + 2.0 * (-0.14 * 1e-4 + 0.01 * 2e-4 + 0.035 * 1e-4);
        assert!((quadratic(&mean, &gradient) / variance - 1.0).abs() < 1e-9);
        let unit = expected_errors(&mean, &gradient);
        assert!((dot(&unit, &gradient) - 1.0).abs() < 1e-12);
        let along = (1e-4 * 0.2 - 9e-4 * 0.7 - 1e-4 * 0.05) / variance;
        assert!((unit[1] / along - 1.0).abs() < 1e-9, "{unit:?}");
    }

    #[test]
    fn the_scan_of_either_body_leaves_its_own_errors_uncertain() {
        let scan = scan(0, 1.0);
        let joint = scan.statistics.estimates.joint.unwrap();
        for (body, place, name) in [(Body::Surface, 0, "surface.scan"), (Body::Counterface, 1, "counterface.scan")] {
            let (found, output) = elastic(body, &scan);
            let [(at, input, errors)] = &found.inputs[..] else { panic!("{found:?}") };
            assert_eq!((at.name().as_str(), input.name(), input.is_unknown()), (name, name, true));
            // Friction changes by the error of the slopes, and the other body not at all.
            assert!((input.marginal().std() / joint[1][1].sqrt() - 1.0).abs() < 1e-9, "{input:?}");
            assert!((errors[place][1] + 1.0).abs() < 1e-9, "{errors:?}");
            assert!((errors[place][0] / errors[place][1] - joint[0][1] / joint[1][1]).abs() < 1e-9, "{errors:?}");
            assert_eq!(errors[1 - place], [0.0; 3]);
            let section = name.split_once('.').unwrap().0;
            assert!(output.assumptions[0].contains(&format!("skewness of the {section} are known from the scan")));
        }
    }

    #[test]
    fn scans_of_a_counterface_differ_beyond_their_errors() {
        let scans = [(0, 1.0), (1, 1.5)].map(|(index, factor)| (format!("{index}.npy"), scan(index, factor)));
        let part = ScannedSurface::from_scans(scans.to_vec()).unwrap();
        let (found, output) = elastic(Body::Counterface, &part);
        let names: Vec<_> = found.inputs.iter().map(|(_, input, _)| (input.name(), input.is_unknown())).collect();
        assert_eq!(names, [("counterface.scan", true), ("counterface.between_scans", false)]);
        // Two values that differ by ln 1.5 and by their errors.
        let error = scans.each_ref().map(|(_, scan)| scan.statistics.estimates.joint.unwrap()[1][1].sqrt());
        let std = found.inputs[1].1.marginal().std();
        assert!((std - 1.5_f64.ln() / 2.0_f64.sqrt()).abs() < 2.0 * error[0].hypot(error[1]), "{std} {error:?}");
        assert!(output.assumptions[0].contains("counterfaces differ by"), "{:?}", output.assumptions);
    }

    #[test]
    fn the_mean_of_covariances_is_taken_element_by_element() {
        let joint = [1.0, 2.0, 6.0].map(|own| [[own, 0.0, 0.5 * own], [0.0, 2.0 * own, 0.0], [0.5 * own, 0.0, own]]);
        assert_eq!(mean_of(&joint), [[3.0, 0.0, 1.5], [0.0, 6.0, 0.0], [1.5, 0.0, 3.0]]);
    }
}
