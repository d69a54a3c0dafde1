//! The root of a function between two arguments.

/// Iterations; bisection alone needs about 60.
const LARGEST_COUNT: usize = 200;

/// The root of a continuous function whose values at `a` and `b`, given as `fa` and `fb`, have different signs, to the
/// last digits of the argument; `None` when the signs are equal or a value is not a number.
///
/// Inverse quadratic interpolation where three points make it safe, bisection elsewhere.
///
/// # References
/// Chandrupatla, *Adv. Eng. Softw.* **28** (1997) 145, <https://doi.org/10.1016/S0965-9978(96)00051-8>.
pub(super) fn root_between(f: impl Fn(f64) -> f64, [a, fa]: [f64; 2], [b, fb]: [f64; 2]) -> Option<f64> {
    if fa == 0.0 || fb == 0.0 {
        return Some(if fa == 0.0 { a } else { b });
    }
    if fa.is_nan() || fb.is_nan() || (fa > 0.0) == (fb > 0.0) {
        return None;
    }
    // The newest point, one of the other sign, and the one that the newest replaced.
    let (mut new, mut other) = ((b, fb), (a, fa));
    let mut share = 0.5;
    for _ in 0..LARGEST_COUNT {
        let x = new.0 + share * (other.0 - new.0);
        let next = (x, f(x));
        if next.1.is_nan() {
            return None;
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
        let resolved = 2.0 * f64::EPSILON * best.0.abs() + f64::MIN_POSITIVE;
        if best.1 == 0.0 || width <= resolved {
            return Some(best.0);
        }
        // Where the three points lie on a curve whose inverse is monotone, the interpolated root is inside the bracket.
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
        share = wanted.clamp(least, 1.0 - least);
    }
    let best = if new.1.abs() < other.1.abs() { new } else { other };
    Some(best.0)
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
}
