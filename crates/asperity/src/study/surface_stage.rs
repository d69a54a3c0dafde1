//! From a scan, or a stated model, to statistics and to random surfaces.

use asperity_formats::Scan;

use crate::correlation::{CorrelationFamily, CorrelationModel, MeasuredReport, StationaryCovariance};
use crate::distribution::Marginal;
use crate::map::HeightMap;
use crate::study::contact_check::contact_warning;
use crate::study::covariance_choice::{Chosen, choose, stated};
use crate::study::file::SurfaceSection;
use crate::study::measured::Measured;
use crate::study::output::StageOutput;
use crate::study::pooled::Part;
use crate::study::result::{
    CovarianceCandidate, CovarianceResult, EmpiricalCovariance, KarhunenLoeveResult, MeasuredSurface, SurfaceResult,
    law_result,
};
use crate::study::surface_model::{
    Expansion, GAMMA, RIDGES, SurfaceCovariance, SurfaceModel, Texture, decay_length_m, decay_lengths_m,
};
use crate::study::{Field, StudyError, sentence};
use crate::surface::level::Level;
use crate::surface::preparation::{Preparation, Prepared};
use crate::surface::{CovarianceSource, SurfaceGenerator};
use crate::translation::TranslationKind;

/// Random surfaces, and the measurement that they rest on.
pub(super) struct SurfaceStage {
    pub(super) model: SurfaceModel,
    pub(super) measured: Option<Measured>,
    covariance: Option<CovarianceResult>,
    pub(super) output: StageOutput,
}

impl SurfaceStage {
    /// Returns the entry of `results.json`; `karhunen_loeve` is the expansion on the patches of the pressure stage.
    pub(super) fn result(&self, karhunen_loeve: Option<KarhunenLoeveResult>) -> SurfaceResult {
        let measured = match &self.measured {
            None => MeasuredSurface::Stated {},
            Some(Measured { part: Some(part), .. }) => MeasuredSurface::Part(Box::new(part.statistics.results())),
            Some(scan) => MeasuredSurface::Scan(Box::new(scan.statistics.results.clone())),
        };
        let (covariance, marginal) = (self.covariance.clone(), law_result(&self.model.marginal));
        SurfaceResult { measured, covariance, marginal, karhunen_loeve }
    }
}

/// Runs the stage; `scans` are the files of the study, already read, with their names.
pub(super) fn run(section: &SurfaceSection, scans: Vec<(String, Scan)>) -> Result<SurfaceStage, StudyError> {
    let mut output = StageOutput::default();
    let measured = measure_all(section, scans, &mut output)?;
    let (model, chosen) = model_of(section, measured.as_ref(), CorrelationFamily::ALL, &mut output)?;
    let covariance = chosen.as_ref().map(covariance_result);
    if let Some(measured) = &measured {
        output.tables.extend(measured.tables(model.covariance(), &model.marginal)?);
        let is_like_the_scan =
            section.covariance.is_of_the_scan() && section.marginal == "measured" && section.rms_height.is_none();
        if let Some(trial) = chosen.and_then(|chosen| chosen.trial).filter(|_| is_like_the_scan) {
            output.warnings.extend(contact_warning(&measured.map, &trial.maps));
        }
    }
    Ok(SurfaceStage { model, measured, covariance, output })
}

/// The random surfaces of a section and, where they are made from a covariance, how it was chosen; a measured covariance is the best
/// fit of `families`.
pub(super) fn model_of(
    section: &SurfaceSection,
    measured: Option<&Measured>,
    families: &[CorrelationFamily],
    output: &mut StageOutput,
) -> Result<(SurfaceModel, Option<Chosen>), StudyError> {
    let (model, chosen) = if section.generator == SurfaceGenerator::WeierstrassMandelbrot {
        (fractal_model(section, measured)?, None)
    } else {
        let (model, chosen) = translated_model(section, measured, families)?;
        (model, Some(chosen))
    };
    let part = measured.and_then(|m| m.part.as_ref());
    output.assumptions.push(model_sentence(section, &model, if part.is_some() { "the scans" } else { "the scan" }));
    if let Some(chosen) = &chosen {
        output.assumptions.extend(chosen.reason.clone());
        output.warnings.extend(chosen.warnings.iter().cloned());
    }
    Ok((model, chosen))
}

/// The first scan with what all say together; maps and series show the first.
fn measure_all(
    section: &SurfaceSection,
    scans: Vec<(String, Scan)>,
    output: &mut StageOutput,
) -> Result<Option<Measured>, StudyError> {
    if scans.len() < 2 {
        let one = scans.into_iter().next();
        return one.map(|(file, scan)| measure(section, &file, scan, output)).transpose();
    }
    let mut measured = Vec::with_capacity(scans.len());
    for (file, scan) in scans {
        let mut own = StageOutput::default();
        let of_file = |error: StudyError| match error {
            error @ StudyError::Map { .. } => error,
            error => StudyError::OneOf { file: file.clone(), error: Box::new(error) },
        };
        let scan = measure(section, &file, scan, &mut own).map_err(of_file)?;
        if measured.is_empty() {
            output.fields = own.fields;
        }
        output.assumptions.append(&mut own.assumptions);
        output.warnings.extend(own.warnings.into_iter().map(|warning| format!("{file}: {warning}")));
        measured.push((file, scan));
    }
    output.assumptions.push(format!(
        "The {} scans are taken as samples of one part: statistics are weighted means over the scans, the correlation is \
         that of all pairs of heights within a scan, the marginal law that of all heights. Maps and figures of the \
         measured heights show {}.",
        measured.len(),
        measured[0].0
    ));
    let mut names: Vec<&String> = measured.iter().map(|(file, _)| file).collect();
    names.sort();
    for pair in names.windows(2).filter(|pair| pair[0] == pair[1]) {
        output.warnings.push(format!("{} is listed twice and counts as two places: intervals are too narrow", pair[0]));
    }
    let part = Part::of(&measured)?;
    let first = measured.into_iter().next();
    Ok(first.map(|(_, first)| Measured { part: Some(part), ..first }))
}

/// Levels the scan and takes its statistics.
pub(super) fn measure(
    section: &SurfaceSection,
    file: &str,
    mut scan: Scan,
    output: &mut StageOutput,
) -> Result<Measured, StudyError> {
    output.warnings.append(&mut scan.warnings);
    let raw = HeightMap::try_from(scan).map_err(|error| StudyError::Map { file: file.into(), error })?;
    let preparation = section.preparation();
    let prepared = preparation.apply(&raw)?;
    let map = &prepared.map;
    output.fields.push(("height_raw", Field { grid: raw.grid(), unit: "m", values: raw.heights_m().clone() }));
    output.fields.push(("height_levelled", Field { grid: map.grid(), unit: "m", values: map.heights_m().clone() }));
    let grid = map.grid();
    output.assumptions.push(format!(
        "The scan {file} {}. Its statistics hold for pixels of {} on a field of {}. {} of {} points are missing and stay \
         missing.",
        in_words(&preparation, &prepared),
        sentence::size(grid.dx_m(), grid.dy_m()),
        sentence::size(grid.width_m(), grid.height_m()),
        map.missing_points(),
        grid.points()
    ));
    if prepared.lost > 0 {
        let lost = sentence::count(prepared.lost, "height", "heights");
        output.warnings.push(format!("the robust filter found no surface around {lost}, which count as missing"));
    }
    Measured::of(prepared)
}

/// What was done to a scan, as the end of a sentence.
fn in_words(preparation: &Preparation, prepared: &Prepared) -> String {
    let form = match preparation.level {
        Level::None => "was not levelled".to_owned(),
        Level::Mean => "was counted from its mean".to_owned(),
        Level::Polynomial(degree) => format!("was levelled by its least-squares polynomial of degree {degree}"),
        Level::Cylinder | Level::Sphere => format!(
            "was levelled by its least-squares {} of radius {}",
            preparation.level,
            sentence::si(prepared.radius_m.unwrap_or(f64::NAN), "m")
        ),
        Level::Plane | Level::Quadratic => format!("was levelled by its least-squares {}", preparation.level),
    };
    let outliers = preparation.outliers.map_or_else(
        || "no outliers were looked for".to_owned(),
        |k| {
            let rejected = sentence::count(prepared.outliers, "height", "heights");
            format!("{rejected} beyond {k} robust standard deviations rejected")
        },
    );
    let filter = |name: &str, cutoff_m: Option<f64>| {
        cutoff_m.map_or_else(|| format!("no {name}-filter"), |m| format!("{name}-filter at {}", sentence::si(m, "m")))
    };
    let kind = if preparation.robust { " (robust)" } else { "" };
    let (short, long) = (filter("S", preparation.s_filter_m), filter("L", preparation.l_filter_m));
    format!("{form} ({outliers}; {short}; {long}{kind})")
}

/// A translated Gaussian field, and how its covariance was chosen.
fn translated_model(
    section: &SurfaceSection,
    measured: Option<&Measured>,
    families: &[CorrelationFamily],
) -> Result<(SurfaceModel, Chosen), StudyError> {
    let std_m = rms_height_m(section, measured)?;
    let marginal = marginal_of(section, measured, std_m)?;
    let chosen = match measured {
        Some(measured) => choose(section, measured, families, &marginal)?,
        None => Chosen::new(stated(section, std_m)?),
    };
    let expansion = match section.generator {
        SurfaceGenerator::KarhunenLoeve => {
            let &SurfaceSection { modes, mean_mode, rescale, .. } = section;
            Some(Expansion { modes, mean_mode, rescale })
        }
        SurfaceGenerator::Spectral | SurfaceGenerator::WeierstrassMandelbrot => None,
    };
    let covariance = chosen.covariance.clone();
    let texture = Texture::Translated { covariance, translation: section.translation, expansion };
    Ok((SurfaceModel { marginal, texture }, chosen))
}

/// A Weierstrass–Mandelbrot surface. Its heights sum many cosines of random phase, so their law is nearly normal, whatever
/// that of the scan.
fn fractal_model(section: &SurfaceSection, measured: Option<&Measured>) -> Result<SurfaceModel, StudyError> {
    let own = measured.and_then(Measured::fractal_dimension);
    let dimension = section.fractal_dimension.or(own).ok_or(StudyError::FractalDimension)?;
    let std_m = rms_height_m(section, measured)?;
    Ok(SurfaceModel { marginal: Marginal::normal(0.0, std_m)?, texture: Texture::WeierstrassMandelbrot { dimension } })
}

fn model_sentence(section: &SurfaceSection, model: &SurfaceModel, scans: &str) -> String {
    match &model.texture {
        Texture::WeierstrassMandelbrot { dimension } => format!(
            "Random surfaces are Weierstrass–Mandelbrot functions of fractal dimension {} ({}), wavenumber ratio {GAMMA} and \
             {RIDGES} ridges, from the longer side of a grid down to its pixels, scaled to the rms height {}. Their heights \
             are taken as normal; covariance and marginal law of the study play no part.",
            sentence::digits(*dimension),
            if section.fractal_dimension.is_some() { "stated".into() } else { format!("measured on {scans}") },
            sentence::si(model.marginal.std(), "m"),
        ),
        Texture::Translated { covariance, translation, .. } => format!(
            "Random surfaces have {} of rms height {}. {} imposed by {} translation.",
            covariance_words(section, covariance, scans),
            sentence::si(covariance.std_m(), "m"),
            if section.marginal == "measured" {
                "The marginal law of the measured heights is".to_owned()
            } else {
                format!("The marginal law {} is", section.marginal)
            },
            match translation {
                TranslationKind::Plain => "plain",
                TranslationKind::Corrected => "corrected",
            }
        ),
    }
}

/// A covariance in words.
fn covariance_words(section: &SurfaceSection, covariance: &SurfaceCovariance, scans: &str) -> String {
    let along = |x_m, y_m| format!("{} along x and {} along y", sentence::si(x_m, "m"), sentence::si(y_m, "m"));
    match covariance {
        SurfaceCovariance::Model(model) => format!(
            "a {} covariance ({}, {} {})",
            model.model().name(),
            if section.covariance == CovarianceSource::Measured {
                format!("fitted to {scans}")
            } else {
                "stated".into()
            },
            match model.model() {
                CorrelationModel::Matern { .. } => "scales",
                CorrelationModel::SelfAffine { .. } => "roll-off lengths",
                CorrelationModel::Exponential | CorrelationModel::SquaredExponential => "lengths",
            },
            along(model.length_x_m(), model.length_y_m()),
        ),
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

/// The stated rms height, or the scan's Sq.
fn rms_height_m(section: &SurfaceSection, measured: Option<&Measured>) -> Result<f64, StudyError> {
    let sq_m = measured.map(Measured::sq_m);
    section.rms_height.map(|rms| rms.0).or(sq_m).ok_or(StudyError::NoStage("surface"))
}

/// The marginal law of mean zero and of the covariance's standard deviation.
fn marginal_of(section: &SurfaceSection, measured: Option<&Measured>, std_m: f64) -> Result<Marginal, StudyError> {
    let law = match (section.marginal.as_str(), measured) {
        ("measured", Some(measured)) => Marginal::empirical(measured.heights_of_all_m())?,
        (text, _) => text.parse()?,
    };
    Ok(law.standardised(0.0, std_m)?)
}

pub(super) fn covariance_result(chosen: &Chosen) -> CovarianceResult {
    let candidates = chosen.candidates.iter().map(|(model, misfit, slope_ratio)| CovarianceCandidate {
        model: model.clone(),
        misfit: *misfit,
        slope_ratio: *slope_ratio,
    });
    let candidates = candidates.collect();
    let &Chosen { misfit, slope_ratio, slope_cutoff_m, .. } = chosen;
    let model = match &chosen.covariance {
        SurfaceCovariance::Model(model) => model,
        SurfaceCovariance::Empirical(own) => {
            let [length_x_m, length_y_m] = decay_lengths_m(own);
            return CovarianceResult {
                model: "empirical".into(),
                std_m: own.std_m(),
                length_x_m,
                length_y_m,
                decay_length_x_m: length_x_m,
                decay_length_y_m: length_y_m,
                smoothness: None,
                hurst: None,
                misfit,
                slope_ratio,
                slope_cutoff_m,
                candidates,
                empirical: Some(empirical_result(own.report())),
            };
        }
    };
    let (smoothness, hurst) = match model.model() {
        CorrelationModel::Matern { nu } => (Some(nu), None),
        CorrelationModel::SelfAffine { hurst } => (None, Some(hurst)),
        _ => (None, None),
    };
    CovarianceResult {
        model: model.model().name().into(),
        std_m: model.std_m(),
        length_x_m: model.length_x_m(),
        length_y_m: model.length_y_m(),
        decay_length_x_m: decay_length_m(FARTHEST_DECAY * model.length_x_m(), |lag_m| model.correlation(lag_m, 0.0)),
        decay_length_y_m: decay_length_m(FARTHEST_DECAY * model.length_y_m(), |lag_m| model.correlation(0.0, lag_m)),
        smoothness,
        hurst,
        misfit,
        slope_ratio,
        slope_cutoff_m,
        candidates,
        empirical: None,
    }
}

fn empirical_result(report: MeasuredReport) -> EmpiricalCovariance {
    EmpiricalCovariance {
        mean_share: report.mean_fraction,
        standard_error: report.standard_error,
        reliable_x_m: report.reliable_x_m,
        reliable_y_m: report.reliable_y_m,
        decayed_x: report.decayed_x,
        decayed_y: report.decayed_y,
        taper_change: report.taper_change,
        clipped_variance: report.clipped_variance,
        clipping_change: report.clipping_change,
    }
}

/// Every model has fallen to 1/e within so many of its lengths ℓ: the smoothest Matérn model, e^{−r²/2}, at √2 of them, the
/// self-affine one of H = 1 at 1.7.
const FARTHEST_DECAY: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::Covariance;

    #[test]
    fn the_decay_length_of_a_model_is_where_it_is_1_over_e() {
        let found = |model| {
            let covariance = Covariance::new(model, 1e-6, 2e-5, 3e-5).unwrap();
            let result = covariance_result(&Chosen::new(SurfaceCovariance::Model(covariance)));
            assert_eq!((result.length_x_m, result.length_y_m), (2e-5, 3e-5));
            assert!((result.decay_length_y_m / result.decay_length_x_m - 1.5).abs() < 1e-9, "{model:?}");
            result.decay_length_x_m / 2e-5
        };
        let exponential = [
            CorrelationModel::Exponential,
            CorrelationModel::SquaredExponential,
            CorrelationModel::Matern { nu: 0.5 },
            CorrelationModel::SelfAffine { hurst: 0.5 },
        ];
        for model in exponential {
            assert!((found(model) - 1.0).abs() < 1e-9, "{model:?}: {}", found(model));
        }
        // (1 + x) e^{−x} = 1/e at x = 2.146193 (Newton), x = √3 r.
        assert!((found(CorrelationModel::Matern { nu: 1.5 }) - 2.146_193_22 / 3.0_f64.sqrt()).abs() < 1e-8);
        let words = |model| {
            let covariance = SurfaceCovariance::Model(Covariance::new(model, 1e-6, 2e-5, 3e-5).unwrap());
            covariance_words(&SurfaceSection::default(), &covariance, "the scan")
        };
        for (model, said) in [
            (CorrelationModel::Exponential, "lengths 20 µm along x"),
            (CorrelationModel::Matern { nu: 1.5 }, "scales 20 µm along x"),
            (CorrelationModel::SelfAffine { hurst: 0.7 }, "roll-off lengths 20 µm along x"),
        ] {
            assert!(words(model).contains(said), "{}", words(model));
        }
        // Ever smoother Matérn models tend to e^{−r²/2}; x K₁(x), of H = 1, is 1/e at 1.6.
        let smooth = found(CorrelationModel::Matern { nu: 60.0 });
        assert!((smooth - 2.0_f64.sqrt()).abs() < 0.01 && smooth < FARTHEST_DECAY, "{smooth}");
        let rough = found(CorrelationModel::SelfAffine { hurst: 0.05 });
        let persistent = found(CorrelationModel::SelfAffine { hurst: 0.999 });
        assert!(0.0 < rough && rough < 0.2 && 1.5 < persistent && persistent < 1.8, "{rough} {persistent}");
    }
}
