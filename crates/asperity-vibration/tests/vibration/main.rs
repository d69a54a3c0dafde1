//! Ensembles, crossings and kinds of motion.

#![expect(clippy::disallowed_methods, reason = "tests read reference files and the environment")]
#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod crossings;
mod ensembles;
mod kinds;
mod reports;
