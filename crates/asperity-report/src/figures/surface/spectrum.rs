//! Power spectral density: the radial mean, and profiles along x and y.

use crate::Run;
use crate::figures::surface::scan::{scan, scan_sentence};
use crate::figures::{CaptionedFigure, columns, positive, present};
use crate::format::{Dimension, Unit};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, GREEN, GREY, Mark, PURPLE, Pen, VERMILION, range};

/// Table of the profiles at all wavenumbers, which every run has.
const ALL: &str = "height_psd";
const RADIAL: &str = "height_psd_radial";
const PROFILES: [&str; 2] = ["height_psd_x", "height_psd_y"];

/// One measured spectrum with its band and its model.
struct Spectrum<'a> {
    q: &'a [f64],
    psd: &'a [f64],
    band: Option<[&'a [f64]; 2]>,
    model: Option<&'a [f64]>,
    /// Name in the legend: `radial`, `x` or `y`.
    name: &'static str,
    pens: [Pen; 2],
}

impl<'a> Spectrum<'a> {
    /// Reads a table in bins; `unit` ends the names of its columns.
    fn binned(run: &'a Run, table: &str, unit: &str, name: &'static str, pens: [Pen; 2]) -> Option<Self> {
        let table = run.tables.get(table)?;
        let [q, psd] = columns(table, ["wavenumber_rad_per_m", &format!("psd_{unit}")])?;
        let band = columns(table, [&format!("psd_low_{unit}"), &format!("psd_high_{unit}")]);
        Some(Self { q, psd, band, model: table.defined_column(&format!("psd_model_{unit}")), name, pens })
    }

    /// Reads the table at all wavenumbers.
    fn profile(run: &'a Run, axis: &'static str, pens: [Pen; 2]) -> Option<Self> {
        let table = run.tables.get(ALL)?;
        let [q, psd] = columns(table, ["wavenumber_rad_per_m", &format!("psd_{axis}_m3")])?;
        let model = table.defined_column(&format!("psd_model_{axis}_m3"));
        Some(Self { q, psd, band: None, model, name: axis, pens })
    }

    fn draw(&self, chart: &mut Chart) {
        let [pen, model] = self.pens;
        if let Some(band) = self.band {
            chart.band("", self.q, band, pen.colour);
        }
        chart.line(format!("measured, {}", self.name), self.q, self.psd, pen);
        if let Some(y) = self.model {
            chart.line(format!("model, {}", self.name), self.q, y, model);
        }
    }
}

/// The wavenumbers at which spectra are reliable, and the limit at the upper end.
struct Reliable {
    low: f64,
    high: f64,
    /// Name of the upper limit in the figure and in its caption.
    limit: Option<(&'static str, &'static str)>,
}

impl Reliable {
    fn new(run: &Run) -> Option<Self> {
        let scan = scan(run)?;
        let limit = match scan.psd_upper_limit.as_str() {
            "pixel" => Some(("pixels", "half of the pixels’ Nyquist wavenumber")),
            "roll_off" => Some(("roll-off", "the roll-off of the instrument, a filter or a smooth surface")),
            "noise_floor" => Some(("noise", "the noise floor")),
            _ => None,
        };
        Some(Self { low: scan.psd_reliable_low_rad_per_m, high: scan.psd_reliable_high_rad_per_m, limit })
    }

    /// Names the regions at the lower left and the upper right, away from falling spectra.
    fn note(&self, chart: &mut Chart) {
        let ((x_low, x_high), (y_low, y_high)) = (chart.x.ends(), chart.y.ends());
        let high = self.high.max(self.low);
        if self.low > x_low {
            chart.note((x_low * self.low).sqrt(), y_low, "field");
        }
        if let Some((name, _)) = self.limit.filter(|_| high < x_high) {
            chart.note((x_high * high).sqrt(), y_high / (y_high / y_low).powf(0.08), name);
        }
    }

    fn draw(&self, chart: &mut Chart) {
        let high = self.high.max(self.low);
        let edge = Pen::new(GREY, 1.1, Dash::Dashed);
        chart.add("", Mark::Region { from: 0.0, to: self.low, colour: GREY });
        chart.add("", Mark::Region { from: high, to: f64::MAX, colour: GREY });
        chart.vertical("", self.low, edge);
        chart.vertical("", high, edge);
    }

    fn sentence(&self) -> String {
        let range = match self.high > self.low {
            true => " Shaded wavenumbers are not reliable in the radial mean. Field and levelling set the lower end",
            false => " No wavenumber is reliable. Field and levelling set the lower end",
        };
        format!("{range}{}.", self.limit.map_or(String::new(), |(_, limit)| format!("; the upper end is {limit}")))
    }
}

/// Draws spectra in one unit over the wavenumbers of the figure; `None` without a positive density.
fn chart(
    (title, label, unit): (&str, &str, Unit),
    x_range: (f64, f64),
    spectra: &[Spectrum<'_>],
    reliable: Option<&Reliable>,
) -> Option<Chart> {
    let measured = range(spectra.iter().flat_map(|s| positive(s.psd)));
    let models = range(spectra.iter().filter_map(|s| s.model).flat_map(positive));
    let (mut low, mut high) = measured.or(models)?;
    // A smooth model can fall by hundreds of decades; it must not flatten the measured spectrum.
    if let Some((model_low, model_high)) = models {
        (low, high) = (model_low.clamp(1e-2 * low, low), high.max(model_high));
    }
    // Bands of few coefficients reach far up and are cut off.
    let bands = range(spectra.iter().filter_map(|s| s.band).flat_map(|[_, high]| positive(high)));
    high = bands.map_or(high, |(_, band)| high.max(band.min(3.0 * high)));
    low = low.max(1e-14 * high);
    let middle = (x_range.0 * x_range.1).sqrt();
    let x = Axis::logarithmic("Wavenumber q", Dimension::Wavenumber.unit(middle), x_range);
    let mut chart = Chart::new(x, Axis::logarithmic(label, unit, (0.4 * low, 2.5 * high))).with_title(title);
    reliable.into_iter().for_each(|reliable| reliable.draw(&mut chart));
    spectra.iter().for_each(|spectrum| spectrum.draw(&mut chart));
    reliable.into_iter().for_each(|reliable| reliable.note(&mut chart));
    Some(chart)
}

pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let radial_pens = [Pen::new(BLUE, 1.9, Dash::Solid), Pen::new(BLACK, 1.5, Dash::Dashed)];
    let pens = [
        ("x", [Pen::new(PURPLE, 1.9, Dash::Short), Pen::new(BLACK, 1.6, Dash::Dotted)]),
        ("y", [Pen::new(VERMILION, 1.9, Dash::Long), Pen::new(GREEN, 1.6, Dash::Alternating)]),
    ];
    let radial: Vec<Spectrum<'_>> = Spectrum::binned(run, RADIAL, "m4", "radial", radial_pens).into_iter().collect();
    let profiles = pens.into_iter().zip(PROFILES).filter_map(|((axis, pens), table)| {
        Spectrum::binned(run, table, "m3", axis, pens).or_else(|| Spectrum::profile(run, axis, pens))
    });
    let profiles: Vec<Spectrum<'_>> = profiles.collect();
    let reliable = Reliable::new(run).filter(|_| !radial.is_empty());
    // Both charts have the same axis, so that equal wavenumbers are aligned.
    let x_range = range(radial.iter().chain(&profiles).flat_map(|spectrum| positive(spectrum.q)))?;
    let of_map = ("Radial mean of the map’s spectrum", "PSD C", Unit::new("µm⁴", 1e-24));
    let of_profiles = ("Mean spectrum of profiles", "PSD C₁", Unit::new("µm³", 1e-18));
    let height = if radial.is_empty() { 380.0 } else { 320.0 };
    let charts: Vec<Chart> = [(of_map, &radial), (of_profiles, &profiles)]
        .into_iter()
        .filter_map(|(labels, spectra)| Some(chart(labels, x_range, spectra, reliable.as_ref())?.with_height(height)))
        .collect();
    let mut caption =
        "Two-sided power spectral densities of the levelled heights and of the covariance model, between the \
                       wavenumber of the field and the Nyquist limit of its pixels."
            .to_owned();
    if profiles.iter().chain(&radial).any(|spectrum| spectrum.band.is_some()) {
        caption += " Means over bins of a sixth of an octave; ribbons are the 95 % bands of these means, chi-square with the \
                    independent Fourier coefficients of the bin.";
    }
    caption += &reliable.as_ref().map_or_else(String::new, Reliable::sentence);
    caption += &scan_sentence(run);
    let tables = present(run, &[RADIAL, PROFILES[0], PROFILES[1], ALL]);
    CaptionedFigure::from_charts(ALL, "Power spectral density of heights", caption, 1, &charts, &tables)
}
