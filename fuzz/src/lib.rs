//! What the fuzz targets share.

use std::sync::{Once, OnceLock};

use asperity_formats::{Format, FormatError, Scan};
use rayon::ThreadPoolBuilder;

#[path = "../../crates/asperity-formats/tests/memory/mod.rs"]
mod memory;

/// The most memory that an input may take beyond twice its size.
const MEMORY_LIMIT: usize = 64 << 20;

/// Does `work` on `length` bytes of input, and fails if it takes too much memory. All of it runs on this thread: edges that depend on the
/// timing of threads would count as news.
pub fn bounded<T>(length: usize, work: impl FnOnce() -> T) -> T {
    static POOL: Once = Once::new();
    POOL.call_once(|| {
        ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("the first pool");
    });
    let (value, peak) = memory::peak_bytes(work);
    assert!(peak <= MEMORY_LIMIT + 2 * length, "{peak} bytes of memory for {length} of input");
    value
}

/// Returns whether content has the format of the target, which `ASPERITY_FORMAT` names; without it every format is wanted. Each format has
/// a target of its own, compressed content too: a target that also followed inputs into other formats would count the edges of their
/// readers.
pub fn is_wanted(content: &[u8]) -> bool {
    static NAME: OnceLock<Option<String>> = OnceLock::new();
    let wanted = NAME.get_or_init(|| std::env::var("ASPERITY_FORMAT").ok());
    // The name of a target ends at a slash, as that of a folder does.
    let is_own = |format: Format| wanted.is_none() || format.name().split('/').next() == wanted.as_deref();
    Format::detect(content).is_some_and(is_own)
}

/// Reads a scan, and checks its invariants.
pub fn read_scan(bytes: &[u8]) -> Result<Scan, FormatError> {
    let scan = bounded(bytes.len(), || asperity_formats::read_bytes(bytes))?;
    assert!(!scan.heights_m.is_empty() && scan.heights_m.iter().all(|z| !z.is_infinite()));
    assert!(scan.pitch_m.is_none_or(|(dx, dy)| dx > 0.0 && dy > 0.0 && dx.is_finite() && dy.is_finite()));
    assert!(scan.channels.is_empty() || scan.channel < scan.channels.len());
    Ok(scan)
}

/// Splits an input at lines `--- NAME` into named parts; what stands before the first such line is left out.
pub fn parts(input: &[u8]) -> Vec<(String, &[u8])> {
    const MARK: &[u8] = b"\n--- ";
    let marks: Vec<usize> =
        input.windows(MARK.len()).enumerate().filter(|(_, window)| *window == MARK).map(|(at, _)| at).collect();
    let ends = marks.iter().skip(1).copied().chain([input.len()]);
    let part = |(start, end): (usize, usize)| {
        let part = &input[start + MARK.len()..end.max(start + MARK.len())];
        let name = part.split(|byte| *byte == b'\n').next().unwrap_or_default();
        (String::from_utf8_lossy(name).into_owned(), part.get(name.len() + 1..).unwrap_or_default())
    };
    marks.iter().copied().zip(ends).map(part).collect()
}
