//! Maximum-likelihood fits of distributions, compared by Akaike's criterion.

mod beta;
mod empirical;
mod gamma;
mod johnson;
mod lognormal;
mod maximise;
mod ranking;
mod uncertainty;
mod weibull;

use super::{DistributionError, Marginal};
use crate::stats::{Moments, sorted_present};

pub use ranking::{FitGoodness, Ranking, rank_by_aic};
pub use uncertainty::ParameterEstimate;

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
    /// [`rank_by_aic`].
    pub fn aic_correlated(&self, effective_size: f64) -> f64 {
        2.0 * self.family.parameters() as f64 - 2.0 * effective_size / self.n as f64 * self.log_likelihood
    }

    fn unbounded(family: Family, marginal: Marginal, values: &[f64]) -> Self {
        let log_likelihood = values.iter().map(|x| marginal.ln_pdf(*x)).sum();
        Self { family, marginal, n: values.len(), log_likelihood, low_end: End::Given, high_end: End::Given }
    }
}

/// Fits a distribution of a family by maximum likelihood; NaN values are skipped.
///
/// The likelihood with a free end is unbounded: as the end approaches the extreme of the sample, the density there
/// becomes arbitrarily large. Free ends are therefore *local* maxima outside the sample. Without one, the lognormal,
/// Weibull and Gamma families return an error, and the Beta family sets the end to the extreme of the sample, excludes
/// that value and fits the rest, which converges faster than a regular fit (Smith 1985).
///
/// # References
/// Johnson, Kotz & Balakrishnan, *Continuous Univariate Distributions*, Wiley 1994–95, ch. 14, 17, 21, 25; Smith,
/// *Biometrika* **72** (1985) 67, <https://doi.org/10.1093/biomet/72.1.67>.
///
/// # Errors
/// [`DistributionError::Sample`]: fewer than 10 values, all equal, values outside the support, or no maximum of the
/// likelihood.
pub fn fit(family: Family, values: &[f64]) -> Result<Fit, DistributionError> {
    let sorted = sorted_present(values.iter().copied());
    let error = |reason| DistributionError::Sample { distribution: family.name(), n: sorted.len(), reason };
    match (sorted.first(), sorted.last()) {
        (Some(first), Some(last)) if sorted.len() >= 10 => {
            if !first.is_finite() || !last.is_finite() {
                return Err(error("a value is infinite"));
            }
            if first == last {
                return Err(error("all values are equal"));
            }
            if *first <= 0.0 && matches!(family, Family::Lognormal | Family::Weibull | Family::Gamma) {
                return Err(error("a value is not positive; fit the shift as well"));
            }
        }
        _ => return Err(error("at least 10 are needed")),
    }
    match family {
        Family::Normal => {
            let moments = Moments::new(&sorted);
            Ok(Fit::unbounded(family, Marginal::normal(moments.mean, moments.std)?, &sorted))
        }
        Family::Lognormal => Ok(Fit::unbounded(family, lognormal::fit(&sorted, 0.0)?, &sorted)),
        Family::ShiftedLognormal => maximise::shift(family, &sorted, lognormal::fit),
        Family::Weibull => Ok(Fit::unbounded(family, weibull::fit(&sorted, 0.0)?, &sorted)),
        Family::ShiftedWeibull => maximise::shift(family, &sorted, weibull::fit),
        Family::Gamma => Ok(Fit::unbounded(family, gamma::fit(&sorted, 0.0)?, &sorted)),
        Family::ShiftedGamma => maximise::shift(family, &sorted, gamma::fit),
        Family::Beta { low, high } => beta::fit_between(&sorted, low, high),
        Family::BetaFreeBounds => beta::fit_free(&sorted),
        Family::Johnson => johnson::fit(&sorted),
        Family::Empirical { bins } => empirical::fit(bins, &sorted),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    pub(super) fn sample(marginal: &str, n: usize, index: u64) -> Vec<f64> {
        let marginal: Marginal = marginal.parse().unwrap();
        random::standard_normal(&mut random::stream(8, "fit", index), n)
            .iter()
            .map(|g| marginal.translate(*g))
            .collect()
    }

    /// Every fitted parameter is a stationary point: no neighbour has a larger likelihood.
    pub(super) fn assert_most_likely(fit: &Fit, values: &[f64], neighbours: &[Marginal]) {
        for marginal in neighbours {
            let log_likelihood: f64 = values.iter().map(|x| marginal.ln_pdf(*x)).sum();
            assert!(log_likelihood <= fit.log_likelihood + 1e-7, "{marginal} is more likely than {}", fit.marginal);
        }
    }

    #[test]
    fn the_normal_fit_has_the_likelihood_of_its_closed_form() {
        let values = sample("normal:3,0.5", 500, 0);
        let fit = fit(Family::Normal, &values).unwrap();
        let std = Moments::new(&values).std;
        let closed = -250.0 * ((std::f64::consts::TAU * std * std).ln() + 1.0);
        assert!((fit.log_likelihood / closed - 1.0).abs() < 1e-12);
        assert!((fit.aic() - (4.0 - 2.0 * closed)).abs() < 1e-9);
        assert!((fit.aic_correlated(50.0) - (4.0 - 0.2 * closed)).abs() < 1e-9);
    }

    #[test]
    fn samples_that_no_distribution_can_fit_are_refused_with_the_reason() {
        assert!(fit(Family::Normal, &[1.0; 50]).is_err());
        assert!(fit(Family::Normal, &[1.0, 2.0]).is_err());
        let error = fit(Family::Weibull, &sample("normal", 100, 1)).unwrap_err();
        assert!(error.to_string().contains("not positive"), "{error}");
    }
}
