//! Characterisation of measured rough surfaces, and random surfaces with the same statistics (paper §2).

#![cfg_attr(test, expect(clippy::disallowed_methods, reason = "tests read reference files and call other programs"))]

pub mod areal;
mod composite;
mod conditional;
mod filling;
pub mod filter;
pub mod fractal;
mod gaussian;
mod height_fits;
mod karhunen_loeve;
pub mod level;
pub mod model;
pub mod pooling;
pub mod preparation;
pub mod profile;
pub mod scanned;
mod spectral;
mod translation;
pub mod uncertainty;
mod weierstrass_mandelbrot;
#[cfg(test)]
mod xi_response;

pub use conditional::{ConditionalError, NeighbourhoodSurface, surrounded};
pub use filling::{
    FILLED_AT_ONCE, FillCovariance, FillError, FillMarginal, FillOptions, Filling, filling_memory_bytes,
};
pub use gaussian::{GaussianSurface, GeneratorError};
pub use height_fits::HeightFits;
pub use karhunen_loeve::{
    KarhunenLoeve, Modes, ModesRoute, ProfileModes, modes, modes_for_slopes, modes_memory_bytes, profile_modes,
};
pub use model::{CovarianceSource, SurfaceGenerator, SurfaceModel};
pub use spectral::SpectralField;
pub use translation::{
    CorrectedField, CorrectionReport, Feasibility, Predistorted, Translated, TranslationCorrection, TranslationError,
    TranslationReport,
};
pub use weierstrass_mandelbrot::WeierstrassMandelbrot;

use ndarray::Array2;

use asperity_base::map::{Grid, HeightMap};

/// A random surface: a map that is a deterministic function of the vector ξ of independent standard normal
/// variables. Samplers and chaos expansions choose ξ.
pub trait RandomSurface: Send + Sync {
    /// Returns the number of normal variables ξ; the most important come first.
    fn xi_len(&self) -> usize;

    /// Returns the grid of the generated maps.
    fn grid(&self) -> Grid;

    /// Generates the map of one ξ of [`RandomSurface::xi_len`] values.
    ///
    /// # Panics
    /// If ξ has another length or a value that is not finite.
    fn generate(&self, xi: &[f64]) -> HeightMap;

    /// Generates a map as [`RandomSurface::generate`], and frees ξ as soon as it can.
    ///
    /// # Panics
    /// If ξ has another length or a value that is not finite.
    fn generate_from(&self, xi: Vec<f64>) -> HeightMap {
        self.generate(&xi)
    }

    /// Returns the response of the weighted sum Σ w z of heights to each normal variable at ξ = 0, in metre; `weights`
    /// has shape `[ny, nx]`.
    ///
    /// It is the adjoint of the generator, at about the cost of one map, and exact for all ξ if the map is linear in ξ.
    /// Returns `None` if only finite differences can compute it.
    ///
    /// # Panics
    /// If the weights have another shape.
    fn xi_response(&self, _weights: &Array2<f64>) -> Option<Vec<f64>> {
        None
    }

    /// Returns the maps of both bodies at ξ if this surface is the composite roughness of two: the surface, and the counterface as
    /// seen from outside, before it is mirrored to face the surface.
    fn bodies(&self, _xi: &[f64]) -> Option<[HeightMap; 2]> {
        None
    }

    /// Returns whether maps that differ by a shift on the periodic grid are equally likely, up to a thousandth of the
    /// variance.
    fn is_periodic_and_stationary(&self) -> bool {
        false
    }
}

/// A map without missing points, as a surface without variables.
impl RandomSurface for HeightMap {
    fn xi_len(&self) -> usize {
        0
    }

    fn grid(&self) -> Grid {
        HeightMap::grid(self)
    }

    fn generate(&self, _xi: &[f64]) -> HeightMap {
        self.clone()
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
