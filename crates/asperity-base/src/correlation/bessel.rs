//! The modified Bessel function of the second kind, of real order.

use statrs::function::gamma::ln_gamma;

/// Step of the trapezoidal rule. Its error falls like |Γ(ν + 2πi/h)| ~ e^{−π²/h}, below 1e−17 here.
const STEP: f64 = 0.2;
/// Terms this far below the largest in the exponent are dropped.
const CUT: f64 = 40.0;

/// Returns ln ∫₀^∞ e^{−x cosh t} cosh(νt) dt = ln K_ν(x) for x > 0, ν ≥ 0.
///
/// The integrand is even and analytic and decays doubly exponentially, so the trapezoidal rule converges geometrically;
/// its step shrinks where the integrand becomes a narrow Gaussian (large x or ν).
///
/// # References
/// NIST Digital Library of Mathematical Functions, 10.32.9, <https://dlmf.nist.gov/10.32.E9>.
fn ln_bessel_k(nu: f64, x: f64) -> f64 {
    let step = STEP.min(0.6 / nu.hypot(x).sqrt());
    let exponent = |t: f64| nu * t - x * t.cosh();
    let top = exponent((nu / x).asinh());
    // cosh(νt) = e^{νt}(1 + e^{−2νt})/2; the term at t = 0 has weight one half.
    let mut sum = 0.5 * (exponent(0.0) - top).exp();
    let mut t = step;
    loop {
        let below_top = exponent(t) - top;
        if below_top < -CUT && t > (nu / x).asinh() {
            break;
        }
        sum += 0.5 * below_top.exp() * (1.0 + (-2.0 * nu * t).exp());
        t += step;
    }
    top + (sum * step).ln()
}

/// Returns 2^{1−ν}/Γ(ν) x^ν K_ν(x), which is 1 at x = 0: the Matérn correlation at the scaled distance x.
pub(super) fn matern(nu: f64, x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    // Below, asinh(ν/x) could overflow; the value no longer changes.
    let x = x.max(1e-300);
    let ln = (1.0 - nu) * std::f64::consts::LN_2 - ln_gamma(nu) + nu * x.ln() + ln_bessel_k(nu, x);
    ln.exp().min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn bessel_k(nu: f64, x: f64) -> f64 {
        ln_bessel_k(nu.abs(), x).exp()
    }

    #[test]
    fn half_integer_orders_are_elementary() {
        for x in [1e-3, 0.01, 0.3, 1.0, 2.7, 10.0, 60.0, 300.0] {
            let half = (PI / (2.0 * x)).sqrt() * (-x).exp();
            for (nu, exact) in [
                (0.5, half),
                (-0.5, half),
                (1.5, half * (1.0 + 1.0 / x)),
                (2.5, half * (1.0 + 3.0 / x + 3.0 / (x * x))),
                (3.5, half * (1.0 + 6.0 / x + 15.0 / (x * x) + 15.0 / (x * x * x))),
            ] {
                let error = (bessel_k(nu, x) / exact - 1.0).abs();
                assert!(error < 2e-13, "K_{nu}({x}): {error:e}");
            }
        }
    }

    #[test]
    fn integer_orders_match_abramowitz_and_stegun() {
        // Tables 9.8 and 9.11.
        for (nu, x, value) in [
            (0.0, 1.0, 0.421_024_438_240_708_3),
            (1.0, 1.0, 0.601_907_230_197_234_6),
            (0.0, 0.1, 2.427_069_024_702_017),
            (1.0, 0.1, 9.853_844_780_870_606),
            (0.0, 5.0, 0.003_691_098_334_042_594),
        ] {
            let error = (bessel_k(nu, x) / value - 1.0).abs();
            assert!(error < 1e-13, "K_{nu}({x}): {error:e}");
        }
    }

    #[test]
    fn neighbouring_orders_obey_the_recurrence() {
        for nu in [0.3, 0.8, 1.2, 4.7, 20.0] {
            for x in [0.02, 0.7, 3.0, 25.0] {
                let right = bessel_k(nu - 1.0, x) + 2.0 * nu / x * bessel_k(nu, x);
                let error = (bessel_k(nu + 1.0, x) / right - 1.0).abs();
                assert!(error < 1e-12, "order {nu} at {x}: {error:e}");
            }
        }
    }
}
