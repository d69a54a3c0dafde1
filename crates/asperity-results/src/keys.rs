//! Inputs of a study: what its parser, the verdict and its readers know about each.

use crate::Pair;

/// Stribeck coefficient of the paper, per unit of dimensionless velocity.
pub const STRIBECK: f64 = 4.2;
/// Kinetic over static friction of the paper.
pub const KINETIC_SHARE: f64 = 1.0;

/// Inputs that scale the motion of a machine: mass, natural frequency and normal force.
pub const SCALES: [&str; 3] = ["vibration.mass", "vibration.natural_frequency", "vibration.normal_force"];
/// Inputs whose product is mω₀.
pub const INERTIA: [&str; 2] = [SCALES[0], SCALES[1]];

/// Value of a study that decides its answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// Section of a study file.
    pub section: &'static str,
    /// Name within its section.
    pub name: &'static str,
    /// SI unit; empty for a number without unit and for a word.
    pub unit: &'static str,
    /// Values that are possible; `None` for a word.
    pub bounds: Option<Bounds>,
    /// What depends on it.
    pub link: Link,
    /// Name for readers.
    pub label: &'static str,
    /// Names of both elements of a list for readers.
    pub elements: Option<[&'static str; 2]>,
    /// Word of its section, by name and value, without which it has no effect; laws name their own inputs.
    pub needs: Option<(&'static str, &'static str)>,
    /// Value that stands for it where a study leaves it out.
    pub default: Option<KeyDefault>,
    /// Whether a percentage such as `3 %` may state a number without unit. One of a standard deviation could be a part of the mean.
    pub percentage: bool,
    /// Power of the unit of velocity N/(mω₀) that a number is proportional to if its value in SI stays the same.
    pub velocity_power: i32,
    /// Name and label of the friction coefficient that it is the share of; programs without a study state that coefficient.
    pub coefficient: Option<[&'static str; 2]>,
}

/// Possible values of a number in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Whether the lower and the upper bound are possible.
    closed: [bool; 2],
    /// Possible values in words.
    pub expected: &'static str,
}

/// Part of the chain that depends on an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Link {
    /// The random surface, and all that follows.
    Surface,
    /// The contact, and all that follows.
    Contact,
    /// Friction over time and velocity, which a machine with coupled modes does not have.
    Fall,
    /// The machine.
    Machine,
    /// Which model the study is of.
    Model,
}

/// Value of an input that a study leaves out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyDefault {
    /// The value.
    pub value: DefaultValue,
    /// Whether it is the one of the paper, not of asperity.
    pub of_paper: bool,
    /// Range at whose ends the verdict states the probability, if it does.
    pub range: Option<Pair>,
}

/// Number, list of numbers or word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefaultValue {
    /// A number in SI.
    Number(f64),
    /// Two numbers in SI.
    Pair(Pair),
    /// A word.
    Word(&'static str),
}

impl DefaultValue {
    /// Returns a number.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Pair(_) | Self::Word(_) => None,
        }
    }
}

const fn above(low: f64, high: f64, expected: &'static str) -> Bounds {
    Bounds { low, high, closed: [false, true], expected }
}

const fn between(low: f64, high: f64, expected: &'static str) -> Bounds {
    Bounds { low, high, closed: [false, false], expected }
}

const ANY: Bounds = between(f64::NEG_INFINITY, f64::INFINITY, "a number");
const POSITIVE: Bounds = between(0.0, f64::INFINITY, "a positive value");
const NOT_NEGATIVE: Bounds = Bounds { closed: [true, false], expected: "zero or a positive value", ..POSITIVE };
const RATIO: Bounds = above(0.0, 1.0, "a ratio above 0, at most 1");
const HEIGHT: Bounds = between(1e-50, 1e50, "a positive value between 1e-50 and 1e50 m");
const POISSON_RATIO: Bounds = above(-1.0, 0.5, "a Poisson ratio above -1 and at most 0.5");
const HURST: Bounds = between(0.0, 1.0, "a Hurst exponent strictly between 0 and 1");
const FRACTAL: Bounds = between(2.0, 3.0, "a value strictly between 2 and 3");

impl Bounds {
    /// Returns whether a value in SI is possible.
    pub fn contain(&self, value: f64) -> bool {
        let Self { low, high, closed: [low_is_possible, high_is_possible], .. } = *self;
        let inside = value > low && value < high;
        inside || value.is_finite() && (low_is_possible && value == low || high_is_possible && value == high)
    }
}

const fn number(unit: &'static str, bounds: Bounds, link: Link, label: &'static str) -> Key {
    Key { unit, bounds: Some(bounds), ..word(link, label) }
}

const fn word(link: Link, label: &'static str) -> Key {
    let (section, name, unit) = ("", "", "");
    Key {
        section,
        name,
        unit,
        bounds: None,
        link,
        label,
        elements: None,
        needs: None,
        default: None,
        percentage: true,
        velocity_power: 0,
        coefficient: None,
    }
}

impl Key {
    const fn usual(self, value: DefaultValue) -> Self {
        Self { default: Some(KeyDefault { value, of_paper: false, range: None }), ..self }
    }

    const fn usual_in_paper(self, value: DefaultValue, range: Option<Pair>) -> Self {
        Self { default: Some(KeyDefault { value, of_paper: true, range }), ..self }
    }

    const fn no_percentage(self) -> Self {
        Self { percentage: false, ..self }
    }

    const fn elements(self, names: [&'static str; 2]) -> Self {
        Self { elements: Some(names), ..self }
    }

    const fn only_with(self, name: &'static str, word: &'static str) -> Self {
        Self { needs: Some((name, word)), ..self }
    }

    const fn times_velocity(self, velocity_power: i32) -> Self {
        Self { velocity_power, ..self }
    }

    const fn share_of(self, name: &'static str, label: &'static str) -> Self {
        Self { coefficient: Some([name, label]), ..self }
    }

    /// Returns its name with the section, `vibration.damping_ratio`.
    pub fn path(&self) -> String {
        format!("{}.{}", self.section, self.name)
    }

    /// Returns the input of a path, such as `vibration.damping_ratio`; of one that may be a number without unit, that.
    pub fn find(path: &str) -> Option<&'static Self> {
        let (section, name) = path.split_once('.')?;
        KEYS.iter().chain(LATENT).find(|key| (key.section, key.name) == (section, name))
    }
}

/// Returns the name of an input, `vibration.damping_ratio` or `surface.correlation_length[0]`, for readers; its own name if it is no row
/// of the table.
pub fn label(input: &str) -> String {
    let label = match input.strip_suffix(']').and_then(|input| input.split_once('[')) {
        Some((path, position)) => element(path, position),
        None => Key::find(input).map(|key| key.label),
    };
    let name = || input.rsplit('.').next().unwrap_or(input).replace('_', " ").replace('[', " [");
    label.map_or_else(name, str::to_owned)
}

fn element(path: &str, position: &str) -> Option<&'static str> {
    Key::find(path)?.elements?.get(position.parse::<usize>().ok()?).copied()
}

/// Calls a macro with the inputs of the velocity laws after `$given`: name, type and description of the key in a study file, and one row
/// of the table or, for a number that may have a unit, two.
#[doc(hidden)]
#[macro_export]
macro_rules! velocity_law_keys {
    ([$($macro:tt)*] $given:tt) => {
        $($macro)*! { $given
            stribeck: Stribeck,
                "Stribeck coefficient a of μ_k/(1 + a|v|), per unit of dimensionless velocity or in s/m; 4.2 when left out.";
                [number("", NOT_NEGATIVE, Fall, "Stribeck coefficient")
                    .usual_in_paper(Number(STRIBECK), Some([2.1, 8.4])).times_velocity(1)]
                [number("s/m", NOT_NEGATIVE, Fall, "Stribeck coefficient")]
            linear_weakening: f64,
                "Slope b of the linear law, per unit of dimensionless velocity.";
                [number("", NOT_NEGATIVE, Fall, "weakening of friction with speed").times_velocity(1)]
            stribeck_velocity: Velocity,
                "Velocity v₀ of the exponential law.";
                [number("m/s", POSITIVE, Fall, "Stribeck speed")]
            high_speed_share: f64,
                "Ratio of the friction coefficient at high velocity to the kinetic one, for the exponential law.";
                [number("", RATIO, Fall, "friction at high speed over kinetic friction")
                    .share_of("high_speed_friction", "friction coefficient at high speed")]
        }
    };
}

/// Makes an array of what `$row!` makes of each input, in the order of the chain. An input with a unit has another row if it may be a
/// number without unit.
#[doc(hidden)]
#[macro_export]
macro_rules! study_keys {
    ($row:ident) => {
        $crate::velocity_law_keys! { [$crate::all_study_keys] { $row } }
    };
}

/// See [`study_keys`].
#[doc(hidden)]
#[macro_export]
macro_rules! all_study_keys {
    ({ $row:ident } $($name:ident: $type:ty, $about:tt; $([$($facts:tt)*])+)*) => {
        [
            $row!(surface.body: word(Model, "rough body")),
            $row!(surface.rms_height: number("m", HEIGHT, Surface, "rms height")),
            $row!(surface.correlation_length: number("m", POSITIVE, Surface, "correlation length")
                .elements(["correlation length along x", "correlation length along y"])),
            $row!(surface.hurst: number("", HURST, Surface, "Hurst exponent").only_with("covariance", "self_affine")),
            $row!(surface.smoothness: number("", POSITIVE, Surface, "smoothness").only_with("covariance", "matern")),
            $row!(surface.fractal_dimension: number("", FRACTAL, Surface, "fractal dimension")
                .only_with("generator", "weierstrass_mandelbrot")),
            $row!(surface.cut_off: number("m", POSITIVE, Surface, "shortest wave")),
            $row!(material.youngs_modulus: number("Pa", POSITIVE, Contact, "Young’s modulus")),
            $row!(material.poisson_ratio: number("", POISSON_RATIO, Contact, "Poisson’s ratio").usual(Number(0.3))),
            $row!(material.hardness: number("Pa", POSITIVE, Contact, "hardness")),
            $row!(material.shear_strength: number("Pa", POSITIVE, Contact, "shear strength")),
            $row!(counterface.youngs_modulus: number("Pa", POSITIVE, Contact, "Young’s modulus of the counterface")),
            $row!(counterface.poisson_ratio: number("", POISSON_RATIO, Contact, "Poisson’s ratio of the counterface")),
            $row!(counterface.hardness: number("Pa", POSITIVE, Contact, "hardness of the counterface")),
            $row!(friction.law: word(Contact, "friction law").usual_in_paper(Word("bowden_tabor"), None)),
            $row!(friction.pressure_coefficient: number("", NOT_NEGATIVE, Contact, "pressure coefficient")),
            $row!(friction.coefficient: number("", POSITIVE, Contact, "coefficient")),
            $row!(friction.nominal_area: number("m^2", POSITIVE, Contact, "nominal area")),
            $row!(vibration.model: word(Model, "model")),
            $row!(vibration.friction_process: word(Model, "friction process")),
            $row!(vibration.static_friction: number("", POSITIVE, Machine, "friction coefficient")),
            $row!(vibration.friction_std: number("", NOT_NEGATIVE, Fall, "standard deviation of friction").no_percentage()),
            $row!(vibration.friction_correlation_length: number("m", POSITIVE, Fall, "friction correlation length")),
            $row!(vibration.velocity_law: word(Fall, "velocity law").usual_in_paper(Word("stribeck"), None)),
            $($($row!(vibration.$name: $($facts)*),)+)*
            $row!(vibration.kinetic_share: number("", RATIO, Fall, "kinetic over static friction")
                .usual_in_paper(Number(KINETIC_SHARE), Some([0.9, 1.0]))
                .share_of("kinetic_friction", "kinetic friction coefficient")),
            $row!(vibration.spring_angles: number("", ANY, Machine, "angles of the springs in degrees").no_percentage()
                .elements(["angle of the first spring in degrees", "angle of the second spring in degrees"])
                .only_with("model", "mode_coupling").usual(Pair([150.0, 30.0]))),
            $row!(vibration.springs: number("", NOT_NEGATIVE, Machine, "springs")
                .elements(["first spring", "second spring"])
                .only_with("model", "mode_coupling").usual(Pair([0.178_632_794_954_081_85, 2.488_033_871_712_584_5]))),
            $row!(vibration.contact_spring: number("", POSITIVE, Machine, "contact spring")
                .only_with("model", "mode_coupling").usual(Number(4.0 / 3.0))),
            $row!(vibration.damping_ratio: number("", NOT_NEGATIVE, Machine, "damping ratio")),
            $row!(vibration.mass: number("kg", POSITIVE, Machine, "mass")),
            $row!(vibration.natural_frequency: number("rad/s", POSITIVE, Machine, "natural frequency")),
            $row!(vibration.normal_force: number("N", POSITIVE, Contact, "normal force")),
            $row!(vibration.nominal_area: number("m^2", POSITIVE, Contact, "nominal area")),
            $row!(vibration.upscaling: word(Machine, "upscaling").usual(Word("area"))),
            $row!(vibration.belt_velocity: number("m/s", POSITIVE, Machine, "belt speed")),
            $row!(vibration.dimensionless_belt_velocity: number("", POSITIVE, Machine, "dimensionless belt speed")
                .times_velocity(-1)),
        ]
    };
}

macro_rules! row {
    ($section:ident.$name:ident: $($facts:tt)*) => {
        Key { section: stringify!($section), name: stringify!($name), ..$($facts)* }
    };
}

/// All inputs in the order of the chain.
pub static KEYS: &[Key] = &{
    use DefaultValue::{Number, Pair, Word};
    use Link::{Contact, Fall, Machine, Model, Surface};
    study_keys!(row)
};

/// Path of the damping ratio.
pub const DAMPING_RATIO: &str = "vibration.damping_ratio";

/// Path of the friction coefficient that a study states.
pub const STATIC_FRICTION: &str = "vibration.static_friction";

/// Path of the load.
pub const NORMAL_FORCE: &str = "vibration.normal_force";

/// Separators of mean and standard deviation in an uncertain value.
pub const SPREADS: [&str; 3] = ["±", "+/-", "+-"];

/// Separators of the ends of a range in an uncertain value.
pub const RANGES: [&str; 2] = ["..", "–"];

/// Standard normal values that no study file states: what the scans of either body leave uncertain, differences between scans, and
/// between the parts of a rough slider.
pub static LATENT: &[Key] = &[
    row!(surface.scan: number("", ANY, Link::Surface, "surface, uncertainty of the scan")),
    row!(surface.between_scans: number("", ANY, Link::Surface, "surface, from part to part")),
    row!(counterface.scan: number("", ANY, Link::Surface, "counterface, uncertainty of the scan")),
    row!(counterface.between_scans: number("", ANY, Link::Surface, "counterface, from part to part")),
    row!(surface.between_parts: number("", ANY, Link::Machine, "friction of the slider’s parts")),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_have_names_for_readers() {
        for (input, wanted) in [
            ("vibration.damping_ratio", "damping ratio"),
            ("surface.correlation_length[0]", "correlation length along x"),
            ("surface.correlation_length", "correlation length"),
            ("vibration.springs[1]", "second spring"),
            ("surface.scan", "surface, uncertainty of the scan"),
            ("counterface.between_scans", "counterface, from part to part"),
            ("counterface.youngs_modulus", "Young’s modulus of the counterface"),
            // No inputs of the table.
            ("friction.mean_pressures[2]", "mean pressures [2]"),
            ("pressure.fine_solves", "fine solves"),
        ] {
            assert_eq!(label(input), wanted);
        }
    }

    #[test]
    fn defaults_are_possible_and_ranges_contain_them() {
        for (key, default) in KEYS.iter().filter_map(|key| Some((key, key.default?))) {
            let numbers = match default.value {
                DefaultValue::Number(number) => vec![number],
                DefaultValue::Pair(pair) => pair.to_vec(),
                DefaultValue::Word(_) => vec![],
            };
            assert!(numbers.iter().all(|number| key.bounds.unwrap().contain(*number)), "{key:?}");
            if let Some([low, high]) = default.range {
                assert!(low < high && numbers.iter().all(|number| (low..=high).contains(number)), "{key:?}");
            }
        }
    }

    #[test]
    fn bounds_contain_their_ends_where_these_are_possible() {
        assert!(NOT_NEGATIVE.contain(0.0) && !POSITIVE.contain(0.0) && RATIO.contain(1.0) && !RATIO.contain(0.0));
        assert!(!HURST.contain(1.0) && HURST.contain(0.5) && !ANY.contain(f64::INFINITY) && !ANY.contain(f64::NAN));
    }
}
