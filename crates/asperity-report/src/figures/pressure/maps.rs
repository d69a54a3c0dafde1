//! Distributions of the pressure at all cells: contact probability, mean, quantiles, and the error of an expansion.

use asperity_results::{Field, GlobalExpansionEntry, HomogeneityEntry, MapsEntry, PressureResult};

use crate::figures::{CaptionedFigure, field_map, raster_panels};
use crate::format::{Dimension, significant};
use crate::plot::{Kind, Raster};
use crate::{ReportError, Run};

/// Mean and quantiles with their titles.
const STATISTICS: [(&str, &str); 4] = [
    ("pressure_mean", "Mean"),
    ("pressure_quantile_10", "10 % quantile"),
    ("pressure_quantile_50", "Median"),
    ("pressure_quantile_90", "90 % quantile"),
];
/// A field with its name and its title.
type Panel<'a> = (&'static str, &'static str, &'a Field);

pub(super) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    let pressure = run.results.pressure.as_ref();
    let caption =
        format!("Fraction of the realisations in which each cell is in contact.{}", contact_sentences(pressure));
    let title = "Contact probability of every cell";
    let contact = field_map(run, "contact_probability", Kind::Probability, title, &caption)?;
    let title = "Variance of every cell that leading modes do not explain";
    let expansion = field_map(run, "expansion_error", Kind::Error, title, &expansion_caption(pressure))?;
    Ok([contact, statistics(run)?, expansion].into_iter().flatten().collect())
}

/// Describes the sample size, the accuracy of the probabilities, and the homogeneity of the cells.
fn contact_sentences(pressure: Option<&PressureResult>) -> String {
    let mut text = String::new();
    let maps = pressure.and_then(|pressure| pressure.maps.as_ref());
    if let Some(&MapsEntry { samples, contact_probability_largest_half_width: Some(half), .. }) = maps {
        let half = significant(half, 2);
        text += &format!(
            " {samples} realisations: the 95 % interval of each value is ± {half} or narrower; errors of neighbouring cells are \
             correlated."
        );
    }
    let found = pressure.and_then(|pressure| pressure.homogeneity.as_ref());
    if let Some(&HomogeneityEntry { p_value: Some(p_value), cells: Some(cells), plausible, .. }) = found {
        let p_value = if p_value < 1e-3 { "below 0.001".to_owned() } else { format!("= {}", significant(p_value, 2)) };
        text += &match plausible {
            Some(true) => {
                format!(" The distributions of {cells} distant cells do not differ beyond chance (p {p_value}).")
            }
            _ => format!(" The distributions of {cells} distant cells differ beyond chance (p {p_value})."),
        };
    }
    text
}

/// Describes the expansion and its errors.
fn expansion_caption(pressure: Option<&PressureResult>) -> String {
    let of = match pressure.and_then(|pressure| pressure.global_expansion.as_ref()) {
        Some(&GlobalExpansionEntry {
            variables: Some(variables),
            degree: Some(degree),
            leave_one_out_error: Some(mean),
            ..
        }) => format!(
            " of total degree {degree} in the {variables} leading variables, {} on average",
            significant(mean, 3)
        ),
        _ => " in the leading variables".to_owned(),
    };
    format!(
        "Leave-one-out error of a chaos expansion of the pressure of each cell{of}: the fraction of the variance that these \
         variables do not explain. From 1 on the expansion predicts no better than the mean."
    )
}

/// Draws mean and quantiles side by side on one colour scale. Constant fields are in the caption only.
fn statistics(run: &Run) -> Result<Option<CaptionedFigure>, ReportError> {
    let defined = |field: &&Field| field.values().iter().any(|value| value.is_finite());
    let all: Vec<Panel<'_>> = STATISTICS
        .iter()
        .filter_map(|(name, title)| Some((*name, *title, run.fields.get(*name).filter(defined)?)))
        .collect();
    let (varied, flat): (Vec<_>, Vec<_>) = all.iter().copied().partition(|(_, _, field)| constant(field).is_none());
    let (panels, hidden) = if varied.is_empty() { (all.clone(), Vec::new()) } else { (varied, flat) };
    let rasters = Raster::with_common_scale(panels.iter().map(|(_, _, field)| *field), Kind::Pressure)?;
    let panels: Vec<(&str, &Raster)> = panels.iter().map(|(_, title, _)| *title).zip(&rasters).collect();
    let columns = panels.len().clamp(1, 2);
    let title = "Mean and quantiles of the pressure of every cell";
    let drawn = raster_panels("pressure_quantiles", title, &caption(run, &hidden), &panels, columns, 560.0);
    let fields: Vec<&str> = all.iter().map(|(name, _, _)| *name).collect();
    Ok(drawn.map(|figure| figure.with_fields(&fields)))
}

fn caption(run: &Run, hidden: &[Panel<'_>]) -> String {
    let mut text =
        "Mean and quantiles over the realisations, zeros out of contact included, on one colour scale.".to_owned();
    if let Some(maps) = run.results.pressure.as_ref().and_then(|pressure| pressure.maps.as_ref()) {
        let &MapsEntry { samples, kept_samples: kept, .. } = maps;
        text += &match samples == kept {
            true => format!(" {samples} realisations."),
            false => format!(" Means of {samples} realisations, quantiles of {kept} of them."),
        };
        if let Some(se) = maps.mean_largest_se_pa {
            text += &format!(" Standard errors of the means are {} at most.", Dimension::Pressure.show_short(se));
        }
    }
    let of = |(_, title, field): &Panel<'_>| {
        let value = constant(field).map_or_else(|| "–".into(), |value| Dimension::Pressure.show_short(value));
        format!("the {} ({value})", title.to_lowercase())
    };
    let names: Vec<String> = hidden.iter().map(of).collect();
    if let [rest @ .., last] = names.as_slice() {
        let and = if rest.is_empty() { "" } else { " and " };
        text += &format!(" Not shown because it is equal in all cells: {}{and}{last}.", rest.join(", "));
    }
    text
}

/// Returns the value of a constant field.
fn constant(field: &Field) -> Option<f64> {
    let first = field.values().first().copied()?;
    field.values().iter().all(|value| *value == first).then_some(first)
}
