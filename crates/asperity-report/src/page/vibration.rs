//! The tables of the vibration stage.

use asperity_results::{DampingResult, EnsembleResult, KindResult, MotionResult, Pair, PointsResult, VibrationResult};

use crate::cells::{DASH, percent, plain, shown, yes_or_no};
use crate::format::{Dimension, show_range, significant, with_error};
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::{distribution_name, kind_in_words, meaning};

/// Returns limits and cycle, cycles over damping, motion, and distributions of points.
pub(super) fn tables(vibration: &VibrationResult) -> Vec<DataTable> {
    vec![
        scalars(vibration),
        counts(vibration),
        crossings(vibration),
        motion(vibration),
        points(vibration, |part| &part.reattachment, "Re-attachment points by upscaling"),
        points(vibration, |part| &part.release, "Points of detachment by upscaling"),
    ]
}

/// Returns the motion without fluctuation, the limits of the damping ratio, and the friction.
fn scalars(vibration: &VibrationResult) -> DataTable {
    let cycle = &vibration.cycle;
    let number = |value: Option<f64>| plain(value, 4);
    // The limits often differ in the last digits only.
    let limit = |value: Option<f64>| plain(value, 5);
    let in_unit = |dimension: Dimension, value: Option<f64>| shown(dimension, value, None);
    let rows = [
        ("Motion that starts in stick", String::new()),
        ("damping ratio ζ of the study", number(Some(vibration.damping_ratio))),
        ("belt velocity V", number(Some(vibration.belt_velocity))),
        ("kind", kind_in_words(vibration.kind).into()),
        ("period τ", number(cycle.period)),
        ("duration τ of the slip", number(cycle.slip_duration)),
        ("least displacement X", number(cycle.displacement_min)),
        ("largest displacement X", number(cycle.displacement_max)),
        ("displacement X at re-attachment", number(cycle.reattachment_displacement)),
        ("least velocity dX/dτ", number(cycle.velocity_min)),
        ("steady sliding is unstable", yes_or_no(vibration.steady_sliding_unstable).into()),
        ("smallest kick that starts vibration", in_unit(Dimension::Velocity, vibration.kick_m_per_s)),
        ("Limits of the damping ratio", String::new()),
        ("ζ_v, largest with any vibration", limit(vibration.limit_damping_ratio)),
        ("ζ_c, largest with stick-slip", limit(vibration.critical_damping_ratio)),
        ("ζ_H, steady sliding is unstable below", limit(vibration.hopf_damping_ratio)),
        ("Friction", String::new()),
        ("upscaling of the study", format!("“{}”", vibration.upscaling)),
        ("percentile of the level", number(vibration.level_percentile)),
        ("mean pressure of the level", in_unit(Dimension::Pressure, vibration.level_mean_pressure_pa)),
        ("static friction coefficient", number(Some(vibration.static_friction))),
        ("variance of μ, “area” over one window", number(Some(vibration.variance_reduction))),
        ("correlation length of μ", in_unit(Dimension::Length, vibration.friction_correlation_length_m)),
        ("correlation length of μ, in X", number(vibration.correlation_length)),
    ];
    let distribution = vibration.marginal.iter().flat_map(|fit| {
        let of = |(key, value): (&String, &f64)| (meaning(&fit.name, key).0, number(Some(*value)));
        std::iter::once(("distribution of μ".into(), distribution_name(fit))).chain(fit.parameters.iter().map(of))
    });
    let rows = rows.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(distribution);
    DataTable::properties("Motion without roughness, and the friction of the machine", rows, RESULTS)
}

/// Returns the cycles by damping ratio and upscaling.
fn counts(vibration: &VibrationResult) -> DataTable {
    let mut counts: Vec<Vec<String>> = Vec::new();
    for entry in vibration.area.damping.iter().chain(&vibration.paper.damping) {
        let damping = significant(entry.damping_ratio, 4);
        if counts.iter().any(|row| row[0] == damping) {
            continue;
        }
        let deterministic = shown(Dimension::None, entry.cycles_deterministic as f64, None);
        let mut row = vec![damping, kind_in_words(entry.kind).to_owned(), deterministic];
        for (_, part) in upscalings(vibration) {
            let found = part.damping.iter().find(|other| other.damping_ratio == entry.damping_ratio);
            row.push(found.map_or_else(|| DASH.into(), |found| shown(Dimension::None, found.cycles_mean, None)));
            row.push(found.map_or_else(|| DASH.into(), difference));
        }
        counts.push(row);
    }
    let headers =
        ["ζ", "Kind without roughness", "M(det)", "Mean M, “area”", "Lost, “area”", "Mean M, “paper”", "Lost, “paper”"];
    let caption =
        "Cycles M and cycles lost, M(det) − mean M, by damping ratio and upscaling; brackets are 95 % intervals";
    DataTable::new(caption, &headers, counts, "tables/cycles_over_damping.csv").without_empty_columns()
}

/// Formats a cell in the column of an upscaling.
type Cell = Box<dyn Fn(&EnsembleResult) -> String>;

/// Returns both upscalings with their names.
fn upscalings(vibration: &VibrationResult) -> [(&'static str, &EnsembleResult); 2] {
    [("area", &vibration.area), ("paper", &vibration.paper)]
}

/// Returns a table with a column for each upscaling behind a first one, without rows in which all values are undefined.
fn by_upscaling(
    vibration: &VibrationResult,
    caption: &str,
    first: &str,
    rows: impl Iterator<Item = (String, Cell)>,
) -> DataTable {
    let upscalings = upscalings(vibration);
    let names = upscalings.map(|(name, _)| format!("“{name}”"));
    let headers: Vec<&str> = std::iter::once(first).chain(names.iter().map(String::as_str)).collect();
    let rows = rows
        .map(|(title, cell)| std::iter::once(title).chain(upscalings.map(|(_, part)| cell(part))).collect())
        .filter(|row: &Vec<String>| row[1..].iter().any(|cell| cell != DASH));
    DataTable::new(caption, &headers, rows.collect(), RESULTS)
}

/// Returns the damping ratios at which the fraction of time in vibration falls below certain values.
fn crossings(vibration: &VibrationResult) -> DataTable {
    let mut fractions: Vec<f64> = upscalings(vibration)
        .iter()
        .flat_map(|(_, part)| part.crossings.iter().map(|crossing| crossing.share))
        .collect();
    fractions.sort_by(|a, b| b.total_cmp(a));
    fractions.dedup();
    let rows = fractions.into_iter().map(|fraction| -> (String, Cell) {
        let cell = move |part: &EnsembleResult| {
            let Some(found) = part.crossings.iter().find(|crossing| crossing.share == fraction) else {
                return DASH.into();
            };
            match (found.damping_ratio, found.damping_ratio_interval) {
                // Equal ends mean that all trajectories agree.
                (ratio, Some([low, high])) if low == high => plain(ratio, 5),
                (None, _) => found.reason.as_ref().map_or_else(|| DASH.into(), |reason| format!("none: {reason}")),
                (ratio, interval) => shown(Dimension::None, ratio, interval),
            }
        };
        (format!("{} %", significant(100.0 * fraction, 3)), Box::new(cell))
    });
    let caption = "Damping ratio at which the fraction of time in vibration falls below a value: the mean over the trajectories, which \
                   start in stick, over the second half of the duration; brackets are 95 % intervals";
    by_upscaling(vibration, caption, "Time in vibration", rows)
}

/// Returns the motion under roughness at the damping of the study.
fn motion(vibration: &VibrationResult) -> DataTable {
    fn cell(text: impl Fn(&MotionResult) -> String + 'static) -> Cell {
        Box::new(move |part| part.motion.as_ref().map_or_else(|| DASH.into(), &text))
    }
    fn kind(kind: KindResult) -> Cell {
        cell(move |motion| percent(motion.kind_shares.get(&kind).copied().filter(|fraction| *fraction > 0.0), 4))
    }
    let number = |value: Option<f64>, interval: Option<Pair>| shown(Dimension::None, value, interval);
    let rows: [(&str, Cell); 10] = [
        ("Period τ between detachments", cell(move |motion| number(motion.period_mean, None))),
        ("Jitter of the period (standard deviation)", cell(move |motion| number(motion.period_std, None))),
        (
            "Time in stick",
            cell(|motion| format!("{} %", with_error(100.0 * motion.stick_share, 100.0 * motion.stick_share_se))),
        ),
        ("Time in vibration", cell(|motion| percent(motion.share_in_cycle, 4))),
        ("of it in stick-slip", kind(KindResult::StickSlip)),
        ("of it overtaking the belt without stick", kind(KindResult::Overtaking)),
        ("of it slower than the belt throughout", kind(KindResult::SlipCycle)),
        (
            "Rate of leaving vibration, per τ in it",
            cell(move |motion| number(motion.exit_rate, motion.exit_rate_interval)),
        ),
        (
            "Rate of returning to it, per τ out of it",
            cell(move |motion| number(motion.entry_rate, motion.entry_rate_interval)),
        ),
        (
            "Trajectories that leave vibration",
            cell(|motion| {
                let [low, high] = motion.left_share_interval.map(|end| 100.0 * end);
                format!("{} {}", percent(motion.left_share, 4), show_range(low, high))
            }),
        ),
    ];
    let caption = format!(
        "The motion under fluctuating friction at ζ = {}; brackets are 95 % intervals, ± is a standard error",
        significant(vibration.damping_ratio, 4)
    );
    by_upscaling(vibration, &caption, "Property", rows.into_iter().map(|(title, cell)| (title.to_owned(), cell)))
}

/// Returns the moments of the distribution of points of the motion.
fn points(vibration: &VibrationResult, of: fn(&EnsembleResult) -> &PointsResult, caption: &str) -> DataTable {
    let rows = upscalings(vibration).map(|(name, part)| {
        let points = of(part);
        let number = |value| shown(Dimension::None, value, None);
        vec![
            format!("“{name}”"),
            number(Some(part.friction_std)),
            match (points.mean, points.std) {
                (Some(mean), Some(std)) => with_error(mean, std),
                (mean, _) => number(mean),
            },
            number(points.skewness),
            number(points.excess_kurtosis),
            plain(points.normality_p, 2),
        ]
    });
    let headers = ["Upscaling", "Std of μ", "X: mean ± std", "Skewness", "Excess kurtosis", "p (normality)"];
    DataTable::new(caption, &headers, rows.into(), RESULTS).without_empty_columns()
}

/// Formats the lost cycles with their interval.
pub(super) fn difference(entry: &DampingResult) -> String {
    shown(Dimension::None, entry.difference_mean, Some(entry.difference_interval))
}
