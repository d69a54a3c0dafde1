//! Maps side by side, parameters among those of the twins, and functions with their bands.

use crate::axis::{Axis, range};
use crate::canvas::{Align, Canvas, Dash, GRID, INK, LABEL, Pen, Rect, TEXT, draw};
use crate::chart::{Chart, Layout, Mark, figure, fitting_ticks};
use crate::format::{Dimension, Unit, significant};
use crate::palette::{BLUE, GREY, SKY, VERMILION};
use crate::raster::{Kind, Raster};
use crate::{ReportError, Table};

use super::{TwinRun, band_of, distance, named, statistics};

/// A figure with what the page says about it.
pub(super) struct Drawn {
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) caption: String,
    /// Files of the folder that hold what is drawn.
    pub(super) sources: Vec<String>,
    pub(super) svg: String,
}

/// Width of figures that span the page.
const WIDE: f64 = 960.0;

/// All figures for which the run holds data.
pub(super) fn all(run: &TwinRun) -> Result<Vec<Drawn>, ReportError> {
    let mut drawn = Vec::new();
    drawn.extend(maps(run)?);
    drawn.extend(parameters(run)?);
    drawn.extend(density(run)?);
    drawn.extend(correlation(run)?);
    drawn.extend(spectrum(run)?);
    Ok(drawn)
}

/// The scan and the first two twins on one colour scale: side by side, or one below the other where they are wide.
fn maps(run: &TwinRun) -> Result<Option<Drawn>, ReportError> {
    const SIDE_BY_SIDE: f64 = 0.45;
    const TALLEST: f64 = 460.0;
    let fields = run.scan.iter().chain(run.twins.iter().take(2));
    let rasters = Raster::on_one_scale(fields, Kind::Height)?;
    let Some(first) = rasters.first() else { return Ok(None) };
    let names: Vec<String> = (0..rasters.len())
        .map(|i| match (i, run.scan.is_some()) {
            (0, true) => "Scan".to_owned(),
            (i, true) => format!("Twin {i}"),
            (i, false) => format!("Twin {}", i + 1),
        })
        .collect();
    let (left, right, gap, above, below): (f64, f64, f64, f64, f64) = (70.0, 100.0, 20.0, 26.0, 52.0);
    let count = rasters.len() as f64;
    let room = WIDE - left - right;
    let aspect = rasters.iter().map(Raster::aspect).fold(0.0, f64::max);
    let in_a_row = first.aspect() >= SIDE_BY_SIDE;
    let plots: Vec<Rect> = if in_a_row {
        let width = ((room - gap * (count - 1.0)) / count).min(TALLEST / aspect).max(30.0);
        let places = rasters.iter().enumerate();
        places
            .map(|(i, r)| {
                Rect::new(left + i as f64 * (width + gap), above, width, (width * r.aspect()).clamp(30.0, TALLEST))
            })
            .collect()
    } else {
        let mut top = 0.0;
        let mut place = |raster: &Raster| {
            let plot = Rect::new(left, top + above, room, (room * raster.aspect()).max(30.0));
            top = plot.bottom;
            plot
        };
        rasters.iter().map(&mut place).collect()
    };
    let bottom = plots.iter().map(|plot| plot.bottom).fold(0.0, f64::max);
    let edge = plots.iter().map(|plot| plot.right).fold(0.0, f64::max);
    let bar = Rect::new(edge + 18.0, above, 16.0, (bottom - above).clamp(100.0, TALLEST));
    let missing = first.missing > 0 && run.scan.is_some();
    let legend = bottom.max(bar.bottom - below) + below;
    let height = (legend + if missing { 26.0 } else { 4.0 }).ceil();
    let title = "Heights of the scan and of its twins";
    let mut caption =
        "Heights relative to their mean, all on one colour scale, which saturates beyond the 0.1 % and 99.9 % \
                       quantiles. The scan is shown as it was prepared, the twins as they were drawn."
            .to_owned();
    if first.block > 1 {
        caption = format!("{caption} Each pixel is the mean of {block} × {block} points.", block = first.block);
    }
    let svg = draw((WIDE, height), title, &caption, |canvas| {
        for (i, (raster, plot)) in rasters.iter().zip(&plots).enumerate() {
            raster.draw_image(canvas, *plot)?;
            canvas.text((plot.left, plot.top - 12.0), &names[i], LABEL, Align::Start)?;
            let last = i + 1 == rasters.len();
            if in_a_row || last {
                raster.draw_x_axis(canvas, *plot)?;
            }
            if !in_a_row || i == 0 {
                let unit = Dimension::Length.unit(raster.width_m().max(raster.aspect() * raster.width_m()));
                raster.draw_y_axis(canvas, *plot, unit)?;
            }
        }
        first.colour_bar(canvas, bar)?;
        if missing { first.legend(canvas, (left, legend + 8.0)) } else { Ok(()) }
    })?;
    Ok(Some(Drawn { name: "maps", title, caption, sources: vec!["twin_0001".into(), "twin_0002".into()], svg }))
}

/// Every statistic of the scan among those of its twins, in standard deviations of the twins.
fn parameters(run: &TwinRun) -> Result<Option<Drawn>, ReportError> {
    const ROW: f64 = 21.0;
    const FARTHEST: f64 = 6.0;
    let rows: Vec<(String, f64, f64, f64)> = statistics(&run.comparison)
        .into_iter()
        .filter_map(|(key, statistic)| {
            let (mean, std) = (statistic["mean"].as_f64()?, statistic["std"].as_f64()?);
            let (low, high) = band_of(statistic)?;
            Some((named(key).0, distance(statistic)?, (low - mean) / std, (high - mean) / std))
        })
        .collect();
    let Some(widest) = rows.iter().map(|(_, d, low, high)| d.abs().max(-low).max(*high)).reduce(f64::max) else {
        return Ok(None);
    };
    let reach = (1.1 * widest).clamp(3.0, FARTHEST);
    let axis =
        Axis::linear("Distance from the mean of the twins (their standard deviations)", Unit::none(), (-reach, reach));
    let (top, bottom) = (34.0, 34.0 + ROW * rows.len() as f64);
    let plot = Rect { left: 110.0, top, right: 560.0, bottom };
    let place = |value: f64| plot.left + axis.position(value).unwrap_or(0.5).clamp(0.0, 1.0) * plot.width();
    let title = "Parameters of the scan among those of its twins";
    let caption =
        "Discs: the scan; bars: the 95 % bands of the twins; zero: the mean of the twins. Discs outside of their \
                   band are orange and carry their distance."
            .to_owned();
    let svg = draw((640.0, bottom + 54.0), title, &caption, |canvas| {
        legend(canvas, plot.left)?;
        for tick in fitting_ticks(&axis, plot.width()).iter().filter(|tick| !tick.label.is_empty()) {
            let x = plot.left + tick.position * plot.width();
            canvas.line(&[(x, plot.top), (x, plot.bottom)], Pen::new(GRID, 0.8, Dash::Solid))?;
            canvas.line(&[(x, plot.bottom), (x, plot.bottom + 5.0)], Pen::new(INK, 1.0, Dash::Solid))?;
            canvas.text((x, plot.bottom + 15.0), &tick.label, TEXT, Align::Middle)?;
        }
        canvas.line(&[(place(0.0), plot.top), (place(0.0), plot.bottom)], Pen::new(GREY, 1.2, Dash::Solid))?;
        for (i, (symbol, distance, low, high)) in rows.iter().enumerate() {
            let y = plot.top + ROW * (i as f64 + 0.5);
            canvas.text((plot.left - 10.0, y), symbol, TEXT, Align::End)?;
            let (from, to) = (place(*low), place(*high));
            canvas.polygon(&[(from, y - 6.0), (to, y - 6.0), (to, y + 6.0), (from, y + 6.0)], SKY, 0.35)?;
            let outside = distance < low || distance > high;
            canvas.disc((place(*distance), y), 4.0, if outside { VERMILION } else { BLUE })?;
            if outside {
                canvas.text((plot.right + 10.0, y), &significant(*distance, 3), TEXT, Align::Start)?;
            }
        }
        canvas.frame(plot, Pen::new(INK, 1.0, Dash::Solid))?;
        let middle = 0.5 * (plot.left + plot.right);
        canvas.text((middle, plot.bottom + 38.0), &axis.label(), LABEL, Align::Middle)
    })?;
    Ok(Some(Drawn { name: "parameters", title, caption, sources: vec!["tables/statistics.csv".into()], svg }))
}

fn legend(canvas: &mut Canvas<'_>, left: f64) -> Result<(), ReportError> {
    let y = 14.0;
    canvas.disc((left + 6.0, y), 4.0, BLUE)?;
    canvas.text((left + 18.0, y), "scan, within", TEXT, Align::Start)?;
    canvas.disc((left + 126.0, y), 4.0, VERMILION)?;
    canvas.text((left + 138.0, y), "scan, outside", TEXT, Align::Start)?;
    canvas.polygon(
        &[(left + 250.0, y - 6.0), (left + 276.0, y - 6.0), (left + 276.0, y + 6.0), (left + 250.0, y + 6.0)],
        SKY,
        0.35,
    )?;
    canvas.text((left + 284.0, y), "twins, 95 % band", TEXT, Align::Start)
}

/// A function of the scan with the mean and the band of its twins.
struct Banded<'a> {
    x: &'a [f64],
    scan: &'a [f64],
    mean: Option<&'a [f64]>,
    band: Option<(&'a [f64], &'a [f64])>,
}

impl<'a> Banded<'a> {
    /// `unit` ends the names of the columns.
    fn of(run: &'a TwinRun, table: &str, abscissa: &str, unit: &str) -> Option<Self> {
        let table: &Table = run.tables.get(table)?;
        let column = |name: &str| table.column(&format!("{name}{unit}"));
        Some(Self {
            x: table.column(abscissa)?,
            scan: column("scan")?,
            mean: column("twins_mean"),
            band: column("twins_low").zip(column("twins_high")),
        })
    }

    /// All values drawn.
    fn values(&self) -> impl Iterator<Item = f64> + '_ {
        let band = self.band.into_iter().flat_map(|(low, high)| low.iter().chain(high));
        self.scan.iter().chain(self.mean.into_iter().flatten()).chain(band).copied().filter(|v| v.is_finite())
    }

    fn draw(&self, chart: &mut Chart) {
        if let Some((low, high)) = self.band {
            let mark = Mark::Band { x: self.x.to_vec(), low: low.to_vec(), high: high.to_vec(), colour: BLUE };
            chart.add("twins, 95 % band", mark);
        }
        if let Some(mean) = self.mean {
            let pen = Pen::new(BLUE, 1.4, Dash::Dashed);
            chart.add("twins, mean", Mark::Line { x: self.x.to_vec(), y: mean.to_vec(), pen });
        }
        let pen = Pen::new(VERMILION, 1.8, Dash::Solid);
        chart.add("scan", Mark::Line { x: self.x.to_vec(), y: self.scan.to_vec(), pen });
    }
}

/// A share inside as the end of a caption.
fn inside_share(run: &TwinRun, curves: &[(&str, &str)]) -> String {
    let said: Vec<String> = curves
        .iter()
        .filter_map(|(curve, what)| {
            let share = run.comparison["curves"][*curve]["inside_share"].as_f64()?;
            Some(format!("{} %{what}", crate::format::fixed(100.0 * share, 0)))
        })
        .collect();
    if said.is_empty() {
        String::new()
    } else {
        format!(" The scan lies in the pointwise band at {}.", said.join(" and "))
    }
}

fn density(run: &TwinRun) -> Result<Option<Drawn>, ReportError> {
    const NAME: &str = "height_pdf";
    let Some(curve) = Banded::of(run, NAME, "height_m", "_per_m") else { return Ok(None) };
    let highest = curve.values().fold(0.0, f64::max);
    if highest <= 0.0 {
        return Ok(None);
    }
    let lowest = curve.scan.iter().copied().filter(|v| *v > 0.0).fold(highest, f64::min).max(1e-7 * highest);
    // The linear panel shows the body of the law, the logarithmic one its tails.
    let body: Vec<f64> =
        curve.x.iter().zip(curve.scan).filter(|(_, v)| **v > 2e-3 * highest).map(|(x, _)| *x).collect();
    let whole = range(curve.x).unwrap_or((0.0, 1.0));
    let axis = |ends: (f64, f64)| Axis::linear("Height", Dimension::Length.unit(ends.0.abs().max(ends.1.abs())), ends);
    let unit = Dimension::Length.unit(whole.0.abs().max(whole.1.abs()));
    let inner = range(&body).filter(|ends| ends.1 > ends.0).unwrap_or(whole);
    let linear_unit = Dimension::Length.unit(inner.0.abs().max(inner.1.abs()));
    let mut linear = Chart::new(axis(inner), Axis::linear("Density", linear_unit.inverse(), (0.0, 1.06 * highest)));
    curve.draw(&mut linear);
    let mut logarithmic =
        Chart::new(axis(whole), Axis::logarithmic("Density", unit.inverse(), (0.5 * lowest, 2.0 * highest)));
    curve.draw(&mut logarithmic);
    let title = "Probability density of heights";
    let caption = format!(
        "Heights about their mean, form removed; left linear, right logarithmic, where the tails show.{}",
        inside_share(run, &[(NAME, "")])
    );
    let svg = figure(title, &caption, Layout::Row(300.0), &[(0.0, linear), (0.0, logarithmic)])?;
    Ok(Some(Drawn { name: NAME, title, caption, sources: vec![csv(NAME)], svg }))
}

fn correlation(run: &TwinRun) -> Result<Option<Drawn>, ReportError> {
    let found = [("acf_x", "Along x"), ("acf_y", "Along y")]
        .into_iter()
        .filter_map(|(name, title)| Some((title, name, Banded::of(run, name, "lag_m", "")?)));
    let curves: Vec<(&str, &str, Banded<'_>)> = found.collect();
    let values: Vec<f64> = curves.iter().flat_map(|(_, _, curve)| curve.values()).collect();
    let Some((low, high)) = range(&values) else { return Ok(None) };
    let charts = curves.iter().map(|(title, _, curve)| {
        let (first, last) = range(curve.x).unwrap_or((0.0, 1.0));
        let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
        let y = Axis::linear(
            "Autocorrelation",
            Unit::none(),
            ((low - 0.04).clamp(-1.0, -0.05), high.clamp(1.0, 1.5) + 0.04),
        );
        let mut chart = Chart::new(x, y).titled(title);
        chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.0, Dash::Solid) });
        curve.draw(&mut chart);
        (0.0, chart)
    });
    let charts: Vec<(f64, Chart)> = charts.collect();
    let title = "Autocorrelation of heights";
    let caption = format!(
        "Autocorrelation up to half of the map.{}",
        inside_share(run, &[("acf_x", " of the lags along x"), ("acf_y", " along y")])
    );
    let svg = figure(title, &caption, Layout::Row(310.0), &charts)?;
    let sources = curves.iter().map(|(_, name, _)| csv(name)).collect();
    Ok(Some(Drawn { name: "acf", title, caption, sources, svg }))
}

fn spectrum(run: &TwinRun) -> Result<Option<Drawn>, ReportError> {
    let sides = [
        ("psd_x", "Along x", "_m3", Unit::new("µm³", 1e-18)),
        ("psd_y", "Along y", "_m3", Unit::new("µm³", 1e-18)),
        ("psd_radial", "Radial mean", "_m4", Unit::new("µm⁴", 1e-24)),
    ];
    let mut charts = Vec::new();
    let mut sources = Vec::new();
    for (name, title, unit, shown) in sides {
        let Some(curve) = Banded::of(run, name, "wavenumber_rad_per_m", unit) else { continue };
        let positive: Vec<f64> = curve.scan.iter().chain(curve.mean.into_iter().flatten()).copied().collect();
        let positive: Vec<f64> = positive.into_iter().filter(|v| *v > 0.0).collect();
        let wavenumbers: Vec<f64> = curve.x.iter().copied().filter(|q| *q > 0.0).collect();
        let (Some((low, high)), Some(ends)) = (range(&positive), range(&wavenumbers)) else { continue };
        let x = Axis::logarithmic("Wavenumber", Dimension::Wavenumber.unit((ends.0 * ends.1).sqrt()), ends);
        let y = Axis::logarithmic("PSD", shown, (0.4 * low.max(1e-14 * high), 2.5 * high));
        let mut chart = Chart::new(x, y).titled(title);
        curve.draw(&mut chart);
        charts.push((0.0, chart));
        sources.push(csv(name));
    }
    if charts.is_empty() {
        return Ok(None);
    }
    let title = "Power spectral density of heights";
    let caption = format!(
        "Power spectral density between the wavenumber of the field and the Nyquist limit of its pixels.{}",
        inside_share(
            run,
            &[("psd_x", " of the wavenumbers along x"), ("psd_y", " along y"), ("psd_radial", " of the wavenumbers")]
        )
    );
    let svg = figure(title, &caption, Layout::Row(330.0), &charts)?;
    Ok(Some(Drawn { name: "psd", title, caption, sources, svg }))
}

fn csv(table: &str) -> String {
    format!("tables/{table}.csv")
}
