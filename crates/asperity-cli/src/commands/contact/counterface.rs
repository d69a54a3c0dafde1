//! Flags of the counterface.

use std::path::{Path, PathBuf};

use asperity::contact::{ContactError, Elastic, ElasticPair, Orientation, composite};
use asperity::map::HeightMap;
use asperity::quantity::Pressure;
use clap::Args;

use crate::args;
use crate::commands::surface::preparation::LevelOption;
use crate::failure::Failure;
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;

/// Counterface; a rigid flat by default.
#[derive(Debug, Args)]
pub(super) struct Counterface {
    /// Heights of the counterface, on the same grid; flat when left out. Heights count outwards from its own material,
    /// as measured. The map is turned over to face the surface, so that its last column lies on the first column of the
    /// surface.
    #[arg(long, value_name = "FILE")]
    counterface: Option<PathBuf>,
    /// Young's modulus of the counterface; rigid when left out.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true)]
    counterface_youngs_modulus: Option<Pressure>,
    /// Poisson's ratio of the counterface; 0.3 when left out.
    #[arg(long, value_name = "X", value_parser = args::of_input("material.poisson_ratio"), allow_hyphen_values = true)]
    #[arg(requires = "counterface_youngs_modulus")]
    counterface_poisson_ratio: Option<f64>,
    /// Do not turn the map of the counterface over; it is already in the coordinates of the surface.
    #[arg(long, requires = "counterface")]
    counterface_as_laid: bool,
}

impl Counterface {
    /// Returns the file of its heights.
    pub(super) fn file(&self) -> Option<&Path> {
        self.counterface.as_deref()
    }

    /// Returns the names of both files for a message.
    pub(super) fn names_with(&self, file: &Path) -> String {
        match &self.counterface {
            None => file.display().to_string(),
            Some(counterface) => format!("{} on {}", counterface.display(), file.display()),
        }
    }

    /// Returns the composite roughness of `map` and the counterface.
    pub(super) fn composite_with(
        &self,
        map: HeightMap,
        options: &ScanOptions,
        level: LevelOption,
        monitor: &Terminal,
    ) -> Result<HeightMap, Failure> {
        let Some(file) = &self.counterface else { return Ok(map) };
        let unusable = |e: ContactError| Failure::data(file.display(), &e);
        let upper = input::map(file, &options.without_channel(), monitor)?;
        let upper = level.remove(upper, file, monitor)?;
        match upper.missing_points() {
            0 => {}
            missing => return Err(unusable(ContactError::Missing { missing, points: upper.grid().points() })),
        }
        let laid = if self.counterface_as_laid { Orientation::Aligned } else { Orientation::Mirrored };
        composite(&map, &upper, laid).map_err(unusable)
    }

    /// Returns whether the counterface is elastic.
    pub(super) fn is_elastic(&self) -> bool {
        self.counterface_youngs_modulus.is_some()
    }

    /// Returns the contact modulus E* of the pair, in pascal.
    pub(super) fn contact_modulus_pa(&self, surface: Elastic) -> Result<f64, Failure> {
        let own = match self.counterface_youngs_modulus {
            None => Ok(Elastic::RIGID),
            Some(modulus) => Elastic::new(modulus.0, self.counterface_poisson_ratio.unwrap_or(Elastic::POISSON_RATIO)),
        };
        let pair = own.and_then(|own| ElasticPair::new(surface, own));
        pair.map(|pair| pair.contact_modulus_pa()).map_err(Failure::usage)
    }
}
