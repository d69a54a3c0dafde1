//! Duration of vibration.

use asperity_results::{Survival, Table};

use crate::Run;
use crate::figures::vibration::curves::Tables;
use crate::figures::{CaptionedFigure, defined, present};
use crate::format::Unit;
use crate::plot::{Axis, BLUE, Chart, Colour, Dash, Pen, VERMILION, range};

/// A table with the name, colour and dash of its curve.
type Curve<'a> = (&'a Table, &'static str, Colour, Dash);

/// Draws the survival of a run.
pub(super) fn of_run(run: &Run) -> Option<CaptionedFigure> {
    let known = [
        ("survival_area", "upscaling “area”", BLUE, Dash::Long),
        ("survival_paper", "upscaling “paper”", VERMILION, Dash::Dashed),
    ];
    let curve = |(table, name, colour, dash)| Some((run.tables.get(table)?, name, colour, dash));
    let curves: Vec<Curve<'_>> = known.into_iter().filter_map(curve).collect();
    Some(drawn(&curves)?.with_tables(&present(run, &known.map(|curve| curve.0))))
}

/// Draws the survival of a command.
pub(super) fn figure(tables: &Tables) -> Option<CaptionedFigure> {
    drawn(&[(tables.get("survival")?, "never left vibration", BLUE, Dash::Solid)])
}

fn drawn(curves: &[Curve<'_>]) -> Option<CaptionedFigure> {
    let curves: Vec<_> =
        curves.iter().map(|&(table, name, colour, dash)| (Survival::of(table), name, colour, dash)).collect();
    let x = Axis::linear("Time τ", Unit::none(), range(curves.iter().flat_map(|curve| &*curve.0.tau))?);
    let mut chart =
        Chart::new(x, Axis::linear("Fraction in vibration", Unit::none(), (-0.04, 1.04))).with_height(300.0);
    for (Survival { tau, share, share_low, share_high }, name, colour, dash) in &curves {
        let Some([tau, share]) = defined([tau, share]) else { continue };
        if let Some(band) = defined([share_low, share_high]) {
            chart.band("", tau, band, *colour);
        }
        chart.line(*name, tau, share, Pen::new(*colour, 2.0, *dash));
    }
    let caption = "Fraction of the trajectories that have vibrated without interruption up to the time τ, with 95 % intervals. Vibration \
                   ends when the mass then slips for three natural periods without a swing that sticks, exceeds the velocity of the \
                   belt or belongs to a slip cycle; trajectories without such a swing leave it at τ = 0.";
    CaptionedFigure::from_charts("survival", "Duration of vibration", caption, 1, &[chart], &[])
}
