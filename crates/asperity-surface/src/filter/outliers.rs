//! Rejection of outliers, which become missing points.

use super::FilterError;
use asperity_base::map::HeightMap;
use asperity_base::stats::{Moments, quantile_sorted};

/// Standard deviation of a normal distribution over its median absolute deviation, 1/Φ⁻¹(¾).
const STD_OVER_MAD: f64 = 1.482_602_218_505_602;

/// A map without its outliers.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered {
    /// The map; outliers are missing.
    pub map: HeightMap,
    /// Number of points rejected.
    pub rejected: usize,
    /// Median of the heights in metre, from which distances are measured.
    pub median_m: f64,
    /// Robust standard deviation of the heights in metre.
    pub scale_m: f64,
}

/// Rejects heights farther than `standard_deviations` from the median. Remove the form first; otherwise a tilt
/// dominates the scale.
///
/// The scale is 1.4826 times the median absolute deviation, the standard deviation of a normal distribution. Outliers
/// cannot inflate it while they are fewer than half. If more than half of the heights are equal, that scale is zero and
/// the standard deviation about the mean is used. There is one pass; rejected heights are not filled.
///
/// # References
/// Rousseeuw & Croux, *J. Am. Stat. Assoc.* **88** (1993) 1273, <https://doi.org/10.1080/01621459.1993.10476408>.
///
/// # Errors
/// The threshold is not positive and finite.
pub fn reject_outliers(map: &HeightMap, standard_deviations: f64) -> Result<Filtered, FilterError> {
    if !(standard_deviations > 0.0 && standard_deviations.is_finite()) {
        return Err(FilterError::Threshold { found: standard_deviations });
    }
    let mut heights_m = Vec::with_capacity(map.grid().points() - map.missing_points());
    heights_m.extend(map.present_m());
    let median_m = median(&mut heights_m);
    heights_m.iter_mut().for_each(|z| *z = (*z - median_m).abs());
    let mad_m = median(&mut heights_m);
    drop(heights_m);
    let scale_m =
        if mad_m > 0.0 { STD_OVER_MAD * mad_m } else { Moments::from_values(map.heights_m().iter().copied()).std };
    let limit_m = standard_deviations * scale_m;
    let heights_m = map.heights_m().mapv(|z| if (z - median_m).abs() > limit_m { f64::NAN } else { z });
    let left = HeightMap::new(map.grid(), heights_m)?;
    let rejected = left.missing_points() - map.missing_points();
    Ok(Filtered { map: left, rejected, median_m, scale_m })
}

/// Returns the median, the mean of two if there are two; NaN without values. The values are reordered.
fn median(values: &mut [f64]) -> f64 {
    let count = values.len();
    if count == 0 {
        return f64::NAN;
    }
    let (below, upper, _) = values.select_nth_unstable_by(count / 2, f64::total_cmp);
    match below.iter().copied().reduce(f64::max).filter(|_| count.is_multiple_of(2)) {
        Some(lower) => quantile_sorted(&[lower, *upper], 0.5),
        None => *upper,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::map::Grid;
    use asperity_base::random;
    use ndarray::Array2;

    fn rough(index: u64) -> Array2<f64> {
        let values = random::standard_normal(&mut random::stream(10, "filter", index), 64 * 64);
        Array2::from_shape_vec((64, 64), values).unwrap() * 1e-6
    }

    fn map(heights: Array2<f64>) -> HeightMap {
        HeightMap::new(Grid::new(64, 64, 1e-6, 1e-6).unwrap(), heights).unwrap()
    }

    #[test]
    fn the_median_is_that_of_sorted_values() {
        for count in 0..7 {
            let values: Vec<f64> = (0..count).map(|i| f64::from((i * 5 + 3) % 7) * 0.3).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let (found, wanted) = (median(&mut values.clone()), quantile_sorted(&sorted, 0.5));
            assert!(found == wanted || found.is_nan() && count == 0, "{count}: {found}, {wanted}");
        }
    }

    #[test]
    fn spikes_become_missing_and_are_counted() {
        let mut heights = rough(0);
        // A tenth of all points are spikes, which would inflate the plain standard deviation.
        heights.iter_mut().step_by(10).for_each(|z| *z = 50e-6);
        heights[[5, 5]] = f64::NAN;
        let spikes = heights.iter().filter(|z| **z == 50e-6).count();
        let filtered = reject_outliers(&map(heights.clone()), 5.0).unwrap();
        assert_eq!(filtered.rejected, spikes);
        assert_eq!(filtered.map.missing_points(), spikes + 1);
        assert!(filtered.map.heights_m().iter().zip(&heights).all(|(a, b)| a.is_nan() || a == b));
    }

    #[test]
    fn the_scale_is_the_standard_deviation_of_normal_heights() {
        let filtered = reject_outliers(&map(rough(1)), 3.0).unwrap();
        // Efficiency 37 %: standard error σ/√(2·0.37·4096) = 1.8 %. Beyond 3 σ lie 0.27 % = 11 ± 3.3 points.
        assert!((filtered.scale_m / 1e-6 - 1.0).abs() < 4.0 * 0.018, "{}", filtered.scale_m);
        assert!((1..=27).contains(&filtered.rejected), "{}", filtered.rejected);
    }

    #[test]
    fn a_flat_map_with_one_spike_loses_only_the_spike() {
        let mut heights = Array2::zeros((64, 64));
        heights[[3, 4]] = 1.0;
        assert_eq!(reject_outliers(&map(heights), 5.0).unwrap().rejected, 1);
        assert_eq!(reject_outliers(&map(Array2::zeros((64, 64))), 5.0).unwrap().rejected, 0);
        assert!(reject_outliers(&map(rough(2)), 0.0).is_err());
        assert!(reject_outliers(&map(rough(2)), f64::NAN).is_err());
    }
}
