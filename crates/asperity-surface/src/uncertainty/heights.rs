//! Estimates of Sq, Sa, Ssk, Sku and Sdq: smooth functions of means over the map.

use super::cells::Cells;
use super::estimate::{Estimate, estimate};
use super::window::Window;
use asperity_base::stats::Interval;

/// Number of means that are fitted to the map before an influence is computed: the statistic and its scale.
pub(super) const FITTED: f64 = 2.0;

/// Kurtosis above which a map does not determine the spread of Ssk and Sku. Their intervals would have less than 90 %
/// coverage, as for lognormal heights of Sku 4.6 on thirty correlation lengths a side.
const LARGEST_SKU: f64 = 4.0;

/// Sums over each cell, over the number of present heights.
pub(super) struct HeightSums {
    /// Fraction of the points.
    pub(super) fraction: Vec<f64>,
    /// Scaled heights to the powers 1 to 4.
    pub(super) power: [Vec<f64>; 4],
    /// Absolute values and signs of the scaled heights.
    size: Vec<f64>,
    sign: Vec<f64>,
}

impl HeightSums {
    pub(super) fn of(cells: &Cells) -> Self {
        let sums = cells.sums_of_all(|point| {
            let v = cells.value(point);
            let sign = f64::from(i8::from(v > 0.0) - i8::from(v < 0.0));
            [v, v * v, v.powi(3), v.powi(4), v.abs(), sign]
        });
        let part = |k: usize| sums.iter().map(|sum| sum[k] / cells.count()).collect::<Vec<f64>>();
        Self { fraction: cells.fractions(), power: [part(0), part(1), part(2), part(3)], size: part(4), sign: part(5) }
    }

    /// Returns the influences on ⟨|v|⟩ over its value.
    pub(super) fn mean_size_influence(&self) -> Vec<f64> {
        let (mean, sign) = (total(&self.size), total(&self.sign));
        let term = |i: usize| (self.size[i] - mean * self.fraction[i] - sign * self.power[0][i]) / mean;
        (0..self.fraction.len()).map(term).collect()
    }

    /// Returns the influences on ⟨v²⟩.
    pub(super) fn sq_influence(&self) -> Vec<f64> {
        self.power[1].iter().zip(&self.fraction).map(|(square, fraction)| square - fraction).collect()
    }

    /// Returns the influences on Ssk.
    pub(super) fn ssk_influence(&self, ssk: f64) -> Vec<f64> {
        let term = |(i, square): (usize, f64)| {
            self.power[2][i] - ssk * self.fraction[i] - 3.0 * self.power[0][i] - 1.5 * ssk * square
        };
        self.sq_influence().into_iter().enumerate().map(term).collect()
    }

    /// Returns the influences on Sku.
    pub(super) fn sku_influence(&self, ssk: f64, sku: f64) -> Vec<f64> {
        let term = |(i, square): (usize, f64)| {
            self.power[3][i] - sku * self.fraction[i] - 4.0 * ssk * self.power[0][i] - 2.0 * sku * square
        };
        self.sq_influence().into_iter().enumerate().map(term).collect()
    }

    /// Returns the relative influences on ⟨v²⟩ of the surface, with the variance removed with the form.
    pub(super) fn restored_sq_influence(&self, removal: &Removal) -> Vec<f64> {
        let inflated = 1.0 / (1.0 - removal.fraction);
        self.sq_influence().iter().zip(&removal.influence).map(|(own, put)| own + inflated * put).collect()
    }

    /// Estimates Sq. The mean of v² is linear in the map except for the form, whose variance is restored.
    pub(super) fn sq(&self, window: &Window, sq_m: f64, removal: &Removal, tail: f64) -> Option<Estimate> {
        squared(window, &self.restored_sq_influence(removal), sq_m, 1.0 / (1.0 - removal.fraction), tail)
    }

    /// Estimates Sa, linear in the map except for the form.
    pub(super) fn sa(&self, window: &Window, sa_m: f64, removal: &Removal, tail: f64) -> Option<Estimate> {
        let kept = 1.0 - removal.fraction;
        let of_map = self.mean_size_influence();
        let influence: Vec<f64> =
            of_map.iter().zip(&removal.influence).map(|(own, put)| own + 0.5 * put / kept).collect();
        let spread = window.spread(&influence, FITTED)?;
        let (low, high) = spread.deviates(tail);
        let (centre, se) = (sa_m / kept.sqrt(), spread.variance.sqrt());
        let interval = Interval { low: centre * (1.0 - se * high), high: centre * (1.0 - se * low) };
        estimate(sa_m, centre, centre * se, interval, spread.blocks).filter(|e| e.interval.low > 0.0)
    }

    /// Estimates Ssk, on the scale arctan Ssk, on which its spread hardly depends on it: for Gamma distributions the
    /// standard error grows as 1 + 0.7 Ssk², for lognormal ones as 1 + 1.1 Ssk², at Ssk up to 1. The standard error
    /// needs sixth powers of the heights, and a map of a heavy-tailed surface has too few large ones. So there is no
    /// estimate above [`LARGEST_SKU`].
    pub(super) fn ssk(&self, window: &Window, ssk: f64, sku: f64, tail: f64) -> Option<Estimate> {
        let spread = window.spread(&self.ssk_influence(ssk), FITTED).filter(|_| sku <= LARGEST_SKU)?;
        let se = spread.variance.sqrt();
        let half = spread.student(tail) * se / (1.0 + ssk * ssk);
        let end = |sign: f64| (ssk.atan() + sign * half).tan();
        let finite = ssk.atan().abs() + half < std::f64::consts::FRAC_PI_2;
        estimate(ssk, ssk, se, Interval { low: end(-1.0), high: end(1.0) }, spread.blocks).filter(|_| finite)
    }

    /// Estimates Sku, on the scale 1/Sku³, on which its spread is uniform, under the same condition as Ssk.
    pub(super) fn sku(&self, window: &Window, ssk: f64, sku: f64, tail: f64) -> Option<Estimate> {
        let spread = window.spread(&self.sku_influence(ssk, sku), FITTED).filter(|_| sku <= LARGEST_SKU)?;
        let se = spread.variance.sqrt();
        let half = 3.0 * spread.student(tail) * se / sku;
        let end = |sign: f64| sku / (1.0 - sign * half).cbrt();
        estimate(sku, sku, se, Interval { low: end(-1.0), high: end(1.0) }, spread.blocks).filter(|_| half < 1.0)
    }
}

/// Fraction of a surface's variance that was removed with the form of a map.
pub(super) struct Removal {
    /// The fraction.
    pub(super) fraction: f64,
    /// Influences on the cells. A map whose long waves happen to be high gives too large a fraction, and is itself too
    /// high.
    pub(super) influence: Vec<f64>,
}

impl Removal {
    /// Computes the fraction for a form of `terms` free coefficients. Each removes the variance β of the map's mean,
    /// for heights of variance 1 after the removal: in total terms·β/(1 + terms·β) of the variance before it.
    pub(super) fn of(window: &Window, sums: &HeightSums, terms: f64) -> Self {
        let (mean_variance, parts) = window.mean_variance(&sums.power[0], terms);
        if mean_variance <= 0.0 {
            return Self::none(parts.len());
        }
        let slope = terms / (1.0 + terms * mean_variance).powi(2);
        let squares = sums.sq_influence();
        let influence = parts
            .iter()
            .zip(&sums.fraction)
            .zip(squares)
            .map(|((part, fraction), square)| slope * (part - mean_variance * fraction - mean_variance * square));
        Self { fraction: terms * mean_variance / (1.0 + terms * mean_variance), influence: influence.collect() }
    }

    /// Returns a removal of zero.
    pub(super) fn none(cells: usize) -> Self {
        Self { fraction: 0.0, influence: vec![0.0; cells] }
    }
}

/// Estimates Sdq by forward differences, whose square is a mean over the map.
pub(super) fn sdq(window: &Window, influence: &[f64], sdq: Option<f64>, tail: f64) -> Option<Estimate> {
    squared(window, influence, sdq?, 1.0, tail)
}

/// Returns the relative influences on the square of Sdq.
pub(super) fn sdq_influence(cells: &Cells) -> Vec<f64> {
    let grid = cells.grid();
    let nx = grid.nx();
    let rows = 0..grid.ny() - 1;
    let columns = 0..nx - 1;
    let slopes = cells.sums(&rows, &columns, |point| {
        if !(cells.is_present(point) && cells.is_present(point + 1) && cells.is_present(point + nx)) {
            return [0.0, 0.0];
        }
        let here = cells.value(point);
        let along_x = (cells.value(point + 1) - here) / grid.dx_m();
        let along_y = (cells.value(point + nx) - here) / grid.dy_m();
        [along_x * along_x + along_y * along_y, 1.0]
    });
    let (sum, count) = slopes.iter().fold((0.0, 0.0), |(sum, count), s| (sum + s[0], count + s[1]));
    let mean = sum / count;
    slopes.iter().map(|s| (s[0] - mean * s[1]) / sum).collect()
}

/// Estimates a root of a mean from the relative influences on the mean; `inflated` restores the variance removed
/// from the mean.
fn squared(window: &Window, influence: &[f64], root: f64, inflated: f64, tail: f64) -> Option<Estimate> {
    let spread = window.spread(influence, FITTED)?;
    let (low, high) = spread.deviates(tail);
    let (centre, se) = (root * inflated.sqrt(), spread.variance.sqrt());
    let end = |deviate: f64| centre * (1.0 - se * deviate).sqrt();
    estimate(root, centre, 0.5 * centre * se, Interval { low: end(high), high: end(low) }, spread.blocks)
}

pub(super) fn total(values: &[f64]) -> f64 {
    values.iter().sum()
}
