//! The tables of the vibration stage.

use serde_json::Value;

use super::DataTable;
use super::json::{flattened, interval, plain, shown};
use super::tables::list;
use crate::Run;
use crate::format::{Dimension, show_range, significant, with_error};

/// `vibration`: limits and cycle, cycles against damping, re-attachment law.
pub(super) fn tables(run: &Run) -> Vec<DataTable> {
    let vibration = &run.results["vibration"];
    let mut tables = Vec::new();
    let mut scalars = vibration.clone();
    if let Value::Object(entries) = &mut scalars {
        entries.remove("paper");
        entries.remove("area");
        entries.remove("map");
    }
    let rows = flattened(&scalars).into_iter().map(|(key, value)| vec![key, value]).collect();
    tables.push(DataTable::new("Without roughness", &["Property", "Value"], rows, "results.json"));

    let mut counts: Vec<Vec<String>> = Vec::new();
    for entry in list(&vibration["area"]["damping"]).iter().chain(list(&vibration["paper"]["damping"])) {
        let damping = entry["damping_ratio"].as_f64().map_or("–".into(), |v| significant(v, 4));
        if counts.iter().any(|row| row[0] == damping) {
            continue;
        }
        let kind = entry["kind"].as_str().map_or("–".into(), |kind| kind.replace('_', "-"));
        let mut row = vec![damping, kind, shown(entry, "cycles_deterministic")];
        for upscaling in ["area", "paper"] {
            let found = at_damping(&vibration[upscaling], entry["damping_ratio"].as_f64());
            row.push(found.map_or("–".into(), |entry| shown(entry, "cycles_mean")));
            row.push(found.map_or("–".into(), |entry| difference(run, upscaling, entry).1));
        }
        counts.push(row);
    }
    let headers = ["ζ", "Deterministic", "M deterministic", "M, “area”", "lost, “area”", "M, “paper”", "lost, “paper”"];
    let caption =
        "Cycles M and cycles lost, M(det) − mean M, by damping ratio and upscaling; brackets hold 95 % intervals";
    tables.push(DataTable::new(caption, &headers, counts, "tables/cycles_over_damping.csv").without_empty_columns());

    tables.extend([crossings(vibration), motion(vibration)]);
    tables.push(points(vibration, "reattachment", "Re-attachment points by upscaling"));
    tables.push(points(vibration, "release", "Points of detachment by upscaling"));
    tables
}

/// What stands in the column of an upscaling.
type Cell = Box<dyn Fn(&Value) -> String>;

/// Upscalings that the results hold, with their name.
fn upscalings(vibration: &Value) -> impl Iterator<Item = (&'static str, &Value)> {
    ["area", "paper"].into_iter().map(|name| (name, &vibration[name])).filter(|(_, part)| part.is_object())
}

/// A column for each upscaling behind a first one; only rows of which something is known.
fn by_upscaling(
    vibration: &Value,
    caption: &str,
    first: &str,
    rows: impl Iterator<Item = (String, Cell)>,
) -> DataTable {
    let names: Vec<String> = upscalings(vibration).map(|(name, _)| format!("“{name}”")).collect();
    let headers: Vec<&str> = std::iter::once(first).chain(names.iter().map(String::as_str)).collect();
    let rows = rows
        .map(|(title, cell)| std::iter::once(title).chain(upscalings(vibration).map(|(_, part)| cell(part))).collect())
        .filter(|row: &Vec<String>| row[1..].iter().any(|cell| cell != "–"));
    DataTable::new(caption, &headers, rows.collect(), "results.json")
}

/// Where vibration falls through levels of the time.
fn crossings(vibration: &Value) -> DataTable {
    let mut shares: Vec<f64> = upscalings(vibration)
        .flat_map(|(_, part)| list(&part["crossings"]).iter().filter_map(|crossing| crossing["share"].as_f64()))
        .collect();
    shares.sort_by(|a, b| b.total_cmp(a));
    shares.dedup();
    let rows = shares.into_iter().map(|share| -> (String, Cell) {
        let cell = move |part: &Value| {
            let found = list(&part["crossings"]).iter().find(|crossing| crossing["share"].as_f64() == Some(share));
            match found.map(|crossing| (&crossing["damping_ratio"], interval(crossing, "damping_ratio"))) {
                // Trajectories that all agree have no interval.
                Some((value, Some((low, high)))) if low == high => plain(value),
                Some((Value::Null, _)) => found
                    .and_then(|crossing| crossing["reason"].as_str())
                    .map_or("–".into(), |reason| format!("none: {reason}")),
                Some(_) => found.map_or("–".into(), |crossing| shown(crossing, "damping_ratio")),
                None => "–".into(),
            }
        };
        (format!("{} %", significant(100.0 * share, 3)), Box::new(cell))
    });
    let caption = "Damping ratio at which vibration falls through a share of the time: the mean over the trajectories, which start in \
                   stick, of the share of the second half of the duration; brackets hold 95 % intervals";
    by_upscaling(vibration, caption, "Time in vibration", rows)
}

/// The motion under roughness at the damping of the study.
fn motion(vibration: &Value) -> DataTable {
    let number = |key: &'static str| move |part: &Value| shown(&part["motion"], key);
    let percent = |key: &'static str| {
        move |part: &Value| {
            let motion = &part["motion"];
            let share = |value: f64| significant(100.0 * value, 4);
            match (motion[key].as_f64(), interval(motion, key), motion[&format!("{key}_se")].as_f64()) {
                (Some(value), Some((low, high)), _) => {
                    format!("{} % {}", share(value), show_range(100.0 * low, 100.0 * high))
                }
                (Some(value), None, Some(error)) => format!("{} %", with_error(100.0 * value, 100.0 * error)),
                (Some(value), None, None) => format!("{} %", share(value)),
                (None, _, _) => "–".into(),
            }
        }
    };
    let kind = |key: &'static str| {
        move |part: &Value| {
            let share = part["motion"]["kind_shares"][key].as_f64().filter(|share| *share > 0.0);
            share.map_or("–".into(), |share| format!("{} %", significant(100.0 * share, 4)))
        }
    };
    let rows: [(&str, Cell); 10] = [
        ("Period τ between detachments", Box::new(number("period_mean"))),
        ("Its jitter (standard deviation)", Box::new(number("period_std"))),
        ("Time in stick", Box::new(percent("stick_share"))),
        ("Time in vibration", Box::new(percent("share_in_cycle"))),
        ("of it stick-slip", Box::new(kind("stick_slip"))),
        ("overtaking the belt without stick", Box::new(kind("overtaking"))),
        ("slower than the belt throughout", Box::new(kind("slip_cycle"))),
        ("Ways out of vibration per τ in it", Box::new(number("exit_rate"))),
        ("Ways back per τ out of it", Box::new(number("entry_rate"))),
        ("Trajectories that leave vibration", Box::new(percent("left_share"))),
    ];
    let at =
        vibration["damping_ratio"].as_f64().map_or(String::new(), |zeta| format!(" at ζ = {}", significant(zeta, 4)));
    let caption =
        format!("The motion under fluctuating friction{at}; brackets hold 95 % intervals, ± is a standard error");
    by_upscaling(vibration, &caption, "Property", rows.into_iter().map(|(title, cell)| (title.to_owned(), cell)))
}

/// The law of points of the motion.
fn points(vibration: &Value, key: &str, caption: &str) -> DataTable {
    let rows = upscalings(vibration).filter(|(_, part)| part[key].is_object()).map(|(name, part)| {
        let law = &part[key];
        vec![
            format!("“{name}”"),
            shown(part, "friction_std"),
            match (law["mean"].as_f64(), law["std"].as_f64()) {
                (Some(mean), Some(std)) => with_error(mean, std),
                _ => shown(law, "mean"),
            },
            shown(law, "skewness"),
            shown(law, "excess_kurtosis"),
            shown(law, "normality_p"),
        ]
    });
    let headers = ["Upscaling", "Std of μ", "X: mean ± std", "Skewness", "Excess kurtosis", "p (normality)"];
    DataTable::new(caption, &headers, rows.collect(), "results.json").without_empty_columns()
}

/// The entry of an upscaling at a damping ratio.
fn at_damping(upscaling: &Value, damping: Option<f64>) -> Option<&Value> {
    let damping = damping?;
    list(&upscaling["damping"]).iter().find(|entry| entry["damping_ratio"].as_f64() == Some(damping))
}

/// The interval of the lost cycles, from the results or from the table of the sweep, and the number as text.
pub(super) fn difference(run: &Run, upscaling: &str, entry: &Value) -> (Option<(f64, f64)>, String) {
    let limits = interval(entry, "difference_mean").or_else(|| interval(entry, "difference")).or_else(|| {
        let table = run.tables.get("cycles_over_damping")?;
        let damping = entry["damping_ratio"].as_f64()?;
        let row = table.column("damping_ratio")?.iter().position(|v| (v - damping).abs() <= 1e-9 * damping.abs())?;
        let end = |end: &str| table.column(&format!("{upscaling}_difference_{end}")).map(|values| values[row]);
        Some((end("low")?, end("high")?)).filter(|(low, high)| low.is_finite() && high.is_finite())
    });
    let text = match entry["difference_mean"].as_f64() {
        Some(value) => Dimension::None.show_interval(value, limits),
        None => "–".into(),
    };
    (limits, text)
}
