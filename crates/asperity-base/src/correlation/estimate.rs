//! Autocorrelation of maps with missing points.

use thiserror::Error;

use super::profiles::{self, Axis};
use crate::blocks;
use crate::fourier::{autocorrelation_sums, good_length};
use crate::map::{Grid, HeightMap};
use crate::stats::Extent;

/// Why a correlation or spectrum could not be estimated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EstimateError {
    /// The values present do not vary, so their correlation is undefined.
    #[error("the {present} values present are all equal; a correlation needs values that vary")]
    Constant {
        /// Values present.
        present: usize,
    },
    /// Too few values are present.
    #[error("{present} values are present, at least {wanted} are needed")]
    TooFew {
        /// Values present.
        present: usize,
        /// Values needed.
        wanted: usize,
    },
    /// Pitches of maps that differ, so that the maps have no common correlation.
    #[error(
        "map {map} has a pitch of {:e} × {:e} m, the first of {:e} × {:e} m: lags must be the same",
        .pitch_m.0, .pitch_m.1, .first_pitch_m.0, .first_pitch_m.1
    )]
    Pitch {
        /// Index of the map, from 0.
        map: usize,
        /// Pitch of the map along x and y in metre.
        pitch_m: (f64, f64),
        /// Pitch of the first map.
        first_pitch_m: (f64, f64),
    },
    /// No map to combine.
    #[error("no correlation to pool")]
    Nothing,
    /// The distance between values is not a positive finite number.
    #[error("the step is {step_m} m, but must be positive")]
    BadStep {
        /// Step passed to the function, in metre.
        step_m: f64,
    },
}

/// Largest relative difference of pitches that count as equal: over 10⁴ lags it adds up to a hundredth of a pixel.
const SAME_PITCH: f64 = 1e-6;

/// Estimate of the autocovariance of a map, normalised by the number of pairs: C(k, l) = Σ z(i, j) z(i + l, j + k)/N(k,
/// l) over the N pairs with both heights present, z without its mean.
///
/// The lags go up to a maximum along x and y, by default half the field: few pairs are left beyond, and the subtracted
/// mean dominates them. No height is interpolated, so missing points scattered at random cause no bias. Subtracting the
/// sample mean lowers every lag by about the variance of that mean; [`super::MeasuredCovariance`] corrects for it. The
/// estimate is not in general positive definite.
#[derive(Debug, Clone, PartialEq)]
pub struct Autocorrelation {
    grid: Grid,
    mean_m: f64,
    present: usize,
    /// Number of ordered pairs of heights about a common mean, each height with itself included.
    all_pairs: f64,
    reach_x: usize,
    reach_y: usize,
    /// Rows of the lags −reach_x … reach_x along x, for the lags 0 … reach_y along y.
    covariance_m2: Vec<f64>,
    /// In the same layout; `None` for a complete map, with (nx − |l|)(ny − |k|) pairs.
    pairs: Option<Vec<f64>>,
    /// Mean square of the two heights of a pair in the same layout, if requested.
    squares_m2: Option<Vec<f64>>,
}

impl Autocorrelation {
    /// Estimates the autocovariance of `map` at the lags up to half the field, [`Autocorrelation::half_field`].
    ///
    /// # Errors
    /// The heights present do not vary.
    pub fn estimate(map: &HeightMap) -> Result<Self, EstimateError> {
        let (reach_x, reach_y) = Self::half_field(map.grid());
        Self::within(map, reach_x, reach_y)
    }

    /// Returns half the number of points of a grid along x and y, rounded up: the largest lags of
    /// [`Autocorrelation::estimate`].
    pub fn half_field(grid: Grid) -> (usize, usize) {
        let half = |points: usize| points.div_ceil(2).min(points - 1);
        (half(grid.nx()), half(grid.ny()))
    }

    /// Estimates the autocovariance of `map` at lags up to `reach_x` and `reach_y` points, by transforms of the
    /// zero-padded heights and mask. The result is exact up to rounding; the cost grows with the lags.
    ///
    /// # Errors
    /// The heights present do not vary.
    ///
    /// # Panics
    /// If a lag is not less than the number of points of the map.
    pub fn within(map: &HeightMap, reach_x: usize, reach_y: usize) -> Result<Self, EstimateError> {
        Self::about(map, &Extent::new(map.values_m()), (reach_x, reach_y))
    }

    /// Estimates as [`Autocorrelation::within`] with a known extent of the heights.
    #[doc(hidden)]
    pub fn about(map: &HeightMap, extent: &Extent, reach: (usize, usize)) -> Result<Self, EstimateError> {
        let grid = map.grid();
        let ((ny, nx), (reach_x, reach_y)) = (grid.shape(), reach);
        let (present, mean_m) = (extent.n, extent.mean);
        if extent.largest_deviation() <= 4.0 * f64::EPSILON * mean_m.abs() {
            return Err(EstimateError::Constant { present });
        }
        let heights = |row: usize| &map.values_m()[row * nx..(row + 1) * nx];
        let mut covariance = autocorrelation_sums((ny, nx), reach, |row, out| {
            out.iter_mut().zip(heights(row)).for_each(|(out, z)| *out = if z.is_nan() { 0.0 } else { z - mean_m });
        });
        let pairs = (present < grid.points()).then(|| {
            autocorrelation_sums((ny, nx), reach, |row, out| {
                out.iter_mut().zip(heights(row)).for_each(|(out, z)| *out = if z.is_nan() { 0.0 } else { 1.0 });
            })
        });
        let width = 2 * reach_x + 1;
        let pairs = pairs.map(|mut pairs| {
            blocks::for_each(pairs.chunks_mut(width), |row| row.iter_mut().for_each(|count| *count = count.round()));
            pairs
        });
        blocks::for_each(covariance.chunks_exact_mut(width).enumerate(), |(lag_y, row)| match &pairs {
            Some(pairs) => {
                for (value, count) in row.iter_mut().zip(&pairs[lag_y * width..]) {
                    *value = if *count > 0.0 { *value / count } else { f64::NAN };
                }
            }
            None => {
                for (value, lag_x) in row.iter_mut().zip(-(reach_x as isize)..) {
                    *value /= complete_pairs(grid, lag_x, lag_y as isize);
                }
            }
        });
        let all_pairs = (present as f64).powi(2);
        let covariance_m2 = covariance;
        Ok(Self { grid, mean_m, present, all_pairs, reach_x, reach_y, covariance_m2, pairs, squares_m2: None })
    }

    /// Returns the estimate with the [semivariance](Autocorrelation::semivariance_m2), computed from the same map.
    ///
    /// # Panics
    /// If the map is smaller than the largest lags.
    #[must_use]
    pub fn and_semivariance(self, map: &HeightMap) -> Self {
        let ((ny, nx), mean_m, variance_m2) = (map.grid().shape(), self.mean_m, self.variance_m2());
        let reach = (self.reach_x, self.reach_y);
        // With the mask m and the squares s, (m + s) ⋆ (m + s) − (m − s) ⋆ (m − s) is four times the sum over the
        // pairs.
        let sums = |sign: f64| {
            autocorrelation_sums((ny, nx), reach, |row, out| {
                let heights = &map.values_m()[row * nx..(row + 1) * nx];
                for (out, z) in out.iter_mut().zip(heights) {
                    *out = if z.is_nan() { 0.0 } else { 1.0 + sign * (z - mean_m).powi(2) / variance_m2 };
                }
            })
        };
        let (mut squares, differences) = (sums(1.0), sums(-1.0));
        let width = 2 * self.reach_x + 1;
        for (place, (sum, difference)) in squares.iter_mut().zip(differences).enumerate() {
            let pairs = self.pairs((place % width) as isize - self.reach_x as isize, (place / width) as isize);
            *sum = if pairs > 0.0 { 0.25 * variance_m2 * (*sum - difference) / pairs } else { f64::NAN };
        }
        Self { squares_m2: Some(squares), ..self }
    }

    /// Creates the autocovariance of several maps of one surface: at each lag the sum of the products over all pairs of
    /// all maps, divided by the number of pairs. The mean of each map is subtracted from it.
    ///
    /// The grid and the largest lags are the smallest of all maps, so that every map contributes to every lag. The bias
    /// due to the means is estimated from the smallest map.
    ///
    /// # Errors
    /// Pitches that differ by more than a millionth, or no map.
    pub fn pooled(estimates: &[&Self]) -> Result<Self, EstimateError> {
        let [first, rest @ ..] = estimates else { return Err(EstimateError::Nothing) };
        let mut grid = first.grid;
        let pitch_m = |grid: Grid| (grid.dx_m(), grid.dy_m());
        for (map, other) in (1..).zip(rest) {
            let (pitch_m, first_pitch_m) = (pitch_m(other.grid), pitch_m(first.grid));
            let same = |a: f64, b: f64| (a / b - 1.0).abs() <= SAME_PITCH;
            if !(same(pitch_m.0, first_pitch_m.0) && same(pitch_m.1, first_pitch_m.1)) {
                return Err(EstimateError::Pitch { map, pitch_m, first_pitch_m });
            }
            let (nx, ny) = (grid.nx().min(other.grid.nx()), grid.ny().min(other.grid.ny()));
            grid = Grid::new(nx, ny, grid.dx_m(), grid.dy_m()).unwrap_or(grid);
        }
        let least = |reach: &dyn Fn(&Self) -> usize| estimates.iter().map(|e| reach(e)).min().unwrap_or(0);
        let (reach_x, reach_y) = (least(&|e| e.reach_x), least(&|e| e.reach_y));
        let width = 2 * reach_x + 1;
        let mut pairs = vec![0.0; width * (reach_y + 1)];
        let mut covariance_m2 = pairs.clone();
        let mut squares_m2 = estimates.iter().all(|e| e.squares_m2.is_some()).then(|| pairs.clone());
        for estimate in estimates {
            for (place, (count, sum)) in pairs.iter_mut().zip(&mut covariance_m2).enumerate() {
                let (lag_x, lag_y) = ((place % width) as isize - reach_x as isize, (place / width) as isize);
                let own = estimate.pairs(lag_x, lag_y);
                if own > 0.0 {
                    *count += own;
                    *sum += own * estimate.covariance_m2(lag_x, lag_y);
                    if let (Some(squares), Some(given)) = (&mut squares_m2, &estimate.squares_m2) {
                        squares[place] += own * given[estimate.place(lag_x, lag_y)];
                    }
                }
            }
        }
        covariance_m2.iter_mut().zip(&pairs).for_each(|(sum, count)| *sum /= *count);
        if let Some(squares) = &mut squares_m2 {
            squares.iter_mut().zip(&pairs).for_each(|(sum, count)| *sum /= *count);
        }
        let present: usize = estimates.iter().map(|e| e.present).sum();
        let mean_m = estimates.iter().map(|e| e.present as f64 * e.mean_m).sum::<f64>() / present as f64;
        let all_pairs = estimates.iter().map(|e| e.all_pairs).sum();
        Ok(Self { grid, mean_m, present, all_pairs, reach_x, reach_y, covariance_m2, pairs: Some(pairs), squares_m2 })
    }

    /// Returns the grid of the map, or the smallest grid of several maps.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns the subtracted mean of the heights present, in metre.
    pub fn mean_m(&self) -> f64 {
        self.mean_m
    }

    /// Returns the number of heights present.
    pub fn present(&self) -> usize {
        self.present
    }

    /// Returns the number of ordered pairs of heights of the same map, each height with itself included.
    pub fn all_pairs(&self) -> f64 {
        self.all_pairs
    }

    /// Returns the largest lags along x and y in points.
    pub fn reach(&self) -> (usize, usize) {
        (self.reach_x, self.reach_y)
    }

    /// Returns the index of a lag, by the symmetry C(−k, −l) = C(k, l).
    fn place(&self, lag_x: isize, lag_y: isize) -> usize {
        let (lag_x, lag_y) = if lag_y < 0 { (-lag_x, -lag_y) } else { (lag_x, lag_y) };
        let (reach_x, reach_y) = (self.reach_x as isize, self.reach_y as isize);
        assert!(
            lag_y <= reach_y && lag_x.abs() <= reach_x,
            "lag ({lag_x}, {lag_y}) exceeds the reach of {reach_x} × {reach_y} points"
        );
        (lag_y * (2 * reach_x + 1) + lag_x + reach_x) as usize
    }

    /// Returns the covariance at a lag in points, in m²; NaN where no pair is present.
    ///
    /// # Panics
    /// If the lag exceeds the reach.
    pub fn covariance_m2(&self, lag_x: isize, lag_y: isize) -> f64 {
        self.covariance_m2[self.place(lag_x, lag_y)]
    }

    /// Returns the number of pairs of present heights at a lag in points.
    ///
    /// # Panics
    /// If the lag exceeds the reach.
    pub fn pairs(&self, lag_x: isize, lag_y: isize) -> f64 {
        let place = self.place(lag_x, lag_y);
        self.pairs.as_ref().map_or_else(|| complete_pairs(self.grid, lag_x, lag_y), |pairs| pairs[place])
    }

    /// Returns the semivariance γ(lag) = Σ (z(i, j) − z(i + l, j + k))²/2N over the N pairs at a lag, in m²; NaN where
    /// no pair is present, `None` without [`Autocorrelation::and_semivariance`].
    ///
    /// Near zero lag, C(0) − C(lag) differs from it by an edge term of the map and its missing regions, which has a
    /// kink at zero; γ is as smooth as the surface.
    ///
    /// # Panics
    /// If the lag exceeds the reach.
    ///
    /// # References
    /// Matheron, *Economic Geology* **58** (1963) 1246, <https://doi.org/10.2113/gsecongeo.58.8.1246>.
    pub fn semivariance_m2(&self, lag_x: isize, lag_y: isize) -> Option<f64> {
        let place = self.place(lag_x, lag_y);
        self.squares_m2.as_ref().map(|squares| squares[place] - self.covariance_m2[place])
    }

    /// Returns the correlation C(lag)/C(0); NaN where no pair is present.
    ///
    /// # Panics
    /// If the lag exceeds the reach.
    pub fn correlation(&self, lag_x: isize, lag_y: isize) -> f64 {
        self.covariance_m2(lag_x, lag_y) / self.variance_m2()
    }

    /// Returns the variance of the heights present, C(0), in m².
    pub fn variance_m2(&self) -> f64 {
        self.covariance_m2(0, 0)
    }

    /// Returns the correlation at the lags 0, 1, 2, … points along an axis, up to its reach.
    pub fn along(&self, axis: Axis) -> Vec<f64> {
        match axis {
            Axis::X => (0..=self.reach_x as isize).map(|lag| self.correlation(lag, 0)).collect(),
            Axis::Y => (0..=self.reach_y as isize).map(|lag| self.correlation(0, lag)).collect(),
        }
    }

    /// Returns the distance in metre at which the correlation along an axis first falls to `level`, linear between
    /// lags; `None` when it does not fall so far within the reach, by default half the field.
    pub fn decay_length_m(&self, axis: Axis, level: f64) -> Option<f64> {
        let pitch_m = match axis {
            Axis::X => self.grid.dx_m(),
            Axis::Y => self.grid.dy_m(),
        };
        first_crossing(&self.along(axis), level).map(|lags| lags * pitch_m)
    }

    /// Returns the distance in metre at which the correlation along an axis first falls to 1/e.
    pub fn correlation_length_m(&self, axis: Axis) -> Option<f64> {
        self.decay_length_m(axis, (-1.0_f64).exp())
    }
}

/// Returns the correlation of a map along an axis at all its lags 0, 1, … points, pair-normalised as in
/// [`Autocorrelation`]; NaN where no pair is present. Beyond half the field few pairs are left, and the subtracted mean
/// dominates them.
///
/// # Errors
/// The heights present do not vary.
pub fn axis_correlation(map: &HeightMap, axis: Axis) -> Result<Vec<f64>, EstimateError> {
    let extent = Extent::new(map.values_m());
    let mean_m = extent.mean;
    if extent.largest_deviation() <= 4.0 * f64::EPSILON * mean_m.abs() {
        return Err(EstimateError::Constant { present: extent.n });
    }
    let (_, points, _) = profiles::dimensions(map, axis);
    let padded = good_length(2 * points);
    let sums = profiles::lag_sums(map, axis, padded, |z| if z.is_nan() { 0.0 } else { z - mean_m });
    let pairs = profiles::lag_sums(map, axis, padded, |z| if z.is_nan() { 0.0 } else { 1.0 });
    let covariance = |lag: usize| if pairs[lag] > 0.5 { sums[lag] / pairs[lag].round() } else { f64::NAN };
    Ok((0..points).map(|lag| covariance(lag) / covariance(0)).collect())
}

/// Returns the distance in metre at which the correlation of a map along an axis first falls to 1/e, linear between
/// lags, at any lag of the map; `None` when it does not.
///
/// Up to half the field it equals [`Autocorrelation::correlation_length_m`]. A larger value means that the field is too
/// small for the surface.
///
/// # Errors
/// The heights present do not vary.
pub fn axis_correlation_length_m(map: &HeightMap, axis: Axis) -> Result<Option<f64>, EstimateError> {
    let (_, _, pitch_m) = profiles::dimensions(map, axis);
    Ok(first_crossing(&axis_correlation(map, axis)?, (-1.0_f64).exp()).map(|lags| lags * pitch_m))
}

/// Returns the number of pairs of points of a complete map at a lag.
fn complete_pairs(grid: Grid, lag_x: isize, lag_y: isize) -> f64 {
    ((grid.nx() - lag_x.unsigned_abs()) * (grid.ny() - lag_y.unsigned_abs())) as f64
}

/// Returns the first crossing of `level` by a sequence that starts above it, in steps, interpolated linearly; `None` if
/// an undefined value comes first.
pub(super) fn first_crossing(values: &[f64], level: f64) -> Option<f64> {
    let after = values.iter().position(|value| value.is_nan() || *value <= level)?;
    if after == 0 || values[after].is_nan() {
        return None;
    }
    let (above, below) = (values[after - 1], values[after]);
    Some((after - 1) as f64 + (above - level) / (above - below))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use ndarray::Array2;
    use rand::RngExt;

    /// Returns a white map with a fraction of its heights missing.
    fn masked(nx: usize, ny: usize, missing: f64, seed: u64) -> HeightMap {
        let mut stream = random::stream(seed, "mask", 0);
        let heights = random::standard_normal(&mut stream, nx * ny);
        let values =
            heights.into_iter().map(|z| if stream.random::<f64>() < missing { f64::NAN } else { 5.0 + z }).collect();
        HeightMap::new(Grid::new(nx, ny, 0.5, 2.0).unwrap(), Array2::from_shape_vec((ny, nx), values).unwrap()).unwrap()
    }

    #[test]
    fn the_estimate_is_the_direct_sum_over_present_pairs() {
        for (nx, ny, missing) in [(9, 7, 0.25), (12, 5, 0.25), (2, 11, 0.25), (9, 7, 0.0), (12, 5, 0.0)] {
            let map = masked(nx, ny, missing, (nx + ny) as u64);
            let found = Autocorrelation::within(&map, nx - 1, ny - 1).unwrap().and_semivariance(&map);
            let half = Autocorrelation::estimate(&map).unwrap();
            let z = map.heights_m();
            let mean = map.present_m().sum::<f64>() / map.present_m().count() as f64;
            for lag_y in -(ny as isize - 1)..ny as isize {
                for lag_x in -(nx as isize - 1)..nx as isize {
                    let (mut sum, mut halved, mut count) = (0.0, 0.0, 0.0);
                    for row in 0..ny as isize {
                        for column in 0..nx as isize {
                            let (r, c) = (row + lag_y, column + lag_x);
                            if r < 0 || c < 0 || r >= ny as isize || c >= nx as isize {
                                continue;
                            }
                            let (a, b) = (z[[row as usize, column as usize]], z[[r as usize, c as usize]]);
                            let product = (a - mean) * (b - mean);
                            if !product.is_nan() {
                                sum += product;
                                halved += 0.5 * (a - b).powi(2);
                                count += 1.0;
                            }
                        }
                    }
                    assert_eq!(found.pairs(lag_x, lag_y), count);
                    let value = found.covariance_m2(lag_x, lag_y);
                    assert!((value - sum / count).abs() < 1e-12 || (count == 0.0 && value.is_nan()));
                    let semivariance = found.semivariance_m2(lag_x, lag_y).unwrap();
                    assert!((semivariance - halved / count).abs() < 1e-12 || (count == 0.0 && semivariance.is_nan()));
                    assert_eq!(half.semivariance_m2(0, 0), None);
                    let (reach_x, reach_y) = half.reach();
                    if lag_x.unsigned_abs() <= reach_x && lag_y.unsigned_abs() <= reach_y {
                        assert_eq!(half.pairs(lag_x, lag_y), count);
                        assert!((half.covariance_m2(lag_x, lag_y) - sum / count).abs() < 1e-12 || count == 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn pooled_maps_have_the_pairs_of_all() {
        let maps = [masked(12, 9, 0.2, 1), masked(9, 14, 0.0, 2), masked(10, 10, 0.4, 3)];
        let single = maps.each_ref().map(|map| Autocorrelation::estimate(map).unwrap().and_semivariance(map));
        let pooled = Autocorrelation::pooled(&single.each_ref()).unwrap();
        assert_eq!((pooled.grid().shape(), pooled.reach()), ((9, 9), (5, 5)));
        let means = maps.each_ref().map(|map| map.present_m().sum::<f64>() / map.present_m().count() as f64);
        for (lag_x, lag_y) in [(0, 0), (1, 0), (-3, 2), (5, 5), (-5, 1), (0, 4)] {
            let (mut sum, mut halved, mut count) = (0.0, 0.0, 0.0);
            for (map, mean) in maps.iter().zip(means) {
                for ((row, column), z) in map.heights_m().indexed_iter() {
                    let (r, c) = (row + lag_y, column.wrapping_add_signed(lag_x));
                    let other = map.heights_m().get([r, c]).copied().unwrap_or(f64::NAN);
                    let product = (z - mean) * (other - mean);
                    if !product.is_nan() {
                        sum += product;
                        halved += 0.5 * (z - other).powi(2);
                        count += 1.0;
                    }
                }
            }
            let semivariance = pooled.semivariance_m2(lag_x, lag_y as isize).unwrap();
            assert!((semivariance - halved / count).abs() < 1e-12, "({lag_x}, {lag_y})");
            assert_eq!(pooled.pairs(lag_x, lag_y as isize), count);
            assert!((pooled.covariance_m2(lag_x, lag_y as isize) - sum / count).abs() < 1e-12, "({lag_x}, {lag_y})");
        }
        assert_eq!(pooled.present(), maps.iter().map(|map| map.present_m().count()).sum::<usize>());
        // Two copies of a map give the estimate of one.
        let twice = Autocorrelation::pooled(&[&single[0], &single[0]]).unwrap();
        assert!((twice.correlation(2, -1) - single[0].correlation(2, -1)).abs() < 1e-14);
    }

    #[test]
    fn maps_of_different_pitch_are_not_pooled() {
        let map = masked(9, 9, 0.0, 1);
        let other = HeightMap::new(Grid::new(9, 9, 0.5, 2.001).unwrap(), map.heights_m().clone()).unwrap();
        let [map, other] = [map, other].map(|map| Autocorrelation::estimate(&map).unwrap());
        let error = Autocorrelation::pooled(&[&map, &map, &other]).unwrap_err();
        assert!(matches!(error, EstimateError::Pitch { map: 2, pitch_m: (0.5, 2.001), .. }), "{error}");
        assert_eq!(Autocorrelation::pooled(&[]), Err(EstimateError::Nothing));
    }

    #[test]
    fn the_correlation_along_an_axis_equals_the_two_dimensional_one() {
        for missing in [0.0, 0.3] {
            let map = masked(13, 9, missing, 3);
            let found = Autocorrelation::within(&map, 12, 8).unwrap();
            for axis in [Axis::X, Axis::Y] {
                let (fast, slow) = (axis_correlation(&map, axis).unwrap(), found.along(axis));
                assert_eq!(fast.len(), slow.len());
                assert!(fast.iter().zip(&slow).all(|(a, b)| (a - b).abs() < 1e-12 || (a.is_nan() && b.is_nan())));
            }
        }
    }

    #[test]
    fn a_cosine_crosses_one_over_e_at_its_arccosine() {
        // Over whole periods the pair-normalised estimate of a cosine tends to cos(q·lag); crossing at acos(1/e)/q.
        let grid = Grid::new(512, 4, 0.1, 1.0).unwrap();
        let q = std::f64::consts::TAU * 16.0 / grid.width_m();
        let map = HeightMap::from_function(grid, |x, _| 3.0 + (q * x).cos()).unwrap();
        let found = Autocorrelation::estimate(&map).unwrap();
        let wanted = (-1.0_f64).exp().acos() / q;
        // Linear interpolation between lags Δ errs by at most (qΔ)²/8 in height, over a slope of about q.
        let bound = (q * 0.1).powi(2) / 8.0 / q + 0.01 * wanted;
        assert!((found.correlation_length_m(Axis::X).unwrap() - wanted).abs() < bound);
        assert_eq!(found.correlation_length_m(Axis::Y), None, "the map does not vary along y");
    }

    #[test]
    fn missing_points_leave_the_correlation_of_the_rest() {
        // A directional texture with a missing region keeps its direction of correlation.
        let grid = Grid::new(64, 64, 1.0, 1.0).unwrap();
        let profile = random::standard_normal(&mut random::stream(4, "lay", 0), 64);
        let map = HeightMap::from_function(grid, |x, y| {
            if (x - 20.0).hypot(y - 40.0) < 12.0 { f64::NAN } else { profile[x as usize] }
        })
        .unwrap();
        let found = Autocorrelation::estimate(&map).unwrap();
        assert!(found.along(Axis::Y)[1..32].iter().all(|rho| *rho > 0.85), "constant along y");
        assert!(found.along(Axis::X)[1].abs() < 0.5);
    }

    #[test]
    fn a_flat_map_has_no_correlation() {
        let map = HeightMap::from_function(Grid::new(4, 4, 1.0, 1.0).unwrap(), |_, _| 0.1).unwrap();
        assert_eq!(Autocorrelation::estimate(&map), Err(EstimateError::Constant { present: 16 }));
    }

    #[test]
    fn crossings_are_interpolated_and_absent_when_not_reached() {
        assert_eq!(first_crossing(&[1.0, 0.6, 0.2], 0.5), Some(1.25));
        assert_eq!(first_crossing(&[1.0, 0.6], 0.5), None);
        assert_eq!(first_crossing(&[1.0, f64::NAN, 0.1], 0.5), None);
    }

    /// Returns the residuals of the heights about their least-squares plane.
    fn levelled(map: &HeightMap) -> HeightMap {
        let (ny, nx) = map.grid().shape();
        let basis = |row: usize, column: usize| [1.0, column as f64 / nx as f64 - 0.5, row as f64 / ny as f64 - 0.5];
        let (mut normal, mut right) = (vec![vec![0.0; 3]; 3], vec![0.0; 3]);
        for ((row, column), z) in map.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan()) {
            let b = basis(row, column);
            for i in 0..3 {
                right[i] += b[i] * z;
                for j in 0..3 {
                    normal[i][j] += b[i] * b[j];
                }
            }
        }
        let plane = crate::numeric::solution(normal, &right);
        let mut heights = map.heights_m().clone();
        for ((row, column), z) in heights.indexed_iter_mut() {
            *z -= basis(row, column).iter().enumerate().map(|(i, b)| b * plane[i]).sum::<f64>();
        }
        HeightMap::new(map.grid(), heights).unwrap()
    }

    #[test]
    fn correlation_lengths_of_measured_maps_agree_with_independent_ones_when_the_reference_folder_is_named() {
        let Ok(folder) = std::env::var("ASPERITY_REFERENCE") else {
            println!("skipped: ASPERITY_REFERENCE names no folder");
            return;
        };
        let folder = std::path::Path::new(&folder).join("surfaces");
        let text = std::fs::read_to_string(folder.join("reference.json")).unwrap();
        let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
        let mut compared = 0;
        for name in ["st_x3p-2.x3p", "st_sur-2.sur", "x3ptools_sample-land.x3p"] {
            let Ok(scan) = asperity_formats::read(&folder.join(name)) else { continue };
            let map = levelled(&HeightMap::try_from(scan).unwrap());
            let found = Autocorrelation::estimate(&map).unwrap();
            for (axis, key) in [(Axis::X, "corrlen_x_1/e_m"), (Axis::Y, "corrlen_y_1/e_m")] {
                let wanted = reference[name]["own_numpy_after_LS_plane"][key].as_f64();
                let length = axis_correlation_length_m(&map, axis).unwrap();
                println!("{name} {axis}: {length:?}, reference {wanted:?}");
                let within = found.correlation_length_m(axis);
                assert!(within.is_none() || (within.unwrap() / length.unwrap() - 1.0).abs() < 1e-9);
                if let (Some(length), Some(wanted)) = (length, wanted) {
                    assert!(
                        (length / wanted - 1.0).abs() < 1e-6,
                        "{name} along {axis}: {length:e}, reference {wanted:e}"
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared >= 4);
    }
}
