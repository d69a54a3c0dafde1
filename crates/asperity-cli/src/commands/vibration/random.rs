//! The random friction fluctuation of a command.

use asperity::friction::process::{Correlation, FrictionProcess, Generator, ProcessError, ProcessModel};
use asperity::law::Marginal;
use clap::{Args, ValueEnum};

use crate::args;
use crate::failure::Failure;

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
    #[arg(long, value_enum, default_value = "autoregressive")]
    generator: Way,
    /// Whose correlation length is meant: of the normal process under the law, or of the fluctuation itself.
    #[arg(long, value_enum, default_value = "plain")]
    translation: Translation,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Way {
    /// The exact recursion of an Ornstein–Uhlenbeck process under the law.
    Autoregressive,
    /// A sum of 256 random harmonics under the law, after the paper.
    Spectral,
    /// A diffusion with Beta law, of exactly exponential correlation.
    Jacobi,
    /// Fresh values over exponential lengths, of exactly exponential correlation.
    Renewal,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Translation {
    Plain,
    Corrected,
}

impl Fluctuation {
    /// The process of a standard deviation and with lengths in another unit.
    pub(super) fn process(&self, std: f64, unit: f64) -> Result<FrictionProcess, Failure> {
        self.made(std, unit).map_err(Failure::usage)
    }

    /// The same, with the library's error.
    pub(super) fn made(&self, std: f64, unit: f64) -> Result<FrictionProcess, ProcessError> {
        let model = ProcessModel::new(self.marginal.clone(), std, self.correlation_length / unit);
        FrictionProcess::new(ProcessModel {
            steps_per_length: self.steps_per_length,
            generator: match self.generator {
                Way::Autoregressive => Generator::Autoregressive,
                Way::Spectral => Generator::Spectral { harmonics: 256 },
                Way::Jacobi => Generator::Jacobi,
                Way::Renewal => Generator::Renewal,
            },
            correlation: match self.translation {
                Translation::Plain => Correlation::Plain,
                Translation::Corrected => Correlation::Corrected,
            },
            ..model
        })
    }
}
