//! The laws of the pressures of all cells: contact probability, mean, quantiles, and the error of an expansion.

use asperity_results::{GlobalExpansionEntry, HomogeneityEntry, MapsEntry};

use crate::canvas::{Align, LABEL, Rect, draw};
use crate::figures::{Plate, Stage, map};
use crate::format::{Dimension, significant};
use crate::raster::{Kind, Raster};
use crate::{Field, ReportError, Run};

/// Mean and quantiles, and how they are called.
const LAWS: [(&str, &str); 4] = [
    ("pressure_mean", "Mean"),
    ("pressure_quantile_10", "10 % quantile"),
    ("pressure_quantile_50", "Median"),
    ("pressure_quantile_90", "90 % quantile"),
];
/// Distances in pixels: of the first panel from the left edge, between panels, and room above each for its name.
const LEFT: f64 = 92.0;
const BETWEEN: f64 = 36.0;
const NAME: f64 = 24.0;

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let caption = format!("Share of the realisations in which each cell is in contact.{}", contact_words(run));
    let stage = Stage::Pressure;
    let title = "Contact probability of every cell";
    plates.extend(map(run, ("contact_probability", stage), Kind::Probability, title, &caption)?);
    plates.extend(laws(run)?);
    let title = "What leading modes say of every cell";
    plates.extend(map(run, ("expansion_error", stage), Kind::Error, title, &expansion_words(run))?);
    Ok(())
}

/// What the maps rest on.
fn maps_of(run: &Run) -> Option<&MapsEntry> {
    run.results.pressure.as_ref()?.maps.as_ref()
}

/// How many samples, how well the probabilities are known, and whether the cells differ.
fn contact_words(run: &Run) -> String {
    let mut words = String::new();
    if let Some(&MapsEntry { samples, contact_probability_largest_half_width: Some(half), .. }) = maps_of(run) {
        let half = significant(half, 2);
        words += &format!(
            " {samples} realisations: each value is known to ± {half} or better, with 95 %; neighbouring \
             cells share their errors."
        );
    }
    let found = run.results.pressure.as_ref().and_then(|pressure| pressure.homogeneity.as_ref());
    if let Some(&HomogeneityEntry { p_value: Some(p_value), cells: Some(cells), plausible, .. }) = found {
        let p_value = if p_value < 1e-3 { "below 0.001".to_owned() } else { format!("= {}", significant(p_value, 2)) };
        words += &match plausible {
            Some(true) => format!(" {cells} cells apart do not differ in law more than by chance (p {p_value})."),
            _ => format!(" {cells} cells apart differ in law by more than chance (p {p_value})."),
        };
    }
    words
}

/// What was expanded in what, and what its errors mean.
fn expansion_words(run: &Run) -> String {
    let found = run.results.pressure.as_ref().and_then(|pressure| pressure.global_expansion.as_ref());
    let of = match found {
        Some(&GlobalExpansionEntry {
            variables: Some(variables),
            degree: Some(degree),
            leave_one_out_error: Some(mean),
            ..
        }) => {
            format!(
                " of total degree {degree} in the {variables} leading variables, {} on average",
                significant(mean, 3)
            )
        }
        _ => " in the leading variables".to_owned(),
    };
    format!(
        "Leave-one-out error of a chaos expansion of the pressure of each cell{of}: the share of the variance that these \
         variables leave unsaid. From 1 on the expansion predicts no better than the mean."
    )
}

/// Mean and quantiles side by side on one colour scale; those that are the same everywhere are left to the caption.
fn laws(run: &Run) -> Result<Option<Plate>, ReportError> {
    let present = |field: &&Field| field.values.iter().any(|value| value.is_finite());
    let all: Vec<(&str, &str, &Field)> =
        LAWS.iter().filter_map(|(name, title)| Some((*name, *title, run.fields.get(*name).filter(present)?))).collect();
    let (varied, flat): (Vec<_>, Vec<_>) = all.iter().copied().partition(|(_, _, field)| the_same(field).is_none());
    let (panels, unseen) = if varied.is_empty() { (all.clone(), Vec::new()) } else { (varied, flat) };
    let rasters = Raster::on_one_scale(panels.iter().map(|(_, _, field)| *field), Kind::Pressure)?;
    let Some(first) = rasters.first() else { return Ok(None) };
    let columns = panels.len().min(2);
    let rows = panels.len().div_ceil(columns);
    let room = (430.0 - BETWEEN * (columns as f64 - 1.0)) / columns as f64;
    let tallest = 560.0 / rows as f64;
    let width = room.min(tallest / first.aspect()).max(40.0);
    let height = (width * first.aspect()).clamp(40.0, tallest);
    let left = LEFT + 0.5 * (room - width) * columns as f64;
    let top = |row: usize| 26.0 + NAME + (height + NAME + 8.0) * row as f64;
    let title = "Mean and quantiles of the pressure of every cell";
    let caption = caption(run, &unseen);
    let bottom = top(rows - 1) + height;
    let svg = draw((640.0, bottom + 54.0), title, &caption, |canvas| {
        if panels.iter().any(|(_, _, field)| field.values.contains(&0.0)) {
            first.legend(canvas, (left, 14.0))?;
        }
        for (number, ((_, name, _), raster)) in panels.iter().zip(&rasters).enumerate() {
            let (row, column) = (number / columns, number % columns);
            let plot = Rect::new(left + (width + BETWEEN) * column as f64, top(row), width, height);
            raster.draw_image(canvas, plot)?;
            // The lowest panel of a column has the axis.
            if number + columns >= panels.len() {
                raster.draw_x_axis(canvas, plot)?;
            }
            if column == 0 {
                let largest = raster.width_m().max(raster.width_m() * raster.aspect());
                raster.draw_y_axis(canvas, plot, Dimension::Length.unit(largest))?;
            }
            canvas.text((plot.left, plot.top - 12.0), name, LABEL, Align::Start)?;
        }
        let right = left + width * columns as f64 + BETWEEN * (columns as f64 - 1.0);
        first.colour_bar(canvas, Rect::new(right + 18.0, top(0), 16.0, (bottom - top(0)).max(100.0)))
    })?;
    let sources = all.iter().map(|(name, _, _)| format!("fields/{name}")).collect();
    Ok(Some(Plate { name: "pressure_quantiles", stage: Stage::Pressure, title: title.into(), caption, sources, svg }))
}

fn caption(run: &Run, unseen: &[(&str, &str, &Field)]) -> String {
    let mut words =
        "Mean and quantiles over the realisations, zeros out of contact counted, on one colour scale.".to_owned();
    if let Some(&MapsEntry { samples, kept_samples: kept, .. }) = maps_of(run) {
        words += &match samples == kept {
            true => format!(" {samples} realisations."),
            false => format!(" Means of {samples} realisations, quantiles of {kept} of them."),
        };
    }
    if let Some(se) = maps_of(run).and_then(|maps| maps.mean_largest_se_pa) {
        words += &format!(" Standard errors of the means are {} at most.", Dimension::Pressure.show_short(se));
    }
    let of = |(_, title, field): &(&str, &str, &Field)| {
        let value = the_same(field).map_or_else(|| "–".into(), |value| Dimension::Pressure.show_short(value));
        format!("the {} ({value})", title.to_lowercase())
    };
    let names: Vec<String> = unseen.iter().map(of).collect();
    match names.as_slice() {
        [] => words,
        [one] => words + &format!(" The same in every cell, and not shown: {one}."),
        [rest @ .., last] => {
            words + &format!(" The same in every cell, and not shown: {} and {last}.", rest.join(", "))
        }
    }
}

/// The value of a field that has the same everywhere.
fn the_same(field: &Field) -> Option<f64> {
    let first = field.values.first().copied()?;
    field.values.iter().all(|value| *value == first).then_some(first)
}
