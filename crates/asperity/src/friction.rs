//! The friction coefficient as a stochastic process (paper §4).
