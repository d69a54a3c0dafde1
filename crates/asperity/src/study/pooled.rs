//! A part from several scans of it.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::correlation::{Autocorrelation, EstimateError};
use crate::map::HeightMap;
use crate::study::StudyError;
use crate::study::measured::Measured;
use crate::study::result::{SurfaceStatistics, pair};
use crate::surface::pooling::{Pooled, PoolingError, Reading, pool, pooled_heights_m};

/// Confidence level of the intervals.
const LEVEL: f64 = 0.95;

/// Statistics that exceed one nowhere.
const SHARES: [&str; 5] = ["Str", "Smrk1", "Smrk2", "Smrk1_secant", "Smrk2_secant"];

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
            if let Some(pooled) = pooled.as_mut().filter(|_| name != "Ssk") {
                // All but the skewness are positive by definition, which two or three scans do not know.
                pooled.interval.low = pooled.interval.low.max(0.0);
                if SHARES.contains(&name) {
                    pooled.interval.high = pooled.interval.high.min(1.0);
                }
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
        Ok(Self { statistics: PooledStatistics::of(named)?, correlation, heights_m: pooled_heights_m(&maps) })
    }
}
