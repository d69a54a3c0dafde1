//! Special functions for distributions, with relative errors of about 1e-14. The rounding of ln Γ adds to it for large shapes.

use statrs::function::{erf, gamma};

/// Argument beyond which e^{−x²/2} underflows.
const FARTHEST: f64 = 40.0;

/// Returns the standard normal distribution function Φ.
#[inline]
pub fn standard_normal_cdf(x: f64) -> f64 {
    let tail = |x: f64| 0.5 * exp_minus_half_square(x) * scaled_erfc(x * std::f64::consts::FRAC_1_SQRT_2);
    if x.is_nan() {
        f64::NAN
    } else if x.abs() > FARTHEST {
        if x < 0.0 { 0.0 } else { 1.0 }
    } else if x.abs() < 0.5 {
        // Σ x^{2n+1}/(2n+1)!!, times φ: the area between 0 and x.
        let (mut term, mut sum, mut odd) = (x, x, 1.0);
        while term.abs() > 1e-17 * sum.abs() {
            odd += 2.0;
            term *= x * x / odd;
            sum += term;
        }
        0.5 + standard_normal_pdf(x) * sum
    } else if x < 0.0 {
        tail(-x)
    } else {
        1.0 - tail(x)
    }
}

/// Returns e^{y²} erfc(y) for y ≥ ¼, by the trapezoidal rule on y/π ∫ e^{−t²}/(t² + y²) dt with the residue of its
/// pole.
///
/// With a step of ½ the error is about e^{−4π²} = 7e-18. For comparison, statrs' erfc has errors of 1e-11 in the tails.
///
/// # References
/// Matta & Reichel, *Math. Comp.* **25** (1971) 339.
fn scaled_erfc(y: f64) -> f64 {
    const STEP: f64 = 0.5;
    const NODES: usize = 12;
    static WEIGHTS: std::sync::LazyLock<[f64; NODES]> =
        std::sync::LazyLock::new(|| std::array::from_fn(|k| (-(STEP * (k + 1) as f64).powi(2)).exp()));
    let square = y * y;
    let sum: f64 = WEIGHTS.iter().enumerate().map(|(k, w)| w / (square + (STEP * (k + 1) as f64).powi(2))).sum();
    let trapezoid = STEP * y / std::f64::consts::PI * (1.0 / square + 2.0 * sum);
    // The pole at t = iy lies within the strip of the rule while y < π/STEP.
    let pole = std::f64::consts::PI / STEP;
    if y < pole { trapezoid - 2.0 * square.exp() / (2.0 * pole * y).exp_m1() } else { trapezoid }
}

/// e^{−x²/2}; x² is split so that its rounding error does not grow with x.
#[inline]
fn exp_minus_half_square(x: f64) -> f64 {
    if x.abs() > FARTHEST {
        return 0.0;
    }
    let coarse = (16.0 * x).trunc() / 16.0;
    (-0.5 * coarse * coarse).exp() * (-0.5 * (x - coarse) * (x + coarse)).exp()
}

/// Returns ln φ(x).
pub(super) fn ln_normal(x: f64) -> f64 {
    -0.5 * x * x - 0.5 * std::f64::consts::TAU.ln()
}

/// Returns the standard normal density φ.
#[inline]
pub fn standard_normal_pdf(x: f64) -> f64 {
    exp_minus_half_square(x) / std::f64::consts::TAU.sqrt()
}

/// Returns the standard normal quantile Φ⁻¹: −∞ at 0, +∞ at 1, NaN outside [0, 1].
pub fn standard_normal_quantile(probability: f64) -> f64 {
    match probability {
        p if !(0.0..=1.0).contains(&p) => f64::NAN,
        0.0 => f64::NEG_INFINITY,
        1.0 => f64::INFINITY,
        p => {
            let x = -std::f64::consts::SQRT_2 * erf::erfc_inv(2.0 * p);
            // One Halley step on the smaller tail, which avoids cancellation.
            let residual = if x <= 0.0 { standard_normal_cdf(x) - p } else { (1.0 - p) - standard_normal_cdf(-x) };
            let newton = residual / standard_normal_pdf(x);
            if newton.is_finite() { x - newton / (1.0 + 0.5 * x * newton) } else { x }
        }
    }
}

/// Returns the regularised incomplete Beta function I_x(a, b): the distribution function of Beta(a, b) on [0, 1].
pub(crate) fn beta_cdf(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if x >= 1.0 {
        1.0
    } else {
        beta_cdf_of(a, b, [x, 1.0 - x], [x.ln(), (-x).ln_1p()])
    }
}

/// Returns I_x(a, b), given x and y = 1 − x and their logarithms, of which either may be too small for f64.
fn beta_cdf_of(a: f64, b: f64, [x, y]: [f64; 2], [ln_x, ln_y]: [f64; 2]) -> f64 {
    let scale = (a * ln_x + b * ln_y - ln_beta(a, b)).exp();
    if x < (a + 1.0) / (a + b + 2.0) {
        scale * beta_fraction(a, b, x) / a
    } else {
        1.0 - scale * beta_fraction(b, a, y) / b
    }
}

/// Returns the continued fraction of I_x(a, b), which converges in about √max(a, b) steps if x < (a+1)/(a+b+2). statrs
/// stops after 140 steps.
///
/// # References
/// DLMF 8.17.22, <https://dlmf.nist.gov/8.17>, evaluated by the method of Lentz.
fn beta_fraction(a: f64, b: f64, x: f64) -> f64 {
    let not_zero = |v: f64| if v.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { v };
    let (mut above, mut below) = (1.0, 1.0 / not_zero(1.0 - (a + b) * x / (a + 1.0)));
    let mut value = below;
    for m in 1..100_000 {
        let (m, before) = (f64::from(m), value);
        let a_2m = a + 2.0 * m;
        for d in [m * (b - m) * x / ((a_2m - 1.0) * a_2m), -(a + m) * (a + b + m) * x / (a_2m * (a_2m + 1.0))] {
            below = 1.0 / not_zero(1.0 + d * below);
            above = not_zero(1.0 + d / above);
            value *= above * below;
        }
        // The rounding of both factors may change the value by two units in each step.
        if (value - before).abs() <= 4.0 * f64::EPSILON * value.abs() {
            break;
        }
    }
    value
}

/// Returns 1 − I_x(a, b) without cancellation in the upper tail.
pub(crate) fn beta_survival(a: f64, b: f64, x: f64) -> f64 {
    // Below the split of the continued fraction the upper tail is not small, and 1 − x may round to one.
    if x < (a + 1.0) / (a + b + 2.0) { 1.0 - beta_cdf(a, b, x) } else { beta_cdf(b, a, 1.0 - x) }
}

/// Shape of a Gamma distribution above which the sums of its incomplete function are long. The expansion that replaces them is
/// exact to 3e-11 standard deviations up to the normal score 7, which is the rounding of the sums at this shape.
const LARGE_SHAPE: f64 = 3e4;

/// Returns the regularised incomplete gamma function P(a, x): the distribution function of the Gamma distribution of
/// scale 1.
pub(crate) fn gamma_cdf(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if a > LARGE_SHAPE {
        standard_normal_cdf(large_shape_score(a, x))
    } else {
        gamma::checked_gamma_lr(a, x).unwrap_or(if x == f64::INFINITY { 1.0 } else { f64::NAN })
    }
}

/// Returns 1 − P(a, x) without cancellation in the upper tail.
pub(crate) fn gamma_survival(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        1.0
    } else if a > LARGE_SHAPE {
        standard_normal_cdf(-large_shape_score(a, x))
    } else {
        gamma::checked_gamma_ur(a, x).unwrap_or(if x == f64::INFINITY { 0.0 } else { f64::NAN })
    }
}

/// Returns the quantile at the normal score z of a Gamma distribution of shape a > [`LARGE_SHAPE`], in standard deviations
/// from its mean: the Cornish–Fisher expansion up to a⁻².
///
/// # References
/// H. Goldberg & H. Levine, *Ann. Math. Statist.* **17** (1946) 216, <https://doi.org/10.1214/aoms/1177730982>.
fn large_shape_deviation(a: f64, z: f64) -> f64 {
    let (s, z2) = (a.sqrt(), z * z);
    z + (z2 - 1.0) / (3.0 * s) + z * (z2 - 7.0) / (36.0 * a) - (z2 * (3.0 * z2 + 7.0) - 16.0) / (810.0 * a * s)
        + z * (z2 * (9.0 * z2 + 256.0) - 433.0) / (38_880.0 * a * a)
}

/// Returns the normal score of x, the inverse of [`large_shape_deviation`].
fn large_shape_score(a: f64, x: f64) -> f64 {
    let deviation = (x - a) / a.sqrt();
    // Farther out both tails are 0 or 1.
    if deviation.abs() > 40.0 {
        return deviation;
    }
    // Each pass divides the error by 3√a/2z > 6.
    (0..20).fold(deviation, |z, _| z + deviation - large_shape_deviation(a, z))
}

/// Quantile of a Gamma distribution below which the leading term of its series is exact.
const TINY_QUANTILE: f64 = 1e-290;

/// Returns the x with P(a, x) = `lower`, given both tails `lower` + `upper` = 1; the smaller is used.
///
/// Newton's method on the logarithm of that tail as a function of ln x. The density of ln x is log-concave, hence both
/// tails are, and the iteration converges monotonically from its own side of the root.
pub(crate) fn gamma_quantile(a: f64, lower: f64, upper: f64) -> f64 {
    if !(lower >= 0.0 && upper >= 0.0) {
        return f64::NAN;
    }
    let below = lower <= upper;
    let probability = if below { lower } else { upper };
    if probability == 0.0 {
        return if below { 0.0 } else { f64::INFINITY };
    }
    if a > LARGE_SHAPE {
        let z = standard_normal_quantile(probability);
        return a + a.sqrt() * large_shape_deviation(a, if below { z } else { -z });
    }
    let (log_probability, log_norm, centre) = (probability.ln(), gamma::ln_gamma(a), a.ln());
    // P ≤ xᵃ/Γ(1 + a), so the leading term is to the left of the root, and equal to it if x is tiny.
    let log_lower = if below { log_probability } else { (-upper).ln_1p() };
    let leading = (log_lower + gamma::ln_gamma(1.0 + a)) / a;
    if leading < TINY_QUANTILE.ln() {
        return leading.exp();
    }
    let mut t = if below { leading } else { centre };
    let mut before = centre;
    for _ in 0..200 {
        let x = t.exp();
        let tail = if below { gamma_cdf(a, x) } else { gamma_survival(a, x) };
        if tail.is_nan() || tail <= 0.0 {
            // So far out that the probability underflows.
            t = 0.5 * (t + before);
            continue;
        }
        before = if below { centre } else { t };
        let slope = (a * t - x - log_norm).exp() / tail;
        let step = (tail.ln() - log_probability) / slope;
        t += if below { -step } else { step };
        // The rounding of ln Γ(a) limits the logarithm of the tail.
        if step.abs() <= 4.0 * f64::EPSILON * t.abs().max(1.0).max(4.0 * log_norm.abs() / slope) {
            break;
        }
    }
    t.exp()
}

/// Returns ln B(a, b).
pub(crate) fn ln_beta(a: f64, b: f64) -> f64 {
    gamma::ln_gamma(a) + gamma::ln_gamma(b) - gamma::ln_gamma(a + b)
}

/// Returns the x in [0, 1] with I_x(a, b) = `lower`, given both tails `lower` + `upper` = 1; the smaller is used.
pub(crate) fn beta_quantile(a: f64, b: f64, lower: f64, upper: f64) -> f64 {
    if !(lower >= 0.0 && upper >= 0.0) {
        f64::NAN
    } else if lower <= upper {
        beta_lower_quantile(a, b, lower).0
    } else {
        beta_lower_quantile(b, a, upper).1
    }
}

/// Returns (x, 1 − x) with I_x(a, b) = `probability` ≤ ½.
///
/// Newton's method on ln I against t = ln(x/(1−x)). The density of t is log-concave, hence so is its distribution
/// function (Prékopa), and Newton's method on a concave increasing function overshoots at most once.
fn beta_lower_quantile(a: f64, b: f64, probability: f64) -> (f64, f64) {
    if probability == 0.0 {
        return (0.0, 1.0);
    }
    let (log_probability, log_norm) = (probability.ln(), ln_beta(a, b));
    // The lower tail I ≈ x^a/(a B), if it is to the left of the mean.
    let lower_tail = (log_probability + a.ln() + log_norm) / a;
    let centre = (a / b).ln();
    let mut t = lower_tail.min(centre);
    for _ in 0..200 {
        let (x, y) = logistic_pair(t);
        let [ln_x, ln_y] = [t.min(0.0), (-t).min(0.0)].map(|part| part - (-t.abs()).exp().ln_1p());
        let cdf = beta_cdf_of(a, b, [x, y], [ln_x, ln_y]);
        if cdf.is_nan() || cdf <= 0.0 {
            // For large shapes the leading term is so far to the left of the distribution that its probability
            // underflows.
            t = 0.5 * (t + centre);
            continue;
        }
        let slope = (a * ln_x + b * ln_y - log_norm).exp() / cdf;
        let step = (cdf.ln() - log_probability) / slope;
        t -= step;
        // The rounding of ln Γ limits the logarithm of the tail.
        let rounding = gamma::ln_gamma(a + b).abs() / slope;
        if step.abs() <= 4.0 * f64::EPSILON * t.abs().max(1.0).max(4.0 * rounding) || !step.is_finite() {
            break;
        }
    }
    logistic_pair(t)
}

/// Returns (x, 1 − x) for x = 1/(1 + e^{−t}), both without cancellation.
fn logistic_pair(t: f64) -> (f64, f64) {
    let e = (-t.abs()).exp();
    let (large, small) = (1.0 / (1.0 + e), e / (1.0 + e));
    if t >= 0.0 { (large, small) } else { (small, large) }
}

/// Returns the digamma function ψ = (ln Γ)′ of x > 0.
pub(crate) fn digamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 15.0 {
        below -= 1.0 / x;
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    let series = r
        * (1.0 / 12.0
            - r * (1.0 / 120.0 - r * (1.0 / 252.0 - r * (1.0 / 240.0 - r * (1.0 / 132.0 - r * 691.0 / 32760.0)))));
    below + x.ln() - 0.5 / x - series
}

/// Returns the trigamma function ψ′ of x > 0.
pub(crate) fn trigamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 15.0 {
        below += 1.0 / (x * x);
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    let series = r
        * (1.0 / 6.0 - r * (1.0 / 30.0 - r * (1.0 / 42.0 - r * (1.0 / 30.0 - r * (5.0 / 66.0 - r * 691.0 / 2730.0)))));
    below + (1.0 + 0.5 / x + series) / x
}

/// Returns ln Γ(x) of x > 0.
pub(crate) fn ln_gamma(x: f64) -> f64 {
    gamma::ln_gamma(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values by mpmath at 40 digits.
    #[test]
    fn the_normal_distribution_is_right_to_the_last_digits_in_both_tails() {
        for (x, wanted) in [
            (-37.0, 5.725571222524577e-300),
            (-10.0, 7.619853024160525e-24),
            (-3.0, 0.0013498980316300946),
            (-1.0, 0.15865525393145705),
            (0.5, 0.6914624612740131),
            (2.0, 0.9772498680518208),
            (5.0, 0.9999997133484281),
        ] {
            assert!((standard_normal_cdf(x) / wanted - 1.0).abs() < 2e-15, "Φ({x}) = {}", standard_normal_cdf(x));
        }
        for (p, wanted) in [
            (1e-300, -37.0470962993612),
            (1e-20, -9.262340089798407),
            (1e-8, -5.612001244174789),
            (0.01, -2.326347874040841),
            (0.3, -0.5244005127080408),
            (0.5, 0.0),
            (0.7, 0.5244005127080407),
            (0.975, 1.9599639845400538),
            (0.999999, 4.753424308817088),
        ] {
            let x = standard_normal_quantile(p);
            assert!((x - wanted).abs() < 1e-14 * (1.0 + wanted.abs()), "Φ⁻¹({p}) = {x}, not {wanted}");
        }
        assert_eq!(standard_normal_quantile(0.0), f64::NEG_INFINITY);
        assert_eq!(standard_normal_quantile(1.0), f64::INFINITY);
        assert!(standard_normal_quantile(1.1).is_nan() && standard_normal_quantile(f64::NAN).is_nan());
    }

    #[test]
    fn the_normal_distribution_ends_at_infinity() {
        for far in [50.0, 1e300, f64::INFINITY] {
            assert_eq!((standard_normal_cdf(-far), standard_normal_cdf(far)), (0.0, 1.0));
            assert_eq!((standard_normal_pdf(-far), standard_normal_pdf(far)), (0.0, 0.0));
        }
        assert!(standard_normal_cdf(f64::NAN).is_nan() && standard_normal_pdf(f64::NAN).is_nan());
    }

    /// Values by mpmath at 40 digits.
    #[test]
    fn the_beta_distribution_is_right_from_the_deep_tail_to_large_shapes() {
        for (a, b, x, wanted) in [
            (2.1, 5.0, 0.01, 0.0010116735405033784),
            (2.1, 5.0, 0.3, 0.5547553311450258),
            (2.1, 5.0, 0.95, 0.99999793650618),
            (300.0, 200.0, 0.5, 3.543480264392538e-06),
            (3000.0, 2000.0, 0.61, 0.9258494502887017),
            (0.05, 0.05, 0.5, 0.5),
            (0.3, 40.0, 0.2, 0.9999902764136027),
            (2e5, 3e5, 0.4, 0.5000767765008481),
            (1e6, 3e6, 0.2499, 0.3221379074226737),
            (1e8, 1e8, 0.50005, 0.9213503967342768),
            (1e8, 1e8, 0.5, 0.5),
        ] {
            // ln Γ of large shapes has an absolute error of their size times the machine precision.
            let tolerance = 1e-13 + 1e-14 * f64::max(a, b);
            let found = beta_cdf(a, b, x);
            assert!((found / wanted - 1.0).abs() < tolerance, "I_{x}({a}, {b}) = {found}, not {wanted}");
            assert!((beta_survival(a, b, x) + found - 1.0).abs() < tolerance);
        }
    }

    /// Values by mpmath at 40 digits, bisection of the incomplete Beta function.
    #[test]
    fn beta_quantiles_are_right_to_thirteen_digits() {
        for (a, b, p, wanted) in [
            (2.1, 5.0, 1e-12, 5.084750601814636e-07),
            (2.1, 5.0, 1e-3, 0.009944166517404464),
            (2.1, 5.0, 0.25, 0.17110501747973442),
            (2.1, 5.0, 0.5, 0.275777184336568),
            (2.1, 5.0, 0.9, 0.5206594314997722),
            (2.1, 5.0, 0.999999, 0.956799759918932),
            (0.3, 0.4, 1e-12, 4.159739860874254e-40),
            (0.3, 0.4, 1e-3, 4.1597398600756454e-10),
            (0.3, 0.4, 0.25, 0.04018081321011898),
            (0.3, 0.4, 0.5, 0.3431703984215373),
            (0.3, 0.4, 0.9, 0.9812695283421334),
            (0.3, 0.4, 0.999999, 0.999999999999994),
            (50.0, 80.0, 1e-12, 0.13564090050347558),
            (50.0, 80.0, 0.25, 0.3554925964867525),
            (50.0, 80.0, 0.9, 0.4396003214302721),
            (50.0, 80.0, 0.999999, 0.5916468635828188),
            (1.0, 1.0, 1e-12, 1e-12),
            (1.0, 1.0, 0.9, 0.9),
            (0.05, 3.0, 1e-12, 2.3000470006648987e-241),
            (0.05, 3.0, 0.25, 2.0918805609342136e-13),
            (0.05, 3.0, 0.9, 0.029573276515247725),
            (0.05, 3.0, 0.999999, 0.962146081664462),
            (300.0, 2.0, 1e-12, 0.9016801860506938),
            (300.0, 2.0, 0.5, 0.9944303748073786),
            (300.0, 2.0, 0.999999, 0.9999952915830613),
            (0.01, 0.5, 0.7, 1.272983942918635e-15),
            (0.01, 0.5, 0.9, 0.0001045315507351928),
            (0.001, 2.0, 0.6, 5.214022540622436e-223),
            (0.5, 0.001, 0.001, 0.2140856817784885),
            (0.02, 0.02, 0.6, 0.999986176730981),
            (0.5, 1e-9, 0.1, 1.0),
            (1e-12, 5.0, 0.9, 0.0),
        ] {
            let x = beta_quantile(a, b, p, 1.0 - p);
            // The relative condition number of the lower tail is 1/a: x ∝ p^{1/a}.
            assert!(
                (x - wanted).abs() <= 1e-13 * f64::max(1.0, 1.0 / a) * wanted,
                "Beta({a}, {b}) at {p}: {x}, not {wanted}"
            );
        }
        assert_eq!((beta_quantile(2.1, 5.0, 0.0, 1.0), beta_quantile(2.1, 5.0, 1.0, 0.0)), (0.0, 1.0));
    }

    #[test]
    fn quantiles_of_large_shapes_invert_the_distribution_function() {
        for (a, b) in [(12720.5, 175.7), (175.7, 12720.5), (1e5, 20.0), (3000.0, 3000.0), (1e7, 3e7), (1e8, 1e8)] {
            for k in 1..200 {
                let p = f64::from(k) / 200.0;
                let x = beta_quantile(a, b, p, 1.0 - p);
                let back = beta_cdf(a, b, x);
                // ln Γ of large shapes has an absolute error of their size times the machine precision.
                assert!((back - p).abs() < 1e-14 * f64::max(a, b) + 1e-12, "Beta({a}, {b}) at {p}: {x} gives {back}");
            }
        }
    }

    /// Values by `scipy.stats.gamma.ppf` and `isf`, SciPy 1.17.1.
    #[test]
    fn gamma_quantiles_match_scipy() {
        for (a, lower, upper, wanted) in [
            (0.05, 1e-10, 0.9999999999, 5.844632057286856e-201),
            (0.05, 0.001, 0.999, 5.844632057286632e-61),
            (0.05, 0.3, 0.7, 2.0378971887326733e-11),
            (0.05, 0.5, 0.5, 5.573878440746256e-07),
            (0.05, 0.9999999999, 1e-10, 17.298041003617612),
            (0.05, 0.999, 0.001, 2.7364585987286776),
            (0.05, 0.7, 0.3, 0.0004665636848952585),
            (0.4, 1e-10, 0.9999999999, 7.415354682563974e-26),
            (0.4, 0.001, 0.999, 2.3449410847664747e-08),
            (0.4, 0.3, 0.7, 0.037541886437423046),
            (0.4, 0.5, 0.5, 0.14507814164343544),
            (0.4, 0.9999999999, 1e-10, 20.392330438271944),
            (0.4, 0.999, 0.001, 5.042608588459962),
            (0.4, 0.7, 0.3, 0.39725716170037817),
            (1.0, 1e-10, 0.9999999999, 1.0000000000499969e-10),
            (1.0, 0.001, 0.999, 0.001000500333583534),
            (1.0, 0.3, 0.7, 0.3566749439387324),
            (1.0, 0.5, 0.5, 0.6931471805599455),
            (1.0, 0.9999999999, 1e-10, 23.025850929940457),
            (1.0, 0.999, 0.001, 6.907755278982137),
            (1.0, 0.7, 0.3, 1.2039728043259357),
            (2.5, 1e-10, 0.9999999999, 0.00016167785731248483),
            (2.5, 0.001, 0.999, 0.1051063013146096),
            (2.5, 0.3, 0.7, 1.4999540663799533),
            (2.5, 0.5, 0.5, 2.175730095547763),
            (2.5, 0.9999999999, 1e-10, 27.78119925911925),
            (2.5, 0.999, 0.001, 10.257502826216438),
            (2.5, 0.7, 0.3, 3.0322149920774524),
            (40.0, 1e-10, 0.9999999999, 11.81450665184226),
            (40.0, 0.001, 0.999, 23.259937964583763),
            (40.0, 0.3, 0.7, 36.45767115693809),
            (40.0, 0.5, 0.5, 39.6671650106891),
            (40.0, 0.9999999999, 1e-10, 94.17962860576232),
            (40.0, 0.999, 0.001, 62.41961200788239),
            (40.0, 0.7, 0.3, 43.05985495117296),
            (3000.0, 1e-10, 0.9999999999, 2664.6204371718313),
            (3000.0, 0.001, 0.999, 2833.5867204784313),
            (3000.0, 0.3, 0.7, 2971.037527212131),
            (3000.0, 0.5, 0.5, 2999.66667325183),
            (3000.0, 0.9999999999, 1e-10, 3361.68640530049),
            (3000.0, 0.999, 0.001, 3172.112702952916),
            (3000.0, 0.7, 0.3, 3028.4791481186576),
        ] {
            let x = gamma_quantile(a, lower, upper);
            // The relative condition number of the lower tail is 1/a: x ∝ p^{1/a}.
            assert!(
                (x / wanted - 1.0).abs() < 1e-12 * f64::max(1.0, 1.0 / a),
                "Gamma({a}) at {lower}: {x}, not {wanted}"
            );
        }
        assert_eq!((gamma_quantile(2.0, 0.0, 1.0), gamma_quantile(2.0, 1.0, 0.0)), (0.0, f64::INFINITY));
    }

    /// Values by Newton's method on an integral of the density, with mpmath at 40 digits.
    #[test]
    fn gamma_quantiles_of_large_shapes_match_their_integrals() {
        const SEVEN: f64 = 1.279812543885835e-12;
        for (a, lower, upper, wanted) in [
            (4e4, SEVEN, 1.0 - SEVEN, 38615.95893350285),
            (4e4, 1.0 - SEVEN, SEVEN, 41416.04060168714),
            (1.2e5, SEVEN, 1.0 - SEVEN, 117591.1052166527),
            (1.2e5, 0.00134989803163009, 1.0 - 0.00134989803163009, 118963.4356980117),
            (1.2e5, 1.0 - 0.0227501319481792, 0.0227501319481792, 120693.819841286),
            (1.2e5, 1.0 - SEVEN, SEVEN, 122440.8946284096),
            (4e6, SEVEN, 1.0 - SEVEN, 3986015.995914342),
            (4e6, 0.00134989803163009, 1.0 - 0.00134989803163009, 3994002.6665832438),
            (4e6, 1.0 - 0.0227501319481792, 0.0227501319481792, 4004000.999916648),
            (4e6, 1.0 - SEVEN, SEVEN, 4014016.00408101),
            (1e10, SEVEN, 1.0 - SEVEN, 9999300015.999918),
            (1e10, 1.0 - SEVEN, SEVEN, 10000700016.000082),
        ] {
            // The first term that is left out has the factor a^{−5/2}.
            let (x, error) = (gamma_quantile(a, lower, upper), 3e-11 * (LARGE_SHAPE / a).powf(2.5));
            assert!(
                (x - wanted).abs() < error * a.sqrt() + f64::EPSILON * a,
                "Gamma({a}) at {lower}: {x}, not {wanted}"
            );
            let back = if lower < upper { gamma_cdf(a, x) / lower } else { gamma_survival(a, x) / upper };
            // A rounding of x changes the logarithm of the tail by up to eight times that in standard deviations.
            assert!((back - 1.0).abs() < 8.0 * f64::EPSILON * a.sqrt() + 1e-13, "Gamma({a}) at {lower}: {back}");
        }
        // Small shapes, whose median underflows or almost does.
        for (a, upper, wanted) in [
            (1e-2, 0.5, 4.465_535_018_910_355e-31),
            (1e-2, 0.2, 1.153_112_725_949_056_2e-10),
            (1e-3, 0.5, 5.244_206_408_277_978e-302),
            (1e-3, 0.01, 2.425_942_838_557_864_9e-5),
            (1e-3, 1e-4, 1.501_028_147_278_368_3),
            (1e-3, 1e-9, 11.313_671_592_614_147),
            (1e-4, 0.5, 0.0),
            (1e-4, 0.02, 1.023_554_717_729_151_5e-88),
            (1e-4, 1e-3, 2.536_573_285_467_606_5e-5),
            (1e-4, 1e-6, 3.210_668_135_083_041),
            (1e-9, 0.02, 0.0),
            (1e-300, 1e-16, 0.0),
        ] {
            let x = gamma_quantile(a, 1.0 - upper, upper);
            // The error of ln Γ(1 + a), a few roundings of 1, changes ln x by 1/a of it.
            assert!(
                (x - wanted).abs() <= 16.0 * f64::EPSILON / a * wanted,
                "Gamma({a}) above {upper}: {x}, not {wanted}"
            );
        }
        // The expansion joins the sums, in which four roundings of 3e5 change a tail by the fraction 1e-10, and x by 3e-8.
        for z in [-6.0, -1.0, 0.0, 3.0, 8.0] {
            let tails = [standard_normal_cdf(z), standard_normal_cdf(-z)];
            let joined = [LARGE_SHAPE, LARGE_SHAPE.next_up()].map(|a| gamma_quantile(a, tails[0], tails[1]));
            assert!((joined[1] - joined[0]).abs() < 3e-8, "{z}: {joined:?}");
        }
        let huge = gamma_quantile(8e66, 0.3, 0.7);
        assert!((huge / 8e66 - 1.0).abs() < 1e-15 && (gamma_cdf(8e66, 0.0), gamma_survival(8e66, 1e70)) == (0.0, 0.0));
    }

    /// Values by mpmath at 40 digits.
    #[test]
    fn digamma_and_trigamma_match_their_tables() {
        for (x, psi, psi1) in [
            (0.01, -100.56088545786866, 10001.621213528313),
            (0.7, -1.2200235536979347, 2.834049156694611),
            (1.0, -0.5772156649015329, 1.6449340668482264),
            (2.1, 0.48533596867983236, 0.6068528698010233),
            (7.1, 1.8880223866580461, 0.15122758043907264),
            (30.0, 3.384438132685525, 0.033895060357739946),
        ] {
            assert!((digamma(x) - psi).abs() < 1e-14 * (1.0 + psi.abs()), "ψ({x}) = {}", digamma(x));
            assert!((trigamma(x) / psi1 - 1.0).abs() < 1e-14, "ψ′({x}) = {}", trigamma(x));
        }
    }
}
