//! The table of how well each headline number is known, and what its error comes from.

use asperity_results::{CutoffResult, FrictionResult, MeasuredSurface, Pair, PressureResult, VibrationResult};

use crate::Run;
use crate::cells::shown;
use crate::format::{Dimension, significant};
use crate::page::data_table::DataTable;
use crate::page::parameters;
use crate::verdict::percent;

/// Name, value with its interval, and the origin of the error.
type Row = [String; 3];

/// Returns the table; empty without results.
pub(super) fn table(run: &Run) -> DataTable {
    let results = &run.results;
    let rows = results.surface.iter().flat_map(|surface| of_surface(&surface.measured));
    let rows = rows.chain(results.pressure.iter().flat_map(of_pressure));
    let rows = rows.chain(results.friction.iter().flat_map(of_friction));
    let rows = rows.chain(results.vibration.iter().flat_map(of_vibration)).chain(of_verdict(run));
    let headers = ["Result", "Value, 95 % interval", "What its error comes from"];
    DataTable::new("", &headers, rows.map(Vec::from).collect())
}

fn row(name: &str, value: String, why: impl Into<String>) -> Row {
    [name.to_owned(), value, why.into()]
}

fn of_surface(measured: &MeasuredSurface) -> Vec<Row> {
    let why = match measured {
        MeasuredSurface::Stated {} => return Vec::new(),
        MeasuredSurface::Scan(_) => {
            "the field of one scan holds few correlation lengths; how parts differ is not known from one scan"
                .to_owned()
        }
        MeasuredSurface::Part(part) => format!("differences between {} scans, and the field of each", part.scan_count),
    };
    let wanted = [("rms height Sq", "Sq_m"), ("correlation length along x", "correlation_length_x_m")];
    let known = |(name, key): (&str, &str)| Some(row(name, parameters::value(measured, key)?, why.clone()));
    wanted.into_iter().filter_map(known).collect()
}

fn of_pressure(pressure: &PressureResult) -> Vec<Row> {
    let why = pressure.origin();
    let probability = shown(Dimension::None, pressure.contact_probability, pressure.contact_probability_interval);
    let mean = shown(Dimension::Pressure, pressure.mean_pa, pressure.mean_interval);
    vec![
        row("contact probability at a point of a patch, estimated", probability, why.clone()),
        row("mean pressure at a point of a patch, estimated", mean, why),
    ]
}

fn of_friction(friction: &FrictionResult) -> Vec<Row> {
    let point = &friction.operating_point;
    let strips = format!("random strips: {}", friction.realisations);
    let of_scan = point.mean_of_scan.map(|mean| {
        row("μ of the scan itself", significant(mean, 4), "pressed like the strips, with all waves down to its pixels")
    });
    let whole = if of_scan.is_some() {
        format!("{strips}; their pitch; the scan itself beside them; one limited scan")
    } else {
        format!("{strips}; their pitch")
    };
    let mut rows = vec![row(
        "friction coefficient μ, whole error",
        shown(Dimension::None, point.mean, point.mean_interval),
        whole,
    )];
    rows.extend(of_scan);
    rows.extend([
        row(
            "the same, error of sampling strips alone",
            shown(Dimension::None, point.mean, point.mean_sampling_interval),
            strips.clone(),
        ),
        row("its standard deviation between windows", shown(Dimension::None, point.std, point.std_interval), strips),
    ]);
    rows.extend(friction.cutoff.as_ref().and_then(|cutoff| of_pitch(cutoff, point.grid_error)));
    let mean = friction.uncertainty.as_ref().and_then(|found| {
        let level = friction.levels.iter().position(|level| level.leading).unwrap_or(0);
        found.levels.get(level)?.at_mean_load.iter().find(|response| response.name == "mean")
    });
    rows.extend(mean.and_then(|mean| {
        let why = "the uncertainty of the surface statistics of one scan; see the sensitivity of friction";
        Some(row("μ over surfaces that agree with the scan", shown(Dimension::None, mean.value?, mean.interval), why))
    }));
    rows
}

fn of_pitch(cutoff: &CutoffResult, grid_error: Option<f64>) -> Option<Row> {
    let finest = cutoff.finer_pitches.last()?;
    let why = format!(
        "what its extrapolation from points every {} to {} leaves open",
        Dimension::Length.show(cutoff.pitch_m),
        Dimension::Length.show(finest.pitch_m)
    );
    Some(row("error of μ by the pitch", significant(grid_error?, 2), why))
}

fn of_vibration(vibration: &VibrationResult) -> Vec<Row> {
    let nearest = |a: &&asperity_results::DampingResult, b: &&asperity_results::DampingResult| {
        let away = |entry: &asperity_results::DampingResult| (entry.damping_ratio - vibration.damping_ratio).abs();
        away(a).total_cmp(&away(b))
    };
    let lost = vibration.area.damping.iter().min_by(nearest).map(|entry| {
        let interval: Option<Pair> = Some(entry.difference_interval);
        row("cycles lost by roughness", shown(Dimension::None, entry.difference_mean, interval), "random trajectories")
    });
    let limit = vibration.limit_damping_ratio.map(|limit| {
        let why = "no sampling: it follows from friction and the machine, and is as good as these";
        row("limit of the damping ratio", significant(limit, 4), why)
    });
    limit.into_iter().chain(lost).collect()
}

fn of_verdict(run: &Run) -> Vec<Row> {
    let Some(verdict) = run.results.verdict.as_ref().filter(|verdict| !crate::verdict::is_exact(verdict)) else {
        return Vec::new();
    };
    let [low, high] = verdict.probability_interval;
    let computed = format!("{} [{}, {}]", percent(verdict.probability), percent(low), percent(high));
    let sampled = format!("machines that were computed: {}", verdict.evaluations);
    let name = format!("probability of {}", crate::verdict::vibration(verdict));
    let mut rows = vec![row(&name, computed, sampled.clone())];
    if verdict.friction_fluctuates {
        let [low, high] = verdict.expected_vibration_share_interval;
        let share = format!("{} [{}, {}]", percent(verdict.expected_vibration_share), percent(low), percent(high));
        rows.insert(0, row("fraction of the time in vibration", share, sampled));
    }
    rows.extend(verdict.probability_range.map(|[low, high]| {
        let range = format!("{} to {} (5–95 %)", percent(low), percent(high));
        row("the same over the unknown values", range, "values that are stated as unknown; measuring them narrows it")
    }));
    rows
}
