//! Clipping and simplification of polylines in pixels.

use crate::plot::canvas::{Point, Rect};

/// Returns the parts of a polyline inside a rectangle (Liang & Barsky on each segment).
pub(crate) fn clipped(points: &[Point], rect: Rect) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let (dx, dy) = (x1 - x0, y1 - y0);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (along, room) in
            [(-dx, x0 - rect.left), (dx, rect.right - x0), (-dy, y0 - rect.top), (dy, rect.bottom - y0)]
        {
            if along < 0.0 {
                enter = enter.max(room / along);
            } else if along > 0.0 {
                leave = leave.min(room / along);
            } else if room < 0.0 {
                leave = -1.0;
            }
        }
        if enter > leave {
            continue;
        }
        let at = |t: f64| (x0 + t * dx, y0 + t * dy);
        match pieces.last_mut() {
            Some(piece) if enter == 0.0 && piece.last() == Some(&(x0, y0)) => piece.push(at(leave)),
            _ => pieces.push(vec![at(enter), at(leave)]),
        }
        if leave == 1.0
            && let Some(end) = pieces.last_mut().and_then(|piece| piece.last_mut())
        {
            *end = (x1, y1);
        }
    }
    pieces
}

/// Returns a polyline with fewer corners that stays within `tolerance` of the given one (Douglas & Peucker).
pub(crate) fn simplified(points: &[Point], tolerance: f64) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut spans = vec![(0, points.len() - 1)];
    while let Some((first, last)) = spans.pop() {
        let farthest = (first + 1..last)
            .map(|i| (i, distance(points[i], points[first], points[last])))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, away)) = farthest
            && away > tolerance
        {
            keep[index] = true;
            spans.extend([(first, index), (index, last)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// Returns the distance of a point from a segment.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx * dx + dy * dy;
    let t =
        if length > 0.0 { (((point.0 - from.0) * dx + (point.1 - from.1) * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    (point.0 - from.0 - t * dx).hypot(point.1 - from.1 - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Rect = Rect { left: 0.0, top: 0.0, right: 1.0, bottom: 1.0 };

    #[test]
    fn a_curve_that_leaves_the_chart_is_cut_at_its_edge() {
        let pieces = clipped(&[(-1.0, 0.5), (0.5, 0.5), (0.5, 2.0), (0.75, 2.0), (0.75, 0.25)], UNIT);
        assert_eq!(pieces, [vec![(0.0, 0.5), (0.5, 0.5), (0.5, 1.0)], vec![(0.75, 1.0), (0.75, 0.25)]]);
        assert!(clipped(&[(2.0, 2.0), (3.0, 0.0)], UNIT).is_empty());
    }

    #[test]
    fn simplification_stays_within_its_tolerance_and_keeps_corners() {
        let points: Vec<(f64, f64)> = (0..2000).map(|i| f64::from(i) * 0.01).map(|x| (x, 5.0 * x.sin())).collect();
        let kept = simplified(&points, 0.05);
        assert!(kept.len() < 200, "{} of 2000 points kept", kept.len());
        for &point in &points {
            let away = kept.windows(2).map(|s| distance(point, s[0], s[1])).fold(f64::INFINITY, f64::min);
            assert!(away <= 0.05 + 1e-12);
        }
        let corner = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 3.0)];
        assert_eq!(simplified(&corner, 0.1), [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)]);
    }
}
