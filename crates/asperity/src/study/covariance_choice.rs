//! Which covariance the random surfaces of a scan have: the model, or the scan's own, that keeps its spectrum and its slopes.

use crate::correlation::{
    CorrelationFamily, Covariance, CovarianceFit, CovarianceFits, FitError, FitWarning, MeasuredCovariance,
    StationaryCovariance, fit_covariance,
};
use crate::distribution::Marginal;
use crate::distribution::translation::Translation;
use crate::study::band_slopes::Roughness;
use crate::study::file::SurfaceSection;
use crate::study::measured::Measured;
use crate::study::surface_model::{CLIPPED_VARIANCE, SurfaceCovariance, SurfaceModel, Texture};
use crate::study::trial::Trial;
use crate::study::{StudyError, sentence};
use crate::surface::CovarianceSource;
use crate::translation::TranslationKind;

/// A model is taken where ln(measured/model spectral density) is below this, in the root mean square over the band.
const LARGEST_MISFIT: f64 = 0.3;
/// A covariance is taken where the Sdq of its surfaces within the band is that of the scan to this fraction.
const SLOPE_TOLERANCE: f64 = 0.1;
/// A greater difference is warned about.
const SLOPE_WARNING: f64 = 0.15;
/// Excess kurtosis of heights of which a few extremes hold much of the slopes.
const HEAVY_TAILS: f64 = 3.0;
/// Corner of the slope correction over the end of the band.
const CORNER: f64 = 0.25;

/// The covariance that was taken.
pub(super) struct Chosen {
    pub(super) covariance: SurfaceCovariance,
    /// Misfit of a fitted model.
    pub(super) misfit: Option<f64>,
    /// Sdq of drawn maps over that of the scan, within the band.
    pub(super) slope_ratio: Option<f64>,
    /// The drawn maps.
    pub(super) trial: Option<Trial>,
    /// Cutoff of the S-filter at the end of the band in metre.
    pub(super) slope_cutoff_m: Option<f64>,
    /// What else was tried: name, misfit, ratio of slopes.
    pub(super) candidates: Vec<(String, Option<f64>, Option<f64>)>,
    /// Why it was taken, where there was a choice.
    pub(super) reason: Option<String>,
    pub(super) warnings: Vec<String>,
}

/// Judges covariances by the slopes of their random surfaces.
struct Judge<'a> {
    roughness: &'a Roughness,
    /// Distortion of the correlation by the marginal law, unless that is normal or corrected for.
    translation: Option<Translation>,
    /// Rms height of the scan over that of the random surfaces, where a study states another.
    scale: f64,
}

impl Judge<'_> {
    fn ratio(&self, covariance: &dyn StationaryCovariance) -> Option<f64> {
        let slopes = self.roughness.slopes.as_ref()?;
        Some(self.scale * slopes.ratio(covariance, self.translation.as_ref()))
    }

    /// The ratio of the Gaussian field beneath the translation.
    fn gaussian_ratio(&self, covariance: &dyn StationaryCovariance) -> Option<f64> {
        Some(self.scale * self.roughness.slopes.as_ref()?.ratio(covariance, None))
    }
}

fn is_near(ratio: Option<f64>, tolerance: f64) -> bool {
    ratio.is_none_or(|ratio| (ratio - 1.0).abs() <= tolerance)
}

/// The covariance of a section's random surfaces of the marginal law `marginal`, which has their rms height; a measured one is
/// chosen among `families` and the scan's own.
pub(super) fn choose(
    section: &SurfaceSection,
    measured: &Measured,
    families: &[CorrelationFamily],
    marginal: &Marginal,
) -> Result<Chosen, StudyError> {
    let std_m = marginal.std();
    let roughness = measured.roughness()?;
    let is_plain = section.translation == TranslationKind::Plain && !matches!(marginal, Marginal::Normal { .. });
    let translation = if is_plain { Some(Translation::new(marginal)?) } else { None };
    let judge = Judge { roughness: &roughness, translation, scale: measured.sq_m() / std_m };
    let spectra: Vec<_> = roughness.spectra.iter().collect();
    let fits = fit_covariance(&spectra, measured.sq_m(), families);
    let models: Vec<(CovarianceFit, SurfaceCovariance, Option<f64>)> = match &fits {
        Err(_) => vec![],
        Ok(found) => found
            .fits
            .iter()
            .map(|fit| {
                let own = fit.covariance;
                let scaled = Covariance::new(own.model(), std_m, own.length_x_m(), own.length_y_m())?;
                let covariance = SurfaceCovariance::Model(scaled);
                let ratio = judge.ratio(&covariance);
                Ok((fit.clone(), covariance, ratio))
            })
            .collect::<Result<_, StudyError>>()?,
    };
    let candidates: Vec<_> = models
        .iter()
        .map(|(fit, _, ratio)| (fit.covariance.model().name().to_owned(), Some(fit.misfit), *ratio))
        .collect();
    // The scan's own covariance keeps an oblique lay, but it rests on as few patches as a model.
    let of_any: Vec<String> = fits.as_ref().map_or(Vec::new(), |fits| {
        let few = fits.warnings.iter().filter(|warning| matches!(warning, FitWarning::FewLengths { .. }));
        few.map(|warning| format!("covariance fit: {warning}")).collect()
    });
    let is_oblique = fits.as_ref().is_ok_and(|fits| fits.oblique);
    let model = models.iter().find(|(fit, ..)| !is_oblique && fit.misfit <= LARGEST_MISFIT);
    let model = model.map(|(fit, covariance, _)| (fit.clone(), covariance.clone()));
    let mut chosen = match section.covariance {
        CovarianceSource::Measured => measured_choice(measured, &judge, models, fits, families, std_m)?,
        CovarianceSource::Empirical => Chosen::new(own_covariance(measured, std_m)?),
        _ => {
            let covariance = stated(section, std_m)?;
            // A stated surface need not be like the scan.
            return Ok(Chosen { candidates, ..Chosen::new(covariance) });
        }
    };
    for candidate in candidates.into_iter().rev() {
        chosen.candidates.insert(0, candidate);
    }
    if let Some(slopes) = &roughness.slopes {
        let draw = |covariance: &SurfaceCovariance| {
            let (covariance, translation) = (covariance.clone(), section.translation);
            let texture = Texture::Translated { covariance, translation, expansion: None };
            let model = SurfaceModel { marginal: marginal.clone(), texture };
            Trial::draw(&model, judge.scale, measured.map.grid(), measured.level, slopes)
        };
        chosen.try_out(draw(&chosen.covariance)?);
        if section.covariance == CovarianceSource::Measured && families.len() == CorrelationFamily::ALL.len() {
            chosen = nearest(chosen, model, measured, &judge, draw)?;
        }
        chosen.slope_cutoff_m = Some(slopes.cutoff_m);
        chosen.warnings.extend(slope_warning(&chosen, &judge, marginal));
    }
    if section.covariance == CovarianceSource::Measured {
        let missing: Vec<String> = of_any.into_iter().filter(|warning| !chosen.warnings.contains(warning)).collect();
        chosen.warnings.extend(missing);
    }
    chosen.warnings.extend(noise_warning(measured));
    Ok(chosen)
}

/// A covariance whose parameters the study states.
pub(super) fn stated(section: &SurfaceSection, std_m: f64) -> Result<SurfaceCovariance, StudyError> {
    use crate::correlation::CorrelationModel as Model;

    let model = match section.covariance {
        CovarianceSource::Measured | CovarianceSource::Empirical => return Err(StudyError::NoStage("surface")),
        CovarianceSource::SquaredExponential => Model::SquaredExponential,
        CovarianceSource::Exponential => Model::Exponential,
        CovarianceSource::Matern => Model::Matern { nu: section.smoothness.unwrap_or(f64::NAN) },
        CovarianceSource::SelfAffine => Model::SelfAffine { hurst: section.hurst.unwrap_or(f64::NAN) },
    };
    let [x, y] = section.correlation_length.map_or([f64::NAN; 2], |lengths| lengths.map(|length| length.0));
    Ok(SurfaceCovariance::Model(Covariance::new(model, std_m, x, y)?))
}

impl Chosen {
    /// Takes the slopes of drawn maps.
    fn try_out(&mut self, trial: Option<Trial>) {
        self.slope_ratio = trial.as_ref().map(Trial::slope_ratio);
        self.trial = trial;
    }

    pub(super) fn new(covariance: SurfaceCovariance) -> Self {
        Self {
            covariance,
            misfit: None,
            slope_ratio: None,
            trial: None,
            slope_cutoff_m: None,
            candidates: vec![],
            reason: None,
            warnings: vec![],
        }
    }
}

/// The scan's own covariance.
fn own_covariance(measured: &Measured, std_m: f64) -> Result<SurfaceCovariance, StudyError> {
    let covariance = match &measured.part {
        Some(part) => MeasuredCovariance::new(&part.correlation)?,
        None => MeasuredCovariance::from_map(&measured.map)?,
    };
    Ok(SurfaceCovariance::Empirical(Box::new(covariance.with_std(std_m))))
}

/// The best model that meets the spectrum and the slopes; else the scan's own covariance; else that changed for the marginal law.
/// Where the caller asks for fewer families than all, the best of them is taken.
fn measured_choice(
    measured: &Measured,
    judge: &Judge<'_>,
    models: Vec<(CovarianceFit, SurfaceCovariance, Option<f64>)>,
    fits: Result<CovarianceFits, FitError>,
    families: &[CorrelationFamily],
    std_m: f64,
) -> Result<Chosen, StudyError> {
    let of_model = |fits: &CovarianceFits, (fit, covariance, _): (CovarianceFit, SurfaceCovariance, Option<f64>)| {
        let warnings = fits.warnings.iter().map(|warning| format!("covariance fit: {warning}")).collect();
        Chosen { misfit: Some(fit.misfit), warnings, ..Chosen::new(covariance) }
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
        // A model is better than nothing.
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

/// The scan's own covariance, taken because of `failure`; where the marginal law changes its slopes, that of normal variables under
/// which the heights keep them.
fn own_choice(judge: &Judge<'_>, own: SurfaceCovariance, failure: &str) -> Chosen {
    let ratio = judge.ratio(&own);
    let mut chosen = Chosen::new(own);
    chosen.candidates.push(("empirical".into(), None, ratio));
    chosen.reason = Some(format!("The scan's own covariance was taken because {failure}."));
    if is_near(ratio, SLOPE_TOLERANCE) {
        return chosen;
    }
    if let (Some(translation), Some(slopes), SurfaceCovariance::Empirical(own)) =
        (&judge.translation, &judge.roughness.slopes, &chosen.covariance)
    {
        let corner = CORNER * std::f64::consts::TAU / slopes.cutoff_m;
        let adjusted =
            own.beneath(|rho| translation.correlation(rho), corner, |own| judge.ratio(own).unwrap_or(f64::NAN));
        if distance(judge.ratio(&adjusted)) < distance(ratio) {
            chosen.reason = Some(format!(
                "The scan's own covariance was taken because {failure}. Under the marginal law it would have {} the scan's Sdq; \
                 the covariance of the normal variables was changed so that the heights keep the slopes.",
                times(ratio.unwrap_or(f64::NAN)),
            ));
            chosen.covariance = SurfaceCovariance::Empirical(Box::new(adjusted));
        }
    }
    chosen
}

/// Heights that hardly correlate with their neighbours.
fn noise_warning(measured: &Measured) -> Option<String> {
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

/// Distance of a ratio from 1, the same for r and 1/r.
fn distance(ratio: Option<f64>) -> f64 {
    ratio.map_or(0.0, |ratio| ratio.ln().abs())
}

/// "1.04 times".
fn times(ratio: f64) -> String {
    format!("{} times", sentence::digits(ratio))
}

/// Where drawn maps have other slopes than the scan, tries the scan's own covariance in place of a model, or in its place `model`, which
/// meets the scan's spectrum, and what it was changed from; the covariance whose maps are nearest is taken.
fn nearest(
    mut chosen: Chosen,
    model: Option<(CovarianceFit, SurfaceCovariance)>,
    measured: &Measured,
    judge: &Judge<'_>,
    draw: impl Fn(&SurfaceCovariance) -> Result<Option<Trial>, StudyError>,
) -> Result<Chosen, StudyError> {
    let Some(ratio) = chosen.slope_ratio.filter(|ratio| !is_near(Some(*ratio), SLOPE_WARNING)) else {
        return Ok(chosen);
    };
    let failure = |name: &str| format!("maps drawn with {name} have {} the scan's Sdq", times(ratio));
    let own = own_covariance(measured, chosen.covariance.std_m()).ok();
    let others: Vec<Chosen> = match &chosen.covariance {
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
                Chosen { misfit: Some(fit.misfit), reason, ..Chosen::new(covariance) }
            });
            let unchanged = own.filter(|own| judge.ratio(own) != judge.ratio(&chosen.covariance));
            let unchanged = unchanged.map(|own| {
                let reason =
                    format!("The scan's own covariance was taken as it is: changed for the marginal law, {failure}.");
                Chosen { reason: Some(reason), ..Chosen::new(own) }
            });
            model.into_iter().chain(unchanged).collect()
        }
    };
    for mut other in others {
        other.try_out(draw(&other.covariance)?);
        let candidates = [chosen.candidates.as_slice(), &other.candidates].concat();
        let is_nearer = distance(other.slope_ratio) < distance(chosen.slope_ratio);
        chosen = Chosen { candidates, ..if is_nearer { other } else { chosen } };
    }
    Ok(chosen)
}

/// A warning where the slopes of a drawn map differ from the scan's.
fn slope_warning(chosen: &Chosen, judge: &Judge<'_>, marginal: &Marginal) -> Option<String> {
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
            "the marginal law of the heights (kurtosis {}) distorts the slopes of the normal variables beneath; reject outliers, or \
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
