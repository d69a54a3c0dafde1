//! How far heights stay correlated, in every direction.

use crate::correlation::{Autocorrelation, EstimateError};
use crate::map::HeightMap;

/// Rays over half a turn; the other half is the same by symmetry.
const RAYS: usize = 360;

/// Distances over which the autocorrelation first falls to a level, over all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decay {
    /// Shortest distance in metre; `None` when no direction decays within half the field.
    pub shortest_m: Option<f64>,
    /// Longest distance in metre; `None` when some direction does not decay within half the field.
    pub longest_m: Option<f64>,
    /// Share of the directions that do not decay.
    pub undecayed: f64,
}

impl Decay {
    /// Shortest over longest distance, where both exist.
    pub fn aspect_ratio(&self) -> Option<f64> {
        Some(self.shortest_m? / self.longest_m?)
    }
}

/// Follows the masked autocorrelation along 360 rays over half a turn, from zero lag to half the field in x and y.
///
/// The correlation is normalised by the number of present pairs, interpolated bilinearly, and sampled every half pixel;
/// the crossing is linear between samples. On a lag without pairs the ray ends undecayed.
///
/// # Errors
/// The heights do not vary.
pub fn decay(map: &HeightMap, level: f64) -> Result<Decay, EstimateError> {
    let correlation = Autocorrelation::estimate(map)?;
    let lengths: Vec<Option<f64>> =
        (0..RAYS).map(|ray| along(&correlation, std::f64::consts::PI * ray as f64 / RAYS as f64, level)).collect();
    let decayed = || lengths.iter().flatten().copied();
    let all = decayed().count() == RAYS;
    Ok(Decay {
        shortest_m: decayed().reduce(f64::min),
        longest_m: if all { decayed().reduce(f64::max) } else { None },
        undecayed: 1.0 - decayed().count() as f64 / RAYS as f64,
    })
}

fn along(correlation: &Autocorrelation, angle: f64, level: f64) -> Option<f64> {
    let grid = correlation.grid();
    let step_m = 0.5 * f64::min(grid.dx_m(), grid.dy_m());
    let (columns, rows) = (angle.cos() * step_m / grid.dx_m(), angle.sin() * step_m / grid.dy_m());
    let (reach_x, reach_y) = (0.5 * grid.nx() as f64, 0.5 * grid.ny() as f64);
    let mut before = 1.0;
    for sample in 1.. {
        let (x, y) = (f64::from(sample) * columns, f64::from(sample) * rows);
        if x.abs() > reach_x || y.abs() > reach_y {
            return None;
        }
        let here = bilinear(correlation, x, y);
        if here.is_nan() {
            return None;
        }
        if here <= level {
            return Some((f64::from(sample - 1) + (before - level) / (before - here)) * step_m);
        }
        before = here;
    }
    None
}

/// Correlation at a lag of (x, y) pixels.
fn bilinear(correlation: &Autocorrelation, x: f64, y: f64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| {
        let weight = (if right == 1 { x - column } else { 1.0 - (x - column) })
            * (if down == 1 { y - row } else { 1.0 - (y - row) });
        // Corners without weight may lie beyond the field.
        if weight == 0.0 { 0.0 } else { weight * correlation.correlation(column as isize + right, row as isize + down) }
    });
    corners.iter().sum()
}
