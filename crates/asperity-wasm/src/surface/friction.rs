//! Friction coefficient along a sliding path.

use std::sync::Arc;

use asperity::contact::Solver;
use asperity::friction::SolvedLevel;
use asperity::friction::law::BowdenTabor;
use asperity::friction::strip::StripProblem;
use asperity::friction::window::Window;
use asperity::map::{BoundaryKind, Grid};
use asperity::stats::{Interval, ProcessEstimate};
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
            window,
            law: Arc::new(BowdenTabor { shear_strength_pa: request.shear_strength_pa }),
            hardness_pa: request.press.hardness_pa,
            solver: Solver::default(),
            valid_share: 1.0,
        };
        let strips = problem.strips(generated.surface.as_ref(), request.realisations, self.seed);
        let solved = strips.solve(&[request.press.control()?], &Progress)?;
        let solved = solved.into_iter().next().ok_or_else(|| Failure("no level was solved".into()))??;
        let level = SolvedLevel::new(request.press.level()?, solved, &problem, self.seed)?;
        let (found, strips) = (&level.process, &level.strips);
        let nominal_area_m2 = request.normal_force_n / strips.mean_pressure_pa;
        let std = found.moments.std;
        let answer = Answer::new(&json!({
            "mean": level.mean,
            "mean_interval": interval(found.estimates.mean),
            "std": std,
            "std_interval": interval(found.estimates.std),
            "correlation_length_m": found.correlation.as_ref().ok().map(|correlation| correlation.exponential.length_m),
            "nominal_area_m2": nominal_area_m2,
            "area_std": std * level.variance_reduction(nominal_area_m2).sqrt(),
            "mean_pressure_pa": strips.mean_pressure_pa,
            "penetration_m": strips.penetration_m,
            "contact_fraction": strips.contact_fraction,
            "plastic_fraction": strips.plastic_fraction,
            "window_m": problem.window.length_m(),
            "window_width_m": problem.window.width_m(),
            "warnings": generated.warnings,
        }))?;
        let (position_m, friction) =
            level.at_mean_load.into_iter().next().map(|first| (first.position_m, first.friction)).unwrap_or_default();
        Ok(answer.with("position_m", position_m).with("friction", friction))
    }
}

fn interval(estimate: Option<ProcessEstimate>) -> Value {
    estimate.map_or(Value::Null, |ProcessEstimate { interval: Interval { low, high }, .. }| json!([low, high]))
}
