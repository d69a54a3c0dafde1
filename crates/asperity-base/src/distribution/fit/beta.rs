//! Beta distribution with given or free bounds.

use super::family::{End, Family, Fit};
use super::maximise::{FARTHEST, NEAREST};
use crate::distribution::special::{digamma, ln_beta, trigamma};
use crate::distribution::{DistributionError, Marginal, condensed};
use crate::numeric::simplex;
use crate::stats::Moments;

/// Maximum-likelihood shapes, and the mean log-density on [0, 1].
#[derive(Debug, Clone, Copy)]
struct Shapes {
    a: f64,
    b: f64,
    mean_log_density: f64,
}

/// Returns the Beta distribution on [low, high] with the mean and variance of the values (divisor n), which may equal
/// the bounds.
///
/// Simple and robust, but not efficient. If `low` and `high` are the extremes of the sample, as often when records are
/// "scaled to (0, 1)", the shapes depend on the sample size: use [`Family::BetaFreeBounds`] instead.
///
/// # Errors
/// Fewer than two values, a value outside the bounds, or a variance that no Beta distribution on them has.
pub(super) fn beta_by_moments(values: &[f64], low: f64, high: f64) -> Result<Marginal, DistributionError> {
    let moments = Moments::new(values);
    let error = |reason| DistributionError::Sample { distribution: "beta", n: moments.n, reason };
    if moments.n < 2 {
        return Err(error("at least two are needed"));
    }
    if values.iter().any(|x| *x < low || *x > high) {
        return Err(error("a value lies outside the bounds"));
    }
    let (mean, variance) = ((moments.mean - low) / (high - low), (moments.std / (high - low)).powi(2));
    let sum = mean * (1.0 - mean) / variance - 1.0;
    if !(sum.is_finite() && sum > 0.0) {
        return Err(error("their variance fits no Beta distribution on these bounds"));
    }
    Marginal::beta(mean * sum, (1.0 - mean) * sum, low, high)
}

/// Returns the maximum-likelihood shapes for known bounds.
pub(super) fn fit_between(sorted: &[f64], low: f64, high: f64) -> Result<Fit, DistributionError> {
    Marginal::beta(1.0, 1.0, low, high)?;
    if sorted[0] <= low || sorted[sorted.len() - 1] >= high {
        let reason = "a value lies at or outside the bounds, where the likelihood is 0 or infinite";
        return Err(DistributionError::Sample { distribution: "beta", n: sorted.len(), reason });
    }
    let shapes = shapes(sorted, low, high).ok_or_else(|| no_maximum(sorted))?;
    let marginal = Marginal::beta(shapes.a, shapes.b, low, high)?;
    Ok(Fit::unbounded(Family::Beta { low, high }, marginal, sorted))
}

/// Returns the maximum-likelihood shapes and bounds, as defined for [`super::fit`]. The bounds of a large sample are
/// found on the [`condensed`] one.
pub(super) fn fit_free(sorted: &[f64]) -> Result<Fit, DistributionError> {
    fit_free_by(sorted, &condensed(sorted))
}

/// Fits as [`fit_free`] does, with a search over the values of `few`.
fn fit_free_by(sorted: &[f64], few: &[f64]) -> Result<Fit, DistributionError> {
    let mut kept = few;
    let (mut low, mut high) = (None, None);
    // Each round may find that an end has no maximum outside the sample; the end is then fixed at the extreme.
    loop {
        let (gaps, found) = climb(sorted, kept, low, high).ok_or_else(|| no_maximum(sorted))?;
        if low.is_none() && (found.a < 1.0 + AT_ONE || gaps[0] <= 1.01 * NEAREST) {
            low = Some(sorted[0]);
            kept = &kept[kept.partition_point(|x| *x <= sorted[0])..];
        } else if high.is_none() && (found.b < 1.0 + AT_ONE || gaps[1] <= 1.01 * NEAREST) {
            let last = sorted[sorted.len() - 1];
            high = Some(last);
            kept = &kept[..kept.partition_point(|x| *x < last)];
        } else {
            let end = |fixed: Option<f64>, gap: f64| match fixed {
                Some(_) => End::SampleExtreme,
                None if gap >= 0.99 * FARTHEST_BETA => End::OutOfSight,
                None => End::Fitted,
            };
            let (low_end, high_end) = (end(low, gaps[0]), end(high, gaps[1]));
            // A value at a fixed end has no finite density.
            let first = low.map_or(0, |low| sorted.partition_point(|x| *x <= low));
            let last = high.map_or(sorted.len(), |high| sorted.partition_point(|x| *x < high));
            let [low, high] = bounds(sorted, low, high, gaps);
            let found = shapes(&sorted[first..last], low, high).ok_or_else(|| no_maximum(sorted))?;
            let marginal = Marginal::beta(found.a, found.b, low, high)?;
            let log_likelihood = sorted.len() as f64 * (found.mean_log_density - (high - low).ln());
            return Ok(Fit {
                family: Family::BetaFreeBounds,
                marginal,
                n: sorted.len(),
                log_likelihood,
                low_end,
                high_end,
            });
        }
    }
}

/// Tolerance of a shape at its lower bound of one.
const AT_ONE: f64 = 1e-3;
/// Largest gap in ranges: beyond a hundred the shapes are in the thousands and the distribution is practically normal.
const FARTHEST_BETA: f64 = 0.1 * FARTHEST;

fn no_maximum(sorted: &[f64]) -> DistributionError {
    DistributionError::Sample {
        distribution: "beta",
        n: sorted.len(),
        reason: "the likelihood has no maximum over the shapes",
    }
}

fn bounds(sorted: &[f64], low: Option<f64>, high: Option<f64>, gaps: [f64; 2]) -> [f64; 2] {
    let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
    let range = last - first;
    [low.unwrap_or(first - range * gaps[0]), high.unwrap_or(last + range * gaps[1])]
}

/// Maximises the profile likelihood of the retained values over the gaps (in ranges) of the free bounds. Shapes at free
/// ends are at least one, where the likelihood is bounded.
fn climb(sorted: &[f64], kept: &[f64], low: Option<f64>, high: Option<f64>) -> Option<([f64; 2], Shapes)> {
    let range = sorted[sorted.len() - 1] - sorted[0];
    let at = |log_gaps: [f64; 2]| {
        let gaps = log_gaps.map(|gap| gap.exp());
        let [low_m, high_m] = bounds(sorted, low, high, gaps);
        shapes(kept, low_m, high_m).filter(|s| (low.is_some() || s.a >= 1.0) && (high.is_some() || s.b >= 1.0))
    };
    let profile = |log_gaps: [f64; 2]| {
        let outside = log_gaps.iter().any(|gap| !(NEAREST.ln()..=FARTHEST_BETA.ln()).contains(gap));
        if outside {
            return f64::NEG_INFINITY;
        }
        let [low_m, high_m] = bounds(sorted, low, high, log_gaps.map(|gap| gap.exp()));
        at(log_gaps).map_or(f64::NEG_INFINITY, |s| s.mean_log_density - ((high_m - low_m) / range).ln())
    };
    let starts = [0.05, 0.5, 5.0];
    let pairs = starts.iter().flat_map(|l| starts.iter().map(move |h| [*l, *h]));
    // A given end needs one start only, since its gap has no effect.
    let pairs = pairs.filter(|[l, h]| (low.is_none() || *l == 0.5) && (high.is_none() || *h == 0.5));
    let (log_gaps, height) = pairs
        .map(|pair| pair.map(f64::ln))
        .map(|pair| (pair, profile(pair)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(pair, _)| simplex(profile, pair, 0.5))?;
    if height == f64::NEG_INFINITY {
        return None;
    }
    Some((log_gaps.map(f64::exp), at(log_gaps)?))
}

/// Newton's method on the concave mean log-density (a−1) mean ln u + (b−1) mean ln(1−u) − ln B(a, b), from the moments.
fn shapes(values: &[f64], low: f64, high: f64) -> Option<Shapes> {
    let width = high - low;
    let n = values.len() as f64;
    let (below, above) =
        values.iter().fold((0.0, 0.0), |(below, above), x| (below + (x - low).ln(), above + (high - x).ln()));
    let (below, above) = (below / n - width.ln(), above / n - width.ln());
    if !(below.is_finite() && above.is_finite()) {
        return None;
    }
    let height = |a: f64, b: f64| (a - 1.0) * below + (b - 1.0) * above - ln_beta(a, b);
    let (mut a, mut b) = match beta_by_moments(values, low, high) {
        Ok(Marginal::Beta { a, b, .. }) => (a, b),
        _ => (1.0, 1.0),
    };
    let mut reached = height(a, b);
    for _ in 0..100 {
        let common = digamma(a + b);
        let gradient = [below - digamma(a) + common, above - digamma(b) + common];
        let (curve, curve_a, curve_b) = (trigamma(a + b), trigamma(a), trigamma(b));
        // −Hessian = diag(ψ′(a), ψ′(b)) − ψ′(a+b), inverted in closed form.
        let determinant = curve_a * curve_b - curve * (curve_a + curve_b);
        let step_a = ((curve_b - curve) * gradient[0] + curve * gradient[1]) / determinant;
        let step_b = (curve * gradient[0] + (curve_a - curve) * gradient[1]) / determinant;
        if !(step_a.is_finite() && step_b.is_finite()) {
            return None;
        }
        let mut fraction = 1.0;
        let (next_a, next_b, next) = loop {
            let (next_a, next_b) = (a + fraction * step_a, b + fraction * step_b);
            if next_a > 0.0 && next_b > 0.0 {
                let next = height(next_a, next_b);
                if next >= reached - 1e-14 * (1.0 + reached.abs()) {
                    break (next_a, next_b, next);
                }
            }
            fraction *= 0.5;
            if fraction < 1e-10 {
                break (a, b, reached);
            }
        };
        let moved = f64::max((next_a / a - 1.0).abs(), (next_b / b - 1.0).abs());
        (a, b, reached) = (next_a, next_b, next);
        if moved < 1e-13 {
            break;
        }
    }
    Some(Shapes { a, b, mean_log_density: reached })
}

#[cfg(test)]
mod tests {
    use super::super::fit;
    use super::super::tests::{assert_most_likely, sample};
    use super::*;

    fn parameters(marginal: &Marginal) -> (f64, f64, f64, f64) {
        let Marginal::Beta { a, b, low, high } = *marginal else { panic!("{marginal} is no Beta distribution") };
        (a, b, low, high)
    }

    #[test]
    fn shapes_between_known_bounds_are_found_within_their_standard_errors() {
        let n = 2000;
        for (index, (wanted_a, wanted_b)) in [(2.1, 5.0), (0.5, 0.4), (30.0, 20.0)].into_iter().enumerate() {
            let values = sample(&format!("beta:{wanted_a},{wanted_b},-1,3"), n, 30 + index as u64);
            let fitted = fit(Family::Beta { low: -1.0, high: 3.0 }, &values).unwrap();
            let (a, b, ..) = parameters(&fitted.marginal);
            // The inverse Fisher information of one value.
            let (curve, curve_a, curve_b) = (trigamma(wanted_a + wanted_b), trigamma(wanted_a), trigamma(wanted_b));
            let determinant = curve_a * curve_b - curve * (curve_a + curve_b);
            let root = (n as f64).sqrt();
            assert!((a - wanted_a).abs() < 4.0 * ((curve_b - curve) / determinant).sqrt() / root, "{a}");
            assert!((b - wanted_b).abs() < 4.0 * ((curve_a - curve) / determinant).sqrt() / root, "{b}");
            let near = |h: f64, k: f64| Marginal::beta(a + h, b + k, -1.0, 3.0).unwrap();
            let neighbours = [near(1e-3, 0.0), near(-1e-3, 0.0), near(0.0, 1e-3), near(0.0, -1e-3)];
            assert_most_likely(&fitted, &values, &neighbours);
        }
        assert!(fit(Family::Beta { low: 0.0, high: 1.0 }, &sample("beta:2,2,0,2", 100, 40)).is_err());
    }

    #[test]
    fn free_bounds_do_not_depend_on_the_sample_size_unlike_the_extremes() {
        for (n, trials, wanted) in [(100, 400, (1.42, 2.35)), (1000, 40, (1.79, 3.40))] {
            let (mut by_extremes, mut free) = (vec![], vec![]);
            for trial in 0..trials {
                let values = sample("beta:2.1,5", n, 1000 + trial);
                let (least, largest) =
                    values.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
                by_extremes.push(parameters(&beta_by_moments(&values, least, largest).unwrap()));
                if n == 1000 {
                    free.push(parameters(&fit(Family::BetaFreeBounds, &values).unwrap().marginal));
                }
            }
            let of = |marginals: &[(f64, f64, f64, f64)], pick: fn(&(f64, f64, f64, f64)) -> f64| {
                Moments::new(&marginals.iter().map(pick).collect::<Vec<_>>())
            };
            let (a, b) = (of(&by_extremes, |p| p.0), of(&by_extremes, |p| p.1));
            // The published means are rounded to the last digit shown.
            assert!((a.mean - wanted.0).abs() < 4.0 * a.standard_error() + 0.005, "n = {n}: {a:?}");
            assert!((b.mean - wanted.1).abs() < 4.0 * b.standard_error() + 0.005, "n = {n}: {b:?}");
            if n == 1000 {
                for (found, wanted) in [
                    (of(&free, |p| p.0), 2.1),
                    (of(&free, |p| p.1), 5.0),
                    (of(&free, |p| p.2), 0.0),
                    (of(&free, |p| p.3), 1.0),
                ] {
                    assert!((found.mean - wanted).abs() < 4.0 * found.standard_error(), "{wanted}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn free_bounds_are_a_local_maximum_of_the_likelihood() {
        let values = sample("beta:3,4,-2,6", 1000, 70);
        let fitted = fit(Family::BetaFreeBounds, &values).unwrap();
        assert_eq!((fitted.low_end, fitted.high_end), (End::Fitted, End::Fitted));
        let (a, b, low, high) = parameters(&fitted.marginal);
        let direct: f64 = values.iter().map(|x| fitted.marginal.ln_pdf(*x)).sum();
        assert!((direct - fitted.log_likelihood).abs() < 1e-8);
        let neighbours: Vec<Marginal> = [-1e-3, 1e-3]
            .into_iter()
            .flat_map(|h| [[h, 0.0, 0.0, 0.0], [0.0, h, 0.0, 0.0], [0.0, 0.0, h, 0.0], [0.0, 0.0, 0.0, h]])
            .map(|[da, db, dl, dh]| Marginal::beta(a + da, b + db, low + dl, high + dh).unwrap())
            .collect();
        assert_most_likely(&fitted, &values, &neighbours);
    }

    #[test]
    fn a_search_over_group_means_finds_the_bounds_of_the_whole_sample() {
        for text in ["beta:3,4,-2,6", "beta:0.7,3,-2,4"] {
            let mut sorted = sample(text, 40_000, 71);
            sorted.sort_by(f64::total_cmp);
            let (found, wanted) = (fit_free(&sorted).unwrap(), fit_free_by(&sorted, &sorted).unwrap());
            let gain = wanted.log_likelihood - found.log_likelihood;
            // One standard error of a parameter costs 1/2.
            assert!((-1e-3..0.05).contains(&gain), "{text}: {gain} {found:?} {wanted:?}");
            assert_eq!((found.low_end, found.high_end), (wanted.low_end, wanted.high_end));
        }
    }

    #[test]
    fn ends_with_a_discontinuous_density_are_at_the_extremes() {
        for (marginal, index) in [("beta:0.5,0.6,-2,4", 50), ("beta:0.7,3,-2,4", 51)] {
            let values = sample(marginal, 2000, index);
            let fitted = fit(Family::BetaFreeBounds, &values).unwrap();
            let (wanted_a, wanted_b, ..) = parameters(&marginal.parse().unwrap());
            let (a, b, low, high) = parameters(&fitted.marginal);
            assert_eq!(fitted.low_end, End::SampleExtreme, "{fitted:?}");
            assert!((low + 2.0).abs() < 0.01 && (a / wanted_a - 1.0).abs() < 0.15, "{fitted:?}");
            assert!((b / wanted_b - 1.0).abs() < 0.3 && (high - 4.0).abs() < 0.8, "{fitted:?}");
            assert!(fitted.log_likelihood.is_finite());
        }
    }

    #[test]
    fn bounds_of_a_normal_sample_are_undetermined_or_distant() {
        let fitted = fit(Family::BetaFreeBounds, &sample("normal:10,2", 1000, 60)).unwrap();
        let normal = fit(Family::Normal, &sample("normal:10,2", 1000, 60)).unwrap();
        assert!((fitted.marginal.mean() - 10.0).abs() < 0.3 && (fitted.marginal.std() - 2.0).abs() < 0.2, "{fitted:?}");
        assert!(
            fitted.log_likelihood > normal.log_likelihood - 0.1,
            "the normal distribution is a limit of Beta distributions"
        );
    }
}
