//! Statistics of a map as estimates for its surface.

use crate::areal::ArealParameters;
use asperity_base::correlation::{Autocorrelation, Axis};
use asperity_base::map::HeightMap;
use asperity_base::stats::Interval;

/// A statistic of a map as an estimate for the surface of which the map is a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Statistic of the map.
    pub value: f64,
    /// Best estimate for the surface: the statistic corrected for the removed form.
    pub surface: f64,
    /// Standard error.
    pub standard_error: f64,
    /// Confidence interval of the statistic of the surface.
    pub interval: Interval,
    /// Number of independent blocks of the map, the degrees of freedom of the standard error.
    pub blocks: f64,
}

/// Returns an estimate if all numbers are finite and in the right order.
pub(super) fn estimate(
    value: f64,
    surface: f64,
    standard_error: f64,
    interval: Interval,
    blocks: f64,
) -> Option<Estimate> {
    let sound = interval.low <= interval.high && interval.high.is_finite() && standard_error > 0.0;
    sound.then_some(Estimate { value, surface, standard_error, interval, blocks })
}

/// Statistics of a map for which estimates are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Values {
    /// Arithmetical mean height Sa in metre.
    pub sa_m: f64,
    /// Root-mean-square height Sq in metre.
    pub sq_m: f64,
    /// Skewness Ssk.
    pub ssk: f64,
    /// Kurtosis Sku.
    pub sku: f64,
    /// Root-mean-square gradient Sdq by forward differences.
    pub sdq: Option<f64>,
    /// Autocorrelation length Sal in metre.
    pub sal_m: Option<f64>,
    /// Core height Sk in metre.
    pub sk_m: f64,
    /// Reduced peak height Spk in metre.
    pub spk_m: f64,
    /// Reduced dale height Svk in metre.
    pub svk_m: f64,
    /// 1/e correlation length along x in metre.
    pub correlation_length_x_m: Option<f64>,
    /// 1/e correlation length along y in metre.
    pub correlation_length_y_m: Option<f64>,
}

impl Values {
    /// Collects the values of a map from its parameters and autocorrelation.
    pub fn new(parameters: &ArealParameters, correlation: &Autocorrelation) -> Self {
        Self {
            sa_m: parameters.sa_m,
            sq_m: parameters.sq_m,
            ssk: parameters.ssk,
            sku: parameters.sku,
            sdq: parameters.sdq,
            sal_m: parameters.sal_m,
            sk_m: parameters.core.sk_m,
            spk_m: parameters.core.spk_m,
            svk_m: parameters.core.svk_m,
            correlation_length_x_m: correlation.correlation_length_m(Axis::X),
            correlation_length_y_m: correlation.correlation_length_m(Axis::Y),
        }
    }

    /// Returns the number of correlation areas l_x l_y that the present heights cover.
    pub(super) fn areas_in(&self, map: &HeightMap) -> Option<f64> {
        let (grid, present) = (map.grid(), map.present_m().count());
        let [x_m, y_m] = self.lengths_m();
        Some(present as f64 * grid.dx_m() * grid.dy_m() / (x_m? * y_m?))
    }

    pub(super) fn lengths_m(&self) -> [Option<f64>; 2] {
        [self.correlation_length_x_m, self.correlation_length_y_m]
    }
}
