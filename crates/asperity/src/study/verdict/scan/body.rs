//! Bodies of the contact, whose scans leave different values uncertain.

use super::errors::{BodyErrors, StatisticErrors};
use crate::study::counterface;
use crate::study::sentence::digits;
use crate::study::surface_stage::SurfaceStage;
use crate::surface::scanned::ScannedSurface;

use super::Measurement;

/// Body of the contact.
#[derive(Debug, Clone, Copy)]
pub(super) enum Body {
    Surface,
    Counterface,
}

impl Body {
    /// Returns the section of the body in a study file.
    pub(super) fn section(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Counterface => "counterface",
        }
    }

    /// Returns the noun for one specimen of the body.
    fn specimen(self) -> &'static str {
        match self {
            Self::Surface => "part",
            Self::Counterface => "counterface",
        }
    }

    /// Returns the uncertainty due to the scans, in a sentence.
    pub(super) fn sentence(self, scans: usize, scan_std: f64, between_std: f64) -> String {
        let percent = |std: f64| digits(100.0 * std);
        let (section, specimen, change) = (self.section(), self.specimen(), percent(scan_std));
        if scans == 1 {
            return format!(
                "The verdict is for the {specimen} with this scan. Rms height, rms slope and skewness of the {section} are known from the scan \
                 with an error that changes the friction coefficient by {change} % (one standard deviation, unknown). Differences between \
                 {specimen}s are not known."
            );
        }
        format!(
            "Rms height, rms slope and skewness of the {section} are known from {scans} scans with an error that changes the friction \
             coefficient by {change} % (one standard deviation, unknown). Beyond the errors of the scans, {section}s differ by {} %, which \
             varies from part to part.",
            percent(between_std)
        )
    }

    /// Returns a warning about the scans of this body.
    pub(super) fn warning(self, warning: &str) -> String {
        match self {
            Self::Surface => warning.into(),
            Self::Counterface => counterface::named(warning),
        }
    }

    /// Returns the scans of this body, or its profile; none for a stated surface.
    pub(super) fn scans(self, stage: &SurfaceStage) -> Vec<Measurement> {
        let scans = |scan: &Option<ScannedSurface>| scan.as_ref().map_or_else(Vec::new, Measurement::all_of);
        match (self, &stage.profile) {
            (Self::Surface, Some(profile)) => vec![Measurement::of_profile(&profile.statistics)],
            (Self::Surface, None) => scans(&stage.measured),
            (Self::Counterface, _) => scans(&stage.measured_counterface),
        }
    }

    /// Returns errors of this body alone.
    pub(super) fn alone(self, errors: StatisticErrors) -> BodyErrors {
        let mut of_both = BodyErrors::default();
        of_both[self as usize] = errors;
        of_both
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_state_standard_deviations_in_percent() {
        let one = Body::Surface.sentence(1, 0.012, 0.0);
        for words in [
            "for the part with this scan",
            "changes the friction coefficient by 1.2 %",
            "Differences between parts are not known",
        ] {
            assert!(one.contains(words), "{one}");
        }
        let several = Body::Counterface.sentence(3, 0.012, 0.034);
        for words in ["from 3 scans", "coefficient by 1.2 %", "counterfaces differ by 3.4 %"] {
            assert!(several.contains(words), "{several}");
        }
    }

    #[test]
    fn warnings_of_the_counterface_name_it() {
        assert_eq!(Body::Surface.warning("few points"), "few points");
        let named = Body::Counterface.warning("few points");
        assert!(named.contains("counterface") && named.contains("few points"), "{named}");
    }
}
