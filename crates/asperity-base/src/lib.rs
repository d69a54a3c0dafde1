//! Maps, spectra, random numbers, distributions and correlation: what the links of asperity share.
//!
//! Maps are indexed `[row y, column x]`, row 0 at the top; missing heights are NaN and masked in every statistic. Quantities are in
//! SI units. Random numbers depend on the seed, the name of a stream and an index alone.

#![cfg_attr(test, expect(clippy::disallowed_methods, reason = "tests read reference files and call other programs"))]

pub mod choice;
pub mod correlation;
pub mod fourier;
pub mod law;
pub mod map;
pub mod monitor;
#[doc(hidden)]
pub mod numeric;
pub mod quantity;
pub mod random;
#[doc(hidden)]
pub mod sentence;
pub mod stats;
pub mod translation;
#[doc(hidden)]
pub mod wide;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
