//! Runge–Kutta steps as polynomials.
//!
//! A step yields polynomials of W, e and S like a Taylor series does, so the same search for events applies to them.
//! They are the Hermite polynomials through values and derivatives at both ends. The derivatives come from the Taylor
//! recurrence at the two ends; their number keeps the error of the polynomial below the error of the step.

use asperity_base::choice::Choice;
use serde::{Deserialize, Serialize};

use super::VibrationError;
use super::series::{Series, root};
use super::tableau::{DORMAND_PRINCE, ErrorEstimate, FEHLBERG, Tableau};
use super::weakening::{CONTINUATION, Loading, Weakening};

/// Integration method of slip. All methods find events on the polynomials of the steps, to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Integrator {
    /// Taylor series of up to 24 terms, whose dropped terms are below about 10⁻¹⁴ of the state: the fastest method.
    #[default]
    Taylor,
    /// Fehlberg's method of orders 4 and 5, as in the paper.
    RungeKuttaFehlberg {
        /// Error of one step in W = |v_rel|/V and e, relative to the larger of them or 1: 10⁻¹⁴ … 0.01.
        tolerance: f64,
    },
    /// Dormand and Prince's method of order 8.
    DormandPrince {
        /// Error of one step, as above.
        tolerance: f64,
    },
}

impl Choice for Integrator {
    const NOUN: &'static str = "integrator";
    const ALL: &'static [Self] =
        &[Self::Taylor, Self::RungeKuttaFehlberg { tolerance: 1e-10 }, Self::DormandPrince { tolerance: 1e-12 }];

    fn name(self) -> &'static str {
        match self {
            Self::Taylor => "taylor",
            Self::RungeKuttaFehlberg { .. } => "runge_kutta_fehlberg",
            Self::DormandPrince { .. } => "dormand_prince",
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::Taylor => "Taylor series: exact to rounding, and the fastest",
            Self::RungeKuttaFehlberg { .. } => {
                "Fehlberg's method of orders 4 and 5, the paper's, with an error of 1e-10 a step"
            }
            Self::DormandPrince { .. } => "Dormand and Prince's method of order 8, with an error of 1e-12 a step",
        }
    }
}

/// Largest number of attempts at a step.
const MAX_TRIES: usize = 200;
const FIRST_STEP: f64 = 0.05;
/// Bounds of the change of the step size, and the safety factor.
const LEAST_CHANGE: f64 = 0.2;
const MOST_CHANGE: f64 = 5.0;
const SAFETY: f64 = 0.9;

impl Integrator {
    /// Returns the integrator; fails if a tolerance is out of range.
    pub(super) fn stepper(self) -> Result<Option<Stepper>, VibrationError> {
        let (tableau, tolerance) = match self {
            Self::Taylor => return Ok(None),
            Self::RungeKuttaFehlberg { tolerance } => (&FEHLBERG, tolerance),
            Self::DormandPrince { tolerance } => (&DORMAND_PRINCE, tolerance),
        };
        if !(1e-14..=0.01).contains(&tolerance) {
            let wanted = "between 1e-14 and 0.01";
            return Err(VibrationError::Parameter { parameter: "tolerance", value: tolerance, wanted });
        }
        Ok(Some(Stepper { tableau, tolerance, step: FIRST_STEP }))
    }
}

/// Runge–Kutta method with its step size.
#[derive(Debug, Clone)]
pub(super) struct Stepper {
    tableau: &'static Tableau,
    tolerance: f64,
    step: f64,
}

impl Stepper {
    /// Writes a step from (w, e) of at most `wanted` into the series. Returns its length, or none if no step is small
    /// enough.
    pub(super) fn step(
        &mut self,
        series: &mut Series,
        weakening: &Weakening,
        loading: &Loading,
        (w, e): (f64, f64),
        wanted: f64,
    ) -> Option<f64> {
        for _ in 0..MAX_TRIES {
            let h = self.step.min(wanted);
            let Some((end, error)) = self.attempt(weakening, loading, [w, e, 0.0], h) else {
                self.step = 0.5 * h;
                continue;
            };
            let allowed = self.tolerance * w.abs().max(e.abs()).max(1.0);
            let change = SAFETY * root(allowed / error.max(f64::MIN_POSITIVE), self.tableau.order);
            let next = h * change.clamp(LEAST_CHANGE, MOST_CHANGE);
            if error <= allowed {
                // A shortened step is no reason to reduce the step size.
                self.step = if h < self.step { next.max(self.step) } else { next };
                series.interpolate(weakening, loading, (w, e), end, h, self.tableau.order / 2 + 1);
                return Some(h);
            }
            self.step = next;
        }
        None
    }

    /// Returns (W, e, S) after h and the estimated error of W and e; none if the law has no value at a stage.
    fn attempt(&self, weakening: &Weakening, loading: &Loading, start: [f64; 3], h: f64) -> Option<([f64; 3], f64)> {
        let mut slopes = [[0.0; 3]; 12];
        let sum = |weights: &[f64], slopes: &[[f64; 3]; 12]| -> [f64; 3] {
            std::array::from_fn(|i| weights.iter().zip(slopes).map(|(weight, slope)| weight * slope[i]).sum())
        };
        for (stage, (weights, node)) in self.tableau.stages.iter().zip(self.tableau.nodes).enumerate() {
            let moved = sum(weights, &slopes);
            let [w, e, _] = std::array::from_fn(|i| start[i] + h * moved[i]);
            if !(w.is_finite() && e.is_finite() && weakening.curvature_of(w) > CONTINUATION) {
                return None;
            }
            slopes[stage] = [weakening.acceleration(w, e), loading.later(node * h).rate(w), w];
        }
        let moved = sum(self.tableau.weights, &slopes);
        let end = std::array::from_fn(|i| start[i] + h * moved[i]);
        let size = |weights: &[f64]| {
            let [w, e, _] = sum(weights, &slopes);
            h * w.abs().max(e.abs())
        };
        let error = match self.tableau.error {
            ErrorEstimate::Difference(weights) => size(weights),
            ErrorEstimate::Pair(five, three) => {
                let (five, three) = (size(five), size(three));
                let both = (five * five + 0.01 * three * three).sqrt();
                if both > 0.0 { five * five / both } else { 0.0 }
            }
        };
        (end.iter().all(|y| y.is_finite()) && weakening.curvature_of(end[0]) > CONTINUATION).then_some((end, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use crate::{
        Drive, EventKind, Forcing, FrictionTable, Oscillator, Parameters, Trajectory, TrajectorySettings, VelocityLaw,
    };
    use asperity_process::{Fluctuation, FrictionProcess, ProcessModel, RecordedProcess, Steady};

    const FEHLBERG_AT: fn(f64) -> Integrator = |tolerance| Integrator::RungeKuttaFehlberg { tolerance };
    const DORMAND_PRINCE_AT: fn(f64) -> Integrator = |tolerance| Integrator::DormandPrince { tolerance };

    /// Returns a forced slip of the paper's law away from events.
    fn slip() -> (Weakening, Loading) {
        let oscillator = Oscillator::with_stribeck(0.3, 4.2, 0.1, 0.2).unwrap();
        let loading = Loading { base: 1.0, kappa: 1.2, swing: 0.3, frequency: 0.8, phase: 0.4 };
        (Weakening::new(&oscillator), loading)
    }

    /// Returns the state after a time by Taylor series.
    fn exact(time: f64) -> [f64; 3] {
        let (weakening, loading) = slip();
        let mut series = Series::new();
        let (mut w, mut e, mut s) = (1.0, 0.5, 0.0);
        for i in 0..200 {
            let h = time / 200.0;
            series.expand(&weakening, &loading.later(f64::from(i) * h), w, e, 1.0);
            s += series.distance(h).0;
            (w, e) = series.state(h);
        }
        [w, e, s]
    }

    #[test]
    fn the_observed_orders_between_events_are_the_nominal_ones() {
        let (weakening, loading) = slip();
        let time = 2.0;
        let wanted = exact(time);
        for (tableau, steps) in [(&FEHLBERG, 40), (&DORMAND_PRINCE, 10)] {
            let stepper = Stepper { tableau, tolerance: 1.0, step: 1.0 };
            let error = |steps: u32| {
                let h = time / f64::from(steps);
                let mut state = [1.0, 0.5, 0.0];
                for i in 0..steps {
                    state = stepper.attempt(&weakening, &loading.later(f64::from(i) * h), state, h).unwrap().0;
                }
                (0..3).map(|i| (state[i] - wanted[i]).abs()).fold(0.0, f64::max)
            };
            let order = (error(steps) / error(2 * steps)).log2();
            let nominal = tableau.order as f64;
            assert!((order - nominal).abs() < 0.05 * nominal, "observed order {order:.3} of {nominal}");
        }
    }

    #[test]
    fn the_polynomials_of_a_step_are_as_accurate_as_its_end() {
        let (weakening, loading) = slip();
        for tableau in [&FEHLBERG, &DORMAND_PRINCE] {
            let error = |h: f64| {
                let mut stepper = Stepper { tableau, tolerance: 1.0, step: h };
                let mut series = Series::new();
                stepper.step(&mut series, &weakening, &loading, (1.0, 0.5), h).unwrap();
                let within = (1..=8).map(|i| {
                    let t = f64::from(i) / 8.0 * h;
                    let ((w, e), s, [a, b, c]) = (series.state(t), series.distance(t).0, exact(t));
                    (w - a).abs().max((e - b).abs()).max((s - c).abs())
                });
                within.fold(0.0, f64::max)
            };
            let order = (error(0.8) / error(0.4)).log2();
            assert!(order > 0.93 * (tableau.order + 1) as f64, "local order {order:.3} of {}", tableau.order);
        }
    }

    fn differences(
        parameters: Parameters,
        process: &impl Fn() -> Box<dyn Fluctuation>,
        method: Integrator,
    ) -> [f64; 4] {
        let oscillator = Oscillator::new(parameters).unwrap();
        let mut settings = TrajectorySettings { duration: 40.0, start: None, drive: Drive::Distance, method };
        let mut worst = [0.0_f64; 4];
        for drive in [Drive::Distance, Drive::Time] {
            settings.drive = drive;
            let events = |method| {
                let settings = TrajectorySettings { method, ..settings };
                Trajectory::simulate(&oscillator, &mut *process(), &settings).unwrap().events
            };
            let (found, wanted) = (events(method), events(Integrator::Taylor));
            assert!(
                wanted.len() > 6 && found.len() == wanted.len(),
                "{method:?} {oscillator:?}: {} and {}",
                found.len(),
                wanted.len()
            );
            for (a, b) in found.iter().zip(&wanted) {
                assert_eq!(a.kind, b.kind);
                let changes = [a.tau - b.tau, a.displacement - b.displacement, a.sliding_distance - b.sliding_distance];
                for (worst, change) in worst.iter_mut().zip(changes) {
                    *worst = worst.max(change.abs());
                }
                worst[3] += f64::from(u8::from(a.kind == EventKind::Reverse));
            }
        }
        worst
    }

    #[test]
    fn all_methods_find_the_same_events() {
        let base = Parameters {
            static_friction: 0.1,
            law: VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }),
            damping_ratio: 0.02,
            belt_velocity: 0.05,
            forcing: None,
        };
        let table = FrictionTable::new(&[[0.0, 0.1], [0.03, 0.08], [0.06, 0.075], [0.1, 0.08]]).unwrap();
        let laws = [
            base.law.clone(),
            VelocityLaw::Coulomb(Coulomb { kinetic: 0.05 }),
            VelocityLaw::Linear(Linear { kinetic: 0.09, slope: 0.1 }),
            VelocityLaw::Exponential(Exponential { kinetic: 0.1, high_speed: 0.07, stribeck_velocity: 0.05 }),
            VelocityLaw::Tabulated(table),
        ];
        let model =
            ProcessModel { steps_per_length: 4, ..ProcessModel::new("beta:2.1,5".parse().unwrap(), 0.002, 0.05) };
        let random = FrictionProcess::new(model).unwrap();
        let mut path = random.path(11, 0);
        let values: Vec<f64> = (0..4000).map(|_| path.next_value()).collect();
        let record: &'static RecordedProcess =
            Box::leak(Box::new(RecordedProcess::new(random.step(), values).unwrap()));
        let mut reversals = 0.0;
        for (amplitude, frequency) in [(0.0, 1.0), (0.01, 0.9), (0.4, 0.6)] {
            for law in &laws {
                let forcing = Some(Forcing { amplitude, frequency });
                let parameters = Parameters { law: law.clone(), forcing, ..base.clone() };
                for noisy in [false, true] {
                    let process =
                        || -> Box<dyn Fluctuation> { if noisy { Box::new(record.path()) } else { Box::new(Steady) } };
                    // Errors of steps accumulate; a slip that barely starts, or grazes, amplifies them to their square
                    // root.
                    for (method, allowed) in [(DORMAND_PRINCE_AT(1e-13), 1e-8), (FEHLBERG_AT(1e-11), 1e-6)] {
                        let [tau, x, s, turns] = differences(parameters.clone(), &process, method);
                        assert!(
                            tau.max(x).max(s) < allowed,
                            "{method:?} {law:?} {amplitude} {noisy}: {tau:e} {x:e} {s:e}"
                        );
                        reversals += turns;
                    }
                }
            }
        }
        assert!(reversals > 100.0, "{reversals} reversals");
    }

    #[test]
    fn errors_follow_the_tolerance_and_invalid_tolerances_are_refused() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let period = |method| {
            let settings = TrajectorySettings { duration: 66.0, start: None, drive: Drive::Distance, method };
            let events = Trajectory::simulate(&oscillator, Steady, &settings)?.events;
            let detached: Vec<f64> = events.iter().filter(|e| e.kind == EventKind::Detach).map(|e| e.tau).collect();
            Ok::<f64, VibrationError>((detached[10] - detached[0]) / 10.0)
        };
        for make in [FEHLBERG_AT, DORMAND_PRINCE_AT] {
            for tolerance in [1e-5, 1e-7, 1e-9, 1e-11] {
                let error = (period(make(tolerance)).unwrap() / 6.372_163_483_739_709 - 1.0).abs();
                assert!(error < 30.0 * tolerance, "{tolerance:e}: {error:e}");
            }
            for tolerance in [0.0, 1.0, f64::NAN] {
                assert!(matches!(period(make(tolerance)), Err(VibrationError::Parameter { .. })));
            }
        }
        let text = serde_json::to_string(&Integrator::DormandPrince { tolerance: 1e-9 }).unwrap();
        assert_eq!(text, r#"{"dormand_prince":{"tolerance":1e-9}}"#);
        assert_eq!(serde_json::from_str::<Integrator>(r#""taylor""#).unwrap(), Integrator::Taylor);
    }
}
