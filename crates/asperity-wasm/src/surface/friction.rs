//! Friction coefficient along a sliding path.

use std::sync::Arc;

use asperity::contact::Solver;
use asperity::correlation::{LengthSettings, RecordCorrelation, RecordModel, WindowedRecords, fit_length, fit_record};
use asperity::friction::FrictionError;
use asperity::friction::analysis::record_ends;
use asperity::friction::law::BowdenTabor;
use asperity::friction::strip::{Record, SolvedStrips, StripProblem};
use asperity::friction::upscaling::{exponential, variance_reduction};
use asperity::friction::window::Window;
use asperity::map::{BoundaryKind, Grid};
use asperity::stats::{Interval, Layout, ProcessEstimate, ProcessMoments};
use asperity::surface::model::XiOrder;
use asperity::vibration::CONSTANT_STD;
use asperity_report::live;
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
        let generated = self.model()?.strip(grid, true, XiOrder::Variance)?;
        let problem = StripProblem {
            half_space: request.press.half_space(grid, BoundaryKind::Periodic)?,
            window: Window::new(request.window_m, grid)?,
            law: Arc::new(BowdenTabor { shear_strength_pa: request.shear_strength_pa }),
            hardness_pa: request.press.hardness_pa,
            solver: Solver::default(),
            valid_share: 1.0,
        };
        let strips = problem.strips(generated.surface.as_ref(), request.realisations, self.seed);
        let solved = strips.solve(&[request.press.control()?], &Progress)?;
        let strips = solved.into_iter().next().ok_or_else(|| Failure("no level was solved".into()))??;
        let friction = WindowProcess::new(&strips, &problem)?;
        let window = &problem.window;
        let nominal_area_m2 = request.normal_force_n / strips.mean_pressure_pa;
        let first = friction.records.first().map(|first| (first.position_m.as_slice(), first.friction.as_slice()));
        let (position_m, values) = first.unwrap_or_default();
        Answer::new(&json!({
            "mean": friction.mean,
            "mean_interval": interval(friction.moments.mean),
            "std": friction.std,
            "correlation_length_m": friction.length_m,
            "nominal_area_m2": nominal_area_m2,
            "area_std": friction.area_std(window, nominal_area_m2),
            "mean_pressure_pa": strips.mean_pressure_pa,
            "window_m": window.length_m(),
            "window_width_m": window.width_m(),
            "warnings": generated.warnings,
            "svg": live::friction(position_m, values, friction.mean),
        }))
    }
}

/// Friction of windows at the mean load.
struct WindowProcess {
    mean: f64,
    /// Standard deviation; 0 if it is a rounding error.
    std: f64,
    moments: ProcessMoments,
    records: Vec<Record>,
    /// Correlation length, which contains the effect of the window; `None` if friction does not vary.
    length_m: Option<f64>,
    /// Correlation length without the window; 0 if the fit fails.
    own_length_m: f64,
}

impl WindowProcess {
    fn new(strips: &SolvedStrips, problem: &StripProblem) -> Result<Self, FrictionError> {
        let (mean, records) = Record::at_mean_load(&strips.records);
        let series: Vec<&[f64]> = records.iter().map(|record| record.friction.as_slice()).collect();
        if !mean.is_finite() {
            let windows = series.iter().map(|values| values.len()).sum();
            return Err(FrictionError::NoContact { windows, with_contact: 0 });
        }
        let (window, tracks) = (&problem.window, strips.tracks);
        let ends = record_ends(&records, window, true, problem.grid().width_m());
        let channel = WindowedRecords {
            window_m: window.length_m(),
            step_m: window.step_m(),
            cell_m: window.cell_m(),
            tracks,
            records: series.clone(),
        };
        let settings = LengthSettings { ends, ..LengthSettings::default() };
        let own = fit_length(&[channel], RecordModel::Exponential, settings);
        let lags = series.iter().map(|values| values.len()).max().unwrap_or(0) / 2;
        let fitted = RecordCorrelation::estimate(&series, window.step_m(), lags)
            .and_then(|estimate| fit_record(&estimate, RecordModel::Exponential));
        let moments = ProcessMoments::new(&series, Layout { periodic: true, tracks });
        let std = Some(moments.moments.std).filter(|std| *std >= CONSTANT_STD).unwrap_or_default();
        let length_m = fitted.ok().map(|fit| fit.length_m).filter(|_| std > 0.0);
        // Without a correlation of their own, windows are independent.
        let own_length_m = own.map_or(0.0, |own| own.length_m);
        Ok(Self { mean, std, moments, length_m, own_length_m, records })
    }

    /// Returns the standard deviation over a nominal area.
    fn area_std(&self, window: &Window, area_m2: f64) -> f64 {
        let correlation = exponential(self.own_length_m);
        self.std * variance_reduction(window.length_m(), window.width_m(), area_m2, &correlation).sqrt()
    }
}

fn interval(estimate: Option<ProcessEstimate>) -> Value {
    estimate.map_or(Value::Null, |ProcessEstimate { interval: Interval { low, high }, .. }| json!([low, high]))
}
