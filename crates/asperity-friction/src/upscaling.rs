//! Variance of friction over the nominal area, from the variance of one window.
//!
//! A nominal area contains many windows, and their mean varies less than one of them. In the paper a single window
//! carries the whole normal force; at a brake pad's nominal pressure its pressure would be tens of gigapascal. Both
//! interpretations are available, and results state which one they use.

use asperity_base::choice;

choice! {
    /// Relation between the standard deviation of friction over the nominal area and over one window.
    #[derive(Default)]
    pub enum Upscaling: "upscaling" {
        /// Windows average over the nominal area.
        #[default]
        Area = "area",
        /// One window carries the whole normal force (the paper's reading).
        Paper = "paper",
    }
}

/// Nodes in (0, 1) and weights of Gauss–Legendre quadrature of ten points on (−1, 1), by pairs ±x.
const GAUSS_10: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];
/// Octaves below the length of averaging that are integrated one by one, and parts of each.
const OCTAVES: i32 = 40;
const PARTS: i32 = 4;
/// Variance function of a window below which the process counts as uncorrelated.
const UNCORRELATED: f64 = 1e-9;

/// Returns the variance of the mean of a stationary process over the length L, divided by its variance:
/// Γ(L) = (2/L) ∫₀ᴸ (1 − s/L) ρ(s) ds with the autocorrelation ρ over lags in metre.
///
/// Uses Gauss–Legendre quadrature in octaves of s, so that it resolves correlation lengths down to 10⁻¹² of L. Kinks of
/// ρ cause an error of about 10⁻⁵.
///
/// # References
/// E. Vanmarcke, *Random Fields: Analysis and Synthesis*, MIT Press (1983), §5.1.
pub fn variance_function(length_m: f64, correlation: &dyn Fn(f64) -> f64) -> f64 {
    let integrand = |fraction: f64| (1.0 - fraction) * correlation(fraction * length_m);
    let panel = |from: f64, to: f64| {
        let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
        let pair = |(x, weight): &(f64, f64)| weight * (integrand(centre - half * x) + integrand(centre + half * x));
        half * GAUSS_10.iter().map(pair).sum::<f64>()
    };
    let octave = |k: i32| -> f64 {
        let low = 2.0_f64.powi(-k - 1);
        let edge = |part: i32| low * (1.0 + f64::from(part) / f64::from(PARTS));
        (0..PARTS).map(|part| panel(edge(part), edge(part + 1))).sum()
    };
    2.0 * (panel(0.0, 2.0_f64.powi(-OCTAVES)) + (0..OCTAVES).rev().map(octave).sum::<f64>())
}

/// Returns the variance of μ over the nominal area, divided by its variance over a window of `window_m` ×
/// `window_width_m`.
///
/// `correlation` is the correlation of friction along the sliding direction without the window, over lags in metre. The
/// mean over the side L of a square nominal area has Γ(L)/Γ(W) times the variance of a window W
/// ([`variance_function`]); without any correlation the factor is W/L. Windows side by side count as independent. An
/// area smaller than a window has the window's variance.
pub fn variance_reduction(
    window_m: f64,
    window_width_m: f64,
    nominal_area_m2: f64,
    correlation: &dyn Fn(f64) -> f64,
) -> f64 {
    let side_m = nominal_area_m2.sqrt();
    let within_window = variance_function(window_m, correlation);
    let along = if within_window > UNCORRELATED {
        variance_function(side_m, correlation) / within_window
    } else {
        window_m / side_m
    };
    let across = window_width_m / side_m;
    (along.min(1.0) * across.min(1.0)).min(1.0)
}

/// Returns the correlation e^{−s/ℓ}; zero for ℓ = 0.
pub fn exponential(length_m: f64) -> impl Fn(f64) -> f64 {
    move |lag_m| if length_m > 0.0 { (-lag_m / length_m).exp() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::correlation::windowed_exponential;

    #[test]
    fn the_variance_function_is_vanmarckes_closed_form() {
        for ratio in [1e-9, 1e-4, 0.03, 250.0 / 600.0, 1.0, 1e3] {
            let exponential_form = 2.0 * ratio * (1.0 + ratio * (-1.0_f64 / ratio).exp_m1());
            assert!((variance_function(1.0, &exponential(ratio)) / exponential_form - 1.0).abs() < 1e-9, "{ratio}");
        }
        assert!((variance_function(600.0, &exponential(250.0)) - 0.51761).abs() < 5e-6);
        // Squared exponential e^{−(s/ℓ)²}: √π (ℓ/L) erf(L/ℓ) − (ℓ/L)²(1 − e^{−(L/ℓ)²}), with erf(2) = 0.995322265018953.
        let found = variance_function(2.0, &|s: f64| (-s * s).exp());
        let wanted = std::f64::consts::PI.sqrt() * 0.5 * 0.995_322_265_018_953 - 0.25 * (1.0 - (-4.0_f64).exp());
        assert!((found - wanted).abs() < 1e-12);
        // Triangle of W: 1 − L/3W for L ≤ W, and (W/L)(1 − W/3L) beyond its kink.
        let triangle = |s: f64| (1.0 - s / 0.6).max(0.0);
        for length in [0.3, 0.6, 0.7, 1.0, 40.0] {
            let ratio = length / 0.6;
            let wanted = if ratio <= 1.0 { 1.0 - ratio / 3.0 } else { (1.0 - 1.0 / (3.0 * ratio)) / ratio };
            assert!((variance_function(length, &triangle) / wanted - 1.0).abs() < 1e-4, "{length}");
        }
    }

    #[test]
    fn the_variance_of_uncorrelated_windows_falls_with_their_number() {
        // 833 mm² contain some 18,500 windows of 75 µm × 600 µm.
        let factor = variance_reduction(600e-6, 75e-6, 833e-6, &exponential(0.0));
        assert!((1.0 / factor - 833e-6 / (600e-6 * 75e-6)).abs() < 1e-6);
        assert!((factor.sqrt() - 0.00735).abs() < 1e-5);
        assert!(variance_reduction(600e-6, 75e-6, 833e-6, &exponential(250e-6)) > factor);
        assert_eq!(variance_reduction(600e-6, 75e-6, 1e-12, &exponential(0.0)), 1.0);
    }

    #[test]
    fn averaging_in_two_steps_equals_averaging_once() {
        // The window's moving average has the correlation triangle ⊛ e^{−s/ℓ}; its mean over L ≫ W differs only at the
        // ends.
        let (window_m, length_m, side_m) = (600e-6, 250e-6, 29e-3);
        let direct = variance_function(side_m, &|s| windowed_exponential(s, window_m, length_m));
        let by_ratio =
            variance_function(side_m, &exponential(length_m)) / variance_function(window_m, &exponential(length_m));
        assert!((direct / by_ratio - 1.0).abs() < window_m / side_m, "{direct} {by_ratio}");
    }
}
