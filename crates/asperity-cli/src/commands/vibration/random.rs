//! Random friction fluctuation of a command.

use std::path::{Path, PathBuf};

use asperity::distribution::Marginal;
use asperity::friction::process::{FrictionProcess, Generator, ProcessModel, TranslationKind};
use asperity::quantity::Length;
use asperity::study::clipping_warning;
use asperity::vibration::{EnsembleSettings, Oscillator, accept_clipping, clipped_to_positive};
use clap::Args;

use crate::args;
use crate::commands::friction::read_process;
use crate::failure::Failure;
use crate::monitor::{Terminal, duration};

/// Approximate time of one core for one value of the fluctuation and the step to it, in seconds.
const SECONDS_A_VALUE: f64 = 1e-7;
/// Estimated time above which the command reports it in advance, in seconds.
const LONG_SECONDS: f64 = 120.0;

/// Prints the estimated time of `count` trajectories over that sliding distance if it is long: a short correlation length requires many
/// steps.
pub(super) fn note_time(process: &FrictionProcess, distance: f64, count: usize, monitor: &Terminal) {
    let values = distance / process.step();
    let threads = rayon::current_num_threads().min(count).max(1);
    let seconds = SECONDS_A_VALUE * values * count as f64 / threads as f64;
    if seconds > LONG_SECONDS {
        monitor.note(&format!(
            "a trajectory reads about {values:.1e} friction values, {:.1e} apart in sliding distance; all of them take about {} on \
             {threads} threads",
            process.step(),
            duration(seconds)
        ));
    }
}

/// Random trajectories.
#[derive(Debug, Args)]
pub(super) struct Trajectories {
    /// Number of trajectories, in a map per point.
    #[arg(long, value_name = "N", value_parser = args::count, allow_hyphen_values = true)]
    trajectories: usize,
    /// Duration τ of each trajectory.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    duration: f64,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
}

impl Trajectories {
    pub(super) fn settings(&self) -> EnsembleSettings {
        EnsembleSettings::new(self.trajectories, self.duration, self.seed)
    }
}

/// Source of the fluctuation: flags, or the file of a fitted process.
#[derive(Debug, Args)]
#[command(mut_arg("correlation_length", |length| length.required(false).required_unless_present("friction_process")))]
#[command(mut_arg("marginal", |marginal| marginal.required(false).required_unless_present("friction_process")))]
pub(super) struct Source {
    /// Standard deviation of the friction coefficient.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true,
          required_unless_present = "friction_process")]
    friction_std: Option<f64>,
    #[command(flatten)]
    fluctuation: Option<Fluctuation>,
    /// Fitted process, written by `asperity friction fit --out` or by a study, instead of the flags of the fluctuation.
    /// Its mean and its Stribeck coefficient are ignored.
    #[arg(long, value_name = "PROCESS.json", requires = "length_unit",
          conflicts_with_all = ["friction_std", "correlation_length", "marginal", "steps_per_length", "generator",
                                "translation"])]
    friction_process: Option<PathBuf>,
    /// Unit N/c of dimensionless lengths; converts the lengths of the fitted process.
    #[arg(long, value_name = "Q", requires = "friction_process", value_parser = args::positive_quantity::<Length>,
          allow_hyphen_values = true)]
    length_unit: Option<Length>,
    #[command(flatten)]
    clipping: Clipping,
}

/// Treatment of friction values that are not positive.
#[derive(Debug, Args)]
pub(super) struct Clipping {
    /// Allow more than 5 % of the friction values to be clipped to stay positive.
    #[arg(long)]
    allow_clipping: bool,
}

impl Clipping {
    /// Reports the fraction of clipped values. Fails if it is above 5 % and not allowed.
    pub(super) fn accept(&self, fraction: f64, monitor: &Terminal) -> Result<(), Failure> {
        accept_clipping(fraction, self.allow_clipping).map_err(|error| {
            Failure::usage(format_args!(
                "{error}; lower the standard deviation of friction or its weakening with velocity, or add --allow-clipping"
            ))
        })?;
        clipping_warning(fraction).iter().for_each(|warning| monitor.warn(warning));
        Ok(())
    }
}

impl Source {
    /// Returns the process, clipped so that the friction of the oscillator stays positive.
    pub(super) fn process(&self, oscillator: &Oscillator, monitor: &Terminal) -> Result<FrictionProcess, Failure> {
        // The table of a Jacobi diffusion may take seconds.
        let new = |model| monitor.killable(|| FrictionProcess::new(clipped_to_positive(oscillator, model, 1.0)));
        let process = match (&self.friction_process, self.length_unit, self.friction_std, &self.fluctuation) {
            (Some(file), Some(unit), ..) => {
                let refuse = |e| Failure::data(file.display(), &e);
                new(read_process(file)?.model(unit.0).map_err(refuse)?)?.map_err(refuse)?
            }
            (_, _, Some(std), Some(fluctuation)) => new(fluctuation.model(std, 1.0))?.map_err(Failure::usage)?,
            _ => {
                let message = "give --friction-std, --correlation-length and --marginal, or --friction-process";
                return Err(Failure::usage(message));
            }
        };
        self.clipping.accept(process.model().clipped_fraction(), monitor)?;
        Ok(process)
    }

    /// Returns the input file, if any.
    pub(super) fn inputs(&self) -> Option<&Path> {
        self.friction_process.as_deref()
    }
}

/// Fluctuation of the friction coefficient over the sliding distance.
#[derive(Debug, Args)]
pub(super) struct Fluctuation {
    /// Correlation length in sliding distance, λ = ℓ_μ·c/N.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    pub(super) correlation_length: f64,
    /// Shape of the distribution: normal, lognormal:MU,SIGMA, weibull:SHAPE,SCALE, gamma:SHAPE,SCALE, beta:A,B or
    /// triangular:LOW,MODE,HIGH.
    #[arg(long, value_name = "DISTRIBUTION")]
    marginal: Marginal,
    /// Grid points of the fluctuation per correlation length.
    #[arg(long, value_name = "N", default_value = "20", value_parser = args::count, allow_hyphen_values = true)]
    steps_per_length: usize,
    /// Generator of the fluctuation.
    #[arg(long, value_parser = args::named::<Generator>(), default_value = "autoregressive")]
    generator: Generator,
    /// Process that the correlation length refers to: the underlying normal process, or the fluctuation itself.
    #[arg(long, value_parser = args::named::<TranslationKind>(), default_value = "plain")]
    translation: TranslationKind,
}

impl Fluctuation {
    /// Returns the model with a standard deviation `std`, its lengths multiplied by `unit`.
    pub(super) fn model(&self, std: f64, unit: f64) -> ProcessModel {
        ProcessModel {
            steps_per_length: self.steps_per_length,
            generator: self.generator,
            correlation: self.translation,
            ..ProcessModel::new(self.marginal.clone(), std, self.correlation_length / unit)
        }
    }
}
