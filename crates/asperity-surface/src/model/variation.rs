//! Random surfaces with other parameters.

use asperity_base::distribution::Marginal;

use super::{SurfaceCovariance, SurfaceModel, SurfaceModelError, Texture};

/// Parameters of a random surface that differ from those of a model; `None` keeps a parameter.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Variation {
    /// Root-mean-square height in metre.
    pub rms_height_m: Option<f64>,
    /// Correlation length along x in metre ([`SurfaceCovariance::length_x_m`]). All other lags keep their ratio to it. A surface
    /// without a covariance ignores it.
    pub correlation_length_m: Option<f64>,
    /// Skewness of the heights, which then have Johnson's distribution.
    pub skewness: Option<f64>,
    /// Change of the skewness. Measured heights change to first order: standardised heights z of skewness g and kurtosis κ become
    /// z + c (z² − 1 − gz) with c = change/(3 (κ − 1 − g²)). Other distributions become Johnson's.
    pub skewness_change: Option<f64>,
}

impl SurfaceModel {
    /// Returns the model with other parameters.
    ///
    /// The kurtosis of a distribution of skewness g is κ + g² − g₀², with κ and g₀ of this model. So its distance from 1 + g², the
    /// smallest kurtosis of any distribution, does not change.
    ///
    /// # Errors
    /// No distribution or covariance has these parameters.
    pub fn varied(&self, variation: &Variation) -> Result<Self, SurfaceModelError> {
        let original = &self.marginal;
        let std_m = variation.rms_height_m.unwrap_or(original.std());
        let change = variation.skewness_change.filter(|change| *change != 0.0);
        let skewness = variation.skewness.or_else(|| Some(original.skewness() + change?));
        let marginal = match (skewness, change, original) {
            (Some(_), Some(change), Marginal::Empirical { sorted }) if variation.skewness.is_none() => {
                skewed(sorted, original, change)?.standardised(0.0, std_m)?
            }
            (None, ..) => original.standardised(0.0, std_m)?,
            (Some(skewness), ..) => {
                let excess_kurtosis = original.excess_kurtosis() + skewness * skewness - original.skewness().powi(2);
                Marginal::johnson_with_moments(0.0, std_m, skewness, excess_kurtosis)?
            }
        };
        let lengths = variation.correlation_length_m.zip(self.covariance().map(SurfaceCovariance::length_x_m));
        let stretch = lengths.map_or(1.0, |(length_m, own_m)| length_m / own_m);
        let mut texture = self.texture.clone();
        if let Texture::Translated { covariance, .. } = &mut texture {
            *covariance = covariance.stretched(std_m, stretch)?;
        }
        Ok(Self { marginal, texture, ..self.clone() })
    }
}

/// Returns the distribution of measured heights with another skewness.
fn skewed(heights_m: &[f64], marginal: &Marginal, change: f64) -> Result<Marginal, SurfaceModelError> {
    let (mean, std, skewness) = (marginal.mean(), marginal.std(), marginal.skewness());
    let bend = change / (3.0 * (marginal.excess_kurtosis() + 2.0 - skewness * skewness));
    let bent = heights_m.iter().map(|height_m| {
        let z = (height_m - mean) / std;
        z + bend * (z * z - 1.0 - skewness * z)
    });
    Ok(Marginal::empirical(bent.collect())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::correlation::{CorrelationModel, Covariance, StationaryCovariance};
    use asperity_base::translation::TranslationKind;

    #[test]
    fn a_varied_model_has_the_stated_parameters() {
        let covariance = Covariance::new(CorrelationModel::Exponential, 1e-6, 20e-6, 10e-6).unwrap();
        let beta = Marginal::beta(4.0, 2.5, 0.0, 1.0).unwrap().standardised(0.0, 1e-6).unwrap();
        let texture = Texture::Translated {
            covariance: SurfaceCovariance::Model(covariance),
            translation: TranslationKind::Plain,
            expansion: None,
        };
        let model = SurfaceModel { marginal: beta.clone(), texture, shortest_wave_m: None };
        for skewness in [beta.skewness(), 0.0, 0.9, -1.5] {
            let (rms_height_m, correlation_length_m) = (Some(1.1e-6), Some(30e-6));
            let variation =
                Variation { rms_height_m, correlation_length_m, skewness: Some(skewness), ..Variation::default() };
            let found = model.varied(&variation).unwrap();
            assert!((found.marginal.std() / 1.1e-6 - 1.0).abs() < 1e-9);
            assert!((found.marginal.skewness() - skewness).abs() < 1e-6);
            let above = |marginal: &Marginal| marginal.excess_kurtosis() + 2.0 - marginal.skewness().powi(2);
            assert!((above(&found.marginal) - above(&beta)).abs() < 1e-6);
            let covariance = found.covariance().unwrap();
            assert!((covariance.correlation(30e-6, 0.0) - (-1.0_f64).exp()).abs() < 1e-12);
            assert!((covariance.correlation(0.0, 15e-6) - (-1.0_f64).exp()).abs() < 1e-12);
        }
        // Without skewness the distribution keeps its shape.
        let found = model.varied(&Variation { rms_height_m: Some(2e-6), ..Variation::default() }).unwrap().marginal;
        assert!((found.quantile(0.9) / (2.0 * beta.quantile(0.9)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn measured_heights_take_a_small_change_of_skewness_and_keep_their_standard_deviation() {
        let beta = Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap();
        let heights: Vec<f64> = (0..20_000).map(|i| beta.quantile((f64::from(i) + 0.5) / 20_000.0)).collect();
        let marginal = Marginal::empirical(heights).unwrap().standardised(0.0, 1e-6).unwrap();
        let texture = Texture::WeierstrassMandelbrot { dimension: 2.3 };
        let model = SurfaceModel { marginal, texture, shortest_wave_m: None };
        let skewness = model.marginal.skewness();
        for change in [-0.05, -0.01, 0.0, 0.01, 0.05] {
            let variation = Variation { skewness_change: Some(change), ..Variation::default() };
            let found = model.varied(&variation).unwrap().marginal;
            // The next term of the expansion is of the order of the square of the change.
            assert!(
                (found.skewness() - skewness - change).abs() <= 1e-9 + change * change,
                "{change}: {}",
                found.skewness()
            );
            assert!((found.std() / 1e-6 - 1.0).abs() < 1e-9 && found.mean().abs() < 1e-15);
        }
    }
}
