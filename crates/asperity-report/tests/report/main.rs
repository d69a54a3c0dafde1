//! Pages and figures of finished runs.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot pose its problem has failed")]

mod documents;
mod friction;
mod motion;
mod pages;
mod partial;
mod pressure;
mod records;
mod stages;
mod surface;
mod synthetic;
mod twins;
mod verdict;
mod vibration;
