//! The power spectrum of the velocity.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use serde_json::Value;

use super::{Words, columns};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark};
use crate::format::{Unit, fixed, show_range, significant};
use crate::palette::{BLUE, VERMILION};
use crate::{Figure, ReportError, Table};

pub(super) fn figure(answer: &Value, tables: &BTreeMap<String, Table>) -> Result<Option<Figure>, ReportError> {
    let Some(table) = tables.get("sound_spectrum") else { return Ok(None) };
    let Some([frequency, density]) = columns(table, ["frequency", "density"]) else { return Ok(None) };
    let band = columns(table, ["density_low", "density_high"]);
    let positive = |values: &&f64| **values > 0.0;
    let values = density.iter().chain(band.into_iter().flatten().flatten()).filter(positive);
    let (Some(x), Some(y)) = (range(frequency.iter().filter(positive)), range(values)) else { return Ok(None) };
    let x = Axis::logarithmic("Frequency ω/ω₀", Unit::none(), (x.0 / 1.1, x.1 * 1.1));
    let y = Axis::logarithmic("Power spectral density of dX/dτ", Unit::none(), (y.0 / 2.0, y.1 * 2.0));
    let mut chart = Chart::new(x, y);
    if let Some([low, high]) = band {
        // A limit at zero has no place on the axis; the band ends there with it.
        let (low_end, _) = chart.y.ends();
        let low = low.iter().map(|v| if *v > 0.0 { *v } else { low_end }).collect();
        chart.add("95 % band", Mark::Band { x: frequency.to_vec(), low, high: high.to_vec(), colour: BLUE });
    }
    let pen = Pen::new(BLUE, 2.0, Dash::Solid);
    chart.add("velocity of the mass", Mark::Line { x: frequency.to_vec(), y: density.to_vec(), pen });
    if let Some(period) = answer["cycle_period"].as_f64().filter(|period| *period > 0.0) {
        let name = format!("limit cycle, ω/ω₀ = {}", significant(TAU / period, 5));
        chart.add_named(name, Mark::Vertical { x: TAU / period, pen: Pen::new(VERMILION, 1.8, Dash::Dashed) });
    }
    if let Some(level) = level(answer) {
        chart = chart.titled(&level);
    }
    let words = Words {
        name: "sound_spectrum",
        title: "Spectrum of the velocity",
        description: "One-sided power spectral density of the velocity dX/dτ over the frequency in natural frequencies; its integral is \
                      the variance.",
    };
    words.figure(Layout::Column, &[(380.0, chart)])
}

/// The level in a sentence.
fn level(answer: &Value) -> Option<String> {
    let level = answer["level_db"].as_f64()?;
    let interval = answer["level_db_interval"][0].as_f64().zip(answer["level_db_interval"][1].as_f64());
    let interval = interval.map_or(String::new(), |(low, high)| format!(" {}", show_range(low, high)));
    Some(format!("Level over the limit cycle without fluctuation: {} dB{interval}", fixed(level, 2)))
}
