//! The tables of the vibration stage.

use asperity_results::{DampingResult, EnsembleResult, KindResult, MotionResult, Pair, PointsResult, VibrationResult};

use super::DataTable;
use super::cells::{DASH, percent, plain, shown, yes_or_no};
use crate::format::{Dimension, show_range, significant, with_error};

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

/// Returns the properties without fluctuation, in the order of the names.
fn scalars(vibration: &VibrationResult) -> DataTable {
    let cycle = &vibration.cycle;
    let number = |value: Option<f64>| plain(value, 5);
    let in_unit = |dimension: Dimension, value: Option<f64>| shown(dimension, value, None);
    let mut rows = vec![
        ("belt velocity", number(Some(vibration.belt_velocity))),
        ("correlation length", number(Some(vibration.correlation_length))),
        ("critical damping ratio", number(vibration.critical_damping_ratio)),
        ("cycle · damping ratio", number(Some(cycle.damping_ratio))),
        ("cycle · displacement max", number(cycle.displacement_max)),
        ("cycle · displacement min", number(cycle.displacement_min)),
        ("cycle · limit cycle", yes_or_no(cycle.limit_cycle).into()),
        ("cycle · period", number(cycle.period)),
        ("cycle · reattachment displacement", number(cycle.reattachment_displacement)),
        ("cycle · slip duration", number(cycle.slip_duration)),
        ("cycle · velocity min", number(cycle.velocity_min)),
        ("damping ratio", number(Some(vibration.damping_ratio))),
        ("friction correlation length", in_unit(Dimension::Length, Some(vibration.friction_correlation_length_m))),
        ("Hopf damping ratio", number(vibration.hopf_damping_ratio)),
        ("kick", in_unit(Dimension::Velocity, vibration.kick_m_per_s)),
        ("kind", vibration.kind.name().into()),
        ("level mean pressure", in_unit(Dimension::Pressure, vibration.level_mean_pressure_pa)),
        ("level percentile", number(vibration.level_percentile)),
        ("limit damping ratio", number(vibration.limit_damping_ratio)),
    ]
    .into_iter()
    .map(|(name, value)| vec![name.to_owned(), value])
    .collect::<Vec<_>>();
    match &vibration.marginal {
        None => rows.push(vec!["marginal".into(), DASH.into()]),
        Some(fit) => {
            rows.push(vec!["marginal · name".into(), fit.name.clone()]);
            let parameters = fit.parameters.iter();
            rows.extend(parameters.map(|(name, v)| vec![format!("marginal · parameters · {name}"), plain(*v, 5)]));
        }
    }
    rows.extend([
        vec!["static friction".into(), plain(vibration.static_friction, 5)],
        vec!["steady sliding unstable".into(), yes_or_no(vibration.steady_sliding_unstable).into()],
        vec!["upscaling".into(), vibration.upscaling.clone()],
        vec!["variance reduction".into(), plain(vibration.variance_reduction, 5)],
    ]);
    DataTable::new("Without roughness", &["Property", "Value"], rows, "results.json")
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
        let mut row = vec![damping, entry.kind.name().replace('_', "-"), deterministic];
        for (_, part) in upscalings(vibration) {
            let found = part.damping.iter().find(|other| other.damping_ratio == entry.damping_ratio);
            row.push(found.map_or_else(|| DASH.into(), |found| shown(Dimension::None, found.cycles_mean, None)));
            row.push(found.map_or_else(|| DASH.into(), difference));
        }
        counts.push(row);
    }
    let headers = ["ζ", "Deterministic", "M deterministic", "M, “area”", "lost, “area”", "M, “paper”", "lost, “paper”"];
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
    DataTable::new(caption, &headers, rows.collect(), "results.json")
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
        ("in stick-slip", kind(KindResult::StickSlip)),
        ("overtaking the belt without stick", kind(KindResult::Overtaking)),
        ("slower than the belt throughout", kind(KindResult::SlipCycle)),
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
            number(points.normality_p),
        ]
    });
    let headers = ["Upscaling", "Std of μ", "X: mean ± std", "Skewness", "Excess kurtosis", "p (normality)"];
    DataTable::new(caption, &headers, rows.into(), "results.json").without_empty_columns()
}

/// Formats the lost cycles with their interval.
pub(super) fn difference(entry: &DampingResult) -> String {
    shown(Dimension::None, entry.difference_mean, Some(entry.difference_interval))
}
