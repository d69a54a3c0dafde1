//! What the surface is pressed against.

use std::path::{Path, PathBuf};

use asperity::contact::{ContactError, Elastic, Orientation, Pair, composite};
use asperity::map::HeightMap;
use asperity::quantity::Pressure;
use clap::Args;

use crate::args;
use crate::commands::surface::preparation::LevelOption;
use crate::failure::Failure;
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;

/// Poisson's ratio of an elastic counterface, unless told.
const POISSON_RATIO: f64 = 0.3;

/// A counterface; a rigid flat when nothing is told of it.
#[derive(Debug, Args)]
pub(super) struct Counterface {
    /// Heights of the counterface, on the same grid; flat when left out. They are counted outwards from its own material, as
    /// measured: to face the surface the map is turned over, so that its last column lies on the first of the surface.
    #[arg(long, value_name = "FILE")]
    counterface: Option<PathBuf>,
    /// Young's modulus of the counterface; rigid when left out.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true)]
    counterface_youngs_modulus: Option<Pressure>,
    /// Poisson's ratio of the counterface, 0.3 when left out.
    #[arg(long, value_name = "X", value_parser = args::poisson_ratio, allow_hyphen_values = true)]
    #[arg(requires = "counterface_youngs_modulus")]
    counterface_poisson_ratio: Option<f64>,
    /// The counterface's map is in the coordinates of the surface already and is not turned over.
    #[arg(long, requires = "counterface")]
    counterface_as_laid: bool,
}

impl Counterface {
    /// The file of its heights.
    pub(super) fn file(&self) -> Option<&Path> {
        self.counterface.as_deref()
    }

    /// Both files, as a message names them.
    pub(super) fn beside(&self, file: &Path) -> String {
        match &self.counterface {
            None => file.display().to_string(),
            Some(counterface) => format!("{} on {}", counterface.display(), file.display()),
        }
    }

    /// The composite roughness of `map` and the counterface.
    pub(super) fn laid_on(
        &self,
        map: HeightMap,
        options: &ScanOptions,
        level: LevelOption,
        monitor: &Terminal,
    ) -> Result<HeightMap, Failure> {
        let Some(file) = &self.counterface else { return Ok(map) };
        let unusable = |e: ContactError| Failure::data(file.display(), &e);
        let upper = input::map(file, &options.of_another_file(), monitor)?;
        let upper = level.remove(upper, file, monitor)?;
        match upper.missing_points() {
            0 => {}
            missing => return Err(unusable(ContactError::Missing { missing, points: upper.grid().points() })),
        }
        let laid = if self.counterface_as_laid { Orientation::Aligned } else { Orientation::Mirrored };
        composite(&map, &upper, laid).map_err(unusable)
    }

    /// Whether it is told to be elastic.
    pub(super) fn is_elastic(&self) -> bool {
        self.counterface_youngs_modulus.is_some()
    }

    /// Contact modulus E* in pascal with a surface.
    pub(super) fn contact_modulus_pa(&self, surface: Elastic) -> Result<f64, Failure> {
        let own = match self.counterface_youngs_modulus {
            None => Ok(Elastic::RIGID),
            Some(modulus) => Elastic::new(modulus.0, self.counterface_poisson_ratio.unwrap_or(POISSON_RATIO)),
        };
        let pair = own.and_then(|own| Pair::new(surface, own));
        pair.map(|pair| pair.contact_modulus_pa()).map_err(Failure::usage)
    }
}
