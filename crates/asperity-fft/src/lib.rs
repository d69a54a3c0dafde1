//! Plans of one-dimensional Fourier transforms.
//!
//! A planner of rustfft is compiled anew, with all its transforms, in every crate that makes one. Here it is compiled once, and
//! only trait objects leave; changes elsewhere do not compile it again.

use std::sync::Arc;

use realfft::RealFftPlanner;
use rustfft::FftPlanner;

pub use realfft::{ComplexToReal, RealToComplex};
#[doc(hidden)]
pub use rustfft::num_complex::{Complex, Complex64};
pub use rustfft::{Fft, FftNum};

/// The forward and the inverse transform of `length` complex values in single precision; neither is normalised.
pub fn complex_f32(length: usize) -> [Arc<dyn Fft<f32>>; 2] {
    let mut planner = FftPlanner::new();
    [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]
}

/// The forward and the inverse transform of `length` complex values in double precision; neither is normalised.
pub fn complex_f64(length: usize) -> [Arc<dyn Fft<f64>>; 2] {
    let mut planner = FftPlanner::new();
    [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]
}

/// The transform of `length` real values to the wavenumbers 0 … length/2, not normalised.
pub fn real_forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(length)
}

/// The transform of the wavenumbers 0 … length/2 to `length` real values, not normalised.
pub fn real_inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(length)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
