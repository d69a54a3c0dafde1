//! Checks of a motion against the equations, step by step, from dense output and a second evaluation of the friction
//! process.

use super::super::motion::Motion;
use super::super::{Drive, Event, EventKind, Forcing, Oscillator, Phase, Slips, VibrationError};
use super::draw::Case;
use super::reader::ProcessReader;
use asperity_base::numeric::golden_section;
use asperity_process::Path;

/// Eight-point Gauss rule on (−1, 1): node and weight of each symmetric pair.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_2, 0.101_228_536_290_376_26],
];

/// Tolerance relative to the sum of all forces, many times the rounding error.
const TIGHT: f64 = 1e-11;
/// Time up to which the rounding of times is within the tolerances.
const EARLY: f64 = 1e3;

/// Results of the checks of one motion.
#[derive(Debug, Default)]
pub(super) struct Checked {
    pub(super) events: Vec<Event>,
    pub(super) slips: Slips,
    pub(super) steps: u64,
    pub(super) cells_read: u64,
    /// Number of slips whose largest backward speed is within rounding of zero.
    pub(super) undecided: u64,
    /// Number of sticks of zero duration.
    pub(super) touches: u64,
    /// Whether the friction coefficient became negative, which the check confirmed.
    pub(super) lost: bool,
    pub(super) worst: [f64; 10],
}

/// Point of dense output, with the friction there.
#[derive(Debug, Clone, Copy)]
struct Point {
    tau: f64,
    x: f64,
    velocity: f64,
    /// Coordinate of the friction process, and its least and largest fluctuation there.
    coordinate: f64,
    m: (f64, f64),
}

/// State before a step: phase, time and sliding distance.
#[derive(Debug, Clone, Copy)]
struct Before {
    phase: Phase,
    tau: f64,
    x: f64,
    velocity: f64,
    s: f64,
}

/// Returns the part of a difference that exceeds an allowance.
fn beyond(difference: f64, allowance: f64) -> f64 {
    (difference.abs() - allowance).max(0.0)
}

struct Checker<'a> {
    case: &'a Case,
    oscillator: &'a Oscillator,
    reader: ProcessReader<Path<'a>>,
    seen: Checked,
    /// Largest fluctuation so far.
    largest: f64,
    /// Time and (X² + V²)^½ when the mass last left the belt or started; and at the start.
    left: (f64, f64),
    started: f64,
    backward: bool,
    undecided: bool,
    /// Effect of the rounding of late times, relative to the sum of all forces.
    late: f64,
}

/// Simulates a case and panics if the motion violates a law.
pub(super) fn check(case: &Case, seed: u64, index: u64) -> Checked {
    let Case { oscillator, process, settings } = case;
    let start = settings.start.unwrap_or_else(|| oscillator.default_start());
    let radius = start.hypot(oscillator.belt_velocity());
    let mut check = Checker {
        case,
        oscillator,
        reader: ProcessReader::new(process.path(seed, index)),
        seen: Checked::default(),
        largest: 0.0,
        left: (0.0, radius),
        started: radius,
        backward: false,
        undecided: false,
        late: 0.0,
    };
    let mut before = Before { phase: Phase::Stick, tau: 0.0, x: start, velocity: oscillator.belt_velocity(), s: 0.0 };
    let mut motion = match Motion::new(oscillator, process.path(seed, index), settings.drive, start) {
        Ok(motion) => motion,
        Err(error) => {
            check.error(&error, &before, None);
            return check.seen;
        }
    };
    if let Some(event) = motion.first_event() {
        let point = check.point(0.0, start, before.velocity, 0.0);
        check.event(event, &point, motion.slip_state().map(|state| state.phase));
    }
    while motion.tau < settings.duration {
        before.phase = motion.slip_state().map_or(Phase::Stick, |state| state.phase);
        match motion.step(settings.duration) {
            Ok(event) => before = check.step(&motion, before, event),
            Err(error) => {
                check.error(&error, &before, Some(&motion));
                return check.seen;
            }
        }
    }
    assert_eq!(motion.tau, settings.duration);
    check.seen.cells_read = check.reader.cells_read;
    check.seen
}

impl Checker<'_> {
    /// Panics unless `number` is zero within `tolerance` times `scale`.
    fn vanishes(&mut self, kind: usize, number: f64, scale: f64, tolerance: f64) {
        let fraction = (number.abs() / scale - self.late).max(0.0);
        self.seen.worst[kind] = self.seen.worst[kind].max(fraction);
        assert!(
            fraction <= tolerance,
            "law {kind} broken by {fraction:e} at {:?}: {:?}",
            self.seen.events.last(),
            self.case
        );
    }

    /// Returns the effect on m of rounding of the coordinate.
    fn rounding(&self, coordinate: f64) -> f64 {
        8.0 * f64::EPSILON * (1.0 + coordinate) * self.reader.steepest
    }

    fn force(&self, tau: f64) -> f64 {
        self.oscillator.forcing().map_or(0.0, |f| f.amplitude * (f.frequency * tau).cos())
    }

    /// Returns the largest friction coefficient so far.
    fn strongest(&self) -> f64 {
        let law = match self.oscillator.law().table() {
            Some(table) => table.points().map(|point| point[1]).fold(0.0, f64::max),
            None => self.oscillator.law().kinetic(),
        };
        law.max(self.oscillator.static_friction()) + self.largest
    }

    fn forcing_amplitude(&self) -> f64 {
        self.oscillator.forcing().map_or(0.0, |Forcing { amplitude, .. }| amplitude)
    }

    /// Returns the sum of the magnitudes of all forces, the scale of rounding errors.
    fn scale(&self, x: f64, velocity: f64) -> f64 {
        self.strongest()
            + self.forcing_amplitude()
            + x.abs()
            + (1.0 + 2.0 * self.oscillator.damping_ratio()) * velocity.abs().max(self.oscillator.belt_velocity())
    }

    fn point(&mut self, tau: f64, x: f64, velocity: f64, s: f64) -> Point {
        let coordinate = match self.case.settings.drive {
            Drive::Distance => s,
            Drive::Time => self.oscillator.belt_velocity() * tau,
        };
        let m = self.reader.range(coordinate, 1e-13 * coordinate);
        self.largest = self.largest.max(m.1);
        Point { tau, x, velocity, coordinate, m }
    }

    /// Returns an upper bound of r = (X² + X′²)^½. With the friction force R, |R| ≤ M, the energy grows at the rate RX′
    /// − 2ζX′² + qX′ cos ητ. Friction supplies energy only to a mass that moves forward, not faster than the belt, so
    /// RX′ ≤ MV and r′ ≤ MV/r + q.
    fn energy_bound(&self, tau: f64) -> f64 {
        let (left, radius) = self.left;
        let feed = 2.0 * self.strongest() * self.oscillator.belt_velocity() * (tau - left);
        (radius * radius + feed).sqrt() + self.forcing_amplitude() * (tau - left)
    }

    /// Returns an upper bound of |X| at all times: the free motion plus (M + q) times the integral of the damped
    /// oscillator's |response|.
    fn damped_bound(&self) -> f64 {
        let damping = self.oscillator.damping_ratio();
        let integral = if damping >= 1.0 {
            1.0
        } else {
            (0.5 * std::f64::consts::PI * damping / (1.0 - damping * damping).sqrt()).tanh().recip()
        };
        self.started + (self.strongest() + self.forcing_amplitude()) * integral
    }

    /// Returns the effect of the rounding of times up to τ, relative to the sum of all forces F.
    ///
    /// The state (W, e) does not depend on times, but dense output is read at differences of times, which are wrong by
    /// δ ≤ ετ. A velocity is wrong by |X″|δ ≤ Fδ, a displacement by |X′|δ ≤ Fδ, and a force by its rate times δ, which
    /// is at most F times η, 2ζ, |dμ/dv| or 1 + |dm/ds|.
    fn late(&self, tau: f64) -> f64 {
        if tau <= EARLY {
            return 0.0;
        }
        let frequency = self.oscillator.forcing().map_or(0.0, |forcing| forcing.frequency);
        let damped = 2.0 * self.oscillator.damping_ratio() + self.oscillator.law().steepest();
        2.0 * f64::EPSILON * tau * (1.0 + self.reader.steepest + damped + frequency)
    }

    /// Checks the step that ends now and returns the state before the next one.
    fn step(&mut self, motion: &Motion<Path<'_>>, before: Before, event: Option<Event>) -> Before {
        self.seen.steps += 1;
        let Before { phase, tau: a, .. } = before;
        let (b, s) = (motion.tau, motion.sliding_distance);
        self.late = self.late(b);
        assert!(b >= a && s >= before.s, "time or distance runs back: {:?}", self.case);
        let drive = self.case.settings.drive;
        let coordinate = if drive == Drive::Distance { before.s } else { self.oscillator.belt_velocity() * a };
        self.reader.forget(coordinate * (1.0 - 1e-12));
        // Position and velocity are continuous between two steps.
        let (x, velocity) = motion.sample(a);
        let end_coordinate = if drive == Drive::Distance { s } else { self.oscillator.belt_velocity() * b };
        let scale = self.scale(x, velocity);
        let rounding = self.rounding(end_coordinate);
        self.vanishes(0, beyond(x - before.x, rounding), scale, TIGHT);
        self.vanishes(1, velocity - before.velocity, scale, TIGHT);
        let (x, velocity) = motion.sample(b);
        let arrived = event.is_some_and(|event| event.kind != EventKind::Detach);
        let rounding = if arrived { rounding + self.grazing(scale) } else { rounding };
        self.vanishes(0, beyond(motion.displacement() - x, rounding), scale, TIGHT);
        let end = self.point(b, x, velocity, s);
        assert!(
            x.hypot(velocity) <= self.energy_bound(b) * (1.0 + 1e-9 + self.late),
            "too much energy: {:?}",
            self.case
        );
        assert!(x.abs() <= self.damped_bound() * (1.0 + 1e-9 + self.late), "too far: {:?}", self.case);
        if phase == Phase::Stick {
            self.stuck(motion, &before, &end);
        } else {
            // One in four of the steps between grid points is checked thoroughly.
            let thorough = event.is_some() || b - a > 0.02 || self.seen.steps.is_multiple_of(4);
            self.slipped(motion, &before, &end, s, thorough);
        }
        if let Some(event) = event {
            assert_eq!((event.tau, event.sliding_distance), (b, s));
            self.vanishes(2, beyond(event.displacement - x, rounding), scale, TIGHT);
            if phase != Phase::Stick {
                self.vanishes(3, velocity - self.oscillator.belt_velocity(), scale, TIGHT);
            }
            self.event(event, &end, motion.slip_state().map(|state| state.phase));
            return Before { phase, tau: b, x: event.displacement, velocity: self.oscillator.belt_velocity(), s };
        }
        Before { phase, tau: b, x, velocity, s }
    }

    /// Returns X + 2ζV − q cos ητ, which friction balances in stick, and its limits.
    fn balance(&self, point: &Point) -> (f64, f64, f64) {
        let (limit, belt) = (self.oscillator.static_friction(), self.oscillator.belt_velocity());
        let force = point.x + 2.0 * self.oscillator.damping_ratio() * belt - self.force(point.tau);
        (force, limit + point.m.0, limit + point.m.1)
    }

    fn stuck(&mut self, motion: &Motion<Path<'_>>, before: &Before, end: &Point) {
        let belt = self.oscillator.belt_velocity();
        let length = end.tau - before.tau;
        assert_eq!(motion.sliding_distance, before.s);
        for fraction in [0.0, 0.31, 0.67, 1.0] {
            let tau = before.tau + fraction * length;
            let (x, velocity) = motion.sample(tau);
            assert_eq!(velocity, belt);
            let point = self.point(tau, x, velocity, before.s);
            let scale = self.scale(x, velocity);
            self.vanishes(
                4,
                beyond(x - before.x - belt * (tau - before.tau), self.rounding(end.coordinate)),
                scale,
                TIGHT,
            );
            let (force, _, most) = self.balance(&point);
            self.vanishes(9, beyond((force.abs() - most).max(0.0), self.rounding(end.coordinate)), scale, TIGHT);
        }
    }

    fn slipped(&mut self, motion: &Motion<Path<'_>>, before: &Before, end: &Point, s: f64, thorough: bool) {
        let direction = before.phase.direction();
        let length = end.tau - before.tau;
        let scale = self.scale(end.x, end.velocity);
        let moved = direction * (self.oscillator.belt_velocity() * length - (end.x - before.x));
        self.vanishes(5, beyond(s - before.s - moved, self.rounding(end.coordinate)), scale + s, TIGHT);
        if thorough {
            self.equation_of_motion(motion, before, end, s, scale);
        }
        if before.phase == Phase::Slip && !self.backward {
            self.check_backward(motion, before, end);
        }
    }

    /// Checks Newton's law, integrated over the step: X′ = ∫ forces and X = ∫ X′ by Gauss's rule, on subintervals where
    /// the whole step is too coarse.
    fn equation_of_motion(&mut self, motion: &Motion<Path<'_>>, before: &Before, end: &Point, s: f64, scale: f64) {
        let length = end.tau - before.tau;
        let mut errors = [f64::INFINITY; 2];
        for parts in [1_u32, 4, 16] {
            let (mut impulse, mut path, mut doubt) = (0.0, 0.0, 0.0);
            for (fraction, weight) in (0..parts).flat_map(|part| {
                GAUSS.into_iter().flat_map(move |[node, weight]| {
                    let place = |node: f64| (f64::from(part) + 0.5 * (1.0 + node)) / f64::from(parts);
                    [(place(-node), 0.5 * weight / f64::from(parts)), (place(node), 0.5 * weight / f64::from(parts))]
                })
            }) {
                let (force, velocity, unsure) = self.acceleration(motion, before, s, before.tau + fraction * length);
                impulse += length * weight * force;
                path += length * weight * velocity;
                doubt += length * weight * unsure;
            }
            let allowed = doubt + length * self.rounding(end.coordinate);
            errors = [
                beyond(end.x - before.x - path, self.rounding(end.coordinate)),
                beyond(end.velocity - before.velocity - impulse, allowed),
            ];
            if errors.iter().all(|error| *error < (1e-13 + self.late) * scale) {
                break;
            }
        }
        self.vanishes(6, errors[0], scale, TIGHT);
        // The length of a step follows from its last two terms; about once in a million steps both are small by
        // accident.
        self.vanishes(7, errors[1], scale * length.max(1.0), 1e-9);
    }

    /// Returns X″ from the forces, X′, and half the jump of friction within rounding of this time.
    fn acceleration(&mut self, motion: &Motion<Path<'_>>, before: &Before, s: f64, tau: f64) -> (f64, f64, f64) {
        let (belt, direction) = (self.oscillator.belt_velocity(), before.phase.direction());
        let (x, velocity) = motion.sample(tau);
        let moved = direction * (belt * (tau - before.tau) - (x - before.x));
        let point = self.point(tau, x, velocity, (before.s + moved).clamp(before.s, s));
        let scale = self.scale(x, velocity);
        let relative = direction * (belt - velocity);
        assert!(relative >= -(1e-9 + self.late) * scale, "{relative:e} slips the wrong way: {:?}", self.case);
        let law = self.oscillator.law().coefficient(relative.max(0.0));
        assert!(
            law + point.m.1 > -(1e-9 + self.late) * scale,
            "friction is negative unseen: {point:?} {:?}",
            self.case
        );
        let friction = direction * (law + 0.5 * (point.m.0 + point.m.1));
        let force = self.force(tau) + friction - 2.0 * self.oscillator.damping_ratio() * velocity - x;
        (force, velocity, 0.5 * (point.m.1 - point.m.0))
    }

    /// Checks whether the mass moves backwards in this step.
    fn check_backward(&mut self, motion: &Motion<Path<'_>>, before: &Before, end: &Point) {
        let length = end.tau - before.tau;
        let mut slowest = before.velocity.min(end.velocity);
        let fall = length * (2.0 * self.scale(end.x, end.velocity) + length * self.scale(0.0, end.velocity));
        if slowest > 0.0 && slowest < fall {
            // Golden-section search in each third of the step.
            for third in 0..3 {
                let ends = [third, third + 1].map(|third| f64::from(third) / 3.0);
                let velocity = |fraction: f64| {
                    let velocity = motion.sample(before.tau + fraction * length).1;
                    slowest = slowest.min(velocity);
                    velocity
                };
                golden_section(velocity, ends, 1.5e-9);
            }
        }
        self.backward = slowest < 0.0;
        let belt = self.oscillator.belt_velocity();
        self.undecided |= slowest.abs() < 1e-9 * belt + self.late * self.scale(end.x, belt);
    }

    fn event(&mut self, event: Event, point: &Point, after: Option<Phase>) {
        let scale = self.scale(point.x, point.velocity);
        let (force, least, most) = self.balance(point);
        let rounding = self.rounding(event.sliding_distance.max(event.tau * self.oscillator.belt_velocity()));
        let last = self.seen.events.last().copied();
        if let Some(last) = last {
            // A grazing arrival at the stick limit, within rounding, is a stick of zero duration.
            let touch = event.tau == last.tau && event.kind == EventKind::Detach && last.tau > 0.0;
            self.seen.touches += u64::from(touch);
            assert!(event.tau > last.tau || touch, "{event:?} not after {last:?}: {:?}", self.case);
            // The distance of a slip starts as the third power of its time; the distance of the shortest slips is below
            // rounding.
            let (further, longer) = (event.sliding_distance - last.sliding_distance, event.tau - last.tau);
            let moved = if event.kind == EventKind::Detach { further == 0.0 } else { further > 0.0 };
            assert!(moved || longer < 1e-3, "{event:?} after {last:?}: {:?}", self.case);
        }
        let stuck =
            last.map_or(event.kind == EventKind::Detach, |last| last.kind == EventKind::Restick) || last.is_none();
        assert_eq!(stuck, event.kind == EventKind::Detach, "{event:?} after {last:?}: {:?}", self.case);
        let overshoot = match (event.kind, after) {
            (EventKind::Detach, Some(phase)) => {
                let excess = phase.direction() * force;
                // At the start, and where friction jumps, the force may exceed the limit considerably.
                let torn_off = event.tau == 0.0 || most > least + rounding;
                self.left = (event.tau, event.displacement.hypot(self.oscillator.belt_velocity()));
                (self.backward, self.undecided) = (false, false);
                if torn_off { least - excess } else { (excess - least).abs().max((excess - most).abs()) }
            }
            (EventKind::Restick, None) => {
                self.count();
                force.abs() - most - self.grazing(scale)
            }
            (EventKind::Reverse, Some(phase)) => {
                if phase == Phase::Slip && self.backward {
                    self.count();
                    self.backward = false;
                }
                least - phase.direction() * force - self.grazing(scale)
            }
            _ => panic!("{event:?} leads to {after:?}: {:?}", self.case),
        };
        self.vanishes(8, (overshoot - rounding).max(0.0), scale, TIGHT);
        self.seen.events.push(event);
    }

    /// Returns the effect of rounding on the force at an arrival. Where the relative velocity W barely passes zero, the
    /// error of the time of its zero is the square root of the rounding of W. The error of e is the same, and the error
    /// of the force is V times as large.
    fn grazing(&self, scale: f64) -> f64 {
        4.0 * (f64::EPSILON * self.oscillator.belt_velocity() * scale).sqrt()
    }

    fn count(&mut self) {
        self.seen.undecided += u64::from(self.undecided);
        if self.backward { self.seen.slips.cycles += 1 } else { self.seen.slips.micro_slips += 1 }
    }

    /// Checks that an error is a loss of friction, and that friction is lost at the reported point.
    fn error(&mut self, error: &VibrationError, before: &Before, motion: Option<&Motion<Path<'_>>>) {
        let VibrationError::FrictionNotPositive { coefficient, tau, sliding_distance, .. } = *error else {
            panic!("{error}: {:?}", self.case)
        };
        assert!(coefficient <= 0.0);
        let (x, velocity) = motion.map_or((before.x, before.velocity), |motion| motion.sample(tau));
        let point = self.point(tau, x, velocity, sliding_distance);
        let scale = self.scale(x, velocity);
        let kinetic = self.oscillator.law().coefficient((self.oscillator.belt_velocity() - velocity).abs());
        let confirmed = [kinetic, self.oscillator.static_friction()].iter().any(|law| {
            let tolerance = (TIGHT + self.late) * scale;
            coefficient >= law + point.m.0 - tolerance && coefficient <= law + point.m.1 + tolerance
        });
        assert!(confirmed, "{error} is wrong: {point:?} {kinetic} {:?}", self.case);
        self.seen.lost = true;
    }
}
