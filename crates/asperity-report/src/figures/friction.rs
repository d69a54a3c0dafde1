//! The friction coefficient against penetration, its law, its correlation and its course along the track.

mod uncertainty;

use super::{Plate, Stage, columns, csv};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen, Rect, draw};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit, significant};
use crate::palette::{BLACK, BLUE, GREEN, GREY, ORANGE, VERMILION, pen};
use crate::raster::{Kind, Raster};
use crate::{ReportError, Run, Table};

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    if let Some(table) = run.tables.get("friction_levels") {
        levels(table, run.tables.get("friction_uncertainty"), plates)?;
    }
    if let Some(table) = run.tables.get("friction_histogram") {
        histogram(table, plates)?;
    }
    if let Some(table) = run.tables.get("friction_acf") {
        autocorrelation(table, plates)?;
    }
    uncertainty::plate(run, plates)?;
    trace(run, plates)
}

/// The rows of a column in the order given.
fn ordered(values: &[f64], order: &[usize]) -> Vec<f64> {
    order.iter().map(|&row| values[row]).collect()
}

/// Penetrations and limits of a moment over the uncertain parameters of the surface.
fn parameter_band(table: &Table, column: &str) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let [penetration, low, high] =
        columns(table, ["penetration_m", &format!("{column}_low"), &format!("{column}_high")])?;
    let known = |row: &usize| penetration[*row].is_finite() && low[*row].is_finite() && high[*row].is_finite();
    let mut order: Vec<usize> = (0..penetration.len()).filter(known).collect();
    order.sort_by(|&a, &b| penetration[a].total_cmp(&penetration[b]));
    (order.len() > 1).then(|| (ordered(penetration, &order), ordered(low, &order), ordered(high, &order)))
}

/// `uncertain` are the moments over the uncertain parameters of the surface.
fn levels(table: &Table, uncertain: Option<&Table>, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "friction_levels";
    let Some([penetration]) = columns(table, ["penetration_m"]) else { return Ok(()) };
    // Levels may be listed in any order; a curve needs rising penetrations.
    let mut order: Vec<usize> = (0..penetration.len()).filter(|&row| penetration[row].is_finite()).collect();
    order.sort_by(|&a, &b| penetration[a].total_cmp(&penetration[b]));
    let x = ordered(penetration, &order);
    let Some(x_range) = range(&x) else { return Ok(()) };
    let rows = [
        ("mean", "Mean of μ", Some(("mean_low", "mean_high"))),
        ("std", "Std of μ", Some(("std_low", "std_high"))),
        ("coefficient_of_variation", "CoV of μ", None),
    ];
    let mut charts = Vec::new();
    for (column, label, limits) in rows {
        let Some(values) = table.column(column) else { continue };
        let y = ordered(values, &order);
        let band = limits.and_then(|(low, high)| columns(table, [low, high]));
        let band = band.map(|[low, high]| (ordered(low, &order), ordered(high, &order)));
        let over = uncertain.and_then(|table| parameter_band(table, column));
        let limits = band.iter().flat_map(|(low, high)| low.iter().chain(high));
        let limits = limits.chain(over.iter().flat_map(|(_, low, high)| low.iter().chain(high)));
        let Some((low, high)) = range(y.iter().chain(limits)) else { continue };
        let room = 0.30 * (high - low);
        let y_axis = Axis::padded(label, Unit::none(), (low, high + if charts.is_empty() { room } else { 0.0 }), 0.08);
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.04);
        let mut chart = Chart::new(x_axis, y_axis);
        if let Some((x, low, high)) = over {
            chart.add("95 % of the parameters", Mark::Band { x, low, high, colour: ORANGE });
        }
        if let Some((low, high)) = band {
            chart.add("95 % interval", Mark::Band { x: x.clone(), low, high, colour: BLUE });
        }
        let pen = Pen::new(BLUE, 1.8, Dash::Solid);
        chart.add("estimate", Mark::Points { x: x.clone(), y: y.clone(), pen });
        if charts.is_empty() {
            let percentiles = table.column("percentile").map(|values| ordered(values, &order));
            for (row, (&x, &y)) in x.iter().zip(&y).enumerate() {
                let percentile = percentiles.as_ref().map_or(f64::NAN, |values| values[row]);
                let text = if percentile.is_finite() {
                    format!("{} %", significant(percentile, 3))
                } else {
                    "at load".to_owned()
                };
                chart.add(None, Mark::Note { x, y, text });
            }
        }
        charts.push((165.0, chart));
    }
    let last = charts.len().saturating_sub(1);
    for (index, (height, chart)) in charts.iter_mut().enumerate() {
        chart.shows_x = index == last;
        *height += if index == last { 42.0 } else { 0.0 };
    }
    if charts.is_empty() {
        return Ok(());
    }
    let title = "Friction coefficient against penetration";
    let mut caption =
        "Mean, standard deviation and coefficient of variation of μ over the windows at each penetration \
                   (the paper’s Fig. 3a); shaded: 95 % intervals. The numbers at the points are the percentile of \
                   heights above the plane; “at load” is the level at the mean pressure of the machine."
            .to_owned();
    let mut sources = vec![csv(NAME)];
    if uncertain.is_some() {
        caption += " Orange: where the moments lie for 95 % of the uncertain parameters of the surface, by their own, fewer strips.";
        sources.push(csv("friction_uncertainty"));
    }
    let svg = figure(title, &caption, Layout::Column, &charts)?;
    plates.push(Plate { name: NAME, stage: Stage::Friction, title: title.into(), caption, sources, svg });
    Ok(())
}

fn histogram(table: &Table, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "friction_histogram";
    let Some([mu, density]) = columns(table, ["mu", "density"]) else { return Ok(()) };
    let beta = table.column("beta_density");
    let highest = density.iter().chain(beta.into_iter().flatten()).copied().filter(|v| v.is_finite());
    let highest = highest.fold(0.0, f64::max);
    let Some((low, high)) = range(mu).filter(|_| highest > 0.0) else { return Ok(()) };
    let margin = if mu.len() > 1 { 0.75 * (high - low) / (mu.len() - 1) as f64 } else { 0.0 };
    let x = Axis::linear("Friction coefficient μ", Unit::none(), (low - margin, high + margin));
    let mut chart = Chart::new(x, Axis::linear("Density", Unit::none(), (0.0, 1.06 * highest)));
    chart.add("windows", Mark::Bars { x: mu.to_vec(), y: density.to_vec(), colour: BLUE });
    if let Some(y) = beta {
        let pen = Pen::new(VERMILION, 2.0, Dash::Solid);
        chart.add("fitted Beta law", Mark::Line { x: mu.to_vec(), y: y.to_vec(), pen });
    }
    if let Some(y) = table.column("fitted_density") {
        let pen = Pen::new(BLACK, 1.5, Dash::Dashed);
        chart.add("law ranked first", Mark::Line { x: mu.to_vec(), y: y.to_vec(), pen });
    }
    let title = "Law of the friction coefficient";
    let caption =
        "Histogram of μ over all windows of the leading level, taken at its mean load, with the Beta law fitted \
                   by likelihood, its bounds included, and the law that Akaike’s criterion ranks first."
            .to_owned();
    let svg = figure(title, &caption, Layout::Column, &[(330.0, chart)])?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Friction, title: title.into(), caption, sources, svg });
    Ok(())
}

fn autocorrelation(table: &Table, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "friction_acf";
    let Some([lag]) = columns(table, ["lag_m"]) else { return Ok(()) };
    let curves = [
        ("acf", "windows", Pen::new(BLUE, 2.0, Dash::Solid)),
        ("fit", "exponential", Pen::new(VERMILION, 1.8, Dash::Dashed)),
        ("windowed_fit", "window and exponential", Pen::new(GREEN, 1.8, Dash::Alternating)),
        ("window_only", "window alone (triangle)", Pen::new(BLACK, 1.5, Dash::Dotted)),
    ];
    let Some((low, high)) = range(curves.iter().filter_map(|c| table.column(c.0)).flatten()) else { return Ok(()) };
    let Some((first, last)) = range(lag) else { return Ok(()) };
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let y = Axis::linear("Autocorrelation of μ", Unit::none(), ((low - 0.04).min(-0.05), high.max(1.0) + 0.04));
    let mut chart = Chart::new(x, y);
    chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
    for (name, label, pen) in curves {
        if let Some(y) = table.column(name) {
            chart.add(label, Mark::Line { x: lag.to_vec(), y: y.to_vec(), pen });
        }
    }
    let title = "Autocorrelation of the friction coefficient";
    let caption = "Autocorrelation of μ along the track at the leading level, taken at its mean load. A window that slides over uncorrelated friction gives the \
                   triangle by itself: only what lies above it is a property of the surface."
        .to_owned();
    let svg = figure(title, &caption, Layout::Column, &[(330.0, chart)])?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Friction, title: title.into(), caption, sources, svg });
    Ok(())
}

/// `mu_p5` is the level of the 5 % percentile, `mu_pressure_3e6_pa` and `mu_penetration_5e-7_m` those of a mean pressure and of a
/// depth; other columns keep their name.
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

fn trace(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "friction_trace";
    let strip = run.fields.get("pressure_strip").map(|field| Raster::new(field, Kind::Pressure)).transpose()?.flatten();
    let chart = run.tables.get(NAME).and_then(|table| trace_chart(table, strip.as_ref()));
    if strip.is_none() && chart.is_none() {
        return Ok(());
    }
    let title = "Pressure along the track and the friction coefficient of a sliding window";
    let mut sources = Vec::new();
    let mut caption = String::new();
    let mut stretch = None;
    if let Some(raster) = &strip {
        let ratio = (STRIP_HEIGHT / STRIP_WIDTH) / raster.aspect();
        stretch = Some(ratio);
        caption =
            format!("Top: pressure on the strip (y stretched {} times; white: no contact).", significant(ratio, 2));
        sources.push("fields/pressure_strip".to_owned());
    }
    if chart.is_some() {
        let place = if strip.is_some() { " Below: " } else { "" };
        caption = format!(
            "{caption}{place}μ of the window centred at each position, by percentile of heights above the plane."
        );
        sources.push(csv(NAME));
    }
    let svg = match (strip, chart) {
        (None, Some(chart)) => figure(title, &caption, Layout::Column, &[(330.0, chart)])?,
        (Some(raster), chart) => strip_figure(title, &caption, &raster, stretch, chart)?,
        (None, None) => return Ok(()),
    };
    plates.push(Plate { name: NAME, stage: Stage::Friction, title: title.into(), caption, sources, svg });
    Ok(())
}

const STRIP_WIDTH: f64 = 460.0;
const STRIP_HEIGHT: f64 = 96.0;

fn trace_chart(table: &Table, strip: Option<&Raster>) -> Option<Chart> {
    let [position] = columns(table, ["position_m"])?;
    let levels: Vec<(&str, &[f64])> = table
        .columns
        .iter()
        .filter(|(name, _)| name.starts_with("mu"))
        .filter_map(|(name, _)| Some((name.as_str(), table.column(name)?)))
        .collect();
    let y = range(levels.iter().flat_map(|(_, values)| values.iter()))?;
    let (mut first, mut last) = range(position)?;
    if let Some(strip) = strip {
        (first, last) = (first.min(0.0), last.max(strip.width_m()));
    }
    let x = Axis::linear("Position along the track", Dimension::Length.unit(last), (first, last));
    let mut chart = Chart::new(x, Axis::padded("Friction coefficient μ", Unit::none(), y, 0.06));
    for (index, (name, values)) in levels.iter().enumerate() {
        let pen = Pen { width: 1.5, ..pen(index) };
        chart.add_named(level_name(name), Mark::Line { x: position.to_vec(), y: values.to_vec(), pen });
    }
    Some(chart)
}

/// The strip above the chart, on the same positions.
fn strip_figure(
    title: &str,
    caption: &str,
    raster: &Raster,
    stretch: Option<f64>,
    chart: Option<Chart>,
) -> Result<String, ReportError> {
    let below = if chart.is_some() { 320.0 } else { 50.0 };
    let plot = Rect::new(72.0, 30.0, STRIP_WIDTH, STRIP_HEIGHT);
    let alone = chart.is_none();
    draw((640.0, plot.bottom + below), title, caption, |canvas| {
        raster.legend(canvas, (plot.left, 14.0))?;
        if let Some(ratio) = stretch {
            let note = format!("y stretched {} ×", significant(ratio, 2));
            canvas.text((plot.right, 14.0), &note, 12.0, crate::canvas::Align::End)?;
        }
        raster.draw(canvas, plot, alone)?;
        raster.colour_bar(canvas, Rect::new(plot.right + 16.0, plot.top, 14.0, plot.height()))?;
        match chart {
            // The chart's own margins put its frame below the strip's.
            Some(chart) => {
                let outer =
                    Rect { left: 0.0, top: plot.bottom + 8.0, right: plot.right + 20.0, bottom: plot.bottom + below };
                chart.draw_with_legend(canvas, outer)
            }
            None => Ok(()),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_the_trace_are_named_by_their_percentile() {
        assert_eq!(level_name("mu_p5"), "5 %");
        assert_eq!(level_name("mu_p12_5"), "12.5 %");
        assert_eq!(level_name("mu_pressure_3e6_pa"), format!("at {}", Dimension::Pressure.show(3e6)));
        assert_eq!(level_name("mu_penetration_5e-7_m"), format!("{} deep", Dimension::Length.show(5e-7)));
        assert_eq!(level_name("mu_mean_pressure"), "mean pressure");
        assert_eq!(level_name("mu"), "mu");
    }

    #[test]
    fn levels_out_of_order_are_sorted_by_penetration() {
        assert_eq!(ordered(&[3.0, 1.0, 2.0], &[1, 2, 0]), [1.0, 2.0, 3.0]);
    }
}
