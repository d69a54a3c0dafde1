//! Taylor series of the motion between two events.

use super::super::super::polynomial::{self, CAPACITY};
use super::super::super::series::exponential_step;
use super::super::Model;
use super::state::{Contact, Now};

/// Largest number of coefficients of a series; even, for pairwise evaluation.
const MOST_TERMS: usize = 24;
const _: () = assert!(MOST_TERMS <= CAPACITY);
/// Last kept term of a series, relative to the state.
const TOLERANCE: f64 = 1e-16;
/// Longest step.
const LONGEST: f64 = 2.0;

/// Coefficients of a polynomial in the time since the start of the step.
type Coefficients = [f64; MOST_TERMS];

/// Taylor series of all variables.
#[derive(Debug, Clone)]
pub(super) struct Series {
    len: usize,
    /// Rate 1/v₀ of an exponential law; 0 for other laws.
    decay: f64,
    x: Coefficients,
    u: Coefficients,
    y: Coefficients,
    v: Coefficients,
    w: Coefficients,
    s: Coefficients,
    law: Coefficients,
    friction: Coefficients,
    normal: Coefficients,
    holding: Coefficients,
}

impl Series {
    pub(super) const ZERO: Self = Self {
        len: 0,
        decay: 0.0,
        x: [0.0; MOST_TERMS],
        u: [0.0; MOST_TERMS],
        y: [0.0; MOST_TERMS],
        v: [0.0; MOST_TERMS],
        w: [0.0; MOST_TERMS],
        s: [0.0; MOST_TERMS],
        law: [0.0; MOST_TERMS],
        friction: [0.0; MOST_TERMS],
        normal: [0.0; MOST_TERMS],
        holding: [0.0; MOST_TERMS],
    };

    /// Expands the motion about a state, for a step of about `horizon`; `slope` is dm/ds.
    pub(super) fn expand(&mut self, model: &Model, now: &Now, slope: f64, horizon: f64) {
        let [k11, k12, k22] = model.stiffness;
        let [c11, c12, c22] = model.damping;
        let parameters = model.parameters();
        let contact = parameters.contact_stiffness;
        // Terms fall approximately like (ρh)ⁿ/n!; otherwise `reach` shortens the step.
        let scaled = horizon * (k11 + k22 + slope.abs()).sqrt().max(c11 + c22);
        self.len = if scaled < 0.07 {
            12
        } else if scaled < 0.33 {
            16
        } else {
            MOST_TERMS
        };
        // In flight the contact spring does not act and the static load remains.
        let (across, mut load) = if now.contact == Contact::Flight { (k22 - contact, 1.0) } else { (k22, 0.0) };
        let direction = now.contact.direction();
        self.decay = if direction == 0.0 { 0.0 } else { parameters.law.exponent() };
        (self.x[0], self.u[0], self.y[0], self.v[0]) = (now.x, now.u, now.y, now.v);
        (self.w[0], self.s[0], self.normal[0]) = (now.speed(model), 0.0, now.normal(model));
        for k in 0..self.len {
            self.holding[k] = holding(model, [self.x[k], self.u[k], self.y[k], self.v[k]]);
            let mut force = 0.0;
            if direction != 0.0 {
                self.law[k] = if k == 0 {
                    parameters.law.coefficient(self.w[0])
                } else {
                    parameters.law.term(&self.law, &self.w, k)
                };
                self.friction[k] = self.law[k] + if k == 0 { now.m } else { slope * self.s[k] };
                for j in 0..=k {
                    force += self.friction[j] * self.normal[k - j];
                }
                force *= direction;
            }
            if k + 1 == self.len {
                break;
            }
            let fraction = 1.0 / (k as f64 + 1.0);
            self.v[k + 1] =
                (load - c12 * self.u[k] - c22 * self.v[k] - k12 * self.x[k] - across * self.y[k]) * fraction;
            self.u[k + 1] = if now.contact == Contact::Stick { 0.0 } else { (force - self.holding[k]) * fraction };
            if k == 0 && now.released {
                // Here the holding force equals the stick limit by definition; the remaining force is the drop to
                // kinetic friction.
                self.u[1] = -direction * (parameters.static_friction - parameters.law.kinetic()) * self.normal[0];
            }
            self.x[k + 1] = self.u[k] * fraction;
            self.y[k + 1] = self.v[k] * fraction;
            self.normal[k + 1] = contact * self.y[k + 1];
            self.w[k + 1] = -direction * self.u[k + 1];
            self.s[k + 1] = self.w[k] * fraction;
            load = 0.0;
        }
    }

    /// Returns the longest step up to `wanted` on which the dropped terms, bounded by the last two kept ones, stay
    /// below rounding.
    pub(super) fn reach(&self, wanted: f64) -> f64 {
        let size = |k: usize| self.x[k].abs().max(self.u[k].abs()).max(self.y[k].abs()).max(self.v[k].abs());
        let allowed = TOLERANCE * size(0).max(self.w[0]);
        let mut h = wanted.min(LONGEST);
        for k in [self.len - 2, self.len - 1] {
            if size(k) * h.powi(k as i32) > allowed {
                h = h.min((allowed / size(k)).powf(1.0 / k as f64));
            }
        }
        exponential_step(&self.w[..self.len], self.decay, h)
    }

    /// Returns x, x′, y, y′ after the time t.
    pub(super) fn state(&self, t: f64) -> [f64; 4] {
        [&self.x, &self.u, &self.y, &self.v].map(|c| polynomial::split_value(&c[..self.len], t))
    }

    /// Returns the sliding distance after the time t.
    pub(super) fn distance(&self, t: f64) -> f64 {
        polynomial::split_value(&self.s[..self.len], t)
    }

    /// Returns the time at which the sliding distance is `distance`, which is reached before h.
    pub(super) fn time_of_distance(&self, distance: f64, h: f64) -> f64 {
        let excess = |t: f64| {
            let (s, w) = polynomial::value_and_slope(&self.s[..self.len], t);
            (s - distance, w)
        };
        let guess = if self.w[0] > 0.0 { (distance / self.w[0]).min(h) } else { 0.5 * h };
        polynomial::bracketed_zero(excess, 0.0, h, false, guess)
    }

    /// Returns the first zero in (0, h] of the relative velocity, which is not zero just after 0.
    pub(super) fn arrival(&self, h: f64) -> Option<f64> {
        first_end(&self.w[..self.len], 1.0, h)
    }

    /// Returns the first zero in (0, h] of the normal force (`sign` = 1) or of the gap (−1), positive just after 0.
    pub(super) fn contact_change(&self, sign: f64, h: f64) -> Option<f64> {
        first_end(&self.normal[..self.len], sign, h)
    }

    /// Returns the first time in (0, h] at which the force that stick requires reaches the limit `friction`·n in a
    /// direction ±.
    pub(super) fn release(&self, friction: f64, direction: f64, h: f64) -> Option<f64> {
        let mut margin = [0.0; MOST_TERMS];
        for (margin, (normal, holding)) in margin.iter_mut().zip(self.normal.iter().zip(&self.holding)) {
            *margin = friction * normal - direction * holding;
        }
        first_end(&margin[..self.len], 1.0, h)
    }

    /// Returns the first time in (0, h] at which the friction coefficient is zero.
    pub(super) fn friction_end(&self, h: f64) -> Option<f64> {
        first_end(&self.friction[..self.len], 1.0, h)
    }

    /// Returns the first time in (0, h] at which x′ changes its sign.
    pub(super) fn tangential_turn(&self, h: f64) -> Option<f64> {
        first_turn(&self.u[..self.len], h)
    }

    /// Returns the first time in (0, h] at which y′ changes its sign.
    pub(super) fn normal_turn(&self, h: f64) -> Option<f64> {
        first_turn(&self.v[..self.len], h)
    }
}

/// Returns the friction force required for x″ = 0: k₁₁x + k₁₂y + c₁₁x′ + c₁₂y′.
pub(super) fn holding(model: &Model, [x, u, y, v]: [f64; 4]) -> f64 {
    model.stiffness[0] * x + model.stiffness[1] * y + model.damping[0] * u + model.damping[1] * v
}

/// Returns the first zero in (0, h] of ±p, which is positive just after 0 and may be exactly zero at 0. Returns 0 if ±p
/// is negative just after 0.
fn first_end(c: &[f64], sign: f64, h: f64) -> Option<f64> {
    if c[0] * sign > 0.0 {
        if sign > 0.0 {
            return polynomial::first_zero(c, h);
        }
    } else if c[0] != 0.0 {
        return Some(0.0);
    }
    let (mut rest, zeros) = divided(c);
    if rest[0] * sign < 0.0 {
        return Some(0.0);
    }
    rest.iter_mut().for_each(|c| *c *= sign);
    if rest[0] == 0.0 { None } else { polynomial::first_zero(&rest[..c.len() - zeros], h) }
}

/// Returns the first zero in (0, h] of p, which may have any sign just after 0 and may be exactly zero at 0.
fn first_turn(c: &[f64], h: f64) -> Option<f64> {
    let (rest, _) = divided(c);
    first_end(c, if rest[0] < 0.0 { -1.0 } else { 1.0 }, h)
}

/// Divides p by its exact powers of t; returns the quotient and the number of powers.
fn divided(c: &[f64]) -> (Coefficients, usize) {
    let zeros = c.iter().take_while(|c| **c == 0.0).count();
    let mut rest = [0.0; MOST_TERMS];
    rest[..c.len() - zeros].copy_from_slice(&c[zeros..]);
    (rest, zeros)
}
