//! Mean friction over the shortest wavelength of the surface.

use asperity_results::{CutoffPoint, CutoffResult, ScanCutoff, ScanFriction};

use crate::Run;
use crate::figures::{CaptionedFigure, positive};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREEN, GREY, Mark, Pen, Shape, VERMILION, range};

const NAME: &str = "friction_cutoff";

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let friction = run.results.friction.as_ref()?;
    let cutoff = friction.cutoff.as_ref()?;
    let chart = chart(cutoff, friction.scan.as_ref())?;
    let caption = format!(
        "Mean μ at the mean pressure of the operating point without the waves below a cut-off, which a Gaussian filter removes from \
         the same strips; shaded: 95 % intervals.{} {}",
        if friction.scan.is_some() { " The dotted line is the scan itself." } else { "" },
        cutoff.known
    );
    let title = "The friction coefficient over the shortest wavelength";
    CaptionedFigure::from_charts(NAME, title, caption.trim_end(), 1, &[chart], &[NAME])
}

fn chart(cutoff: &CutoffResult, scan: Option<&ScanFriction>) -> Option<Chart> {
    let &CutoffResult { cutoff_m: own, band_end_m: band_end, plastic_floor: floor, .. } = cutoff;
    let of_points = |value: &dyn Fn(&CutoffPoint) -> f64| cutoff.points.iter().map(value).collect::<Vec<f64>>();
    let (x, mean) = (of_points(&|point| point.cutoff_m), of_points(&|point| point.mean));
    let end = |end: usize| of_points(&|point| point.mean_interval.map_or(f64::NAN, |ends| ends[end]));
    let limits = cutoff.points.iter().any(|point| point.mean_interval.is_some()).then(|| [end(0), end(1)]);
    let finest_mean = cutoff.finer_pitches.last().map(|finest| finest.mean);
    let of_scan = |value: fn(&ScanCutoff) -> f64| -> Vec<f64> {
        scan.map_or_else(Vec::new, |scan| scan.cut_offs.iter().map(value).collect())
    };
    let (scan_x, scan_mean) = (of_scan(|of| of.cutoff_m), of_scan(|of| of.mean));
    let (first, last) = range(positive(&x).chain(positive(&scan_x)).chain([&own]).chain(band_end.as_slice()))?;
    let shown = mean.iter().chain(&scan_mean).chain(floor.as_slice()).chain(finest_mean.as_slice());
    let (low, high) = range(shown.chain(limits.iter().flatten().flatten()))?;
    let x_axis = Axis::logarithmic("Cut-off wavelength", Dimension::Length.unit(last), (first / 1.25, last * 1.25));
    let mut chart = Chart::new(x_axis, Axis::padded("Friction coefficient μ", Unit::none(), (low, high), 0.08));
    if let Some([low, high]) = &limits {
        chart.band("", &x, [low, high], VERMILION);
    }
    chart.points("mean μ, 95 %", &x, &mean, Pen::new(VERMILION, 1.8, Dash::Solid));
    if !scan_x.is_empty() {
        chart.points("the scan itself", &scan_x, &scan_mean, Pen::new(BLACK, 1.2, Dash::Dotted));
    }
    if let Some(y) = finest_mean {
        chart.add("smallest pitch", Mark::Symbol { x: own, y, shape: Shape::OpenDiamond, colour: BLUE });
    }
    if let Some(floor) = floor {
        chart.horizontal("plastic floor τ/H", floor, Pen::new(BLACK, 1.3, Dash::Dashed));
    }
    chart.vertical("cut-off of the study’s strips", own, Pen::new(GREY, 1.5, Dash::Dotted));
    if let Some(end) = band_end {
        chart.vertical("end of the scan’s band", end, Pen::new(GREEN, 1.5, Dash::Long));
    }
    Some(chart)
}
