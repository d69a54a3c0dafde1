//! The contact pressure of one surface, and its law at a point by every method.

use super::{Plate, Stage, columns, csv, map};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit};
use crate::page::method_name;
use crate::palette::{BLACK, GREY, pen};
use crate::raster::Kind;
use crate::{ReportError, Run, Table};

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let title = "Contact pressure on one realisation";
    let caption = "Pressure on one realisation of the surface; white points are not in contact. The colours saturate \
                   beyond the 99.9 % quantile.";
    plates.extend(map(run, ("pressure_sample", Stage::Pressure), Kind::Pressure, title, caption)?);
    match run.tables.get("pressure_cdf") {
        Some(table) => distribution(table, plates),
        None => Ok(()),
    }
}

/// The column that the others are compared with.
fn reference(table: &Table) -> Option<&'static str> {
    ["reference", "monte_carlo"].into_iter().find(|name| table.column(name).is_some())
}

fn distribution(table: &Table, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "pressure_cdf";
    let Some([pressure]) = columns(table, ["pressure_pa"]) else { return Ok(()) };
    let reference = reference(table);
    let mut methods: Vec<(&str, &[f64])> = table
        .columns
        .iter()
        .filter(|(name, _)| name != "pressure_pa")
        .filter_map(|(name, _)| Some((name.as_str(), table.column(name)?)))
        .collect();
    // The reference lies below the others.
    methods.sort_by_key(|(name, _)| Some(*name) != reference);
    if methods.is_empty() {
        return Ok(());
    }
    let axis = pressure_axis(pressure, methods[0].1);
    let logarithmic = axis.position(0.0).is_none();
    let mut top = Chart::new(axis.clone(), Axis::linear("CDF of the pressure", Unit::none(), (0.0, 1.03)));
    let mut below: Vec<(String, Mark)> = Vec::new();
    let mut others = 0;
    for (name, cdf) in &methods {
        let style = if Some(*name) == reference {
            Pen { opacity: 0.55, ..Pen::new(GREY, 5.0, Dash::Solid) }
        } else {
            others += 1;
            pen(others - 1)
        };
        let (mut x, mut y) = (pressure.to_vec(), cdf.to_vec());
        if logarithmic {
            // The atom at zero is the height at which the curve enters from the left.
            if let Some(first) = (0..x.len()).find(|&i| y[i].is_finite()) {
                x.insert(0, axis.ends().0);
                y.insert(0, y[first]);
            }
        } else {
            // The jump at zero, from the empty side of negative pressures.
            x.splice(0..0, [axis.ends().0, 0.0]);
            y.splice(0..0, [0.0, 0.0]);
        }
        top.add_named(method_name(name), Mark::Line { x, y, pen: style });
        if let Some(base) = reference.filter(|base| base != name).and_then(|base| table.column(base)) {
            let difference = cdf.iter().zip(base).map(|(a, b)| a - b).collect();
            let mark = Mark::Line { x: pressure.to_vec(), y: difference, pen: style };
            below.push((method_name(name), mark));
        }
    }
    let atom = reference.and_then(|name| table.column(name)).unwrap_or(methods[0].1)[0];
    if pressure[0] <= 0.0 && atom.is_finite() {
        let pen = Pen::new(BLACK, 1.0, Dash::Dotted);
        top.add("1 − P(contact), the atom at p = 0", Mark::Horizontal { y: atom, pen });
    }
    let mut charts = vec![(330.0, top)];
    let largest = below.iter().flat_map(|(_, mark)| match mark {
        Mark::Line { y, .. } => y.as_slice(),
        _ => &[],
    });
    let largest = range(largest).map_or(0.0, |(low, high)| low.abs().max(high.abs()));
    if largest > 0.0 {
        let y = Axis::linear("Difference", Unit::none(), (-1.1 * largest, 1.1 * largest));
        let mut chart = Chart::new(axis, y);
        chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen { opacity: 0.55, ..Pen::new(GREY, 3.0, Dash::Solid) } });
        for (name, mark) in below {
            chart.add_named(name, mark);
        }
        charts[0].1.shows_x = false;
        charts[0].0 -= 40.0;
        charts.push((190.0, chart));
    }
    let title = "Law of the contact pressure by method";
    let compared = reference.map_or(String::new(), |name| {
        format!(
            " Below: difference of every method from “{}”; its largest absolute value is the KS distance.",
            method_name(name)
        )
    });
    let caption = format!(
        "Cumulative distribution of the pressure at the point studied (the paper’s Fig. 2). The step at p = 0 is the \
         probability of no contact.{compared}"
    );
    let svg = figure(title, &caption, Layout::Column, &charts)?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Pressure, title: title.into(), caption, sources, svg });
    Ok(())
}

/// Linear from just below zero, so that the atom shows as a step; logarithmic when most of the law lies in the lowest
/// part of the range.
fn pressure_axis(pressure: &[f64], cdf: &[f64]) -> Axis {
    let atom = cdf.first().copied().filter(|v| v.is_finite()).unwrap_or(0.0);
    let quantile = |share: f64| {
        let level = atom + share * (1.0 - atom);
        pressure.iter().zip(cdf).find(|(p, f)| **p > 0.0 && **f >= level).map(|(p, _)| *p)
    };
    let last = range(pressure).map_or(1.0, |(_, high)| high);
    let high = Some(quantile(0.9995).unwrap_or(last)).filter(|high| *high > 0.0).unwrap_or(1.0);
    let unit = Dimension::Pressure.unit(high);
    let median = quantile(0.5).unwrap_or(high);
    let lowest = pressure.iter().copied().filter(|p| *p > 0.0).fold(high, f64::min);
    if median < 0.02 * high && lowest < median {
        let low = lowest.max(1e-3 * median);
        Axis::logarithmic("Pressure", Dimension::Pressure.unit(median), (low, high))
    } else {
        Axis::linear("Pressure", unit, (-0.03 * high, 1.03 * high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressure_axis_is_linear_for_an_even_law_and_logarithmic_for_one_of_many_decades() {
        let even: Vec<f64> = (0..=100).map(|i| f64::from(i) * 1e7).collect();
        let cdf: Vec<f64> = even.iter().map(|p| 0.5 + 0.5 * p / 1e9).collect();
        assert!(pressure_axis(&even, &cdf).position(0.0).is_some_and(|zero| zero > 0.0));
        let wide: Vec<f64> =
            std::iter::once(0.0).chain((0..=90).map(|i| 10f64.powf(3.0 + f64::from(i) / 15.0))).collect();
        let cdf: Vec<f64> = (0..wide.len()).map(|i| 0.5 + 0.5 * i as f64 / (wide.len() - 1) as f64).collect();
        assert_eq!(pressure_axis(&wide, &cdf).position(0.0), None);
    }
}
