//! Estimates of the lengths at which the correlation falls to a level.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::cells::Cells;
use super::estimate::{Estimate, estimate};
use super::heights::{HeightSums, Removal};
use super::window::Window;
use asperity_base::correlation::Axis;
use asperity_base::numeric::try_root_between;
use asperity_base::stats::{Interval, Spread};

/// Number of means that are fitted to the map before the influence on a correlation is computed: heights, squares and
/// products.
const FITTED: f64 = 3.0;
/// Number of directions over half a turn in the search of Sal.
const DIRECTIONS: usize = 12;
/// Accuracy of the ends of an interval in points.
const RESOLVED: f64 = 1e-6;
/// Ratio of successive lengths in the search along a direction.
const STRIDE: f64 = 1.25;

/// A lag in points along x and y.
type Lag = (isize, usize);

/// Data for the estimates of lengths.
pub(super) struct Lengths<'a> {
    cells: &'a Cells,
    window: &'a Window,
    sums: &'a HeightSums,
    removal: &'a Removal,
    /// Probability beyond either end of an interval.
    tail: f64,
    /// Returns the correlation of the surface at a lag minus a level, and its influences on the cells.
    known: RefCell<BTreeMap<Lag, (f64, Vec<f64>)>>,
}

impl<'a> Lengths<'a> {
    pub(super) fn new(
        cells: &'a Cells,
        window: &'a Window,
        sums: &'a HeightSums,
        removal: &'a Removal,
        tail: f64,
    ) -> Self {
        Self { cells, window, sums, removal, tail, known: RefCell::default() }
    }

    /// Estimates the length over which the correlation along an axis falls to 1/e; `value_m` is the length of the map.
    ///
    /// A test rejects a length if the mean of z(x)z(x + τ) − z²(x)/e over the map is farther from zero than its spread
    /// allows. The interval contains the lengths that are not rejected. It needs no slope of the correlation, and the
    /// mean is linear in the averaged products.
    ///
    /// Between whole lags the product is a weighted sum of those at the two neighbours. The length of the map is that of
    /// a linear correlation, and longer than that of a convex one: by 5 % for a squared exponential of 1.5 points. The
    /// map does not determine the shape between lags, so the upper end is that of a linear correlation and the lower
    /// end that of a convex one. Returns `None` if the test does not reject a length of one point, below which no lag
    /// lies.
    pub(super) fn along(&self, axis: Axis, value_m: Option<f64>) -> Option<Estimate> {
        let level = (-1.0_f64).exp();
        let value_m = value_m?;
        let grid = self.cells.grid();
        let (pitch_m, limit) = match axis {
            Axis::X => (grid.dx_m(), grid.nx() / 2),
            Axis::Y => (grid.dy_m(), grid.ny() / 2),
        };
        let lag = |k: usize| match axis {
            Axis::X => (k as isize, 0),
            Axis::Y => (0, k),
        };
        let at = |parts: [(usize, f64); 2]| parts.map(|(k, weight)| (lag(k), weight));
        let difference = |length: f64| self.mixed(at(linear(length)), level);
        let distance = |parts: [(usize, f64); 2]| {
            let (difference, spread) = self.tested_mixed(at(parts), level)?;
            Some(spread.distance(difference, self.tail))
        };
        let inside = (value_m / pitch_m).floor() as usize;
        if inside + 1 > limit {
            return None;
        }
        let low = outward(inside + 1, 1, |length| distance(convex(length, level)).map(|d| 1.0 - d))?;
        let high = outward(inside, limit, |length| distance(linear(length)).map(|d| 1.0 + d))?;
        let centre = outward(inside, limit, difference)?;
        let (_, spread) = self.tested_mixed(at(linear(centre)), level)?;
        // The mean slope of the correlation over the interval converts the spread of a correlation into that of a
        // length.
        let (near, far) = (low.floor(), high.ceil());
        let error = spread.variance.sqrt() * (far - near) / (difference(near)? - difference(far)?);
        // With a long tail behind a fall over the first lags the linear correlation can have the shorter length.
        let interval = Interval { low: low.min(centre) * pitch_m, high: high * pitch_m };
        estimate(value_m, centre * pitch_m, error * pitch_m, interval, spread.blocks)
    }

    /// Estimates Sal, the shortest length over all directions at which the correlation falls to 0.2; `guess_m` are
    /// lengths along x and y of that order.
    ///
    /// The shortest of many estimates is too short. The lower end is the shortest lower end of all directions. The
    /// upper end is the shortest upper end, with simultaneous limits for all directions, which is conservative. Returns
    /// `None` if the lower end is below the shortest lag.
    pub(super) fn sal(&self, sal_m: Option<f64>, guess_m: [Option<f64>; 2]) -> Option<Estimate> {
        let (sal_m, level) = (sal_m?, 0.2);
        let mut shortest: Option<(f64, f64, f64)> = None;
        let (mut low, mut high) = (f64::INFINITY, f64::INFINITY);
        for direction in 0..DIRECTIONS {
            let turn = std::f64::consts::PI * direction as f64 / DIRECTIONS as f64;
            let Some(ray) = self.ray(turn, level, guess_m) else { continue };
            let (_, spread) = self.tested(ray.lag, level)?;
            let relative = spread.variance.sqrt() / ray.slope_per_m / ray.length_m;
            low = low.min(ray.length_m * (-spread.student(self.tail) * relative).exp());
            high = high.min(ray.length_m * (spread.student(self.tail / DIRECTIONS as f64) * relative).exp());
            if shortest.is_none_or(|(length_m, ..)| ray.length_m < length_m) {
                shortest = Some((ray.length_m, relative * ray.length_m, spread.blocks));
            }
        }
        let (centre, se, blocks) = shortest?;
        let grid = self.cells.grid();
        if low < grid.dx_m().min(grid.dy_m()) {
            return None;
        }
        estimate(sal_m, centre, se, Interval { low, high }, blocks)
    }

    /// Returns the interval of the correlation at a lag, on the scale artanh ρ, on which the spread hardly depends on ρ
    /// and no end reaches ±1.
    pub(super) fn correlation(&self, lag: Lag) -> Option<Interval> {
        if lag == (0, 0) {
            return Some(Interval { low: 1.0, high: 1.0 });
        }
        let correlation = self.difference(lag, 0.0)?;
        let (_, spread) = self.tested(lag, correlation)?;
        let half = spread.student(self.tail) * spread.variance.sqrt() / (1.0 - correlation * correlation);
        let end = |sign: f64| (correlation.atanh() + sign * half).tanh();
        let interval = Interval { low: end(-1.0), high: end(1.0) };
        (interval.low <= interval.high).then_some(interval)
    }

    /// Returns the correlation of the surface at a lag, minus a level; `None` without pairs.
    fn difference(&self, lag: Lag, level: f64) -> Option<f64> {
        if let Some((correlation, _)) = self.known.borrow().get(&lag) {
            return Some(correlation - level);
        }
        let pairs = self.cells.pairs(lag.0, lag.1);
        let (sum, count) = pairs.iter().fold((0.0, 0.0), |(sum, count), p| (sum + p[0], count + p[1]));
        if count == 0.0 {
            return None;
        }
        let (mean, kept) = (sum / count, 1.0 - self.removal.fraction);
        let of_pairs = pairs.iter().map(|p| kept * (p[0] - mean * p[1]) / count);
        let influence = of_pairs.zip(&self.removal.influence).map(|(own, put)| own + (1.0 - mean) * put).collect();
        let correlation = kept * mean + self.removal.fraction;
        self.known.borrow_mut().insert(lag, (correlation, influence));
        Some(correlation - level)
    }

    /// Returns the weighted sum of the correlations of the surface at two lags, minus a level.
    fn mixed(&self, parts: [(Lag, f64); 2], level: f64) -> Option<f64> {
        let [a, b] = parts.map(|(lag, weight)| Some(weight * self.difference(lag, 0.0)?));
        Some(a? + b? - level)
    }

    /// Returns the difference and its spread.
    pub(super) fn tested(&self, lag: Lag, level: f64) -> Option<(f64, Spread)> {
        self.tested_mixed([(lag, 1.0), (lag, 0.0)], level)
    }

    /// Returns [`Lengths::mixed`] and its spread.
    fn tested_mixed(&self, parts: [(Lag, f64); 2], level: f64) -> Option<(f64, Spread)> {
        let difference = self.mixed(parts, level)?;
        let known = self.known.borrow();
        let [(_, a), (_, b)] = [known.get(&parts[0].0)?, known.get(&parts[1].0)?];
        let products = a.iter().zip(b).map(|(a, b)| parts[0].1 * a + parts[1].1 * b);
        let weight = level * (1.0 - self.removal.fraction);
        let squares =
            self.sums.power[1].iter().zip(&self.sums.fraction).map(|(square, fraction)| weight * (square - fraction));
        let influence: Vec<f64> = products.zip(squares).map(|(product, square)| product - square).collect();
        Some((difference, self.window.spread(&influence, FITTED)?))
    }

    /// Returns the point at which the correlation in a direction falls to `level` within half the field.
    fn ray(&self, turn: f64, level: f64, guess_m: [Option<f64>; 2]) -> Option<Ray> {
        let grid = self.cells.grid();
        let lag = |length_m: f64| -> Option<Lag> {
            let (x, y) = ((turn.cos() * length_m / grid.dx_m()).round(), (turn.sin() * length_m / grid.dy_m()).round());
            let within = x.abs() <= (grid.nx() / 2) as f64 && y.abs() <= (grid.ny() / 2) as f64;
            within.then_some((x as isize, y.max(0.0) as usize))
        };
        // Lags are whole points, so their own lengths are used.
        let length_m = |(x, y): Lag| (x as f64 * grid.dx_m()).hypot(y as f64 * grid.dy_m());
        let look = |wanted_m: f64| {
            let lag = lag(wanted_m)?;
            Some((length_m(lag), self.difference(lag, level)?))
        };
        let along = |cosine: f64, guess_m: Option<f64>| guess_m.map_or(0.0, |guess_m| (cosine / guess_m).powi(2));
        let inverse = along(turn.cos(), guess_m[0]) + along(turn.sin(), guess_m[1]);
        let start_m = if inverse > 0.0 { 1.0 / inverse.sqrt() } else { guess_m[0].or(guess_m[1])? };
        let mut wanted_m = start_m.min(0.5 * grid.width_m().hypot(grid.height_m()));
        while lag(wanted_m).is_none() {
            wanted_m /= STRIDE;
        }
        let mut near = look(wanted_m)?;
        let mut far = near;
        while far.1 > 0.0 {
            wanted_m *= STRIDE;
            (near, far) = (far, look(wanted_m)?);
        }
        while near.1 <= 0.0 {
            wanted_m /= STRIDE;
            (near, far) = (look(wanted_m)?, near);
        }
        let slope_per_m = (near.1 - far.1) / (far.0 - near.0);
        let crossing = |near: (f64, f64), far: (f64, f64)| near.0 + near.1 / (near.1 - far.1) * (far.0 - near.0);
        let middle = look(crossing(near, far))?;
        let length_m = match middle {
            // The result is still one of the two lags.
            (length_m, _) if length_m <= near.0 || length_m >= far.0 => crossing(near, far),
            (_, difference) if difference > 0.0 => crossing(middle, far),
            _ => crossing(near, middle),
        };
        Some(Ray { length_m, slope_per_m, lag: lag(length_m)? })
    }
}

struct Ray {
    length_m: f64,
    slope_per_m: f64,
    /// Returns the nearest lag.
    lag: Lag,
}

/// Returns the whole lags on either side of a length, with the weights of a correlation that is linear between them.
fn linear(length: f64) -> [(usize, f64); 2] {
    let near = length.floor() as usize;
    let beyond = length - length.floor();
    // At a whole lag no other is needed.
    let far = if beyond == 0.0 { near } else { near + 1 };
    [(near, 1.0 - beyond), (far, beyond)]
}

/// Returns the lags of [`linear`], with weights for which the sum of the correlations is `level` if the correlation
/// falls to `level` at the length and is exponential or squared exponential.
///
/// The sum is close to `level` for shapes between these: within 0.004 for exp(−(r/l)^p) with 1 < p < 2. A length
/// below one point has no such weights, since the correlation at zero is 1 for all shapes.
pub(super) fn convex(length: f64, level: f64) -> [(usize, f64); 2] {
    let lags = linear(length);
    let [near, far] = lags.map(|(lag, _)| lag as f64);
    if near == far {
        return lags;
    }
    let exponential = |lag: f64| level.powf(lag / length);
    let squared = |lag: f64| level.powf((lag / length).powi(2));
    let determinant = squared(near) * exponential(far) - squared(far) * exponential(near);
    let first = level * (exponential(far) - squared(far)) / determinant;
    let second = level * (squared(near) - exponential(near)) / determinant;
    [(lags[0].0, first), (lags[1].0, second)]
}

/// Returns the first zero of a function that is positive at `from`, on the way to `to`. It is bracketed in whole steps
/// that double, then found between two whole numbers. Returns `None` if the function does not fall to zero, or is
/// undefined on the way.
fn outward(from: usize, to: usize, value: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let (mut near, mut above) = (from, value(from as f64)?);
    let mut stride = 1;
    while above > 0.0 && near != to {
        let next = if to > from { (near + stride).min(to) } else { near.saturating_sub(stride).max(to) };
        let reached = value(next as f64)?;
        if reached <= 0.0 {
            let (mut far, mut below) = (next, reached);
            while far.abs_diff(near) > 1 {
                let middle = usize::midpoint(far, near);
                match value(middle as f64)? {
                    v if v <= 0.0 => (far, below) = (middle, v),
                    v => (near, above) = (middle, v),
                }
            }
            let ends = [[near as f64, above], [far as f64, below]];
            return try_root_between(|x| value(x).ok_or(()), ends[0], ends[1], RESOLVED).ok()?;
        }
        (near, above) = (next, reached);
        stride *= 2;
    }
    None
}
