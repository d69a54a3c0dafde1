//! What a rough surface is, and how to draw maps like it (paper §2).

pub mod areal;
mod conditional;
mod filling;
pub mod filter;
pub mod fractal;
mod gaussian;
mod karhunen_loeve;
pub mod level;
pub mod pooling;
pub mod preparation;
mod spectral;
mod translation;
pub mod uncertainty;
mod weierstrass_mandelbrot;

pub use conditional::{ConditionalError, ConditionalSurface, Conditioning, NeighbourhoodSurface, surrounded};
pub use filling::{
    FILLED_AT_ONCE, FillCovariance, FillError, FillMarginal, FillOptions, Filling, filling_memory_bytes,
};
pub use gaussian::{GaussianSurface, GeneratorError};
pub use karhunen_loeve::{
    KarhunenLoeve, Modes, ModesRoute, ProfileModes, exponential_eigenvalues_m, modes, modes_memory_bytes, profile_modes,
};
pub use spectral::SpectralField;
pub use translation::{
    CorrectedField, CorrectionReport, Feasibility, Predistorted, Translated, TranslationCorrection, TranslationError,
    TranslationReport,
};
pub use weierstrass_mandelbrot::{WeierstrassForm, WeierstrassMandelbrot, WeierstrassProfile};

use crate::map::{Grid, HeightMap};

/// A random surface: a map that is a deterministic function of a germ, the vector ξ of independent standard normal
/// variables. Samplers and chaos expansions act on the germ.
pub trait RandomSurface: Sync {
    /// Number of germ variables, most important first.
    fn germ_len(&self) -> usize;

    /// Grid of the generated maps.
    fn grid(&self) -> Grid;

    /// The map of one germ of [`RandomSurface::germ_len`] values.
    ///
    /// # Panics
    /// If the germ has another length or a value that is not finite.
    fn generate(&self, germ: &[f64]) -> HeightMap;

    /// Whether maps that differ by a shift on the periodic grid are equally likely, up to a thousandth of the variance.
    fn is_periodic_and_stationary(&self) -> bool {
        false
    }
}
