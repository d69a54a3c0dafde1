//! Non-Gaussian surfaces by translation, z = F⁻¹(Φ(g)).

use ndarray::Array2;

use super::gaussian::map_of;
use super::{GaussianSurface, GeneratorError, RandomSurface};
use crate::correlation::StationaryCovariance;
use crate::law::{LawError, Marginal, translation::Translation};
use crate::map::{Grid, HeightMap};

/// Least pointwise variance, over the largest on the map, that may be scaled up to a full marginal.
const LEAST_SHARE: f64 = 1e-6;

/// A surface z(x) = F⁻¹(Φ(g(x)/σ_g(x))) whose heights have the law F at every point.
///
/// A truncated expansion has a pointwise variance below σ² that varies over the map. The Gaussian field is therefore
/// divided by its *own* standard deviation at each point: the marginal is F exactly, everywhere, and what truncation
/// leaves out shows in the correlation alone, which [`Translated::correlation_report`] measures.
///
/// *Plain* translation takes a Gaussian field with the wanted correlation; F⁻¹∘Φ then distorts it (towards zero). For the
/// *corrected* one, make the Gaussian field with [`Predistorted`].
///
/// # References
/// Grigoriu, *J. Eng. Mech.* **110** (1984) 610, <https://doi.org/10.1061/(ASCE)0733-9399(1984)110:4(610)>.
#[derive(Debug, Clone)]
pub struct Translated<S> {
    gaussian: S,
    law: Marginal,
    map: NormalToLaw,
    /// 1/σ_g at each point in row order.
    inverse_std_per_m: Vec<f64>,
    least_variance_share: f64,
}

/// How far the correlation of a translated surface lies from a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TranslationReport {
    /// Largest |ρ − target| over all lags of up to half the map from its centre.
    pub largest_deviation: f64,
    /// Lag along x of that deviation in metre.
    pub lag_x_m: f64,
    /// Lag along y of that deviation in metre.
    pub lag_y_m: f64,
    /// Root mean square deviation over these lags.
    pub rms_deviation: f64,
}

impl<S: GaussianSurface> Translated<S> {
    /// Heights of law `law`, in metre.
    ///
    /// # Errors
    /// A law with a parameter outside its range, or a field that hardly varies at some point.
    pub fn new(gaussian: S, law: Marginal) -> Result<Self, TranslationError> {
        Self::scaled(gaussian, law, 0.0, 1.0)
    }

    /// Heights of the law of shape `law`, shifted to mean zero and scaled to `rms_height_m`.
    ///
    /// # Errors
    /// As [`Translated::new`], and an rms height that is not positive.
    pub fn with_rms_height(gaussian: S, law: Marginal, rms_height_m: f64) -> Result<Self, TranslationError> {
        if !(rms_height_m > 0.0 && rms_height_m.is_finite()) {
            let parameter = "rms_height_m";
            return Err(GeneratorError::Parameter { parameter, value: rms_height_m, wanted: "positive" }.into());
        }
        law.check()?;
        let scale = rms_height_m / law.std();
        let offset = -scale * law.mean();
        Self::scaled(gaussian, law, offset, scale)
    }

    fn scaled(gaussian: S, law: Marginal, offset: f64, scale: f64) -> Result<Self, TranslationError> {
        law.check()?;
        let std = gaussian.pointwise_std_m();
        let largest = std.iter().fold(0.0_f64, |m, s| m.max(*s));
        let mut least_variance_share = 1.0_f64;
        for ((row, column), value) in std.indexed_iter() {
            let share = if largest > 0.0 { (value / largest).powi(2) } else { 0.0 };
            if share < LEAST_SHARE {
                return Err(GeneratorError::NoVariance { row, column, share }.into());
            }
            least_variance_share = least_variance_share.min(share);
        }
        let map = NormalToLaw::new(&law, offset, scale);
        let inverse_std_per_m = std.iter().map(|s| 1.0 / s).collect();
        Ok(Self { gaussian, law, map, inverse_std_per_m, least_variance_share })
    }

    /// The Gaussian field beneath.
    pub fn gaussian(&self) -> &S {
        &self.gaussian
    }

    /// The law of the heights before any shift and scale.
    pub fn law(&self) -> &Marginal {
        &self.law
    }

    /// Least pointwise variance of the Gaussian field over its largest; 1 for a stationary field.
    pub fn least_variance_share(&self) -> f64 {
        self.least_variance_share
    }

    /// Correlation of the translated heights with the one at (`row`, `column`), shape `[ny, nx]`; no sampling is involved.
    ///
    /// # Errors
    /// As [`Translated::new`].
    pub fn correlation_with(&self, row: usize, column: usize) -> Result<Array2<f64>, TranslationError> {
        let translation = Translation::new(&self.law)?;
        let mut correlation = self.gaussian.covariance_with_m2(row, column);
        let nx = self.gaussian.grid().nx();
        let here = self.inverse_std_per_m[row * nx + column];
        for (value, there) in correlation.iter_mut().zip(&self.inverse_std_per_m) {
            *value = translation.correlation((*value * here * there).clamp(-1.0, 1.0));
        }
        Ok(correlation)
    }

    /// Compares the correlation around the map's centre with that of `target`: what translation, its correction and the
    /// truncation of the field leave.
    ///
    /// # Errors
    /// As [`Translated::new`].
    pub fn correlation_report(&self, target: &dyn StationaryCovariance) -> Result<TranslationReport, TranslationError> {
        let grid = self.gaussian.grid();
        let (row, column) = (grid.ny() / 2, grid.nx() / 2);
        let met = self.correlation_with(row, column)?;
        let mut report = TranslationReport { largest_deviation: 0.0, lag_x_m: 0.0, lag_y_m: 0.0, rms_deviation: 0.0 };
        for ((r, c), value) in met.indexed_iter() {
            let lag_x = (c as f64 - column as f64) * grid.dx_m();
            let lag_y = (r as f64 - row as f64) * grid.dy_m();
            let deviation = (value - target.correlation(lag_x, lag_y)).abs();
            report.rms_deviation += deviation * deviation / grid.points() as f64;
            if deviation > report.largest_deviation {
                (report.largest_deviation, report.lag_x_m, report.lag_y_m) = (deviation, lag_x, lag_y);
            }
        }
        report.rms_deviation = report.rms_deviation.sqrt();
        Ok(report)
    }
}

impl<S: GaussianSurface> RandomSurface for Translated<S> {
    fn germ_len(&self) -> usize {
        self.gaussian.germ_len()
    }

    fn grid(&self) -> Grid {
        self.gaussian.grid()
    }

    fn generate(&self, germ: &[f64]) -> HeightMap {
        let map = self.gaussian.generate(germ);
        let heights =
            map.heights_m().iter().zip(&self.inverse_std_per_m).map(|(g, inverse)| self.map.value(g * inverse));
        map_of(self.gaussian.grid(), heights.collect())
    }
}

/// Why a surface could not be translated.
#[derive(Debug, thiserror::Error)]
pub enum TranslationError {
    /// The law is not valid.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The Gaussian field cannot carry it.
    #[error(transparent)]
    Generator(#[from] GeneratorError),
}

/// The Gaussian correlation that a translation turns into that of `target`: ρ_G = T⁻¹(ρ_X).
///
/// ρ_G may fail to be a correlation function; generators then clip what is negative, and
/// [`Translated::correlation_report`] says what is left. Targets below the least correlation of the law are raised to it.
#[derive(Debug, Clone)]
pub struct Predistorted<C> {
    target: C,
    translation: Translation,
    least: f64,
}

impl<C: StationaryCovariance> Predistorted<C> {
    /// The correlation to give to a Gaussian field for heights of law `law` with the covariance `target`.
    ///
    /// # Errors
    /// A law with a parameter outside its range.
    pub fn new(target: C, law: &Marginal) -> Result<Self, LawError> {
        let translation = Translation::new(law)?;
        let least = translation.least_correlation();
        Ok(Self { target, translation, least })
    }
}

impl<C: StationaryCovariance> StationaryCovariance for Predistorted<C> {
    fn std_m(&self) -> f64 {
        self.target.std_m()
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        let wanted = self.target.correlation(dx_m, dy_m).clamp(self.least, 1.0);
        // A value that is not finite is found by the generators.
        self.translation.normal_correlation(wanted).unwrap_or(f64::NAN)
    }

    fn mirror_symmetric(&self) -> bool {
        self.target.mirror_symmetric()
    }
}

/// Nodes per unit of the table, and its reach.
const NODES_PER_UNIT: f64 = 128.0;
const REACH: f64 = 8.0;

/// g ↦ offset + scale·F⁻¹(Φ(g)).
#[derive(Debug, Clone)]
struct NormalToLaw {
    law: Marginal,
    offset: f64,
    scale: f64,
    /// Values at −REACH, …, REACH and two nodes beyond each end: where the quantile needs a root search for each value.
    table: Option<Vec<f64>>,
}

impl NormalToLaw {
    fn new(law: &Marginal, offset: f64, scale: f64) -> Self {
        let table = matches!(law, Marginal::Beta { .. }).then(|| {
            let nodes = (2.0 * REACH * NODES_PER_UNIT) as usize + 5;
            (0..nodes).map(|i| law.translate((i as f64 - 2.0) / NODES_PER_UNIT - REACH)).collect()
        });
        Self { law: law.clone(), offset, scale, table }
    }

    fn value(&self, g: f64) -> f64 {
        let value = match &self.table {
            Some(table) if g.abs() < REACH => interpolate(table, (g + REACH) * NODES_PER_UNIT),
            _ => self.law.translate(g),
        };
        self.offset + self.scale * value
    }
}

/// Cubic Hermite interpolation at `position` (in nodes after the second) with fourth-order slopes: error O(h⁴).
fn interpolate(table: &[f64], position: f64) -> f64 {
    let left = (position.floor() as usize + 2).min(table.len() - 4);
    let t = position - (left as f64 - 2.0);
    let slope = |i: usize| (table[i - 2] - 8.0 * table[i - 1] + 8.0 * table[i + 1] - table[i + 2]) / 12.0;
    let (a, b, m, n) = (table[left], table[left + 1], slope(left), slope(left + 1));
    let rise = b - a;
    a + t * (m + t * ((3.0 * rise - 2.0 * m - n) + t * (m + n - 2.0 * rise)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{CorrelationModel, Covariance};
    use crate::random;
    use crate::surface::{KarhunenLoeve, ModesRoute, SpectralField};

    fn covariance(model: CorrelationModel, length_m: f64) -> Covariance {
        Covariance::isotropic(model, 1.0, length_m).unwrap()
    }

    fn beta() -> Marginal {
        Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap()
    }

    #[test]
    fn the_table_is_the_quantile() {
        for law in [beta(), Marginal::beta(0.6, 0.8, -1.0, 3.0).unwrap(), Marginal::beta(30.0, 2.0, 0.0, 1.0).unwrap()]
        {
            let map = NormalToLaw::new(&law, 0.0, 1.0);
            for i in -900..=900 {
                let g = f64::from(i) * 0.010_37;
                let error = (map.value(g) - law.translate(g)).abs();
                assert!(error < 2e-9, "{law:?} at {g}: {error:e}");
            }
        }
    }

    #[test]
    fn heights_have_the_law_at_every_point_also_of_a_truncated_field() {
        // 12 modes hold about half of the variance, unevenly; Kolmogorov's distance stays below its 1e−3 quantile.
        let grid = Grid::new(16, 16, 1.0, 1.0).unwrap();
        let field =
            KarhunenLoeve::new(&covariance(CorrelationModel::Exponential, 4.0), grid, 12, ModesRoute::Separable)
                .unwrap();
        assert!(field.captured_variance() < 0.7);
        let surface = Translated::new(field, beta()).unwrap();
        assert!(surface.least_variance_share() < 0.9);
        let count = 4000;
        let maps: Vec<_> = (0..count)
            .map(|index| surface.generate(&random::standard_normal(&mut random::stream(2, "law", index), 12)))
            .collect();
        for place in [[0, 0], [8, 8], [3, 15]] {
            let mut values: Vec<f64> = maps.iter().map(|map| map.heights_m()[place]).collect();
            values.sort_by(f64::total_cmp);
            let distance = values
                .iter()
                .enumerate()
                .fold(0.0_f64, |m, (i, z)| m.max((beta().cdf(*z) - (i as f64 + 0.5) / count as f64).abs()));
            assert!(distance < 1.95 / (count as f64).sqrt(), "{place:?}: {distance}");
        }
    }

    #[test]
    fn a_plain_lognormal_translation_distorts_as_the_closed_form_says() {
        // ρ_X = (e^{σ²ρ} − 1)/(e^{σ²} − 1).
        let sigma = 0.8_f64;
        let target = covariance(CorrelationModel::SquaredExponential, 4.0);
        let field = SpectralField::free(&target, Grid::new(32, 32, 1.0, 1.0).unwrap()).unwrap();
        let surface = Translated::new(field, Marginal::lognormal(0.0, sigma, 0.0).unwrap()).unwrap();
        let met = surface.correlation_with(16, 16).unwrap();
        let mut largest = 0.0_f64;
        for ((row, column), value) in met.indexed_iter() {
            let rho = target.correlation(column as f64 - 16.0, row as f64 - 16.0);
            let wanted = (sigma * sigma * rho).exp_m1() / (sigma * sigma).exp_m1();
            assert!((value - wanted).abs() < 1e-9);
            largest = largest.max((wanted - rho).abs());
        }
        let report = surface.correlation_report(&target).unwrap();
        assert!((report.largest_deviation - largest).abs() < 1e-9 && largest > 0.05);
    }

    #[test]
    fn the_corrected_translation_meets_the_target_and_the_plain_one_does_not() {
        let target = covariance(CorrelationModel::Exponential, 5.0);
        let grid = Grid::new(48, 48, 1.0, 1.0).unwrap();
        let law = Marginal::lognormal(0.0, 0.8, 0.0).unwrap();
        let plain = Translated::new(SpectralField::periodic(&target, grid), law.clone()).unwrap();
        let predistorted = Predistorted::new(target, &law).unwrap();
        let field = SpectralField::periodic(&predistorted, grid);
        let clipped = field.clipped_variance();
        let corrected = Translated::new(field, law).unwrap();
        let (before, after) =
            (plain.correlation_report(&target).unwrap(), corrected.correlation_report(&target).unwrap());
        assert!(before.largest_deviation > 0.03);
        assert!(
            after.largest_deviation < 0.02 * before.largest_deviation + 3.0 * clipped,
            "{after:?}, clipped {clipped}"
        );
    }

    #[test]
    fn the_predistortion_of_the_papers_beta_is_the_published_one() {
        // ρ_G for ρ_X = e⁻¹, e^{−.1} and e⁻².
        let gaussian = Predistorted::new(covariance(CorrelationModel::Exponential, 1.0), &beta()).unwrap();
        for (lag, wanted) in [(1.0, 0.375_013_83), (0.1, 0.907_643_18), (2.0, 0.138_828_91)] {
            assert!((gaussian.correlation(lag, 0.0) - wanted).abs() < 5e-8);
        }
    }

    #[test]
    fn sampled_heights_have_the_correlation_that_is_computed() {
        let target = covariance(CorrelationModel::SquaredExponential, 3.0);
        let grid = Grid::new(24, 24, 1.0, 1.0).unwrap();
        let predistorted = Predistorted::new(target, &beta()).unwrap();
        let surface = Translated::with_rms_height(SpectralField::periodic(&predistorted, grid), beta(), 2.0).unwrap();
        let wanted = surface.correlation_with(0, 0).unwrap();
        let lags = [(0, 0), (1, 0), (2, 1), (0, 4)];
        let count = 600;
        let mut sums = [(0.0, 0.0); 4];
        for index in 0..count {
            let germ = random::standard_normal(&mut random::stream(4, "beta", index), surface.germ_len());
            let map = surface.generate(&germ);
            let z = map.heights_m();
            for (sum, (x, y)) in sums.iter_mut().zip(lags) {
                let mean = z.indexed_iter().map(|((r, c), v)| v * z[[(r + y) % 24, (c + x) % 24]]).sum::<f64>() / 576.0;
                *sum = (sum.0 + mean, sum.1 + mean * mean);
            }
        }
        for ((sum, square), (x, y)) in sums.into_iter().zip(lags) {
            let mean = sum / count as f64;
            let error = ((square / count as f64 - mean * mean) / (count - 1) as f64).sqrt();
            assert!((mean - 4.0 * wanted[[y, x]]).abs() < 4.0 * error, "({x},{y}): {mean} ± {error}");
        }
    }

    #[test]
    fn a_field_that_vanishes_at_a_point_is_refused() {
        // One odd mode is zero in the middle of a grid with an odd number of points.
        let grid = Grid::new(9, 2, 1.0, 1.0).unwrap();
        let full = covariance(CorrelationModel::SquaredExponential, 30.0);
        let field = KarhunenLoeve::new(&full, grid, 1, ModesRoute::Separable).unwrap();
        assert!(Translated::new(field, beta()).is_ok());
        #[derive(Debug)]
        struct Odd(Grid);
        impl RandomSurface for Odd {
            fn germ_len(&self) -> usize {
                1
            }
            fn grid(&self) -> Grid {
                self.0
            }
            fn generate(&self, germ: &[f64]) -> HeightMap {
                HeightMap::from_function(self.0, |x, _| germ[0] * (x - 4.5)).unwrap()
            }
        }
        impl GaussianSurface for Odd {
            fn pointwise_std_m(&self) -> Array2<f64> {
                self.generate(&[1.0]).heights_m().mapv(f64::abs)
            }
            fn covariance_with_m2(&self, row: usize, column: usize) -> Array2<f64> {
                let shape = self.generate(&[1.0]).heights_m().clone();
                let here = shape[[row, column]];
                shape * here
            }
        }
        let error = Translated::new(Odd(grid), beta()).unwrap_err();
        assert!(matches!(error, TranslationError::Generator(GeneratorError::NoVariance { column: 4, .. })), "{error}");
    }
}
