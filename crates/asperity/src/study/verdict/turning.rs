//! Values at which a machine without uncertain values begins or ceases to vibrate.

use asperity_base::numeric::try_root_between;
use asperity_results::keys::{Bounds, DAMPING_RATIO, STATIC_FRICTION};

use super::dynamics::Dynamics;
use super::machines::{Change, Machine, Machines};
use crate::study::check::LARGEST_CHANGE;
use crate::study::file::Hold;
use crate::study::result::{InputValue, Pair, RestsOn, TurningPoint};
use crate::study::uncertain::Place;
use crate::vibration::{VibrationError, limit_damping};

/// Steps to the farthest values that are tried.
const STEPS: u32 = 16;
/// Relative tolerance of a value.
const TOLERANCE: f64 = 1e-8;

/// Returns the turning point of every number of the machine, and of a friction coefficient that is computed or read. `nominal` is the machine.
///
/// # Errors
/// The machine has no limit of the damping ratio.
pub(super) fn turning_points(
    machines: &Machines<'_>,
    nominal: &Machine,
    rests_on: &[RestsOn],
) -> Result<Vec<TurningPoint>, VibrationError> {
    let numbers = rests_on.iter().filter(|input| matches!(input.value, InputValue::Number(_)));
    let places = numbers.filter_map(|input| Place::named(&input.input, machines.central()));
    let mut found = Vec::new();
    for place in places.filter(|place| place.key().section == "vibration") {
        let (key, Some(now)) = (place.key(), machines.central_value(place)) else { continue };
        let margin = |value: f64| margin(&machines.with_changes(vec![Change { place, value, hold: Hold::Damper }]));
        let value = match &nominal.dynamics {
            // The limit may be far from the present value, which may be 0. Without a limit no damping starts vibration.
            Dynamics::StickSlip(oscillator) if place.name() == DAMPING_RATIO => {
                Some(limit_damping(oscillator)?).filter(|limit| *limit > 0.0)
            }
            _ => nearest(now, key.bounds, &margin),
        };
        found.push(TurningPoint { input: place.name(), unit: key.unit.into(), now, value });
    }
    if found.iter().all(|point| point.input != STATIC_FRICTION) {
        let now = nominal.window.mean;
        let value = nearest(now, None, &|value| margin(&machines.with_friction_factor(value / now)));
        found.push(TurningPoint { input: STATIC_FRICTION.into(), unit: String::new(), now, value });
    }
    Ok(found)
}

/// Returns the margin of the machine; `None` without an answer.
fn margin(machines: &Machines<'_>) -> Option<f64> {
    Some(machines.nominal().ok()?.dynamics.margins().ok()?.from_stick)
}

/// Returns the smallest and the largest margin of the machine with its friction coefficient times either factor; `None` for equal factors
/// and without an answer.
pub(super) fn margins_between(machines: &Machines<'_>, factors: [f64; 2]) -> Option<Pair> {
    let [low, high] = factors.map(|factor| margin(&machines.with_friction_factor(factor)));
    let [low, high] = [low?, high?];
    (factors[0] < factors[1]).then(|| [low.min(high), low.max(high)])
}

/// Returns the value nearest to the present one at which a margin changes its sign, within the bounds.
fn nearest(now: f64, bounds: Option<Bounds>, margin: &dyn Fn(f64) -> Option<f64>) -> Option<f64> {
    let within = |value: f64| bounds.map_or(value, |bounds| value.clamp(bounds.low, bounds.high));
    let side = |ratio: f64| {
        let mut before = [now, margin(now)?];
        for step in 1..=STEPS {
            let value = within(now * ratio.powf(f64::from(step) / f64::from(STEPS)));
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
    [LARGEST_CHANGE.recip(), LARGEST_CHANGE]
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
        let nominal = machines.nominal().unwrap();
        let points = turning_points(&machines, &nominal, &rests_on(&study, verdict, &window, false)).unwrap();
        let of = |name: &str| points.iter().find(|point| point.input == format!("vibration.{name}")).unwrap();
        // The damper stays, so ζ falls as 1/m and 1/ω₀, and b as 1/(mω₀).
        for (name, ratio) in [("damping_ratio", 1.25), ("linear_weakening", 0.8), ("normal_force", 0.8)] {
            let point = of(name);
            assert!((point.value.unwrap() / point.now / ratio - 1.0).abs() < 1e-6, "{point:?}");
        }
        for name in ["mass", "natural_frequency", "static_friction", "belt_velocity"] {
            assert_eq!(of(name).value, None, "{name}");
        }
        // A share just below the bound of 1 is found, although a step of the search would pass it.
        let (study, window) = stated(&format!("{text}kinetic_share = 0.9\n").replace("0.04", "0.07"));
        let verdict = study.verdict.as_ref().unwrap();
        let machines = Machines::new(verdict, &window, None, 1);
        let nominal = machines.nominal().unwrap();
        let points = turning_points(&machines, &nominal, &rests_on(&study, verdict, &window, false)).unwrap();
        let share = points.iter().find(|point| point.input == "vibration.kinetic_share").unwrap();
        assert!(nominal.dynamics.margins().unwrap().from_stick < 0.0);
        assert!(share.value.is_some_and(|share| share > 0.9 && share < 1.0), "{share:?}");
    }
    #[test]
    fn margins_between_factors_of_friction_are_those_of_other_belt_velocities() {
        // Without weakening the motion depends on (μ_st − μ_k)/V alone.
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
            nominal_area = \"833 mm^2\"\nstatic_friction = 0.3\nfriction_std = 0\ndimensionless_belt_velocity = 0.1\n\
            velocity_law = \"linear\"\nlinear_weakening = 0\nkinetic_share = 0.7\ndamping_ratio = 0.2\n";
        let (study, window) = stated(text);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1);
        let at_velocity = |velocity: &str| {
            let (study, window) = stated(&text.replace("velocity = 0.1", &format!("velocity = {velocity}")));
            margin(&Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1)).unwrap()
        };
        let found = margins_between(&machines, [0.8, 1.25]).unwrap();
        for (found, wanted) in found.into_iter().zip([at_velocity("0.08"), at_velocity("0.125")]) {
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
        assert!(found[0] < found[1] && margins_between(&machines, [1.0; 2]).is_none());
    }
}
