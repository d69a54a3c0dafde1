//! Areal Gaussian filters of ISO 16610-61 and robust ones of ISO 16610-71, on maps with missing points.

use ndarray::Array2;

use super::{ALPHA, FilterError};
use asperity_base::blocks;
use asperity_base::fourier::{Complex64, RealFft2, Workspace, good_length};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::stats::upper_median;

/// Reach of the weights over the cutoff; beyond, weights are below 1e−13 of the central one.
const REACH: f64 = 1.45;
/// Biweight scale over the median absolute residual, 3/Φ⁻¹(¾).
const BIWEIGHT: f64 = 4.447_806_655_516_806;
/// Relative change of the scale below which the robust iteration ends.
const SETTLED: f64 = 1e-4;
/// Largest number of robust iterations.
const MAX_ITERATIONS: usize = 100;
/// Least sum of weights, over the sum of a full window, for which a height is computed.
const LEAST_WEIGHT: f64 = 1e-8;

/// Number of points in one unit of work of a thread.
const POINTS_AT_ONCE: usize = 1 << 12;

/// Function that is fitted under the weights around each point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regression {
    /// A constant: the weighted mean of the present heights, ISO 16610-61 with its weights normalised at edges and
    /// voids.
    Constant,
    /// A quadratic polynomial: forms up to degree two pass unchanged, also at edges.
    Quadratic,
}

/// Gaussian filter: the weight of a height at the distance (x, y) is exp(−π(x² + y²)/(α λ)²), α = √(ln 2/π), cutoff λ.
///
/// # References
/// ISO 16610-61:2015; ISO 16610-71:2014; Seewig, *J. Phys.: Conf. Ser.* **13** (2005) 254,
/// <https://doi.org/10.1088/1742-6596/13/1/059>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianFilter {
    /// Cutoff (nesting index) λ in metre: the wavelength with a transmission of one half.
    pub cutoff_m: f64,
    /// Function that is fitted under the weights.
    pub regression: Regression,
    /// Whether heights far from the smooth surface lose their weight, iteratively by Tukey's biweight.
    pub robust: bool,
}

/// The large scales of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// The smooth surface, missing where the map is missing and at `lost` further points.
    pub map: HeightMap,
    /// Number of points around which no height kept a weight; 0 without robust weights.
    pub lost: usize,
    /// Number of robust iterations; 0 without robust weights.
    pub iterations: usize,
}

impl GaussianFilter {
    /// Creates the plain filter of ISO 16610-61.
    pub fn linear(cutoff_m: f64) -> Self {
        Self { cutoff_m, regression: Regression::Constant, robust: false }
    }

    /// Creates the robust quadratic regression of ISO 16610-71, on which grooves and spikes have no influence.
    pub fn robust(cutoff_m: f64) -> Self {
        Self { cutoff_m, regression: Regression::Quadratic, robust: true }
    }

    /// Returns the transmission of the plain filter for a wave with this number of periods per metre, exp(−π(αλf)²) =
    /// 2^−(λf)².
    pub fn transmission(&self, frequency_per_m: f64) -> f64 {
        (-std::f64::consts::PI * (ALPHA * self.cutoff_m * frequency_per_m).powi(2)).exp()
    }

    /// Checks that maps of this grid can be filtered.
    ///
    /// # Errors
    /// [`FilterError::Cutoff`] for a cutoff below a pixel or above the field.
    pub fn check(&self, grid: Grid) -> Result<(), FilterError> {
        let (low_m, high_m) = (grid.dx_m().max(grid.dy_m()), grid.width_m().min(grid.height_m()));
        if (low_m..=high_m).contains(&self.cutoff_m) {
            Ok(())
        } else {
            Err(FilterError::Cutoff { found_m: self.cutoff_m, low_m, high_m })
        }
    }

    /// Returns the large scales, the output of an S-filter. Only present heights have weights; missing heights are not
    /// filled.
    ///
    /// # Errors
    /// [`FilterError::Cutoff`] for a cutoff below a pixel or above the field; [`FilterError::NotConverged`].
    pub fn smooth(&self, map: &HeightMap) -> Result<Smoothed, FilterError> {
        let grid = map.grid();
        self.check(grid)?;
        let mean_m = map.present_m().sum::<f64>() / (grid.points() - map.missing_points()) as f64;
        let present = |z: f64| f64::from(u8::from(!z.is_nan()));
        let height = |z: f64| if z.is_nan() { 0.0 } else { z - mean_m };
        let mut windows = Windows::new(grid, self.cutoff_m);
        let (mut smooth, iterations) = if self.robust {
            let heights: Vec<f64> = map.heights_m().iter().copied().map(height).collect();
            let present: Vec<f64> = map.heights_m().iter().copied().map(present).collect();
            let mut search = Search { heights: &heights, present: &present, weights: present.clone(), iterations: 0 };
            // Beside an outlier at an edge a quadratic overshoots and downweights valid heights. A mean does not.
            search.settle(&mut windows, Regression::Constant)?;
            (search.settle(&mut windows, self.regression)?, search.iterations)
        } else {
            let values = map.values_m();
            // Missing heights are 0, as their weights are.
            (windows.regress(|point| height(values[point]), |point| present(values[point]), self.regression), 0)
        };
        for (w, z) in smooth.iter_mut().zip(map.heights_m()) {
            *w = if z.is_nan() { f64::NAN } else { *w + mean_m };
        }
        let smooth = HeightMap::new(grid, array(grid, smooth))?;
        let lost = smooth.missing_points() - map.missing_points();
        Ok(Smoothed { map: smooth, lost, iterations })
    }

    /// Returns the small scales, the map minus [`GaussianFilter::smooth`]: the output of an L-filter.
    ///
    /// # Errors
    /// The errors of [`GaussianFilter::smooth`].
    pub fn roughness(&self, map: &HeightMap) -> Result<Smoothed, FilterError> {
        let Smoothed { map: smooth, lost, iterations } = self.smooth(map)?;
        let mut rough = smooth.into_heights_m();
        rough.zip_mut_with(map.heights_m(), |w, z| *w = z - *w);
        Ok(Smoothed { map: HeightMap::new(map.grid(), rough)?, lost, iterations })
    }
}

/// Iteration of the robust weights.
struct Search<'a> {
    heights: &'a [f64],
    /// 1 at present points, 0 at missing ones.
    present: &'a [f64],
    weights: Vec<f64>,
    iterations: usize,
}

impl Search<'_> {
    /// Alternates between Tukey's biweights and the smooth surface until the scale of the residuals converges.
    fn settle(&mut self, windows: &mut Windows, regression: Regression) -> Result<Vec<f64>, FilterError> {
        let mut smooth = self.regress(windows, regression);
        let mut scale = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let before = std::mem::replace(&mut scale, BIWEIGHT * median_distance(self.heights, &smooth, self.present));
            // With a scale of zero more than half of the heights are on the smooth surface.
            if scale == 0.0 || (before - scale).abs() <= SETTLED * scale {
                return Ok(smooth);
            }
            for (((weight, present), z), w) in self.weights.iter_mut().zip(self.present).zip(self.heights).zip(&smooth)
            {
                let distance = (z - w) / scale;
                // A point without a smooth height has no residual and gets no weight.
                *weight = if distance.abs() < 1.0 { present * (1.0 - distance * distance).powi(2) } else { 0.0 };
            }
            smooth = self.regress(windows, regression);
            self.iterations += 1;
        }
        Err(FilterError::NotConverged { iterations: self.iterations })
    }

    fn regress(&self, windows: &mut Windows, regression: Regression) -> Vec<f64> {
        windows.regress(|point| self.heights[point] * self.weights[point], |point| self.weights[point], regression)
    }
}

/// Returns the values of all points as an array, without a copy.
fn array(grid: Grid, values: Vec<f64>) -> Array2<f64> {
    Array2::from_shape_vec(grid.shape(), values).unwrap_or_default()
}

fn median_distance(heights: &[f64], smooth: &[f64], present: &[f64]) -> f64 {
    let distances = heights.iter().zip(smooth).zip(present);
    let mut distances: Vec<f64> =
        distances.filter(|((_, w), m)| **m > 0.0 && !w.is_nan()).map(|((z, w), _)| (z - w).abs()).collect();
    upper_median(&mut distances).unwrap_or(0.0)
}

/// Exponents (a, b) of the moments x^a y^b up to the fourth order; the first six form a quadratic.
const MOMENTS: [(usize, usize); 15] = [
    (0, 0),
    (1, 0),
    (0, 1),
    (2, 0),
    (1, 1),
    (0, 2),
    (3, 0),
    (2, 1),
    (1, 2),
    (0, 3),
    (4, 0),
    (3, 1),
    (2, 2),
    (1, 3),
    (0, 4),
];
/// Number of terms of a quadratic.
const TERMS: usize = 6;

/// Sums over the window around every point, by products of transforms on a grid padded by the reach of the window.
struct Windows {
    grid: Grid,
    fft: RealFft2,
    work: Workspace,
    /// Transforms of (−t)^a exp(−π t²/(αλ)²), t over the cutoff, a = 0 … 4; the weights add up to 1.
    along_x: Vec<Vec<Complex64>>,
    along_y: Vec<Vec<Complex64>>,
}

impl Windows {
    fn new(grid: Grid, cutoff_m: f64) -> Self {
        let reach = |pitch_m: f64| (REACH * cutoff_m / pitch_m).ceil() as usize;
        let (reach_x, reach_y) = (reach(grid.dx_m()), reach(grid.dy_m()));
        let fft = RealFft2::new(good_length(grid.nx() + reach_x), good_length(grid.ny() + reach_y));
        Self {
            grid,
            along_x: axis_windows(fft.nx(), reach_x, grid.dx_m() / cutoff_m),
            along_y: axis_windows(fft.ny(), reach_y, grid.dy_m() / cutoff_m),
            work: fft.workspace(),
            fft,
        }
    }

    /// Returns Σ f(x′) ((x′ − x)/λ)^a ((y′ − y)/λ)^b w(x′ − x) for the given moments.
    fn sums(&mut self, value: impl Fn(usize) -> f64 + Sync, moments: &[(usize, usize)]) -> Vec<Vec<f64>> {
        let (ny, nx) = self.grid.shape();
        let mut transform = self.fft.spectrum();
        let fill = |row: usize, out: &mut [f64]| (row * nx..).zip(out).for_each(|(point, out)| *out = value(point));
        // The rows of the forward transform are not kept.
        self.fft.forward_rows(ny, nx, fill, &mut transform, &mut self.fft.workspace());
        let rows = self.fft.ny();
        let last = moments.len() - 1;
        moments
            .iter()
            .enumerate()
            .map(|(place, &(a, b))| {
                // The last product may take the memory of the transform.
                let mut product = if place == last { std::mem::take(&mut transform) } else { transform.clone() };
                for (product, x) in product.chunks_exact_mut(rows).zip(&self.along_x[a]) {
                    for (value, y) in product.iter_mut().zip(&self.along_y[b]) {
                        *value = *value * x * y;
                    }
                }
                let mut sums = vec![0.0; nx * ny];
                self.fft.inverse_cropped(&mut product, &mut sums, ny, nx, &mut self.work);
                sums
            })
            .collect()
    }

    /// Returns the constant term of the weighted regression around every point; NaN if all weights are zero. `weighted` are the heights times
    /// their weights.
    fn regress(
        &mut self,
        weighted: impl Fn(usize) -> f64 + Sync,
        weight: impl Fn(usize) -> f64 + Sync,
        regression: Regression,
    ) -> Vec<f64> {
        let (of_weights, of_heights) = match regression {
            Regression::Constant => (1, 1),
            Regression::Quadratic => (MOMENTS.len(), TERMS),
        };
        let matrix = self.sums(weight, &MOMENTS[..of_weights]);
        let right = self.sums(weighted, &MOMENTS[..of_heights]);
        let value = |point: usize| {
            let sum = matrix[0][point];
            if sum < LEAST_WEIGHT {
                return f64::NAN;
            }
            let mean = right[0][point] / sum;
            match regression {
                Regression::Constant => mean,
                // With too few heights for a quadratic the result is the weighted mean.
                Regression::Quadratic => quadratic(&matrix, &right, point).unwrap_or(mean),
            }
        };
        let mut values = vec![0.0; self.grid.points()];
        blocks::for_each(values.chunks_mut(POINTS_AT_ONCE).enumerate(), |(chunk, values)| {
            (chunk * POINTS_AT_ONCE..).zip(values).for_each(|(point, out)| *out = value(point));
        });
        values
    }
}

/// Computes the transforms of the windows of one axis on `n` points.
fn axis_windows(n: usize, reach: usize, step: f64) -> Vec<Vec<Complex64>> {
    let weight = |t: f64| (-std::f64::consts::PI * (t / ALPHA).powi(2)).exp();
    let offsets = -(reach as isize)..=reach as isize;
    let total: f64 = offsets.clone().map(|i| weight(i as f64 * step)).sum();
    let line = RealFft2::new(n, 1);
    let (mut half, mut work) = (line.spectrum(), line.workspace());
    (0..5)
        .map(|power| {
            let mut window = vec![0.0; n];
            for offset in offsets.clone() {
                let t = offset as f64 * step;
                window[offset.rem_euclid(n as isize) as usize] += (-t).powi(power) * weight(t) / total;
            }
            line.forward(&window, &mut half, &mut work);
            (0..n).map(|k| if k < half.len() { half[k] } else { half[n - k].conj() }).collect()
        })
        .collect()
}

/// Returns the constant term of the weighted quadratic at a point by Cholesky factorisation; `None` if undetermined.
fn quadratic(matrix: &[Vec<f64>], right: &[Vec<f64>], point: usize) -> Option<f64> {
    /// Least pivot over its diagonal entry.
    const LEAST_PIVOT: f64 = 1e-7;
    let entry = |i: usize, j: usize| {
        let wanted = (MOMENTS[i].0 + MOMENTS[j].0, MOMENTS[i].1 + MOMENTS[j].1);
        MOMENTS.iter().position(|moment| *moment == wanted).map_or(f64::NAN, |k| matrix[k][point])
    };
    // The constant is the last unknown, so back substitution finds it first.
    let order = |i: usize| TERMS - 1 - i;
    let mut factor = [[0.0; TERMS]; TERMS];
    let mut reduced = [0.0; TERMS];
    for i in 0..TERMS {
        for j in 0..=i {
            let product: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = entry(order(i), order(j)) - product;
            if i == j {
                if rest.is_nan() || rest <= LEAST_PIVOT * entry(order(i), order(i)) {
                    return None;
                }
                factor[i][i] = rest.sqrt();
            } else {
                factor[i][j] = rest / factor[j][j];
            }
        }
        let product: f64 = (0..i).map(|k| factor[i][k] * reduced[k]).sum();
        reduced[i] = (right[order(i)][point] - product) / factor[i][i];
    }
    Some(reduced[TERMS - 1] / factor[TERMS - 1][TERMS - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;
    use std::f64::consts::{PI, TAU};

    fn rough(grid: Grid, index: u64) -> HeightMap {
        let values = random::standard_normal(&mut random::stream(12, "gaussian filter", index), grid.points());
        HeightMap::new(grid, array(grid, values)).unwrap()
    }

    fn with_holes(map: &HeightMap) -> HeightMap {
        let mut heights = map.heights_m().clone();
        heights
            .indexed_iter_mut()
            .filter(|((row, column), _)| (3 * row + 5 * column) % 7 < 2)
            .for_each(|(_, z)| *z = f64::NAN);
        HeightMap::new(map.grid(), heights).unwrap()
    }

    /// Computes the weighted regression around one point from its definition.
    fn at_point(map: &HeightMap, cutoff_m: f64, regression: Regression, row: usize, column: usize) -> f64 {
        let grid = map.grid();
        let terms = if regression == Regression::Constant { 1 } else { TERMS };
        let (mut gram, mut right) = (vec![0.0; terms * terms], vec![0.0; terms]);
        for ((r, c), z) in map.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan()) {
            let (x, y) = ((c as f64 - column as f64) * grid.dx_m(), (r as f64 - row as f64) * grid.dy_m());
            let weight = (-PI * (x * x + y * y) / (ALPHA * cutoff_m).powi(2)).exp();
            let basis = MOMENTS.map(|(a, b)| (x / cutoff_m).powi(a as i32) * (y / cutoff_m).powi(b as i32));
            for i in 0..terms {
                for j in 0..terms {
                    gram[i * terms + j] += weight * basis[i] * basis[j];
                }
                right[i] += weight * basis[i] * z;
            }
        }
        // Gauss–Jordan elimination with pivoting, independent of the code under test.
        for i in 0..terms {
            let pivot =
                (i..terms).max_by(|a, b| gram[a * terms + i].abs().total_cmp(&gram[b * terms + i].abs())).unwrap();
            right.swap(i, pivot);
            (0..terms).for_each(|j| gram.swap(i * terms + j, pivot * terms + j));
            for k in (0..terms).filter(|k| *k != i) {
                let factor = gram[k * terms + i] / gram[i * terms + i];
                (0..terms).for_each(|j| gram[k * terms + j] -= factor * gram[i * terms + j]);
                right[k] -= factor * right[i];
            }
        }
        right[0] / gram[0]
    }

    #[test]
    fn the_fast_sums_equal_the_weighted_regression_at_every_point() {
        let grid = Grid::new(21, 17, 1e-6, 1.5e-6).unwrap();
        for map in [rough(grid, 0), with_holes(&rough(grid, 1))] {
            for regression in [Regression::Constant, Regression::Quadratic] {
                let filter = GaussianFilter { cutoff_m: 8e-6, regression, robust: false };
                let smooth = filter.smooth(&map).unwrap();
                assert_eq!((smooth.lost, smooth.iterations), (0, 0));
                assert_eq!(smooth.map.missing_points(), map.missing_points());
                for ((row, column), z) in smooth.map.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan()) {
                    let wanted = at_point(&map, 8e-6, regression, row, column);
                    assert!((z - wanted).abs() < 1e-9, "{regression:?} at ({row}, {column}): {z}, not {wanted}");
                }
            }
        }
    }

    #[test]
    fn the_transmission_is_one_half_at_the_cutoff_and_gaussian_elsewhere() {
        let cutoff_m = 40e-6;
        let grid = Grid::new(400, 100, 1e-6, 1e-6).unwrap();
        for length_m in [40e-6, 80e-6, 25e-6] {
            let map = HeightMap::from_function(grid, |x, _| (TAU * x / length_m).cos()).unwrap();
            let smooth = GaussianFilter::linear(cutoff_m).smooth(&map).unwrap().map;
            let passed = (-PI * (ALPHA * cutoff_m / length_m).powi(2)).exp();
            for column in 100..300 {
                let (found, before) = (smooth.heights_m()[[50, column]], map.heights_m()[[50, column]]);
                assert!((found - passed * before).abs() < 1e-9, "{found}, not {passed} of {before}");
            }
            if length_m == cutoff_m {
                assert!((passed - 0.5).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn quadratic_forms_pass_the_quadratic_regression_to_the_edges_and_around_voids() {
        let grid = Grid::new(60, 50, 1e-6, 1e-6).unwrap();
        let form = |x: f64, y: f64| 1e-6 + 0.1 * x - 0.2 * y + 3e3 * x * x - 1e3 * x * y + 2e3 * y * y;
        let map = with_holes(&HeightMap::from_function(grid, form).unwrap());
        let filter = GaussianFilter { cutoff_m: 20e-6, regression: Regression::Quadratic, robust: false };
        let rest = filter.roughness(&map).unwrap().map;
        assert!(
            rest.present_m().all(|z| z.abs() < 1e-14),
            "{:e}",
            rest.present_m().fold(0.0, |m: f64, z| m.max(z.abs()))
        );
    }

    #[test]
    fn grooves_affect_the_linear_filter_but_not_the_robust_one() {
        let grid = Grid::new(200, 60, 1e-6, 1e-6).unwrap();
        let plateau = rough(grid, 2).heights_m() * 10e-9;
        let mut grooved = plateau.clone();
        // Grooves 2 µm deep and 6 µm wide every 50 µm.
        grooved.indexed_iter_mut().filter(|((_, column), _)| column % 50 < 6).for_each(|(_, z)| *z -= 2e-6);
        let map = HeightMap::new(grid, grooved).unwrap();
        let pulled = |filter: GaussianFilter| {
            let smooth = filter.smooth(&map).unwrap();
            assert_eq!(smooth.lost, 0);
            let on_plateau = smooth.map.heights_m().indexed_iter().filter(|((_, column), _)| column % 50 >= 6);
            on_plateau.map(|(_, z)| z.abs()).fold(0.0, f64::max)
        };
        let (linear, robust) = (pulled(GaussianFilter::linear(50e-6)), pulled(GaussianFilter::robust(50e-6)));
        // The mean of the map is 0.24 µm below the plateau. White noise of 10 nm is reduced by the root of some 500 to
        // 1,000 effective points of a window.
        assert!(linear > 0.2e-6, "{linear:e}");
        assert!(robust < 5e-9, "{robust:e}");
    }

    #[test]
    fn without_outliers_the_robust_filter_is_close_to_the_linear_regression() {
        let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
        let map = rough(grid, 3);
        let plain =
            GaussianFilter { cutoff_m: 16e-6, regression: Regression::Quadratic, robust: false }.smooth(&map).unwrap();
        let robust = GaussianFilter::robust(16e-6).smooth(&map).unwrap();
        assert!(robust.iterations > 1);
        let rms = |a: &HeightMap, b: &Array2<f64>| ((a.heights_m() - b).mapv(|d| d * d).mean().unwrap()).sqrt();
        let zero = Array2::zeros(grid.shape());
        // The biweight at c = 3 σ has the efficiency e = (E ψ′)²/E ψ² on normal heights. Its excess error is
        // uncorrelated with the least-squares estimate and √(1/e − 1) times the error of that estimate. A map contains
        // some 30 windows.
        let ratio = rms(&robust.map, plain.map.heights_m()) / rms(&plain.map, &zero);
        assert!((ratio / 0.5423 - 1.0).abs() < 0.3, "{ratio}");
    }

    #[test]
    fn invalid_cutoffs_are_refused() {
        let map = rough(Grid::new(20, 30, 1e-6, 2e-6).unwrap(), 4);
        for cutoff_m in [0.0, -1e-6, 1.9e-6, 20.1e-6, f64::NAN, f64::INFINITY] {
            let error = GaussianFilter::linear(cutoff_m).smooth(&map).unwrap_err();
            assert!(matches!(error, FilterError::Cutoff { .. }), "{cutoff_m}");
        }
        GaussianFilter::linear(2e-6).smooth(&map).unwrap();
    }
}
