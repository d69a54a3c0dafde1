//! Variance of the sum of a correlated field that is given on cells.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_8};

use super::cells::dot;
use asperity_base::stats::Spread;
use asperity_base::stats::flat_top::{self, BLOCKS_TO_SPARE, FADED, LARGEST_FITTED, REACHES};

/// Longest distance between cells that a window spans.
const LONGEST: f64 = 24.0;
/// Largest fraction of the variance in the window that the mean of the heights may remove, whose own variance is
/// wanted; see [`LARGEST_FITTED`].
const LARGEST_REMOVED: f64 = 0.15;
/// Least number of blocks for an interval.
const LEAST_BLOCKS: f64 = 6.0;
/// Number of sectors of direction in which a correlogram is evaluated.
const SECTORS: usize = 4;

/// Pairs of cells: their lags, distances, and fractions of the points of the map.
pub(super) struct Window {
    rows: usize,
    columns: usize,
    length: f64,
    /// Area of a cell, or its side if only one axis is divided.
    cell: f64,
    plane: bool,
    /// Half of all lags, by distance; the first is zero.
    lags: Vec<Lag>,
}

struct Lag {
    right: isize,
    down: usize,
    distance: f64,
    sector: usize,
    /// 1 for the lag zero, 2 for the others, which stand for their opposites too.
    times: f64,
    /// Sum over the pairs of cells of the product of their fractions of the points.
    fraction: f64,
}

impl Window {
    /// Creates the pairs for the fraction of the points in each cell, the `step` between cells along x and y, and the
    /// correlation `length` of the heights.
    pub(super) fn new(rows: usize, columns: usize, step: (f64, f64), length: f64, fraction: &[f64]) -> Self {
        let plane = rows > 1 && columns > 1;
        let mut lags = vec![];
        for down in 0..rows {
            for right in 1 - columns as isize..columns as isize {
                let (x, y) = (right as f64 * step.0, down as f64 * step.1);
                let distance = x.hypot(y);
                if distance > LONGEST || (down == 0 && right < 0) {
                    continue;
                }
                let turn = ((y.atan2(x) + FRAC_PI_8) / FRAC_PI_4).floor() as usize % SECTORS;
                let times = if down == 0 && right == 0 { 1.0 } else { 2.0 };
                let fraction = products(fraction, columns, right, down);
                lags.push(Lag { right, down, distance, sector: turn, times, fraction });
            }
        }
        lags.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let cell = if plane { step.0 * step.1 } else { step.0.max(step.1) };
        Self { rows, columns, length, cell, plane, lags }
    }

    /// Computes the spread of a statistic whose error is the sum of its influences on the cells. They add up to zero
    /// because `fitted` means of the map replaced those of the surface.
    ///
    /// The variance is the sum of the products of influences over all pairs of cells, under a window of their distance
    /// that is flat and then falls to zero. It is corrected for the variance that the fitted means removed, and for the
    /// tail of an exponential correlogram beyond the window. The blocks are the degrees of freedom of that sum, reduced
    /// for heavy tails of the influence.
    ///
    /// Returns `None` if fewer than six blocks are left, or the influences are constant.
    ///
    /// # References
    /// Politis & Romano, *J. Time Ser. Anal.* **16** (1995) 67, <https://doi.org/10.1111/j.1467-9892.1995.tb00223.x>
    /// (flat-top windows); Lahiri, *Resampling Methods for Dependent Data*, Springer 2003, ch. 12 (blocks of spatial
    /// data).
    pub(super) fn spread(&self, influence: &[f64], fitted: f64) -> Option<Spread> {
        let reach = self.reach(influence);
        let spare = 2.0 * (self.cells() * self.cell / (5.76 * BLOCKS_TO_SPARE)).sqrt();
        let spare = if self.plane { spare } else { 0.75 * self.cells() * self.cell / BLOCKS_TO_SPARE };
        let least = flat_top::least_end(reach, self.length);
        let end = self.narrowed(spare.clamp(least, 2.0 * least).min(LONGEST), fitted, LARGEST_FITTED);
        let within: Vec<&Lag> = self.lags.iter().take_while(|lag| lag.distance < end).collect();
        let (mut sum, mut taken, mut squares) = (0.0, 0.0, 0.0);
        for lag in within {
            let weight = flat_top::weight(lag.distance, end);
            sum += weight * lag.times * products(influence, self.columns, lag.right, lag.down);
            taken += weight * lag.times * lag.fraction;
            squares += weight * weight * lag.times * lag.fraction;
        }
        let (third, fourth, blocks) = self.block_moments(influence, end.round() as usize);
        let tail = self.tail(end, reach / (1.0 / FADED).ln());
        let variance = sum / (1.0 - fitted * taken) / tail;
        let excess = (fourth - 3.0 / blocks).max(0.0);
        let freedom = 1.0 / (squares + 0.5 * excess);
        (variance > 0.0 && 1.0 / squares >= LEAST_BLOCKS).then_some(Spread {
            variance,
            blocks: freedom,
            skewness: third,
        })
    }

    /// Returns the covariance matrix of statistics from their influences ([`Window::spread`]). The correlation of two statistics a and b of
    /// variance 1 is (var(a + b) − var(a − b))/(var(a + b) + var(a − b)), which lies in −1 … 1. `None` if a statistic has no variance.
    pub(super) fn covariance<const K: usize>(&self, influences: &[Vec<f64>; K], fitted: f64) -> Option<[[f64; K]; K]> {
        let mut std = [0.0; K];
        for (std, influence) in std.iter_mut().zip(influences) {
            *std = self.spread(influence, fitted)?.variance.sqrt();
        }
        let mut covariance = [[0.0; K]; K];
        for i in 0..K {
            covariance[i][i] = std[i] * std[i];
            for j in 0..i {
                let scaled = |sign: f64| -> Vec<f64> {
                    influences[i].iter().zip(&influences[j]).map(|(a, b)| a / std[i] + sign * b / std[j]).collect()
                };
                let variance = |sign: f64| self.spread(&scaled(sign), fitted).map_or(0.0, |spread| spread.variance);
                let correlation = (variance(1.0) - variance(-1.0)) / (variance(1.0) + variance(-1.0));
                covariance[i][j] = correlation * std[i] * std[j];
                covariance[j][i] = covariance[i][j];
            }
        }
        Some(covariance)
    }

    /// Returns the variance of the mean of the heights over the variance of the remaining heights, after `terms`
    /// orthogonal means were removed. `heights` are the sums of the scaled heights on the cells over the number of
    /// points. Also returns the contribution of each cell: its height times those of its neighbours under the window.
    pub(super) fn mean_variance(&self, heights: &[f64], terms: f64) -> (f64, Vec<f64>) {
        let reach = self.reach(heights);
        let end = self.narrowed((REACHES * reach).clamp(2.0, LONGEST), terms, LARGEST_REMOVED);
        let mut taken = 0.0;
        let mut parts = vec![0.0; heights.len()];
        for lag in self.lags.iter().take_while(|lag| lag.distance < end) {
            let weight = flat_top::weight(lag.distance, end);
            taken += weight * lag.times * lag.fraction;
            // Half of a pair belongs to either cell.
            let shift = lag.down * self.columns;
            for here in 0..heights.len() - shift {
                let column = (here % self.columns).wrapping_add_signed(lag.right);
                if column < self.columns {
                    let there = (here + shift).wrapping_add_signed(lag.right);
                    let half = 0.5 * weight * lag.times * heights[here] * heights[there];
                    parts[here] += half;
                    parts[there] += half;
                }
            }
        }
        let scale = 1.0 / (1.0 - terms * taken) / self.tail(end, reach / (1.0 / FADED).ln());
        parts.iter_mut().for_each(|part| *part *= scale);
        (parts.iter().sum(), parts)
    }

    /// Returns the number of equally filled cells.
    fn cells(&self) -> f64 {
        1.0 / self.lags[0].fraction
    }

    /// Narrows a window until `fitted` means remove at most `largest` of the variance from it.
    fn narrowed(&self, mut end: f64, fitted: f64, largest: f64) -> f64 {
        let taken = |end: f64| {
            let within = self.lags.iter().take_while(|lag| lag.distance < end);
            within.map(|lag| flat_top::weight(lag.distance, end) * lag.times * lag.fraction).sum::<f64>()
        };
        while end > 2.0 && fitted * taken(end) > largest {
            end *= 0.95;
        }
        end
    }

    /// Returns the distance at which the correlogram first falls to [`FADED`], averaged over rings of pairs; the
    /// longest of all directions and of each sector.
    fn reach(&self, field: &[f64]) -> f64 {
        let mut rings = vec![[[0.0; 4]; SECTORS]; LONGEST as usize + 2];
        let mut ring_before = 0;
        let mut found = [None; SECTORS + 1];
        for lag in &self.lags {
            let ring = lag.distance.round() as usize;
            if ring > ring_before {
                for (which, reach) in found.iter_mut().enumerate().filter(|(_, reach)| reach.is_none()) {
                    *reach = crossing(&rings[..=ring_before], which);
                }
                ring_before = ring;
                if found.iter().all(Option::is_some) {
                    break;
                }
            }
            let product = products(field, self.columns, lag.right, lag.down);
            let sectors = if ring == 0 { 0..SECTORS } else { lag.sector..lag.sector + 1 };
            for sector in sectors {
                let [sum, fraction, distance, lags] = &mut rings[ring][sector];
                *sum += product;
                *fraction += lag.fraction;
                *distance += lag.distance;
                *lags += 1.0;
            }
        }
        found[SECTORS].unwrap_or(LONGEST)
    }

    /// Returns the fraction of the sum of an exponential correlogram of this decay that lies under the window.
    fn tail(&self, end: f64, decay: f64) -> f64 {
        let (half, full) = (0.5 * end / decay, end / decay);
        let zeroth = |x: f64| (-x).exp();
        let first = |x: f64| (1.0 + x) * (-x).exp();
        let second = |x: f64| (x * x + 2.0 * x + 2.0) * (-x).exp();
        let (low, high): (&dyn Fn(f64) -> f64, &dyn Fn(f64) -> f64) =
            if self.plane { (&first, &second) } else { (&zeroth, &first) };
        1.0 - low(half) + 2.0 * (low(half) - low(full)) - (high(half) - high(full)) / half
    }

    /// Returns Σ S³/(Σ S²)^{3/2}, Σ S⁴/(Σ S²)² and the number of square blocks of `side` cells with the sums S.
    fn block_moments(&self, influence: &[f64], side: usize) -> (f64, f64, f64) {
        let longest = if self.plane { self.rows.min(self.columns) } else { self.rows.max(self.columns) };
        let side = side.min(longest / 3).max(1);
        let (down, right) = (self.rows.div_ceil(side), self.columns.div_ceil(side));
        let mut sums = vec![0.0; down * right];
        for row in 0..self.rows {
            for column in 0..self.columns {
                sums[row / side * right + column / side] += influence[row * self.columns + column];
            }
        }
        let power = |n: i32| sums.iter().map(|s: &f64| s.powi(n)).sum::<f64>();
        let second = power(2);
        let filled = sums.iter().filter(|sum| **sum != 0.0).count();
        (power(3) / second.powf(1.5), power(4) / (second * second), filled as f64)
    }
}

/// Returns the sum of the products of the values of a cell and of the cell `right` and `down` of it.
fn products(values: &[f64], columns: usize, right: isize, down: usize) -> f64 {
    let rows = values.len() / columns;
    let from = (-right).max(0) as usize;
    let to = columns.saturating_add_signed(-right.max(0));
    let width = to - from;
    let mut sum = 0.0;
    for row in 0..rows.saturating_sub(down) {
        let here = &values[row * columns + from..][..width];
        let there = &values[((row + down) * columns + from).wrapping_add_signed(right)..][..width];
        sum += dot(here, there);
    }
    sum
}

/// Returns the distance at which the correlogram of one sector, or of all, crosses [`FADED`] on the last ring.
fn crossing(rings: &[[[f64; 4]; SECTORS]], which: usize) -> Option<f64> {
    let of = |ring: &[[f64; 4]; SECTORS]| {
        let chosen = if which < SECTORS { which..which + 1 } else { 0..SECTORS };
        let total = ring[chosen].iter().fold([0.0; 4], |sum, part| std::array::from_fn(|i| sum[i] + part[i]));
        (total[2] / total[3], total[0] / total[1])
    };
    let last = rings.len() - 1;
    let before = (0..last).rev().find(|ring| of(&rings[*ring]).1.is_finite())?;
    let ((_, zero), (near, above), (far, below)) = (of(&rings[0]), of(&rings[before]), of(&rings[last]));
    let (above, below) = (above / zero, below / zero);
    (below <= FADED).then(|| near + (above - FADED) / (above - below) * (far - near))
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;
    use asperity_base::stats::Moments;

    /// Returns means over discs of `radius` of white noise on a square of `side` cells: a field of known correlation.
    fn field(side: usize, radius: isize, index: u64) -> Vec<f64> {
        let wide = side + 2 * radius as usize;
        let white = random::standard_normal(&mut random::stream(31, "white", index), wide * wide);
        let mut values = vec![0.0; side * side];
        for row in 0..side {
            for column in 0..side {
                for y in -radius..=radius {
                    for x in -radius..=radius {
                        if x * x + y * y <= radius * radius {
                            let place = (row + radius as usize).wrapping_add_signed(y) * wide;
                            values[row * side + column] +=
                                white[place + (column + radius as usize).wrapping_add_signed(x)];
                        }
                    }
                }
            }
        }
        values
    }

    #[test]
    fn the_variance_of_a_mean_equals_that_of_the_underlying_white_noise() {
        let side = 48;
        let fraction = vec![1.0 / (side * side) as f64; side * side];
        let window = Window::new(side, side, (1.0, 1.0), 2.0, &fraction);
        // Discs of 1 and of 13 points: each white value counts once for each point of its disc, except near the edges.
        for (radius, points) in [(0, 1.0), (2, 13.0_f64)] {
            let spreads: Vec<Spread> = (0..60)
                .map(|index| {
                    let values = field(side, radius, index);
                    let mean = values.iter().sum::<f64>() / values.len() as f64;
                    let influence: Vec<f64> = values.iter().map(|v| (v - mean) * fraction[0]).collect();
                    window.spread(&influence, 1.0).unwrap()
                })
                .collect();
            let wanted = points * points * fraction[0];
            let found = Moments::new(&spreads.iter().map(|s| s.variance).collect::<Vec<_>>());
            let error = found.standard_error();
            // The allowance for an exponential tail is at most 5 % where there is none; edges remove up to 2·2/48.
            let ratio = found.mean / wanted;
            assert!(ratio > 0.91 - 3.0 * error / wanted && ratio < 1.06 + 3.0 * error / wanted, "{radius}: {ratio}");
            // The variance varies like χ² with the number of blocks as degrees of freedom.
            let blocks = Moments::new(&spreads.iter().map(|s| s.blocks).collect::<Vec<_>>()).mean;
            let ratio = found.std / found.mean * (0.5 * blocks).sqrt();
            assert!(ratio > 0.7 && ratio < 1.4, "{radius}: {ratio}");
        }
    }

    #[test]
    fn the_fraction_of_an_exponential_under_the_window_equals_its_integral() {
        for (columns, power) in [(9, 1), (1, 0)] {
            let fraction = vec![1.0 / (9 * columns) as f64; 9 * columns];
            let window = Window::new(9, columns, (1.0, 1.0), 1.0, &fraction);
            for (end, decay) in [(4.65, 1.0), (10.0, 1.5)] {
                let steps = 20_000;
                let step = end / f64::from(steps);
                let sum: f64 = (0..steps)
                    .map(|i| (f64::from(i) + 0.5) * step)
                    .map(|r| {
                        step * flat_top::weight(r, end) * (-r / decay).exp() * r.powi(power) / decay.powi(power + 1)
                    })
                    .sum();
                assert!((window.tail(end, decay) - sum).abs() < 1e-7, "{columns} {end}: {sum}");
            }
        }
    }

    #[test]
    fn a_window_of_radius_r_gives_the_blocks_of_its_squared_area() {
        // ∫ w² over the plane is 2π (½ + 5/12)(end/2)² = 5.76 (end/2)².
        let side = 64;
        let fraction = vec![1.0 / (side * side) as f64; side * side];
        let window = Window::new(side, side, (1.0, 1.0), 2.0, &fraction);
        let area: f64 = window.lags.iter().map(|lag| flat_top::weight(lag.distance, 10.0).powi(2) * lag.times).sum();
        assert!((area / (5.76 * 25.0) - 1.0).abs() < 0.01, "{area}");
        assert!((window.cells() / (side * side) as f64 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn limits_have_the_distance_of_the_quantile() {
        for skewness in [-0.4, 0.0, 1e-8, 0.3] {
            let spread = Spread { variance: 4.0, blocks: 17.0, skewness };
            let (low, high) = spread.deviates(0.025);
            assert!((spread.distance(2.0 * low, 0.025) + 1.0).abs() < 1e-6);
            assert!((spread.distance(2.0 * high, 0.025) - 1.0).abs() < 1e-6);
            // Student's quantile of 17 degrees of freedom.
            assert!((spread.student(0.025) - 2.109_815_577_833_317).abs() < 1e-9);
        }
    }
}
