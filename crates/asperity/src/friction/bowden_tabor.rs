//! Friction of sheared contacts: μ = τ_max A_c / N.

use crate::friction::window::WindowContact;

/// Relative difference below which two areas are the same.
const ROUNDING: f64 = 1e-12;

/// Shear-dominated friction of contacts that yield in shear at τ_max.
///
/// # References
/// F. P. Bowden and D. Tabor, *The Friction and Lubrication of Solids*, Clarendon Press (1950). Gaus et al. 2016, §4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BowdenTabor {
    /// Shear strength τ_max of the contacts in pascal.
    pub shear_strength_pa: f64,
    /// Hardness in pascal, if the contact was capped.
    pub hardness_pa: Option<f64>,
}

impl BowdenTabor {
    /// The friction coefficient of one window; `None` where it carries no load.
    ///
    /// The area is the perimeter-corrected one. No area smaller than N/H can carry the load N under the hardness H, so
    /// the area is never taken below it: μ ≥ τ_max/H, with equality where all contact is plastic.
    pub fn coefficient(&self, window: &WindowContact) -> Option<f64> {
        if window.load_n <= 0.0 {
            return None;
        }
        if let Some(hardness_pa) = self.hardness_pa {
            // Where all cells are plastic the two areas differ by the rounding of a sum.
            let least_m2 = window.load_n / hardness_pa;
            if window.area_m2 <= least_m2 * (1.0 + ROUNDING) {
                return Some(self.shear_strength_pa / hardness_pa);
            }
        }
        Some(self.shear_strength_pa * window.area_m2 / window.load_n)
    }
}
