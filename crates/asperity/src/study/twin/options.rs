//! Options of twins.

use crate::correlation::CorrelationFamily;
use crate::map::BoundaryKind;
use crate::map::Grid;
use crate::study::StudyError;
use crate::study::file::SurfaceSection;
use crate::surface::{CovarianceSource, SurfaceGenerator};
use crate::translation::TranslationKind;

/// Options of twins.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinOptions {
    /// Preparation of the scan and model of the twins, as in a study; its `file`, `channel`, `height_unit`, `decimal`
    /// and `pixel_size` are ignored.
    pub surface: SurfaceSection,
    /// Models from which a measured covariance is chosen.
    pub families: Vec<CorrelationFamily>,
    /// Whether the best model replaces an empirical covariance if the scan is too short for it, with a warning.
    pub allow_model: bool,
    /// Size (x, y) of a twin in metre; when left out, the scan's size, or the size of the points at the scan's pitch.
    pub size_m: Option<[f64; 2]>,
    /// Points (x, y) of a twin; when left out, the scan's points, or enough to fill the size at the scan's pitch.
    pub points: Option<[usize; 2]>,
    /// Continuation of a twin beyond its edge.
    pub boundary: BoundaryKind,
    /// Seed of every random draw.
    pub seed: u64,
}

impl TwinOptions {
    /// Returns options that reproduce the scan as closely as possible: the scan's own covariance, all Fourier modes,
    /// corrected translation, free boundary, the scan's own grid.
    pub fn new(seed: u64) -> Self {
        let surface = SurfaceSection {
            generator: SurfaceGenerator::Spectral,
            covariance: CovarianceSource::Empirical,
            translation: TranslationKind::Corrected,
            ..SurfaceSection::default()
        };
        let families = CorrelationFamily::ALL.to_vec();
        Self { surface, families, allow_model: true, size_m: None, points: None, boundary: BoundaryKind::Free, seed }
    }

    /// Estimates the memory in byte for making twins of a scan of `scan_points` points and comparing `at_once` of them
    /// at a time.
    pub fn memory_bytes(&self, scan_points: usize, pitch_m: Option<(f64, f64)>, at_once: usize) -> f64 {
        // The embedded covariance has twice the width and height, with its sorted modes; each twin needs its normal
        // variables, the transform, and the padded correlations; the scan is stored raw and prepared.
        const GENERATOR: f64 = 4.0 * 64.0;
        const TWIN: f64 = 4.0 * 48.0;
        const SCAN: f64 = 64.0;
        let points = match (self.points, self.size_m, pitch_m) {
            (Some([nx, ny]), _, _) => nx as f64 * ny as f64,
            (None, Some([width_m, height_m]), Some((dx_m, dy_m))) => (width_m / dx_m) * (height_m / dy_m),
            _ => scan_points as f64,
        };
        scan_points as f64 * SCAN + points * (GENERATOR + at_once as f64 * TWIN)
    }

    pub(super) fn grid(&self, scan: Grid) -> Result<Grid, StudyError> {
        let pitch_m = [scan.dx_m(), scan.dy_m()];
        let filling = |size_m: [f64; 2]| [0, 1].map(|axis| (size_m[axis] / pitch_m[axis]).round() as usize);
        let grid = match (self.points, self.size_m) {
            (None, None) => Ok(scan),
            (Some([nx, ny]), Some([width_m, height_m])) => Grid::with_size(nx, ny, width_m, height_m),
            (Some([nx, ny]), None) => Grid::new(nx, ny, pitch_m[0], pitch_m[1]),
            (None, Some(size_m)) => {
                let [nx, ny] = filling(size_m);
                Grid::new(nx, ny, pitch_m[0], pitch_m[1])
            }
        };
        grid.map_err(|error| StudyError::Grid { section: "size and points", error })
    }
}
