//! Friction coefficient along a sliding path.

use std::sync::Arc;

use asperity::contact::Solver;
use asperity::correlation::{RecordCorrelation, RecordModel, fit_record};
use asperity::friction::law::BowdenTabor;
use asperity::friction::strip::{Record, StripProblem};
use asperity::friction::upscaling::{exponential, variance_reduction};
use asperity::friction::window::Window;
use asperity::map::{BoundaryKind, Grid};
use asperity::stats::{Interval, Layout, ProcessEstimate, ProcessMoments};
use asperity::surface::model::XiOrder;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Surface;
use super::contact::Press;
use crate::answer::{Answer, Failure, read};
use crate::monitor::Progress;

/// Request for a record of friction.
#[derive(Debug, Deserialize)]
struct Request {
    /// Points and size (x, y) of a strip.
    strip_points: [usize; 2],
    strip_m: [f64; 2],
    /// Length of the window, which is as wide as the strip.
    window_m: f64,
    /// Number of strips.
    realisations: usize,
    shear_strength_pa: f64,
    /// Normal force of the machine, which the mean pressure spreads over the nominal area.
    normal_force_n: f64,
    #[serde(flatten)]
    press: Press,
}

impl Surface {
    /// Solves strips and slides a window along them.
    pub(super) fn slid(&self, request: &str) -> Result<Answer, Failure> {
        let request: Request = read(request)?;
        let ([nx, ny], [width_m, height_m]) = (request.strip_points, request.strip_m);
        let grid = Grid::with_size(nx, ny, width_m, height_m)?;
        let window = Window::new(request.window_m, grid)?;
        let generated = self.model()?.strip(grid, true, XiOrder::Variance)?;
        let problem = StripProblem {
            half_space: request.press.half_space(grid, BoundaryKind::Periodic)?,
            window: window.clone(),
            law: Arc::new(BowdenTabor { shear_strength_pa: request.shear_strength_pa }),
            hardness_pa: request.press.hardness_pa,
            solver: Solver::default(),
            valid_share: 1.0,
        };
        let strips = problem.strips(generated.surface.as_ref(), request.realisations, self.seed);
        let solved = strips.solve(&[request.press.control()?], &Progress)?;
        let level = solved.into_iter().next().ok_or_else(|| Failure("no level was solved".into()))??;
        let (mean, records) = Record::at_mean_load(&level.records);
        let series: Vec<&[f64]> = records.iter().map(|record| record.friction.as_slice()).collect();
        let layout = Layout { periodic: true, tracks: level.tracks };
        let found = ProcessMoments::new(&series, layout);
        let nominal_area_m2 = request.normal_force_n / level.mean_pressure_pa;
        let length_m = correlation_length_m(&series, window.step_m());
        let area_std = length_m.map(|length_m| {
            let correlation = exponential(length_m);
            let (long, wide) = (window.length_m(), window.width_m());
            found.moments.std * variance_reduction(long, wide, nominal_area_m2, &correlation).sqrt()
        });
        let answer = Answer::new(&json!({
            "mean": mean,
            "mean_interval": interval(found.mean),
            "std": found.moments.std,
            "std_interval": interval(found.std),
            "correlation_length_m": length_m,
            "nominal_area_m2": nominal_area_m2,
            "area_std": area_std,
            "mean_pressure_pa": level.mean_pressure_pa,
            "penetration_m": level.penetration_m,
            "contact_fraction": level.contact_fraction,
            "plastic_fraction": level.plastic_fraction,
            "window_m": window.length_m(),
            "window_width_m": window.width_m(),
            "warnings": generated.warnings,
        }))?;
        let (position_m, friction) =
            records.into_iter().next().map(|first| (first.position_m, first.friction)).unwrap_or_default();
        Ok(answer.with("position_m", position_m).with("friction", friction))
    }
}

/// Returns the length of the exponential correlation of the records; `None` if friction does not vary.
fn correlation_length_m(series: &[&[f64]], step_m: f64) -> Option<f64> {
    let lags = series.iter().map(|record| record.len()).max().unwrap_or(0) / 2;
    let estimate = RecordCorrelation::estimate(series, step_m, lags).ok()?;
    Some(fit_record(&estimate, RecordModel::Exponential).ok()?.length_m)
}

fn interval(estimate: Option<ProcessEstimate>) -> Value {
    estimate.map_or(Value::Null, |ProcessEstimate { interval: Interval { low, high }, .. }| json!([low, high]))
}
