//! Mean friction against the shortest waves that the surface keeps.

use asperity_results::CutoffResult;

use super::{HEIGHT, plate, positive};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Mark};
use crate::figures::{Plate, columns};
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, GREEN, GREY, VERMILION};
use crate::symbol::Shape;
use crate::{ReportError, Run, Table};

const NAME: &str = "friction_cutoff";

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let cutoff = run.results.friction.as_ref().and_then(|friction| friction.cutoff.as_ref());
    let Some(chart) = run.tables.get(NAME).and_then(|table| chart(table, cutoff)) else { return Ok(()) };
    let title = "The friction coefficient against the shortest waves";
    let caption = format!(
        "Mean μ at the mean pressure of the leading level without the waves below a cut-off, taken out of the same strips by a Gaussian \
         filter; shaded: 95 % intervals. {}",
        cutoff.map_or("", |cutoff| &cutoff.known)
    );
    plates.push(plate(NAME, NAME, title, caption.trim_end().to_owned(), &[(HEIGHT, chart)])?);
    Ok(())
}

fn chart(table: &Table, cutoff: Option<&CutoffResult>) -> Option<Chart> {
    let [x, mean] = columns(table, ["cutoff_m", "mean"])?;
    let own = cutoff.map(|cutoff| cutoff.cutoff_m);
    let band_end = cutoff.and_then(|cutoff| cutoff.band_end_m);
    let floor = cutoff.and_then(|cutoff| cutoff.plastic_floor);
    let halved = cutoff.and_then(|cutoff| cutoff.halved_pitch.as_ref()).map(|halved| halved.mean);
    let limits = columns(table, ["mean_low", "mean_high"]);
    let (first, last) = range(positive(x).chain(own.as_slice()).chain(band_end.as_slice()))?;
    let shown = mean.iter().chain(floor.as_slice()).chain(halved.as_slice());
    let (low, high) = range(shown.chain(limits.into_iter().flatten().flatten()))?;
    let x_axis = Axis::logarithmic("Cut-off wavelength", Dimension::Length.unit(last), (first / 1.25, last * 1.25));
    let mut chart = Chart::new(x_axis, Axis::padded("Friction coefficient μ", Unit::none(), (low, high), 0.08));
    let pen = Pen::new(VERMILION, 1.8, Dash::Solid);
    if let Some([low, high]) = limits {
        let (x, low, high) = (x.to_vec(), low.to_vec(), high.to_vec());
        chart.add(None, Mark::Band { x, low, high, colour: pen.colour });
    }
    chart.add("mean μ, 95 %", Mark::Points { x: x.to_vec(), y: mean.to_vec(), pen });
    if let (Some(x), Some(y)) = (own, halved) {
        chart.add("half the pitch", Mark::Symbol { x, y, shape: Shape::OpenDiamond, colour: BLUE });
    }
    if let Some(y) = floor {
        chart.add("plastic floor τ/H", Mark::Horizontal { y, pen: Pen::new(BLACK, 1.3, Dash::Dashed) });
    }
    if let Some(x) = own {
        chart.add("cut-off of the study’s strips", Mark::Vertical { x, pen: Pen::new(GREY, 1.5, Dash::Solid) });
    }
    if let Some(x) = band_end {
        chart.add("end of the scan’s band", Mark::Vertical { x, pen: Pen::new(GREEN, 1.5, Dash::Long) });
    }
    Some(chart)
}
