//! Foundations of the other asperity crates: maps, spectra, random numbers, statistics, distributions and correlation.
//!
//! Maps are indexed `[row y, column x]` with row 0 at the top; missing heights are NaN and excluded from every
//! statistic. Quantities are in SI units. Random numbers depend only on the seed, the name of a stream and an index.

#![cfg_attr(test, expect(clippy::disallowed_methods, reason = "tests read reference files and call other programs"))]

#[doc(hidden)]
pub mod blocks;
pub mod correlation;
pub mod distribution;
pub mod fourier;
pub mod map;
pub mod monitor;
#[doc(hidden)]
pub mod numeric;
pub mod quantity;
pub mod random;
#[doc(hidden)]
pub mod sentence;
#[doc(hidden)]
pub mod statement;
pub mod stats;
#[cfg(test)]
mod testing;
pub mod translation;
#[doc(hidden)]
pub mod wide;

pub use asperity_results::choice;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
