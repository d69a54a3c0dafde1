//! Python module `asperity._core`: converts arguments, calls the library, converts results.
//!
//! The package `python/asperity` wraps every function of this module, with documentation and types. Nothing is computed
//! here. Settings and results cross the border as dictionaries (`convert`), fields as NumPy arrays, errors by kind
//! (`errors`). Calls that may take long run on a thread of their own (`long`), so that Ctrl-C ends them.

mod chaos;
mod contact;
mod convert;
mod distribution;
mod errors;
mod long;
mod machines;
mod parts;
mod pool;
mod process;
mod random_surface;
mod resources;
mod study;
mod surface;
mod vibration;

use pyo3::prelude::*;

/// Compiled part of the package asperity.
#[pymodule]
mod _core {
    #[pymodule_export]
    use crate::chaos::{Expansion, design};
    #[pymodule_export]
    use crate::contact::solve_contact;
    #[pymodule_export]
    use crate::distribution::{Marginal, distribution_nodes};
    #[pymodule_export]
    use crate::machines::Oscillator;
    #[pymodule_export]
    use crate::parts::{compute_or_leave, module_program, study_part};
    #[pymodule_export]
    use crate::process::{fit_friction_record, friction_process, read_friction_process, simulate_friction};
    #[pymodule_export]
    use crate::random_surface::{RandomSurface, SurfaceModel};
    #[pymodule_export]
    use crate::study::{
        check_inputs, check_study, cite, compute, read_study, results_schema, study_schema, toml_of, unit_of,
    };
    #[pymodule_export]
    use crate::surface::{
        acf, fill, height_map, level, map_names, pooled_statistics, psd, read_map, statistics, write_map,
    };
    #[pymodule_export]
    use crate::vibration::{
        critical_damping, ensemble, ensembles, limit_cycle, parameters_schema, rescaled_law, stability_map, trajectory,
        vibration_schema,
    };

    #[pymodule_init]
    fn init() {
        crate::pool::loaded();
    }
}
