//! Studies from file to results.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod files;
mod friction_cutoff;
mod friction_levels;
mod friction_uncertainty;
mod paper_fig3;
mod paper_fig5;
mod pressure;
mod robustness;
mod stages;
mod surface_slopes;
mod vibration;
