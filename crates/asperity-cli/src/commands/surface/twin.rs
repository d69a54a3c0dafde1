//! Random twins of a measured surface, and their comparison with it.

use std::path::{Path, PathBuf};

use asperity::correlation::CorrelationFamily;
use asperity::distribution::Marginal;
use asperity::map::BoundaryKind;
use asperity::map::{HeightMap, MapError};
use asperity::monitor::Cancelled;
use asperity::quantity::Length;
use asperity::study::Provenance;
use asperity::study::file::SurfaceSection;
use asperity::study::{
    Comparison, Staging, StatisticComparison, StudyError, TwinError, TwinOptions, TwinTables, Twins, json_bytes,
};
use asperity::study::{Field, StoreError};
use asperity::surface::model::SurfaceModelError;
use asperity::surface::{CovarianceSource, SurfaceGenerator};
use asperity::translation::TranslationKind;
use asperity_formats::{Format, Scan};
use asperity_report::{Figure, Report, TwinRun, render_twins};
use clap::Args;

use super::convert::format_failure;
use super::preparation::PreparationOptions;
use crate::args::{self, OneOrTwo};
use crate::commands::study_file;
use crate::failure::{Failure, Kind, chain};
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::{self, Answer, columns};
use crate::provenance;
use crate::resources::{require_disk, require_memory};
use crate::run_folder::{begin_folder, load_failure, store_failure};

/// Draws random maps with the statistics of a measured one, and compares them with it on one page.
///
/// The folder contains the twins, comparison.json, tables, figures and twins.html.
#[derive(Debug, Args)]
pub(crate) struct Twin {
    /// Measured heights, in any format that `asperity formats` lists; the content decides the format.
    file: PathBuf,
    /// Number of twins. Bands of fewer than 39 twins assume normally distributed statistics.
    #[arg(long, value_name = "K", default_value = "10", value_parser = args::count, allow_hyphen_values = true)]
    count: usize,
    /// Folder to write. It appears complete or not at all.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace a folder that asperity wrote. A folder that contains an input, or a file that asperity did not write or
    /// that has changed, is never replaced.
    #[arg(long)]
    force: bool,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", default_value = "1", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Format of the twins as a file extension: x3p, sur, npy, txt, …
    #[arg(long, value_name = "EXT", default_value = "x3p", value_parser = written_extension)]
    format: String,
    #[command(flatten)]
    options: ScanOptions,
    #[command(flatten)]
    preparation: PreparationOptions,
    #[command(flatten)]
    model: ModelOptions,
    /// Print comparison.json instead of a table.
    #[arg(long)]
    json: bool,
}

/// Random surface model of the twins.
#[derive(Debug, Args)]
#[command(next_help_heading = "Model of the twins")]
struct ModelOptions {
    /// Generator of the twins.
    #[arg(long, value_parser = args::named::<SurfaceGenerator>(), default_value = "spectral")]
    generator: SurfaceGenerator,
    /// Covariance: the scan's own, the model that fits it best, or a named model, which is fitted or, with
    /// --correlation-length, stated. When left out: empirical, or measured if the scan is too short for it.
    #[arg(long, value_parser = args::named::<CovarianceSource>())]
    covariance: Option<CovarianceSource>,
    /// Lengths ℓ along x and y of a stated covariance. The correlation of the exponential models falls to 1/e at ℓ. For
    /// the Matérn model ℓ is the scale and for the self-affine model the roll-off length; their 1/e lengths differ.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    correlation_length: Option<OneOrTwo<Length>>,
    /// Hurst exponent of a stated self-affine covariance.
    #[arg(long, value_name = "X", value_parser = args::positive, requires = "correlation_length", allow_hyphen_values = true)]
    hurst: Option<f64>,
    /// Smoothness ν of a stated Matérn covariance.
    #[arg(long, value_name = "X", value_parser = args::positive, requires = "correlation_length", allow_hyphen_values = true)]
    smoothness: Option<f64>,
    /// Rms height before a form is removed. When left out, the value that gives the scan's Sq.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    rms_height: Option<Length>,
    /// Marginal distribution of the heights: measured, normal, beta:A,B, lognormal:MU,SIGMA, weibull:SHAPE,SCALE,
    /// gamma:SHAPE,SCALE, triangular:LOW,MODE,HIGH, johnson:SKEWNESS,KURTOSIS.
    #[arg(long, value_name = "DISTRIBUTION", default_value = "measured", value_parser = marginal)]
    marginal: String,
    /// Method that imposes the marginal distribution: corrected keeps the correlation, plain distorts it slightly.
    #[arg(long, value_parser = args::named::<TranslationKind>(), default_value = "corrected")]
    translation: TranslationKind,
    /// Number of terms of the Karhunen–Loève generator. When left out: enough for 90 % of the slope variance, or all
    /// Fourier modes if more than 400 are needed.
    #[arg(long, value_name = "M", value_parser = args::count, allow_hyphen_values = true)]
    modes: Option<usize>,
    /// Continuation of a twin beyond its edge.
    #[arg(long, value_parser = args::named::<BoundaryKind>(), default_value = "free")]
    boundary: BoundaryKind,
    /// Size of a twin along x and y; the scan's size when left out.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    size: Option<OneOrTwo<Length>>,
    /// Points of a twin along x and y. When left out: the scan's points, or enough to fill --size at the scan's pixel
    /// size.
    #[arg(long, value_name = "N[,N]", value_parser = args::count_pair, allow_hyphen_values = true)]
    points: Option<OneOrTwo<usize>>,
}

fn written_extension(text: &str) -> Result<String, args::Refusal> {
    let extension = text.trim_start_matches('.').to_ascii_lowercase();
    match Format::from_extension(&extension) {
        Some(_) => Ok(extension),
        None => Err("this extension belongs to no writable format; `asperity formats` lists them".into()),
    }
}

fn marginal(text: &str) -> Result<String, args::Refusal> {
    if text != "measured" {
        text.parse::<Marginal>()?;
    }
    Ok(text.to_owned())
}

impl ModelOptions {
    /// Returns the covariance key of a study, and the families from which a fitted covariance is chosen.
    fn covariance(&self) -> Result<(CovarianceSource, Vec<CorrelationFamily>), Failure> {
        let choice = self.covariance.unwrap_or(CovarianceSource::Empirical);
        let families = choice.name().parse().map_or(CorrelationFamily::ALL.to_vec(), |family| vec![family]);
        if self.correlation_length.is_none() {
            // Without a stated length the covariance is fitted.
            let is_empirical = choice == CovarianceSource::Empirical;
            return Ok((if is_empirical { choice } else { CovarianceSource::Measured }, families));
        }
        match choice {
            CovarianceSource::Measured | CovarianceSource::Empirical => Err(Failure::usage(
                "--correlation-length: conflicts with a measured covariance; name a model with --covariance",
            )),
            CovarianceSource::Matern if self.smoothness.is_none() => {
                Err(Failure::usage("--smoothness: required by a stated Matérn covariance"))
            }
            CovarianceSource::SelfAffine if self.hurst.is_none() => {
                Err(Failure::usage("--hurst: required by a stated self-affine covariance"))
            }
            choice => Ok((choice, families)),
        }
    }
}

impl Twin {
    fn options(&self) -> Result<TwinOptions, Failure> {
        let model = &self.model;
        let (covariance, families) = model.covariance()?;
        if model.modes.is_some() && model.generator != SurfaceGenerator::KarhunenLoeve {
            return Err(Failure::usage("--modes: requires --generator karhunen_loeve"));
        }
        let preparation = &self.preparation;
        let surface = SurfaceSection {
            level: preparation.level,
            outliers: preparation.outliers,
            s_filter: preparation.s_filter,
            l_filter: preparation.l_filter,
            robust_filter: preparation.robust,
            generator: model.generator,
            covariance,
            rms_height: model.rms_height,
            correlation_length: model.correlation_length.map(|lengths| <[Length; 2]>::from(lengths.both())),
            hurst: model.hurst,
            smoothness: model.smoothness,
            marginal: model.marginal.clone(),
            translation: model.translation,
            modes: model.modes,
            ..SurfaceSection::default()
        };
        Ok(TwinOptions {
            surface,
            families,
            allow_model: model.covariance.is_none(),
            size_m: model.size.map(OneOrTwo::both).map(|(x, y)| [x.0, y.0]),
            points: model.points.map(|points| <[usize; 2]>::from(points.both())),
            boundary: model.boundary,
            seed: self.seed,
        })
    }

    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let options = self.options()?;
        // Check the folder before computing. The check leaves nothing behind.
        begin_folder("--out", &self.out, self.force, &[&self.file])?;
        let name = self.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let scan = input::scan(&self.file, &self.options, monitor)?;
        let inputs = asperity::study::provenance(&name, self.seed, std::slice::from_ref(&self.file));
        let mut provenance = provenance::begin(inputs.map_err(|e| load_failure(&e))?)?;
        let at_once = rayon::current_num_threads().min(self.count);
        require_memory(
            options.memory_bytes(scan.heights_m.len(), scan.pitch_m, at_once),
            "making and comparing twins",
        )?;
        let points = options.points.map_or(scan.heights_m.len(), |[nx, ny]| nx.saturating_mul(ny));
        require_disk(8.0 * points as f64 * self.count as f64, &self.out, "the folder of twins")?;
        let (printed, source) = (scan.warnings.len(), input::source(&scan));
        let file = self.file.display().to_string();
        let twins = monitor.killable(|| Twins::new(scan, &file, &options))?.map_err(|e| self.failure(&e))?;
        // The warnings of the file were printed when it was read.
        twins.warnings().iter().skip(printed).for_each(|warning| monitor.warn(warning));

        let staging = begin_folder("--out", &self.out, self.force, &[&self.file])?;
        let (comparison, tables) = twins
            .compare(self.count, monitor, |index, twin| self.store(&staging, index, twin))
            .map_err(|e| match e {
                TwinError::Study(e) => self.failure(&e),
                TwinError::Keep(failure) => failure,
            })?;
        comparison.warnings.iter().skip(twins.warnings().len()).for_each(|warning| monitor.warn(warning));
        provenance.seconds = monitor.seconds();
        let report = page(&name, &twins, &comparison, &tables, &provenance)?;
        self.write(&staging, &comparison, &tables, &report, &provenance)?;
        monitor.check()?;
        let written = staging.commit().map_err(|e| store_failure(&e))?;
        self.note_lost_pitch(&twins, monitor);
        monitor.note(&format!("wrote {}", written.join("twins.html").display()));
        if self.json { source.and(Answer::new(&comparison)?).print(true) } else { output::print(&table(&comparison)) }
    }

    /// Writes one twin; file names count from 1.
    fn store(&self, staging: &Staging, index: usize, twin: &HeightMap) -> Result<(), Failure> {
        let name = format!("twin_{:04}.{}", index + 1, self.format);
        let grid = twin.grid();
        let scan = Scan::new(twin.heights_m().clone(), Some((grid.dx_m(), grid.dy_m())));
        let bytes = asperity_formats::to_bytes(&scan, Path::new(&name)).map_err(|e| format_failure(&e))?;
        staging.write(&name, &bytes).map_err(|e| store_failure(&e))
    }

    fn write(
        &self,
        staging: &Staging,
        comparison: &Comparison,
        tables: &TwinTables,
        report: &Report,
        provenance: &Provenance,
    ) -> Result<(), Failure> {
        let write = |relative: &str, bytes: &[u8]| staging.write(relative, bytes).map_err(|e| store_failure(&e));
        write("comparison.json", &json_bytes(comparison).map_err(|e| store_failure(&e))?)?;
        write("provenance.json", &json_bytes(provenance).map_err(|e| store_failure(&e))?)?;
        for (name, table) in tables {
            write(&format!("tables/{name}.csv"), &table.to_csv().map_err(|e| store_failure(&StoreError::content(e)))?)?;
        }
        for (path, svg) in report.figures.iter().flat_map(Figure::files) {
            write(&path, svg.as_bytes())?;
        }
        write("twins.html", report.html.as_bytes())
    }

    fn note_lost_pitch(&self, twins: &Twins, monitor: &Terminal) {
        if let Some(format) = Format::from_extension(&self.format).filter(|format| !format.stores_pitch()) {
            let grid = twins.grid();
            monitor.warn(&format!(
                "{} cannot store the pixel size, {:?} × {:?} m; note it",
                format.name(),
                grid.dx_m(),
                grid.dy_m()
            ));
        }
    }

    /// Converts an error of the library, which refers to a study file, to a message about the flags.
    fn failure(&self, error: &StudyError) -> Failure {
        let file = self.file.display();
        match error {
            StudyError::Map { error: MapError::NoPitch, .. } => {
                Failure::usage(format_args!("{file}: {}", MapError::NoPitch))
            }
            StudyError::Surface(SurfaceModelError::Fit(error)) => Failure::new(
                Kind::Data,
                format!("{file}: covariance: {error}; state one with --covariance and --correlation-length"),
            ),
            StudyError::Surface(SurfaceModelError::Empirical(error)) => Failure::new(
                Kind::Data,
                format!("{file}: covariance: {error}; state one with --covariance and --correlation-length"),
            ),
            StudyError::Surface(SurfaceModelError::FractalDimension) => Failure::new(
                Kind::Data,
                format!("{file}: the scan has no scaling range, which the Weierstrass–Mandelbrot generator requires"),
            ),
            StudyError::Surface(SurfaceModelError::Covariance(error)) => {
                Failure::usage(format_args!("covariance: {error}"))
            }
            StudyError::Grid { error, .. } => Failure::usage(format_args!("--size, --points: {error}")),
            StudyError::Cancelled(Cancelled) => Cancelled.into(),
            error => study_file::failure(&self.file, None, error),
        }
    }
}

/// Renders the page of the comparison.
fn page(
    name: &str,
    twins: &Twins,
    comparison: &Comparison,
    tables: &TwinTables,
    provenance: &Provenance,
) -> Result<Report, Failure> {
    let shown = (0..comparison.count.min(2)).map(|index| field(&twins.draw(index as u64)));
    render_twins(&TwinRun {
        name: name.to_owned(),
        comparison: comparison.clone(),
        tables: tables.iter().map(|(name, table)| ((*name).to_owned(), table.clone())).collect(),
        scan: Some(field(twins.scan())),
        twins: shown.collect(),
        provenance: Some(provenance.clone()),
    })
    .map_err(|e| Failure::new(Kind::Runtime, format!("the page could not be rendered: {}", chain(&e))))
}

fn field(map: &HeightMap) -> Field {
    let grid = map.grid();
    Field::new([grid.dx_m(), grid.dy_m()], "m", map.heights_m().clone())
}

/// Formats the statistics as lines: name, scan, mean of the twins, band, and whether the scan lies outside.
fn table(comparison: &Comparison) -> String {
    let value = |key: &str, value: Option<f64>| output::row(key, &value.into());
    let line = |(key, found): &(String, StatisticComparison)| {
        let (name, scan) = value(key, found.target);
        let band = found.band.map(|[low, high]| {
            let (low, high) = (value(key, Some(low)).1, value(key, Some(high)).1);
            format!("{low} to {high}")
        });
        let verdict = if found.inside == Some(false) { "outside" } else { "" };
        [name, scan, value(key, found.mean).1, band.unwrap_or_else(|| "undefined".into()), verdict.into()]
    };
    let header = ["", "scan", "mean of twins", "95 % band of twins", ""].map(str::to_owned);
    let rows: Vec<[String; 5]> = std::iter::once(header).chain(comparison.twins.iter().map(line)).collect();
    let Comparison { inside, compared, .. } = comparison;
    let percent = |fraction: f64| format!("{:.0} %", 100.0 * fraction);
    let curves = comparison.curves_inside_share().map_or(String::new(), |fraction| {
        let each = comparison
            .curves
            .iter()
            .filter_map(|(name, curve)| Some(format!("{} {}", name.replace('_', " "), percent(curve.inside_share?))));
        format!(" and {} of the points of its curves ({})", percent(fraction), each.collect::<Vec<_>>().join(", "))
    });
    format!(
        "{}{inside} of {compared} statistics of the scan{curves} lie within the band of its twins\n",
        columns(&rows)
    )
}
