//! How a statistic spreads, as far as one sample tells.

use super::student_quantile;

/// The variance of a statistic, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(hidden)]
pub struct Spread {
    /// Variance.
    #[doc(hidden)]
    pub variance: f64,
    /// Independent blocks on which the variance rests: its degrees of freedom.
    #[doc(hidden)]
    pub blocks: f64,
    /// Skewness, from blocks.
    #[doc(hidden)]
    pub skewness: f64,
}

impl Spread {
    /// Returns the spread of the statistic times a factor.
    #[doc(hidden)]
    pub fn scaled(self, factor: f64) -> Self {
        Self { variance: factor * factor * self.variance, ..self }
    }

    /// Returns the values of (estimate − truth)/√variance that leave `tail` on the lower and on the upper side.
    ///
    /// Student's quantiles on as many degrees of freedom as there are blocks, bent by Hall's cubic for the skewness of
    /// the studentised sum.
    ///
    /// # References
    /// Hall, *J. R. Stat. Soc. B* **54** (1992) 221, <https://doi.org/10.1111/j.2517-6161.1992.tb01876.x>.
    #[doc(hidden)]
    pub fn deviates(&self, tail: f64) -> (f64, f64) {
        let student = self.student(tail);
        (self.unbent(-student), self.unbent(student))
    }

    /// Returns the studentised distance from a supposed truth over its limit: beyond ±1 the truth is refused.
    #[doc(hidden)]
    pub fn distance(&self, difference: f64, tail: f64) -> f64 {
        let (t, skew) = (difference / self.variance.sqrt(), self.skewness);
        (t + skew * t * t / 3.0 + skew * skew * t.powi(3) / 27.0 + skew / 6.0) / self.student(tail)
    }

    /// Returns Student's upper quantile.
    #[doc(hidden)]
    pub fn student(&self, tail: f64) -> f64 {
        student_quantile(1.0 - tail, self.blocks)
    }

    fn unbent(&self, x: f64) -> f64 {
        let skew = self.skewness;
        if skew.abs() < 1e-6 { x } else { 3.0 / skew * ((1.0 + skew * (x - skew / 6.0)).cbrt() - 1.0) }
    }
}

/// Returns 1 up to half of `end`, then falling to 0 there: the weight of pairs of values this far apart.
///
/// # References
/// Politis & Romano, *J. Time Ser. Anal.* **16** (1995) 67, <https://doi.org/10.1111/j.1467-9892.1995.tb00223.x>.
#[doc(hidden)]
pub fn flat_top(distance: f64, end: f64) -> f64 {
    (2.0 - 2.0 * distance / end).clamp(0.0, 1.0)
}
