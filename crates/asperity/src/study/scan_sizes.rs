//! Sizes of strips, windows and patches that suit a scan.

use std::fmt;
use std::path::Path;

use super::check::SurfaceStudy;
use super::file::FrictionSection;
use super::output::StageOutput;
use super::profile::MeasuredProfile;
use super::surface_scans::measure_all;
use super::{Study, StudyError, StudyFile, sentence};
use crate::correlation::Axis;
use crate::surface::model::SurfaceRequest;

/// Pitch of the strips over the shortest wave that the scan resolves.
const PITCH: f64 = 0.25;
/// Sides over correlation lengths: of a patch, the width of a strip and its least width, the length of a window, the windows of a strip,
/// and the least length of a strip.
const PATCH: f64 = 6.4;
const WIDTH: f64 = 8.0;
const NARROWEST: f64 = 4.0;
const WINDOW: f64 = 30.0;
const WINDOWS: f64 = 10.0;
const SHORTEST: f64 = 60.0;
/// Least points of a scan along either axis, from which sizes follow.
const LEAST_POINTS: usize = 32;
/// Least points across a strip, and points of a strip: as many as a study of minutes solves.
const ACROSS: f64 = 32.0;
const POINTS: f64 = 260_000.0;

/// Sizes of a study on one scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanSizes {
    /// Length in metre of the shortest wave of the random strips: the one that the study states, or the shortest that the scan resolves.
    pub shortest_wave_m: f64,
    /// Correlation lengths (x, y) in metre at which the autocorrelation of the scan falls to 1/e.
    pub correlation_length_m: [f64; 2],
    /// Sides (x, y) of a patch in metre.
    pub patch_m: [f64; 2],
    /// Sides (x, y) of a strip in metre.
    pub strip_m: [f64; 2],
    /// Points (x, y) of a strip.
    pub strip_points: [usize; 2],
}

impl StudyFile {
    /// Fills in the sizes of strips and windows that are left out with those that suit the scan. Without a usable scan, which the run reports,
    /// the usual ones remain.
    pub(super) fn fill_in_sizes(&mut self, folder: &Path) {
        let states_all = |f: &FrictionSection| f.strip.is_some() && f.points.is_some() && f.window.is_some();
        if self.friction.as_ref().is_none_or(states_all) {
            return;
        }
        let sizes = self.check_surface().ok().flatten().and_then(|surface| ScanSizes::of(&surface, folder).ok());
        if let (Some(section), Some(sizes)) = (&mut self.friction, sizes) {
            section.fill_in_sizes(Some(&sizes));
        }
    }
}

impl Study {
    /// Returns the sizes that suit the scan of `[surface]`; `folder` is the folder of the study file. Four points resolve the shortest wave
    /// of the strips. Windows are tens of correlation lengths long, and strips contain ten of them where a study of minutes allows it.
    ///
    /// # Errors
    /// The study has no scan, or the scan cannot be read, has few points or no correlation length.
    pub fn scan_sizes(&self, folder: &Path) -> Result<ScanSizes, StudyError> {
        let surface = self.surface.as_ref().ok_or(StudyError::NoStage("surface"))?;
        for (_, scan) in surface.read_scans(folder)? {
            let (ny, nx) = scan.heights_m.dim();
            if nx.min(if scan.is_profile() { nx } else { ny }) < LEAST_POINTS {
                return Err(StudyError::FewPoints { found: [nx, ny], least: LEAST_POINTS });
            }
        }
        ScanSizes::of(surface, folder)
    }
}

impl fmt::Display for ScanSizes {
    /// States the properties of the scan from which the sizes follow.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.correlation_length_m.map(|length_m| sentence::si(length_m, "m"));
        let wave = sentence::si(self.shortest_wave_m, "m");
        write!(f, "The scan resolves waves down to {wave}; its correlation lengths are {x} along x and {y} along y.")
    }
}

impl ScanSizes {
    fn of(surface: &SurfaceStudy, folder: &Path) -> Result<Self, StudyError> {
        let scans = surface.read_scans(folder)?;
        if let Some(profile) = MeasuredProfile::of(surface, &scans, &mut StageOutput::default())? {
            let length_m = profile.statistics.correlation_length_m.ok_or(StudyError::NoCorrelationLength)?;
            return Ok(Self::new(profile.shortest_wave_m, [length_m; 2]));
        }
        let measured = measure_all(&surface.preparation, scans, &mut StageOutput::default())?;
        let scan = measured.ok_or(StudyError::NoStage("surface"))?;
        let length_m = |axis| scan.correlation.correlation_length_m(axis);
        let lengths_m = length_m(Axis::X).zip(length_m(Axis::Y)).ok_or(StudyError::NoCorrelationLength)?;
        let shortest_wave_m = match surface.request {
            SurfaceRequest::Translated { shortest_wave_m: Some(stated_m), .. } => stated_m,
            _ => scan.shortest_wave_m()?,
        };
        Ok(Self::new(shortest_wave_m, lengths_m.into()))
    }

    fn new(shortest_wave_m: f64, correlation_length_m: [f64; 2]) -> Self {
        let [x_m, y_m] = correlation_length_m;
        // The pitch is that of the shortest wave, or coarser where a strip would otherwise be too short.
        let affordable_m = (SHORTEST * x_m * NARROWEST * y_m / POINTS).sqrt().max(SHORTEST * x_m * ACROSS / POINTS);
        let pitch_m = two_digits((PITCH * shortest_wave_m).max(affordable_m));
        let across = even((WIDTH * y_m / pitch_m).min(POINTS * pitch_m / (SHORTEST * x_m)).max(ACROSS));
        let along = even((WINDOWS * WINDOW * x_m / pitch_m).min(POINTS / across));
        let strip_m = [along * pitch_m, across * pitch_m];
        Self {
            shortest_wave_m,
            correlation_length_m,
            patch_m: correlation_length_m.map(|length_m| two_digits(PATCH * length_m)),
            strip_m,
            strip_points: [along as usize, across as usize],
        }
    }

    /// Returns the points of another strip: as close, or as close as a study of minutes allows.
    pub(super) fn points_of(&self, strip_m: [f64; 2]) -> [usize; 2] {
        let affordable_m = (strip_m[0] * strip_m[1] / POINTS).sqrt();
        let pitch_m = (self.strip_m[0] / self.strip_points[0] as f64).max(affordable_m);
        strip_m.map(|side_m| even(side_m / pitch_m).max(16.0) as usize)
    }

    /// Returns the length of the window of a strip in metre.
    pub fn window_m(strip_m: f64) -> f64 {
        strip_m / WINDOWS
    }
}

/// Returns a number of points, for which transforms are fast.
fn even(points: f64) -> f64 {
    16.0 * (points / 16.0).round()
}

/// Returns a positive number with two digits, rounded up.
fn two_digits(value: f64) -> f64 {
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    (value / unit).ceil() * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_the_example_are_near_those_of_its_study() {
        let found = ScanSizes::new(8e-6, [20e-6, 20e-6]);
        assert_eq!(found.strip_points, [3008, 80]);
        for (found, wanted) in [(found.strip_m, [6.016e-3, 160e-6]), (found.patch_m, [130e-6, 130e-6])] {
            assert!(found.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?}");
        }
        assert!((ScanSizes::window_m(found.strip_m[0]) - 601.6e-6).abs() < 1e-12);
        assert_eq!(found.points_of([6.016e-3, 75e-6]), [3008, 32]);
        let [nx, ny] = found.points_of([0.1, 1e-3]);
        assert!(nx * ny <= 270_000 && nx / ny >= 95, "{nx} {ny}");
    }

    #[test]
    fn strips_of_any_scan_are_affordable_and_longer_than_their_windows() {
        for wave in [1e-9, 3e-8, 1e-6, 2e-4] {
            for ratios in [[1.0, 1.0], [3.0, 100.0], [1000.0, 2.0], [1e5, 1e5]] {
                let found = ScanSizes::new(wave, ratios.map(|ratio| ratio * wave));
                let [nx, ny] = found.strip_points.map(|points| points as f64);
                assert!(nx * ny <= 1.1 * POINTS && ny >= ACROSS, "{found:?}");
                let lengths = [found.strip_m[0] / ratios[0], found.strip_m[1] / ratios[1]].map(|sides| sides / wave);
                assert!(lengths[0] > 50.0 && lengths[1] > 3.5, "{found:?}");
                let pitches = [found.strip_m[0] / nx, found.strip_m[1] / ny];
                assert!((pitches[0] / pitches[1] - 1.0).abs() < 1e-12 && pitches[0] >= PITCH * wave * (1.0 - 1e-12));
            }
        }
    }
}
