//! Distance of each method from the reference, over its cost.

use std::f64::consts::{FRAC_2_PI, LN_2, PI};

use asperity_results::choice::Choice;
use asperity_results::{MethodEntry, PressureMethod, PressureResult, Table};

use crate::Run;
use crate::figures::pressure::style::style;
use crate::figures::{CaptionedFigure, columns};
use crate::format::Unit;
use crate::plot::{Axis, BLACK, Chart, Dash, GREY, Mark, Pen, range, stacked};

/// Larger errors are not drawn: such a distribution is unrelated to the true one.
const LARGEST: f64 = 3.0;
/// Works that differ by less than this fraction count as equal, and are drawn this far apart, as a ratio.
const NEAR: f64 = 0.02;
const APART: f64 = 1.07;

/// A point of the figure: method, work and error.
type ErrorPoint = (PressureMethod, f64, f64);

/// One measure of error.
struct Measure {
    label: &'static str,
    /// The methods with an error above zero.
    points: Vec<ErrorPoint>,
    /// Expected error of one independent sample; the error of n samples is smaller by √n.
    monte_carlo: Option<f64>,
    /// Errors below this one are not resolved by the reference.
    resolution: Option<f64>,
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let pressure = run.results.pressure.as_ref().filter(|pressure| pressure.reference_samples > 0)?;
    let measures = measures(run, pressure);
    let (low, high) = range(measures.iter().flat_map(|m| m.points.iter().map(|(_, work, _)| work)))?;
    let charts = measures.iter().filter_map(|measure| chart(measure, (low / 2.0, high * 2.0)));
    let caption = "Distance of every method from the reference, in one run, over its work: contact solutions, those on coarse \
                   grids counted by cells and iterations; methods of equal work are drawn side by side. KS: largest difference of \
                   the distribution functions; W₁: area between them, over the standard deviation of the pressure; last, the error of \
                   the contact probability. The grey lines are the expected errors of as many independent samples (KS: of a \
                   distribution without a point mass). Errors above 3 are not shown. Errors of one run are partly random, and \
                   below the dotted line they are due to the reference.";
    let title = "Error and cost of the methods";
    let charts = stacked(charts.collect(), 152.0);
    CaptionedFigure::from_charts("pressure_accuracy", title, caption, 1, &charts, &["pressure_methods"])
}

/// Draws one measure over the work; `None` without points.
fn chart(measure: &Measure, ends: (f64, f64)) -> Option<Chart> {
    let rate = measure.monte_carlo.map(|one| [one / ends.0.sqrt(), one / ends.1.sqrt()]);
    let lines = rate.iter().flatten().chain(measure.resolution.as_slice());
    let (least, most) = range(measure.points.iter().map(|(_, _, error)| error).chain(lines))?;
    let x = Axis::logarithmic("Work in fine contact solutions", Unit::none(), ends);
    let mut chart = Chart::new(x, Axis::logarithmic(measure.label, Unit::none(), (least / 1.4, most * 1.4)));
    if let Some(errors) = rate {
        let pen = Pen { opacity: 0.7, ..Pen::new(GREY, 2.4, Dash::Solid) };
        chart.line("expected of Monte Carlo", &[ends.0, ends.1], &errors, pen);
    }
    if let Some(y) = measure.resolution {
        chart.horizontal("resolution of the reference", y, Pen::new(BLACK, 1.0, Dash::Dotted));
    }
    for (&(method, _, y), x) in measure.points.iter().zip(side_by_side(&measure.points)) {
        let (Pen { colour, .. }, shape) = style(method);
        chart.add(method.words(), Mark::Symbol { x, y, shape, colour });
    }
    (!measure.points.is_empty()).then_some(chart)
}

/// Returns the works, equal ones spread evenly about their value so that no symbol hides another.
fn side_by_side(points: &[ErrorPoint]) -> Vec<f64> {
    let near = |a: f64, b: f64| (a / b).ln().abs() < NEAR;
    let place = |position: usize| {
        let work = points[position].1;
        let alike = |slice: &[ErrorPoint]| slice.iter().filter(|point| near(point.1, work)).count() as f64;
        let (before, all) = (alike(&points[..position]), alike(points));
        work * APART.powf(before - 0.5 * (all - 1.0))
    };
    (0..points.len()).map(place).collect()
}

fn measures(run: &Run, pressure: &PressureResult) -> [Measure; 3] {
    let points = |error: &dyn Fn(&MethodEntry) -> Option<f64>| -> Vec<ErrorPoint> {
        let each = pressure.methods.iter();
        let each = each.filter_map(|method| Some((method.name, method.work_in_fine_solves, error(method)?)));
        each.filter(|(_, work, error)| *work > 0.0 && *error > 0.0 && *error < LARGEST).collect()
    };
    let truth = pressure.contact_probability;
    let resolution = pressure.contact_probability_se.map(|se| 1.96 * se).filter(|r| *r > 0.0);
    [
        Measure {
            label: "KS distance",
            points: points(&|method| method.ks_distance),
            // Mean of the Kolmogorov distribution.
            monte_carlo: Some((PI / 2.0).sqrt() * LN_2),
            resolution: pressure.ks_resolution.filter(|r| *r > 0.0),
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

/// Returns √n times the expected W₁ of n samples over the standard deviation: E|F̂ − F| = √(2F(1 − F)/πn) at every pressure.
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
    fn methods_of_equal_work_are_placed_side_by_side() {
        let point = |work, error| (PressureMethod::Default, work, error);
        let found = side_by_side(&[point(500.0, 0.1), point(1500.0, 0.1), point(500.0, 0.1), point(500.0, 0.2)]);
        let wanted = [500.0 / APART, 1500.0, 500.0, 500.0 * APART];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn the_expected_distance_of_one_uniform_sample_equals_its_closed_form() {
        // ∫√(2u(1 − u)/π) du = √(2/π) π/8, and the standard deviation is 1/√12.
        let u: Vec<f64> = (0..=4000).map(|i| f64::from(i) / 4000.0).collect();
        let table = Table::new([("pressure_pa", u.clone()), ("reference", u)]);
        let wanted = FRAC_2_PI.sqrt() * PI / 8.0 * 12_f64.sqrt();
        assert!((wasserstein_of_one(&table).unwrap() / wanted - 1.0).abs() < 1e-3);
    }
}
