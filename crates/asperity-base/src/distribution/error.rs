//! Why a distribution could not be made.

use thiserror::Error;

/// Why a distribution could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DistributionError {
    /// A parameter lies outside its range.
    #[error("{distribution}: {parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the distribution.
        distribution: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// The sample is too small or degenerate.
    #[error("{distribution}: cannot be fitted to {n} values: {reason}")]
    Sample {
        /// Name of the distribution.
        distribution: &'static str,
        /// Sample size.
        n: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// No distribution at all has these moments.
    #[error(
        "no marginal has a skewness of {skewness} and a kurtosis of {kurtosis}: the kurtosis (3 for the normal marginal) must exceed \
         1 + skewness² = {least}"
    )]
    Infeasible {
        /// Skewness that was wanted.
        skewness: f64,
        /// Kurtosis that was wanted; 3 for the normal distribution.
        kurtosis: f64,
        /// 1 + skewness², the kurtosis of two point masses, which a density exceeds.
        least: f64,
    },
    /// The parameters of a distribution with these moments were not found.
    #[error("{distribution}: no parameters found for a skewness of {skewness} and a kurtosis of {kurtosis}: {reason}")]
    Moments {
        /// Name of the distribution.
        distribution: &'static str,
        /// Skewness that was wanted.
        skewness: f64,
        /// Kurtosis that was wanted; 3 for the normal distribution.
        kurtosis: f64,
        /// What is in the way.
        reason: &'static str,
    },
    /// No correlation of normal variables gives the wanted one.
    #[error(
        "{distribution}: a correlation of {target} cannot be reached; translated normal variables reach {least} to 1"
    )]
    Correlation {
        /// Name of the distribution.
        distribution: &'static str,
        /// Correlation that was wanted.
        target: f64,
        /// Least correlation that can be reached.
        least: f64,
    },
    /// The text names no distribution.
    #[error(
        "`{text}` is not a marginal; write normal[:MEAN,STD], lognormal:MU,SIGMA[,SHIFT], weibull:SHAPE,SCALE[,SHIFT], \
         gamma:SHAPE,SCALE[,SHIFT], beta:A,B[,LOW,HIGH], johnson:SKEWNESS,KURTOSIS[,MEAN,STD] (a normal kurtosis is 3) or \
         johnson_su|johnson_sb|johnson_sl|johnson_sn:GAMMA,DELTA[,XI,LAMBDA]"
    )]
    Syntax {
        /// What was found.
        text: String,
    },
}
