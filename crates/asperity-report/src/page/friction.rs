//! The tables of the friction stage, and the conditions that its numbers hold under.

use serde_json::{Value, json};

use super::json::{plain, shown};
use super::tables::list;
use super::{DataTable, cutoff, in_words};
use crate::format::{Dimension, significant};

/// How a level is named: by percentile, or by the depth or the mean pressure that defines it.
pub(super) fn level_name(level: &Value) -> String {
    if let ("penetration", Some(metre)) = (level["control"].as_str().unwrap_or(""), level["penetration_m"].as_f64()) {
        return format!("{} deep", Dimension::Length.show(metre));
    }
    match (level["percentile"].as_f64(), level["mean_pressure_pa"].as_f64()) {
        (Some(percentile), _) => format!("{} %", significant(percentile, 3)),
        (None, Some(pressure)) => format!("at {}", Dimension::Pressure.show(pressure)),
        _ => "–".into(),
    }
}

/// The level that feeds the vibration: the one marked, else the one given by mean pressure, else the first.
pub(crate) fn leading_level(friction: &Value) -> Option<&Value> {
    let levels = list(&friction["levels"]);
    levels
        .iter()
        .find(|level| level["leading"] == Value::Bool(true))
        .or_else(|| levels.iter().find(|level| level["percentile"].is_null() && level["mean_pressure_pa"].is_f64()))
        .or(levels.first())
}

/// Window, strips and boundary in a sentence; empty where there is no window.
pub(crate) fn conditions(friction: &Value) -> String {
    let length = |key: &str| friction[key].as_f64().map(|metre| Dimension::Length.show(metre));
    let Some(window) = length("window_m") else { return String::new() };
    let width = length("window_width_m").map_or(String::new(), |width| format!(" × {width}"));
    let strips = friction["realisations"].as_u64().map_or(String::new(), |count| {
        let wide = length("strip_width_m").map_or(String::new(), |width| format!(" {width} wide"));
        let boundary = match friction["mean_compliance_m_per_pa"].as_f64() {
            Some(compliance) => {
                format!("periodic, of mean compliance {} under a fixed plane", Dimension::Compliance.show(compliance))
            }
            None => "free".into(),
        };
        format!(" on {count} strips{wide} ({boundary})")
    });
    format!("Window of {window}{width}{strips}.")
}

/// The friction coefficient that drives the vibration. Of a run of an older version it is that of the leading level.
pub(super) fn operating_point(friction: &Value) -> Option<Value> {
    if friction["operating_point"].is_object() {
        return Some(friction["operating_point"].clone());
    }
    let level = leading_level(friction)?;
    let process = if level["at_mean_load"].is_object() { &level["at_mean_load"] } else { level };
    Some(json!({
        "level": format!("level {}", level_name(level)), "mean_pressure_pa": level["mean_pressure_pa"],
        "contact_fraction": level["contact_fraction"], "mean": process["mean"], "mean_interval": process["mean_interval"],
        "std": process["std"], "std_interval": process["std_interval"],
        "std_nominal_area": level["upscaling"]["area"]["std"],
    }))
}

/// The operating point in words: its level and its mean pressure.
pub(super) fn place(point: &Value) -> String {
    let level = point["level"].as_str().unwrap_or("–");
    match point["mean_pressure_pa"].as_f64() {
        // The pressure is the name of such a level.
        Some(_) if level.starts_with("the mean pressure") || level.starts_with("level at") => level.to_owned(),
        Some(pascal) => format!("{level}, {}", Dimension::Pressure.show(pascal)),
        None => level.to_owned(),
    }
}

/// What stands above the friction section.
pub(super) fn lead(friction: &Value) -> String {
    let stated = operating_point(friction).filter(|point| point["mean"].is_number()).map_or(String::new(), |point| {
        format!(" At the operating point ({}) μ = {}.", place(&point), shown(&point, "mean"))
    });
    format!(
        "The friction coefficient of a window that slides over the surface, as a stochastic process in which a window counts by \
         the load it carries.{stated} {}",
        conditions(friction)
    )
}

/// What stands above the section of the quotient F/N: where it has no variance, and why.
pub(super) fn quotient_lead(friction: &Value) -> String {
    let mut lead =
        "The paper’s definition, friction force over load of every single window. It differs from the friction \
                    coefficient above where windows carry few contacts, and it does not drive the vibration."
            .to_owned();
    for level in list(&friction["levels"]) {
        if let Some(reason) = level["no_variance"].as_str() {
            lead += &format!(
                " Level {}: F/N has no variance, so that no standard deviation, law or return level is stated: {reason}.",
                level_name(level)
            );
        }
    }
    lead
}

/// `friction`: process and drifts by level; then the law and the correlation of the operating point.
pub(super) fn tables(friction: &Value) -> Vec<DataTable> {
    let mut tables: Vec<DataTable> = [process, drifts].map(|table| table(friction)).into();
    if let Some(lead) = leading_level(friction) {
        tables.extend([law(lead, &lead["at_mean_load"], "at the mean load"), correlation_models(lead)]);
    }
    tables.extend(cutoff::table(friction));
    tables.extend(uncertain(friction));
    tables
}

/// Moments of F/N by level, and its law at the operating point.
pub(super) fn quotient_tables(friction: &Value) -> Vec<DataTable> {
    let lead = leading_level(friction).map(|lead| law(lead, lead, "of the quotient F/N"));
    std::iter::once(moments(friction)).chain(lead).collect()
}

/// Moments over the uncertain parameters of the surface, level by level.
fn uncertain(friction: &Value) -> Option<DataTable> {
    let uncertainty = &friction["uncertainty"];
    let own = list(&friction["levels"]);
    let percent = |value: &Value| value.as_f64().map_or("–".into(), |v| format!("{} %", significant(100.0 * v, 2)));
    let mut rows = Vec::new();
    for (place, level) in list(&uncertainty["levels"]).iter().enumerate() {
        rows.push(vec![level_name(own.get(place).unwrap_or(level))]);
        for response in list(&level["at_mean_load"]) {
            let name = response["name"].as_str().unwrap_or("–");
            let dimension = Dimension::of_key(name).1;
            let ends = (response["interval"][0].as_f64(), response["interval"][1].as_f64());
            let band = match ends {
                (Some(low), Some(high)) => format!("{} to {}", dimension.show(low), dimension.show(high)),
                _ => "–".into(),
            };
            let number = |key: &str| response[key].as_f64().map_or("–".into(), |value| dimension.show(value));
            let indices: Vec<String> = list(&response["sobol"])
                .iter()
                .map(|index| {
                    let parameter = index["parameter"].as_str().unwrap_or("–").replace('_', " ");
                    let total = index["total"].as_f64().map_or("–".into(), |v| significant(v, 2));
                    format!("{parameter} {total}")
                })
                .collect();
            let indices = if indices.is_empty() { plain(&response["reason"]) } else { indices.join(", ") };
            rows.push(vec![
                Dimension::of_key(name).0.replace('_', " "),
                number("value"),
                number("std"),
                band,
                percent(&response["noise_share"]),
                percent(&response["loo_error"]),
                indices,
            ]);
        }
    }
    if rows.is_empty() {
        return None;
    }
    let points = uncertainty["points"].as_u64().map_or(String::new(), |n| format!(" over {n} surfaces of"));
    let caption = format!(
        "Moments of μ at the mean load{points} uncertain parameters; noise is the strips’, unexplained is by the expansion"
    );
    let headers = ["Moment", "Mean", "Std", "95 % of surfaces", "Noise", "Unexplained", "Total indices"];
    Some(DataTable::new(&caption, &headers, rows, "results.json"))
}

/// One row per level: its name, then the cells.
fn by_level(friction: &Value, caption: &str, headers: &[&str], cells: impl Fn(&Value) -> Vec<String>) -> DataTable {
    let row = |level: &Value| [vec![level_name(level)], cells(level)].concat();
    let rows: Vec<Vec<String>> = list(&friction["levels"]).iter().map(row).collect();
    let known = rows.iter().any(|row| row[1..].iter().any(|cell| cell != "–"));
    let headers = [&["Level"], headers].concat();
    let rows = if known { rows } else { Vec::new() };
    DataTable::new(caption, &headers, rows, "results.json").without_empty_columns()
}

fn moments(friction: &Value) -> DataTable {
    let keys = [
        "penetration_m",
        "mean_pressure_pa",
        "contact_fraction",
        "mean",
        "std",
        "coefficient_of_variation",
        "skewness",
        "excess_kurtosis",
    ];
    let window = friction["window_m"]
        .as_f64()
        .map_or(String::new(), |w| format!(" for a window of {}", Dimension::Length.show(w)));
    let caption = format!("Friction coefficient F/N by level{window}; brackets hold 95 % intervals");
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
        let known = |key: &str| match key {
            "contact_fraction" => level[key].as_f64().map_or("–".into(), |share| significant(share, 3)),
            key => shown(level, key),
        };
        keys.map(known).into_iter().chain([marginal(&level["marginal"])]).collect()
    });
    DataTable { source: "tables/friction_levels.csv".into(), ..table }
}

fn process(friction: &Value) -> DataTable {
    let upscaled = list(&friction["levels"]).iter().any(|level| level["upscaling"].is_object());
    let upscalings = "; “paper” lets one window carry the whole normal force, “area” averages μ over the nominal area";
    let caption = format!(
        "The process at the mean load by level, where a window counts by the load it carries; ℓ is that of e^(−s/ℓ), with the \
         window inside and with the window taken out{}",
        if upscaled { upscalings } else { "" }
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
        let process = &level["at_mean_load"];
        let with_window = match process["correlation_length_m"].is_number() {
            true => shown(process, "correlation_length_m"),
            false => shown(level, "correlation_length_m"),
        };
        // The length of the exponential fit contains the window; it never stands without saying so.
        let only = if level["window_only"] == Value::Bool(true) { " (window only)" } else { "" };
        let upscaling = &level["upscaling"];
        vec![
            shown(process, "mean"),
            shown(process, "std"),
            format!("{with_window}{only}"),
            shown(level, "correlation_length_without_window_m"),
            shown(&upscaling["paper"], "std"),
            shown(&upscaling["area"], "std"),
            shown(&upscaling["area"], "variance_reduction"),
            process["effective_windows"].as_f64().map_or("–".into(), |count| significant(count, 3)),
        ]
    })
}

fn drifts(friction: &Value) -> DataTable {
    let caption = "Drifts of friction along the strips, with the probability p of at least as much where there is none, and the \
                   correlation of contact area and load of a window";
    let keys = ["trend_p", "mean_change_p", "ends_p", "variance_change_p", "wander_p"];
    let headers = ["Slope of μ", "p: slope", "p: halves", "p: ends", "p: variances", "p: wander", "Area and load"];
    by_level(friction, caption, &headers, |level| {
        let tests = &level["stationarity"];
        let chance = |key: &str| tests[key].as_f64().map_or("–".into(), |p| significant(p, 2));
        let slope = tests["trend_per_m"].as_f64().map_or("–".into(), |slope| format!("{} /m", significant(slope, 2)));
        let together = estimated(&level["area_and_load"], "correlation");
        [slope].into_iter().chain(keys.map(chance)).chain([together]).collect()
    })
}

/// The law of the operating point, at the mean load or of the quotient F/N: how well it fits, and what it expects far out.
fn law(lead: &Value, part: &Value, of: &str) -> DataTable {
    let mut rows = Vec::new();
    rows.extend(law_name(&part["marginal"]).map(|name| vec!["law ranked first".into(), name]));
    for (name, value) in part["marginal"]["parameters"].as_object().into_iter().flatten() {
        let ends = pair(&part["marginal_parameter_intervals"][name]);
        let shown = value.as_f64().map_or_else(|| plain(value), |value| Dimension::None.show_interval(value, ends));
        rows.push(vec![name.clone(), shown]);
    }
    for (key, name) in
        [("kolmogorov_smirnov", "Kolmogorov–Smirnov distance"), ("anderson_darling", "Anderson–Darling A²")]
    {
        if let Some(distance) = part["gof"][key].as_f64() {
            let chance = part["gof"][&format!("{key}_p")].as_f64();
            let chance = chance.map_or(String::new(), |p| format!(" (p = {})", significant(p, 2)));
            rows.push(vec![name.into(), format!("{}{chance}", significant(distance, 3))]);
        }
    }
    let laws: Vec<String> = list(&part["laws"])
        .iter()
        .filter_map(|law| {
            Some(format!("{} {}", in_words(&law["name"]), significant(law["aic_difference"].as_f64()?, 3)))
        })
        .collect();
    if !laws.is_empty() {
        rows.push(vec!["laws by ΔAIC".into(), laws.join(", ")]);
    }
    for level in list(&part["return_levels"]) {
        let distance = level["distance_m"].as_f64().map_or("–".into(), |metre| Dimension::Length.show(metre));
        rows.push(vec![format!("exceeded once in {distance}"), estimated(level, "mu")]);
    }
    let caption = format!("Law of μ at the operating point ({}), {of}; brackets hold 95 % intervals", level_name(lead));
    DataTable::new(&caption, &["Property", "Value"], rows, "results.json")
}

fn correlation_models(lead: &Value) -> DataTable {
    let rows = list(&lead["at_mean_load"]["correlation_models"]).iter().map(|model| {
        let number = |key: &str| model[key].as_f64().map_or("–".into(), |value| significant(value, 3));
        vec![
            in_words(&model["model"]),
            if model["window_taken_out"] == Value::Bool(true) { "taken out" } else { "inside" }.into(),
            estimated(model, "length_m"),
            number("misfit"),
            number("aic_difference"),
            plain(&model["worse_beyond_chance"]),
        ]
    });
    let caption = format!(
        "Models of the correlation at the operating point ({}), the best first: curves with the window inside by least squares, and \
         with the window taken out by likelihood",
        level_name(lead)
    );
    let headers = ["Model", "Window", "ℓ", "Misfit", "ΔAIC", "Worse beyond chance"];
    DataTable::new(&caption, &headers, rows.collect(), "results.json").without_empty_columns()
}

fn pair(ends: &Value) -> Option<(f64, f64)> {
    ends[0].as_f64().zip(ends[1].as_f64())
}

/// The number of an entry that is about one number, with the interval of the entry.
fn estimated(entry: &Value, key: &str) -> String {
    let (_, dimension) = Dimension::of_key(key);
    entry[key].as_f64().map_or("–".into(), |value| dimension.show_interval(value, pair(&entry["interval"])))
}

/// The name of a fitted law as a reader calls it.
pub(crate) fn law_name(law: &Value) -> Option<String> {
    law["name"].as_str()?;
    let shifted = law["parameters"]["shift"].as_f64().is_some_and(|shift| shift != 0.0);
    Some(format!("{}{}", if shifted { "shifted " } else { "" }, in_words(&law["name"])))
}

fn marginal(law: &Value) -> String {
    match law_name(law) {
        Some(name) if law["parameters"].as_object().is_none_or(serde_json::Map::is_empty) => name,
        Some(name) => format!("{name} ({})", plain(&law["parameters"])),
        None => "–".into(),
    }
}
