//! Checks of `[surface]`.

use std::path::{Path, PathBuf};

use asperity_formats::{Channel, FormatError, LengthUnit, ReadOptions, Scan};

use super::invalid_value::{InvalidValue, POSITIVE, at_least, invalid, positive, within};
use crate::correlation::{CorrelationFamily, CorrelationModel};
use crate::distribution::DistributionError;
use crate::map::{BoundaryKind, PITCH_RANGE_M};
use crate::study::file::{StudyFile, SurfaceSection};
use crate::surface::model::{CovarianceRequest, Measurable, SurfaceRequest, TruncatedExpansion};
use crate::surface::preparation::Preparation;
use crate::surface::{CovarianceSource, SurfaceGenerator};

const SECTION: &str = "surface";

/// Surface of a body: its scans, and the request for its random maps.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::study) struct SurfaceStudy {
    /// Scan files, relative to the study file.
    pub(in crate::study) files: Vec<PathBuf>,
    options: ReadOptions,
    /// Whether a profile may stand for the surface.
    pub(in crate::study) isotropic: bool,
    /// Preparation of the scans before their statistics are computed.
    pub(in crate::study) preparation: Preparation,
    pub(in crate::study) request: SurfaceRequest,
    /// Marginal distribution as stated; `None` if it is measured.
    pub(in crate::study) stated_marginal: Option<String>,
}

impl SurfaceStudy {
    /// Reads the scans; returns them with the names of their files, none for a surface without scans. `folder` is the
    /// folder of the study file.
    ///
    /// # Errors
    /// A file cannot be read or lacks the channel.
    pub(in crate::study) fn read_scans(&self, folder: &Path) -> Result<Vec<(String, Scan)>, FormatError> {
        let name = |file: &PathBuf| file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let read = |file| Ok((name(file), asperity_formats::read_with(&folder.join(file), &self.options)?));
        self.files.iter().map(read).collect()
    }
}

impl StudyFile {
    pub(in crate::study) fn check_surface(&self) -> Result<Option<SurfaceStudy>, InvalidValue> {
        let Some(s) = &self.surface else {
            return match (self.pressure.is_some() || self.friction.is_some(), self.vibration.is_some()) {
                (true, _) => Err(invalid(SECTION, "file", "[pressure] and [friction] need a [surface] section")),
                (false, false) => Err(invalid(SECTION, "file", "the study has no stage; add a [surface] section")),
                (false, true) => Ok(None),
            };
        };
        if !s.mean_mode && self.pressure.as_ref().is_some_and(|p| p.boundary == BoundaryKind::Free) {
            let message = "only periodic patches have a constant Fourier mode to omit; set boundary = \"periodic\" in \
                           [pressure]";
            return Err(invalid(SECTION, "mean_mode", message));
        }
        s.check().map(Some)
    }
}

impl SurfaceSection {
    /// Checks the values and returns the surface.
    ///
    /// # Errors
    /// A value is out of range, or a quantity is neither stated nor measured on a scan.
    pub(in crate::study) fn check(&self) -> Result<SurfaceStudy, InvalidValue> {
        if let Some(pixel) = self.pixel_size {
            for side in pixel {
                let (low, high) = (PITCH_RANGE_M.start(), PITCH_RANGE_M.end());
                let expected = format!("a size between {low:e} m and {high:e} m");
                within(SECTION, "pixel_size", side, |side| PITCH_RANGE_M.contains(&side), &expected)?;
            }
        }
        let height_unit = self.height_unit.as_deref().map(str::parse::<LengthUnit>).transpose();
        let height_unit = height_unit.map_err(|error| invalid(SECTION, "height_unit", error.to_string()))?;
        if let Some(outliers) = self.outliers {
            within(SECTION, "outliers", outliers, |k| k >= 1.0, "at least 1 standard deviation")?;
        }
        for (key, cutoff) in [("s_filter", self.s_filter), ("l_filter", self.l_filter)] {
            if let Some(cutoff) = cutoff {
                within(SECTION, key, cutoff, positive, POSITIVE)?;
            }
        }
        if let (Some(short), Some(long)) = (self.s_filter, self.l_filter) {
            let expected = "a cutoff longer than `s_filter`, so that some wavelengths remain";
            within(SECTION, "l_filter", long, |cutoff| cutoff > short.0, expected)?;
        }
        at_least(SECTION, "modes", self.modes.unwrap_or(1), 1)?;
        let expanded = self.generator == SurfaceGenerator::KarhunenLoeve;
        for (key, stated) in [("mean_mode", !self.mean_mode), ("rescale", self.rescale.is_some())] {
            if stated && !expanded {
                return Err(invalid(SECTION, key, "this key requires generator = \"karhunen_loeve\""));
            }
        }
        if self.rescale.is_some() && self.marginal != "normal" {
            let message = "this key requires marginal = \"normal\"; any other distribution is imposed at every point";
            return Err(invalid(SECTION, "rescale", message));
        }
        if self.file.is_some() && self.files().is_empty() {
            return Err(invalid(SECTION, "file", "the list of scans is empty; name at least one, or remove `file`"));
        }
        let channel = self.channel.as_deref().map(Channel::from);
        let pitch_m = self.pixel_size.map(|[x, y]| (x.0, y.0));
        Ok(SurfaceStudy {
            files: self.files().to_vec(),
            options: ReadOptions { channel, height_unit, decimal: self.decimal.map(Into::into), pitch_m },
            isotropic: self.isotropic,
            preparation: self.preparation(),
            request: self.request(CorrelationFamily::ALL)?,
            stated_marginal: self.stated_marginal().map(str::to_owned),
        })
    }

    /// Returns the preparation of the scans before their statistics are computed.
    pub(in crate::study) fn preparation(&self) -> Preparation {
        Preparation {
            level: self.level,
            outliers: self.outliers,
            s_filter_m: self.s_filter.map(|cutoff| cutoff.0),
            l_filter_m: self.l_filter.map(|cutoff| cutoff.0),
            robust: self.robust_filter,
        }
    }

    /// Returns the request for a random surface; a measured covariance is the best of `families`.
    ///
    /// # Errors
    /// A quantity is neither stated nor measured on a scan.
    pub(in crate::study) fn request(&self, families: &[CorrelationFamily]) -> Result<SurfaceRequest, InvalidValue> {
        let rms_height = self.rms_height.map(|rms| rms.0);
        let expansion = match self.generator {
            SurfaceGenerator::KarhunenLoeve => {
                let &Self { modes, mean_mode, rescale, .. } = self;
                Some(TruncatedExpansion { modes, mean_mode, rescale })
            }
            SurfaceGenerator::Spectral => None,
            SurfaceGenerator::WeierstrassMandelbrot => {
                let rms_height_m = self.stated_or_measured("rms_height", "the rms height", rms_height)?;
                let dimension =
                    self.stated_or_measured("fractal_dimension", "the fractal dimension", self.fractal_dimension)?;
                return Ok(SurfaceRequest::WeierstrassMandelbrot { rms_height_m, dimension });
            }
        };
        let stated = self.stated_covariance()?;
        let covariance = match self.stated_or_measured("covariance", "the covariance", stated)? {
            Measurable::Stated((model, lengths_m)) => CovarianceRequest::Stated { model, lengths_m },
            Measurable::Measured if self.covariance == CovarianceSource::Empirical => CovarianceRequest::Empirical,
            Measurable::Measured => CovarianceRequest::Measured,
        };
        let marginal = self.stated_marginal().map(str::parse).transpose();
        let marginal = marginal.map_err(|e: DistributionError| invalid(SECTION, "marginal", e.to_string()))?;
        let marginal = self.stated_or_measured("marginal", "the marginal distribution", marginal)?;
        let rms_height_m = self.stated_or_measured("rms_height", "the rms height", rms_height)?;
        let (families, translation) = (families.to_vec(), self.translation);
        let shortest_wave_m = self.cut_off.map(|cut_off| cut_off.0);
        Ok(SurfaceRequest::Translated {
            rms_height_m,
            covariance,
            families,
            marginal,
            shortest_wave_m,
            translation,
            expansion,
        })
    }

    fn stated_or_measured<T>(
        &self,
        key: &'static str,
        name: &str,
        stated: Option<T>,
    ) -> Result<Measurable<T>, InvalidValue> {
        match stated {
            Some(value) => Ok(Measurable::Stated(value)),
            None if self.files().is_empty() => {
                Err(invalid(SECTION, key, format!("{name} cannot be measured without `file`; state it")))
            }
            None => Ok(Measurable::Measured),
        }
    }

    /// Returns the stated correlation model and its lengths along x and y in metre; `None` for the covariance of a scan.
    fn stated_covariance(&self) -> Result<Option<(CorrelationModel, [f64; 2])>, InvalidValue> {
        let needed = |key, message: &str| invalid(SECTION, key, message);
        let model = match self.covariance {
            CovarianceSource::Measured | CovarianceSource::Empirical => return Ok(None),
            CovarianceSource::SquaredExponential => Ok(CorrelationModel::SquaredExponential),
            CovarianceSource::Exponential => Ok(CorrelationModel::Exponential),
            CovarianceSource::Matern => {
                let model = self.smoothness.map(|nu| CorrelationModel::Matern { nu });
                model.ok_or_else(|| needed("smoothness", "a Matérn covariance requires its smoothness ν"))
            }
            CovarianceSource::SelfAffine => {
                let model = self.hurst.map(|hurst| CorrelationModel::SelfAffine { hurst });
                model.ok_or_else(|| needed("hurst", "a self-affine covariance requires its Hurst exponent"))
            }
        };
        let lengths = self
            .correlation_length
            .ok_or_else(|| needed("correlation_length", "a stated covariance needs its lengths along x and y"))?;
        Ok(Some((model?, lengths.map(|length| length.0))))
    }
}
