//! What is done to a map before anything is read off it.

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

/// The form alone, which is left in unless stated.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct LevelOption {
    /// Form that is removed by least squares before anything else: none, mean, plane, quadratic, polynomial:N, cylinder or
    /// sphere. Nothing is removed when left out.
    #[arg(long, value_name = "FORM")]
    level: Option<Level>,
}

impl LevelOption {
    /// Whether a form is removed at all.
    pub(crate) fn removes(self) -> bool {
        self.level.is_some_and(|level| level != Level::None)
    }

    /// The map without the form; where none is stated, warns about one that exceeds the roughness. `file` names the map.
    pub(crate) fn remove(self, map: HeightMap, file: &Path, monitor: &Terminal) -> Result<HeightMap, Failure> {
        if self.level.is_none()
            && let Some(form) = monitor.at_once(|| dominant_form(&map))?
        {
            let (level, file) = (form.level, file.display());
            let shown = |height_m: f64| row("height_m", &height_m.into()).1;
            let (form, rest) = (shown(form.form_rms_m), shown(form.roughness_rms_m));
            monitor.warn(&format!(
                "{file}: the form ({level}) has an rms height of {form}, more than the roughness around it, {rest}; \
                 --level {level} removes it, --level none keeps it"
            ));
        }
        let Some(level) = self.level.filter(|_| self.removes()) else { return Ok(map) };
        let levelled = monitor.at_once(|| remove_form(&map, level))?;
        Ok(levelled.map_err(|e| Failure::data(file.display(), &e))?.map)
    }
}

/// Form, outliers and filters.
#[derive(Debug, Args)]
pub(super) struct PreparationOptions {
    /// Form that is removed by least squares: none, mean, plane, quadratic, polynomial:N, cylinder or sphere.
    #[arg(long, value_name = "FORM", default_value = "plane")]
    pub(super) level: Level,
    /// Heights farther from the median than this many robust standard deviations count as missing.
    #[arg(long, value_name = "X", value_parser = args::outliers, allow_hyphen_values = true)]
    pub(super) outliers: Option<f64>,
    /// Cutoff of the S-filter (ISO 16610-61): shorter waves are taken out.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    pub(super) s_filter: Option<Length>,
    /// Cutoff of the L-filter: longer waves are taken out.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    pub(super) l_filter: Option<Length>,
    /// Make the L-filter robust against grooves and spikes (ISO 16610-71).
    #[arg(long, requires = "l_filter")]
    pub(super) robust: bool,
}

impl PreparationOptions {
    /// The library's.
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
