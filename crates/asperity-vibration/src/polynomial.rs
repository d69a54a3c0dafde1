//! Values and first zeros of the polynomials of an integration step.
//!
//! Coefficients are in ascending order: p(t) = c\[0\] + c\[1\]·t + …

/// Largest number of coefficients of a polynomial in this module.
pub(super) const CAPACITY: usize = 28;

/// 1/n.
pub(super) const RECIPROCAL: [f64; CAPACITY + 1] = {
    let mut r = [0.0; CAPACITY + 1];
    let mut n = 1;
    while n <= CAPACITY {
        r[n] = 1.0 / n as f64;
        n += 1;
    }
    r
};

/// Relative width below which the bracket of a zero counts as a point.
const RESOLUTION: f64 = 1e-15;

/// Returns p(t) by Horner's rule.
#[inline]
pub(super) fn value(c: &[f64], t: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, coefficient| sum * t + coefficient)
}

/// Returns p(t) as the sum of four polynomials in t⁴, which shortens the chain of dependent operations to a quarter.
/// The number of coefficients must be a multiple of four.
#[inline(always)]
pub(super) fn split_value(c: &[f64], t: f64) -> f64 {
    let square = t * t;
    let fourth = square * square;
    let mut sums = [0.0; 4];
    for four in c.chunks_exact(4).rev() {
        for (sum, coefficient) in sums.iter_mut().zip(four) {
            *sum = *sum * fourth + coefficient;
        }
    }
    (sums[0] + t * sums[1]) + square * (sums[2] + t * sums[3])
}

/// Returns Σ a_k b_{n−k} over 0 < k < n, in two chains. The terms of high and low order, which a recurrence computes
/// last, are added last; the term of b_{n−1} is the very last.
#[inline(always)]
pub(super) fn cross<const N: usize>(a: &[f64; N], b: &[f64; N], n: usize) -> f64 {
    let half = n / 2;
    let mut sums = [0.0, if n == 2 * half && n > 0 { a[half] * b[half] } else { 0.0 }];
    let mut k = n.div_ceil(2);
    while k > 2 {
        k -= 1;
        sums[0] += a[n - k] * b[k];
        sums[1] += a[k] * b[n - k];
    }
    let sum = sums[0] + sums[1];
    if n > 2 { (sum + a[n - 1] * b[1]) + a[1] * b[n - 1] } else { sum }
}

/// Returns p(t) and p′(t).
#[inline]
pub(super) fn value_and_slope(c: &[f64], t: f64) -> (f64, f64) {
    c.iter().rev().fold((0.0, 0.0), |(sum, slope), coefficient| (sum * t + coefficient, slope * t + sum))
}

/// Returns the coefficients of p′.
pub(super) fn derivative(c: &[f64]) -> [f64; CAPACITY] {
    let mut d = [0.0; CAPACITY];
    for k in 1..c.len() {
        d[k - 1] = k as f64 * c[k];
    }
    d
}

/// Returns a lower bound of p on [0, h] from the signs of the coefficients.
#[inline]
pub(super) fn lower_bound(c: &[f64], h: f64) -> f64 {
    let square = h * h;
    let (mut even, mut odd) = (0.0, 0.0);
    for pair in c[1..].rchunks(2) {
        // Pairs of coefficients from the highest power down; the lowest one may be unpaired.
        if let [low, high] = pair {
            even = even * square + low.min(0.0);
            odd = odd * square + high.min(0.0);
        } else {
            return c[0] + h * ((even + h * odd) * h + pair[0].min(0.0));
        }
    }
    c[0] + h * (even + h * odd)
}

/// Returns an upper bound of p on [0, h] from the signs of the coefficients, like [`lower_bound`].
pub(super) fn upper_bound(c: &[f64], h: f64) -> f64 {
    let square = h * h;
    let mut sums = [0.0; 2];
    for pair in c[1..].rchunks(2) {
        if let [low, high] = pair {
            sums = [sums[0] * square + low.max(0.0), sums[1] * square + high.max(0.0)];
        } else {
            return c[0] + h * ((sums[0] + h * sums[1]) * h + pair[0].max(0.0));
        }
    }
    c[0] + h * (sums[0] + h * sums[1])
}

/// Returns an upper bound of p′ on [0, h] from the signs of the coefficients.
fn slope_upper_bound(c: &[f64], h: f64) -> f64 {
    let mut order = c.len() as f64;
    let tail = c[2..].iter().rev().fold(0.0, |sum, &coefficient| {
        order -= 1.0;
        sum * h + (order * coefficient).max(0.0)
    });
    c[1] + h * tail
}

/// Returns the zero of a function with a single sign change in [low, high], by Newton's method inside a bracket.
///
/// `function` returns value and slope; `start` is a guess. The error of the result is of the order of rounding in the
/// argument.
#[inline]
pub(super) fn bracketed_zero(
    function: impl Fn(f64) -> (f64, f64),
    mut low: f64,
    mut high: f64,
    falling: bool,
    start: f64,
) -> f64 {
    let mut t = start;
    // Sixty halvings exhaust the digits; Newton's method rarely needs six steps.
    for _ in 0..100 {
        let (y, dy) = function(t);
        if y == 0.0 {
            return t;
        }
        if (y > 0.0) == falling {
            low = t;
        } else {
            high = t;
        }
        let newton = t - y / dy;
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        // The error of Newton's method after a step is of the order of the square of that step.
        if high - low <= RESOLUTION * high || (next - t).abs() <= RESOLUTION * high {
            return next;
        }
        if inside && (next - t).abs() <= 1e-9 * high {
            let (y, dy) = function(next);
            let last = next - y / dy;
            return if last >= low && last <= high { last } else { next };
        }
        t = next;
    }
    t
}

/// Returns the coefficients of p(a + t).
pub(super) fn shifted(c: &[f64], a: f64) -> [f64; CAPACITY] {
    let mut s = [0.0; CAPACITY];
    s[..c.len()].copy_from_slice(c);
    let rows = if a == 0.0 { 0 } else { c.len() };
    for i in 0..rows {
        for k in (i..c.len() - 1).rev() {
            s[k] += a * s[k + 1];
        }
    }
    s
}

/// Returns the first zero in (0, h] of a polynomial that is positive at 0; none if it stays positive.
///
/// Intervals without a zero are excluded by coefficient bounds. In intervals in which the polynomial falls
/// monotonically, the single zero is located; all others are halved. No zero is missed, even next to another one,
/// unless the distance of the two is below rounding.
pub(super) fn first_zero(c: &[f64], h: f64) -> Option<f64> {
    if lower_bound(c, h) > 0.0 {
        return None;
    }
    let n = c.len();
    let (mut a, mut width) = (0.0, h);
    while a < h {
        let local = shifted(c, a);
        let local = &local[..n];
        width = f64::min(width, h - a);
        loop {
            if local[0] <= 0.0 {
                return Some(a);
            }
            if lower_bound(local, width) > 0.0 {
                break;
            }
            let falls = slope_upper_bound(local, width) < 0.0;
            if falls || width <= RESOLUTION * h {
                if value(local, width) > 0.0 {
                    break;
                }
                let guess = (-local[0] / local[1]).clamp(0.0, width);
                return Some(a + bracketed_zero(|t| value_and_slope(local, t), 0.0, width, true, guess));
            }
            width *= 0.5;
        }
        // The last interval ends exactly at h.
        a = if width >= h - a { h } else { a + width };
        width *= 2.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns Π (r_i − t), positive at 0 for positive roots.
    fn from_roots(roots: &[f64]) -> Vec<f64> {
        let mut c = vec![1.0];
        for r in roots {
            let mut next = vec![0.0; c.len() + 1];
            for (k, v) in c.iter().enumerate() {
                next[k] += r * v;
                next[k + 1] -= v;
            }
            c = next;
        }
        c
    }

    #[test]
    fn the_first_zero_is_found_next_to_close_zeros() {
        for roots in
            [&[0.3, 0.31, 0.9][..], &[0.5, 0.5 + 1e-6], &[0.7], &[1.0, 2.0], &[0.2, 0.2001, 0.2002, 0.8, 0.9, 3.0]]
        {
            let c = from_roots(roots);
            let found = first_zero(&c, 1.0).unwrap();
            // Rounding moves a zero of a polynomial by (rounding of its value)/slope.
            assert!((found - roots[0]).abs() < 1e-14 / value_and_slope(&c, roots[0]).1.abs(), "{roots:?}: {found}");
        }
        assert_eq!(first_zero(&from_roots(&[1.5, 2.0]), 1.0), None);
        // Raised by 1e-9, the polynomial stays above the axis.
        let mut above = from_roots(&[0.5, 0.5]);
        above[0] += 1e-9;
        assert_eq!(first_zero(&above, 1.0), None);
    }

    #[test]
    fn bounds_enclose_the_values() {
        let rng = &mut asperity_base::random::stream(1, "test", 0);
        for len in 3..CAPACITY {
            let c = asperity_base::random::standard_normal(rng, len);
            let h = 0.7;
            for i in 0..=100 {
                let t = h * f64::from(i) / 100.0;
                assert!(lower_bound(&c, h) <= value(&c, t) && value(&c, t) <= upper_bound(&c, h));
                assert!(value_and_slope(&c, t).1 <= slope_upper_bound(&c, h));
            }
            // The bounds are the sums over the negative or positive coefficients.
            let parts = |keep: fn(f64) -> f64| c[0] + (1..len).map(|k| keep(c[k]) * h.powi(k as i32)).sum::<f64>();
            assert!((lower_bound(&c, h) - parts(|x| x.min(0.0))).abs() < 1e-14);
            assert!((upper_bound(&c, h) - parts(|x| x.max(0.0))).abs() < 1e-14);
        }
    }

    #[test]
    fn derivative_shift_and_value_agree_with_the_exponential() {
        let c: Vec<f64> =
            (0..CAPACITY).scan(1.0, |f, k| Some(*f / (1..=k as u64).product::<u64>().max(1) as f64)).take(18).collect();
        assert!((value(&c, 0.5) - 0.5_f64.exp()).abs() < 1e-15);
        assert!((split_value(&c, 0.5) - 0.5_f64.exp()).abs() < 1e-15);
        assert!((value_and_slope(&c, 0.5).1 - 0.5_f64.exp()).abs() < 1e-14);
        assert!((value(&derivative(&c)[..17], 0.5) - 0.5_f64.exp()).abs() < 1e-14);
        assert!((value(&shifted(&c, 0.25)[..18], 0.25) - 0.5_f64.exp()).abs() < 1e-14);
    }
}
