//! Piecewise constant density of a sample.

use super::family::{End, Family, Fit};
use crate::distribution::{DistributionError, Marginal};
use crate::stats::quantile_sorted;

/// Least number of values per bin.
const LEAST: usize = 5;
/// Number of values that represent the distribution.
const HELD: usize = 1001;

/// Returns a density that is constant in bins of equal probability, bounded by quantiles of the sample. Every bin edge,
/// including the extremes, counts as a parameter in Akaike's criterion.
pub(super) fn fit(bins: usize, sorted: &[f64]) -> Result<Fit, DistributionError> {
    let n = sorted.len();
    let error = |reason| DistributionError::Sample { distribution: "empirical", n, reason };
    if bins == 0 || n < LEAST * bins {
        return Err(error("a bin needs five values"));
    }
    let edges: Vec<f64> = (0..=bins).map(|edge| quantile_sorted(sorted, edge as f64 / bins as f64)).collect();
    if edges.windows(2).any(|bin| bin[1] <= bin[0]) {
        return Err(error("too many values are equal"));
    }
    let mut log_likelihood = 0.0;
    let mut below = 0;
    for (bin, ends) in edges.windows(2).enumerate() {
        let through = if bin + 1 == bins { n } else { sorted.partition_point(|x| *x <= ends[1]) };
        log_likelihood -= (through - below) as f64 * (bins as f64 * (ends[1] - ends[0])).ln();
        below = through;
    }
    let quantile = |place: usize| {
        let position = (place as f64 + 0.5) / HELD as f64 * bins as f64;
        let bin = (position as usize).min(bins - 1);
        edges[bin] + (position - bin as f64) * (edges[bin + 1] - edges[bin])
    };
    Ok(Fit {
        family: Family::Empirical { bins },
        marginal: Marginal::empirical((0..HELD).map(quantile).collect())?,
        n,
        log_likelihood,
        low_end: End::SampleExtreme,
        high_end: End::SampleExtreme,
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::super::{Family, rank_by_aic};
    use super::*;
    use crate::random;

    #[test]
    fn the_density_is_constant_between_equally_spaced_quantiles() {
        // Fractions of 1/2 on (0, 1) and (1, 3): densities 1/2 and 1/4.
        let low = (0..50).map(|i| f64::from(i) / 50.0);
        let sorted: Vec<f64> = low.chain((0..=50).map(|i| 1.0 + f64::from(i) / 25.0)).collect();
        let found = fit(2, &sorted).unwrap();
        // The median, 1, is the 51st of 101 values and belongs to the lower bin.
        assert!((found.log_likelihood - (51.0 * 0.5_f64.ln() + 50.0 * 0.25_f64.ln())).abs() < 1e-12);
        let fraction = |from: f64, to: f64| found.marginal.cdf(to) - found.marginal.cdf(from);
        assert!(
            (fraction(0.2, 0.8) - 0.3).abs() < 1e-9 && (fraction(1.5, 2.5) - 0.25).abs() < 1e-9,
            "{}",
            fraction(1.5, 2.5)
        );
        assert!((found.marginal.quantile(0.75) - 2.0).abs() < 1e-9);
        assert_eq!(found.family.parameters(), 3);
        assert!(fit(32, &sorted).is_err() && fit(4, &[1.0; 100]).is_err());
    }

    #[test]
    fn the_empirical_distribution_wins_where_no_family_fits_and_only_with_enough_values() {
        let families = [&Family::ANYWHERE[..], &Family::EMPIRICAL].concat();
        let two: Vec<f64> = sample("normal:-3,1", 1000, 5).into_iter().chain(sample("normal:3,1", 1000, 6)).collect();
        let ranking = rank_by_aic(&families, &two, None);
        assert!(matches!(ranking.fits[0].family, Family::Empirical { .. }), "{ranking:?}");
        assert_eq!(ranking.fits.iter().filter(|fit| fit.family.name() == "empirical").count(), 1);
        // For a normal sample the steps cost the sum over bins of the change of the density: a hundredth in ln f for
        // some tens of bins.
        let one = random::standard_normal(&mut random::stream(8, "fit/empirical", 0), 2000);
        assert_eq!(rank_by_aic(&families, &one, None).fits[0].family, Family::Normal);
        // With an effective size of ten, four bins with five edges cost more than they gain.
        assert!(!matches!(rank_by_aic(&families, &two, Some(4.0)).fits[0].family, Family::Empirical { .. }));
    }
}
