//! From the scatter of one window to that of the nominal area.
//!
//! A nominal area holds many windows, and their mean scatters less than one of them. The paper lets a single window carry
//! the whole normal force; at a brake pad's nominal pressure that is a pressure of tens of gigapascal. Both readings are
//! offered, and results state which is which.

use crate::friction::process::window_variance_factor;

/// Variance of μ over the nominal area, divided by that over one window of `window_m` × `strip_width_m`.
///
/// Along the sliding direction the mean over the side L of a square nominal area has the variance function γ(L)/γ(W) of a
/// process of correlation length ℓ without the window (Vanmarcke, *Random Fields*, 1983, §5.1); ℓ = 0 gives W/L. Across it,
/// strips of the window's width count as independent. An area smaller than a window keeps the window's variance.
pub fn variance_reduction(window_m: f64, strip_width_m: f64, length_m: f64, nominal_area_m2: f64) -> f64 {
    let side_m = nominal_area_m2.sqrt();
    let along = if length_m > 1e-9 * window_m {
        window_variance_factor(length_m, side_m) / window_variance_factor(length_m, window_m)
    } else {
        window_m / side_m
    };
    let across = strip_width_m / side_m;
    (along.min(1.0) * across.min(1.0)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncorrelated_windows_average_as_their_number() {
        // 833 mm² hold some 18,500 windows of 75 µm × 600 µm.
        let factor = variance_reduction(600e-6, 75e-6, 0.0, 833e-6);
        assert!((1.0 / factor - 833e-6 / (600e-6 * 75e-6)).abs() < 1e-6);
        assert!((factor.sqrt() - 0.00735).abs() < 1e-5);
        assert!(variance_reduction(600e-6, 75e-6, 250e-6, 833e-6) > factor);
        assert_eq!(variance_reduction(600e-6, 75e-6, 0.0, 1e-12), 1.0);
    }
}
