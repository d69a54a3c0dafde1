//! Spectra over blocks of wavevectors, compared with spectra of maps.

use asperity_base::correlation::{Block, BlockSpectrum, CorrelationModel, Covariance};
use asperity_base::map::Grid;
use asperity_base::random;
use asperity_surface::{RandomSurface, SpectralField};

#[test]
fn the_expected_density_equals_the_mean_density_of_maps() {
    // With folded tails, the window and a lay: the mean density of each block over 24 maps is compared with its
    // expectation.
    for covariance in [
        Covariance::new(CorrelationModel::Exponential, 1.0, 6.0, 6.0).unwrap(),
        Covariance::new(CorrelationModel::Matern { nu: 1.0 }, 1.0, 3.0, 12.0).unwrap(),
    ] {
        let field = SpectralField::free(&covariance, Grid::new(128, 96, 1.0, 1.0).unwrap()).unwrap();
        let maps: Vec<BlockSpectrum> = (0..24)
            .map(|index| {
                let xi = random::standard_normal(&mut random::stream(3, "blocks", index), field.xi_len());
                BlockSpectrum::new(&field.generate(&xi)).unwrap()
            })
            .collect();
        let (mut squares, mut compared) = (0.0, 0.0);
        for first in maps[0].blocks() {
            // The ends of the reliable bands differ, so a block may be incomplete in some maps. Steep blocks have more
            // samples.
            let same =
                |block: &&Block| block.degrees_of_freedom == first.degrees_of_freedom && block.samples == first.samples;
            let found: Vec<&Block> = maps.iter().filter_map(|map| map.blocks().iter().find(same)).collect();
            if found.len() < maps.len() {
                continue;
            }
            let mean = found.iter().map(|block| block.density_m4).sum::<f64>() / 24.0;
            let freedom = 24.0 * found[0].degrees_of_freedom;
            let wanted = maps[0].expected_m4(first, &covariance);
            // The standard error of the mean, plus 4 % for the samples that represent a block.
            squares += (mean / wanted - 1.0).powi(2) / (2.0 / freedom + 0.04_f64.powi(2));
            compared += 1.0;
        }
        assert!(compared > 40.0 && squares / compared < 2.0, "{covariance:?}: {} of {compared}", squares / compared);
    }
}
