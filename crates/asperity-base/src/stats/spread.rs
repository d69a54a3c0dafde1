//! Variance of a statistic estimated from one sample.

use super::student_quantile;

/// Variance of a statistic and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(hidden)]
pub struct Spread {
    /// Variance.
    #[doc(hidden)]
    pub variance: f64,
    /// Effective number of independent blocks: the degrees of freedom of the variance.
    #[doc(hidden)]
    pub blocks: f64,
    /// Skewness, estimated from blocks.
    #[doc(hidden)]
    pub skewness: f64,
}

impl Spread {
    /// Returns the spread of the statistic scaled by a factor.
    #[doc(hidden)]
    pub fn scaled(self, factor: f64) -> Self {
        Self { variance: factor * factor * self.variance, ..self }
    }

    /// Returns the lower and upper quantiles of (estimate − truth)/√variance with probability `tail` beyond each.
    ///
    /// Student's quantiles with the number of blocks as degrees of freedom, transformed by Hall's cubic for the
    /// skewness of the studentised sum.
    ///
    /// # References
    /// Hall, *J. R. Stat. Soc. B* **54** (1992) 221, <https://doi.org/10.1111/j.2517-6161.1992.tb01876.x>.
    #[doc(hidden)]
    pub fn deviates(&self, tail: f64) -> (f64, f64) {
        let student = self.student(tail);
        (self.unbent(-student), self.unbent(student))
    }

    /// Returns the studentised distance from a hypothetical value relative to its limit; beyond ±1 it is rejected.
    #[doc(hidden)]
    pub fn distance(&self, difference: f64, tail: f64) -> f64 {
        let (t, skew) = (difference / self.variance.sqrt(), self.skewness);
        (t + skew * t * t / 3.0 + skew * skew * t.powi(3) / 27.0 + skew / 6.0) / self.student(tail)
    }

    /// Returns the upper quantile of Student's distribution.
    #[doc(hidden)]
    pub fn student(&self, tail: f64) -> f64 {
        student_quantile(1.0 - tail, self.blocks)
    }

    fn unbent(&self, x: f64) -> f64 {
        let skew = self.skewness;
        if skew.abs() < 1e-6 { x } else { 3.0 / skew * ((1.0 + skew * (x - skew / 6.0)).cbrt() - 1.0) }
    }
}
