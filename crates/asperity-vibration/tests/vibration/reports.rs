//! Cases that users of other programs reported; docs/validation/reports.md lists them.

use asperity_process::{RecordedProcess, Steady};
use asperity_vibration::{
    Drive, EventKind, Oscillator, Trajectory, TrajectorySettings, limit_cycle, trajectory_portrait,
};

/// Period of the cycle, by a solver of high precision.
const PERIOD: f64 = 6.372_163_483_739_709;

#[test]
fn the_period_and_the_number_of_reattachments_depend_on_no_step() {
    // SciPy #10319, diffrax #416, ModelingToolkit #3327. The mass starts at the limit of static friction.
    let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
    assert!((limit_cycle(&oscillator).unwrap().cycle().unwrap().period / PERIOD - 1.0).abs() < 1e-13);
    let start = Some(0.1 - 2.0 * 0.17 * 0.003);
    let settings = TrajectorySettings { duration: 60.0, start, drive: Drive::Time };
    let steady = Trajectory::simulate(&oscillator, Steady, &settings).unwrap();
    // Steps of the friction record: each has its own grid points, at which the motion is computed.
    for step in [3e-4, 2e-3, 0.05] {
        let record = RecordedProcess::new(step, vec![0.0; (0.2 / step) as usize + 2]).unwrap();
        let found = Trajectory::simulate(&oscillator, record.path(), &settings).unwrap();
        for kind in [EventKind::Detach, EventKind::Restick] {
            let times: Vec<f64> = found.events.iter().filter(|e| e.kind == kind).map(|e| e.tau).collect();
            // The first slip of 60/T = 9.4 periods begins at once.
            assert!(times.len() == if kind == EventKind::Detach { 10 } else { 9 }, "{step}: {times:?}");
            times.windows(2).for_each(|pair| assert!((pair[1] - pair[0] - PERIOD).abs() < 1e-10, "{step}: {pair:?}"));
        }
        assert_eq!(found.events.len(), steady.events.len());
        assert_eq!(found.slips, steady.slips);
    }
    // Steps of the output: the motion is sampled, not recomputed. Values at common times are equal.
    let sampled = |points| trajectory_portrait(&oscillator, Steady, &settings, 0.0, points).unwrap();
    let (coarse, fine) = (sampled(31), sampled(30_001));
    for (k, point) in coarse.iter().enumerate() {
        let same = fine[1000 * k];
        assert!((point.displacement - same.displacement).abs() < 1e-12, "{point:?} {same:?}");
        assert!((point.velocity - same.velocity).abs() < 1e-12, "{point:?} {same:?}");
    }
}
