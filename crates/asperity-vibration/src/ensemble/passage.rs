//! Vibration of one trajectory: times of stick, of loss of vibration and of its return.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::super::sample_distribution::SampleCollector;
use super::super::trajectory::{Observer, Slipped};
use super::super::{Event, EventKind, MotionKind};

/// Time of slip without a swing after which vibration counts as lost: three natural periods. A slip of a cycle is
/// shorter than one natural period; the time in stick does not count.
const LOSS_TIME: f64 = 3.0 * TAU;

/// Kinds of vibration in the order of [`Passage::kinds`].
pub(super) const KINDS: [MotionKind; 3] = [MotionKind::StickSlip, MotionKind::Overtaking, MotionKind::SlipCycle];

/// The vibration of one trajectory.
///
/// A mass vibrates while swings follow each other. A swing is one of three motions: a slip that reaches ẋ < 0 and ends
/// in stick; a slip that reaches ẋ < 0 and then passes the velocity of the belt without stick; or a slip slower than
/// the belt whose velocity exceeds the level of a slip cycle, see [`super::super::settled::swing_level`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Passage {
    duration: f64,
    /// Displacements at the ends of the slips of cycles.
    pub(super) reattachments: SampleCollector,
    /// Displacements at detachments, except the detachment from the first stick.
    pub(super) releases: SampleCollector,
    /// Times from the start of a swing to the start of the next, unless vibration was lost in between.
    pub(super) periods: SampleCollector,
    /// Time in stick.
    pub(super) stick: f64,
    /// Times in vibration and out of it, and the time in vibration in the second half.
    pub(super) inside: f64,
    pub(super) outside: f64,
    pub(super) late_inside: f64,
    /// Time in each of the [`KINDS`] of vibration.
    pub(super) kinds: [f64; 3],
    /// Numbers of exits from vibration and of returns.
    pub(super) exits: u64,
    pub(super) entries: u64,
    /// Time of the first loss of vibration.
    pub(super) first_exit: Option<f64>,
    stuck_since: Option<f64>,
    /// Whether the mass has left the belt.
    detached: bool,
    /// Start of the present slip. A slip slower than the belt starts with a detachment or with the end of over-slip.
    start: f64,
    /// Start of the last swing, and its kind.
    last_start: Option<(f64, usize)>,
    /// End of the last swing, or the start of the trajectory.
    last_end: f64,
    /// Time at which vibration started.
    entered: f64,
    /// Time of slip since the end of the last swing, up to `slides_from`.
    slipped: f64,
    slides_from: f64,
    /// End of a swing slower than the belt that may still end in stick or over-slip.
    pending: Option<f64>,
}

impl Passage {
    /// Creates the record of a trajectory that starts in stick, vibrating; each distribution keeps at most `capacity`
    /// values.
    pub(super) fn new(trajectory: usize, duration: f64, capacity: usize) -> Self {
        let [reattachments, releases, periods] = [(); 3].map(|()| SampleCollector::new(trajectory as u64, capacity));
        Self {
            duration,
            reattachments,
            releases,
            periods,
            stick: 0.0,
            inside: 0.0,
            outside: 0.0,
            late_inside: 0.0,
            kinds: [0.0; 3],
            exits: 0,
            entries: 0,
            first_exit: None,
            stuck_since: Some(0.0),
            detached: false,
            start: 0.0,
            last_start: None,
            last_end: 0.0,
            entered: 0.0,
            slipped: 0.0,
            slides_from: 0.0,
            pending: None,
        }
    }

    /// Closes the open intervals at the end of the trajectory.
    pub(super) fn finish(&mut self) {
        self.settle();
        match self.stuck_since {
            Some(since) => self.stick += self.duration - since,
            None => self.slipped += self.duration - self.slides_from,
        }
        if self.slipped > LOSS_TIME {
            self.lose();
            self.outside += self.duration - self.last_end;
        } else {
            let kind = self.last_start.map_or(0, |(_, kind)| kind);
            self.kinds[kind] += self.duration - self.last_end.max(self.entered);
            self.stay(self.duration);
        }
    }

    /// Returns the fraction of the second half of the time in vibration.
    pub(super) fn late_fraction(&self) -> f64 {
        (self.late_inside / (0.5 * self.duration)).min(1.0)
    }

    /// Adds the time in vibration up to its end.
    fn stay(&mut self, end: f64) {
        self.inside += end - self.entered;
        self.late_inside += (end - self.entered.max(0.5 * self.duration)).max(0.0);
    }

    /// Records that vibration was lost at the end of the last swing.
    fn lose(&mut self) {
        self.stay(self.last_end);
        self.exits += 1;
        self.first_exit.get_or_insert(self.last_end);
    }

    /// Counts a swing slower than the belt after which the mass did not reach the belt velocity.
    fn settle(&mut self) {
        if let Some(tau) = self.pending.take() {
            self.slipped += tau - self.slides_from;
            self.swing(2, tau, tau);
        }
    }

    /// Records a slip that ended in stick or over-slip.
    fn contact(&mut self, tau: f64) {
        // Reaching the belt velocity from X′ = 0 takes less than a natural period.
        if self.pending.is_some_and(|swung| tau - swung < TAU) {
            self.pending = None;
        }
        self.settle();
        self.slipped += tau - self.slides_from;
    }

    /// Records a swing of one of the [`KINDS`].
    fn swing(&mut self, kind: usize, start: f64, end: f64) {
        if self.slipped > LOSS_TIME {
            self.lose();
            self.outside += end - self.last_end;
            self.entries += 1;
            self.entered = end;
        } else {
            self.kinds[kind] += end - self.last_end;
            // Swings of slip cycles start at another phase of the period.
            if let Some((before, _)) = self.last_start.filter(|(_, last)| (*last == 2) == (kind == 2)) {
                self.periods.add(start - before);
            }
        }
        (self.last_start, self.last_end, self.slipped, self.slides_from) = (Some((start, kind)), end, 0.0, end);
    }
}

impl Observer for Passage {
    fn on_event(&mut self, event: Event, slipped: Slipped) {
        let tau = event.tau;
        match event.kind {
            EventKind::Detach => {
                if let Some(since) = self.stuck_since.take() {
                    self.stick += tau - since;
                    if self.detached {
                        self.releases.add(event.displacement);
                    }
                }
                (self.detached, self.start, self.slides_from) = (true, tau, tau);
            }
            EventKind::Restick => {
                self.contact(tau);
                self.stuck_since = Some(tau);
                if slipped == Slipped::Cycle {
                    self.reattachments.add(event.displacement);
                    self.swing(0, self.start, tau);
                }
            }
            EventKind::Reverse if slipped == Slipped::Cycle => {
                self.contact(tau);
                self.swing(1, self.start, tau);
                self.start = tau;
            }
            EventKind::Reverse => {}
        }
    }

    fn on_swing(&mut self, tau: f64) {
        self.settle();
        self.pending = Some(tau);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(kind: EventKind, tau: f64) -> Event {
        Event { kind, tau, displacement: tau, sliding_distance: 0.0 }
    }

    /// Returns the record of a list of events: detachments (D), ends of cycles (C) and of micro-slips (M), over-slips
    /// that end without stick (O) and swings slower than the belt (S).
    fn recorded(duration: f64, events: &[(char, f64)]) -> Passage {
        let mut passage = Passage::new(0, duration, 100);
        for &(kind, tau) in events {
            match kind {
                'D' => passage.on_event(event(EventKind::Detach, tau), Slipped::Not),
                'C' => passage.on_event(event(EventKind::Restick, tau), Slipped::Cycle),
                'O' => passage.on_event(event(EventKind::Reverse, tau), Slipped::Cycle),
                'S' => passage.on_swing(tau),
                _ => passage.on_event(event(EventKind::Restick, tau), Slipped::Micro),
            }
        }
        passage.finish();
        passage
    }

    #[test]
    fn a_steady_cycle_is_never_left() {
        let passage = recorded(100.0, &[('D', 1.0), ('C', 6.0), ('D', 8.0), ('C', 13.0), ('D', 15.0), ('C', 20.0)]);
        assert_eq!(passage.periods.clone().values(), [7.0, 7.0]);
        assert_eq!(passage.reattachments.clone().values().len(), 3);
        assert_eq!(passage.releases.clone().values(), [8.0, 15.0]);
        // A long last stick belongs to the cycle.
        assert_eq!((passage.stick, passage.inside, passage.outside), (85.0, 100.0, 0.0));
        assert_eq!((passage.exits, passage.entries, passage.first_exit, passage.late_inside), (0, 0, None, 50.0));
    }

    #[test]
    fn a_lost_cycle_ends_with_its_last_stick_and_a_new_one_begins_with_its_first() {
        let events = [
            ('D', 1.0),
            ('C', 6.0),
            ('D', 8.0),
            ('C', 40.0),
            ('D', 41.0),
            ('M', 42.0),
            ('D', 43.0),
            ('C', 46.0),
            ('D', 47.0),
        ];
        let passage = recorded(100.0, &events);
        assert_eq!(passage.periods.clone().values(), [35.0]);
        assert_eq!((passage.exits, passage.entries, passage.first_exit), (2, 1, Some(6.0)));
        // In the cycle from 0 to 6 and from 40 to 46; out of it from 6 to 40 and after 46.
        assert_eq!((passage.inside, passage.outside, passage.late_inside), (12.0, 88.0, 0.0));
        assert_eq!(passage.stick, 1.0 + 2.0 + 1.0 + 1.0 + 1.0);
    }

    #[test]
    fn every_kind_of_swing_keeps_up_vibration_and_has_its_time() {
        // Stick-slip up to 8, overtaking up to 26, slip cycles up to 50; then steady sliding.
        let events = [('D', 1.0), ('S', 5.0), ('C', 8.0), ('D', 9.0), ('O', 14.0), ('O', 20.0), ('O', 26.0)];
        let swings = [32.0, 38.0, 44.0, 50.0].map(|tau| ('S', tau));
        let passage = recorded(100.0, &[&events[..], &swings[..]].concat());
        assert_eq!(passage.kinds, [8.0, 18.0, 24.0]);
        assert_eq!((passage.inside, passage.outside, passage.first_exit), (50.0, 50.0, Some(50.0)));
        // From detachment to detachment, from one end of over-slip to the next, and from swing to swing.
        assert_eq!(passage.periods.clone().values(), [8.0, 5.0, 6.0, 6.0, 6.0, 6.0]);
        assert_eq!((passage.reattachments.clone().values().len(), passage.stick), (1, 2.0));
        // The same swings up to the end.
        let lasting = recorded(52.0, &[&events[..], &swings[..]].concat());
        assert_eq!((lasting.exits, lasting.inside, lasting.kinds), (0, 52.0, [8.0, 18.0, 26.0]));
        assert_eq!(lasting.late_fraction(), 1.0);
    }

    #[test]
    fn a_mass_that_never_sticks_has_lost_the_cycle_from_the_beginning() {
        let mut passage = Passage::new(0, 50.0, 100);
        passage.on_event(event(EventKind::Detach, 0.0), Slipped::Not);
        passage.finish();
        assert_eq!((passage.exits, passage.first_exit, passage.outside), (1, Some(0.0), 50.0));
    }
}
