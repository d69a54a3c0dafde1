//! End of the cycle as a curve over another parameter.

use serde::{Deserialize, Serialize};

use super::super::{Oscillator, VibrationError, critical_damping};
use super::parameter::CurveParameter;
use asperity_base::monitor::{Cancelled, Monitor};

/// Length of a step, as a fraction of the range, below which a curve ends.
const LEAST_STEP: f64 = 1e-9;

/// Settings of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveSettings {
    /// Least and largest value of the parameter.
    pub range: [f64; 2],
    /// Largest relative difference between ζ_c and its linear prediction from the two previous points. It controls the
    /// density of points on curved parts.
    pub deviation: f64,
    /// Longest step, as a fraction of the range.
    pub longest_step: f64,
    /// Largest number of points of a branch.
    pub most_points: usize,
}

impl CurveSettings {
    /// Creates settings for a range, with a deviation of 0.002 and steps up to a thirtieth of the range.
    pub fn new(range: [f64; 2]) -> Self {
        Self { range, deviation: 2e-3, longest_step: 1.0 / 30.0, most_points: 10_000 }
    }

    pub(super) fn validate(&self) -> Result<(), VibrationError> {
        let [low, high] = self.range;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(VibrationError::Parameter {
                parameter: "range",
                value: high,
                wanted: "finite, and greater than its lower end",
            });
        }
        for (parameter, value) in [("deviation", self.deviation), ("longest_step", self.longest_step)] {
            if !(value > 1e-6 && value <= 1.0) {
                return Err(VibrationError::Parameter { parameter, value, wanted: "above 1e-6 and at most 1" });
            }
        }
        Ok(())
    }

    /// Returns the scale on which steps are equal: logarithmic if the range spans more than a factor of 4.
    pub(super) fn scale(&self) -> Scale {
        let [low, high] = self.range;
        let logarithmic = low > 0.0 && high > 4.0 * low;
        let of = |value: f64| if logarithmic { value.ln() } else { value };
        Scale { logarithmic, low: of(low), width: of(high) - of(low), range: self.range }
    }
}

/// Map of the range of a parameter to 0 … 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    logarithmic: bool,
    low: f64,
    width: f64,
    range: [f64; 2],
}

impl Scale {
    /// Returns the value at a fraction of the range; the ends are exact.
    pub(super) fn value(&self, fraction: f64) -> f64 {
        if fraction == 0.0 || fraction == 1.0 {
            return self.range[fraction as usize];
        }
        let value = self.low + fraction * self.width;
        if self.logarithmic { value.exp() } else { value }
    }

    pub(super) fn fraction(&self, value: f64) -> f64 {
        ((if self.logarithmic { value.ln() } else { value }) - self.low) / self.width
    }
}

/// Point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BranchPoint {
    /// Value of the parameter.
    pub parameter: f64,
    /// ζ_c, or under forcing the damping ratio at which the locked cycle grazes.
    pub critical_damping_ratio: f64,
    /// ζ_H.
    pub hopf_damping_ratio: f64,
    /// Phase ητ mod 2π of the detachment of the grazing orbit, under forcing.
    pub detachment_phase: Option<f64>,
}

/// Reason for the end of a branch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BranchEnd {
    /// The branch reaches the end of the range.
    Range,
    /// The branch turns back: no such orbit exists beyond this value of the parameter.
    Turns,
    /// The computation fails beyond the last point.
    Lost {
        /// Reason.
        reason: String,
    },
    /// The largest number of points is reached.
    Points,
}

/// End of the cycle as a function of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Branch {
    /// The parameter.
    pub parameter: CurveParameter,
    /// Points by rising parameter.
    pub points: Vec<BranchPoint>,
    /// Reason why the branch ends before its first point.
    pub start: BranchEnd,
    /// Reason why the branch ends after its last point.
    pub end: BranchEnd,
}

/// Returns ζ_c and ζ_H over a parameter of the oscillator without forcing.
///
/// ζ_c is a function of the parameter, so the curve is followed upwards from the least value. Each point is computed by
/// [`critical_damping`], with its accuracy; the step size follows the curvature of the curve.
///
/// Fails if there is no ζ_c at the least value, or when cancelled. If there is no ζ_c at a larger value, the branch
/// ends there and reports the reason.
pub fn critical_curve(
    oscillator: &Oscillator,
    parameter: CurveParameter,
    settings: &CurveSettings,
    monitor: &dyn Monitor,
) -> Result<Branch, VibrationError> {
    settings.validate()?;
    let scale = settings.scale();
    let free = oscillator.with_forcing(None)?;
    let point = |fraction: f64| -> Result<BranchPoint, VibrationError> {
        let value = scale.value(fraction);
        let found = critical_damping(&parameter.set(&free, value)?)?;
        Ok(BranchPoint {
            parameter: value,
            critical_damping_ratio: found.critical_damping_ratio,
            hopf_damping_ratio: found.hopf_damping_ratio,
            detachment_phase: None,
        })
    };
    let mut fractions = vec![0.0];
    let mut points = vec![point(0.0)?];
    let mut step = f64::min(0.01, settings.longest_step);
    let mut end = BranchEnd::Points;
    while points.len() < settings.most_points {
        if monitor.cancelled() {
            return Err(Cancelled.into());
        }
        let n = points.len();
        let (last, at) = (points[n - 1].critical_damping_ratio, fractions[n - 1]);
        let fraction = f64::min(at + step, 1.0);
        let next = match point(fraction) {
            Ok(next) => next,
            Err(error) if step < LEAST_STEP => {
                end = BranchEnd::Lost { reason: error.to_string() };
                break;
            }
            Err(_) => {
                step *= 0.5;
                continue;
            }
        };
        let found = next.critical_damping_ratio;
        let slope = if n > 1 { (last - points[n - 2].critical_damping_ratio) / (at - fractions[n - 2]) } else { 0.0 };
        let deviation = if n > 1 { (found - last - slope * (fraction - at)).abs() / found.max(last) } else { 0.0 };
        if deviation > settings.deviation && step > LEAST_STEP {
            step *= 0.5;
            continue;
        }
        fractions.push(fraction);
        points.push(next);
        monitor.progress("critical curve, parts per thousand", (1000.0 * fraction) as usize, 1000);
        if fraction == 1.0 {
            end = BranchEnd::Range;
            break;
        }
        if deviation < 0.25 * settings.deviation {
            step = f64::min(1.5 * step, settings.longest_step);
        }
    }
    Ok(Branch { parameter, points, start: BranchEnd::Range, end })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VelocityLaw;
    use crate::law::Linear;
    use crate::tests::machine;
    use asperity_base::monitor::Silent;

    #[test]
    fn the_curve_over_the_belt_velocity_passes_through_the_published_points_near_the_averaged_one() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.0, 0.1).unwrap();
        let curve =
            critical_curve(&oscillator, CurveParameter::BeltVelocity, &CurveSettings::new([0.003, 0.1]), &Silent)
                .unwrap();
        let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
        assert_eq!((curve.end, first.parameter, last.parameter), (BranchEnd::Range, 0.003, 0.1));
        assert!((first.critical_damping_ratio - 0.204_830_150_584_523_17).abs() < 1e-12);
        assert!((last.critical_damping_ratio - 0.111_508_270_209_214_07).abs() < 1e-12);
        for point in &curve.points {
            let speed = 4.2 * point.parameter;
            let averaged = 0.1 / (speed * point.parameter) * ((1.0 + speed) / (1.0 + 2.0 * speed).sqrt() - 1.0);
            // Error of first order in the friction coefficient.
            assert!((point.critical_damping_ratio / averaged - 1.0).abs() < 0.01, "{point:?}");
            assert!((point.hopf_damping_ratio - 0.21 / (1.0 + speed).powi(2)).abs() < 1e-15);
        }
        // Density of points: chords over two steps deviate from the curve by less than the requested deviation.
        for three in curve.points.windows(3) {
            let [a, b, c] = [0, 1, 2].map(|i| (three[i].parameter.ln(), three[i].critical_damping_ratio));
            let chord = a.1 + (c.1 - a.1) * (b.0 - a.0) / (c.0 - a.0);
            assert!((b.1 / chord - 1.0).abs() < 2e-3);
        }
    }

    #[test]
    fn the_curve_of_the_linear_law_is_half_its_slope_and_missing_parameters_are_errors() {
        let law = VelocityLaw::Linear(Linear { kinetic: 0.4, slope: 0.1 });
        let oscillator = machine(0.4, law, 0.0, 0.1);
        let settings = CurveSettings::new([0.0, 1.0]);
        let curve = critical_curve(&oscillator, CurveParameter::Weakening, &settings, &Silent).unwrap();
        for point in &curve.points {
            assert!((point.critical_damping_ratio - 0.5 * point.parameter).abs() < 1e-12, "{point:?}");
        }
        let friction =
            critical_curve(&oscillator, CurveParameter::StaticFriction, &CurveSettings::new([0.1, 1.0]), &Silent)
                .unwrap();
        assert!(friction.points.iter().all(|p| (p.critical_damping_ratio - 0.05).abs() < 1e-12));
        assert!(critical_curve(&oscillator, CurveParameter::ForcingFrequency, &settings, &Silent).is_err());
        // Friction coefficients above 1000 are out of range.
        let beyond = CurveSettings::new([300.0, 3000.0]);
        let lost = critical_curve(&oscillator, CurveParameter::StaticFriction, &beyond, &Silent).unwrap();
        let last = lost.points[lost.points.len() - 1].parameter;
        assert!(
            matches!(lost.end, BranchEnd::Lost { .. }) && (last / 1000.0 - 1.0).abs() < 1e-8,
            "{last} {:?}",
            lost.end
        );
    }
}
