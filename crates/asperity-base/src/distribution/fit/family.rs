//! Families of distributions and fits of them.

use crate::distribution::Marginal;

/// Family of distributions for fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Family {
    /// Normal distribution: mean and standard deviation (divisor n).
    Normal,
    /// Lognormal distribution of positive values, no shift.
    Lognormal,
    /// Lognormal distribution with a fitted shift.
    ShiftedLognormal,
    /// Weibull distribution of positive values, no shift.
    Weibull,
    /// Weibull distribution with a fitted shift.
    ShiftedWeibull,
    /// Gamma distribution of positive values, no shift.
    Gamma,
    /// Gamma distribution with a fitted shift.
    ShiftedGamma,
    /// Beta distribution between known bounds.
    Beta {
        /// Lower end of the support.
        low: f64,
        /// Upper end of the support.
        high: f64,
    },
    /// Beta distribution with fitted bounds.
    BetaFreeBounds,
    /// Johnson distribution, unbounded or bounded, whichever has the larger likelihood.
    Johnson,
    /// Piecewise constant density of the sample in bins of equal probability.
    Empirical {
        /// Number of bins.
        bins: usize,
    },
}

impl Family {
    /// Families for any sample, of values of any sign and without known bounds.
    pub const ANYWHERE: [Self; 4] = [Self::Normal, Self::ShiftedLognormal, Self::ShiftedWeibull, Self::BetaFreeBounds];

    /// Families for heights: [`Family::ANYWHERE`] and Johnson's with free skewness and kurtosis.
    pub const HEIGHTS: [Self; 5] =
        [Self::Normal, Self::ShiftedLognormal, Self::ShiftedWeibull, Self::BetaFreeBounds, Self::Johnson];

    /// All families for positive values without known bounds.
    pub const POSITIVE: [Self; 8] = [
        Self::Normal,
        Self::Lognormal,
        Self::ShiftedLognormal,
        Self::Weibull,
        Self::ShiftedWeibull,
        Self::Gamma,
        Self::ShiftedGamma,
        Self::BetaFreeBounds,
    ];

    /// Piecewise constant densities from coarse to fine; a ranking keeps the best of them.
    pub const EMPIRICAL: [Self; 4] = [
        Self::Empirical { bins: 4 },
        Self::Empirical { bins: 8 },
        Self::Empirical { bins: 16 },
        Self::Empirical { bins: 32 },
    ];

    /// Returns the name of the distribution.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Lognormal | Self::ShiftedLognormal => "lognormal",
            Self::Weibull | Self::ShiftedWeibull => "weibull",
            Self::Gamma | Self::ShiftedGamma => "gamma",
            Self::Beta { .. } | Self::BetaFreeBounds => "beta",
            Self::Johnson => "johnson",
            Self::Empirical { .. } => "empirical",
        }
    }

    /// Returns a name that distinguishes distributions with and without a fitted shift.
    pub fn key(self) -> &'static str {
        match self {
            Self::ShiftedLognormal => "shifted_lognormal",
            Self::ShiftedWeibull => "shifted_weibull",
            Self::ShiftedGamma => "shifted_gamma",
            _ => self.name(),
        }
    }

    /// Returns the number of fitted parameters.
    pub fn parameters(self) -> usize {
        match self {
            Self::Normal | Self::Lognormal | Self::Weibull | Self::Gamma | Self::Beta { .. } => 2,
            Self::ShiftedLognormal | Self::ShiftedWeibull | Self::ShiftedGamma => 3,
            Self::BetaFreeBounds | Self::Johnson => 4,
            Self::Empirical { bins } => bins + 1,
        }
    }
}

/// Origin of the end of a fitted distribution's support.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Infinite, or prescribed.
    Given,
    /// Local maximum of the likelihood outside the sample.
    Fitted,
    /// Extreme value of the sample: the likelihood has no maximum outside it, because the density is positive there.
    SampleExtreme,
    /// So far away that the sample does not determine it; the distribution is close to one without that end.
    OutOfSight,
}

/// Fit of a distribution to a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The family.
    pub family: Family,
    /// Distribution of maximum likelihood.
    pub marginal: Marginal,
    /// Number of values.
    pub n: usize,
    /// Log likelihood, in units of the values^{−n}. A value at an [`End::SampleExtreme`], where the density is 0 or
    /// infinite, contributes the mean of the others.
    pub log_likelihood: f64,
    /// Lower end of the support.
    pub low_end: End,
    /// Upper end of the support.
    pub high_end: End,
}

impl Fit {
    /// Returns Akaike's criterion 2k − 2 ln L for independent values; smaller is better.
    pub fn aic(&self) -> f64 {
        self.aic_correlated(self.n as f64)
    }

    /// Returns Akaike's criterion 2k − 2 (n_eff/n) ln L of a correlated sample with effective size n_eff; see
    /// [`super::rank_by_aic`].
    pub fn aic_correlated(&self, effective_size: f64) -> f64 {
        2.0 * self.family.parameters() as f64 - 2.0 * effective_size / self.n as f64 * self.log_likelihood
    }

    pub(super) fn unbounded(family: Family, marginal: Marginal, values: &[f64]) -> Self {
        let log_likelihood = values.iter().map(|x| marginal.ln_pdf(*x)).sum();
        Self { family, marginal, n: values.len(), log_likelihood, low_end: End::Given, high_end: End::Given }
    }
}
