//! Random machines, friction processes and starts over the whole allowed range, including unusual values.

use rand::RngExt;

use super::super::{
    Drive, Forcing, FrictionTable, Integrator, Oscillator, Parameters, TrajectorySettings, VelocityLaw,
};
use asperity_base::random;
use asperity_process::{CorrelationShape, FrictionProcess, Generator, ProcessModel, TranslationKind};

/// Approximate largest number of grid points per motion, and the duration below which more are allowed.
const MOST_GRID_POINTS: f64 = 5_000.0;
const LEAST_DURATION: f64 = 10.0;

/// Machine, process and settings of a test case.
pub(super) struct Case {
    pub(super) oscillator: Oscillator,
    pub(super) process: FrictionProcess,
    pub(super) settings: TrajectorySettings,
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} {:?} {:?}", self.oscillator.parameters(), self.process.model(), self.settings)
    }
}

/// Generator of uniform choices.
struct Draw(random::Stream);

impl Draw {
    fn chance(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Returns 10 to the power of a uniform number between `low` and `high`.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(self.between(low, high))
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.0.random::<f64>() * choices.len() as f64) as usize]
    }

    fn law(&mut self, kinetic: f64, fastest: f64) -> VelocityLaw {
        match self.one_of(&[0, 1, 2, 2, 3, 4]) {
            0 => VelocityLaw::Coulomb { kinetic },
            1 => {
                let slope = if self.chance(0.1) { 0.0 } else { kinetic / fastest * self.decades(-2.0, 0.1) };
                VelocityLaw::Linear { kinetic, slope }
            }
            2 => {
                let decay = if self.chance(0.1) { 0.0 } else { self.decades(-1.0, 3.0) };
                VelocityLaw::Stribeck { kinetic, decay }
            }
            3 => VelocityLaw::Exponential {
                kinetic,
                high_speed: kinetic * self.between(0.1, 1.0),
                stribeck_velocity: fastest * self.decades(-2.0, 0.5),
            },
            _ => {
                let mut speed = 0.0;
                let points: Vec<_> = (0..self.one_of(&[2, 3, 5, 9]))
                    .map(|i| {
                        let point = [speed, if i == 0 { kinetic } else { kinetic * self.between(0.3, 1.1) }];
                        speed += fastest * self.decades(-2.0, 0.0);
                        point
                    })
                    .collect();
                VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap())
            }
        }
    }

    fn parameters(&mut self) -> Parameters {
        let static_friction = self.decades(-2.0, 0.0);
        let kinetic = static_friction * if self.chance(0.4) { 1.0 } else { self.between(0.3, 1.0) };
        let belt_velocity = self.decades(-5.0, 0.0);
        let law = self.law(kinetic, belt_velocity + static_friction);
        let damping_ratio = match self.one_of(&[0, 1, 1, 1, 2, 2, 2, 3]) {
            0 => 0.0,
            1 => self.decades(-4.0, -1.0),
            2 => self.between(0.0, 0.5),
            _ => self.decades(-0.3, 1.0),
        };
        let forcing = self.chance(0.35).then(|| Forcing {
            amplitude: static_friction * self.decades(-3.0, 0.5),
            frequency: self.decades(-1.0, 1.0),
        });
        Parameters { static_friction, law, damping_ratio, belt_velocity, forcing }
    }

    /// Returns a process with a standard deviation from zero to more than friction allows.
    fn model(&mut self, kinetic: f64, speed: f64) -> ProcessModel {
        let exponential = CorrelationShape::Exponential;
        let length = self.decades(-4.0, 1.0);
        let (generator, shape) = match self.one_of(&[0, 0, 0, 1, 2, 2, 3, 4, 4]) {
            0 => (Generator::Autoregressive, exponential),
            1 => {
                let window = length * self.decades(-0.5, 0.5);
                (Generator::Autoregressive, CorrelationShape::WindowedExponential { window })
            }
            2 => {
                let smooth = [exponential, CorrelationShape::SquaredExponential, CorrelationShape::Matern { nu: 1.5 }];
                (Generator::Spectral { harmonics: self.one_of(&[4, 16]) }, self.one_of(&smooth))
            }
            3 => (Generator::Jacobi, exponential),
            _ => (Generator::Renewal, exponential),
        };
        let (law, lowest) = match generator {
            Generator::Jacobi => ("beta:2.1,5", 1.844),
            _ => self.one_of(&[
                ("beta:2.1,5", 1.844),
                ("beta:2.1,5", 1.844),
                ("beta:1,1", 1.733),
                ("normal", 4.0),
                ("lognormal:0,0.4", 2.4),
            ]),
        };
        let mildest = self.one_of(&[-5.0, -1.5]);
        let std = kinetic / lowest * self.decades(mildest, 0.1);
        let steps_per_length = match generator {
            Generator::Jacobi => self.one_of(&[4, 20]),
            // Motions pass thousands of short correlation lengths.
            _ if length * MOST_GRID_POINTS < 2.0 * LEAST_DURATION * speed => self.one_of(&[1, 2]),
            _ => self.one_of(&[1, 2, 5, 20, 80]),
        };
        ProcessModel {
            shape,
            generator,
            steps_per_length,
            correlation: if self.chance(0.3) { TranslationKind::Corrected } else { TranslationKind::Plain },
            least: self.chance(0.4).then(|| -0.5 * kinetic * self.between(0.01, 1.0)),
            ..ProcessModel::new(law.parse().unwrap(), std, length)
        }
    }
}

/// Returns case `index` under `seed`.
pub(super) fn case(seed: u64, index: u64) -> Case {
    let mut draw = Draw(random::stream(seed, "robustness of stick-slip", index));
    let parameters = draw.parameters();
    let (static_friction, velocity) = (parameters.static_friction, parameters.belt_velocity);
    // Approximate sliding speed: the mass slips about as fast as static friction pulls it.
    let drive = draw.one_of(&[Drive::Distance, Drive::Distance, Drive::Time]);
    let push = parameters.forcing.map_or(0.0, |forcing| forcing.amplitude);
    let speed = velocity + if drive == Drive::Distance { 0.3 * (static_friction + push) } else { 0.0 };
    let process = FrictionProcess::new(draw.model(parameters.law.kinetic(), speed)).unwrap();
    // Renewal processes have no grid points except their jumps.
    let spacing = match process.model().generator {
        Generator::Renewal => process.model().correlation_length,
        _ => process.step(),
    };
    let duration = draw.decades(1.0, 3.0).min((MOST_GRID_POINTS * spacing / speed).max(LEAST_DURATION));
    let start = draw.chance(0.3).then(|| static_friction * draw.between(-2.0, 2.0));
    let oscillator = Oscillator::new(parameters).unwrap();
    Case { oscillator, process, settings: TrajectorySettings { duration, start, drive, method: Integrator::Taylor } }
}
