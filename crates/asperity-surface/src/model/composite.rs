//! Models of the random surfaces of two bodies in contact.

use asperity_base::distribution::{Marginal, standard_normal_pdf};
use asperity_base::map::Grid;
use asperity_base::numeric::root_between;

use super::{Generated, SurfaceModel, SurfaceModelError, Texture, XiOrder};
use crate::composite::CompositeSurface;

/// Random surface and, if it is rough too, the random surface of the body that is pressed against it.
///
/// The gap between the bodies depends on the sum of their heights, the composite roughness. The two surfaces are independent, so
/// variances and covariances add. Heights point out of the material of each body; the counterface is mirrored along x.
#[derive(Debug, Clone)]
pub struct CompositeModel {
    /// Surface.
    pub surface: SurfaceModel,
    /// Rough counterface; `None` is smooth.
    pub counterface: Option<SurfaceModel>,
}

impl CompositeModel {
    /// Makes the generator of composite maps on a small patch; see [`SurfaceModel::patch`].
    ///
    /// # Errors
    /// The errors of [`SurfaceModel::patch`].
    pub fn patch(&self, grid: Grid, periodic: bool) -> Result<Generated, SurfaceModelError> {
        self.composed(|model| model.patch(grid, periodic))
    }

    /// Makes the generator of composite maps on a long strip; see [`SurfaceModel::strip`].
    ///
    /// # Errors
    /// The errors of [`SurfaceModel::strip`].
    pub fn strip(&self, grid: Grid, periodic: bool, order: XiOrder) -> Result<Generated, SurfaceModelError> {
        self.composed(|model| model.strip(grid, periodic, order))
    }

    fn composed(
        &self,
        generate: impl Fn(&SurfaceModel) -> Result<Generated, SurfaceModelError>,
    ) -> Result<Generated, SurfaceModelError> {
        let own = generate(&self.surface)?;
        let Some(model) = &self.counterface else { return Ok(own) };
        let other = generate(model).map_err(|error| SurfaceModelError::Counterface(Box::new(error)))?;
        let (own_m, other_m) = (self.surface.marginal.std(), model.marginal.std());
        let correction = [own.correction, other.correction.map(|correction| format!("Counterface: {correction}"))];
        let correction: Vec<String> = correction.into_iter().flatten().collect();
        let of_other = other.warnings.into_iter().map(|warning| format!("counterface: {warning}"));
        Ok(Generated {
            surface: Box::new(CompositeSurface::new(own.surface, other.surface)),
            karhunen_loeve: own.karhunen_loeve,
            std_share: (own.std_share * own_m).hypot(other.std_share * other_m) / own_m.hypot(other_m),
            warnings: own.warnings.into_iter().chain(of_other).collect(),
            correction: (!correction.is_empty()).then(|| correction.join(" ")),
            clipped_variance: own.clipped_variance.max(other.clipped_variance),
        })
    }

    /// Returns the quantile of the composite heights at a point, in metre.
    pub fn height_quantile_m(&self, probability: f64) -> f64 {
        let own = &self.surface.marginal;
        self.counterface.as_ref().map_or_else(
            || own.quantile(probability),
            |counterface| quantile_of_sum(own, &counterface.marginal, probability),
        )
    }

    /// Returns the length in metre of the shortest wave of both bodies; 0 if the grid limits it.
    pub fn shortest_wave_m(&self) -> f64 {
        let of = |model: &SurfaceModel| model.shortest_wave_m.unwrap_or(0.0);
        self.counterface.as_ref().map_or(f64::INFINITY, of).min(of(&self.surface))
    }

    /// Returns whether the maps of a periodic strip continue across its edges. A sum of cosines of arbitrary directions does not.
    pub fn closes(&self) -> bool {
        let closes = |model: &SurfaceModel| !matches!(model.texture, Texture::WeierstrassMandelbrot { .. });
        closes(&self.surface) && self.counterface.as_ref().is_none_or(closes)
    }
}

/// Returns the quantile of the sum of two independent variables X and Y; NaN outside [0, 1].
///
/// P(X + Y ≤ t) = ∫ F_X(t − F_Y⁻¹(Φ(g))) φ(g) dg, where X has the larger standard deviation. The trapezoidal rule in g converges
/// faster than any power of its step, because the density vanishes at both ends.
fn quantile_of_sum(a: &Marginal, b: &Marginal, probability: f64) -> f64 {
    /// Nodes per standard deviation on either side of 0, and standard deviations.
    const NODES: i32 = 64;
    const REACH: i32 = 8;

    if let (Marginal::Normal { .. }, Marginal::Normal { .. }) = (a, b) {
        return Marginal::Normal { mean: a.mean() + b.mean(), std: a.std().hypot(b.std()) }.quantile(probability);
    }
    let (wider, narrower) = if a.std() >= b.std() { (a, b) } else { (b, a) };
    let nodes = (-REACH * NODES..=REACH * NODES).map(|node| f64::from(node) / f64::from(NODES));
    let nodes: Vec<(f64, f64)> = nodes.map(|g| (narrower.translate(g), standard_normal_pdf(g))).collect();
    let total: f64 = nodes.iter().map(|(_, weight)| weight).sum();
    let excess = |t: f64| {
        let below: f64 = nodes.iter().map(|(y, weight)| weight * wider.cdf(t - y)).sum();
        below / total - probability
    };
    // X + Y ≤ t requires X ≤ x or Y ≤ y if t = x + y, so the sum of the quantiles at p/2 lies below that at p.
    let bound = |p: f64| a.quantile(p) + b.quantile(p);
    let (low, high) = (bound(0.5 * probability), bound(0.5 * (1.0 + probability)));
    root_between(excess, [low, excess(low)], [high, excess(high)]).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::SurfaceCovariance;
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::random::{standard_normal, stream};
    use asperity_base::translation::TranslationKind;

    #[test]
    fn the_quantile_of_a_sum_is_that_of_its_closed_form() {
        // Two exponential variables of scale 1: P(X + Y ≤ t) = 1 − (1 + t) e^{−t}, a gamma variable of shape 2.
        let exponential = Marginal::gamma(1.0, 1.0, 0.0).unwrap();
        let sum = Marginal::gamma(2.0, 1.0, 0.0).unwrap();
        // A normal variable and an almost constant one.
        let (wide, narrow) = (Marginal::normal(1.0, 2.0).unwrap(), Marginal::beta(2.1, 5.0, -1e-6, 1e-6).unwrap());
        for p in [0.001, 0.05, 0.5, 0.9, 0.999] {
            let found = quantile_of_sum(&exponential, &exponential, p);
            assert!((found / sum.quantile(p) - 1.0).abs() < 1e-3, "{p}: {found}");
            assert!((quantile_of_sum(&narrow, &wide, p) - wide.quantile(p)).abs() < 2e-6, "{p}");
            let normal = quantile_of_sum(&wide, &wide, p);
            assert!((normal - Marginal::normal(2.0, 8.0_f64.sqrt()).unwrap().quantile(p)).abs() < 1e-12, "{p}");
        }
    }

    fn model(std_m: f64) -> SurfaceModel {
        let covariance = Covariance::isotropic(CorrelationModel::Exponential, std_m, 4e-6).unwrap();
        SurfaceModel {
            marginal: Marginal::normal(0.0, std_m).unwrap(),
            texture: Texture::Translated {
                covariance: SurfaceCovariance::Model(covariance),
                translation: TranslationKind::Plain,
                expansion: None,
            },
            shortest_wave_m: None,
        }
    }

    #[test]
    fn two_bodies_of_half_the_variance_have_the_covariance_of_one() {
        let half = 0.5_f64.sqrt() * 1e-6;
        let pair = CompositeModel { surface: model(half), counterface: Some(model(half)) };
        let grid = Grid::new(32, 24, 1e-6, 1e-6).unwrap();
        let generated = pair.strip(grid, true, XiOrder::Variance).unwrap();
        let (surface, count) = (generated.surface.as_ref(), 400);
        assert!(surface.is_periodic_and_stationary() && pair.closes() && generated.std_share == 1.0);
        // Mean over the map of z(x) z(x + lag): independent samples, so that their standard deviation gives the standard error.
        for lag in [0, 1, 4] {
            let products: Vec<f64> = (0..count)
                .map(|index| {
                    let xi = standard_normal(&mut stream(3, "composite", index), surface.xi_len());
                    let map = surface.generate(&xi);
                    let heights_m = map.heights_m();
                    let product =
                        |((row, column), z): ((usize, usize), &f64)| z * heights_m[[row, (column + lag) % 32]];
                    heights_m.indexed_iter().map(product).sum::<f64>() / heights_m.len() as f64
                })
                .collect();
            let mean = products.iter().sum::<f64>() / count as f64;
            let variance = products.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
            // On the periodic grid the correlation is e^{−r/ℓ} up to e^{−16/4} of images.
            let wanted = 1e-12 * (-(lag as f64) / 4.0).exp();
            let error = (variance / count as f64).sqrt();
            assert!((mean - wanted).abs() < 4.0 * error + 0.01e-12, "{lag}: {mean:e} ± {error:e}, not {wanted:e}");
        }
        assert!((pair.height_quantile_m(0.9) / 1e-6 - 1.281_551_565_544_6).abs() < 1e-9);
        let alone = CompositeModel { surface: model(1e-6), counterface: None };
        assert_eq!(alone.height_quantile_m(0.9), alone.surface.marginal.quantile(0.9));
    }
}
