//! Maps side by side, parameters of the scan among those of the twins, and functions with their bands.

use asperity_results::Table;

use crate::ReportError;
use crate::figures::{CaptionedFigure, columns, positive, raster_panels};
use crate::format::{Dimension, Unit, significant};
use crate::plot::{Axis, BLUE, Chart, Dash, GREY, Kind, Mark, Pen, Raster, SKY, Shape, VERMILION, range};
use crate::twin::run::{TwinRun, distance, inside_share, named, percent, statistics};

/// Draws the figures for which the run holds data.
///
/// # Errors
/// The PNG encoder failed.
pub(super) fn figures(run: &TwinRun) -> Result<Vec<CaptionedFigure>, ReportError> {
    let charts = [parameters(run), density(run), correlation(run), spectrum(run)];
    Ok(maps(run)?.into_iter().chain(charts.into_iter().flatten()).collect())
}

/// Draws the scan and the first two twins on one colour scale, side by side, or one below the other if they are wide.
fn maps(run: &TwinRun) -> Result<Option<CaptionedFigure>, ReportError> {
    /// Least height over width of maps side by side.
    const SIDE_BY_SIDE: f64 = 0.45;
    /// Largest height with one row and with several.
    const WIDE: f64 = 460.0;
    const TALL: f64 = 1000.0;
    let rasters = Raster::with_common_scale(run.scan.iter().chain(run.twins.iter().take(2)), Kind::Height)?;
    let names = run.scan.as_ref().map(|_| "Scan").into_iter().chain(["Twin 1", "Twin 2"]);
    let panels: Vec<(&str, &Raster)> = names.zip(&rasters).collect();
    let in_a_row = rasters.first().is_none_or(|first| first.aspect() >= SIDE_BY_SIDE);
    let (columns, height) = if in_a_row { (panels.len().max(1), WIDE) } else { (1, TALL) };
    let title = "Heights of the scan and of its twins";
    let caption = "Heights relative to their mean, all on one colour scale, which saturates beyond the 0.1 % and 99.9 % quantiles. \
                   The scan is shown after preparation, the twins as drawn.";
    let mut drawn = raster_panels("maps", title, caption, &panels, columns, height);
    drawn.iter_mut().for_each(|figure| figure.sources = vec!["twin_0001".into(), "twin_0002".into()]);
    Ok(drawn)
}

/// Draws every statistic of the scan among those of its twins, in standard deviations of the twins.
fn parameters(run: &TwinRun) -> Option<CaptionedFigure> {
    const ROW: f64 = 21.0;
    const FARTHEST: f64 = 6.0;
    let row = |(key, statistic): (&str, &asperity_results::StatisticComparison)| {
        let (mean, std) = (statistic.mean?, statistic.std?);
        let [low, high] = statistic.band?.map(|end| (end - mean) / std);
        Some((named(key).0, distance(statistic)?, low, high))
    };
    let rows: Vec<(String, f64, f64, f64)> = statistics(&run.comparison).into_iter().filter_map(row).collect();
    let widest = rows.iter().map(|(_, d, low, high)| d.abs().max(-low).max(*high)).reduce(f64::max)?;
    let reach = (1.1 * widest).clamp(3.0, FARTHEST);
    let label = "Distance from the mean of the twins (their standard deviations)";
    let names = Axis::named(rows.iter().map(|(symbol, ..)| symbol.clone()).collect());
    let mut chart = Chart::new(Axis::linear(label, Unit::none(), (-reach, reach)), names);
    chart.height = ROW * rows.len() as f64 + 58.0;
    chart.vertical("", 0.0, Pen::new(GREY, 1.2, Dash::Solid));
    for (row, (_, distance, low, high)) in rows.iter().enumerate() {
        let y = row as f64;
        let pen = Pen { opacity: 0.5, ..Pen::new(SKY, 12.0, Dash::Solid) };
        chart.add("twins, 95 % band", Mark::Span { from: low.max(-reach), to: high.min(reach), y, pen });
        let outside = distance < low || distance > high;
        let (name, colour) = if outside { ("scan, outside", VERMILION) } else { ("scan, within", BLUE) };
        let x = distance.clamp(-reach, reach);
        chart.add(name, Mark::Symbol { x, y, shape: Shape::Disc, colour });
        if outside {
            chart.note(x, y, significant(*distance, 3));
        }
    }
    let title = "Parameters of the scan among those of its twins";
    let caption = "Discs: the scan; bars: the 95 % bands of the twins; zero: the mean of the twins. Discs outside their band are \
                   orange and carry their distance.";
    CaptionedFigure::from_charts("parameters", title, caption, 1, &[chart], &["statistics"])
}

/// A function of the scan with the mean and the band of its twins.
struct Banded<'a> {
    x: &'a [f64],
    scan: &'a [f64],
    mean: Option<&'a [f64]>,
    band: Option<[&'a [f64]; 2]>,
}

impl<'a> Banded<'a> {
    /// Reads a table; `unit` ends the names of its columns.
    fn new(run: &'a TwinRun, table: &str, abscissa: &str, unit: &str) -> Option<Self> {
        let table: &Table = run.tables.get(table)?;
        let [x, scan] = columns(table, [abscissa, &format!("scan{unit}")])?;
        let band = columns(table, [&format!("twins_low{unit}"), &format!("twins_high{unit}")]);
        Some(Self { x, scan, mean: table.defined_column(&format!("twins_mean{unit}")), band })
    }

    /// Returns all values in the figure.
    fn values(&self) -> impl Iterator<Item = &f64> {
        self.scan.iter().chain(self.mean.into_iter().flatten()).chain(self.band.into_iter().flatten().flatten())
    }

    fn draw(&self, chart: &mut Chart) {
        if let Some(band) = self.band {
            chart.band("twins, 95 % band", self.x, band, BLUE);
        }
        if let Some(mean) = self.mean {
            chart.line("twins, mean", self.x, mean, Pen::new(BLUE, 1.4, Dash::Dashed));
        }
        chart.line("scan", self.x, self.scan, Pen::new(VERMILION, 1.8, Dash::Solid));
    }
}

/// Returns a sentence on the fraction of the points inside the band, for the end of a caption.
fn inside_sentence(run: &TwinRun, curves: &[(&str, &str)]) -> String {
    let fractions = curves
        .iter()
        .filter_map(|(curve, points)| Some(format!("{}{points}", percent(inside_share(&run.comparison, curve)?))));
    match fractions.collect::<Vec<_>>().as_slice() {
        [] => String::new(),
        all => format!(" The scan lies in the pointwise band at {}.", all.join(" and ")),
    }
}

fn density(run: &TwinRun) -> Option<CaptionedFigure> {
    const NAME: &str = "height_pdf";
    let curve = Banded::new(run, NAME, "height_m", "_per_m")?;
    let (_, highest) = range(curve.values()).filter(|(_, highest)| *highest > 0.0)?;
    let lowest = positive(curve.scan).copied().fold(highest, f64::min).max(1e-7 * highest);
    let whole = range(curve.x)?;
    // The linear panel shows the body of the distribution, the logarithmic one its tails.
    let body = curve.x.iter().zip(curve.scan).filter(|(_, v)| **v > 2e-3 * highest).map(|(x, _)| x);
    let inner = range(body).filter(|ends| ends.1 > ends.0).unwrap_or(whole);
    let unit = |ends: (f64, f64)| Dimension::Length.unit(ends.0.abs().max(ends.1.abs()));
    let axis = |ends| Axis::linear("Height", unit(ends), ends);
    let linear = Axis::linear("Density", unit(inner).inverse(), (0.0, 1.06 * highest));
    let logarithmic = Axis::logarithmic("Density", unit(whole).inverse(), (0.5 * lowest, 2.0 * highest));
    let charts = [(axis(inner), linear), (axis(whole), logarithmic)].map(|(x, y)| {
        let mut chart = Chart::new(x, y).with_height(300.0);
        curve.draw(&mut chart);
        chart
    });
    let caption = format!(
        "Heights about their mean, form removed; left linear, right logarithmic to show the tails.{}",
        inside_sentence(run, &[(NAME, "")])
    );
    CaptionedFigure::from_charts(NAME, "Probability density of heights", caption, 2, &charts, &[NAME])
}

fn correlation(run: &TwinRun) -> Option<CaptionedFigure> {
    let curves = [("acf_x", "Along x"), ("acf_y", "Along y")];
    let curves = curves.map(|(name, title)| Some((name, title, Banded::new(run, name, "lag_m", "")?)));
    let curves: Vec<_> = curves.into_iter().flatten().collect();
    let (low, high) = range(curves.iter().flat_map(|(_, _, curve)| curve.values()))?;
    let charts = curves.iter().filter_map(|(_, title, curve)| {
        let (first, last) = range(curve.x)?;
        let ends = ((low - 0.04).clamp(-1.0, -0.05), high.clamp(1.0, 1.5) + 0.04);
        let x = Axis::linear("Lag", Dimension::Length.unit(last), (first, last));
        let mut chart = Chart::new(x, Axis::linear("Autocorrelation", Unit::none(), ends)).with_title(title);
        chart.horizontal("", 0.0, Pen::new(GREY, 1.0, Dash::Solid));
        curve.draw(&mut chart);
        Some(chart.with_height(310.0))
    });
    let charts: Vec<Chart> = charts.collect();
    let caption = format!(
        "Autocorrelation up to half of the map.{}",
        inside_sentence(run, &[("acf_x", " of the lags along x"), ("acf_y", " along y")])
    );
    let tables: Vec<&str> = curves.iter().map(|(name, _, _)| *name).collect();
    CaptionedFigure::from_charts("acf", "Autocorrelation of heights", caption, charts.len(), &charts, &tables)
}

fn spectrum(run: &TwinRun) -> Option<CaptionedFigure> {
    let sides = [
        ("psd_x", "Along x", "_m3", Unit::new("µm³", 1e-18)),
        ("psd_y", "Along y", "_m3", Unit::new("µm³", 1e-18)),
        ("psd_radial", "Radial mean", "_m4", Unit::new("µm⁴", 1e-24)),
    ];
    let charts = sides.into_iter().filter_map(|(name, title, suffix, unit)| {
        let curve = Banded::new(run, name, "wavenumber_rad_per_m", suffix)?;
        let (low, high) = range(positive(curve.scan).chain(positive(curve.mean.unwrap_or_default())))?;
        let ends = range(positive(curve.x))?;
        let x = Axis::logarithmic("Wavenumber", Dimension::Wavenumber.unit((ends.0 * ends.1).sqrt()), ends);
        let y = Axis::logarithmic("PSD", unit, (0.4 * low.max(1e-14 * high), 2.5 * high));
        let mut chart = Chart::new(x, y).with_title(title).with_height(330.0);
        curve.draw(&mut chart);
        Some((name, chart))
    });
    let (tables, charts): (Vec<&str>, Vec<Chart>) = charts.unzip();
    let points =
        [("psd_x", " of the wavenumbers along x"), ("psd_y", " along y"), ("psd_radial", " of the wavenumbers")];
    let caption = format!(
        "Power spectral density between the wavenumber of the field and the Nyquist limit of its pixels.{}",
        inside_sentence(run, &points)
    );
    let title = "Power spectral density of heights";
    CaptionedFigure::from_charts("psd", title, caption, charts.len(), &charts, &tables)
}
