//! Zeros of functions that cost an integration.

use super::VibrationError;

/// Iterations; bisection alone needs about 60.
const MAX_ITERATIONS: usize = 200;

/// Zero of a function between `low`, where it is negative, and `high`, where it is positive; their order is free.
///
/// Regula falsi with the Illinois weighting, replaced by a bisection whenever two steps did not halve the bracket. The
/// answer is good to `tolerance` in the argument, or to rounding.
pub(super) fn zero_between(
    mut function: impl FnMut(f64) -> Result<f64, VibrationError>,
    (mut low, mut at_low): (f64, f64),
    (mut high, mut at_high): (f64, f64),
    tolerance: f64,
) -> Result<f64, VibrationError> {
    let mut width = (high - low).abs();
    let mut last_side = 0;
    for iteration in 0..MAX_ITERATIONS {
        let mut x = (low * at_high - high * at_low) / (at_high - at_low);
        if iteration % 3 == 2 {
            if (high - low).abs() > 0.5 * width {
                x = 0.5 * (low + high);
                last_side = 0;
            }
            width = (high - low).abs();
        }
        if !(x > low.min(high) && x < low.max(high)) {
            x = 0.5 * (low + high);
        }
        let y = function(x)?;
        if y == 0.0 {
            return Ok(x);
        }
        if y < 0.0 {
            (low, at_low) = (x, y);
            if last_side == -1 {
                at_high *= 0.5;
            }
            last_side = -1;
        } else {
            (high, at_high) = (x, y);
            if last_side == 1 {
                at_low *= 0.5;
            }
            last_side = 1;
        }
        if (high - low).abs() <= tolerance.max(2.0 * f64::EPSILON * x.abs()) {
            return Ok(0.5 * (low + high));
        }
    }
    Ok(0.5 * (low + high))
}

/// Zero of a function that gives its value and slope, between `low`, where it is negative, and `high`, where it is
/// positive; their order is free.
///
/// Newton's method from `start`; a step that leaves the bracket or does not halve the value is replaced by a bisection. A
/// function that jumps through zero has the place of the jump as its answer.
pub(super) fn newton_between(
    mut function: impl FnMut(f64) -> Result<(f64, f64), VibrationError>,
    mut low: f64,
    mut high: f64,
    start: f64,
) -> Result<f64, VibrationError> {
    let mut x = start;
    let mut before = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        if !(x > low.min(high) && x < low.max(high)) {
            x = 0.5 * (low + high);
        }
        let (y, slope) = function(x)?;
        if y == 0.0 {
            return Ok(x);
        }
        if y < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let rounding = 2.0 * f64::EPSILON * x.abs();
        if (high - low).abs() <= rounding {
            return Ok(x);
        }
        let newton = x - y / slope;
        let useful = y.abs() < 0.5 * before || before == f64::INFINITY;
        before = y.abs();
        if newton.is_finite() && (newton - x).abs() <= rounding {
            return Ok(newton);
        }
        x = if useful { newton } else { 0.5 * (low + high) };
        if !useful {
            before = f64::INFINITY;
        }
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_and_broken_functions_have_their_zeros_found() {
        let mut calls = 0;
        let root = zero_between(
            |x: f64| {
                calls += 1;
                Ok(x.cos() - x)
            },
            (2.0, 2.0_f64.cos() - 2.0),
            (0.0, 1.0),
            1e-15,
        )
        .unwrap();
        assert!((root - 0.739_085_133_215_160_6).abs() < 1e-15);
        assert!(calls < 20, "{calls} evaluations");
        let step = zero_between(|x| Ok(if x < 0.3 { -1e6 } else { 1e-6 }), (0.0, -1e6), (1.0, 1e-6), 1e-12).unwrap();
        assert!((step - 0.3).abs() < 1e-12);
        // Newton's method, from a good start, from one whose first step leaves the bracket, and at a jump.
        for start in [0.7, 1.99] {
            let root = newton_between(|x: f64| Ok((x.cos() - x, -x.sin() - 1.0)), 2.0, 0.0, start).unwrap();
            assert!((root - 0.739_085_133_215_160_6).abs() < 1e-15);
        }
        let far = newton_between(|x: f64| Ok(((x - 1.0).atan(), 1.0 / (1.0 + (x - 1.0).powi(2)))), -90.0, 30.0, 25.0);
        assert!((far.unwrap() - 1.0).abs() < 1e-15);
        let step = newton_between(|x| Ok((if x < 0.3 { -1e6 } else { 1e-6 }, 1.0)), 0.0, 1.0, 0.9).unwrap();
        assert!((step - 0.3).abs() < 1e-15);
    }
}
