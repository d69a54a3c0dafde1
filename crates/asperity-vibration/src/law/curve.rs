//! Nonlinear parts of laws in the variables of slip.

/// Nonlinear part r(W) = (μ_k − μ(VW))/V − bW of a law with the linear part b.
pub(crate) trait CurveShape {
    /// Its Taylor coefficients, N of them.
    type Terms<const N: usize>: Recurrence<N>;

    /// Returns r(W).
    fn value(&self, w: f64) -> f64;

    /// Returns dr/dW.
    fn slope(&self, w: f64) -> f64;

    /// Returns the argument cW of the law continued below W = 0, where a pole lies at −1.
    fn argument(&self, w: f64) -> f64;

    /// Returns the rate c of a law with e^{−cW}; 0 for other laws.
    fn exponent(&self) -> f64 {
        0.0
    }

    /// Starts the Taylor coefficients about W₀.
    fn terms<const N: usize>(&self, w0: f64) -> Self::Terms<N>;
}

/// Taylor coefficients of r(W(t)) from those of W(t), order by order.
pub(crate) trait Recurrence<const N: usize> {
    /// Returns dr/dW at the start.
    fn slope(&self) -> f64;

    /// Returns r_n − slope·w_n, for n = 1, 2, … in turn; w is known up to n.
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64;
}

/// r = 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Straight;

impl CurveShape for Straight {
    type Terms<const N: usize> = NoTerms;

    #[inline(always)]
    fn value(&self, _: f64) -> f64 {
        0.0
    }

    fn slope(&self, _: f64) -> f64 {
        0.0
    }

    fn argument(&self, _: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn terms<const N: usize>(&self, _: f64) -> NoTerms {
        NoTerms
    }
}

/// Coefficients of a law without nonlinear part.
pub(crate) struct NoTerms;

impl<const N: usize> Recurrence<N> for NoTerms {
    #[inline(always)]
    fn slope(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn rest(&mut self, _: &[f64; N], _: usize) -> f64 {
        0.0
    }
}
