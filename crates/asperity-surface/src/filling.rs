//! Filling of voids of a measured map, and extension beyond its edges, by a random surface with the statistics of the
//! map.

use ndarray::Array2;
use thiserror::Error;

use super::RandomSurface;
use super::conditional::{ConditionalError, LARGEST_DOMAIN, NeighbourhoodSurface, scores, surrounded};
use super::level::{Level, LevelError, remove_form};
use asperity_base::correlation::{
    Autocorrelation, BlockSpectrum, CorrelationFamily, EstimateError, FitError, MeasuredCovariance,
    MeasuredCovarianceError, StationaryCovariance, fit_covariance,
};
use asperity_base::distribution::{DistributionError, Marginal};
use asperity_base::map::{Grid, HeightMap, MapError};
use asperity_base::monitor::{Cancelled, Monitor};

asperity_base::choice! {
    /// Covariance of the missing heights.
    #[derive(Default)]
    pub enum FillCovariance: "covariance" {
        /// Measured covariance of the map.
        #[default]
        Measured = "measured",
        /// Best-fitting model.
        Fitted = "fitted",
    }
}

asperity_base::choice! {
    /// Marginal distribution of the missing heights.
    #[derive(Default)]
    pub enum FillMarginal: "distribution" {
        /// Distribution of the present heights, by translation.
        #[default]
        Measured = "measured",
        /// Normal distribution.
        Normal = "normal",
    }
}

/// Options for filling a map.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FillOptions {
    /// Form that is removed before and restored afterwards, also at missing heights. Beyond the map it is constant as
    /// at the edge.
    pub level: Level,
    /// Number of columns added on the left and on the right.
    pub extend_x: usize,
    /// Number of rows added above and below.
    pub extend_y: usize,
    /// Covariance of the missing heights.
    pub covariance: FillCovariance,
    /// Marginal distribution of the missing heights.
    pub marginal: FillMarginal,
    /// Variance of the measurement noise over that of the heights; see [`NeighbourhoodSurface::new`].
    pub nugget: f64,
}

/// Reason why a map could not be filled.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FillError {
    /// The form could not be removed.
    #[error("levelling: {0}")]
    Level(#[from] LevelError),
    /// The autocorrelation is undefined.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The measured covariance is undefined.
    #[error(transparent)]
    Measured(#[from] MeasuredCovarianceError),
    /// No covariance model could be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The marginal distribution is invalid.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
    /// The surface could not be conditioned on the present heights.
    #[error(transparent)]
    Conditional(#[from] ConditionalError),
    /// The extended grid is invalid.
    #[error(transparent)]
    Grid(#[from] MapError),
}

/// Complete random maps that equal a measured one at every present height.
///
/// The form is removed. Distribution and covariance of the remaining heights are estimated with missing heights masked.
/// If the distribution F is not normal, the covariance is that of the normal scores Φ⁻¹(F(z)). Missing heights are
/// drawn conditional on the heights around them ([`NeighbourhoodSurface`]), and the form is restored. Present heights
/// are returned bit by bit. The filled heights are one possible surface out of many, not a measurement: statistics of a
/// filled map are those of the model as far as they depend on filled points.
#[derive(Debug)]
pub struct Filling {
    measured: HeightMap,
    form_m: Array2<f64>,
    surface: NeighbourhoodSurface,
}

impl Filling {
    /// Prepares to fill `map`.
    ///
    /// # Errors
    /// The present heights do not determine a form, covariance or distribution; options are outside their ranges;
    /// cancellation.
    pub fn new(map: &HeightMap, options: FillOptions, monitor: &dyn Monitor) -> Result<Self, FillError> {
        let roughness = remove_form(map, options.level)?.map;
        // Equal heights have neither a covariance nor a distribution.
        Autocorrelation::within(&roughness, 0, 0)?;
        let measured = surrounded(map, options.extend_x, options.extend_y)?;
        let levelled = remove_form(&measured, options.level)?;
        let nugget = options.nugget;
        let surface = match options.marginal {
            FillMarginal::Normal => {
                let (covariance, mean_m) = covariance_of(&roughness, options.covariance)?;
                NeighbourhoodSurface::new(&*covariance, &levelled.map, mean_m, nugget, monitor)?
            }
            FillMarginal::Measured => {
                let marginal = Marginal::empirical(levelled.map.present_m().collect())?;
                let mut scores = scores(&marginal, &levelled.map)?.into_iter();
                let scores =
                    roughness.heights_m().mapv(|z| if z.is_nan() { z } else { scores.next().unwrap_or(f64::NAN) });
                let (covariance, _) = covariance_of(&HeightMap::new(map.grid(), scores)?, options.covariance)?;
                NeighbourhoodSurface::with_marginal(&*covariance, &levelled.map, &marginal, nugget, monitor)?
            }
        };
        // Beyond the map the form is constant as at the edge; a polynomial would diverge.
        let ((ny, nx), (left, top)) = (map.grid().shape(), (options.extend_x, options.extend_y));
        let form_m = Array2::from_shape_fn(levelled.form_m.dim(), |(row, column)| {
            levelled.form_m[[row.clamp(top, top + ny - 1), column.clamp(left, left + nx - 1)]]
        });
        Ok(Self { measured, form_m, surface })
    }

    /// Returns the number of filled heights.
    pub fn filled_points(&self) -> usize {
        self.measured.missing_points()
    }

    /// Returns the measured map, surrounded by the missing points of the extension.
    pub fn measured(&self) -> &HeightMap {
        &self.measured
    }

    /// Returns the random heights without the form.
    pub fn surface(&self) -> &NeighbourhoodSurface {
        &self.surface
    }

    /// Generates the maps of several ξ of [`RandomSurface::xi_len`] values each; see [`NeighbourhoodSurface::draw`].
    ///
    /// # Errors
    /// Cancellation.
    ///
    /// # Panics
    /// If a ξ has another length or a value that is not finite.
    pub fn draw(
        &self,
        xis: impl IntoIterator<Item = Vec<f64>>,
        monitor: &dyn Monitor,
    ) -> Result<Vec<HeightMap>, Cancelled> {
        Ok(self.surface.draw(xis, monitor)?.iter().map(|roughness| self.with_form(roughness)).collect())
    }

    fn with_form(&self, roughness: &HeightMap) -> HeightMap {
        let mut heights = roughness.heights_m() + &self.form_m;
        heights.zip_mut_with(self.measured.heights_m(), |z, measured| {
            if !measured.is_nan() {
                *z = *measured;
            }
        });
        match HeightMap::new(self.measured.grid(), heights) {
            Ok(map) => map,
            Err(_) => unreachable!("measured heights are present on the grid"),
        }
    }
}

impl RandomSurface for Filling {
    fn xi_len(&self) -> usize {
        self.surface.xi_len()
    }

    fn grid(&self) -> Grid {
        self.surface.grid()
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        self.with_form(&self.surface.generate(xi))
    }
}

/// Number of maps to generate together. Each needs memory, and all share the factors of the neighbourhoods.
pub const FILLED_AT_ONCE: usize = 8;

/// Returns the requested covariance of a map, and the mean of its heights in metre.
fn covariance_of(
    map: &HeightMap,
    covariance: FillCovariance,
) -> Result<(Box<dyn StationaryCovariance>, f64), FillError> {
    let estimate = Autocorrelation::estimate(map)?;
    let mean_m = estimate.mean_m();
    Ok(match covariance {
        FillCovariance::Measured => (Box::new(MeasuredCovariance::from_map(map)?), mean_m),
        FillCovariance::Fitted => {
            let fits =
                fit_covariance(&[&BlockSpectrum::new(map)?], estimate.variance_m2().sqrt(), CorrelationFamily::ALL)?;
            (Box::new(fits.best()), mean_m)
        }
    })
}

/// Returns the memory in byte, about, for filling a map of this grid: the modes of the domain of the unconditional
/// field, and up to [`FILLED_AT_ONCE`] maps with their differences from the measured heights.
pub fn filling_memory_bytes(points: f64) -> f64 {
    const BYTES_PER_MODE: f64 = 90.0;
    const BYTES_PER_POINT: f64 = 24.0 * FILLED_AT_ONCE as f64 + 150.0;
    // Domains are rounded up to lengths of small factors.
    BYTES_PER_MODE * (4.4 * points).max(LARGEST_DOMAIN as f64) + BYTES_PER_POINT * points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SpectralField;
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::monitor::Silent;
    use asperity_base::random;

    /// Returns a tilted map of lognormal heights with a void, and the true map, for a marginal distribution.
    fn scan(marginal: &Marginal) -> (HeightMap, HeightMap) {
        let grid = Grid::new(160, 120, 1e-6, 1e-6).unwrap();
        let covariance = Covariance::isotropic(CorrelationModel::Exponential, 1.0, 5e-6).unwrap();
        let field = SpectralField::free(&covariance, grid).unwrap();
        let xi = random::standard_normal(&mut random::stream(9, "scan", 0), field.xi_len());
        let mut heights = field.generate(&xi).heights_m().mapv(|g| 1e-6 * marginal.translate(g));
        for ((row, column), z) in heights.indexed_iter_mut() {
            *z += 1e-2 * 1e-6 * column as f64 - 3e-2 * 1e-6 * row as f64 + 1.0;
        }
        let whole = HeightMap::new(grid, heights.clone()).unwrap();
        heights.slice_mut(ndarray::s![30..80, 60..130]).fill(f64::NAN);
        (whole, HeightMap::new(grid, heights).unwrap())
    }

    #[test]
    #[ignore = "slow"]
    fn a_filled_map_keeps_its_heights_and_their_statistics() {
        let marginal = Marginal::lognormal(0.0, 0.5, 0.0).unwrap();
        let (_, map) = scan(&marginal);
        let options = FillOptions { extend_x: 20, extend_y: 10, ..FillOptions::default() };
        let filling = Filling::new(&map, options, &Silent).unwrap();
        assert_eq!(filling.filled_points(), 200 * 140 - 160 * 120 + 50 * 70);
        let xi = random::standard_normal(&mut random::stream(9, "fill", 0), filling.xi_len());
        let filled = filling.generate(&xi);
        assert_eq!(filled.missing_points(), 0);
        for (before, after) in filling.measured().heights_m().iter().zip(filled.heights_m()) {
            assert!(before.is_nan() || before.to_bits() == after.to_bits());
        }
        // Inside the void, without the tilt, the distribution is as skewed as the rest: some fifty independent patches
        // in each map.
        let tilt = |r: usize, c: usize| 1e-8 * (c - 20) as f64 - 3e-8 * (r - 10) as f64;
        let mut inside: Vec<f64> = Vec::new();
        for index in 0..6 {
            let xi = random::standard_normal(&mut random::stream(9, "fill", index), filling.xi_len());
            let map = filling.generate(&xi);
            let places = (44..86).flat_map(|r| (84..146).map(move |c| (r, c)));
            inside.extend(places.map(|(r, c)| map.heights_m()[[r, c]] - 1.0 - tilt(r, c)));
        }
        let asperity_base::stats::Moments { mean, std, skewness, .. } = asperity_base::stats::Moments::new(&inside);
        // The tolerance is four standard errors: patches at the edge of the void are nearly the same in every map.
        let (wanted_mean, wanted_std) = (1e-6 * 0.125_f64.exp(), 1e-6 * (0.25_f64.exp_m1() * 0.25_f64.exp()).sqrt());
        assert!((mean - wanted_mean).abs() < 4.0 * wanted_std / 100.0_f64.sqrt(), "{mean:e} {wanted_mean:e}");
        assert!((std / wanted_std - 1.0).abs() < 0.3, "{std:e} {wanted_std:e}");
        assert!(skewness > 0.5, "{skewness}");
    }

    #[test]
    fn a_form_does_not_diverge_beyond_the_map() {
        // A bowl of 1 mm radius under roughness: its polynomial would rise by tens of micrometres in the extension.
        let (whole, _) = scan(&Marginal::STANDARD_NORMAL);
        let bowl = |x: f64, y: f64| ((x - 80e-6).powi(2) + (y - 60e-6).powi(2)) / 2e-3;
        let form = HeightMap::from_function(whole.grid(), bowl).unwrap();
        let map = HeightMap::new(whole.grid(), whole.heights_m() + form.heights_m()).unwrap();
        let options =
            FillOptions { level: Level::Polynomial(4), extend_x: 120, extend_y: 90, ..FillOptions::default() };
        let filling = Filling::new(&map, options, &Silent).unwrap();
        let filled = filling.generate(&random::standard_normal(&mut random::stream(9, "far", 0), filling.xi_len()));
        let range = |map: &HeightMap| {
            map.present_m().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)))
        };
        let ((low, high), (measured_low, measured_high)) = (range(&filled), range(&map));
        // The extension is as high as the edges, where the form ends, and as rough.
        assert!(low > measured_low - 4e-6 && high < measured_high + 4e-6, "{low:e} {high:e}");
    }

    #[test]
    fn a_lay_through_the_whole_map_continues_through_the_void() {
        let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
        let lay = Covariance::new(CorrelationModel::Exponential, 1e-6, 3e-6, 200e-6).unwrap();
        let field = SpectralField::periodic(&lay, grid);
        let whole = field.generate(&random::standard_normal(&mut random::stream(9, "lay", 0), field.xi_len()));
        let mut heights = whole.heights_m().clone();
        heights.slice_mut(ndarray::s![24..36, 20..40]).fill(f64::NAN);
        let map = HeightMap::new(grid, heights).unwrap();
        let filling =
            Filling::new(&map, FillOptions { level: Level::Mean, ..FillOptions::default() }, &Silent).unwrap();
        let filled = filling.generate(&random::standard_normal(&mut random::stream(9, "fill", 1), filling.xi_len()));
        // In the middle of the void, six lags from either edge, unconditioned heights would have an error of 1.4 µm.
        let middle =
            |map: &HeightMap| -> Vec<f64> { map.heights_m().row(30).iter().skip(20).take(20).copied().collect() };
        let off: Vec<f64> = middle(&filled).iter().zip(middle(&whole)).map(|(a, b)| (a - b).powi(2)).collect();
        let rms_m = (off.iter().sum::<f64>() / off.len() as f64).sqrt();
        assert!(rms_m < 0.6e-6, "{rms_m:e}");
    }

    #[test]
    #[ignore = "slow"]
    fn a_fitted_covariance_and_a_normal_distribution_can_be_chosen() {
        let (_, map) = scan(&Marginal::STANDARD_NORMAL);
        let options = FillOptions {
            covariance: FillCovariance::Fitted,
            marginal: FillMarginal::Normal,
            nugget: 1e-6,
            ..FillOptions::default()
        };
        let filling = Filling::new(&map, options, &Silent).unwrap();
        let xi = random::standard_normal(&mut random::stream(9, "fill", 1), filling.xi_len());
        let filled = filling.generate(&xi);
        assert_eq!(filled.missing_points(), 0);
        assert!(map.heights_m().iter().zip(filled.heights_m()).all(|(a, b)| a.is_nan() || a.to_bits() == b.to_bits()));
    }

    #[test]
    fn a_flat_map_is_refused() {
        let flat =
            HeightMap::from_function(Grid::new(16, 16, 1.0, 1.0).unwrap(), |x, _| if x > 8.0 { f64::NAN } else { 2.0 });
        let error = Filling::new(&flat.unwrap(), FillOptions::default(), &Silent).unwrap_err();
        assert!(matches!(error, FillError::Estimate(EstimateError::Constant { .. })), "{error}");
    }
}
