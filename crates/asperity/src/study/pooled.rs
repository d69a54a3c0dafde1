//! Statistics of a part from several scans of it.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::study::result::{SurfaceStatistics, pair};
use crate::surface::pooling::{Pooled, PoolingError, Reading, pool};

/// Confidence level of the intervals.
const LEVEL: f64 = 0.95;

/// Statistics of a part, and those of its scans.
///
/// As JSON, for each statistic x: `x` (the weighted mean of the scans' own), `x_interval` = [low, high] at 95 % and `x_se` of
/// the part's, `x_within_std` (the standard error of one scan) and `x_between_std` (the standard deviation between places);
/// `scan_count`, and the scans as `scans`, each with its `file`. A statistic that is undefined on a scan is null.
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
            statistics.push((name, readings.map(|readings| pool(&readings, mean, LEVEL)).transpose()?));
        }
        Ok(Self { statistics, scans })
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
        for (name, pooled) in &self.statistics {
            map.serialize_entry(name, &pooled.map(|p| p.value))?;
            map.serialize_entry(&format!("{name}_interval"), &pooled.map(|p| pair(p.interval)))?;
            map.serialize_entry(&format!("{name}_se"), &pooled.map(|p| p.standard_error))?;
            map.serialize_entry(&format!("{name}_within_std"), &pooled.and_then(|p| p.within_std))?;
            map.serialize_entry(&format!("{name}_between_std"), &pooled.and_then(|p| p.between_std))?;
        }
        let scans: Vec<Scan> = self.scans.iter().map(|(file, statistics)| Scan { file, statistics }).collect();
        map.serialize_entry("scans", &scans)?;
        map.end()
    }
}
