//! The scan in the figures.

use asperity_results::{SurfaceResult, SurfaceStatistics};

use crate::Run;

/// Returns the statistics of the scan in the figures: the first of several.
pub(super) fn scan(run: &Run) -> Option<&SurfaceStatistics> {
    let surface = run.results.surface.as_ref()?;
    surface.scan().or_else(|| Some(&surface.part()?.scans.first()?.statistics))
}

/// Returns a sentence for a caption that names the scan in the figure; empty if there is only one.
pub(super) fn scan_sentence(run: &Run) -> String {
    let scans = run.results.surface.as_ref().and_then(SurfaceResult::part).map_or(&[][..], |part| &part.scans);
    match scans {
        [first, _, ..] => {
            let (file, count) = (&first.file, scans.len());
            format!(" Measured: {file}, the first of {count} scans; the random surface is fitted to all of them.")
        }
        _ => String::new(),
    }
}
