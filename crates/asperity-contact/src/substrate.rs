//! Elastic body under the surface: a half-space, or a layer on a rigid or an elastic base.
//!
//! A pressure wave p̂ e^{iqx} without shear moves the surface by û = C(q) p̂, and C(q) = R(qh)·2/(E*q) with the contact
//! modulus E* and the thickness h of the layer. The stresses of such a wave follow from Airy's function (A + Bz)
//! e^{−qz} + (C + Dz) e^{qz} in the layer and (P + Qz) e^{−qz} in the base, with 2Gw = (1−ν)φ‴/q² − (2−ν)φ′ and 2Gu =
//! (1−ν)φ″/q + νqφ, and the six conditions: pressure and no shear on top, and both stresses and displacements
//! continuous where layer and base are bonded. Eliminating them gives, with y = 2qh, k = 3 − 4ν, μ = G₁/G₂, a =
//! (1+μk₂)(μ+k₁), b = (μk₂−k₁)(μ−1),
//!
//! R = [2a(sinh y − y) + 2y(1+μk₂)(2μ+k₁−1) + (a−b)e^{−y}]
//!   / [(a−b) sinh y + (a+b)(cosh y − 1 − y²/2) + (1+k₁)² + (1+k₁)(1+μ(k₂−1)/2)y²],
//!
//! No term of it is negative, so no cancellation occurs. A rigid base is μ = 0. A frictionless base has zero shear
//! stress at the base instead of zero displacement along it, and R = (cosh y − 1)/(sinh y + y).
//!
//! # References
//! D. M. Burmister, *J. Appl. Phys.* **16** (1945) 89, <https://doi.org/10.1063/1.1707558>. T. C. O'Sullivan and R. B.
//! King, *J. Tribology* **110** (1988) 235, <https://doi.org/10.1115/1.3261591>. G. Carbone and L. Mangialardi, *J.
//! Mech. Phys. Solids* **56** (2008) 684, <https://doi.org/10.1016/j.jmps.2007.05.009>.

use std::f64::consts::TAU;

use crate::error::positive;
use crate::{Boundary, ContactError, Control, Elastic};
use asperity_base::map::Grid;

mod point_load;

pub(super) use point_load::PointLoad;

/// Base of a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// A rigid base, to which the layer is bonded.
    Rigid,
    /// A rigid base, on which the layer slides without friction but does not lift off.
    Slippery,
    /// An elastic half-space, to which the layer is bonded.
    Elastic(Elastic),
}

/// A layer of uniform thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Thickness in metre, > 0, large against the heights of the surface.
    pub thickness_m: f64,
    /// Material of the layer.
    pub material: Elastic,
    /// Base of the layer.
    pub base: Base,
}

/// The elastic body under a rough surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Substrate {
    /// A homogeneous half-space.
    HalfSpace {
        /// Contact modulus E* = E/(1−ν²) in pascal, > 0.
        modulus_pa: f64,
    },
    /// A layer on a base.
    Layer(Layer),
}

impl Substrate {
    /// Returns the contact modulus E* in pascal of the body at the surface.
    pub fn modulus_pa(&self) -> f64 {
        match self {
            Self::HalfSpace { modulus_pa } => *modulus_pa,
            Self::Layer(layer) => layer.material.contact_modulus_pa(),
        }
    }

    /// Returns C(q) = û/p̂ in m/Pa at the wavenumber q > 0 in rad/m. At q = 0 it returns the limit, which is infinite
    /// without a rigid base.
    pub fn compliance_m_per_pa(&self, q_rad_per_m: f64) -> f64 {
        match self {
            Self::HalfSpace { modulus_pa } => 2.0 / (modulus_pa * q_rad_per_m),
            Self::Layer(layer) => match self.mean_compliance_m_per_pa() {
                Some(mean) if q_rad_per_m == 0.0 => mean,
                _ => 2.0 / (self.modulus_pa() * q_rad_per_m) * layer.ratio(q_rad_per_m * layer.thickness_m),
            },
        }
    }

    /// Returns the limit of C(q) for long waves in m/Pa: h(1+ν)(1−2ν)/(E(1−ν)) for a layer bonded to a rigid base, and
    /// h/E* for one that slips (it then widens along the wave; laterally confined layers are stiffer). Returns `None`
    /// if the limit is infinite.
    pub fn mean_compliance_m_per_pa(&self) -> Option<f64> {
        let Self::Layer(Layer { thickness_m, material, base }) = self else {
            return None;
        };
        let nu = material.poisson_ratio;
        match base {
            Base::Rigid => {
                Some(thickness_m * (1.0 + nu) * (1.0 - 2.0 * nu) / (material.youngs_modulus_pa * (1.0 - nu)))
            }
            Base::Slippery => Some(thickness_m / material.contact_modulus_pa()),
            Base::Elastic(_) => None,
        }
    }

    /// Returns the mean compliance of a periodic surface in m/Pa: the finite limit on a rigid base, otherwise
    /// customarily the compliance of the longest wave.
    pub fn usual_mean_compliance_m_per_pa(&self, grid: Grid) -> f64 {
        let longest_m = grid.width_m().max(grid.height_m());
        self.mean_compliance_m_per_pa().unwrap_or_else(|| self.compliance_m_per_pa(TAU / longest_m))
    }

    /// Returns the periodic boundary with a mean compliance in m/Pa, by default the usual one where `control` prescribes the place of the
    /// plane. Otherwise it changes the displacement of the plane alone, and is zero by default.
    pub fn periodic(&self, grid: Grid, control: Control, mean_compliance_m_per_pa: Option<f64>) -> Boundary {
        let usual = || self.usual_mean_compliance_m_per_pa(grid);
        let default = || if control.prescribes_plane() { usual() } else { 0.0 };
        Boundary::Periodic { mean_compliance_m_per_pa: mean_compliance_m_per_pa.unwrap_or_else(default) }
    }

    /// Returns 1/C(q) in Pa/m for q > 0.
    pub(super) fn stiffness_pa_per_m(&self, q_rad_per_m: f64) -> f64 {
        match self {
            Self::HalfSpace { modulus_pa } => 0.5 * modulus_pa * q_rad_per_m,
            Self::Layer(_) => 1.0 / self.compliance_m_per_pa(q_rad_per_m),
        }
    }

    pub(super) fn validate(&self) -> Result<(), ContactError> {
        match self {
            Self::HalfSpace { modulus_pa } => positive("contact modulus", *modulus_pa, "Pa", 1e30),
            Self::Layer(Layer { thickness_m, material, base }) => {
                positive("thickness of the layer", *thickness_m, "m", 1e100)?;
                material.validate("Young's modulus of the layer", "Poisson's ratio of the layer")?;
                positive("contact modulus of the layer", material.contact_modulus_pa(), "Pa", 1e30)?;
                match base {
                    Base::Rigid | Base::Slippery => Ok(()),
                    Base::Elastic(base) => base.validate("Young's modulus of the base", "Poisson's ratio of the base"),
                }
            }
        }
    }
}

impl Layer {
    /// Returns R(qh): the compliance over the compliance of a half-space of the layer's material.
    fn ratio(&self, qh: f64) -> f64 {
        let y = 2.0 * qh;
        // All terms are multiplied by e^{−y}.
        let decay = (-y).exp();
        let sinh = -0.5 * (-2.0 * y).exp_m1();
        let Some(bond) = self.bond() else {
            // (cosh y − 1)/sinh y = tanh(y/2).
            return sinh * (0.5 * y).tanh() / (sinh + y * decay);
        };
        let Bond { stiff, soft, sum, linear, constant, square } = bond;
        let above = 2.0 * stiff * sinh_less_y(y) + decay * (y * linear + soft * decay);
        let below = soft * sinh + sum * cosh_less_parabola(y) + decay * (constant + square * y * y);
        above / below
    }

    /// Returns the coefficients of R of a bonded layer.
    fn bond(&self) -> Option<Bond> {
        let k1 = self.material.kolosov();
        let (mu, k2) = match self.base {
            Base::Slippery => return None,
            Base::Rigid => (0.0, 1.0),
            Base::Elastic(base) => (self.material.shear_modulus_pa() / base.shear_modulus_pa(), base.kolosov()),
        };
        Some(Bond {
            stiff: (1.0 + mu * k2) * (mu + k1),
            soft: mu * (1.0 + k1) * (1.0 + k2),
            sum: 2.0 * mu * mu * k2 + mu * (1.0 - k1) * (1.0 - k2) + 2.0 * k1,
            linear: 2.0 * (1.0 + mu * k2) * (2.0 * mu + k1 - 1.0),
            constant: (1.0 + k1).powi(2),
            square: (1.0 + k1) * (1.0 + 0.5 * mu * (k2 - 1.0)),
        })
    }
}

/// Coefficients of R(y): a, a − b, a + b, the coefficient of y in the numerator and those of 1 and y² in the
/// denominator.
#[derive(Debug, Clone, Copy)]
struct Bond {
    stiff: f64,
    soft: f64,
    sum: f64,
    linear: f64,
    constant: f64,
    square: f64,
}

/// Returns (sinh y − y) e^{−y}.
fn sinh_less_y(y: f64) -> f64 {
    if y < 1.0 { (-y).exp() * y * series_of_cosh(y, 1) } else { -0.5 * (-2.0 * y).exp_m1() - y * (-y).exp() }
}

/// Returns (cosh y − 1 − y²/2) e^{−y}.
fn cosh_less_parabola(y: f64) -> f64 {
    if y < 1.0 {
        (-y).exp() * series_of_cosh(y, 2)
    } else {
        0.5 * (1.0 + (-2.0 * y).exp()) - (1.0 + 0.5 * y * y) * (-y).exp()
    }
}

/// Returns Σ y^{2j}/n! over j ≥ `first` for y < 1, with n = 2j + 1 if `first` is 1 (sinh y/y) and n = 2j if it is 2
/// (cosh y).
fn series_of_cosh(y: f64, first: u32) -> f64 {
    let shift = if first == 1 { 1.0 } else { 0.0 };
    let (mut sum, mut term) = (0.0, 1.0);
    for j in 1..=12_u32 {
        let n = 2.0 * f64::from(j) + shift;
        term *= y * y / (n * (n - 1.0));
        if j >= first {
            sum += term;
        }
    }
    sum
}

#[cfg(test)]
mod tests;
