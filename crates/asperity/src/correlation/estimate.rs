//! Autocorrelation of maps with missing points.

use ndarray::Array2;
use thiserror::Error;

use crate::fourier::{RealFft2, good_length};
use crate::map::{Grid, HeightMap};

/// Why a correlation or spectrum could not be estimated.
#[derive(Debug, Clone, PartialEq, Error)]
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
    /// The distance between values is not a positive finite number.
    #[error("the step is {step_m} m, but must be positive")]
    BadStep {
        /// Step found in metre.
        step_m: f64,
    },
    /// Every profile along the axis has missing points.
    #[error("all {profiles} profiles along {axis} have missing points; none is left for a spectrum")]
    NoCompleteProfile {
        /// Axis of the profiles.
        axis: Axis,
        /// Number of profiles.
        profiles: usize,
    },
}

/// A direction of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Along rows.
    X,
    /// Along columns.
    Y,
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
        })
    }
}

/// Autocovariance of a map over all lags, normalised by the number of pairs:
/// C(k, l) = Σ z(i, j) z(i + l, j + k) / N(k, l) over the N pairs whose both heights are present, z without its mean.
///
/// No height is filled in, so scattered missing points bias nothing. Removing the sample mean lowers every lag by about
/// the variance of that mean; [`super::fit_covariance`] accounts for it. Lags close to the size of the map rest on few
/// pairs: N says how many. Away from zero the estimate is not positive definite by construction.
#[derive(Debug, Clone, PartialEq)]
pub struct Autocorrelation {
    grid: Grid,
    mean_m: f64,
    present: usize,
    /// Rows are lags 0 … ny − 1 along y, columns −(nx − 1) … nx − 1 along x.
    covariance_m2: Array2<f64>,
    pairs: Array2<f64>,
}

impl Autocorrelation {
    /// Estimates the autocovariance of `map` by zero-padded transforms of heights and mask.
    ///
    /// # Errors
    /// The heights present do not vary.
    pub fn estimate(map: &HeightMap) -> Result<Self, EstimateError> {
        let grid = map.grid();
        let (ny, nx) = grid.shape();
        let present = grid.points() - map.missing_points();
        let mean_m = map.present_m().sum::<f64>() / present as f64;
        let range = map.present_m().fold(0.0_f64, |m, z| m.max((z - mean_m).abs()));
        if range <= 4.0 * f64::EPSILON * mean_m.abs() {
            return Err(EstimateError::Constant { present });
        }
        let centred: Vec<f64> = map.heights_m().iter().map(|z| if z.is_nan() { 0.0 } else { z - mean_m }).collect();
        let mask: Vec<f64> = map.heights_m().iter().map(|z| f64::from(u8::from(!z.is_nan()))).collect();

        let fft = RealFft2::new(good_length(2 * nx - 1), good_length(2 * ny - 1));
        let mut work = fft.workspace();
        let mut correlate = |values: &[f64]| {
            let mut spectrum = fft.spectrum();
            fft.forward_padded(values, ny, nx, &mut spectrum, &mut work);
            for value in &mut spectrum {
                *value = (value.norm_sqr()).into();
            }
            let mut sums = vec![0.0; fft.nx() * fft.ny()];
            fft.inverse(&mut spectrum, &mut sums, &mut work);
            sums
        };
        let (sums, counts) = (correlate(&centred), correlate(&mask));
        let at = |row: usize, column: usize| {
            let lag_x = column as isize - (nx as isize - 1);
            row * fft.nx() + lag_x.rem_euclid(fft.nx() as isize) as usize
        };
        let pairs = Array2::from_shape_fn((ny, 2 * nx - 1), |(row, column)| counts[at(row, column)].round());
        let covariance_m2 = Array2::from_shape_fn(pairs.dim(), |(row, column)| match pairs[[row, column]] {
            count if count > 0.0 => sums[at(row, column)] / count,
            _ => f64::NAN,
        });
        Ok(Self { grid, mean_m, present, covariance_m2, pairs })
    }

    /// Grid of the map.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Mean of the heights present, which was removed, in metre.
    pub fn mean_m(&self) -> f64 {
        self.mean_m
    }

    /// Number of heights present.
    pub fn present(&self) -> usize {
        self.present
    }

    /// Place of a lag, by the symmetry C(−k, −l) = C(k, l).
    fn place(&self, lag_x: isize, lag_y: isize) -> (usize, usize) {
        let (lag_x, lag_y) = if lag_y < 0 { (-lag_x, -lag_y) } else { (lag_x, lag_y) };
        let (nx, ny) = (self.grid.nx() as isize, self.grid.ny() as isize);
        assert!(lag_y < ny && lag_x.abs() < nx, "lag ({lag_x}, {lag_y}) exceeds the map of {nx} × {ny}");
        (lag_y as usize, (lag_x + nx - 1) as usize)
    }

    /// Covariance at a lag in points, in m²; NaN where no pair is present.
    ///
    /// # Panics
    /// If the lag exceeds the map.
    pub fn covariance_m2(&self, lag_x: isize, lag_y: isize) -> f64 {
        self.covariance_m2[self.place(lag_x, lag_y)]
    }

    /// Number of pairs of present heights at a lag in points.
    ///
    /// # Panics
    /// If the lag exceeds the map.
    pub fn pairs(&self, lag_x: isize, lag_y: isize) -> f64 {
        self.pairs[self.place(lag_x, lag_y)]
    }

    /// Correlation C(lag)/C(0); NaN where no pair is present.
    ///
    /// # Panics
    /// If the lag exceeds the map.
    pub fn correlation(&self, lag_x: isize, lag_y: isize) -> f64 {
        self.covariance_m2(lag_x, lag_y) / self.variance_m2()
    }

    /// Variance of the heights present, C(0), in m².
    pub fn variance_m2(&self) -> f64 {
        self.covariance_m2(0, 0)
    }

    /// Correlation at the lags 0, 1, 2, … points along an axis.
    pub fn along(&self, axis: Axis) -> Vec<f64> {
        match axis {
            Axis::X => (0..self.grid.nx() as isize).map(|lag| self.correlation(lag, 0)).collect(),
            Axis::Y => (0..self.grid.ny() as isize).map(|lag| self.correlation(0, lag)).collect(),
        }
    }

    /// Distance in metre at which the correlation along an axis first falls to `level`, linear between lags; `None` when
    /// it does not fall so far within the map.
    pub fn decay_length_m(&self, axis: Axis, level: f64) -> Option<f64> {
        let pitch_m = match axis {
            Axis::X => self.grid.dx_m(),
            Axis::Y => self.grid.dy_m(),
        };
        first_crossing(&self.along(axis), level).map(|lags| lags * pitch_m)
    }

    /// Distance in metre at which the correlation along an axis first falls to 1/e.
    pub fn correlation_length_m(&self, axis: Axis) -> Option<f64> {
        self.decay_length_m(axis, (-1.0_f64).exp())
    }
}

/// Where a sequence that starts above `level` first reaches it, in steps, linear between values. Undefined values end it.
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
    use rand::RngExt;

    /// A white map with every fourth or so height missing.
    fn masked(nx: usize, ny: usize, seed: u64) -> HeightMap {
        let mut stream = random::stream(seed, "mask", 0);
        let heights = random::standard_normal(&mut stream, nx * ny);
        let values =
            heights.into_iter().map(|z| if stream.random::<f64>() < 0.25 { f64::NAN } else { 5.0 + z }).collect();
        HeightMap::new(Grid::new(nx, ny, 0.5, 2.0).unwrap(), Array2::from_shape_vec((ny, nx), values).unwrap()).unwrap()
    }

    #[test]
    fn the_estimate_is_the_direct_sum_over_present_pairs() {
        for (nx, ny) in [(9, 7), (12, 5), (2, 11)] {
            let map = masked(nx, ny, (nx + ny) as u64);
            let found = Autocorrelation::estimate(&map).unwrap();
            let z = map.heights_m();
            let mean = map.present_m().sum::<f64>() / map.present_m().count() as f64;
            for lag_y in -(ny as isize - 1)..ny as isize {
                for lag_x in -(nx as isize - 1)..nx as isize {
                    let (mut sum, mut count) = (0.0, 0.0);
                    for row in 0..ny as isize {
                        for column in 0..nx as isize {
                            let (r, c) = (row + lag_y, column + lag_x);
                            if r < 0 || c < 0 || r >= ny as isize || c >= nx as isize {
                                continue;
                            }
                            let product =
                                (z[[row as usize, column as usize]] - mean) * (z[[r as usize, c as usize]] - mean);
                            if !product.is_nan() {
                                sum += product;
                                count += 1.0;
                            }
                        }
                    }
                    assert_eq!(found.pairs(lag_x, lag_y), count);
                    let value = found.covariance_m2(lag_x, lag_y);
                    assert!((value - sum / count).abs() < 1e-12 || (count == 0.0 && value.is_nan()));
                }
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
        // A lay of scratches with a hole: the direction of correlation stays.
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
}
