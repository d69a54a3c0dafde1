//! Solved strips at the values of a study file.

use super::scan::errors::{BodyErrors, Measured, ScanErrors, StatisticErrors};
use crate::friction::replicates::{LevelMoments, MomentReplicates};
use crate::friction::{LevelControl, MeanErrors, OperatingLevel};
use crate::monitor::{Cancelled, Monitor, Quiet};
use crate::study::friction_strips::solve_level;
use crate::study::surface_stage::SurfaceStage;
use crate::study::uncertain::Point;
use crate::study::{Study, StudyError};
use crate::surface::model::{CovarianceRequest, Measurable, SurfaceModel, SurfaceModelError, SurfaceRequest};

/// Smallest number of strips per point.
const LEAST_STRIPS: usize = 4;

/// Strips of a study at other values, all drawn from the same random numbers.
pub(super) struct ContactPoints<'a> {
    pub(super) study: &'a Study,
    pub(super) surface: &'a SurfaceStage,
    /// The central values.
    pub(super) central: &'a Point,
    /// Errors of the statistics of the scans of both bodies.
    pub(super) scan: ScanErrors,
    /// Errors of the mean friction at the central values.
    pub(super) mean_errors: &'a MeanErrors,
    pub(super) monitor: &'a dyn Monitor,
}

impl ContactPoints<'_> {
    pub(super) fn seed(&self) -> u64 {
        self.study.seed()
    }

    /// Solves the strips of one point at its operating level.
    pub(super) fn solve(&self, point: &Point) -> Result<Option<MomentReplicates>, StudyError> {
        let mut errors = BodyErrors::default();
        for (place, _, unit) in &self.scan.inputs {
            let change = place.value_in(point).unwrap_or(0.0);
            let pairs = errors.iter_mut().flatten().zip(unit.iter().flatten());
            pairs.for_each(|(error, unit)| *error += change * unit);
        }
        self.solve_with_errors(point, errors, true)
    }

    /// Returns ln μ at the central values, of bodies whose scans had statistics with these errors.
    pub(super) fn ln_friction(&self, errors: BodyErrors) -> Result<f64, StudyError> {
        let solved = self.solve_with_errors(self.central, errors, false)?;
        Ok(solved.map_or(LevelMoments::NONE, |solved| solved.all).mean.ln())
    }

    fn solve_with_errors(
        &self,
        point: &Point,
        errors: BodyErrors,
        with_stiffness: bool,
    ) -> Result<Option<MomentReplicates>, StudyError> {
        if self.monitor.cancelled() {
            return Err(Cancelled.into());
        }
        let mut point = point.clone();
        // Friction is proportional to it.
        let proportional = self.study.verdict.as_ref().and_then(|verdict| verdict.proportional);
        if let Some((place, value)) = proportional.and_then(|place| Some((place, place.value_in(self.central)?))) {
            place.set(&mut point, value);
        }
        let own = point.file.check()?;
        let (Some(friction), Some(vibration), Some(surface)) = (&own.friction, &own.vibration, &own.surface) else {
            return Ok(None);
        };
        let mut model = self.surface.model.clone();
        if own.surface != self.study.surface {
            let stated = surface.request.clone();
            let request = self.surface.profile.as_ref().map_or_else(|| stated.clone(), |own| own.state(stated.clone()));
            model.surface = SurfaceModel::new(request, self.surface.measured.as_ref())?.0;
        }
        let [of_surface, of_counterface] = errors;
        vary(&mut model.surface, &surface.request, of_surface)?;
        if let Some((model, counterface)) = model.counterface.as_mut().zip(own.counterface.as_ref()) {
            vary(model, &counterface.request, of_counterface)
                .map_err(|error| StudyError::from(error).of_counterface())?;
        }
        let level = match own.operating_level() {
            OperatingLevel::Percentile(percentile) => LevelControl::Percentile(percentile),
            OperatingLevel::NominalPressure(pascal) => LevelControl::Nominal(pascal),
            OperatingLevel::Deepest => LevelControl::Nominal(vibration.machine.nominal_contact().pressure_pa),
        };
        let strips = (strips_per_point(friction.realisations), self.mean_errors.pitch_factor);
        solve_level(friction, &model, level, strips, with_stiffness, own.seed(), &Quiet(self.monitor))
    }
}

/// Returns the number of strips at each point.
pub(super) fn strips_per_point(realisations: usize) -> usize {
    LEAST_STRIPS.max(realisations.div_ceil(2))
}

/// Changes a body to one whose scan had statistics with these errors.
fn vary(model: &mut SurfaceModel, request: &SurfaceRequest, errors: StatisticErrors) -> Result<(), SurfaceModelError> {
    if errors != [0.0; 3] {
        *model = measured(request).with_errors(model, errors)?;
    }
    Ok(())
}

/// Returns the properties that a request measures on the scans.
fn measured(request: &SurfaceRequest) -> Measured {
    match request {
        SurfaceRequest::Translated { rms_height_m, covariance, marginal, .. } => Measured {
            rms_height: *rms_height_m == Measurable::Measured,
            covariance: matches!(covariance, CovarianceRequest::Measured | CovarianceRequest::Empirical),
            marginal: *marginal == Measurable::Measured,
        },
        SurfaceRequest::WeierstrassMandelbrot { rms_height_m, .. } => {
            Measured { rms_height: *rms_height_m == Measurable::Measured, covariance: false, marginal: false }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::UncertainInput;
    use crate::distribution::Marginal;
    use crate::map::Grid;
    use crate::monitor::Silent;
    use crate::random::stream;
    use crate::study::surface_stage;
    use crate::study::uncertain::Place;
    use asperity_testing::filtered_noise;
    use ndarray::Array2;

    const TEXT: &str = "seed = 1\n[surface]\nfile = \"scan.npy\"\npixel_size = \"1 um\"\nheight_unit = \"m\"\n\
        generator = \"spectral\"\ncovariance = \"squared_exponential\"\ncorrelation_length = \"10 um\"\nmarginal = \"normal\"\n\
        [material]\nyoungs_modulus = \"10 GPa\"\npoisson_ratio = 0.25\nhardness = \"1 GPa\"\nshear_strength = \"100 MPa\"\n\
        [friction]\nboundary = \"periodic\"\nstrip = [\"640 um\", \"64 um\"]\npoints = [160, 16]\nwindow = \"64 um\"\nrealisations = 8\n\
        [vibration]\nmass = \"1 kg\"\nnatural_frequency = \"100 Hz\"\nnormal_force = \"500 N\"\nnominal_area = \"25 mm^2\"\n\
        belt_velocity = \"20 mm/s\"\ndamping_ratio = 0.03\nstribeck = \"0.3 s/m\"\n";

    #[test]
    fn only_measured_statistics_have_errors() {
        let own = "covariance = \"squared_exponential\"\ncorrelation_length = \"10 um\"\n";
        for (surface, wanted) in [
            (format!("{own}marginal = \"normal\"\n"), [true, false, false]),
            (format!("{own}rms_height = \"1 um\"\nmarginal = \"normal\"\n"), [false, false, false]),
            (own.to_owned(), [true, false, true]),
            ("covariance = \"measured\"\nmarginal = \"normal\"\n".into(), [true, true, false]),
        ] {
            let stated = format!("{own}marginal = \"normal\"\n");
            let study = Study::parse(&TEXT.replace(&stated, &surface), "study.toml").unwrap();
            let Measured { rms_height, covariance, marginal } = measured(&study.surface.as_ref().unwrap().request);
            assert_eq!([rms_height, covariance, marginal], wanted, "{surface}");
        }
    }

    /// Returns a folder with the scan of the study.
    fn scanned() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
        let noise = filtered_noise(grid, &mut stream(3, "scan", 0), |x, y| (-(x * x + y * y) / 200.0).exp());
        let heights_m = Array2::from_shape_vec(grid.shape(), noise).unwrap() * 1e-7;
        let bytes = asperity_formats::write_npy(&asperity_formats::Scan::new(heights_m, None));
        std::fs::write(folder.path().join("scan.npy"), bytes).unwrap();
        folder
    }

    #[test]
    #[ignore = "slow"]
    fn friction_follows_the_errors_of_a_scan() {
        let folder = scanned();
        let study = Study::parse(TEXT, "study.toml").unwrap();
        let surface = surface_stage::without_tables(study.surface.as_ref().unwrap(), folder.path()).unwrap();
        let place = Place::latent("surface.scan").unwrap();
        let unit = [[0.3, 0.3, 0.0], [0.0; 3]];
        let input = UncertainInput::new("surface.scan", Marginal::STANDARD_NORMAL, true).unwrap();
        let central = study.verdict.as_ref().unwrap().central.clone();
        let scan = ScanErrors { inputs: vec![(place, input, unit)] };
        let (study, surface, central) = (&study, &surface, &central);
        let mean_errors = &MeanErrors::default();
        let points = ContactPoints { study, surface, central, scan, mean_errors, monitor: &Silent };
        let mean = |point: &Point| points.solve(point).unwrap().unwrap().all.mean.ln();
        let at = |normal: f64| {
            let mut point = central.clone();
            point.add_latent(&[place]);
            place.set(&mut point, normal);
            mean(&point)
        };
        // A rougher surface with the same correlation length carries the load on a smaller area.
        let [low, usual, high] = [-1.0, 0.0, 1.0].map(at);
        assert_eq!(usual, points.ln_friction(BodyErrors::default()).unwrap());
        assert_eq!(high, points.ln_friction(unit).unwrap());
        assert_eq!(low, points.ln_friction(unit.map(|body| body.map(|error| -error))).unwrap());
        assert!(low > usual && usual > high, "{low} {usual} {high}");
    }

    #[test]
    fn friction_has_the_power_one_of_an_input_to_which_its_law_says_it_is_proportional() {
        let folder = scanned();
        let solve = |strength: f64| {
            let text = TEXT.replace("\"100 MPa\"", &format!("\"{strength} MPa\""));
            let study = Study::parse(&text, "study.toml").unwrap();
            let surface = surface_stage::without_tables(study.surface.as_ref().unwrap(), folder.path()).unwrap();
            let friction = study.friction.as_ref().unwrap();
            let level = LevelControl::Nominal(20e6);
            let solved = solve_level(friction, &surface.model, level, (4, 1.0), true, 1, &Silent).unwrap().unwrap().all;
            (solved, friction.law.proportional_to())
        };
        let ((one, input), (other, _)) = (solve(100.0), solve(130.0));
        assert_eq!(input, Some("material.shear_strength"));
        for (one, other, factor) in [
            (one.mean, other.mean, 1.3),
            (one.std, other.std, 1.3),
            (one.correlation_length_m, other.correlation_length_m, 1.0),
            (one.stiffness_pa_per_m, other.stiffness_pa_per_m, 1.0),
        ] {
            assert!(one > 0.0 && (other / one / factor - 1.0).abs() < 1e-9, "{one} and {other}");
        }
    }
}
