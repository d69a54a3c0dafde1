//! Load curve: mean pressure against the depth of the plane.

use std::convert::Infallible;

use thiserror::Error;

use crate::strip::SolvedStrips;
use asperity_base::numeric::bisect;
use asperity_base::stats::{Interval, student_95};

/// Fraction of a segment that is negligible in double precision.
const NEGLIGIBLE: f64 = 1e-18;

/// Reason why there is no load curve, or no point on it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LoadCurveError {
    /// Too few levels carry load.
    #[error("{loaded} levels carry load; a load curve needs at least two")]
    TooFew {
        /// Levels with load.
        loaded: usize,
    },
    /// A deeper plane does not carry more.
    #[error(
        "the mean pressure does not grow from {shallow_pa:e} Pa at {shallow_m:e} m to {deep_pa:e} Pa at {deep_m:e} m; levels \
         under different controls or of different strips do not lie on one curve"
    )]
    NotMonotone {
        /// Penetration of the shallower level in metre.
        shallow_m: f64,
        /// Its mean pressure in pascal.
        shallow_pa: f64,
        /// Penetration of the deeper level in metre.
        deep_m: f64,
        /// Its mean pressure in pascal.
        deep_pa: f64,
    },
    /// The value lies outside of the curve.
    #[error(
        "{value:e} {unit} lies outside of the solved levels, {low:e} {unit} to {high:e} {unit}; solve one more level"
    )]
    Outside {
        /// Requested value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Least value of the levels.
        low: f64,
        /// Largest value of the levels.
        high: f64,
    },
}

/// A solved level as a point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadPoint {
    /// Mean depth of the plane below the highest point of the strips, in metre.
    pub penetration_m: f64,
    /// Mean pressure over all strips in pascal.
    pub mean_pressure_pa: f64,
    /// 95 % interval of the mean pressure by Student's distribution over strips, symmetric in the logarithm. If the
    /// pressure is prescribed, both ends equal it.
    pub interval: Interval,
    /// Contact area over nominal area, corrected at the edges of contact.
    pub contact_fraction: f64,
}

impl LoadPoint {
    /// Computes the point of a level. For a single strip the interval is unknown, from 0 to infinity.
    pub fn from_strips(strips: &SolvedStrips) -> Self {
        let (pressures, mean) = (&strips.strip_pressures_pa, strips.mean_pressure_pa);
        let count = pressures.len() as f64;
        let variance = pressures.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let relative = (variance / count).sqrt() / mean;
        // Rounding differences of equal pressures do not count as variability.
        let spread = match relative {
            r if r < 1e-12 => 0.0,
            r if r.is_finite() => student_95(pressures.len()) * r,
            _ => f64::INFINITY,
        };
        Self {
            penetration_m: strips.penetration_m,
            mean_pressure_pa: mean,
            interval: Interval { low: mean * (-spread).exp(), high: mean * spread.exp() },
            contact_fraction: strips.contact_fraction,
        }
    }
}

/// Monotone curve through solved levels: a piecewise cubic in ln p̄ over the penetration, in both directions.
///
/// Slopes at the levels are harmonic means of the slopes of the neighbouring chords, which keeps the cubic monotone.
/// Two levels give a straight line in ln p̄. The curve does not extrapolate. Levels of the same strips under a fixed
/// plane, by percentile or by height, always lie on one curve. With other levels mixed in, the curve is valid as far as
/// the strips are alike.
///
/// # References
/// F. N. Fritsch and J. Butland, *SIAM J. Sci. Stat. Comput.* **5** (1984) 300, <https://doi.org/10.1137/0905021>.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCurve {
    points: Vec<LoadPoint>,
    /// Slopes d ln p̄/dd at the points, per metre.
    slopes_per_m: Vec<f64>,
}

impl LoadCurve {
    /// Creates the curve through points in any order. Points without load are left out.
    ///
    /// # Errors
    /// Fewer than two points carry load, or a deeper plane does not carry more.
    pub fn from_points(mut points: Vec<LoadPoint>) -> Result<Self, LoadCurveError> {
        points.retain(|point| point.mean_pressure_pa > 0.0);
        points.sort_by(|a, b| a.penetration_m.total_cmp(&b.penetration_m));
        if points.len() < 2 {
            return Err(LoadCurveError::TooFew { loaded: points.len() });
        }
        let grows =
            |a: &LoadPoint, b: &LoadPoint| a.penetration_m < b.penetration_m && a.mean_pressure_pa < b.mean_pressure_pa;
        if let Some(pair) = points.windows(2).find(|pair| !grows(&pair[0], &pair[1])) {
            return Err(LoadCurveError::NotMonotone {
                shallow_m: pair[0].penetration_m,
                shallow_pa: pair[0].mean_pressure_pa,
                deep_m: pair[1].penetration_m,
                deep_pa: pair[1].mean_pressure_pa,
            });
        }
        let chords: Vec<f64> = points
            .windows(2)
            .map(|pair| (pair[1].mean_pressure_pa / pair[0].mean_pressure_pa).ln() / width_m(&pair[0], &pair[1]))
            .collect();
        let slopes_per_m = (0..points.len())
            .map(|index| match (index.checked_sub(1).map(|before| chords[before]), chords.get(index)) {
                (Some(before), Some(after)) => {
                    let (left_m, right_m) =
                        (width_m(&points[index - 1], &points[index]), width_m(&points[index], &points[index + 1]));
                    // Weighted harmonic mean of the slopes of both chords.
                    let (w_before, w_after) = (2.0 * right_m + left_m, right_m + 2.0 * left_m);
                    (w_before + w_after) / (w_before / before + w_after / after)
                }
                (Some(chord), None) => chord,
                (None, chord) => chord.copied().unwrap_or(0.0),
            })
            .collect();
        Ok(Self { points, slopes_per_m })
    }

    /// Returns the points, from the shallowest.
    pub fn points(&self) -> &[LoadPoint] {
        &self.points
    }

    /// Returns the mean pressure in pascal at a penetration in metre.
    ///
    /// # Errors
    /// The penetration lies outside of the levels.
    pub fn mean_pressure_pa(&self, penetration_m: f64) -> Result<f64, LoadCurveError> {
        let segment = self.segment(penetration_m, "m", |point| point.penetration_m)?;
        let (from, to) = (&self.points[segment], &self.points[segment + 1]);
        Ok(self.log_pressure(segment, (penetration_m - from.penetration_m) / width_m(from, to)).exp())
    }

    /// Returns the penetration in metre at a mean pressure in pascal.
    ///
    /// # Errors
    /// The pressure lies outside of the levels.
    pub fn penetration_m(&self, mean_pressure_pa: f64) -> Result<f64, LoadCurveError> {
        let segment = self.segment(mean_pressure_pa, "Pa", |point| point.mean_pressure_pa)?;
        let wanted = mean_pressure_pa.ln();
        let is_below = |fraction: f64| Ok::<_, Infallible>(self.log_pressure(segment, fraction) < wanted);
        let Ok([low, high]) = bisect(0.0, 1.0, NEGLIGIBLE, is_below);
        let (from, to) = (&self.points[segment], &self.points[segment + 1]);
        Ok(from.penetration_m + 0.5 * (low + high) * width_m(from, to))
    }

    /// Returns the segment that contains a value of a quantity that grows along the curve.
    fn segment(
        &self,
        value: f64,
        unit: &'static str,
        quantity: impl Fn(&LoadPoint) -> f64,
    ) -> Result<usize, LoadCurveError> {
        let last = self.points.len() - 1;
        let (low, high) = (quantity(&self.points[0]), quantity(&self.points[last]));
        if !(low..=high).contains(&value) {
            return Err(LoadCurveError::Outside { value, unit, low, high });
        }
        Ok(self.points.partition_point(|point| quantity(point) <= value).saturating_sub(1).min(last - 1))
    }

    /// Returns ln p̄ at a fraction of a segment, by the cubic through its ends and their slopes.
    fn log_pressure(&self, segment: usize, fraction: f64) -> f64 {
        let (from, to) = (&self.points[segment], &self.points[segment + 1]);
        let (t, rest, width) = (fraction, 1.0 - fraction, width_m(from, to));
        let (low, high) = (from.mean_pressure_pa.ln(), to.mean_pressure_pa.ln());
        rest * rest * (1.0 + 2.0 * t) * low
            + t * t * (3.0 - 2.0 * t) * high
            + t * rest * width * (rest * self.slopes_per_m[segment] - t * self.slopes_per_m[segment + 1])
    }
}

fn width_m(from: &LoadPoint, to: &LoadPoint) -> f64 {
    to.penetration_m - from.penetration_m
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(of: impl Fn(f64) -> f64, depths_m: &[f64]) -> Result<LoadCurve, LoadCurveError> {
        let point = |d: &f64| {
            let mean_pressure_pa = of(*d);
            let interval = Interval { low: 0.9 * mean_pressure_pa, high: mean_pressure_pa / 0.9 };
            LoadPoint { penetration_m: *d, mean_pressure_pa, interval, contact_fraction: 0.1 }
        };
        LoadCurve::from_points(depths_m.iter().map(point).collect())
    }

    #[test]
    fn an_exponential_curve_is_reproduced_in_both_directions() {
        let law = |d: f64| 3e6 * (d / 0.2e-6).exp();
        let curve = curve(law, &[1e-6, 0.2e-6, 0.5e-6, 0.35e-6]).unwrap();
        for d in [0.2e-6, 0.21e-6, 0.35e-6, 0.7e-6, 1e-6] {
            assert!((curve.mean_pressure_pa(d).unwrap() / law(d) - 1.0).abs() < 1e-12);
            assert!((curve.penetration_m(law(d)).unwrap() / d - 1.0).abs() < 1e-12);
        }
        for (d, found) in [(0.1e-6, curve.mean_pressure_pa(0.1e-6)), (9e9, curve.penetration_m(9e9))] {
            assert!(matches!(found, Err(LoadCurveError::Outside { value, .. }) if value == d));
        }
        assert!(curve.mean_pressure_pa(f64::NAN).is_err());
    }

    #[test]
    fn a_power_law_is_reproduced_to_second_order_and_stays_monotone() {
        // Hertz: F ∝ d^{3/2}.
        let law = |d: f64| d.powf(1.5);
        let mut errors = Vec::new();
        for count in [6, 11, 21] {
            let depths: Vec<f64> = (0..count).map(|k| 1.0 + k as f64 / (count - 1) as f64).collect();
            let curve = curve(law, &depths).unwrap();
            let fine: Vec<f64> = (0..=400).map(|k| 1.0 + k as f64 / 400.0).collect();
            let found: Vec<f64> = fine.iter().map(|d| curve.mean_pressure_pa(*d).unwrap()).collect();
            assert!(found.windows(2).all(|pair| pair[0] < pair[1]));
            errors.push(found.iter().zip(&fine).map(|(p, d)| (p / law(*d) - 1.0).abs()).fold(0.0, f64::max));
        }
        // The error is largest at the end, whose slope is the slope of the chord: (4/27)h·½h|f″| with f = 1.5 ln d and
        // h = 0.2.
        assert!(errors[0] < 4.5e-3 && errors[1] < errors[0] / 3.5 && errors[2] < errors[1] / 3.5, "{errors:?}");
    }

    #[test]
    fn levels_without_a_monotone_curve_are_refused() {
        assert_eq!(curve(|_| 0.0, &[1.0, 2.0]), Err(LoadCurveError::TooFew { loaded: 0 }));
        assert!(matches!(curve(|d| 3.0 - d, &[1.0, 2.0]), Err(LoadCurveError::NotMonotone { .. })));
        assert!(matches!(curve(|d| d, &[1.0, 1.0]), Err(LoadCurveError::NotMonotone { .. })));
    }
}
