//! Progress, Ctrl-C and SIGTERM: bars on a terminal, a line every ten seconds elsewhere, nothing when quiet.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use asperity::monitor::{Cancelled, Monitor};
use asperity::study::result::StageCost;
use asperity::study::{forget_peak_memory, peak_memory_bytes};
use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};

use crate::failure::{Failure, Kind};
use crate::output::{print_message, record_warning};

/// Time between two progress lines if stderr is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Time after which another signal ends the program immediately. `timeout` sends two in a row.
const FORCE_EXIT_AFTER: Duration = Duration::from_millis(500);

/// Time after a signal at which the program ends, although blocks are not finished.
const EXIT_AFTER: Duration = Duration::from_millis(1200);

/// Work that a signal must do before it ends the program, and whether the same command goes on from what it stored; `None` once the result
/// is at its destination.
type Last = Option<Vec<Box<dyn FnOnce() -> bool + Send>>>;

/// Progress display on stderr, timer of tasks, and receiver of Ctrl-C and SIGTERM.
pub(crate) struct Terminal {
    display: Display,
    tasks: Mutex<BTreeMap<String, Task>>,
    cancelled: Arc<AtomicBool>,
    /// Set during a computation that cannot be cancelled; a signal then ends the program.
    exit_immediately: Arc<AtomicBool>,
    last: Arc<Mutex<Last>>,
    /// Stages begun, with their starts and peaks of memory.
    stages: Mutex<Vec<Stage>>,
    /// Start of the computation, and its time limit.
    limit: OnceLock<(Instant, Duration)>,
}

struct Stage {
    name: String,
    started: Instant,
    ended: Option<(Duration, Option<f64>)>,
}

enum Display {
    Nothing,
    Bars(MultiProgress),
    Lines,
}

struct Task {
    started: Instant,
    last_line: Instant,
    /// Time and steps of finished rounds.
    spent: Duration,
    before: usize,
    done: usize,
    total: usize,
    bar: Option<ProgressBar>,
}

impl Task {
    fn new() -> Self {
        let now = Instant::now();
        Self { started: now, last_line: now, spent: Duration::ZERO, before: 0, done: 0, total: usize::MAX, bar: None }
    }

    fn finished(&self) -> bool {
        self.done >= self.total
    }

    /// Records a progress report, possibly out of order. Returns whether it changed anything.
    fn advance(&mut self, done: usize, total: usize) -> bool {
        if self.finished() {
            // The same task begins again, for example for the next damping ratio of a sweep. Late reports are near the
            // end.
            if done > total / 2 {
                return false;
            }
            *self = Self { spent: self.spent, before: self.before + self.total, ..Self::new() };
        }
        (self.done, self.total) = (self.done.max(done), total);
        if self.finished() {
            self.spent += self.started.elapsed();
        }
        true
    }

    fn time(&self) -> Duration {
        if self.finished() { self.spent } else { self.spent + self.started.elapsed() }
    }
}

impl Terminal {
    /// Starts to listen for Ctrl-C and SIGTERM. The first signal cancels the computation, a later one ends the program.
    pub(crate) fn new(quiet: bool) -> Result<Self, Failure> {
        let cancelled = Arc::new(AtomicBool::new(false));
        let exit_immediately = Arc::new(AtomicBool::new(false));
        let (flag, exit_now) = (Arc::clone(&cancelled), Arc::clone(&exit_immediately));
        let last = Arc::new(Mutex::new(Some(Vec::new())));
        let at_exit = Arc::clone(&last);
        let mut first: Option<Instant> = None;
        on_signal(move || {
            flag.store(true, Ordering::SeqCst);
            let again = first.is_some_and(|first| first.elapsed() > FORCE_EXIT_AFTER);
            if exit_now.load(Ordering::SeqCst) {
                print_message(&Failure::from(Cancelled).to_string());
            }
            if again || exit_now.load(Ordering::SeqCst) {
                std::process::exit(i32::from(Kind::Cancelled.exit_code()));
            }
            if first.is_none() {
                print_message("stopping; press Ctrl-C again to stop immediately");
                first = Some(Instant::now());
                let last = Arc::clone(&at_exit);
                std::thread::spawn(move || exit_soon(&last));
            }
        })
        .map_err(|error| Failure::io(Kind::Runtime, "cannot listen for Ctrl-C", &error))?;
        let display = if quiet {
            Display::Nothing
        } else if io::stderr().is_terminal() {
            Display::Bars(MultiProgress::new())
        } else {
            Display::Lines
        };
        Ok(Self {
            display,
            tasks: Mutex::default(),
            cancelled,
            exit_immediately,
            last,
            stages: Mutex::default(),
            limit: OnceLock::new(),
        })
    }

    /// Adds what is left to do if a signal ends the program before its blocks are finished. The work returns whether the same command
    /// goes on from what it stored.
    pub(crate) fn before_exit(&self, work: impl FnOnce() -> bool + Send + 'static) {
        if let Some(last) = self.last.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            last.push(Box::new(work));
        }
    }

    /// Moves a result to its destination, which no signal interrupts.
    pub(crate) fn commit<T>(&self, commit: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        self.check()?;
        let found = commit()?;
        *last = None;
        Ok(found)
    }

    /// Cancels the computation after a time.
    pub(crate) fn limit_time(&self, time: Duration) {
        let _ = self.limit.set((Instant::now(), time));
    }

    /// Returns the time for the computation if it has passed.
    pub(crate) fn exceeded_time(&self) -> Option<Duration> {
        self.limit.get().filter(|(started, limit)| started.elapsed() > *limit).map(|(_, limit)| *limit)
    }

    /// Prints a message to stderr, unless quiet.
    pub(crate) fn note(&self, message: &str) {
        if !matches!(self.display, Display::Nothing) {
            print_message(message);
        }
    }

    /// Prints a warning, unless quiet, and records it for the JSON answer.
    pub(crate) fn warn(&self, message: &str) {
        record_warning(message);
        self.note(&format!("warning: {message}"));
    }

    /// Removes the progress bars from the screen.
    pub(crate) fn finish(&self) {
        for bar in self.tasks().values().filter_map(|task| task.bar.as_ref()) {
            bar.finish_and_clear();
        }
    }

    /// Fails if a signal arrived during a part that cannot be cancelled.
    pub(crate) fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Runs a computation that cannot be cancelled and writes nothing. A signal ends the program immediately.
    pub(crate) fn killable<T>(&self, compute: impl FnOnce() -> T) -> Result<T, Cancelled> {
        self.exit_immediately.store(true, Ordering::SeqCst);
        self.check()?;
        let found = compute();
        self.exit_immediately.store(false, Ordering::SeqCst);
        self.check()?;
        Ok(found)
    }

    /// Returns the seconds that each task took so far.
    pub(crate) fn seconds(&self) -> BTreeMap<String, f64> {
        self.tasks().iter().map(|(what, task)| (what.clone(), task.time().as_secs_f64())).collect()
    }

    /// Returns the time and the peak of memory of each stage so far.
    pub(crate) fn stages(&self) -> BTreeMap<String, StageCost> {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = stages.last_mut() {
            last.end();
        }
        let cost = |stage: &Stage| {
            let (time, peak_memory_bytes) = stage.ended.unwrap_or_default();
            (stage.name.clone(), StageCost { seconds: time.as_secs_f64(), peak_memory_bytes })
        };
        stages.iter().map(cost).collect()
    }

    fn tasks(&self) -> MutexGuard<'_, BTreeMap<String, Task>> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Stage {
    fn end(&mut self) {
        self.ended.get_or_insert_with(|| (self.started.elapsed(), peak_memory_bytes()));
    }
}

impl Monitor for Terminal {
    fn begin(&self, stage: &str) {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = stages.last_mut() {
            last.end();
        }
        forget_peak_memory();
        stages.push(Stage { name: stage.to_owned(), started: Instant::now(), ended: None });
    }

    fn progress(&self, what: &str, done: usize, total: usize) {
        let mut tasks = self.tasks();
        let task = tasks.entry(what.to_owned()).or_insert_with(Task::new);
        if !task.advance(done, total) {
            return;
        }
        match &self.display {
            Display::Nothing => {}
            Display::Bars(_) if task.finished() => {
                if let Some(bar) = task.bar.take() {
                    bar.finish_and_clear();
                }
            }
            Display::Bars(all) => {
                let (before, total) = (task.before as u64, total as u64);
                let bar = task.bar.get_or_insert_with(|| {
                    let bar = ProgressBar::new(before + total).with_message(what.to_owned()).with_position(before);
                    if let Ok(style) = ProgressStyle::with_template("{msg:32} {wide_bar} {pos}/{len} {left:>9}") {
                        bar.set_style(style.with_key("left", left));
                    }
                    all.add(bar)
                });
                bar.set_length(before + total);
                bar.set_position(before + task.done as u64);
            }
            Display::Lines => {
                if task.last_line.elapsed() >= LINE_INTERVAL && !task.finished() {
                    task.last_line = Instant::now();
                    print_message(&line(what, task.before, [task.done, total], task.started.elapsed()));
                }
            }
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst) || self.exceeded_time().is_some()
    }
}

/// Ends the program some time after a signal, unless it ended by itself.
fn exit_soon(last: &Mutex<Last>) {
    std::thread::sleep(EXIT_AFTER);
    // A result that is on its way to its destination comes first.
    let Some(work) = last.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
    let goes_on = work.into_iter().fold(false, |goes_on, work| work() | goes_on);
    print_message(Failure::cancelled(goes_on).message());
    std::process::exit(i32::from(Kind::Cancelled.exit_code()));
}

/// Calls `handle` on its own thread for each signal that asks the program to end.
#[cfg(unix)]
fn on_signal(mut handle: impl FnMut() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = vec![SIGINT, SIGTERM];
    // `nohup` makes the program ignore the hangup of its terminal.
    if !ignores_hangup() {
        signals.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(signals)?;
    std::thread::Builder::new().name("signals".into()).spawn(move || signals.forever().for_each(|_| handle()))?;
    Ok(())
}

/// Returns whether SIGHUP was ignored from the start; true on systems that do not report it.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_none_or(|mask| mask & 1 != 0)
}

#[cfg(not(unix))]
fn on_signal(handle: impl FnMut() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(handle).map_err(io::Error::other)
}

/// Returns a progress line: steps of this round and of the `before` ones of finished rounds, so that a task never goes backwards.
fn line(what: &str, before: usize, [done, total]: [usize; 2], elapsed: Duration) -> String {
    let steps = format!("{what}: {} of {}", before + done, before + total);
    if done == 0 {
        return steps;
    }
    match elapsed.as_secs_f64() * (total - done) as f64 / done as f64 {
        left if left < 1.0 => format!("{steps}, almost done"),
        left => format!("{steps}, about {} left", duration(left)),
    }
}

/// Writes the time that a bar needs to its end; nothing before its first step and in its last second.
fn left(state: &ProgressState, writer: &mut dyn Write) {
    let seconds = state.eta().as_secs_f64();
    if state.pos() > 0 && seconds >= 1.0 {
        let _ = write!(writer, "{} left", duration(seconds));
    }
}

/// Formats a duration with a unit.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_reports_change_nothing_and_a_second_round_restarts_the_task() {
        let mut task = Task::new();
        assert!(task.advance(1, 10) && task.advance(10, 10));
        let first = task.time();
        assert!(!task.advance(9, 10) && task.finished());
        assert_eq!(task.time(), first);
        assert!(task.advance(1, 10) && !task.finished());
        assert!(task.advance(3, 10) && task.advance(2, 10));
        assert_eq!((task.before, task.done), (10, 3));
        assert!(task.time() >= first);
    }

    #[test]
    fn the_remaining_time_is_proportional_to_the_remaining_blocks() {
        for (before, done, total, wanted) in [
            (0, 0, 9, "paths: 0 of 9"),
            (0, 25, 100, "paths: 25 of 100, about 30 s left"),
            (0, 1, 61, "paths: 1 of 61, about 10 min left"),
            (0, 1, 721, "paths: 1 of 721, about 2.0 h left"),
            (0, 63, 64, "paths: 63 of 64, almost done"),
            (192, 96, 192, "paths: 288 of 384, about 10 s left"),
        ] {
            assert_eq!(line("paths", before, [done, total], Duration::from_secs(10)), wanted);
        }
    }
}
