//! Trial maps of a model on the grid of the scan, for comparisons of slopes and contact with the scan.

use asperity_base::blocks;
use asperity_base::map::{Grid, HeightMap};
use asperity_base::random;

use super::{BandSlopes, SurfaceModel, SurfaceModelError, XiOrder};
use crate::RandomSurface;
use crate::level::Level;
use crate::preparation::Preparation;

/// Most points along a side of the maps.
const POINTS: usize = 512;
/// Number of maps.
const MAPS: usize = 3;

/// Random maps on the grid of a scan, or on at most 512 × 512 points of it, levelled like the scan.
#[derive(Debug, Clone)]
pub struct TrialMaps {
    /// Levelled maps.
    pub maps: Vec<HeightMap>,
    /// Sdq of each map over Sdq of the scan, within the band.
    slope_ratios: Vec<f64>,
    /// Fraction of the variance that the generator clipped.
    pub(super) clipped_variance: f64,
}

impl TrialMaps {
    /// Draws maps of a model on the grid of a scan and multiplies their slope ratios by `scale`; `None` if a map is too small for
    /// the S-filter of `slopes`.
    pub(super) fn draw(
        model: &SurfaceModel,
        scale: f64,
        grid: Grid,
        level: Level,
        slopes: &BandSlopes,
    ) -> Result<Option<Self>, SurfaceModelError> {
        let grid = Grid::new(grid.nx().min(POINTS), grid.ny().min(POINTS), grid.dx_m(), grid.dy_m())
            .map_err(SurfaceModelError::TrialGrid)?;
        let generated = model.strip(grid, false, XiOrder::Variance)?;
        let surface = &generated.surface;
        let drawn: Result<Vec<Option<_>>, SurfaceModelError> = blocks::map(0..MAPS, |index| {
            let mut stream = random::stream(1, "trial maps", index as u64);
            let map = surface.generate(&random::standard_normal(&mut stream, surface.xi_len()));
            let map = Preparation { level: level.as_polynomial(), ..Preparation::default() }.apply(map)?.map;
            Ok(slopes.ratio_of(&map)?.map(|ratio| (map, scale * ratio)))
        });
        let drawn: Option<Vec<(HeightMap, f64)>> = drawn?.into_iter().collect();
        let clipped_variance = generated.clipped_variance;
        Ok(drawn.map(|drawn| {
            let (maps, slope_ratios) = drawn.into_iter().unzip();
            Self { maps, slope_ratios, clipped_variance }
        }))
    }

    /// Returns the root mean square of the ratios of Sdq.
    pub(super) fn slope_ratio(&self) -> f64 {
        let squares: f64 = self.slope_ratios.iter().map(|ratio| ratio * ratio).sum();
        (squares / self.slope_ratios.len() as f64).sqrt()
    }

    /// Returns the smallest and the largest ratio of Sdq.
    pub(super) fn slope_range(&self) -> (f64, f64) {
        let over = |pick: fn(f64, f64) -> f64, start| self.slope_ratios.iter().copied().fold(start, pick);
        (over(f64::min, f64::INFINITY), over(f64::max, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{SurfaceCovariance, Texture};
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::distribution::Marginal;
    use asperity_base::translation::TranslationKind;

    #[test]
    fn drawn_maps_have_the_expected_slopes() {
        let covariance = Covariance::new(CorrelationModel::Exponential, 1e-6, 8e-6, 5e-6).unwrap();
        let surface_covariance = SurfaceCovariance::Model(covariance);
        let translation = TranslationKind::Plain;
        let texture = Texture::Translated { covariance: surface_covariance, translation, expansion: None };
        let model = SurfaceModel { marginal: Marginal::normal(0.0, 1e-6).unwrap(), texture, shortest_wave_m: None };
        // A wave of slope 0.2 along x, sampled at 1 µm: what the maps are compared with.
        let grid = Grid::new(600, 120, 1e-6, 1e-6).unwrap();
        let wave = HeightMap::from_function(grid, |x, _| 4e-6 * (x / 2e-5).sin()).unwrap();
        let slopes = BandSlopes::new(&[&wave], 1e6).unwrap().unwrap();
        let trial = TrialMaps::draw(&model, 2.0, grid, Level::Plane, &slopes).unwrap().unwrap();
        assert_eq!(trial.maps.iter().map(|map| map.grid().shape()).collect::<Vec<_>>(), [(120, POINTS); 3]);
        // The closed form of the expectation, without sampling; three maps of some thousand patches each.
        let expected = 2.0 * slopes.ratio(&covariance, None);
        assert!((trial.slope_ratio() / expected - 1.0).abs() < 0.02, "{} {expected}", trial.slope_ratio());
        let (least, most) = trial.slope_range();
        assert!(least <= trial.slope_ratio() && trial.slope_ratio() <= most && trial.clipped_variance < 1e-12);
    }
}
