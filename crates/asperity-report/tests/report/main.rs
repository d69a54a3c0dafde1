//! Pages and figures of finished runs.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot pose its problem has failed")]

mod documents;
mod records;
mod render;
mod synthetic;
mod twins;
mod vibration;
