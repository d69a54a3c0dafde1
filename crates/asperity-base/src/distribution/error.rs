//! Errors of distributions.

use thiserror::Error;

/// Error of a distribution or of its fit.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DistributionError {
    /// A parameter outside its range.
    #[error("{distribution}: {parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the distribution.
        distribution: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// Rejected value.
        value: f64,
        /// Range of the parameter.
        wanted: &'static str,
    },
    /// A sample that is too small or degenerate.
    #[error("{distribution}: cannot be fitted to {n} values: {reason}")]
    Sample {
        /// Name of the distribution.
        distribution: &'static str,
        /// Sample size.
        n: usize,
        /// Description of the problem.
        reason: &'static str,
    },
    /// Moments that no distribution has.
    #[error(
        "no marginal has a skewness of {skewness} and a kurtosis of {kurtosis}: the kurtosis (3 for the normal marginal) must exceed \
         1 + skewness² = {least}"
    )]
    Infeasible {
        /// Requested skewness.
        skewness: f64,
        /// Requested kurtosis; 3 for the normal distribution.
        kurtosis: f64,
        /// 1 + skewness², the kurtosis of two point masses and lower bound of any density's.
        least: f64,
    },
    /// No parameters found for these moments.
    #[error("{distribution}: no parameters found for a skewness of {skewness} and a kurtosis of {kurtosis}: {reason}")]
    Moments {
        /// Name of the distribution.
        distribution: &'static str,
        /// Requested skewness.
        skewness: f64,
        /// Requested kurtosis; 3 for the normal distribution.
        kurtosis: f64,
        /// Description of the problem.
        reason: &'static str,
    },
    /// A correlation that no correlation of normal variables translates to.
    #[error(
        "{distribution}: a correlation of {target} cannot be reached; translated normal variables reach {least} to 1"
    )]
    Correlation {
        /// Name of the distribution.
        distribution: &'static str,
        /// Requested correlation.
        target: f64,
        /// Least attainable correlation.
        least: f64,
    },
    /// A text that is not a distribution.
    #[error(
        "`{text}` is not a marginal; write normal[:MEAN,STD], lognormal:MU,SIGMA[,SHIFT], weibull:SHAPE,SCALE[,SHIFT], \
         gamma:SHAPE,SCALE[,SHIFT], beta:A,B[,LOW,HIGH], uniform:LOW,HIGH, triangular:LOW,MODE,HIGH, \
         johnson:SKEWNESS,KURTOSIS[,MEAN,STD] (a normal kurtosis is 3) or \
         johnson_su|johnson_sb|johnson_sl|johnson_sn:GAMMA,DELTA[,XI,LAMBDA]"
    )]
    Syntax {
        /// The text.
        text: String,
    },
}
