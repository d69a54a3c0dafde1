//! Friction of the contact as a function of the uncertain values, learnt from solved strips.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Deserialize;
use toml::Table;

use crate::chaos::{Expansion, Observed, Parameter, Propagation, Resamples};
use crate::friction::replicates::{LevelMoments, MomentReplicates};
use crate::friction::{LevelControl, OperatingLevel, RoughBody, WindowFriction};
use crate::monitor::{Cancelled, Monitor, Quiet};
use crate::study::check::VerdictStudy;
use crate::study::friction_stage;
use crate::study::output::StageOutput;
use crate::study::surface_stage::{self, SurfaceStage};
use crate::study::uncertain::Place;
use crate::study::{Study, StudyError, StudyFile, sentence};

/// Probability of values below and above the range on which friction is learnt.
const TAIL: f64 = 1e-3;
/// Solved points per uncertain value and one.
const POINTS_PER_VALUE: usize = 6;
/// Smallest number of strips per point.
const LEAST_STRIPS: usize = 4;
/// Standard error of the mean friction coefficient in percent above which there is a warning.
const LARGEST_PERCENT: f64 = 5.0;
/// Places of the moments in [`LevelMoments::values`].
const MEAN: usize = 0;
const STD: usize = 1;
const LENGTH: usize = 3;
/// Keys of [vibration] that change the pressure of the contact.
const LOADS: [&str; 2] = ["normal_force", "nominal_area"];

/// Friction learnt as a function of the values that change the contact.
pub(super) struct FrictionResponses {
    axes: Vec<Axis>,
    /// Expansions of the logarithms of mean, standard deviation and correlation length: friction is nearly a product of powers.
    moments: [Option<Expansion>; 3],
    /// Relative standard error of the mean: of the few strips, and of the expansion.
    pub(super) mean_error: f64,
}

/// One value, on a linear or logarithmic scale.
struct Axis {
    place: Place,
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axis {
    /// Returns the axis over the values of an input and of its remedies.
    fn new(place: Place, study: &VerdictStudy) -> Option<Self> {
        let mut ends = Vec::new();
        if let Some(index) = study.places.iter().position(|own| *own == place) {
            let input = &study.inputs.inputs()[index];
            ends.extend([TAIL, 1.0 - TAIL].map(|probability| input.marginal().quantile(probability)));
        }
        for remedy in study.remedies.iter().filter(|remedy| remedy.place == place) {
            ends.extend([remedy.low, remedy.high]);
        }
        let low = ends.iter().copied().reduce(f64::min)?;
        let high = ends.into_iter().reduce(f64::max)?;
        Some(Self { place, low, high, logarithmic: low > 0.0 })
    }

    fn scale(&self, value: f64) -> f64 {
        if self.logarithmic { value.ln() } else { value }
    }

    /// Returns the value at a point of the scale.
    fn value(&self, scaled: f64) -> f64 {
        if self.logarithmic { scaled.exp() } else { scaled }
    }

    /// Returns the position of a value in −1 … 1; values beyond the ends count as the ends.
    fn xi(&self, value: f64) -> f64 {
        let [low, high] = [self.low, self.high].map(|end| self.scale(end));
        (2.0 * (self.scale(value) - low) / (high - low) - 1.0).clamp(-1.0, 1.0)
    }

    fn parameter(&self) -> Result<Parameter, StudyError> {
        Ok(Parameter::uniform(&self.place.name(), self.scale(self.low), self.scale(self.high))?)
    }
}

impl FrictionResponses {
    /// Solves strips at points of the values that change the contact; `None` if all of them are exact.
    ///
    /// # Errors
    /// A point has no answer, or the monitor cancelled.
    pub(super) fn learn(
        study: &Study,
        verdict: &VerdictStudy,
        surface: &SurfaceStage,
        monitor: &dyn Monitor,
        output: &mut StageOutput,
    ) -> Result<Option<Self>, StudyError> {
        let changes_contact = |place: &Place| {
            let key = place.key();
            key.section != "vibration" || LOADS.contains(&key.name)
        };
        let mut places: Vec<Place> = Vec::new();
        for place in verdict.places.iter().copied().chain(verdict.remedies.iter().map(|remedy| remedy.place)) {
            if changes_contact(&place) && !places.contains(&place) {
                places.push(place);
            }
        }
        if places.is_empty() {
            return Ok(None);
        }
        let axes: Vec<Axis> = places.into_iter().filter_map(|place| Axis::new(place, verdict)).collect();
        let parameters = axes.iter().map(Axis::parameter).collect::<Result<Vec<_>, _>>()?;
        let points = POINTS_PER_VALUE * (axes.len() + 1);
        let propagation = Propagation::new(parameters, points, study.seed())?;
        let done = AtomicUsize::new(0);
        let mut found = Vec::with_capacity(points);
        for index in 0..points {
            monitor.progress("verdict: friction", done.fetch_add(1, Ordering::Relaxed), points);
            if monitor.cancelled() {
                return Err(Cancelled.into());
            }
            let mut table = verdict.central.clone();
            for (axis, scaled) in axes.iter().zip(propagation.point(index)) {
                axis.place.set(&mut table, axis.value(scaled));
            }
            found.push(solve(study, table, surface, monitor)?);
        }
        monitor.progress("verdict: friction", points, points);
        let mut responses = Vec::new();
        for moment in [MEAN, STD, LENGTH] {
            responses.push(learn_moment(&propagation, &found, moment, study.seed())?);
        }
        let mean_error = responses[0].as_ref().map_or(0.0, |(_, error)| *error);
        if !axes.is_empty() {
            let percent = 100.0 * mean_error;
            output.assumptions.push(format!(
                "The friction coefficient as a function of {} is expanded from {points} solved points; its standard error is {} %.",
                axes.iter().map(|axis| axis.place.name()).collect::<Vec<_>>().join(", "),
                sentence::digits(percent)
            ));
            if percent > LARGEST_PERCENT {
                output.warnings.push(format!(
                    "the friction coefficient as a function of the uncertain values has a standard error of {} %; raise `realisations` \
                     in [friction]",
                    sentence::digits(percent)
                ));
            }
        }
        let [mean, std, length] = <[_; 3]>::try_from(responses).unwrap_or_default();
        // Only the windows of a smooth slider have the correlation of the strips along the path.
        let length =
            length.filter(|_| study.friction.as_ref().is_some_and(|friction| friction.body == RoughBody::Track));
        let moments = [mean, std, length].map(|learnt| learnt.map(|(expansion, _)| expansion));
        Ok(Some(Self { axes, moments, mean_error }))
    }

    /// Returns the friction of a study file's values, `window` being the friction at their centres.
    pub(super) fn at(&self, table: &Table, window: &WindowFriction) -> WindowFriction {
        let xi: Vec<f64> =
            self.axes.iter().map(|axis| axis.xi(axis.place.value_in(table).unwrap_or(axis.low))).collect();
        let [mean, std, length] =
            [0, 1, 2].map(|moment| self.moments[moment].as_ref().map(|expansion| expansion.evaluate(&xi).exp()));
        // The standard deviation of a point is that of all windows; its fractions along the path and between parts are those of
        // `window`.
        let all = window.std.hypot(window.between_parts_std);
        let fractions = if all > 0.0 { [window.std / all, window.between_parts_std / all] } else { [1.0, 0.0] };
        WindowFriction {
            mean: mean.unwrap_or(window.mean),
            std: std.map_or(window.std, |std| std * fractions[0]),
            between_parts_std: std.map_or(window.between_parts_std, |std| std * fractions[1]),
            length_m: length.unwrap_or(window.length_m),
            ..window.clone()
        }
    }
}

/// Solves the strips of one study file at its operating point.
fn solve(
    study: &Study,
    mut table: Table,
    surface: &SurfaceStage,
    monitor: &dyn Monitor,
) -> Result<Option<MomentReplicates>, StudyError> {
    table.remove("verdict");
    table.remove("uncertainty");
    let file = StudyFile::deserialize(table).map_err(|error| StudyError::Verdict(error.message().to_owned()))?;
    let own = file.check()?;
    let (Some(friction), Some(vibration), Some(request)) = (&own.friction, &own.vibration, &own.surface) else {
        return Ok(None);
    };
    let mut model = surface.model.clone();
    if own.file().surface != study.file().surface
        && let Some(section) = &own.file().surface
    {
        let output = &mut StageOutput::default();
        model.surface = surface_stage::model_of(section, request.clone(), surface.measured.as_ref(), output)?.0;
    }
    let level = match own.operating_level() {
        OperatingLevel::Percentile(percentile) => LevelControl::Percentile(percentile),
        OperatingLevel::NominalPressure(pascal) => LevelControl::Nominal(pascal),
        OperatingLevel::Deepest => LevelControl::Nominal(vibration.nominal_contact().pressure_pa),
    };
    let realisations = LEAST_STRIPS.max(friction.realisations.div_ceil(2));
    let solved = friction_stage::solve_level(friction, &model, level, realisations, own.seed(), &Quiet(monitor))?;
    Ok(solved)
}

/// Expands the logarithm of one moment, with its standard error; `None` for a moment that is undefined or zero.
fn learn_moment(
    propagation: &Propagation,
    found: &[Option<MomentReplicates>],
    moment: usize,
    seed: u64,
) -> Result<Option<(Expansion, f64)>, StudyError> {
    let strips = found.iter().flatten().map(|replicates| replicates.without.len()).max().unwrap_or(0);
    let of = |moments: &LevelMoments| moments.values()[moment].ln();
    let values: Vec<f64> = found.iter().map(|found| found.as_ref().map_or(f64::NAN, |r| of(&r.all))).collect();
    let without: Vec<Vec<f64>> = (0..strips)
        .map(|strip| {
            let one = |found: &Option<MomentReplicates>| {
                found.as_ref().and_then(|r| r.without.get(strip)).map_or(f64::NAN, of)
            };
            found.iter().map(one).collect()
        })
        .collect();
    if moment != MEAN && values.iter().any(|value| !value.is_finite()) {
        return Ok(None);
    }
    let observed = Observed { values: &values, without: &without, resolution: 0.0 };
    let propagated = propagation.respond(&observed, &Resamples { count: 20, ..Resamples::new(seed) })?;
    let unexplained = propagated.leave_one_out * propagated.std.value.powi(2);
    let error = (unexplained + propagated.noise.standard_error.powi(2)).sqrt();
    Ok(Some((propagated.expansion, error)))
}
