//! Exact moments of the distributions.

use super::special::{ln_gamma, standard_normal_cdf, standard_normal_pdf};

/// Shape of a Weibull distribution above which differences of its raw moments lose more than six digits of the kurtosis.
const LARGE_WEIBULL_SHAPE: f64 = 100.0;

/// Mean, standard deviation, skewness and excess kurtosis of a distribution.
pub(super) struct Exact {
    pub(super) mean: f64,
    pub(super) std: f64,
    pub(super) skewness: f64,
    pub(super) excess_kurtosis: f64,
}

pub(super) fn lognormal(mu: f64, sigma: f64, shift: f64) -> Exact {
    let d = (sigma * sigma).exp_m1();
    let unshifted = (mu + 0.5 * sigma * sigma).exp();
    Exact {
        mean: shift + unshifted,
        std: unshifted * d.sqrt(),
        skewness: (d + 3.0) * d.sqrt(),
        // w⁴ + 2w³ + 3w² − 6 at w = 1 + d.
        excess_kurtosis: d * (16.0 + d * (15.0 + d * (6.0 + d))),
    }
}

pub(super) fn weibull(shape: f64, scale: f64, shift: f64) -> Exact {
    if shape > LARGE_WEIBULL_SHAPE {
        return narrow_weibull(shape, scale, shift);
    }
    // Relative raw moments E tᵏ/(E t)ᵏ − 1, which minimise the cancellation in the central moments of large shapes.
    let log_mean = ln_gamma(1.0 + 1.0 / shape);
    let relative = |k: f64| (ln_gamma(1.0 + k / shape) - k * log_mean).exp_m1();
    let (second, third, fourth) = (relative(2.0), relative(3.0), relative(4.0));
    let mean = scale * log_mean.exp();
    Exact {
        mean: shift + mean,
        std: mean * second.sqrt(),
        skewness: (third - 3.0 * second) / second.powf(1.5),
        excess_kurtosis: (fourth - 4.0 * third + 6.0 * second) / (second * second) - 3.0,
    }
}

/// Returns the moments of a Weibull distribution of large shape. Those of z with x = shift + scale (1 + z/shape) are integrals over the
/// normal variable of x, by the trapezoidal rule; nothing cancels.
fn narrow_weibull(shape: f64, scale: f64, shift: f64) -> Exact {
    const STEPS_PER_UNIT: i32 = 32;
    const REACH: i32 = 12 * STEPS_PER_UNIT;
    let nodes: Vec<(f64, f64)> = (-REACH..=REACH)
        .map(|node| f64::from(node) / f64::from(STEPS_PER_UNIT))
        .map(|g| {
            let tail = standard_normal_cdf(-g.abs());
            let exponential = if g > 0.0 { -tail.ln() } else { -(-tail).ln_1p() };
            ((exponential.ln() / shape).exp_m1() * shape, standard_normal_pdf(g) / f64::from(STEPS_PER_UNIT))
        })
        .collect();
    let mean = nodes.iter().map(|(z, weight)| z * weight).sum::<f64>();
    let central = |power| nodes.iter().map(|(z, weight)| weight * (z - mean).powi(power)).sum::<f64>();
    let variance = central(2);
    Exact {
        mean: shift + scale * (1.0 + mean / shape),
        std: scale * variance.sqrt() / shape,
        skewness: central(3) / variance.powf(1.5),
        excess_kurtosis: central(4) / (variance * variance) - 3.0,
    }
}

pub(super) fn beta(a: f64, b: f64, low: f64, high: f64) -> Exact {
    let sum = a + b;
    let variance = a * b / (sum * sum * (sum + 1.0));
    Exact {
        mean: low + (high - low) * a / sum,
        std: (high - low) * variance.sqrt(),
        skewness: 2.0 * (b - a) * (sum + 1.0).sqrt() / ((sum + 2.0) * (a * b).sqrt()),
        excess_kurtosis: 6.0 * ((a - b) * (a - b) * (sum + 1.0) - a * b * (sum + 2.0))
            / (a * b * (sum + 2.0) * (sum + 3.0)),
    }
}

pub(super) fn triangular(low: f64, mode: f64, high: f64) -> Exact {
    let (rise, fall) = (mode - low, high - mode);
    let square = rise * rise + rise * fall + fall * fall;
    let asymmetry = (fall - rise) * (2.0 * rise + fall) * (rise + 2.0 * fall);
    Exact {
        mean: low + (2.0 * rise + fall) / 3.0,
        std: (square / 18.0).sqrt(),
        skewness: std::f64::consts::SQRT_2 * asymmetry / (5.0 * square.powf(1.5)),
        excess_kurtosis: -0.6,
    }
}

/// The interpolated distribution is uniform with mass 1/n between neighbours, with a point mass of 1/(2n) at either
/// end.
pub(super) fn empirical(sorted: &[f64]) -> Exact {
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else {
        return Exact { mean: f64::NAN, std: f64::NAN, skewness: f64::NAN, excess_kurtosis: f64::NAN };
    };
    let n = sorted.len() as f64;
    let mean = sorted.iter().map(|x| x - first).sum::<f64>() / n + first;
    // For a uniform distribution on [u, v]: E xᵏ = (uᵏ + uᵏ⁻¹v + … + vᵏ)/(k + 1).
    let central = |power: usize| {
        let ends = 0.5 * ((first - mean).powi(power as i32) + (last - mean).powi(power as i32));
        let pieces: f64 = sorted
            .windows(2)
            .map(|pair| {
                let (u, v) = (pair[0] - mean, pair[1] - mean);
                (0..=power).map(|j| u.powi((power - j) as i32) * v.powi(j as i32)).sum::<f64>() / (power as f64 + 1.0)
            })
            .sum();
        (ends + pieces) / n
    };
    let variance = central(2);
    Exact {
        mean,
        std: variance.sqrt(),
        skewness: central(3) / variance.powf(1.5),
        excess_kurtosis: central(4) / (variance * variance) - 3.0,
    }
}

#[cfg(test)]
mod tests {
    use crate::distribution::Marginal;
    use crate::distribution::marginal::tests::examples;

    #[test]
    fn moments_are_the_integrals_of_the_translated_normal_distribution() {
        // Independent of the formulas: trapezoidal rule over g for F⁻¹(Φ(g))ᵏ φ(g), with spectral accuracy.
        let smooth = |marginal: &Marginal| !matches!(marginal.name(), "empirical" | "triangular");
        for marginal in examples().into_iter().filter(smooth) {
            let step = 1.0 / 64.0;
            let nodes: Vec<(f64, f64)> = (-768..=768)
                .map(|i| f64::from(i) * step)
                .map(|g| (marginal.translate(g), step * super::super::standard_normal_pdf(g)))
                .collect();
            let mean: f64 = nodes.iter().map(|(x, w)| x * w).sum();
            let central = |power: i32| nodes.iter().map(|(x, w)| (x - mean).powi(power) * w).sum::<f64>();
            let std = central(2).sqrt();
            assert!((marginal.mean() - mean).abs() < 1e-11, "{marginal:?}: mean {} {mean}", marginal.mean());
            assert!((marginal.std() / std - 1.0).abs() < 1e-11, "{marginal:?}: std {} {std}", marginal.std());
            let (skewness, kurtosis) = (central(3) / std.powi(3), central(4) / std.powi(4) - 3.0);
            assert!((marginal.skewness() - skewness).abs() < 1e-9, "{marginal:?}: {} {skewness}", marginal.skewness());
            assert!(
                (marginal.excess_kurtosis() - kurtosis).abs() < 1e-8,
                "{marginal:?}: {} {kurtosis}",
                marginal.excess_kurtosis()
            );
        }
    }

    /// Values by mpmath at 50 digits.
    #[test]
    fn moments_of_narrow_weibull_distributions_lose_no_digits() {
        for (shape, mean, std, skewness, kurtosis) in [
            (1e3, 0.999_423_772_484_595_5, 1.280_875_747_871_350_4e-3, -1.133_592_730_660_14, 2.371_234_264_109_68),
            (1e5, 0.999_994_227_942_255_7, 1.282_533_055_031_233_2e-5, -1.139_487_434_508_46, 2.399_710_838_377_53),
            (1e8, 0.999_999_994_227_843_5, 1.282_549_813_386_386_7e-8, -1.139_547_039_738_53, 2.399_999_710_823_13),
        ] {
            let found = super::weibull(shape, 1.0, 0.0);
            assert!((found.mean - mean).abs() < 1e-15, "{shape}: {}", found.mean);
            assert!((found.std / std - 1.0).abs() < 1e-12, "{shape}: {}", found.std);
            assert!((found.skewness - skewness).abs() < 1e-11, "{shape}: {}", found.skewness);
            assert!((found.excess_kurtosis - kurtosis).abs() < 1e-10, "{shape}: {}", found.excess_kurtosis);
        }
        // Where both ways meet, a rounding of ln Γ changes the second to fourth moment by the fractions 1e-11, 1e-9 and 1e-7.
        let [below, above] = [100.0, 100.0_f64.next_up()].map(|shape| super::weibull(shape, 1.0, 0.0));
        assert!((below.std / above.std - 1.0).abs() < 1e-11 && (below.skewness - above.skewness).abs() < 1e-8);
        assert!((below.excess_kurtosis - above.excess_kurtosis).abs() < 1e-6);
    }

    #[test]
    fn the_friction_distribution_of_the_paper_leans_right_and_has_negative_excess_kurtosis() {
        let marginal = Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap();
        assert!((marginal.mean() - 0.295_775).abs() < 5e-7);
        assert!((marginal.std().powi(2) - 0.025_715).abs() < 5e-7);
        assert!((marginal.skewness() - 0.559_8).abs() < 5e-5);
        assert!((marginal.excess_kurtosis() + 0.170_5).abs() < 5e-5);
    }

    #[test]
    fn empirical_moments_are_those_of_the_interpolated_distribution() {
        let marginal = Marginal::empirical(vec![3.0, 1.0, 1.5, 2.0, 4.0]).unwrap();
        let n = 200_000;
        let draws: Vec<f64> = (0..n).map(|i| marginal.quantile((f64::from(i) + 0.5) / f64::from(n))).collect();
        let moments = crate::stats::Moments::new(&draws);
        assert!((marginal.mean() - moments.mean).abs() < 1e-9);
        assert!((marginal.std() - moments.std).abs() < 1e-9);
        assert!((marginal.skewness() - moments.skewness).abs() < 1e-8);
        assert!((marginal.excess_kurtosis() - moments.excess_kurtosis).abs() < 1e-8);
    }

    #[test]
    fn a_nearly_normal_lognormal_distribution_has_an_accurate_skewness() {
        let marginal = Marginal::lognormal(0.0, 1e-6, 0.0).unwrap();
        assert!((marginal.skewness() / 3e-6 - 1.0).abs() < 1e-9);
        assert!((marginal.excess_kurtosis() / 16e-12 - 1.0).abs() < 1e-9);
    }
}
