//! Labels, attractors and curves of the figures.

use std::collections::BTreeMap;

use asperity_results::Table;

use crate::plot::{BLUE, Chart, Colour, Dash, GREEN, ORANGE, Pen, VERMILION, WHITE};
/// The tables of a command or of a run, by name.
pub(crate) type Tables = BTreeMap<String, Table>;

/// Returns the label of an axis over a parameter of the machine.
pub(super) fn axis_label(parameter: &str) -> String {
    let label = match parameter {
        "damping_ratio" => "Damping ratio ζ",
        "belt_velocity" => "Belt velocity V",
        "friction_std" => "Standard deviation of μ",
        "load_ratio" => "Load ratio N/N₀",
        "static_friction" => "Static friction coefficient",
        "weakening" => "Weakening rate of the friction law",
        "forcing_amplitude" => "Amplitude q of the force",
        "forcing_frequency" => "Frequency η of the force",
        other => return other.replace('_', " "),
    };
    label.to_owned()
}

/// Attractors of the motion: number in tables, name, colour and dash.
pub(super) const ATTRACTORS: [(f64, &str, Colour, Dash); 4] = [
    (0.0, "steady sliding", BLUE, Dash::Long),
    (1.0, "slip cycle", GREEN, Dash::Alternating),
    (2.0, "stick-slip", VERMILION, Dash::Solid),
    (3.0, "overtaking", ORANGE, Dash::Short),
];

/// Returns the points of several curves, with an undefined point between them wherever the number of the curve changes.
pub(super) fn separated(curve: &[f64], x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let points = (0..x.len()).flat_map(|i| {
        let starts = i > 0 && curve[i].to_bits() != curve[i - 1].to_bits();
        starts.then_some((f64::NAN, f64::NAN)).into_iter().chain([(x[i], y[i])])
    });
    points.unzip()
}

/// Draws a line with a white halo, which is visible on every colour.
pub(in crate::figures) fn outlined(chart: &mut Chart, name: &str, x: &[f64], y: &[f64], pen: Pen) {
    chart.line("", x, y, Pen { opacity: 0.85, ..Pen::new(WHITE, pen.width + 2.6, Dash::Solid) });
    chart.line(name, x, y, pen);
}
