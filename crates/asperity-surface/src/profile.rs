//! Profiles: heights along one line, and their parameters by ISO 21920-2.
//!
//! A profile is treated as the map of a surface that does not vary across it, of a few equal rows: form, outliers, filters, pointwise
//! statistics and their intervals are those of maps.

mod parameters;

use asperity_base::correlation::{
    Autocorrelation, Axis, CorrelationFamily, CovarianceFits, FitError, ProfileSpectrum, fit_profile_covariance,
    profile_spectrum,
};
use asperity_base::distribution::{DistributionError, Marginal};
use asperity_base::map::{Grid, HeightMap, MapError};
use asperity_base::stats::Interval;
use ndarray::Array2;

use crate::HeightFits;
use crate::areal::{self, ArealError};
use crate::filter::{FilterError, GaussianFilter};
use crate::level::{Level, LevelError, MAX_DEGREE};
use crate::model::SurfaceModelError;
use crate::preparation::{Preparation, PreparationError, Prepared};
use crate::uncertainty::{Estimate, JointErrors, Uncertainty, Values};

pub use parameters::FeatureParameters;

/// Rows of the map that stands for a profile: more than the seven-point stencil and the polynomial of the highest degree need.
const ROWS: usize = MAX_DEGREE as usize + 2;
/// Rows of that map within a cutoff of a filter.
const ROWS_PER_CUTOFF: f64 = 4.0;

/// Heights along one line at equal distances.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Equal rows.
    map: HeightMap,
}

impl Profile {
    /// Creates a profile of heights in metre, NaN for missing ones, at distances of `pitch_m`.
    ///
    /// # Errors
    /// Fewer than two points, a pitch or heights out of range, or no height.
    pub fn new(heights_m: &[f64], pitch_m: f64) -> Result<Self, MapError> {
        Self::with_distance(heights_m, pitch_m, pitch_m)
    }

    fn with_distance(heights_m: &[f64], pitch_m: f64, between_rows_m: f64) -> Result<Self, MapError> {
        let grid = Grid::new(heights_m.len(), ROWS, pitch_m, between_rows_m)?;
        let rows = Array2::from_shape_fn(grid.shape(), |(_, column)| heights_m[column]);
        let map = HeightMap::measured(grid, rows).map_err(|error| match error {
            MapError::Empty { .. } => MapError::Empty { points: heights_m.len() },
            error => error,
        })?;
        Ok(Self { map })
    }

    /// Returns the heights in metre.
    pub fn heights_m(&self) -> &[f64] {
        &self.map.values_m()[..self.map.grid().nx()]
    }

    /// Returns the distance between points in metre.
    pub fn pitch_m(&self) -> f64 {
        self.map.grid().dx_m()
    }

    /// Returns the length in metre; a profile of n points is n distances long.
    pub fn length_m(&self) -> f64 {
        self.map.grid().width_m()
    }

    /// Removes form, outliers and scales as from a map.
    ///
    /// # Errors
    /// Those of [`Preparation::apply`].
    pub fn prepare(&self, preparation: &Preparation) -> Result<PreparedProfile, PreparationError> {
        self.check(preparation)?;
        // A sphere would bend the rows across the profile.
        let level = if preparation.level == Level::Sphere { Level::Cylinder } else { preparation.level };
        let form = Preparation { level, s_filter_m: None, l_filter_m: None, ..*preparation };
        let Prepared { map, outliers, radius_m, level, .. } =
            form.apply(self.map.clone()).map_err(|error| match error {
                PreparationError::Level(LevelError::Undetermined { level, present }) => {
                    LevelError::Undetermined { level, present: present / ROWS }.into()
                }
                error => error,
            })?;
        let (mut profile, mut lost) = (Self { map }, 0);
        if let Some(cutoff_m) = preparation.s_filter_m {
            let smooth = |map: &HeightMap| GaussianFilter::linear(cutoff_m).smooth(map);
            profile = profile.filtered(cutoff_m, |map| Ok(smooth(map)?.map)).map_err(PreparationError::SFilter)?;
        }
        if let Some(cutoff_m) = preparation.l_filter_m {
            let filter =
                if preparation.robust { GaussianFilter::robust(cutoff_m) } else { GaussianFilter::linear(cutoff_m) };
            let rough = |map: &HeightMap| {
                let rough = filter.roughness(map)?;
                lost = rough.lost / ROWS;
                Ok(rough.map)
            };
            profile = profile.filtered(cutoff_m, rough).map_err(PreparationError::LFilter)?;
        }
        let section_m = preparation.l_filter_m;
        Ok(PreparedProfile { profile, outliers: outliers / ROWS, lost, radius_m, level, section_m })
    }

    /// Checks the cutoffs of the filters.
    fn check(&self, preparation: &Preparation) -> Result<(), PreparationError> {
        let (low_m, high_m) = (self.pitch_m(), self.length_m());
        let within = |cutoff_m: Option<f64>| match cutoff_m {
            Some(found_m) if !(low_m..=high_m).contains(&found_m) => {
                Err(FilterError::Cutoff { found_m, low_m, high_m })
            }
            _ => Ok(()),
        };
        within(preparation.s_filter_m).map_err(PreparationError::SFilter)?;
        within(preparation.l_filter_m).map_err(PreparationError::LFilter)?;
        match (preparation.s_filter_m, preparation.l_filter_m) {
            (Some(s_filter_m), Some(l_filter_m)) if s_filter_m >= l_filter_m => {
                Err(PreparationError::EmptyBand { s_filter_m, l_filter_m })
            }
            _ => Ok(()),
        }
    }

    /// Filters the profile, with rows so far apart that the cutoff covers a few. Equal rows remain equal.
    fn filtered<E: From<MapError>>(
        &self,
        cutoff_m: f64,
        filter: impl FnOnce(&HeightMap) -> Result<HeightMap, E>,
    ) -> Result<Self, E> {
        let spread = Self::with_distance(self.heights_m(), self.pitch_m(), cutoff_m / ROWS_PER_CUTOFF)?;
        let map = filter(&spread.map)?;
        Ok(Self::new(&map.values_m()[..map.grid().nx()], self.pitch_m())?)
    }
}

/// A profile that is ready for statistics.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedProfile {
    /// The profile.
    pub profile: Profile,
    /// Number of heights rejected as outliers.
    pub outliers: usize,
    /// Number of heights removed by the robust filter.
    pub lost: usize,
    /// Radius of a removed circle in metre, positive for a ridge.
    pub radius_m: Option<f64>,
    /// Form that was removed.
    pub level: Level,
    /// Section length in metre, the cutoff of the L-filter; `None` for the whole profile.
    pub section_m: Option<f64>,
}

/// Parameters of a profile with 95 % intervals for the surface along its direction.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileStatistics {
    /// The profile.
    pub prepared: PreparedProfile,
    /// Number of missing heights.
    pub missing: usize,
    /// Arithmetic mean height Ra in metre.
    pub ra_m: f64,
    /// Root mean square height Rq in metre.
    pub rq_m: f64,
    /// Skewness Rsk.
    pub rsk: f64,
    /// Kurtosis Rku.
    pub rku: f64,
    /// Root mean square gradient by forward differences.
    pub rdq: Option<f64>,
    /// Root mean square gradient Rdq by the seven-point stencil.
    pub rdq_7point: Option<f64>,
    /// Peaks, pits and elements.
    pub features: FeatureParameters,
    /// Autocorrelation at the lags up to half the profile.
    pub correlation: Vec<f64>,
    /// 1/e correlation length in metre.
    pub correlation_length_m: Option<f64>,
    /// Power spectral density.
    pub spectrum: ProfileSpectrum,
    /// Estimates of Ra, Rq, Rsk, Rku, Rdq and the correlation length.
    pub estimates: [(&'static str, Option<Estimate>); 6],
    /// Joint errors of Rq, Rdq and Rsk, which are those of Sq, Sdq and Ssk of a surface without lay.
    pub joint: Option<JointErrors>,
    /// Intervals of Rz and RSm, from their values in sections and elements.
    pub feature_intervals: [(&'static str, Option<(Interval, f64)>); 2],
}

impl ProfileStatistics {
    /// Computes the parameters about the mean line.
    ///
    /// # Errors
    /// The profile is flat.
    pub fn new(prepared: PreparedProfile) -> Result<Self, SurfaceModelError> {
        let map = &prepared.profile.map;
        let once = |ArealError::Flat { present }| match prepared.level {
            Level::None => ArealError::Flat { present: present / ROWS }.into(),
            level => SurfaceModelError::FormAlone { level, present: present / ROWS },
        };
        let parameters = areal::parameters(map).map_err(once)?;
        let correlation = Autocorrelation::within(map, map.grid().nx() / 2, 0)?;
        let length_m = correlation.correlation_length_m(Axis::X);
        let values = Values { correlation_length_y_m: None, ..Values::new(&parameters, &correlation) };
        let terms = match prepared.level {
            Level::None | Level::Mean => 1,
            Level::Plane => 2,
            Level::Quadratic | Level::Cylinder | Level::Sphere => 3,
            Level::Polynomial(degree) => usize::from(degree) + 1,
        };
        let estimates = Uncertainty { removed_terms: terms, ..Uncertainty::default() }.of(map, &values)?;
        let features = FeatureParameters::new(&prepared.profile, prepared.section_m);
        Ok(Self {
            missing: parameters.missing / ROWS,
            ra_m: parameters.sa_m,
            rq_m: parameters.sq_m,
            rsk: parameters.ssk,
            rku: parameters.sku,
            rdq: parameters.sdq,
            rdq_7point: parameters.sdq_7point,
            correlation: correlation.along(Axis::X),
            correlation_length_m: length_m,
            spectrum: profile_spectrum(map, Axis::X)?,
            estimates: [
                ("Ra_m", estimates.sa_m),
                ("Rq_m", estimates.sq_m),
                ("Rsk", estimates.ssk),
                ("Rku", estimates.sku),
                ("Rdq", estimates.sdq),
                ("correlation_length_m", estimates.correlation_length_x_m),
            ],
            joint: estimates.joint,
            feature_intervals: [("Rz_m", features.rz_interval()), ("RSm_m", features.rsm_interval())],
            features,
            prepared,
        })
    }

    /// Returns the distribution of the heights ([`HeightFits::marginal`]). A profile of length L has the effective sample size L/∫ρ, the
    /// integral to the first lag at which the correlation is not positive.
    ///
    /// # Errors
    /// The heights have no distribution.
    pub fn marginal(&self) -> Result<Marginal, DistributionError> {
        let lobe: f64 = self.correlation.iter().skip(1).take_while(|rho| **rho > 0.0).sum();
        let heights_m = self.prepared.profile.heights_m();
        let present = heights_m.len() - self.missing;
        HeightFits::with_effective_size(heights_m.iter().copied(), present as f64 / (1.0 + 2.0 * lobe)).marginal()
    }

    /// Returns the length in metre of the shortest wave that the profile resolves.
    pub fn shortest_wave_m(&self) -> f64 {
        self.spectrum.shortest_wave_m(self.prepared.profile.pitch_m())
    }

    /// Fits isotropic covariance models to the spectrum, for the heights of a surface without lay.
    ///
    /// # Errors
    /// Those of [`fit_profile_covariance`].
    pub fn isotropic_covariance(&self, families: &[CorrelationFamily]) -> Result<CovarianceFits, FitError> {
        fit_profile_covariance(&self.spectrum, self.prepared.profile.pitch_m(), self.rq_m, families)
    }
}

#[cfg(test)]
mod tests;
