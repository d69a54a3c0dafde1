//! Growth of small motion about steady sliding under fluctuating friction.

use serde::{Deserialize, Serialize};

use super::super::sample_distribution::RunningMoments;
use super::super::{FailedTrajectory, VibrationError, positive};
use super::ensemble::{Runs, run_all};
use super::{Model, modes};
use asperity_base::monitor::Monitor;
use asperity_base::stats::{quantile_sorted, sorted_present, wilson_interval};
use asperity_process::{Cancellable, Cell, Fluctuation, FrictionProcess};

/// Number of coefficients of the series of one step.
const TERMS: usize = 16;
/// Last kept term of a series, relative to the state.
const TOLERANCE: f64 = 1e-17;
/// Size above which a state is scaled back.
const RESCALING_SIZE: f64 = 1e100;

/// Settings of the growth rates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GrowthSettings {
    /// Number of realisations, at least 2.
    pub trajectories: usize,
    /// Time τ over which growth is measured.
    pub duration: f64,
    /// Time before the measurement, in which the motion turns into the fastest-growing mode.
    pub settling: f64,
    /// Seed; realisation i is the one of the friction process.
    pub seed: u64,
    /// Least fraction of valid realisations.
    pub least_valid_share: f64,
}

/// Distribution of the growth rate of small motion (finite-time Lyapunov exponents) over realisations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GrowthRates {
    /// μ of steady sliding.
    pub friction: f64,
    /// Largest growth rate without fluctuation.
    pub deterministic: f64,
    /// Mean rate: the Lyapunov exponent, except for an end effect of the order of 1/duration.
    pub mean: f64,
    /// Standard deviation over realisations, divisor n − 1.
    pub std: f64,
    /// Standard error of the mean.
    pub se: f64,
    /// Quantiles of the rates at 5, 50 and 95 %.
    pub quantiles: [f64; 3],
    /// Fraction of the realisations in which motion grows.
    pub growing: f64,
    /// 95 % interval of that fraction (Wilson).
    pub growing_interval: [f64; 2],
    /// Realisations that failed.
    pub failures: Vec<FailedTrajectory>,
}

/// Returns growth rates of small motion about steady sliding at the friction coefficient μ under m(s), s = Vτ.
///
/// A small motion ξ along the belt shifts the position at which friction is evaluated, m(Vτ − ξ). Linearised, this
/// stiffens the mass by m′·n, with n the steady normal force:
///
/// ξ″ + c₁₁ξ′ + c₁₂η′ + (k₁₁ + m′n)ξ + (k₁₂ − (μ + m)k₃)η = 0,  η″ + c₁₂ξ′ + c₂₂η′ + k₁₂ξ + k₂₂η = 0.
///
/// The rate is the growth rate of √E over the duration, with the energy E = ½(ξ′² + η′²) + ½(ξ, η)·K(0)(ξ, η). The
/// force m·n is left out: it excites the mass but does not make motion grow. The result does not depend on the number
/// of threads.
///
/// Fails if steady sliding does not exist, if settings are out of range, if too few realisations are valid (the
/// friction coefficient must stay positive), or when cancelled.
///
/// # References
/// Arnold, *Random Dynamical Systems*, Springer (1998), for Lyapunov exponents of linear systems driven by noise.
pub fn growth_rates(
    model: &Model,
    friction: f64,
    process: &FrictionProcess,
    settings: &GrowthSettings,
    monitor: &dyn Monitor,
) -> Result<GrowthRates, VibrationError> {
    let GrowthSettings { trajectories, duration, settling, seed, least_valid_share } = *settings;
    let system = Linear::new(model, friction, duration, settling)?;
    let run = |index| system.rate(Cancellable::new(process.path(seed, index), monitor));
    let Runs { values: rates, failures } = run_all(trajectories, least_valid_share, monitor, run)?;
    let mut sums = RunningMoments::EMPTY;
    rates.iter().for_each(|rate| sums.add(*rate));
    let growing = rates.iter().filter(|rate| **rate > 0.0).count();
    let interval = wilson_interval(growing, rates.len());
    let deterministic = modes(model, friction).iter().map(|mode| mode.growth).fold(f64::NEG_INFINITY, f64::max);
    let (mean, std, n) = (sums.mean(), sums.std(), rates.len() as f64);
    let sorted = sorted_present(rates);
    Ok(GrowthRates {
        friction,
        deterministic,
        mean,
        std,
        se: std / n.sqrt(),
        quantiles: [0.05, 0.5, 0.95].map(|probability| quantile_sorted(&sorted, probability)),
        growing: growing as f64 / n,
        growing_interval: [interval.low, interval.high],
        failures,
    })
}

/// Linearised equations of motion.
#[derive(Debug, Clone, Copy)]
struct Linear {
    stiffness: [f64; 3],
    /// c₁₁ with the weakening of friction, c₁₂, c₂₂.
    damping: [f64; 3],
    contact: f64,
    normal_force: f64,
    velocity: f64,
    friction: f64,
    duration: f64,
    settling: f64,
}

impl Linear {
    fn new(model: &Model, friction: f64, duration: f64, settling: f64) -> Result<Self, VibrationError> {
        positive("duration", duration)?;
        positive("friction coefficient", friction)?;
        super::super::non_negative("settling time", settling)?;
        let reason = "friction pulls the mass away";
        let missing = VibrationError::NotFound { what: "state of steady sliding", reason };
        let normal_force = model.steady(friction).ok_or(missing)?.normal_force;
        let [_, c12, c22] = model.damping;
        Ok(Self {
            stiffness: model.stiffness,
            damping: [model.effective_damping(friction), c12, c22],
            contact: model.parameters().contact_stiffness,
            normal_force,
            velocity: model.belt_velocity(),
            friction,
            duration,
            settling,
        })
    }

    /// Returns the growth rate under one realisation.
    fn rate(&self, mut fluctuation: impl Fluctuation) -> Result<f64, VibrationError> {
        // This state contains both modes, except by coincidence.
        let mut state = [1.0, 0.3, -0.5, 0.2];
        let end = self.settling + self.duration;
        let (mut tau, mut log_size, mut at_start) = (0.0, 0.0, None);
        while tau < end {
            let cell = self.cell(&mut fluctuation, tau)?;
            // Times of grid points are not accumulated, so rounding does not add up.
            let next = cell.end / self.velocity;
            let slope = if cell.length.is_finite() { cell.slope() * self.velocity } else { 0.0 };
            let began = tau;
            for goal in [self.settling, end] {
                let goal = goal.min(next);
                while tau < goal {
                    let m = cell.left + slope * (tau - began);
                    let h = self.advance(&mut state, m, slope, goal - tau);
                    tau = if h == goal - tau { goal } else { tau + h };
                }
                if tau == self.settling && at_start.is_none() {
                    at_start = Some(log_size + self.log_size(&state));
                }
            }
            let largest = state.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            if !(RESCALING_SIZE.recip()..=RESCALING_SIZE).contains(&largest) {
                log_size += largest.ln();
                state.iter_mut().for_each(|z| *z /= largest);
            }
        }
        Ok((log_size + self.log_size(&state) - at_start.unwrap_or(f64::NAN)) / self.duration)
    }

    fn cell(&self, fluctuation: &mut impl Fluctuation, tau: f64) -> Result<Cell, VibrationError> {
        let sliding_distance = self.velocity * tau;
        let cell =
            fluctuation.next_cell().ok_or(VibrationError::ProcessTooShort { tau, coordinate: sliding_distance })?;
        let fluctuation = cell.left.min(cell.right);
        let coefficient = self.friction + fluctuation;
        if coefficient > 0.0 {
            Ok(cell)
        } else {
            Err(VibrationError::FrictionNotPositive { coefficient, fluctuation, tau, sliding_distance })
        }
    }

    /// Returns ln √E.
    fn log_size(&self, [x, u, y, v]: &[f64; 4]) -> f64 {
        let [k11, k12, k22] = self.stiffness;
        0.5 * (0.5 * (u * u + v * v + k11 * x * x + k22 * y * y) + k12 * x * y).ln()
    }

    /// Advances by one Taylor step of at most `wanted`, with m + slope·t; returns its length.
    fn advance(&self, state: &mut [f64; 4], m: f64, slope: f64, wanted: f64) -> f64 {
        let [k11, k12, k22] = self.stiffness;
        let [c11, c12, c22] = self.damping;
        let k11 = k11 + slope / self.velocity * self.normal_force;
        let across = k12 - (self.friction + m) * self.contact;
        let drift = slope * self.contact;
        let scaled = wanted * (k11.abs() + k22 + across.abs()).sqrt().max(c11.abs() + c22);
        let terms = if scaled < 0.05 { 10 } else { TERMS };
        let mut c = [[0.0; 4]; TERMS];
        c[0] = *state;
        for k in 0..terms - 1 {
            let [x, u, y, v] = c[k];
            let fraction = 1.0 / (k as f64 + 1.0);
            let before = if k == 0 { 0.0 } else { c[k - 1][2] };
            let pull = -k11 * x - across * y - c11 * u - c12 * v + drift * before;
            let push = -k12 * x - k22 * y - c12 * u - c22 * v;
            c[k + 1] = [u * fraction, pull * fraction, v * fraction, push * fraction];
        }
        let size = |c: &[f64; 4]| c.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let allowed = TOLERANCE * size(&c[0]);
        let mut h = wanted;
        for k in [terms - 2, terms - 1] {
            let last = size(&c[k]);
            if last * h.powi(k as i32) > allowed {
                h = h.min((allowed / last).powf(1.0 / k as f64));
            }
        }
        for i in 0..4 {
            state[i] = c[..terms].iter().rev().fold(0.0, |sum, c| sum * h + c[i]);
        }
        h
    }
}

#[cfg(test)]
mod tests {
    use crate::law::Stribeck;
    use std::f64::consts::TAU;

    use super::super::{CoupledParameters, CoupledTrajectory, CoupledTrajectorySettings, Damping, Mode, State};
    use super::*;
    use crate::VelocityLaw;
    use asperity_base::monitor::Silent;
    use asperity_process::{ProcessModel, RecordedProcess, Steady};

    fn leading(model: &Model, friction: f64) -> Mode {
        let [a, b] = modes(model, friction);
        if a.growth > b.growth { a } else { b }
    }

    #[test]
    fn without_fluctuation_the_rate_is_the_real_part_of_the_eigenvalue() {
        let damping = Damping::Modal { ratios: [0.02, 0.08] };
        let law = VelocityLaw::Stribeck(Stribeck { kinetic: 0.9, decay: 0.2 });
        let model =
            Model::new(CoupledParameters { damping, law, static_friction: 0.9, ..CoupledParameters::default() })
                .unwrap();
        for friction in [0.3, 0.8, 1.2] {
            let wanted = leading(&model, friction);
            // Over whole periods √E grows by exactly e^{growth·τ} once the other mode has decayed.
            let duration = 10.0 * TAU / wanted.frequency;
            let system = Linear::new(&model, friction, duration, 900.0).unwrap();
            let found = system.rate(Steady).unwrap();
            assert!((found - wanted.growth).abs() < 1e-12, "{found} {wanted:?}");
        }
    }

    #[test]
    fn a_constant_fluctuation_gives_the_rate_of_the_changed_coefficient() {
        let damping = Damping::Modal { ratios: [0.05, 0.01] };
        let model = Model::new(CoupledParameters { damping, ..CoupledParameters::default() }).unwrap();
        let wanted = leading(&model, 0.8);
        let duration = 10.0 * TAU / wanted.frequency;
        let system = Linear::new(&model, 0.7, duration, 900.0).unwrap();
        let process = RecordedProcess::new(0.7, vec![0.1; 1000]).unwrap();
        let found = system.rate(process.path()).unwrap();
        assert!((found - wanted.growth).abs() < 1e-12, "{found} {wanted:?}");
    }

    #[test]
    fn a_periodic_fluctuation_gives_the_floquet_exponent() {
        // Reference: monodromy matrix M by SciPy's DOP853 (rtol 1e-13, atol 1e-14) between grid points, with K(0) = [2,
        // 1; 1, 2], k₃ = 4/3, C = diag(0.06, 0.02), μ = 0.8 constant, V = 0.5, n = 3/(3 + 4·0.8/3), and m through 0,
        // 0.1, 0.05, −0.12, 0, … at s = 0, 0.4, 0.8, …; growth rates of √E for Mz and M¹⁰z, z = (1, 0.3, −0.5, 0.2),
        // and the largest Floquet exponent.
        let damping = Damping::Axes { tangential: 0.06, normal: 0.02 };
        let model = Model::new(CoupledParameters { damping, ..CoupledParameters::default() }).unwrap();
        let values = (0..8000).map(|i| [0.0, 0.1, 0.05, -0.12][i % 4]).collect();
        let process = RecordedProcess::new(0.4, values).unwrap();
        let rate = |periods: u32, settling: u32| {
            let (duration, settling) = (3.2 * f64::from(periods), 3.2 * f64::from(settling));
            Linear::new(&model, 0.8, duration, settling).unwrap().rate(process.path()).unwrap()
        };
        for (periods, wanted) in [(1, 0.146_048_448_251_647_06), (10, 0.100_958_244_819_462_65)] {
            let found = rate(periods, 0);
            assert!((found - wanted).abs() < 1e-12, "{periods}: {found} {wanted}");
        }
        // The phase of the mode causes an end effect, bounded by the eccentricity of its ellipse over the duration.
        for periods in [100, 400, 1600] {
            let found = rate(periods, 100);
            assert!((found - 0.077_701_506_391_896_69).abs() < 1.0 / (3.2 * f64::from(periods)), "{periods}: {found}");
        }
    }

    #[test]
    fn a_slope_of_the_fluctuation_stiffens_the_mass() {
        // Without coupling, under m = 0.3 s and the constant normal force 1, motion is linear: the difference of two
        // trajectories from one point obeys the linearised equations.
        let model = Model::new(CoupledParameters {
            angles_deg: [0.0, 90.0],
            springs: [1.0, 1.0],
            damping: Damping::Axes { tangential: 0.1, normal: 0.1 },
            belt_velocity: 1.0,
            ..CoupledParameters::default()
        })
        .unwrap();
        let ramp = RecordedProcess::new(0.1, (0..400).map(|i| 0.03 * f64::from(i)).collect()).unwrap();
        let end = |x: f64, u: f64| {
            let start = State { tangential: x, tangential_velocity: u, normal: 0.0, normal_velocity: 0.0 };
            let settings = CoupledTrajectorySettings { duration: 7.0, start: Some(start) };
            CoupledTrajectory::simulate(&model, ramp.path(), &settings).unwrap().end
        };
        let (a, b) = (end(0.9, 0.0), end(0.9, -0.2));
        let system = Linear::new(&model, 0.8, 7.0, 0.0).unwrap();
        let (mut state, mut tau) = ([0.0, -0.2, 0.0, 0.0], 0.0);
        while tau < 7.0 {
            tau += system.advance(&mut state, 0.0, 0.3, 7.0 - tau);
        }
        assert!((b.tangential - a.tangential - state[0]).abs() < 1e-13);
        assert!((b.tangential_velocity - a.tangential_velocity - state[1]).abs() < 1e-13);
    }

    #[test]
    fn rates_of_an_ensemble_surround_the_exponent_and_do_not_depend_on_threads() {
        let damping = Damping::Modal { ratios: [0.02, 0.02] };
        let model = Model::new(CoupledParameters { damping, ..CoupledParameters::default() }).unwrap();
        let process = FrictionProcess::new(ProcessModel::new("normal".parse().unwrap(), 0.02, 1.0)).unwrap();
        let settings =
            GrowthSettings { trajectories: 64, duration: 200.0, settling: 50.0, seed: 3, least_valid_share: 1.0 };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| growth_rates(&model, 0.8, &process, &settings, &Silent).unwrap())
        };
        let (one, two) = (run(1), run(2));
        assert_eq!(one, two);
        assert!(one.se < 0.002 && (one.mean - one.deterministic).abs() < 0.02, "{one:?}");
        assert!(one.quantiles[0] < one.mean && one.mean < one.quantiles[2]);
        assert!(growth_rates(&model, 0.8, &process, &GrowthSettings { trajectories: 1, ..settings }, &Silent).is_err());
    }
}
