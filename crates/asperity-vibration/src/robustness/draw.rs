//! Random machines, friction processes and starts, including unusual values. Every fourth case draws friction, damping
//! and belt velocity over the whole allowed range, the others over the range of real machines.

use crate::law::{Coulomb, Exponential, Linear, Stribeck};
use rand::RngExt;

use super::super::{Drive, Forcing, FrictionTable, Oscillator, Parameters, TrajectorySettings, VelocityLaw};
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

impl Case {
    /// Returns the case with all lengths, velocities and forces multiplied by `factor`; none if a parameter leaves its
    /// range.
    pub(super) fn scaled(&self, factor: f64) -> Option<Self> {
        let old = self.oscillator.parameters();
        // f·μ(|v|/f).
        let law = old.law.with_coefficients(|coefficient| factor * coefficient).ok()?;
        let law = if law.is_linear() { law } else { law.rescaled(1.0 / factor) };
        let parameters = Parameters {
            static_friction: factor * old.static_friction,
            law,
            damping_ratio: old.damping_ratio,
            belt_velocity: factor * old.belt_velocity,
            forcing: old.forcing.map(|forcing| Forcing { amplitude: factor * forcing.amplitude, ..forcing }),
        };
        let model = self.process.model().clone();
        let shape = match model.shape {
            CorrelationShape::WindowedExponential { window } => {
                CorrelationShape::WindowedExponential { window: factor * window }
            }
            shape => shape,
        };
        let process = FrictionProcess::new(ProcessModel {
            shape,
            std: factor * model.std,
            correlation_length: factor * model.correlation_length,
            least: model.least.map(|least| factor * least),
            ..model
        });
        let settings = TrajectorySettings { start: self.settings.start.map(|x| factor * x), ..self.settings };
        Some(Self { oscillator: Oscillator::new(parameters).ok()?, process: process.ok()?, settings })
    }
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} {:?} {:?}", self.oscillator.parameters(), self.process.model(), self.settings)
    }
}

/// Belt velocity divided by static friction in wide cases, as powers of ten.
const WIDE_RATIO: [f64; 2] = [-12.0, 6.0];
/// Longest time in which the belt stretches the spring to the stick limit, in motions that follow it. A mass that never
/// sticks again takes at least one step per unit of time.
const LONGEST_STRETCH: f64 = 1e5;
/// Least correlation length; processes with grid points less than 1e-15 apart are refused.
const LEAST_LENGTH: f64 = 1e-12;
/// Largest 2ζ times the duration: a step is a few units of 1/2ζ long.
const MOST_DECAYS: f64 = 2e4;

/// Generator of uniform choices.
struct Draw {
    stream: random::Stream,
    wide: bool,
}

impl Draw {
    fn chance(&mut self, probability: f64) -> bool {
        self.stream.random::<f64>() < probability
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.stream.random::<f64>()
    }

    /// Returns 10 to the power of a uniform number between `low` and `high`.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(self.between(low, high))
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.stream.random::<f64>() * choices.len() as f64) as usize]
    }

    fn law(&mut self, kinetic: f64, fastest: f64) -> VelocityLaw {
        match self.one_of(&[0, 1, 2, 2, 3, 4]) {
            0 => VelocityLaw::Coulomb(Coulomb { kinetic }),
            1 => {
                let slope = if self.chance(0.1) { 0.0 } else { kinetic / fastest * self.decades(-2.0, 0.1) };
                VelocityLaw::Linear(Linear { kinetic, slope })
            }
            2 => {
                let unit = if self.wide { kinetic } else { 1.0 };
                let decay = if self.chance(0.1) { 0.0 } else { (self.decades(-1.0, 3.0) / unit).min(1e6) };
                VelocityLaw::Stribeck(Stribeck { kinetic, decay })
            }
            3 => VelocityLaw::Exponential(Exponential {
                kinetic,
                high_speed: kinetic * self.between(0.1, 1.0),
                stribeck_velocity: fastest * self.decades(-2.0, 0.5),
            }),
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
        // Kinetic friction is at least 0.3 times as large, and at least 1e-12.
        let static_friction = if self.wide { self.decades(-11.4, 3.0) } else { self.decades(-2.0, 0.0) };
        let kinetic = static_friction * if self.chance(0.4) { 1.0 } else { self.between(0.3, 1.0) };
        let belt_velocity = if self.wide {
            (static_friction * self.decades(WIDE_RATIO[0], WIDE_RATIO[1])).clamp(1e-12, 1e6)
        } else {
            self.decades(-5.0, 0.0)
        };
        let law = self.law(kinetic, belt_velocity + static_friction);
        let damping_ratio = match self.one_of(&[0, 1, 1, 1, 2, 2, 2, 3]) {
            0 => 0.0,
            1 => self.decades(-4.0, -1.0),
            2 => self.between(0.0, 0.5),
            _ => self.decades(-0.3, if self.wide { 3.0 } else { 1.0 }),
        };
        let forcing = self.chance(0.35).then(|| Forcing {
            amplitude: static_friction * self.decades(-3.0, 0.5),
            frequency: self.decades(-1.0, 1.0),
        });
        Parameters { static_friction, law, damping_ratio, belt_velocity, forcing }
    }

    /// Returns a process with a standard deviation from zero to more than friction allows.
    fn model(&mut self, kinetic: f64, speed: f64, unit: f64) -> ProcessModel {
        let exponential = CorrelationShape::Exponential;
        let length = (unit * self.decades(-4.0, 1.0)).max(LEAST_LENGTH);
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
    let mut draw =
        Draw { stream: random::stream(seed, "robustness of stick-slip", index), wide: index.is_multiple_of(4) };
    let parameters = draw.parameters();
    let (static_friction, velocity) = (parameters.static_friction, parameters.belt_velocity);
    let drive = draw.one_of(&[Drive::Distance, Drive::Distance, Drive::Time]);
    let push = parameters.forcing.map_or(0.0, |forcing| forcing.amplitude);
    // A slow belt stretches the spring for a long time, on the scale of which nearly all motion is stick.
    let slow = velocity < static_friction && static_friction < LONGEST_STRETCH * velocity;
    let long = draw.wide && slow && parameters.damping_ratio < 1.0 && draw.chance(0.5);
    // Approximate sliding speed: the mass slips about as fast as static friction pulls it.
    let pulled = if drive == Drive::Distance && !long { 0.3 * (static_friction + push) } else { 0.0 };
    let speed = velocity + pulled;
    let unit = match (draw.wide, long) {
        (false, _) => 1.0,
        (true, false) => speed,
        (true, true) => static_friction,
    };
    let process = FrictionProcess::new(draw.model(parameters.law.kinetic(), speed, unit)).unwrap();
    // Renewal processes have no grid points except their jumps.
    let spacing = match process.model().generator {
        Generator::Renewal => process.model().correlation_length,
        _ => process.step(),
    };
    let (duration, least) = if long {
        let stretch = static_friction / velocity;
        (stretch * draw.decades(0.0, 1.0), 0.1 * stretch)
    } else {
        (draw.decades(1.0, 3.0), LEAST_DURATION)
    };
    let duration = duration.min((MOST_GRID_POINTS * spacing / speed).max(least));
    let damped = 2.0 * parameters.damping_ratio;
    let duration = if draw.wide && !long { duration.min(MOST_DECAYS / damped) } else { duration };
    let start = if draw.wide && draw.chance(0.3) {
        // The belt reaches the stick limit soon.
        Some(static_friction - velocity * (damped + draw.decades(-1.0, 1.0)))
    } else {
        draw.chance(0.3).then(|| static_friction * draw.between(-2.0, 2.0))
    };
    let oscillator = Oscillator::new(parameters).unwrap();
    Case { oscillator, process, settings: TrajectorySettings { duration, start, drive } }
}
