//! Karhunen–Loève spectrum of a covariance.

use asperity::correlation::{CorrelationFamily, CorrelationModel, Covariance};
use asperity::quantity::Length;
use asperity::surface::{self, GeneratorError, ModesRoute, modes, modes_memory_bytes};
use clap::Args;

use crate::args::{self, OneOrTwo};
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::Answer;
use crate::resources::require_memory;

/// Computes eigenvalues of a correlation on an interval (one size) or a rectangle (two).
///
/// Eigenvalues are in m on an interval and in m² on a rectangle. The variance is 1, so all eigenvalues together add up
/// to the length or the area. The captured variance is the fraction of this sum in the stated number of modes.
#[derive(Debug, Args)]
pub(crate) struct Modes {
    /// Shape of the correlation.
    #[arg(long, value_parser = args::named::<CorrelationFamily>())]
    covariance: CorrelationFamily,
    /// Hurst exponent H of the self-affine model, which requires it.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    hurst: Option<f64>,
    /// Smoothness ν of the Matérn model.
    #[arg(long, value_name = "X", default_value = "1.5", value_parser = args::positive, allow_hyphen_values = true)]
    smoothness: f64,
    /// Length ℓ of the model, along x and y: the distance at which the correlation falls to 1/e. For the Matérn model
    /// it is the scale, not the 1/e length, and for the self-affine one the roll-off length.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    correlation_length: OneOrTwo<Length>,
    /// Length of the interval, or size of the rectangle along x and y.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    size: OneOrTwo<Length>,
    /// Points, along x and y.
    #[arg(long, value_name = "N[,N]", value_parser = args::count_pair, allow_hyphen_values = true)]
    points: OneOrTwo<usize>,
    /// Number of modes.
    #[arg(long, value_name = "M", value_parser = args::count, allow_hyphen_values = true)]
    modes: usize,
    /// Covariance of the modes of a rectangle.
    #[arg(long, value_parser = args::named::<ModesRoute>(), default_value = "separable")]
    route: ModesRoute,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Modes {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        if self.hurst.is_some() && self.covariance != CorrelationFamily::SelfAffine {
            return Err(Failure::usage("--hurst: has no effect without --covariance self_affine"));
        }
        let model = match self.covariance {
            CorrelationFamily::SquaredExponential => CorrelationModel::SquaredExponential,
            CorrelationFamily::Exponential => CorrelationModel::Exponential,
            CorrelationFamily::Matern => CorrelationModel::Matern { nu: self.smoothness },
            CorrelationFamily::SelfAffine => CorrelationModel::SelfAffine {
                hurst: self.hurst.ok_or_else(|| Failure::usage("--hurst: required by a self-affine covariance"))?,
            },
        };
        let (length_x, length_y) = self.correlation_length.both();
        let covariance = Covariance::new(model, 1.0, length_x.0, length_y.0).map_err(Failure::usage)?;
        let sizes_m: Vec<f64> = self.size.given().into_iter().map(|size| size.0).collect();
        if let (OneOrTwo::Two(..), [_]) = (self.correlation_length, &sizes_m[..]) {
            return Err(Failure::usage(
                "--correlation-length: an interval has one; give --size two values for a rectangle",
            ));
        }
        let points = self.points.given();
        require_memory(modes_memory_bytes(&points, self.modes, self.route), "the eigenproblem")?;
        let found = monitor
            .killable(|| modes(&covariance, &sizes_m, &points, self.modes, self.route))?
            .or_else(|e| Err(generator_failure(&e).print(answer(None, sizes_m.len()), self.json)?))?;
        answer(Some(&found), sizes_m.len()).print(self.json)
    }
}

/// Returns the results; eigenvalues have the unit metre to the power of the dimension.
fn answer(found: Option<&surface::Modes>, dimension: usize) -> Answer {
    let unit = if dimension == 1 { "m" } else { "m^2" };
    Answer::default()
        .with("eigenvalue_unit", unit)
        .with("eigenvalues", found.map(|f| f.eigenvalues.clone()))
        .with("captured_variance", found.map(|f| f.captured_variance))
}

fn generator_failure(error: &GeneratorError) -> Failure {
    match error {
        GeneratorError::NotConverged { .. } => Failure::new(Kind::NotConverged, error.to_string()),
        _ => Failure::usage(error),
    }
}
