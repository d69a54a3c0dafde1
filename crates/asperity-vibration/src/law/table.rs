//! Friction law given by points.

use std::sync::Arc;

use asperity_base::statement::{Statement, StatementError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::curve::{CurveShape, Recurrence};
use super::{Curve, Law, VelocityLaw, VelocityLawKind};
use crate::polynomial::cross;
use crate::{VibrationError, positive};

/// Kinetic friction law through points (|v|, μ): monotone cubics between them, constant beyond the last.
///
/// The slopes at the points are weighted harmonic means of the neighbouring secants, and zero where these differ in
/// sign, so the law rises and falls only where its points do. The law is continuous. Its slope is continuous except at
/// the last point, unless the last two coefficients are equal. As text the law is a list of pairs, `points = [[0.0,
/// 0.3], [0.1, 0.25]]`.
///
/// # References
/// Fritsch & Carlson, *SIAM Journal on Numerical Analysis* **17** (1980) 238, <https://doi.org/10.1137/0717021>, with the slopes of
/// Fritsch & Butland, *SIAM J. Sci. Stat. Comput.* **5** (1984) 300, <https://doi.org/10.1137/0905021>.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Points", into = "Points")]
pub struct FrictionTable {
    /// One piece per point; the last one has no end.
    pieces: Arc<[Piece]>,
}

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Points {
    /// Points (|v|, μ) by rising velocity, the first at 0.
    points: Vec<[f64; 2]>,
}

/// Cubic in the speed beyond `from`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    from: f64,
    coefficients: [f64; 4],
    /// Least coefficient at speeds up to `from`.
    least: f64,
}

impl FrictionTable {
    /// Creates a law from at least two points, with speeds rising from 0 and positive coefficients.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, VibrationError> {
        let count = points.len();
        let first = points.first().map_or(f64::NAN, |point| point[0]);
        let refused = |parameter, value, wanted| Err(VibrationError::Parameter { parameter, value, wanted });
        if count < 2 {
            return refused("number of points of the friction law", count as f64, "at least 2");
        }
        if first != 0.0 {
            return refused("first speed of the friction law", first, "zero");
        }
        for point in points {
            positive("coefficient of the friction law", point[1])?;
        }
        if let Some(pair) = points.windows(2).find(|pair| !(pair[1][0] > pair[0][0] && pair[1][0].is_finite())) {
            return refused("speed of the friction law", pair[1][0], "finite and larger than the one before");
        }
        let slopes = slopes(points);
        let mut least = f64::INFINITY;
        let pieces = (0..count)
            .map(|i| {
                let [from, y] = points[i];
                least = least.min(y);
                let coefficients = if i + 1 < count {
                    let (width, secant) = secant(points, i);
                    let [a, b] = [slopes[i], slopes[i + 1]];
                    [y, a, (3.0 * secant - 2.0 * a - b) / width, (a + b - 2.0 * secant) / (width * width)]
                } else {
                    [y, 0.0, 0.0, 0.0]
                };
                Piece { from, coefficients, least }
            })
            .collect();
        Ok(Self { pieces })
    }

    /// Returns the points (|v|, μ) of the law.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        self.pieces.iter().map(|piece| [piece.from, piece.coefficients[0]])
    }

    fn piece(&self, speed: f64) -> &Piece {
        &self.pieces[self.pieces.partition_point(|piece| piece.from <= speed).saturating_sub(1)]
    }
}

const POINTS: &str = "vibration.friction_table";

impl FrictionTable {
    pub(super) const STATEMENT: &Statement<VelocityLaw> = &Statement {
        inputs: &[POINTS],
        law: |stated| {
            let points = stated.points(POINTS).ok_or_else(|| VelocityLawKind::Table.requires(POINTS))?;
            let table = Self::new(&points);
            Ok(table.map_err(|error| StatementError { input: POINTS, reason: error.to_string() })?.into())
        },
    };
}

impl Law for FrictionTable {
    fn coefficient(&self, speed: f64) -> f64 {
        let piece = self.piece(speed);
        let [a, b, c, d] = piece.coefficients;
        let x = speed - piece.from;
        a + x * (b + x * (c + x * d))
    }

    fn weakening(&self, speed: f64) -> f64 {
        let piece = self.piece(speed);
        let [_, b, c, d] = piece.coefficients;
        let x = speed - piece.from;
        -(b + x * (2.0 * c + x * 3.0 * d))
    }

    /// Returns the least coefficient at speeds up to this one; each piece is monotone.
    fn least_coefficient(&self, speed: f64) -> f64 {
        self.piece(speed).least.min(self.coefficient(speed))
    }

    fn kinetic(&self) -> f64 {
        self.pieces[0].coefficients[0]
    }

    /// Returns the largest |dμ/d|v||: slopes of a monotone cubic are at most three times its secant.
    fn steepest(&self) -> f64 {
        let points: Vec<_> = self.points().collect();
        (0..points.len() - 1).map(|i| 3.0 * secant(&points, i).1.abs()).fold(0.0, f64::max)
    }

    fn rescaled(&self, factor: f64) -> Self {
        let pieces = self.pieces.iter().map(|piece| {
            let [y, a, b, c] = piece.coefficients;
            let coefficients = [y, a * factor, b * factor * factor, c * factor * factor * factor];
            Piece { from: piece.from / factor, coefficients, least: piece.least }
        });
        Self { pieces: pieces.collect() }
    }

    fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        let points: Vec<[f64; 2]> = self.points().map(|[v, mu]| [v, map(mu)]).collect();
        Self::new(&points)
    }

    fn curve(&self, velocity: f64) -> Curve {
        Curve::Cubic(Cubic::new(self, velocity, 0))
    }

    fn table(&self) -> Option<&FrictionTable> {
        Some(self)
    }

    /// [`crate::mode_coupling::Model`] refuses tables.
    fn term(&self, _: &[f64], _: &[f64], _: usize) -> f64 {
        f64::NAN
    }

    fn describe(&self) -> String {
        "a tabulated law".into()
    }

    #[cfg(test)]
    fn examples() -> Vec<Self> {
        [
            &[[0.0, 0.4], [0.1, 0.3], [0.5, 0.2]][..],
            &[[0.0, 0.3], [0.05, 0.27], [0.2, 0.2], [0.3, 0.22], [0.5, 0.22], [0.9, 0.25]],
            &[[0.0, 0.3], [1.0, 0.3]],
        ]
        .map(|points| Self::new(points).unwrap())
        .to_vec()
    }
}

/// r is a cubic between two points of a table.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic {
    index: usize,
    /// Range `from` … `to` of W in which the cubic is valid.
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Coefficients in powers of W − from.
    coefficients: [f64; 4],
}

impl Cubic {
    /// Creates (μ_k − μ(VW))/V in an interval of a table.
    fn new(table: &FrictionTable, v: f64, index: usize) -> Self {
        let piece = &table.pieces[index];
        let to = table.pieces.get(index + 1).map_or(f64::INFINITY, |next| next.from / v);
        let [y, b, c, d] = piece.coefficients;
        Self { index, from: piece.from / v, to, coefficients: [(table.kinetic() - y) / v, -b, -c * v, -d * v * v] }
    }

    /// Returns the cubic in the interval in which W lies.
    pub(crate) fn at(&self, table: &FrictionTable, v: f64, w: f64) -> Self {
        let at_least = |index: usize| table.pieces[index].from / v <= w;
        let mut index = self.index;
        while index > 0 && !at_least(index) {
            index -= 1;
        }
        while index + 1 < table.pieces.len() && at_least(index + 1) {
            index += 1;
        }
        Self::new(table, v, index)
    }

    /// Returns the cubic in the interval before; none in the first.
    pub(crate) fn before(&self, table: &FrictionTable, v: f64) -> Option<Self> {
        Some(Self::new(table, v, self.index.checked_sub(1)?))
    }

    /// Returns r, r′, r″/2, r‴/6.
    #[inline(always)]
    fn derivatives(&self, w: f64) -> [f64; 4] {
        let [a, b, c, d] = self.coefficients;
        let x = w - self.from;
        [a + x * (b + x * (c + x * d)), b + x * (2.0 * c + x * 3.0 * d), c + 3.0 * d * x, d]
    }
}

impl CurveShape for Cubic {
    type Terms<const N: usize> = CubicTerms<N>;

    #[inline(always)]
    fn value(&self, w: f64) -> f64 {
        self.derivatives(w)[0]
    }

    fn slope(&self, w: f64) -> f64 {
        self.derivatives(w)[1]
    }

    fn argument(&self, w: f64) -> f64 {
        w / self.to
    }

    #[inline(always)]
    fn terms<const N: usize>(&self, w0: f64) -> CubicTerms<N> {
        CubicTerms { derivatives: self.derivatives(w0), square: [0.0; N] }
    }
}

/// Coefficients of a cubic: r = r_0 + r′u + (r″/2)u² + (r‴/6)u³ with u = W − W_0.
pub(crate) struct CubicTerms<const N: usize> {
    derivatives: [f64; 4],
    /// u².
    square: [f64; N],
}

impl<const N: usize> Recurrence<N> for CubicTerms<N> {
    #[inline(always)]
    fn slope(&self) -> f64 {
        self.derivatives[1]
    }

    #[inline(always)]
    fn rest(&mut self, w: &[f64; N], n: usize) -> f64 {
        self.square[n] = cross(w, w, n);
        self.derivatives[2] * self.square[n] + self.derivatives[3] * cross(w, &self.square, n)
    }
}

/// Returns the width and slope of the interval after point i.
fn secant(points: &[[f64; 2]], i: usize) -> (f64, f64) {
    let width = points[i + 1][0] - points[i][0];
    (width, (points[i + 1][1] - points[i][1]) / width)
}

/// Returns the slopes at the points.
fn slopes(points: &[[f64; 2]]) -> Vec<f64> {
    let last = points.len() - 1;
    if last == 1 {
        return vec![secant(points, 0).1; 2];
    }
    (0..=last)
        .map(|i| {
            if i == 0 {
                return end_slope(secant(points, 0), secant(points, 1));
            }
            if i == last {
                return end_slope(secant(points, last - 1), secant(points, last - 2));
            }
            let ((before, p), (after, q)) = (secant(points, i - 1), secant(points, i));
            if p * q <= 0.0 {
                return 0.0;
            }
            let (u, v) = (2.0 * after + before, after + 2.0 * before);
            (u + v) / (u / p + v / q)
        })
        .collect()
}

/// Returns the slope at an end: the slope of the parabola through three points, limited so that the cubic stays
/// monotone.
fn end_slope((width, secant): (f64, f64), (next_width, next): (f64, f64)) -> f64 {
    let slope = ((2.0 * width + next_width) * secant - width * next) / (width + next_width);
    if slope * secant <= 0.0 {
        0.0
    } else if secant * next <= 0.0 && slope.abs() > 3.0 * secant.abs() {
        3.0 * secant
    } else {
        slope
    }
}

impl TryFrom<Points> for FrictionTable {
    type Error = VibrationError;

    fn try_from(points: Points) -> Result<Self, VibrationError> {
        Self::new(&points.points)
    }
}

impl From<FrictionTable> for Points {
    fn from(table: FrictionTable) -> Self {
        Self { points: table.points().collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 2]; 6] = [[0.0, 0.3], [0.05, 0.27], [0.2, 0.2], [0.3, 0.22], [0.5, 0.22], [0.9, 0.25]];

    #[test]
    fn the_cubics_match_an_independent_code() {
        // Reference: scipy 1.17.1, scipy.interpolate.PchipInterpolator and its derivative.
        let table = FrictionTable::new(&POINTS).unwrap();
        for (speed, wanted) in [
            (0.02, 0.287_453_617_021_276_6),
            (0.1, 0.239_936_958_234_830_6),
            (0.16, 0.208_084_475_965_327_03),
            (0.25, 0.21),
            (0.4, 0.22),
            (0.6, 0.222_343_75),
            (0.85, 0.243_925_781_25),
        ] {
            assert!((table.coefficient(speed) - wanted).abs() < 1e-15, "{speed}: {}", table.coefficient(speed));
        }
        for (speed, wanted) in [
            (0.0, 0.633_333_333_333_333),
            (0.05, 0.536_170_212_765_957),
            (0.1, 0.622_222_222_222_222),
            (0.25, -0.3),
            (0.6, -0.045_312_5),
            (0.9 - 1e-12, -0.125),
        ] {
            assert!((table.weakening(speed) - wanted).abs() < 1e-11, "{speed}: {}", table.weakening(speed));
        }
        assert_eq!((table.coefficient(0.9), table.coefficient(7.0), table.weakening(7.0)), (0.25, 0.25, 0.0));
    }

    #[test]
    fn between_points_the_law_is_monotone_and_its_bounds_hold() {
        let rng = &mut asperity_base::random::stream(3, "test", 0);
        for _ in 0..50 {
            let g = asperity_base::random::standard_normal(rng, 16);
            let mut speed = 0.0;
            let points: Vec<_> = (0..8)
                .map(|i| {
                    let from = speed;
                    speed += g[2 * i].exp();
                    [from, (2.0 * g[2 * i + 1]).exp()]
                })
                .collect();
            let table = FrictionTable::new(&points).unwrap();
            let mut least = f64::INFINITY;
            for pair in points.windows(2) {
                let rises = pair[1][1] - pair[0][1];
                for k in 0..=100 {
                    let speed = pair[0][0] + f64::from(k) / 100.0 * (pair[1][0] - pair[0][0]);
                    let slope = -table.weakening(speed);
                    assert!(k == 100 || slope * rises >= -1e-9 * rises.abs());
                    assert!(slope.abs() <= table.steepest() * (1.0 + 1e-12));
                    least = least.min(table.coefficient(speed));
                    assert!((table.least_coefficient(speed) - least).abs() < 1e-12 * least);
                }
            }
        }
    }

    #[test]
    fn invalid_points_are_refused() {
        for points in [
            &[][..],
            &[[0.0, 0.3]],
            &[[0.1, 0.3], [0.2, 0.3]],
            &[[0.0, 0.3], [0.0, 0.2]],
            &[[0.0, 0.3], [f64::NAN, 0.2]],
            &[[0.0, 0.3], [f64::INFINITY, 0.2]],
            &[[0.0, 0.3], [1.0, 0.0]],
        ] {
            assert!(FrictionTable::new(points).is_err(), "{points:?}");
        }
    }
}
