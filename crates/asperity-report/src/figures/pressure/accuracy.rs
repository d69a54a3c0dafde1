//! How far each method is from the reference, over what it cost.

use std::f64::consts::{FRAC_2_PI, LN_2, PI};

use asperity_results::{MethodEntry, PressureResult};

use super::style;
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::figures::{Plate, Stage, columns, csv};
use crate::format::Unit;
use crate::page::method_name;
use crate::palette::{BLACK, GREY};
use crate::{ReportError, Run, Table};

const NAME: &str = "pressure_accuracy";
/// Larger errors are beyond the frame: such a law has nothing to do with the one looked for.
const LARGEST: f64 = 3.0;
/// Works that differ by less than this share are taken as equal, and drawn so far apart, as a ratio.
const NEAR: f64 = 0.02;
const APART: f64 = 1.07;

/// One measure of error.
struct Measure {
    label: &'static str,
    /// Work and error of each method that has one above zero, with its place in the list.
    points: Vec<(usize, f64, f64)>,
    /// Expected error of one independent sample; of n it is smaller by √n.
    monte_carlo: Option<f64>,
    /// Smaller errors are not resolved by the reference.
    resolution: Option<f64>,
}

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(pressure) = &run.results.pressure else { return Ok(()) };
    let measures = measures(run, pressure);
    let works = || measures.iter().flat_map(|m| m.points.iter().map(|(_, work, _)| work));
    let Some((low, high)) = range(works()) else { return Ok(()) };
    let ends = (low / 2.0, high * 2.0);
    let mut charts = Vec::new();
    for measure in measures.iter().filter(|measure| !measure.points.is_empty()) {
        let rate = |work: f64| measure.monte_carlo.map(|one| one / work.sqrt());
        let lines = [rate(ends.0), rate(ends.1), measure.resolution].into_iter().flatten();
        let shown: Vec<f64> = measure.points.iter().map(|(_, _, error)| *error).chain(lines).collect();
        let Some((least, most)) = range(&shown) else { continue };
        let x = Axis::logarithmic("Work in fine contact solutions", Unit::none(), ends);
        let y = Axis::logarithmic(measure.label, Unit::none(), (least / 1.4, most * 1.4));
        let mut chart = Chart::new(x, y);
        if let (Some(from), Some(to)) = (rate(ends.0), rate(ends.1)) {
            let pen = Pen { opacity: 0.7, ..Pen::new(GREY, 2.4, Dash::Solid) };
            chart.add("expected of Monte Carlo", Mark::Line { x: vec![ends.0, ends.1], y: vec![from, to], pen });
        }
        if let Some(y) = measure.resolution {
            chart.add("resolution of the reference", Mark::Horizontal { y, pen: Pen::new(BLACK, 1.0, Dash::Dotted) });
        }
        for (&(index, _, y), x) in measure.points.iter().zip(side_by_side(&measure.points)) {
            let name = &pressure.methods[index].name;
            let (pen, shape) = style(name, index);
            chart.add_named(method_name(name), Mark::Symbol { x, y, shape, colour: pen.colour });
        }
        chart.shows_x = false;
        charts.push((152.0, chart));
    }
    let Some((height, last)) = charts.last_mut() else { return Ok(()) };
    last.shows_x = true;
    *height += 42.0;
    let title = "What the methods cost and are worth";
    let caption = "Distance of every method from the reference, in one run, over its work: contact solutions, those on coarse \
                   grids counted by cells and iterations; methods of equal work stand side by side. KS: \
                   largest difference of the distribution functions; W₁: area between them, over the standard deviation of the pressure; last, the error of the \
                   contact probability. The grey lines are what so many independent samples are expected to be off (KS: of a \
                   law without an atom). Errors above 3 are not shown. Errors of one run are partly luck, and below the dotted line they are the \
                   reference’s own.";
    let svg = figure(title, caption, Layout::Column, &charts)?;
    let sources = vec![csv("pressure_methods")];
    plates.push(Plate {
        name: NAME,
        stage: Stage::Pressure,
        title: title.into(),
        caption: caption.into(),
        sources,
        svg,
    });
    Ok(())
}

/// The works, those of equal ones spread evenly about their value, so that no symbol hides another.
fn side_by_side(points: &[(usize, f64, f64)]) -> Vec<f64> {
    let near = |a: f64, b: f64| (a / b).ln().abs() < NEAR;
    let place = |position: usize| {
        let work = points[position].1;
        let alike = |slice: &[(usize, f64, f64)]| slice.iter().filter(|point| near(point.1, work)).count() as f64;
        let (before, all) = (alike(&points[..position]), alike(points));
        work * APART.powf(before - 0.5 * (all - 1.0))
    };
    (0..points.len()).map(place).collect()
}

fn measures(run: &Run, pressure: &PressureResult) -> [Measure; 3] {
    let points = |error: &dyn Fn(&MethodEntry) -> Option<f64>| -> Vec<(usize, f64, f64)> {
        let each = pressure.methods.iter().enumerate();
        let each = each.filter_map(|(index, method)| Some((index, method.work_in_fine_solves, error(method)?)));
        each.filter(|(_, work, error)| *work > 0.0 && *error > 0.0 && *error < LARGEST).collect()
    };
    let truth = pressure.contact_probability;
    let resolution = pressure.contact_probability_se.map(|se| 1.96 * se).filter(|r| *r > 0.0);
    [
        Measure {
            label: "KS distance",
            points: points(&|method| method.ks_distance),
            // The mean of Kolmogorov's law.
            monte_carlo: Some((PI / 2.0).sqrt() * LN_2),
            resolution: Some(pressure.ks_resolution).filter(|r| *r > 0.0),
        },
        Measure {
            label: "W₁ / std",
            points: points(&|method| method.wasserstein_1_over_std),
            monte_carlo: run.tables.get("pressure_cdf").and_then(wasserstein_of_one),
            resolution: None,
        },
        Measure {
            label: "|Δ P(contact)|",
            points: points(&|method| Some((method.contact_probability? - truth).abs())),
            monte_carlo: Some((FRAC_2_PI * truth * (1.0 - truth)).sqrt()).filter(|e| *e > 0.0),
            resolution,
        },
    ]
}

/// √n times the expected W₁ of n samples over the standard deviation: E|F̂ − F| = √(2F(1 − F)/πn) at every pressure.
fn wasserstein_of_one(table: &Table) -> Option<f64> {
    let [pressure, cdf] = columns(table, ["pressure_pa", "reference"])?;
    let steps = || pressure.windows(2).zip(cdf).map(|(p, f)| (p[1] - p[0], p[1], p[0], *f));
    let area: f64 = steps().map(|(dp, _, _, f)| dp * (FRAC_2_PI * f * (1.0 - f)).max(0.0).sqrt()).sum();
    // Moments by parts: E p = ∫(1 − F) dp, E p² = ∫2p(1 − F) dp.
    let mean: f64 = steps().map(|(dp, _, _, f)| dp * (1.0 - f)).sum();
    let square: f64 = steps().map(|(_, high, low, f)| (high * high - low * low) * (1.0 - f)).sum();
    let std = (square - mean * mean).sqrt();
    (std > 0.0 && area > 0.0).then(|| area / std)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_of_equal_work_stand_side_by_side_about_it() {
        let found = side_by_side(&[(0, 500.0, 0.1), (1, 1500.0, 0.1), (2, 500.0, 0.1), (3, 500.0, 0.2)]);
        let wanted = [500.0 / APART, 1500.0, 500.0, 500.0 * APART];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn the_expected_distance_of_one_sample_of_a_uniform_law_is_known() {
        // ∫√(2u(1 − u)/π) du = √(2/π) π/8, and the standard deviation is 1/√12.
        let u: Vec<f64> = (0..=4000).map(|i| f64::from(i) / 4000.0).collect();
        let table = Table { columns: vec![("pressure_pa".into(), u.clone()), ("reference".into(), u)] };
        let wanted = FRAC_2_PI.sqrt() * PI / 8.0 * 12_f64.sqrt();
        assert!((wasserstein_of_one(&table).unwrap() / wanted - 1.0).abs() < 1e-3);
    }
}
