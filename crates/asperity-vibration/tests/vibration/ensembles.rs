//! Ensembles of stick-slip motions: known counts, limits of little noise and of fine steps, and equal bytes for any
//! number of threads.
//!
//! `ASPERITY_TRAJECTORIES` sets the number of trajectories of each mean of cycles (about a thousand by default).

use asperity_vibration::law::{Coulomb, Exponential, Stribeck};
use std::f64::consts::TAU;

use asperity_base::monitor::Silent;
use asperity_base::random;
use asperity_process::{FrictionProcess, Generator, ProcessModel, Steady, TranslationKind};
use asperity_vibration::{
    Drive, Ensemble, EnsembleSettings, EventKind, Forcing, FrictionTable, Oscillator, Parameters, Trajectory,
    TrajectorySettings, VelocityLaw, limit_cycle,
};
use rand::RngExt;

/// Duration of the published trajectories.
const DURATION: f64 = 637.2;

fn paper(damping_ratio: f64) -> Oscillator {
    Oscillator::with_stribeck(0.1, 4.2, damping_ratio, 0.003).unwrap()
}

fn model(std: f64) -> ProcessModel {
    ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01)
}

/// Returns the settings of the published ensembles, with this number of trajectories unless the environment sets
/// another.
fn published(trajectories: usize, seed: u64) -> EnsembleSettings {
    let asked = std::env::var("ASPERITY_TRAJECTORIES");
    EnsembleSettings::new(asked.map_or(trajectories, |count| count.parse().unwrap()), DURATION, seed)
}

fn simulate(oscillator: &Oscillator, model: ProcessModel, settings: &EnsembleSettings) -> Ensemble {
    Ensemble::simulate(oscillator, &FrictionProcess::new(model).unwrap(), settings, &Silent).unwrap()
}

#[test]
fn means_are_within_three_standard_errors_of_all_published_means() {
    // ζ, cycles without noise, and means with standard errors: over 400 trajectories, and over 4,000 and 8,000 by two
    // other codes.
    let known = [
        (0.17, 99, vec![(69.48, 0.30), (68.99, 0.10), (69.20, 0.07)]),
        (0.204_830_1, 101, vec![(45.59, 0.35), (45.21, 0.11)]),
        (0.22, 0, vec![(34.70, 0.34), (34.31, 0.11)]),
        (0.25, 0, vec![(17.26, 0.26), (17.18, 0.08), (17.23, 0.06)]),
    ];
    for (damping, deterministic, means) in known {
        let found = simulate(&paper(damping), model(0.001), &published(1_600, 41));
        assert!(found.failures.is_empty());
        assert_eq!(found.cycles_deterministic, deterministic);
        for (mean, se) in means {
            let distance = (found.cycles.mean - mean) / found.cycles.se.hypot(se);
            assert!(distance.abs() < 3.0, "damping {damping}: {:?} is {distance:.2} errors from {mean}", found.cycles);
        }
    }
}

#[test]
#[ignore = "slow"]
fn a_four_times_finer_grid_changes_the_mean_count_by_less_than_two_per_cent() {
    for damping in [0.17, 0.22] {
        let [coarse, fine] = [20, 80].map(|steps_per_length| {
            let model = ProcessModel { steps_per_length, ..model(0.001) };
            simulate(&paper(damping), model, &published(1_200, 7)).cycles
        });
        let shift = fine.mean / coarse.mean - 1.0;
        let noise = fine.se.hypot(coarse.se) / coarse.mean;
        println!("damping {damping}: shift {shift:.4} ± {noise:.4}");
        assert!(noise < 0.009 && shift.abs() < 0.02, "damping {damping}: {shift} ± {noise}");
    }
}

#[test]
fn vanishing_noise_gives_exactly_the_count_without_noise() {
    let generators =
        [Generator::Autoregressive, Generator::Spectral { harmonics: 16 }, Generator::Jacobi, Generator::Renewal];
    for (i, generator) in generators.into_iter().enumerate() {
        for (k, damping) in [0.02, 0.1, 0.17, 0.2, 0.21, 0.3].into_iter().enumerate() {
            for drive in [Drive::Distance, Drive::Time] {
                let std = [1e-12, 1e-11, 1e-10, 1e-9][(i + k) % 4];
                let settings = EnsembleSettings { drive, ..EnsembleSettings::new(2, 1_500.0, 3) };
                let found = simulate(&paper(damping), ProcessModel { generator, ..model(std) }, &settings);
                let count = found.cycles_deterministic;
                assert_eq!(
                    (found.cycles.mean, found.cycles.std),
                    (count as f64, 0.0),
                    "{generator:?} {damping} {drive:?}"
                );
                assert_eq!(found.micro_slips.mean, 0.0);
                assert!((damping < 0.205) == (count > 150), "damping {damping}: {count} cycles");
            }
        }
    }
}

/// Asserts that 1, 2 and 3 threads give the same bytes.
fn same_on_any_threads(oscillator: &Oscillator, model: &ProcessModel, settings: &EnsembleSettings) {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        serde_json::to_string(&pool.install(|| simulate(oscillator, model.clone(), settings))).unwrap()
    };
    let one = with(1);
    assert!(one.len() > 1_000);
    for threads in [2, 3] {
        assert!(with(threads) == one, "{threads} threads: {oscillator:?}");
    }
}

#[test]
fn ten_thousand_trajectories_have_the_same_bytes_on_any_number_of_threads() {
    same_on_any_threads(&paper(0.17), &model(0.001), &EnsembleSettings::new(10_000, 80.0, 5));
}

#[test]
fn single_simulations_have_the_same_bytes_on_any_number_of_threads() {
    let of = |law, forcing| {
        Oscillator::new(Parameters { static_friction: 0.1, law, damping_ratio: 0.1, belt_velocity: 0.003, forcing })
            .unwrap()
    };
    let exponential = VelocityLaw::Exponential(Exponential { kinetic: 0.1, high_speed: 0.08, stribeck_velocity: 0.03 });
    let table = FrictionTable::new(&[[0.0, 0.1], [0.004, 0.098], [0.02, 0.09], [0.1, 0.08]]).unwrap();
    let stribeck = VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 });
    let forcing = Some(Forcing { amplitude: 0.002, frequency: 0.9 });
    let settings = EnsembleSettings::new(300, 60.0, 5);
    for oscillator in [of(exponential, None), of(VelocityLaw::Tabulated(table), None), of(stribeck.clone(), forcing)] {
        same_on_any_threads(&oscillator, &model(0.001), &settings);
    }
    let in_time = EnsembleSettings { drive: Drive::Time, ..settings };
    let corrected = ProcessModel { correlation: TranslationKind::Corrected, ..model(0.001) };
    same_on_any_threads(&of(stribeck.clone(), None), &corrected, &in_time);
    // A trajectory leaves the batch when friction jumps while the mass is at relative rest.
    let jumps = ProcessModel { generator: Generator::Renewal, ..model(0.004) };
    same_on_any_threads(&of(stribeck, None), &jumps, &settings);
}

#[test]
fn coulomb_cycles_have_their_closed_form_at_any_jump_and_belt_velocity() {
    let mut rng = random::stream(12, "closed form", 0);
    for _ in 0..10 {
        let jump = 10.0_f64.powf(rng.random_range(-3.0..0.0));
        let velocity = 10.0_f64.powf(rng.random_range(-3.0..0.5));
        let kinetic = 10.0_f64.powf(rng.random_range(-1.0..0.5));
        let parameters = Parameters {
            static_friction: kinetic + jump,
            law: VelocityLaw::Coulomb(Coulomb { kinetic }),
            damping_ratio: 0.0,
            belt_velocity: velocity,
            forcing: None,
        };
        let oscillator = Oscillator::new(parameters).unwrap();
        // The jump in floating-point arithmetic.
        let jump = oscillator.static_friction() - kinetic;
        let slip = TAU - 2.0 * (jump / velocity).atan();
        let (period, back) = (slip + 2.0 * jump / velocity, kinetic - jump);
        let amplitude = jump.hypot(velocity);
        let cycle = *limit_cycle(&oscillator).unwrap().cycle().unwrap();
        let scale = kinetic + amplitude;
        for (found, wanted, size) in [
            (cycle.period, period, period),
            (cycle.slip_duration, slip, slip),
            (cycle.reattachment_displacement.unwrap(), back, scale),
            (cycle.displacement_max, kinetic + amplitude, scale),
            (cycle.displacement_min, kinetic - amplitude, scale),
            (cycle.velocity_min, -amplitude, amplitude),
        ] {
            assert!((found - wanted).abs() < 1e-12 * size, "{jump} {velocity}: {found} instead of {wanted}");
        }
        // The same from the events of a motion that starts at its stick limit.
        let settings = TrajectorySettings {
            duration: 3.5 * period,
            start: Some(oscillator.static_friction()),
            drive: Drive::Distance,
        };
        let events = Trajectory::simulate(&oscillator, Steady, &settings).unwrap().events;
        let first = events[0].tau;
        assert!(events.len() >= 7 && first.abs() < 1e-12 * scale / velocity);
        for (i, event) in events.iter().enumerate() {
            let (kind, since, x) = if i % 2 == 0 {
                (EventKind::Detach, 0.0, oscillator.static_friction())
            } else {
                (EventKind::Restick, slip, back)
            };
            let turns = (i / 2) as f64;
            assert_eq!(event.kind, kind);
            assert!((event.tau - first - turns * period - since).abs() < 1e-12 * (1.0 + turns) * period);
            assert!((event.displacement - x).abs() < 1e-12 * scale);
            // Vt minus the distance of the mass in each slip.
            let distance = (turns + f64::from(u8::from(i % 2 == 1))) * (velocity * slip + 2.0 * jump);
            assert!((event.sliding_distance - distance).abs() < 1e-12 * (1.0 + turns) * (distance + scale));
        }
    }
}
