//! Several scans of one part.

use asperity_base::correlation::Autocorrelation;

use super::statistics::MapStatistics;
use crate::model::Roughness;
use crate::pooling::{Mean, Pooled, PoolingError, Reading, pool};

/// Confidence level of the intervals.
const LEVEL: f64 = 0.95;
/// Statistics whose squares are means over the surface.
const SQUARES: [&str; 3] = ["Sq_m", "Sdq", "Sdq_7point"];

/// Returns the smallest and the largest possible value of a statistic, to which the wide intervals of few scans are cut.
fn range(name: &str) -> (f64, f64) {
    match name {
        "Ssk" => (f64::NEG_INFINITY, f64::INFINITY),
        "Sku" => (1.0, f64::INFINITY),
        "Str" | "Smrk1" | "Smrk2" | "Smrk1_secant" | "Smrk2_secant" | "hurst" => (0.0, 1.0),
        "fractal_dimension" => (2.0, 3.0),
        _ => (0.0, f64::INFINITY),
    }
}

/// Pooled statistics of a part and the statistics of its scans.
#[derive(Debug, Clone, PartialEq)]
pub struct PooledStatistics {
    /// Names as in tables and JSON, and pooled statistics; `None` if a statistic is undefined on a scan.
    pub statistics: Vec<(&'static str, Option<Pooled>)>,
    /// Names and statistics of the scans.
    pub scans: Vec<(String, MapStatistics)>,
}

impl PooledStatistics {
    /// Pools the statistics of named scans, which may differ in size and pitch. Slopes depend on the pitch, and so does their
    /// difference between scans.
    ///
    /// # Errors
    /// There are fewer than two scans.
    pub fn new(scans: Vec<(String, MapStatistics)>) -> Result<Self, PoolingError> {
        let Some((_, first)) = scans.first() else { return Err(PoolingError::TooFew { scans: 0 }) };
        let mut statistics = vec![];
        let (squares, others): (Vec<_>, Vec<_>) =
            first.poolable().into_iter().enumerate().partition(|(_, (name, _))| SQUARES.contains(name));
        for (place, (name, _)) in squares.into_iter().chain(others) {
            let mean = if SQUARES.contains(&name) { Mean::RootMeanSquare } else { Mean::Arithmetic };
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

    /// Returns a pooled statistic by its name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.statistics.iter().find(|(own, _)| *own == name).and_then(|(_, pooled)| Some((*pooled)?.value))
    }
}

/// Several scans of one part, pooled.
#[derive(Debug, Clone)]
pub struct Part {
    /// Pooled statistics.
    pub statistics: PooledStatistics,
    /// Autocorrelation over all pairs of points within a scan.
    pub correlation: Autocorrelation,
    /// Spectra and slopes of the scans.
    pub roughness: Roughness,
    /// Heights of all scans about the mean of their scan, in metre.
    pub heights_m: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fractal::Scaling;
    use crate::preparation::Preparation;
    use asperity_base::map::{Grid, HeightMap};
    use asperity_base::random;

    /// Statistics of a map whose heights are a function of standard normal numbers.
    fn scan(seed: u64, height_m: impl Fn(f64) -> f64) -> MapStatistics {
        let grid = Grid::new(48, 40, 1e-6, 1e-6).unwrap();
        let noise = random::standard_normal(&mut random::stream(seed, "pooled", 0), grid.points());
        let heights = ndarray::Array2::from_shape_fn(grid.shape(), |(row, column)| height_m(noise[row * 48 + column]));
        let map = HeightMap::new(grid, heights).unwrap();
        MapStatistics::new(&Preparation::default().apply(map).unwrap()).unwrap()
    }

    #[test]
    fn no_interval_of_a_part_leaves_the_range_of_its_statistic() {
        // Plateaus with pits, and peaks on a plain: of two such scans hardly anything is known, and Student's factor of one
        // degree of freedom is 12.7.
        let one = scan(1, |g| -1e-6 * (2.0 * g).exp());
        let other = scan(2, |g| 1e-7 * g);
        let mut statistics = [one, other];
        let scaling = |hurst| Scaling { hurst, hurst_se: None, fractal_dimension: 3.0 - hurst, x: None, y: None };
        (statistics[0].scaling, statistics[1].scaling) = (Some(scaling(0.2)), Some(scaling(0.9)));
        (statistics[0].parameters.str_ratio, statistics[1].parameters.str_ratio) = (Some(0.1), Some(0.95));
        let named = ["a", "b"].map(str::to_owned).into_iter().zip(statistics.clone()).collect();
        let pooled = PooledStatistics::new(named).unwrap();
        let interval = |name: &str| {
            let found = pooled.statistics.iter().find(|(own, _)| *own == name).unwrap().1;
            found.map(|found| found.interval).unwrap()
        };
        for ratio in ["Str", "Smrk1", "Smrk2", "Smrk1_secant", "Smrk2_secant", "hurst"] {
            let ends = interval(ratio);
            assert!(ends.low >= 0.0 && ends.high <= 1.0 && ends.low < ends.high, "{ratio}: {ends:?}");
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
