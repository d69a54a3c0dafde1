//! Height maps, height density, autocorrelation and spectrum.

use super::{Plate, Stage, columns, csv, map};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, GREY, SKY, VERMILION};
use crate::raster::Kind;
use crate::{ReportError, Run};

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    maps(run, plates)?;
    density(run, plates)?;
    autocorrelation(run, plates)?;
    spectrum(run, plates)
}

fn maps(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let maps = [
        ("height_raw", "Heights as measured"),
        ("height_levelled", "Heights after levelling"),
        ("surface_sample", "One realisation of the random surface"),
    ];
    let caption = "Heights relative to their mean; the colours saturate beyond the 0.1 % and 99.9 % quantiles.";
    for (name, title) in maps {
        plates.extend(map(run, (name, Stage::Surface), Kind::Height, title, caption)?);
    }
    Ok(())
}

fn density(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "height_pdf";
    let Some(table) = run.tables.get(NAME) else { return Ok(()) };
    let Some([x, measured]) = columns(table, ["height_m", "density_per_m"]) else { return Ok(()) };
    let fits = [
        ("fitted_density_per_m", "fitted law", Pen::new(VERMILION, 1.8, Dash::Solid)),
        ("normal_density_per_m", "normal law", Pen::new(BLACK, 1.6, Dash::Dashed)),
    ];
    let unit = Dimension::Length.unit(range(x).map_or(0.0, |(low, high)| low.abs().max(high.abs())));
    let shown = fits.iter().filter_map(|(name, _, _)| table.column(name));
    let highest = shown.chain([measured]).flatten().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let lowest = measured.iter().copied().filter(|v| *v > 0.0).fold(highest, f64::min).max(highest * 1e-7);
    if highest <= 0.0 {
        return Ok(());
    }
    let axis = || Axis::linear("Height", unit.clone(), range(x).unwrap_or((0.0, 1.0)));
    let mut linear = Chart::new(axis(), Axis::linear("Density", unit.inverse(), (0.0, 1.06 * highest)));
    let mut logarithmic =
        Chart::new(axis(), Axis::logarithmic("Density", unit.inverse(), (0.3 * lowest, 2.0 * highest)));
    linear.add("measured", Mark::Bars { x: x.to_vec(), y: measured.to_vec(), colour: BLUE });
    let positive = measured.iter().map(|v| if *v > 0.0 { *v } else { f64::NAN }).collect();
    let points = Pen { opacity: 0.35, ..Pen::new(BLUE, 0.8, Dash::Solid) };
    logarithmic.add(None, Mark::Points { x: x.to_vec(), y: positive, pen: points });
    for (name, label, pen) in fits {
        if let Some(y) = table.column(name) {
            for chart in [&mut linear, &mut logarithmic] {
                chart.add(label, Mark::Line { x: x.to_vec(), y: y.to_vec(), pen });
            }
        }
    }
    let title = "Probability density of heights";
    let caption = "Density of the levelled heights with the fitted law and the normal law of equal mean and standard \
                   deviation; left linear, right logarithmic, where the tails show."
        .to_owned();
    let svg = figure(title, &caption, Layout::Row(300.0), &[(0.0, linear), (0.0, logarithmic)])?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Surface, title: title.into(), caption, sources, svg });
    Ok(())
}

fn autocorrelation(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "height_acf";
    let Some(table) = run.tables.get(NAME) else { return Ok(()) };
    let Some([lag]) = columns(table, ["lag_m"]) else { return Ok(()) };
    let curves = [
        ("acf_x", "measured, x", Pen::new(BLUE, 2.0, Dash::Solid)),
        ("acf_y", "measured, y", Pen::new(SKY, 2.0, Dash::Long)),
        ("fit_x", "model, x", Pen::new(VERMILION, 1.6, Dash::Dashed)),
        ("fit_y", "model, y", Pen::new(BLACK, 1.6, Dash::Dotted)),
    ];
    let Some((low, high)) = range(curves.iter().filter_map(|c| table.column(c.0)).flatten()) else { return Ok(()) };
    let Some((first, last)) = range(lag) else { return Ok(()) };
    let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
    let y = Axis::linear("Autocorrelation", Unit::none(), ((low - 0.04).min(-0.05), high.max(1.0) + 0.04));
    let mut chart = Chart::new(x, y);
    chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
    let decay = Pen::new(GREY, 1.0, Dash::Dotted);
    chart.add("1/e", Mark::Horizontal { y: (-1f64).exp(), pen: decay });
    for (name, label, pen) in curves {
        if let Some(y) = table.column(name) {
            chart.add(label, Mark::Line { x: lag.to_vec(), y: y.to_vec(), pen });
        }
    }
    let title = "Autocorrelation of heights";
    let caption = "Autocorrelation of the levelled heights along x and y with the covariance model that the random \
                   surface uses; the correlation length is read where the curve falls to 1/e."
        .to_owned();
    let svg = figure(title, &caption, Layout::Column, &[(350.0, chart)])?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Surface, title: title.into(), caption, sources, svg });
    Ok(())
}

fn spectrum(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const NAME: &str = "height_psd";
    let Some(table) = run.tables.get(NAME) else { return Ok(()) };
    let Some([wavenumber]) = columns(table, ["wavenumber_rad_per_m"]) else { return Ok(()) };
    let curves = [
        ("psd_x_m3", "measured, x", Pen::new(BLUE, 1.5, Dash::Solid)),
        ("psd_y_m3", "measured, y", Pen::new(SKY, 1.5, Dash::Long)),
        ("psd_model_x_m3", "model, x", Pen::new(VERMILION, 1.8, Dash::Dashed)),
    ];
    let positive = |values: &[f64]| values.iter().copied().filter(|v| *v > 0.0).collect::<Vec<_>>();
    let Some(x_range) = range(&positive(wavenumber)) else { return Ok(()) };
    let measured: Vec<f64> = curves[..2].iter().filter_map(|c| table.column(c.0)).flat_map(positive).collect();
    let model: Vec<f64> = table.column(curves[2].0).map(positive).unwrap_or_default();
    let Some((mut low, mut high)) = range(&measured).or(range(&model)) else { return Ok(()) };
    // A smooth model can fall by hundreds of decades; it must not flatten what was measured.
    if let Some((model_low, model_high)) = range(&model) {
        (low, high) = (model_low.clamp(1e-2 * low, low), high.max(model_high));
    }
    low = low.max(1e-14 * high);
    let x = Axis::logarithmic("Wavenumber", Dimension::Wavenumber.unit((x_range.0 * x_range.1).sqrt()), x_range);
    let y = Axis::logarithmic("PSD", Unit::new("µm³", 1e-18), (0.5 * low, 2.0 * high));
    let mut chart = Chart::new(x, y);
    for (name, label, pen) in curves {
        if let Some(y) = table.column(name) {
            chart.add(label, Mark::Line { x: wavenumber.to_vec(), y: y.to_vec(), pen });
        }
    }
    let title = "Power spectral density of heights";
    let caption =
        "One-dimensional power spectral density of the levelled heights and of the covariance model, between \
                   the wavenumber of the field and the Nyquist limit of its pixels."
            .to_owned();
    let svg = figure(title, &caption, Layout::Column, &[(380.0, chart)])?;
    let sources = vec![csv(NAME)];
    plates.push(Plate { name: NAME, stage: Stage::Surface, title: title.into(), caption, sources, svg });
    Ok(())
}
