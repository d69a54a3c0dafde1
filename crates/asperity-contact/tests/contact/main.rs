//! Contact against closed forms, identities and independent solvers.

#![expect(clippy::disallowed_methods, reason = "tests read reference files and the environment")]
#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod analysis;
mod contact_check;
mod edges;
mod half_space;
mod random;
mod reference;
mod reports;
mod substrate;
