//! A part from several scans of it.

use crate::correlation::{Autocorrelation, EstimateError};
use crate::map::HeightMap;
use crate::study::StudyError;
use crate::study::band_slopes::Roughness;
use crate::study::measured::{MapStatistics, Measured};
use crate::study::result::{Companions, PartStatistics, PooledResult, ScanOfPart, SurfaceStatistics, pair};
use crate::surface::pooling::{Pooled, PoolingError, Reading, pool, pooled_heights_m};

/// Confidence level of the intervals.
const LEVEL: f64 = 0.95;

/// The least and the greatest that a statistic can be, which the interval of two or three scans does not know.
fn range(name: &str) -> (f64, f64) {
    match name {
        "Ssk" => (f64::NEG_INFINITY, f64::INFINITY),
        "Sku" => (1.0, f64::INFINITY),
        "Str" | "Smrk1" | "Smrk2" | "Smrk1_secant" | "Smrk2_secant" | "hurst" => (0.0, 1.0),
        "fractal_dimension" => (2.0, 3.0),
        _ => (0.0, f64::INFINITY),
    }
}

/// Statistics of a part, and those of its scans.
#[derive(Debug, Clone, PartialEq)]
pub struct PooledStatistics {
    /// Names as in `results.json`, and pooled statistics; `None` where a statistic is undefined on a scan.
    pub statistics: Vec<(&'static str, Option<Pooled>)>,
    /// Names and statistics of the scans.
    pub scans: Vec<(String, MapStatistics)>,
}

impl PooledStatistics {
    /// Pools the statistics of named scans, which may differ in size and pitch. Slopes and other statistics that depend on
    /// the pitch then differ for that reason, too.
    ///
    /// # Errors
    /// Fewer than two scans.
    pub fn of(scans: Vec<(String, MapStatistics)>) -> Result<Self, PoolingError> {
        let Some((_, first)) = scans.first() else { return Err(PoolingError::TooFew { scans: 0 }) };
        let mut statistics = vec![];
        for (place, (name, _, mean)) in first.poolable().into_iter().enumerate() {
            let reading = |scan: &MapStatistics| {
                let estimates = scan.estimates.named();
                Some(Reading {
                    value: scan.poolable()[place].1?,
                    estimate: estimates.into_iter().find(|(estimated, _)| *estimated == name).and_then(|(_, e)| e),
                    area_m2: scan.present_area_m2(),
                })
            };
            let readings: Option<Vec<Reading>> = scans.iter().map(|(_, scan)| reading(scan)).collect();
            let mut pooled = readings.map(|readings| pool(&readings, mean, LEVEL)).transpose()?;
            if let Some(pooled) = pooled.as_mut() {
                let (least, greatest) = range(name);
                pooled.interval.low = pooled.interval.low.max(least);
                pooled.interval.high = pooled.interval.high.min(greatest);
            }
            statistics.push((name, pooled));
        }
        Ok(Self { statistics, scans })
    }

    /// A pooled statistic by its name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.statistics.iter().find(|(own, _)| *own == name).and_then(|(_, pooled)| Some((*pooled)?.value))
    }

    /// Returns the statistics as `results.json` holds them: points and pitches where all scans have the same, the missing points and
    /// outliers of all scans, the wavenumbers at which every spectrum is reliable, and the outermost lags of the Hurst exponents.
    pub fn results(&self) -> PartStatistics {
        let narrowest = self
            .scans
            .iter()
            .map(|(_, scan)| &scan.results)
            .min_by(|a, b| a.psd_reliable_high_rad_per_m.total_cmp(&b.psd_reliable_high_rad_per_m));
        let named = |(name, pooled): &(&str, Option<Pooled>)| ((*name).to_owned(), pooled.as_ref().map(pooled_result));
        let scan = |(file, scan): &(String, MapStatistics)| ScanOfPart {
            file: file.clone(),
            statistics: scan.results.clone(),
        };
        PartStatistics {
            scan_count: self.scans.len(),
            nx: self.common(|s| s.nx),
            ny: self.common(|s| s.ny),
            dx_m: self.common(|s| s.dx_m),
            dy_m: self.common(|s| s.dy_m),
            missing_points: self.total(|s| s.missing_points),
            outliers: self.total(|s| s.outliers),
            pooled: Companions(self.statistics.iter().map(named).collect()),
            psd_reliable_low_rad_per_m: self.extreme(|s| s.psd_reliable_low_rad_per_m, f64::max),
            psd_reliable_high_rad_per_m: self.extreme(|s| s.psd_reliable_high_rad_per_m, f64::min),
            psd_upper_limit: narrowest.map_or_else(String::new, |scan| scan.psd_upper_limit.clone()),
            hurst_range_low_m: self.ends(|s| s.hurst_range_low_m, f64::min),
            hurst_range_high_m: self.ends(|s| s.hurst_range_high_m, f64::max),
            scans: self.scans.iter().map(scan).collect(),
        }
    }

    /// What all scans agree on.
    fn common<T: PartialEq>(&self, of: impl Fn(&SurfaceStatistics) -> T) -> Option<T> {
        let mut values = self.scans.iter().map(|(_, scan)| of(&scan.results));
        let first = values.next()?;
        values.all(|value| value == first).then_some(first)
    }

    fn total(&self, of: impl Fn(&SurfaceStatistics) -> usize) -> usize {
        self.scans.iter().map(|(_, scan)| of(&scan.results)).sum()
    }

    /// The outermost of what is defined.
    fn ends(&self, of: fn(&SurfaceStatistics) -> Option<f64>, outer: fn(f64, f64) -> f64) -> Option<f64> {
        self.scans.iter().filter_map(|(_, scan)| of(&scan.results)).reduce(outer)
    }

    fn extreme(&self, of: impl Fn(&SurfaceStatistics) -> f64, further: fn(f64, f64) -> f64) -> f64 {
        self.scans.iter().map(|(_, scan)| of(&scan.results)).fold(f64::NAN, further)
    }
}

fn pooled_result(pooled: &Pooled) -> PooledResult {
    let Pooled { value, standard_error, within_std, between_std, .. } = *pooled;
    PooledResult { value, interval: pair(pooled.interval), standard_error, within_std, between_std }
}

/// What several scans say together.
pub(super) struct Part {
    pub(super) statistics: PooledStatistics,
    pub(super) correlation: Autocorrelation,
    pub(super) roughness: Roughness,
    /// All heights, those of each scan about their mean, in metre.
    pub(super) heights_m: Vec<f64>,
}

impl Part {
    /// Pools named scans.
    pub(super) fn of(scans: &[(String, Measured)]) -> Result<Self, StudyError> {
        let correlations: Vec<Autocorrelation> =
            scans.iter().map(|(_, scan)| scan.correlation.clone().and_semivariance(&scan.map)).collect();
        let correlation =
            Autocorrelation::pooled(&correlations.iter().collect::<Vec<_>>()).map_err(|error| match error {
                EstimateError::Pitch { map, pitch_m, first_pitch_m } => {
                    StudyError::Pitch { file: scans[map].0.clone(), pitch_m, first: scans[0].0.clone(), first_pitch_m }
                }
                error => error.into(),
            })?;
        let maps: Vec<&HeightMap> = scans.iter().map(|(_, scan)| &scan.map).collect();
        let named = scans.iter().map(|(file, scan)| (file.clone(), scan.statistics.clone())).collect();
        Ok(Self {
            statistics: PooledStatistics::of(named)?,
            correlation,
            roughness: Roughness::of(&maps)?,
            heights_m: pooled_heights_m(&maps),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Grid;
    use crate::random;
    use crate::study::statistics;
    use crate::surface::preparation::Preparation;

    /// Statistics of a map whose heights are a function of standard normal numbers.
    fn scan(seed: u64, height_m: impl Fn(f64) -> f64) -> MapStatistics {
        let grid = Grid::new(48, 40, 1e-6, 1e-6).unwrap();
        let noise = random::standard_normal(&mut random::stream(seed, "pooled", 0), grid.points());
        let heights = ndarray::Array2::from_shape_fn(grid.shape(), |(row, column)| height_m(noise[row * 48 + column]));
        let map = HeightMap::new(grid, heights).unwrap();
        statistics(&Preparation::default().apply(&map).unwrap()).unwrap()
    }

    #[test]
    fn no_interval_of_a_part_leaves_the_range_of_its_statistic() {
        // Plateaus with pits, and peaks on a plain: of two such scans hardly anything is known, and Student's factor of one
        // degree of freedom is 12.7.
        let one = scan(1, |g| -1e-6 * (2.0 * g).exp());
        let other = scan(2, |g| 1e-7 * g);
        let mut statistics = [one, other];
        (statistics[0].results.hurst, statistics[1].results.hurst) = (Some(0.2), Some(0.9));
        (statistics[0].results.fractal_dimension, statistics[1].results.fractal_dimension) = (Some(2.8), Some(2.1));
        (statistics[0].results.Str, statistics[1].results.Str) = (Some(0.1), Some(0.95));
        let named = ["a", "b"].map(str::to_owned).into_iter().zip(statistics.clone()).collect();
        let pooled = PooledStatistics::of(named).unwrap();
        let interval = |name: &str| {
            let found = pooled.statistics.iter().find(|(own, _)| *own == name).unwrap().1;
            found.map(|found| found.interval).unwrap()
        };
        for share in ["Str", "Smrk1", "Smrk2", "Smrk1_secant", "Smrk2_secant", "hurst"] {
            let ends = interval(share);
            assert!(ends.low >= 0.0 && ends.high <= 1.0 && ends.low < ends.high, "{share}: {ends:?}");
        }
        assert_eq!((interval("Str").low, interval("Str").high), (0.0, 1.0), "as wide as two such scans make it");
        assert_eq!((interval("hurst").low, interval("hurst").high), (0.0, 1.0));
        assert_eq!((interval("fractal_dimension").low, interval("fractal_dimension").high), (2.0, 3.0));
        assert_eq!(interval("Sku").low, 1.0);
        for positive in ["Sq_m", "Sa_m", "Spk_m", "Svk_m", "Sdr", "Sdq", "Vmp_m", "Sp_m"] {
            let ends = interval(positive);
            assert!(ends.low == 0.0 && ends.high > 0.0, "{positive}: {ends:?}");
        }
        assert!(interval("Ssk").low < -1.0, "a skewness has no least value: {:?}", interval("Ssk"));
    }
}
