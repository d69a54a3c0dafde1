//! Random surfaces through the measured heights around each void.

mod embedding;
mod groups;
mod metric;
mod noise;
mod pyramid;
mod system;
#[cfg(test)]
mod tests;

use ndarray::Array2;

use self::embedding::embedded;
use self::groups::{Group, groups, work_per_point};
use self::metric::Metric;
use self::noise::{LEAST_NOISE, likeliest_noise};
use self::pyramid::Pyramid;
use super::lags::Lags;
use super::{ConditionalError, Standardised, check, map, places, scores};
use crate::gaussian::check_xi;
use crate::{RandomSurface, SpectralField};
use asperity_base::blocks;
use asperity_base::correlation::StationaryCovariance;
use asperity_base::distribution::Marginal;
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::{Cancelled, Monitor, Silent};

pub(crate) use embedding::LARGEST_DOMAIN;

/// Number of groups of missing points between two progress reports, for each thread.
const BLOCK: usize = 32;

/// Random maps of a stationary Gaussian surface conditioned on heights at some points, by the heights around each void.
///
/// An unconditional map z is corrected by its differences from the measured heights d (Matheron), void by void. At the
/// missing points of a void
///
/// z_d = z + K_{·n} (K_nn + τ²I)⁻¹ (d_n − z(x_n) − τε),
///
/// where n are some hundred heights around the void, and a dense factorisation solves the system. The unconditional
/// map is the same for all voids, so neighbouring voids agree with each other as far as their neighbourhoods agree.
///
/// *Neighbourhoods.* A neighbourhood contains all heights within a few points of the void. Beyond, it contains fewer
/// heights at a spacing that grows with the distance, up to eight radii of the central lobe of the correlation or as
/// far as the correlation is above 0.1. Distances are scaled by the lobe, so they are longer along a lay. Small
/// adjacent voids share a neighbourhood. If a neighbourhood would exceed some 2,000 heights, the void is divided into
/// overlapping parts with smooth transitions.
///
/// *Accuracy.* The joint distribution of a void and its neighbourhood is exact, so slopes inside and steps across the
/// edge have the distribution of the field. Only the dependence on heights outside of the neighbourhood is lost.
/// Compared with conditioning on all heights, the error variance is larger by less than 1 % for exponential and Matérn
/// correlations, with or without a lay. For a squared exponential, whose exact error variance ranges from 1e-10 to 1 of
/// σ² within a void, it is larger by up to 0.11 of σ² (`docs/validation/filling.md`). Far from measured heights the
/// distribution is unconditional.
///
/// *Noise.* Smooth correlations are singular to rounding, so the model always includes noise on the heights. Its
/// variance, from 1e-10 to 1e-2 of σ², maximises the likelihood of small patches of the heights, and is at least the
/// given nugget. For heights with the given correlation it is the least, which has no visible effect. Heights rougher
/// than their correlation would otherwise cause oscillations in the voids.
///
/// ξ contains the variables of the embedding, followed by one variable per measured height if the noise exceeds the
/// least. No solve is iterative, so none fails to converge. The result is bit-identical for any number of threads.
///
/// # References
/// Chilès & Delfiner, *Geostatistics* (2012), §3.6 (neighbourhoods) and §7.3 (conditioning by kriging),
/// <https://doi.org/10.1002/9781118136188>; Stein, *Ann. Stat.* **30** (2002) 298,
/// <https://doi.org/10.1214/aos/1015362194> (screening of far heights by near ones).
#[derive(Debug)]
pub struct NeighbourhoodSurface {
    grid: Grid,
    field: SpectralField,
    lags: Lags,
    /// Places of the measured heights, and their Gaussian values: heights minus the mean, or normal scores.
    places: Vec<usize>,
    values: Vec<f64>,
    groups: Vec<Group>,
    measured: HeightMap,
    mean_m: f64,
    marginal: Option<Marginal>,
    /// Variance of the noise over the variance of the Gaussian field, and the standard deviation of the field.
    noise: f64,
    std: f64,
}

impl NeighbourhoodSurface {
    /// Creates random maps of mean `mean_m` on the grid of `measured` that contain its present heights and have this
    /// covariance, with noise of variance `nugget`·σ² on the heights. Measured heights are kept bit by bit. With noise,
    /// the heights between them are those of the underlying surface.
    ///
    /// # Errors
    /// Parameters outside their ranges, a grid without room for the embedding, or cancellation.
    pub fn new(
        covariance: &dyn StationaryCovariance,
        measured: &HeightMap,
        mean_m: f64,
        nugget: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, ConditionalError> {
        check("mean_m", mean_m, mean_m.is_finite(), "finite")?;
        let values = measured.present_m().map(|z| z - mean_m).collect();
        Self::assemble(covariance, measured, (mean_m, values), None, nugget, monitor)
    }

    /// Creates a surface like [`NeighbourhoodSurface::new`] for heights of the distribution `marginal`, in metre, over
    /// a Gaussian field with the correlation of `covariance`, whose standard deviation is not used.
    ///
    /// # Errors
    /// The errors of [`NeighbourhoodSurface::new`]; an invalid distribution, or one under which a measured height is
    /// impossible.
    pub fn with_marginal(
        covariance: &dyn StationaryCovariance,
        measured: &HeightMap,
        marginal: &Marginal,
        nugget: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, ConditionalError> {
        let scores = scores(marginal, measured)?;
        Self::assemble(&Standardised(covariance), measured, (0.0, scores), Some(marginal.clone()), nugget, monitor)
    }

    fn assemble(
        covariance: &dyn StationaryCovariance,
        measured: &HeightMap,
        (mean_m, values): (f64, Vec<f64>),
        marginal: Option<Marginal>,
        nugget: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, ConditionalError> {
        check("nugget", nugget, (0.0..=1.0).contains(&nugget), "in [0, 1]")?;
        let (grid, places, std) = (measured.grid(), places(measured), covariance.std_m());
        let field = embedded(covariance, grid)?;
        let lags = Lags::of(field.modes());
        let noise = likeliest_noise(&lags, grid, &places, &values, std * std).max(nugget);
        let pyramid = Pyramid::new(Metric::of(&lags, grid), grid, places);
        let groups = groups(&pyramid, grid, work_per_point(measured.missing_points()), monitor)?;
        Ok(Self {
            grid,
            field,
            lags,
            places: pyramid.into_places(),
            values,
            groups,
            measured: measured.clone(),
            mean_m,
            marginal,
            noise,
            std,
        })
    }

    /// Returns the fraction of the variance that the embedding clipped; see [`SpectralField::clipped_variance`].
    pub fn clipped_variance(&self) -> f64 {
        self.field.clipped_variance()
    }

    /// Returns the variance of the noise on the measured heights over the variance of the field: the nugget, or the
    /// estimate if larger.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// Generates the maps of several ξ of [`RandomSurface::xi_len`] values each. They share the factors of the
    /// neighbourhoods, so many maps together take less time than one by one, but more memory.
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
        let noise_std = self.std * self.noise.sqrt();
        let (mut drawn, mut misses) = (Vec::new(), Vec::new());
        for xi in xis {
            if monitor.cancelled() {
                return Err(Cancelled);
            }
            check_xi(&xi, self.xi_len());
            let (of_field, of_noise) = xi.split_at(self.field.xi_len());
            let map = self.field.generate(of_field).heights_m().clone();
            let flat = map.as_slice().unwrap_or_default();
            let mut missed: Vec<f64> =
                self.places.iter().zip(&self.values).map(|(p, value)| value - flat[*p]).collect();
            missed.iter_mut().zip(of_noise).for_each(|(miss, xi)| *miss -= noise_std * xi);
            misses.push(missed);
            drawn.push(map);
        }
        self.correct(&misses, &mut drawn, monitor)?;
        Ok(drawn.into_iter().map(|gaussian| self.heights(gaussian)).collect())
    }

    /// Corrects each map at the missing points by its differences from the measured heights.
    fn correct(&self, misses: &[Vec<f64>], maps: &mut [Array2<f64>], monitor: &dyn Monitor) -> Result<(), Cancelled> {
        let nx = self.grid.nx();
        let mut done = 0;
        for block in self.groups.chunks(BLOCK * rayon::current_num_threads()) {
            monitor.progress("voids", done, self.groups.len());
            let corrections: Vec<Vec<f64>> = blocks::map(0..block.len(), |group| {
                if monitor.cancelled() { Vec::new() } else { self.corrections(&block[group], misses) }
            });
            if monitor.cancelled() {
                return Err(Cancelled);
            }
            for (group, corrections) in block.iter().zip(&corrections) {
                for (place, of_maps) in group.targets.iter().zip(corrections.chunks_exact(misses.len())) {
                    let at = [*place as usize / nx, *place as usize % nx];
                    maps.iter_mut().zip(of_maps).for_each(|(map, correction)| map[at] += correction);
                }
            }
            done += block.len();
        }
        monitor.progress("voids", self.groups.len(), self.groups.len());
        Ok(())
    }

    /// Returns the heights in metre of a Gaussian map, with the measured heights inserted.
    fn heights(&self, gaussian: Array2<f64>) -> HeightMap {
        let mut heights = match &self.marginal {
            Some(marginal) => gaussian.mapv(|g| marginal.translate(g)),
            None => gaussian.mapv(|z| z + self.mean_m),
        };
        heights.zip_mut_with(self.measured.heights_m(), |z, measured| {
            if !measured.is_nan() {
                *z = *measured;
            }
        });
        map(self.grid, heights)
    }
}

impl RandomSurface for NeighbourhoodSurface {
    fn xi_len(&self) -> usize {
        self.field.xi_len() + if self.noise > LEAST_NOISE { self.values.len() } else { 0 }
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        let drawn = self.draw([xi.to_vec()], &Silent);
        match drawn.map(|mut maps| maps.pop()) {
            Ok(Some(map)) => map,
            _ => unreachable!("one ξ gives one map, and nothing cancels"),
        }
    }
}
