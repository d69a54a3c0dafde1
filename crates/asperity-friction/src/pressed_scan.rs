//! Friction of a scan that is pressed itself, as the check of its random strips.

use asperity_base::blocks::Task;
use asperity_base::map::HeightMap;
use asperity_base::monitor::Cancelled;
use asperity_base::stats::{Moments, ratio_95};
use asperity_contact::{Boundary, Control, rms_gradient};

use crate::strip::{Record, StripProblem};

/// Smallest and largest observed order of convergence with which a mean is extrapolated.
const ORDERS: std::ops::RangeInclusive<f64> = 0.5..=2.5;

/// Tiles along each side of the map for the sampling error.
const TILES: usize = 4;
/// Windows of a map along x and along y: four of them side by side for each tile along x, one along y.
pub const WINDOWS: [usize; 2] = [4 * TILES, TILES];

/// Friction of a pressed map.
#[derive(Debug, Clone, PartialEq)]
pub struct PressedScan {
    /// μ = ΣF/ΣN, extrapolated in the pitch.
    pub mean: Extrapolated,
    /// Half of the 95 % interval of the mean of the surface of which the map is a sample, from the differences between its tiles.
    pub sampling_error: f64,
    /// Standard deviation of friction between the windows at the mean load, on the finest grid.
    pub std: f64,
    /// Root-mean-square slope on the coarsest grid.
    pub rms_slope: f64,
    /// Fraction of the contact cells at the hardness.
    pub plastic_fraction: f64,
}

impl PressedScan {
    /// Presses one map, given on grids of falling pitch, each with the problem of its grid; returns the reason if there is no solution.
    ///
    /// The map is closed periodically at its edges. The windows of the problems are [`WINDOWS`] along its sides.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub fn new(
        maps: &[HeightMap],
        problems: &[StripProblem],
        control: Control,
        task: &Task<'_>,
    ) -> Result<Result<Self, String>, Cancelled> {
        let mut means = Vec::with_capacity(maps.len());
        let (mut sampling_error, mut std, mut plastic_fraction) = (f64::NAN, f64::NAN, 0.0);
        for (map, problem) in maps.iter().zip(problems) {
            let level = match problem.strips(map, 1, 0).solve_steps(&[control], task)?.remove(0) {
                Ok(level) => level,
                Err(error) => return Ok(Err(error.to_string())),
            };
            let stride = (problem.window.length_m() / problem.window.step_m()).round() as usize;
            let (mean, tracks) = Record::at_mean_load(&level.records);
            if !mean.is_finite() {
                return Ok(Err("it carries no load".into()));
            }
            (sampling_error, plastic_fraction) = (of_tiles(&level.records, stride), level.plastic_fraction());
            std = Moments::from_values(tracks.into_iter().flat_map(|track| track.friction)).std;
            means.push(mean);
        }
        let Some(mean) = Extrapolated::new(&means) else { return Ok(Err("there is no grid".into())) };
        let rms_slope = maps.first().map_or(f64::NAN, |map| {
            // Differences across the edges are not slopes of the surface.
            rms_gradient(map.heights_m(), map.grid(), Boundary::Free)
        });
        Ok(Ok(Self { mean, sampling_error, std, rms_slope, plastic_fraction }))
    }
}

/// Returns half of the 95 % interval of ΣF/ΣN over tiles of windows that do not overlap; `stride` is the number of positions per window.
///
/// Tiles count as independent, so they must be longer than the correlation of friction.
fn of_tiles(tracks: &[Record], stride: usize) -> f64 {
    let mut tiles = vec![[0.0; 2]; TILES * TILES];
    for (row, track) in tracks.iter().enumerate() {
        let windows = track.load_n.len() / stride;
        for window in 0..windows {
            let tile = row * TILES / tracks.len() * TILES + window * TILES / windows;
            tiles[tile][0] += track.friction_force_n[window * stride];
            tiles[tile][1] += track.load_n[window * stride];
        }
    }
    ratio_95(&tiles)[1]
}

/// Limit of values on grids of halved pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extrapolated {
    /// Limit.
    pub value: f64,
    /// Error of the limit; `None` if only one pitch was solved.
    pub error: Option<f64>,
    /// Observed order of convergence; `None` if it is below 0.5 or unknown.
    pub order: Option<f64>,
}

impl Extrapolated {
    /// Extrapolates values on grids of halved pitch, the finest last; `None` without a value. The order of convergence is observed on the
    /// last three. If it is not between 0.5 and 2.5, the limit is the last value, and its difference from the one before is the error.
    pub fn new(values: &[f64]) -> Option<Self> {
        match *values {
            [] => None,
            [value] => Some(Self { value, error: None, order: None }),
            [.., coarse, fine] => {
                let change = fine - coarse;
                let order = match *values {
                    [.., first, _, _] => Some(((coarse - first) / change).log2()),
                    _ => None,
                };
                let order = order.filter(|order| order.is_finite() && order >= ORDERS.start());
                if let Some(order) = order.filter(|order| ORDERS.contains(order)) {
                    let rest = change / (order.exp2() - 1.0);
                    return Some(Self { value: fine + rest, error: Some(rest.abs()), order: Some(order) });
                }
                Some(Self { value: fine, error: Some(change.abs()), order })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    #[test]
    fn values_of_one_order_have_their_limit_and_others_the_last_difference() {
        for order in [0.6, 1.0, 1.5, 2.4] {
            let values = [1.0, 0.5, 0.25].map(|h: f64| 0.3 + 0.05 * h.powf(order));
            let found = Extrapolated::new(&values).unwrap();
            assert!((found.value - 0.3).abs() < 1e-12 && (found.order.unwrap() - order).abs() < 1e-9, "{found:?}");
            assert!((found.error.unwrap() - 0.05 * 0.25_f64.powf(order)).abs() < 1e-12);
        }
        // Values that do not converge, oscillate or are equal, and too few.
        for values in [[0.3_f64, 0.31, 0.33], [0.3, 0.32, 0.31], [0.3, 0.3, 0.3]] {
            let error = Some((values[2] - values[1]).abs());
            assert_eq!(Extrapolated::new(&values), Some(Extrapolated { value: values[2], error, order: None }));
        }
        // Faster convergence than of any expected order.
        let fast = Extrapolated::new(&[0.3, 0.26, 0.255]).unwrap();
        assert_eq!((fast.value, fast.order), (0.255, Some(((0.26_f64 - 0.3) / (0.255 - 0.26)).log2())));
        let two = Extrapolated { value: 0.25, error: Some(0.3 - 0.25), order: None };
        assert_eq!(Extrapolated::new(&[0.3, 0.25]), Some(two));
        assert_eq!(Extrapolated::new(&[0.3]).unwrap().error, None);
        assert_eq!(Extrapolated::new(&[]), None);
    }

    #[test]
    fn the_sampling_error_covers_the_mean_of_independent_tiles() {
        // Windows of load 1 + .3 z and force .2 N + .01 z: 16 tiles of 4 windows of one position.
        let (repeats, mut covered) = (1000, 0);
        for repeat in 0..repeats {
            let z = random::standard_normal(&mut random::stream(6, "tiles", repeat), 2 * WINDOWS[0] * TILES);
            let track = |row: usize| {
                let of = |value: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
                    (0..WINDOWS[0])
                        .map(|k| value(z[2 * (row * WINDOWS[0] + k)], z[2 * (row * WINDOWS[0] + k) + 1]))
                        .collect()
                };
                let load_n = of(&|a, _| 1.0 + 0.3 * a);
                let friction_force_n = of(&|a, b| 0.2 * (1.0 + 0.3 * a) + 0.01 * b);
                let unused = load_n.clone();
                Record {
                    position_m: unused.clone(),
                    friction: unused.clone(),
                    contact_cells: unused.clone(),
                    area_m2: unused,
                    friction_force_n,
                    load_n,
                }
            };
            let tracks: Vec<Record> = (0..TILES).map(track).collect();
            let mean = Record::at_mean_load(&tracks).0;
            covered += usize::from((mean - 0.2).abs() <= of_tiles(&tracks, 1));
        }
        // Binomial standard error 0.7 %.
        assert!((930..=970).contains(&covered), "{covered} of {repeats}");
    }
}
