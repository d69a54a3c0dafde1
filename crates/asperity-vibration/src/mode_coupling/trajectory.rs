//! Trajectory under one realisation of the friction process.

use serde::{Deserialize, Serialize};

use super::super::{VibrationError, positive};
use super::motion::{Cut, Motion};
use super::{Contact, CoupledEvent, Model, State};
use asperity_process::Fluctuation;

/// Default distance from steady sliding at the start, as a fraction of the steady displacement.
const DEFAULT_OFFSET: f64 = 0.01;

/// Settings of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoupledTrajectorySettings {
    /// Duration τ.
    pub duration: f64,
    /// State at τ = 0. The default is at rest in space, displaced 1 % further along the belt than steady sliding.
    pub start: Option<State>,
}

/// Events of one trajectory and fractions of its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoupledTrajectory {
    /// Events in order.
    pub events: Vec<CoupledEvent>,
    /// Fraction of the time in stick.
    pub stick_share: f64,
    /// Fraction of the time off the belt.
    pub flight_share: f64,
    /// State at the end.
    pub end: State,
}

/// A point of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Time τ.
    pub tau: f64,
    /// State of the mass.
    pub state: State,
    /// Contact with the belt.
    pub contact: Contact,
}

impl CoupledTrajectory {
    /// Simulates a mass under one realisation of m(s).
    ///
    /// Fails if no start is given and no steady sliding exists, if the friction coefficient does not stay positive, if
    /// a record is too short, or if events follow each other without time between them.
    pub fn simulate(
        model: &Model,
        fluctuation: impl Fluctuation,
        settings: &CoupledTrajectorySettings,
    ) -> Result<Self, VibrationError> {
        let mut motion = started(model, fluctuation, settings)?;
        let mut events = Vec::new();
        let (mut stick, mut flight) = (0.0, 0.0);
        while motion.now.tau < settings.duration {
            if let Cut::Event(event) = motion.step(settings.duration)? {
                events.push(event);
            }
            match motion.passed {
                (Contact::Stick, since) => stick += motion.now.tau - since,
                (Contact::Flight, since) => flight += motion.now.tau - since,
                _ => {}
            }
        }
        let (stick_share, flight_share) = (stick / settings.duration, flight / settings.duration);
        Ok(Self { events, stick_share, flight_share, end: motion.now.state() })
    }

    /// Returns the same trajectory at `points` ≥ 2 equal times from τ = `from` to the end.
    ///
    /// Fails like [`CoupledTrajectory::simulate`], and if `from` is not between 0 and the duration.
    pub fn portrait(
        model: &Model,
        fluctuation: impl Fluctuation,
        settings: &CoupledTrajectorySettings,
        from: f64,
        points: usize,
    ) -> Result<Vec<Point>, VibrationError> {
        if !(from >= 0.0 && from < settings.duration) {
            let wanted = "between 0 and the duration";
            return Err(VibrationError::Parameter { parameter: "from", value: from, wanted });
        }
        if points < 2 {
            let value = points as f64;
            return Err(VibrationError::Parameter { parameter: "points of the portrait", value, wanted: "at least 2" });
        }
        let mut motion = started(model, fluctuation, settings)?;
        let time = |i: usize| from + (settings.duration - from) * i as f64 / (points - 1) as f64;
        let mut portrait = Vec::with_capacity(points);
        if from == 0.0 {
            portrait.push(Point { tau: 0.0, state: motion.now.state(), contact: motion.now.contact });
        }
        while portrait.len() < points {
            motion.step(settings.duration)?;
            while portrait.len() < points
                && (time(portrait.len()) <= motion.now.tau || motion.now.tau >= settings.duration)
            {
                let tau = time(portrait.len()).min(settings.duration);
                portrait.push(Point { tau, state: motion.sample(tau), contact: motion.passed.0 });
            }
        }
        Ok(portrait)
    }
}

/// Returns the default start.
pub(super) fn default_start(model: &Model) -> Result<State, VibrationError> {
    let reason = "friction pulls the mass away; state the start of the mass";
    let missing = VibrationError::NotFound { what: "state of steady sliding", reason };
    let steady = model.steady(model.sliding_friction()).ok_or(missing)?;
    let tangential = steady.tangential * (1.0 + DEFAULT_OFFSET);
    Ok(State { tangential, tangential_velocity: 0.0, normal: steady.normal, normal_velocity: 0.0 })
}

/// Returns the motion at τ = 0.
pub(super) fn started<'a, F: Fluctuation>(
    model: &'a Model,
    fluctuation: F,
    settings: &CoupledTrajectorySettings,
) -> Result<Motion<'a, F>, VibrationError> {
    positive("duration", settings.duration)?;
    let start = settings.start.map_or_else(|| default_start(model), Ok)?;
    Motion::new(model, fluctuation, start)
}

#[cfg(test)]
mod tests {
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use std::f64::consts::TAU;

    use super::super::{CoupledEventKind, CoupledParameters, Damping, modes};
    use super::*;
    use crate::{self as vibration, VelocityLaw};
    use asperity_base::random;
    use asperity_process::{FrictionProcess, ProcessModel, RecordedProcess, Steady};

    fn state(x: f64, u: f64, y: f64, v: f64) -> State {
        State { tangential: x, tangential_velocity: u, normal: y, normal_velocity: v }
    }

    /// Returns a model with k₃ = 4/3, K(0) = [2, 1; 1, 2], C = diag(0.02, 0.02), V = 0.2, μ_s = 1.3, μ = 1.2/(1 + 0.3|v|).
    fn example() -> Model {
        Model::new(CoupledParameters {
            damping: Damping::Axes { tangential: 0.02, normal: 0.02 },
            static_friction: 1.3,
            law: VelocityLaw::Stribeck(Stribeck { kinetic: 1.2, decay: 0.3 }),
            belt_velocity: 0.2,
            ..CoupledParameters::default()
        })
        .unwrap()
    }

    /// Returns the largest difference from given events (letter, τ, x, y, s) and from a final state (x, x′, y, y′).
    fn difference(found: &CoupledTrajectory, wanted: &[(&str, f64, f64, f64, f64)], end: [f64; 4]) -> f64 {
        assert_eq!(found.events.len(), wanted.len(), "{:?}", found.events);
        let mut worst = 0.0_f64;
        for (event, wanted) in found.events.iter().zip(wanted) {
            assert_eq!(event.kind.code(), wanted.0);
            for (a, b) in [
                (event.tau, wanted.1),
                (event.state.tangential, wanted.2),
                (event.state.normal, wanted.3),
                (event.sliding_distance, wanted.4),
            ] {
                worst = worst.max((a - b).abs());
            }
        }
        let State { tangential: x, tangential_velocity: u, normal: y, normal_velocity: v } = found.end;
        [x, u, y, v].iter().zip(end).fold(worst, |worst, (a, b)| worst.max((a - b).abs()))
    }

    // Reference for both tables: SciPy's DOP853 on each smooth branch (rtol 3e-14, atol 1e-15, steps up to 0.02),
    // events by Brent's method on its dense output, sampled 41 times per 0.05.
    #[test]
    fn stick_slip_and_flight_match_an_independent_integration() {
        let settings = CoupledTrajectorySettings { duration: 14.0, start: Some(state(0.5, 0.0, -0.4, 0.1)) };
        let found = CoupledTrajectory::simulate(&example(), Steady, &settings).unwrap();
        let worst = difference(
            &found,
            &[
                ("R", 5.7015249878305, 0.3164205073411, 0.0013661730928, 1.3238844902250),
                ("D", 7.2099759918813, 0.6181107081512, -0.0815162504966, 1.3238844902250),
                ("F", 8.3878250146745, 0.6151191421171, -0.7500000000000, 1.5624458608178),
                ("L", 8.9954094169269, 0.3835535486239, -0.7500000000000, 1.5624458608178),
                ("R", 10.1522734288718, 0.1371071923074, 0.1432333118240, 2.0402650195233),
                ("D", 12.1853503177818, 0.5437225700894, -0.2843929906651, 2.0402650195233),
                ("F", 12.6232071964301, 0.6106925545296, -0.7500000000000, 2.0608664108127),
            ],
            [0.5346777706937, -0.0854156382958, -0.9974121754245, 0.6177655591002],
        );
        assert!(worst < 1e-11, "{worst:e}");
    }

    #[test]
    fn recorded_fluctuations_and_over_slip_match_an_independent_integration() {
        // m = 0.01·((7i² + 3i) mod 11 − 5) at s = 0.03i.
        let values = (0..200_i32).map(|i| 0.01 * f64::from((7 * i * i + 3 * i) % 11 - 5)).collect();
        let process = RecordedProcess::new(0.03, values).unwrap();
        let settings = CoupledTrajectorySettings { duration: 9.0, start: Some(state(1.4, 0.9, 0.4, 0.1)) };
        let found = CoupledTrajectory::simulate(&example(), process.path(), &settings).unwrap();
        let worst = difference(
            &found,
            &[
                ("O", 0.1404352328758, 1.4779624716890, 0.3919928561113, 0.0498754251139),
                ("F", 1.1979581530209, 0.7524873373263, -0.7500000000000, 0.9868551435057),
                ("L", 2.8198709385193, -0.2137033905269, -0.7500000000000, 0.9868551435057),
                ("R", 3.4879855159264, 0.2825238483889, 0.5094383869097, 1.3494594669401),
                ("D", 5.2705098692170, 0.6390287190470, -0.0829250018829, 1.3494594669401),
                ("F", 5.5851258684381, 0.6881156287336, -0.7500000000000, 1.3632957570978),
                ("L", 8.6380595486675, 1.2347380172165, -0.7500000000000, 1.3632957570978),
            ],
            [0.8462399438358, -1.2843456388024, -0.2254937593515, 1.4091766603012],
        );
        assert!(worst < 1e-11, "{worst:e}");
    }

    #[test]
    fn small_motion_grows_with_the_real_part_of_the_eigenvalue() {
        let damping = Damping::Modal { ratios: [0.03, 0.01] };
        // With Coulomb friction growth is exactly linear; under a weakening law the nonlinear part is of the order of
        // the amplitude.
        for (law, a, tolerance) in [
            (VelocityLaw::Coulomb(Coulomb { kinetic: 0.4 }), 1e-3, 1e-12),
            (VelocityLaw::Coulomb(Coulomb { kinetic: 0.9 }), 1e-3, 1e-12),
            (VelocityLaw::Stribeck(Stribeck { kinetic: 0.9, decay: 0.3 }), 1e-6, 1e-6),
            (VelocityLaw::Linear(Linear { kinetic: 0.6, slope: 0.1 }), 1e-6, 1e-6),
        ] {
            let model = Model::new(CoupledParameters {
                damping,
                law: law.clone(),
                static_friction: 0.9,
                ..CoupledParameters::default()
            })
            .unwrap();
            let friction = model.sliding_friction();
            let [k11, k12, _] = model.stiffness();
            let (c11, c12) = (model.effective_damping(friction), model.damping()[1]);
            let steady = model.steady(friction).unwrap();
            for mode in modes(&model, friction) {
                // Eigenvector (1, r), r = −(λ² + c₁₁λ + k₁₁)/(c₁₂λ + k₁₂ − μk₃), in real and imaginary parts.
                let (g, w) = (mode.growth, mode.frequency);
                let top = (g * g - w * w + c11 * g + k11, 2.0 * g * w + c11 * w);
                let bottom = (c12 * g + k12 - friction * 4.0 / 3.0, c12 * w);
                let size = bottom.0 * bottom.0 + bottom.1 * bottom.1;
                let r = (-(top.0 * bottom.0 + top.1 * bottom.1) / size, -(top.1 * bottom.0 - top.0 * bottom.1) / size);
                let start = state(steady.tangential + a, a * g, steady.normal + a * r.0, a * (g * r.0 - w * r.1));
                // After two periods the deviation is the same, multiplied by e^{growth·τ}.
                let duration = 2.0 * TAU / w;
                let settings = CoupledTrajectorySettings { duration, start: Some(start) };
                let CoupledTrajectory { events, end, .. } =
                    CoupledTrajectory::simulate(&model, Steady, &settings).unwrap();
                assert!(events.is_empty());
                for (after, before) in [
                    (end.tangential - steady.tangential, a),
                    (end.tangential_velocity, start.tangential_velocity),
                    (end.normal - steady.normal, start.normal - steady.normal),
                    (end.normal_velocity, start.normal_velocity),
                ] {
                    let growth = (after / before).ln() / duration;
                    assert!((growth - g).abs() < tolerance * (a / before).abs(), "{law:?}: {growth} {g}");
                }
            }
        }
    }

    #[test]
    fn energy_changes_by_the_work_of_friction_and_dampers() {
        let model = example();
        let process = FrictionProcess::new(ProcessModel::new("normal".parse().unwrap(), 0.02, 0.3)).unwrap();
        let settings = CoupledTrajectorySettings { duration: 60.0, start: Some(state(0.5, 0.0, -0.4, 0.1)) };
        let ([k11, k12, k22], [c11, _, c22]) = (model.stiffness(), model.damping());
        let contact = model.parameters().contact_stiffness;
        // Energy of the springs, the static load and the contact spring, the last one only in contact.
        let energy = |s: &State| {
            let (x, y) = (s.tangential, s.normal);
            let springs = 0.5 * (k11 * x * x + (k22 - contact) * y * y) + k12 * x * y;
            let pressure = (1.0 + contact * y).max(0.0);
            let speeds = s.tangential_velocity.powi(2) + s.normal_velocity.powi(2);
            0.5 * speeds + springs - y + 0.5 * pressure * pressure / contact
        };
        // Five-point Gauss–Legendre rule.
        let (near, far) =
            ((5.0 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0, (5.0 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0);
        let root = 13.0 * 70.0_f64.sqrt();
        let rule = [
            (0.0, 128.0 / 225.0),
            (near, (322.0 + root) / 900.0),
            (-near, (322.0 + root) / 900.0),
            (far, (322.0 - root) / 900.0),
            (-far, (322.0 - root) / 900.0),
        ];
        let mut motion = started(&model, process.path(5, 0), &settings).unwrap();
        let (before, mut work, mut flight) = (energy(&motion.now.state()), 0.0, 0);
        while motion.now.tau < settings.duration {
            let (m_before, s_before) = (motion.now.m, motion.now.sliding_distance);
            motion.step(settings.duration).unwrap();
            let (contact_kind, since) = motion.passed;
            let length = motion.now.tau - since;
            flight += usize::from(contact_kind == Contact::Flight);
            let slope = (motion.now.m - m_before) / (motion.now.sliding_distance - s_before);
            let pieces = (length / 0.02).ceil().max(1.0) as usize;
            for piece in 0..pieces {
                for (node, weight) in rule {
                    let fraction = (piece as f64 + 0.5 + 0.5 * node) / pieces as f64;
                    let s = motion.sample(since + fraction * length);
                    let (u, v) = (s.tangential_velocity, s.normal_velocity);
                    let ahead = model.belt_velocity() - u;
                    let force = match contact_kind {
                        Contact::Flight => 0.0,
                        Contact::Stick => k11 * s.tangential + k12 * s.normal + c11 * u,
                        Contact::Slip | Contact::OverSlip => {
                            let distance = motion.distance_at(since + fraction * length);
                            let m = if distance > 0.0 { m_before + slope * distance } else { m_before };
                            let law = model.parameters().law.coefficient(ahead.abs());
                            ahead.signum() * (law + m) * (1.0 + contact * s.normal)
                        }
                    };
                    work += (force * u - c11 * u * u - c22 * v * v) * 0.5 * weight * length / pieces as f64;
                }
            }
        }
        let after = energy(&motion.now.state());
        assert!(flight > 10);
        assert!((after - before - work).abs() < 1e-10, "{after} {before} {work}");
    }

    #[test]
    fn a_portrait_contains_the_events() {
        let settings = CoupledTrajectorySettings { duration: 14.0, start: Some(state(0.5, 0.0, -0.4, 0.1)) };
        let points = CoupledTrajectory::portrait(&example(), Steady, &settings, 0.0, 14_001).unwrap();
        let trajectory = CoupledTrajectory::simulate(&example(), Steady, &settings).unwrap();
        assert_eq!((points.len(), points[14_000].state), (14_001, trajectory.end));
        for (mut points, kind) in
            [(Contact::Stick, CoupledEventKind::Detach), (Contact::Flight, CoupledEventKind::Landing)]
                .map(|(contact, kind)| (points.iter().filter(move |p| p.contact == contact), kind))
        {
            let last = trajectory.events.iter().rev().find(|event| event.kind == kind).unwrap();
            let before = points.rfind(|p| p.tau <= last.tau).unwrap();
            assert!(last.tau - before.tau <= 1e-3 && (last.state.normal - before.state.normal).abs() < 2e-3);
        }
        let fraction = points.iter().filter(|p| p.contact == Contact::Flight).count() as f64 / 14_001.0;
        assert!((fraction - trajectory.flight_share).abs() < 1e-3);
    }

    #[test]
    fn without_coupling_events_match_one_degree_of_freedom() {
        let stribeck = vibration::Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        // The weakening acts in the last hundredth of a slip.
        let law = VelocityLaw::Exponential(Exponential { kinetic: 0.09, high_speed: 0.06, stribeck_velocity: 0.0004 });
        let steep =
            vibration::Parameters { law, belt_velocity: 0.04, damping_ratio: 0.005, ..stribeck.parameters().clone() };
        for (oscillator, length) in [(stribeck, 0.01), (vibration::Oscillator::new(steep).unwrap(), 20.0)] {
            let belt_velocity = oscillator.belt_velocity();
            let model = Model::new(CoupledParameters {
                angles_deg: [0.0, 90.0],
                springs: [1.0, 2.0],
                damping: Damping::Axes { tangential: 2.0 * oscillator.damping_ratio(), normal: 0.1 },
                static_friction: 0.1,
                law: oscillator.law().clone(),
                belt_velocity,
                ..CoupledParameters::default()
            })
            .unwrap();
            let model_of_friction = ProcessModel::new("beta:2.1,5".parse().unwrap(), 0.001, length);
            let process = FrictionProcess::new(model_of_friction).unwrap();
            let drive = vibration::Drive::Distance;
            let settings = vibration::TrajectorySettings { duration: 60.0, start: None, drive };
            let wanted = vibration::Trajectory::simulate(&oscillator, process.path(1, 0), &settings).unwrap().events;
            let start = state(oscillator.default_start(), belt_velocity, 0.0, 0.0);
            let settings = CoupledTrajectorySettings { duration: 60.0, start: Some(start) };
            let found = CoupledTrajectory::simulate(&model, process.path(1, 0), &settings).unwrap().events;
            assert!(found.len() == wanted.len() && found.len() > 10, "{} and {}", found.len(), wanted.len());
            for (a, b) in found.iter().zip(&wanted) {
                assert_eq!(a.kind.code(), b.kind.code());
                let same = (a.tau - b.tau).abs() < 1e-8 && (a.state.tangential - b.displacement).abs() < 1e-11;
                assert!(same, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn motions_of_random_parameters_complete() {
        let mut stream = random::stream(17, "mode coupling test", 0);
        let process = FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), 0.02, 0.1)).unwrap();
        for index in 0..300 {
            let z = random::standard_normal(&mut stream, 12);
            let static_friction = 0.7 * (0.5 * z[0]).exp();
            let decay = z[1].exp();
            let kinetic = static_friction * (1.0 - 0.2 * z[2].abs()).max(0.2);
            let law = if z[3] > 0.0 {
                VelocityLaw::Stribeck(Stribeck { kinetic, decay })
            } else {
                VelocityLaw::Coulomb(Coulomb { kinetic })
            };
            let model = Model::new(CoupledParameters {
                angles_deg: [180.0 * z[4], 180.0 * z[5]],
                springs: [z[6].exp(), z[7].exp()],
                contact_stiffness: (2.0 * z[8]).exp(),
                damping: Damping::Axes { tangential: 0.02 * z[9].exp(), normal: 0.02 * z[10].exp() },
                static_friction,
                law,
                belt_velocity: 0.1 * (1.5 * z[11]).exp(),
            })
            .unwrap();
            let settings = CoupledTrajectorySettings { duration: 50.0, start: Some(state(z[0], z[1], z[2], z[3])) };
            for found in [
                CoupledTrajectory::simulate(&model, Steady, &settings),
                CoupledTrajectory::simulate(&model, process.path(2, index), &settings),
            ] {
                match found {
                    Ok(found) => assert!(found.end.tangential.is_finite() && found.end.normal.is_finite()),
                    Err(VibrationError::FrictionNotPositive { .. }) => {}
                    Err(error) => panic!("{model:?}: {error}"),
                }
            }
        }
    }

    #[test]
    fn negative_friction_and_short_records_are_errors() {
        let settings = CoupledTrajectorySettings { duration: 50.0, start: None };
        let run = |values: Vec<f64>| {
            CoupledTrajectory::simulate(&example(), RecordedProcess::new(0.1, values).unwrap().path(), &settings)
        };
        assert!(matches!(run(vec![0.0; 4]), Err(VibrationError::ProcessTooShort { .. })));
        assert!(matches!(run(vec![-1.25; 1000]), Err(VibrationError::FrictionNotPositive { .. })));
        let nowhere = CoupledTrajectorySettings { duration: 1.0, start: Some(state(f64::NAN, 0.0, 0.0, 0.0)) };
        assert!(CoupledTrajectory::simulate(&example(), Steady, &nowhere).is_err());
    }
}
