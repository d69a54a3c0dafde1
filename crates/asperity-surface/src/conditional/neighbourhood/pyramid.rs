//! Measured heights, thinned level by level.

use rayon::prelude::*;

use super::metric::Metric;
use asperity_base::blocks;
use asperity_base::map::Grid;

/// Measured heights of a map, thinned level by level to one per cell of a lattice in the frame of the metric. The
/// pitch of the lattice doubles from level to level.
#[derive(Debug)]
pub(super) struct Pyramid {
    metric: Metric,
    nx: usize,
    ny: usize,
    /// Place of each height.
    places: Vec<usize>,
    /// Number of the height at each place; [`MISSING`] if there is none.
    heights: Vec<u32>,
    /// Binary logarithm of half the pitch of the first level.
    finest: i32,
    levels: Vec<Level>,
}

/// Marks a place without height.
const MISSING: u32 = u32::MAX;

/// One height per cell, sorted by row and column of the cell.
#[derive(Debug)]
struct Level {
    cells: Vec<(i32, i32, u32)>,
}

impl Pyramid {
    /// Creates the levels of the heights at `places` of a map on `grid`.
    pub(super) fn new(metric: Metric, grid: Grid, places: Vec<usize>) -> Self {
        let (ny, nx) = grid.shape();
        let mut heights = vec![MISSING; grid.points()];
        for (height, place) in places.iter().enumerate() {
            heights[*place] = height as u32;
        }
        let finest = -(metric.elongation().log2().ceil() as i32);
        let [width, height] = [metric.frame(nx as f64, 0.0), metric.frame(0.0, ny as f64)];
        let largest = (width[0].abs() + height[0].abs()).hypot(width[1].abs() + height[1].abs());
        let coarsest = metric.reach().min(largest).log2().ceil() as i32;
        let mut pyramid = Self { metric, nx, ny, places, heights, finest, levels: Vec::new() };
        let mut kept: Vec<u32> = (0..pyramid.places.len() as u32).collect();
        for exponent in finest + 1..=coarsest {
            let level = pyramid.thinned(&kept, 2.0_f64.powi(exponent));
            kept = level.cells.iter().map(|cell| cell.2).collect();
            pyramid.levels.push(level);
        }
        pyramid
    }

    /// Returns, out of `kept`, the height next to the centre of each cell of a lattice of this pitch.
    fn thinned(&self, kept: &[u32], pitch: f64) -> Level {
        let mut found: Vec<(i32, i32, f64, u32)> = blocks::map(0..kept.len(), |index| {
            let height = &kept[index];
            let [u, v] = self.frame_of(self.places[*height as usize]).map(|t| t / pitch);
            let (column, row) = (u.floor(), v.floor());
            let off = (u - column - 0.5).powi(2) + (v - row - 0.5).powi(2);
            (row as i32, column as i32, off, *height)
        });
        found.par_sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)).then(a.3.cmp(&b.3)));
        found.dedup_by_key(|cell| (cell.0, cell.1));
        Level { cells: found.into_iter().map(|(row, column, _, height)| (row, column, height)).collect() }
    }

    /// Transforms a place to the frame of the metric, half a point off, so that no place lies between two cells.
    fn frame_of(&self, place: usize) -> [f64; 2] {
        self.metric.frame((place % self.nx) as f64 + 0.5, (place / self.nx) as f64 + 0.5)
    }

    /// Returns the places of the heights, by their numbers.
    pub(super) fn places(&self) -> &[usize] {
        &self.places
    }

    pub(super) fn into_places(self) -> Vec<usize> {
        self.places
    }

    /// Returns the heights around `targets` with their squared distances to them, nearest first: all within `dense`
    /// times the elongation of the lobe, and beyond thinned to a spacing of about 1/`dense` of their distance. Returns
    /// `None` if they are more than `most`.
    pub(super) fn around(&self, targets: &Targets, dense: f64, most: usize) -> Option<Vec<(f64, u32)>> {
        let mut found = Vec::new();
        let mut outer = dense * 2.0_f64.powi(self.finest);
        self.within(targets, outer, most, &mut found);
        for (level, exponent) in self.levels.iter().zip(self.finest + 1..) {
            let inner = outer;
            outer *= 2.0;
            if inner > self.metric.reach() {
                break;
            }
            let pitch = 2.0_f64.powi(exponent);
            let [low_u, low_v, high_u, high_v] = targets.bounds;
            let cell = |t: f64| (t / pitch).floor() as i32;
            let (first, last) = (cell(low_u - outer), cell(high_u + outer));
            for row in cell(low_v - outer)..=cell(high_v + outer) {
                if found.len() > most {
                    return None;
                }
                let from = level.cells.partition_point(|c| (c.0, c.1) < (row, first));
                for (_, _, height) in level.cells[from..].iter().take_while(|c| c.0 == row && c.1 <= last) {
                    let squared = targets.squared_distance(self.frame_of(self.places[*height as usize]));
                    if (inner * inner..outer * outer).contains(&squared) {
                        found.push((squared, *height));
                    }
                }
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        (found.len() <= most).then_some(found)
    }

    /// Collects all heights within `radius`, or some more than `most`.
    fn within(&self, targets: &Targets, radius: f64, most: usize, found: &mut Vec<(f64, u32)>) {
        let (half_x, half_y) = self.metric.half_sides(radius);
        let [left, top, right, bottom] = targets.sides;
        let rows = top.saturating_sub(half_y as usize)..(bottom + half_y as usize + 1).min(self.ny);
        for row in rows {
            if found.len() > most {
                return;
            }
            for column in left.saturating_sub(half_x as usize)..(right + half_x as usize + 1).min(self.nx) {
                let height = self.heights[row * self.nx + column];
                if height != MISSING {
                    let squared = targets.squared_distance(self.frame_of(row * self.nx + column));
                    if squared < radius * radius {
                        found.push((squared, height));
                    }
                }
            }
        }
    }

    /// Prepares the missing `places` for the search of heights around them.
    pub(super) fn targets(&self, places: &[u32]) -> Targets {
        let at = |place: u32| (place as usize % self.nx, place as usize / self.nx);
        let mut sides = [usize::MAX, usize::MAX, 0, 0];
        for place in places {
            let (column, row) = at(*place);
            sides = [sides[0].min(column), sides[1].min(row), sides[2].max(column), sides[3].max(row)];
        }
        // The nearest target is always on the rim.
        let width = sides[2] - sides[0] + 3;
        let mut mask = vec![false; width * (sides[3] - sides[1] + 3)];
        let inside = |place: u32| {
            let (column, row) = at(place);
            (row - sides[1] + 1) * width + column - sides[0] + 1
        };
        places.iter().for_each(|place| mask[inside(*place)] = true);
        let on_rim = |place: &&u32| {
            let i = inside(**place);
            !(mask[i - 1] && mask[i + 1] && mask[i - width] && mask[i + width])
        };
        let rim: Vec<[f64; 2]> = places.iter().filter(on_rim).map(|place| self.frame_of(*place as usize)).collect();
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for [u, v] in &rim {
            bounds = [bounds[0].min(*u), bounds[1].min(*v), bounds[2].max(*u), bounds[3].max(*v)];
        }
        Targets { sides, bounds, rim }
    }
}

/// Missing points around which heights are searched.
#[derive(Debug)]
pub(super) struct Targets {
    /// First and last column and row: left, top, right, bottom.
    pub(super) sides: [usize; 4],
    /// The sides in the frame of the metric.
    bounds: [f64; 4],
    /// Targets that are not surrounded by others, in the frame.
    rim: Vec<[f64; 2]>,
}

impl Targets {
    fn squared_distance(&self, [u, v]: [f64; 2]) -> f64 {
        // Four independent minima, because each comparison waits for the one before.
        let mut least = [f64::INFINITY; 4];
        for some in self.rim.chunks(4) {
            for (least, [a, b]) in least.iter_mut().zip(some) {
                let squared = (a - u) * (a - u) + (b - v) * (b - v);
                *least = if squared < *least { squared } else { *least };
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}
