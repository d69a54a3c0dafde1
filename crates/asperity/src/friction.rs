//! The friction coefficient as a stochastic process (paper §4).

pub mod process;
