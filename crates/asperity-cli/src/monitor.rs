//! Progress and Ctrl-C: bars on a terminal, a line every ten seconds elsewhere, nothing when quiet.

use std::collections::HashMap;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use asperity::monitor::{Cancelled, Monitor};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::failure::{Failure, Kind};
use crate::output::talk;

/// Time between two lines when stderr is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Shows progress on stderr and learns of Ctrl-C.
pub(crate) struct Terminal {
    display: Display,
    cancelled: Arc<AtomicBool>,
}

enum Display {
    Nothing,
    Bars { all: MultiProgress, tasks: Mutex<HashMap<String, ProgressBar>> },
    Lines(Mutex<HashMap<String, Task>>),
}

struct Task {
    started: Instant,
    last_line: Instant,
    done: usize,
}

impl Terminal {
    /// Installs the handler of Ctrl-C. The first one asks the computation to stop, the second one ends the program.
    pub(crate) fn new(quiet: bool) -> Result<Self, Failure> {
        let cancelled = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&cancelled);
        ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(i32::from(Kind::Cancelled.exit_code()));
            }
            talk("stopping at the next block; press Ctrl-C again to end at once");
        })
        .map_err(|e| Failure::new(Kind::Runtime, format!("cannot listen for Ctrl-C: {e}")))?;
        let display = if quiet {
            Display::Nothing
        } else if io::stderr().is_terminal() {
            Display::Bars { all: MultiProgress::new(), tasks: Mutex::default() }
        } else {
            Display::Lines(Mutex::default())
        };
        Ok(Self { display, cancelled })
    }

    /// Tells something that is neither data nor a warning, unless quiet.
    pub(crate) fn note(&self, message: &str) {
        if !matches!(self.display, Display::Nothing) {
            talk(message);
        }
    }

    /// Takes the bars off the screen.
    pub(crate) fn finish(&self) {
        if let Display::Bars { tasks, .. } = &self.display {
            for bar in tasks.lock().unwrap_or_else(PoisonError::into_inner).values() {
                bar.finish_and_clear();
            }
        }
    }

    /// Ends a command that Ctrl-C reached while it was in a part that cannot stop.
    pub(crate) fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

impl Monitor for Terminal {
    fn progress(&self, what: &str, done: usize, total: usize) {
        match &self.display {
            Display::Nothing => {}
            Display::Bars { all, tasks } => {
                let mut tasks = tasks.lock().unwrap_or_else(PoisonError::into_inner);
                let bar = tasks.entry(what.to_owned()).or_insert_with(|| {
                    let bar = all.add(ProgressBar::new(total as u64));
                    if let Ok(style) = ProgressStyle::with_template("{msg:32} {wide_bar} {pos}/{len} {eta:>4} left") {
                        bar.set_style(style);
                    }
                    bar.set_message(what.to_owned());
                    bar
                });
                bar.set_length(total as u64);
                bar.set_position(bar.position().max(done as u64));
                if done >= total {
                    bar.finish_and_clear();
                    tasks.remove(what);
                }
            }
            Display::Lines(tasks) => {
                let mut tasks = tasks.lock().unwrap_or_else(PoisonError::into_inner);
                let now = Instant::now();
                let task = tasks.entry(what.to_owned()).or_insert(Task { started: now, last_line: now, done: 0 });
                task.done = task.done.max(done);
                if now - task.last_line >= LINE_EVERY && task.done < total {
                    task.last_line = now;
                    talk(&line(what, task.done, total, now - task.started));
                }
            }
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst)
    }
}

fn line(what: &str, done: usize, total: usize, elapsed: Duration) -> String {
    if done == 0 {
        return format!("{what}: 0 of {total}");
    }
    let left = elapsed.as_secs_f64() * (total - done) as f64 / done as f64;
    format!("{what}: {done} of {total}, about {} left", duration(left))
}

fn duration(seconds: f64) -> String {
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
    fn the_time_left_is_that_of_the_blocks_left() {
        assert_eq!(line("paths", 0, 9, Duration::from_secs(10)), "paths: 0 of 9");
        assert_eq!(line("paths", 25, 100, Duration::from_secs(10)), "paths: 25 of 100, about 30 s left");
        assert_eq!(line("paths", 1, 61, Duration::from_secs(10)), "paths: 1 of 61, about 10 min left");
        assert_eq!(line("paths", 1, 721, Duration::from_secs(10)), "paths: 1 of 721, about 2.0 h left");
    }
}
