//! Range of the lags of an autocorrelation that are significant.

use std::f64::consts::PI;

use crate::correlation::estimate::Autocorrelation;

/// Level that bounds the central lobe, as for the autocorrelation length of ISO 25178-2.
const LOBE: f64 = 0.2;
/// Width of the rings in which lags are compared with their noise, in lobe radii.
const RING: f64 = 0.5;
/// Number of consecutive rings of noise after which the correlation counts as decayed.
const QUIET_RINGS: usize = 3;
/// Factor from the decay to the radius of full weight: a smooth correlation continues below the noise, and truncating
/// it would put ripples larger than its own high wavenumbers into the spectrum.
const MARGIN: f64 = 1.5;
/// Number of sectors of a ring, so that correlation in one direction is not averaged with the noise of the others.
const SECTORS: usize = 4;
/// Standard deviations by which the mean square of a sector must exceed that of noise to be significant.
const SIGNIFICANT: f64 = 4.0;
/// Fraction of the map over which the squares for the noise level are summed, and limit of the lags used if they decay.
const NOISE_FRACTION: f64 = 0.25;
const LARGEST_FRACTION: f64 = 0.5;

/// Weight of a lag: 1 up to the reliable radius, falling to 0 at twice that; see [`super::MeasuredCovariance`].
#[derive(Debug, Clone)]
pub(super) struct Taper {
    x: Side,
    y: Side,
    ellipse: Ellipse,
    /// Radius in lobes up to which lags are reliable; infinite without decay.
    reliable: f64,
    standard_error: f64,
}

/// One axis of the map.
#[derive(Debug, Clone, Copy)]
struct Side {
    pitch_m: f64,
    /// Largest lag used, in points.
    limit: isize,
    /// Whether the correlation extends beyond half of that.
    open: bool,
}

impl Side {
    fn weight(&self, lag: isize) -> f64 {
        let s = lag.unsigned_abs() as f64 / (self.limit + 1) as f64;
        if self.open { bohman(s) } else { flat_top(s) }
    }

    /// Returns the largest lag in metre with weight 1, at most `reliable_m`.
    fn reliable_m(&self, reliable_m: f64) -> f64 {
        if self.open { 0.0 } else { reliable_m.min(0.5 * (self.limit + 1) as f64 * self.pitch_m) }
    }
}

/// Scaled distance r = √(hᵀBh), 1 on the boundary of the central lobe.
#[derive(Debug, Clone, Copy)]
struct Ellipse {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Ellipse {
    /// Returns a lag in coordinates in which the ellipse is the unit circle.
    fn scaled(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let across = (self.yy - self.xy * self.xy / self.xx).max(0.0).sqrt();
        ((self.xx * x_m + self.xy * y_m) / self.xx.sqrt(), across * y_m)
    }

    fn radius(&self, x_m: f64, y_m: f64) -> f64 {
        let (x, y) = self.scaled(x_m, y_m);
        x.hypot(y)
    }

    /// Returns a wavevector in rad/m in the coordinates in which the ellipse is the unit circle, in radian per lobe
    /// radius.
    fn wavevector(&self, qx_rad_per_m: f64, qy_rad_per_m: f64) -> (f64, f64) {
        let across = (self.yy - self.xy * self.xy / self.xx).max(0.0).sqrt();
        (qx_rad_per_m / self.xx.sqrt(), (qy_rad_per_m - self.xy / self.xx * qx_rad_per_m) / across)
    }

    /// Returns the largest |x| and |y| on the unit circle.
    fn half_widths_m(&self) -> (f64, f64) {
        let determinant = self.xx * self.yy - self.xy * self.xy;
        ((self.yy / determinant).sqrt(), (self.xx / determinant).sqrt())
    }
}

impl Taper {
    pub(super) fn new(estimate: &Autocorrelation) -> Self {
        let grid = estimate.grid();
        let (reach_x, reach_y) = estimate.reach();
        let fraction =
            |n: usize, fraction: f64, reach: usize| ((fraction * n as f64).floor() as isize).max(1).min(reach as isize);
        let near = (fraction(grid.nx(), NOISE_FRACTION, reach_x), fraction(grid.ny(), NOISE_FRACTION, reach_y));
        let limit = (fraction(grid.nx(), LARGEST_FRACTION, reach_x), fraction(grid.ny(), LARGEST_FRACTION, reach_y));
        // Σρ² over all lags: the number of lags over which the noise of the estimate is itself correlated.
        let squares: f64 = half_plane(near)
            .map(|(x, y)| (estimate.correlation(x, y), if y == 0 { 1.0 } else { 2.0 }))
            .filter(|(rho, _)| !rho.is_nan())
            .map(|(rho, times)| times * rho * rho)
            .sum();
        let lobe = Lobe::new(estimate, limit);
        let reliable = decay(estimate, limit, &lobe.ellipse, squares);
        let side = |pitch_m: f64, estimated: usize, limit: isize, reach: isize| {
            let open = 2 * reach > limit || reliable.is_infinite();
            Side { pitch_m, limit: if open { estimated as isize } else { limit }, open }
        };
        Self {
            x: side(grid.dx_m(), reach_x, limit.0, lobe.reach.0),
            y: side(grid.dy_m(), reach_y, limit.1, lobe.reach.1),
            ellipse: lobe.ellipse,
            reliable,
            standard_error: (squares / estimate.pairs(0, 0)).sqrt(),
        }
    }

    /// Returns the weight of a lag in points.
    pub(super) fn weight(&self, lag_x: isize, lag_y: isize) -> f64 {
        let radius = self.ellipse.radius(lag_x as f64 * self.x.pitch_m, lag_y as f64 * self.y.pitch_m);
        self.x.weight(lag_x) * self.y.weight(lag_y) * flat_top(radius / (2.0 * self.reliable))
    }

    /// Returns the largest lags along x and y in points with a non-zero weight.
    pub(super) fn reach(&self) -> (usize, usize) {
        let (x_m, y_m) = self.ellipse.half_widths_m();
        let reach = |half_width_m: f64, side: &Side| {
            ((2.0 * self.reliable * half_width_m / side.pitch_m).floor() as usize).clamp(1, side.limit as usize)
        };
        (reach(x_m, &self.x), reach(y_m, &self.y))
    }

    /// Returns a wavevector in radian per lag in coordinates in which ellipses similar to the central lobe are circles,
    /// in units of the resolution of the taper.
    pub(super) fn wavevector(&self, phase_x: f64, phase_y: f64) -> (f64, f64) {
        let (x_m, y_m) = self.ellipse.half_widths_m();
        let far = |side: &Side, half_width_m: f64| (side.limit + 1) as f64 * side.pitch_m / half_width_m;
        let radius = (2.0 * self.reliable).min(far(&self.x, x_m)).min(far(&self.y, y_m));
        let (x, y) = self.ellipse.wavevector(phase_x / self.x.pitch_m, phase_y / self.y.pitch_m);
        (x * radius / PI, y * radius / PI)
    }

    /// Returns the largest lags along x and y with weight 1, in metre.
    pub(super) fn reliable_m(&self) -> (f64, f64) {
        let (x_m, y_m) = self.ellipse.half_widths_m();
        (self.x.reliable_m(self.reliable * x_m), self.y.reliable_m(self.reliable * y_m))
    }

    /// Returns whether the correlation falls to its noise within the map, along x and along y.
    pub(super) fn decayed(&self) -> (bool, bool) {
        (!self.x.open, !self.y.open)
    }

    pub(super) fn standard_error(&self) -> f64 {
        self.standard_error
    }
}

/// Returns 1 up to ½, 0 from 1 on, with a smooth step between; three continuous derivatives keep the leakage into high
/// wavenumbers small.
fn flat_top(s: f64) -> f64 {
    let t = (2.0 - 2.0 * s).clamp(0.0, 1.0);
    t.powi(4) * (35.0 - 84.0 * t + 70.0 * t * t - 20.0 * t.powi(3))
}

/// Returns Bohman's window, the autocorrelation of half a cosine wave: positive semi-definite.
fn bohman(s: f64) -> f64 {
    if s < 1.0 { (1.0 - s) * (PI * s).cos() + (PI * s).sin() / PI } else { 0.0 }
}

/// Returns the lags (x, y) with y ≥ 0 up to a limit.
fn half_plane(limit: (isize, isize)) -> impl Iterator<Item = (isize, isize)> {
    (0..=limit.1).flat_map(move |y| (-limit.0..=limit.0).map(move |x| (x, y)))
}

/// Returns the radius up to which lags have full weight: [`MARGIN`] times the larger of the lobe radius and the radius
/// from which on the mean squares of rings are those of noise, s² = Σρ²/N.
fn decay(estimate: &Autocorrelation, limit: (isize, isize), ellipse: &Ellipse, squares: f64) -> f64 {
    let (dx_m, dy_m) = (estimate.grid().dx_m(), estimate.grid().dy_m());
    // Sum of ρ̂²/s² and number of lags of every sector of every ring.
    let mut rings: Vec<[(f64, f64); SECTORS]> = Vec::new();
    for (x, y) in half_plane(limit) {
        let rho = estimate.correlation(x, y);
        if rho.is_nan() || (x, y) == (0, 0) {
            continue;
        }
        let (scaled_x, scaled_y) = ellipse.scaled(x as f64 * dx_m, y as f64 * dy_m);
        let ring = (scaled_x.hypot(scaled_y) / RING) as usize;
        if ring >= rings.len() {
            rings.resize(ring + 1, [(0.0, 0.0); SECTORS]);
        }
        // Sectors are centred on the axes and diagonals of the ellipse; opposite sectors are identified.
        let sector = (scaled_y.atan2(scaled_x) / PI * SECTORS as f64).round() as usize % SECTORS;
        rings[ring][sector].0 += rho * rho * estimate.pairs(x, y) / squares;
        rings[ring][sector].1 += 1.0;
    }
    let quiet = |(sum, lags): &(f64, f64)| {
        // The mean square of noise is 1, with variance 2 over the number of independent lags.
        let independent = (lags / squares).max(1.0);
        *lags == 0.0 || sum / lags <= 1.0 + SIGNIFICANT * (2.0 / independent).sqrt()
    };
    let first = rings.windows(QUIET_RINGS).position(|window| window.iter().flatten().all(quiet));
    first.map_or(f64::INFINITY, |ring| MARGIN * (RING * ring as f64).max(1.0))
}

/// Lags connected with zero lag above [`LOBE`].
struct Lobe {
    /// Ellipse of their second moments.
    ellipse: Ellipse,
    /// Largest lags along x and y in points.
    reach: (isize, isize),
}

impl Lobe {
    fn new(estimate: &Autocorrelation, limit: (isize, isize)) -> Self {
        let (limit_x, limit_y) = limit;
        let width = 2 * limit_x + 1;
        let place = |x: isize, y: isize| ((y + limit_y) * width + x + limit_x) as usize;
        let mut seen = vec![false; (width * (2 * limit_y + 1)) as usize];
        let mut waiting = vec![(0_isize, 0_isize)];
        seen[place(0, 0)] = true;
        let (dx_m, dy_m) = (estimate.grid().dx_m(), estimate.grid().dy_m());
        let (mut count, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0);
        let mut reach = (0, 0);
        while let Some((x, y)) = waiting.pop() {
            let (x_m, y_m) = (x as f64 * dx_m, y as f64 * dy_m);
            count += 1.0;
            xx += x_m * x_m;
            xy += x_m * y_m;
            yy += y_m * y_m;
            reach = (reach.0.max(x), reach.1.max(y));
            for (x, y) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                if x.abs() <= limit_x && y.abs() <= limit_y && !seen[place(x, y)] && estimate.correlation(x, y) > LOBE {
                    seen[place(x, y)] = true;
                    waiting.push((x, y));
                }
            }
        }
        // An ellipse with semi-axes a, b has the moments a²/4, b²/4. A lag stands for a cell, which gives an isolated
        // zero lag its size.
        let (xx, xy, yy) = (4.0 * xx / count + dx_m * dx_m, 4.0 * xy / count, 4.0 * yy / count + dy_m * dy_m);
        let determinant = xx * yy - xy * xy;
        Self { ellipse: Ellipse { xx: yy / determinant, xy: -xy / determinant, yy: xx / determinant }, reach }
    }
}
