//! Selection of the covariance that keeps the spectrum and the slopes of a scan: a model, or the covariance of the scan.

use std::f64::consts::TAU;

use asperity_base::correlation::{
    CorrelationFamily, Covariance, CovarianceFit, CovarianceFits, FitError, FitWarning, MeasuredCovariance,
    StationaryCovariance, fit_covariance,
};
use asperity_base::distribution::Marginal;
use asperity_base::distribution::translation::Translation;
use asperity_base::sentence;
use asperity_base::translation::TranslationKind;

use super::generated::CLIPPED_VARIANCE;
use super::{CovarianceRequest, Roughness, SurfaceCovariance, SurfaceModel, SurfaceModelError, Texture, TrialMaps};
use crate::scanned::ScannedSurface;
use asperity_results::CovarianceCandidateResult;

/// Largest root mean square of ln(measured/model spectral density) over the band of a model that is selected.
const LARGEST_MISFIT: f64 = 0.3;
/// Largest relative difference between Sdq of the surfaces and Sdq of the scan, within the band, of a covariance that is selected.
const SLOPE_TOLERANCE: f64 = 0.1;
/// Relative difference above which there is a warning.
const SLOPE_WARNING: f64 = 0.15;
/// Excess kurtosis of heights above which a few extremes contain much of the slopes.
const HEAVY_TAILS: f64 = 3.0;
/// Number of independent patches below which a covariance has a warning: ten lengths along each side.
const FEW_PATCHES: f64 = 100.0;
/// Corner of the slope correction over the end of the band.
const CORNER: f64 = 0.25;

/// Selected covariance of a random surface.
#[derive(Debug, Clone)]
pub struct SelectedCovariance {
    /// Covariance.
    pub covariance: SurfaceCovariance,
    /// Misfit of a fitted model: root mean square of ln(measured/model spectral density) over the band.
    pub misfit: Option<f64>,
    /// Sdq of trial maps over Sdq of the scan, within the band.
    pub slope_ratio: Option<f64>,
    /// Trial maps; `None` for a stated covariance, or if the band does not fit on a map.
    pub trial: Option<TrialMaps>,
    /// Cutoff of the S-filter at the end of the band in metre.
    pub slope_cutoff_m: Option<f64>,
    /// Length in metre of the shortest wave that the scan resolves; `None` for a stated covariance.
    pub shortest_wave_m: Option<f64>,
    /// Covariances that were compared.
    pub candidates: Vec<CovarianceCandidateResult>,
    /// Sentence on the reason of the selection, if there was a choice.
    pub reason: Option<String>,
    /// Warnings in sentences.
    pub warnings: Vec<String>,
}

/// Comparison of covariances by the slopes of their random surfaces.
struct Judge<'a> {
    roughness: &'a Roughness,
    /// Distortion of the correlation by the marginal distribution; `None` if that is normal or corrected for.
    translation: Option<Translation>,
    /// Rms height of the scan over rms height of the random surfaces.
    scale: f64,
}

/// A fitted model, its covariance of the random surfaces, and their expected Sdq over that of the scan.
type JudgedModel = (CovarianceFit, SurfaceCovariance, Option<f64>);

impl Judge<'_> {
    /// Returns the expected Sdq of the random surfaces over Sdq of the scan.
    fn ratio(&self, covariance: &dyn StationaryCovariance) -> Option<f64> {
        let slopes = self.roughness.slopes.as_ref()?;
        Some(self.scale * slopes.ratio(covariance, self.translation.as_ref()))
    }

    /// Returns a fitted model, as the covariance of the random surfaces with their rms height, and with its ratio.
    fn model(&self, fit: &CovarianceFit, std_m: f64) -> Result<JudgedModel, SurfaceModelError> {
        let own = fit.covariance;
        let scaled = Covariance::new(own.model(), std_m, own.length_x_m(), own.length_y_m())?;
        let covariance = SurfaceCovariance::Model(scaled);
        let ratio = self.ratio(&covariance);
        Ok((fit.clone(), covariance, ratio))
    }

    /// Returns the ratio of the Gaussian field before the translation.
    fn gaussian_ratio(&self, covariance: &dyn StationaryCovariance) -> Option<f64> {
        Some(self.scale * self.roughness.slopes.as_ref()?.ratio(covariance, None))
    }
}

fn is_near(ratio: Option<f64>, tolerance: f64) -> bool {
    ratio.is_none_or(|ratio| (ratio - 1.0).abs() <= tolerance)
}

/// Selects the covariance of random surfaces with the marginal distribution `marginal` and, without a scan, the rms height `std_m`. A
/// measured covariance is one of `families` or the covariance of the scan.
pub(super) fn select(
    request: CovarianceRequest,
    translation: TranslationKind,
    families: &[CorrelationFamily],
    // The standard deviation of a distribution with other parameters differs from the rms height in its last digits.
    (marginal, std_m): (&Marginal, f64),
    scan: Option<&ScannedSurface>,
) -> Result<SelectedCovariance, SurfaceModelError> {
    let std_m = if scan.is_some() { marginal.std() } else { std_m };
    let stated = match request {
        CovarianceRequest::Stated { model, lengths_m: [x_m, y_m] } => {
            Some(SurfaceCovariance::Model(Covariance::new(model, std_m, x_m, y_m)?))
        }
        CovarianceRequest::Measured | CovarianceRequest::Empirical => None,
    };
    let measured = match (scan, &stated) {
        (Some(measured), _) => measured,
        (None, Some(covariance)) => return Ok(SelectedCovariance::new(covariance.clone())),
        (None, None) => return Err(SurfaceModelError::NoScan("the covariance")),
    };
    let roughness = measured.roughness()?;
    let is_plain = translation == TranslationKind::Plain && !matches!(marginal, Marginal::Normal { .. });
    let of_heights = if is_plain { Some(Translation::new(marginal)?) } else { None };
    let judge = Judge { roughness: &roughness, translation: of_heights, scale: measured.sq_m() / std_m };
    let fits = fit_covariance(&roughness.spectra.iter().collect::<Vec<_>>(), measured.sq_m(), families);
    let models = match &fits {
        Err(_) => vec![],
        Ok(found) => found.fits.iter().map(|fit| judge.model(fit, std_m)).collect::<Result<_, _>>()?,
    };
    let candidate = |(fit, _, ratio): &JudgedModel| CovarianceCandidateResult {
        model: fit.covariance.model().name().to_owned(),
        misfit: Some(fit.misfit),
        slope_ratio: *ratio,
    };
    let mut candidates: Vec<_> = models.iter().map(candidate).collect();
    if let Some(covariance) = stated {
        // A stated surface need not resemble the scan.
        return Ok(SelectedCovariance { candidates, ..SelectedCovariance::new(covariance) });
    }
    let is_free = request == CovarianceRequest::Measured;
    // The covariance of the scan keeps an oblique lay, but depends on as few patches as a model.
    let of_any = fits.as_ref().map_or(Vec::new(), |fits| few_lengths(&fits.warnings));
    let is_said = !of_any.is_empty();
    let is_oblique = fits.as_ref().is_ok_and(|fits| fits.oblique);
    let model = models.iter().find(|(fit, ..)| !is_oblique && fit.misfit <= LARGEST_MISFIT);
    let model = model.map(|(fit, covariance, _)| (fit.clone(), covariance.clone()));
    let shortest_wave_m = Some(roughness.shortest_wave_m());
    let mut chosen = if is_free {
        measured_choice(measured, &judge, models, fits, families, std_m)?
    } else {
        SelectedCovariance::new(own_covariance(measured, std_m)?)
    };
    candidates.append(&mut chosen.candidates);
    chosen.candidates = candidates;
    if let Some(slopes) = &roughness.slopes {
        let draw = |covariance: &SurfaceCovariance| {
            let covariance = covariance.clone();
            let texture = Texture::Translated { covariance, translation, expansion: None };
            let model = SurfaceModel { marginal: marginal.clone(), texture, shortest_wave_m };
            TrialMaps::draw(&model, judge.scale, measured.map.grid(), measured.level, slopes)
        };
        chosen.try_out(draw(&chosen.covariance)?);
        if is_free && families.len() == CorrelationFamily::ALL.len() {
            chosen = nearest(chosen, model, measured, &judge, draw)?;
        }
        chosen.slope_cutoff_m = Some(slopes.cutoff_m);
        chosen.warnings.extend(slope_warning(&chosen, &judge, marginal));
    }
    if is_free {
        let missing: Vec<String> = of_any.into_iter().filter(|warning| !chosen.warnings.contains(warning)).collect();
        chosen.warnings.extend(missing);
    }
    // Fits that follow the scan badly know its length as little as no fit does.
    if !is_said {
        chosen.warnings.extend(patches_warning(&chosen.covariance));
    }
    chosen.warnings.extend(noise_warning(measured));
    chosen.shortest_wave_m = shortest_wave_m;
    Ok(chosen)
}

/// Returns the warnings of fits to few correlation lengths.
fn few_lengths(warnings: &[FitWarning]) -> Vec<String> {
    let few = warnings.iter().filter(|warning| matches!(warning, FitWarning::FewLengths { .. }));
    few.map(|warning| format!("covariance fit: {warning}")).collect()
}

/// Returns the warning of a covariance of the scan that rests on few patches.
fn patches_warning(covariance: &SurfaceCovariance) -> Option<String> {
    let SurfaceCovariance::Empirical(own) = covariance else { return None };
    let patches = own.report().standard_error.powi(-2);
    (patches < FEW_PATCHES).then(|| {
        let patches = sentence::digits(patches);
        format!("covariance of the scan: it rests on only {patches} independent patches of the map")
    })
}

impl SelectedCovariance {
    /// Stores trial maps and their slopes.
    fn try_out(&mut self, trial: Option<TrialMaps>) {
        self.slope_ratio = trial.as_ref().map(TrialMaps::slope_ratio);
        self.trial = trial;
    }

    fn new(covariance: SurfaceCovariance) -> Self {
        Self {
            covariance,
            misfit: None,
            slope_ratio: None,
            trial: None,
            slope_cutoff_m: None,
            shortest_wave_m: None,
            candidates: vec![],
            reason: None,
            warnings: vec![],
        }
    }
}

/// Returns the covariance of the scan.
fn own_covariance(measured: &ScannedSurface, std_m: f64) -> Result<SurfaceCovariance, SurfaceModelError> {
    let covariance = match &measured.part {
        Some(part) => MeasuredCovariance::new(&part.correlation)?,
        None => MeasuredCovariance::from_map(&measured.map)?,
    };
    Ok(SurfaceCovariance::Empirical(Box::new(covariance.with_std(std_m))))
}

/// Selects the best model that meets the spectrum and the slopes, or else the covariance of the scan, changed if the marginal
/// distribution distorts its slopes. If the caller asks for fewer families than all, selects the best of them.
fn measured_choice(
    measured: &ScannedSurface,
    judge: &Judge<'_>,
    models: Vec<JudgedModel>,
    fits: Result<CovarianceFits, FitError>,
    families: &[CorrelationFamily],
    std_m: f64,
) -> Result<SelectedCovariance, SurfaceModelError> {
    let of_model = |fits: &CovarianceFits, (fit, covariance, _): (CovarianceFit, SurfaceCovariance, Option<f64>)| {
        let warnings = fits.warnings.iter().map(|warning| format!("covariance fit: {warning}")).collect();
        SelectedCovariance { misfit: Some(fit.misfit), warnings, ..SelectedCovariance::new(covariance) }
    };
    let failure = match &fits {
        Err(error) => error.to_string(),
        Ok(fits) => {
            let is_oblique = fits.oblique && families.len() == CorrelationFamily::ALL.len();
            let passes = |(fit, _, ratio): &&(CovarianceFit, SurfaceCovariance, Option<f64>)| {
                !is_oblique && fit.misfit <= LARGEST_MISFIT && is_near(*ratio, SLOPE_TOLERANCE)
            };
            if let Some(model) = models.iter().find(passes) {
                let mut chosen = of_model(fits, model.clone());
                chosen.reason = Some(format!(
                    "The {} model was fitted to the scan's spectrum by likelihood; within the reliable band it meets the \
                     spectral density to {} % rms{}.",
                    model.0.covariance.model().name(),
                    sentence::digits(100.0 * model.0.misfit.exp_m1()),
                    model.2.map_or(String::new(), |ratio| format!(" and has {} the scan's Sdq", times(ratio))),
                ));
                return Ok(chosen);
            }
            let best = &models[0];
            if is_oblique {
                "the lay runs at an angle to the axes, which no model has".into()
            } else {
                format!(
                    "no model meets the scan's spectrum and slopes (the best, {}, misses the spectral density by {} % rms{})",
                    best.0.covariance.model().name(),
                    sentence::digits(100.0 * best.0.misfit.exp_m1()),
                    best.2.map_or(String::new(), |ratio| format!(" and has {} the scan's Sdq", times(ratio))),
                )
            }
        }
    };
    if families.len() < CorrelationFamily::ALL.len() {
        return match fits {
            Err(error) => Err(error.into()),
            Ok(fits) => Ok(of_model(&fits, models[0].clone())),
        };
    }
    let own = match own_covariance(measured, std_m) {
        Ok(own) => own,
        // Without the covariance of the scan, the nearest model is selected.
        Err(error) => {
            let Ok(fits) = fits else { return Err(error) };
            let nearest = models.into_iter().min_by(|a, b| distance(a.2).total_cmp(&distance(b.2)));
            let Some(nearest) = nearest else { return Err(error) };
            let mut chosen = of_model(&fits, nearest);
            chosen.warnings.push(format!("{failure}; the scan's own covariance cannot be used: {error}"));
            return Ok(chosen);
        }
    };
    Ok(own_choice(judge, own, &failure))
}

/// Selects the covariance of the scan because of `failure`. If the marginal distribution changes its slopes, selects the covariance
/// of normal variables with which the heights keep them.
fn own_choice(judge: &Judge<'_>, own: SurfaceCovariance, failure: &str) -> SelectedCovariance {
    let ratio = judge.ratio(&own);
    let mut chosen = SelectedCovariance::new(own);
    let candidate = CovarianceCandidateResult { model: "empirical".into(), misfit: None, slope_ratio: ratio };
    chosen.candidates.push(candidate);
    chosen.reason = Some(format!("The scan's own covariance was taken because {failure}."));
    if is_near(ratio, SLOPE_TOLERANCE) {
        return chosen;
    }
    if let (Some(translation), Some(slopes), SurfaceCovariance::Empirical(own)) =
        (&judge.translation, &judge.roughness.slopes, &chosen.covariance)
    {
        let corner = CORNER * TAU / slopes.cutoff_m;
        let adjusted =
            own.beneath(|rho| translation.correlation(rho), corner, |own| judge.ratio(own).unwrap_or(f64::NAN));
        if distance(judge.ratio(&adjusted)) < distance(ratio) {
            chosen.reason = Some(format!(
                "The scan's own covariance was taken because {failure}. Under the marginal distribution it would have {} the scan's Sdq; \
                 the covariance of the normal variables was changed so that the heights keep the slopes.",
                times(ratio.unwrap_or(f64::NAN)),
            ));
            chosen.covariance = SurfaceCovariance::Empirical(Box::new(adjusted));
        }
    }
    chosen
}

/// Returns a warning if heights hardly correlate with their neighbours.
fn noise_warning(measured: &ScannedSurface) -> Option<String> {
    let correlation = measured.part.as_ref().map_or(&measured.correlation, |part| &part.correlation);
    let (along_x, along_y) = (correlation.correlation(1, 0), correlation.correlation(0, 1));
    let least = along_x.min(along_y);
    (least < (-1.0_f64).exp()).then(|| {
        format!(
            "neighbouring heights of the scan correlate by {} along x and {} along y, less than 1/e: they are noise, or a texture \
             shorter than the pixels, and so are the random surfaces; an S-filter or the rejection of outliers leaves what the \
             scan resolves",
            sentence::digits(along_x),
            sentence::digits(along_y)
        )
    })
}

/// Returns the distance of a ratio from 1, equal for r and 1/r.
fn distance(ratio: Option<f64>) -> f64 {
    ratio.map_or(0.0, |ratio| ratio.ln().abs())
}

/// Formats a ratio: "1.04 times".
fn times(ratio: f64) -> String {
    format!("{} times", sentence::digits(ratio))
}

/// Compares trial maps of other covariances if those of the selected one have other slopes than the scan, and selects the nearest.
///
/// A model is compared with the covariance of the scan. The covariance of the scan is compared with `model`, which meets the
/// spectrum of the scan, and with itself before it was changed for the marginal distribution.
fn nearest(
    mut chosen: SelectedCovariance,
    model: Option<(CovarianceFit, SurfaceCovariance)>,
    measured: &ScannedSurface,
    judge: &Judge<'_>,
    draw: impl Fn(&SurfaceCovariance) -> Result<Option<TrialMaps>, SurfaceModelError>,
) -> Result<SelectedCovariance, SurfaceModelError> {
    let Some(ratio) = chosen.slope_ratio.filter(|ratio| !is_near(Some(*ratio), SLOPE_WARNING)) else {
        return Ok(chosen);
    };
    let failure = |name: &str| format!("maps drawn with {name} have {} the scan's Sdq", times(ratio));
    let own = own_covariance(measured, chosen.covariance.std_m()).ok();
    let others: Vec<SelectedCovariance> = match &chosen.covariance {
        SurfaceCovariance::Model(found) => {
            let failure = failure(&format!("the {} model", found.model().name()));
            own.into_iter().map(|own| own_choice(judge, own, &failure)).collect()
        }
        SurfaceCovariance::Empirical(_) => {
            let failure = failure("the scan's own covariance");
            let model = model.map(|(fit, covariance)| {
                let name = fit.covariance.model().name();
                let reason = Some(format!(
                    "The {name} model was fitted to the scan's spectrum by likelihood because {failure}."
                ));
                SelectedCovariance { misfit: Some(fit.misfit), reason, ..SelectedCovariance::new(covariance) }
            });
            let unchanged = own.filter(|own| judge.ratio(own) != judge.ratio(&chosen.covariance));
            let unchanged = unchanged.map(|own| {
                let reason = format!(
                    "The scan's own covariance was taken as it is: changed for the marginal distribution, {failure}."
                );
                SelectedCovariance { reason: Some(reason), ..SelectedCovariance::new(own) }
            });
            model.into_iter().chain(unchanged).collect()
        }
    };
    for mut other in others {
        other.try_out(draw(&other.covariance)?);
        let candidates = [chosen.candidates.as_slice(), &other.candidates].concat();
        let is_nearer = distance(other.slope_ratio) < distance(chosen.slope_ratio);
        chosen = SelectedCovariance { candidates, ..if is_nearer { other } else { chosen } };
    }
    Ok(chosen)
}

/// Returns a warning if the slopes of a trial map differ from those of the scan.
fn slope_warning(chosen: &SelectedCovariance, judge: &Judge<'_>, marginal: &Marginal) -> Option<String> {
    let trial = chosen.trial.as_ref()?;
    let (least, most) = trial.slope_range();
    if is_near(Some(least), SLOPE_WARNING) && is_near(Some(most), SLOPE_WARNING) {
        return None;
    }
    let ratio = trial.slope_ratio();
    let (expected, gaussian) = (judge.ratio(&chosen.covariance), judge.gaussian_ratio(&chosen.covariance));
    let reason = if trial.clipped_variance > CLIPPED_VARIANCE {
        format!(
            "a map of this size holds too few correlation lengths, so that {} % of the variance was clipped and its waves changed; a \
             larger scan, or a form of higher degree to remove, helps",
            sentence::digits(100.0 * trial.clipped_variance)
        )
    } else if judge.translation.is_some()
        && (distance(gaussian) < 0.5 * distance(expected) || marginal.excess_kurtosis() > HEAVY_TAILS)
    {
        format!(
            "the marginal distribution of the heights (kurtosis {}) distorts the slopes of the normal variables beneath; reject outliers, or \
             use marginal = \"normal\"",
            sentence::digits(3.0 + marginal.excess_kurtosis())
        )
    } else if is_near(expected, SLOPE_TOLERANCE) {
        "a map of this size holds few correlation lengths, and maps differ that much by chance; a larger scan helps"
            .to_owned()
    } else {
        "the covariance does not follow the scan's spectrum up to the end of its band".to_owned()
    };
    let cutoff = sentence::si(chosen.slope_cutoff_m?, "m");
    Some(format!(
        "the slopes of the random surfaces are {} those of the scan, of single maps {} to {} (Sdq, both S-filtered at {cutoff}, the end \
         of the scan's reliable band): {reason}. Elastic contact area and friction depend on slopes",
        times(ratio),
        sentence::digits(least),
        times(most),
    ))
}
