//! Fig. 2 of the paper: the distribution function of the pressure by every method.

use super::{BAND, style};
use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure};
use crate::figures::{Plate, Stage, columns, csv};
use crate::format::{Dimension, Unit};
use crate::page::method_name;
use crate::palette::{BLACK, GREY, ORANGE};
use crate::{ReportError, Run, Table};

const NAME: &str = "pressure_cdf";
const BANDS: &str = "pressure_bands";

/// The column that the others are compared with.
fn reference(table: &Table) -> Option<&'static str> {
    ["reference", "monte_carlo"].into_iter().find(|name| table.column(name).is_some())
}

/// The default's limits at its own pressures, pointwise and simultaneous.
struct Limits<'a> {
    pressure: &'a [f64],
    pointwise: [&'a [f64]; 2],
    simultaneous: [&'a [f64]; 2],
}

impl<'a> Limits<'a> {
    fn of(run: &'a Run) -> Option<Self> {
        let names = ["pressure_pa", "pointwise_low", "pointwise_high", "simultaneous_low", "simultaneous_high"];
        let names = names.map(|name| format!("default_{name}"));
        let table = run.tables.get(BANDS)?;
        let [pressure, a, b, c, d] = columns(table, names.each_ref().map(String::as_str))?;
        Some(Self { pressure, pointwise: [a, b], simultaneous: [c, d] })
    }

    /// Adds both bands, less a curve.
    fn add_to(&self, chart: &mut Chart, less: impl Fn(f64) -> f64) {
        let shifted = |limit: &[f64]| limit.iter().zip(self.pressure).map(|(f, p)| f - less(*p)).collect::<Vec<f64>>();
        for (name, limits, colour) in [
            ("default: 95 %, all pressures at once", self.simultaneous, ORANGE),
            ("default: 95 %, at one pressure", self.pointwise, BAND),
        ] {
            let [low, high] = limits.map(shifted);
            chart.add(name, Mark::Band { x: self.pressure.to_vec(), low, high, colour });
        }
    }

    /// Largest half width of the simultaneous band.
    fn reach(&self) -> f64 {
        let [low, high] = self.simultaneous;
        low.iter().zip(high).map(|(low, high)| 0.5 * (high - low)).filter(|w| w.is_finite()).fold(0.0, f64::max)
    }
}

/// A larger difference of neighbours is a jump.
const JUMP: f64 = 0.02;

/// A tabulated distribution function between its points: linear, but for jumps; constant beyond.
fn interpolated(x: &[f64], y: &[f64], at: f64) -> f64 {
    let after = x.partition_point(|x| *x <= at);
    match (after.checked_sub(1), x.get(after)) {
        (None, _) => y[0],
        (Some(last), None) => y[last],
        (Some(low), Some(_)) if y[after] - y[low] > JUMP => y[low],
        (Some(low), Some(_)) => y[low] + (at - x[low]) / (x[after] - x[low]) * (y[after] - y[low]),
    }
}

pub(super) fn plate(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(table) = run.tables.get(NAME) else { return Ok(()) };
    let Some([pressure]) = columns(table, ["pressure_pa"]) else { return Ok(()) };
    let reference = reference(table);
    let mut methods: Vec<(&str, &[f64])> = table
        .columns
        .iter()
        .filter(|(name, _)| name != "pressure_pa")
        .filter_map(|(name, _)| Some((name.as_str(), table.column(name)?)))
        .collect();
    // The reference lies below the others.
    methods.sort_by_key(|(name, _)| Some(*name) != reference);
    if methods.is_empty() {
        return Ok(());
    }
    let axis = pressure_axis(pressure, methods[0].1);
    let lowest = lowest_share(&methods);
    let mut top = Chart::new(
        axis.clone(),
        Axis::linear("CDF of the pressure", Unit::none(), (lowest, 1.0 + 0.03 * (1.0 - lowest))),
    );
    let mut below: Vec<(&str, String, Mark)> = Vec::new();
    for (index, (name, cdf)) in methods.iter().enumerate() {
        let style = if Some(*name) == reference {
            Pen { opacity: 0.55, ..Pen::new(GREY, 5.0, Dash::Solid) }
        } else {
            style(name, index.saturating_sub(1)).0
        };
        let (x, y) = with_atom(&axis, pressure, cdf);
        top.add_named(method_name(name), Mark::Line { x, y, pen: style });
        if let Some(base) = reference.filter(|base| base != name).and_then(|base| table.column(base)) {
            let difference = cdf.iter().zip(base).map(|(a, b)| a - b).collect();
            below.push((name, method_name(name), Mark::Line { x: pressure.to_vec(), y: difference, pen: style }));
        }
    }
    let atom = reference.and_then(|name| table.column(name)).unwrap_or(methods[0].1)[0];
    if pressure[0] <= 0.0 && atom.is_finite() {
        let pen = Pen::new(BLACK, 1.0, Dash::Dotted);
        top.add("1 − P(contact), the atom at p = 0", Mark::Horizontal { y: atom, pen });
    }
    let limits = Limits::of(run).filter(|_| reference.is_some());
    let mut charts = vec![(330.0, top)];
    let mut leave = Vec::new();
    let (reach, far) = reach(&below, limits.as_ref());
    if reach > 0.0 {
        let mut chart = Chart::new(axis, Axis::linear("Difference", Unit::none(), (-reach, reach)));
        if let (Some(limits), Some(base)) = (&limits, reference.and_then(|base| table.column(base))) {
            limits.add_to(&mut chart, |p| interpolated(pressure, base, p));
        }
        chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen { opacity: 0.55, ..Pen::new(GREY, 3.0, Dash::Solid) } });
        for (name, label, mark) in below {
            if far.contains(&name) {
                leave.push(format!("“{label}”"));
            }
            chart.add_named(label, mark);
        }
        charts[0].1.shows_x = false;
        charts[0].0 -= 40.0;
        charts.push((if limits.is_some() { 230.0 } else { 190.0 }, chart));
    }
    let title = "Law of the contact pressure by method";
    let mut caption =
        "Cumulative distribution of the pressure at the point studied (the paper’s Fig. 2). The step at p = 0 is \
                       the probability of no contact."
            .to_owned();
    if lowest > 0.0 {
        caption += " The vertical axis does not begin at 0.";
    }
    if let Some(name) = reference {
        let name = method_name(name);
        caption += &format!(
            " Below: difference of every method from “{name}”; its largest absolute value is the KS distance."
        );
    }
    if limits.is_some() {
        caption += " The shaded bands are those of the default of asperity: they hold the true law at one pressure, and at all \
                    pressures at once, with 95 %.";
    }
    if !leave.is_empty() {
        caption += &format!(" Beyond the frame below: {}.", leave.join(", "));
    }
    let svg = figure(title, &caption, Layout::Column, &charts)?;
    let sources = std::iter::once(csv(NAME)).chain(limits.map(|_| csv(BANDS))).collect();
    plates.push(Plate { name: NAME, stage: Stage::Pressure, title: title.into(), caption, sources, svg });
    Ok(())
}

/// Where the axis of shares begins: a tenth or two below the atoms at zero, so that most of the height shows the pressures.
fn lowest_share(methods: &[(&str, &[f64])]) -> f64 {
    let atoms = methods.iter().filter_map(|(_, cdf)| cdf.first()).filter(|atom| atom.is_finite());
    let least = atoms.fold(1.0_f64, |least, atom| least.min(*atom));
    (10.0 * least - 1.0).floor().clamp(0.0, 9.0) / 10.0
}

/// The distribution function with its step at zero.
fn with_atom(axis: &Axis, pressure: &[f64], cdf: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (pressure.to_vec(), cdf.to_vec());
    if axis.position(0.0).is_none() {
        // On a logarithmic axis the atom is the height at which the curve enters from the left.
        if let Some(first) = (0..x.len()).find(|&i| y[i].is_finite()) {
            x.insert(0, axis.ends().0);
            y.insert(0, y[first]);
        }
    } else {
        // The jump at zero, from the empty side of negative pressures.
        x.splice(0..0, [axis.ends().0, 0.0]);
        y.splice(0..0, [0.0, 0.0]);
    }
    (x, y)
}

/// Half the height of the axis of differences, and the methods that leave it: a biased one does not press the others flat.
fn reach<'a>(below: &[(&'a str, String, Mark)], limits: Option<&Limits<'_>>) -> (f64, Vec<&'a str>) {
    let largest = |mark: &Mark| match mark {
        Mark::Line { y, .. } => range(y).map_or(0.0, |(low, high)| low.abs().max(high.abs())),
        _ => 0.0,
    };
    let mut each: Vec<f64> = below.iter().map(|(_, _, mark)| largest(mark)).collect();
    each.sort_by(f64::total_cmp);
    let most = each.last().copied().unwrap_or(0.0);
    // Three times what half of the methods need: as many as that are models, which may be biased together.
    let usual = each.get(each.len().div_ceil(2).saturating_sub(1)).copied().unwrap_or(0.0);
    let reach = 1.1 * most.min((3.0 * usual).max(limits.map_or(0.0, Limits::reach)));
    let far = below.iter().filter(|(_, _, mark)| largest(mark) > reach).map(|(name, _, _)| *name).collect();
    (reach, far)
}

/// Linear from just below zero, so that the atom shows as a step; logarithmic when most of the law lies in the lowest
/// part of the range.
fn pressure_axis(pressure: &[f64], cdf: &[f64]) -> Axis {
    let atom = cdf.first().copied().filter(|v| v.is_finite()).unwrap_or(0.0);
    let quantile = |share: f64| {
        let level = atom + share * (1.0 - atom);
        pressure.iter().zip(cdf).find(|(p, f)| **p > 0.0 && **f >= level).map(|(p, _)| *p)
    };
    let last = range(pressure).map_or(1.0, |(_, high)| high);
    let high = Some(quantile(0.9995).unwrap_or(last)).filter(|high| *high > 0.0).unwrap_or(1.0);
    let unit = Dimension::Pressure.unit(high);
    let median = quantile(0.5).unwrap_or(high);
    let lowest = pressure.iter().copied().filter(|p| *p > 0.0).fold(high, f64::min);
    if median < 0.02 * high && lowest < median {
        let low = lowest.max(1e-3 * median);
        Axis::logarithmic("Pressure", Dimension::Pressure.unit(median), (low, high))
    } else {
        Axis::linear("Pressure", unit, (-0.03 * high, 1.03 * high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressure_axis_is_linear_for_an_even_law_and_logarithmic_for_one_of_many_decades() {
        let even: Vec<f64> = (0..=100).map(|i| f64::from(i) * 1e7).collect();
        let cdf: Vec<f64> = even.iter().map(|p| 0.5 + 0.5 * p / 1e9).collect();
        assert!(pressure_axis(&even, &cdf).position(0.0).is_some_and(|zero| zero > 0.0));
        let wide: Vec<f64> =
            std::iter::once(0.0).chain((0..=90).map(|i| 10f64.powf(3.0 + f64::from(i) / 15.0))).collect();
        let cdf: Vec<f64> = (0..wide.len()).map(|i| 0.5 + 0.5 * i as f64 / (wide.len() - 1) as f64).collect();
        assert_eq!(pressure_axis(&wide, &cdf).position(0.0), None);
    }
}
