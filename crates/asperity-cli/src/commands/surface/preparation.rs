//! What is done to a map before anything is read off it.

use asperity::quantity::Length;
use asperity::surface::level::Level;
use asperity::surface::preparation::Preparation;
use clap::Args;

use crate::args;

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
