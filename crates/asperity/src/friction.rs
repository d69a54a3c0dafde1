//! The friction coefficient as a stochastic process (paper §4).

pub mod bowden_tabor;
pub mod process;
pub mod record;
pub mod window;
