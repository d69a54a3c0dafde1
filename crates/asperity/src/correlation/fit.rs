//! Covariance models fitted to the autocorrelation of a map.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::estimate::{Autocorrelation, Axis, first_crossing};
use super::least_squares::{Range, minimise};
use super::model::{CorrelationModel, Covariance, CovarianceError};

/// Correlation below which lags say little and the fit stops.
const LEAST_CORRELATION: f64 = 0.1;
/// Share of the map beyond which lags rest on too few independent pairs.
const LARGEST_LAG_SHARE: f64 = 0.25;
/// Lags along each axis, and along each side of the two-dimensional set, that enter the fit at most.
const AXIS_LAGS: usize = 48;
const PLANE_LAGS: usize = 10;
/// Share of the variance in the map's mean from which a fit is called an extrapolation.
const LARGE_MEAN_SHARE: f64 = 0.25;
/// A length may reach this many sizes of the map where its axis decays, and where it does not.
const LONGEST: [f64; 2] = [1.0, 10.0];
/// Sizes of a map in lengths below which it is called short, and the asymmetry from which its lay is called oblique.
const FEW_LENGTHS: f64 = 10.0;
const OBLIQUE: f64 = 0.1;
/// A model with one more parameter must lower the misfit by this share to be ranked before.
const PARSIMONY: f64 = 0.25;
/// Of models that are the same function, as Matérn and self-affine for ν < 1, the one named first in the list is taken.
const TIE: f64 = 1e-6;

/// Why no covariance could be fitted.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// No family of models was named.
    #[error("no family of covariance models to fit")]
    NoFamily,
    /// Neighbouring heights are nearly uncorrelated: noise, or a correlation length below the pitch.
    #[error(
        "the correlation of neighbours along {axis} is {correlation:.3}, below 1/e: the map is noise there, or its \
         correlation length is shorter than the pitch of {pitch_m:e} m"
    )]
    Unresolved {
        /// Axis along which it happens.
        axis: Axis,
        /// Correlation at one point's distance.
        correlation: f64,
        /// Pitch along that axis in metre.
        pitch_m: f64,
    },
    /// The correlation falls to 1/e along neither axis within half of the map.
    #[error(
        "within half of the map the correlation falls only to {least_x:.3} along x and {least_y:.3} along y, not to 1/e: \
         the map is shorter than a few correlation lengths, or still has form to remove"
    )]
    NotDecayed {
        /// Least correlation along x.
        least_x: f64,
        /// Least correlation along y.
        least_y: f64,
    },
    /// A fitted parameter makes no covariance.
    #[error(transparent)]
    Covariance(#[from] CovarianceError),
}

/// What to know before a fit is used.
#[derive(Debug, Clone, PartialEq)]
pub enum FitWarning {
    /// Along this axis the correlation does not fall to 1/e within half of the map, so its length is extrapolated.
    NotDecayed {
        /// Axis along which it happens.
        axis: Axis,
        /// Least correlation within half of the map.
        least: f64,
    },
    /// The map is fewer than ten fitted lengths long, so its correlation rests on few independent patches.
    FewLengths {
        /// Axis along which it happens.
        axis: Axis,
        /// Size of the map over the fitted length.
        lengths: f64,
    },
    /// By the best fit more than a quarter of the surface's variance went with the map's mean: lengths and variance are
    /// extrapolated. Form may remain, or the surface has no roll-off within the map.
    LargeMeanShare {
        /// [`CovarianceFit::mean_share`] of the best fit.
        share: f64,
    },
    /// The correlation at (x, y) and (−x, y) differs: the lay runs at an angle to the axes, which the models, even in x and
    /// y, average away. Rotate the map first.
    ObliqueLay {
        /// Root mean square of half the difference over the lags used.
        asymmetry: f64,
    },
}

impl fmt::Display for FitWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotDecayed { axis, least } => write!(
                f,
                "along {axis} the correlation falls only to {least:.2} within half of the map: its length is extrapolated"
            ),
            Self::FewLengths { axis, lengths } => write!(
                f,
                "along {axis} the map is only {lengths:.1} correlation lengths long: few patches are independent"
            ),
            Self::LargeMeanShare { share } => write!(
                f,
                "{:.0} % of the surface's variance went with the map's mean, by the fit: form may remain, or the surface has \
                 no roll-off within the map",
                100.0 * share
            ),
            Self::ObliqueLay { asymmetry } => write!(
                f,
                "the lay runs at an angle to the axes (correlations of mirrored lags differ by {:.2} rms), which the models \
                 average away: rotate the map first",
                2.0 * asymmetry
            ),
        }
    }
}

/// One model fitted to a map.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceFit {
    /// The covariance of the surface from which the map is a sample. Its variance is that of the heights divided by
    /// 1 − [`CovarianceFit::mean_share`].
    pub covariance: Covariance,
    /// Weighted root mean square of estimated minus fitted correlation over the lags used.
    pub misfit: f64,
    /// Fitted parameters: two lengths, and ν or H where the model has one.
    pub parameters: usize,
    /// Share of the variance that went with the map's mean, according to the model.
    pub mean_share: f64,
}

/// All models fitted to a map, the best first.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceFits {
    /// Ranked by misfit; a model with one more parameter comes first only if it lowers the misfit by a quarter, because a
    /// free shape always fits part of the sampling noise.
    pub fits: Vec<CovarianceFit>,
    /// Largest lag used along x in metre.
    pub largest_lag_x_m: f64,
    /// Largest lag used along y in metre.
    pub largest_lag_y_m: f64,
    /// Number of lags used.
    pub lags: usize,
    /// What to know before use.
    pub warnings: Vec<FitWarning>,
}

impl CovarianceFits {
    /// The covariance ranked first.
    pub fn best(&self) -> Covariance {
        self.fits[0].covariance
    }

    /// The fit of the model with this name, as in study files.
    pub fn named(&self, name: &str) -> Option<&CovarianceFit> {
        self.fits.iter().find(|fit| fit.covariance.model().name() == name)
    }
}

/// One lag that enters the fit.
struct Lag {
    x_m: f64,
    y_m: f64,
    correlation: f64,
    /// Square root of the number of pairs, over the root of their sum.
    weight: f64,
}

/// A family of correlation models, whose shape parameter is to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CorrelationFamily {
    /// [`CorrelationModel::SquaredExponential`].
    SquaredExponential,
    /// [`CorrelationModel::Exponential`].
    Exponential,
    /// [`CorrelationModel::SelfAffine`] with H in [0.05, 0.995].
    SelfAffine,
    /// [`CorrelationModel::Matern`] with ν in [0.05, 50].
    Matern,
}

impl CorrelationFamily {
    /// All families.
    pub const ALL: [Self; 4] = [Self::SquaredExponential, Self::Exponential, Self::SelfAffine, Self::Matern];

    /// Range and start of the shape parameter, if there is one.
    fn shape(self) -> Option<(Range, f64)> {
        match self {
            Self::SquaredExponential | Self::Exponential => None,
            Self::SelfAffine => Some((Range { low: 0.05, high: 0.995 }, 0.7)),
            Self::Matern => Some((Range { low: 0.05, high: 50.0 }, 1.0)),
        }
    }

    /// The model of a shape parameter, the third of `parameters`.
    fn model(self, parameters: &[f64]) -> CorrelationModel {
        match (self, parameters.get(2)) {
            (Self::SquaredExponential, _) => CorrelationModel::SquaredExponential,
            (Self::SelfAffine, Some(&hurst)) => CorrelationModel::SelfAffine { hurst },
            (Self::Matern, Some(&nu)) => CorrelationModel::Matern { nu },
            (Self::Exponential | Self::SelfAffine | Self::Matern, _) => CorrelationModel::Exponential,
        }
    }
}

/// Fits `families` to an estimated autocorrelation and ranks them.
///
/// Lags run along x, along y and over a coarse set between, each axis up to where its correlation first falls below 0.1
/// and at most to a quarter of the map; a lag weighs as many pairs as it has. Lags (x, y) and (−x, y) are averaged: the
/// models are even, and a lay at an angle to the axes is not represented.
///
/// Because the map's own mean was removed, the estimate tends to (ρ(h) − β)/(1 − β), β the mean of ρ over all pairs of
/// points of the map. That is what is fitted, so lengths are not biased short.
///
/// # Errors
/// No family, neighbours nearly uncorrelated along an axis, or no decay along either.
pub fn fit_covariance(estimate: &Autocorrelation, families: &[CorrelationFamily]) -> Result<CovarianceFits, FitError> {
    if families.is_empty() {
        return Err(FitError::NoFamily);
    }
    let sides = [Side::survey(estimate, Axis::X)?, Side::survey(estimate, Axis::Y)?];
    if sides.iter().all(|side| !side.decayed) {
        return Err(FitError::NotDecayed { least_x: sides[0].least, least_y: sides[1].least });
    }
    let (lags, asymmetry) = collect_lags(estimate, &sides);
    let mut fits = Vec::new();
    for family in families {
        fits.push(fit_family(*family, &sides, &lags, estimate.variance_m2())?);
    }
    rank(&mut fits);
    Ok(CovarianceFits {
        warnings: warnings(&sides, &fits[0], asymmetry),
        fits,
        largest_lag_x_m: sides[0].reach as f64 * sides[0].pitch_m,
        largest_lag_y_m: sides[1].reach as f64 * sides[1].pitch_m,
        lags: lags.len(),
    })
}

/// What the correlation along one axis says before any fit.
struct Side {
    axis: Axis,
    pitch_m: f64,
    size_m: f64,
    /// Whether it falls to 1/e within half of the map.
    decayed: bool,
    /// Least correlation within half of the map.
    least: f64,
    /// Lags that enter the fit.
    reach: usize,
    /// First guess of the length in metre.
    start_m: f64,
}

impl Side {
    fn survey(estimate: &Autocorrelation, axis: Axis) -> Result<Self, FitError> {
        let grid = estimate.grid();
        let (points, pitch_m) = match axis {
            Axis::X => (grid.nx(), grid.dx_m()),
            Axis::Y => (grid.ny(), grid.dy_m()),
        };
        let profile = estimate.along(axis);
        if profile[1].is_nan() || profile[1] < (-1.0_f64).exp() {
            return Err(FitError::Unresolved { axis, correlation: profile[1], pitch_m });
        }
        let half = &profile[..points.div_ceil(2).max(2)];
        let least = half.iter().copied().filter(|v| !v.is_nan()).fold(1.0, f64::min);
        let length = first_crossing(half, (-1.0_f64).exp());
        // A correlation that only falls to c at the half has ℓ ≈ half/ln(1/c) if exponential.
        let guess = length.unwrap_or((half.len() - 1) as f64 / -(least.min(0.999).ln()));
        let faded = half.iter().position(|v| *v < LEAST_CORRELATION).unwrap_or(usize::MAX);
        let share = (LARGEST_LAG_SHARE * points as f64).ceil() as usize;
        Ok(Self {
            axis,
            pitch_m,
            size_m: points as f64 * pitch_m,
            decayed: length.is_some(),
            least,
            reach: faded.min(share).clamp(2.min(points - 1), points - 1),
            start_m: guess * pitch_m,
        })
    }

    fn range(&self) -> Range {
        let longest = if self.decayed { LONGEST[0] } else { LONGEST[1] };
        Range { low: 0.1 * self.pitch_m, high: longest * self.size_m }
    }
}

fn fit_family(
    family: CorrelationFamily,
    sides: &[Side; 2],
    lags: &[Lag],
    variance_m2: f64,
) -> Result<CovarianceFit, FitError> {
    let mut start: Vec<f64> = sides.iter().map(|side| side.start_m).collect();
    let mut ranges: Vec<Range> = sides.iter().map(Side::range).collect();
    if let Some((range, value)) = family.shape() {
        start.push(value);
        ranges.push(range);
    }
    let mean_share =
        |model: CorrelationModel, p: &[f64]| mean_correlation(model, sides[0].size_m / p[0], sides[1].size_m / p[1]);
    let residuals = |p: &[f64]| {
        let model = family.model(p);
        let beta = mean_share(model, p);
        lags.iter()
            .map(|lag| {
                let rho = model.correlation((lag.x_m / p[0]).hypot(lag.y_m / p[1]));
                lag.weight * ((rho - beta) / (1.0 - beta) - lag.correlation)
            })
            .collect::<Vec<f64>>()
    };
    let (found, sum) = minimise(&residuals, &start, &ranges);
    let model = family.model(&found);
    let mean_share = mean_share(model, &found);
    let std_m = (variance_m2 / (1.0 - mean_share)).sqrt();
    Ok(CovarianceFit {
        covariance: Covariance::new(model, std_m, found[0], found[1])?,
        misfit: sum.sqrt(),
        parameters: found.len(),
        mean_share,
    })
}

fn warnings(sides: &[Side; 2], best: &CovarianceFit, asymmetry: f64) -> Vec<FitWarning> {
    let mut warnings = Vec::new();
    let lengths = [best.covariance.length_x_m(), best.covariance.length_y_m()];
    for (side, length_m) in sides.iter().zip(lengths) {
        if !side.decayed {
            warnings.push(FitWarning::NotDecayed { axis: side.axis, least: side.least });
        }
        if side.size_m < FEW_LENGTHS * length_m {
            warnings.push(FitWarning::FewLengths { axis: side.axis, lengths: side.size_m / length_m });
        }
    }
    if best.mean_share > LARGE_MEAN_SHARE {
        warnings.push(FitWarning::LargeMeanShare { share: best.mean_share });
    }
    if asymmetry > OBLIQUE {
        warnings.push(FitWarning::ObliqueLay { asymmetry });
    }
    warnings
}

/// Lags 1 … `reach`, at most `most` of them, evenly spread.
fn spread(reach: usize, most: usize) -> Vec<isize> {
    let count = reach.min(most);
    let mut lags: Vec<isize> = (1..=count).map(|i| ((i * reach) as f64 / count as f64).round() as isize).collect();
    lags.dedup();
    lags
}

/// The lags that enter the fit, and the root mean square of half the difference between (x, y) and (−x, y).
fn collect_lags(estimate: &Autocorrelation, sides: &[Side; 2]) -> (Vec<Lag>, f64) {
    let grid = estimate.grid();
    let reach = [sides[0].reach, sides[1].reach];
    let mut places: Vec<(isize, isize)> = Vec::new();
    places.extend(spread(reach[0], AXIS_LAGS).into_iter().map(|lag| (lag, 0)));
    places.extend(spread(reach[1], AXIS_LAGS).into_iter().map(|lag| (0, lag)));
    for y in spread(reach[1], PLANE_LAGS) {
        for x in spread(reach[0], PLANE_LAGS) {
            if (x as f64 / reach[0] as f64).hypot(y as f64 / reach[1] as f64) <= 1.0 {
                places.push((x, y));
            }
        }
    }
    let mut lags: Vec<Lag> = places
        .iter()
        .filter_map(|&(x, y)| {
            let (right, left) = (estimate.pairs(x, y), estimate.pairs(-x, y));
            let sum = |pairs: f64, value: f64| if pairs > 0.0 { pairs * value } else { 0.0 };
            let total = sum(right, estimate.correlation(x, y)) + sum(left, estimate.correlation(-x, y));
            let pairs = right + left;
            (pairs > 0.0).then(|| Lag {
                x_m: x as f64 * grid.dx_m(),
                y_m: y as f64 * grid.dy_m(),
                correlation: total / pairs,
                weight: pairs,
            })
        })
        .collect();
    let (mut squares, mut compared) = (0.0, 0.0);
    for (x, y) in places.into_iter().filter(|(x, y)| *x > 0 && *y > 0) {
        let difference = 0.5 * (estimate.correlation(x, y) - estimate.correlation(-x, y));
        if !difference.is_nan() {
            squares += difference * difference;
            compared += 1.0;
        }
    }
    let asymmetry = if compared > 0.0 { (squares / compared).sqrt() } else { 0.0 };
    let all: f64 = lags.iter().map(|lag| lag.weight).sum();
    for lag in &mut lags {
        lag.weight = (lag.weight / all).sqrt();
    }
    (lags, asymmetry)
}

/// Mean of ρ over all pairs of points of a rectangle of `a` × `b` scaled lengths: the variance share of the mean.
///
/// 4/(ab) ∬ (1 − x/a)(1 − y/b) ρ(√(x² + y²)) dx dy over the quarter, by the midpoint rule after x = a u³, which is fine
/// near zero where ρ varies.
fn mean_correlation(model: CorrelationModel, a: f64, b: f64) -> f64 {
    const NODES: usize = 16;
    let node = |i: usize| {
        let u = (i as f64 + 0.5) / NODES as f64;
        (u.powi(3), 3.0 * u * u / NODES as f64 * (1.0 - u.powi(3)))
    };
    let mut sum = 0.0;
    for i in 0..NODES {
        let (x, weight_x) = node(i);
        for j in 0..NODES {
            let (y, weight_y) = node(j);
            sum += weight_x * weight_y * model.correlation((a * x).hypot(b * y));
        }
    }
    (4.0 * sum).clamp(0.0, 1.0 - 1e-9)
}

/// Sorts by misfit, a model with p parameters counting as (1 + 25 %)^p worse.
fn rank(fits: &mut Vec<CovarianceFit>) {
    let mut scored: Vec<(f64, CovarianceFit)> = fits
        .drain(..)
        .enumerate()
        .map(|(place, fit)| {
            let score = fit.misfit * (1.0 + PARSIMONY).powi(fit.parameters as i32) * (1.0 + TIE * place as f64);
            (score, fit)
        })
        .collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    fits.extend(scored.into_iter().map(|(_, fit)| fit));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Grid, HeightMap};
    use crate::random;

    #[test]
    fn the_variance_share_of_a_mean_is_known_for_a_squared_exponential() {
        // It factorises: ∫₀¹ 2(1 − u) e^{−(au)²} du = √π erf(a)/a − (1 − e^{−a²})/a².
        let share = |a: f64| {
            let erf = 2.0 * crate::law::standard_normal_cdf(a * 2_f64.sqrt()) - 1.0;
            std::f64::consts::PI.sqrt() * erf / a + (-a * a).exp_m1() / (a * a)
        };
        for (a, b) in [(0.3, 0.5), (2.0, 2.0), (10.0, 4.0), (30.0, 50.0)] {
            let found = mean_correlation(CorrelationModel::SquaredExponential, a, b);
            assert!((found / (share(a) * share(b)) - 1.0).abs() < 0.01, "{a} {b}: {found}");
        }
    }

    #[test]
    fn noise_is_an_error_and_names_the_axis() {
        let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
        let noise = random::standard_normal(&mut random::stream(1, "noise", 0), grid.points());
        let map = HeightMap::new(grid, ndarray::Array2::from_shape_vec(grid.shape(), noise).unwrap()).unwrap();
        let error = fit_covariance(&Autocorrelation::estimate(&map).unwrap(), &CorrelationFamily::ALL).unwrap_err();
        assert!(matches!(error, FitError::Unresolved { axis: Axis::X, .. }), "{error}");
    }

    #[test]
    fn a_slope_that_was_not_removed_is_an_error_or_a_warning() {
        let plane = |points: usize| {
            let grid = Grid::new(points, points, 1.0, 1.0).unwrap();
            let map = HeightMap::from_function(grid, |x, y| x + y).unwrap();
            fit_covariance(&Autocorrelation::estimate(&map).unwrap(), &CorrelationFamily::ALL)
        };
        // Of 5 points, half the map holds two lags, where the profile −2 … 2 has the correlation −1/6
        // and the plane ½(1 − 1/6).
        let error = plane(5).unwrap_err();
        assert!(
            matches!(error, FitError::NotDecayed { least_x, .. } if (least_x - 5.0 / 12.0).abs() < 1e-12),
            "{error}"
        );
        let warnings = plane(64).unwrap().warnings;
        assert!(warnings.iter().any(|w| matches!(w, FitWarning::LargeMeanShare { .. })), "{warnings:?}");
    }
}
