//! Preparation of a map before its statistics are computed.

use std::path::Path;

use asperity::map::HeightMap;
use asperity::quantity::Length;
use asperity::surface::level::{Level, dominant_form, remove_form};
use asperity::surface::preparation::Preparation;
use clap::Args;

use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::row;

/// Form removal alone; by default nothing is removed.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct LevelOption {
    /// Form to remove by least squares before anything else: none, mean, plane, quadratic, polynomial:N, cylinder or
    /// sphere. Nothing is removed when left out.
    #[arg(long, value_name = "FORM")]
    level: Option<Level>,
}

impl LevelOption {
    /// Returns whether a form is removed.
    pub(crate) fn removes(self) -> bool {
        self.level.is_some_and(|level| level != Level::None)
    }

    /// Returns the map without the form. If no form is stated, warns about a form larger than the roughness. `file`
    /// names the map.
    pub(crate) fn remove(self, map: HeightMap, file: &Path, monitor: &Terminal) -> Result<HeightMap, Failure> {
        if self.level.is_none()
            && let Some(form) = monitor.killable(|| dominant_form(&map))?
        {
            let (level, file) = (form.level, file.display());
            let shown = |height_m: f64| row("height_m", &height_m.into()).1;
            let (form, rest) = (shown(form.form_rms_m), shown(form.roughness_rms_m));
            monitor.warn(&format!(
                "{file}: the form ({level}) has an rms height of {form}, more than the roughness, {rest}; \
                 --level {level} removes it, --level none keeps it"
            ));
        }
        let Some(level) = self.level.filter(|_| self.removes()) else { return Ok(map) };
        let levelled = monitor.killable(|| remove_form(&map, level))?;
        Ok(levelled.map_err(|e| Failure::data(file.display(), &e))?.map)
    }
}

/// Form removal, outliers and filters.
#[derive(Debug, Args)]
pub(super) struct PreparationOptions {
    /// Form to remove by least squares: none, mean, plane, quadratic, polynomial:N, cylinder or sphere.
    #[arg(long, value_name = "FORM", default_value = "plane")]
    pub(super) level: Level,
    /// Treat heights farther from the median than this many robust standard deviations as missing.
    #[arg(long, value_name = "X", value_parser = args::outliers, allow_hyphen_values = true)]
    pub(super) outliers: Option<f64>,
    /// Cutoff of the S-filter (ISO 16610-61), which removes shorter waves.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    pub(super) s_filter: Option<Length>,
    /// Cutoff of the L-filter, which removes longer waves.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    pub(super) l_filter: Option<Length>,
    /// Make the L-filter robust against grooves and spikes (ISO 16610-71).
    #[arg(long, requires = "l_filter")]
    pub(super) robust: bool,
}

impl PreparationOptions {
    /// Returns the preparation of the surface library.
    pub(super) fn preparation(&self) -> Preparation {
        Preparation {
            level: self.level,
            outliers: self.outliers,
            s_filter_m: self.s_filter.map(|cutoff| cutoff.0),
            l_filter_m: self.l_filter.map(|cutoff| cutoff.0),
            robust: self.robust,
        }
    }
}
