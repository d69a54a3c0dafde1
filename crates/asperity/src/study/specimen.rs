//! Random maps of the `[surface]` of a study, on any grid.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::map::{BoundaryKind, Grid, HeightMap};
use crate::quantity::Length;
use crate::random;
use crate::study::check::SurfaceStudy;
use crate::study::file::SurfaceSection;
use crate::study::parse::line_of_key;
use crate::study::{StudyError, StudyFileError, surface_stage};
use crate::surface::RandomSurface;

/// Stream name of the random numbers of drawn maps.
const STAGE: &str = "specimen";

/// Specification of random maps: a surface, its size and its points. The file has the keys `seed`, `size`, `points`,
/// `boundary` and the section `[surface]` of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Specimen {
    /// Seed of every random draw.
    pub seed: u64,
    grid: Grid,
    boundary: BoundaryKind,
    surface: SurfaceStudy,
    /// Sentences on keys without effect.
    warnings: Vec<String>,
}

/// File of a specification.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpecimenFile {
    seed: u64,
    /// Size (x, y) of a map.
    size: [Length; 2],
    /// Points (x, y) of a map.
    points: [usize; 2],
    /// Continuation of a map beyond its edge.
    #[serde(default = "free")]
    boundary: BoundaryKind,
    surface: SurfaceSection,
}

fn free() -> BoundaryKind {
    BoundaryKind::Free
}

impl Specimen {
    /// Reads the text of a specification; `file` names it in errors.
    ///
    /// # Errors
    /// The first error of the specification, with its line.
    pub fn parse(text: &str, file: &str) -> Result<Self, StudyFileError> {
        let SpecimenFile { seed, size: [width, height], points: [nx, ny], boundary, surface: section } =
            StudyFileError::read(text, file)?;
        let grid = Grid::with_size(nx, ny, width.0, height.0).map_err(|error| StudyFileError {
            file: file.into(),
            line: line_of_key(text, "", "points"),
            message: format!("size and points: {error}"),
            in_data: false,
        })?;
        let surface = section.check().map_err(|value| StudyFileError::invalid(&value, text, file))?;
        let mut warnings = section.keys_without_effect("surface");
        warnings.extend(section.body.map(|_| "[surface] body has no effect on drawn maps".to_owned()));
        Ok(Self { seed, grid, boundary, surface, warnings })
    }

    /// Returns the grid of a map.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns the scan files, `folder` being the folder of the specification.
    pub fn scan_paths(&self, folder: &Path) -> Vec<PathBuf> {
        self.surface.files.iter().map(|file| folder.join(file)).collect()
    }

    /// Estimates the memory in byte of the generator and a map.
    pub fn memory_bytes(&self) -> f64 {
        // The embedded covariance has twice the width and height, in complex numbers; the map has its normal variables.
        const BYTES_PER_POINT: f64 = 4.0 * 16.0 + 3.0 * 8.0;
        BYTES_PER_POINT * self.grid.nx() as f64 * self.grid.ny() as f64
    }

    /// Builds the generator of the maps. `folder` is the folder of the specification, to which scan paths are relative.
    ///
    /// # Errors
    /// The scan cannot be read or has no texture, or the model is invalid.
    pub fn sampler(&self, folder: &Path) -> Result<Sampler, StudyError> {
        let stage = surface_stage::run(&self.surface, folder)?;
        let generated = stage.model.patch(self.grid, self.boundary == BoundaryKind::Periodic)?;
        let warnings = self.warnings.iter().cloned().chain(stage.output.warnings).chain(generated.warnings).collect();
        Ok(Sampler { seed: self.seed, surface: generated.surface, warnings })
    }
}

/// Draws map number `index` of a random surface, independently of other maps.
pub fn draw_map(surface: &dyn RandomSurface, seed: u64, index: u64) -> HeightMap {
    surface.generate_from(random::standard_normal(&mut random::stream(seed, STAGE, index), surface.xi_len()))
}

/// Generator of the maps of a [`Specimen`].
pub struct Sampler {
    seed: u64,
    surface: Box<dyn RandomSurface>,
    warnings: Vec<String>,
}

impl Sampler {
    /// Draws map number `index`, independently of other maps.
    pub fn draw(&self, index: u64) -> HeightMap {
        draw_map(self.surface.as_ref(), self.seed, index)
    }

    /// Returns the warnings, in sentences.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECIFICATION: &str = "\nseed = 3\nsize = [\"64 um\", \"32 um\"]\npoints = [64, 32]\n[surface]\ncovariance = \"exponential\"\n\
                                 marginal = \"normal\"\nrms_height = \"1 um\"\ncorrelation_length = [\"8 um\", \"8 um\"]\n\
                                 generator = \"spectral\"\n";

    #[test]
    fn drawn_maps_have_the_stated_rms_height_and_differ() {
        let sampler = Specimen::parse(SPECIFICATION, "spec.toml").unwrap().sampler(Path::new(".")).unwrap();
        let maps: Vec<HeightMap> = (0..64).map(|index| sampler.draw(index)).collect();
        assert_eq!((maps[0].grid().nx(), maps[0].grid().ny(), maps[0].grid().dx_m()), (64, 32, 1e-6));
        assert_ne!(maps[0], maps[1]);
        assert_eq!(sampler.draw(1), maps[1]);
        let squares: Vec<f64> =
            maps.iter().map(|map| map.present_m().map(|z| z * z).sum::<f64>() / map.grid().points() as f64).collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (squares.len() - 1) as f64;
        let se = (variance / squares.len() as f64).sqrt();
        assert!((mean - 1e-12).abs() < 4.0 * se, "{mean} ± {se}");
    }

    #[test]
    fn a_fractal_surface_needs_no_covariance_and_a_key_without_effect_gives_a_warning() {
        let text = "seed = 3\nsize = [\"64 um\", \"32 um\"]\npoints = [64, 32]\n[surface]\nrms_height = \"1 um\"\n\
                    generator = \"weierstrass_mandelbrot\"\nfractal_dimension = 2.4\nhurst = 0.6\n";
        let sampler = Specimen::parse(text, "spec.toml").unwrap().sampler(Path::new(".")).unwrap();
        assert_eq!(sampler.draw(0).missing_points(), 0);
        assert!(sampler.warnings()[0].contains("hurst has no effect"), "{:?}", sampler.warnings());
        let undimensioned = text.replace("fractal_dimension = 2.4\n", "");
        let error = Specimen::parse(&undimensioned, "spec.toml").unwrap_err();
        assert!(error.message.contains("fractal_dimension"), "{error}");
    }

    #[test]
    fn a_wrong_specification_points_at_its_line() {
        for (from, to, line, expected) in [
            ("size =", "siz =", 3, "did you mean `size`?"),
            ("\"1 um\"", "\"1 GPa\"", 8, "length"),
            ("rms_height = \"1 um\"", "", 5, "rms_height"),
            ("seed = 3", "", 1, "seed"),
            ("[64, 32]", "[1, 32]", 4, "points"),
            ("[64, 32]", "[64, 32, 32]", 4, "found 3 values, expected 2"),
            ("[\"64 um\", \"32 um\"]", "[\"64 um\"]", 3, "found 1 value, expected 2"),
        ] {
            let error = Specimen::parse(&SPECIFICATION.replace(from, to), "spec.toml").unwrap_err();
            assert_eq!((error.line, error.file.as_str()), (line, "spec.toml"), "{error}");
            assert!(error.message.contains(expected), "{error}");
        }
    }
}
