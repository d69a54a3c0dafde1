//! Loops that a run leaves to other processes, because they finish them earlier.

use std::time::{Duration, Instant};

/// Time of the first measurement of a loop in seconds, if starting elsewhere takes longer than twice that.
const MEASURED_S: f64 = 0.5;
/// A loop is left if it then takes less than this fraction of its time.
const GAIN: f64 = 0.8;
/// Time in seconds that each part takes to be distributed and gathered.
const PART_S: f64 = 0.002;
/// Least work of a part in seconds on one thread, and over the time in which it repeats what lies between the loops.
const LEAST_S: f64 = 1.0;
const LEAST_PER_REPEATED: f64 = 8.0;
const MOST_PARTS: usize = 1000;

/// Threads of other processes that compute loops in parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Others {
    /// Number of threads.
    pub threads: usize,
    /// Number of parts of a loop; `None` if it follows from the work.
    pub parts: Option<usize>,
    /// Time until the first part begins, in seconds.
    pub start_s: f64,
}

/// Loop that a run left to other processes.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftLoop {
    /// Stage of the loop: that of a study, or `campaign`.
    pub stage: String,
    /// Name of the loop.
    pub name: String,
    /// Number of parts in which to compute it.
    pub parts: usize,
    /// Time that this process needs for the rest of it, in seconds.
    pub left_s: f64,
}

impl Others {
    /// Returns the number of parts in which others compute `blocks` blocks of `block_s` seconds on one thread, if they finish earlier than
    /// `own` threads here. This process and each part repeat `repeated_s` seconds of other work.
    fn parts(&self, blocks: usize, block_s: f64, own: usize, repeated_s: f64) -> Option<usize> {
        if self.threads == 0 {
            return None;
        }
        let work_s = blocks as f64 * block_s;
        let least_s = LEAST_S.max(LEAST_PER_REPEATED * repeated_s);
        // All threads are busy until the end.
        let stated = self.parts.unwrap_or(self.threads * ((work_s / self.threads as f64 / least_s) as usize).max(1));
        let parts = stated.min(blocks).clamp(1, MOST_PARTS);
        let part_s = repeated_s + blocks.div_ceil(parts) as f64 * block_s;
        // Blocks that are being computed here end first.
        let distributed_s = block_s + self.start_s + PART_S * parts as f64;
        let elsewhere_s = distributed_s + parts.div_ceil(self.threads) as f64 * part_s + repeated_s;
        (elsewhere_s < GAIN * work_s / own as f64).then_some(parts)
    }
}

/// Times of the loop that is computed.
#[derive(Debug)]
pub(super) struct Clock {
    /// Number of the loop in the run; `None` before the first block.
    pub(super) place: Option<usize>,
    /// Time when its first block began.
    begun: Instant,
    computed: usize,
    /// Time when the last block ended, or the run began.
    ended: Instant,
    /// Time between the loops so far, which a computation with all their blocks repeats.
    repeated: Duration,
    pub(super) left: Option<LeftLoop>,
}

impl Clock {
    pub(super) fn start() -> Self {
        let now = Instant::now();
        Self { place: None, begun: now, computed: 0, ended: now, repeated: Duration::ZERO, left: None }
    }

    /// Records that a block of the loop has ended.
    pub(super) fn end_block(&mut self) {
        self.computed += 1;
        self.ended = Instant::now();
    }

    /// Records that a block of the loop number `place` may begin, of which `blocks` are missing. Returns the number of parts in which to
    /// leave the loop to others and the seconds that `own` threads here need, if others finish earlier.
    pub(super) fn leaves(&mut self, place: usize, blocks: usize, own: usize, others: &Others) -> Option<(usize, f64)> {
        if self.place.replace(place) != Some(place) {
            (self.begun, self.computed) = (Instant::now(), 0);
            self.repeated += self.ended.elapsed();
        }
        let elapsed_s = self.begun.elapsed().as_secs_f64();
        if self.computed == 0 || elapsed_s < MEASURED_S.min(0.5 * others.start_s) {
            return None;
        }
        // Each thread may be about to end its first block.
        let block_s = elapsed_s * own as f64 / self.computed.max(own) as f64;
        let parts = others.parts(blocks, block_s, own, self.repeated.as_secs_f64())?;
        Some((parts, blocks as f64 * block_s / own as f64))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use asperity_base::blocks::Task;
    use asperity_base::monitor::{Cancelled, Monitor, Silent};

    use super::*;
    use crate::{RunBlocks, RunRecord, Share};

    /// Computes two loops of a run. Returns their sums, the number of computed blocks, and the loop that was left.
    fn computed(run: &Path, share: Share) -> (Result<u64, Cancelled>, usize, Option<LeftLoop>) {
        let blocks = RunBlocks::open(run, RunRecord::default(), share).unwrap();
        let stage = blocks.stage("stage", &0, &Silent).unwrap();
        let count = AtomicUsize::new(0);
        let sum = |name: &str| {
            let block = |index| {
                count.fetch_add(1, Ordering::Relaxed);
                Ok::<u64, Cancelled>(index as u64)
            };
            Task::new(&stage as &dyn Monitor, name, 30).map(30, block).map(|found| found.iter().sum::<u64>())
        };
        let found = sum("first").and_then(|first| Ok(first + sum("second")?));
        blocks.flush().unwrap();
        (found, count.into_inner(), blocks.left())
    }

    #[test]
    fn a_loop_is_left_with_its_finished_blocks_and_then_computed_in_parts() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let share = |threads| Share::UnlessFaster(Others { threads, parts: Some(2), start_s: f64::NEG_INFINITY });
        let (found, first, left) = computed(&run, share(8));
        let left = left.unwrap();
        assert_eq!((found, left.stage.as_str(), left.name.as_str(), left.parts), (Err(Cancelled), "stage", "first", 2));
        assert!((1..30).contains(&first), "{first}");
        let mut missing = 30 - first;
        for number in [1, 2] {
            let part = folder.path().join(format!("part-{number}"));
            missing -= computed(&part, Share::Part { number, of: 2 }).1;
        }
        assert_eq!(missing, 0);
        let blocks = RunBlocks::open(&run, RunRecord::default(), Share::None).unwrap();
        (1..=2).for_each(|number| blocks.import(&folder.path().join(format!("part-{number}"))).unwrap());
        // The first loop is complete now; without others the second one is not left.
        assert_eq!(computed(&run, share(8)).2.unwrap().name, "second");
        let (found, _, left) = computed(&run, share(0));
        assert_eq!((found, left), (Ok(2 * 435), None));
    }

    #[test]
    fn parts_follow_from_the_work_and_are_left_only_for_a_gain() {
        let parts = |threads, parts, seconds: f64, repeated_s| {
            // Two threads here would take `seconds`.
            Others { threads, parts, start_s: 1.0 }.parts(10_000, 2.0 * seconds / 10_000.0, 2, repeated_s)
        };
        // As many threads elsewhere, or none, gain nothing; short loops neither.
        assert_eq!(parts(2, None, 1000.0, 0.0), None);
        assert_eq!(parts(0, None, 1000.0, 0.0), None);
        assert_eq!(parts(64, None, 1.0, 0.0), None);
        // A part has at least a second of work, and more if it repeats more; all threads are busy.
        assert_eq!(parts(64, None, 100.0, 0.0), Some(192));
        assert_eq!(parts(8, None, 100.0, 0.5), Some(48));
        assert_eq!(parts(8, None, 100.0, 5.0), Some(8));
        assert_eq!(parts(8, None, 100.0, 40.0), None);
        assert_eq!(parts(8, None, 100_000.0, 0.0), Some(MOST_PARTS));
        // A stated number holds unless its repetitions outweigh the gain.
        assert_eq!(parts(8, Some(32), 100.0, 1.0), Some(32));
        assert_eq!(parts(8, Some(200), 100.0, 1.0), Some(200));
        assert_eq!(parts(8, Some(800), 100.0, 1.0), None);
        assert_eq!(parts(4, Some(1), 100.0, 0.0), None);
    }

    #[test]
    fn few_blocks_make_few_parts() {
        let others = Others { threads: 64, parts: None, start_s: 1.0 };
        assert_eq!(others.parts(40, 10.0, 2, 0.0), Some(40));
        // The last of them would take as long as all here.
        assert_eq!(others.parts(2, 100.0, 2, 0.0), None);
    }
}
