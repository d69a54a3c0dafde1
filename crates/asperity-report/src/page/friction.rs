//! The tables of the friction stage, and the conditions of its numbers.

use std::collections::BTreeMap;

use asperity_results::{
    DistributionResult, FrictionResult, GoodnessResult, LevelResult, OperatingPoint, Pair, Prescribed,
    RankedDistributionResult, ReturnLevelResult, RoughBodyResult, UncertaintyResult,
};

use crate::cells::{DASH, percent, plain, shown, yes_or_no};
use crate::format::{Dimension, significant};
use crate::page::cutoff;
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::{conditions, distribution_name, in_words, meaning};

/// Returns the name of a level: its percentile, or the depth or mean pressure that defines it.
fn level_name(level: &LevelResult) -> String {
    match (level.control, level.percentile) {
        (Prescribed::Penetration, _) => format!("{} deep", Dimension::Length.show(level.penetration_m)),
        (_, Some(percentile)) => format!("{} %", significant(percentile, 3)),
        (_, None) => format!("at {}", Dimension::Pressure.show(level.mean_pressure_pa)),
    }
}

/// Describes the operating point: its level and its mean pressure.
pub(super) fn place(point: &OperatingPoint) -> String {
    // The name of such a level contains the pressure.
    if point.level.starts_with("the mean pressure") {
        return point.level.clone();
    }
    format!("{}, {}", point.level, Dimension::Pressure.show(point.mean_pressure_pa))
}

/// Returns the introduction of the friction section.
pub(super) fn lead(friction: Option<&FrictionResult>) -> String {
    let stated = friction.map_or_else(String::new, |friction| {
        let point = &friction.operating_point;
        let mean = shown(Dimension::None, point.mean, point.mean_interval);
        format!(" At the operating point ({}) μ = {mean}. {}", place(point), conditions(friction))
    });
    let described = match friction.map(|friction| friction.body).unwrap_or_default() {
        RoughBodyResult::Track => {
            "The friction coefficient of a window that slides over the rough track, as a stochastic process"
        }
        RoughBodyResult::Slider => {
            "The friction coefficient of a window of the rough slider, which carries its contacts along: it is constant for each \
             part, and standard deviations are those between parts"
        }
        RoughBodyResult::Both => {
            "The friction coefficient of a window between two rough bodies: standard deviations contain differences between parts \
             and the fluctuation along the path"
        }
    };
    format!("{described}; windows are weighted by the load they carry.{stated}")
}

/// Returns the introduction of the section of the quotient F/N, with the levels at which it has no variance.
pub(super) fn quotient_lead(friction: Option<&FrictionResult>) -> String {
    let mut lead =
        "The paper’s definition, friction force over load of every single window. It differs from the friction \
                    coefficient above if windows carry few contacts. The vibration stage does not use it."
            .to_owned();
    for level in friction.iter().flat_map(|friction| &friction.levels) {
        if let Some(reason) = &level.no_variance {
            lead += &format!(
                " Level {}: F/N has no variance, and thus no standard deviation, distribution or return level: {reason}.",
                level_name(level)
            );
        }
    }
    lead
}

/// Returns the tables of `friction`: process and drifts by level, the cut-off, and uncertain surfaces.
pub(super) fn tables(friction: &FrictionResult) -> Vec<DataTable> {
    let mut tables: Vec<DataTable> = [process, drifts].map(|table| table(friction)).into();
    tables.extend(friction.cutoff.as_ref().and_then(cutoff::table));
    tables.extend(friction.scan.as_ref().map(cutoff::of_scan));
    tables.extend(friction.uncertainty.as_ref().and_then(|found| uncertain(friction, found)));
    tables
}

/// Returns the distributions and the correlation families fitted at the operating point.
pub(super) fn model_tables(friction: &FrictionResult) -> Vec<DataTable> {
    let Some(level) = friction.operating_level() else { return Vec::new() };
    let process = &level.at_mean_load;
    let found = Distribution {
        of: "at the mean load",
        marginal: process.marginal.as_ref(),
        intervals: &process.marginal_parameter_intervals,
        gof: process.gof.as_ref(),
        ranked: &process.laws,
        return_levels: &[],
    };
    vec![found.table(level), correlation_models(level)]
}

/// Returns the moments of F/N by level, and its distribution at the operating point.
pub(super) fn quotient_tables(friction: &FrictionResult) -> Vec<DataTable> {
    let distribution = friction.operating_level().map(|level| {
        let found = Distribution {
            of: "of the quotient F/N",
            marginal: level.marginal.as_ref(),
            intervals: &level.marginal_parameter_intervals,
            gof: level.gof.as_ref(),
            ranked: &[],
            return_levels: &level.return_levels,
        };
        found.table(level)
    });
    std::iter::once(moments(friction)).chain(distribution).collect()
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
    Some(DataTable::new(&caption, &headers, rows, RESULTS))
}

/// Returns one row per level: its name, then the cells.
fn by_level(
    friction: &FrictionResult,
    caption: &str,
    headers: &[&str],
    cells: impl Fn(&LevelResult) -> Vec<String>,
) -> DataTable {
    let row = |level: &LevelResult| [vec![level_name(level)], cells(level)].concat();
    let rows: Vec<Vec<String>> = friction.levels.iter().map(row).collect();
    let known = rows.iter().any(|row| row[1..].iter().any(|cell| cell != DASH));
    let headers = [&["Level"], headers].concat();
    let rows = if known { rows } else { Vec::new() };
    DataTable::new(caption, &headers, rows, RESULTS).without_empty_columns()
}

fn moments(friction: &FrictionResult) -> DataTable {
    let caption = format!(
        "Friction coefficient F/N by level for a window of {}; brackets are 95 % intervals",
        Dimension::Length.show(friction.window_m)
    );
    let headers = [
        "Penetration",
        "Mean pressure",
        "Contact fraction",
        "Mean μ",
        "Std",
        "CoV",
        "Skewness",
        "Excess kurtosis",
        "Distribution",
    ];
    let table = by_level(friction, &caption, &headers, |level| {
        let number = |value, interval| shown(Dimension::None, value, interval);
        vec![
            Dimension::Length.show_interval(level.penetration_m, None),
            Dimension::Pressure.show_interval(level.mean_pressure_pa, None),
            significant(level.contact_fraction, 3),
            number(level.mean, level.mean_interval),
            number(level.std, level.std_interval),
            number(level.coefficient_of_variation, level.coefficient_of_variation_interval),
            number(level.skewness, level.skewness_interval),
            number(level.excess_kurtosis, level.excess_kurtosis_interval),
            level.marginal.as_ref().map_or_else(|| DASH.into(), distribution_name),
        ]
    });
    DataTable { source: "tables/friction_levels.csv".into(), ..table }
}

fn process(friction: &FrictionResult) -> DataTable {
    let length = match friction.body {
        RoughBodyResult::Track => " ℓ is that of e^(−s/ℓ), with and without the effect of the window;",
        RoughBodyResult::Slider | RoughBodyResult::Both => "",
    };
    let caption = format!(
        "Friction at the mean load by level; a level of 5 % has 5 % of the heights above the plane; windows are weighted by the \
         load they carry;{length} “paper” lets one window carry the whole normal force, “area” averages μ over the nominal area"
    );
    let headers = [
        "Mean μ",
        "Std",
        "ℓ with the window",
        "ℓ without it",
        "Std, “paper”",
        "Std, “area”",
        "Variance, area over window",
        "Independent windows",
    ];
    by_level(friction, &caption, &headers, |level| {
        let process = &level.at_mean_load;
        let number = |value: f64, interval| shown(Dimension::None, value, interval);
        let length = |metre, interval| shown(Dimension::Length, metre, interval);
        let with_window = match process.correlation_length_m {
            Some(metre) => length(Some(metre), process.correlation_length_m_interval),
            None => length(level.correlation_length_m, level.correlation_length_m_interval),
        };
        // The length of the exponential fit includes the effect of the window.
        let only = if level.window_only == Some(true) { " (due to the window alone)" } else { "" };
        let (own, own_interval) =
            (level.correlation_length_without_window_m, level.correlation_length_without_window_m_interval);
        vec![
            number(process.mean, process.mean_interval),
            number(process.std, process.std_interval),
            format!("{with_window}{only}"),
            length(own, own_interval),
            number(level.upscaling.paper.std, None),
            number(level.upscaling.area.std, None),
            number(level.upscaling.area.variance_reduction, None),
            significant(process.effective_windows, 3),
        ]
    })
}

fn drifts(friction: &FrictionResult) -> DataTable {
    let caption = "Drifts of friction along the strips, with the p-value of each test for no drift, and the correlation of contact area and \
                   load of a window";
    let headers =
        ["Slope of μ (1/m)", "p: slope", "p: halves", "p: ends", "p: variances", "p: wander", "Area and load"];
    by_level(friction, caption, &headers, |level| {
        let tests = level.stationarity.clone().unwrap_or_default();
        let chances = [tests.trend_p, tests.mean_change_p, tests.ends_p, tests.variance_change_p, tests.wander_p];
        let together = level.area_and_load.as_ref();
        let together = together.map(|found| shown(Dimension::None, found.correlation, Some(found.interval)));
        std::iter::once(plain(tests.trend_per_m, 2))
            .chain(chances.map(|p| plain(p, 2)))
            .chain([together.unwrap_or_else(|| DASH.into())])
            .collect()
    })
}

/// The distribution at the operating point, at the mean load or of the quotient F/N: goodness of fit and return levels.
struct Distribution<'a> {
    of: &'static str,
    marginal: Option<&'a DistributionResult>,
    intervals: &'a BTreeMap<String, Option<Pair>>,
    gof: Option<&'a GoodnessResult>,
    ranked: &'a [RankedDistributionResult],
    return_levels: &'a [ReturnLevelResult],
}

impl Distribution<'_> {
    fn table(&self, level: &LevelResult) -> DataTable {
        let mut rows = Vec::new();
        if let Some(marginal) = self.marginal {
            rows.push(("distribution ranked first".into(), distribution_name(marginal)));
            rows.extend(marginal.parameters.iter().map(|(name, value)| {
                let interval = self.intervals.get(name).copied().flatten();
                (meaning(&marginal.name, name).0, shown(Dimension::None, *value, interval))
            }));
        }
        if let Some(gof) = self.gof {
            let distances = [
                ("Kolmogorov–Smirnov distance", Some(gof.kolmogorov_smirnov), Some(gof.kolmogorov_smirnov_p)),
                ("Anderson–Darling A²", gof.anderson_darling, gof.anderson_darling_p),
            ];
            rows.extend(distances.into_iter().filter_map(|(name, distance, chance)| {
                let chance = chance.map_or_else(String::new, |p| format!(" (p = {})", significant(p, 2)));
                Some((name.into(), format!("{}{chance}", significant(distance?, 3))))
            }));
        }
        let ranked = self.ranked.iter();
        let ranked: Vec<String> =
            ranked.map(|fit| format!("{} {}", in_words(&fit.name), significant(fit.aic_difference, 3))).collect();
        if !ranked.is_empty() {
            rows.push(("distributions by ΔAIC".into(), ranked.join(", ")));
        }
        for exceeded in self.return_levels {
            let name = format!("exceeded once in {}", Dimension::Length.show(exceeded.distance_m));
            rows.push((name, shown(Dimension::None, exceeded.mu, exceeded.interval)));
        }
        let caption = format!(
            "Distribution of μ at the operating point ({}), {}; brackets are 95 % intervals",
            level_name(level),
            self.of
        );
        DataTable::properties(&caption, rows, RESULTS)
    }
}

fn correlation_models(level: &LevelResult) -> DataTable {
    let length = |metre: f64, interval| shown(Dimension::Length, metre, interval);
    let curves = level.at_mean_load.correlation_curves.iter().map(|curve| {
        let [model, window] = [in_words(&curve.model), "included".into()];
        vec![model, window, length(curve.length_m, None), significant(curve.misfit, 3), DASH.into(), DASH.into()]
    });
    let models = level.at_mean_load.correlation_models.iter().map(|model| {
        vec![
            in_words(&model.model),
            "removed".into(),
            length(model.length_m, Some(model.length_interval)),
            DASH.into(),
            significant(model.aic_difference, 3),
            yes_or_no(model.worse_beyond_chance).into(),
        ]
    });
    let told = match level.correlation_families_told_apart {
        Some(false) => {
            "; the record cannot tell the families apart: the exponential is used, and the interval of its length covers both"
        }
        _ => "",
    };
    let caption = format!(
        "Families of the correlation at the operating point ({}), the best first: with the effect of the window by least squares, and \
         without it by likelihood{told}",
        level_name(level)
    );
    let headers = ["Family", "Window", "ℓ", "Misfit", "ΔAIC", "Worse beyond chance"];
    DataTable::new(&caption, &headers, curves.chain(models).collect(), RESULTS).without_empty_columns()
}
