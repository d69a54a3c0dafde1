//! Scans with their statistics: one scan of a part, or several that are pooled.

mod pooled;

pub use pooled::{Part, PooledStatistics};

use std::f64::consts::TAU;

use asperity_base::correlation::{Autocorrelation, Axis, ReliableBand, axis_correlation_length_m};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::stats::Interval;

use crate::areal::{self, Analysis, ArealError, ArealParameters};
use crate::fractal::{self, Scaling};
use crate::level::Level;
use crate::model::{Roughness, SurfaceModelError};
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
    fn analyse(prepared: &Prepared, intervals: bool) -> Result<(Self, Values, Autocorrelation), SurfaceModelError> {
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
    fn poolable(&self) -> Vec<(&'static str, Option<f64>)> {
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

/// Prepared scan with its statistics and, if there are several scans of a part, those of the part.
#[derive(Debug, Clone)]
pub struct ScannedSurface {
    /// Prepared map; the first of several.
    pub map: HeightMap,
    /// Statistics of the map.
    pub statistics: MapStatistics,
    /// Autocorrelation of the map up to half the field.
    pub correlation: Autocorrelation,
    /// Statistics of the map that have intervals.
    pub values: Values,
    /// Form that was removed.
    pub level: Level,
    /// Pooled scans; `None` for a single scan.
    pub part: Option<Part>,
}

impl ScannedSurface {
    /// Computes the statistics of one scan with their intervals.
    ///
    /// # Errors
    /// The map is flat.
    pub fn new(prepared: Prepared) -> Result<Self, SurfaceModelError> {
        Self::analyse(prepared, true)
    }

    /// Computes the statistics of one scan without intervals.
    ///
    /// # Errors
    /// The map is flat.
    pub fn without_intervals(prepared: Prepared) -> Result<Self, SurfaceModelError> {
        Self::analyse(prepared, false)
    }

    /// Pools named scans of one part with equal pitches; returns the first with the pooled scans.
    ///
    /// # Errors
    /// There are fewer than two scans, or their pitches differ.
    pub fn from_scans(scans: Vec<(String, Self)>) -> Result<Self, SurfaceModelError> {
        let part = Part::new(&scans)?;
        let mut scans = scans.into_iter().map(|(_, scan)| scan);
        let first = scans.next().ok_or(crate::pooling::PoolingError::TooFew { scans: 0 })?;
        Ok(Self { part: Some(part), ..first })
    }

    fn analyse(prepared: Prepared, intervals: bool) -> Result<Self, SurfaceModelError> {
        let (statistics, values, mut correlation) = MapStatistics::analyse(&prepared, intervals)?;
        if correlation.reach() != Autocorrelation::half_field(prepared.map.grid()) {
            correlation = Autocorrelation::estimate(&prepared.map)?;
        }
        Ok(Self { map: prepared.map, statistics, correlation, values, level: prepared.level, part: None })
    }

    /// Returns the root-mean-square height of the scan, or of the part, in metre.
    pub fn sq_m(&self) -> f64 {
        let of_part = self.part.as_ref().and_then(|part| part.statistics.value("Sq_m"));
        of_part.unwrap_or(self.statistics.parameters.sq_m)
    }

    /// Returns the fractal dimension of the scan, or of the part.
    pub fn fractal_dimension(&self) -> Option<f64> {
        match &self.part {
            Some(part) => part.statistics.value("fractal_dimension"),
            None => self.statistics.scaling.map(|scaling| scaling.fractal_dimension),
        }
    }

    /// Returns a statistic of the scan, or of the part, with its 95 % interval.
    pub fn estimate(&self, name: &str) -> Option<(f64, Interval)> {
        if let Some(part) = &self.part {
            let found = part.statistics.statistics.iter().find(|(own, _)| *own == name)?.1?;
            return Some((found.value, found.interval));
        }
        let found = self.statistics.estimates.named().into_iter().find(|(own, _)| *own == name)?.1?;
        Some((found.value, found.interval))
    }

    /// Returns the shortest wavelength at which the spectra of all scans are reliable; `None` if no spectrum is reliable.
    pub fn band_end_m(&self) -> Option<f64> {
        let of_part = self.part.iter().flat_map(|part| part.statistics.scans.iter().map(|(_, scan)| scan));
        let own = if self.part.is_some() { None } else { Some(&self.statistics) };
        own.into_iter()
            .chain(of_part)
            .map(|scan| scan.reliable)
            .filter(|band| band.high_rad_per_m > band.low_rad_per_m)
            .map(|band| TAU / band.high_rad_per_m)
            .reduce(f64::max)
    }

    /// Estimates spectra and slopes of the scan, or of the scans of the part.
    ///
    /// # Errors
    /// The map has no spectrum, or cannot be filtered.
    pub fn roughness(&self) -> Result<Roughness, SurfaceModelError> {
        self.part.as_ref().map_or_else(|| Roughness::new(&[&self.map]), |part| Ok(part.roughness.clone()))
    }

    /// Returns the heights of the scan, or of the part, in metre.
    pub fn heights_of_all_m(&self) -> Vec<f64> {
        self.part.as_ref().map_or_else(|| self.map.present_m().collect(), |part| part.heights_m.clone())
    }
}
