//! Figure of residuals against iterations, as SVG. The library may not depend on the crate that draws the reports.

use std::fmt::Write;
use std::path::Path;

use crate::Result;
use crate::tables::History;

/// Colours that differ for colour-blind readers and in grey (Okabe and Ito), by load.
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#000000"];
const PANEL: (f64, f64) = (480.0, 420.0);
/// Position of the axes in a panel: left, right, top, bottom.
const PLOT: [f64; 4] = [78.0, 466.0, 36.0, 362.0];
/// Decades of the residual.
const DECADES: (i32, i32) = (-13, 1);

/// Writes one panel for each grid. Lines of problems with a hardness are dashed.
pub(crate) fn write(file: &Path, histories: &[History]) -> Result<()> {
    let most = histories.iter().map(|history| history.residuals.len()).max().unwrap_or(1);
    let most = most.div_ceil(10) * 10;
    let panels: Vec<&[History]> = histories.chunk_by(|a, b| a.cells == b.cells).collect();
    let (width, height) = (PANEL.0 * panels.len() as f64, PANEL.1);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<title>Largest residual of contact solves against iterations</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    for (place, members) in panels.into_iter().enumerate() {
        writeln!(svg, "<g transform=\"translate({} 0)\">", PANEL.0 * place as f64)?;
        panel(&mut svg, members, most)?;
        svg += "</g>\n";
    }
    svg += "</svg>\n";
    Ok(std::fs::write(file, svg)?)
}

fn panel(svg: &mut String, members: &[History], most: usize) -> Result<()> {
    let [left, right, top, bottom] = PLOT;
    let x = |k: f64| left + (right - left) * k / most as f64;
    let y = |decade: f64| bottom - (bottom - top) * (decade - f64::from(DECADES.0)) / f64::from(DECADES.1 - DECADES.0);
    let middle = (0.5 * (left + right), 0.5 * (top + bottom));
    let cells = members.first().map_or(0, |history| history.cells);
    writeln!(
        svg,
        "<text x=\"{}\" y=\"22\" font-size=\"16\" text-anchor=\"middle\">{cells} × {cells} cells</text>",
        middle.0
    )?;
    let grid = "stroke=\"#cccccc\" stroke-width=\"0.8\"";
    for k in (0..=most).step_by(10) {
        let at = x(k as f64);
        writeln!(svg, "<path d=\"M{at:.1} {top}V{bottom}\" {grid}/>")?;
        writeln!(svg, "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{k}</text>", bottom + 18.0)?;
    }
    for decade in (DECADES.0..=DECADES.1).filter(|decade| decade % 2 == 0) {
        let at = y(f64::from(decade));
        writeln!(svg, "<path d=\"M{left} {at:.1}H{right}\" {grid}/>")?;
        let power = decade.to_string().replace('-', "−");
        writeln!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">10<tspan dy=\"-5\" font-size=\"10\">{power}</tspan></text>",
            left - 8.0,
            at + 5.0
        )?;
    }
    writeln!(
        svg,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#000000\"/>",
        right - left,
        bottom - top
    )?;
    let label = "font-size=\"15\" text-anchor=\"middle\"";
    writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" {label}>iterations (applications of the operator)</text>",
        middle.0,
        bottom + 44.0
    )?;
    writeln!(
        svg,
        "<text transform=\"translate(24 {}) rotate(-90)\" {label}>largest residual (dimensionless)</text>",
        middle.1
    )?;
    for history in members {
        let mut points = String::new();
        for (k, residual) in history.residuals.iter().enumerate() {
            write!(points, "{:.1},{:.1} ", x(k as f64), y(residual.log10()))?;
        }
        writeln!(svg, "<polyline points=\"{}\" {}/>", points.trim_end(), pen(history))?;
    }
    let (box_left, row) = (right - 258.0, 19.0);
    writeln!(
        svg,
        "<rect x=\"{box_left}\" y=\"{}\" width=\"250\" height=\"{}\" fill=\"#ffffff\" stroke=\"#cccccc\"/>",
        top + 8.0,
        row * members.len() as f64 + 8.0
    )?;
    for (place, history) in members.iter().enumerate() {
        let at = top + 21.0 + row * place as f64;
        writeln!(svg, "<path d=\"M{} {at}h30\" {}/>", box_left + 8.0, pen(history))?;
        let body = if history.yields { "elasto-plastic" } else { "elastic" };
        let contact = 100.0 * history.contact;
        writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" font-size=\"12\">{contact:.0} % contact, {body}</text>",
            box_left + 46.0,
            at + 4.5
        )?;
    }
    Ok(())
}

/// Returns the SVG attributes of the line of a history.
fn pen(history: &History) -> String {
    let dashes = if history.yields { " stroke-dasharray=\"6 4\"" } else { "" };
    format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{dashes}", COLOURS[history.load])
}
