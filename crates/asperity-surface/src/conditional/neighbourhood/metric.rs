//! Distance between two points, scaled by the correlation.

use std::collections::VecDeque;

use crate::conditional::lags::Lags;
use asperity_base::map::Grid;

/// Fractions of the correlation of neighbours: at the border of the central lobe, and below which heights are not used.
const LOBE: f64 = 0.5;
const FAINT: f64 = 0.1;
/// Reach in radii of the central lobe, and least reach in points.
const REACH: f64 = 8.0;
/// Elongation of the lobe below which it counts as round.
const ROUND: f64 = 1.25;

/// Distances in points along the short axis of the central lobe of the correlation. Distances along its long axis are
/// divided by the ratio of the axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Metric {
    /// Rows of the matrix from lags in points to the frame in which distances are Euclidean.
    to_frame: [[f64; 2]; 2],
    /// Long over short axis of the lobe.
    elongation: f64,
    /// Distance beyond which heights have little influence.
    reach: f64,
}

impl Metric {
    /// Computes the metric from the moments of the central lobe: the connected lags around zero with more than half the
    /// correlation of neighbours. It reaches over eight radii of the lobe, and further while the correlation exceeds a
    /// tenth of that of neighbours.
    pub(super) fn of(lags: &Lags, grid: Grid) -> Self {
        let (nx, ny) = (grid.nx() as isize, grid.ny() as isize);
        let neighbours = [(1, 0), (0, 1), (1, 1), (-1, 1)].into_iter().filter(|(x, y)| *x < nx && *y < ny);
        let nearest = neighbours.map(|(x, y)| lags.at(x, y)).fold(0.0, f64::max).min(1.0);
        let [xx, xy, yy] = lobe_moments(lags, (nx, ny), LOBE * nearest);
        // Eigenvalues of the moments: a quarter of the squared semi-axes of an ellipse.
        let (middle, spread) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        let (long, short) = (middle + spread, (middle - spread).max(1.0 / 12.0));
        let elongation = (long / short).sqrt();
        let (to_frame, elongation) = if elongation < ROUND {
            ([[1.0, 0.0], [0.0, 1.0]], 1.0)
        } else {
            let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
            ([[cos / elongation, sin / elongation], [-sin, cos]], elongation)
        };
        let mut metric = Self { to_frame, elongation, reach: REACH * (2.0 * short.sqrt()).max(1.0) };
        let mut furthest = metric.reach;
        for y in 0..ny {
            for x in 1 - nx..nx {
                if lags.at(x, y).abs() > FAINT * nearest && nearest > 0.0 {
                    let [u, v] = metric.frame(x as f64, y as f64);
                    furthest = furthest.max(u.hypot(v));
                }
            }
        }
        metric.reach = furthest;
        metric
    }

    /// Transforms a lag or place in points to the frame in which distances are Euclidean.
    pub(super) fn frame(&self, x: f64, y: f64) -> [f64; 2] {
        let [[xx, xy], [yx, yy]] = self.to_frame;
        [xx * x + xy * y, yx * x + yy * y]
    }

    /// Returns the half sides in points of the box around all lags of a distance of at most `radius`.
    pub(super) fn half_sides(&self, radius: f64) -> (f64, f64) {
        let [[xx, xy], [yx, yy]] = self.to_frame;
        let determinant = xx * yy - xy * yx;
        (radius * yy.hypot(xy) / determinant, radius * xx.hypot(yx) / determinant)
    }

    pub(super) fn elongation(&self) -> f64 {
        self.elongation
    }

    pub(super) fn reach(&self) -> f64 {
        self.reach
    }
}

/// Returns the second moments xx, xy, yy of the connected lags around zero above `level`, each a square of one point.
fn lobe_moments(lags: &Lags, (nx, ny): (isize, isize), level: f64) -> [f64; 3] {
    // The other half plane is the mirror image.
    let width = (2 * nx - 1) as usize;
    let place = |x: isize, y: isize| y as usize * width + (x + nx - 1) as usize;
    let mut seen = vec![false; width * ny as usize];
    let mut queue = VecDeque::from([(0_isize, 0_isize)]);
    seen[place(0, 0)] = true;
    let (mut count, mut sums) = (0.0, [0.0; 3]);
    while let Some((x, y)) = queue.pop_front() {
        let images = if y == 0 { 1.0 } else { 2.0 };
        count += images;
        let (fx, fy) = (x as f64, y as f64);
        for (sum, term) in sums.iter_mut().zip([fx * fx, fx * fy, fy * fy]) {
            *sum += images * term;
        }
        for (x, y) in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] {
            let inside = x.abs() < nx && (0..ny).contains(&y);
            if inside && !seen[place(x, y)] && lags.at(x, y) > level {
                seen[place(x, y)] = true;
                queue.push_back((x, y));
            }
        }
    }
    let point = 1.0 / 12.0;
    [sums[0] / count + point, sums[1] / count, sums[2] / count + point]
}
