//! Pooled statistics of several scans of one part.
//!
//! Scans differ because each is a small sample of a random surface, and because the part varies from place to place. The
//! intervals of [`super::uncertainty`] cover the first cause; the remaining difference is the spread between places.

use thiserror::Error;

use super::uncertainty::Estimate;
use asperity_base::blocks;
use asperity_base::map::HeightMap;
use asperity_base::numeric::dot;
use asperity_base::stats::{Interval, student_quantile};

/// Statistic of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Statistic of the map.
    pub value: f64,
    /// Estimate for the surface, if the map contains enough correlation lengths.
    pub estimate: Option<Estimate>,
    /// Area of the present points in m²; the variance within a scan is inversely proportional to it.
    pub area_m2: f64,
}

/// Quantity that is averaged over scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mean {
    /// The statistic.
    Arithmetic,
    /// The square of the statistic: for Sq and Sdq, whose squares are means over the surface.
    RootMeanSquare,
}

/// Statistic of a part from several scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pooled {
    /// Number of scans.
    pub scans: usize,
    /// Weighted mean of the statistics of the maps.
    pub value: f64,
    /// Weighted mean of the estimates for the surface.
    pub surface: f64,
    /// Standard error of the mean as an estimate for the whole part, of which the scans are a sample.
    pub standard_error: f64,
    /// Confidence interval of the part's statistic.
    pub interval: Interval,
    /// Standard error of a single scan of mean area; `None` if no scan has one.
    pub within_std: Option<f64>,
    /// Standard deviation between places of the part; zero if sampling explains the differences; `None` without
    /// standard errors.
    pub between_std: Option<f64>,
}

/// Reason why scans could not be pooled.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PoolingError {
    /// A single scan has no spread between scans.
    #[error("found {scans} scan, but pooling needs at least 2")]
    TooFew {
        /// Number of scans found.
        scans: usize,
    },
    /// A scan without area has no weight.
    #[error("scan {scan} has the area {area_m2} m², but must be larger than zero")]
    Area {
        /// Number of the scan, from 0.
        scan: usize,
        /// Area of the scan in m².
        area_m2: f64,
    },
    /// The confidence level is not between 0 and 1.
    #[error("the confidence level is {level}, but must be between 0 and 1")]
    Level {
        /// Level found.
        level: f64,
    },
}

/// Pools one statistic of several scans, which may differ in size and pitch as far as the statistic allows.
///
/// The model has random effects: scan i measures the part's mean, plus a deviation of its place of variance τ², plus a
/// sampling error of variance κ/A_i. κ is the mean of the scans' own estimates, because scans of one surface differ
/// only in area and the single estimates are noisy. τ² is DerSimonian and Laird's estimate. Scans have the weights
/// 1/(τ² + κ/A_i). The interval uses the larger of the weighted spread of the readings and the spread of the model,
/// with Student's quantiles of one degree of freedom less than there are scans (Hartung & Knapp). So two scans
/// determine a part only roughly, however precise they are. Without standard errors, scans have equal weights and the
/// interval is Student's.
///
/// # References
/// DerSimonian & Laird, *Control. Clin. Trials* **7** (1986) 177, <https://doi.org/10.1016/0197-2456(86)90046-2>;
/// Hartung & Knapp, *Stat. Med.* **20** (2001) 1771, <https://doi.org/10.1002/sim.791>.
///
/// # Errors
/// Fewer than two scans, a scan without area, a level outside (0, 1).
pub fn pool(readings: &[Reading], mean: Mean, level: f64) -> Result<Pooled, PoolingError> {
    let scans = readings.len();
    if scans < 2 {
        return Err(PoolingError::TooFew { scans });
    }
    if let Some((scan, reading)) = readings.iter().enumerate().find(|(_, r)| r.area_m2.is_nan() || r.area_m2 <= 0.0) {
        return Err(PoolingError::Area { scan, area_m2: reading.area_m2 });
    }
    if !(level > 0.0 && level < 1.0) {
        return Err(PoolingError::Level { level });
    }
    let scaled: Vec<f64> = readings.iter().map(|r| mean.of(r.estimate.map_or(r.value, |e| e.surface))).collect();
    let areas: Vec<f64> = readings.iter().map(|r| r.area_m2).collect();
    let mean_area = areas.iter().sum::<f64>() / scans as f64;
    // The variance within a scan of mean area, on the scale of the averaged quantity.
    let (known, sum) = readings.iter().filter_map(|r| Some((r.area_m2, r.estimate?))).fold(
        (0.0, 0.0),
        |(known, sum), (area, estimate)| {
            let error = mean.slope(estimate.surface) * estimate.standard_error;
            (known + area, sum + area * area / mean_area * error * error)
        },
    );
    let within = (known > 0.0 && sum > 0.0).then(|| sum / known);
    let sampling = |area: f64| within.unwrap_or(1.0) * mean_area / area;
    let between = within.map(|_| {
        let weights: Vec<f64> = areas.iter().map(|area| 1.0 / sampling(*area)).collect();
        let (all, centre) = weighted(&weights, &scaled);
        let spread: f64 = weights.iter().zip(&scaled).map(|(w, y)| w * (y - centre).powi(2)).sum();
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        ((spread - (scans as f64 - 1.0)) / (all - squares / all)).max(0.0)
    });
    let weights: Vec<f64> = match between {
        Some(between) => areas.iter().map(|area| 1.0 / (between + sampling(*area))).collect(),
        None => vec![1.0; scans],
    };
    let (all, centre) = weighted(&weights, &scaled);
    let spread: f64 = weights.iter().zip(&scaled).map(|(w, y)| w * (y - centre).powi(2)).sum();
    let ratio = spread / (scans as f64 - 1.0);
    let error = (if between.is_some() { ratio.max(1.0) } else { ratio } / all).sqrt();
    let student = student_quantile(1.0 - 0.5 * (1.0 - level), scans as f64 - 1.0);
    let values: Vec<f64> = readings.iter().map(|r| mean.of(r.value)).collect();
    let surface = mean.back(centre);
    let own_scale = |std: f64| std / mean.slope(surface);
    Ok(Pooled {
        scans,
        value: mean.back(weighted(&weights, &values).1),
        surface,
        standard_error: own_scale(error),
        interval: Interval { low: mean.back(centre - student * error), high: mean.back(centre + student * error) },
        within_std: within.map(|variance| own_scale(variance.sqrt())),
        between_std: between.map(|variance| own_scale(variance.sqrt())),
    })
}

impl Mean {
    fn of(self, value: f64) -> f64 {
        match self {
            Self::Arithmetic => value,
            Self::RootMeanSquare => value * value,
        }
    }

    fn back(self, mean: f64) -> f64 {
        match self {
            Self::Arithmetic => mean,
            Self::RootMeanSquare => mean.max(0.0).sqrt(),
        }
    }

    /// Returns the derivative of the averaged quantity.
    fn slope(self, value: f64) -> f64 {
        match self {
            Self::Arithmetic => 1.0,
            Self::RootMeanSquare => 2.0 * value,
        }
    }
}

/// Returns the sum of the weights and the weighted mean.
fn weighted(weights: &[f64], values: &[f64]) -> (f64, f64) {
    let all: f64 = weights.iter().sum();
    (all, dot(weights, values) / all)
}

/// Returns the present heights of several maps, each about its own mean, in metre: a sample of the marginal
/// distribution of the part in which every height has the same weight.
pub fn pooled_heights_m(maps: &[&HeightMap]) -> Vec<f64> {
    let centred = |map: &&HeightMap| {
        let present: Vec<f64> = map.present_m().collect();
        let mean_m = present.iter().sum::<f64>() / present.len() as f64;
        present.into_iter().map(|z| z - mean_m).collect::<Vec<f64>>()
    };
    blocks::map::<_, Vec<_>>(0..maps.len(), |map| centred(&maps[map])).concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::map::Grid;
    use asperity_base::random;
    use asperity_base::stats::Moments;
    use asperity_testing::{covered, repetitions};
    use ndarray::array;

    fn reading(value: f64, standard_error: f64, area_m2: f64) -> Reading {
        let interval = Interval { low: value - 2.0 * standard_error, high: value + 2.0 * standard_error };
        let estimate = Estimate { value, surface: value, standard_error, interval, blocks: 20.0 };
        Reading { value, estimate: Some(estimate), area_m2 }
    }

    #[test]
    fn identical_scans_have_no_spread_between_them() {
        for mean in [Mean::Arithmetic, Mean::RootMeanSquare] {
            let pooled = pool(&[reading(2.0, 0.1, 1e-6); 4], mean, 0.95).unwrap();
            assert_eq!((pooled.scans, pooled.value, pooled.between_std), (4, 2.0, Some(0.0)));
            assert!((pooled.within_std.unwrap() - 0.1).abs() < 1e-15);
            // Four independent scans of one surface halve the error.
            assert!((pooled.standard_error - 0.05).abs() < 1e-15);
            // Student's quantile on 3 degrees of freedom.
            let half: f64 = 3.182_446_305_283_71 * if mean == Mean::Arithmetic { 0.05 } else { 4.0 * 0.05 };
            let ends = match mean {
                Mean::Arithmetic => (2.0 - half, 2.0 + half),
                Mean::RootMeanSquare => ((4.0 - half).sqrt(), (4.0 + half).sqrt()),
            };
            assert!((pooled.interval.low - ends.0).abs() < 1e-9 && (pooled.interval.high - ends.1).abs() < 1e-9);
        }
    }

    #[test]
    fn scans_without_errors_of_their_own_have_the_interval_of_student() {
        let readings = [1.0, 2.0, 4.0, 5.0].map(|value| Reading { value, estimate: None, area_m2: 1.0 });
        let pooled = pool(&readings, Mean::Arithmetic, 0.95).unwrap();
        assert_eq!((pooled.value, pooled.within_std, pooled.between_std), (3.0, None, None));
        // Deviations −2, −1, 1, 2: s² = 10/3.
        assert!((pooled.standard_error - (10.0_f64 / 12.0).sqrt()).abs() < 1e-15);
        assert!((pooled.interval.high - 3.0 - 3.182_446_305_283_71 * pooled.standard_error).abs() < 1e-9);
    }

    #[test]
    fn equal_areas_give_the_simple_mean_and_the_analysis_of_variance() {
        // s² of 1, 2, 4, 5 is 10/3; the sampling variance is 0.5².
        let pooled = pool(&[1.0, 2.0, 4.0, 5.0].map(|v| reading(v, 0.5, 3.0)), Mean::Arithmetic, 0.95).unwrap();
        assert!((pooled.value - 3.0).abs() < 1e-15);
        assert!((pooled.between_std.unwrap().powi(2) - (10.0 / 3.0 - 0.25)).abs() < 1e-12);
        assert!((pooled.standard_error - (10.0_f64 / 12.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn scans_of_one_surface_are_weighted_by_area() {
        // Variances 0.01/A: the readings agree within them, so τ² = 0 and weights are areas.
        let readings = [reading(1.0, 0.1, 1.0), reading(1.1, 0.05, 4.0), reading(1.05, 0.1, 1.0)];
        let pooled = pool(&readings, Mean::Arithmetic, 0.95).unwrap();
        assert_eq!(pooled.between_std, Some(0.0));
        assert!((pooled.value - (1.0 + 4.4 + 1.05) / 6.0).abs() < 1e-12);
        assert!((pooled.standard_error - (0.01_f64 / 6.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn spread_between_scans_is_recovered_and_intervals_cover_the_mean() {
        // Squares of Sq with mean 4, spread between places 0.4, sampling errors 0.3/√A of areas 1 and 2 in turn.
        let (mean, between, within, scans) = (4.0, 0.4, 0.3, 12);
        let mut found = vec![];
        let mut held = 0;
        let repeats = repetitions(400);
        for repeat in 0..repeats as u64 {
            let noise = random::standard_normal(&mut random::stream(5, "pooling", repeat), 2 * scans);
            let readings: Vec<Reading> = (0..scans)
                .map(|i| {
                    let area = 1.0 + (i % 2) as f64;
                    let error = within / area.sqrt();
                    let square: f64 = mean + between * noise[2 * i] + error * noise[2 * i + 1];
                    reading(square.sqrt(), error / (2.0 * square.sqrt()), area)
                })
                .collect();
            let pooled = pool(&readings, Mean::RootMeanSquare, 0.95).unwrap();
            found.push((2.0 * pooled.surface * pooled.between_std.unwrap()).powi(2));
            held += usize::from(pooled.interval.contains(mean.sqrt()));
        }
        let moments = Moments::new(&found);
        // Truncation at zero is rare here: τ² exceeds twice its standard error.
        assert!((moments.mean - between * between).abs() < 4.0 * moments.standard_error(), "{moments:?}");
        // The standard error of τ² by theory, 2 (τ² + σ²)²/(k − 1) with σ² between 0.045 and 0.09.
        let theory = |sampling: f64| (between * between + sampling) * (2.0 / (scans as f64 - 1.0)).sqrt();
        assert!(moments.std > 0.9 * theory(0.045) && moments.std < 1.1 * theory(0.09), "{}", moments.std);
        // The coverage of 95 % over 400 runs has a standard error of 1.1 %.
        let fraction = covered("statistic of several scans", "Sq of twelve scans that differ", held, repeats);
        assert!((fraction - 0.95).abs() < 4.0 * 0.011, "{fraction}");
    }

    #[test]
    fn pooled_heights_are_about_the_mean_of_their_own_scan() {
        let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
        let a = HeightMap::new(grid, array![[1.0, 2.0], [3.0, f64::NAN]]).unwrap();
        let b = HeightMap::new(grid, array![[10.0, 10.0], [14.0, 14.0]]).unwrap();
        assert_eq!(pooled_heights_m(&[&a, &b]), [-1.0, 0.0, 1.0, -2.0, -2.0, 2.0, 2.0]);
    }

    #[test]
    fn invalid_samples_are_refused() {
        assert_eq!(pool(&[reading(1.0, 0.1, 1.0)], Mean::Arithmetic, 0.95), Err(PoolingError::TooFew { scans: 1 }));
        let readings = [reading(1.0, 0.1, 1.0), reading(1.0, 0.1, 0.0)];
        assert_eq!(pool(&readings, Mean::Arithmetic, 0.95), Err(PoolingError::Area { scan: 1, area_m2: 0.0 }));
        assert!(pool(&[reading(1.0, 0.1, 1.0); 2], Mean::Arithmetic, 1.0).is_err());
    }
}
