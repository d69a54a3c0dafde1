//! End of the locked cycle over a parameter of the forced oscillator.

use std::f64::consts::TAU;

use super::super::locked::grazing_lock;
use super::super::scaled_forcing::ScaledForcing;
use super::super::weakening::Weakening;
use super::super::{Oscillator, VibrationError, critical_damping};
use super::boundary::{Branch, BranchEnd, BranchPoint, CurveSettings, Scale};
use super::grazing::graze;
use super::parameter::CurveParameter;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::numeric::bisect;

/// Largest number of Newton steps of the corrector.
const MAX_CORRECTIONS: usize = 12;
/// Correction below which a point is accepted, in fractions of the range, units of the first damping ratio, and radian.
const CORRECTED: f64 = 1e-13;
/// Fraction of the range over which the derivative with respect to the parameter is differenced.
const DIFFERENCE: f64 = 1e-6;
const LEAST_STEP: f64 = 1e-8;
/// Least cosine between neighbouring directions.
const STRAIGHT: f64 = 0.995;

/// Point (fraction of the range, damping ratio in units of the first one, detachment phase).
type Point = [f64; 3];

/// Returns the damping ratio at which the locked cycle grazes, [`super::super::locked_boundary`], over a parameter.
///
/// The unknowns are the damping ratio and the phase of the detachment. The equations require that the slip orbit
/// touches the belt velocity, and that it returns, after the stick that a jump of the law causes, in one forcing
/// period. The curve is followed by pseudo-arclength continuation, from the oscillator's own value of the parameter in
/// both directions, with the derivatives of the orbit. It ends at the end of the range or where it turns back; beyond
/// that point the locked cycle does not end by grazing. The first point is the boundary; the curve then stays on the
/// same branch, even if another root becomes larger.
///
/// Fails without forcing, if there is no boundary at the oscillator's own value or this value is outside the range, or
/// when cancelled.
pub fn locked_curve(
    oscillator: &Oscillator,
    parameter: CurveParameter,
    settings: &CurveSettings,
    monitor: &dyn Monitor,
) -> Result<Branch, VibrationError> {
    settings.validate()?;
    if parameter == CurveParameter::DampingRatio {
        return Err(VibrationError::NotFound { what: "curve", reason: "the damping ratio is the result of the curve" });
    }
    let scale = settings.scale();
    let value = parameter.value(oscillator).unwrap_or(f64::NAN);
    let fraction = scale.fraction(value);
    if !(0.0..=1.0).contains(&fraction) {
        return Err(VibrationError::Parameter { parameter: "start of the curve", value, wanted: "in the range" });
    }
    let (tau, damping) = grazing_lock(oscillator)?;
    let frequency = oscillator.forcing().map_or(0.0, |f| f.frequency);
    let lock = Lock { oscillator: oscillator.clone(), parameter, scale, unit: damping };
    let first = [fraction, 1.0, frequency * tau];
    let (mut back, start) = lock.follow(first, -1.0, settings, monitor)?;
    let (forth, end) = lock.follow(first, 1.0, settings, monitor)?;
    back.reverse();
    let all = back.into_iter().chain([first]).chain(forth);
    let points = all.map(|point| lock.report(point)).collect::<Result<_, _>>()?;
    Ok(Branch { parameter, points, start, end })
}

struct Lock {
    oscillator: Oscillator,
    parameter: CurveParameter,
    scale: Scale,
    unit: f64,
}

impl Lock {
    fn at(&self, [fraction, damping, _]: Point) -> Result<Oscillator, VibrationError> {
        let oscillator = self.parameter.set(&self.oscillator, self.scale.value(fraction))?;
        oscillator.with_damping(damping * self.unit)
    }

    fn report(&self, point: Point) -> Result<BranchPoint, VibrationError> {
        let oscillator = self.at(point)?;
        Ok(BranchPoint {
            parameter: self.scale.value(point[0]),
            critical_damping_ratio: oscillator.damping_ratio(),
            hopf_damping_ratio: critical_damping(&oscillator)?.hopf_damping_ratio,
            detachment_phase: Some(point[2].rem_euclid(TAU)),
        })
    }

    /// Returns (least W, lateness of the return) of the orbit, and their derivatives with respect to the damping and
    /// the phase of the point.
    fn residual(&self, point: Point) -> Result<[(f64, [f64; 2]); 2], VibrationError> {
        let what = "grazing orbit";
        let oscillator = self.at(point)?;
        let (scaled, jump) = (ScaledForcing::new(&oscillator), Weakening::new(&oscillator).jump);
        if scaled.amplitude == 0.0 {
            return Err(VibrationError::NotFound { what, reason: "the forcing has vanished" });
        }
        let tau = point[2] / scaled.frequency;
        if 1.0 + scaled.rate(tau) <= 0.0 {
            return Err(VibrationError::NotFound { what, reason: "the force holds the mass at that phase" });
        }
        let Some(found) = graze(&oscillator, tau)? else {
            return Err(VibrationError::NotFound {
                what,
                reason: "the slip orbit does not turn back to the belt velocity",
            });
        };
        let touch = found.minimum.time;
        let Some(stick) = scaled.release(1.0, 1.0, -jump, tau + touch, f64::INFINITY) else {
            return Err(VibrationError::NotFound { what, reason: "the mass stays in stick" });
        };
        // A later start of the stick shortens it in proportion to the growth of the excess.
        let (before, after) = (1.0 + scaled.rate(tau + touch), 1.0 + scaled.rate(tau + touch + stick));
        let shift = if jump == 0.0 { 0.0 } else { (before - after) / after };
        let [by_damping, by_tau] = found.time_by;
        let (by_damping, by_tau) = (by_damping * (1.0 + shift), by_tau * (1.0 + shift) + shift);
        let units = [self.unit, 1.0 / scaled.frequency];
        Ok([
            (found.minimum.w, [found.w_by[0] * units[0], found.w_by[1] * units[1]]),
            (touch + stick - TAU / scaled.frequency, [by_damping * units[0], by_tau * units[1]]),
        ])
    }

    /// Returns the residuals with all derivatives.
    fn system(&self, point: Point) -> Result<[(f64, Point); 2], VibrationError> {
        let here = self.residual(point)?;
        // One-sided at the ends of the range.
        let (low, high) = ((point[0] - DIFFERENCE).max(0.0), (point[0] + DIFFERENCE).min(1.0));
        let [_, damping, phase] = point;
        let (before, after) = (self.residual([low, damping, phase])?, self.residual([high, damping, phase])?);
        Ok([0, 1].map(|i| {
            let (value, [by_damping, by_phase]) = here[i];
            (value, [(after[i].0 - before[i].0) / (high - low), by_damping, by_phase])
        }))
    }

    /// Moves the point onto the curve within the plane perpendicular to `across`; returns the unit vector along the
    /// curve and the number of Newton steps.
    fn correct(&self, point: &mut Point, across: Point) -> Result<(Point, usize), VibrationError> {
        for steps in 1..=MAX_CORRECTIONS {
            let [(first, a), (second, b)] = self.system(*point)?;
            // The solution of a·x = −first, b·x = −second, across·x = 0.
            let along = cross(a, b);
            let determinant = dot(along, across);
            let (p, q) = (cross(b, across), cross(across, a));
            let step: Point = std::array::from_fn(|i| -(first * p[i] + second * q[i]) / determinant);
            *point = std::array::from_fn(|i| point[i] + step[i]);
            let size = dot(step, step).sqrt();
            if size.is_nan() || size > 0.5 {
                break;
            }
            if size < CORRECTED {
                let length = dot(along, along).sqrt();
                return Ok((along.map(|c| c / length), steps));
            }
        }
        Err(VibrationError::NotFound { what: "point of the curve", reason: "Newton's method did not converge" })
    }

    /// Returns the points after the first, in the direction in which the parameter rises or falls.
    fn follow(
        &self,
        first: Point,
        sense: f64,
        settings: &CurveSettings,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<Point>, BranchEnd), VibrationError> {
        let bound = if sense > 0.0 { 1.0 } else { 0.0 };
        let mut points = Vec::new();
        let mut point = first;
        if point[0] == bound {
            return Ok((points, BranchEnd::Range));
        }
        let fixed = [1.0, 0.0, 0.0];
        let turned = |[direction, reference]: [Point; 2]| {
            let sign = dot(direction, reference).signum();
            direction.map(|c| sign * c)
        };
        let mut direction = turned([self.correct(&mut point, fixed)?.0, fixed.map(|c| sense * c)]);
        let mut step = f64::min(0.01, settings.longest_step);
        while points.len() < settings.most_points {
            if monitor.cancelled() {
                return Err(Cancelled.into());
            }
            let mut next: Point = std::array::from_fn(|i| point[i] + step * direction[i]);
            let leaves = sense * (next[0] - bound) >= 0.0;
            let corrected = if leaves {
                let fraction = (bound - point[0]) / direction[0];
                next = std::array::from_fn(|i| point[i] + fraction * direction[i]);
                next[0] = bound;
                self.correct(&mut next, fixed)
            } else {
                self.correct(&mut next, direction)
            };
            let (ahead, corrections) = match corrected {
                Ok((ahead, corrections)) => (turned([ahead, direction]), corrections),
                Err(error) if step < LEAST_STEP => {
                    return Ok((points, BranchEnd::Lost { reason: error.to_string() }));
                }
                Err(_) => {
                    step *= 0.5;
                    continue;
                }
            };
            let inside = leaves || (0.0..=1.0).contains(&next[0]);
            if (dot(ahead, direction) < STRAIGHT || !inside) && step > LEAST_STEP {
                step *= 0.5;
                continue;
            }
            if sense * ahead[0] <= 0.0 {
                points.push(self.turn(point, direction, step, sense)?);
                return Ok((points, BranchEnd::Turns));
            }
            points.push(next);
            monitor.progress("points of the locked curve", points.len(), settings.most_points);
            if leaves {
                return Ok((points, BranchEnd::Range));
            }
            (point, direction) = (next, ahead);
            if corrections <= 4 {
                step = f64::min(1.4 * step, settings.longest_step);
            }
        }
        Ok((points, BranchEnd::Points))
    }

    /// Finds the extreme of the parameter on the next step, by bisection of its direction.
    fn turn(&self, point: Point, direction: Point, step: f64, sense: f64) -> Result<Point, VibrationError> {
        let mut found = point;
        bisect(0.0, step, 1e-10, |along| -> Result<bool, VibrationError> {
            found = std::array::from_fn(|i| point[i] + along * direction[i]);
            let (ahead, _) = self.correct(&mut found, direction)?;
            Ok(sense * ahead[0] * dot(ahead, direction).signum() > 0.0)
        })?;
        Ok(found)
    }
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Stribeck;
    use crate::{Forcing, Parameters, VelocityLaw, locked_boundary};
    use asperity_base::monitor::Silent;

    fn forced(kinetic: f64) -> Oscillator {
        Oscillator::new(Parameters {
            static_friction: 0.2,
            law: VelocityLaw::Stribeck(Stribeck { kinetic, decay: 4.2 }),
            damping_ratio: 0.0,
            belt_velocity: 0.1,
            forcing: Some(Forcing { amplitude: 0.01, frequency: 0.98 }),
        })
        .unwrap()
    }

    #[test]
    fn the_curve_over_the_frequency_passes_through_both_published_points() {
        let settings = CurveSettings::new([0.98, 1.0]);
        let curve = locked_curve(&forced(0.2), CurveParameter::ForcingFrequency, &settings, &Silent).unwrap();
        let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
        assert_eq!((first.parameter, last.parameter), (0.98, 1.0));
        assert_eq!((curve.start, curve.end), (BranchEnd::Range, BranchEnd::Range));
        assert!((first.critical_damping_ratio - 0.270_299_774_5).abs() < 1e-10, "{first:?}");
        assert!((last.critical_damping_ratio - 0.273_186_622_3).abs() < 1e-10, "{last:?}");
    }

    #[test]
    fn the_curve_matches_the_search_over_all_phases_until_it_turns() {
        // With a jump of the law the orbit ends in a stick.
        for kinetic in [0.2, 0.19] {
            let settings = CurveSettings::new([0.5, 1.5]);
            let curve = locked_curve(&forced(kinetic), CurveParameter::ForcingFrequency, &settings, &Silent).unwrap();
            assert_eq!((&curve.start, &curve.end), (&BranchEnd::Turns, &BranchEnd::Turns));
            let n = curve.points.len();
            for point in curve.points[2..n - 2].iter().step_by(n / 6) {
                let oscillator = CurveParameter::ForcingFrequency.set(&forced(kinetic), point.parameter).unwrap();
                let wanted = locked_boundary(&oscillator).unwrap();
                assert!((point.critical_damping_ratio - wanted).abs() < 1e-12, "{point:?} instead of {wanted}");
            }
            // Beyond the turning points no orbit closes.
            for (end, outwards) in [(curve.points[0], -1e-6), (curve.points[n - 1], 1e-6)] {
                let oscillator =
                    CurveParameter::ForcingFrequency.set(&forced(kinetic), end.parameter + outwards).unwrap();
                assert!(locked_boundary(&oscillator).is_err(), "{end:?}");
            }
        }
    }

    #[test]
    fn curves_without_a_start_are_refused() {
        let settings = CurveSettings::new([0.5, 1.5]);
        let oscillator = forced(0.2);
        assert!(locked_curve(&oscillator, CurveParameter::DampingRatio, &settings, &Silent).is_err());
        assert!(locked_curve(&oscillator, CurveParameter::BeltVelocity, &settings, &Silent).is_err());
        let free = oscillator.with_forcing(None).unwrap();
        assert!(locked_curve(&free, CurveParameter::BeltVelocity, &CurveSettings::new([0.01, 1.0]), &Silent).is_err());
    }
}
