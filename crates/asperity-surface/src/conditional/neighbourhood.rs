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
use rayon::prelude::*;

use self::embedding::embedded;
use self::groups::{Group, groups, work_per_point};
use self::metric::Metric;
use self::noise::{LEAST_NOISE, likeliest_noise};
use self::pyramid::Pyramid;
use super::lags::Lags;
use super::{ConditionalError, Standardised, check, map, places, scores};
use crate::gaussian::check_xi;
use crate::{RandomSurface, SpectralField};
use asperity_base::correlation::StationaryCovariance;
use asperity_base::law::Marginal;
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::{Cancelled, Monitor, Silent};

pub(crate) use embedding::LARGEST_DOMAIN;

/// Groups of missing points that are dealt with between two reports, for each thread.
const BLOCK: usize = 32;

/// Maps of a stationary Gaussian surface, given its heights at some points, by the heights around each void alone.
///
/// An unconditional map z is corrected by what it misses of the measured heights d (Matheron), void by void: at the missing
/// points of one,
///
/// z_d = z + K_{·n} (K_nn + τ²I)⁻¹ (d_n − z(x_n) − τε),
///
/// where n are some hundred heights around it instead of all, and the system is solved by a dense factor. The unconditional
/// map is one and the same for all voids, so neighbouring ones agree with each other as far as their neighbourhoods do.
///
/// *Neighbourhoods.* All heights within a few points of the void, and beyond them ever fewer, at a spacing that grows with the
/// distance, up to eight radii of the central lobe of the correlation or as far as it is above 0.1. Distances follow the
/// lobe, so with a lay they are longer along it. Small voids next to each other share a neighbourhood; one whose
/// neighbourhood would exceed some 2,000 heights is cut into parts that overlap and fade into each other.
///
/// *What it costs.* The law of a void and its neighbourhood together is exact, so slopes inside and steps across the edge are
/// those of the field; what is lost is agreement with heights outside of the neighbourhood. For exponential and Matérn
/// correlations with or without a lay the error variance exceeds that of conditioning on all heights by less than 1 %; for a
/// squared exponential, whose exact one runs from 1e-10 to 1 of σ² within a void, by up to 0.11 of σ²
/// (`docs/validation/filling.md`). Far from measured heights the unconditional law returns.
///
/// *Noise.* Smooth correlations are singular to rounding, so the heights are always allowed some noise: of the variances
/// from 1e-10 to 1e-2 of σ² the one that makes small patches of the heights likeliest, and at least the nugget given. For
/// heights with the correlation given it is the least one, which shows nowhere; heights rougher than their correlation would
/// otherwise have the voids swing.
///
/// The germ is that of the embedding, followed by one variable per measured height where there is more noise than the least.
/// No solve is iterative, so none fails to converge. The result is the same to the bit for any number of threads.
///
/// # References
/// Chilès & Delfiner, *Geostatistics* (2012), §3.6 (neighbourhoods) and §7.3 (conditioning by kriging),
/// <https://doi.org/10.1002/9781118136188>; Stein, *Ann. Stat.* **30** (2002) 298,
/// <https://doi.org/10.1214/aos/1015362194> (why near heights screen far ones).
#[derive(Debug)]
pub struct NeighbourhoodSurface {
    grid: Grid,
    field: SpectralField,
    lags: Lags,
    /// Places of the measured heights, and these as the Gaussian field sees them: less the mean, or scores.
    places: Vec<usize>,
    values: Vec<f64>,
    groups: Vec<Group>,
    measured: HeightMap,
    mean_m: f64,
    marginal: Option<Marginal>,
    /// Variance of the noise over that of the Gaussian field, and the standard deviation of this.
    noise: f64,
    std: f64,
}

impl NeighbourhoodSurface {
    /// Maps of mean `mean_m` on the grid of `measured` through the heights that are present there, with this covariance
    /// elsewhere, and noise of variance `nugget`·σ² on the heights. Measured heights stay as they are, bit by bit; with noise,
    /// what is drawn between them is the surface beneath it.
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

    /// As [`NeighbourhoodSurface::new`] for heights of the law `law`, in metre, over a Gaussian field of the correlation of
    /// `covariance`, whose standard deviation is not used.
    ///
    /// # Errors
    /// As there, and a law with a parameter outside its range or that makes a measured height impossible.
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

    /// Number of measured heights.
    pub fn measured_points(&self) -> usize {
        self.values.len()
    }

    /// Share of the variance that the embedding had to clip; see [`SpectralField::clipped_variance`].
    pub fn clipped_variance(&self) -> f64 {
        self.field.clipped_variance()
    }

    /// Variance of the noise on the measured heights over that of the field: the nugget, or what the heights have more.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// The maps of several germs of [`RandomSurface::xi_len`] values each. They share the factors of the neighbourhoods,
    /// so many at once take less time than one by one, and memory for each.
    ///
    /// # Errors
    /// Cancellation.
    ///
    /// # Panics
    /// If a germ has another length or a value that is not finite.
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

    /// The conditional mean; with a marginal law, the conditional median.
    ///
    /// # Errors
    /// Cancellation.
    pub fn kriging_mean(&self, monitor: &dyn Monitor) -> Result<HeightMap, Cancelled> {
        let mut mean = Array2::zeros(self.grid.shape());
        self.places
            .iter()
            .zip(&self.values)
            .for_each(|(p, value)| mean[[p / self.grid.nx(), p % self.grid.nx()]] = *value);
        let mut means = [mean];
        self.correct(std::slice::from_ref(&self.values), &mut means, monitor)?;
        let [mean] = means;
        Ok(self.heights(mean))
    }

    /// Adds to each map what its misses at the measured heights say at the missing points.
    fn correct(&self, misses: &[Vec<f64>], maps: &mut [Array2<f64>], monitor: &dyn Monitor) -> Result<(), Cancelled> {
        let nx = self.grid.nx();
        let mut done = 0;
        for block in self.groups.chunks(BLOCK * rayon::current_num_threads()) {
            monitor.progress("voids", done, self.groups.len());
            let corrections: Vec<Vec<f64>> = block
                .par_iter()
                .map(|group| if monitor.cancelled() { Vec::new() } else { self.corrections(group, misses) })
                .collect();
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

    /// Heights in metre of a Gaussian map; measured ones are put in as they are.
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
            _ => unreachable!("one xi makes one map, and nobody cancels"),
        }
    }
}
