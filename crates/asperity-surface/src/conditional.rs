//! Random surfaces through measured heights.

mod factor;
mod kernel;
mod neighbourhood;
#[cfg(test)]
mod tests;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use ndarray::Array2;
use thiserror::Error;

use self::kernel::{Kernel, SolveError};
pub(super) use self::neighbourhood::LARGEST_DOMAIN;
pub use self::neighbourhood::NeighbourhoodSurface;
use super::gaussian::check_germ;
use super::{GeneratorError, RandomSurface, SpectralField};
use asperity_base::correlation::StationaryCovariance;
use asperity_base::law::{LawError, Marginal, standard_normal_quantile};
use asperity_base::map::{Grid, HeightMap, MapError};
use asperity_base::monitor::Cancelled;

/// Measured heights up to which the dense algebra of the kriging variance is done.
const MOST_FOR_VARIANCE: usize = 2000;
/// Points whose variance is found at once.
const VARIANCE_POINTS: usize = 1024;

/// How measured heights are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioning {
    /// Mean of the heights in metre. Unused with a marginal law, which has its own.
    pub mean_m: f64,
    /// Variance of the noise of each measured height over the variance of the heights. At zero the maps pass through the
    /// measured heights; above, what is drawn is the surface beneath the noise.
    pub nugget: f64,
    /// Largest misfit at a measured height over the standard deviation.
    pub tolerance: f64,
    /// Most conjugate-gradient iterations of one solve.
    pub iterations: usize,
}

impl Default for Conditioning {
    fn default() -> Self {
        Self { mean_m: 0.0, nugget: 0.0, tolerance: 1e-8, iterations: 2000 }
    }
}

/// Why a surface could not be conditioned.
#[derive(Debug, Error)]
pub enum ConditionalError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// The weights of the measured heights did not settle.
    #[error(
        "the weights of {heights} measured heights did not settle in {iterations} iterations: a misfit of {misfit:.1e} \
         standard deviations is left, wanted {tolerance:.1e}. Heights this smooth hardly tell neighbours apart; allow them \
         noise (a nugget)"
    )]
    NotConverged {
        /// Measured heights.
        heights: usize,
        /// Iterations done.
        iterations: usize,
        /// Largest misfit over the standard deviation.
        misfit: f64,
        /// Misfit asked for.
        tolerance: f64,
    },
    /// A measured height is impossible under the marginal law.
    #[error("the height {height_m:e} m at row {row}, column {column} lies outside the support of the {law} law")]
    OutsideLaw {
        /// Row of the point.
        row: usize,
        /// Column of the point.
        column: usize,
        /// Height found in metre.
        height_m: f64,
        /// Name of the law.
        law: &'static str,
    },
    /// The variance needs dense algebra, which is for few heights.
    #[error("the kriging variance of {heights} measured heights needs dense algebra, which is for at most {most}")]
    TooMany {
        /// Measured heights.
        heights: usize,
        /// Most heights.
        most: usize,
    },
    /// The covariance between the measured heights is singular, so their kriging variance is not defined.
    #[error("the covariance of {heights} measured heights is singular; allow them noise (a nugget)")]
    Singular {
        /// Measured heights.
        heights: usize,
    },
    /// The marginal law.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The unconditional field.
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    /// The monitor cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Maps of a stationary Gaussian surface, given its heights at some points.
///
/// An unconditional map z is corrected by what it misses of the measured heights d (Matheron):
///
/// z_d = z + K_{·d} (K_dd + τ²I)⁻¹ (d − z(x_d) − τε),
///
/// which has the conditional mean and covariance exactly, with noise of variance τ² = nugget·σ² on the heights. The weights
/// are found by conjugate gradients, one solve per map. Products with K are convolutions on the domain of the circulant
/// embedding that also draws z, so that both have the same covariance; the preconditioner is a sparse factor of the inverse
/// in which every height, in an order from coarse to fine, depends on its few best correlated predecessors alone.
///
/// Maps of many smooth heights take long, or do not converge: [`NeighbourhoodSurface`] is for these.
///
/// Far from measured heights the unconditional law returns. The germ is that of [`SpectralField::free`], followed by one
/// variable per measured height for its noise when there is any.
///
/// With a marginal law F the measured heights are first turned into scores Φ⁻¹(F(d)), and what is drawn is turned back: a
/// translated surface given the heights, whose *Gaussian* correlation is the one given.
///
/// [`RandomSurface::generate`] cannot fail; where the solve does, it leaves the points missing that were to be drawn.
/// [`ConditionalSurface::draw`] says why.
///
/// # References
/// Journel & Huijbregts, *Mining Geostatistics* (1978), §VII.A (conditioning by kriging); Fritz, Neuweiler & Nowak,
/// *Math. Geosci.* **41** (2009) 509, <https://doi.org/10.1007/s11004-009-9220-x> (by FFT); Schäfer, Katzfuss & Owhadi,
/// *SIAM J. Sci. Comput.* **43** (2021) A2019, <https://doi.org/10.1137/20M1336254> (the sparse factor).
#[derive(Debug)]
pub struct ConditionalSurface {
    grid: Grid,
    field: SpectralField,
    kernel: Kernel,
    /// Measured heights, in row order, and as the Gaussian field sees them: less the mean, or scores.
    measured_m: Vec<f64>,
    values: Vec<f64>,
    law: Option<Marginal>,
    options: Conditioning,
    /// Standard deviation of the Gaussian field.
    std: f64,
}

impl ConditionalSurface {
    /// Maps on the grid of `measured` through the heights that are present there, with this covariance elsewhere.
    ///
    /// # Errors
    /// Options outside their ranges, or a grid without room for the embedding.
    pub fn new(
        covariance: &dyn StationaryCovariance,
        measured: &HeightMap,
        options: Conditioning,
    ) -> Result<Self, ConditionalError> {
        check("mean_m", options.mean_m, options.mean_m.is_finite(), "finite")?;
        let values = measured.present_m().map(|z| z - options.mean_m).collect();
        Self::assemble(covariance, measured, values, None, options)
    }

    /// As [`ConditionalSurface::new`] for heights of the law `law`, in metre, over a Gaussian field of the correlation of
    /// `covariance`, whose standard deviation is not used.
    ///
    /// # Errors
    /// A law with a parameter outside its range or that makes a measured height impossible.
    pub fn with_law(
        covariance: &dyn StationaryCovariance,
        measured: &HeightMap,
        law: &Marginal,
        options: Conditioning,
    ) -> Result<Self, ConditionalError> {
        let scores = scores(law, measured)?;
        Self::assemble(&Standardised(covariance), measured, scores, Some(law.clone()), options)
    }

    fn assemble(
        covariance: &dyn StationaryCovariance,
        measured: &HeightMap,
        values: Vec<f64>,
        law: Option<Marginal>,
        options: Conditioning,
    ) -> Result<Self, ConditionalError> {
        let (nugget, tolerance) = (options.nugget, options.tolerance);
        check("nugget", nugget, (0.0..=1.0).contains(&nugget), "in [0, 1]")?;
        check("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "in (0, 1)")?;
        check("iterations", options.iterations as f64, options.iterations > 0, "at least 1")?;
        let grid = measured.grid();
        let places = places(measured);
        let field = SpectralField::free(covariance, grid)?;
        let kernel = Kernel::new(field.modes(), grid, places, nugget);
        let measured_m = measured.present_m().collect();
        Ok(Self { grid, field, kernel, measured_m, values, law, options, std: covariance.std_m() })
    }

    /// Number of measured heights.
    pub fn measured_points(&self) -> usize {
        self.values.len()
    }

    /// Share of the variance that the embedding had to clip; see [`SpectralField::clipped_variance`].
    pub fn clipped_variance(&self) -> f64 {
        self.field.clipped_variance()
    }

    /// The map of one germ of [`RandomSurface::germ_len`] values.
    ///
    /// # Errors
    /// The weights of the measured heights do not settle.
    ///
    /// # Panics
    /// If the germ has another length or a value that is not finite.
    pub fn draw(&self, germ: &[f64]) -> Result<HeightMap, ConditionalError> {
        check_germ(germ, self.germ_len());
        let (of_field, of_noise) = germ.split_at(self.field.germ_len());
        let drawn = self.field.generate(of_field);
        let (ny, nx) = self.grid.shape();
        let drawn: Vec<f64> = drawn.heights_m().iter().copied().collect();
        let mut misses: Vec<f64> =
            self.kernel.places().iter().zip(&self.values).map(|(place, value)| value - drawn[*place]).collect();
        let noise = self.std * self.options.nugget.sqrt();
        for (miss, xi) in misses.iter_mut().zip(of_noise) {
            *miss -= noise * xi;
        }
        let mut correction = self.weighted(&misses)?;
        correction.iter_mut().zip(&drawn).for_each(|(z, drawn)| *z += drawn);
        Ok(self.heights(Array2::from_shape_fn((ny, nx), |(row, column)| correction[row * nx + column])))
    }

    /// The conditional mean, by simple kriging; with a marginal law, the conditional median.
    ///
    /// # Errors
    /// The weights of the measured heights do not settle.
    ///
    /// # References
    /// Matheron, *Economic Geology* **58** (1963) 1246, <https://doi.org/10.2113/gsecongeo.58.8.1246>.
    pub fn kriging_mean(&self) -> Result<HeightMap, ConditionalError> {
        let mean = self.weighted(&self.values)?;
        let (ny, nx) = self.grid.shape();
        Ok(self.heights(Array2::from_shape_fn((ny, nx), |(row, column)| mean[row * nx + column])))
    }

    /// The conditional variance in m², by dense algebra, shape `[ny, nx]`; with a marginal law, that of the scores.
    ///
    /// # Errors
    /// More than 2,000 measured heights, or heights whose covariance is singular.
    pub fn kriging_variance_m2(&self) -> Result<Array2<f64>, ConditionalError> {
        let heights = self.values.len();
        if heights > MOST_FOR_VARIANCE {
            return Err(ConditionalError::TooMany { heights, most: MOST_FOR_VARIANCE });
        }
        let places = self.kernel.places();
        let entry = |i: usize, j: usize| {
            let nugget = if i == j { self.options.nugget } else { 0.0 };
            self.kernel.correlation(places[i], places[j]) + nugget
        };
        let factor = Mat::from_fn(heights, heights, entry)
            .llt(Side::Lower)
            .map_err(|_| ConditionalError::Singular { heights })?;
        let (points, scale) = (self.grid.points(), self.std * self.std);
        let mut variance = Vec::with_capacity(points);
        for first in (0..points).step_by(VARIANCE_POINTS) {
            let count = VARIANCE_POINTS.min(points - first);
            let to_points = Mat::from_fn(heights, count, |i, j| self.kernel.correlation(places[i], first + j));
            let solved = factor.solve(&to_points);
            for j in 0..count {
                let known: f64 = (0..heights).map(|i| to_points[(i, j)] * solved[(i, j)]).sum();
                let own = self.kernel.correlation(first + j, first + j);
                variance.push(scale * (own - known).max(0.0));
            }
        }
        let nx = self.grid.nx();
        Ok(Array2::from_shape_fn(self.grid.shape(), |(row, column)| variance[row * nx + column]))
    }

    /// K_{·d} (K_dd + τ²I)⁻¹ of what the measured points miss.
    fn weighted(&self, misses: &[f64]) -> Result<Vec<f64>, ConditionalError> {
        // In correlations: the variance drops out of K_{·d} (K_dd + τ²I)⁻¹.
        let (tolerance, iterations) = (self.options.tolerance, self.options.iterations);
        self.kernel.interpolate(misses, self.std * tolerance, iterations).map_err(|error: SolveError| {
            ConditionalError::NotConverged {
                heights: misses.len(),
                iterations: error.iterations,
                misfit: error.misfit / self.std,
                tolerance,
            }
        })
    }

    /// Heights in metre of a Gaussian map; measured ones are put in as they are, unless they are noisy.
    fn heights(&self, gaussian: Array2<f64>) -> HeightMap {
        let mut heights = match &self.law {
            Some(law) => gaussian.mapv(|g| law.translate(g)),
            None => gaussian.mapv(|z| z + self.options.mean_m),
        };
        if self.options.nugget == 0.0 {
            self.put_measured(&mut heights);
        }
        map(self.grid, heights)
    }

    fn put_measured(&self, heights: &mut Array2<f64>) {
        let nx = self.grid.nx();
        for (place, height_m) in self.kernel.places().iter().zip(&self.measured_m) {
            heights[[place / nx, place % nx]] = *height_m;
        }
    }
}

impl RandomSurface for ConditionalSurface {
    fn germ_len(&self) -> usize {
        self.field.germ_len() + if self.options.nugget > 0.0 { self.values.len() } else { 0 }
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, germ: &[f64]) -> HeightMap {
        self.draw(germ).unwrap_or_else(|_| {
            let mut heights = Array2::from_elem(self.grid.shape(), f64::NAN);
            self.put_measured(&mut heights);
            map(self.grid, heights)
        })
    }
}

/// The map with `columns` more missing points on its left and on its right, and `rows` above and below: what is to be drawn
/// to extend it beyond its edges.
///
/// # Errors
/// Never for a valid map.
pub fn surrounded(map: &HeightMap, columns: usize, rows: usize) -> Result<HeightMap, MapError> {
    let inner = map.grid();
    let grid = Grid::new(inner.nx() + 2 * columns, inner.ny() + 2 * rows, inner.dx_m(), inner.dy_m())?;
    let mut heights = Array2::from_elem(grid.shape(), f64::NAN);
    heights.slice_mut(ndarray::s![rows..rows + inner.ny(), columns..columns + inner.nx()]).assign(map.heights_m());
    HeightMap::new(grid, heights)
}

/// The same correlation with a standard deviation of 1.
struct Standardised<'a>(&'a dyn StationaryCovariance);

impl StationaryCovariance for Standardised<'_> {
    fn std_m(&self) -> f64 {
        1.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.0.correlation(dx_m, dy_m)
    }

    fn mirror_symmetric(&self) -> bool {
        self.0.mirror_symmetric()
    }
}

fn check(parameter: &'static str, value: f64, valid: bool, wanted: &'static str) -> Result<(), ConditionalError> {
    if valid { Ok(()) } else { Err(ConditionalError::Parameter { parameter, value, wanted }) }
}

/// Φ⁻¹(F(x)) of the heights present, in row order.
pub(super) fn scores(law: &Marginal, measured: &HeightMap) -> Result<Vec<f64>, ConditionalError> {
    law.check()?;
    let present = measured.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan());
    let scores = present.map(|((row, column), &height_m)| {
        let score = score(law, height_m);
        let outside = ConditionalError::OutsideLaw { row, column, height_m, law: law.name() };
        if score.is_finite() { Ok(score) } else { Err(outside) }
    });
    scores.collect()
}

/// Φ⁻¹(F(x)), from the nearer tail; infinite outside the support.
fn score(law: &Marginal, x: f64) -> f64 {
    if let Marginal::Empirical { sorted } = law {
        // The last half steps are atoms at the least and the largest value.
        let (least, largest) = (sorted[0], sorted[sorted.len() - 1]);
        let half_step = 0.5 / sorted.len() as f64;
        let inside = (least..=largest).contains(&x);
        return if inside { standard_normal_quantile(law.cdf(x).clamp(half_step, 1.0 - half_step)) } else { f64::NAN };
    }
    let (lower, upper) = (law.cdf(x), law.survival(x));
    if lower <= upper { standard_normal_quantile(lower) } else { -standard_normal_quantile(upper) }
}

/// Places of the heights that are present, in row order.
fn places(map: &HeightMap) -> Vec<usize> {
    map.heights_m().iter().enumerate().filter(|(_, z)| !z.is_nan()).map(|(place, _)| place).collect()
}

fn map(grid: Grid, heights: Array2<f64>) -> HeightMap {
    match HeightMap::new(grid, heights) {
        Ok(map) => map,
        Err(_) => unreachable!("measured heights are present on the grid"),
    }
}
