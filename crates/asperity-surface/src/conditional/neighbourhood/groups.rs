//! Groups of missing points that share one neighbourhood of measured heights.

use std::collections::BTreeMap;

use super::pyramid::Pyramid;
use asperity_base::blocks;
use asperity_base::map::Grid;
use asperity_base::monitor::{Cancelled, Monitor};

/// Side in points of the tiles whose small voids share a neighbourhood.
const TILE: usize = 8;
/// Number of points and side in points above which a void is divided without trying it as a whole.
const WHOLE_POINTS: usize = 4096;
const WHOLE_SIDE: usize = 96;
/// Least number of points and shortest side of a part.
const FEW_POINTS: usize = 24;
const SHORT_SIDE: usize = 8;
/// Floating-point operations of the factorisations of a map, least and largest number of them for each missing point,
/// and the resulting limits of the number of heights.
const WORK: f64 = 5e10;
pub(super) const LEAST_WORK_PER_POINT: f64 = 1.5e6;
const MOST_WORK_PER_POINT: f64 = 2e7;
const FEWEST_HEIGHTS: f64 = 150.0;
const MOST_HEIGHTS: f64 = 2000.0;
/// Largest number of heights of any neighbourhood.
const HEIGHTS_AT_MOST: usize = 4000;
/// Distances in points within which all heights are used, in the order of the search.
const DENSE: [f64; 6] = [3.0, 4.0, 6.0, 8.0, 12.0, 16.0];

/// Missing points, and the heights on which they are conditioned.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    /// Places of the missing points.
    pub(super) targets: Vec<u32>,
    /// Weight of this group at each missing point; the weights of all groups at a point add up to 1.
    pub(super) weights: Vec<f64>,
    /// Numbers of the measured heights.
    pub(super) heights: Vec<u32>,
}

/// Returns the floating-point operations available for each of this number of missing points.
pub(super) fn work_per_point(missing: usize) -> f64 {
    (WORK / missing as f64).clamp(LEAST_WORK_PER_POINT, MOST_WORK_PER_POINT)
}

/// Divides all missing points of a map into groups.
///
/// Voids that are connected by sides or corners stay together if one neighbourhood suffices. Small voids within a tile
/// share one. Large voids are divided into overlapping parts with smooth transitions.
pub(super) fn groups(
    pyramid: &Pyramid,
    grid: Grid,
    work_per_point: f64,
    monitor: &dyn Monitor,
) -> Result<Vec<Group>, Cancelled> {
    let (ny, nx) = grid.shape();
    let (regions, labels) = regions(pyramid.places(), grid);
    let cutter = Cutter { pyramid, labels, nx, work_per_point };
    let mut tiles = BTreeMap::<(usize, usize), Vec<u32>>::new();
    let mut jobs = Vec::new();
    for (label, region) in regions.into_iter().enumerate() {
        let sides = pyramid.targets(&region).sides;
        if sides[2] - sides[0] < TILE && sides[3] - sides[1] < TILE {
            let middle = [0, 1].map(|axis| (sides[axis] + sides[axis + 2]) / 2 / TILE);
            tiles.entry((middle[1], middle[0])).or_default().extend(region);
        } else {
            jobs.push(Job::Void(label as u32, sides));
        }
    }
    jobs.extend(tiles.into_values().map(Job::Tile));
    let mut found = Vec::new();
    let (mut done, total) = (0, jobs.len());
    for some in jobs.chunks(64 * rayon::current_num_threads()) {
        if monitor.cancelled() {
            return Err(Cancelled);
        }
        monitor.progress("neighbourhoods", done, total);
        let cut: Vec<Vec<Group>> = blocks::map(0..some.len(), |job| match &some[job] {
            _ if monitor.cancelled() => Vec::new(),
            Job::Tile(places) => vec![cutter.tile(places)],
            Job::Void(label, [left, top, right, bottom]) => {
                let whole = Part { label: *label, first: [*left, *top], end: [right + 1, bottom + 1], whole: true };
                cutter.cut(&whole, monitor)
            }
        });
        found.extend(cut.into_iter().flatten());
        done += some.len();
    }
    if monitor.cancelled() {
        return Err(Cancelled);
    }
    monitor.progress("neighbourhoods", total, total);
    let mut sums = vec![0.0; nx * ny];
    for group in &found {
        group.targets.iter().zip(&group.weights).for_each(|(place, weight)| sums[*place as usize] += weight);
    }
    for group in &mut found {
        group.targets.iter().zip(&mut group.weights).for_each(|(place, weight)| *weight /= sums[*place as usize]);
    }
    Ok(found)
}

enum Job {
    /// Places of small adjacent voids.
    Tile(Vec<u32>),
    /// Label and sides of one void.
    Void(u32, [usize; 4]),
}

/// Divides voids into parts.
struct Cutter<'a> {
    pyramid: &'a Pyramid,
    /// Number of the void at each place.
    labels: Vec<u32>,
    nx: usize,
    work_per_point: f64,
}

/// Part of a void in a rectangle of columns and rows from `first` up to, but without, `end`.
struct Part {
    label: u32,
    first: [usize; 2],
    end: [usize; 2],
    /// Whether the part is the whole void.
    whole: bool,
}

impl Cutter<'_> {
    fn tile(&self, places: &[u32]) -> Group {
        let most = self.most_heights(places.len());
        let heights = self.heights(places, most).unwrap_or_else(|| self.fewest_heights(places));
        Group { targets: places.to_vec(), weights: vec![1.0; places.len()], heights }
    }

    /// Halves a part until its neighbourhood is small enough for its number of points.
    fn cut(&self, part: &Part, monitor: &dyn Monitor) -> Vec<Group> {
        if monitor.cancelled() {
            return Vec::new();
        }
        let sides = [part.end[0] - part.first[0], part.end[1] - part.first[1]];
        let (longer, side) = if sides[0] >= sides[1] { (0, sides[0]) } else { (1, sides[1]) };
        // Parts overlap by an eighth of their side on either side of a cut.
        let overlap = if part.whole { 0 } else { (sides[0].min(sides[1]) / 8).max(2) };
        let (targets, weights) = self.points(part, overlap);
        let within = |axis: usize, at: usize| (part.first[axis]..part.end[axis]).contains(&at);
        if !targets.iter().any(|place| within(0, *place as usize % self.nx) && within(1, *place as usize / self.nx)) {
            return Vec::new();
        }
        let divisible = targets.len() > FEW_POINTS && side > SHORT_SIDE;
        let too_large = targets.len() > WHOLE_POINTS || side > WHOLE_SIDE;
        if !(divisible && too_large) {
            let heights = self.heights(&targets, self.most_heights(targets.len()));
            if let Some(heights) = heights.or_else(|| (!divisible).then(|| self.fewest_heights(&targets))) {
                return vec![Group { targets, weights, heights }];
            }
        }
        let middle = part.first[longer] + side / 2;
        let (mut one, mut other) = (part.end, part.first);
        (one[longer], other[longer]) = (middle, middle);
        let (one, other) = (Part { end: one, whole: false, ..*part }, Part { first: other, whole: false, ..*part });
        let (mut groups, others) = rayon::join(|| self.cut(&one, monitor), || self.cut(&other, monitor));
        groups.extend(others);
        groups
    }

    /// Returns the points of a part with their weights, which fall linearly over the overlap on either side of its
    /// edges.
    fn points(&self, part: &Part, overlap: usize) -> (Vec<u32>, Vec<f64>) {
        let ny = self.labels.len() / self.nx;
        let span = |axis: usize, n: usize| part.first[axis].saturating_sub(overlap)..(part.end[axis] + overlap).min(n);
        let (mut targets, mut weights) = (Vec::new(), Vec::new());
        for row in span(1, ny) {
            for column in span(0, self.nx) {
                let place = row * self.nx + column;
                if self.labels[place] == part.label {
                    targets.push(place as u32);
                    weights.push(weight(part, 0, column, overlap) * weight(part, 1, row, overlap));
                }
            }
        }
        (targets, weights)
    }

    /// Returns the largest number of heights whose factorisation is affordable for this number of missing points.
    fn most_heights(&self, points: usize) -> usize {
        (3.0 * self.work_per_point * points as f64).cbrt().clamp(FEWEST_HEIGHTS, MOST_HEIGHTS) as usize
    }

    /// Returns the best neighbourhood of at most `most` heights, if there is one.
    fn heights(&self, places: &[u32], most: usize) -> Option<Vec<u32>> {
        let targets = self.pyramid.targets(places);
        let found = DENSE.iter().map_while(|dense| self.pyramid.around(&targets, *dense, most)).last();
        found.map(numbers)
    }

    /// Returns the smallest neighbourhood, truncated if it exceeds all bounds.
    fn fewest_heights(&self, places: &[u32]) -> Vec<u32> {
        let found = self.pyramid.around(&self.pyramid.targets(places), DENSE[0], usize::MAX);
        let mut heights = numbers(found.unwrap_or_default());
        heights.truncate(HEIGHTS_AT_MOST);
        heights
    }
}

fn numbers(found: Vec<(f64, u32)>) -> Vec<u32> {
    found.into_iter().map(|(_, height)| height).collect()
}

/// Returns a trapezoidal weight: one half at the edges of the part, falling to zero where only its neighbour counts.
fn weight(part: &Part, axis: usize, at: usize, overlap: usize) -> f64 {
    if overlap == 0 {
        return 1.0;
    }
    let (first, end, at) = (part.first[axis] as f64, part.end[axis] as f64, at as f64 + 0.5);
    let inside = (at - first).min(end - at);
    (0.5 + 0.5 * inside / (overlap as f64 + 0.5)).clamp(0.0, 1.0)
}

/// Label of a place outside of all voids.
const NONE: u32 = u32::MAX;

/// Returns the missing points connected by sides or corners, each in row order, and the number of the void at each
/// place.
fn regions(present: &[usize], grid: Grid) -> (Vec<Vec<u32>>, Vec<u32>) {
    let (ny, nx) = grid.shape();
    let mut labels = vec![0; nx * ny];
    present.iter().for_each(|place| labels[*place] = NONE);
    let mut waiting: Vec<bool> = labels.iter().map(|label| *label == 0).collect();
    let mut regions = Vec::new();
    for start in 0..nx * ny {
        if !waiting[start] {
            continue;
        }
        waiting[start] = false;
        let (mut region, mut next) = (vec![start as u32], 0);
        while next < region.len() {
            let (row, column) = (region[next] as usize / nx, region[next] as usize % nx);
            labels[region[next] as usize] = regions.len() as u32;
            next += 1;
            for r in row.saturating_sub(1)..(row + 2).min(ny) {
                for c in column.saturating_sub(1)..(column + 2).min(nx) {
                    if waiting[r * nx + c] {
                        waiting[r * nx + c] = false;
                        region.push((r * nx + c) as u32);
                    }
                }
            }
        }
        region.sort_unstable();
        regions.push(region);
    }
    (regions, labels)
}
