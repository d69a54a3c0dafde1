//! Structure functions along x and y with the power laws that give the Hurst exponent.

use asperity_results::StructureFunctions;

use crate::Run;
use crate::figures::surface::scan::{scan, scan_sentence};
use crate::figures::{CaptionedFigure, defined, positive};
use crate::format::{Dimension, Unit, significant};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREY, ORANGE, Pen, VERMILION, range};

const NAME: &str = "structure_function";

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let table = StructureFunctions::of(run.tables.get(NAME)?);
    let [lag, x, y] = defined([&table.lag_m, &table.structure_x_m2, &table.structure_y_m2])?;
    let lags = range(positive(lag))?;
    let (low, high) = range(positive(x).chain(positive(y)))?;
    let unit = if high < 1e-14 { Unit::new("nm²", 1e-18) } else { Unit::new("µm²", 1e-12) };
    let mut chart = Chart::new(
        Axis::logarithmic("Lag τ", Dimension::Length.unit((lags.0 * lags.1).sqrt()), lags),
        Axis::logarithmic("Structure function S(τ)", unit, (0.7 * low, 2.0 * high)),
    );
    if let Some(sq_m) = scan(run).map(|scan| scan.Sq_m) {
        chart.horizontal("2 Sq²", 2.0 * sq_m * sq_m, Pen::new(GREY, 1.2, Dash::Dashed));
    }
    let curves = [
        (x, "measured, x", Pen::new(BLUE, 2.0, Dash::Solid)),
        (y, "measured, y", Pen::new(ORANGE, 2.0, Dash::Long)),
        (&table.fit_x_m2, "power law, x", Pen::new(BLACK, 1.6, Dash::Dotted)),
        (&table.fit_y_m2, "power law, y", Pen::new(VERMILION, 1.6, Dash::Alternating)),
    ];
    for (values, name, pen) in curves {
        // Lags of the other axis leave gaps.
        let (x, y): (Vec<f64>, Vec<f64>) = lag.iter().zip(values).filter(|(_, v)| v.is_finite()).unzip();
        if !x.is_empty() {
            chart.line(name, &x, &y, pen);
        }
    }
    let fit = match scan(run).and_then(|scan| scan.hurst.zip(scan.fractal_dimension)) {
        Some((hurst, dimension)) => format!(
            "Slopes of 2H over the lags of the fit give the Hurst exponent H = {}, the fractal dimension D = 3 − H = {}.",
            significant(hurst, 3),
            significant(dimension, 3)
        ),
        _ => "No range of lags is straight enough for a Hurst exponent.".to_owned(),
    };
    let caption = format!(
        "Mean squared difference of the levelled heights at a distance τ along x and y; far apart it is twice the variance. \
         {fit}{}",
        scan_sentence(run)
    );
    let chart = chart.with_height(340.0);
    CaptionedFigure::from_charts(NAME, "Structure functions of heights", caption, 1, &[chart], &[NAME])
}
