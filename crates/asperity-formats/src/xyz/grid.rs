//! Grid of a list of points.

use std::collections::HashSet;

use crate::refuse_if;

/// Maximum distance of a point from its grid point, as a fraction of a step.
pub(super) const TOLERANCE: f64 = 0.25;
/// Maximum number of grid points per point of the list.
pub(super) const MAX_SPREAD: f64 = 4.0;
/// Least ratio of a step to the jitter.
const LEAST_RATIO: f64 = 4.0;
/// Fewest points that show a grid by their coordinates alone, and the least fraction of it that they fill.
const FEWEST: usize = 9;
const LEAST_FILLED: f64 = 0.6;
/// Number of points per one that has no place of its own, from which shuffled points are recognised.
const FEW_FLAWS: usize = 10;
/// Fraction of the range of a coordinate below which differences are rounding errors.
const ROUNDING: f64 = 1e-12;

/// List of points, `[x, y, z]` one after the other.
#[derive(Clone, Copy)]
pub(super) struct Points<'a>(pub(super) &'a [f64]);

/// Equally spaced lines of a grid along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    pub(super) first: f64,
    pub(super) step: f64,
    pub(super) lines: usize,
}

/// Heights on a grid: rows from the lowest y on, NaN for grid points without a point.
pub(super) struct Grid {
    pub(super) axes: [Axis; 2],
    pub(super) heights: Vec<f64>,
}

/// Reason why points do not form a grid.
#[derive(Debug, PartialEq)]
pub(super) enum NoGrid {
    /// A coordinate of a point is not finite.
    NotFinite { point: usize, axis: usize },
    /// All points have the same coordinate along an axis, or there are too few.
    Line { axis: usize },
    /// Most of the grid would be empty.
    Sparse { columns: f64, rows: f64 },
    /// A point is `steps` steps away from a grid point.
    Off { point: usize, axis: usize, steps: f64 },
    /// Two points are on one grid point.
    Twice { point: usize },
}

impl<'a> Points<'a> {
    pub(super) fn len(self) -> usize {
        self.0.len() / 3
    }

    fn coordinates(self, axis: usize) -> impl Iterator<Item = f64> + 'a {
        self.0.chunks_exact(3).map(move |point| point[axis])
    }

    /// Returns the spacing of a square grid with as many points on the same area.
    pub(super) fn spacing(self) -> f64 {
        let range = |axis| {
            let ends = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
            let (low, high) = self.coordinates(axis).fold((f64::INFINITY, f64::NEG_INFINITY), ends);
            high - low
        };
        (range(0) * range(1) / self.len() as f64).sqrt()
    }

    /// Returns the distances between successive points.
    fn steps(self, axis: usize) -> Vec<f64> {
        self.coordinates(axis).zip(self.coordinates(axis).skip(1)).map(|(a, b)| (b - a).abs()).collect()
    }

    /// Arranges the points on their grid.
    ///
    /// # Errors
    /// The points, taken line by line and in any order, do not lie on a grid.
    pub(super) fn grid(self) -> Result<Grid, NoGrid> {
        self.by_lines().or_else(|reason| self.in_any_order().map_err(|_| reason))
    }

    /// Arranges points that are in lines of any order: along a line the fast coordinate changes by the pitch, and the other only
    /// jitters. Coordinates closer than the steps allow belong to one grid line.
    fn by_lines(self) -> Result<Grid, NoGrid> {
        for axis in [0, 1] {
            if let Some(point) = self.coordinates(axis).position(|x| !x.is_finite()) {
                return Err(NoGrid::NotFinite { point, axis });
            }
        }
        let usual = [0, 1].map(|axis| part(&mut self.steps(axis), 0.5));
        let fast = usize::from(usual[1] > usual[0]);
        // With missing points the usual step may be several grid steps, but a quarter of the steps are single.
        let step = Some(part(&mut self.steps(fast), 0.25)).filter(|step| *step > 0.0).unwrap_or(usual[fast]);
        // Uniform jitter of ±j gives the slow coordinate a median step of 0.6 j, and at most 2 j.
        let width = |axis| if axis == fast { step / 2.0 } else { 4.0 * usual[axis] };
        let axis = |axis| Axis::fit(self.coordinates(axis).collect(), width(axis)).ok_or(NoGrid::Line { axis });
        let axes = [axis(0)?, axis(1)?];
        let [columns, rows] = axes.map(|axis| axis.lines as f64);
        refuse_if!(columns * rows > MAX_SPREAD * self.len() as f64, NoGrid::Sparse { columns, rows });
        self.fill(axes)
    }

    /// Arranges points in any order. The distances between successive coordinates are jitter within a grid line and pitch between two;
    /// the largest ratio between two of them tells one from the other.
    fn in_any_order(self) -> Result<Grid, NoGrid> {
        // Coordinates without jitter may leave out lines, whose gaps would pass for steps.
        self.with_lines_of(|_| 0.0).or_else(|_| self.with_lines_of(jitter))
    }

    fn with_lines_of(self, width: impl Fn(&[f64]) -> f64) -> Result<Grid, NoGrid> {
        let axis = |axis| {
            let coordinates: Vec<f64> = self.coordinates(axis).collect();
            let width = width(&coordinates);
            Axis::fit(coordinates, width).ok_or(NoGrid::Line { axis })
        };
        let axes = [axis(0)?, axis(1)?];
        let [columns, rows] = axes.map(|axis| axis.lines as f64);
        // Few numbers lie on some sparse grid by chance.
        let is_grid = self.len() >= FEWEST && columns * rows * LEAST_FILLED <= self.len() as f64;
        refuse_if!(!is_grid, NoGrid::Sparse { columns, rows });
        self.fill(axes)
    }

    /// Returns the points with coordinates of their own, and the first other one.
    pub(super) fn sound(self) -> (Vec<f64>, Option<NoGrid>) {
        let (mut kept, mut first, mut taken) = (Vec::with_capacity(self.0.len()), None, HashSet::new());
        for (point, position) in self.0.chunks_exact(3).enumerate() {
            // The sum turns -0 into 0.
            let place = [0, 1].map(|axis: usize| (position[axis] + 0.0).to_bits());
            let flaw = match [0, 1].into_iter().find(|&axis| !position[axis].is_finite()) {
                Some(axis) => Some(NoGrid::NotFinite { point, axis }),
                None => (!taken.insert(place)).then_some(NoGrid::Twice { point }),
            };
            match flaw {
                Some(flaw) => first = first.or(Some(flaw)),
                None => kept.extend_from_slice(position),
            }
        }
        (kept, first)
    }

    /// Returns whether the points, but for a few without a place of their own, fill a grid, in any order.
    pub(super) fn are_shuffled(self) -> bool {
        let (sound, _) = self.sound();
        FEW_FLAWS * (self.0.len() - sound.len()) <= self.0.len() && Points(&sound).in_any_order().is_ok()
    }

    fn fill(self, axes: [Axis; 2]) -> Result<Grid, NoGrid> {
        let [columns, rows] = axes.map(|axis| axis.lines);
        let mut heights = vec![f64::NAN; columns * rows];
        let mut taken = vec![false; columns * rows];
        for (point, position) in self.0.chunks_exact(3).enumerate() {
            let mut place = [0; 2];
            for axis in [0, 1] {
                let Axis { first, step, lines } = axes[axis];
                let steps = (position[axis] - first) / step;
                let line = steps.round().clamp(0.0, (lines - 1) as f64);
                refuse_if!((steps - line).abs() > TOLERANCE, NoGrid::Off { point, axis, steps: (steps - line).abs() });
                place[axis] = line as usize;
            }
            let place = place[1] * columns + place[0];
            refuse_if!(std::mem::replace(&mut taken[place], true), NoGrid::Twice { point });
            heights[place] = position[2];
        }
        Ok(Grid { axes, heights })
    }
}

impl Axis {
    /// Fits grid lines to coordinates. Coordinates less than `width` apart belong to one line.
    fn fit(mut coordinates: Vec<f64>, width: f64) -> Option<Self> {
        coordinates.sort_unstable_by(f64::total_cmp);
        let (low, high) = (*coordinates.first()?, *coordinates.last()?);
        let width = width.max(ROUNDING * (high - low));
        let centres: Vec<f64> = coordinates
            .chunk_by(|a, b| b - a <= width)
            .map(|line| line.iter().map(|x| x - low).sum::<f64>() / line.len() as f64)
            .collect();
        drop(coordinates);
        let gaps = || centres.windows(2).map(|pair| pair[1] - pair[0]);
        let usual = part(&mut gaps().collect::<Vec<_>>(), 0.5);
        let single: Vec<f64> = gaps().filter(|gap| (0.5..=1.5).contains(&(gap / usual))).collect();
        let usual = single.iter().sum::<f64>() / single.len() as f64;
        let steps: f64 = gaps().map(|gap| (gap / usual).round().max(1.0)).sum();
        let step = (centres.last()? - centres.first()?) / steps;
        (step.is_finite() && step > 0.0).then(|| Self {
            first: low + centres[0],
            step,
            lines: (steps as usize).saturating_add(1),
        })
    }
}

/// Returns the largest distance of coordinates on one grid line: the distance before the largest ratio of successive distances, and 0 if
/// equal coordinates alone are on one line.
fn jitter(coordinates: &[f64]) -> f64 {
    let mut sorted = coordinates.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let [Some(low), Some(high)] = [sorted.first(), sorted.last()] else { return 0.0 };
    let rounding = ROUNDING * (high - low);
    let mut gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > rounding).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let widest = gaps.windows(2).map(|pair| (pair[1] / pair[0], pair[0])).max_by(|a, b| a.0.total_cmp(&b.0));
    // Gaps of several steps, where points are missing, have smaller ratios.
    widest.filter(|(ratio, _)| *ratio > LEAST_RATIO).map_or(0.0, |(_, gap)| gap)
}

/// Returns the quantile of the values; NaN if there is none.
fn part(values: &mut [f64], part: f64) -> f64 {
    match values.len().checked_sub(1) {
        Some(last) => *values.select_nth_unstable_by((last as f64 * part) as usize, f64::total_cmp).1,
        None => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(coordinates: &[f64], width: f64) -> Option<Axis> {
        Axis::fit(coordinates.to_vec(), width)
    }

    #[test]
    fn rounded_coordinates_give_the_true_step() {
        // Steps of 10/3 printed as whole numbers: 3 or 4 apart.
        let coordinates: Vec<f64> = (0..31).map(|line| (f64::from(line) * 10.0 / 3.0).round()).collect();
        let found = axis(&coordinates, 0.0).unwrap();
        assert_eq!(found.lines, 31);
        assert!((found.step - 10.0 / 3.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn lines_that_are_missing_are_counted() {
        let found = axis(&[0.0, 0.5, 0.5, 1.0, 3.5, 4.0], 0.0).unwrap();
        assert_eq!(found, Axis { first: 0.0, step: 0.5, lines: 9 });
    }

    #[test]
    fn one_line_is_not_an_axis() {
        assert_eq!(axis(&[2.0, 2.0, 2.0], 0.0), None);
        assert_eq!(axis(&[], 0.0), None);
    }

    #[test]
    fn coordinates_beyond_the_range_of_f64_are_not_an_axis() {
        assert_eq!(axis(&[-1e308, 0.0, 1e308], 0.0), None);
    }
}
