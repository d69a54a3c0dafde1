//! Models of random surfaces, stated or measured on scans.
//!
//! [`SurfaceModel::new`] makes a [`SurfaceModel`] from a [`SurfaceRequest`] and, if the request measures something, from the
//! [`ScannedSurface`](crate::scanned::ScannedSurface). [`SurfaceModel::patch`] and [`SurfaceModel::strip`] make the generators of
//! its random surfaces on a grid.
//!
//! ```
//! use asperity_base::correlation::{CorrelationFamily, CorrelationModel};
//! use asperity_base::distribution::Marginal;
//! use asperity_base::map::Grid;
//! use asperity_base::translation::TranslationKind;
//! use asperity_surface::RandomSurface;
//! use asperity_surface::model::{CovarianceRequest, Measurable, SurfaceModel, SurfaceRequest};
//!
//! let request = SurfaceRequest::Translated {
//!     rms_height_m: Measurable::Stated(1e-6),
//!     covariance: CovarianceRequest::Stated { model: CorrelationModel::Exponential, lengths_m: [8e-6, 8e-6] },
//!     families: CorrelationFamily::ALL.to_vec(),
//!     marginal: Measurable::Stated(Marginal::STANDARD_NORMAL),
//!     shortest_wave_m: None,
//!     translation: TranslationKind::Plain,
//!     expansion: None,
//! };
//! let (model, _) = SurfaceModel::new(request, None)?;
//! let generated = model.patch(Grid::new(64, 64, 1e-6, 1e-6)?, false)?;
//! let map = generated.surface.generate(&vec![0.5; generated.surface.xi_len()]);
//! assert_eq!(map.grid().shape(), (64, 64));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod band_slopes;
mod composite;
mod covariance;
mod error;
mod generated;
mod request;
mod selection;
mod trial;
mod variation;

pub use band_slopes::{BandSlopes, Roughness};
pub use composite::CompositeModel;
pub use covariance::{CovarianceRequest, SurfaceCovariance};
pub use error::SurfaceModelError;
pub use generated::{GAMMA, Generated, PatchSize, RIDGES, XiOrder};
pub use request::{Measurable, SurfaceRequest};
pub use selection::SelectedCovariance;
pub use trial::TrialMaps;
pub use variation::Variation;

use asperity_base::distribution::Marginal;
use asperity_base::translation::TranslationKind;

asperity_base::choice! {
    /// Generator of random surfaces.
    #[derive(Default)]
    pub enum SurfaceGenerator: "generator of surfaces" {
        /// Truncated Karhunen–Loève expansion (paper, eq. 2).
        #[default]
        KarhunenLoeve = "karhunen_loeve",
        /// Weierstrass–Mandelbrot function (paper, eq. 1) in its two-dimensional form.
        WeierstrassMandelbrot = "weierstrass_mandelbrot",
        /// All Fourier modes of the grid.
        Spectral = "spectral",
    }
}

asperity_base::choice! {
    /// Covariance of random surfaces.
    #[derive(Default)]
    pub enum CovarianceSource: "covariance" {
        /// The best of the models, fitted to the scan by likelihood; the scan's own where none keeps its spectrum and slopes.
        ///
        /// Spectrum and heights do not determine the contact. Copies of a scan with random phases and the scan's own heights need
        /// 0.75 to 1.44 times its mean pressure for 5 % contact on reference scans (st_al3d-1 and st_x3p-2 of
        /// SurfaceTopography): a study presses drawn maps and a part of the scan, and warns where they touch on different areas.
        #[default]
        Measured = "measured",
        /// The scan's own, made positive definite: no model, lays at any angle.
        Empirical = "empirical",
        /// ρ = e^{−r²}, with r in lengths ℓ.
        SquaredExponential = "squared_exponential",
        /// ρ = e^{−r}, with r in lengths ℓ.
        Exponential = "exponential",
        /// Matérn.
        Matern = "matern",
        /// Self-affine with roll-off.
        SelfAffine = "self_affine",
    }
}

impl CovarianceSource {
    /// Returns whether the covariance is taken from a scan.
    pub fn is_of_the_scan(self) -> bool {
        matches!(self, Self::Measured | Self::Empirical)
    }
}

/// Random surface, independent of any grid.
#[derive(Debug, Clone)]
pub struct SurfaceModel {
    /// Marginal distribution of the heights in metre, of mean zero.
    pub marginal: Marginal,
    /// Dependence of heights at different points.
    pub texture: Texture,
    /// Length in metre of the shortest wave of a translated field; `None` is limited by the grid.
    pub shortest_wave_m: Option<f64>,
}

/// Dependence of heights at different points.
#[derive(Debug, Clone)]
pub enum Texture {
    /// Translated Gaussian field.
    Translated {
        /// Covariance of the heights.
        covariance: SurfaceCovariance,
        /// Kind of translation from normal heights to the marginal distribution.
        translation: TranslationKind,
        /// Karhunen–Loève expansion of patches; `None` uses all Fourier modes.
        expansion: Option<TruncatedExpansion>,
    },
    /// Sum of cosines, scaled to the standard deviation of the marginal distribution.
    WeierstrassMandelbrot {
        /// Fractal dimension, between 2 and 3.
        dimension: f64,
    },
}

/// Truncated Karhunen–Loève expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruncatedExpansion {
    /// Number of terms; `None` takes as many as contain 90 % of the slope variance.
    pub modes: Option<usize>,
    /// Whether the expansion of a periodic patch contains the constant Fourier mode.
    pub mean_mode: bool,
    /// Treatment of the truncated variance: `true` scales all heights by one factor, `false` leaves them lower, `None` imposes the
    /// marginal distribution at every point.
    pub rescale: Option<bool>,
}

impl SurfaceModel {
    /// Returns the covariance; `None` for a Weierstrass–Mandelbrot surface.
    pub fn covariance(&self) -> Option<&SurfaceCovariance> {
        match &self.texture {
            Texture::Translated { covariance, .. } => Some(covariance),
            Texture::WeierstrassMandelbrot { .. } => None,
        }
    }
}
