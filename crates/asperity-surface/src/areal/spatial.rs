//! Autocorrelation length and texture aspect ratio: decay of the autocorrelation in all directions.

use asperity_base::blocks;
use asperity_base::correlation::{Autocorrelation, Axis, EstimateError};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::stats::Extent;

/// Number of rays over half a turn; the other half is the same by symmetry.
const RAYS: usize = 360;
/// Number of profiles along each axis used to guess the reach of the correlation.
const GUESSED_FROM: usize = 64;

/// Distances over which the autocorrelation first falls to a level, over all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decay {
    /// Shortest distance in metre; `None` if no direction decays within half the field.
    pub shortest_m: Option<f64>,
    /// Longest distance in metre; `None` if some direction does not decay within half the field.
    pub longest_m: Option<f64>,
    /// Fraction of the directions that do not decay.
    pub undecayed: f64,
}

impl Decay {
    /// Returns the shortest over the longest distance, if both exist.
    pub fn aspect_ratio(&self) -> Option<f64> {
        Some(self.shortest_m? / self.longest_m?)
    }
}

/// Follows the masked autocorrelation along 360 rays over half a turn, from zero lag to half the field in x and y.
///
/// The correlation is normalised by the number of present pairs, interpolated bilinearly, and sampled every half pixel;
/// the crossing is linear between samples. On a lag without pairs the ray ends undecayed.
///
/// Distances are along straight rays to the *first* crossing, as ISO 25178-2 defines Str. Programs that use the farthest
/// point of the region above the level report longer distances if that region bends or branches.
///
/// # Errors
/// All heights are equal.
pub fn decay(map: &HeightMap, level: f64) -> Result<Decay, EstimateError> {
    Ok(decay_and_correlation(map, &Extent::new(map.values_m()), level)?.0)
}

/// Computes [`decay`], and returns the autocorrelation. It reaches as far as the rays, so the correlation along
/// either axis falls to `level` within it, or it reaches half the field.
///
/// Lags are first estimated up to a guess. If a ray leaves the guess across an axis, they are estimated up to half the
/// field along that axis.
pub(super) fn decay_and_correlation(
    map: &HeightMap,
    extent: &Extent,
    level: f64,
) -> Result<(Decay, Autocorrelation), EstimateError> {
    let half = Autocorrelation::half_field(map.grid());
    let mut reach = guess(map, extent.mean, level);
    loop {
        let correlation = Autocorrelation::about(map, extent, reach)?;
        match followed(&correlation, level) {
            Ok(decay) => return Ok((decay, correlation)),
            Err(Left { x, y }) => reach = (if x { half.0 } else { reach.0 }, if y { half.1 } else { reach.1 }),
        }
    }
}

/// A ray left the estimated lags before the correlation decayed; the flags give the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Left {
    x: bool,
    y: bool,
}

/// Follows an autocorrelation along all rays.
pub(super) fn followed(correlation: &Autocorrelation, level: f64) -> Result<Decay, Left> {
    let rays: Vec<Ray> = blocks::map(0..RAYS, |ray| {
        let angle = std::f64::consts::PI * ray as f64 / RAYS as f64;
        along(correlation, angle, level)
    });
    let left = Left { x: rays.contains(&Ray::Left(Axis::X)), y: rays.contains(&Ray::Left(Axis::Y)) };
    if left.x || left.y {
        return Err(left);
    }
    let lengths =
        || rays.iter().filter_map(|ray| if let Ray::Decayed(length_m) = ray { Some(*length_m) } else { None });
    let all = lengths().count() == RAYS;
    Ok(Decay {
        shortest_m: lengths().reduce(f64::min),
        longest_m: if all { lengths().reduce(f64::max) } else { None },
        undecayed: 1.0 - lengths().count() as f64 / RAYS as f64,
    })
}

/// End of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ray {
    /// The correlation fell to the level at this distance in metre.
    Decayed(f64),
    /// The ray reached half the field, or a lag without pairs, above the level.
    Undecayed,
    /// The ray left the estimated lags across the side of this axis.
    Left(Axis),
}

/// Ratio of the sides of a pixel up to which rays are followed in steps of half the shorter one.
const LONGEST_PIXEL: f64 = 64.0;

fn along(correlation: &Autocorrelation, angle: f64, level: f64) -> Ray {
    let grid = correlation.grid();
    let pixel_m = 1.0 / f64::max(angle.cos().abs() / grid.dx_m(), angle.sin() / grid.dy_m());
    // Half of the shorter side of a pixel, unless pixels are so long that most steps would stay in one.
    let step_m = 0.5 * f64::min(grid.dx_m(), grid.dy_m()).max(pixel_m / LONGEST_PIXEL);
    let (columns, rows) = (angle.cos() * step_m / grid.dx_m(), angle.sin() * step_m / grid.dy_m());
    let (half_x, half_y) = (0.5 * grid.nx() as f64, 0.5 * grid.ny() as f64);
    let (reach_x, reach_y) = correlation.reach();
    let mut before = 1.0;
    for sample in 1.. {
        let (x, y) = (f64::from(sample) * columns, f64::from(sample) * rows);
        if x.abs() > half_x || y.abs() > half_y {
            return Ray::Undecayed;
        }
        if x.abs() > reach_x as f64 {
            return Ray::Left(Axis::X);
        }
        if y.abs() > reach_y as f64 {
            return Ray::Left(Axis::Y);
        }
        let here = bilinear(correlation, x, y);
        if here.is_nan() {
            return Ray::Undecayed;
        }
        if here <= level {
            return Ray::Decayed((f64::from(sample - 1) + (before - level) / (before - here)) * step_m);
        }
        before = here;
    }
    Ray::Undecayed
}

/// Returns the correlation at a lag of (x, y) pixels by bilinear interpolation.
fn bilinear(correlation: &Autocorrelation, x: f64, y: f64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| {
        let weight = (if right == 1 { x - column } else { 1.0 - (x - column) })
            * (if down == 1 { y - row } else { 1.0 - (y - row) });
        // Corners without weight may be outside of the estimated lags.
        if weight == 0.0 { 0.0 } else { weight * correlation.correlation(column as isize + right, row as isize + down) }
    });
    corners.iter().sum()
}

/// Returns twice the first of the lags 1, 2, 4, … at which the correlation of some profiles is below the level, along x
/// and y; half the field if there is none. It affects only the time, not the result.
fn guess(map: &HeightMap, mean_m: f64, level: f64) -> (usize, usize) {
    let grid: Grid = map.grid();
    let (ny, nx) = grid.shape();
    let half = Autocorrelation::half_field(grid);
    let rows: Vec<&[f64]> = map.values_m().chunks_exact(nx).collect();
    let columns: Vec<usize> = (0..nx).step_by(nx.div_ceil(GUESSED_FROM)).collect();
    let along_x: Vec<Vec<f64>> = rows.iter().step_by(ny.div_ceil(GUESSED_FROM)).map(|row| row.to_vec()).collect();
    let along_y: Vec<Vec<f64>> = columns.iter().map(|column| rows.iter().map(|row| row[*column]).collect()).collect();
    let reach = |profiles: &[Vec<f64>], half: usize| {
        let covariance = |lag: usize| {
            let products =
                profiles.iter().flat_map(|z| z[lag..].iter().zip(z).map(|(a, b)| (a - mean_m) * (b - mean_m)));
            let (sum, count) =
                products.filter(|p| !p.is_nan()).fold((0.0, 0.0), |(sum, count), product| (sum + product, count + 1.0));
            sum / count
        };
        let variance = covariance(0);
        let ladder = std::iter::successors(Some(1), |lag| Some(2 * lag)).take_while(|lag| *lag < half);
        ladder.into_iter().find(|lag| covariance(*lag) < level * variance).map_or(half, |lag| half.min(2 * lag))
    };
    (reach(&along_x, half.0), reach(&along_y, half.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RandomSurface, SpectralField};
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::random;

    #[test]
    fn the_guessed_reach_affects_only_the_time() {
        let grid = Grid::new(120, 90, 1.0, 1.3).unwrap();
        // Correlation lengths: short, long along y, longer than half the field; and a hole.
        for (length_x, length_y, hole) in [(3.0, 3.0, false), (3.0, 25.0, false), (40.0, 4.0, true), (80.0, 80.0, true)]
        {
            let covariance = Covariance::new(CorrelationModel::Exponential, 1.0, length_x, length_y).unwrap();
            let field = SpectralField::periodic(&covariance, grid);
            let xi = random::standard_normal(&mut random::stream(17, "decay", 0), field.xi_len());
            let mut heights = field.generate(&xi).heights_m().clone();
            if hole {
                heights.slice_mut(ndarray::s![20..50, 30..70]).fill(f64::NAN);
            }
            let map = HeightMap::new(grid, heights).unwrap();
            let (found, used) = decay_and_correlation(&map, &Extent::new(map.values_m()), 0.2).unwrap();
            let whole = Autocorrelation::estimate(&map).unwrap();
            let rays: Vec<Ray> =
                (0..RAYS).map(|ray| along(&whole, std::f64::consts::PI * ray as f64 / RAYS as f64, 0.2)).collect();
            assert!(rays.iter().all(|ray| !matches!(ray, Ray::Left(_))));
            let lengths: Vec<f64> =
                rays.iter().filter_map(|ray| if let Ray::Decayed(l) = ray { Some(*l) } else { None }).collect();
            let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            assert!((found.shortest_m.unwrap() / shortest - 1.0).abs() < 1e-9);
            assert_eq!(found.longest_m.is_some(), lengths.len() == RAYS);
            assert_eq!(found.undecayed, 1.0 - lengths.len() as f64 / RAYS as f64);
            for axis in [Axis::X, Axis::Y] {
                let (short, long) = (used.correlation_length_m(axis), whole.correlation_length_m(axis));
                assert_eq!(short.is_some(), long.is_some());
                assert!(short.is_none() || (short.unwrap() / long.unwrap() - 1.0).abs() < 1e-9);
            }
        }
    }
}
