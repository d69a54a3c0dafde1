//! Kinds of vibration, compared with an independent integrator: the classical Runge–Kutta method in small fixed steps,
//! with events by bisection.

use asperity_base::monitor::Silent;
use asperity_process::{FrictionProcess, ProcessModel};
use asperity_vibration::{
    Ensemble, EnsembleSettings, FrictionTable, MotionKind, Oscillator, Parameters, VelocityLaw, limit_cycle,
};

/// Belt velocity of the published cycles.
#[expect(clippy::approx_constant, reason = "a published number, which is not π")]
const PUBLISHED_VELOCITY: f64 = 3.1416;
const STEP: f64 = 0.02;
/// Longest period in the search.
const LONGEST: f64 = 60.0;

/// State of the slow integration; in stick the velocity is the velocity of the belt.
struct Slow<'a> {
    oscillator: &'a Oscillator,
    tau: f64,
    x: f64,
    velocity: f64,
    /// Sign of V − X′, 0 in stick.
    sign: f64,
}

/// Results of the last part of the slow integration.
#[derive(Debug, Default)]
struct Seen {
    sticks: Vec<f64>,
    /// Times at which over-slip ends without stick.
    returns: Vec<f64>,
    /// Times at which X′ rises through zero, and the least X′ before each.
    turns: Vec<(f64, f64)>,
}

impl Slow<'_> {
    fn rate(&self, [x, velocity]: [f64; 2]) -> [f64; 2] {
        let relative = self.sign * (self.oscillator.belt_velocity() - velocity);
        let friction = self.sign * self.oscillator.law().coefficient(relative.max(0.0));
        [velocity, friction - x - 2.0 * self.oscillator.damping_ratio() * velocity]
    }

    fn advanced(&self, h: f64) -> [f64; 2] {
        let y = [self.x, self.velocity];
        let add = |k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        let k1 = self.rate(y);
        let k2 = self.rate(add(k1, 0.5 * h));
        let k3 = self.rate(add(k2, 0.5 * h));
        let k4 = self.rate(add(k3, h));
        std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// Simulates the mass from stick to `end` and records from `from` on.
    fn run(mut self, from: f64, end: f64) -> Seen {
        let (belt, limit) = (self.oscillator.belt_velocity(), self.oscillator.static_friction());
        let drag = 2.0 * self.oscillator.damping_ratio() * belt;
        let mut seen = Seen::default();
        let mut slowest = f64::INFINITY;
        while self.tau < end {
            if self.sign == 0.0 {
                // Without forcing the mass leaves the belt at the positive limit.
                self.tau += (limit - drag - self.x) / belt;
                (self.x, self.sign) = (limit - drag, 1.0);
                // The first step leaves v_rel = 0 in the direction of slip, for any size of the force.
                [self.x, self.velocity] = self.advanced(STEP);
                self.tau += STEP;
                continue;
            }
            let (mut low, mut high) = (0.0, STEP);
            let passes = |slow: &Self, h: f64| slow.sign * (belt - slow.advanced(h)[1]) < 0.0;
            let arrives = passes(&self, STEP);
            while arrives && high - low > 1e-15 {
                let middle = 0.5 * (low + high);
                if passes(&self, middle) { high = middle } else { low = middle }
            }
            let [x, velocity] = self.advanced(high);
            slowest = slowest.min(velocity);
            if self.velocity < 0.0 && velocity >= 0.0 {
                if self.tau > from {
                    seen.turns.push((self.tau + high * self.velocity / (self.velocity - velocity), slowest));
                }
                slowest = f64::INFINITY;
            }
            (self.tau, self.x, self.velocity) = (self.tau + high, x, velocity);
            if !arrives {
                continue;
            }
            self.velocity = belt;
            let before = self.sign;
            self.sign = if (self.x + drag).abs() <= limit { 0.0 } else { (self.x + drag).signum() };
            if self.tau > from {
                match (self.sign == 0.0, before < 0.0) {
                    (true, _) => seen.sticks.push(self.tau),
                    (false, true) => seen.returns.push(self.tau),
                    (false, false) => {}
                }
            }
        }
        seen
    }
}

/// Returns the kind and the period of the motion that starts in stick, after the time `settle`.
fn slow(oscillator: &Oscillator, settle: f64) -> (MotionKind, Option<f64>) {
    let start =
        Slow { oscillator, tau: 0.0, x: oscillator.default_start(), velocity: oscillator.belt_velocity(), sign: 0.0 };
    let seen = start.run(settle, settle + LONGEST);
    let period =
        |times: &[f64]| (times.len() > 1).then(|| (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64);
    let swing = seen.turns.last().map_or(0.0, |(_, slowest)| -slowest / oscillator.belt_velocity());
    if !seen.sticks.is_empty() {
        (MotionKind::StickSlip, period(&seen.sticks))
    } else if !seen.returns.is_empty() {
        (MotionKind::Overtaking, period(&seen.returns))
    } else if swing > 0.01 {
        let times: Vec<f64> = seen.turns.iter().map(|turn| turn.0).collect();
        (MotionKind::SlipCycle, period(&times))
    } else {
        (MotionKind::None, None)
    }
}

fn process(std: f64, length: f64) -> FrictionProcess {
    FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), std, length)).unwrap()
}

/// Simulates an ensemble with very little fluctuation.
fn ensemble(oscillator: &Oscillator, duration: f64) -> Ensemble {
    let (velocity, friction) = (oscillator.belt_velocity(), oscillator.static_friction());
    let settings = EnsembleSettings { sample_capacity: 100, ..EnsembleSettings::new(4, duration, 3) };
    Ensemble::simulate(oscillator, &process(1e-7 * friction, 10.0 * velocity), &settings, &Silent).unwrap()
}

/// Asserts that the library finds the kind and period of the slow integration, and that an ensemble counts vibration as
/// vibration.
fn agree(oscillator: &Oscillator, settle: f64) -> MotionKind {
    let (kind, period) = slow(oscillator, settle);
    assert_eq!(limit_cycle(oscillator).unwrap().kind(), kind, "{oscillator:?}");
    if let (Some(cycle), Some(period)) = (limit_cycle(oscillator).unwrap().cycle(), period) {
        assert!((cycle.period / period - 1.0).abs() < 2e-5, "{cycle:?} and {period}: {oscillator:?}");
    }
    let found = ensemble(oscillator, 400.0 + settle);
    let vibrates = if kind.is_vibration() { 1.0 } else { 0.0 };
    assert_eq!(found.passages.sustained.value, vibrates, "{kind}: {oscillator:?}");
    assert_eq!(found.passages.late_share.mean, vibrates, "{kind}: {oscillator:?}");
    if let Some(period) = period {
        assert_eq!(found.passages.left.value, 0.0);
        assert!(
            (found.periods.mean / period - 1.0).abs() < 0.02,
            "{} and {period}: {oscillator:?}",
            found.periods.mean
        );
    }
    let shares = &found.passages.kinds;
    let most = shares.iter().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    assert_eq!(*most.0, kind, "{shares:?}: {oscillator:?}");
    assert!((shares.values().sum::<f64>() - 1.0).abs() < 1e-12);
    kind
}

#[test]
fn the_published_cycles_overtake_the_belt_without_stick_and_count_as_vibration() {
    for (damping, kind, period) in [
        (0.001, MotionKind::Overtaking, 6.294_67),
        (0.002, MotionKind::Overtaking, 6.294_99),
        (0.004, MotionKind::StickSlip, 6.295_32),
    ] {
        let oscillator = Oscillator::with_stribeck(0.432_353, 4.2, damping, PUBLISHED_VELOCITY).unwrap();
        assert_eq!(agree(&oscillator, 2000.0), kind);
        let (_, slow) = slow(&oscillator, 5000.0);
        for found in [slow.unwrap(), limit_cycle(&oscillator).unwrap().cycle().unwrap().period] {
            assert!((found - period).abs() < 6e-6, "{found} instead of {period}");
        }
        // Every turn is a slip that reaches a negative velocity.
        let found = ensemble(&oscillator, 1000.0);
        assert!((found.cycles_deterministic as f64 - 1000.0 / period).abs() < 3.0, "{}", found.cycles_deterministic);
        assert!((found.cycles.mean - found.cycles_deterministic as f64).abs() <= 1.0, "{:?}", found.cycles);
    }
}

#[test]
fn kinds_and_periods_match_an_independent_integrator() {
    let mut kinds = [0; MotionKind::ALL.len()];
    for decay in [1.0, 4.2, 12.0] {
        for velocity in [0.05, 1.0, 4.0] {
            for damping in [0.001, 0.003, 0.05, 0.3] {
                let oscillator = Oscillator::with_stribeck(0.4, decay, damping, velocity).unwrap();
                kinds[agree(&oscillator, 1500.0) as usize] += 1;
            }
        }
    }
    assert!(kinds[0] >= 5 && kinds[1] >= 3 && kinds[MotionKind::None as usize] >= 5, "{kinds:?}");
}

#[test]
fn slip_cycles_count_as_vibration_and_noise_about_steady_sliding_does_not() {
    let law = |v: f64| 0.3 + 0.1 * (-(v / 0.08).powi(2)).exp();
    let points: Vec<[f64; 2]> = (0..=80).map(|i| 0.005 * f64::from(i)).map(|v| [v, law(v)]).collect();
    let table = FrictionTable::new(&points).unwrap();
    let machine = |damping_ratio| {
        let (static_friction, law) = (0.4, VelocityLaw::Tabulated(table.clone()));
        Oscillator::new(Parameters { static_friction, law, damping_ratio, belt_velocity: 0.056, forcing: None })
            .unwrap()
    };
    // ζ_c = .418 and ζ_H = .536.
    for (damping, kind) in [
        (0.3, MotionKind::StickSlip),
        (0.45, MotionKind::SlipCycle),
        (0.5, MotionKind::SlipCycle),
        (0.6, MotionKind::None),
    ] {
        let oscillator = machine(damping);
        assert_eq!(agree(&oscillator, 600.0), kind);
        // Noise of a hundredth of the friction neither turns steady sliding into vibration nor ends a slip cycle.
        let settings = EnsembleSettings { sample_capacity: 0, ..EnsembleSettings::new(8, 600.0, 5) };
        let noisy = Ensemble::simulate(&oscillator, &process(0.002, 0.02), &settings, &Silent).unwrap();
        let share = noisy.passages.late_share.mean;
        assert!(if kind.is_vibration() { share > 0.99 } else { share < 0.01 }, "{kind}: {share}");
    }
}
