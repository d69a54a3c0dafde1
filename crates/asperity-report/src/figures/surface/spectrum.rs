//! Power spectral density: the radial mean, and profiles along x and y.

use super::{Plate, Stage, columns, csv, scan, which};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::format::{Dimension, Unit};
use crate::palette::{BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION};
use crate::{ReportError, Run};

/// Table of the profiles at all wavenumbers, which runs always have.
const ALL: &str = "height_psd";
const RADIAL: &str = "height_psd_radial";
const PROFILES: [&str; 2] = ["height_psd_x", "height_psd_y"];

/// One measured spectrum with its band and its model.
struct Spectrum<'a> {
    q: &'a [f64],
    psd: &'a [f64],
    band: Option<[&'a [f64]; 2]>,
    model: Option<&'a [f64]>,
    /// What tells it from the others.
    what: &'static str,
    pens: [Pen; 2],
}

impl<'a> Spectrum<'a> {
    /// From a table in bins; `unit` ends the names of its columns.
    fn binned(run: &'a Run, table: &str, unit: &str, what: &'static str, pens: [Pen; 2]) -> Option<Self> {
        let table = run.tables.get(table)?;
        let column = |name: &str| table.column(&format!("{name}_{unit}"));
        Some(Self {
            q: table.column("wavenumber_rad_per_m")?,
            psd: column("psd")?,
            band: column("psd_low").zip(column("psd_high")).map(Into::into),
            model: column("psd_model"),
            what,
            pens,
        })
    }

    /// From the table at all wavenumbers.
    fn profile(run: &'a Run, axis: &'static str, what: &'static str, pens: [Pen; 2]) -> Option<Self> {
        let table = run.tables.get(ALL)?;
        let [q, psd] = columns(table, ["wavenumber_rad_per_m", &format!("psd_{axis}_m3")])?;
        let model = table.column(&format!("psd_model_{axis}_m3"));
        Some(Self { q, psd, band: None, model, what, pens })
    }

    fn positive(values: &[f64]) -> impl Iterator<Item = &f64> {
        values.iter().filter(|v| **v > 0.0)
    }

    fn draw(&self, chart: &mut Chart) {
        let [pen, model] = self.pens;
        let named = |name: &str| format!("{name}, {}", self.what);
        if let Some([low, high]) = self.band {
            let band = Mark::Band { x: self.q.to_vec(), low: low.to_vec(), high: high.to_vec(), colour: pen.colour };
            chart.add("95 % bands", band);
        }
        let curve = |y: &[f64], pen| Mark::Line { x: self.q.to_vec(), y: y.to_vec(), pen };
        chart.add_named(named("measured"), curve(self.psd, pen));
        if let Some(y) = self.model {
            chart.add_named(named("model"), curve(y, model));
        }
    }
}

/// The wavenumbers at which spectra can be relied on, and what ends them.
struct Reliable {
    low: f64,
    high: f64,
    /// What sets the upper end: in the figure, and in its caption.
    limit: Option<(&'static str, &'static str)>,
}

impl Reliable {
    fn of(run: &Run) -> Option<Self> {
        let scan = scan(run)?;
        let limit = match scan.psd_upper_limit.as_str() {
            "pixel" => Some(("pixels", "half of the pixels’ Nyquist wavenumber")),
            "roll_off" => Some(("roll-off", "the roll-off of the instrument, a filter or a smooth surface")),
            "noise_floor" => Some(("noise", "the noise floor")),
            _ => None,
        };
        Some(Self { low: scan.psd_reliable_low_rad_per_m, high: scan.psd_reliable_high_rad_per_m, limit })
    }

    /// Names of the regions, where no falling spectrum is in the way: at the lower left and the upper right.
    fn notes(&self, chart: &mut Chart) {
        let ((x_low, x_high), (y_low, y_high)) = (chart.x.ends(), chart.y.ends());
        let high = self.high.max(self.low);
        let share = (y_high / y_low).powf(0.08);
        if self.low > x_low {
            chart.add(None, Mark::Note { x: (x_low * self.low).sqrt(), y: y_low, text: "field".into() });
        }
        if let Some((name, _)) = self.limit.filter(|_| high < x_high) {
            chart.add(None, Mark::Note { x: (x_high * high).sqrt(), y: y_high / share, text: name.into() });
        }
    }

    fn draw(&self, chart: &mut Chart) {
        let high = self.high.max(self.low);
        let edge = Pen::new(GREY, 1.1, Dash::Dashed);
        chart.add("outside the reliable band", Mark::Region { from: 0.0, to: self.low, colour: GREY });
        chart.add(None, Mark::Region { from: high, to: f64::MAX, colour: GREY });
        chart.add(None, Mark::Vertical { x: self.low, pen: edge });
        chart.add(None, Mark::Vertical { x: high, pen: edge });
    }
}

/// A chart of spectra in one unit over the wavenumbers of the figure; none without a positive density.
fn chart(
    (title, label, unit): (&str, &str, Unit),
    x_range: (f64, f64),
    spectra: &[Spectrum<'_>],
    reliable: Option<&Reliable>,
) -> Option<Chart> {
    let measured = range(spectra.iter().flat_map(|s| Spectrum::positive(s.psd)));
    let models = range(spectra.iter().filter_map(|s| s.model).flat_map(Spectrum::positive));
    let (mut low, mut high) = measured.or(models)?;
    // A smooth model can fall by hundreds of decades; it must not flatten what was measured.
    if let Some((model_low, model_high)) = models {
        (low, high) = (model_low.clamp(1e-2 * low, low), high.max(model_high));
    }
    // Bands of few coefficients reach far up; a part of them is enough.
    let bands = range(spectra.iter().filter_map(|s| s.band).flat_map(|[_, high]| Spectrum::positive(high)));
    high = bands.map_or(high, |(_, band)| high.max(band.min(3.0 * high)));
    low = low.max(1e-14 * high);
    let middle = (x_range.0 * x_range.1).sqrt();
    let x = Axis::logarithmic("Wavenumber q", Dimension::Wavenumber.unit(middle), x_range);
    let mut chart = Chart::new(x, Axis::logarithmic(label, unit, (0.4 * low, 2.5 * high))).titled(title);
    if let Some(reliable) = reliable {
        reliable.draw(&mut chart);
    }
    spectra.iter().for_each(|spectrum| spectrum.draw(&mut chart));
    if let Some(reliable) = reliable {
        reliable.notes(&mut chart);
    }
    Some(chart)
}

pub(super) fn plate(run: &Run) -> Result<Option<Plate>, ReportError> {
    let radial_pens = [Pen::new(BLUE, 1.9, Dash::Solid), Pen::new(BLACK, 1.5, Dash::Dashed)];
    let pens = [
        ("x", "x", [Pen::new(PURPLE, 1.9, Dash::Solid), Pen::new(BLACK, 1.6, Dash::Dotted)]),
        ("y", "y", [Pen::new(VERMILION, 1.9, Dash::Long), Pen::new(GREEN, 1.6, Dash::Alternating)]),
    ];
    let radial: Vec<Spectrum<'_>> = Spectrum::binned(run, RADIAL, "m4", "radial", radial_pens).into_iter().collect();
    let profiles: Vec<Spectrum<'_>> = pens
        .into_iter()
        .zip(PROFILES)
        .filter_map(|((axis, what, pens), table)| {
            Spectrum::binned(run, table, "m3", what, pens).or_else(|| Spectrum::profile(run, axis, what, pens))
        })
        .collect();
    let reliable = Reliable::of(run).filter(|_| !radial.is_empty());
    // One axis for both charts, so that wavenumbers stand below each other.
    let wavenumbers = radial.iter().chain(&profiles).flat_map(|spectrum| Spectrum::positive(spectrum.q));
    let Some(x_range) = range(wavenumbers) else { return Ok(None) };
    let of_map = ("Radial mean of the map’s spectrum", "PSD C", Unit::new("µm⁴", 1e-24));
    let of_profiles = ("Mean spectrum of profiles", "PSD C₁", Unit::new("µm³", 1e-18));
    let charts: Vec<(f64, Chart)> =
        [chart(of_map, x_range, &radial, reliable.as_ref()), chart(of_profiles, x_range, &profiles, reliable.as_ref())]
            .into_iter()
            .flatten()
            .map(|chart| (if radial.is_empty() { 380.0 } else { 320.0 }, chart))
            .collect();
    if charts.is_empty() {
        return Ok(None);
    }
    let title = "Power spectral density of heights";
    let mut caption =
        "Two-sided power spectral densities of the levelled heights and of the covariance model, between the \
                       wavenumber of the field and the Nyquist limit of its pixels."
            .to_owned();
    if profiles.iter().chain(&radial).any(|spectrum| spectrum.band.is_some()) {
        caption += " Means over bins of a sixth of an octave; ribbons are the 95 % bands of these means, chi-square with the \
                    independent Fourier coefficients of the bin.";
    }
    if let Some(reliable) = &reliable {
        caption += match reliable.high > reliable.low {
            true => " Shaded wavenumbers are not reliable in the radial mean: below, field and levelling rule",
            false => " No wavenumber is reliable: field and levelling rule below",
        };
        caption += &reliable.limit.map_or(".".to_owned(), |(_, limit)| format!("; the upper end is {limit}."));
    }
    caption += &which(run);
    let svg = figure(title, &caption, Layout::Column, &charts)?;
    let tables = [RADIAL, PROFILES[0], PROFILES[1], ALL];
    let sources = tables.into_iter().filter(|table| run.tables.contains_key(*table)).map(csv).collect();
    Ok(Some(Plate { name: ALL, stage: Stage::Surface, title: title.into(), caption, sources, svg }))
}
