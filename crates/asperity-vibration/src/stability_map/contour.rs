//! Lines of equal value over the squares of a quadtree.

use std::collections::BTreeMap;

/// Point (column, row) of the finest grid.
pub(super) type Place = (usize, usize);

/// Square of the quadtree: its lower corner and its side, on the finest grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Square {
    pub(super) corner: Place,
    pub(super) side: usize,
}

impl Square {
    pub(super) fn corners(&self) -> [Place; 4] {
        let (i, j) = self.corner;
        let side = self.side;
        [(i, j), (i + side, j), (i + side, j + side), (i, j + side)]
    }

    pub(super) fn quarters(&self) -> [Self; 4] {
        let (i, j) = self.corner;
        let side = self.side / 2;
        [(i, j), (i + side, j), (i, j + side), (i + side, j + side)].map(|corner| Self { corner, side })
    }
}

/// Vertex of the triangles: a point of a grid with half the finest spacing, so that centres of squares are grid points.
type Vertex = (usize, usize);

/// Returns lines on which `value` is zero, in the coordinates of `place`. Squares with an unknown value at a vertex
/// have no lines.
///
/// Each square is a fan of triangles about its centre, whose value is the mean of the values at the corners. All points
/// on its sides are vertices, so lines continue without gaps between squares of different sizes. The value is linear in
/// each triangle.
pub(super) fn contour<P>(
    squares: &[Square],
    points: &BTreeMap<Place, P>,
    value: &dyn Fn(&P) -> Option<f64>,
    place: &dyn Fn(Place) -> [f64; 2],
) -> Vec<Vec<[f64; 2]>> {
    let mut segments: Vec<[Crossing; 2]> = Vec::new();
    for square in squares {
        let sides = boundary(square, points);
        let known: Option<Vec<Corner>> = sides
            .iter()
            .map(|&(i, j)| {
                let value = value(&points[&(i, j)])?;
                Some(Corner { vertex: (2 * i, 2 * j), value, place: place((i, j)) })
            })
            .collect();
        let Some(known) = known.filter(|corners| corners.iter().all(|c| c.value.is_finite())) else { continue };
        let [low, _, high, _] = square.corners().map(place);
        let corners = square.corners();
        let mean = corners.iter().filter_map(|c| value(&points[c])).sum::<f64>() / 4.0;
        let middle = Corner {
            vertex: (2 * square.corner.0 + square.side, 2 * square.corner.1 + square.side),
            value: mean,
            place: [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])],
        };
        for k in 0..known.len() {
            let triangle = [middle, known[k], known[(k + 1) % known.len()]];
            let crossings: Vec<Crossing> =
                (0..3).filter_map(|e| Crossing::between(&triangle[e], &triangle[(e + 1) % 3])).collect();
            if let [a, b] = crossings[..] {
                segments.push([a, b]);
            }
        }
    }
    joined(&segments)
}

/// Returns lines on which a function is zero; `values[j][i]` is its value at `x[i]`, `y[j]`. Cells with an undefined value at a corner
/// have no lines.
pub fn grid_contour(x: &[f64], y: &[f64], values: &[Vec<f64>]) -> Vec<Vec<[f64; 2]>> {
    let places = |nx: usize, ny: usize| (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j)));
    let points: BTreeMap<Place, f64> = places(x.len(), y.len()).map(|(i, j)| ((i, j), values[j][i])).collect();
    let cells = places(x.len().saturating_sub(1), y.len().saturating_sub(1));
    let squares: Vec<Square> = cells.map(|corner| Square { corner, side: 1 }).collect();
    contour(&squares, &points, &|value| Some(*value), &|(i, j)| [x[i], y[j]])
}

/// Returns all points on the sides of a square, in order around it.
pub(super) fn boundary<P>(square: &Square, points: &BTreeMap<Place, P>) -> Vec<Place> {
    let ((i, j), side) = (square.corner, square.side);
    let around = (0..side)
        .map(|k| (i + k, j))
        .chain((0..side).map(|k| (i + side, j + k)))
        .chain((0..side).map(|k| (i + side - k, j + side)))
        .chain((0..side).map(|k| (i, j + side - k)));
    around.filter(|place| points.contains_key(place)).collect()
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    vertex: Vertex,
    value: f64,
    place: [f64; 2],
}

/// Point of an edge at which the value is zero.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    edge: (Vertex, Vertex),
    place: [f64; 2],
}

impl Crossing {
    fn between(a: &Corner, b: &Corner) -> Option<Self> {
        if (a.value < 0.0) == (b.value < 0.0) {
            return None;
        }
        // Sorted, so that the arithmetic is the same from both sides.
        let (a, b) = if a.vertex <= b.vertex { (a, b) } else { (b, a) };
        let fraction = a.value / (a.value - b.value);
        let at = |k: usize| a.place[k] + fraction * (b.place[k] - a.place[k]);
        Some(Self { edge: (a.vertex, b.vertex), place: [at(0), at(1)] })
    }
}

/// Joins segments to lines at shared edges.
fn joined(segments: &[[Crossing; 2]]) -> Vec<Vec<[f64; 2]>> {
    let mut at: BTreeMap<(Vertex, Vertex), Vec<usize>> = BTreeMap::new();
    for (index, segment) in segments.iter().enumerate() {
        for end in segment {
            at.entry(end.edge).or_default().push(index);
        }
    }
    let mut used = vec![false; segments.len()];
    let follow = |start: usize, from: Crossing, used: &mut Vec<bool>| {
        let mut line = vec![from.place];
        let (mut index, mut end) = (start, from);
        loop {
            used[index] = true;
            let [a, b] = segments[index];
            end = if a.edge == end.edge { b } else { a };
            line.push(end.place);
            let Some(&next) = at[&end.edge].iter().find(|&&i| !used[i]) else { return line };
            index = next;
        }
    };
    let mut lines = Vec::new();
    // Open lines first, from their ends, then closed lines.
    let open = (0..segments.len()).flat_map(|i| [(i, 0), (i, 1)]).filter(|&(i, k)| at[&segments[i][k].edge].len() == 1);
    for (index, end) in open {
        if !used[index] {
            lines.push(follow(index, segments[index][end], &mut used));
        }
    }
    for index in 0..segments.len() {
        if !used[index] {
            lines.push(follow(index, segments[index][0], &mut used));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contour_of_a_plane_is_its_line_and_undefined_values_interrupt_it() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [0.0, 10.0, 30.0]);
        let plane = |x: f64, y: f64| x + 0.1 * y - 2.25;
        let mut values: Vec<Vec<f64>> = y.iter().map(|y| x.iter().map(|x| plane(*x, *y)).collect()).collect();
        let lines = grid_contour(&x, &y, &values);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|[x, y]| plane(*x, *y).abs() < 1e-12), "{lines:?}");
        let mut ends = [lines[0][0], lines[0][lines[0].len() - 1]];
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!((ends[0][1] - 22.5).abs() < 1e-12 && (ends[1][0] - 2.25).abs() < 1e-12, "{ends:?}");
        // The line crosses the cell of this corner.
        values[0][3] = f64::NAN;
        assert!(grid_contour(&x, &y, &values).concat().iter().all(|[x, _]| *x <= 2.0));
    }
}
