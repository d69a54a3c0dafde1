//! Friction by shear of the contacts: F = τ_max A_c.

use std::sync::Arc;

use asperity_base::statement::Statement;

use crate::WindowContact;
use crate::law::{SHEAR_STRENGTH, WindowLaw, describe_shear, shear_strength_pa};

/// Shear-dominated friction of contacts that yield in shear at τ_max: F = τ_max A_c, μ = τ_max A_c/N.
///
/// The area is corrected at the edges of contact, but at least the area that carries the load at the hardness H
/// ([`WindowContact::bearing_area_m2`]). So μ ≥ τ_max/H, with equality if all contact is plastic.
///
/// # References
/// F. P. Bowden and D. Tabor, *The Friction and Lubrication of Solids*, Clarendon Press (1950). Gaus et al. 2016, §4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BowdenTabor {
    /// Shear strength τ_max of the contacts in pascal.
    pub shear_strength_pa: f64,
}

impl BowdenTabor {
    pub(super) const STATEMENT: &Statement<Arc<dyn WindowLaw>> = &Statement {
        inputs: &[SHEAR_STRENGTH],
        law: |stated| Ok(Arc::new(Self { shear_strength_pa: shear_strength_pa(stated)? })),
    };
}

impl WindowLaw for BowdenTabor {
    fn force_n(&self, window: &WindowContact) -> f64 {
        self.shear_strength_pa * window.bearing_area_m2()
    }

    fn describe(&self) -> String {
        format!("Friction is shear-dominated, μ = τ_max A_c/N with {}", describe_shear(self.shear_strength_pa))
    }

    fn plastic_floor(&self, hardness_pa: f64) -> Option<f64> {
        Some(self.shear_strength_pa / hardness_pa)
    }

    fn proportional_to(&self) -> Option<&'static str> {
        Some(SHEAR_STRENGTH)
    }
}
