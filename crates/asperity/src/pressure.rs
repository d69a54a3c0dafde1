//! The law of the random contact pressure (paper §3).
