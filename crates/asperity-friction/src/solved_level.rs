//! Friction of the strips at one level of contact.

use asperity_base::correlation::{LengthSettings, RecordEnds};
use asperity_base::sentence;
use asperity_base::stats::{Interval, Layout, ProcessMoments};
use asperity_process::{CorrelationShape, FittedCorrelation, FittedProcess, Origin, OriginKind};

use crate::FrictionError;
use crate::analysis::{ProcessAnalysis, record_ends};
use crate::level_control::LevelControl;
use crate::mean_errors::MeanErrors;
use crate::statistics::{FrictionStatistics, HeavyTail};
use crate::strip::{Record, SolvedStrips, StripProblem};
use crate::two_bodies::split::TwoBodyFriction;
use crate::upscaling::variance_reduction;
use crate::window::Window;
use crate::window_study::WindowStudy;

/// Strips at one level of contact with the statistics of their friction.
#[derive(Debug, Clone)]
pub struct SolvedLevel {
    /// Prescribed quantity.
    pub control: LevelControl,
    /// Window of the records.
    pub window: Window,
    /// Solved strips.
    pub strips: SolvedStrips,
    /// Statistics of the quotient F/N of each window.
    pub statistics: FrictionStatistics,
    /// Tail of the quotient, if the quotient has no variance.
    pub heavy_tail: Option<HeavyTail>,
    /// Contact area over nominal area with its 95 % interval.
    pub contact_fraction: (f64, Option<Interval>),
    /// μ̄ = ΣF/ΣN.
    pub mean: f64,
    /// Records at the mean load ([`Record::at_mean_load`]).
    pub at_mean_load: Vec<Record>,
    /// Errors of `mean` beside that of sampling.
    pub mean_errors: MeanErrors,
    /// Statistics of the records at the mean load.
    pub process: FrictionStatistics,
    /// Analysis of the records at the mean load.
    pub analysis: ProcessAnalysis,
    /// Correlation without the effect of the window; `None` if friction does not vary.
    pub window_study: Option<WindowStudy>,
    /// Friction between two rough bodies; `None` unless [`TwoBodyFriction::solve`] computed it.
    pub two_bodies: Option<TwoBodyFriction>,
}

impl SolvedLevel {
    /// Computes the statistics of the strips of a problem at one level; `seed` seeds their resamples.
    ///
    /// # Errors
    /// Too few windows carry load, or a statistic is undefined.
    pub fn new(
        control: LevelControl,
        strips: SolvedStrips,
        problem: &StripProblem,
        seed: u64,
    ) -> Result<Self, FrictionError> {
        let (window, periodic, strip_m) = (&problem.window, problem.is_periodic(), problem.grid().width_m());
        let layout = Layout { periodic, tracks: strips.tracks };
        let statistics = FrictionStatistics::new(&strips.records, window.step_m(), layout, seed)?;
        let (mean, at_mean_load) = Record::at_mean_load(&strips.records);
        let process = FrictionStatistics::new(&at_mean_load, window.step_m(), layout, seed)?;
        // The window study requires rectangles.
        let own = window.is_rectangle().then(|| (window.clone(), at_mean_load.clone()));
        let narrower = window.narrower().into_iter().zip(&strips.narrower);
        let narrower = narrower.map(|(window, records)| (window, Record::at_mean_load(records).1));
        let windows: Vec<(Window, Vec<Record>)> = own.into_iter().chain(narrower).collect();
        let varies = process.moments.std > 0.0;
        let whole = |(window, records): &(Window, Vec<Record>)| record_ends(records, window, periodic, strip_m);
        let round = windows.iter().all(|seen| whole(seen) == RecordEnds::Periodic);
        let ends = if round { RecordEnds::Periodic } else { RecordEnds::Free };
        let settings = LengthSettings { ends, ..LengthSettings::default() };
        let study = || WindowStudy::new(&windows, strips.tracks, settings).ok();
        let window_study = if varies { study() } else { None };
        let analysis = ProcessAnalysis::new(&at_mean_load, window, layout, strip_m);
        let heavy_tail = statistics.heavy_tail();
        let contact_fraction = contact_fraction(&strips, layout);
        Ok(Self {
            control,
            window: window.clone(),
            strips,
            statistics,
            heavy_tail,
            contact_fraction,
            mean,
            mean_errors: MeanErrors::default(),
            at_mean_load,
            process,
            analysis,
            window_study,
            two_bodies: None,
        })
    }

    /// Returns the mean of the quotient F/N; `None` if it does not exist.
    pub fn quotient_mean(&self) -> Option<f64> {
        self.heavy_tail.is_none_or(|tail| tail.has_mean()).then_some(self.statistics.moments.mean)
    }

    /// Returns the variance of μ over the nominal area divided by the variance of one window, from the correlation without the
    /// effect of the window.
    pub fn variance_reduction(&self, nominal_area_m2: f64) -> f64 {
        let window = &self.window;
        let correlation = |lag_m: f64| match &self.window_study {
            Some(study) if study.length_m > 0.0 => study.model.correlation(lag_m, study.length_m),
            _ => 0.0,
        };
        // Windows of another shape count as rectangles of their area and width.
        let rectangle_m = window.area_m2() / window.width_m();
        variance_reduction(rectangle_m, window.width_m(), nominal_area_m2, &correlation)
    }

    /// Multiplies the ends of the intervals of the standard deviation and of the coefficient of variation by factors, which the pitch leaves
    /// possible.
    pub fn widen_fluctuation(&mut self, [low, high]: [f64; 2]) {
        for statistics in [&mut self.statistics, &mut self.process] {
            let of = &mut statistics.estimates;
            for estimate in [&mut of.std, &mut of.coefficient_of_variation].into_iter().flatten() {
                estimate.interval = Interval { low: low * estimate.interval.low, high: high * estimate.interval.high };
            }
        }
    }

    /// Returns the friction process at the mean load. Constant friction has neither a distribution nor a correlation.
    ///
    /// # Errors
    /// The reason why there is no process, for instance friction that varies without a correlation.
    pub fn fitted_process(&self, stribeck_s_per_m: Option<f64>) -> Result<FittedProcess, String> {
        let (process, window) = (&self.process, &self.window);
        let pair = |interval: Interval| [interval.low, interval.high];
        let correlation = process.correlation.as_ref().map(|found| FittedCorrelation {
            shape: CorrelationShape::Exponential,
            length_m: found.exponential.length_m,
            length_interval_m: found.length_interval.map(pair),
            window_m: Some(window.length_m()),
            length_without_window_m: self
                .window_study
                .as_ref()
                // Readers of the process use it as the length of an exponential.
                .map(|study| study.model.integral_scale_m(study.length_m)),
        });
        let varies = process.moments.std > 0.0;
        let fitted = FittedProcess {
            mean: self.mean,
            mean_interval: process.estimates.mean.map(|mean| pair(mean.interval)).filter(|_| varies),
            std: process.moments.std,
            std_interval: process.estimates.std.map(|std| pair(std.interval)).filter(|_| varies),
            marginal: process.marginal().filter(|_| varies).map(|fit| fit.marginal.clone()),
            correlation: match correlation {
                Ok(correlation) => Some(correlation).filter(|_| varies),
                Err(_) if !varies => None,
                Err(error) => return Err(error.to_string()),
            },
            generator: None,
            stribeck_s_per_m,
            averaged_over_m: Some([window.length_m(), window.area_m2() / window.length_m()]),
            mean_pressure_pa: Some(self.strips.mean_pressure_pa),
            origin: Origin {
                kind: OriginKind::Study,
                description: format!(
                    "windows of {} at {} and the mean load",
                    sentence::size(window.length_m(), window.width_m()),
                    self.control.name()
                ),
            },
        };
        fitted.check().map_err(|error| error.to_string())?;
        Ok(fitted)
    }
}

/// Returns the contact area over the nominal area with the relative error of the mean contact area of the windows.
fn contact_fraction(strips: &SolvedStrips, layout: Layout) -> (f64, Option<Interval>) {
    let areas_m2: Vec<&[f64]> = strips.records.iter().map(|record| record.area_m2.as_slice()).collect();
    let moments = ProcessMoments::new(&areas_m2, layout);
    let fraction = strips.contact_fraction / moments.moments.mean;
    let interval =
        moments.mean.map(|mean| Interval { low: fraction * mean.interval.low, high: fraction * mean.interval.high });
    (strips.contact_fraction, interval)
}
