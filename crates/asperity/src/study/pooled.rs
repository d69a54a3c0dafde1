//! A part from several scans of it.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::correlation::{Autocorrelation, EstimateError};
use crate::map::HeightMap;
use crate::study::StudyError;
use crate::study::band_slopes::Roughness;
use crate::study::measured::Measured;
use crate::study::result::{SurfaceStatistics, pair};
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
///
/// As JSON, for each statistic x: `x` (the weighted mean of the scans' own), `x_interval` = [low, high] at 95 % and `x_se` of
/// the part's, `x_within_std` (the standard error of one scan) and `x_between_std` (the standard deviation between places);
/// `scan_count`, and the scans as `scans`, each with its `file` and all that is said of a single map. A statistic that is
/// undefined on a scan is null. Points and pitches stand beside them where all scans have the same, missing points and
/// outliers are those of all scans, wavenumbers are reliable where they are so in every scan, and the lags of the Hurst exponent are the
/// outermost of all scans.
#[derive(Debug, Clone, PartialEq)]
pub struct PooledStatistics {
    /// Names as in [`SurfaceStatistics`], and pooled statistics.
    pub statistics: Vec<(&'static str, Option<Pooled>)>,
    /// Names and statistics of the scans.
    pub scans: Vec<(String, SurfaceStatistics)>,
}

impl PooledStatistics {
    /// Pools the statistics of named scans, which may differ in size and pitch. Slopes and other statistics that depend on
    /// the pitch then differ for that reason, too.
    ///
    /// # Errors
    /// Fewer than two scans.
    pub fn of(scans: Vec<(String, SurfaceStatistics)>) -> Result<Self, PoolingError> {
        let Some((_, first)) = scans.first() else { return Err(PoolingError::TooFew { scans: 0 }) };
        let mut statistics = vec![];
        for (place, (name, _, mean)) in first.poolable().into_iter().enumerate() {
            let reading = |scan: &SurfaceStatistics| {
                let estimates = scan.intervals.0.named();
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

    /// What all scans agree on.
    fn common<T: PartialEq>(&self, of: impl Fn(&SurfaceStatistics) -> T) -> Option<T> {
        let mut values = self.scans.iter().map(|(_, scan)| of(scan));
        let first = values.next()?;
        values.all(|value| value == first).then_some(first)
    }

    fn total(&self, of: impl Fn(&SurfaceStatistics) -> usize) -> usize {
        self.scans.iter().map(|(_, scan)| of(scan)).sum()
    }

    /// The outermost of what is defined.
    fn ends(&self, of: fn(&SurfaceStatistics) -> Option<f64>, outer: fn(f64, f64) -> f64) -> Option<f64> {
        self.scans.iter().filter_map(|(_, scan)| of(scan)).reduce(outer)
    }

    fn extreme(&self, of: impl Fn(&SurfaceStatistics) -> f64, further: fn(f64, f64) -> f64) -> Option<f64> {
        self.scans.iter().map(|(_, scan)| of(scan)).reduce(further)
    }
}

impl Serialize for PooledStatistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        /// A scan with its name.
        #[derive(Serialize)]
        struct Scan<'a> {
            file: &'a str,
            #[serde(flatten)]
            statistics: &'a SurfaceStatistics,
        }
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scan_count", &self.scans.len())?;
        map.serialize_entry("nx", &self.common(|s| s.nx))?;
        map.serialize_entry("ny", &self.common(|s| s.ny))?;
        map.serialize_entry("dx_m", &self.common(|s| s.dx_m))?;
        map.serialize_entry("dy_m", &self.common(|s| s.dy_m))?;
        map.serialize_entry("missing_points", &self.total(|s| s.missing_points))?;
        map.serialize_entry("outliers", &self.total(|s| s.outliers))?;
        for (name, pooled) in &self.statistics {
            map.serialize_entry(name, &pooled.map(|p| p.value))?;
            map.serialize_entry(&format!("{name}_interval"), &pooled.map(|p| pair(p.interval)))?;
            map.serialize_entry(&format!("{name}_se"), &pooled.map(|p| p.standard_error))?;
            map.serialize_entry(&format!("{name}_within_std"), &pooled.and_then(|p| p.within_std))?;
            map.serialize_entry(&format!("{name}_between_std"), &pooled.and_then(|p| p.between_std))?;
        }
        let low = self.extreme(|s| s.psd_reliable_low_rad_per_m, f64::max);
        let high = self.extreme(|s| s.psd_reliable_high_rad_per_m, f64::min);
        let narrowest = self
            .scans
            .iter()
            .map(|(_, scan)| scan)
            .min_by(|a, b| a.psd_reliable_high_rad_per_m.total_cmp(&b.psd_reliable_high_rad_per_m));
        map.serialize_entry("psd_reliable_low_rad_per_m", &low)?;
        map.serialize_entry("psd_reliable_high_rad_per_m", &high)?;
        map.serialize_entry("psd_upper_limit", &narrowest.map(|scan| scan.psd_upper_limit))?;
        map.serialize_entry("hurst_range_low_m", &self.ends(|s| s.hurst_range_low_m, f64::min))?;
        map.serialize_entry("hurst_range_high_m", &self.ends(|s| s.hurst_range_high_m, f64::max))?;
        let scans: Vec<Scan> = self.scans.iter().map(|(file, statistics)| Scan { file, statistics }).collect();
        map.serialize_entry("scans", &scans)?;
        map.end()
    }
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
    fn scan(seed: u64, height_m: impl Fn(f64) -> f64) -> SurfaceStatistics {
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
        (statistics[0].hurst, statistics[1].hurst) = (Some(0.2), Some(0.9));
        (statistics[0].fractal_dimension, statistics[1].fractal_dimension) = (Some(2.8), Some(2.1));
        (statistics[0].Str, statistics[1].Str) = (Some(0.1), Some(0.95));
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
