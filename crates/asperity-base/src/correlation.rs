//! Correlation: covariance models, and their estimates and fits.
//!
//! # Conventions
//! - A stationary covariance is C(x, y) = E z(s) z(s + (x, y)) of a field without its mean; ρ = C/σ².
//! - A two-sided power spectral density is P(q) = ∬ C(x) e^{−iq·x} d²x, so C(x) = ∬ P(q) e^{iq·x} d²q/(2π)², in m⁴;
//!   the density of a profile is P₁(q) = ∫ C(x, 0) e^{−iqx} dx, so C(x, 0) = ∫ P₁(q) e^{iqx} dq/2π, in m³. The
//!   wavenumber q is in rad/m.

mod bessel;
mod estimate;
mod fit;
mod measured;
mod model;
#[doc(hidden)]
pub mod profiles;
mod record;
mod spectrum;

pub use asperity_results::EmpiricalCovariance;
pub use estimate::{Autocorrelation, EstimateError, axis_correlation, axis_correlation_length_m};
pub use fit::{
    CorrelationFamily, CovarianceFit, CovarianceFits, FitError, FitWarning, fit_covariance, fit_profile_covariance,
};
pub use measured::{MeasuredCovariance, MeasuredCovarianceError};
pub use model::{CorrelationModel, Covariance, CovarianceError, Rotated, SeparableCovariance, StationaryCovariance};
pub use profiles::Axis;
pub use record::{
    CrossCorrelation, DriftTest, FamilyFits, LackOfFit, LengthFit, LengthSettings, Observation, ObservedLengths,
    RecordBand, RecordCorrelation, RecordEnds, RecordFit, RecordHistory, RecordModel, RecordSpectrum, Stationarity,
    Wander, WindowedModel, WindowedRecords, cross_correlation, fit_families, fit_length, fit_record,
    fitted_length_interval, record_spectrum, windowed_exponential,
};
#[doc(hidden)]
pub use spectrum::Block;
pub use spectrum::{
    AngularSpectrum, AreaSpectrum, BinnedSpectrum, BlockSpectrum, ProfileSpectrum, RadialSpectrum, ReliableBand,
    SpectrumRoute, UpperLimit, binned_profile_spectrum, binned_radial_spectrum, profile_spectrum, radial_spectrum,
    radial_spectrum_with_bands,
};
