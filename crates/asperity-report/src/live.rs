//! Figures of values that the browser computes: SVG from arrays in SI units.

use asperity_results::Field;

use crate::ReportError;
use crate::figures::raster_panels;
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLUE, Chart, Dash, GREY, Kind, Layout, Mark, Pen, Raster, SCREEN, VERMILION, Width, range};

/// Draws the limit cycle over the ends of runs with fluctuating friction, which undefined points separate. A curve is its displacements
/// and its velocities.
#[must_use]
pub fn portrait(cycle: [&[f64]; 2], runs: [&[f64]; 2], belt_velocity_m_per_s: f64) -> String {
    let values = |coordinate: usize| cycle[coordinate].iter().chain(runs[coordinate]);
    let x = axis("Displacement x", Dimension::Length, values(0), 0.05);
    let v = axis("Velocity", Dimension::Velocity, values(1).chain(&[belt_velocity_m_per_s, 0.0]), 0.05);
    let mut chart = Chart::new(x, v);
    chart.line(
        "runs with fluctuating friction",
        runs[0],
        runs[1],
        Pen { opacity: 0.5, ..Pen::new(GREY, 0.8, Dash::Solid) },
    );
    chart.line("limit cycle without fluctuation", cycle[0], cycle[1], Pen::new(BLUE, 2.2, Dash::Solid));
    chart.horizontal("belt speed", belt_velocity_m_per_s, Pen::new(VERMILION, 1.4, Dash::Dashed));
    svg("Phase portrait of the machine", chart)
}

/// Draws the density of the displacements at re-attachment over the centres of its bins, and the displacement without fluctuation.
#[must_use]
pub fn reattachment(centres_m: &[f64], density_per_m: &[f64], without_m: Option<f64>) -> String {
    let x = axis("Displacement at re-attachment", Dimension::Length, centres_m.iter().chain(&without_m), 0.05);
    let unit = x.unit().inverse();
    let highest = range(density_per_m).map_or(1.0, |(_, highest)| highest);
    let mut chart = Chart::new(x, Axis::padded("Density", unit, (0.0, highest), 0.05));
    chart.bars("runs with fluctuating friction", centres_m, density_per_m, BLUE);
    if let Some(without) = without_m {
        chart.vertical("without fluctuation", without, Pen::new(VERMILION, 1.6, Dash::Dashed));
    }
    svg("Displacements at re-attachment", chart)
}

/// Draws a radial power spectral density over wavenumbers, and the ends of the reliable ones.
#[must_use]
pub fn spectrum(q_rad_per_m: &[f64], psd_m4: &[f64], reliable_rad_per_m: (f64, f64)) -> String {
    let ends = |values: &[f64], wide: f64| {
        let (low, high) = range(values.iter().filter(|value| **value > 0.0)).unwrap_or((1.0, 1.0));
        (low / wide, high * wide)
    };
    let (low, high) = reliable_rad_per_m;
    let x = Axis::logarithmic("Wavenumber q", Unit::new("rad/µm", 1e6), ends(q_rad_per_m, 1.1));
    let y = Axis::logarithmic("Power spectral density", Unit::new("µm⁴", 1e-24), ends(psd_m4, 2.0));
    let mut chart = Chart::new(x, y);
    chart.add("reliable wavenumbers", Mark::Region { from: low, to: high, colour: BLUE });
    chart.line("mean over directions", q_rad_per_m, psd_m4, Pen::new(BLUE, 1.8, Dash::Solid));
    svg("Power spectral density of the map", chart)
}

/// Draws the friction coefficient of a window along its path, and the mean.
#[must_use]
pub fn friction(position_m: &[f64], friction: &[f64], mean: f64) -> String {
    let x = axis("Sliding distance s", Dimension::Length, position_m, 0.0);
    let mut chart =
        Chart::new(x, axis("Friction coefficient μ", Dimension::None, friction.iter().chain(&[mean]), 0.15));
    chart.line("one window", position_m, friction, Pen::new(BLUE, 1.8, Dash::Solid));
    chart.horizontal("mean", mean, Pen::new(VERMILION, 1.6, Dash::Dashed));
    svg("Friction coefficient along the path", chart)
}

/// Draws maps of heights, each with its name, in columns on one colour scale.
///
/// # Errors
/// The PNG encoder failed.
pub fn heights(maps: &[(&str, &Field)], columns: usize) -> Result<String, ReportError> {
    panels("Heights", Kind::Height, maps, columns)
}

/// Draws a map of the contact pressure.
///
/// # Errors
/// The PNG encoder failed.
pub fn pressure(map: &Field) -> Result<String, ReportError> {
    panels("Contact pressure", Kind::Pressure, &[("", map)], 1)
}

fn panels(title: &str, kind: Kind, maps: &[(&str, &Field)], columns: usize) -> Result<String, ReportError> {
    let rasters = Raster::with_common_scale(maps.iter().map(|(_, map)| *map), kind)?;
    let named: Vec<(&str, &Raster)> = maps.iter().map(|(name, _)| *name).zip(&rasters).collect();
    let width = Width { px: if columns == 1 { 400.0 } else { 640.0 }, ..SCREEN };
    let drawn = raster_panels("map", title, "", &named, columns, 400.0 * named.len().div_ceil(columns) as f64);
    Ok(drawn.map(|drawn| drawn.layout.svg(title, &drawn.caption, width)).unwrap_or_default())
}

/// Returns the axis that contains values, with a margin.
fn axis<'a>(quantity: &str, dimension: Dimension, values: impl IntoIterator<Item = &'a f64>, margin: f64) -> Axis {
    let (low, high) = range(values).unwrap_or_default();
    Axis::padded(quantity, dimension.unit(low.abs().max(high.abs())), (low, high), margin)
}

fn svg(title: &str, chart: Chart) -> String {
    Layout::new(1, &[chart]).svg(title, "", SCREEN)
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn maps_stand_in_columns_with_one_bar_and_a_legend_for_fingers() {
        let field = Field::new([1e-6, 1e-6], "m", array![[0.0, 1e-6], [f64::NAN, 2e-6]]);
        let drawn = |columns| heights(&[("Scan", &field), ("Twin", &field)], columns).unwrap();
        let (side_by_side, stacked) = (drawn(2), drawn(1));
        for (drawn, width) in [(&side_by_side, 640), (&stacked, 400)] {
            assert!(drawn.contains(&format!("viewBox=\"0 0 {width} ")) && drawn.matches("<image").count() == 3);
            assert_eq!([">Scan<", ">Twin<", ">Height (µm)<"].map(|text| drawn.matches(text).count()), [1; 3]);
        }
        let entry = side_by_side.split_once("data-entry=\"missing (1 points)\">\n").unwrap().1;
        assert!(entry.starts_with("<polygon") && entry.lines().next().unwrap().contains("opacity=\"0\""), "{entry}");
        assert!(pressure(&field).unwrap().contains("no contact (p = 0)"));
    }

    #[test]
    fn axes_have_the_units_of_their_values_and_runs_are_separate_curves() {
        let runs = [&[0.0, 1e-5, f64::NAN, 2e-5, 0.0, f64::NAN][..], &[0.0, 0.01, f64::NAN, 0.02, 0.0, f64::NAN]];
        let drawn = portrait([&[0.0, 2e-5, 0.0], &[0.0, 0.03, 0.0]], runs, 0.03);
        assert!(
            drawn.contains("data-label=\"Displacement x (µm)\"") && drawn.contains("data-label=\"Velocity (mm/s)\"")
        );
        let curves = |name: &str| {
            let series = drawn.split_once(&format!("data-series=\"{name}\"")).unwrap().1;
            series.split_once("</g>").unwrap().0.matches("<polyline").count()
        };
        assert_eq!(
            ["runs with fluctuating friction", "limit cycle without fluctuation", "belt speed"].map(curves),
            [2, 1, 1]
        );
        // Densities over lengths have the reciprocal unit, and a histogram without a cycle has no line.
        let histogram = |without| reattachment(&[1e-5, 2e-5], &[4e4, 6e4], without);
        assert!(
            histogram(None)
                .contains("data-label=\"Density (1/µm)\" data-spacing=\"linear\" data-from=\"0\" data-to=\"0.063\"")
        );
        assert!(
            histogram(Some(1e-5)).contains("without fluctuation") && !histogram(None).contains("without fluctuation")
        );
    }
}
