//! Counts of the intervals that contain the truth.

use std::path::Path;

/// Names the folder of the counts, one file each, for the page of coverages in the documentation.
const FOLDER: &str = "ASPERITY_COVERAGE";

/// Returns the number of repetitions of a count: a thousand for the documentation, otherwise `quick`.
pub fn repetitions(quick: usize) -> usize {
    if folder().is_some() { 1000 } else { quick }
}

/// Returns the least fraction of `of` intervals of 95 % that must contain the truth: 94 % less three standard errors.
pub fn least_coverage(of: usize) -> f64 {
    0.94 - 3.0 * (0.95 * 0.05 / of as f64).sqrt()
}

/// Returns the fraction of `of` intervals that contain the truth, and writes it for the documentation.
///
/// `interval` names the kind of interval as the report does, and `case` the problem with known truth.
///
/// # Panics
///
/// Panics if the file cannot be written.
#[expect(clippy::expect_used, reason = "a test without its count must fail")]
#[expect(clippy::disallowed_methods, reason = "the counts of many test programs meet in a folder")]
pub fn covered(interval: &str, case: &str, held: usize, of: usize) -> f64 {
    if let Some(folder) = folder() {
        let name: String =
            format!("{interval} {case}").chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        let line = format!("{interval} | {case} | {held} | {of}\n");
        std::fs::write(Path::new(&folder).join(name), line).expect("the count can be written");
    }
    held as f64 / of as f64
}

#[expect(clippy::disallowed_methods, reason = "the documentation asks for more repetitions than a test")]
fn folder() -> Option<std::ffi::OsString> {
    std::env::var_os(FOLDER)
}
