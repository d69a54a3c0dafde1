//! Slow and simple reference integration for the tests.
//!
//! The classical Runge–Kutta method in fixed steps integrates displacement and velocity on the slip branch of a
//! fixed sign. Events and grid points are found by bisection of the step.

use super::{Drive, EventKind, Oscillator, Trajectory, TrajectorySettings};
use asperity_process::Cell;

const STEP: f64 = 1e-3;

/// Motion by the reference.
pub(crate) struct Oracle<'a> {
    oscillator: &'a Oscillator,
    cells: &'a [Cell],
    drive: Drive,
    step: f64,
    pub(crate) tau: f64,
    pub(crate) x: f64,
    velocity: f64,
    s: f64,
    /// Cell of the process, which changes only at its ends.
    cell: usize,
    /// Sign of the relative velocity, 0 in stick.
    sign: f64,
}

impl<'a> Oracle<'a> {
    /// Creates the motion from the default start.
    pub(crate) fn new(oscillator: &'a Oscillator, cells: &'a [Cell], drive: Drive, step: f64) -> Self {
        Self {
            oscillator,
            cells,
            drive,
            step,
            tau: 0.0,
            x: oscillator.default_start(),
            velocity: oscillator.belt_velocity(),
            s: 0.0,
            cell: 0,
            sign: 0.0,
        }
    }
    fn friction_fluctuation(&self, tau: f64, s: f64) -> f64 {
        let cell = &self.cells[self.cell];
        cell.right + (self.coordinate(tau, s) - cell.end) / cell.length * (cell.right - cell.left)
    }

    fn coordinate(&self, tau: f64, s: f64) -> f64 {
        match self.drive {
            Drive::Distance => s,
            Drive::Time => self.oscillator.belt_velocity() * tau,
        }
    }

    fn external(&self, tau: f64) -> f64 {
        self.oscillator.forcing().map_or(0.0, |f| f.amplitude * (f.frequency * tau).cos())
    }

    /// Returns (X′, X″, s′).
    fn rate(&self, tau: f64, [x, velocity, s]: [f64; 3]) -> [f64; 3] {
        let belt = self.oscillator.belt_velocity();
        if self.sign == 0.0 {
            return [belt, 0.0, 0.0];
        }
        let relative = self.sign * (belt - velocity);
        let friction = self.oscillator.law().coefficient(relative) + self.friction_fluctuation(tau, s);
        let force = self.external(tau) + self.sign * friction;
        [velocity, force - x - 2.0 * self.oscillator.damping_ratio() * velocity, relative]
    }

    /// Returns the state after dt.
    fn advanced(&self, dt: f64) -> [f64; 3] {
        let y = [self.x, self.velocity, self.s];
        let add = |k: [f64; 3], h: f64| [y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2]];
        let k1 = self.rate(self.tau, y);
        let k2 = self.rate(self.tau + 0.5 * dt, add(k1, 0.5 * dt));
        let k3 = self.rate(self.tau + 0.5 * dt, add(k2, 0.5 * dt));
        let k4 = self.rate(self.tau + dt, add(k3, dt));
        std::array::from_fn(|i| y[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// Returns the force required to stick.
    fn stick_force(&self, tau: f64, x: f64) -> f64 {
        x + 2.0 * self.oscillator.damping_ratio() * self.oscillator.belt_velocity() - self.external(tau)
    }

    fn stick_limit(&self, tau: f64, s: f64) -> f64 {
        self.oscillator.static_friction() + self.friction_fluctuation(tau, s)
    }

    /// Returns whether a step of dt passes an event, and whether it passes a grid point.
    fn passes(&self, dt: f64) -> (bool, bool) {
        let [x, velocity, s] = self.advanced(dt);
        let tau = self.tau + dt;
        let event = if self.sign == 0.0 {
            self.stick_force(tau, x).abs() > self.stick_limit(tau, s)
        } else {
            self.sign * (self.oscillator.belt_velocity() - velocity) < 0.0
        };
        (event, self.coordinate(tau, s) > self.cells[self.cell].end)
    }

    fn sign_at_rest(&self) -> f64 {
        let force = self.stick_force(self.tau, self.x);
        if force.abs() <= self.stick_limit(self.tau, self.s) { 0.0 } else { force.signum() }
    }

    /// Returns kind, time, displacement and sliding distance of the events until this time.
    pub(crate) fn run(&mut self, duration: f64) -> Vec<(EventKind, f64, f64, f64)> {
        let mut events = Vec::new();
        self.sign = self.sign_at_rest();
        if self.sign != 0.0 {
            events.push((EventKind::Detach, 0.0, self.x, 0.0));
        }
        while self.tau < duration {
            let passed = self.passes(self.step);
            let (mut low, mut high) = (0.0, self.step);
            if passed != (false, false) {
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if self.passes(middle) == (false, false) { low = middle } else { high = middle }
                }
            }
            let (event, grid_point) = if passed == (false, false) { passed } else { self.passes(high) };
            let [x, velocity, s] = self.advanced(high);
            let stuck = self.sign == 0.0;
            (self.tau, self.x, self.velocity, self.s) = (self.tau + high, x, velocity, s);
            if event {
                self.velocity = self.oscillator.belt_velocity();
                let before = self.sign;
                let force = self.stick_force(self.tau, self.x);
                self.sign = if stuck { force.signum() } else { self.sign_at_rest() };
                let kind = match (stuck, self.sign == 0.0) {
                    (true, _) => EventKind::Detach,
                    (false, true) => EventKind::Restick,
                    (false, false) => EventKind::Reverse,
                };
                assert!(stuck || self.sign != before, "an arrival cannot slip on in its direction");
                events.push((kind, self.tau, self.x, self.s));
            } else if grid_point {
                self.cell += 1;
            }
        }
        events
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use crate::{Forcing, FrictionTable, Parameters, VelocityLaw};
    use asperity_process::{Fluctuation, FrictionProcess, Generator, ProcessModel};

    fn compare(parameters: Parameters, std: f64, length: f64, drive: Drive) -> [usize; 3] {
        compare_made(Generator::Autoregressive, parameters, std, length, drive, STEP)
    }

    fn compare_made(
        generator: Generator,
        parameters: Parameters,
        std: f64,
        length: f64,
        drive: Drive,
        step: f64,
    ) -> [usize; 3] {
        let model = ProcessModel {
            steps_per_length: 4,
            generator,
            ..ProcessModel::new("beta:2.1,5".parse().unwrap(), std, length)
        };
        let process = FrictionProcess::new(model).unwrap();
        let mut path = process.path(11, 0);
        let cells: Vec<Cell> = (0..4000).map(|_| path.next_cell().unwrap()).collect();
        let oscillator = Oscillator::new(parameters).unwrap();
        let settings = TrajectorySettings { duration: 50.0, start: None, drive };
        let fast = Trajectory::simulate(&oscillator, process.path(11, 0), &settings).unwrap();
        let slow = Oracle::new(&oscillator, &cells, drive, step).run(50.0);
        let slow: Vec<_> = slow.into_iter().filter(|e| e.1 <= 50.0).collect();
        assert_eq!(fast.events.len(), slow.len());
        for (event, (kind, tau, x, s)) in fast.events.iter().zip(slow) {
            assert_eq!(event.kind, kind, "{event:?}");
            // The error of the method is of the order 50·STEP⁴; the error of times at grazing events is of the order of
            // its square root.
            let differences = [event.tau - tau, event.displacement - x, event.sliding_distance - s];
            assert!(differences.iter().all(|d| d.abs() < 1e-8), "{event:?}: {differences:?}");
        }
        let count = |kind| fast.events.iter().filter(|e| e.kind == kind).count();
        [count(EventKind::Detach), count(EventKind::Restick), count(EventKind::Reverse)]
    }

    #[test]
    fn fast_and_slow_integration_agree_on_every_event() {
        let base = Parameters {
            static_friction: 0.3,
            law: VelocityLaw::Stribeck(Stribeck { kinetic: 0.25, decay: 3.0 }),
            damping_ratio: 0.05,
            belt_velocity: 0.05,
            forcing: None,
        };
        for drive in [Drive::Distance, Drive::Time] {
            let [detach, restick, _] = compare(base.clone(), 0.01, 0.05, drive);
            assert!(detach >= 4 && restick >= 4);
            compare(
                Parameters { law: VelocityLaw::Coulomb(Coulomb { kinetic: 0.2 }), ..base.clone() },
                0.005,
                0.1,
                drive,
            );
            compare(
                Parameters { law: VelocityLaw::Linear(Linear { kinetic: 0.3, slope: 0.2 }), ..base.clone() },
                0.005,
                0.1,
                drive,
            );
            let law = VelocityLaw::Exponential(Exponential { kinetic: 0.28, high_speed: 0.2, stribeck_velocity: 0.05 });
            compare(Parameters { law, ..base.clone() }, 0.005, 0.1, drive);
            // Monotone cubics through points on a line are the line. The oracle ignores the points; the fast
            // integration stops at them.
            let line = |v: f64| [v, 0.3 - 0.2 * v];
            let table = FrictionTable::new(&[0.0, 0.03, 0.06, 0.08, 0.1, 1.0].map(line)).unwrap();
            compare(Parameters { law: VelocityLaw::Tabulated(table), ..base.clone() }, 0.005, 0.1, drive);
            // Weakening continuous at zero: every detachment starts with zero acceleration, and noise causes
            // micro-slips.
            let paper = Parameters {
                static_friction: 0.1,
                law: VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }),
                damping_ratio: 0.17,
                belt_velocity: 0.02,
                forcing: None,
            };
            compare(paper.clone(), 0.004, 0.05, drive);
        }
    }

    #[test]
    fn fast_and_slow_integration_agree_under_forcing_through_over_slip() {
        let base = Parameters {
            static_friction: 0.1,
            law: VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 3.0 }),
            damping_ratio: 0.1,
            belt_velocity: 0.05,
            forcing: Some(Forcing { amplitude: 0.4, frequency: 0.6 }),
        };
        for drive in [Drive::Distance, Drive::Time] {
            let [_, _, reverse] = compare(base.clone(), 0.003, 0.2, drive);
            assert!(reverse >= 4, "{reverse} reversals");
            let gentle = Parameters { forcing: Some(Forcing { amplitude: 0.15, frequency: 0.5 }), ..base.clone() };
            let [detach, restick, _] = compare(gentle, 0.003, 0.2, drive);
            assert!(detach >= 4 && restick >= 4);
        }
    }

    #[test]
    fn fast_and_slow_integration_agree_on_forced_motions_of_every_law() {
        let table = FrictionTable::new(&[[0.0, 0.1], [0.03, 0.08], [0.06, 0.075], [0.1, 0.08]]).unwrap();
        let laws = [
            VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }),
            VelocityLaw::Coulomb(Coulomb { kinetic: 0.05 }),
            VelocityLaw::Linear(Linear { kinetic: 0.09, slope: 0.1 }),
            VelocityLaw::Exponential(Exponential { kinetic: 0.1, high_speed: 0.07, stribeck_velocity: 0.05 }),
            // The oracle steps over the points, where the curvature jumps.
            VelocityLaw::Tabulated(table),
        ];
        let mut reversals = 0;
        for (amplitude, frequency) in [(0.01, 0.9), (0.4, 0.6)] {
            for law in &laws {
                for drive in [Drive::Distance, Drive::Time] {
                    let forcing = Some(Forcing { amplitude, frequency });
                    let base = Parameters {
                        static_friction: 0.1,
                        law: law.clone(),
                        damping_ratio: 0.02,
                        belt_velocity: 0.05,
                        forcing,
                    };
                    let recursion = Generator::Autoregressive;
                    reversals += compare_made(recursion, base, 0.002, 0.05, drive, 0.25 * STEP)[2];
                }
            }
        }
        assert!(reversals > 20, "{reversals} reversals");
    }

    #[test]
    fn fast_and_slow_integration_agree_where_friction_jumps() {
        let base = Parameters {
            static_friction: 0.3,
            law: VelocityLaw::Coulomb(Coulomb { kinetic: 0.25 }),
            damping_ratio: 0.0,
            belt_velocity: 0.05,
            forcing: None,
        };
        for drive in [Drive::Distance, Drive::Time] {
            let jumping =
                |parameters, std, length| compare_made(Generator::Renewal, parameters, std, length, drive, STEP);
            let [detach, restick, _] = jumping(base.clone(), 0.02, 0.1);
            assert!(detach >= 4 && restick >= 4);
            let law = VelocityLaw::Stribeck(Stribeck { kinetic: 0.3, decay: 3.0 });
            jumping(Parameters { law, damping_ratio: 0.05, ..base.clone() }, 0.03, 0.05);
            let forced = Parameters {
                static_friction: 0.1,
                law: VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 3.0 }),
                damping_ratio: 0.1,
                forcing: Some(Forcing { amplitude: 0.4, frequency: 0.6 }),
                ..base.clone()
            };
            let [_, _, reverse] = jumping(forced.clone(), 0.01, 0.2);
            assert!(reverse >= 4, "{reverse} reversals");
            let gentle = Parameters { forcing: Some(Forcing { amplitude: 0.15, frequency: 0.5 }), ..forced };
            let [detach, restick, _] = jumping(gentle, 0.01, 0.2);
            assert!(detach >= 4 && restick >= 4);
        }
    }
}
