//! Contact, friction and friction-induced vibration of measured rough surfaces, with uncertainty.
//!
//! asperity implements the multi-scale chain of N. Gaus, C. Proppe and C. Zaccardi, *Influence of surface roughness on
//! friction induced vibrations*, Meccanica dei Materiali e delle Strutture VI (2016) 1, 115–122 ("the paper"):
//!
//! scan → [`map::HeightMap`] → statistics and random surfaces ([`surface`]) → elastic and elasto-plastic half-space
//! [`contact`] → distribution of the random [`pressure`] → [`friction`] as a process → stochastic stick-slip
//! [`vibration`] → [`study`].
//!
//! # Conventions
//! - SI units inside; scalars carry their unit in the name (`modulus_pa`, `pitch_x_m`).
//! - Maps are indexed `[row y, column x]`, row 0 at the top; options are ordered (x, y).
//! - Heights point up, pressure is positive in compression, E* = E/(1−ν²).
//! - Missing heights stay missing: they are masked in every statistic and never silently filled.
//! - A random draw depends on seed, stage and sample index alone; results do not depend on the number of threads.

#[doc(hidden)]
pub use asperity_base::{blocks, sentence, statement};
pub use asperity_base::{
    choice, correlation, distribution, fourier, map, monitor, quantity, random, stats, translation,
};
pub use asperity_chaos as chaos;
pub use asperity_contact as contact;
pub use asperity_friction as friction;
pub use asperity_pressure as pressure;
#[doc(hidden)]
pub use asperity_results::keys;
pub use asperity_surface as surface;
pub use asperity_vibration as vibration;

pub mod study;

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct CrateReadme;
