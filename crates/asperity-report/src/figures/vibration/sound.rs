//! The power spectrum of the velocity.

use std::f64::consts::TAU;

use asperity_results::{Pair, SoundSpectrum};

use crate::figures::vibration::curves::Tables;
use crate::figures::{CaptionedFigure, defined, positive};
use crate::format::{Unit, fixed, show_range, significant};
use crate::plot::{Axis, BLUE, Chart, Dash, Pen, VERMILION, range};

/// Draws the spectrum with the level and its interval in the title, and a line at the frequency of the limit cycle.
pub(super) fn figure(
    level: Option<(f64, Option<Pair>)>,
    cycle_period: Option<f64>,
    tables: &Tables,
) -> Option<CaptionedFigure> {
    let SoundSpectrum { frequency, density, density_low, density_high } =
        SoundSpectrum::of(tables.get("sound_spectrum")?);
    let [frequency, density] = defined([&frequency, &density])?;
    let band = defined([&density_low, &density_high]);
    let values = positive(density).chain(band.into_iter().flatten().flat_map(positive));
    let (x, y) = (range(positive(frequency))?, range(values)?);
    let x = Axis::logarithmic("Frequency ω/ω₀", Unit::none(), (x.0 / 1.1, x.1 * 1.1));
    let y = Axis::logarithmic("Power spectral density of dX/dτ", Unit::none(), (y.0 / 2.0, y.1 * 2.0));
    let mut chart = Chart::new(x, y).with_height(380.0);
    if let Some([low, high]) = band {
        // A limit at zero has no place on the axis; the band ends with the axis.
        let (low_end, _) = chart.y.ends();
        let low: Vec<f64> = low.iter().map(|v| if *v > 0.0 { *v } else { low_end }).collect();
        chart.band("95 % band", frequency, [&low, high], BLUE);
    }
    chart.line("velocity of the mass", frequency, density, Pen::new(BLUE, 2.0, Dash::Solid));
    if let Some(period) = cycle_period.filter(|period| *period > 0.0) {
        let name = format!("limit cycle, ω/ω₀ = {}", significant(TAU / period, 4));
        chart.vertical(name, TAU / period, Pen::new(VERMILION, 1.8, Dash::Dashed));
    }
    if let Some((level, interval)) = level {
        chart = chart.with_title(&sentence(level, interval));
    }
    let caption = "One-sided power spectral density of the velocity dX/dτ over the frequency relative to the natural frequency; its \
                   integral is the variance.";
    CaptionedFigure::from_charts("sound_spectrum", "Spectrum of the velocity", caption, 1, &[chart], &[])
}

/// Returns the level in a sentence.
fn sentence(level: f64, interval: Option<Pair>) -> String {
    let interval = interval.map_or(String::new(), |[low, high]| format!(" {}", show_range(low, high)));
    format!("Level over the limit cycle without fluctuation: {} dB{interval}", fixed(level, 2))
}
