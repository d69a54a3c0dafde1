//! Slopes of scans and of random surfaces within the reliable band of the scans.

use std::f64::consts::{PI, TAU};

use super::SurfaceModelError;
use crate::filter::{ALPHA, GaussianFilter};
use crate::preparation::PreparationError;
use asperity_base::correlation::{BlockSpectrum, StationaryCovariance};
use asperity_base::distribution::translation::Translation;
use asperity_base::map::HeightMap;

/// Lag in cutoffs beyond which the weights of the filter on the covariance are negligible: e^{−π·1.5²/2α²} = 1e-7.
const REACH: f64 = 1.5;
/// Shortest cutoff in pixels.
const FEWEST_PIXELS: f64 = 4.0;

/// Spectra and slopes of one scan or several.
#[derive(Debug, Clone)]
pub struct Roughness {
    /// Power spectral densities of the scans, for the fit of covariance models.
    pub spectra: Vec<BlockSpectrum>,
    /// Slopes within the band; `None` if the cutoff exceeds a scan or no neighbours are present.
    pub slopes: Option<BandSlopes>,
}

impl Roughness {
    /// Estimates spectra and slopes from maps of one surface with one pitch.
    ///
    /// # Errors
    /// A map has no spectrum, or cannot be filtered.
    pub fn new(maps: &[&HeightMap]) -> Result<Self, SurfaceModelError> {
        let spectra = maps.iter().map(|map| BlockSpectrum::new(map)).collect::<Result<Vec<BlockSpectrum>, _>>()?;
        let end = spectra.iter().map(|spectrum| spectrum.reliable().high_rad_per_m).fold(f64::INFINITY, f64::min);
        let slopes = BandSlopes::new(maps, end)?;
        Ok(Self { spectra, slopes })
    }

    /// Returns the length in metre of the shortest wave that all scans resolve ([`BlockSpectrum::shortest_wave_m`]).
    pub fn shortest_wave_m(&self) -> f64 {
        self.spectra.iter().map(BlockSpectrum::shortest_wave_m).fold(0.0, f64::max)
    }
}

/// Mean squared slopes of one scan, or of several, after an S-filter at the end of their reliable bands.
#[derive(Debug, Clone, PartialEq)]
pub struct BandSlopes {
    /// Cutoff of the S-filter in metre.
    pub cutoff_m: f64,
    pitch_m: [f64; 2],
    /// Mean squares of the slopes along x and y.
    squares: [f64; 2],
}

impl BandSlopes {
    /// Measures the slopes of maps of one pitch whose bands end at `high_rad_per_m`; `None` if no neighbours are present or the
    /// cutoff exceeds a map.
    ///
    /// # Errors
    /// A map cannot be filtered.
    pub fn new(maps: &[&HeightMap], high_rad_per_m: f64) -> Result<Option<Self>, SurfaceModelError> {
        let Some(grid) = maps.first().map(|map| map.grid()) else { return Ok(None) };
        let pitch_m = [grid.dx_m(), grid.dy_m()];
        let cutoff_m = (TAU / high_rad_per_m).max(FEWEST_PIXELS * pitch_m[0].max(pitch_m[1]));
        let (mut sums, mut pairs) = ([0.0; 2], [0.0; 2]);
        for map in maps {
            let own = map.grid();
            if cutoff_m > own.width_m().min(own.height_m()) {
                return Ok(None);
            }
            let smooth = GaussianFilter::linear(cutoff_m).smooth(map).map_err(PreparationError::SFilter)?;
            let (nx, heights) = (own.nx(), smooth.map.values_m());
            for (place, z) in heights.iter().enumerate() {
                let right = (place % nx + 1 < nx).then(|| heights[place + 1]);
                let below = heights.get(place + nx).copied();
                for (axis, other) in [right, below].into_iter().enumerate() {
                    let slope = other.map_or(f64::NAN, |other| (other - z) / pitch_m[axis]);
                    if !slope.is_nan() {
                        sums[axis] += slope * slope;
                        pairs[axis] += 1.0;
                    }
                }
            }
        }
        let known = pairs.iter().all(|pairs| *pairs > 0.0) && sums.iter().all(|sum| *sum > 0.0);
        Ok(known.then(|| Self { cutoff_m, pitch_m, squares: [sums[0] / pairs[0], sums[1] / pairs[1]] }))
    }

    /// Returns Sdq of random surfaces over Sdq of the scan, both within the band.
    ///
    /// The surfaces have the covariance σ²T(ρ) with σ and ρ of `covariance` and T the distortion of the translation, if any. After the filter their mean squared slope is Σ W(h) σ²T(ρ(h)) over the lags h of the grid, W the second
    /// difference of the filter's weights convolved with themselves: an expectation, without sampling.
    pub fn ratio(&self, covariance: &dyn StationaryCovariance, translation: Option<&Translation>) -> f64 {
        let squares = self.expected(covariance, translation);
        ((squares[0] + squares[1]) / (self.squares[0] + self.squares[1])).max(0.0).sqrt()
    }

    /// Returns Sdq of a map over Sdq of the scan, both within the band; `None` if the cutoff exceeds the map.
    ///
    /// # Errors
    /// The map cannot be filtered.
    pub fn ratio_of(&self, map: &HeightMap) -> Result<Option<f64>, SurfaceModelError> {
        let found = Self::new(&[map], TAU / self.cutoff_m)?;
        let sum = |slopes: &Self| slopes.squares[0] + slopes.squares[1];
        Ok(found.map(|found| (sum(&found) / sum(self)).sqrt()))
    }

    /// Returns the expected mean squared slopes along x and y.
    fn expected(&self, covariance: &dyn StationaryCovariance, translation: Option<&Translation>) -> [f64; 2] {
        // The weights exp(−π(h/αλ)²) of the filter, convolved with themselves, on the lags −R−1 … R+1 with the reach R.
        let weights = |axis: usize| -> Vec<f64> {
            let reach = (REACH * self.cutoff_m / self.pitch_m[axis]).ceil() as i64;
            let weight = |lag: i64| {
                let u = lag as f64 * self.pitch_m[axis] / (ALPHA * self.cutoff_m);
                if lag.abs() > reach { 0.0 } else { (-0.5 * PI * u * u).exp() }
            };
            let sum: f64 = (-reach..=reach).map(weight).sum();
            (-reach - 1..=reach + 1).map(|lag| weight(lag) / sum).collect()
        };
        let along = [weights(0), weights(1)];
        // Twice the weight less its neighbours', over the squared pitch.
        let difference = |axis: usize| -> Vec<f64> {
            let weights = &along[axis];
            let at = |place: Option<usize>| place.and_then(|place| weights.get(place)).copied().unwrap_or(0.0);
            (0..weights.len())
                .map(|i| (2.0 * weights[i] - at(i.checked_sub(1)) - at(Some(i + 1))) / self.pitch_m[axis].powi(2))
                .collect()
        };
        let differences = [difference(0), difference(1)];
        let [half_x, half_y] = [along[0].len() / 2, along[1].len() / 2];
        let variance = covariance.std_m().powi(2);
        let mut squares = [0.0; 2];
        // Lags (x, y) and (−x, −y) have the same correlation: the rows y ≥ 0 contain all.
        for row in half_y..along[1].len() {
            let times = if row == half_y { 1.0 } else { 2.0 };
            for column in 0..along[0].len() {
                let lag_x_m = (column as f64 - half_x as f64) * self.pitch_m[0];
                let lag_y_m = (row - half_y) as f64 * self.pitch_m[1];
                let rho = covariance.correlation(lag_x_m, lag_y_m).clamp(-1.0, 1.0);
                let met = translation.map_or(rho, |translation| translation.correlation(rho));
                squares[0] += times * differences[0][column] * along[1][row] * met;
                squares[1] += times * along[0][column] * differences[1][row] * met;
            }
        }
        squares.map(|square| variance * square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RandomSurface, SpectralField, Translated};
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::distribution::Marginal;
    use asperity_base::map::Grid;
    use asperity_base::random;

    #[test]
    fn the_slope_of_a_filtered_squared_exponential_surface_is_known() {
        // σ²e^{−r²/ℓ²} after the filter: variances of Gaussians add. With s² = (αλ)²/π the weights convolved with themselves are
        // e^{−r²/2s²}, and C = σ² ℓ²/(ℓ² + 2s²) e^{−r²/(ℓ² + 2s²)}, whose slopes have E|∇z|² = 4C(0)/(ℓ² + 2s²).
        let (length_m, cutoff_m) = (2e-5, 1.2e-5);
        let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1e-6, length_m).unwrap();
        let slopes = BandSlopes { cutoff_m, pitch_m: [2e-7, 3e-7], squares: [0.5, 0.5] };
        let wide = length_m * length_m + 2.0 * (ALPHA * cutoff_m).powi(2) / PI;
        let wanted = 4.0 * 1e-12 * (length_m * length_m / wide) / wide;
        // Differences over a pitch fall short by (Δ/ℓ)²/2.
        assert!((slopes.ratio(&covariance, None).powi(2) / wanted - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_expected_slopes_are_those_of_generated_maps_with_any_marginal_distribution() {
        let grid = Grid::new(192, 160, 1e-6, 1.5e-6).unwrap();
        let covariance = Covariance::new(CorrelationModel::Exponential, 1e-6, 8e-6, 5e-6).unwrap();
        for text in ["normal", "lognormal:0,0.8", "beta:0.6,0.6"] {
            let marginal: Marginal = text.parse::<Marginal>().unwrap().standardised(0.0, 1e-6).unwrap();
            let translation = Translation::new(&marginal).unwrap();
            let field = Translated::new(SpectralField::free(&covariance, grid).unwrap(), marginal).unwrap();
            let maps: Vec<HeightMap> = (0..12)
                .map(|index| {
                    let xi = random::standard_normal(&mut random::stream(4, "slopes", index), field.xi_len());
                    field.generate(&xi)
                })
                .collect();
            let slopes = BandSlopes::new(&maps.iter().collect::<Vec<_>>(), 1e6).unwrap().unwrap();
            let ratio = slopes.ratio(&covariance, Some(&translation));
            // 12 maps of some 400 patches each: under 2 % for the skewed distribution; at the edges the filter sees less.
            assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        }
    }
}
