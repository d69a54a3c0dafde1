//! Statistics of one map.

use asperity_base::correlation::{Autocorrelation, Axis, ReliableBand, axis_correlation_length_m};
use asperity_base::map::Grid;

use crate::areal::{self, Analysis, ArealError, ArealParameters};
use crate::fractal::{self, Scaling};
use crate::level::Level;
use crate::model::SurfaceModelError;
use crate::preparation::Prepared;
use crate::uncertainty::{Estimates, Uncertainty, Values, removed_terms};

/// Statistics of one map with their uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct MapStatistics {
    /// Grid of the map.
    pub grid: Grid,
    /// Number of heights rejected as outliers.
    pub outliers: usize,
    /// Radius of a removed cylinder or sphere in metre.
    pub form_radius_m: Option<f64>,
    /// Texture parameters.
    pub parameters: ArealParameters,
    /// Wavenumbers at which the power spectral density is reliable.
    pub reliable: ReliableBand,
    /// Variance on no ring of the radial spectrum in m² ([`RadialSpectrum::corners_m2`](asperity_base::correlation::RadialSpectrum)).
    pub corners_m2: f64,
    /// 1/e correlation lengths along x and y in metre.
    pub correlation_lengths_m: [Option<f64>; 2],
    /// Hurst exponent and fractal dimension.
    pub scaling: Option<Scaling>,
    /// Estimates of the statistics of the surface of which the map is a sample.
    pub estimates: Estimates,
}

impl MapStatistics {
    /// Computes the statistics of a prepared map with their intervals.
    ///
    /// # Errors
    /// The map is flat.
    pub fn new(prepared: &Prepared) -> Result<Self, SurfaceModelError> {
        Ok(Self::analyse(prepared, true)?.0)
    }

    /// Computes the statistics, with their intervals on request, and the intermediate estimates.
    pub(super) fn analyse(
        prepared: &Prepared,
        intervals: bool,
    ) -> Result<(Self, Values, Autocorrelation), SurfaceModelError> {
        let map = &prepared.map;
        let Analysis { parameters, correlation, spectrum } = areal::analyse(map).map_err(|error| match error {
            // The removed form may have been the whole surface.
            ArealError::Flat { present } if prepared.level != Level::None => {
                SurfaceModelError::FormAlone { level: prepared.level, present }
            }
            error => error.into(),
        })?;
        // If the correlation does not fall to 1/e within half the field, larger lags are searched.
        let correlation_length_m = |axis: Axis| match correlation.correlation_length_m(axis) {
            Some(length_m) => Ok(Some(length_m)),
            None => axis_correlation_length_m(map, axis),
        };
        let scaling = fractal::scaling(map, None)?;
        let values = Values::new(&parameters, &correlation);
        let estimates = if intervals { uncertainty(prepared.level).of(map, &values)? } else { Estimates::default() };
        let statistics = Self {
            grid: map.grid(),
            outliers: prepared.outliers,
            form_radius_m: prepared.radius_m,
            parameters,
            reliable: spectrum.reliable,
            corners_m2: spectrum.corners_m2,
            correlation_lengths_m: [correlation_length_m(Axis::X)?, correlation_length_m(Axis::Y)?],
            scaling,
            estimates,
        };
        Ok((statistics, values, correlation))
    }

    /// Returns the smallest and largest lag of the fits of the Hurst exponent over both axes, in metre.
    pub fn hurst_range_m(&self) -> Option<(f64, f64)> {
        let Scaling { x, y, .. } = self.scaling?;
        let ranges = [x, y].into_iter().flatten().map(|axis| axis.range_m);
        ranges.reduce(|(low, high), range| (low.min(range.0), high.max(range.1)))
    }

    /// Returns names and values of the statistics that are meaningful for a part of which the map is one scan; `None` is undefined.
    pub(super) fn poolable(&self) -> Vec<(&'static str, Option<f64>)> {
        let [x_m, y_m] = self.correlation_lengths_m;
        let others = [
            ("correlation_length_x_m", x_m),
            ("correlation_length_y_m", y_m),
            ("hurst", self.scaling.map(|scaling| scaling.hurst)),
            ("fractal_dimension", self.scaling.map(|scaling| scaling.fractal_dimension)),
        ];
        let of_part = self.parameters.named().into_iter().filter(|(name, _)| *name != "Std_rad");
        of_part.map(|(name, value)| (name, value.filter(|value| value.is_finite()))).chain(others).collect()
    }

    /// Returns the area of the present points in m².
    pub fn present_area_m2(&self) -> f64 {
        self.parameters.present as f64 * self.grid.dx_m() * self.grid.dy_m()
    }
}

/// Returns the settings of the intervals of maps without a form.
pub fn uncertainty(removed: Level) -> Uncertainty {
    Uncertainty { removed_terms: removed_terms(removed), ..Uncertainty::default() }
}
