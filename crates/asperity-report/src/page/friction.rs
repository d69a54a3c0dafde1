//! The tables of the friction stage, and the conditions of its numbers.

use std::collections::BTreeMap;

use asperity_results::{
    Answer, AtMeanLoad, DistributionResult, FrictionResult, LevelProcess, LevelResult, Pair, Prescribed, RoughBody,
    UncertaintyResult,
};

use crate::cells::{DASH, percent, shown};
use crate::format::{Dimension, significant};
use crate::page::answer_table::{all, distribution};
use crate::page::cutoff;
use crate::page::data_table::DataTable;
use crate::words::conditions;

/// Returns the name of a level: its percentile, or the depth or mean pressure that defines it.
fn level_name(level: &LevelResult) -> String {
    match (level.control, level.percentile) {
        (Prescribed::Penetration, _) => format!("{} deep", Dimension::Length.show(level.penetration_m)),
        (_, Some(percentile)) => format!("{} %", significant(percentile, 3)),
        (_, None) => format!("at {}", Dimension::Pressure.show(level.mean_pressure_pa)),
    }
}

/// Describes the operating point: its level and its mean pressure.
pub(super) fn place(friction: &FrictionResult) -> String {
    let point = &friction.operating_point;
    match friction.operating_level().map(|level| level.control) {
        Some(Prescribed::MeanPressure) => {
            format!("the mean pressure {}", Dimension::Pressure.show(point.mean_pressure_pa))
        }
        _ => format!("{}, {}", point.level, Dimension::Pressure.show(point.mean_pressure_pa)),
    }
}

/// Returns the introduction of the friction section.
pub(super) fn lead(friction: Option<&FrictionResult>) -> String {
    let stated = friction.map_or_else(String::new, |friction| {
        format!(" At the operating point: {}. {}", place(friction), conditions(friction))
    });
    let described = match friction.map(|friction| friction.body).unwrap_or_default() {
        RoughBody::Track => {
            "The friction coefficient of a window that slides over the rough track, as a stochastic process"
        }
        RoughBody::Slider => {
            "The friction coefficient of a window of the rough slider, which carries its contacts along: it is constant for each \
             part, and standard deviations are those between parts"
        }
        RoughBody::Both => {
            "The friction coefficient of a window between two rough bodies: standard deviations contain differences between parts \
             and the fluctuation along the path"
        }
    };
    format!("{described}; windows are weighted by the load they carry.{stated}")
}

/// Returns a part of the levels with their names.
fn levels<T>(friction: &FrictionResult, of: fn(&LevelResult) -> &T) -> Vec<(String, &T)> {
    friction.levels.iter().map(|level| (level_name(level), of(level))).collect()
}

/// Returns the tables of `friction`: friction at the mean load by level, the cut-off, uncertain surfaces, fitted distributions and
/// correlation families, and the quotient F/N of single windows.
pub(super) fn tables(friction: &FrictionResult) -> Vec<DataTable> {
    let caption = "Friction at the mean load by level; a level of 5 % has 5 % of the heights above the plane; windows are weighted by the \
                   load they carry; brackets are 95 % intervals of the sampling of strips alone";
    let levels = levels(friction, |level| &level.process);
    // The fitted distribution has a table of its own.
    let mut tables = vec![
        DataTable::of(
            "Friction at the operating point; brackets are 95 % intervals, of μ̄ with its whole error",
            &friction.operating_point,
            all,
        ),
        DataTable::beside(caption, &levels, |key| key != "at_mean_load.marginal.parameters"),
    ];
    tables.extend(friction.cutoff.iter().flat_map(cutoff::tables));
    tables.extend(friction.scan.iter().flat_map(cutoff::of_scan));
    tables.extend(friction.uncertainty.as_ref().and_then(|found| uncertain(friction, found)));
    tables.extend(model_tables(friction));
    tables.extend(quotient_tables(friction));
    tables
}

/// Returns the distributions and the correlation families fitted at the operating point.
fn model_tables(friction: &FrictionResult) -> Vec<DataTable> {
    let Some(level) = friction.operating_level() else { return Vec::new() };
    let AtMeanLoad { marginal, marginal_parameter_intervals, laws, correlation_curves, correlation_models, .. } =
        &level.process.at_mean_load;
    let place = level_name(level);
    vec![
        fitted(&format!("at the mean load ({place})"), marginal.as_ref(), marginal_parameter_intervals),
        DataTable::listed(&format!("Distributions fitted to μ at the mean load ({place}), best first"), laws, all),
        DataTable::listed(
            "Families of the correlation with the effect of the window, fitted by least squares",
            correlation_curves,
            all,
        ),
        DataTable::listed(
            "Families of the correlation without the effect of the window, fitted by likelihood; brackets are 95 % intervals",
            correlation_models,
            all,
        ),
    ]
}

/// Returns the distribution ranked first with its parameters.
fn fitted(of: &str, marginal: Option<&DistributionResult>, intervals: &BTreeMap<String, Option<Pair>>) -> DataTable {
    let caption = format!("Distribution of μ {of} that is ranked first; brackets are 95 % intervals");
    let rows = marginal.map_or_else(Vec::new, |fit| distribution(fit, intervals, Dimension::None));
    DataTable::new(&caption, &["Property", "Value"], rows)
}

/// Returns the numbers of F/N by level, and its distribution at the operating point.
fn quotient_tables(friction: &FrictionResult) -> Vec<DataTable> {
    let caption = format!(
        "Friction coefficient F/N by level for a window of {}; brackets are 95 % intervals",
        Dimension::Length.show_short(friction.window_m)
    );
    let of_process = LevelProcess::fields();
    let keep =
        |key: &str| of_process.iter().all(|field| field.key != key) && !["marginal.parameters", "beta"].contains(&key);
    let lead = friction.operating_level();
    let of_lead = lead.into_iter().flat_map(|level| {
        let place = level_name(level);
        let returns = format!("Values of μ that a window exceeds once in a sliding distance ({place})");
        [
            fitted(
                &format!("of the quotient F/N ({place})"),
                level.marginal.as_ref(),
                &level.marginal_parameter_intervals,
            ),
            DataTable::listed(&returns, &level.return_levels, all),
        ]
    });
    std::iter::once(DataTable::beside(&caption, &levels(friction, |level| level), keep)).chain(of_lead).collect()
}

/// Returns the moments over the uncertain parameters of the surface, level by level.
fn uncertain(friction: &FrictionResult, uncertainty: &UncertaintyResult) -> Option<DataTable> {
    let mut rows = Vec::new();
    for (own, level) in friction.levels.iter().zip(&uncertainty.levels) {
        rows.push(vec![level_name(own)]);
        for response in &level.at_mean_load {
            let (name, dimension) = Dimension::of_key(&response.name);
            let number = |value| shown(dimension, value, None);
            let band =
                response.interval.map(|[low, high]| format!("{} to {}", dimension.show(low), dimension.show(high)));
            let indices = response.sobol.iter();
            let indices: Vec<String> = indices
                .map(|index| format!("{} {}", index.parameter.replace('_', " "), significant(index.total, 2)))
                .collect();
            let reason = response.reason.clone().unwrap_or_else(|| DASH.into());
            rows.push(vec![
                name.replace('_', " "),
                number(response.value),
                number(response.std),
                band.unwrap_or_else(|| DASH.into()),
                percent(response.noise_share, 2),
                percent(response.loo_error, 2),
                if indices.is_empty() { reason } else { indices.join(", ") },
            ]);
        }
    }
    if rows.is_empty() {
        return None;
    }
    let caption = format!(
        "Moments of μ at the mean load over {} surfaces of uncertain parameters; noise is due to the finite number of strips, \
         unexplained variance is that of the expansion",
        uncertainty.points
    );
    let headers = ["Moment", "Mean", "Std", "95 % of surfaces", "Noise", "Unexplained", "Total indices"];
    Some(DataTable::new(&caption, &headers, rows))
}
