//! Sliding distances at which the friction of two rough bodies is solved.

use std::collections::BTreeMap;

use asperity_base::map::Grid;

/// Number of distances within the correlation, in a geometric sequence, and far beyond it.
const NEAR: usize = 5;
const FAR: usize = 2;
/// Largest number of sliding distances at which each strip is solved again.
pub const DISTANCES: usize = NEAR + FAR;
/// Correlation lengths of the track that the longest near distance exceeds the window by.
const REACH_LENGTHS: f64 = 3.0;
/// Fractions of a correlation length of the track and of the window, the smaller of which is the shortest distance.
const LENGTH_FRACTION: f64 = 0.5;
const WINDOW_FRACTION: f64 = 0.125;

/// Sliding distances on a periodic strip and the distances between them, in cells.
pub(super) struct Distances {
    /// Distances, from 0.
    cells: Vec<usize>,
    /// Pairs of places in `cells` by the distance between them, within the correlation.
    pub(super) near: BTreeMap<usize, Vec<[usize; 2]>>,
    /// Pairs of places in `cells` at least a quarter of the strip apart.
    pub(super) far: Vec<[usize; 2]>,
    /// Length of a cell in metre.
    pub(super) cell_m: f64,
}

impl Distances {
    /// Chooses the distances for the length of a window and the correlation length of the track; without the latter the correlation
    /// of friction is taken for that of the window.
    pub(super) fn new(grid: Grid, window_m: f64, track_length_m: Option<f64>) -> Self {
        let (nx, cell_m) = (grid.nx(), grid.dx_m());
        let length_m = track_length_m.unwrap_or(0.0);
        let longest = ((window_m + REACH_LENGTHS * length_m) / cell_m).min(0.25 * nx as f64);
        let resolved_m = track_length_m.map_or(window_m, |length_m| LENGTH_FRACTION * length_m);
        let shortest = (resolved_m.min(WINDOW_FRACTION * window_m) / cell_m).clamp(1.0, longest.max(1.0));
        let ratio = (longest / shortest).powf(1.0 / (NEAR - 1) as f64);
        let near = (0..NEAR).map(|place| (shortest * ratio.powi(place as i32)).round() as usize);
        let mut cells: Vec<usize> = std::iter::once(0).chain(near).collect();
        cells.dedup();
        let within = cells.len();
        cells.extend((1..=FAR).map(|third| third * nx / (FAR + 1)));
        let apart = |[a, b]: [usize; 2]| {
            let distance: usize = cells[a].abs_diff(cells[b]);
            distance.min(nx - distance)
        };
        let (mut near, mut far) = (BTreeMap::<usize, Vec<[usize; 2]>>::new(), Vec::new());
        for pair in (0..cells.len()).flat_map(|b| (0..b).map(move |a| [a, b])) {
            if pair[1] < within {
                near.entry(apart(pair)).or_default().push(pair);
            } else if 4 * apart(pair) >= nx {
                far.push(pair);
            }
        }
        Self { cells, near, far, cell_m }
    }

    /// Returns the distances other than 0.
    pub(super) fn moved(&self) -> &[usize] {
        &self.cells[1..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_resolve_the_track_and_reach_beyond_the_window() {
        let grid = Grid::new(2048, 32, 3e-6, 3e-6).unwrap();
        // A window of 200 cells, and tracks of 8, of 800 and of unknown length.
        for (length_m, shortest, longest) in [(Some(24e-6), 4, 224), (Some(2.4e-3), 25, 512), (None, 25, 200)] {
            let distances = Distances::new(grid, 600e-6, length_m);
            assert_eq!(distances.moved().len(), DISTANCES);
            let lags: Vec<usize> = distances.near.keys().copied().collect();
            assert_eq!([distances.cells[1], lags[lags.len() - 1]], [shortest, longest], "{lags:?}");
            assert!(lags[0] > 0 && lags[0] <= shortest, "{lags:?}");
            assert_eq!(distances.near.values().map(Vec::len).sum::<usize>(), 15);
            let apart = |a: usize, b: usize| distances.cells[b].abs_diff(distances.cells[a]);
            assert!(distances.far.len() >= 7);
            assert!(distances.far.iter().all(|[a, b]| (512..=1536).contains(&apart(*a, *b))));
        }
        // On a coarse grid some distances are the same.
        let coarse = Distances::new(Grid::new(40, 4, 3e-6, 3e-6).unwrap(), 12e-6, Some(1e-6));
        assert!(coarse.moved().len() < DISTANCES && coarse.near.keys().all(|lag| *lag > 0));
    }
}
