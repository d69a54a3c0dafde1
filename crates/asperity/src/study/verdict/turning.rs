//! Values at which a machine without uncertain values begins or ceases to vibrate.

use asperity_base::numeric::try_root_between;

use super::machines::{Change, Machines};
use crate::study::file::Hold;
use crate::study::result::{InputValue, RestsOn, TurningPoint};
use crate::study::uncertain::Place;

/// Largest ratio of the values that are tried to the present one, and steps to it.
const LARGEST_RATIO: f64 = 10.0;
const STEPS: u32 = 16;
/// Relative tolerance of a value.
const TOLERANCE: f64 = 1e-8;
/// Friction coefficient, which the machine may state or not.
const FRICTION: &str = "vibration.static_friction";

/// Returns the turning point of every number of the machine, and of a friction coefficient that is computed or read.
pub(super) fn turning_points(machines: &Machines<'_>, rests_on: &[RestsOn]) -> Vec<TurningPoint> {
    let mut found: Vec<TurningPoint> = rests_on
        .iter()
        .filter(|input| input.input.starts_with("vibration.") && matches!(input.value, InputValue::Number(_)))
        .filter_map(|input| {
            let place = Place::named(&input.input, machines.central())?;
            let now = machines.central_value(place).filter(|now| *now != 0.0)?;
            let key = place.key();
            let margin = |value: f64| {
                key.bounds.filter(|bounds| bounds.contain(value))?;
                margin(&machines.with_changes(vec![Change { place, value, hold: Hold::Damper }]))
            };
            Some(TurningPoint { input: place.name(), unit: key.unit.into(), now, value: nearest(now, &margin) })
        })
        .collect();
    if found.iter().all(|point| point.input != FRICTION)
        && let Ok(nominal) = machines.nominal()
    {
        let now = nominal.window.mean;
        let value = nearest(now, &|value| margin(&machines.with_friction_factor(value / now)));
        found.push(TurningPoint { input: FRICTION.into(), unit: String::new(), now, value });
    }
    found
}

/// Returns the margin of the machine; `None` without an answer.
fn margin(machines: &Machines<'_>) -> Option<f64> {
    Some(machines.nominal().ok()?.dynamics.margins().ok()?.from_stick)
}

/// Returns the value nearest to the present one at which a margin changes its sign.
fn nearest(now: f64, margin: &dyn Fn(f64) -> Option<f64>) -> Option<f64> {
    let side = |ratio: f64| {
        let mut before = [now, margin(now)?];
        for step in 1..=STEPS {
            let value = now * ratio.powf(f64::from(step) / f64::from(STEPS));
            let here = [value, margin(value)?];
            if here[1].is_sign_negative() != before[1].is_sign_negative() {
                let found = try_root_between(|value| margin(value).ok_or(()), before, here, TOLERANCE * now.abs());
                return found.ok().flatten();
            }
            before = here;
        }
        None
    };
    let distance = |value: &f64| (value / now).ln().abs();
    [LARGEST_RATIO.recip(), LARGEST_RATIO]
        .into_iter()
        .filter_map(side)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use super::super::machines::tests::stated;
    use super::super::rests_on::rests_on;
    use super::*;

    #[test]
    fn values_turn_the_machine_where_its_damping_ratio_is_the_limit() {
        // Linear friction μ(1 − b v/v₀) without a jump: vibration ends at ζ = b/2, whatever mass and frequency are; b is per unit of
        // dimensionless velocity, so in SI it is proportional to the load.
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
            nominal_area = \"833 mm^2\"\nstatic_friction = 0.3\nfriction_std = 0\nbelt_velocity = \"0.1 m/s\"\n\
            velocity_law = \"linear\"\nlinear_weakening = 0.1\ndamping_ratio = 0.04\n";
        let (study, window) = stated(text);
        let verdict = study.verdict.as_ref().unwrap();
        let machines = Machines::new(verdict, &window, None, 1);
        let points = turning_points(&machines, &rests_on(&study, verdict, &window, false));
        let of = |name: &str| points.iter().find(|point| point.input == format!("vibration.{name}")).unwrap();
        // The damper stays, so ζ falls as 1/m and 1/ω₀, and b as 1/(mω₀).
        for (name, ratio) in [("damping_ratio", 1.25), ("linear_weakening", 0.8), ("normal_force", 0.8)] {
            let point = of(name);
            assert!((point.value.unwrap() / point.now / ratio - 1.0).abs() < 1e-6, "{point:?}");
        }
        for name in ["mass", "natural_frequency", "static_friction", "belt_velocity"] {
            assert_eq!(of(name).value, None, "{name}");
        }
        assert!(points.iter().all(|point| point.now != 0.0), "{points:?}");
    }
}
