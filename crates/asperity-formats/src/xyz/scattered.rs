//! Whether three columns without a header are heights or points that lie on no grid.

use std::f64::consts::PI;

/// Points below which columns of heights could look like coordinates by chance.
const MIN_POINTS: usize = 32;
/// Points around the middle of the list whose distances are compared.
const COMPARED: usize = 512;
/// Points of a scan keep apart: in all but one of 20 the nearest neighbour is farther than this part of the usual distance.
/// Points at random have 0.27.
const MIN_DISTANCE: f64 = 0.5;
/// Usual distances within which neighbours are counted, and neighbours that points in a plane have there. Points on a curve
/// have 4, points at random 4.3, points of a square grid 20.
const RADIUS: f64 = 2.5;
const MIN_NEIGHBOURS: f64 = 6.0;
/// Usual distances that the usual step from a point to the next may take: lists follow lines.
const MAX_STEP: f64 = 3.0;
/// Interquartile ranges of the heights in that of either coordinate: columns of one surface have about the same range.
const FLATNESS: f64 = 30.0;
/// Usual distance times the root of the points per area: 0.47 for points at random, 1 on a square grid, 0.05 on a line.
const MIN_EVENNESS: f64 = 0.3;

/// Whether the first two of three columns are coordinates: their points fill a plane, and either their range is far beyond that
/// of the third column, or they keep apart and follow lines.
pub(crate) fn are_coordinates(values: &[f64]) -> bool {
    let mut points: Vec<[f64; 2]> = values.chunks_exact(3).map(|row| [row[0], row[1]]).collect();
    if points.len() < MIN_POINTS || points.iter().flatten().any(|x| !x.is_finite()) {
        return false;
    }
    let distance = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let mut steps: Vec<f64> = points.windows(2).map(|pair| distance(&pair[0], &pair[1])).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let middle = points[points.len() / 2];
    points.sort_unstable_by(|a, b| distance(a, &middle).total_cmp(&distance(b, &middle)));
    points.truncate(COMPARED);
    let distances = |point: [f64; 2]| points.iter().map(move |other| distance(other, &point));
    // The nearest after the point itself.
    let second = |(first, second): (f64, f64), next: f64| (first.min(next), second.min(first.max(next)));
    let nearest = |&point: &[f64; 2]| distances(point).fold((f64::INFINITY, f64::INFINITY), second).1;
    let mut nearest: Vec<f64> = points.iter().map(nearest).collect();
    nearest.sort_unstable_by(f64::total_cmp);
    let usual = part(&nearest, 0.5);
    let area = PI * points.last().map_or(f64::NAN, |last| distance(last, &middle)).powi(2);
    if is_flat(values) && usual * (points.len() as f64 / area).sqrt() >= MIN_EVENNESS {
        return true;
    }
    let near = |&point: &[f64; 2]| distances(point).filter(|distance| *distance <= RADIUS * usual).count() - 1;
    usual > 0.0
        && part(&nearest, 0.05) >= MIN_DISTANCE * usual
        && part(&steps, 0.5) <= MAX_STEP * usual
        && points.iter().map(near).sum::<usize>() as f64 >= MIN_NEIGHBOURS * points.len() as f64
}

/// Whether the third column has a range far below that of the others, without outliers.
fn is_flat(values: &[f64]) -> bool {
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let mut column: Vec<f64> = values.chunks_exact(3).map(|row| row[axis]).filter(|x| x.is_finite()).collect();
        column.sort_unstable_by(f64::total_cmp);
        part(&column, 0.75) - part(&column, 0.25)
    });
    z > 0.0 && x.min(y) > FLATNESS * z
}

/// The value below which a part of the sorted values lies; NaN where there is none.
fn part(sorted: &[f64], part: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * part) as usize).copied().unwrap_or(f64::NAN)
}
