//! The tables of the friction stage.

use crate::correlation::{WindowedModel, windowed_exponential};
use crate::distribution::Marginal;
use crate::distribution::fit::{Family, Fit};
use crate::friction::diagnostics::{Columns, integral_transform, quantile_pairs};
use crate::friction::load_curve::LoadPoint;
use crate::friction::window_study::{WindowCorrelation, WindowStudy};
use crate::friction::{LevelControl, RoughBody, SolvedLevel};
use crate::stats::{Histogram, sorted_present};
use crate::study::Table;
use crate::study::result::{AreaAndLoad, FrictionSpectrum, FrictionWindows, LevelResult, LoadCurve};

type Tables = Vec<(&'static str, Table)>;

/// Moments and load of all levels, and the course of friction along one strip if that is a path.
pub(super) fn of_levels(results: &[LevelResult], levels: &[SolvedLevel], body: RoughBody) -> Tables {
    let mut tables = vec![("friction_levels", Table::of(results)), ("friction_load_curve", load_curve_table(levels))];
    tables.extend((body == RoughBody::Track).then(|| ("friction_trace", trace_table(levels))));
    tables
}

/// Law of the leading level at the mean load and, along a path, its correlation, spectrum and window study.
pub(super) fn of_lead(lead: &SolvedLevel, body: RoughBody) -> Tables {
    let mut tables = law_tables(lead);
    if body != RoughBody::Track {
        return tables;
    }
    tables.extend(correlation_table(lead).map(|table| ("friction_acf", table)));
    tables.extend(spectrum_table(lead).map(|table| ("friction_spectrum", table)));
    tables.extend(cross_table(lead).map(|table| ("friction_area_load", table)));
    tables.extend(lead.window_study.as_ref().map(|study| ("friction_windows", windows_table(study))));
    tables
}

/// Load against depth, from the shallowest level.
fn load_curve_table(levels: &[SolvedLevel]) -> Table {
    let mut points: Vec<LoadPoint> = levels.iter().map(|level| LoadPoint::from_strips(&level.strips)).collect();
    points.sort_by(|a, b| a.penetration_m.total_cmp(&b.penetration_m));
    let column = |value: &dyn Fn(&LoadPoint) -> f64| points.iter().map(value).collect();
    Table::from(LoadCurve {
        penetration_m: column(&|p| p.penetration_m),
        mean_pressure_pa: column(&|p| p.mean_pressure_pa),
        low: column(&|p| p.interval.low),
        high: column(&|p| p.interval.high),
        contact_fraction: column(&|p| p.contact_fraction),
    })
}

/// Returns the column of a level in the table of traces.
fn trace_column(level: LevelControl) -> String {
    match level {
        LevelControl::Percentile(percent) => format!("mu_p{percent}").replace('.', "_"),
        LevelControl::MeanPressure(pascal) => format!("mu_pressure_{pascal:e}_pa"),
        LevelControl::Penetration(metre) => format!("mu_penetration_{metre:e}_m"),
        LevelControl::Nominal(_) => "mu_load".into(),
    }
}

/// μ(s) of the first strip at every level.
fn trace_table(levels: &[SolvedLevel]) -> Table {
    let first = levels.iter().filter_map(|level| level.strips.records.first()).next();
    let mut columns = vec![("position_m".to_owned(), first.map_or_else(Vec::new, |record| record.position_m.clone()))];
    let rows = columns[0].1.len();
    for level in levels {
        let trace = level.strips.records.first().filter(|record| record.friction.len() == rows);
        columns.push((
            trace_column(level.control),
            trace.map_or_else(|| vec![f64::NAN; rows], |record| record.friction.clone()),
        ));
    }
    Table::new(columns)
}

/// Histogram with the fitted distributions, and how well the one to go on with fits.
fn law_tables(lead: &SolvedLevel) -> Tables {
    let process = &lead.process;
    let pooled = sorted_present(lead.at_mean_load.iter().flat_map(|record| record.friction.iter().copied()));
    // Values that are all equal have no histogram.
    let Ok(histogram) = Histogram::new(&pooled) else { return Vec::new() };
    let centres = histogram.centres();
    let density = |law: &Marginal| -> Vec<f64> { centres.iter().map(|mu| law.pdf(*mu)).collect() };
    let chosen = process.marginal();
    let mut columns = vec![("density".to_owned(), histogram.density())];
    // The windows' own distribution has no density beside their histogram.
    let smooth = |fit: &&Fit| !matches!(fit.family, Family::Empirical { .. });
    columns.extend(chosen.filter(smooth).map(|fit| ("fitted_density".to_owned(), density(&fit.marginal))));
    columns.extend(process.beta.iter().map(|fit| ("beta_density".to_owned(), density(&fit.marginal))));
    let others =
        process.marginals.fits.iter().filter(|fit| Some(*fit) != chosen && Some(*fit) != process.beta.as_ref());
    columns.extend(others.filter(smooth).map(|fit| (format!("{}_density", fit.family.key()), density(&fit.marginal))));
    columns.push(("mu".to_owned(), centres));
    let mut tables = vec![("friction_histogram", Table::new(columns).with_first("mu"))];
    if let Some(fit) = chosen {
        let transform = integral_transform(&fit.marginal, &pooled, process.effective_windows);
        tables.push(("friction_pit", table(transform).with_first("probability")));
        tables.push(("friction_qq", table(quantile_pairs(&fit.marginal, &pooled)).with_first("probability")));
    }
    tables
}

fn table(columns: Columns) -> Table {
    Table::new(columns)
}

/// Autocorrelation with the models fitted to it.
fn correlation_table(lead: &SolvedLevel) -> Option<Table> {
    let window = &lead.window;
    let correlation = lead.process.correlation.as_ref().ok()?;
    let estimate = &correlation.estimate;
    let lags: Vec<f64> = (0..estimate.correlation.len()).map(|k| k as f64 * estimate.step_m).collect();
    let over_lags = |of: &dyn Fn(f64) -> f64| -> Vec<f64> { lags.iter().map(|lag| of(*lag)).collect() };
    let exponential = correlation.exponential;
    let mut columns = vec![
        ("acf".to_owned(), estimate.correlation.clone()),
        ("fit".to_owned(), over_lags(&|lag| exponential.model.correlation(lag, exponential.length_m))),
    ];
    if window.is_rectangle() {
        let window_m = window.length_m();
        columns.push(("window_only".to_owned(), over_lags(&|lag| windowed_exponential(lag, window_m, 0.0))));
        columns.extend(lead.window_study.as_ref().map(|study| {
            let model = WindowedModel::new(study.model, window_m).with_cells(window.cell_m());
            ("windowed_fit".to_owned(), over_lags(&|lag| model.correlation(lag, study.length_m)))
        }));
    }
    let others = correlation.models.iter().filter(|fit| fit.model != exponential.model);
    columns.extend(
        others.map(|fit| {
            (format!("fit_{}", fit.model.name()), over_lags(&|lag| fit.model.correlation(lag, fit.length_m)))
        }),
    );
    columns.push(("lag_m".to_owned(), lags));
    Some(Table::new(columns).with_first("lag_m"))
}

/// Power spectral density with its band, and that of the window alone and of the process under it.
fn spectrum_table(lead: &SolvedLevel) -> Option<Table> {
    let window = &lead.window;
    let spectrum = lead.analysis.spectrum.as_ref().ok()?;
    let variance = lead.process.moments.std.powi(2);
    let mut curves = FrictionSpectrum {
        frequency_per_m: (&spectrum.frequency_per_m).into(),
        density_m: (&spectrum.density).into(),
        density_m_low: (&spectrum.low).into(),
        density_m_high: (&spectrum.high).into(),
        ..FrictionSpectrum::default()
    };
    if let (Some(study), true) = (&lead.window_study, window.is_rectangle()) {
        let model = WindowedModel::new(study.model, window.length_m()).with_cells(window.cell_m());
        curves.window_only_m = spectrum.model_density(&model, 0.0, variance).into();
        curves.windowed_fit_m = spectrum.model_density(&model, study.length_m, variance).into();
    }
    Some(curves.into())
}

/// Correlation of contact area and load of the windows over the lag between them.
fn cross_table(lead: &SolvedLevel) -> Option<Table> {
    let cross = lead.analysis.area_and_load.as_ref().ok()?;
    let lag_m = cross.lags.iter().map(|lag| *lag as f64 * cross.step_m).collect();
    Some(AreaAndLoad { lag_m, correlation: (&cross.correlation).into() }.into())
}

fn windows_table(study: &WindowStudy) -> Table {
    let column = |value: &dyn Fn(&WindowCorrelation) -> f64| study.windows.iter().map(value).collect();
    Table::from(FrictionWindows {
        window_m: column(&|seen| seen.window_m),
        std: column(&|seen| seen.std),
        expected_std: column(&|seen| seen.expected_std),
        correlation_length_m: column(&|seen| seen.length_m),
        own_length_m: column(&|seen| seen.own.map_or(f64::NAN, |own| own.length_m)),
        own_length_low_m: column(&|seen| seen.own.map_or(f64::NAN, |own| own.interval.low)),
        own_length_high_m: column(&|seen| seen.own.map_or(f64::NAN, |own| own.interval.high)),
    })
}
