//! Checks of `[surface]`.

use std::str::FromStr;

use asperity_formats::LengthUnit;

use super::{InvalidValue, POSITIVE, at_least, invalid, positive, within};
use crate::distribution::Marginal;
use crate::map::{BoundaryKind, PITCH_RANGE_M};
use crate::study::file::StudyFile;
use crate::surface::{CovarianceSource, SurfaceGenerator};

impl StudyFile {
    pub(super) fn check_surface(&self) -> Result<(), InvalidValue> {
        const SECTION: &str = "surface";
        let Some(s) = &self.surface else {
            return match (self.pressure.is_some() || self.friction.is_some(), self.vibration.is_some()) {
                (true, _) => Err(invalid(SECTION, "file", "[pressure] and [friction] need a [surface] section")),
                (false, false) => Err(invalid(SECTION, "file", "the study has no stage; add a [surface] section")),
                (false, true) => Ok(()),
            };
        };
        if let Some(pixel) = s.pixel_size {
            for side in pixel {
                let (low, high) = (PITCH_RANGE_M.start(), PITCH_RANGE_M.end());
                let expected = format!("a size between {low:e} m and {high:e} m");
                within(SECTION, "pixel_size", side.0, |side| PITCH_RANGE_M.contains(&side), &expected)?;
            }
        }
        if let Some(Err(error)) = s.height_unit.as_deref().map(str::parse::<LengthUnit>) {
            return Err(invalid(SECTION, "height_unit", error.to_string()));
        }
        if let Some(outliers) = s.outliers {
            within(SECTION, "outliers", outliers, |k| k >= 1.0, "at least 1 standard deviation")?;
        }
        for (key, cutoff) in [("s_filter", s.s_filter), ("l_filter", s.l_filter)] {
            if let Some(cutoff) = cutoff {
                within(SECTION, key, cutoff.0, positive, POSITIVE)?;
            }
        }
        if let (Some(short), Some(long)) = (s.s_filter, s.l_filter) {
            let expected = "a cutoff longer than `s_filter`, so that some wavelengths remain";
            within(SECTION, "l_filter", long.0, |cutoff| cutoff > short.0, expected)?;
        }
        if let Some(rms) = s.rms_height {
            within(SECTION, "rms_height", rms.0, positive, POSITIVE)?;
        }
        for length in s.correlation_length.into_iter().flatten() {
            within(SECTION, "correlation_length", length.0, positive, POSITIVE)?;
        }
        if let Some(hurst) = s.hurst {
            within(SECTION, "hurst", hurst, |h| h > 0.0 && h < 1.0, "a Hurst exponent strictly between 0 and 1")?;
        }
        if let Some(smoothness) = s.smoothness {
            within(SECTION, "smoothness", smoothness, positive, POSITIVE)?;
        }
        if let Some(dimension) = s.fractal_dimension {
            within(
                SECTION,
                "fractal_dimension",
                dimension,
                |d| d > 2.0 && d < 3.0,
                "a value strictly between 2 and 3",
            )?;
        }
        at_least(SECTION, "modes", s.modes.unwrap_or(1), 1)?;
        if s.marginal != "measured" {
            Marginal::from_str(&s.marginal).map_err(|error| invalid(SECTION, "marginal", error.to_string()))?;
        }
        let gaussian = s.generator != SurfaceGenerator::WeierstrassMandelbrot;
        let expanded = s.generator == SurfaceGenerator::KarhunenLoeve;
        for (key, stated) in [("mean_mode", !s.mean_mode), ("rescale", s.rescale.is_some())] {
            if stated && !expanded {
                return Err(invalid(SECTION, key, "this key requires generator = \"karhunen_loeve\""));
            }
        }
        if !s.mean_mode && self.pressure.as_ref().is_some_and(|p| p.boundary == BoundaryKind::Free) {
            let message = "only periodic patches have a constant Fourier mode to omit; set boundary = \"periodic\" in \
                           [pressure]";
            return Err(invalid(SECTION, "mean_mode", message));
        }
        if s.rescale.is_some() && s.marginal != "normal" {
            let message = "this key requires marginal = \"normal\"; any other distribution is imposed at every point";
            return Err(invalid(SECTION, "rescale", message));
        }
        if s.file.is_some() && s.files().is_empty() {
            return Err(invalid(SECTION, "file", "the list of scans is empty; name at least one, or remove `file`"));
        }
        if s.file.is_none() {
            let missing =
                |key, what: &str| invalid(SECTION, key, format!("{what} cannot be measured without `file`; state it"));
            if gaussian && s.covariance.is_of_the_scan() {
                return Err(missing("covariance", "the covariance"));
            }
            if gaussian && s.marginal == "measured" {
                return Err(missing("marginal", "the marginal distribution"));
            }
            if s.rms_height.is_none() {
                return Err(missing("rms_height", "the rms height"));
            }
        }
        if !s.covariance.is_of_the_scan() && s.correlation_length.is_none() {
            return Err(invalid(SECTION, "correlation_length", "a stated covariance needs its lengths along x and y"));
        }
        if s.covariance == CovarianceSource::SelfAffine && s.hurst.is_none() {
            return Err(invalid(SECTION, "hurst", "a self-affine covariance requires its Hurst exponent"));
        }
        if s.covariance == CovarianceSource::Matern && s.smoothness.is_none() {
            return Err(invalid(SECTION, "smoothness", "a Matérn covariance requires its smoothness ν"));
        }
        if !gaussian && s.fractal_dimension.is_none() && s.file.is_none() {
            let message = "the Weierstrass–Mandelbrot generator requires this key if there is no scan to measure it on";
            return Err(invalid(SECTION, "fractal_dimension", message));
        }
        Ok(())
    }
}
