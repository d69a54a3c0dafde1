//! Root finding in an interval.

use std::convert::Infallible;

/// Largest number of iterations; bisection alone needs about 60.
const LARGEST_COUNT: usize = 200;

/// Returns the root of a continuous function between `a` and `b`, each given with the value of the function, to machine
/// precision; `None` if the signs are equal or a value is NaN.
pub fn root_between(f: impl Fn(f64) -> f64, a: [f64; 2], b: [f64; 2]) -> Option<f64> {
    let Ok(root) = try_root_between(|x| Ok::<_, Infallible>(f(x)), a, b, 0.0);
    root
}

/// Returns as [`root_between`], for a fallible function, to `tolerance` in the argument. For a function that jumps
/// through zero it is the position of the jump.
///
/// Inverse quadratic interpolation where three points make it safe, otherwise bisection.
///
/// # References
/// Chandrupatla, *Adv. Eng. Softw.* **28** (1997) 145, <https://doi.org/10.1016/S0965-9978(96)00051-8>.
///
/// # Errors
/// The first error of the function.
pub fn try_root_between<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    [a, fa]: [f64; 2],
    [b, fb]: [f64; 2],
    tolerance: f64,
) -> Result<Option<f64>, E> {
    if fa == 0.0 || fb == 0.0 {
        return Ok(Some(if fa == 0.0 { a } else { b }));
    }
    if fa.is_nan() || fb.is_nan() || (fa > 0.0) == (fb > 0.0) {
        return Ok(None);
    }
    // The newest point, one of the opposite sign, and the one replaced by the newest.
    let (mut new, mut other) = ((b, fb), (a, fa));
    let mut fraction = 0.5;
    for _ in 0..LARGEST_COUNT {
        let x = new.0 + fraction * (other.0 - new.0);
        let next = (x, f(x)?);
        if next.1.is_nan() {
            return Ok(None);
        }
        let before = if (next.1 > 0.0) == (new.1 > 0.0) {
            new
        } else {
            let before = other;
            other = new;
            before
        };
        new = next;
        let best = if new.1.abs() < other.1.abs() { new } else { other };
        let width = (other.0 - new.0).abs();
        let resolved = tolerance.max(2.0 * f64::EPSILON * best.0.abs() + f64::MIN_POSITIVE);
        if best.1 == 0.0 || width <= resolved {
            return Ok(Some(best.0));
        }
        // If a monotone inverse passes through the three points, the interpolated root is inside the bracket.
        let place = (new.0 - other.0) / (before.0 - other.0);
        let height = (new.1 - other.1) / (before.1 - other.1);
        let safe = height * height < place && (1.0 - height) * (1.0 - height) < 1.0 - place;
        let wanted = if safe {
            new.1 / (other.1 - new.1) * before.1 / (other.1 - before.1)
                + (before.0 - new.0) / (other.0 - new.0) * new.1 / (before.1 - new.1) * other.1 / (before.1 - other.1)
        } else {
            0.5
        };
        let least = 0.5 * resolved / width;
        fraction = wanted.clamp(least, 1.0 - least);
    }
    let best = if new.1.abs() < other.1.abs() { new } else { other };
    Ok(Some(best.0))
}

/// Returns the root of a function with known derivative between `low`, where it is negative, and `high`, where it is
/// positive, in either order.
///
/// Newton's method from `start`; a step that leaves the bracket or does not halve the value is replaced by bisection.
/// For a function that jumps through zero it is the position of the jump.
///
/// # Errors
/// The first error of the function.
pub fn newton_between<E>(
    mut function: impl FnMut(f64) -> Result<(f64, f64), E>,
    mut low: f64,
    mut high: f64,
    start: f64,
) -> Result<f64, E> {
    let mut x = start;
    let mut before = f64::INFINITY;
    for _ in 0..LARGEST_COUNT {
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

/// Bisects between `inside`, where a condition is true, and `outside`, where it is false, until their distance is at
/// most `tolerance` or no number lies between them. Returns both, `inside` first; they may be in either order.
///
/// # Errors
/// The first error of the condition.
pub fn bisect<E>(
    mut inside: f64,
    mut outside: f64,
    tolerance: f64,
    mut holds: impl FnMut(f64) -> Result<bool, E>,
) -> Result<[f64; 2], E> {
    while (outside - inside).abs() > tolerance {
        let middle = 0.5 * (inside + outside);
        if middle == inside || middle == outside {
            break;
        }
        if holds(middle)? { inside = middle } else { outside = middle }
    }
    Ok([inside, outside])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_steep_flat_and_scaled_functions_are_found_to_the_last_digits() {
        let between = |f: &dyn Fn(f64) -> f64, a: f64, b: f64| root_between(f, [a, f(a)], [b, f(b)]).unwrap();
        assert!((between(&|x| x * x - 2.0, 0.0, 2.0) - 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((between(&|x| x.exp() - 1e-9, -40.0, 0.0) - 1e-9_f64.ln()).abs() < 1e-13);
        assert!((between(&|x: f64| (x - 0.3).powi(3), -1.0, 5.0) - 0.3).abs() < 1e-5);
        assert!((between(&|x: f64| (1e3 * (x - 0.7)).tanh(), -10.0, 10.0) - 0.7).abs() < 1e-15);
        assert!((between(&|x| 1.0 - x * 1e20, 0.0, 1.0) - 1e-20).abs() < 1e-34);
        assert_eq!(between(&|x| x, 0.0, 1.0), 0.0);
    }

    #[test]
    fn equal_signs_and_undefined_values_have_no_root() {
        assert_eq!(root_between(|x| x, [1.0, 1.0], [2.0, 2.0]), None);
        assert_eq!(root_between(|x| x, [1.0, f64::NAN], [2.0, 2.0]), None);
        assert_eq!(root_between(|_| f64::NAN, [-1.0, -1.0], [2.0, 2.0]), None);
    }

    #[test]
    fn smooth_and_broken_functions_have_their_roots_found_in_few_calls() {
        let mut calls = 0;
        let cosine = |x: f64| {
            calls += 1;
            Ok::<_, ()>(x.cos() - x)
        };
        let root = try_root_between(cosine, [2.0, 2.0_f64.cos() - 2.0], [0.0, 1.0], 1e-15).unwrap().unwrap();
        assert!((root - 0.739_085_133_215_160_6).abs() < 1e-15);
        assert!(calls < 20, "{calls} evaluations");
        let jump = |x: f64| Ok::<_, ()>(if x < 0.3 { -1e6 } else { 1e-6 });
        let step = try_root_between(jump, [0.0, -1e6], [1.0, 1e-6], 1e-12).unwrap().unwrap();
        assert!((step - 0.3).abs() < 1e-12);
        assert_eq!(try_root_between(|_| Err("no value"), [0.0, -1.0], [1.0, 1.0], 0.0), Err("no value"));
    }

    #[test]
    fn newton_s_method_stays_inside_its_bracket() {
        // From a good start, from one with a first step outside the bracket, and at a jump.
        for start in [0.7, 1.99] {
            let root = newton_between(|x: f64| Ok::<_, ()>((x.cos() - x, -x.sin() - 1.0)), 2.0, 0.0, start).unwrap();
            assert!((root - 0.739_085_133_215_160_6).abs() < 1e-15);
        }
        let far = newton_between(
            |x: f64| Ok::<_, ()>(((x - 1.0).atan(), 1.0 / (1.0 + (x - 1.0).powi(2)))),
            -90.0,
            30.0,
            25.0,
        );
        assert!((far.unwrap() - 1.0).abs() < 1e-15);
        let step = newton_between(|x| Ok::<_, ()>((if x < 0.3 { -1e6 } else { 1e-6 }, 1.0)), 0.0, 1.0, 0.9).unwrap();
        assert!((step - 0.3).abs() < 1e-15);
    }

    #[test]
    fn bisection_ends_at_its_tolerance_or_between_neighbouring_numbers() {
        let below_third = |x: f64| Ok::<_, ()>(x < 1.0 / 3.0);
        assert_eq!(bisect(0.0, 1.0, 0.25, below_third).unwrap(), [0.25, 0.5]);
        let [inside, outside] = bisect(0.0, 1.0, 0.0, below_third).unwrap();
        assert_eq!((inside, outside), ((1.0_f64 / 3.0).next_down(), 1.0 / 3.0));
        assert_eq!(bisect(1.0, 0.0, 0.5, |x| Ok::<_, ()>(x > 0.7)).unwrap(), [1.0, 0.5]);
    }
}
