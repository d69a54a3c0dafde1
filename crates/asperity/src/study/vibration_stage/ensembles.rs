//! Ensembles of one study: those of both upscalings over the sweep, and the portraits of single trajectories.

use asperity_base::choice::Choice;

use super::clipping::clipping_warning;
use super::entries::{damping_result, motion_result, points_result};
use super::tables::{cloud_table, portrait_table};
use crate::friction::process::{Cancellable, FrictionProcess, ProcessModel};
use crate::friction::{Upscaling, WindowFriction};
use crate::monitor::{Cancelled, Monitor, Quiet};
use crate::study::check::VibrationStudy;
use crate::study::output::left_out;
use crate::study::result::{DampingResult, EnsembleResult, PointsResult};
use crate::study::run_machine::RunMachine;
use crate::study::{StudyError, Table, sentence};
use crate::vibration::{
    CONSTANT_STD, DampingSweep, Drive, Ensemble, EnsembleSettings, Oscillator, TrajectorySettings, VibrationError,
    accept_clipping, clipped_to_positive, crossings_without_fluctuation, cycle_portrait, deterministic_slips,
    limit_cycle, trajectory_portrait,
};

/// Points of a plotted limit cycle and trajectory, and the duration τ of the trajectory.
const CYCLE_POINTS: usize = 600;
const TRAJECTORY_POINTS: usize = 6000;
const TRAJECTORY_SPAN: f64 = 120.0;
/// Number of trajectories of a cloud.
const CLOUD_TRAJECTORIES: usize = 60;
/// Levels of the mean fraction of time in vibration whose damping ratios are reported.
const LEVELS: [f64; 3] = [0.95, 0.5, 0.05];
/// Multiples of the fastest expected slip for which friction is kept positive; the next is tried if slips are faster.
const MARGINS: [f64; 3] = [1.0, 5.0, 25.0];

/// Fails if friction that is known before the run is clipped more than the study allows.
pub(in crate::study) fn refuse_clipping(study: &VibrationStudy, window: &WindowFriction) -> Result<(), StudyError> {
    let ensembles = Ensembles::new(study, window, 0)?;
    let process = |upscaling| ensembles.process(upscaling, MARGINS[0]).map(|_| ());
    [Upscaling::Paper, Upscaling::Area].into_iter().try_for_each(process)
}

/// Ensembles of one study.
pub(super) struct Ensembles<'a> {
    pub(super) study: &'a VibrationStudy,
    pub(super) oscillator: Oscillator,
    pub(super) window: &'a WindowFriction,
    pub(super) seed: u64,
}

impl<'a> Ensembles<'a> {
    /// Prepares the ensembles of a study with this friction.
    pub(super) fn new(study: &'a VibrationStudy, window: &'a WindowFriction, seed: u64) -> Result<Self, StudyError> {
        Ok(Self { study, oscillator: study.machine.oscillator(window.mean, window.stribeck)?, window, seed })
    }

    /// Returns the model of the dimensionless fluctuation.
    pub(super) fn model(&self, upscaling: Upscaling) -> ProcessModel {
        self.window.process_model(upscaling, self.study.machine.generator, self.study.machine.scales.length_m())
    }

    pub(super) fn machine(&self) -> RunMachine {
        let (study, model) = (self.study, self.model(self.study.machine.upscaling));
        RunMachine {
            parameters: self.oscillator.parameters().clone(),
            process: (model.std >= CONSTANT_STD).then_some(model),
            length_m: study.machine.scales.length_m(),
            time_s: study.machine.scales.time_s(),
            drive: study.machine.drive,
            trajectories: study.trajectories,
            duration: study.duration,
            seed: self.seed,
        }
    }

    /// Returns the dimensionless correlation length.
    pub(super) fn correlation_length(&self) -> f64 {
        self.window.length_m / self.study.machine.scales.length_m()
    }

    /// Returns the process of the fluctuation; `None` if friction is constant.
    ///
    /// # Errors
    /// More of its values are clipped than the study allows.
    fn process(&self, upscaling: Upscaling, margin: f64) -> Result<Option<FrictionProcess>, StudyError> {
        let model = self.model(upscaling);
        if model.std < CONSTANT_STD {
            return Ok(None);
        }
        let model = clipped_to_positive(&self.oscillator, model, margin);
        self.accepted(model.clipped_fraction(), upscaling)?;
        Ok(Some(FrictionProcess::new(model)?))
    }

    /// Returns a clipped fraction of the friction.
    ///
    /// # Errors
    /// It exceeds the limit of the study, under the main upscaling. The other upscaling serves for comparison and only warns.
    pub(super) fn accepted(&self, fraction: f64, upscaling: Upscaling) -> Result<f64, StudyError> {
        let allowed = self.study.allow_clipping || upscaling != self.study.machine.upscaling;
        let clipped =
            |error| StudyError::Clipped { upscaling: upscaling.name(), error, computed: self.window.computed };
        accept_clipping(fraction, allowed).map_err(clipped)?;
        Ok(fraction)
    }

    pub(super) fn settings(&self) -> EnsembleSettings {
        EnsembleSettings {
            drive: self.study.machine.drive,
            least_valid_share: self.study.valid_fraction,
            ..EnsembleSettings::new(self.study.trajectories, self.study.duration, self.seed)
        }
    }

    fn followed(&self) -> TrajectorySettings {
        TrajectorySettings { duration: self.study.duration, start: None, drive: self.study.machine.drive }
    }

    /// Simulates ensembles over the sweep, and one at the study's own damping ratio. If slips are faster than expected,
    /// so that friction would change its sign, retries with a stronger clipping, which the result reports.
    pub(super) fn run(
        &self,
        upscaling: Upscaling,
        monitor: &dyn Monitor,
        warnings: &mut Vec<String>,
    ) -> Result<(EnsembleResult, Option<Ensemble>), StudyError> {
        let mut result = self.run_with_margin(upscaling, MARGINS[0], monitor, warnings);
        for margin in &MARGINS[1..] {
            if let Err(StudyError::Vibration(VibrationError::TooFewValid { .. })) = result {
                result = self.run_with_margin(upscaling, *margin, monitor, warnings);
            }
        }
        result
    }

    fn run_with_margin(
        &self,
        upscaling: Upscaling,
        margin: f64,
        monitor: &dyn Monitor,
        warnings: &mut Vec<String>,
    ) -> Result<(EnsembleResult, Option<Ensemble>), StudyError> {
        let (from, to, count) = self.study.damping_sweep;
        let ratios = (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64);
        let friction_std = self.window.upscaled_std(upscaling);
        let Some(process) = self.process(upscaling, margin)? else {
            return Ok((self.constant_friction(friction_std, ratios, monitor)?, None));
        };
        let clipped_fraction = process.model().clipped_fraction();
        let (mut damping_ratios, mut ensembles) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut damping = Vec::with_capacity(count);
        let task = format!("vibration ({upscaling})");
        for (done, damping_ratio) in ratios.enumerate() {
            monitor.progress(&task, done, count + 2);
            let oscillator = self.oscillator.with_damping(damping_ratio)?;
            let settings = EnsembleSettings { sample_capacity: 0, ..self.settings() };
            let ensemble = Ensemble::simulate(&oscillator, &process, &settings, &Quiet(monitor))?;
            damping.push(damping_result(damping_ratio, limit_cycle(&oscillator)?.kind(), &ensemble));
            damping_ratios.push(damping_ratio);
            ensembles.push(ensemble);
        }
        monitor.progress(&task, count, count + 2);
        let ensemble = Ensemble::simulate(&self.oscillator, &process, &self.settings(), &Quiet(monitor))?;
        monitor.progress(&task, count + 1, count + 2);
        let sweep = DampingSweep { damping_ratios, ensembles };
        let crossings = sweep.crossings(&self.oscillator, &process, &LEVELS, &self.settings(), monitor)?;
        monitor.progress(&task, count + 2, count + 2);
        let failed: usize = damping.iter().map(|found: &DampingResult| found.failed_samples).sum();
        let what = format!("trajectories of the damping sweep with the {upscaling} upscaling");
        warnings.extend(left_out(&what, failed, count * self.study.trajectories));
        let clipping = clipping_warning(clipped_fraction);
        warnings.extend(clipping.map(|warning| format!("with the {upscaling} upscaling, {warning}")));
        let result = EnsembleResult {
            friction_std,
            clipped_fraction,
            damping,
            crossings,
            reattachment: points_result(&ensemble.reattachments),
            release: points_result(&ensemble.releases),
            motion: Some(motion_result(&ensemble)),
        };
        Ok((result, Some(ensemble)))
    }

    /// Returns the result of constant friction: every trajectory is the deterministic one.
    fn constant_friction(
        &self,
        friction_std: f64,
        ratios: impl Iterator<Item = f64>,
        monitor: &dyn Monitor,
    ) -> Result<EnsembleResult, StudyError> {
        let machines = ratios.map(|ratio| self.oscillator.with_damping(ratio)).collect::<Result<Vec<_>, _>>()?;
        let mut damping = Vec::new();
        for (oscillator, slips) in machines.iter().zip(deterministic_slips(&machines, &self.followed())) {
            let (damping_ratio, cycles) = (oscillator.damping_ratio(), slips?.cycles);
            let kind = limit_cycle(oscillator)?.kind();
            let fraction = if kind.is_vibration() { 1.0 } else { 0.0 };
            damping.push(DampingResult {
                damping_ratio,
                kind,
                cycles_deterministic: cycles,
                cycles_mean: cycles as f64,
                cycles_se: 0.0,
                difference_mean: 0.0,
                difference_interval: [0.0, 0.0],
                share_in_cycle: fraction,
                vibration_share: fraction,
                vibration_share_se: 0.0,
                sustained_share: fraction,
                sustained_share_interval: [fraction, fraction],
                failed_samples: 0,
            });
        }
        let crossings = crossings_without_fluctuation(&self.oscillator, &LEVELS, self.study.damping_sweep.1, monitor)?;
        let (reattachment, release) = (PointsResult::default(), PointsResult::default());
        Ok(EnsembleResult {
            friction_std,
            clipped_fraction: 0.0,
            damping,
            crossings,
            reattachment,
            release,
            motion: None,
        })
    }

    /// Returns the limit cycle, and the end of one trajectory, for a phase portrait.
    pub(super) fn portraits(&self, monitor: &dyn Monitor) -> Result<Vec<(&'static str, Table)>, StudyError> {
        let mut tables = Vec::new();
        if let Some(points) = cycle_portrait(&self.oscillator, CYCLE_POINTS)? {
            tables.push(("limit_cycle", portrait_table(&points)));
        }
        let settings = self.followed();
        let from = (settings.duration - TRAJECTORY_SPAN).max(0.0);
        for margin in MARGINS {
            let process = match self.process(self.study.machine.upscaling, margin) {
                Ok(Some(process)) => process,
                // The ensembles did not reach this velocity.
                Ok(None) | Err(StudyError::Clipped { .. }) => break,
                Err(error) => return Err(error),
            };
            let path = Cancellable::new(process.path(self.seed, 0), monitor);
            match trajectory_portrait(&self.oscillator, path, &settings, from, TRAJECTORY_POINTS) {
                Ok(points) => {
                    tables.push(("trajectory", portrait_table(&points)));
                    let (of, most) = (self.settings(), CLOUD_TRAJECTORIES);
                    tables.push(("phase_cloud", cloud_table(&self.oscillator, &process, &of, most, monitor)?));
                    break;
                }
                Err(_) if monitor.cancelled() => return Err(Cancelled.into()),
                Err(VibrationError::FrictionNotPositive { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(tables)
    }

    pub(super) fn sentences(&self) -> Vec<String> {
        let (study, window) = (self.study, self.window);
        let mut sentences = vec![format!(
            "The oscillator slides with {} + μ_s at V = {}{}. Cycles are slips that reach a negative velocity within τ = {}, \
             starting in stick. The damping ratios at which vibration falls below 95, 50 and 5 % of the time belong to the second \
             half of this time: the longer it is, the more trajectories leave vibration.",
            self.oscillator.law().describe(),
            sentence::digits(self.oscillator.belt_velocity()),
            self.oscillator.forcing().map_or_else(String::new, |forcing| format!(
                ", under the force {} cos {}τ in units of N",
                sentence::digits(forcing.amplitude),
                sentence::digits(forcing.frequency)
            )),
            study.duration
        )];
        if window.std < CONSTANT_STD {
            sentences.push(format!(
                "Friction ({}) is constant at {}: every trajectory is the deterministic one.",
                window.origin,
                sentence::digits(window.mean)
            ));
            return sentences;
        }
        sentences.push(format!(
            "Friction ({}) has mean {}, standard deviation {} for one window, and correlation length {} over the sliding \
             distance, λ = ℓ_μ c/N = {}.",
            window.origin,
            sentence::digits(window.mean),
            sentence::digits(window.std),
            sentence::si(window.length_m, "m"),
            sentence::digits(self.correlation_length())
        ));
        if let Some(generator) = study.machine.generator.or(window.generator) {
            let other = self.model(Upscaling::Area).generator;
            let but = if other == generator {
                String::new()
            } else {
                format!(", but over the nominal area, where its distribution is normal, by the {} one", other.name())
            };
            sentences.push(format!("The fluctuation is made by the {} generator{but}.", generator.name()));
        }
        if study.machine.drive == Drive::Time {
            sentences.push("The fluctuation goes on with the travel of the belt, also in stick.".into());
        }
        sentences.extend(window.area_m2.map(|area_m2| {
            format!(
                "Upscaling: with `paper` one window carries the whole normal force of {}, {} on its area. With `area` the \
                 windows of a square nominal area of {} average, so that the standard deviation falls to {}{}. Both keep the correlation \
                 length of one window.",
                study.machine.normal_force,
                sentence::si(study.machine.normal_force.0 / area_m2, "Pa"),
                study.machine.nominal_area,
                sentence::digits(window.upscaled_std(Upscaling::Area)),
                if window.holds_many() { " and the distribution becomes normal" } else { "" }
            )
        }));
        sentences
    }
}
