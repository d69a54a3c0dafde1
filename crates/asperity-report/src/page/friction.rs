//! The tables of the friction stage, and the conditions that its numbers hold under.

use std::collections::BTreeMap;

use asperity_results::{
    FrictionResult, GoodnessResult, LawResult, LevelResult, OperatingPoint, Pair, Prescribed, RankedLawResult,
    ReturnLevelResult, UncertaintyResult,
};

use super::cells::{DASH, percent, plain, shown, yes_or_no};
use super::{DataTable, cutoff, in_words};
use crate::format::{Dimension, significant};

/// How a level is named: by percentile, or by the depth or the mean pressure that defines it.
fn level_name(level: &LevelResult) -> String {
    match (level.control, level.percentile) {
        (Prescribed::Penetration, _) => format!("{} deep", Dimension::Length.show(level.penetration_m)),
        (_, Some(percentile)) => format!("{} %", significant(percentile, 3)),
        (_, None) => format!("at {}", Dimension::Pressure.show(level.mean_pressure_pa)),
    }
}

/// The level at the operating point.
pub(crate) fn leading_level(friction: &FrictionResult) -> Option<&LevelResult> {
    friction.levels.iter().find(|level| level.leading).or(friction.levels.first())
}

/// Window, strips and boundary in a sentence.
pub(crate) fn conditions(friction: &FrictionResult) -> String {
    let length = |metre: f64| Dimension::Length.show(metre);
    let boundary = match friction.mean_compliance_m_per_pa {
        Some(compliance) => {
            format!("periodic, of mean compliance {} under a fixed plane", Dimension::Compliance.show(compliance))
        }
        None => "free".into(),
    };
    format!(
        "Window of {} × {} on {} strips {} wide ({boundary}).",
        length(friction.window_m),
        length(friction.window_width_m),
        friction.realisations,
        length(friction.strip_width_m)
    )
}

/// The operating point in words: its level and its mean pressure.
pub(super) fn place(point: &OperatingPoint) -> String {
    // The pressure is the name of such a level.
    if point.level.starts_with("the mean pressure") {
        return point.level.clone();
    }
    format!("{}, {}", point.level, Dimension::Pressure.show(point.mean_pressure_pa))
}

/// What stands above the friction section.
pub(super) fn lead(friction: Option<&FrictionResult>) -> String {
    let stated = friction.map_or_else(String::new, |friction| {
        let point = &friction.operating_point;
        let mean = shown(Dimension::None, point.mean, point.mean_interval);
        format!(" At the operating point ({}) μ = {mean}. {}", place(point), conditions(friction))
    });
    format!(
        "The friction coefficient of a window that slides over the surface, as a stochastic process in which a window counts by \
         the load it carries.{stated}"
    )
}

/// What stands above the section of the quotient F/N: where it has no variance, and why.
pub(super) fn quotient_lead(friction: Option<&FrictionResult>) -> String {
    let mut lead =
        "The paper’s definition, friction force over load of every single window. It differs from the friction \
                    coefficient above where windows carry few contacts, and it does not drive the vibration."
            .to_owned();
    for level in friction.iter().flat_map(|friction| &friction.levels) {
        if let Some(reason) = &level.no_variance {
            lead += &format!(
                " Level {}: F/N has no variance, so that no standard deviation, law or return level is stated: {reason}.",
                level_name(level)
            );
        }
    }
    lead
}

/// `friction`: process and drifts by level; then the law and the correlation of the operating point.
pub(super) fn tables(friction: &FrictionResult) -> Vec<DataTable> {
    let mut tables: Vec<DataTable> = [process, drifts].map(|table| table(friction)).into();
    if let Some(lead) = leading_level(friction) {
        let process = &lead.at_mean_load;
        let found = Law {
            of: "at the mean load",
            marginal: process.marginal.as_ref(),
            intervals: &process.marginal_parameter_intervals,
            gof: process.gof.as_ref(),
            laws: &process.laws,
            return_levels: &[],
        };
        tables.extend([found.table(lead), correlation_models(lead)]);
    }
    tables.extend(friction.cutoff.as_ref().and_then(cutoff::table));
    tables.extend(friction.uncertainty.as_ref().and_then(|found| uncertain(friction, found)));
    tables
}

/// Moments of F/N by level, and its law at the operating point.
pub(super) fn quotient_tables(friction: &FrictionResult) -> Vec<DataTable> {
    let law = leading_level(friction).map(|lead| {
        let found = Law {
            of: "of the quotient F/N",
            marginal: lead.marginal.as_ref(),
            intervals: &lead.marginal_parameter_intervals,
            gof: lead.gof.as_ref(),
            laws: &[],
            return_levels: &lead.return_levels,
        };
        found.table(lead)
    });
    std::iter::once(moments(friction)).chain(law).collect()
}

/// Moments over the uncertain parameters of the surface, level by level.
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
        "Moments of μ at the mean load over {} surfaces of uncertain parameters; noise is the strips’, unexplained is by the \
         expansion",
        uncertainty.points
    );
    let headers = ["Moment", "Mean", "Std", "95 % of surfaces", "Noise", "Unexplained", "Total indices"];
    Some(DataTable::new(&caption, &headers, rows, "results.json"))
}

/// One row per level: its name, then the cells.
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
    DataTable::new(caption, &headers, rows, "results.json").without_empty_columns()
}

fn moments(friction: &FrictionResult) -> DataTable {
    let caption = format!(
        "Friction coefficient F/N by level for a window of {}; brackets hold 95 % intervals",
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
        "Marginal law",
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
            level.marginal.as_ref().map_or_else(|| DASH.into(), marginal),
        ]
    });
    DataTable { source: "tables/friction_levels.csv".into(), ..table }
}

fn process(friction: &FrictionResult) -> DataTable {
    let caption = "The process at the mean load by level, where a window counts by the load it carries; ℓ is that of e^(−s/ℓ), with the \
                   window inside and with the window taken out; “paper” lets one window carry the whole normal force, “area” \
                   averages μ over the nominal area";
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
    by_level(friction, caption, &headers, |level| {
        let process = &level.at_mean_load;
        let number = |value: f64, interval| shown(Dimension::None, value, interval);
        let length = |metre, interval| shown(Dimension::Length, metre, interval);
        let with_window = match process.correlation_length_m {
            Some(metre) => length(Some(metre), process.correlation_length_m_interval),
            None => length(level.correlation_length_m, level.correlation_length_m_interval),
        };
        // The length of the exponential fit contains the window; it never stands without saying so.
        let only = if level.window_only == Some(true) { " (window only)" } else { "" };
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
    let caption = "Drifts of friction along the strips, with the probability p of at least as much where there is none, and the \
                   correlation of contact area and load of a window";
    let headers = ["Slope of μ", "p: slope", "p: halves", "p: ends", "p: variances", "p: wander", "Area and load"];
    by_level(friction, caption, &headers, |level| {
        let tests = level.stationarity.clone().unwrap_or_default();
        let slope = tests.trend_per_m.map(|slope| format!("{} /m", significant(slope, 2)));
        let chances = [tests.trend_p, tests.mean_change_p, tests.ends_p, tests.variance_change_p, tests.wander_p];
        let together = level.area_and_load.as_ref();
        let together = together.map(|found| shown(Dimension::None, found.correlation, Some(found.interval)));
        std::iter::once(slope.unwrap_or_else(|| DASH.into()))
            .chain(chances.map(|p| plain(p, 2)))
            .chain([together.unwrap_or_else(|| DASH.into())])
            .collect()
    })
}

/// The law at the operating point, at the mean load or of the quotient F/N: how well it fits, and what it expects far out.
struct Law<'a> {
    of: &'static str,
    marginal: Option<&'a LawResult>,
    intervals: &'a BTreeMap<String, Option<Pair>>,
    gof: Option<&'a GoodnessResult>,
    laws: &'a [RankedLawResult],
    return_levels: &'a [ReturnLevelResult],
}

impl Law<'_> {
    fn table(&self, lead: &LevelResult) -> DataTable {
        let mut rows = Vec::new();
        if let Some(law) = self.marginal {
            rows.push(vec!["law ranked first".into(), law_name(law)]);
            rows.extend(law.parameters.iter().map(|(name, value)| {
                vec![name.clone(), shown(Dimension::None, *value, self.intervals.get(name).copied().flatten())]
            }));
        }
        if let Some(gof) = self.gof {
            let distances = [
                ("Kolmogorov–Smirnov distance", Some(gof.kolmogorov_smirnov), Some(gof.kolmogorov_smirnov_p)),
                ("Anderson–Darling A²", gof.anderson_darling, gof.anderson_darling_p),
            ];
            rows.extend(distances.into_iter().filter_map(|(name, distance, chance)| {
                let chance = chance.map_or_else(String::new, |p| format!(" (p = {})", significant(p, 2)));
                Some(vec![name.into(), format!("{}{chance}", significant(distance?, 3))])
            }));
        }
        let laws = self.laws.iter();
        let laws: Vec<String> =
            laws.map(|law| format!("{} {}", in_words(&law.name), significant(law.aic_difference, 3))).collect();
        if !laws.is_empty() {
            rows.push(vec!["laws by ΔAIC".into(), laws.join(", ")]);
        }
        for level in self.return_levels {
            let name = format!("exceeded once in {}", Dimension::Length.show(level.distance_m));
            rows.push(vec![name, shown(Dimension::None, level.mu, level.interval)]);
        }
        let caption = format!(
            "Law of μ at the operating point ({}), {}; brackets hold 95 % intervals",
            level_name(lead),
            self.of
        );
        DataTable::new(&caption, &["Property", "Value"], rows, "results.json")
    }
}

fn correlation_models(lead: &LevelResult) -> DataTable {
    let length = |metre: f64, interval| shown(Dimension::Length, metre, interval);
    let curves = lead.at_mean_load.correlation_curves.iter().map(|curve| {
        let [model, window] = [in_words(&curve.model), "inside".into()];
        vec![model, window, length(curve.length_m, None), significant(curve.misfit, 3), DASH.into(), DASH.into()]
    });
    let models = lead.at_mean_load.correlation_models.iter().map(|model| {
        vec![
            in_words(&model.model),
            "taken out".into(),
            length(model.length_m, Some(model.length_interval)),
            DASH.into(),
            significant(model.aic_difference, 3),
            yes_or_no(model.worse_beyond_chance).into(),
        ]
    });
    let caption = format!(
        "Models of the correlation at the operating point ({}), the best first: curves with the window inside by least squares, and \
         with the window taken out by likelihood",
        level_name(lead)
    );
    let headers = ["Model", "Window", "ℓ", "Misfit", "ΔAIC", "Worse beyond chance"];
    DataTable::new(&caption, &headers, curves.chain(models).collect(), "results.json").without_empty_columns()
}

/// The name of a fitted law as a reader calls it.
pub(crate) fn law_name(law: &LawResult) -> String {
    let shifted = law.parameters.get("shift").is_some_and(|shift| *shift != 0.0);
    format!("{}{}", if shifted { "shifted " } else { "" }, in_words(&law.name))
}

fn marginal(law: &LawResult) -> String {
    let parameters: Vec<String> =
        law.parameters.iter().map(|(name, value)| format!("{name} = {}", significant(*value, 5))).collect();
    if parameters.is_empty() { law_name(law) } else { format!("{} ({})", law_name(law), parameters.join(", ")) }
}
