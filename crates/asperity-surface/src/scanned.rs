//! Scans with their statistics: one scan of a part, or several that are pooled.

mod pooled;
mod statistics;

pub use pooled::{Part, PooledStatistics};
pub use statistics::{MapStatistics, uncertainty};

use std::f64::consts::TAU;

use asperity_base::correlation::{Autocorrelation, EstimateError};
use asperity_base::distribution::{DistributionError, Marginal};
use asperity_base::map::HeightMap;
use asperity_base::stats::Interval;

use crate::height_fits::{HeightFits, effective_heights};
use crate::level::Level;
use crate::model::{Roughness, SurfaceModelError};
use crate::pooling::{PoolingError, pooled_heights_m};
use crate::preparation::Prepared;
use crate::uncertainty::Values;

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
        let correlations: Vec<Autocorrelation> =
            scans.iter().map(|(_, scan)| scan.correlation.clone().and_semivariance(&scan.map)).collect();
        let correlation =
            Autocorrelation::pooled(&correlations.iter().collect::<Vec<_>>()).map_err(|error| match error {
                EstimateError::Pitch { map, pitch_m, first_pitch_m } => SurfaceModelError::Pitch {
                    file: scans[map].0.clone(),
                    pitch_m,
                    first: scans[0].0.clone(),
                    first_pitch_m,
                },
                error => error.into(),
            })?;
        let maps: Vec<&HeightMap> = scans.iter().map(|(_, scan)| &scan.map).collect();
        let named = scans.iter().map(|(file, scan)| (file.clone(), scan.statistics.clone())).collect();
        let part = Part {
            statistics: PooledStatistics::new(named)?,
            correlation,
            roughness: Roughness::new(&maps)?,
            heights_m: pooled_heights_m(&maps),
        };
        let mut scans = scans.into_iter().map(|(_, scan)| scan);
        let first = scans.next().ok_or(PoolingError::TooFew { scans: 0 })?;
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

    /// Returns the length in metre of the shortest wave that all scans resolve
    /// ([`BlockSpectrum::shortest_wave_m`](asperity_base::correlation::BlockSpectrum::shortest_wave_m)).
    ///
    /// # Errors
    /// The map has no spectrum, or cannot be filtered.
    pub fn shortest_wave_m(&self) -> Result<f64, SurfaceModelError> {
        Ok(self.roughness()?.shortest_wave_m())
    }

    /// Estimates spectra and slopes of the scan, or of the scans of the part.
    ///
    /// # Errors
    /// The map has no spectrum, or cannot be filtered.
    pub fn roughness(&self) -> Result<Roughness, SurfaceModelError> {
        self.part.as_ref().map_or_else(|| Roughness::new(&[&self.map]), |part| Ok(part.roughness.clone()))
    }

    /// Returns the distribution of the heights of random surfaces ([`HeightFits::marginal`]).
    ///
    /// # Errors
    /// The heights have no distribution.
    pub fn marginal(&self) -> Result<Marginal, DistributionError> {
        let heights_m = self.heights_of_all_m();
        let correlation = self.part.as_ref().map_or(&self.correlation, |part| &part.correlation);
        HeightFits::with_effective_size(heights_m.into_iter(), effective_heights(correlation)).marginal()
    }

    /// Returns the heights of the scan, or of the part, in metre.
    pub fn heights_of_all_m(&self) -> Vec<f64> {
        self.part.as_ref().map_or_else(|| self.map.present_m().collect(), |part| part.heights_m.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preparation::Preparation;
    use crate::{RandomSurface, SpectralField, Translated};
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::map::Grid;
    use asperity_base::random;

    #[test]
    fn heights_have_a_smooth_distribution_unless_the_scan_shows_another() {
        // Some 400 independent patches: a lognormal skewness of 1.75 is seen, one of 0 is not; two separate plateaus fit no family.
        let grid = Grid::new(160, 160, 1e-6, 1e-6).unwrap();
        let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, 4e-6).unwrap();
        let field = SpectralField::periodic(&covariance, grid);
        let xi = random::standard_normal(&mut random::stream(8, "heights", 0), field.xi_len());
        let found = |heights: &dyn Fn(&HeightMap) -> HeightMap| {
            let map = heights(&field.generate(&xi));
            let prepared = Preparation::default().apply(map).unwrap();
            ScannedSurface::without_intervals(prepared).unwrap().marginal().unwrap()
        };
        let normal = found(&HeightMap::clone);
        assert!(matches!(normal, Marginal::Normal { .. }), "{normal:?}");
        let lognormal = Marginal::lognormal(0.0, 0.5, 0.0).unwrap();
        let translated = Translated::new(field.clone(), lognormal).unwrap();
        let skewed = found(&|_| translated.generate(&xi));
        assert!(!matches!(skewed, Marginal::Normal { .. } | Marginal::Empirical { .. }), "{skewed:?}");
        assert!(skewed.skewness() > 1.0, "{skewed:?}");
        let plateaus = found(&|map| {
            let heights_m = map.heights_m().mapv(|z| 0.05 * z + if z > 0.0 { 1.0 } else { -1.0 });
            HeightMap::new(grid, heights_m).unwrap()
        });
        assert!(matches!(plateaus, Marginal::Empirical { .. }), "{plateaus:?}");
    }
}
