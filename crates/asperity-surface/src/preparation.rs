//! Preparation of measured heights: removal of form, outliers, small and large scales.

use thiserror::Error;

use super::filter::{FilterError, GaussianFilter, reject_outliers};
use super::level::{Level, LevelError, Levelled, remove_form};
use asperity_base::map::{Grid, HeightMap};

/// Steps that turn a measured map into roughness, in this order. The form is removed. Outliers become missing. The form
/// of the remaining heights is removed, so that outliers do not tilt it. The S-filter removes small scales, and the
/// L-filter large scales.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Preparation {
    /// Form that is removed.
    pub level: Level,
    /// Distance from the median, in robust standard deviations, beyond which heights become missing; `None` keeps all.
    pub outliers: Option<f64>,
    /// Cutoff of the S-filter in metre; shorter waves are removed.
    pub s_filter_m: Option<f64>,
    /// Cutoff of the L-filter in metre; longer waves are removed.
    pub l_filter_m: Option<f64>,
    /// Whether the L-filter is the robust quadratic regression instead of the plain Gaussian.
    pub robust: bool,
}

/// A map that is ready for statistics.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The map.
    pub map: HeightMap,
    /// Number of heights rejected as outliers.
    pub outliers: usize,
    /// Number of heights removed by the robust filter.
    pub lost: usize,
    /// Radius of a removed cylinder or sphere in metre, positive for a ridge or cap.
    pub radius_m: Option<f64>,
    /// Form that was removed.
    pub level: Level,
}

/// Reason why a map could not be prepared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PreparationError {
    /// The form could not be removed.
    #[error("levelling: {0}")]
    Level(#[from] LevelError),
    /// Outliers could not be rejected.
    #[error("outliers: {0}")]
    Outliers(FilterError),
    /// The S-filter failed.
    #[error("S-filter: {0}")]
    SFilter(FilterError),
    /// The L-filter failed.
    #[error("L-filter: {0}")]
    LFilter(FilterError),
    /// The L-filter would remove the whole band that the S-filter keeps.
    #[error(
        "the L-filter, {l_filter_m:e} m, is not longer than the S-filter, {s_filter_m:e} m; no scale is left between"
    )]
    EmptyBand {
        /// Cutoff of the S-filter in metre.
        s_filter_m: f64,
        /// Cutoff of the L-filter in metre.
        l_filter_m: f64,
    },
}

impl Preparation {
    /// Checks that maps of this grid can be filtered.
    ///
    /// # Errors
    /// No band between the filters, or a cutoff below a pixel or above the field.
    pub fn check(&self, grid: Grid) -> Result<(), PreparationError> {
        if let (Some(s_filter_m), Some(l_filter_m)) = (self.s_filter_m, self.l_filter_m)
            && s_filter_m >= l_filter_m
        {
            return Err(PreparationError::EmptyBand { s_filter_m, l_filter_m });
        }
        let check =
            |cutoff_m: Option<f64>| cutoff_m.map_or(Ok(()), |cutoff_m| GaussianFilter::linear(cutoff_m).check(grid));
        check(self.s_filter_m).map_err(PreparationError::SFilter)?;
        check(self.l_filter_m).map_err(PreparationError::LFilter)
    }

    /// Prepares a map.
    ///
    /// # Errors
    /// A form that is not determined, invalid thresholds or cutoffs, or no band between the filters.
    pub fn apply(&self, map: HeightMap) -> Result<Prepared, PreparationError> {
        self.check(map.grid())?;
        let (map, radius_m, outliers) = self.level(map)?;
        let mut prepared = Prepared { map, outliers, lost: 0, radius_m, level: self.level };
        if let Some(cutoff_m) = self.s_filter_m {
            prepared.map =
                GaussianFilter::linear(cutoff_m).smooth(&prepared.map).map_err(PreparationError::SFilter)?.map;
        }
        if let Some(cutoff_m) = self.l_filter_m {
            let filter = if self.robust { GaussianFilter::robust(cutoff_m) } else { GaussianFilter::linear(cutoff_m) };
            let rough = filter.roughness(&prepared.map).map_err(PreparationError::LFilter)?;
            (prepared.map, prepared.lost) = (rough.map, rough.lost);
        }
        Ok(prepared)
    }

    /// Removes form and outliers. Returns the map, the radius of the form and the number of outliers.
    fn level(&self, map: HeightMap) -> Result<(HeightMap, Option<f64>, usize), PreparationError> {
        let Levelled { map: rough, radius_m, .. } = remove_form(&map, self.level)?;
        let Some(limit) = self.outliers else { return Ok((rough, radius_m, 0)) };
        let filtered = reject_outliers(&rough, limit).map_err(PreparationError::Outliers)?;
        if filtered.rejected == 0 {
            return Ok((rough, radius_m, 0));
        }
        drop(rough);
        // The form is fitted to the remaining heights and subtracted from the measured ones.
        let mut kept = filtered.map.into_heights_m();
        kept.zip_mut_with(map.heights_m(), |left, z| *left = if left.is_nan() { f64::NAN } else { *z });
        let grid = map.grid();
        drop(map);
        let kept = HeightMap::new(grid, kept).map_err(|error| PreparationError::Outliers(error.into()))?;
        let Levelled { map, radius_m, .. } = remove_form(&kept, self.level)?;
        Ok((map, radius_m, filtered.rejected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use std::f64::consts::TAU;

    /// Returns waves of 4, 40 and 160 µm on a tilted plane.
    fn waves(grid: Grid) -> Array2<f64> {
        let wave = |x: f64, length: f64| 1e-6 * (TAU * x / length).sin();
        Array2::from_shape_fn(grid.shape(), |(row, column)| {
            let (x, y) = ((column as f64 + 0.5) * 1e-6, (row as f64 + 0.5) * 1e-6);
            wave(x, 4e-6) + wave(x, 40e-6) + wave(x, 160e-6) + 0.05 * x - 0.02 * y
        })
    }

    #[test]
    fn s_and_l_filters_leave_the_band_between() {
        let grid = Grid::new(640, 200, 1e-6, 1e-6).unwrap();
        let map = HeightMap::new(grid, waves(grid)).unwrap();
        let preparation = Preparation { s_filter_m: Some(12e-6), l_filter_m: Some(80e-6), ..Preparation::default() };
        let prepared = preparation.apply(map.clone()).unwrap();
        // Transmissions exp(−ln 2 (λc/λ)²): S transmits 2e−3, 0.940, 0.996 of the three waves, then L 1, 0.94, 0.16.
        let pass = |cutoff: f64, length: f64| (-std::f64::consts::LN_2 * (cutoff / length).powi(2)).exp();
        let expected = |x: f64| {
            let wave =
                |length: f64| 1e-6 * (TAU * x / length).sin() * pass(12e-6, length) * (1.0 - pass(80e-6, length));
            wave(4e-6) + wave(40e-6) + wave(160e-6)
        };
        for column in 200..440 {
            let (found, wanted) = (prepared.map.heights_m()[[100, column]], expected((column as f64 + 0.5) * 1e-6));
            // The least-squares plane of waves cut at whole periods differs slightly from their plane.
            assert!((found - wanted).abs() < 5e-9, "{found:e}, not {wanted:e}");
        }
    }

    #[test]
    fn outliers_do_not_tilt_the_form() {
        let grid = Grid::new(640, 200, 1e-6, 1e-6).unwrap();
        let mut heights = waves(grid);
        let clean = HeightMap::new(grid, heights.clone()).unwrap();
        heights.indexed_iter_mut().filter(|((row, column), _)| row + column < 20).for_each(|(_, z)| *z += 500e-6);
        let spoilt = heights.iter().zip(clean.heights_m()).filter(|(a, b)| a != b).count();
        let map = HeightMap::new(grid, heights).unwrap();
        let preparation = Preparation { outliers: Some(8.0), ..Preparation::default() };
        let (found, wanted) = (preparation.apply(map.clone()).unwrap(), preparation.apply(clean.clone()).unwrap());
        assert_eq!((found.outliers, wanted.outliers), (spoilt, 0));
        let distance = (found.map.heights_m() - wanted.map.heights_m())
            .iter()
            .filter(|d| !d.is_nan())
            .fold(0.0, |m: f64, d| m.max(d.abs()));
        // 210 of 128,000 points, in a corner, no longer influence the plane.
        assert!(distance < 0.05e-6, "{distance:e}");
    }

    #[test]
    fn an_empty_band_is_refused() {
        let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
        let map = HeightMap::new(grid, waves(grid)).unwrap();
        let preparation = Preparation { s_filter_m: Some(8e-6), l_filter_m: Some(8e-6), ..Preparation::default() };
        assert!(matches!(preparation.apply(map.clone()), Err(PreparationError::EmptyBand { .. })));
        let beyond = Preparation { l_filter_m: Some(1.0), ..Preparation::default() };
        assert!(matches!(beyond.apply(map.clone()), Err(PreparationError::LFilter(FilterError::Cutoff { .. }))));
    }
}
