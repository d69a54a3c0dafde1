//! Tests of studies, from file to results.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod choices;
mod errors;
mod files;
mod friction_cutoff;
mod friction_levels;
mod friction_scan;
mod friction_uncertainty;
mod paper_fig3;
mod paper_fig5;
mod pressure;
mod profile;
mod scans;
mod stages;
mod support;
mod surface_slopes;
mod vibration;
mod vibration_friction;
