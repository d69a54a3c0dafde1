//! Structure functions along x and y with the power laws that give the Hurst exponent.

use super::{Plate, Stage, columns, csv, scan, which};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit, significant};
use crate::palette::{BLACK, BLUE, GREY, ORANGE, VERMILION};
use crate::{ReportError, Run};

const NAME: &str = "structure_function";

pub(super) fn plate(run: &Run) -> Result<Option<Plate>, ReportError> {
    let Some(table) = run.tables.get(NAME) else { return Ok(None) };
    let Some([lag, x, y]) = columns(table, ["lag_m", "structure_x_m2", "structure_y_m2"]) else { return Ok(None) };
    let positive = |values: &[f64]| values.iter().copied().filter(|v| *v > 0.0).collect::<Vec<_>>();
    let Some(lags) = range(&positive(lag)) else { return Ok(None) };
    let Some((low, high)) = range(&positive(&[x, y].concat())) else { return Ok(None) };
    let unit = if high < 1e-14 { Unit::new("nm²", 1e-18) } else { Unit::new("µm²", 1e-12) };
    let mut chart = Chart::new(
        Axis::logarithmic("Lag τ", Dimension::Length.unit((lags.0 * lags.1).sqrt()), lags),
        Axis::logarithmic("Structure function S(τ)", unit, (0.7 * low, 2.0 * high)),
    );
    if let Some(sq_m) = scan(run).map(|scan| scan.Sq_m) {
        let level = Mark::Horizontal { y: 2.0 * sq_m * sq_m, pen: Pen::new(GREY, 1.2, Dash::Dashed) };
        chart.add("2 Sq²", level);
    }
    let curves =
        [(x, "measured, x", Pen::new(BLUE, 2.0, Dash::Solid)), (y, "measured, y", Pen::new(ORANGE, 2.0, Dash::Long))];
    for (values, name, pen) in curves {
        // Lags of the other axis leave gaps.
        let (x, y) = lag.iter().zip(values).filter(|(_, v)| v.is_finite()).map(|(l, v)| (*l, *v)).unzip();
        chart.add(name, Mark::Line { x, y, pen });
    }
    let fits = [
        ("fit_x_m2", "power law, x", Pen::new(BLACK, 1.6, Dash::Dotted)),
        ("fit_y_m2", "power law, y", Pen::new(VERMILION, 1.6, Dash::Alternating)),
    ];
    for (column, name, pen) in fits {
        let values = table.column(column).unwrap_or_default();
        let (x, y): (Vec<f64>, Vec<f64>) =
            lag.iter().zip(values).filter(|(_, v)| v.is_finite()).map(|(l, v)| (*l, *v)).unzip();
        if x.len() > 1 {
            chart.add(name, Mark::Line { x, y, pen });
        }
    }
    let title = "Structure functions of heights";
    let found = match scan(run).and_then(|scan| scan.hurst.zip(scan.fractal_dimension)) {
        Some((hurst, dimension)) => format!(
            "Slopes of 2H over the lags of the fit give the Hurst exponent H = {}, the fractal dimension D = 3 − H = {}.",
            significant(hurst, 3),
            significant(dimension, 3)
        ),
        _ => "No range of lags is straight enough for a Hurst exponent.".to_owned(),
    };
    let caption = format!(
        "Mean squared difference of the levelled heights at a distance τ along x and y; far apart it is twice the variance. \
         {found}{}",
        which(run)
    );
    let svg = figure(title, &caption, Layout::Column, &[(340.0, chart)])?;
    let sources = vec![csv(NAME)];
    Ok(Some(Plate { name: NAME, stage: Stage::Surface, title: title.into(), caption, sources, svg }))
}
