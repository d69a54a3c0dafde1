//! Covariances and spectra of maps.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod block_spectrum;
mod measured_covariance;
mod reports;
