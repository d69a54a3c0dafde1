//! Progress, Ctrl-C and SIGTERM: bars on a terminal, a line every ten seconds elsewhere, nothing when quiet.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asperity::monitor::{Cancelled, Monitor};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::failure::{Failure, Kind};
use crate::output::{record_warning, talk};

/// Time between two lines when stderr is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Time after which another signal ends the program at once. `timeout` sends two in a row.
const IMPATIENT_AFTER: Duration = Duration::from_millis(500);

/// Shows progress on stderr, takes the time of every task, and receives Ctrl-C and SIGTERM.
pub(crate) struct Terminal {
    display: Display,
    tasks: Mutex<BTreeMap<String, Task>>,
    cancelled: Arc<AtomicBool>,
    /// Set while a computation runs that nobody can ask to stop.
    abrupt: Arc<AtomicBool>,
}

enum Display {
    Nothing,
    Bars(MultiProgress),
    Lines,
}

struct Task {
    started: Instant,
    last_line: Instant,
    /// Time of finished rounds.
    spent: Duration,
    done: usize,
    total: usize,
    bar: Option<ProgressBar>,
}

impl Task {
    fn new() -> Self {
        let now = Instant::now();
        Self { started: now, last_line: now, spent: Duration::ZERO, done: 0, total: usize::MAX, bar: None }
    }

    fn finished(&self) -> bool {
        self.done >= self.total
    }

    /// Takes a report, which may come late. Returns whether something new is known.
    fn advance(&mut self, done: usize, total: usize) -> bool {
        if self.finished() {
            // The same task again, as for every damping ratio of a sweep; late reports lie near the end.
            if done > total / 2 {
                return false;
            }
            *self = Self { spent: self.spent, ..Self::new() };
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
    /// Listens for Ctrl-C and SIGTERM. The first signal asks the computation to stop, a later one ends the program.
    pub(crate) fn new(quiet: bool) -> Result<Self, Failure> {
        let cancelled = Arc::new(AtomicBool::new(false));
        let abrupt = Arc::new(AtomicBool::new(false));
        let (flag, at_once) = (Arc::clone(&cancelled), Arc::clone(&abrupt));
        let mut first: Option<Instant> = None;
        on_signal(move || {
            flag.store(true, Ordering::SeqCst);
            let again = first.is_some_and(|first| first.elapsed() > IMPATIENT_AFTER);
            if at_once.load(Ordering::SeqCst) {
                talk(&Failure::from(Cancelled).to_string());
            }
            if again || at_once.load(Ordering::SeqCst) {
                std::process::exit(i32::from(Kind::Cancelled.exit_code()));
            }
            if first.is_none() {
                talk("stopping at the next block; press Ctrl-C again to end at once");
                first = Some(Instant::now());
            }
        })
        .map_err(|e| Failure::new(Kind::Runtime, format!("cannot listen for Ctrl-C: {e}")))?;
        let display = if quiet {
            Display::Nothing
        } else if io::stderr().is_terminal() {
            Display::Bars(MultiProgress::new())
        } else {
            Display::Lines
        };
        Ok(Self { display, tasks: Mutex::default(), cancelled, abrupt })
    }

    /// Tells something that is not data, unless quiet.
    pub(crate) fn note(&self, message: &str) {
        if !matches!(self.display, Display::Nothing) {
            talk(message);
        }
    }

    /// Tells something doubtful, unless quiet; a JSON answer holds it in any case.
    pub(crate) fn warn(&self, message: &str) {
        record_warning(message);
        self.note(&format!("warning: {message}"));
    }

    /// Takes the bars off the screen.
    pub(crate) fn finish(&self) {
        for bar in self.tasks().values().filter_map(|task| task.bar.as_ref()) {
            bar.finish_and_clear();
        }
    }

    /// Ends a command that a signal reached while it was in a part that cannot stop.
    pub(crate) fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Runs a computation that cannot be asked to stop and that writes nothing: a signal ends the program in the midst of it.
    pub(crate) fn at_once<T>(&self, compute: impl FnOnce() -> T) -> Result<T, Cancelled> {
        self.abrupt.store(true, Ordering::SeqCst);
        self.check()?;
        let found = compute();
        self.abrupt.store(false, Ordering::SeqCst);
        self.check()?;
        Ok(found)
    }

    /// Seconds that each task took so far.
    pub(crate) fn seconds(&self) -> BTreeMap<String, f64> {
        self.tasks().iter().map(|(what, task)| (what.clone(), task.time().as_secs_f64())).collect()
    }

    fn tasks(&self) -> MutexGuard<'_, BTreeMap<String, Task>> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Monitor for Terminal {
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
                let bar = task.bar.get_or_insert_with(|| {
                    let bar = all.add(ProgressBar::new(0));
                    if let Ok(style) = ProgressStyle::with_template("{msg:32} {wide_bar} {pos}/{len} {eta:>4} left") {
                        bar.set_style(style);
                    }
                    bar.set_message(what.to_owned());
                    bar
                });
                bar.set_length(total as u64);
                bar.set_position(task.done as u64);
            }
            Display::Lines => {
                if task.last_line.elapsed() >= LINE_EVERY && !task.finished() {
                    task.last_line = Instant::now();
                    talk(&line(what, task.done, total, task.started.elapsed()));
                }
            }
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst)
    }
}

/// Calls `handle` on its own thread for each signal that asks the program to end.
#[cfg(unix)]
fn on_signal(mut handle: impl FnMut() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = vec![SIGINT, SIGTERM];
    // `nohup` has the program ignore the end of its terminal.
    if !ignores_hangup() {
        signals.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(signals)?;
    std::thread::Builder::new().name("signals".into()).spawn(move || signals.forever().for_each(|_| handle()))?;
    Ok(())
}

/// Whether SIGHUP was ignored from the start. Systems that do not tell are taken to.
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

fn line(what: &str, done: usize, total: usize, elapsed: Duration) -> String {
    if done == 0 {
        return format!("{what}: 0 of {total}");
    }
    let left = elapsed.as_secs_f64() * (total - done) as f64 / done as f64;
    format!("{what}: {done} of {total}, about {} left", duration(left))
}

/// A time in words.
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
    fn late_reports_change_nothing_and_a_second_round_begins_again() {
        let mut task = Task::new();
        assert!(task.advance(1, 10) && task.advance(10, 10));
        let first = task.time();
        assert!(!task.advance(9, 10) && task.finished());
        assert_eq!(task.time(), first);
        assert!(task.advance(1, 10) && !task.finished());
        assert!(task.advance(3, 10) && task.advance(2, 10));
        assert_eq!(task.done, 3);
        assert!(task.time() >= first);
    }

    #[test]
    fn the_time_left_is_that_of_the_blocks_left() {
        assert_eq!(line("paths", 0, 9, Duration::from_secs(10)), "paths: 0 of 9");
        assert_eq!(line("paths", 25, 100, Duration::from_secs(10)), "paths: 25 of 100, about 30 s left");
        assert_eq!(line("paths", 1, 61, Duration::from_secs(10)), "paths: 1 of 61, about 10 min left");
        assert_eq!(line("paths", 1, 721, Duration::from_secs(10)), "paths: 1 of 721, about 2.0 h left");
    }
}
