//! Residuals against iterations.

use std::path::Path;

use plotters::prelude::*;

use crate::Result;
use crate::tables::History;

/// Colours that differ for colour-blind readers and in grey (Okabe and Ito), by load.
const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 0, 0)];
const SIZE: (u32, u32) = (960, 420);

/// One panel for each grid, dashed where there is a hardness.
pub(crate) fn write(file: &Path, histories: &[History]) -> Result<()> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let most = histories.iter().map(|history| history.residuals.len()).max().unwrap_or(1);
        let panels = area.split_evenly((1, 2));
        for (panel, members) in panels.iter().zip(histories.chunk_by(|a, b| a.cells == b.cells)) {
            let title = format!("{0} × {0} cells", members[0].cells);
            let mut chart = ChartBuilder::on(panel)
                .caption(title, ("sans-serif", 17))
                .margin(12)
                .x_label_area_size(44)
                .y_label_area_size(64)
                .build_cartesian_2d(0.0..most as f64, (1e-13..10.0).log_scale())?;
            chart
                .configure_mesh()
                .light_line_style(WHITE)
                .x_desc("iterations (applications of the operator)")
                .y_desc("largest residual (dimensionless)")
                .x_label_formatter(&|x| format!("{x:.0}"))
                .y_label_formatter(&|y| format!("{y:.0e}"))
                .label_style(("sans-serif", 13))
                .axis_desc_style(("sans-serif", 15))
                .draw()?;
            for history in members {
                let style = COLOURS[history.load].stroke_width(2);
                let points = history.residuals.iter().enumerate().map(|(k, residual)| (k as f64, *residual));
                let body = if history.yields { "elasto-plastic" } else { "elastic" };
                let name = format!("{:.0} % contact, {body}", 100.0 * history.contact);
                if history.yields {
                    let line = chart.draw_series(DashedLineSeries::new(points, 6, 4, style))?;
                    line.label(name).legend(move |(x, y)| {
                        EmptyElement::at((x, y))
                            + PathElement::new([(0, 0), (9, 0)], style)
                            + PathElement::new([(15, 0), (24, 0)], style)
                    });
                } else {
                    let line = chart.draw_series(LineSeries::new(points, style))?;
                    line.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
                }
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .legend_area_size(30)
                .background_style(WHITE)
                .border_style(RGBColor(200, 200, 200))
                .label_font(("sans-serif", 13))
                .draw()?;
        }
        area.present()?;
    }
    Ok(std::fs::write(file, svg)?)
}
