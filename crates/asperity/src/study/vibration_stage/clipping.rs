//! Limits and warnings about friction values that are clipped to stay positive.

use super::{Ensembles, MARGINS};
use crate::friction::process::ProcessModel;
use crate::friction::{Upscaling, WindowFriction};
use crate::study::check::VibrationStudy;
use crate::study::file::MapSection;
use crate::study::{StudyError, sentence};
use crate::vibration::LARGEST_CLIPPED_FRACTION;

/// Clipped fraction below which no warning is given.
const NEGLIGIBLE: f64 = 1e-4;

/// Returns a warning about a clipped fraction of the friction; `None` below 0.01 %.
pub fn clipping_warning(fraction: f64) -> Option<String> {
    (fraction >= NEGLIGIBLE).then(|| {
        format!(
            "{} % of the friction values were clipped to stay positive; variability is understated",
            sentence::digits(100.0 * fraction)
        )
    })
}

/// Fails if friction that is known before the run is clipped more than the study allows.
pub(in crate::study) fn refuse_clipping(study: &VibrationStudy, window: &WindowFriction) -> Result<(), StudyError> {
    let ensembles = Ensembles::new(study, window, 0)?;
    let process = |upscaling| ensembles.process(upscaling, MARGINS[0]).map(|_| ());
    [Upscaling::Paper, Upscaling::Area].into_iter().try_for_each(process)
}

impl Ensembles<'_> {
    /// Returns the fraction of the values that a process clips.
    ///
    /// # Errors
    /// It exceeds the limit of the study, under the main upscaling. The other upscaling serves for comparison and only
    /// warns.
    pub(super) fn clipped(&self, model: &ProcessModel, upscaling: Upscaling) -> Result<f64, StudyError> {
        self.accept(model.clipped_fraction(), upscaling)
    }

    fn accept(&self, fraction: f64, upscaling: Upscaling) -> Result<f64, StudyError> {
        let leads = upscaling == self.study.upscaling;
        if leads && fraction > LARGEST_CLIPPED_FRACTION && !self.study.allow_clipping {
            return Err(StudyError::Clipped { upscaling: upscaling.name(), fraction, computed: self.window.computed });
        }
        Ok(fraction)
    }

    /// Returns a warning about the points of a stability map at which friction is clipped.
    ///
    /// # Errors
    /// At a point of the first grid more friction is clipped than the study allows.
    pub(super) fn map_clipping(&self, map: &MapSection) -> Result<Option<String>, StudyError> {
        let upscaling = self.study.upscaling;
        let found = self.map_settings(map).clipped_fraction(map.over, &self.oscillator, &self.model(upscaling))?;
        let largest = self.accept(found, upscaling)?;
        Ok(clipping_warning(largest).map(|warning| format!("stability map: at the worst point, {warning}")))
    }
}
