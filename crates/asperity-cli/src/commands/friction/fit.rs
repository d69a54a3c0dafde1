//! Fit of a process to a measured record.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use asperity::correlation::LengthFit;
use asperity::distribution::fit::Fit;
use asperity::friction::measured::{
    Abscissa, ColumnTable, Cut, Detrend, DistributionChoice, FittedRecord, MeasuredError, MeasuredRecord, NormalForce,
    PreparedRecord, RecordColumns, RecordPreparation,
};
use asperity::quantity::{Force, Frequency, Length, Time, Velocity};
use asperity::stats::ProcessEstimate;
use asperity::study::{StoreError, Table, json_bytes};
use asperity_formats::read_limited;
use asperity_report::{Figure, record_figures};
use clap::Args;
use serde_json::{Value, json};

use crate::args;
use crate::failure::{Failure, Kind, chain};
use crate::monitor::Terminal;
use crate::output::{Answer, check_target, replace_file, write_verb};
use crate::run_folder::{begin_folder, store_failure};

/// Fits a process to a measured friction record: moments, distribution and correlation, with 95 % intervals.
///
/// A record is a text file of columns, separated by semicolons, tabs, commas or spaces, with decimal points or commas.
/// The flags name columns by header or by number, counted from 1. Units come from the header, `Force [N]`, `t (s)`, or
/// from a flag. Missing values remain gaps. Steps that differ by less than 1 % are resampled, with a warning; steps
/// that differ more are an error.
#[derive(Debug, Args)]
pub(crate) struct FitRecord {
    /// Text file of columns.
    record: PathBuf,
    #[command(flatten)]
    columns: ColumnOptions,
    #[command(flatten)]
    preparation: PreparationOptions,
    /// Distribution to fit: auto, normal, lognormal, weibull, beta, beta:LOW,HIGH with known bounds, johnson, or
    /// empirical.
    #[arg(long, value_name = "DISTRIBUTION", default_value = "auto", value_parser = distribution, allow_hyphen_values = true)]
    law: DistributionChoice,
    /// Write the process to this file, for `[vibration] friction_process` and `asperity friction simulate`.
    #[arg(long, value_name = "PROCESS.json")]
    out: Option<PathBuf>,
    /// Write process, tables and figures to this folder. The folder appears complete or not at all.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Replace a folder that asperity wrote; one that holds any other or changed file, or an input, is refused.
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Columns")]
struct ColumnOptions {
    /// Column of the friction force or coefficient.
    #[arg(long, value_name = "NAME|N")]
    column: String,
    /// Unit of the column if the header states none, or to replace the header's; - for a coefficient.
    #[arg(long, value_name = "UNIT", allow_hyphen_values = true)]
    unit: Option<String>,
    /// Column of times.
    #[arg(long, value_name = "NAME|N", group = "abscissa")]
    time_column: Option<String>,
    /// Unit of the times.
    #[arg(long, value_name = "UNIT", requires = "time_column")]
    time_unit: Option<String>,
    /// Column of sliding distances.
    #[arg(long, value_name = "NAME|N", group = "abscissa")]
    distance_column: Option<String>,
    /// Unit of the distances.
    #[arg(long, value_name = "UNIT", requires = "distance_column")]
    distance_unit: Option<String>,
    /// Number of values per second if there is no column of times or distances.
    #[arg(long, value_name = "Q", group = "abscissa", value_parser = args::positive_quantity::<Frequency>,
          allow_hyphen_values = true)]
    sampling_rate: Option<Frequency>,
    /// Sliding velocity, to convert times to distances.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Velocity>, allow_hyphen_values = true)]
    velocity: Option<Velocity>,
    /// Normal force, to convert a friction force to a coefficient.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Force>, allow_hyphen_values = true,
          conflicts_with = "normal_force_column")]
    normal_force: Option<Force>,
    /// Column of the normal force.
    #[arg(long, value_name = "NAME|N")]
    normal_force_column: Option<String>,
    /// Unit of the normal force.
    #[arg(long, value_name = "UNIT", requires = "normal_force_column")]
    normal_force_unit: Option<String>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Preparation, in this order")]
struct PreparationOptions {
    /// Part of the record to keep, in the file's times or distances: two times or two distances.
    #[arg(long, value_name = "A,B", value_parser = cut, allow_hyphen_values = true)]
    cut: Option<Cut>,
    /// Trend to remove: none, mean, linear, polynomial:DEGREE or high_pass:LENGTH. The mean stays.
    #[arg(long, value_name = "TREND", default_value = "none", value_parser = detrend, allow_hyphen_values = true)]
    detrend: Detrend,
    /// Cutoff length of a Gaussian filter that removes shorter waves.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    low_pass: Option<Length>,
    /// Number of consecutive values to replace by their mean.
    #[arg(long, value_name = "K", default_value = "1", value_parser = args::count, allow_hyphen_values = true)]
    decimate: usize,
}

fn distribution(text: &str) -> Result<DistributionChoice, args::Refusal> {
    text.parse().map_err(|e: String| e.into())
}

/// Parses a trend; hyphens in its name may stand for underscores.
fn detrend(text: &str) -> Result<Detrend, args::Refusal> {
    let end = text.find(':').unwrap_or(text.len());
    let name = text[..end].replace('-', "_");
    format!("{name}{}", &text[end..]).parse().map_err(|e: String| e.into())
}

fn cut(text: &str) -> Result<Cut, args::Refusal> {
    let message = "give two times or two distances, such as 2s,30s or 1mm,20mm";
    let (from, to) = text.split_once(',').ok_or(message)?;
    if let (Ok(from), Ok(to)) = (from.parse::<Time>(), to.parse::<Time>()) {
        return Ok(Cut::Time(from.0, to.0));
    }
    match (from.parse::<Length>(), to.parse::<Length>()) {
        (Ok(from), Ok(to)) => Ok(Cut::Distance(from.0, to.0)),
        (Err(e), _) | (_, Err(e)) => Err(format!("{message}: {e}").into()),
    }
}

impl ColumnOptions {
    fn columns(&self) -> Result<RecordColumns, Failure> {
        let abscissa = match (&self.time_column, &self.distance_column, self.sampling_rate) {
            (Some(column), _, _) => Abscissa::Time { column: column.clone(), unit: self.time_unit.clone() },
            (_, Some(column), _) => Abscissa::Distance { column: column.clone(), unit: self.distance_unit.clone() },
            (_, _, Some(rate)) => Abscissa::SamplingRate { hertz: rate.0 },
            (None, None, None) => {
                return Err(Failure::usage("give one of --time-column, --distance-column and --sampling-rate"));
            }
        };
        let column =
            |column: &String| NormalForce::Column { column: column.clone(), unit: self.normal_force_unit.clone() };
        let constant = self.normal_force.map(|force| NormalForce::Constant { newton: force.0 });
        Ok(RecordColumns {
            column: self.column.clone(),
            unit: self.unit.clone(),
            abscissa,
            velocity_m_per_s: self.velocity.map(|velocity| velocity.0),
            normal_force: constant.or(self.normal_force_column.as_ref().map(column)),
        })
    }
}

impl FitRecord {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let columns = self.columns.columns()?;
        let preparation = RecordPreparation {
            cut: self.preparation.cut,
            detrend: self.preparation.detrend,
            low_pass_m: self.preparation.low_pass.map(|cutoff| cutoff.0),
            decimation: self.preparation.decimate,
        };
        if let (Some(out), Some(folder)) = (&self.out, &self.report)
            && out.starts_with(folder)
        {
            return Err(Failure::usage(
                "--out: this file lies in the report folder, which contains only the report; choose another folder",
            ));
        }
        if let Some(out) = &self.out {
            check_target("--out", out, &[&self.record])?;
        }
        if let Some(folder) = &self.report {
            // Check the folder before computing. The check leaves nothing behind.
            begin_folder("--report", folder, self.force, &[&self.record])?;
        }
        let bytes = read_limited(&self.record).map_err(|e| Failure::io(Kind::Data, self.record.display(), &e))?;
        let name = self.record.file_name().unwrap_or_default().to_string_lossy();
        let description = format!("{name}, column {}, trend {}", columns.column, preparation.detrend);
        let (prepared, fitted) = monitor
            .killable(|| {
                let record = MeasuredRecord::new(&ColumnTable::read(&bytes)?, &columns)?;
                let prepared = preparation.apply(&record)?;
                let fitted = FittedRecord::monitored(&prepared, self.law, &description, monitor)?;
                Ok((prepared, fitted))
            })?
            .or_else(|e| Err(self.failure(&e).print(Answer::default().with("reason", e.to_string()), self.json)?))?;
        for warning in prepared.record.warnings.iter().chain(&fitted.warnings) {
            monitor.warn(&format!("{}: {warning}", self.record.display()));
        }
        let process = fitted.process.to_json().map_err(|e| Failure::data(self.record.display(), &e))?;
        if let Some(out) = &self.out {
            let verb = write_verb(out);
            replace_file(out, |file| file.write_all(process.as_bytes()))?;
            monitor.note(&format!("{verb} {}", out.display()));
        }
        let answer = answer(&prepared, &fitted, self.json);
        if let Some(folder) = &self.report {
            let written = self.write(folder, &prepared, &fitted, &process, &answer)?;
            monitor.note(&format!("wrote {}", written.display()));
        }
        answer.print(self.json)
    }

    fn failure(&self, error: &MeasuredError) -> Failure {
        let kind = match error {
            error if error.is_request() => Kind::Usage,
            error if error.is_too_few() => Kind::NotConverged,
            _ => Kind::Data,
        };
        Failure::new(kind, format!("{}: {}", self.record.display(), chain(error)))
    }

    fn write(
        &self,
        folder: &Path,
        prepared: &PreparedRecord,
        fitted: &FittedRecord,
        process: &str,
        answer: &Answer,
    ) -> Result<PathBuf, Failure> {
        let staging = begin_folder("--report", folder, self.force, &[&self.record])?;
        let write = |relative: &str, bytes: &[u8]| staging.write(relative, bytes).map_err(|e| store_failure(&e));
        write("friction_process.json", process.as_bytes())?;
        write("fit.json", &json_bytes(&answer.as_object()).map_err(|e| store_failure(&e))?)?;
        let mut drawn = BTreeMap::new();
        for (name, columns) in fitted.tables(prepared) {
            let table = Table::new(columns);
            write(&format!("tables/{name}.csv"), &table.to_csv().map_err(|e| store_failure(&StoreError::content(e)))?)?;
            drawn.insert(name.to_owned(), table);
        }
        for (path, svg) in record_figures(&drawn).iter().flat_map(Figure::files) {
            write(&path, svg.as_bytes())?;
        }
        staging.commit_unmarked().map_err(|e| store_failure(&e))
    }
}

/// Returns the results. JSON includes every distribution and model that was tried.
fn answer(prepared: &PreparedRecord, fitted: &FittedRecord, json: bool) -> Answer {
    let (record, process, moments) = (&prepared.record, &fitted.process, &fitted.moments);
    let correlation = process.correlation;
    let (families, length) = (&fitted.families, &fitted.families.chosen);
    let fit = fitted.goodness.map(|fit| fit.kolmogorov_smirnov);
    let mut answer = Answer::default()
        .with("values", record.friction.len())
        .with("present", record.present())
        .with("step_m", record.step_m)
        .with("effective_size", moments.effective_size)
        .with("mean", process.mean)
        .with("mean_interval", json!(process.mean_interval))
        .with("std", process.std)
        .with("std_interval", json!(process.std_interval))
        .with("std_measured", fitted.std_measured)
        .with("coefficient_of_variation", moments.moments.coefficient_of_variation())
        .with("coefficient_of_variation_interval", interval(moments.coefficient_of_variation))
        .with("skewness", moments.moments.skewness)
        .with("skewness_interval", interval(moments.skewness))
        .with("excess_kurtosis", moments.moments.excess_kurtosis)
        .with("excess_kurtosis_interval", interval(moments.excess_kurtosis))
        .with("correlation", correlation.map(|correlation| correlation.shape.name()))
        .with("correlation_length_m", correlation.map(|correlation| correlation.length_m))
        .with("correlation_length_m_interval", json!(correlation.and_then(|correlation| correlation.length_interval_m)))
        .with("correlation_families_told_apart", families.told_apart())
        .with("correlation_fit_p_value", length.lack_of_fit.map(|test| test.p_value))
        .with("values_are", fitted.observation.name())
        .with("noise_share", length.noise_fraction)
        .with("noise_share_interval", json!(length.noise_interval.map(|i| [i.low, i.high])))
        .with("law", process.marginal.as_ref().map(ToString::to_string))
        .with("law_distance", fit.map(|fit| fit.statistic))
        .with("law_p_value", fit.map(|fit| fit.p_value));
    for removal in &prepared.removed {
        answer = answer.with(&format!("{}_variance_share", removal.step), removal.variance_share);
    }
    if !json {
        return answer;
    }
    let marginals = &fitted.marginals;
    let ranked = |fit: &Fit| {
        let aic = fit.aic_correlated(marginals.effective_size);
        json!({ "name": fit.family.key(), "law": fit.marginal.to_string(), "aic": aic })
    };
    let model = |fit: &LengthFit| {
        let best = fit.model == families.fits[0].model;
        json!({
            "model": fit.model.name(),
            "length_m": fit.length_m,
            "length_m_interval": [fit.interval.low, fit.interval.high],
            "aic_difference": if best { 0.0 } else { families.evidence() },
            "worse": !best && families.told_apart(),
            "window_m": fit.window_m,
            "noise_share": fit.noise_fraction,
            "fit_p_value": fit.lack_of_fit.map(|test| test.p_value),
        })
    };
    let warnings: Vec<&String> = record.warnings.iter().chain(&fitted.warnings).collect();
    answer
        .with("laws", marginals.fits.iter().map(ranked).collect::<Vec<_>>())
        .with("correlation_models", families.fits.iter().map(model).collect::<Vec<_>>())
        .with("warnings", json!(warnings))
}

fn interval(estimate: Option<ProcessEstimate>) -> Value {
    json!(estimate.map(|estimate| [estimate.interval.low, estimate.interval.high]))
}
