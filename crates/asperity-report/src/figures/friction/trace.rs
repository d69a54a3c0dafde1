//! Friction along the track, below the pressure on the strip.

use asperity_results::Table;

use crate::figures::{CaptionedFigure, columns};
use crate::format::{Dimension, Unit, significant};
use crate::plot::{Axis, Chart, Kind, Pen, Raster, pen, range};
use crate::{ReportError, Run};

const NAME: &str = "friction_trace";
const TITLE: &str = "Pressure along the track and the friction coefficient of a sliding window";
/// Height of the map of the strip in pixels.
const STRIP_HEIGHT: f64 = 112.0;
/// Largest number of levels in the figure.
const MAX_LEVELS: usize = 4;

/// Returns the name of a level from its column: `mu_p5` is the 5 % percentile, `mu_pressure_3e6_pa` a mean pressure,
/// `mu_penetration_5e-7_m` a depth.
fn level_name(column: &str) -> String {
    let name = column.strip_prefix("mu_").unwrap_or(column);
    let stated = |prefix: &str, unit: &str| name.strip_prefix(prefix)?.strip_suffix(unit)?.parse::<f64>().ok();
    if let Some(pascal) = stated("pressure_", "_pa") {
        return format!("at {}", Dimension::Pressure.show(pascal));
    }
    if let Some(metre) = stated("penetration_", "_m") {
        return format!("{} deep", Dimension::Length.show(metre));
    }
    match name.strip_prefix('p').and_then(|percent| percent.replace('_', ".").parse::<f64>().ok()) {
        Some(percent) => format!("{} %", significant(percent, 3)),
        None if name == "load" => "at load".into(),
        None => name.replace('_', " "),
    }
}

pub(super) fn figure(run: &Run) -> Result<Option<CaptionedFigure>, ReportError> {
    let strip = run.fields.get("pressure_strip").map(|field| Raster::new(field, Kind::Pressure)).transpose()?.flatten();
    let chart = run.tables.get(NAME).and_then(|table| trace_chart(table, strip.as_ref()));
    let trace = "μ = F/N of the window centred at each position, by percentile of heights above the plane; at most four levels.";
    Ok(match (&strip, chart) {
        (Some(strip), chart) => with_strip(strip, chart, trace),
        (None, chart) => CaptionedFigure::from_charts(NAME, TITLE, trace, 1, chart.as_slice(), &[NAME]),
    })
}

/// Selects at most [`MAX_LEVELS`] columns of friction, evenly over all.
fn levels(table: &Table) -> Vec<(&str, &[f64])> {
    let named = table.columns().iter().filter(|(name, _)| name.starts_with("mu"));
    let all: Vec<(&str, &[f64])> =
        named.filter_map(|(name, _)| Some((name.as_str(), table.defined_column(name)?))).collect();
    let shown = all.len().min(MAX_LEVELS);
    (0..shown).map(|place| all[place * (all.len() - 1) / (shown - 1).max(1)]).collect()
}

fn trace_chart(table: &Table, strip: Option<&Raster>) -> Option<Chart> {
    let [position] = columns(table, ["position_m"])?;
    let levels = levels(table);
    let y = range(levels.iter().flat_map(|(_, values)| values.iter()))?;
    let mut order: Vec<usize> = (0..position.len()).collect();
    let mut position = position.to_vec();
    let (mut first, mut last) = range(&position)?;
    if let Some(width_m) = strip.map(Raster::width_m) {
        // Windows across the end of a periodic strip are drawn at its beginning.
        position.iter_mut().filter(|at| **at > width_m).for_each(|at| *at -= width_m);
        order.sort_by(|&a, &b| position[a].total_cmp(&position[b]));
        (first, last) = (first.min(0.0), width_m);
    }
    let x = Axis::linear("Position along the track", Dimension::Length.unit(last), (first, last));
    let mut chart = Chart::new(x, Axis::padded("Friction coefficient μ", Unit::none(), y, 0.06));
    let ordered = |values: &[f64]| order.iter().map(|&row| values[row]).collect::<Vec<f64>>();
    for (index, (name, values)) in levels.iter().enumerate() {
        chart.line(level_name(name), &ordered(&position), &ordered(values), Pen { width: 1.5, ..pen(index) });
    }
    Some(chart)
}

/// Draws the strip above the chart, aligned with its positions.
fn with_strip(strip: &Raster, chart: Option<Chart>, trace: &str) -> Option<CaptionedFigure> {
    let mut map = strip.chart().with_height(STRIP_HEIGHT);
    // The strip is stretched across, so that its width can be seen.
    map.backdrop.iter_mut().for_each(|backdrop| backdrop.aspect = None);
    map.shows_x = chart.is_none();
    let below = chart.as_ref().map_or(String::new(), |_| format!(" Below: {trace}"));
    let caption =
        format!("Top: pressure on the strip at the operating point, stretched in y (no colour: no contact).{below}");
    let tables: &[&str] = if chart.is_some() { &[NAME] } else { &[] };
    let charts: Vec<Chart> = std::iter::once(map).chain(chart).collect();
    let drawn = CaptionedFigure::from_charts(NAME, TITLE, caption, 1, &charts, &[])?;
    Some(drawn.with_colours(strip.colour_bar().clone()).with_fields(&["pressure_strip"]).with_tables(tables))
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;
    use asperity_results::Field;

    #[test]
    fn columns_of_the_trace_are_named_by_their_percentile() {
        assert_eq!(level_name("mu_p5"), "5 %");
        assert_eq!(level_name("mu_p12_5"), "12.5 %");
        assert_eq!(level_name("mu_pressure_3e6_pa"), format!("at {}", Dimension::Pressure.show(3e6)));
        assert_eq!(level_name("mu_penetration_5e-7_m"), format!("{} deep", Dimension::Length.show(5e-7)));
        assert_eq!(level_name("mu_mean_pressure"), "mean pressure");
        assert_eq!(level_name("mu"), "mu");
    }
    fn row(name: &str, values: &[f64]) -> (String, Vec<f64>) {
        (name.to_owned(), values.to_vec())
    }

    #[test]
    fn windows_across_the_end_of_a_periodic_strip_are_drawn_at_its_beginning() {
        let field = Field::new([1e-3, 1e-3], "m", Array2::from_elem((1, 4), 1.0));
        let strip = Raster::new(&field, Kind::Pressure).unwrap().unwrap();
        let table =
            Table::new([row("position_m", &[1.5e-3, 2.5e-3, 3.5e-3, 4.5e-3]), row("mu", &[1.0, 2.0, 3.0, 4.0])]);
        let chart = trace_chart(&table, Some(&strip)).unwrap();
        let crate::plot::Mark::Line { x, y, .. } = &chart.series[0].mark else { panic!("a curve") };
        assert!(x.iter().zip([0.5e-3, 1.5e-3, 2.5e-3, 3.5e-3]).all(|(x, wanted)| (x - wanted).abs() < 1e-12), "{x:?}");
        assert_eq!(*y, [4.0, 1.0, 2.0, 3.0]);
        assert_eq!(chart.x.ends(), (0.0, 4e-3));
    }

    #[test]
    fn the_first_the_last_and_some_levels_between_are_drawn() {
        let table = |count: usize| Table::new((0..count).map(|i| row(&format!("mu_p{i}"), &[0.2])));
        let named = |count| levels(&table(count)).into_iter().map(|(name, _)| name.to_owned()).collect::<Vec<_>>();
        assert_eq!(named(8), ["mu_p0", "mu_p2", "mu_p4", "mu_p7"]);
        assert_eq!((named(2), named(1).len(), named(0).len()), (vec!["mu_p0".into(), "mu_p1".into()], 1, 0));
    }
}
