//! Distributions fitted to the heights of a scan.

use asperity_base::correlation::Autocorrelation;
use asperity_base::distribution::fit::{Family, Fit, Ranking, rank_by_aic};
use asperity_base::distribution::{DistributionError, Marginal};
use asperity_base::map::HeightMap;
use asperity_base::stats::sorted_present;

/// Largest number of fitted heights; larger maps are represented by equally spaced order statistics.
const MOST_FITTED: usize = 16_384;
/// Smallest and largest correlation at which the lobe around zero may end.
const LOW: f64 = 0.02;
const HIGH: f64 = 0.2;
/// Difference of Akaike's criterion from which a distribution is better than the normal one.
const BETTER: f64 = 2.0;
/// Probability below which heights differ from a distribution.
const SIGNIFICANT: f64 = 0.05;

/// Returns the effective sample size of the heights of a map: its area over ∬ρ, between 1 and the number of present heights.
///
/// The integral covers the lobe of the correlation around zero: the connected lags with a correlation above twice the standard
/// error √(Σρ²/N) of a lag, at least 0.02 and at most 0.2. Estimates at larger lags are noise. For a slowly falling exponential
/// correlation this leaves out a tenth. If the correlation becomes negative, as on filtered maps, the integral covers the lobe
/// alone, because the whole integral describes the precision of the mean, which is better than that of other statistics. The
/// removal of the mean of the map, ρ̂ = (ρ − β)/(1 − β) with β = 1/n_eff, is accounted for.
pub(crate) fn effective_heights(correlation: &Autocorrelation) -> f64 {
    let present = correlation.present() as f64;
    let squares = Lobe::of(correlation, HIGH).squares;
    let lobe = Lobe::of(correlation, (2.0 * (squares / present).sqrt()).clamp(LOW, HIGH));
    let (products, pairs) = (lobe.products / (present * present), lobe.pairs / (present * present));
    let fraction = products / (1.0 - pairs + products);
    fraction.recip().clamp(1.0, present)
}

/// Sums over the lags that are connected with zero by correlations above a level.
#[derive(Debug, Clone, Copy, Default)]
struct Lobe {
    /// Pairs of points.
    pairs: f64,
    /// Correlations times pairs.
    products: f64,
    /// Squared correlations.
    squares: f64,
}

impl Lobe {
    fn of(correlation: &Autocorrelation, level: f64) -> Self {
        let (reach_x, reach_y) = correlation.reach();
        let (reach_x, reach_y) = (reach_x as isize, reach_y as isize);
        let width = 2 * reach_x + 1;
        let place = |x: isize, y: isize| ((y + reach_y) * width + x + reach_x) as usize;
        let mut seen = vec![false; (width * (2 * reach_y + 1)) as usize];
        let mut waiting = vec![(0, 0)];
        seen[place(0, 0)] = true;
        let mut sums = Self::default();
        while let Some((x, y)) = waiting.pop() {
            let (rho, pairs) = (correlation.correlation(x, y), correlation.pairs(x, y));
            sums.pairs += pairs;
            sums.products += pairs * rho;
            sums.squares += rho * rho;
            for (x, y) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                let within = x.abs() <= reach_x && y.abs() <= reach_y && !seen[place(x, y)];
                if within && correlation.correlation(x, y) > level {
                    seen[place(x, y)] = true;
                    waiting.push((x, y));
                }
            }
        }
        sums
    }
}

/// Fits of the distributions [`Family::HEIGHTS`] to the heights of a scan.
#[derive(Debug, Clone)]
pub struct HeightFits {
    /// Present heights in metre, sorted.
    pub sorted_m: Vec<f64>,
    /// Fits in the order of Akaike's criterion, the best first.
    pub ranking: Ranking,
}

impl HeightFits {
    /// Fits the heights of a map with this autocorrelation.
    pub fn new(map: &HeightMap, correlation: &Autocorrelation) -> Self {
        Self::with_effective_size(map.present_m(), effective_heights(correlation))
    }

    /// Fits heights in metre that carry as much information as `effective_size` independent ones.
    pub fn with_effective_size(heights_m: impl Iterator<Item = f64>, effective_size: f64) -> Self {
        let sorted_m = sorted_present(heights_m);
        let stride = sorted_m.len().div_ceil(MOST_FITTED).max(1);
        let thinned: Vec<f64> = sorted_m.iter().copied().skip(stride / 2).step_by(stride).collect();
        let ranking = rank_by_aic(&Family::HEIGHTS, &thinned, Some(effective_size));
        Self { sorted_m, ranking }
    }

    /// Returns the distribution of the heights of random surfaces: the normal distribution unless another one of [`Family::HEIGHTS`] fits
    /// better by more than 2 in Akaike's criterion at the effective sample size, which a likelihood-ratio test at 5 % requires; else the
    /// best of them, unless the heights differ from it too (Anderson and Darling, 5 %); else the distribution of the heights
    /// themselves.
    ///
    /// The contact rests on the few highest points of a scan. A smooth distribution estimates them from all points.
    ///
    /// # Errors
    /// The heights have no distribution.
    pub fn marginal(self) -> Result<Marginal, DistributionError> {
        let Self { sorted_m, ranking } = self;
        let criterion = |fit: &Fit| fit.aic_correlated(ranking.effective_size);
        let least = ranking.fits.first().map_or(f64::NAN, criterion);
        let normal = ranking.fits.iter().find(|fit| fit.family == Family::Normal);
        if let Some(normal) = normal.filter(|normal| criterion(normal) - least <= BETTER) {
            return Ok(normal.marginal.clone());
        }
        let is_adequate = |place: &usize| {
            let distance = ranking.distance(*place).and_then(|goodness| goodness.anderson_darling);
            distance.is_some_and(|distance| distance.p_value >= SIGNIFICANT)
        };
        match ranking.place().filter(is_adequate) {
            Some(place) => Ok(ranking.fits[place].marginal.clone()),
            None => Marginal::empirical(sorted_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::map::Grid;
    use asperity_base::random;
    use ndarray::Array2;

    fn white(nx: usize, ny: usize) -> Vec<f64> {
        random::standard_normal(&mut random::stream(41, "height fits", 0), nx * ny)
    }

    #[test]
    fn repeated_heights_count_once() {
        // Blocks of 4 × 4 equal heights: ρ is a triangle whose integral is the block, so n_eff is the number of blocks.
        let (blocks, side) = (32, 128);
        let heights = white(blocks, blocks);
        let block = Array2::from_shape_fn((side, side), |(row, column)| heights[row / 4 * blocks + column / 4]);
        let map = HeightMap::new(Grid::new(side, side, 1.0, 1.0).unwrap(), block).unwrap();
        let found = effective_heights(&Autocorrelation::estimate(&map).unwrap());
        // Σρ over 7 × 7 lags scatters by 7/√N·…, a few percent; the tail of the triangle below the level is lost.
        assert!((0.85..1.2).contains(&(found / (blocks * blocks) as f64)), "{found}");
    }
}
