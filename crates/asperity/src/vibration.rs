//! Stochastic stick-slip of a mass on a belt (paper §5).
