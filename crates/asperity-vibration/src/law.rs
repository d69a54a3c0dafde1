//! Velocity laws: the friction coefficient as a function of the relative velocity.

mod coulomb;
pub(crate) mod curve;
mod exponential;
mod linear;
mod stribeck;
mod table;

pub use coulomb::Coulomb;
pub use exponential::Exponential;
pub use linear::Linear;
pub use stribeck::Stribeck;
pub use table::FrictionTable;

use asperity_base::choice;
use asperity_base::statement::{Statement, StatementError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::curve::Straight;
use self::exponential::Decay;
use self::stribeck::Quotient;
use self::table::Cubic;
use super::{VibrationError, non_negative, positive};

impl VelocityLawKind {
    /// Returns the error of a study without an input of the law.
    fn requires(self, input: &'static str) -> StatementError {
        StatementError { input, reason: format!("velocity_law = \"{self}\" requires this key") }
    }
}

/// A velocity law: its formula over the speed |v| ≥ 0, and its form in slip.
pub(crate) trait Law: Sized {
    /// Returns the coefficient.
    fn coefficient(&self, speed: f64) -> f64;

    /// Returns the weakening rate −dμ/d|v|; at the last point of a table, the rate beyond it.
    fn weakening(&self, speed: f64) -> f64;

    /// Returns the coefficient at vanishing sliding velocity, μ_k.
    fn kinetic(&self) -> f64;

    /// Returns the law μ(f|v|), f > 0.
    fn rescaled(&self, factor: f64) -> Self;

    /// Returns the law with `map` applied to its friction coefficients. Weakening rates and velocities stay equal.
    fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError>;

    /// Returns the parameters that are numbers, by their names.
    fn numbers_mut(&mut self) -> Vec<(&'static str, &mut f64)> {
        Vec::new()
    }

    /// Returns the weakening rate as a parameter of the law.
    fn rate(&self) -> Option<f64> {
        None
    }

    /// Returns the law with another weakening rate.
    fn with_rate(&self, _rate: f64) -> Option<Self> {
        None
    }

    /// Checks parameters other than μ_k and the weakening rate.
    fn validate(&self) -> Result<(), VibrationError> {
        Ok(())
    }

    /// Returns whether the coefficient depends linearly on the velocity.
    fn is_linear(&self) -> bool {
        false
    }

    /// Returns whether the fall −dμ/d|v| is a convex function of the velocity that nowhere increases.
    fn has_convex_fall(&self) -> bool {
        false
    }

    /// Returns whether the coefficient is positive at every speed.
    fn is_positive(&self) -> bool {
        true
    }

    /// Returns the least coefficient at speeds up to this one: that at it, where friction falls.
    fn least_coefficient(&self, speed: f64) -> f64 {
        self.coefficient(speed)
    }

    /// Returns an upper bound of |dμ/d|v||.
    fn steepest(&self) -> f64;

    /// Returns whether the coefficient is the same at all speeds.
    fn is_constant(&self) -> bool {
        self.steepest() == 0.0
    }

    /// Returns b of the linear part of (μ_k − μ(VW))/V = bW + r(W).
    fn linear_part(&self) -> f64 {
        0.0
    }

    /// Returns r(W) at the belt velocity V.
    fn curve(&self, _velocity: f64) -> Curve {
        Curve::Straight(Straight)
    }

    /// Returns the form of the law in batches; without one, machines are simulated one by one.
    fn batch_form(&self, _velocity: f64) -> Option<BatchForm> {
        None
    }

    /// Returns the rate c of a law with e^{−c|v|}; 0 for other laws.
    fn exponent(&self) -> f64 {
        0.0
    }

    /// Returns the Taylor coefficient k > 0 of μ(w(t)) from those of w up to k and those of μ before it.
    fn term(&self, before: &[f64], w: &[f64], k: usize) -> f64;

    /// Returns the table of a law of pieces.
    fn table(&self) -> Option<&FrictionTable> {
        None
    }

    /// Describes the law with its parameters.
    fn describe(&self) -> String;

    /// Returns laws that show all it can do, for tests.
    #[cfg(test)]
    fn examples() -> Vec<Self>;
}

/// Nonlinear part of any law.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Curve {
    Straight(Straight),
    Quotient(Quotient),
    Decay(Decay),
    Cubic(Cubic),
}

/// Does the same with each kind of curve.
macro_rules! with_curve {
    ($value:expr, $curve:ident => $body:expr) => {
        match $value {
            $crate::law::Curve::Straight($curve) => $body,
            $crate::law::Curve::Quotient($curve) => $body,
            $crate::law::Curve::Decay($curve) => $body,
            $crate::law::Curve::Cubic($curve) => $body,
        }
    };
}
pub(crate) use with_curve;

/// Law of one of the two families that batches simulate, with the variables of [`curve::CurveShape`]: bW + gW/(1 + cW), which
/// includes linear and constant laws, or (g/c)(1 − e^{−cW}).
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchForm {
    /// g.
    pub(crate) gain: f64,
    /// c.
    pub(crate) curvature: f64,
    pub(crate) is_exponential: bool,
    /// With a fluctuation m ≤ 0, friction is positive if `floor` + m > W(`loss` − m·c), with c = 0 for exponentials.
    pub(crate) floor: f64,
    /// See `floor`.
    pub(crate) loss: f64,
}

impl BatchForm {
    fn constant(floor: f64) -> Self {
        Self { gain: 0.0, curvature: 0.0, is_exponential: false, floor, loss: 0.0 }
    }
}

/// Declares [`VelocityLaw`] and [`VelocityLawKind`] from the list of laws, with the names of those that a study may state. `$dollar` is a
/// dollar sign, which the inner macro needs.
macro_rules! laws {
    (
        $dollar:tt $(#[$about:meta])* pub enum $name:ident;
        $($(#[$doc:meta])* $variant:ident($law:ty) $(stated as #[doc = $stated:literal] $(#[$($of_kind:tt)+])* $kind:ident = $word:literal)?,)+
    ) => {
        choice! {
            /// Dependence of friction on the sliding velocity.
            #[derive(Default)]
            pub enum VelocityLawKind: "velocity law" {
                $($(#[doc = $stated] $(#[$($of_kind)+])* $kind = $word,)?)+
            }
        }

        impl VelocityLawKind {
            /// Returns how a study or the flags of a program state it, in dimensionless units.
            #[doc(hidden)]
            pub fn statement(self) -> &'static Statement<$name> {
                match self {
                    $($(Self::$kind => <$law>::STATEMENT,)?)+
                }
            }
        }

        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $($(#[$doc])* $variant($law),)+
        }

        $(impl From<$law> for $name {
            fn from(law: $law) -> Self {
                Self::$variant(law)
            }
        })+

        /// Returns the examples of each law.
        #[cfg(test)]
        pub(crate) fn examples() -> Vec<$name> {
            let all = [$(<$law as Law>::examples().into_iter().map($name::from).collect::<Vec<_>>(),)+];
            all.into_iter().flatten().collect()
        }

        /// Does the same with each law.
        macro_rules! with_law {
            ($dollar of:expr, $dollar law:ident => $dollar body:expr) => {
                match $dollar of {
                    $($name::$variant($dollar law) => $dollar body,)+
                }
            };
        }
    };
}

laws! {$
    /// Kinetic friction coefficient μ(|v|) of a sliding contact, at the dimensionless relative velocity v = v_rel·mω₀/N.
    ///
    /// The stick limit is a separate parameter, [`super::Oscillator::static_friction`].
    pub enum VelocityLaw;
    /// The law of the paper.
    Stribeck(Stribeck) stated as
        /// μ_k/(1 + a|v|) with `stribeck` a (the paper's law; Coulomb's for a = 0).
        #[default]
        Stribeck = "stribeck",
    /// Constant coefficient.
    Coulomb(Coulomb),
    /// Linear weakening.
    Linear(Linear) stated as
        /// μ_k − b|v| with `linear_weakening` b.
        Linear = "linear",
    /// Exponential weakening.
    Exponential(Exponential) stated as
        /// μ_∞ + (μ_k − μ_∞)e^{−|v|/v₀} with `stribeck_velocity` v₀ and `high_speed_share` μ_∞/μ_k.
        Exponential = "exponential",
    /// Monotone cubics between given points.
    Tabulated(FrictionTable) stated as
        /// monotone cubics between the points of `friction_table`.
        Table = "table",
}

impl VelocityLaw {
    /// Returns the coefficient at the speed |v| ≥ 0.
    pub fn coefficient(&self, speed: f64) -> f64 {
        with_law!(self, law => law.coefficient(speed))
    }

    /// Returns the weakening rate −dμ/d|v| at the speed |v| ≥ 0; at the last point of a table, the rate beyond it.
    pub fn weakening(&self, speed: f64) -> f64 {
        with_law!(self, law => law.weakening(speed))
    }

    /// Returns the coefficient at vanishing sliding velocity, μ_k.
    pub fn kinetic(&self) -> f64 {
        with_law!(self, law => law.kinetic())
    }

    /// Returns the weakening rate as a parameter: a of the Stribeck law, b of the linear law; `None` for other laws.
    pub fn weakening_rate(&self) -> Option<f64> {
        with_law!(self, law => law.rate())
    }

    /// Returns the law with another weakening rate; `None` for laws without one.
    pub fn with_weakening_rate(&self, rate: f64) -> Option<Self> {
        with_law!(self, law => law.with_rate(rate).map(Self::from))
    }

    /// Returns the law with `map` applied to its friction coefficients. Weakening rates and velocities stay equal.
    ///
    /// # Errors
    /// A table with these coefficients is invalid.
    pub fn with_coefficients(&self, map: impl Fn(f64) -> f64) -> Result<Self, VibrationError> {
        with_law!(self, law => law.with_coefficients(map).map(Self::from))
    }

    /// Returns a parameter that is a number, by its name; `None` for any other name.
    pub fn number_mut(&mut self, name: &str) -> Option<&mut f64> {
        let numbers = with_law!(self, law => law.numbers_mut());
        numbers.into_iter().find(|(own, _)| *own == name).map(|(_, number)| number)
    }

    /// Describes the law with its parameters.
    pub fn describe(&self) -> String {
        with_law!(self, law => law.describe())
    }

    /// Returns the law μ(f|v|), f > 0. It is the same law in SI when the unit of velocity N/(mω₀) grows by the factor
    /// f, for example under another load. The factor N/(mω₀) in m/s makes a law of velocities in m/s dimensionless.
    pub fn rescaled(&self, factor: f64) -> Self {
        with_law!(self, law => law.rescaled(factor).into())
    }

    pub(super) fn validate(&self) -> Result<(), VibrationError> {
        positive("kinetic_friction", self.kinetic())?;
        if let Some(rate) = self.weakening_rate() {
            non_negative("velocity weakening of the friction law", rate)?;
        }
        with_law!(self, law => law.validate())
    }
}

/// See [`Law`].
impl VelocityLaw {
    pub(super) fn is_linear(&self) -> bool {
        with_law!(self, law => law.is_linear())
    }

    pub(super) fn has_convex_fall(&self) -> bool {
        with_law!(self, law => law.has_convex_fall())
    }

    pub(super) fn is_positive(&self) -> bool {
        with_law!(self, law => law.is_positive())
    }

    pub(super) fn is_constant(&self) -> bool {
        with_law!(self, law => law.is_constant())
    }

    pub(super) fn least_coefficient(&self, speed: f64) -> f64 {
        with_law!(self, law => law.least_coefficient(speed))
    }

    pub(super) fn steepest(&self) -> f64 {
        with_law!(self, law => law.steepest())
    }

    pub(super) fn linear_part(&self) -> f64 {
        with_law!(self, law => law.linear_part())
    }

    pub(super) fn curve(&self, velocity: f64) -> Curve {
        with_law!(self, law => law.curve(velocity))
    }

    pub(super) fn batch_form(&self, velocity: f64) -> Option<BatchForm> {
        with_law!(self, law => law.batch_form(velocity))
    }

    pub(super) fn exponent(&self) -> f64 {
        with_law!(self, law => law.exponent())
    }

    pub(super) fn table(&self) -> Option<&FrictionTable> {
        with_law!(self, law => law.table())
    }

    pub(super) fn term(&self, before: &[f64], w: &[f64], k: usize) -> f64 {
        with_law!(self, law => law.term(before, w, k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use curve::{CurveShape, Recurrence};

    #[test]
    fn every_number_of_a_law_is_found_by_its_name() {
        for mut law in examples() {
            let stored = serde_json::to_value(&law).unwrap();
            let (_, parameters) = stored.as_object().unwrap().iter().next().unwrap();
            let numbers = parameters.as_object().unwrap().iter().filter_map(|(name, own)| Some((name, own.as_f64()?)));
            for (name, value) in numbers {
                assert_eq!(law.number_mut(name).copied(), Some(value), "{name} of {law:?}");
            }
            assert_eq!(law.number_mut("damping_ratio"), None);
        }
    }

    #[test]
    fn every_law_is_what_its_methods_say() {
        for law in examples() {
            // The third derivatives of the laws are at most 240, so the error of a difference is at most 4e-10.
            let (h, steps) = (3e-6, 400);
            let speeds: Vec<f64> = (1..=steps).map(|i| 1.003 * f64::from(i) / f64::from(steps)).collect();
            let is_constant = speeds.iter().all(|speed| law.coefficient(*speed) == law.kinetic());
            let (mut least, mut before) = (law.kinetic(), law.weakening(0.0));
            let [rescaled, scaled] =
                [law.rescaled(2.5), law.with_coefficients(|coefficient| 2.0 * coefficient).unwrap()];
            assert!((scaled.kinetic() - 2.0 * law.kinetic()).abs() < 1e-15 && law.coefficient(0.0) == law.kinetic());
            for speed in speeds {
                let difference = (law.coefficient(speed - h) - law.coefficient(speed + h)) / (2.0 * h);
                let rate = law.weakening(speed);
                assert!((rate - difference).abs() < 1e-9, "{law:?} at {speed}: {rate}, {difference}");
                assert!(rate.abs() <= law.steepest() * (1.0 + 1e-12), "{law:?}");
                let wide = [speed - 1e-3, speed + 1e-3].map(|speed| law.weakening(speed.max(0.0)));
                let bends = wide[0] + wide[1] - 2.0 * rate;
                assert!(!law.has_convex_fall() || rate <= before * (1.0 + 1e-12) && bends > -1e-12, "{law:?}");
                assert!(!law.is_linear() || rate == before, "{law:?}");
                assert!(!law.is_positive() || law.coefficient(speed) > 0.0, "{law:?}");
                assert!((rescaled.coefficient(speed) - law.coefficient(2.5 * speed)).abs() < 1e-15);
                least = law.coefficient(speed).min(least);
                assert!((law.least_coefficient(speed) - least).abs() < 1e-4 * law.kinetic(), "{law:?}");
                before = rate;
            }
            assert_eq!(law.is_constant(), is_constant, "{law:?}");
            if let Some(rate) = law.weakening_rate() {
                let twice = law.with_weakening_rate(2.0 * rate).unwrap();
                assert!((twice.weakening(0.0) - 2.0 * law.weakening(0.0)).abs() < 1e-12, "{law:?}");
            }
            law.validate().unwrap();
        }
    }

    #[test]
    fn the_form_of_every_law_in_slip_is_its_formula() {
        let v = 0.07;
        for law in examples() {
            for i in 1..200 {
                let w = 0.01 * f64::from(i);
                let wanted = (law.kinetic() - law.coefficient(v * w)) / v;
                let linear = law.linear_part() * w;
                if let Some(BatchForm { gain, curvature, is_exponential, floor, loss }) = law.batch_form(v) {
                    let thinning = if is_exponential { 0.0 } else { curvature };
                    for m in [0.0, -0.5, -0.9, -1.1].map(|share| share * law.kinetic()) {
                        assert!(
                            floor + m <= w * (loss - m * thinning) || law.coefficient(v * w) + m > -1e-15,
                            "{law:?}"
                        );
                    }
                    let rest = match is_exponential {
                        true => (gain / curvature) * (1.0 - (-curvature * w).exp()),
                        false => gain * w / (1.0 + curvature * w),
                    };
                    assert!((linear + rest - wanted).abs() < 1e-13, "{law:?}: {rest}");
                }
                let curve = match (law.curve(v), law.table()) {
                    (Curve::Cubic(cubic), Some(table)) => Curve::Cubic(cubic.at(table, v, w)),
                    (curve, _) => curve,
                };
                let [value, slope] = with_curve!(&curve, curve => [curve.value(w), curve.slope(w)]);
                assert!((linear + value - wanted).abs() < 1e-13, "{law:?}: {value}");
                assert!((law.linear_part() + slope - law.weakening(v * w)).abs() < 1e-12, "{law:?}: {slope}");
                let exponent = with_curve!(&curve, curve => curve.exponent());
                assert!(exponent == 0.0 || (law.exponent() * v - exponent).abs() < 1e-12, "{law:?}: {exponent}");
            }
        }
    }

    /// Returns the Taylor coefficients of r(W(t)) − r(W₀).
    fn terms_of<const N: usize>(mut recurrence: impl Recurrence<N>, w: &[f64; N]) -> Vec<f64> {
        let term = |n| if n == 0 { 0.0 } else { recurrence.slope() * w[n] + recurrence.rest(w, n) };
        (0..N).map(term).collect()
    }

    #[test]
    fn the_series_of_every_law_follow_its_formula() {
        // W(t) = 0.8 + 0.3t − 0.2t² + 0.1t³, at t = 0.01.
        const N: usize = 12;
        let (mut w, t, v) = ([0.0; N], 0.01, 0.07);
        w[..4].copy_from_slice(&[0.8, 0.3, -0.2, 0.1]);
        let sum = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * t + term);
        for law in examples() {
            let at = |w: f64| law.coefficient(v * w);
            if law.table().is_none() {
                let speeds = w.map(|term| v * term);
                let mut terms = vec![at(w[0])];
                (1..N).for_each(|k| terms.push(law.term(&terms, &speeds, k)));
                assert!((sum(&terms) - at(sum(&w))).abs() < 1e-15, "{law:?}");
            }
            let curve = match (law.curve(v), law.table()) {
                (Curve::Cubic(cubic), Some(table)) => Curve::Cubic(cubic.at(table, v, w[0])),
                (curve, _) => curve,
            };
            let change = with_curve!(&curve, curve => {
                sum(&terms_of(curve.terms::<N>(w[0]), &w)) - (curve.value(sum(&w)) - curve.value(w[0]))
            });
            assert!(change.abs() < 1e-15, "{law:?}: {change}");
        }
    }

    #[test]
    fn laws_are_named_in_snake_case_and_tables_are_checked_when_read() {
        let text = r#"{"tabulated":{"points":[[0.0,0.4],[0.1,0.3]]}}"#;
        let law: VelocityLaw = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&law).unwrap(), text);
        assert!(serde_json::from_str::<VelocityLaw>(r#"{"tabulated":{"points":[[0.1,0.4],[0.2,0.3]]}}"#).is_err());
        let text = r#"{"exponential":{"kinetic":0.4,"high_speed":0.3,"stribeck_velocity":0.2}}"#;
        assert_eq!(serde_json::to_string(&serde_json::from_str::<VelocityLaw>(text).unwrap()).unwrap(), text);
    }

    #[test]
    fn an_exponential_that_rises_is_refused() {
        for (kinetic, high_speed, stribeck_velocity) in [(0.3, 0.4, 0.1), (0.3, 0.0, 0.1), (0.3, 0.2, 0.0)] {
            assert!(
                VelocityLaw::Exponential(Exponential { kinetic, high_speed, stribeck_velocity }).validate().is_err()
            );
        }
    }
}
