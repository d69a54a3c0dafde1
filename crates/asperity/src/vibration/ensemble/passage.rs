//! What one trajectory tells of the cycle: where it sticks and slides, and when it is lost and found.

use std::f64::consts::TAU;

use super::super::lanes::Witness;
use super::super::sample_law::Gathering;
use super::super::trajectory::Slipped;
use super::super::{Event, EventKind};

/// Time of slip without a finished cycle after which the cycle counts as lost: three natural periods. A slip of a cycle is
/// shorter than one, whatever the time in stick.
const PATIENCE: f64 = 3.0 * TAU;

/// The story of one trajectory.
#[derive(Debug, Clone)]
pub(super) struct Passage {
    duration: f64,
    /// Displacements at the ends of the slips of cycles.
    pub(super) reattachments: Gathering,
    /// Displacements at detachments after a stick that is not the first.
    pub(super) releases: Gathering,
    /// Times from the detachment of a cycle to that of the next, where the cycle was not lost between.
    pub(super) periods: Gathering,
    /// Time in stick.
    pub(super) stick: f64,
    /// Times in the cycle and out of it, and the former in the second half.
    pub(super) inside: f64,
    pub(super) outside: f64,
    pub(super) late_inside: f64,
    /// Number of ways out of the cycle and back.
    pub(super) exits: u64,
    pub(super) entries: u64,
    /// When the cycle was lost first.
    pub(super) first_exit: Option<f64>,
    stuck_since: Option<f64>,
    detached: Option<f64>,
    last_start: Option<f64>,
    /// End of the last cycle, or the start.
    last_end: f64,
    /// When the mass came into the cycle.
    entered: f64,
    /// Time of slip since the end of the last cycle.
    slipped: f64,
}

impl Passage {
    /// The trajectory of an index, which begins on the cycle, in stick; of each law at most `capacity` values are kept.
    pub(super) fn new(trajectory: usize, duration: f64, capacity: usize) -> Self {
        let [reattachments, releases, periods] = [(); 3].map(|()| Gathering::new(trajectory as u64, capacity));
        Self {
            duration,
            reattachments,
            releases,
            periods,
            stick: 0.0,
            inside: 0.0,
            outside: 0.0,
            late_inside: 0.0,
            exits: 0,
            entries: 0,
            first_exit: None,
            stuck_since: Some(0.0),
            detached: None,
            last_start: None,
            last_end: 0.0,
            entered: 0.0,
            slipped: 0.0,
        }
    }

    /// The end: what is open is closed.
    pub(super) fn finish(&mut self) {
        match (self.stuck_since, self.detached) {
            (Some(since), _) => self.stick += self.duration - since,
            (None, Some(since)) => self.slipped += self.duration - since,
            (None, None) => self.slipped += self.duration,
        }
        if self.slipped > PATIENCE {
            self.lose();
            self.outside += self.duration - self.last_end;
        } else {
            self.stay(self.duration);
        }
    }

    /// Adds the time in the cycle, up to its end.
    fn stay(&mut self, end: f64) {
        self.inside += end - self.entered;
        self.late_inside += (end - self.entered.max(0.5 * self.duration)).max(0.0);
    }

    /// The cycle was lost with its last end.
    fn lose(&mut self) {
        self.stay(self.last_end);
        self.exits += 1;
        self.first_exit.get_or_insert(self.last_end);
    }

    fn cycle(&mut self, end: f64) {
        let start = self.detached;
        if self.slipped > PATIENCE {
            self.lose();
            self.outside += end - self.last_end;
            self.entries += 1;
            self.entered = end;
        } else if let (Some(before), Some(start)) = (self.last_start, start) {
            self.periods.add(start - before);
        }
        (self.last_start, self.last_end, self.slipped) = (start, end, 0.0);
    }
}

impl Witness for Passage {
    fn see(&mut self, event: Event, slipped: Slipped) {
        match event.kind {
            EventKind::Detach => {
                if let Some(since) = self.stuck_since.take() {
                    self.stick += event.tau - since;
                    if self.detached.is_some() {
                        self.releases.add(event.displacement);
                    }
                }
                self.detached = Some(event.tau);
            }
            EventKind::Restick => {
                self.slipped += event.tau - self.detached.unwrap_or(0.0);
                self.stuck_since = Some(event.tau);
                if slipped == Slipped::Cycle {
                    self.reattachments.add(event.displacement);
                    self.cycle(event.tau);
                }
            }
            EventKind::Reverse => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(kind: EventKind, tau: f64) -> Event {
        Event { kind, tau, displacement: tau, sliding_distance: 0.0 }
    }

    /// A story told by its events: detachments and ends of cycles, and of micro-slips.
    fn told(duration: f64, events: &[(char, f64)]) -> Passage {
        let mut passage = Passage::new(0, duration, 100);
        for &(kind, tau) in events {
            match kind {
                'D' => passage.see(event(EventKind::Detach, tau), Slipped::Not),
                'C' => passage.see(event(EventKind::Restick, tau), Slipped::Cycle),
                _ => passage.see(event(EventKind::Restick, tau), Slipped::Micro),
            }
        }
        passage.finish();
        passage
    }

    #[test]
    fn a_steady_cycle_is_never_left() {
        let passage = told(100.0, &[('D', 1.0), ('C', 6.0), ('D', 8.0), ('C', 13.0), ('D', 15.0), ('C', 20.0)]);
        assert_eq!(passage.periods.clone().values(), [7.0, 7.0]);
        assert_eq!(passage.reattachments.clone().values().len(), 3);
        assert_eq!(passage.releases.clone().values(), [8.0, 15.0]);
        // However long the last stick lasts, it is a stick of the cycle.
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
        let passage = told(100.0, &events);
        assert_eq!(passage.periods.clone().values(), [35.0]);
        assert_eq!((passage.exits, passage.entries, passage.first_exit), (2, 1, Some(6.0)));
        // In the cycle from 0 to 6 and from 40 to 46; out of it from 6 to 40 and from 46 on.
        assert_eq!((passage.inside, passage.outside, passage.late_inside), (12.0, 88.0, 0.0));
        assert_eq!(passage.stick, 1.0 + 2.0 + 1.0 + 1.0 + 1.0);
    }

    #[test]
    fn a_mass_that_never_sticks_has_lost_the_cycle_from_the_beginning() {
        let mut passage = Passage::new(0, 50.0, 100);
        passage.see(event(EventKind::Detach, 0.0), Slipped::Not);
        passage.finish();
        assert_eq!((passage.exits, passage.first_exit, passage.outside), (1, Some(0.0), 50.0));
    }
}
