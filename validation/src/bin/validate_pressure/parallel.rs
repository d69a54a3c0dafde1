//! Replicates on two threads, each of which is all that one of them has.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use asperity::pressure::PressureError;

use crate::Result;

/// Replicates at a time.
const THREADS: usize = 2;

/// The results of replicates 0 to `count` in their order; progress goes to standard error.
pub(crate) fn each<T: Send>(
    count: u64,
    what: &str,
    one: impl Fn(u64) -> std::result::Result<T, PressureError> + Sync,
) -> Result<Vec<T>> {
    let (next, start) = (AtomicU64::new(0), Instant::now());
    let work = || -> std::result::Result<Vec<(u64, T)>, PressureError> {
        let mut own = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return Ok(own);
            }
            own.push((number, one(number)?));
            if (number + 1) % count.div_ceil(10) == 0 {
                eprintln!("{what}: {} of {count}, {:.0} s", number + 1, start.elapsed().as_secs_f64());
            }
        }
    };
    let pools = (0..THREADS)
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<std::result::Result<Vec<_>, _>>()?;
    let parts = thread::scope(|scope| {
        let threads: Vec<_> = pools.iter().map(|pool| scope.spawn(|| pool.install(work))).collect();
        threads.into_iter().map(|thread| thread.join()).collect::<Vec<_>>()
    });
    let mut all = Vec::new();
    for part in parts {
        all.extend(part.map_err(|_| "a replicate panicked")??);
    }
    all.sort_by_key(|(number, _)| *number);
    Ok(all.into_iter().map(|(_, found)| found).collect())
}
