//! Twins: random maps with the statistics of a measured one, and their comparison with it.
//!
//! [`Twins::new`] measures a scan and fits the model, [`Twins::draw`] draws a twin, and [`Twins::compare`] draws many
//! and compares every statistic of the scan with those of its twins. A twin is measured like the scan: the scan's
//! missing points are masked out and the form is removed, so that the biases of estimators on a finite map cancel.

mod band;
mod comparison;
mod curve;
mod options;
#[cfg(test)]
mod tests;

use asperity_base::blocks;
use asperity_formats::Scan;
use thiserror::Error;

use crate::distribution::Marginal;
use crate::map::BoundaryKind;
use crate::map::{Grid, HeightMap};
use crate::monitor::{Cancelled, Monitor, Silent};
use crate::random;
use crate::study::file::SurfaceSection;
use crate::study::output::StageOutput;
use crate::study::result::{BandMethod, Comparison, TwinModel, distribution_result};
use crate::study::surface_model::model_of;
use crate::study::surface_result::covariance_result;
use crate::study::surface_scans::{filled, measure};
use crate::study::{StudyError, Table, sentence};
use crate::surface::RandomSurface;
use crate::surface::level::Level;
use crate::surface::model::{SurfaceCovariance, SurfaceModelError, Texture};
use crate::surface::preparation::{Preparation, Prepared};
use crate::surface::{CovarianceSource, SurfaceGenerator};

use band::{LEVEL, band_method};
use comparison::{Target, TwinTraits, masked, outside_sentence, statistics_table};

pub use options::TwinOptions;

/// Stream names of the random numbers: of the twins, of the maps that estimate the variance of the form, and of missing heights.
const STAGE: &str = "twin";
const TRIAL_STAGE: &str = "twin trial";
const FILL_STAGE: &str = "twin fill";
/// Number of maps that estimate the fraction of variance in the form.
const TRIALS: usize = 8;
/// Fraction of variance in the form above which the height of the long waves is reported as uncertain.
const LARGE_FORM_FRACTION: f64 = 0.25;
/// Kurtosis above which a scan is suspected of spikes. Lognormal heights with σ = 0.9 have a kurtosis of 20.
const SPIKE_KURTOSIS: f64 = 20.0;

/// Functions with their bands, and the statistics of every twin, by the name of the table.
pub type TwinTables = Vec<(&'static str, Table)>;

/// Error of comparing twins; `E` is the error of the caller that stores them.
#[derive(Debug, Error)]
pub enum TwinError<E> {
    /// A twin has no statistics, or the comparison was cancelled.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A twin could not be stored.
    #[error("{0}")]
    Keep(E),
}

/// Generator of the twins of a scan.
///
/// Twins are complete maps about the height zero. They may contain a form; none is removed. Unless the options state
/// their rms height, it gives the scan's Sq *after* the form is removed.
pub struct Twins {
    file: String,
    seed: u64,
    level: Level,
    scan: HeightMap,
    target: Target,
    surface: Box<dyn RandomSurface>,
    /// Factor on the heights of `surface`.
    gain: f64,
    model: TwinModel,
    limits: Vec<String>,
    assumptions: Vec<String>,
    warnings: Vec<String>,
}

impl Twins {
    /// Measures a scan and builds the generator of its twins; `file` names the scan.
    ///
    /// # Errors
    /// The scan has no texture or no covariance that can be fitted, or the model or the grid is invalid.
    pub fn new(scan: Scan, file: &str, options: &TwinOptions) -> Result<Self, StudyError> {
        let mut section = SurfaceSection { file: Some(file.into()), ..options.surface.clone() };
        let mut output = StageOutput::default();
        // Warnings of the file come first.
        let measured = measure(&section.preparation(), file, scan, &mut output)?;
        output.warnings.extend(section.keys_without_effect("surface"));
        let request = section.request(&options.families)?;
        let model = model_of(&request, section.stated_marginal(), Some(&measured), None, &mut output);
        let (mut model, mut chosen) = match model {
            Err(StudyError::Surface(SurfaceModelError::Empirical(error))) if options.allow_model => {
                output.warnings.push(format!("the twins have the covariance model that fits the scan best: {error}"));
                section.covariance = CovarianceSource::Measured;
                let request = section.request(&options.families)?;
                model_of(&request, section.stated_marginal(), Some(&measured), None, &mut output)?
            }
            model => model?,
        };
        let section = &section;
        let (own, grid) = (measured.map.grid(), options.grid(measured.map.grid())?);
        let periodic = options.boundary == BoundaryKind::Periodic;
        let mut is_sharp = false;
        if let Texture::Translated { covariance: SurfaceCovariance::Empirical(covariance), .. } = &mut model.texture {
            // The scan's own correlation contains all its waves, down to the pixel.
            model.shortest_wave_m = None;
            // Heights that cannot be filled leave the tapered correlation.
            if grid == own
                && !periodic
                && let Ok(complete) = filled(&measured.map, options.seed, FILL_STAGE, &Silent)
            {
                **covariance = covariance.deconvolved(&complete);
                is_sharp = true;
            }
            if let Some(chosen) = &mut chosen {
                chosen.covariance = SurfaceCovariance::Empirical(covariance.clone());
            }
        }
        let mut generated = model.patch(grid, periodic)?;
        output.warnings.append(&mut generated.warnings);
        output.assumptions.extend(generated.correction.take());

        let mut twins = Self {
            file: file.to_owned(),
            seed: options.seed,
            level: section.level.as_polynomial(),
            target: Target::new(&measured),
            scan: measured.map,
            surface: generated.surface,
            gain: 1.0,
            model: TwinModel {
                generator: section.generator.to_string(),
                boundary: options.boundary.to_string(),
                translation: chosen.is_some().then(|| section.translation.to_string()),
                rms_height_m: model.marginal.std(),
                form_share: None,
                covariance: chosen.as_ref().map(covariance_result),
                marginal: distribution_result(&model.marginal),
            },
            limits: limits(section, is_sharp),
            assumptions: output.assumptions,
            warnings: output.warnings,
        };
        if section.rms_height.is_none() {
            let fraction = if grid == own {
                twins.form_fraction(&*twins.surface)?
            } else {
                twins.form_fraction(&*model.patch(own, periodic)?.surface)?
            };
            twins.compensate_form(fraction, &model.marginal)?;
        }
        twins.add_sentences(section, grid);
        Ok(twins)
    }

    /// Returns the fraction of the variance that is removed with the form from maps on the scan's grid.
    fn form_fraction(&self, surface: &dyn RandomSurface) -> Result<f64, StudyError> {
        let square = |map: &HeightMap| map.present_m().map(|z| z * z).sum::<f64>();
        let squares: Result<Vec<(f64, f64)>, StudyError> = blocks::map(0..TRIALS, |index| {
            let mut stream = random::stream(self.seed, TRIAL_STAGE, index as u64);
            let trial = masked(&surface.generate(&random::standard_normal(&mut stream, surface.xi_len())), &self.scan)?;
            let whole = square(&trial);
            let left = self.without_form(trial)?.map;
            // Statistics are relative to the mean, whether or not the form includes it.
            let points = left.present_m().count() as f64;
            let mean = left.present_m().sum::<f64>() / points;
            Ok((whole, square(&left) - points * mean * mean))
        });
        let (before, after) = squares?.into_iter().fold((0.0, 0.0), |sum, (b, a)| (sum.0 + b, sum.1 + a));
        Ok((1.0 - after / before).clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// Scales the twins so that their variance without the form equals the scan's.
    fn compensate_form(&mut self, fraction: f64, law: &Marginal) -> Result<(), StudyError> {
        self.gain = 1.0 / (1.0 - fraction).sqrt();
        let model = &mut self.model;
        model.rms_height_m *= self.gain;
        model.form_share = Some(fraction);
        model.marginal = distribution_result(&law.standardised(0.0, model.rms_height_m)?);
        if let Some(covariance) = &mut model.covariance {
            covariance.std_m = model.rms_height_m;
        }
        self.assumptions.push(format!(
            "The removal of the form removes {} % of the variance of such a surface ({TRIALS} trial maps), so \
             twins were drawn with the rms height {}: without their form they have that of the scan.",
            sentence::digits(100.0 * fraction),
            sentence::si(self.model.rms_height_m, "m")
        ));
        if fraction > LARGE_FORM_FRACTION {
            self.warnings.push(format!(
                "{} % of the variance of such a surface goes with the form of a map of this size: how high its long waves \
                 are is a guess, which the scan cannot confirm; a form of higher degree or an L-filter leaves what it shows",
                sentence::digits(100.0 * fraction)
            ));
        }
        Ok(())
    }

    /// Adds assumptions about the measurement of twins, and warnings about their limits.
    fn add_sentences(&mut self, section: &SurfaceSection, grid: Grid) {
        if section.s_filter.is_some() || section.l_filter.is_some() {
            self.assumptions.push(
                "Twins are like the filtered scan. They were not filtered again: a wave that the filter halves would be \
                 quartered."
                    .into(),
            );
        }
        let kurtosis = self.target.statistics.Sku.filter(|kurtosis| *kurtosis > SPIKE_KURTOSIS);
        if let Some(kurtosis) = kurtosis.filter(|_| section.outliers.is_none()) {
            self.warnings.push(format!(
                "the kurtosis of the scan is {}: single spikes or pits, which twins do not have; reject them as outliers",
                sentence::digits(kurtosis)
            ));
        }
        if self.level != section.level {
            self.assumptions.push(format!(
                "Twins have no {}; a quadratic polynomial, which follows one, was removed from them.",
                section.level
            ));
        }
        if grid == self.scan.grid() {
            let missing = self.scan.missing_points();
            if missing > 0 {
                let points = sentence::count(missing, "missing point", "missing points");
                self.assumptions.push(format!(
                    "Twins are complete; the {points} of the scan {} masked out of them before they were compared.",
                    if missing == 1 { "was" } else { "were" }
                ));
            }
        } else {
            self.warnings.push(format!(
                "twins have {} × {} points on {}, the scan {} × {} on {}: parameters that depend on the pixel or the field, \
                 such as Sdq and Sz, belong to different bandwidths",
                grid.nx(),
                grid.ny(),
                sentence::size(grid.width_m(), grid.height_m()),
                self.scan.grid().nx(),
                self.scan.grid().ny(),
                sentence::size(self.scan.grid().width_m(), self.scan.grid().height_m()),
            ));
        }
        if section.stated_marginal().is_none() && section.generator != SurfaceGenerator::WeierstrassMandelbrot {
            self.assumptions.push(
                "The measured marginal distribution ends at the extremes of the scan and contains a sharp peak or pit as a few \
                 heights only: Sp, Sv and Sz of the twins tend to be smaller."
                    .into(),
            );
        }
    }

    /// Returns the scan after preparation.
    pub fn scan(&self) -> &HeightMap {
        &self.scan
    }

    /// Returns the grid of the twins.
    pub fn grid(&self) -> Grid {
        self.surface.grid()
    }

    /// Returns the warnings that are known before any twin is drawn.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Draws twin number `index`, counted from 0. The twin depends on the seed and the number alone.
    pub fn draw(&self, index: u64) -> HeightMap {
        let mut stream = random::stream(self.seed, STAGE, index);
        let twin = self.surface.generate(&random::standard_normal(&mut stream, self.surface.xi_len()));
        twin.scaled(self.gain)
    }

    /// Prepares a twin like the scan: masks its missing points and removes the form.
    fn prepared_twin(&self, twin: &HeightMap) -> Result<Prepared, StudyError> {
        let twin = if self.grid() == self.scan.grid() { masked(twin, &self.scan)? } else { twin.clone() };
        self.without_form(twin)
    }

    /// Removes the form from a map.
    fn without_form(&self, map: HeightMap) -> Result<Prepared, StudyError> {
        let preparation = Preparation { level: self.level, ..Preparation::default() };
        Ok(preparation.apply(map).map_err(SurfaceModelError::from)?)
    }

    /// Draws twins 0 … `count` − 1, passes each to `keep`, and compares the scan with them.
    ///
    /// Memory holds as many twins at once as there are threads. `keep` runs on any of the threads, in any order.
    ///
    /// # Errors
    /// Cancelled, or `keep` failed.
    pub fn compare<E: Send>(
        &self,
        count: usize,
        monitor: &dyn Monitor,
        keep: impl Fn(usize, &HeightMap) -> Result<(), E> + Sync,
    ) -> Result<(Comparison, TwinTables), TwinError<E>> {
        let at_once = rayon::current_num_threads().max(1);
        let mut traits = Vec::with_capacity(count);
        for first in (0..count).step_by(at_once) {
            let read: Result<Vec<TwinTraits>, TwinError<E>> = blocks::map(first..count.min(first + at_once), |index| {
                if monitor.cancelled() {
                    return Err(StudyError::from(Cancelled).into());
                }
                let twin = self.draw(index as u64);
                keep(index, &twin).map_err(TwinError::Keep)?;
                Ok(self.target.measure_twin(self.prepared_twin(&twin)?)?)
            });
            traits.extend(read?);
            monitor.progress("twins", traits.len(), count);
        }
        Ok(self.comparison(&traits))
    }

    fn comparison(&self, traits: &[TwinTraits]) -> (Comparison, TwinTables) {
        let twins = self.target.compare_statistics(traits);
        let mut tables = vec![("statistics", statistics_table(traits))];
        let mut curves = Vec::new();
        let mut warnings = self.warnings.clone();
        for (name, comparison, table, sentence) in self.target.compare_curves(traits) {
            curves.push((name.to_owned(), comparison));
            tables.push((name, table));
            warnings.extend(sentence);
        }
        if band_method(traits.len()) == BandMethod::None {
            warnings
                .push("one twin does not spread: draw at least two for bands, 39 for bands of any distribution".into());
        }
        warnings.extend(outside_sentence(&twins));
        let grid = self.grid();
        let comparison = Comparison {
            file: self.file.clone(),
            count: traits.len(),
            seed: self.seed,
            points: [grid.nx(), grid.ny()],
            pitch_m: [grid.dx_m(), grid.dy_m()],
            band_method: band_method(traits.len()),
            band_level: LEVEL,
            inside: twins.iter().filter(|(_, statistic)| statistic.inside == Some(true)).count(),
            compared: twins.iter().filter(|(_, statistic)| statistic.inside.is_some()).count(),
            curves_inside: curves.iter().map(|(_, curve)| curve.inside).sum(),
            curves_compared: curves.iter().map(|(_, curve)| curve.points).sum(),
            model: self.model.clone(),
            target: self.target.statistics.clone(),
            twins,
            curves,
            limits: self.limits.clone(),
            assumptions: self.assumptions.clone(),
            warnings,
        };
        (comparison, tables)
    }
}

/// Returns sentences about features that twins of a generator lack, whatever the fit.
fn limits(section: &SurfaceSection, is_sharp: bool) -> Vec<String> {
    let mut limits = vec![
        "Twins are stationary: they look alike everywhere, while a scan may be rougher in one place than in another."
            .into(),
    ];
    if section.generator == SurfaceGenerator::WeierstrassMandelbrot {
        limits.push(
            "Twins sum cosines of random phase: their heights are nearly normal, whatever those of the scan.".into(),
        );
    } else {
        limits.push(
            "Twins are Gaussian fields whose heights are transformed to a marginal distribution. Their heights are as frequent \
             as those of scratches, pores and spikes of the scan, but do not form connected features."
                .into(),
        );
        if section.covariance == CovarianceSource::Empirical {
            limits.push(if is_sharp {
                "Twins have the spectrum of the scan as sharp as its window shows it, with the noise of the spectrum of one map.".into()
            } else {
                "The scan's own correlation is kept at short lags and tapered where it falls into its noise: longer waves \
                 are weaker in the twins."
                    .into()
            });
        } else {
            limits.push(
                "The covariance models are symmetric about x and y: a lay at an angle to the axes is averaged away; the \
                 empirical covariance keeps it."
                    .into(),
            );
        }
    }
    limits
}
