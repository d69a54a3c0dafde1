//! Batches of trajectories in lockstep: sixteen lanes of one instruction stream.
//!
//! All lanes are always in slip. A stick without forcing, under friction that stays constant during stick, lasts
//! exactly −e and is skipped in one operation. A lane whose trajectory has ended takes the next one. The arithmetic of
//! each lane is independent of the others, so a trajectory has the same bits in any batch. The rare steps that the
//! vector code cannot decide are decided by the polynomials of one lane. Trajectories that batches do not support
//! (forcing, friction as a function of time, tabulated laws, slip cycles) are simulated one by one with [`follow`].

mod kernel;

use std::ops::Range;

use self::kernel::{Consts, Cuts, Expansion, LANES, NOISY, STEADY, States};
use super::law::BatchForm;
use super::motion::MAX_IDLE_STEPS;
use super::trajectory::{Observer, Slipped, follow, start_of};
use super::{Drive, Event, EventKind, Oscillator, Slips, TrajectorySettings, VibrationError};
use asperity_base::monitor::Silent;
use asperity_process::{Cell, Fluctuation};

/// Trajectory to simulate.
pub(super) struct Task<F, W> {
    oscillator: Oscillator,
    fluctuation: F,
    observer: W,
    /// Level of the observed swings; see [`follow`].
    swing_level: f64,
}

impl<F, W> Task<F, W> {
    /// Creates a trajectory whose swings below the velocity of the belt are not observed.
    pub(super) fn new(oscillator: Oscillator, fluctuation: F, observer: W) -> Self {
        Self { oscillator, fluctuation, observer, swing_level: f64::INFINITY }
    }

    /// Returns the same trajectory with observed swings; see [`follow`].
    pub(super) fn with_swing_level(self, swing_level: f64) -> Self {
        Self { swing_level, ..self }
    }
}

/// Result of a finished trajectory.
pub(super) struct Followed<W> {
    pub(super) slips: Slips,
    pub(super) observer: W,
}

/// Simulates the trajectories `indices`, created by `make`, and passes each result to `done`, in any order.
///
/// `make` may be called twice for one trajectory and must then return the same task.
pub(super) fn simulate_many<F: Fluctuation, W: Observer>(
    settings: &TrajectorySettings,
    indices: Range<usize>,
    make: impl Fn(usize) -> Result<Task<F, W>, VibrationError>,
    mut done: impl FnMut(usize, Result<Followed<W>, VibrationError>),
) {
    let alone = |index: usize| {
        let Task { oscillator, mut fluctuation, mut observer, swing_level } = make(index)?;
        let slips = follow(&oscillator, &mut fluctuation, settings, swing_level, &Silent, &mut observer)?;
        Ok(Followed { slips, observer })
    };
    let mut waiting = indices;
    if settings.drive == Drive::Time || !(settings.duration.is_finite() && settings.duration > 0.0) {
        waiting.for_each(|index| done(index, alone(index)));
        return;
    }
    // Four batches: with or without grid points, and with an exponential law or another one.
    let mut batches: [Option<Box<dyn Lockstep<F, W>>>; 4] = [const { None }; 4];
    for index in &mut waiting {
        match make(index).and_then(|task| LaneTrajectory::new(index, task, settings)) {
            Ok(Some(trajectory)) => {
                let (noisy, exponential) = (trajectory.cell.length.is_finite(), trajectory.form.is_exponential);
                let kind = 2 * usize::from(exponential) + usize::from(noisy);
                let batch = batches[kind].get_or_insert_with(|| match (noisy, exponential) {
                    (true, false) => Box::new(Batch::<NOISY, false, F, W>::new(settings)),
                    (false, false) => Box::new(Batch::<STEADY, false, F, W>::new(settings)),
                    (true, true) => Box::new(Batch::<NOISY, true, F, W>::new(settings)),
                    (false, true) => Box::new(Batch::<STEADY, true, F, W>::new(settings)),
                });
                // Few trajectories wait at a time, so that memory stays small.
                if batch.push(trajectory) >= LANES {
                    batch.run(false, &mut |index, followed| done(index, followed.map_or_else(|| alone(index), Ok)));
                }
            }
            Ok(None) => done(index, alone(index)),
            Err(error) => done(index, Err(error)),
        }
    }
    for batch in batches.iter_mut().flatten() {
        batch.run(true, &mut |index, followed| done(index, followed.map_or_else(|| alone(index), Ok)));
    }
}

/// Receives the result of a trajectory, or none if the trajectory must be simulated alone.
type Done<'a, W> = &'a mut dyn FnMut(usize, Option<Followed<W>>);

/// Batch of trajectories of one kind of process and law.
trait Lockstep<F, W> {
    /// Queues a trajectory for a free lane; returns the length of the queue.
    fn push(&mut self, trajectory: LaneTrajectory<F, W>) -> usize;

    /// Advances until the queue is empty or, with `to_the_end`, until all trajectories have ended.
    fn run(&mut self, to_the_end: bool, done: Done<'_, W>);
}

impl<const N: usize, const EXPONENTIAL: bool, F: Fluctuation, W: Observer> Lockstep<F, W>
    for Batch<N, EXPONENTIAL, F, W>
{
    fn push(&mut self, trajectory: LaneTrajectory<F, W>) -> usize {
        self.queue.push(trajectory);
        self.queue.len()
    }

    fn run(&mut self, to_the_end: bool, done: Done<'_, W>) {
        loop {
            for lane in 0..LANES {
                while self.trajectories[lane].is_none() {
                    let Some(trajectory) = self.queue.pop() else { break };
                    let outcome = self.start(lane, trajectory);
                    self.finish_lane(lane, outcome, done);
                }
            }
            let all_empty = self.trajectories.iter().all(Option::is_none);
            if all_empty || (!to_the_end && self.trajectories.iter().any(Option::is_none)) {
                return;
            }
            loop {
                self.expansion.step(&self.consts, &mut self.states, self.duration, &mut self.cuts);
                let mut one_ended = false;
                for lane in 0..LANES {
                    let outcome = self.finish_step(lane);
                    if !matches!(outcome, Outcome::Continues) {
                        self.finish_lane(lane, outcome, done);
                        one_ended = true;
                    }
                }
                if one_ended {
                    break;
                }
            }
        }
    }
}

/// Trajectory of one lane, without the state in [`States`].
struct LaneTrajectory<F, W> {
    index: usize,
    fluctuation: F,
    observer: W,
    slips: Slips,
    oscillator: Oscillator,
    form: BatchForm,
    velocity: f64,
    static_friction: f64,
    /// 2ζV.
    drag: f64,
    /// Distance at the start of the current cell of the process, and the cell.
    start: f64,
    cell: Cell,
    /// Excess force e at the start.
    excess: f64,
    /// Whether the mass has moved backwards since its last slip was finished.
    reached_backward: bool,
    idle_steps: usize,
}

/// Outcome of a step of one lane.
enum Outcome {
    Continues,
    Ended,
    /// Not supported in a batch: the trajectory is simulated alone, from its beginning.
    Unsupported,
}

impl<F: Fluctuation, W: Observer> LaneTrajectory<F, W> {
    /// Creates a trajectory at its start; returns none if batches do not support it.
    fn new(index: usize, task: Task<F, W>, settings: &TrajectorySettings) -> Result<Option<Self>, VibrationError> {
        let Task { oscillator, mut fluctuation, observer, swing_level } = task;
        if oscillator.forcing().is_some() || swing_level.is_finite() {
            return Ok(None);
        }
        let velocity = oscillator.belt_velocity();
        let Some(form) = oscillator.law().batch_form(velocity) else { return Ok(None) };
        let Some(cell) = fluctuation.next_cell() else { return Ok(None) };
        let mut trajectory = Self {
            index,
            fluctuation,
            observer,
            slips: Slips::default(),
            oscillator: oscillator.clone(),
            form,
            velocity,
            static_friction: oscillator.static_friction(),
            drag: 2.0 * oscillator.damping_ratio() * velocity,
            start: 0.0,
            cell,
            excess: 0.0,
            reached_backward: false,
            idle_steps: 0,
        };
        let start = start_of(&oscillator, settings)?;
        trajectory.excess = ((start - trajectory.static_friction) + trajectory.drag - cell.left) / velocity;
        // A trajectory that does not start in stick is simulated alone.
        let limit = trajectory.static_friction + cell.left;
        let sticks = trajectory.excess <= 0.0 && -trajectory.excess - 2.0 * limit / velocity <= 0.0 && limit > 0.0;
        Ok(sticks.then_some(trajectory))
    }

    /// Returns m at the scaled distance `passed` since the start of the cell.
    fn fluctuation_at(&self, passed: f64) -> f64 {
        if self.cell.length.is_finite() {
            self.cell.left + self.cell.slope() * (passed * self.velocity)
        } else {
            self.cell.left
        }
    }

    /// Reports an event that may finish a slip.
    fn finish_slip(&mut self, kind: EventKind, tau: f64, passed: f64, e: f64, direction: f64) {
        let slipped = Slipped::new(kind, direction < 0.0, self.reached_backward);
        if slipped != Slipped::Not {
            self.reached_backward = false;
        }
        self.slips.add(slipped);
        self.notify(kind, tau, passed, e, direction, slipped);
    }

    fn notify(&mut self, kind: EventKind, tau: f64, passed: f64, e: f64, direction: f64, slipped: Slipped) {
        let m = self.fluctuation_at(passed);
        let displacement = (self.velocity * e + m + self.static_friction) * direction - self.drag;
        let sliding_distance = self.start + passed * self.velocity;
        self.observer.on_event(Event { kind, tau, displacement, sliding_distance }, slipped);
    }
}

/// Trajectories in the lanes, and the queue of those that wait for a free lane.
struct Batch<const N: usize, const EXPONENTIAL: bool, F, W> {
    duration: f64,
    consts: Consts,
    states: States,
    cuts: Cuts,
    expansion: Box<Expansion<N, EXPONENTIAL>>,
    trajectories: [Option<LaneTrajectory<F, W>>; LANES],
    queue: Vec<LaneTrajectory<F, W>>,
}

impl<const N: usize, const EXPONENTIAL: bool, F: Fluctuation, W: Observer> Batch<N, EXPONENTIAL, F, W> {
    fn new(settings: &TrajectorySettings) -> Self {
        Self {
            duration: settings.duration,
            consts: Consts::NONE,
            states: States::NONE,
            cuts: Cuts::NONE,
            expansion: Box::new(Expansion::NONE),
            trajectories: [const { None }; LANES],
            queue: Vec::with_capacity(LANES),
        }
    }

    fn finish_lane(&mut self, lane: usize, outcome: Outcome, done: Done<'_, W>) {
        if matches!(outcome, Outcome::Continues) {
            return;
        }
        if let Some(LaneTrajectory { index, slips, observer, .. }) = self.trajectories[lane].take() {
            let ended = matches!(outcome, Outcome::Ended);
            done(index, ended.then_some(Followed { slips, observer }));
        }
        self.states.clear(lane);
    }

    /// Assigns a trajectory, which starts in stick, to a lane.
    fn start(&mut self, lane: usize, trajectory: LaneTrajectory<F, W>) -> Outcome {
        self.consts.set(lane, &trajectory.oscillator, &trajectory.form);
        let excess = trajectory.excess;
        self.states.tau[lane] = 0.0;
        self.states.enter(lane, &trajectory.cell, trajectory.velocity);
        self.trajectories[lane] = Some(trajectory);
        self.stick(lane, excess)
    }

    /// Advances through stick to the release, where the force reaches its limit, e = 0.
    fn stick(&mut self, lane: usize, excess: f64) -> Outcome {
        let states = &mut self.states;
        let Some(trajectory) = &mut self.trajectories[lane] else { return Outcome::Continues };
        let release = states.tau[lane] - excess;
        if release >= self.duration {
            return Outcome::Ended;
        }
        trajectory.idle_steps = if release > states.tau[lane] { 0 } else { trajectory.idle_steps + 1 };
        (states.tau[lane], states.w[lane], states.e[lane]) = (release, 0.0, 0.0);
        (states.direction[lane], states.fastest[lane]) = (1.0, 0.0);
        trajectory.reached_backward = false;
        trajectory.notify(EventKind::Detach, release, states.passed[lane], 0.0, 1.0, Slipped::Not);
        if trajectory.idle_steps > MAX_IDLE_STEPS { Outcome::Unsupported } else { Outcome::Continues }
    }

    /// Handles the end of a step in one lane.
    #[inline(always)]
    fn finish_step(&mut self, lane: usize) -> Outcome {
        if self.cuts.plain[lane] > 0.5 {
            self.cross(lane)
        } else if self.cuts.quiet[lane] > 0.5 {
            Outcome::Continues
        } else {
            self.handle_events(lane)
        }
    }

    /// Enters the next cell of the friction process.
    #[inline(always)]
    fn cross(&mut self, lane: usize) -> Outcome {
        let states = &mut self.states;
        let Some(trajectory) = &mut self.trajectories[lane] else { return Outcome::Continues };
        let Some(cell) = trajectory.fluctuation.next_cell() else { return Outcome::Unsupported };
        if cell.left != trajectory.cell.right {
            // The displacement is continuous where m jumps. A mass at relative rest there may stick or slip, which lanes
            // do not decide.
            states.e[lane] -= (cell.left - trajectory.cell.right) / trajectory.velocity;
            if states.w[lane] == 0.0 {
                return Outcome::Unsupported;
            }
        }
        trajectory.start = trajectory.cell.end;
        trajectory.cell = cell;
        trajectory.idle_steps = 0;
        states.enter(lane, &cell, trajectory.velocity);
        Outcome::Continues
    }

    /// Handles every end of a step other than a plain crossing of a grid point.
    #[inline(never)]
    fn handle_events(&mut self, lane: usize) -> Outcome {
        if self.trajectories[lane].is_none() {
            self.states.clear(lane);
            return Outcome::Continues;
        }
        if self.cuts.weak[lane] > 0.5 {
            return Outcome::Unsupported;
        }
        if self.cuts.unsure[lane] > 0.5 {
            self.expansion.recompute_end(lane, &mut self.states, self.duration, &mut self.cuts);
        }
        if self.cuts.turned[lane] > 0.5 {
            let highest = self.expansion.highest(lane, self.cuts.h[lane]);
            self.states.fastest[lane] = self.states.fastest[lane].max(highest);
        }
        if self.cuts.crossed[lane] > 0.5 {
            let outcome = self.cross(lane);
            return if self.states.tau[lane] < self.duration { outcome } else { Outcome::Ended };
        }
        let arrived = self.cuts.arrived[lane] > 0.5;
        let states = &mut self.states;
        let Some(trajectory) = &mut self.trajectories[lane] else { return Outcome::Continues };
        trajectory.idle_steps = if self.cuts.h[lane] > 0.0 { 0 } else { trajectory.idle_steps + 1 };
        if trajectory.idle_steps > MAX_IDLE_STEPS {
            return Outcome::Unsupported;
        }
        if !arrived {
            return if states.tau[lane] < self.duration { Outcome::Continues } else { Outcome::Ended };
        }
        // An arrival has W′ = e + jump ≤ 0; any other value is rounding at a grazing arrival.
        let opposite = |e: f64, m: f64, t: &LaneTrajectory<F, W>| -e - 2.0 * (t.static_friction + m) / t.velocity;
        let m = trajectory.fluctuation_at(states.passed[lane]);
        let mut e = states.e[lane].min(-self.consts.jump[lane]);
        let from = states.direction[lane];
        if from < 0.0 {
            e = opposite(e, m, trajectory);
        }
        let (tau, passed) = (states.tau[lane], states.passed[lane]);
        if e > 0.0 || opposite(e, m, trajectory) > 0.0 {
            let direction = if e > 0.0 { 1.0 } else { -1.0 };
            if direction < 0.0 {
                e = opposite(e, m, trajectory);
            }
            (states.direction[lane], states.e[lane]) = (direction, e);
            trajectory.reached_backward |= from > 0.0 && states.fastest[lane] > 1.0;
            states.fastest[lane] = 0.0;
            trajectory.finish_slip(EventKind::Reverse, tau, passed, e, direction);
            return if tau < self.duration { Outcome::Continues } else { Outcome::Ended };
        }
        trajectory.reached_backward |= from > 0.0 && states.fastest[lane] > 1.0;
        trajectory.finish_slip(EventKind::Restick, tau, passed, e, 1.0);
        self.stick(lane, e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Trajectory;
    use crate::VelocityLaw;
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use crate::tests::machine;
    use asperity_process::{FrictionProcess, ProcessModel, RecordedProcess, Steady};

    #[derive(Debug, Default, Clone, PartialEq)]
    struct All(Vec<(Event, Slipped)>);

    impl Observer for All {
        fn on_event(&mut self, event: Event, slipped: Slipped) {
            self.0.push((event, slipped));
        }
    }

    fn process(std: f64) -> FrictionProcess {
        FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01)).unwrap()
    }

    /// Returns events and counts, or the error, of each trajectory in order.
    fn followed(
        oscillator: &Oscillator,
        process: &FrictionProcess,
        duration: f64,
        indices: Range<usize>,
    ) -> Vec<Result<(Slips, All), VibrationError>> {
        let settings = TrajectorySettings { duration, start: None, drive: Drive::Distance };
        let mut found: Vec<Option<Result<(Slips, All), VibrationError>>> = indices.clone().map(|_| None).collect();
        let first = indices.start;
        simulate_many(
            &settings,
            indices,
            |index| {
                let fluctuation = process.path(3, index as u64);
                Ok(Task::new(oscillator.clone(), fluctuation, All::default()))
            },
            |index, ended: Result<Followed<All>, _>| {
                let place = &mut found[index - first];
                assert!(place.is_none(), "trajectory {index} ended twice");
                *place = Some(ended.map(|followed| (followed.slips, followed.observer)));
            },
        );
        found.into_iter().map(|ended| ended.expect("every trajectory ends")).collect()
    }

    fn exponential(kinetic: f64, high_speed: f64, stribeck_velocity: f64) -> VelocityLaw {
        VelocityLaw::Exponential(Exponential { kinetic, high_speed, stribeck_velocity })
    }

    fn machines() -> Vec<(Oscillator, f64)> {
        let of = |static_friction, law, damping_ratio, belt_velocity, std| {
            (machine(static_friction, law, damping_ratio, belt_velocity), std)
        };
        vec![
            of(0.1, VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }), 0.17, 0.003, 0.001),
            of(0.1, VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }), 0.25, 0.003, 0.001),
            of(0.1, VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }), 0.17, 0.003, 0.006),
            of(0.3, VelocityLaw::Stribeck(Stribeck { kinetic: 0.25, decay: 3.0 }), 0.05, 0.05, 0.01),
            of(0.3, VelocityLaw::Linear(Linear { kinetic: 0.3, slope: 0.2 }), 0.05, 0.05, 0.005),
            of(0.4, VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 }), 0.02, 0.05, 0.005),
            of(0.4, exponential(0.4, 0.3, 0.4), 0.05, 0.05, 0.005),
            of(0.3, exponential(0.25, 0.1, 0.03), 0.05, 0.1, 0.005),
            // Laws that fall within a small fraction of the velocity of the belt, and one that hardly falls.
            of(0.3, exponential(0.3, 0.2, 0.001), 0.05, 0.05, 0.004),
            of(0.3, exponential(0.3, 0.2, 300.0), 0.01, 0.05, 0.004),
            // Strong motion: the mass overtakes the belt.
            of(0.17, VelocityLaw::Stribeck(Stribeck { kinetic: 0.14, decay: 5.0 }), 0.003, 1.7, 0.001),
        ]
    }

    #[test]
    fn a_batch_and_a_single_simulation_have_the_same_events() {
        for (oscillator, std) in machines() {
            let process = process(std);
            let settings = TrajectorySettings { duration: 25.0, start: None, drive: Drive::Distance };
            for (index, ended) in followed(&oscillator, &process, 25.0, 0..40).into_iter().enumerate() {
                let (slips, All(events)) = ended.unwrap();
                let alone = Trajectory::simulate(&oscillator, process.path(3, index as u64), &settings).unwrap();
                assert_eq!(slips, alone.slips);
                assert_eq!(events.len(), alone.events.len());
                for ((event, _), wanted) in events.iter().zip(&alone.events) {
                    assert_eq!(event.kind, wanted.kind);
                    let scale = oscillator.static_friction();
                    let differences = [
                        event.tau - wanted.tau,
                        (event.displacement - wanted.displacement) / scale,
                        (event.sliding_distance - wanted.sliding_distance) / scale,
                    ];
                    // Noise amplifies rounding differences from slip to slip.
                    assert!(differences.iter().all(|d| d.abs() < 1e-9), "{oscillator:?}: {event:?} and {wanted:?}");
                }
            }
        }
    }

    #[test]
    fn the_sliding_distance_is_the_way_of_the_belt_less_that_of_the_mass() {
        let mut slips = 0;
        for (oscillator, std) in machines().into_iter().take(4) {
            for ended in followed(&oscillator, &process(std), 60.0, 0..8) {
                let (_, All(events)) = ended.unwrap();
                for pair in events.windows(2) {
                    let [before, after] = [pair[0].0, pair[1].0];
                    let way = after.sliding_distance - before.sliding_distance;
                    let belt = oscillator.belt_velocity() * (after.tau - before.tau);
                    let wanted = match before.kind {
                        EventKind::Detach => belt - (after.displacement - before.displacement),
                        _ => 0.0,
                    };
                    assert!((way - wanted).abs() < 1e-9 * oscillator.static_friction(), "{before:?} {after:?}");
                    slips += usize::from(before.kind == EventKind::Detach);
                }
            }
        }
        assert!(slips > 100, "{slips}");
    }

    #[test]
    fn ending_records_and_negative_friction_fail_as_in_a_single_simulation() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let settings = TrajectorySettings { duration: 60.0, start: None, drive: Drive::Distance };
        for values in [vec![0.0; 30], (0..4000).map(|i| -0.005 * f64::from(i)).collect(), vec![0.01; 20]] {
            let record = RecordedProcess::new(0.005, values).unwrap();
            let alone = Trajectory::simulate(&oscillator, record.path(), &settings).unwrap_err();
            simulate_many(
                &settings,
                0..3,
                |_| Ok(Task::new(oscillator.clone(), record.path(), All::default())),
                |_, ended| assert_eq!(ended.map(|followed| followed.observer).unwrap_err(), alone),
            );
        }
    }

    #[test]
    fn without_noise_every_lane_follows_the_cycle() {
        let settings = TrajectorySettings { duration: 200.0, start: None, drive: Drive::Distance };
        let of = |index: usize| {
            let damping_ratio = 0.1 + 0.005 * (index % 20) as f64;
            let (static_friction, law, belt_velocity) = match index / 20 {
                0 => (0.1, VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }), 0.003),
                1 => (0.3, exponential(0.3, 0.1, 0.2), 0.02),
                _ => (0.4, exponential(0.35, 0.2, 0.004), 0.08),
            };
            machine(static_friction, law, damping_ratio, belt_velocity)
        };
        simulate_many(
            &settings,
            0..60,
            |index| Ok(Task::new(of(index), Steady, All::default())),
            |index, ended| {
                let followed = ended.unwrap();
                let cycle = *crate::limit_cycle(&of(index)).unwrap().cycle().unwrap();
                let detached: Vec<f64> = followed
                    .observer
                    .0
                    .iter()
                    .filter(|(e, _)| e.kind == EventKind::Detach)
                    .map(|(e, _)| e.tau)
                    .collect();
                assert!(detached.len() as f64 > 180.0 / cycle.period);
                for pair in detached.windows(2) {
                    let error = (pair[1] - pair[0] - cycle.period).abs();
                    assert!(error < 1e-12 * cycle.period + 1e-13, "{error:e}");
                }
                for (event, _) in followed.observer.0.iter().filter(|(e, _)| e.kind == EventKind::Restick) {
                    let wanted = cycle.reattachment_displacement.unwrap();
                    let error = (event.displacement - wanted).abs() / of(index).static_friction();
                    assert!(error < 1e-12, "{index}: {error:e}");
                }
                let alone = Trajectory::simulate(&of(index), Steady, &settings).unwrap();
                assert_eq!(followed.slips, alone.slips);
            },
        );
    }
}
