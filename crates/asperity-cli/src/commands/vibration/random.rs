//! The random friction fluctuation of a command.

use std::path::{Path, PathBuf};

use asperity::distribution::Marginal;
use asperity::friction::process::{FrictionProcess, Generator, ProcessModel, TranslationKind};
use asperity::quantity::Length;
use asperity::study::clipping_warning;
use asperity::vibration::{LARGEST_CLIPPED_FRACTION, Oscillator, clipped_to_positive};
use clap::Args;
use clap::builder::ArgPredicate;

use crate::args;
use crate::commands::friction::read_process;
use crate::failure::Failure;
use crate::monitor::{Terminal, duration};

/// About the time of a core for one value of the fluctuation, with the step to it.
const SECONDS_A_VALUE: f64 = 1e-7;
/// Time from which on it is told before it is spent.
const LONG_SECONDS: f64 = 120.0;

/// Paths that are to be followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paths {
    pub(super) belt_velocity: f64,
    pub(super) duration: f64,
    pub(super) count: usize,
}

impl Paths {
    /// Tells about how long it takes, if that is long: a short correlation length makes many steps.
    pub(super) fn announce(&self, process: &FrictionProcess, monitor: &Terminal) {
        let values = self.belt_velocity * self.duration / process.step();
        let threads = rayon::current_num_threads().min(self.count).max(1);
        let seconds = SECONDS_A_VALUE * values * self.count as f64 / threads as f64;
        if seconds > LONG_SECONDS {
            monitor.note(&format!(
                "a path reads about {values:.1e} values of friction, {:.1e} apart in sliding distance; the paths take about {} on \
                 {threads} threads",
                process.step(),
                duration(seconds)
            ));
        }
    }
}

/// Where the fluctuation comes from: flags, or the file of a fitted process.
#[derive(Debug, Args)]
pub(super) struct Source {
    /// Standard deviation of the friction coefficient.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true,
          required_unless_present = "friction_process",
          requires_ifs = [(ArgPredicate::IsPresent, "correlation_length"), (ArgPredicate::IsPresent, "marginal")])]
    friction_std: Option<f64>,
    #[command(flatten)]
    fluctuation: Option<Fluctuation>,
    /// Fitted process, as `asperity friction fit --out` or a study wrote it, in place of the flags of the fluctuation. Its mean
    /// and its Stribeck coefficient are left aside.
    #[arg(long, value_name = "PROCESS.json", requires = "length_unit",
          conflicts_with_all = ["friction_std", "correlation_length", "marginal"])]
    friction_process: Option<PathBuf>,
    /// Unit N/c of dimensionless lengths, in which the lengths of the fitted process are counted.
    #[arg(long, value_name = "Q", requires = "friction_process", value_parser = args::positive_quantity::<Length>,
          allow_hyphen_values = true)]
    length_unit: Option<Length>,
    #[command(flatten)]
    clipping: Clipping,
}

/// What happens to friction values that would not be positive.
#[derive(Debug, Args)]
pub(super) struct Clipping {
    /// Allow more than 5 % of the friction values to be clipped to stay positive.
    #[arg(long)]
    allow_clipping: bool,
}

impl Clipping {
    /// Reports the fraction of clipped values; fails if it is above 5 % and not allowed.
    pub(super) fn accept(&self, fraction: f64, monitor: &Terminal) -> Result<(), Failure> {
        if fraction > LARGEST_CLIPPED_FRACTION && !self.allow_clipping {
            return Err(Failure::usage(format_args!(
                "{:.3} % of the friction values would be clipped to stay positive, more than {} %; lower the standard deviation \
                 of friction or its weakening with velocity, or allow it with --allow-clipping",
                100.0 * fraction,
                100.0 * LARGEST_CLIPPED_FRACTION
            )));
        }
        clipping_warning(fraction).iter().for_each(|warning| monitor.warn(warning));
        Ok(())
    }
}

impl Source {
    /// The process, clipped so that the friction of the oscillator stays positive.
    pub(super) fn process(&self, oscillator: &Oscillator, monitor: &Terminal) -> Result<FrictionProcess, Failure> {
        let process = match (&self.friction_process, self.length_unit, self.friction_std, &self.fluctuation) {
            (Some(file), Some(unit), ..) => {
                let model = read_process(file)?.model(unit.0);
                let made = model.and_then(|model| FrictionProcess::new(clipped_to_positive(oscillator, model, 1.0)));
                made.map_err(|e| Failure::data(file.display(), &e))?
            }
            (_, _, Some(std), Some(fluctuation)) => {
                FrictionProcess::new(clipped_to_positive(oscillator, fluctuation.model(std, 1.0), 1.0))
                    .map_err(Failure::usage)?
            }
            _ => {
                let wanted = "state --friction-std, --correlation-length and --marginal, or --friction-process";
                return Err(Failure::usage(wanted));
            }
        };
        self.clipping.accept(process.model().clipped_fraction(), monitor)?;
        Ok(process)
    }

    /// Files that are read.
    pub(super) fn inputs(&self) -> Option<&Path> {
        self.friction_process.as_deref()
    }
}

/// The fluctuation of the friction coefficient over the sliding distance.
#[derive(Debug, Args)]
pub(super) struct Fluctuation {
    /// Its correlation length in sliding distance, λ = ℓ_μ·c/N.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    pub(super) correlation_length: f64,
    /// Shape of its law: normal, lognormal:MU,SIGMA, weibull:SHAPE,SCALE, gamma:SHAPE,SCALE or beta:A,B.
    #[arg(long, value_name = "LAW")]
    marginal: Marginal,
    /// Knots of the fluctuation per correlation length.
    #[arg(long, value_name = "N", default_value = "20", value_parser = args::count, allow_hyphen_values = true)]
    steps_per_length: usize,
    /// How it is generated.
    #[arg(long, value_parser = args::named::<Generator>(), default_value = "autoregressive")]
    generator: Generator,
    /// Whose correlation length is meant: of the normal process under the law, or of the fluctuation itself.
    #[arg(long, value_parser = args::named::<TranslationKind>(), default_value = "plain")]
    translation: TranslationKind,
}

impl Fluctuation {
    /// The model of a standard deviation and with lengths in another unit.
    pub(super) fn model(&self, std: f64, unit: f64) -> ProcessModel {
        ProcessModel {
            steps_per_length: self.steps_per_length,
            generator: self.generator,
            correlation: self.translation,
            ..ProcessModel::new(self.marginal.clone(), std, self.correlation_length / unit)
        }
    }
}
