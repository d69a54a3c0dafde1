//! How much memory and time a piece of work takes at most.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::time::Duration;

/// The longest that one file may take, unoptimised and on a busy machine: quadratic work would take minutes.
pub(crate) const TIME_LIMIT: Duration = Duration::from_secs(20);

/// The system's allocator with a count of the bytes that each thread and the whole process hold.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

static HELD_BY_ALL: AtomicIsize = AtomicIsize::new(0);
static PEAK_OF_ALL: AtomicIsize = AtomicIsize::new(0);

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn count(bytes: isize) {
    let held = HELD_BY_ALL.fetch_add(bytes, Ordering::Relaxed) + bytes;
    PEAK_OF_ALL.fetch_max(held, Ordering::Relaxed);
    // Memory may be freed after the thread's locals are gone; nobody measures then.
    let _ = HELD.try_with(|held| {
        held.set(held.get() + bytes);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(held.get())));
    });
}

#[expect(unsafe_code, reason = "counting allocations needs an allocator; every call goes to the system's unchanged")]
// SAFETY: every method passes its arguments to `System` and returns its result. Counting touches only two static
// numbers, and thread locals that need no initialisation and no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller's promise about `pointer` and `layout` is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // The old block may live until the new one is filled.
        count(size as isize);
        count(-(layout.size() as isize));
        // SAFETY: the caller's promise about `pointer`, `layout` and `size` is passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Returns the result of `work`, and the maximum number of bytes that all threads held during it in addition to the
/// bytes held before. Other tests must not run meanwhile.
#[allow(dead_code, reason = "each test program uses one of the two")]
pub(crate) fn peak_bytes_of_all_threads<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = HELD_BY_ALL.load(Ordering::Relaxed);
    PEAK_OF_ALL.store(before, Ordering::Relaxed);
    let value = work();
    (value, PEAK_OF_ALL.load(Ordering::Relaxed).saturating_sub(before).max(0) as usize)
}

/// Returns the result of `work`, and the maximum number of bytes that this thread held during it in addition to the
/// bytes held before.
pub(crate) fn peak_bytes<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = HELD.get();
    PEAK.set(before);
    let value = work();
    (value, PEAK.get().saturating_sub(before).max(0) as usize)
}

#[test]
fn the_peak_counts_memory_held_at_one_time() {
    let (kept, peak) = peak_bytes(|| {
        drop(std::hint::black_box(vec![1_u8; 5000]));
        std::hint::black_box(vec![1_u8; 3000])
    });
    assert_eq!(kept.len(), 3000);
    assert!((5000..6000).contains(&peak), "{peak}");
}
