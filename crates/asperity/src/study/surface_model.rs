//! Model of the random surfaces of a section, and its description.

use crate::correlation::{CorrelationModel, StationaryCovariance};
use crate::study::output::StageOutput;
use crate::study::profile::MeasuredProfile;
use crate::study::{StudyError, sentence};
use crate::surface::model::{
    CovarianceRequest, GAMMA, Measurable, RIDGES, SelectedCovariance, SurfaceCovariance, SurfaceModel, SurfaceRequest,
    Texture,
};
use crate::surface::scanned::ScannedSurface;
use crate::translation::TranslationKind;

/// Makes the model of the random surfaces from the scans or the profile and, if it has a covariance, reports its selection.
/// `stated_marginal` is the text of a stated marginal distribution.
pub(super) fn model_of(
    stated: &SurfaceRequest,
    stated_marginal: Option<&str>,
    measured: Option<&ScannedSurface>,
    profile: Option<&MeasuredProfile>,
    output: &mut StageOutput,
) -> Result<(SurfaceModel, Option<SelectedCovariance>), StudyError> {
    let request = profile.map_or_else(|| stated.clone(), |profile| profile.state(stated.clone()));
    let (model, selected) = SurfaceModel::new(request, measured)?;
    let source = match measured.and_then(|measured| measured.part.as_ref()) {
        _ if profile.is_some() => "the profile",
        Some(_) => "the scans",
        None => "the scan",
    };
    output.assumptions.push(model_sentence(stated, stated_marginal, &model, source));
    if let Some(selected) = &selected {
        output.assumptions.extend(selected.reason.clone());
        output.warnings.extend(selected.warnings.iter().cloned());
    }
    Ok((model, selected))
}

fn model_sentence(
    request: &SurfaceRequest,
    stated_marginal: Option<&str>,
    model: &SurfaceModel,
    scans: &str,
) -> String {
    match &model.texture {
        Texture::WeierstrassMandelbrot { dimension } => format!(
            "Random surfaces are Weierstrass–Mandelbrot functions of fractal dimension {} ({}), wavenumber ratio {GAMMA} and \
             {RIDGES} ridges, from the longer side of a grid down to its pixels, scaled to the rms height {}. Their heights \
             are taken as normal; covariance and marginal distribution of the study have no effect.",
            sentence::digits(*dimension),
            match request {
                SurfaceRequest::WeierstrassMandelbrot { dimension: Measurable::Stated(_), .. } => "stated".into(),
                _ => format!("measured on {scans}"),
            },
            sentence::si(model.marginal.std(), "m"),
        ),
        Texture::Translated { covariance, translation, .. } => format!(
            "Random surfaces have {} of rms height {}. {} imposed by {} translation.",
            covariance_words(request, covariance, scans),
            sentence::si(covariance.std_m(), "m"),
            stated_marginal.map_or_else(
                || "The distribution of the measured heights is".to_owned(),
                |text| format!("The marginal distribution `{text}` is"),
            ),
            match translation {
                TranslationKind::Plain => "plain",
                TranslationKind::Corrected => "corrected",
            }
        ),
    }
}

/// Returns a description of a covariance.
fn covariance_words(request: &SurfaceRequest, covariance: &SurfaceCovariance, scans: &str) -> String {
    let along = |x_m, y_m| format!("{} along x and {} along y", sentence::si(x_m, "m"), sentence::si(y_m, "m"));
    match covariance {
        SurfaceCovariance::Model(model) => {
            let (name, lengths) = match model.model() {
                CorrelationModel::Matern { .. } => ("Matérn", "scales"),
                CorrelationModel::SelfAffine { .. } => ("self-affine", "roll-off lengths"),
                CorrelationModel::Exponential => ("exponential", "lengths"),
                CorrelationModel::SquaredExponential => ("squared exponential", "lengths"),
            };
            let along = along(model.length_x_m(), model.length_y_m());
            match request {
                SurfaceRequest::Translated { covariance: CovarianceRequest::Measured, .. } => {
                    format!("a {name} covariance (fitted to {scans}, {lengths} {along})")
                }
                _ => format!("a {name} covariance (stated, {lengths} {along})"),
            }
        }
        SurfaceCovariance::Empirical(own) => {
            let report = own.report();
            format!(
                "the covariance of {scans} itself (lags up to {} as estimated, then tapered; to make it positive definite {} % of \
                 the variance was clipped and correlations changed by at most {})",
                along(report.reliable_x_m, report.reliable_y_m),
                sentence::digits(100.0 * report.clipped_variance),
                sentence::digits(report.clipping_change),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{CorrelationFamily, Covariance};
    use crate::study::file::SurfaceSection;

    #[test]
    fn the_lengths_of_a_model_are_named() {
        let section = SurfaceSection { file: Some("scan.x3p".into()), ..SurfaceSection::default() };
        let request = section.request(CorrelationFamily::ALL).unwrap();
        let words = |model| {
            let covariance = SurfaceCovariance::Model(Covariance::new(model, 1e-6, 2e-5, 3e-5).unwrap());
            covariance_words(&request, &covariance, "the scan")
        };
        for (model, said) in [
            (CorrelationModel::Exponential, "lengths 20 µm along x"),
            (CorrelationModel::Matern { nu: 1.5 }, "scales 20 µm along x"),
            (CorrelationModel::SelfAffine { hurst: 0.7 }, "roll-off lengths 20 µm along x"),
        ] {
            assert!(words(model).contains(said), "{}", words(model));
        }
    }
}
