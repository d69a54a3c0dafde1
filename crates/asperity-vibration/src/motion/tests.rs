//! Friction with jumps, compared with circular arcs: Coulomb friction without damping.

use super::*;
use crate::Parameters;
use crate::law::{Coulomb, Exponential, Stribeck};
use crate::tests::machine;

const STATIC: f64 = 0.4;
const KINETIC: f64 = 0.3;
const BELT: f64 = 0.05;

struct Levels(std::vec::IntoIter<Cell>);

impl Fluctuation for Levels {
    fn next_cell(&mut self) -> Option<Cell> {
        self.0.next()
    }
}

/// Returns the events under m = 0 up to `jump_at` and `m` after it, from X = `start` to `duration`.
fn events(jump_at: f64, m: f64, drive: Drive, start: f64, duration: f64) -> Vec<Event> {
    let cells = vec![
        Cell { end: jump_at, length: jump_at, left: 0.0, right: 0.0 },
        Cell { end: f64::INFINITY, length: f64::INFINITY, left: m, right: m },
    ];
    let law = VelocityLaw::Coulomb(Coulomb { kinetic: KINETIC });
    let oscillator = machine(STATIC, law, 0.0, BELT);
    let mut motion = Motion::new(&oscillator, Levels(cells.into_iter()), drive, start).unwrap();
    let mut events = vec![];
    while motion.tau < duration {
        events.extend(motion.step(duration).unwrap());
    }
    events
}

/// Returns the duration of a slip from X with the friction μ: X = μ + (X₀ − μ) cos t + V sin t until X′ = V.
fn slip(from: f64, friction: f64) -> f64 {
    2.0 * (std::f64::consts::PI - ((from - friction) / BELT).atan())
}

#[test]
fn a_jump_in_stick_releases_the_mass_at_once_or_holds_it_longer() {
    // At the grid point, τ = 0.4, the mass is at X = 0.32.
    let found = events(0.02, -0.15, Drive::Time, 0.3, 6.0);
    let friction = KINETIC - 0.15;
    let wanted =
        [(EventKind::Detach, 0.4, 0.32), (EventKind::Restick, 0.4 + slip(0.32, friction), 2.0 * friction - 0.32)];
    assert_eq!(found.len(), 2);
    for (event, (kind, tau, x)) in found.iter().zip(wanted) {
        assert_eq!(event.kind, kind);
        assert!((event.tau - tau).abs() < 1e-13 && (event.displacement - x).abs() < 1e-13, "{event:?}");
    }
    let held = events(0.02, 0.1, Drive::Time, 0.3, 5.0);
    assert!(held.len() == 1 && (held[0].tau - 4.0).abs() < 1e-13 && (held[0].displacement - 0.5).abs() < 1e-13);
}

#[test]
fn a_jump_in_slip_changes_the_circle_but_not_position_or_velocity() {
    // From rest at X = 0.4 over a distance of 0.3, then about another centre.
    for m in [-0.1, 0.15] {
        let found = events(0.3, m, Drive::Distance, STATIC, 8.0);
        let arc = |t: f64, centre: f64, x: f64, v: f64| {
            (centre + (x - centre) * t.cos() + v * t.sin(), v * t.cos() - (x - centre) * t.sin())
        };
        // Vt − (X − X₀) = 0.3 by bisection.
        let (mut low, mut high) = (0.0, slip(STATIC, KINETIC));
        for _ in 0..60 {
            let t = 0.5 * (low + high);
            if BELT * t - arc(t, KINETIC, STATIC, BELT).0 + STATIC < 0.3 { low = t } else { high = t }
        }
        let (x, v) = arc(low, KINETIC, STATIC, BELT);
        let centre = KINETIC + m;
        // X′ = V: R sin(angle of the arrival − phase), the later of the two solutions per turn.
        let radius = (x - centre).hypot(v);
        let phase = v.atan2(x - centre);
        let turn = std::f64::consts::TAU;
        let arrivals = [-(BELT / radius).asin(), std::f64::consts::PI + (BELT / radius).asin()];
        let t = arrivals.iter().map(|angle| (angle + phase).rem_euclid(turn)).fold(f64::INFINITY, f64::min);
        assert_eq!(found[1].kind, EventKind::Restick);
        assert!((found[1].tau - low - t).abs() < 1e-12, "{:?} not {}", found[1], low + t);
        assert!((found[1].displacement - arc(t, centre, x, v).0).abs() < 1e-12);
    }
}

#[test]
fn an_arrival_exactly_at_a_grid_point_is_found() {
    let duration = slip(STATIC, KINETIC);
    let back = 2.0 * KINETIC - STATIC;
    let distance = BELT * duration + STATIC - back;
    for m in [-0.05, 0.0, 0.05, 0.3] {
        for ulps in -12..=12 {
            let jump_at = distance * (1.0 + f64::from(ulps) * f64::EPSILON);
            let found = events(jump_at, m, Drive::Distance, STATIC, duration + (STATIC + m - back) / BELT + 1.0);
            let kinds: Vec<EventKind> = found.iter().map(|event| event.kind).collect();
            // The next release is at either limit, depending on whether the mass arrived before or after the grid
            // point.
            assert_eq!(kinds[..2], [EventKind::Detach, EventKind::Restick], "{m} {ulps}");
            // An error of the distance of the order of rounding causes an error of the velocity of the order of its
            // square root.
            assert!((found[1].tau - duration).abs() < 1e-6 && (found[1].displacement - back).abs() < 1e-7);
            if let Some(next) = found.get(2) {
                let limit = (next.displacement - STATIC).abs().min((next.displacement - STATIC - m).abs());
                assert!(next.kind == EventKind::Detach && limit < 1e-7, "{m} {ulps}: {next:?}");
            }
        }
    }
}

#[test]
fn a_release_exactly_at_a_grid_point_is_found() {
    for ulps in -6..=6 {
        let jump_at = 0.1 * (1.0 + f64::from(ulps) * f64::EPSILON);
        // Less friction: one release, at τ = 2.
        let found = events(jump_at, -0.05, Drive::Time, 0.3, 3.0);
        assert!(found.len() == 1 && found[0].kind == EventKind::Detach, "{ulps}: {found:?}");
        assert!((found[0].tau - 2.0).abs() < 1e-12 && (found[0].displacement - STATIC).abs() < 1e-12);
        // More friction, also in slip: the mass is held until τ = 5, even if it was free for zero time.
        let found = events(jump_at, 0.15, Drive::Time, 0.3, 6.0);
        let last = found[found.len() - 1];
        assert!((last.tau - 5.0).abs() < 1e-12 && last.kind == EventKind::Detach, "{ulps}: {found:?}");
        assert!(found.len() == 1 || (found.len() == 3 && (found[1].tau - 2.0).abs() < 1e-12), "{ulps}: {found:?}");
    }
}

#[test]
fn no_extreme_of_a_step_is_missed() {
    // High frequencies and strong forces turn the velocity several times in a step.
    let mut most = 0;
    for (amplitude, frequency, belt_velocity) in [(0.3, 0.9, 0.05), (0.6, 3.0, 0.2), (2.0, 8.0, 0.5), (0.01, 11.0, 2.0)]
    {
        for law in [
            VelocityLaw::Stribeck(Stribeck { kinetic: KINETIC, decay: 2.0 }),
            VelocityLaw::Exponential(Exponential { kinetic: KINETIC, high_speed: 0.2, stribeck_velocity: 0.1 }),
        ] {
            let forcing = Some(crate::Forcing { amplitude, frequency });
            let parameters = Parameters { static_friction: STATIC, law, damping_ratio: 0.01, belt_velocity, forcing };
            let oscillator = Oscillator::new(parameters).unwrap();
            let steady = asperity_process::Steady;
            let mut motion = Motion::new(&oscillator, steady, Drive::Distance, 0.1).unwrap();
            for _ in 0..400 {
                motion.step(f64::INFINITY).unwrap();
                let Segment { tau, duration, .. } = motion.segment;
                let turning = motion.turning_times();
                most = most.max(turning.len());
                let extremes = |times: &mut dyn Iterator<Item = f64>| {
                    times
                        .map(|tau| motion.sample(tau))
                        .fold([f64::INFINITY; 4], |[a, b, c, d], (x, v)| [a.min(x), b.min(-x), c.min(v), d.min(-v)])
                };
                let found = extremes(&mut turning.into_iter());
                let dense = extremes(&mut (0..=300).map(|i| tau + duration * f64::from(i) / 300.0));
                for (found, dense) in found.into_iter().zip(dense) {
                    assert!(
                        found <= dense + 1e-13 * dense.abs().max(1.0),
                        "{dense} beyond {found} in {:?}",
                        motion.segment
                    );
                }
            }
        }
    }
    // At least: two ends, two extremes and a zero of X′ in between.
    assert!(most >= 5, "{most} times at most");
}

#[test]
fn a_start_at_the_limit_and_the_grid_of_a_record_leave_the_number_of_steps_bounded() {
    // docs/validation/reports.md, SciPy #10319: nine cycles of some five steps, and one step for each grid point.
    let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
    for grid_points in [0, 600] {
        let end = |point: usize| if point == grid_points { f64::INFINITY } else { 3e-4 * (point + 1) as f64 };
        let cells: Vec<Cell> =
            (0..=grid_points).map(|point| Cell { end: end(point), length: 3e-4, left: 0.0, right: 0.0 }).collect();
        let mut motion =
            Motion::new(&oscillator, Levels(cells.into_iter()), Drive::Time, 0.1 - 2.0 * 0.17 * 0.003).unwrap();
        let mut steps = 0;
        while motion.tau < 60.0 {
            motion.step(60.0).unwrap();
            steps += 1;
        }
        assert!(steps <= 60 + grid_points, "{steps} steps, {grid_points} grid points");
    }
}
