//! Expansions, indices and regressions through the public interface.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod reports;
