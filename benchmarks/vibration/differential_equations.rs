//! The stick-slip oscillator by the crate `differential-equations`, with its event detection; prints JSON.
//!
//! `CASE key=value …`: `cycle` times cycles from one detachment to the next, `path` trajectories under friction whose knots a file
//! holds. Slip ends where the relative velocity falls through zero; stick is a straight line, left in closed form.

use std::collections::HashMap;
use std::hint::black_box;
use std::time::Instant;

use differential_equations::control::ControlFlag;
use differential_equations::ode::solve_ode;
use differential_equations::prelude::*;
use differential_equations::solout::{CrossingDirection, DefaultSolout, Event, EventConfig, EventSolout, Solout};
use differential_equations::traits::State;

/// Longest slip that is followed.
const LONGEST_SLIP: f64 = 100.0;

/// Longest first step towards a knot.
const LONGEST_FIRST_STEP: f64 = 0.3;

struct Machine {
    friction: f64,
    decay: f64,
    damping: f64,
    velocity: f64,
}

impl Machine {
    fn acceleration(&self, x: f64, v: f64, m: f64) -> f64 {
        self.friction / (1.0 + self.decay * (self.velocity - v)) + m - 2.0 * self.damping * v - x
    }

    /// Displacement at which stick ends.
    fn release(&self, m: f64) -> f64 {
        self.friction + m - 2.0 * self.damping * self.velocity
    }
}

/// A system in slip.
trait Slipping<const N: usize>: ODE<f64, [f64; N]> + Event<f64, [f64; N]>
where
    [f64; N]: State<f64>,
{
    /// Whether events are found by [`first_zero`], as the crate knows one at a time and overlooks two in one step.
    const TWO_EVENTS: bool = false;

    /// Time to the event from a state close to it.
    fn rest(&self, y: &[f64; N], slope: &[f64; N]) -> f64;

    /// Whether the event at a state is worth another step; see [`How::refine`].
    fn matters(&self, _: &[f64; N]) -> bool {
        true
    }

    /// First step from a state; none: the crate's.
    fn first_step(&self, _: &[f64; N]) -> Option<f64> {
        None
    }
}

/// X and X′ without fluctuation.
impl ODE<f64, [f64; 2]> for Machine {
    fn diff(&self, _: f64, y: &[f64; 2], dydt: &mut [f64; 2]) {
        *dydt = [y[1], self.acceleration(y[0], y[1], 0.0)];
    }
}

impl Event<f64, [f64; 2]> for Machine {
    fn config(&self) -> EventConfig {
        EventConfig::new(CrossingDirection::Negative, Some(1))
    }

    fn event(&self, _: f64, y: &[f64; 2]) -> f64 {
        self.velocity - y[1]
    }
}

impl Slipping<2> for Machine {
    fn rest(&self, y: &[f64; 2], slope: &[f64; 2]) -> f64 {
        (self.velocity - y[1]) / slope[1]
    }
}

/// A machine under a straight line through knots of the fluctuation.
struct Path<'a> {
    machine: &'a Machine,
    knots: &'a [f64],
    step: f64,
}

impl Path<'_> {
    fn fluctuation(&self, s: f64) -> f64 {
        let place = s.max(0.0) / self.step;
        let cell = (place as usize).min(self.knots.len() - 2);
        self.knots[cell] + (self.knots[cell + 1] - self.knots[cell]) * (place - cell as f64)
    }
}

/// X, X′ and the sliding distance.
impl ODE<f64, [f64; 3]> for Path<'_> {
    fn diff(&self, _: f64, y: &[f64; 3], dydt: &mut [f64; 3]) {
        let machine = self.machine;
        *dydt = [y[1], machine.acceleration(y[0], y[1], self.fluctuation(y[2])), machine.velocity - y[1]];
    }
}

impl Event<f64, [f64; 3]> for Path<'_> {
    fn config(&self) -> EventConfig {
        EventConfig::new(CrossingDirection::Negative, Some(1))
    }

    fn event(&self, _: f64, y: &[f64; 3]) -> f64 {
        self.machine.velocity - y[1]
    }
}

impl Slipping<3> for Path<'_> {
    fn rest(&self, y: &[f64; 3], slope: &[f64; 3]) -> f64 {
        (self.machine.velocity - y[1]) / slope[1]
    }
}

/// One straight piece of a path, which ends at the next knot or where slip ends.
struct Piece<'a> {
    machine: &'a Machine,
    start: f64,
    end: f64,
    left: f64,
    slope: f64,
    /// Whether the knot is worth another step.
    refine_knot: bool,
}

impl Piece<'_> {
    fn to_knot(&self, y: &[f64; 3]) -> f64 {
        self.end - y[2]
    }

    fn relative_velocity(&self, y: &[f64; 3]) -> f64 {
        self.machine.velocity - y[1]
    }

    /// Whether the piece ended with the slip, not at the knot.
    fn arrived(&self, y: &[f64; 3]) -> bool {
        self.relative_velocity(y).abs() / self.machine.velocity < self.to_knot(y).abs() / (self.end - self.start)
    }
}

impl ODE<f64, [f64; 3]> for Piece<'_> {
    fn diff(&self, _: f64, y: &[f64; 3], dydt: &mut [f64; 3]) {
        let m = self.left + self.slope * (y[2] - self.start);
        *dydt = [y[1], self.machine.acceleration(y[0], y[1], m), self.machine.velocity - y[1]];
    }
}

impl Event<f64, [f64; 3]> for Piece<'_> {
    fn config(&self) -> EventConfig {
        EventConfig::new(CrossingDirection::Negative, Some(1))
    }

    fn event(&self, _: f64, y: &[f64; 3]) -> f64 {
        self.relative_velocity(y).min(self.to_knot(y))
    }
}

impl Slipping<3> for Piece<'_> {
    const TWO_EVENTS: bool = true;

    fn rest(&self, y: &[f64; 3], slope: &[f64; 3]) -> f64 {
        if self.arrived(y) { self.relative_velocity(y) / slope[1] } else { self.to_knot(y) / slope[2] }
    }

    fn matters(&self, y: &[f64; 3]) -> bool {
        self.refine_knot || self.arrived(y)
    }

    /// To the knot, at the velocity at the start or, from a detachment, at the acceleration that follows.
    fn first_step(&self, y: &[f64; 3]) -> Option<f64> {
        let velocity = self.relative_velocity(y);
        let step = if velocity > 0.0 {
            self.to_knot(y) / velocity
        } else {
            (6.0 * self.to_knot(y) / self.machine.velocity).cbrt()
        };
        Some(step.min(LONGEST_FIRST_STEP))
    }
}

/// Leaves events to the crate and remembers the last step.
struct Watch<'a, const N: usize, S>
where
    S: Slipping<N>,
    [f64; N]: State<f64>,
{
    system: &'a S,
    event: EventSolout<'a, f64, [f64; N], S>,
    t: f64,
    y: [f64; N],
    /// Whether the mass moves backwards at the end of a step.
    reached_backward: bool,
}

impl<const N: usize, S> Solout<f64, [f64; N]> for Watch<'_, N, S>
where
    S: Slipping<N>,
    [f64; N]: State<f64>,
{
    fn solout<I>(
        &mut self,
        t: f64,
        t_before: f64,
        y: &[f64; N],
        y_before: &[f64; N],
        interpolator: &mut I,
        solution: &mut Solution<f64, [f64; N]>,
    ) -> ControlFlag<f64, [f64; N]>
    where
        I: Interpolation<f64, [f64; N]> + ?Sized,
    {
        self.reached_backward |= y[1] < 0.0;
        (self.t, self.y) = (t_before, *y_before);
        if S::TWO_EVENTS {
            if t <= t_before || self.system.event(t, y) > 0.0 {
                return ControlFlag::Continue;
            }
            let (t, y) = first_zero(self.system, (t_before, *y_before), (t, *y), interpolator);
            solution.push(t, y);
            return ControlFlag::Terminate;
        }
        self.event.solout(t, t_before, y, y_before, interpolator, solution)
    }
}

/// Returns the time at which the event of a system falls through zero in a step, by the Illinois method on the crate's interpolation.
fn first_zero<const N: usize, S, I>(
    system: &S,
    start: (f64, [f64; N]),
    end: (f64, [f64; N]),
    interpolator: &mut I,
) -> (f64, [f64; N])
where
    S: Slipping<N>,
    [f64; N]: State<f64>,
    I: Interpolation<f64, [f64; N]> + ?Sized,
{
    let (mut left, mut right, mut found) = (start.0, end.0, end);
    let (mut above, mut below) = (system.event(left, &start.1), system.event(right, &end.1));
    let mut side = 0;
    for _ in 0..100 {
        if right - left < 1e-14 || below == 0.0 {
            break;
        }
        let middle = if above > 0.0 { (left * below - right * above) / (below - above) } else { 0.5 * (left + right) };
        let y = interpolator.interpolate(middle).expect("inside the step");
        let value = system.event(middle, &y);
        if value > 0.0 {
            (left, above) = (middle, value);
            below *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            (right, below, found) = (middle, value, (middle, y));
            above *= if side == 2 { 0.5 } else { 1.0 };
            side = 2;
        }
        if value.abs() < 1e-15 {
            return (middle, y);
        }
    }
    found
}

/// Integration method of slips.
#[derive(Clone, Copy)]
struct How {
    rtol: f64,
    atol: f64,
    /// Whether the last step is taken again, as far as the event, with one iteration of Newton's method from there: the crate
    /// finds events on its interpolation, whose error no tolerance governs.
    refine: bool,
    /// The same at knots.
    refine_knots: bool,
}

/// Time and state at the end of a slip, and whether it moved backwards.
fn slip<const N: usize, S>(system: &S, start: [f64; N], how: How) -> (f64, [f64; N], bool)
where
    S: Slipping<N>,
    [f64; N]: State<f64>,
{
    let mut method = ExplicitRungeKutta::dop853().rtol(how.rtol).atol(how.atol);
    if let Some(step) = system.first_step(&start) {
        method = method.h0(step);
    }
    let event = EventSolout::new(system, 0.0, LONGEST_SLIP);
    let mut watch = Watch { system, event, t: 0.0, y: start, reached_backward: false };
    let solution = solve_ode(&mut method, system, 0.0, LONGEST_SLIP, &start, &mut watch).expect("a slip is solved");
    let (&t, &y) = (solution.t.last().expect("an end"), solution.y.last().expect("an end"));
    assert!(t < LONGEST_SLIP, "the slip ends");
    if !how.refine || !system.matters(&y) || t - watch.t < 1e-12 {
        return (t, y, watch.reached_backward);
    }
    let mut method = ExplicitRungeKutta::dop853().rtol(how.rtol).atol(how.atol).h0(t - watch.t);
    let again =
        solve_ode(&mut method, system, watch.t, t, &watch.y, &mut DefaultSolout::new()).expect("a step is solved");
    let mut y = *again.y.last().expect("an end");
    let mut slope = y;
    system.diff(t, &y, &mut slope);
    let rest = system.rest(&y, &slope);
    for (value, slope) in y.iter_mut().zip(slope) {
        *value += rest * slope;
    }
    (t + rest, y, watch.reached_backward)
}

/// The mean period of cycles.
fn cycles(machine: &Machine, count: usize, how: How) -> f64 {
    let release = machine.release(0.0);
    let mut total = 0.0;
    for _ in 0..count {
        let (t, [x, _], _) = slip(machine, black_box([release, machine.velocity]), how);
        total += t + (release - x) / machine.velocity;
    }
    total / count as f64
}

/// One slip from a detachment at `start`, piece by piece between knots.
fn slip_by_pieces(path: &Path<'_>, start: [f64; 3], how: How) -> (f64, [f64; 3], bool) {
    let (mut tau, mut y, mut reached_backward) = (0.0, start, false);
    let mut cell = (y[2] / path.step) as usize;
    loop {
        let (left, right) = (path.knots[cell], path.knots[cell + 1]);
        let slope = (right - left) / path.step;
        let (start, end) = (cell as f64 * path.step, (cell + 1) as f64 * path.step);
        if y[2] >= end {
            cell += 1;
            continue;
        }
        let piece = Piece { machine: path.machine, start, end, left, slope, refine_knot: how.refine_knots };
        let (t, state, backward) = slip(&piece, y, how);
        (tau, y, reached_backward) = (tau + t, state, reached_backward || backward);
        if piece.arrived(&y) {
            return (tau, y, reached_backward);
        }
        y[2] = end;
        cell += 1;
    }
}

/// Ends of the cycles of a trajectory.
fn follow(path: &Path<'_>, duration: f64, pieces: bool, how: How) -> Vec<f64> {
    let machine = path.machine;
    let (mut tau, mut x, mut s) = (0.0, 0.97 * machine.friction - 2.0 * machine.damping * machine.velocity, 0.0);
    let mut ends = Vec::new();
    loop {
        let release = machine.release(path.fluctuation(s)).max(x);
        tau += (release - x) / machine.velocity;
        if tau >= duration {
            return ends;
        }
        let start = [release, machine.velocity, s];
        let (t, [end, _, slid], backward) =
            if pieces { slip_by_pieces(path, start, how) } else { slip(path, start, how) };
        (x, s, tau) = (end, slid, tau + t);
        if tau > duration {
            return ends;
        }
        if backward {
            ends.push(tau);
        }
    }
}

fn main() {
    let mut words = std::env::args().skip(1);
    let case = words.next().expect("a case");
    let words: HashMap<String, String> =
        words.map(|word| word.split_once('=').map(|(k, v)| (k.into(), v.into())).expect("key=value")).collect();
    let number = |key: &str| words[key].parse::<f64>().expect("a number");
    let count = |key: &str| words[key].parse::<usize>().expect("a count");
    let [friction, decay, damping, velocity] = ["friction", "decay", "damping", "velocity"].map(number);
    let machine = Machine { friction, decay, damping, velocity };
    let refine = words["refine"].as_str();
    let how =
        How { rtol: number("rtol"), atol: number("atol"), refine: refine != "none", refine_knots: refine == "all" };
    let warm_up = count("warm_up");
    let mut seconds = Vec::new();
    let mut timed = |run: &mut dyn FnMut()| {
        for turn in 0..warm_up + count("repeats") {
            let start = Instant::now();
            run();
            if turn >= warm_up {
                seconds.push(start.elapsed().as_secs_f64());
            }
        }
    };
    let answer = match case.as_str() {
        "cycle" => {
            let mut period = 0.0;
            timed(&mut || period = cycles(&machine, count("cycles"), how));
            format!("\"period\": {period:?}")
        }
        "path" => {
            let bytes = std::fs::read(&words["knots"]).expect("knots");
            let knots: Vec<f64> =
                bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes"))).collect();
            let each = knots.len() / count("paths");
            let mut ends = Vec::new();
            timed(&mut || {
                ends.clear();
                ends.extend(knots.chunks(each).map(|knots| {
                    let path = Path { machine: &machine, knots, step: number("step") };
                    follow(&path, number("duration"), words["pieces"] == "true", how)
                }));
            });
            format!("\"ends\": {ends:?}")
        }
        _ => panic!("{case} is no case"),
    };
    println!("{{\"seconds\": {seconds:?}, {answer}}}");
}
