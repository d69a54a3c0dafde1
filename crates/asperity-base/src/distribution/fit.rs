//! Maximum-likelihood fits of distributions, compared by Akaike's criterion.

mod beta;
mod empirical;
mod family;
mod gamma;
mod johnson;
mod lognormal;
mod maximise;
mod ranking;
mod uncertainty;
mod weibull;

use super::{DistributionError, Marginal};
use crate::stats::{Moments, sorted_present};

pub use family::{End, Family, Fit};
pub use ranking::{Ranking, rank_by_aic};
pub use uncertainty::ParameterEstimate;

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
    fit_sorted(family, &sorted_present(values.iter().copied()))
}

/// Fits as [`fit`] does to sorted values.
fn fit_sorted(family: Family, sorted: &[f64]) -> Result<Fit, DistributionError> {
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
            let moments = Moments::new(sorted);
            Ok(Fit::unbounded(family, Marginal::normal(moments.mean, moments.std)?, sorted))
        }
        Family::Lognormal => Ok(Fit::unbounded(family, lognormal::fit(sorted, 0.0)?, sorted)),
        Family::ShiftedLognormal => maximise::shift(family, sorted, lognormal::fit),
        Family::Weibull => Ok(Fit::unbounded(family, weibull::fit(sorted, 0.0)?, sorted)),
        Family::ShiftedWeibull => maximise::shift(family, sorted, weibull::fit),
        Family::Gamma => Ok(Fit::unbounded(family, gamma::fit(sorted, 0.0)?, sorted)),
        Family::ShiftedGamma => maximise::shift(family, sorted, gamma::fit),
        Family::Beta { low, high } => beta::fit_between(sorted, low, high),
        Family::BetaFreeBounds => beta::fit_free(sorted),
        Family::Johnson => johnson::fit(sorted),
        Family::Empirical { bins } => empirical::fit(bins, sorted),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::special::trigamma;
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

    /// Returns the numbers in the text of a distribution of the same form, with zeros for those that are left out.
    fn numbers(marginal: &Marginal, count: usize) -> Vec<f64> {
        let text = marginal.to_string();
        let mut found: Vec<f64> =
            text.split_once(':').unwrap().1.split(',').map(|part| part.parse().unwrap()).collect();
        found.resize(count.max(found.len()), 0.0);
        found
    }

    #[test]
    fn parameters_are_found_within_their_standard_errors_and_are_a_local_maximum() {
        // Standard errors of one value by the inverse Fisher information; for gamma var k = k/(k ψ′ − 1) and var s = s² ψ′/(k ψ′ − 1).
        let gamma = |k: f64| [k, 4.0 * trigamma(k)].map(|top| (top / (k * trigamma(k) - 1.0)).sqrt()).to_vec();
        let weibull = |k: f64| vec![0.78 * k, 1.05 * 2.0 / k];
        let of_2000 = |errors: [f64; 3]| errors.map(|error| error * 2000_f64.sqrt()).to_vec();
        for (family, planted, n, index, errors) in [
            (Family::Weibull, "weibull:0.6,2", 2000, 10, weibull(0.6)),
            (Family::Weibull, "weibull:1,2", 2000, 11, weibull(1.0)),
            (Family::Weibull, "weibull:4,2", 2000, 12, weibull(4.0)),
            (Family::ShiftedWeibull, "weibull:2.5,2,-7", 2000, 20, of_2000([0.0550, 0.0290, 0.0196])),
            (Family::Gamma, "gamma:0.6,2", 2000, 80, gamma(0.6)),
            (Family::Gamma, "gamma:2,2", 2000, 81, gamma(2.0)),
            (Family::Gamma, "gamma:40,2", 2000, 82, gamma(40.0)),
            (
                Family::ShiftedGamma,
                "gamma:4,2,-7",
                4000,
                84,
                vec![f64::INFINITY, f64::INFINITY, 0.25 * 4000_f64.sqrt()],
            ),
            (Family::Lognormal, "lognormal:0.4,0.7", 2000, 3, vec![0.7, 0.7 / 2_f64.sqrt()]),
            (Family::ShiftedLognormal, "lognormal:0.4,0.7,-3", 2000, 4, of_2000([0.0281, 0.0197, 0.0272])),
        ] {
            let values = sample(planted, n, index);
            let fitted = fit(family, &values).unwrap();
            let free = errors.len();
            let (found, wanted) = (numbers(&fitted.marginal, free), numbers(&planted.parse().unwrap(), free));
            for (i, error) in errors.into_iter().enumerate() {
                assert!((found[i] - wanted[i]).abs() < 4.0 * error / (n as f64).sqrt(), "{planted}: {fitted:?}");
            }
            assert!(free == 3 || found.get(2).is_none_or(|shift| *shift == 0.0), "{fitted:?}");
            assert!(free == 2 || fitted.low_end == End::Fitted, "{fitted:?}");
            let (name, _) = planted.split_once(':').unwrap();
            let neighbours = (0..2 * free).map(|i| {
                let mut moved = found.clone();
                moved[i / 2] += if i % 2 == 0 { 1e-3 } else { -1e-3 };
                let list: Vec<String> = moved.iter().map(|number| format!("{number:?}")).collect();
                format!("{name}:{}", list.join(",")).parse().unwrap()
            });
            assert_most_likely(&fitted, &values, &neighbours.collect::<Vec<_>>());
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
