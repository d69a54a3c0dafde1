//! Triangular distribution: the density rises linearly from `low` to `mode` and falls linearly to `high`.

/// Lower end, mode and upper end, in ascending order.
pub(super) type Triangle = [f64; 3];

/// Returns the distribution function.
pub(super) fn cdf(triangle: Triangle, x: f64) -> f64 {
    let [_, mode, _] = triangle;
    if x <= mode { below(triangle, x) } else { 1.0 - above(triangle, x) }
}

/// Returns the survival function.
pub(super) fn survival(triangle: Triangle, x: f64) -> f64 {
    let [_, mode, _] = triangle;
    if x <= mode { 1.0 - below(triangle, x) } else { above(triangle, x) }
}

/// Returns the quantile, given both tails of its probability.
pub(super) fn quantile([low, mode, high]: Triangle, lower: f64, upper: f64) -> f64 {
    let width = high - low;
    if lower * width <= mode - low {
        low + (lower * width * (mode - low)).sqrt()
    } else {
        high - (upper * width * (high - mode)).sqrt()
    }
}

/// Returns the logarithm of the density.
pub(super) fn ln_pdf([low, mode, high]: Triangle, x: f64) -> f64 {
    let relative = if x < mode {
        (x - low) / (mode - low)
    } else if x > mode {
        (high - x) / (high - mode)
    } else {
        1.0
    };
    (2.0 * relative.max(0.0) / (high - low)).ln()
}

/// Returns the distribution function for x ≤ mode.
fn below([low, mode, high]: Triangle, x: f64) -> f64 {
    let rise = x - low;
    if rise <= 0.0 { 0.0 } else { rise / (high - low) * (rise / (mode - low)) }
}

/// Returns the survival function for x > mode.
fn above([low, mode, high]: Triangle, x: f64) -> f64 {
    let fall = high - x;
    if fall <= 0.0 { 0.0 } else { fall / (high - low) * (fall / (high - mode)) }
}

#[cfg(test)]
mod tests {
    use super::super::Marginal;

    #[test]
    fn a_triangle_has_its_elementary_values() {
        // Sides of 1 and 3: a quarter of the mass lies below the mode.
        let marginal = Marginal::triangular(1.0, 2.0, 5.0).unwrap();
        assert_eq!((marginal.cdf(2.0), marginal.survival(2.0)), (0.25, 0.75));
        assert_eq!((marginal.cdf(1.5), marginal.survival(3.5)), (0.0625, 0.1875));
        assert_eq!((marginal.cdf(0.0), marginal.survival(9.0)), (0.0, 0.0));
        for (x, density) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.25), (2.0, 0.5), (3.5, 0.25), (5.0, 0.0), (6.0, 0.0)] {
            assert!((marginal.pdf(x) - density).abs() < 1e-15, "{x}");
        }
        assert!((marginal.quantile(0.5) - (5.0 - 6.0_f64.sqrt())).abs() < 1e-15);
    }

    #[test]
    fn raw_moments_are_the_mean_monomials_of_the_corners() {
        // E xᵏ is the mean of all monomials of degree k in low, mode and high.
        let [a, b, c] = [-1.0_f64, 0.25, 3.0];
        let mean_monomial = |k: i32| {
            let monomials = (0..=k).flat_map(|i| (0..=k - i).map(move |j| a.powi(i) * b.powi(j) * c.powi(k - i - j)));
            monomials.sum::<f64>() / f64::from((k + 1) * (k + 2) / 2)
        };
        let [m1, m2, m3, m4] = [1, 2, 3, 4].map(mean_monomial);
        let variance = m2 - m1 * m1;
        let third = m3 - 3.0 * m1 * m2 + 2.0 * m1.powi(3);
        let fourth = m4 - 4.0 * m1 * m3 + 6.0 * m1 * m1 * m2 - 3.0 * m1.powi(4);
        let marginal = Marginal::triangular(a, b, c).unwrap();
        assert!((marginal.mean() - m1).abs() < 1e-15 && (marginal.std() - variance.sqrt()).abs() < 1e-15);
        assert!((marginal.skewness() - third / variance.powf(1.5)).abs() < 1e-13, "{}", marginal.skewness());
        assert!((marginal.excess_kurtosis() - (fourth / (variance * variance) - 3.0)).abs() < 1e-13);
    }

    #[test]
    fn the_mode_may_be_an_end() {
        // Density 2(1 − x) on [0, 1] and its mirror image.
        let falling = Marginal::triangular(0.0, 0.0, 1.0).unwrap();
        let rising = Marginal::triangular(0.0, 1.0, 1.0).unwrap();
        assert_eq!((falling.cdf(0.0), falling.cdf(0.5)), (0.0, 0.75));
        assert_eq!((rising.cdf(0.5), rising.cdf(1.0)), (0.25, 1.0));
        assert!((falling.pdf(0.0) - 2.0).abs() < 1e-15 && (rising.pdf(1.0) - 2.0).abs() < 1e-15);
        assert_eq!((falling.pdf(-0.1), rising.pdf(1.1)), (0.0, 0.0));
        assert_eq!((falling.quantile(0.75), rising.quantile(0.25)), (0.5, 0.5));
        assert_eq!(falling.skewness(), -rising.skewness());
        for [low, mode, high] in [[0.0, -0.1, 1.0], [0.0, 1.1, 1.0], [1.0, 1.0, 1.0], [0.0, f64::NAN, 1.0]] {
            assert!(Marginal::triangular(low, mode, high).is_err());
        }
    }
}
