//! Sample statistics.
