//! Friction processes and measured records.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod measured;
