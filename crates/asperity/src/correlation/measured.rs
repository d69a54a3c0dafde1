//! The measured covariance itself, without a model.

mod positive;
mod taper;
#[cfg(test)]
mod tests;

use ndarray::Array2;
use thiserror::Error;

use self::positive::{PositiveCorrelation, Spline, made_positive};
use self::taper::Taper;
use super::estimate::Autocorrelation;
use super::model::StationaryCovariance;

/// Independent patches N/Σρ² of a map below which its correlation is not known.
const FEWEST_PATCHES: f64 = 10.0;

/// Why an autocorrelation makes no covariance.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeasuredCovarianceError {
    /// The correlation reaches so far that the map is a sample of a few patches.
    #[error(
        "the correlation reaches so far that the map holds only {patches:.1} independent patches, at least {wanted} are \
         needed: it is too short for its roughness or still has form to remove"
    )]
    FewPatches {
        /// Points over the sum of squared correlations, N/Σρ².
        patches: f64,
        /// Patches needed.
        wanted: f64,
    },
    /// Lags next to zero rest on no pair of present heights.
    #[error("no two neighbouring heights are present, so the correlation near zero is unknown")]
    NoPairs,
}

/// What was done to an autocorrelation to make it a covariance. All correlations are over the variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredReport {
    /// Share of the variance that went with the map's mean; lags and variance are corrected for it.
    pub mean_share: f64,
    /// Standard error of a lag near zero in a field without correlation there, √(Σρ²/N).
    pub standard_error: f64,
    /// Largest lag along x, over all directions, up to which the estimate is used as it stands, in metre.
    pub reliable_x_m: f64,
    /// Largest lag along y up to which the estimate is used as it stands, in metre.
    pub reliable_y_m: f64,
    /// Whether the correlation decays along x within the map. Otherwise the taper shortened it.
    pub decayed_x: bool,
    /// Whether the correlation decays along y within the map.
    pub decayed_y: bool,
    /// Largest change of a lag by the taper.
    pub taper_change: f64,
    /// Share of the variance in negative values of the tapered spectrum, which were set to zero.
    pub clipped_variance: f64,
    /// Largest change of a lag by the clipping and the scaling back to the variance.
    pub clipping_change: f64,
}

/// The covariance of a measured map: its own autocorrelation, made a covariance function.
///
/// Five steps lead from an [`Autocorrelation`] to it, and [`MeasuredReport`] says what they changed:
///
/// 1. *Mean.* Because the map's mean was removed, the estimate tends to (ρ − β)/(1 − β), β the mean of ρ over all pairs of
///    points; with lags beyond the taper counted as zero β follows from the estimate itself, and ρ and σ² are put back.
/// 2. *Taper.* Lags count fully up to where they fall into their own standard error √(Σρ²/N), N the pairs of a lag
///    (Bartlett), and not at all beyond twice that, or beyond half of the map. Distance is measured by the ellipse of the
///    central lobe ρ > 0.2, so that a lay at any angle is followed. The flat top leaves short lags as they are. Along an
///    axis on which the lobe reaches beyond a quarter of the map, or on both when nothing falls into noise, as on a periodic
///    surface, Bohman's window over the whole side takes the place of the flat top: positive semi-definite itself, it
///    shortens the correlation smoothly instead of cutting it.
/// 3. *Clipping.* Negative values of the tapered spectrum are set to zero.
/// 4. *Factor.* The root of that spectrum is a moving average, cut where the taper ends; the covariance is the correlation
///    of this finite sequence with itself, so it is positive semi-definite on the whole lattice, and ends at twice the
///    taper. It is scaled to the variance.
/// 5. *Interpolation* by cubic B-splines, which pass through the lags. The spline's spectrum is that of the lags times a
///    positive factor that cuts off beyond their Nyquist wavenumber: it stays positive semi-definite at every pitch, and
///    invents no roughness on a finer one.
///
/// ρ(−x, −y) = ρ(x, y); ρ(−x, y) may differ.
///
/// # References
/// Politis & Romano, *J. Time Ser. Anal.* **16** (1995) 67, <https://doi.org/10.1111/j.1467-9892.1995.tb00223.x>;
/// Politis, *J. Nonparametr. Stat.* **15** (2003) 517, <https://doi.org/10.1080/10485250310001604659> (flat-top tapers and
/// where to end them); Unser, *IEEE Signal Process. Mag.* **16** (6) (1999) 22, <https://doi.org/10.1109/79.799930> (splines).
#[derive(Debug, Clone)]
pub struct MeasuredCovariance {
    std_m: f64,
    spline: Spline,
    dx_m: f64,
    dy_m: f64,
    report: MeasuredReport,
}

impl MeasuredCovariance {
    /// The covariance of the map from which `estimate` was made.
    ///
    /// # Errors
    /// A map of few independent patches, or no pair of neighbours.
    pub fn new(estimate: &Autocorrelation) -> Result<Self, MeasuredCovarianceError> {
        let grid = estimate.grid();
        if estimate.pairs(1, 0) + estimate.pairs(0, 1) == 0.0 {
            return Err(MeasuredCovarianceError::NoPairs);
        }
        let taper = Taper::of(estimate);
        let patches = taper.standard_error().powi(-2);
        if patches < FEWEST_PATCHES {
            return Err(MeasuredCovarianceError::FewPatches { patches, wanted: FEWEST_PATCHES });
        }
        let mean_share = mean_share(estimate, &taper);
        // Rows are lags 0 … along y, columns all lags along x.
        let (reach_x, reach_y) = taper.reach();
        let mut taper_change = 0.0_f64;
        let tapered = Array2::from_shape_fn((reach_y + 1, 2 * reach_x + 1), |(row, column)| {
            let (lag_x, lag_y) = (column as isize - reach_x as isize, row as isize);
            let estimated = estimate.correlation(lag_x, lag_y);
            if estimated.is_nan() {
                return 0.0;
            }
            let rho = (1.0 - mean_share) * estimated + mean_share;
            let weight = taper.weight(lag_x, lag_y);
            taper_change = taper_change.max(((1.0 - weight) * rho).abs());
            weight * rho
        });
        let PositiveCorrelation { spline, clipped_variance, largest_change } = made_positive(&tapered);
        let (reliable_x_m, reliable_y_m) = taper.reliable_m();
        let (decayed_x, decayed_y) = taper.decayed();
        let report = MeasuredReport {
            mean_share,
            standard_error: taper.standard_error(),
            reliable_x_m,
            reliable_y_m,
            decayed_x,
            decayed_y,
            taper_change,
            clipped_variance,
            clipping_change: largest_change,
        };
        let std_m = (estimate.variance_m2() / (1.0 - mean_share)).sqrt();
        Ok(Self { std_m, spline, dx_m: grid.dx_m(), dy_m: grid.dy_m(), report })
    }

    /// What was changed on the way.
    pub fn report(&self) -> MeasuredReport {
        self.report
    }

    /// Covariance σ²ρ at the lag (dx, dy) in metre, in m².
    pub fn value_m2(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.std_m * self.std_m * self.correlation(dx_m, dy_m)
    }

    /// Lags along x and y in metre beyond which the covariance is zero.
    pub fn support_m(&self) -> (f64, f64) {
        let (x, y) = self.spline.reach();
        (x as f64 * self.dx_m, y as f64 * self.dy_m)
    }
}

impl StationaryCovariance for MeasuredCovariance {
    fn std_m(&self) -> f64 {
        self.std_m
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        if dx_m == 0.0 && dy_m == 0.0 { 1.0 } else { self.spline.value(dx_m / self.dx_m, dy_m / self.dy_m) }
    }
}

/// The mean β of ρ over all pairs of points, from the estimate (ρ − β)/(1 − β) within the taper w and zero beyond it.
///
/// With N pairs at a lag, β = Σ N w ((1 − β)ρ̂ + β)/Σ N, which is linear in β.
fn mean_share(estimate: &Autocorrelation, taper: &Taper) -> f64 {
    let (reach_x, reach_y) = estimate.reach();
    let (reach_x, reach_y) = (reach_x as isize, reach_y as isize);
    // Every point makes a pair with every other and with itself.
    let all = (estimate.present() as f64).powi(2);
    let (mut weights, mut products) = (0.0, 0.0);
    for lag_y in 0..=reach_y {
        // A lag and its opposite.
        let times = if lag_y == 0 { 1.0 } else { 2.0 };
        for lag_x in -reach_x..=reach_x {
            let pairs = times * estimate.pairs(lag_x, lag_y);
            let weight = taper.weight(lag_x, lag_y);
            if weight > 0.0 && pairs > 0.0 {
                weights += pairs * weight;
                products += pairs * weight * estimate.correlation(lag_x, lag_y);
            }
        }
    }
    let (weights, products) = (weights / all, products / all);
    // An oscillating correlation may come out below zero, which no variance of a mean can be.
    (products / (1.0 - weights + products)).max(0.0)
}
