//! Modes of small motion about steady sliding and their loss of stability.

use serde::{Deserialize, Serialize};

use super::super::{VibrationError, positive};
use super::Model;
use super::roots::{self, Mode};
use asperity_base::numeric::root_between;

/// Number of intervals in the search for a change of stability when friction falls with velocity.
const INTERVALS: usize = 4096;
/// Size of a coefficient, relative to the terms of its difference, below which it is rounding.
const ROUNDING: f64 = 1e-13;
/// Range of the search for the loss of stability, relative to the largest of the scan, the coalescence and the
/// machine's own friction.
const BEYOND: f64 = 10.0;

/// Kind of the loss of stability of steady sliding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Instability {
    /// A growing vibration.
    Flutter,
    /// A growing displacement without vibration.
    Divergence,
}

/// Least friction coefficient at which steady sliding is unstable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Critical {
    /// Friction coefficient μ.
    pub friction: f64,
    /// Kind of the instability.
    pub instability: Instability,
    /// Angular frequency of the vibration; 0 for divergence.
    pub frequency: f64,
}

/// Modes as functions of the friction coefficient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EigenvalueScan {
    /// μ, from 0 in equal steps.
    pub friction: Vec<f64>,
    /// The two modes at every μ, each followed continuously; the slow mode at μ = 0 first.
    pub modes: Vec<[Mode; 2]>,
    /// Friction coefficient μ at which the frequencies meet without damping and without weakening of friction.
    pub coalescence: Option<f64>,
    /// Loss of stability with damping, within the scan or up to ten times as far.
    pub critical: Option<Critical>,
}

impl Model {
    /// Returns μ_c = ((k₁₁ − k₂₂)² + 4k₁₂²)/(4k₁₂k₃), where the discriminant of the quadratic in ω² vanishes. From μ_c
    /// on the undamped modes share one frequency and one of them grows. Returns none if k₁₂ ≤ 0, because friction then
    /// separates the frequencies.
    pub fn coalescence(&self) -> Option<f64> {
        let [k11, k12, k22] = self.stiffness;
        let friction = ((k11 - k22).powi(2) + 4.0 * k12 * k12) / (4.0 * k12 * self.parameters().contact_stiffness);
        (k12 > 0.0 && friction.is_finite()).then_some(friction)
    }

    /// Returns μ_d = (k₁₂² − k₁₁k₂₂)/(k₁₂k₃), where the stiffness becomes singular. Returns none if k₁₂ ≥ 0.
    pub fn divergence(&self) -> Option<f64> {
        let [k11, k12, k22] = self.stiffness;
        let friction = (k12 * k12 - k11 * k22) / (k12 * self.parameters().contact_stiffness);
        (k12 < 0.0 && friction.is_finite()).then_some(friction)
    }

    /// Returns −dμ/dv at the belt velocity divided by the coefficient there.
    fn relative_weakening(&self) -> f64 {
        self.parameters().law.weakening(self.belt_velocity()) / self.sliding_friction()
    }

    /// Returns the damping along the belt in small motion: c₁₁ less the weakening of friction times the normal force.
    pub(super) fn effective_damping(&self, friction: f64) -> f64 {
        let weakening = self.relative_weakening() * friction;
        if weakening == 0.0 {
            return self.damping[0];
        }
        self.damping[0] - weakening * self.steady(friction).map_or(f64::NAN, |steady| steady.normal_force)
    }

    /// Returns the coefficients a₀ … a₃ of the characteristic polynomial λ⁴ + a₃λ³ + a₂λ² + a₁λ + a₀ at the friction
    /// coefficient μ.
    fn characteristic(&self, friction: f64) -> [f64; 4] {
        let [k11, k12, k22] = self.stiffness;
        let [_, c12, c22] = self.damping;
        let c11 = self.effective_damping(friction);
        let across = k12 - friction * self.parameters().contact_stiffness;
        [
            k11 * k22 - k12 * across,
            c11 * k22 + c22 * k11 - c12 * (k12 + across),
            k11 + k22 + c11 * c22 - c12 * c12,
            c11 + c22,
        ]
    }
}

/// Returns H = a₁(a₂a₃ − a₁) − a₃²a₀ (Routh and Hurwitz), which is positive in a stable system and zero where a
/// vibration neither grows nor decays.
fn hurwitz([a0, a1, a2, a3]: [f64; 4]) -> f64 {
    a1 * (a2 * a3 - a1) - a3 * a3 * a0
}

/// Returns the two modes of small motion about steady sliding at the friction coefficient μ, the slow one first.
///
/// A velocity-weakening law enters by its slope at V, scaled to μ; the modes are then NaN where no steady sliding
/// exists. Without damping the modes come from the closed form, accurate to rounding also where they meet. With
/// damping, equal modes are accurate to half the digits. Of two real eigenvalues the larger is returned.
pub fn modes(model: &Model, friction: f64) -> [Mode; 2] {
    let polynomial = model.characteristic(friction);
    if polynomial.iter().any(|a| !a.is_finite()) {
        return [Mode { growth: f64::NAN, frequency: f64::NAN }; 2];
    }
    let [a0, a1, a2, a3] = polynomial;
    if a1 != 0.0 || a3 != 0.0 {
        return roots::pairs(polynomial);
    }
    // λ² = −a₂/2 ± ½√discriminant.
    let [k11, k12, k22] = model.stiffness;
    let across = k12 - friction * model.parameters().contact_stiffness;
    let discriminant = (k11 - k22).powi(2) + 4.0 * k12 * across;
    let half = 0.5 * discriminant.abs().sqrt();
    if discriminant < 0.0 {
        let (mean, size) = (0.5 * a2, a0.sqrt());
        let growth = (0.5 * half * half / (size + mean)).sqrt();
        let frequency = (0.5 * (size + mean)).sqrt();
        return [Mode { growth, frequency }, Mode { growth: -growth, frequency }];
    }
    let fast = 0.5 * a2 + half;
    [a0 / fast, fast].map(|square| {
        if square >= 0.0 {
            Mode { growth: 0.0, frequency: square.sqrt() }
        } else {
            Mode { growth: (-square).sqrt(), frequency: 0.0 }
        }
    })
}

/// Returns the modes at `points` ≥ 2 equal steps of the friction coefficient from 0 to `most`, each followed without
/// swapping.
///
/// Of the two ways to continue a pair of modes, the one nearer to their linear continuation is used, so modes that
/// cross keep their order. The order is arbitrary after modes have met and separated.
pub fn eigenvalue_scan(model: &Model, most: f64, points: usize) -> Result<EigenvalueScan, VibrationError> {
    positive("largest friction coefficient", most)?;
    if points < 2 {
        let value = points as f64;
        return Err(VibrationError::Parameter { parameter: "points of the scan", value, wanted: "at least 2" });
    }
    let friction: Vec<f64> = (0..points).map(|i| most * i as f64 / (points - 1) as f64).collect();
    let mut followed: Vec<[Mode; 2]> = Vec::with_capacity(points);
    for &mu in &friction {
        let [a, b] = modes(model, mu);
        let swapped = followed.last().is_some_and(|last| {
            let before = followed.len().checked_sub(2).map_or(last, |i| &followed[i]);
            let expected = [0, 1].map(|i| {
                let step = last[i].minus(before[i]);
                Mode { growth: last[i].growth + step.growth, frequency: last[i].frequency + step.frequency }
            });
            let distance = |first: Mode, second: Mode| {
                first.minus(expected[0]).size().powi(2) + second.minus(expected[1]).size().powi(2)
            };
            distance(b, a) < distance(a, b)
        });
        followed.push(if swapped { [b, a] } else { [a, b] });
    }
    let coalescence = model.coalescence();
    // Damping moves the loss of stability beyond the coalescence, and a short scan may end before it.
    let far = BEYOND * coalescence.unwrap_or(0.0).max(model.sliding_friction()).max(most);
    let critical =
        critical_friction(model, most)?.map_or_else(|| critical_friction(model, far), |found| Ok(Some(found)))?;
    Ok(EigenvalueScan { friction, modes: followed, coalescence, critical })
}

/// Returns the least friction coefficient up to `most` at which steady sliding is unstable; none if it is always
/// stable.
///
/// Without damping and weakening of friction it is the point where the modes meet or where the stiffness becomes
/// singular. With damping and a constant coefficient H is quadratic in μ; its zero has a closed form, accurate to
/// rounding. With a weakening law, whose slope is scaled to μ, the change is bracketed among 4096 intervals; a stable
/// island narrower than one interval is missed.
pub fn critical_friction(model: &Model, most: f64) -> Result<Option<Critical>, VibrationError> {
    positive("largest friction coefficient", most)?;
    let divergence = model.divergence();
    let flutter = if model.relative_weakening() != 0.0 {
        falling(model, most)?
    } else if model.damping == [0.0; 3] {
        model.coalescence()
    } else {
        constant(model)
    };
    let flutter = flutter.map(|friction| {
        let [_, a1, a2, a3] = model.characteristic(friction);
        let square = if a3 == 0.0 { 0.5 * a2 } else { a1 / a3 };
        Critical { friction, instability: Instability::Flutter, frequency: square.max(0.0).sqrt() }
    });
    let divergence =
        divergence.map(|friction| Critical { friction, instability: Instability::Divergence, frequency: 0.0 });
    let first = [flutter, divergence].into_iter().flatten().min_by(|a, b| a.friction.total_cmp(&b.friction));
    Ok(first.filter(|critical| critical.friction <= most))
}

/// Returns the least μ ≥ 0 above which H < 0, for a constant coefficient: a₁ and a₀ are linear in μ, so H is quadratic.
fn constant(model: &Model) -> Option<f64> {
    let [a0, a1, a2, a3] = model.characteristic(0.0);
    let [_, k12, _] = model.stiffness;
    let [_, c12, _] = model.damping;
    let contact = model.parameters().contact_stiffness;
    // a₀ + s₀μ and a₁ + s₁μ.
    let (s0, s1) = (k12 * contact, c12 * contact);
    let unless_rounding = |value: f64, size: f64| if value.abs() <= ROUNDING * size.abs() { 0.0 } else { value };
    let h0 = unless_rounding(hurwitz([a0, a1, a2, a3]), a1 * a2 * a3);
    let h1 = unless_rounding(s1 * (a2 * a3 - 2.0 * a1) - a3 * a3 * s0, a3 * a3 * s0);
    let h2 = -s1 * s1;
    if h0 <= 0.0 && h1 <= 0.0 {
        // One mode is undamped without friction, and friction couples it to the other.
        return (h0 < 0.0 || h1 < 0.0 || h2 < 0.0).then_some(0.0);
    }
    // H is positive at the start and concave, so its only positive zero is the result.
    if h2 == 0.0 {
        return (h1 < 0.0).then_some(-h0 / h1);
    }
    let root = (h1 * h1 - 4.0 * h2 * h0).sqrt();
    Some(if h1 < 0.0 { 2.0 * h0 / (-h1 + root) } else { (h1 + root) / (-2.0 * h2) })
}

/// Searches for the same limit under a weakening law.
fn falling(model: &Model, most: f64) -> Result<Option<f64>, VibrationError> {
    let margin = |friction: f64| {
        let [a0, a1, a2, a3] = model.characteristic(friction);
        // At the loss of stability one of these vanishes first. NaN (no steady sliding) counts as the loss of
        // stability.
        let least = hurwitz([a0, a1, a2, a3]).min(a3 * a3 * a3);
        if least.is_nan() { -1.0 } else { least }
    };
    if margin(0.0) <= 0.0 {
        let fraction = most / INTERVALS as f64;
        return Ok((margin(1e-6 * fraction) < 0.0).then_some(0.0));
    }
    let mut before = 0.0;
    for i in 1..=INTERVALS {
        let friction = most * i as f64 / INTERVALS as f64;
        if margin(friction) < 0.0 {
            return Ok(root_between(margin, [friction, margin(friction)], [before, margin(before)]));
        }
        before = friction;
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::super::{CoupledParameters, Damping};
    use super::*;
    use crate::VelocityLaw;
    use crate::law::{Coulomb, Linear, Stribeck};

    fn damped(damping: Damping) -> Model {
        Model::new(CoupledParameters { damping, ..CoupledParameters::default() }).unwrap()
    }

    /// Returns damping by d₂ (fast) and d₁ in modal coordinates (x + y, x − y)/√2, where K = [3 − Δ/2, Δ/2; −Δ/2, 1 +
    /// Δ/2].
    fn modal(d1: f64, d2: f64) -> Damping {
        Damping::Modal { ratios: [0.5 * d1, 0.5 * d2 / 3.0_f64.sqrt()] }
    }

    #[test]
    fn undamped_modes_meet_at_the_closed_form() {
        let model = Model::new(CoupledParameters::default()).unwrap();
        assert!((model.coalescence().unwrap() - 0.75).abs() < 1e-15);
        for i in 0..=60 {
            let delta = f64::from(i) / 30.0;
            let found = modes(&model, 0.75 * delta);
            // ω² = 2 ∓ √(1 − Δ).
            if delta <= 1.0 - 1e-9 {
                let root = (1.0 - delta).sqrt();
                for (mode, square) in found.iter().zip([2.0 - root, 2.0 + root]) {
                    assert!((mode.frequency - square.sqrt()).abs() < 1e-14 / root.max(1e-3));
                    assert_eq!(mode.growth, 0.0);
                }
            } else if delta > 1.0 + 1e-9 {
                // λ² = −2 + i√(Δ − 1).
                let (size, root) = ((3.0 + delta).sqrt(), (delta - 1.0).sqrt());
                let growth = (0.5 * (size - 2.0)).sqrt();
                assert!((found[0].growth - growth).abs() < 1e-13 && (found[1].growth + growth).abs() < 1e-13);
                assert!((found[0].frequency - 0.5 * root / growth).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn equal_damping_shifts_the_modes_and_moves_the_onset_up() {
        // C = c·1: λ² + cλ = −2 ± √(1 − Δ), and flutter starts where the imaginary part of −λ² − cλ is c√2: Δ = 1 + 2c².
        for c in [0.01, 0.1, 0.5] {
            let model = damped(Damping::Proportional { mass: c, stiffness: 0.0 });
            let found = critical_friction(&model, 10.0).unwrap().unwrap();
            assert!((found.friction / 0.75 - (1.0 + 2.0 * c * c)).abs() < 1e-13, "{found:?}");
            assert!((found.frequency - 2.0_f64.sqrt()).abs() < 1e-13);
            let at = modes(&model, found.friction);
            assert!(at.iter().map(|m| m.growth).fold(f64::MIN, f64::max).abs() < 1e-12, "{at:?}");
        }
    }

    #[test]
    fn unequal_damping_destabilises() {
        // Small damping: vibration starts at ω² = f, f = a₁/a₃ = ((1 + Δ/2)d₂ + (3 − Δ/2)d₁)/(d₁ + d₂), where a₀ = 3 + Δ
        // = f(4 − f), so Δ = 1 − (f − 2)². With r = (d₂ − d₁)/(d₁ + d₂): f = 2 − r(1 − Δ/2), Δ = 1 − r²(1 − Δ/2)².
        let onset =
            |d1: f64, d2: f64| critical_friction(&damped(modal(d1, d2)), 10.0).unwrap().unwrap().friction / 0.75;
        for ratio in [0.5_f64, 0.2, 0.05, 3.0, 10.0] {
            let r = (ratio - 1.0) / (ratio + 1.0);
            // r²Δ²/4 + (1 − r²)Δ + r² − 1 = 0.
            let (a, b) = (0.25 * r * r, 1.0 - r * r);
            let wanted = 2.0 * b / (b + (b * b + 4.0 * a * b).sqrt());
            let d = 1e-4;
            let found = onset(d, ratio * d);
            assert!((found - wanted).abs() < 20.0 * d * d * (1.0 + ratio * ratio), "{ratio}: {found} {wanted}");
            assert!(found < 1.0 && onset(d, d) > 1.0);
        }
        // With one mode damped alone, no friction is low enough.
        assert_eq!(onset(0.01, 0.0), 0.0);
        assert_eq!(onset(0.0, 0.01), 0.0);
    }

    #[test]
    fn the_onset_is_where_the_largest_growth_rate_vanishes() {
        let stribeck = VelocityLaw::Stribeck(Stribeck { kinetic: 0.5, decay: 0.3 });
        for (damping, law) in [
            (Damping::Axes { tangential: 0.1, normal: 0.02 }, VelocityLaw::Coulomb(Coulomb { kinetic: 0.5 })),
            (Damping::Proportional { mass: 0.02, stiffness: 0.03 }, VelocityLaw::Coulomb(Coulomb { kinetic: 0.5 })),
            (Damping::Modal { ratios: [0.03, 0.01] }, VelocityLaw::Coulomb(Coulomb { kinetic: 0.5 })),
            (Damping::Modal { ratios: [0.05, 0.05] }, stribeck),
            (
                Damping::Axes { tangential: 0.05, normal: 0.05 },
                VelocityLaw::Linear(Linear { kinetic: 0.5, slope: 0.05 }),
            ),
        ] {
            let model = Model::new(CoupledParameters { damping, law, ..CoupledParameters::default() }).unwrap();
            let critical = critical_friction(&model, 2.0).unwrap().unwrap();
            let largest = |mu: f64| modes(&model, mu).iter().map(|m| m.growth).fold(f64::MIN, f64::max);
            assert!(largest(critical.friction).abs() < 1e-12, "{damping:?}: {critical:?}");
            for fraction in [0.02, 0.3, 0.7, 0.99] {
                assert!(largest(fraction * critical.friction) < 0.0, "{damping:?} {fraction}");
            }
            assert!(largest(1.001 * critical.friction) > 0.0);
            let frequencies = modes(&model, critical.friction).map(|m| (m.frequency - critical.frequency).abs());
            assert!(frequencies[0].min(frequencies[1]) < 1e-11);
        }
    }

    #[test]
    fn a_short_scan_finds_the_onset_beyond_its_end() {
        for damping in [Damping::Modal { ratios: [0.05, 0.01] }, Damping::Modal { ratios: [0.3, 0.3] }] {
            let model = damped(damping);
            let wanted = critical_friction(&model, 20.0).unwrap().unwrap();
            for most in [0.1 * wanted.friction, 2.0 * wanted.friction] {
                let found = eigenvalue_scan(&model, most, 5).unwrap().critical.unwrap();
                assert!(
                    (found.friction / wanted.friction - 1.0).abs() < 1e-12,
                    "{damping:?} {most}: {found:?} {wanted:?}"
                );
            }
        }
    }

    #[test]
    fn springs_with_the_opposite_inclination_diverge() {
        let springs = CoupledParameters::default().springs;
        let model = Model::new(CoupledParameters { springs: [springs[1], springs[0]], ..CoupledParameters::default() })
            .unwrap();
        assert_eq!(model.coalescence(), None);
        // det K = 3 − Δ.
        let critical = critical_friction(&model, 10.0).unwrap().unwrap();
        assert!((critical.friction - 2.25).abs() < 1e-14 && critical.instability == Instability::Divergence);
        assert!(modes(&model, 2.2)[0].growth == 0.0 && modes(&model, 2.3)[0].growth > 0.0);
        assert!(model.steady(2.2).is_some() && model.steady(2.3).is_none());
    }

    #[test]
    fn followed_modes_do_not_swap() {
        let model = damped(Damping::Modal { ratios: [0.05, 0.01] });
        let step_of = |points: usize| {
            let scan = eigenvalue_scan(&model, 1.5, points).unwrap();
            scan.modes
                .windows(2)
                .flat_map(|pair| [0, 1].map(|i| pair[1][i].minus(pair[0][i]).size()))
                .fold(0.0, f64::max)
        };
        // With unequal damping the modes never meet, so their differences shrink with the step of μ.
        let (coarse, fine) = (step_of(2001), step_of(4001));
        assert!((coarse / fine - 2.0).abs() < 0.05, "{coarse} {fine}");
        let scan = eigenvalue_scan(&model, 1.5, 301).unwrap();
        assert!(scan.modes[0][0].frequency < scan.modes[0][1].frequency);
        assert_eq!(scan.coalescence, model.coalescence());
    }
}
