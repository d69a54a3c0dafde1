//! Axes: range, unit, spacing and ticks.

use crate::format::{Unit, fixed, significant, superscript};

/// Spacing of an axis: equal distances for equal differences or for equal ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Spacing {
    Linear,
    Logarithmic,
}

/// A tick of an axis; minor ticks have an empty label.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    /// Position between 0 (low end) and 1.
    pub(crate) position: f64,
    pub(crate) label: String,
}

/// One axis of a chart over a range in SI units, labelled in `unit`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    quantity: String,
    unit: Unit,
    spacing: Spacing,
    low: f64,
    high: f64,
    /// Names at 0, 1, … in place of numbers; empty for numbers.
    names: Vec<String>,
    /// Whether values increase downward.
    downward: bool,
}

/// Least span and largest end of a linear axis, and its least span over its largest end.
const LEAST_SPAN: f64 = 1e-280;
const NOISE: f64 = 1e-11;
const LARGEST: f64 = 1e300;

/// Returns the least and the largest finite value.
pub(crate) fn range<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|v| v.is_finite()).fold(None, |range, &v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

impl Axis {
    /// Returns a linear axis from `low` to `high`; a range that is empty, or as narrow as the rounding of its ends, is widened.
    pub(crate) fn linear(quantity: &str, unit: Unit, (low, high): (f64, f64)) -> Self {
        let (low, high) = (low.clamp(-LARGEST, LARGEST), high.clamp(-LARGEST, LARGEST));
        let (low, high) = if high - low > LEAST_SPAN.max(NOISE * low.abs().max(high.abs())) {
            (low, high)
        } else {
            let reach = if low.abs() <= 10.0 * LEAST_SPAN { 0.5 * unit.si } else { 0.1 * low.abs() };
            (low - reach, low + reach)
        };
        Self {
            quantity: quantity.into(),
            unit,
            spacing: Spacing::Linear,
            low,
            high,
            names: Vec::new(),
            downward: false,
        }
    }

    /// Returns an axis with names at 0, 1, … from the top.
    pub(crate) fn named(names: Vec<String>) -> Self {
        let ends = (-0.5, names.len() as f64 - 0.5);
        Self { names, ..Self::linear("", Unit::none(), ends).downward() }
    }

    /// Turns a vertical axis downward.
    pub(crate) fn downward(self) -> Self {
        Self { downward: true, ..self }
    }

    /// Returns the unit of the labels.
    pub(crate) fn unit(&self) -> &Unit {
        &self.unit
    }

    /// Returns the names in place of numbers.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the attributes from which the page's script computes the value of a place: label, spacing, and the numbers at the left or
    /// lower end and at the other end, as the labels show them.
    pub(crate) fn attributes(&self) -> [(&'static str, String); 4] {
        let shown = |value: f64| (value - self.offset()) / (self.unit.si * 10f64.powi(self.power()));
        let text =
            |value: f64| format!("{:.6e}", shown(value)).parse().map_or_else(|_| String::new(), |v: f64| v.to_string());
        let (from, to) = if self.downward { (self.high, self.low) } else { (self.low, self.high) };
        let spacing = match self.spacing {
            Spacing::Linear if !self.names.is_empty() => "names",
            Spacing::Linear => "linear",
            Spacing::Logarithmic => "log",
        };
        [
            ("data-label", self.label()),
            ("data-spacing", spacing.into()),
            ("data-from", text(from)),
            ("data-to", text(to)),
        ]
    }

    /// Returns a linear axis with a margin at either end, as a fraction of the range; an end at zero stays there.
    pub(crate) fn padded(quantity: &str, unit: Unit, range: (f64, f64), margin: f64) -> Self {
        let mut axis = Self::linear(quantity, unit, range);
        let margin = margin * (axis.high - axis.low);
        axis.low -= if axis.low == 0.0 { 0.0 } else { margin };
        axis.high += if axis.high == 0.0 { 0.0 } else { margin };
        axis
    }

    /// Returns a logarithmic axis; the range must be positive.
    pub(crate) fn logarithmic(quantity: &str, unit: Unit, (low, high): (f64, f64)) -> Self {
        let (low, high) = if high > low { (low, high) } else { (low / 2.0, high * 2.0) };
        Self { spacing: Spacing::Logarithmic, ..Self::linear(quantity, unit, (low, high)) }
    }

    /// Returns the ends of the range in SI units.
    pub(crate) fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// Returns the position of a value: 0 at the low end, 1 at the high end, outside [0, 1] beyond; `None` if undefined.
    pub(crate) fn position(&self, value: f64) -> Option<f64> {
        let position = match self.spacing {
            Spacing::Linear => (value - self.low) / (self.high - self.low),
            Spacing::Logarithmic if value > 0.0 => (value / self.low).ln() / (self.high / self.low).ln(),
            Spacing::Logarithmic => return None,
        };
        position.is_finite().then_some(if self.downward { 1.0 - position } else { position })
    }

    /// Returns the quantity with its unit and the power of ten that is left out of the tick labels.
    pub(crate) fn label(&self) -> String {
        let power = match self.power() {
            0 => String::new(),
            power => format!("10{}", superscript(power)),
        };
        let unit = [power, self.unit.symbol.clone()].iter().filter(|s| !s.is_empty()).cloned().collect::<Vec<_>>();
        let offset = self.offset() / self.unit.si;
        let quantity = if offset == 0.0 {
            self.quantity.clone()
        } else {
            let sign = if offset > 0.0 { '−' } else { '+' };
            format!("{} {sign} {}", self.quantity, significant(offset.abs(), 12))
        };
        if unit.is_empty() { quantity } else { format!("{quantity} ({})", unit.join(" ")) }
    }

    /// Returns a round number in the middle of a linear axis so narrow that its labels would share their first digits; the labels
    /// are relative to it. Zero on other axes.
    fn offset(&self) -> f64 {
        let (span, largest) = (self.high - self.low, self.low.abs().max(self.high.abs()));
        if self.spacing == Spacing::Logarithmic || span >= 2e-3 * largest {
            return 0.0;
        }
        let quantum = 10f64.powi((span / self.unit.si).log10().floor() as i32);
        (0.5 * (self.low + self.high) / self.unit.si / quantum).round() * quantum * self.unit.si
    }

    /// Returns the power of ten, a multiple of three, that is left out of the labels of a linear axis with very small or large numbers.
    fn power(&self) -> i32 {
        let offset = self.offset();
        let largest = (self.low - offset).abs().max((self.high - offset).abs()) / self.unit.si;
        match self.spacing {
            Spacing::Linear if largest > 0.0 && !(0.02..1e4).contains(&largest) => {
                3 * (largest.log10() / 3.0).floor() as i32
            }
            _ => 0,
        }
    }

    /// Returns at least `wanted` labelled ticks and fewer than three times as many, on decades at most twice as many, with minor ones
    /// between them.
    pub(crate) fn ticks(&self, wanted: usize) -> Vec<Tick> {
        let mut ticks = match self.spacing {
            Spacing::Linear if !self.names.is_empty() => self.named_ticks(),
            Spacing::Linear => self.linear_ticks(wanted),
            Spacing::Logarithmic => self.logarithmic_ticks(wanted),
        };
        if self.downward {
            ticks.iter_mut().for_each(|tick| tick.position = 1.0 - tick.position);
        }
        ticks
    }

    fn named_ticks(&self) -> Vec<Tick> {
        let place = |number: usize| (number as f64 - self.low) / (self.high - self.low);
        self.names.iter().enumerate().map(|(i, name)| Tick { position: place(i), label: name.clone() }).collect()
    }

    fn linear_ticks(&self, wanted: usize) -> Vec<Tick> {
        let scale = self.unit.si * 10f64.powi(self.power());
        let (low, high) = ((self.low - self.offset()) / scale, (self.high - self.offset()) / scale);
        let rough = (high - low) / wanted.max(1) as f64;
        let decade = 10f64.powi(rough.log10().floor() as i32);
        let step = [5.0, 2.0].into_iter().map(|m| m * decade).find(|s| *s <= 1.001 * rough).unwrap_or(decade);
        let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
        let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
        (first..=last)
            .map(|index| index as f64 * step)
            .map(|value| Tick { position: (value - low) / (high - low), label: fixed(value, decimals) })
            .collect()
    }

    fn logarithmic_ticks(&self, wanted: usize) -> Vec<Tick> {
        let (low, high) = (self.low / self.unit.si, self.high / self.unit.si);
        let decades = (high / low).log10();
        let every = (decades / (2 * wanted.max(1)) as f64).ceil().max(1.0) as i32;
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let mut ticks = Vec::new();
        // Powers and plain numbers are not mixed on one axis.
        let plain = first >= -3 && last <= 4;
        for exponent in first..=last {
            for digit in 1..10 {
                let value = f64::from(digit) * 10f64.powi(exponent);
                let position = (value / low).ln() / (high / low).ln();
                if !(-1e-9..=1.0 + 1e-9).contains(&position) {
                    continue;
                }
                let labelled = match digit {
                    1 => exponent.rem_euclid(every) == 0,
                    2 | 5 => decades < 2.0,
                    _ => decades < 0.6,
                };
                if labelled || (digit == 1 || every == 1) {
                    let label = if labelled { decade_label(digit, exponent, plain) } else { String::new() };
                    ticks.push(Tick { position, label });
                }
            }
        }
        ticks
    }
}

fn decade_label(digit: i32, exponent: i32, plain: bool) -> String {
    match (plain, digit) {
        (true, _) => fixed(f64::from(digit) * 10f64.powi(exponent), (-exponent).max(0) as usize),
        (false, 1) => format!("10{}", superscript(exponent)),
        (false, _) => format!("{digit}·10{}", superscript(exponent)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, wanted: usize) -> Vec<String> {
        axis.ticks(wanted).into_iter().map(|tick| tick.label).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_in_the_unit_of_the_axis() {
        let axis = Axis::linear("Lag", Unit::new("µm", 1e-6), (0.0, 2e-4));
        assert_eq!(labels(&axis, 4), ["0", "50", "100", "150", "200"]);
        assert_eq!(axis.label(), "Lag (µm)");
        let axis = Axis::linear("μ", Unit::none(), (-0.1, 0.2));
        assert_eq!(labels(&axis, 3), ["−0.1", "0.0", "0.1", "0.2"]);
    }

    #[test]
    fn the_label_has_the_power_of_small_numbers() {
        let axis = Axis::linear("Velocity", Unit::none(), (-0.004, 0.003));
        assert_eq!(axis.label(), "Velocity (10⁻³)");
        assert_eq!(labels(&axis, 7), ["−4", "−3", "−2", "−1", "0", "1", "2", "3"]);
    }

    #[test]
    fn labels_of_a_narrow_range_are_relative_to_a_round_number() {
        let axis = Axis::linear("X", Unit::none(), (0.096_795_59, 0.096_796_02));
        assert_eq!(axis.label(), "X − 0.0967958 (10⁻⁹)");
        assert_eq!(labels(&axis, 4), ["−200", "−100", "0", "100", "200"]);
        assert_eq!(Axis::linear("μ", Unit::none(), (0.19, 0.2)).label(), "μ");
    }

    #[test]
    fn decades_are_labelled_as_powers_and_equally_spaced() {
        let axis = Axis::logarithmic("PSD", Unit::none(), (1e-8, 1e-4));
        assert_eq!(labels(&axis, 3), ["10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴"]);
        for (exponent, position) in [(-8, 0.0), (-6, 0.5), (-4, 1.0)] {
            assert!((axis.position(10f64.powi(exponent)).unwrap() - position).abs() < 1e-12);
        }
        assert_eq!(axis.position(0.0), None);
        assert_eq!(labels(&Axis::logarithmic("k", Unit::none(), (1.0, 20.0)), 6), ["1", "2", "5", "10", "20"]);
    }

    #[test]
    fn a_range_without_width_is_widened() {
        let (low, high) = Axis::linear("x", Unit::none(), (3.0, 3.0)).ends();
        assert!(low < 3.0 && high > 3.0);
        for extreme in [(0.0, 1e-320), (1e-320, 2e-320), (-f64::MAX, f64::MAX), (f64::MAX, f64::MAX), (0.0, f64::MAX)] {
            let axis = Axis::linear("x", Unit::new("µm", 1e-6), extreme);
            let ticks = axis.ticks(4);
            assert!(
                (2..12).contains(&ticks.len()) && ticks.iter().all(|tick| tick.position.is_finite()),
                "{extreme:?}"
            );
        }
        let (low, high) = Axis::linear("μ", Unit::none(), (0.2, 0.2 + 1e-16)).ends();
        assert!(low < 0.19 && high > 0.21);
        assert_eq!(range(&[f64::NAN, 2.0, -1.0, f64::INFINITY]), Some((-1.0, 2.0)));
        assert_eq!(range(&[f64::NAN]), None);
    }
}
