//! Studies from file to results.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

#[path = "../../../../validation/src/bin/validate_contact/check.rs"]
#[allow(dead_code, reason = "the program's tables need more")]
mod check;
#[path = "../../../asperity-contact/tests/contact/contact_check.rs"]
mod contact_check;
mod contact_validation;
mod files;
mod friction_cutoff;
mod friction_levels;
mod friction_uncertainty;
mod paper_fig3;
mod paper_fig5;
mod pressure;
#[path = "../../../../validation/src/bin/validate_contact/problems.rs"]
#[allow(dead_code, reason = "the program's tables need more")]
mod problems;
mod robustness;
mod stages;
mod surface_slopes;
mod vibration;
