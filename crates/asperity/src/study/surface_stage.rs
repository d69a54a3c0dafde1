//! From a scan, or a stated model, to statistics and to random surfaces.

use std::collections::BTreeMap;

use asperity_formats::Scan;

use crate::correlation::{
    Autocorrelation, Axis, CorrelationFamily, CorrelationModel, Covariance, CovarianceFits, fit_covariance,
    profile_spectrum,
};
use crate::law::Marginal;
use crate::law::fit::{Family, rank_by_aic};
use crate::map::{Grid, HeightMap};
use crate::stats::{Histogram, Moments};
use crate::study::config::{CovarianceChoice, GeneratorChoice, LevelChoice, SurfaceSection, TranslationChoice};
use crate::study::result::{
    CovarianceCandidate, CovarianceResult, KarhunenLoeveResult, LawResult, SurfaceResult, SurfaceStatistics,
};
use crate::study::{Field, StudyError, Table};
use crate::surface::level::{Level, remove_form};
use crate::surface::{
    GaussianSurface, KarhunenLoeve, ModesRoute, Predistorted, RandomSurface, SpectralField, Translated,
    WeierstrassForm, WeierstrassMandelbrot, areal, filter, fractal,
};

/// Ratio of neighbouring wavenumbers and number of ridges of Weierstrass–Mandelbrot surfaces.
const GAMMA: f64 = 1.5;
const RIDGES: usize = 20;
/// Below this share of captured variance a Karhunen–Loève expansion is warned about.
const WANTED_VARIANCE: f64 = 0.9;

impl From<LevelChoice> for Level {
    fn from(choice: LevelChoice) -> Self {
        match choice {
            LevelChoice::None => Self::None,
            LevelChoice::Mean => Self::Mean,
            LevelChoice::Plane => Self::Plane,
            LevelChoice::Quadratic => Self::Quadratic,
        }
    }
}

/// Statistics of a levelled map.
///
/// # Errors
/// The map is flat.
pub fn statistics(map: &HeightMap, outliers: usize) -> Result<SurfaceStatistics, StudyError> {
    let parameters = areal::parameters(map)?;
    let correlation = Autocorrelation::estimate(map)?;
    let scaling = fractal::scaling(map, None)?;
    let grid = map.grid();
    Ok(SurfaceStatistics {
        nx: grid.nx(),
        ny: grid.ny(),
        dx_m: grid.dx_m(),
        dy_m: grid.dy_m(),
        missing_points: map.missing_points(),
        outliers,
        Sa_m: parameters.sa_m,
        Sq_m: parameters.sq_m,
        Ssk: parameters.ssk,
        Sku: parameters.sku,
        Sp_m: parameters.sp_m,
        Sv_m: parameters.sv_m,
        Sz_m: parameters.sz_m,
        Sdq: parameters.sdq,
        Sdq_7point: parameters.sdq_7point,
        Sdr: parameters.sdr,
        Sal_m: parameters.sal_m,
        Str: parameters.str_ratio,
        Sk_m: parameters.sk_m,
        Spk_m: parameters.spk_m,
        Svk_m: parameters.svk_m,
        Smrk1: parameters.smrk1,
        Smrk2: parameters.smrk2,
        Vmp_m: parameters.vmp_m,
        Vmc_m: parameters.vmc_m,
        Vvc_m: parameters.vvc_m,
        Vvv_m: parameters.vvv_m,
        correlation_length_x_m: correlation.correlation_length_m(Axis::X),
        correlation_length_y_m: correlation.correlation_length_m(Axis::Y),
        hurst: scaling.map(|s| s.hurst),
        fractal_dimension: scaling.map(|s| s.fractal_dimension),
    })
}

/// A law with its parameters by name.
pub(super) fn law_result(law: &Marginal) -> LawResult {
    let parameters: BTreeMap<String, f64> =
        law.parameters().into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    LawResult { name: law.name().into(), parameters }
}

/// Random surfaces of one covariance and one marginal law.
#[derive(Debug, Clone)]
pub(super) struct SurfaceModel {
    covariance: Covariance,
    /// Marginal law of the heights in metre, of mean zero.
    pub(super) marginal: Marginal,
    generator: GeneratorChoice,
    translation: TranslationChoice,
    modes: usize,
    fractal_dimension: Option<f64>,
}

/// A random surface on a grid, and what is worth knowing about it.
pub(super) struct Generated {
    pub(super) surface: Box<dyn RandomSurface>,
    pub(super) karhunen_loeve: Option<KarhunenLoeveResult>,
    pub(super) warnings: Vec<String>,
}

impl SurfaceModel {
    /// Surfaces for small patches, by the generator of the study.
    pub(super) fn patch(&self, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        match self.generator {
            GeneratorChoice::KarhunenLoeve => match self.translation {
                TranslationChoice::Plain => self.karhunen_loeve(&self.covariance, grid, periodic),
                TranslationChoice::Corrected => {
                    self.karhunen_loeve(&Predistorted::new(self.covariance, &self.marginal)?, grid, periodic)
                }
            },
            GeneratorChoice::Spectral => self.spectral(grid, periodic),
            GeneratorChoice::WeierstrassMandelbrot => self.weierstrass_mandelbrot(grid),
        }
    }

    /// Surfaces for long strips. A truncated expansion cannot hold their variance, so all Fourier modes are used in its
    /// place.
    pub(super) fn strip(&self, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        match self.generator {
            GeneratorChoice::WeierstrassMandelbrot => self.weierstrass_mandelbrot(grid),
            _ => self.spectral(grid, periodic),
        }
    }

    fn karhunen_loeve(
        &self,
        covariance: &dyn crate::correlation::StationaryCovariance,
        grid: Grid,
        periodic: bool,
    ) -> Result<Generated, StudyError> {
        let exact_product = self.covariance.model() == CorrelationModel::SquaredExponential
            && self.translation == TranslationChoice::Plain;
        let route = match (periodic, exact_product) {
            (true, _) => ModesRoute::Periodic,
            (false, true) => ModesRoute::Separable,
            (false, false) => ModesRoute::General,
        };
        let field = KarhunenLoeve::new(covariance, grid, self.modes, route)?;
        let captured_variance = field.captured_variance();
        let mut warnings = Vec::new();
        if captured_variance < WANTED_VARIANCE {
            warnings.push(format!(
                "{} Karhunen–Loève terms hold {:.0} % of the variance on a patch of {:.3e} m × {:.3e} m: the random \
                 surfaces are smoother than the model; raise `modes` or use the spectral generator",
                self.modes,
                100.0 * captured_variance,
                grid.width_m(),
                grid.height_m()
            ));
        }
        let karhunen_loeve = Some(KarhunenLoeveResult { modes: self.modes, captured_variance });
        Ok(Generated { surface: self.translated(field)?, karhunen_loeve, warnings })
    }

    fn spectral(&self, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        let make = |covariance: &dyn crate::correlation::StationaryCovariance| {
            if periodic { Ok(SpectralField::periodic(covariance, grid)) } else { SpectralField::free(covariance, grid) }
        };
        let field = match self.translation {
            TranslationChoice::Plain => make(&self.covariance)?,
            TranslationChoice::Corrected => make(&Predistorted::new(self.covariance, &self.marginal)?)?,
        };
        let mut warnings = Vec::new();
        if field.clipped_variance() > 1e-3 {
            warnings.push(format!(
                "on a grid of {:.3e} m × {:.3e} m the covariance is not positive definite when wrapped: {:.1} % of the \
                 variance was clipped",
                grid.width_m(),
                grid.height_m(),
                100.0 * field.clipped_variance()
            ));
        }
        Ok(Generated { surface: self.translated(field)?, karhunen_loeve: None, warnings })
    }

    fn translated(&self, field: impl GaussianSurface + 'static) -> Result<Box<dyn RandomSurface>, StudyError> {
        Ok(Box::new(Translated::new(field, self.marginal.clone())?))
    }

    fn weierstrass_mandelbrot(&self, grid: Grid) -> Result<Generated, StudyError> {
        let dimension = self.fractal_dimension.unwrap_or(f64::NAN);
        // The fractal roughness is set by the rms height, so any positive value will do here.
        let form = WeierstrassForm::Truncated;
        let surface = WeierstrassMandelbrot::new(grid, dimension, GAMMA, RIDGES, 1e-9, form)?
            .with_rms_height(self.marginal.std())?;
        Ok(Generated { surface: Box::new(surface), karhunen_loeve: None, warnings: Vec::new() })
    }
}

/// What the surface stage hands on.
pub(super) struct SurfaceStage {
    pub(super) model: SurfaceModel,
    pub(super) result: SurfaceResult,
    pub(super) tables: Vec<(&'static str, Table)>,
    pub(super) fields: Vec<(&'static str, Field)>,
    pub(super) assumptions: Vec<String>,
    pub(super) warnings: Vec<String>,
}

/// Levels a scan; rejects outliers; levels what is left, so that outliers do not tilt the form.
fn cleaned(section: &SurfaceSection, raw: &HeightMap) -> Result<(HeightMap, usize), StudyError> {
    let level = Level::from(section.level);
    let levelled = remove_form(raw, level)?.map;
    match section.outliers {
        None => Ok((levelled, 0)),
        Some(limit) => {
            let filtered = filter::reject_outliers(&levelled, limit)?;
            Ok((remove_form(&filtered.map, level)?.map, filtered.rejected))
        }
    }
}

/// Runs the stage; `scan` is the file of the study, already read.
pub(super) fn run(section: &SurfaceSection, scan: Option<(&str, Scan)>) -> Result<SurfaceStage, StudyError> {
    let (mut warnings, mut assumptions) = (Vec::new(), Vec::new());
    let (mut tables, mut fields) = (Vec::new(), Vec::new());
    let mut measured = None;
    if let Some((file, mut scan)) = scan {
        warnings.append(&mut scan.warnings);
        if let Some([x, y]) = section.pixel_size {
            if scan.pitch_m.is_some_and(|pitch| pitch != (x.0, y.0)) {
                warnings.push(format!("the pixel size of {file} is overridden by the study's"));
            }
            scan.pitch_m = Some((x.0, y.0));
        }
        let raw = HeightMap::try_from(scan).map_err(|error| StudyError::Map { file: file.into(), error })?;
        let (map, outliers) = cleaned(section, &raw)?;
        fields.push(("height_raw", Field { grid: raw.grid(), unit: "m", values: raw.heights_m().clone() }));
        fields.push(("height_levelled", Field { grid: map.grid(), unit: "m", values: map.heights_m().clone() }));
        assumptions.push(format!(
            "The scan {file} was levelled by its {} ({}); statistics hold for pixels of {:.3e} m × {:.3e} m on a field of \
             {:.3e} m × {:.3e} m, without further filters. {} of {} points are missing and stay missing.",
            Level::from(section.level),
            section.outliers.map_or_else(
                || "no outliers rejected".into(),
                |k| format!("{outliers} heights beyond {k} robust standard deviations rejected")
            ),
            map.grid().dx_m(),
            map.grid().dy_m(),
            map.grid().width_m(),
            map.grid().height_m(),
            map.missing_points(),
            map.grid().points()
        ));
        measured = Some(Measured::of(map, outliers)?);
    }
    let fits = measured.as_ref().map(|m| fit_covariance(&m.correlation, &CorrelationFamily::ALL));
    let (covariance, misfit) = covariance_of(section, measured.as_ref(), fits.as_ref())?;
    let marginal = marginal_of(section, measured.as_ref(), covariance.std_m())?;
    let fits = fits.and_then(Result::ok);
    warnings.extend(fits.iter().flat_map(|fits| &fits.warnings).map(|warning| format!("covariance fit: {warning}")));
    if let Some(measured) = &measured {
        tables.extend(measured.tables(&covariance, &marginal)?);
    }
    assumptions.push(model_sentence(section, &covariance, &marginal));
    let result = SurfaceResult {
        statistics: measured.as_ref().map(|m| m.statistics.clone()),
        covariance: covariance_result(&covariance, misfit, fits.as_ref()),
        marginal: law_result(&marginal),
        karhunen_loeve: None,
    };
    let fractal_dimension =
        section.fractal_dimension.or(measured.as_ref().and_then(|m| m.statistics.fractal_dimension));
    let model = SurfaceModel {
        covariance,
        marginal,
        generator: section.generator,
        translation: section.translation,
        modes: section.modes,
        fractal_dimension,
    };
    if section.generator == GeneratorChoice::WeierstrassMandelbrot && fractal_dimension.is_none() {
        warnings.push(
            "the scan shows no scaling range, so its fractal dimension is undefined: state `fractal_dimension`".into(),
        );
    }
    Ok(SurfaceStage { model, result, tables, fields, assumptions, warnings })
}

fn model_sentence(section: &SurfaceSection, covariance: &Covariance, marginal: &Marginal) -> String {
    let origin = if section.covariance == CovarianceChoice::Measured { "fitted to the scan" } else { "stated" };
    let law = if section.marginal == "measured" { "measured heights" } else { marginal.name() };
    format!(
        "Random surfaces have a {} covariance ({origin}) of rms height {:.3e} m and lengths {:.3e} m along x and {:.3e} m \
         along y, and the marginal law of the {law}, imposed by {} translation.",
        covariance.model().name(),
        covariance.std_m(),
        covariance.length_x_m(),
        covariance.length_y_m(),
        match section.translation {
            TranslationChoice::Plain => "plain",
            TranslationChoice::Corrected => "corrected",
        }
    )
}

fn covariance_of(
    section: &SurfaceSection,
    measured: Option<&Measured>,
    fits: Option<&Result<CovarianceFits, crate::correlation::FitError>>,
) -> Result<(Covariance, Option<f64>), StudyError> {
    let model = match section.covariance {
        CovarianceChoice::Measured => {
            let fits = match fits {
                Some(Ok(fits)) => fits,
                Some(Err(error)) => return Err(error.clone().into()),
                None => return Err(StudyError::NoStage("surface")),
            };
            let best = fits.best();
            // The fit's own variance is extrapolated beyond the scan's field; the scan's Sq is what was measured.
            let sq_m = measured.map_or(best.std_m(), |m| m.statistics.Sq_m);
            let std_m = section.rms_height.map_or(sq_m, |rms| rms.0);
            let covariance = Covariance::new(best.model(), std_m, best.length_x_m(), best.length_y_m())?;
            return Ok((covariance, Some(fits.fits[0].misfit)));
        }
        CovarianceChoice::SquaredExponential => CorrelationModel::SquaredExponential,
        CovarianceChoice::Exponential => CorrelationModel::Exponential,
        CovarianceChoice::Matern => CorrelationModel::Matern { nu: section.smoothness.unwrap_or(f64::NAN) },
        CovarianceChoice::SelfAffine => CorrelationModel::SelfAffine { hurst: section.hurst.unwrap_or(f64::NAN) },
    };
    let sq_m = measured.map(|m| m.statistics.Sq_m);
    let std_m = section.rms_height.map(|rms| rms.0).or(sq_m).unwrap_or(f64::NAN);
    let [x, y] = section.correlation_length.map_or([f64::NAN; 2], |lengths| lengths.map(|length| length.0));
    Ok((Covariance::new(model, std_m, x, y)?, None))
}

/// The marginal law of mean zero and of the covariance's standard deviation.
fn marginal_of(section: &SurfaceSection, measured: Option<&Measured>, std_m: f64) -> Result<Marginal, StudyError> {
    let law = match (section.marginal.as_str(), measured) {
        ("measured", Some(measured)) => Marginal::empirical(measured.map.present_m().collect())?,
        (text, _) => text.parse()?,
    };
    Ok(law.standardised(0.0, std_m)?)
}

fn covariance_result(covariance: &Covariance, misfit: Option<f64>, fits: Option<&CovarianceFits>) -> CovarianceResult {
    let (smoothness, hurst) = match covariance.model() {
        CorrelationModel::Matern { nu } => (Some(nu), None),
        CorrelationModel::SelfAffine { hurst } => (None, Some(hurst)),
        _ => (None, None),
    };
    CovarianceResult {
        model: covariance.model().name().into(),
        std_m: covariance.std_m(),
        length_x_m: covariance.length_x_m(),
        length_y_m: covariance.length_y_m(),
        smoothness,
        hurst,
        misfit,
        candidates: fits.map_or_else(Vec::new, |fits| {
            let candidate = |fit: &crate::correlation::CovarianceFit| CovarianceCandidate {
                model: fit.covariance.model().name().into(),
                misfit: fit.misfit,
            };
            fits.fits.iter().map(candidate).collect()
        }),
    }
}

/// A levelled scan and what was estimated from it.
struct Measured {
    map: HeightMap,
    statistics: SurfaceStatistics,
    correlation: Autocorrelation,
}

impl Measured {
    fn of(map: HeightMap, outliers: usize) -> Result<Self, StudyError> {
        let statistics = statistics(&map, outliers)?;
        let correlation = Autocorrelation::estimate(&map)?;
        Ok(Self { map, statistics, correlation })
    }

    fn tables(&self, covariance: &Covariance, marginal: &Marginal) -> Result<Vec<(&'static str, Table)>, StudyError> {
        Ok(vec![
            ("height_pdf", self.pdf_table(marginal)?),
            ("height_acf", self.acf_table(covariance)),
            ("height_psd", self.psd_table(covariance)),
        ])
    }

    fn pdf_table(&self, marginal: &Marginal) -> Result<Table, StudyError> {
        let heights: Vec<f64> = self.map.present_m().collect();
        let histogram = Histogram::of(&heights)?;
        let moments = Moments::of(&heights);
        let normal = Marginal::normal(moments.mean, moments.std)?;
        // The law drawn beside the histogram: the stated one, or the best fit to a thinned sample of the measured.
        let fitted = if let Marginal::Empirical { sorted } = marginal {
            let stride = (sorted.len() / 4096).max(1);
            let thinned: Vec<f64> = sorted.iter().copied().skip(stride / 2).step_by(stride).collect();
            rank_by_aic(&Family::ANYWHERE, &thinned, None).fits.into_iter().next().map(|fit| fit.law)
        } else {
            Some(marginal.clone())
        };
        let centres = histogram.centres();
        let fitted = |z: &f64| fitted.as_ref().map_or(f64::NAN, |law| law.pdf(*z));
        Ok(Table::new([
            ("fitted_density_per_m", centres.iter().map(fitted).collect()),
            ("normal_density_per_m", centres.iter().map(|z| normal.pdf(*z)).collect()),
            ("density_per_m", histogram.density()),
            ("height_m", centres),
        ]))
    }

    fn acf_table(&self, covariance: &Covariance) -> Table {
        let grid = self.map.grid();
        let (along_x, along_y) = (self.correlation.along(Axis::X), self.correlation.along(Axis::Y));
        // Lags beyond half the field rest on few pairs.
        let step_m = grid.dx_m().min(grid.dy_m());
        let largest_m = 0.5 * grid.width_m().max(grid.height_m());
        let lags: Vec<f64> = (0..=(largest_m / step_m) as usize).map(|k| k as f64 * step_m).collect();
        let at = |acf: &[f64], pitch_m: f64, side_m: f64, lag_m: f64| {
            let position = lag_m / pitch_m;
            let left = position.floor() as usize;
            if lag_m > 0.5 * side_m || left + 1 >= acf.len() {
                return f64::NAN;
            }
            acf[left] + (position - left as f64) * (acf[left + 1] - acf[left])
        };
        Table::new([
            ("acf_x", lags.iter().map(|lag| at(&along_x, grid.dx_m(), grid.width_m(), *lag)).collect()),
            ("acf_y", lags.iter().map(|lag| at(&along_y, grid.dy_m(), grid.height_m(), *lag)).collect()),
            ("fit_x", lags.iter().map(|lag| covariance.correlation(*lag, 0.0)).collect()),
            ("fit_y", lags.iter().map(|lag| covariance.correlation(0.0, *lag)).collect()),
            ("lag_m", lags),
        ])
    }

    /// Profile spectra along x and y on the wavenumbers of the finer one; an axis without a complete profile is empty.
    fn psd_table(&self, covariance: &Covariance) -> Table {
        let spectrum = |axis| profile_spectrum(&self.map, axis).ok();
        let (x, y) = (spectrum(Axis::X), spectrum(Axis::Y));
        let mut wavenumbers: Vec<f64> =
            [&x, &y].into_iter().flatten().flat_map(|s| s.q_rad_per_m.iter().copied().filter(|q| *q > 0.0)).collect();
        wavenumbers.sort_by(f64::total_cmp);
        wavenumbers.dedup();
        let on = |spectrum: &Option<crate::correlation::ProfileSpectrum>| -> Vec<f64> {
            let own = spectrum.as_ref().map_or(&[][..], |s| &s.q_rad_per_m);
            let value = |q: &f64| own.iter().position(|own| own == q);
            wavenumbers
                .iter()
                .map(|q| match (value(q), spectrum) {
                    (Some(index), Some(s)) => s.psd_m3[index],
                    _ => f64::NAN,
                })
                .collect()
        };
        Table::new([
            ("psd_x_m3", on(&x)),
            ("psd_y_m3", on(&y)),
            ("psd_model_x_m3", wavenumbers.iter().map(|q| covariance.profile_psd_x_m3(*q)).collect()),
            ("wavenumber_rad_per_m", wavenumbers),
        ])
    }
}
