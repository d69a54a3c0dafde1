//! Spheres and circular cylinders.

use ndarray::Array2;

use super::polynomial::{self, Span, sums_over_rows};
use asperity_base::map::HeightMap;
use asperity_base::numeric::solve_positive_definite;

/// Largest number of steps of the search.
const MAX_ITERATIONS: usize = 100;
/// Largest change of a parameter, in units of half the map, at which the search ends.
const SETTLED: f64 = 1e-13;
/// Bounds of the damping.
const LEAST_DAMPING: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e12;
/// Parameters of a cylinder: height and two slopes at the centre, curvature, direction of the axis.
const PARAMETERS: usize = 5;

/// Reason why there is no sphere or cylinder.
pub(super) enum RoundError {
    /// The points do not determine the form.
    Undetermined,
    /// The search did not converge.
    NotConverged { iterations: usize },
}

/// Result of the fit of a sphere or cylinder.
pub(super) struct Fitted {
    pub(super) heights_m: Array2<f64>,
    pub(super) radius_m: f64,
}

/// A sphere or cylinder that passes the height `c` above the centre of the map, with slopes (p, q) and signed curvature
/// κ there. These parameters are smooth through the plane, κ = 0, while centre and radius are not.
///
/// A point d = (x, y, w) from that height is on the surface if κ/2 (|d|² − (t·d)²) = n·d, with n the unit normal and t
/// the axis of the cylinder, orthogonal to n. For a sphere the term with t is absent. Of the two roots w, the one that
/// tends to the tangent plane is taken.
#[derive(Debug, Clone, Copy)]
struct Round {
    height: f64,
    slope_x: f64,
    slope_y: f64,
    /// Curvature along −n: positive for a ridge or cap.
    curvature: f64,
    /// Angle of the axis with x in the map plane; `None` for a sphere.
    axis: Option<f64>,
}

impl Round {
    /// Returns the number of parameters of the fit.
    fn parameters(&self) -> usize {
        if self.axis.is_some() { PARAMETERS } else { PARAMETERS - 1 }
    }

    fn moved(&self, step: &[f64]) -> Self {
        Self {
            height: self.height + step[0],
            slope_x: self.slope_x + step[1],
            slope_y: self.slope_y + step[2],
            curvature: self.curvature + step[3],
            axis: self.axis.map(|angle| angle + step[4]),
        }
    }

    /// Returns the height at (x, y) from the centre, NaN beyond the rim.
    fn at(&self, x: f64, y: f64) -> f64 {
        let (p, q) = (self.slope_x, self.slope_y);
        let upright = 1.0 / (1.0 + p * p + q * q).sqrt();
        let kappa = -self.curvature;
        let (along, tilt) = self.axis.map_or((0.0, 0.0), |angle| {
            let (sin, cos) = angle.sin_cos();
            let rise = p * cos + q * sin;
            let length = (1.0 + rise * rise).sqrt();
            ((x * cos + y * sin) / length, rise / length)
        });
        // κ/2 (1 − tz²) w² − (nz + κ s tz) w + κ/2 (r² − s²) + nz (p x + q y) = 0.
        let square = kappa * (1.0 - tilt * tilt);
        let linear = upright + kappa * along * tilt;
        let constant = 0.5 * kappa * (x * x + y * y - along * along) + upright * (p * x + q * y);
        let root = (linear * linear - 2.0 * square * constant).sqrt();
        self.height + 2.0 * constant / (linear + root)
    }
}

/// Points of a map in units of half its longer side, so that all parameters of a fit have similar size.
struct Points<'a> {
    map: &'a HeightMap,
    columns: Span,
    rows: Span,
    unit_m: f64,
    offset_m: f64,
}

impl Points<'_> {
    fn x(&self, column: usize) -> f64 {
        (column as f64 - self.columns.centre) * self.map.grid().dx_m() / self.unit_m
    }

    fn y(&self, row: usize) -> f64 {
        (row as f64 - self.rows.centre) * self.map.grid().dy_m() / self.unit_m
    }

    /// Returns Σ (z − form)² over the present points; NaN if a point is beyond the rim.
    fn misfit(&self, form: &Round) -> f64 {
        self.accumulate(1, |x, y, z, sums| sums[0] += (z - form.at(x, y)).powi(2))[0]
    }

    fn accumulate(&self, count: usize, of_point: impl Fn(f64, f64, f64, &mut [f64]) + Sync) -> Vec<f64> {
        let heights = self.map.heights_m();
        sums_over_rows(heights.nrows(), count, |row, sums| {
            let y = self.y(row);
            for (column, z) in heights.row(row).iter().enumerate().filter(|(_, z)| !z.is_nan()) {
                of_point(self.x(column), y, (z - self.offset_m) / self.unit_m, sums);
            }
        })
    }
}

/// Fits a sphere or cylinder by least squares in height with the Levenberg–Marquardt method, starting from a quadratic.
pub(super) fn fit(map: &HeightMap, cylinder: bool) -> Result<Fitted, RoundError> {
    let grid = map.grid();
    let (columns, rows) = Span::of(map);
    let unit_m = f64::max(columns.half * grid.dx_m(), rows.half * grid.dy_m());
    let offset_m = map.present_m().sum::<f64>() / (grid.points() - map.missing_points()) as f64;
    let points = Points { map, columns, rows, unit_m, offset_m };
    let start = start(&points, cylinder)?;
    let n = start.parameters();
    let (mut best, mut misfit) = (start, points.misfit(&start));
    if misfit.is_nan() {
        // The quadratic's curvature may be too large for a sphere that includes the outermost points.
        best.curvature = 0.0;
        misfit = points.misfit(&best);
    }
    let mut damping = 1e-3;
    for _ in 0..MAX_ITERATIONS {
        let (gram, right) = normal_equations(&points, &best, n);
        let settled = loop {
            let (mut damped, mut step) = (gram.clone(), right.clone());
            for i in 0..n {
                damped[i * n + i] *= 1.0 + damping;
            }
            if !solve_positive_definite(&mut damped, &mut step) {
                return Err(RoundError::Undetermined);
            }
            let moved = best.moved(&step);
            let found = points.misfit(&moved);
            let is_still = step.iter().all(|s| s.abs() <= SETTLED);
            if found <= misfit {
                (best, misfit) = (moved, found);
                damping = (0.1 * damping).max(LEAST_DAMPING);
                break is_still;
            }
            // Only rounding prevents a further decrease of the misfit.
            if is_still || damping > MOST_DAMPING {
                break true;
            }
            damping *= 10.0;
        };
        if settled {
            return Ok(Fitted {
                heights_m: Array2::from_shape_fn(grid.shape(), |(row, column)| {
                    offset_m + unit_m * best.at(points.x(column), points.y(row))
                }),
                radius_m: unit_m / best.curvature,
            });
        }
    }
    Err(RoundError::NotConverged { iterations: MAX_ITERATIONS })
}

/// Returns JᵀJ and Jᵀr, with derivatives by central differences.
fn normal_equations(points: &Points, form: &Round, n: usize) -> (Vec<f64>, Vec<f64>) {
    /// Step close to the cube root of the rounding unit; the error of a central difference is then about its square.
    const DIFFERENCE: f64 = 1e-5;
    let moved = |parameter: usize, by: f64| {
        let mut step = [0.0; PARAMETERS];
        step[parameter] = by;
        form.moved(&step)
    };
    let pairs: Vec<(Round, Round)> = (0..n).map(|i| (moved(i, DIFFERENCE), moved(i, -DIFFERENCE))).collect();
    let mut sums = points.accumulate(n * n + n, |x, y, z, sums| {
        let left = z - form.at(x, y);
        let mut slopes = [0.0; PARAMETERS];
        for (slope, (after, before)) in slopes.iter_mut().zip(&pairs) {
            *slope = (after.at(x, y) - before.at(x, y)) / (2.0 * DIFFERENCE);
        }
        // A point at the rim has no derivative. It is inside the form, and steps that lose it are rejected.
        if slopes.iter().any(|s| s.is_nan()) {
            return;
        }
        for i in 0..n {
            for j in 0..n {
                sums[i * n + j] += slopes[i] * slopes[j];
            }
            sums[n * n + i] += slopes[i] * left;
        }
    });
    let right = sums.split_off(n * n);
    (sums, right)
}

/// Returns height, slopes and curvatures of the least-squares quadratic at the centre.
fn start(points: &Points, cylinder: bool) -> Result<Round, RoundError> {
    let form = polynomial::fit(points.map, 2).map_err(|polynomial::Undetermined| RoundError::Undetermined)?;
    // Five values of a quadratic along each axis and diagonal determine its coefficients; a step is the whole map.
    let grid = points.map.grid();
    let (row, column) = (grid.ny() / 2, grid.nx() / 2);
    let value = |row: usize, column: usize| (form[[row, column]] - points.offset_m) / points.unit_m;
    let (x0, x1, x2) = (points.x(0), points.x(column), points.x(grid.nx() - 1));
    let (y0, y1, y2) = (points.y(0), points.y(row), points.y(grid.ny() - 1));
    let second = |[a, b, c]: [f64; 3], [s, t, u]: [f64; 3]| 2.0 * ((c - b) / (u - t) - (b - a) / (t - s)) / (u - s);
    let (end_row, end_column) = (grid.ny() - 1, grid.nx() - 1);
    let (xx, yy) = if grid.nx() > 2 && grid.ny() > 2 {
        (
            second([value(row, 0), value(row, column), value(row, end_column)], [x0, x1, x2]),
            second([value(0, column), value(row, column), value(end_row, column)], [y0, y1, y2]),
        )
    } else {
        return Err(RoundError::Undetermined);
    };
    let xy =
        (value(end_row, end_column) - value(end_row, 0) - value(0, end_column) + value(0, 0)) / ((x2 - x0) * (y2 - y0));
    // z = c + p x + q y + (xx x² + 2 xy x y + yy y²)/2, from values along the middle lines.
    let slope_x = (value(row, end_column) - value(row, 0)) / (x2 - x0) - 0.5 * xx * (x2 + x0) - xy * y1;
    let slope_y = (value(end_row, column) - value(0, column)) / (y2 - y0) - 0.5 * yy * (y2 + y0) - xy * x1;
    let height = value(row, column) - slope_x * x1 - slope_y * y1 - 0.5 * (xx * x1 * x1 + yy * y1 * y1) - xy * x1 * y1;
    // The axis of a cylinder is normal to the direction of the stronger curvature.
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let strongest = half.hypot(xy);
    let (bend, axis) = if cylinder {
        let direction = 0.5 * xy.atan2(half);
        if mean >= 0.0 {
            (mean + strongest, direction + std::f64::consts::FRAC_PI_2)
        } else {
            (mean - strongest, direction)
        }
    } else {
        (mean, 0.0)
    };
    let upright = 1.0 / (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt();
    Ok(Round { height, slope_x, slope_y, curvature: -bend * upright.powi(3), axis: cylinder.then_some(axis) })
}
